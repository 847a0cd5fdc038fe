// Where a result comes from: the command and the files it was made of.
#pragma once

#include <string>
#include <vector>

#include "problems/io/input_file.h"

namespace sagitta {

// What all files of one set have in common: 16 hexadecimal digits out of version, command and inputs. Runs that cannot
// differ have the same.
struct Provenance;
std::string RunId(const Provenance& provenance);

// "# run: …", a comment of a YAML file.
std::string RunComment(const Provenance& provenance);

// What a result was made of, and by which command.
struct Provenance {
  std::string command;
  std::string method = "joint";
  std::vector<InputFile> inputs;
  std::string simulation = "";  // "columns": the estimate corrects somebody else's simulation and predicts no points
};

}  // namespace sagitta

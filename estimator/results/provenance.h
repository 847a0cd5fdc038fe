// Where a result comes from: the command and the files it was made of.
#pragma once

#include <string>
#include <vector>

#include "problems/io/input_file.h"

namespace sagitta {

struct Provenance {
  std::string command;
  std::string method = "joint";
  std::vector<InputFile> inputs;
  std::string simulation = "";  // "columns": the estimate corrects somebody else's simulation and predicts no points
};

}  // namespace sagitta

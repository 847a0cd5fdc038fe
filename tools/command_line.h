// The command line: a command, its arguments and the flags it accepts.
//
// Flags are gflags (DEFINE_* next to the code that uses them), but a command
// accepts only those it lists: gflags' own parser would accept every flag of every
// library and exits with 1 on a wrong one.
#pragma once

#include <gflags/gflags_declare.h>

#include <map>
#include <string>
#include <vector>

#include "problems/text.h"

DECLARE_string(out);
DECLARE_uint64(seed);
DECLARE_int32(threads);
DECLARE_bool(quiet);

namespace sagitta {

struct CommandLine {
  std::string text;                    // as typed, for provenance
  std::vector<std::string> arguments;  // positional
  bool help = false;
};

struct Command {
  std::string name;
  std::string summary;  // one line
  std::string help;     // usage, what it does, examples
  std::vector<std::string> flags;
  int (*run)(const CommandLine& line) = nullptr;  // exit status; null: `program` does it
  std::string program = {};                       // another program that does it, in the same folder
};

// `arguments`: what follows the command's name. `--flag value` and
// `--flag=value`, `--flag` and `--noflag` for switches, `--` ends flags. Throws
// InputError for a flag that the command does not accept or a value that is none.
CommandLine ParseCommandLine(const Command& command, const std::vector<std::string>& arguments);

// True when the command line sets the flag.
bool IsGiven(const std::string& flag);

// Throws InputError unless the number of arguments lies in the range.
void ExpectArguments(const CommandLine& line, const Command& command, size_t least, size_t most);

// Help text of a flag: name, what it does, default.
std::string DescribeFlag(const std::string& flag);

// What a flag's text "NAME=VALUE,…" is made of, in words; and an example of it.
struct PairWords {
  const char *pair, *twice, *example;
};
// All pairs, by name; throws InputError that names the flag. "": none.
std::map<std::string, std::string> PairsOfFlag(const std::string& flag, const std::string& text,
                                               const PairWords& words);

// All numbers of "1,2,3"; throws InputError that names the flag.
std::vector<double> NumbersOfFlag(const std::string& flag, const std::string& text);

}  // namespace sagitta

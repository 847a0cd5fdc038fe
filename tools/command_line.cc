#include "tools/command_line.h"

#include <gflags/gflags.h>

#include <algorithm>

#include "problems/input_error.h"
#include "problems/io/text_checks.h"
#include "problems/io/trimmed.h"
#include "problems/io/units.h"
#include "problems/range.h"

DEFINE_string(out, "", "where the results go: a folder, or a file where the command says so");
DEFINE_uint64(seed, 1, "seed of everything random: hold-out, simulated noise");
DEFINE_int32(threads, 1, "threads of the solver");
DEFINE_bool(quiet, false, "no progress on stderr");

namespace sagitta {
namespace {

struct FlagText {
  std::string name;
  std::string value;
  bool has_value = false;
};

FlagText SplitFlag(const std::string& argument) {
  if (argument == "-v") return {"verbose", "", false};
  const std::string body = argument.substr(argument.rfind("--", 0) == 0 ? 2 : 1);
  const size_t equals = body.find('=');
  FlagText flag{body.substr(0, equals), "", equals != std::string::npos};
  if (flag.has_value) flag.value = body.substr(equals + 1);
  std::replace(flag.name.begin(), flag.name.end(), '-', '_');
  return flag;
}

bool LooksLikeFlag(const std::string& argument) { return argument.rfind("--", 0) == 0 && argument.size() > 2; }

bool Takes(const Command& command, const std::string& flag) {
  return std::find(command.flags.begin(), command.flags.end(), flag) != command.flags.end();
}

bool IsSwitch(const std::string& flag) { return gflags::GetCommandLineFlagInfoOrDie(flag.c_str()).type == "bool"; }

std::string WhatIsExpected(const gflags::CommandLineFlagInfo& info) {
  if (info.type == "bool") return "true or false";
  if (info.type == "double") return "a number";
  return info.type.front() == 'u' ? "a whole number from 0 on" : "a whole number";
}

void SetFlag(const std::string& name, const std::string& value) {
  const gflags::CommandLineFlagInfo info = gflags::GetCommandLineFlagInfoOrDie(name.c_str());
  if (!info.is_default) throw InputError({"", 0, "--" + name}, "the flag is given twice");
  if (info.type == "double") NumbersOfFlag(name, value);
  if (gflags::SetCommandLineOption(name.c_str(), value.c_str()).empty()) {
    throw InputError({"", 0, "--" + name}, "'" + value + "' is no value for this flag",
                     WhatIsExpected(info) + " is expected: " + info.description);
  }
}

// -out=DIR: no file is called like a flag.
void RefuseOneHyphen(const Command& command, const std::string& argument) {
  if (argument.size() < 2 || argument.front() != '-') return;
  const FlagText flag = SplitFlag(argument);
  if (!Takes(command, flag.name)) return;
  throw InputError({"", 0, argument}, "flags begin with two hyphens", "--" + argument.substr(1));
}

[[noreturn]] void FailUnknownFlag(const Command& command, const std::string& name) {
  std::vector<std::string> known;
  for (const std::string& flag : command.flags) known.push_back("--" + flag);
  throw InputError({"", 0, "--" + name}, "'sagitta " + command.name + "' has no such flag",
                   SpellingHint("--" + name, known));
}

[[noreturn]] void FailUsage(const Command& command, const std::string& what) {
  throw InputError({"", 0, "sagitta " + command.name}, what, command.help.substr(0, command.help.find('\n')));
}

[[noreturn]] void FailWithoutValue(const std::string& name) {
  throw InputError({"", 0, "--" + name}, "the flag needs a value", "--" + name + "=…");
}

std::string JoinForShell(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) {
    text += (text.empty() ? "" : " ") + ShellWord(word);
  }
  return text;
}

}  // namespace

CommandLine ParseCommandLine(const Command& command, const std::vector<std::string>& arguments) {
  CommandLine line;
  line.text = "sagitta " + command.name + (arguments.empty() ? "" : " ") + JoinForShell(arguments);
  bool flags_ended = false;
  for (size_t i = 0; i < arguments.size(); ++i) {
    const std::string& argument = arguments[i];
    if (flags_ended || !(LooksLikeFlag(argument) || argument == "--" || argument == "-h" || argument == "-v")) {
      if (Trimmed(argument).empty()) FailUsage(command, "an argument is empty");
      if (!flags_ended) RefuseOneHyphen(command, argument);
      line.arguments.push_back(argument);
      continue;
    }
    if (argument == "--") {
      flags_ended = true;
      continue;
    }
    const FlagText flag = SplitFlag(argument);
    if (flag.name == "help" || flag.name == "h") {
      line.help = true;
    } else if (Takes(command, flag.name)) {
      const bool is_switch = IsSwitch(flag.name);
      const bool takes_next = !flag.has_value && !is_switch;
      if (takes_next && (i + 1 == arguments.size() || LooksLikeFlag(arguments[i + 1]))) FailWithoutValue(flag.name);
      const std::string value = flag.has_value ? flag.value : is_switch ? "true" : arguments[++i];
      if (Trimmed(value).empty()) FailWithoutValue(flag.name);  // --out=$DIR where the shell knows no DIR
      SetFlag(flag.name, value);
    } else if (!flag.has_value && flag.name.rfind("no", 0) == 0 && Takes(command, flag.name.substr(2)) &&
               IsSwitch(flag.name.substr(2))) {
      SetFlag(flag.name.substr(2), "false");
    } else {
      FailUnknownFlag(command, flag.name);
    }
  }
  CheckIn(allowed::kThreads, FLAGS_threads, "--threads");
  return line;
}

bool IsGiven(const std::string& flag) { return !gflags::GetCommandLineFlagInfoOrDie(flag.c_str()).is_default; }

void ExpectArguments(const CommandLine& line, const Command& command, size_t least, size_t most) {
  const size_t n = line.arguments.size();
  if (n >= least && n <= most) return;
  FailUsage(command, n < least ? "an argument is missing" : "'" + line.arguments[most] + "' is one argument too many");
}

std::string DescribeFlag(const std::string& flag) {
  const gflags::CommandLineFlagInfo info = gflags::GetCommandLineFlagInfoOrDie(flag.c_str());
  std::string text = "  --" + flag;
  if (info.type != "bool") text += "=" + std::string(info.type == "string" ? "TEXT" : "NUMBER");
  text.resize(std::max<size_t>(text.size() + 2, 26), ' ');
  text += info.description;
  const bool shows_default = info.type != "bool" && info.type != "double" && !info.default_value.empty();
  return text + (shows_default ? " [" + info.default_value + "]" : "") + "\n";
}

std::map<std::string, std::string> PairsOfFlag(const std::string& flag, const std::string& text,
                                               const PairWords& words) {
  std::map<std::string, std::string> pairs;
  if (text.empty()) return pairs;
  for (const std::string& entry : SplitText(text, ',')) {
    const size_t equals = entry.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == entry.size())
      throw InputError({"", 0, "--" + flag}, "'" + entry + "' does not name " + words.pair, words.example);
    if (!pairs.emplace(entry.substr(0, equals), entry.substr(equals + 1)).second)
      throw InputError({"", 0, "--" + flag}, "'" + entry.substr(0, equals) + "' " + words.twice);
  }
  return pairs;
}

std::vector<double> NumbersOfFlag(const std::string& flag, const std::string& text) {
  std::vector<double> numbers;
  for (const std::string& part : SplitText(text, ',')) {
    const std::optional<double> number = ParseNumber(part);
    if (!number) throw InputError({"", 0, "--" + flag}, "'" + part + "' is not a finite number");
    numbers.push_back(*number);
  }
  return numbers;
}

}  // namespace sagitta

// sagitta: estimates the true geometry of a robot from measured points.
#include <gflags/gflags.h>
#include <glog/logging.h>

#include <exception>
#include <iostream>

#include "problems/input_error.h"
#include "tools/commands.h"

namespace sagitta {
namespace {

constexpr int kUsageError = 2;
constexpr int kNumericalFailure = 3;

const std::vector<Command>& Commands() {
  static const std::vector<Command> commands = {
      CalibrateCommand(),
      PredictCommand(),
      SimulateCommand(),
      CompareCommand(),
      DiagnoseCommand(),
      ValidateCommand(),
      InspectCommand(),
      CoverageCommand(),
      {"plan", "which poses to measure next", "", {}},
      {"compensate", "corrected joint values for targets", "", {}},
      ReproduceCommand(),
      {"convert", "robot files between formats", "", {}},
  };
  return commands;
}

std::string Overview() {
  std::string text = "sagitta " SAGITTA_VERSION
                     ": robot calibration from measured points\n\n"
                     "sagitta COMMAND … | sagitta help COMMAND | sagitta --version\n\n";
  for (const bool built : {true, false}) {
    if (!built) text += "\nnot in this version yet\n";
    for (const Command& command : Commands()) {
      if ((command.run != nullptr) != built) continue;
      std::string name = "  " + command.name;
      name.resize(14, ' ');
      text += name + command.summary + "\n";
    }
  }
  return text +
         "\nFirst steps: sagitta calibrate ROBOT.yaml MEASUREMENTS.csv --out=results\n"
         "Exit status: 0 done; 1 a requirement is not met; 2 input or usage error; 3 numerical failure\n";
}

std::string HelpOf(const Command& command) {
  if (command.run == nullptr) return "sagitta " + command.name + ": " + command.summary + "; not in this version yet\n";
  std::string text = command.help + "\nFlags\n";
  for (const std::string& flag : command.flags) text += DescribeFlag(flag);
  return text;
}

const Command& FindCommand(const std::string& name) {
  std::vector<std::string> names;
  for (const Command& command : Commands()) {
    if (command.name == name) return command;
    names.push_back(command.name);
  }
  throw InputError({"", 0, ""}, "there is no command '" + name + "'", SpellingHint(name, names));
}

int Run(const std::vector<std::string>& arguments) {
  const std::string first = arguments.empty() ? "" : arguments[0];
  if (first.empty()) {
    std::cerr << Overview();
    return kUsageError;
  }
  if (first == "--version" || first == "version") {
    std::cout << "sagitta " SAGITTA_VERSION "\n";
    return 0;
  }
  const bool asks_help = first == "--help" || first == "-h" || first == "help";
  if (asks_help) {
    const bool about_one = arguments.size() > 1 && arguments[1] != "help";
    std::cout << (about_one ? HelpOf(FindCommand(arguments[1])) : Overview());
    return 0;
  }
  const Command& command = FindCommand(first);
  if (command.run == nullptr) {
    for (const std::string& argument : arguments) {
      if (argument != "--help") continue;
      std::cout << HelpOf(command);
      return 0;
    }
    throw InputError({"", 0, ""}, "this version does not have 'sagitta " + command.name + "' yet",
                     "'sagitta --help' lists what it has");
  }
  const CommandLine line = ParseCommandLine(command, {arguments.begin() + 1, arguments.end()});
  if (line.help) {
    std::cout << HelpOf(command);
    return 0;
  }
  return command.run(line);
}

void Print(const InputError& error) {
  std::string message = error.what();
  const std::string in_brackets = " (" + error.hint() + ")";
  if (!error.hint().empty()) message.resize(message.size() - in_brackets.size());
  std::cerr << "sagitta: error: " << message << "\n";
  if (!error.hint().empty()) std::cerr << "  hint: " << error.hint() << "\n";
}

}  // namespace
}  // namespace sagitta

int main(int argc, char** argv) {
  google::InitGoogleLogging(argv[0]);
  FLAGS_logtostderr = true;
  FLAGS_minloglevel = google::GLOG_FATAL;  // what matters is said in the summary; Ceres' own words help nobody
  try {
    return sagitta::Run({argv + 1, argv + argc});
  } catch (const sagitta::InputError& error) {
    sagitta::Print(error);
    return sagitta::kUsageError;
  } catch (const std::exception& error) {
    std::cerr << "sagitta: error: " << error.what() << "\n";
    return sagitta::kNumericalFailure;
  }
}

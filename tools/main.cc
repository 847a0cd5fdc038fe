// sagitta: estimates the true geometry of a robot from measured points.
#include <iostream>

#include "problems/input_error.h"
#include "tools/commands.h"
#include "tools/heap.h"
#include "tools/run_command.h"
#include "tools/shell_pages.h"

namespace sagitta {
namespace {

const std::vector<Command>& Commands() {
  static const std::vector<Command> commands = {
      CalibrateCommand(), PredictCommand(),
      SimulateCommand(),  CompareCommand(),
      DiagnoseCommand(),  ValidateCommand(),
      InspectCommand(),   CoverageCommand(),
      PlanCommand(),      CompensateCommand(),
      ChangedCommand(),   {"reproduce", "the published tables side by side", "", {}, nullptr, "sagitta-reproduce"},
      ImportCommand(),    ConvertCommand(),
  };
  return commands;
}

std::string Overview() {
  std::string text = "sagitta " SAGITTA_VERSION
                     ": robot calibration from measured points\n\n"
                     "sagitta COMMAND … | sagitta help COMMAND | sagitta --version\n\n";
  for (const Command& command : Commands()) {
    std::string name = "  " + command.name;
    name.resize(14, ' ');
    text += name + command.summary + "\n";
  }
  return text +
         "\nTo begin: sagitta calibrate ROBOT.yaml MEASUREMENTS.csv --out=results\n"
         "Exit status: 0 done; 1 a requirement is not met; 2 input or usage error; 3 numerical failure\n";
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
  if (first == "--shell-pages" && arguments.size() == 2) {  // when it is built: tools/CMakeLists.txt
    WriteShellPages(Commands(), Overview(), arguments[1]);
    return 0;
  }
  const bool asks_help = first == "--help" || first == "-h" || first == "help";
  if (asks_help && (arguments.size() < 2 || arguments[1] == "help")) {
    std::cout << Overview();
    return 0;
  }
  const Command& command = FindCommand(asks_help ? arguments[1] : first);
  std::vector<std::string> rest(arguments.begin() + (asks_help ? 2 : 1), arguments.end());
  if (asks_help) rest = {"--help"};
  if (!command.program.empty()) return HandOver(command.program, rest);
  return RunCommand(command, rest);
}

}  // namespace
}  // namespace sagitta

int main(int argc, char** argv) {
  sagitta::PrepareHeap();
  return sagitta::RunGuarded(argv[0], [&] { return sagitta::Run({argv + 1, argv + argc}); });
}

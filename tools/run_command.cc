#include "tools/run_command.h"

#include <gflags/gflags.h>
#include <glog/logging.h>
#include <unistd.h>

#include <exception>
#include <filesystem>
#include <iostream>

#include "problems/input_error.h"

namespace sagitta {
namespace {

void Print(const InputError& error) {
  std::string message = error.what();
  const std::string in_brackets = " (" + error.hint() + ")";
  if (!error.hint().empty()) message.resize(message.size() - in_brackets.size());
  std::cerr << "sagitta: error: " << message << "\n";
  if (!error.hint().empty()) std::cerr << "  hint: " << error.hint() << "\n";
}

}  // namespace

int RunGuarded(const char* program_path, const std::function<int()>& program) {
  google::InitGoogleLogging(program_path);
  FLAGS_logtostderr = true;
  FLAGS_minloglevel = google::GLOG_FATAL;  // what matters is said in the summary; Ceres' own words help nobody
  try {
    return program();
  } catch (const InputError& error) {
    Print(error);
    return kUsageError;
  } catch (const std::exception& error) {
    std::cerr << "sagitta: error: " << error.what() << "\n";
    return kNumericalFailure;
  }
}

namespace {

namespace fs = std::filesystem;

// Folders that are made for results and stay empty, because the command ended before it had any, are taken away again.
class NewFolders {
 public:
  explicit NewFolders(const std::string& folder) {
    std::error_code error;
    for (fs::path path = folder; !path.empty() && !fs::exists(path, error); path = path.parent_path())
      made_.push_back(path);
  }
  ~NewFolders() {
    std::error_code error;
    for (const fs::path& path : made_) {
      if (fs::is_directory(path, error) && fs::is_empty(path, error)) fs::remove(path, error);
    }
  }
  NewFolders(const NewFolders&) = delete;
  NewFolders& operator=(const NewFolders&) = delete;

 private:
  std::vector<fs::path> made_;  // that are not there yet, the innermost first
};

}  // namespace

std::string HelpOf(const Command& command) {
  std::string text = command.help + "\nFlags\n";
  for (const std::string& flag : command.flags) text += DescribeFlag(flag);
  return text;
}

int RunCommand(const Command& command, const std::vector<std::string>& arguments) {
  const CommandLine line = ParseCommandLine(command, arguments);
  if (line.help) {
    std::cout << HelpOf(command);
    return 0;
  }
  const NewFolders folders(FLAGS_out);
  return command.run(line);
}

int HandOver(const std::string& program, const std::vector<std::string>& arguments) {
  std::error_code error;
  const std::filesystem::path own = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::string path = (own.parent_path() / program).string();
  std::vector<char*> words = {const_cast<char*>(path.c_str())};
  for (const std::string& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
  words.push_back(nullptr);
  execv(path.c_str(), words.data());
  throw InputError({path, 0, ""}, "the program '" + program + "' is not installed in the folder of sagitta");
}

}  // namespace sagitta

#include "tools/run_command.h"

#include <gflags/gflags.h>
#include <glog/logging.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <exception>
#include <filesystem>
#include <iostream>
#include <new>

#include "problems/failure.h"
#include "problems/input_error.h"
#include "problems/interruption.h"
#include "problems/io/files.h"
#include "tools/terminal.h"

DEFINE_bool(verbose, false, "say on stderr how the equations are solved; also -v");

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

namespace {

std::atomic<bool> g_interrupted{false};

extern "C" void NoteInterrupt(int) { g_interrupted = true; }

// The first Ctrl-C asks the work to end at its next round, a second one ends the program at once.
void ListenForInterrupts() {
  struct sigaction action = {};
  action.sa_handler = NoteInterrupt;
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  sigaction(SIGINT, &action, nullptr);
}

// As the signal would have done: shells and scripts see that it was one.
void EndByInterrupt() {
  std::cout.flush();
  std::cerr.flush();
  std::signal(SIGINT, SIG_DFL);
  std::raise(SIGINT);
}

// The program's status; an exception becomes words. Texts of libraries' exceptions help nobody.
int StatusOf(const std::function<int()>& program) {
  try {
    return program();
  } catch (const InputError& error) {
    Print(error);
    return kUsageError;
  } catch (const Interruption&) {
    std::cerr << "sagitta: interrupted; no result is written\n";
    EndByInterrupt();
  } catch (const Failure& error) {
    std::cerr << "sagitta: error: " << error.what() << "\n";
  } catch (const std::bad_alloc&) {
    std::cerr << "sagitta: error: there is not enough memory for what these files ask for\n";
  } catch (const std::exception&) {
    std::cerr << "sagitta: error: this command met something that it was not made for; nothing more is written\n"
                 "  hint: please report the command and its files\n";
  }
  return kNumericalFailure;
}

}  // namespace

int RunGuarded(const char* program_path, const std::function<int()>& program) {
  google::InitGoogleLogging(program_path);
  FLAGS_logtostderr = true;
  FLAGS_minloglevel = google::GLOG_FATAL;  // what matters is said in the summary; Ceres' own words help nobody
  const PrintableStream out(&std::cout), err(&std::cerr);
  ListenForInterrupts();
  std::signal(SIGXFSZ, SIG_IGN);  // a file that grows beyond the limit is one that cannot be written
  const Interruptible scope(&g_interrupted);
  const int status = StatusOf(program);
  std::cout.flush();
  if (std::cout) return status;
  std::cerr << "sagitta: error: standard output cannot be written, what stands there is not all\n";
  return status == 0 ? kUsageError : status;
}

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
  if (FLAGS_verbose) {
    FLAGS_v = 1;
    FLAGS_minloglevel = google::GLOG_INFO;
    FLAGS_log_prefix = false;
  }
  const FileSession files;
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

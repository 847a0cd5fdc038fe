// Progress lines on stderr: at once on a terminal, elsewhere only what is still
// going on after a second.
#pragma once

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace sagitta {

class Progress {
 public:
  explicit Progress(bool quiet);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void Say(const std::string& what);

 private:
  void PrintPending();

  const bool quiet_;
  bool patient_ = true;  // the first second, where stderr is no terminal
  bool done_ = false;
  std::string pending_;
  std::mutex mutex_;
  std::condition_variable ended_;
  std::thread timer_;
};

}  // namespace sagitta

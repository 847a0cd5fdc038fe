// Progress lines on stderr, twice a second at most: from the start on a terminal,
// elsewhere only when the work takes longer than a second.
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
  void PrintUntilDone();

  bool done_ = false;
  std::string pending_;
  std::mutex mutex_;
  std::condition_variable ended_;
  std::thread printer_;
};

}  // namespace sagitta

#include "tools/progress.h"

#include <unistd.h>

#include <chrono>
#include <iostream>

namespace sagitta {

Progress::Progress(bool quiet) {
  if (!quiet) printer_ = std::thread(&Progress::PrintUntilDone, this);
}

Progress::~Progress() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    done_ = true;
  }
  ended_.notify_all();
  if (printer_.joinable()) printer_.join();
}

void Progress::Say(const std::string& what) {
  const std::lock_guard<std::mutex> lock(mutex_);
  pending_ = what;
}

void Progress::PrintUntilDone() {
  std::unique_lock<std::mutex> lock(mutex_);
  std::chrono::milliseconds wait(isatty(STDERR_FILENO) != 0 ? 50 : 1000);
  while (!ended_.wait_for(lock, wait, [this] { return done_; })) {
    if (!pending_.empty()) std::cerr << "sagitta: " << pending_ << " ..." << std::endl;
    pending_.clear();
    wait = std::chrono::milliseconds(500);
  }
}

}  // namespace sagitta

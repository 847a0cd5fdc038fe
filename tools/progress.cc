#include "tools/progress.h"

#include <unistd.h>

#include <chrono>
#include <iostream>

namespace sagitta {

Progress::Progress(bool quiet) : quiet_(quiet) {
  if (quiet_) return;
  patient_ = isatty(STDERR_FILENO) == 0;
  if (!patient_) return;
  timer_ = std::thread([this] {
    std::unique_lock<std::mutex> lock(mutex_);
    if (ended_.wait_for(lock, std::chrono::seconds(1), [this] { return done_; })) return;
    patient_ = false;
    PrintPending();
  });
}

Progress::~Progress() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    done_ = true;
  }
  ended_.notify_all();
  if (timer_.joinable()) timer_.join();
}

void Progress::Say(const std::string& what) {
  if (quiet_) return;
  const std::lock_guard<std::mutex> lock(mutex_);
  pending_ = what;
  if (!patient_) PrintPending();
}

void Progress::PrintPending() {
  if (!pending_.empty()) std::cerr << "sagitta: " << pending_ << " ..." << std::endl;
  pending_.clear();
}

}  // namespace sagitta

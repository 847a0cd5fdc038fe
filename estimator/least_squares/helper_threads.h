// Threads that work for one caller after the other and sleep in between. To start a thread costs as much as a pass over
// some 500 configurations (BENCHMARKS.md), to wake one a tenth of that.
#pragma once

#include <functional>
#include <vector>

namespace sagitta {

class HelperThread;

// Helpers of one caller, for as long as the object lives: those that sleep, and new ones where they are too few.
// std::system_error where the system has no more threads. A process that was forked begins with none.
class HelperThreads {
 public:
  explicit HelperThreads(int count);
  ~HelperThreads();  // waits for those that work
  HelperThreads(const HelperThreads&) = delete;
  HelperThreads& operator=(const HelperThreads&) = delete;

  // Each calls work(i) once, i in 0..count-1, and begins at once. It lives until Wait returns and does not throw.
  void Begin(const std::function<void(int i)>& work);
  void Wait();

 private:
  std::vector<HelperThread*> helpers_;
};

}  // namespace sagitta

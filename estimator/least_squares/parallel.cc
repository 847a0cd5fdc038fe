#include "estimator/least_squares/parallel.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "problems/interruption.h"

namespace sagitta {

void ParallelFor(int n, int threads, const std::function<void(int i, int worker)>& work) {
  std::atomic<int> next{0};
  std::exception_ptr failure;
  std::mutex mutex;
  const std::atomic<bool>* stop = Interruptible::Flag();
  const auto run = [&](int worker) {
    const Interruptible scope(stop);
    try {
      for (int i = next++; i < n; i = next++) {
        CheckInterruption();
        work(i, worker);
      }
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex);
      if (!failure) failure = std::current_exception();
      next = n;
    }
  };
  std::vector<std::thread> helpers;
  for (int worker = 1; worker < std::min(threads, n); ++worker) helpers.emplace_back(run, worker);
  run(0);
  for (std::thread& helper : helpers) helper.join();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace sagitta

#include "estimator/least_squares/parallel.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <vector>

#include "estimator/least_squares/helper_threads.h"
#include "problems/interruption.h"

namespace sagitta {
namespace {

constexpr std::chrono::milliseconds kWait(100);

// What has been made and who has not used it yet.
class Conveyor {
 public:
  Conveyor(int n, int threads, int slots) : n_(n), threads_(threads), made_(slots, -1), users_left_(slots, 0) {}

  // All that one user does, and what it makes while it has nothing to use.
  void Run(int user, const std::function<void(int i, int slot)>& make,
           const std::function<void(int slot, int user)>& use) {
    std::unique_lock<std::mutex> lock(mutex_);
    for (int own = 0; own < n_ && !failed_;) {
      if (made_[SlotOf(own)] == own) {
        Unlocked(&lock, [&] { use(SlotOf(own), user); });
        if (--users_left_[SlotOf(own++)] == 0) moved_.notify_all();
      } else if (next_ < n_ && users_left_[SlotOf(next_)] == 0) {
        const int i = next_++;
        users_left_[SlotOf(i)] = threads_;
        Unlocked(&lock, [&] { make(i, SlotOf(i)); });
        made_[SlotOf(i)] = i;
        moved_.notify_all();
      } else {
        moved_.wait_for(lock, kWait);
        CheckInterruption();  // another user may have ended before it began
      }
    }
  }
  // Nobody waits for a user that has thrown.
  void Fail() {
    const std::lock_guard<std::mutex> lock(mutex_);
    failed_ = true;
    moved_.notify_all();
  }

 private:
  int SlotOf(int i) const { return i % static_cast<int>(made_.size()); }

  template <typename Work>
  static void Unlocked(std::unique_lock<std::mutex>* lock, const Work& work) {
    lock->unlock();
    CheckInterruption();
    work();
    lock->lock();
  }

  const int n_, threads_;
  std::mutex mutex_;
  std::condition_variable moved_;
  int next_ = 0;  // to be made
  bool failed_ = false;
  std::vector<int> made_, users_left_;  // of each slot: what is in it, -1: nothing; how many will use it
};

}  // namespace

void MakeAndUse(int n, int threads, int slots, const std::function<void(int i, int slot)>& make,
                const std::function<void(int slot, int user)>& use) {
  Conveyor conveyor(n, threads, threads == 1 ? 1 : slots);
  ParallelFor(threads, threads, [&](int user, int) {
    try {
      conveyor.Run(user, make, use);
    } catch (...) {
      conveyor.Fail();
      throw;
    }
  });
}

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
  const std::function<void(int)> help = [&run](int helper) { run(helper + 1); };
  HelperThreads helpers(std::min(threads, n) - 1);
  helpers.Begin(help);
  run(0);
  helpers.Wait();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace sagitta

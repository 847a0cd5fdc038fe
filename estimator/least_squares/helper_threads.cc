#include "estimator/least_squares/helper_threads.h"

#include <pthread.h>

#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

namespace sagitta {

// Never ends: it sleeps when the process does. Detached, so that nobody has to join it while statics are destroyed.
class HelperThread {
 public:
  HelperThread() {
    std::thread([this] { Run(); }).detach();
  }

  void Begin(std::function<void()> work) {
    const std::lock_guard<std::mutex> lock(mutex_);
    work_ = std::move(work);
    changed_.notify_all();
  }
  void Wait() {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [this] { return work_ == nullptr; });
  }

 private:
  void Run() {
    std::unique_lock<std::mutex> lock(mutex_);
    for (;;) {
      changed_.wait(lock, [this] { return work_ != nullptr; });
      lock.unlock();
      work_();  // nobody replaces it before it is done
      lock.lock();
      work_ = nullptr;
      changed_.notify_all();
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::function<void()> work_;  // null: asleep
};

namespace {

struct Sleepers {
  std::mutex mutex;
  std::vector<HelperThread*> threads;
};

Sleepers* sleepers = nullptr;  // of this process; never deleted, like its threads

Sleepers& OfThisProcess() {
  static std::once_flag once;
  std::call_once(once, [] {
    sleepers = new Sleepers;
    // The threads are not in the child, and the mutex may have been locked when it was copied.
    pthread_atfork(nullptr, nullptr, [] { sleepers = new Sleepers; });
  });
  return *sleepers;
}

}  // namespace

HelperThreads::HelperThreads(int count) {
  if (count <= 0) return;
  Sleepers& all = OfThisProcess();
  const std::lock_guard<std::mutex> lock(all.mutex);
  for (int missing = count - static_cast<int>(all.threads.size()); missing > 0; --missing) {
    all.threads.push_back(new HelperThread);
  }
  helpers_.assign(all.threads.end() - count, all.threads.end());
  all.threads.resize(all.threads.size() - static_cast<size_t>(count));
}

HelperThreads::~HelperThreads() {
  if (helpers_.empty()) return;
  Wait();
  Sleepers& all = OfThisProcess();
  const std::lock_guard<std::mutex> lock(all.mutex);
  all.threads.insert(all.threads.end(), helpers_.begin(), helpers_.end());
}

void HelperThreads::Begin(const std::function<void(int i)>& work) {
  for (size_t i = 0; i < helpers_.size(); ++i) {
    helpers_[i]->Begin([&work, i] { work(static_cast<int>(i)); });
  }
}

void HelperThreads::Wait() {
  for (HelperThread* const helper : helpers_) helper->Wait();
}

}  // namespace sagitta

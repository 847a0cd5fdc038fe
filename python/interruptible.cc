#include "python/interruptible.h"

#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <set>
#include <thread>

namespace sagitta::python {

namespace py = pybind11;

namespace {

constexpr auto kPatience = std::chrono::seconds(10);

// Read and written with the interpreter's lock held, never without.
struct RunningCalls {
  std::set<RunningCall*> calls;
  bool is_ending = false;
  std::thread::id ender;  // may call while the interpreter ends: handlers of users run in it
};

RunningCalls& Running() {
  static auto* running = new RunningCalls;  // never destroyed: a thread may outlive what is static
  return *running;
}

// What the two threads share.
class Work {
 public:
  Work(const std::function<void(const Say&)>& work, std::atomic<bool>* stop)
      : stop_(stop), thread_([this, work] { Run(work); }) {}
  ~Work() {
    const py::gil_scoped_release others_may_run;
    thread_.join();
  }

  void Stop() { *stop_ = true; }

  // Waits a moment. True when the work has ended; hands out what was said meanwhile.
  bool Wait(std::deque<std::string>* said) {
    const py::gil_scoped_release others_may_run;
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait_for(lock, std::chrono::milliseconds(50), [this] { return done_ || !said_.empty(); });
    said->swap(said_);
    said_.clear();
    return done_;
  }

  std::exception_ptr failure() const { return failure_; }

 private:
  void Run(const std::function<void(const Say&)>& work) {
    const Interruptible scope(stop_);
    try {
      work([this](const std::string& what) {
        if (*stop_) throw Interruption();
        const std::lock_guard<std::mutex> lock(mutex_);
        said_.push_back(what);
        changed_.notify_all();
      });
    } catch (...) {
      failure_ = std::current_exception();
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    done_ = true;
    changed_.notify_all();
  }

  std::atomic<bool>* stop_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::string> said_;
  bool done_ = false;
  std::exception_ptr failure_;
  std::thread thread_;  // last: it uses all the others
};

}  // namespace

RunningCall::RunningCall() {
  RunningCalls& running = Running();
  if (running.is_ending && running.ender != std::this_thread::get_id()) RaiseSystemExit();
  running.calls.insert(this);
}

RunningCall::~RunningCall() { Running().calls.erase(this); }

void RaiseSystemExit() {
  PyErr_SetNone(PyExc_SystemExit);
  throw py::error_already_set();
}

void ForgetRunningCalls() { Running().calls.clear(); }

void EndRunningCalls() {
  RunningCalls& running = Running();
  running.is_ending = true;
  running.ender = std::this_thread::get_id();
  for (RunningCall* call : running.calls) *call->stop() = true;
  const auto latest = std::chrono::steady_clock::now() + kPatience;
  while (!running.calls.empty() && std::chrono::steady_clock::now() < latest) {
    const py::gil_scoped_release others_may_run;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

void RunInterruptibly(const py::object& progress, const std::function<void(const Say&)>& work) {
  std::exception_ptr raised, failure;
  RunningCall call;
  {
    Work running(work, call.stop());
    bool done = false;
    while (!done) {
      std::deque<std::string> said;
      done = running.Wait(&said);
      if (raised) continue;
      try {
        for (const std::string& what : said) {
          if (!progress.is_none()) progress(what);
        }
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
        if (*call.stop()) RaiseSystemExit();
      } catch (...) {
        raised = std::current_exception();
        running.Stop();
      }
    }
    failure = running.failure();
  }
  if (raised) std::rethrow_exception(raised);
  if (failure) std::rethrow_exception(failure);
}

}  // namespace sagitta::python

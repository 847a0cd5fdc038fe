// Long work next to the interpreter: the global lock is free; Ctrl-C, an exception of the progress callback and the end
// of the interpreter end it.
#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <functional>
#include <optional>
#include <string>

#include "problems/interruption.h"

namespace sagitta::python {

// A call that may be without the interpreter's lock. A thread that asks for the lock when the interpreter has ended is
// ended itself, in the middle of C++, and the process aborts: so the interpreter waits for all calls before that. Made
// and destroyed with the lock held; a call that begins after the interpreter has asked raises SystemExit.
class RunningCall {
 public:
  RunningCall();
  ~RunningCall();
  RunningCall(const RunningCall&) = delete;
  RunningCall& operator=(const RunningCall&) = delete;

  // Raised where the call is to end.
  std::atomic<bool>* stop() { return &stop_; }

 private:
  std::atomic<bool> stop_{false};
};

// The threads of a process that forked are not in its child: nothing is waited for there.
void ForgetRunningCalls();

// What ends the calling thread without a word, as an exception of Python.
[[noreturn]] void RaiseSystemExit();

// The atexit handler: asks all calls to end and waits for them, at most ten seconds.
void EndRunningCalls();

// Other threads of Python run for as long as the object lives; what the core does meanwhile may throw Interruption.
class OthersMayRun {
  RunningCall call_;
  Interruptible scope_{call_.stop()};
  pybind11::gil_scoped_release released_;
};

using Say = std::function<void(const std::string&)>;

// Runs `work` on a thread of its own; the calling thread passes what it says to `progress` (None: to nobody) and asks
// Python for signals 20 times a second. What work throws is thrown here, and so is what Python raises.
void RunInterruptibly(const pybind11::object& progress, const std::function<void(const Say&)>& work);

template <typename Result>
Result ResultOf(const pybind11::object& progress, const std::function<Result(const Say&)>& work) {
  std::optional<Result> result;
  RunInterruptibly(progress, [&](const Say& say) { result.emplace(work(say)); });
  return std::move(*result);
}

}  // namespace sagitta::python

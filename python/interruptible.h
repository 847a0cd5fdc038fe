// Long work next to the interpreter: the global lock is free, Ctrl-C and an exception of the progress callback end it.
#pragma once

#include <pybind11/pybind11.h>

#include <functional>
#include <optional>
#include <string>

namespace sagitta::python {

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

// Ends long work early, at the wish of somebody on another thread: who holds the flag raises it, and what iterates
// throws at its next step. What was interrupted writes nothing: output files ask too.
//
//   std::atomic<bool> stop{false};      // raised by another thread
//   const Interruptible scope(&stop);   // on the thread that works; ParallelFor hands it on to its helpers
//   Calibrate(problem);                 // throws Interruption
#pragma once

#include <atomic>
#include <stdexcept>

namespace sagitta {

struct Interruption : std::runtime_error {
  Interruption() : std::runtime_error("interrupted") {}
};

// The flag of this thread for as long as the object lives; null: nobody interrupts.
class Interruptible {
 public:
  explicit Interruptible(const std::atomic<bool>* stop);
  ~Interruptible();
  Interruptible(const Interruptible&) = delete;
  Interruptible& operator=(const Interruptible&) = delete;

  static const std::atomic<bool>* Flag();

 private:
  const std::atomic<bool>* before_;
};

// Whether the flag of this thread is set.
bool IsInterrupted();
// Throws Interruption.
void CheckInterruption();

}  // namespace sagitta

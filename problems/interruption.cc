#include "problems/interruption.h"

namespace sagitta {
namespace {

thread_local const std::atomic<bool>* t_stop = nullptr;

}  // namespace

Interruptible::Interruptible(const std::atomic<bool>* stop) : before_(t_stop) { t_stop = stop; }

Interruptible::~Interruptible() { t_stop = before_; }

const std::atomic<bool>* Interruptible::Flag() { return t_stop; }

bool IsInterrupted() { return t_stop != nullptr && t_stop->load(std::memory_order_relaxed); }

void CheckInterruption() {
  if (IsInterrupted()) throw Interruption();
}

}  // namespace sagitta

// Whether work ends where it is interrupted.
#pragma once

#include <gtest/gtest.h>

#include <atomic>

#include "problems/interruption.h"

namespace sagitta::test {

// `work` throws Interruption where the flag is up, and nothing where it is not.
template <typename Work>
void ExpectInterruptible(const Work& work) {
  std::atomic<bool> stop{false};
  const Interruptible scope(&stop);
  EXPECT_NO_THROW(work());
  stop = true;
  EXPECT_THROW(work(), Interruption);
}

}  // namespace sagitta::test

// With every instruction set that batched code is compiled for and this machine has: a user's machine may have less.
#pragma once

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cstdint>
#include <functional>
#include <set>
#include <string>

#include "models/batch/batch_rows.h"

namespace sagitta::test {

inline void OnEveryInstructionSet(const std::function<void()>& check) {
  std::set<std::string> done;
  for (std::int64_t left = hwy::SupportedTargets(); left != 0; left &= left - 1) {
    hwy::SetSupportedTargetsForTest(left & -left);
    hwy::GetChosenTarget().DeInit();
    SCOPED_TRACE(BatchInstructions());
    if (done.insert(BatchInstructions()).second) check();
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().DeInit();
}

}  // namespace sagitta::test

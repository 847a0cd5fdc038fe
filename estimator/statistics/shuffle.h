#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace sagitta {

// In an order that is drawn (Fisher and Yates), the same wherever it is compiled: std::shuffle does not say how it
// draws.
template <typename Value, typename Random>
void Shuffle(std::vector<Value>* values, Random* random) {
  for (std::size_t k = values->size(); k > 1; --k) std::swap((*values)[k - 1], (*values)[(*random)() % k]);
}

}  // namespace sagitta

// Independent pieces of work on several threads. What comes out does not depend
// on how many: every piece has its number and its own seed.
#pragma once

#include <algorithm>
#include <functional>
#include <optional>
#include <vector>

namespace sagitta {

// Calls work(i, worker) once for every i in 0..n-1; worker in 0..threads-1 says
// which thread, for buffers of its own. The first exception is thrown again here.
void ParallelFor(int n, int threads, const std::function<void(int i, int worker)>& work);

// Calls make(i, slot) once for every i in 0..n-1, each on one of the threads, and use(slot, user) for i after i, by
// every user in 0..threads-1 on a thread of its own. slots: how many i are made and not yet used by all; slot i % slots
// has i. The first exception is thrown again here.
void MakeAndUse(int n, int threads, int slots, const std::function<void(int i, int slot)>& make,
                const std::function<void(int slot, int user)>& use);

// The result of the smallest i in 0..n-1 for which work(i) has one; those beyond it are tried by the way only.
template <typename Result>
std::optional<Result> FirstFound(int n, int threads, const std::function<std::optional<Result>(int i)>& work) {
  for (int first = 0; first < n; first += threads) {
    std::vector<std::optional<Result>> found(std::min(threads, n - first));
    ParallelFor(static_cast<int>(found.size()), threads, [&](int i, int) { found[i] = work(first + i); });
    for (std::optional<Result>& result : found) {
      if (result) return std::move(result);
    }
  }
  return std::nullopt;
}

}  // namespace sagitta

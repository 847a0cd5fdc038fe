// Independent pieces of work on several threads. What comes out does not depend
// on how many: every piece has its number and its own seed.
#pragma once

#include <functional>

namespace sagitta {

// Calls work(i, worker) once for every i in 0..n-1; worker in 0..threads-1 says
// which thread, for buffers of its own. The first exception is thrown again here.
void ParallelFor(int n, int threads, const std::function<void(int i, int worker)>& work);

// Calls make(i, slot) once for every i in 0..n-1, each on one of the threads, and use(slot, user) for i after i, by
// every user in 0..threads-1 on a thread of its own. slots: how many i are made and not yet used by all; slot i % slots
// has i. The first exception is thrown again here.
void MakeAndUse(int n, int threads, int slots, const std::function<void(int i, int slot)>& make,
                const std::function<void(int slot, int user)>& use);

}  // namespace sagitta

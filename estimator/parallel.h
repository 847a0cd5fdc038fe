// Independent pieces of work on several threads. What comes out does not depend
// on how many: every piece has its number and its own seed.
#pragma once

#include <functional>

namespace sagitta {

// Calls work(i, worker) once for every i in 0..n-1; worker in 0..threads-1 says
// which thread, for buffers of its own. The first exception is thrown again here.
void ParallelFor(int n, int threads, const std::function<void(int i, int worker)>& work);

}  // namespace sagitta

// Memory of a program that reads long tables once and makes matrices by the thousand.
#pragma once

namespace sagitta {

// At the beginning of main, before anything large is asked for.
void PrepareHeap();

}  // namespace sagitta

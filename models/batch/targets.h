// Instruction sets that the batched code is compiled for; the best one that the machine has runs. Those left out are
// close to one that stays, or have registers of unknown size. To be included before any header of Highway.
#pragma once

#undef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS \
  (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)

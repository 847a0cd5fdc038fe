// What becomes of 64 random bits.
#pragma once

#include <cstdint>

namespace sagitta {

// In [0, 1), of the upper 53 bits.
inline double UnitNumber(std::uint64_t bits) { return static_cast<double>(bits >> 11) * 0x1.0p-53; }

// 2^64 over the golden ratio: its multiples lie evenly in all bits, the highest first (Knuth, The art of computer
// programming 3, 6.4), and it is what SplitMix64 adds at each step.
constexpr std::uint64_t kGoldenBits = 0x9E3779B97F4A7C15ULL;

// The last step of SplitMix64 (Steele, Lea and Flood 2014): numbers that differ by a constant become unrelated.
inline std::uint64_t MixedBits(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
  return z ^ (z >> 31);
}

}  // namespace sagitta

// Random numbers for tests: seeded, and the same on every platform.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>

namespace sagitta::test {

class RandomNumbers {
 public:
  explicit RandomNumbers(std::uint64_t seed) : random_(seed) {}

  double Uniform(double low, double high) {
    return low + (high - low) * (static_cast<double>(random_() >> 11) * 0x1.0p-53);
  }
  int Index(int n) { return static_cast<int>(random_() % static_cast<std::uint64_t>(n)); }
  double Sign() { return Index(2) == 0 ? -1.0 : 1.0; }
  Eigen::Vector3d Vector(double size) { return {Uniform(-size, size), Uniform(-size, size), Uniform(-size, size)}; }

 private:
  std::mt19937_64 random_;
};

}  // namespace sagitta::test

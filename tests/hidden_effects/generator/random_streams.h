// Random numbers in independent streams: each case of each study, and within a
// case each purpose, has a generator of its own, seeded by all three.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>

namespace hidden {

enum class Purpose : std::uint32_t { kDesign = 1, kGeometry, kEffect, kNoise, kRepeatability, kOutliers };

// A stream hands out numbers in the order of its calls: at most one call in an expression, unless a comma between
// declarations or in braces says which comes first. Compilers differ in the order of arguments and of operands.
class Stream {
 public:
  Stream(std::uint64_t study, std::uint64_t number, Purpose purpose) {
    std::seed_seq seed{static_cast<std::uint32_t>(study), static_cast<std::uint32_t>(study >> 32),
                       static_cast<std::uint32_t>(number), static_cast<std::uint32_t>(number >> 32),
                       static_cast<std::uint32_t>(purpose)};
    engine_.seed(seed);
  }

  double Uniform(double low, double high) { return low + (high - low) * ((engine_() >> 11) * 0x1.0p-53); }
  int Below(int n) { return static_cast<int>(Uniform(0.0, n)); }
  bool Chance(double p) { return Uniform(0.0, 1.0) < p; }
  double Sign() { return Chance(0.5) ? 1.0 : -1.0; }

  // Box-Muller: the standard fixes the engine, not std::normal_distribution.
  double Normal(double sigma = 1.0) {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - Uniform(0.0, 1.0)));
    return sigma * radius * std::cos(6.283185307179586 * Uniform(0.0, 1.0));
  }
  Eigen::Vector3d NormalVector(double sigma) {
    const double x = Normal(sigma), y = Normal(sigma), z = Normal(sigma);
    return {x, y, z};
  }
  Eigen::Vector3d Direction() { return NormalVector(1.0).normalized(); }

 private:
  std::mt19937_64 engine_;
};

}  // namespace hidden

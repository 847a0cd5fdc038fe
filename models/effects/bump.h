// A smooth function by its knots: Gaussian bumps, as wide as they are apart. With independent weights of unit variance
// it is a random function of unit variance inside the knots (the sum over an endless row of squared bumps is sqrt(pi));
// beyond them it fades to zero within two distances.
// Or what changes at once, creeps or wanders: ramps from one knot to the next, which keep their end; one alone is a
// jump somewhere between two knots. With independent weights it is a random walk from zero at the first knot; the
// factor sqrt(6 / n) of n ramps gives it unit variance about its mean over the range where the weights have (of
// Brownian motion that is a sixth of the variance at the end).
#pragma once

#include <algorithm>
#include <cmath>

#include "models/constants.h"

namespace sagitta {

template <typename T>
T Bump(const T& x, double at, double width) {
  using std::exp;
  static const double unit = std::pow(kPi, -0.25);
  const T off = (x - T(at)) / T(width);
  return T(unit) * exp(T(-0.5) * off * off);
}

// Knots evenly over [low, high]: one for each function, of ramps one more.
struct Knots {
  double low = 0.0, high = 1.0;
  int count = 2;  // functions
  bool ramps = false;

  double Apart() const { return (high - low) / (ramps ? count : std::max(1, count - 1)); }
  double At(int k) const { return low + k * Apart(); }
  double Value(int k, double x) const {
    if (!ramps) return Bump(x, At(k), Apart());
    return std::sqrt(6.0 / count) * std::clamp((x - At(k)) / Apart(), 0.0, 1.0);
  }
};

}  // namespace sagitta

// A smooth function by its knots: Gaussian bumps, as wide as they are apart. With independent weights of unit variance
// it is a random function of unit variance inside the knots (the sum over an endless row of squared bumps is sqrt(pi));
// beyond them it fades to zero within two distances.
#pragma once

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

// Knots evenly over [low, high].
struct Knots {
  double low = 0.0, high = 1.0;
  int count = 2;

  double Apart() const { return (high - low) / (count - 1); }
  double At(int k) const { return low + k * Apart(); }
  double Value(int k, double x) const { return Bump(x, At(k), Apart()); }
};

}  // namespace sagitta

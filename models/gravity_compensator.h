// The spring between link and base that carries part of a heavy arm's weight.
//
//   s^2 = a^2 + L^2 + 2 a L cos(gamma),  gamma = alpha - q,  alpha = atan2(a_x, a_y)
//   torque on the joint = -Kc (1 - s0/s) a L sin(gamma)            N m
//   stiffness = -d torque / d q = Kc a L eta,
//   eta = (s0/s) (a L sin^2(gamma)/s^2 + cos(gamma)) - cos(gamma)
//
// Papers 000 and 002, eq. (10), (11), (14); alpha is measured from the vertical
// (a_x and a_y swapped against the usual atan2), the only reading that
// reproduces the published fit. With a sin(gamma) = a_x cos q - a_y sin q and
// a cos(gamma) = a_y cos q + a_x sin q no angle is ever formed.
//
// (L, a_x, a_y, s0, Kc) has a scale gauge: c (L, a_x, a_y, s0), Kc / c^2 gives
// the same torque at every q.
#pragma once

#include <cmath>
#include <string>

namespace sagitta {

// How candidates of the diagnosis name it among the effects.
constexpr char kGravityCompensator[] = "gravity_compensator";

// Its unknowns, in the order of CompensatorParameters and of a model's theta.
enum class CompensatorPart { kL, kAx, kAy, kS0, kKc };
constexpr CompensatorPart kCompensatorParts[] = {CompensatorPart::kL, CompensatorPart::kAx, CompensatorPart::kAy,
                                                 CompensatorPart::kS0, CompensatorPart::kKc};

// L, a_x, a_y, s0, Kc.
inline const char* WordOf(CompensatorPart part) {
  switch (part) {
    case CompensatorPart::kL:
      return "L";
    case CompensatorPart::kAx:
      return "a_x";
    case CompensatorPart::kAy:
      return "a_y";
    case CompensatorPart::kS0:
      return "s0";
    case CompensatorPart::kKc:
      return "Kc";
  }
  return "";
}

// Of the parameter in results: compensator/L.
inline std::string NameOf(CompensatorPart part) { return std::string("compensator/") + WordOf(part); }

// What it is made of.
template <typename T>
struct CompensatorParameters {
  T L, a_x, a_y, s0;  // m
  T Kc;               // N/m
};

// Length of the spring, m, at joint value q (law of cosines), of which cosine and sine are given.
template <typename T>
T CompensatorSpringLength(const CompensatorParameters<T>& p, const T& cosine, const T& sine) {
  using std::sqrt;
  const T a_cos_gamma = p.a_y * cosine + p.a_x * sine;
  return sqrt(p.a_x * p.a_x + p.a_y * p.a_y + p.L * p.L + T(2) * p.L * a_cos_gamma);
}

// Of the actual joint angle q, of which cosine and sine are given.
template <typename T>
T CompensatorTorque(const CompensatorParameters<T>& p, const T& cosine, const T& sine) {
  const T a_sin_gamma = p.a_x * cosine - p.a_y * sine;
  return -p.Kc * (T(1) - p.s0 / CompensatorSpringLength(p, cosine, sine)) * p.L * a_sin_gamma;
}

// q: rad.
template <typename T>
T CompensatorSpringLength(const CompensatorParameters<T>& p, const T& q) {
  using std::cos;
  using std::sin;
  return CompensatorSpringLength(p, T(cos(q)), T(sin(q)));
}

// q: actual joint angle, rad.
template <typename T>
T CompensatorTorque(const CompensatorParameters<T>& p, const T& q) {
  using std::cos;
  using std::sin;
  return CompensatorTorque(p, T(cos(q)), T(sin(q)));
}

}  // namespace sagitta

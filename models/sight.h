// What an instrument that reads azimuth, elevation and range makes of a point when a reading is wrong.
//
// With d = p - instrument, s = |d|, h = |(d_x, d_y)|, e = d / s, z the measurement frame's third axis (up):
//
//   azimuth a = atan2(d_y, d_x)      d p / d a = z x d
//   elevation b = atan2(d_z, h)      d p / d b = s (z - sin b e) / cos b = h z - d_z (d_x, d_y, 0) / h
//   range s                          d p / d s = e
//
// A reading that is too large by factor * theta * g moves the point by that times d p / d reading: first order, as
// every effect. g = cos a, sin a: the circle's centre is off the axis of rotation (Muralikrishnan et al., ASME B89.4.19
// performance evaluation tests and geometric misalignments in laser trackers, J. Res. NIST 114 (2009) 21). g = psi^2,
// psi the angle between the marker's axis and the direction to the instrument. g = s: refraction. g of a reading x = a,
// b or s: a bump over (x - centre) / width, or cos, sin of 2 pi x / period; azimuths are the same after a turn.
#pragma once

#include <cmath>

#include "models/constants.h"
#include "models/effects/bump.h"
#include "models/effects/effect.h"

namespace sagitta {

// m: a point that close to the instrument has no direction, one that close to its upright axis no azimuth.
constexpr double kNoSight = 1e-9;

// acos(c)^2, smooth at c = 1: the series of acos^2 there, acos^2 = 2 x + x^2 / 3 + 4 x^3 / 45 + x^4 / 70, x = 1 - c
// (the next term is x^5 / 394).
template <typename T>
T SquaredAngle(const T& cosine) {
  using std::acos;
  const T x = T(1) - cosine;
  if (x < T(1e-3)) return x * (T(2) + x * (T(1.0 / 3.0) + x * (T(4.0 / 45.0) + x * T(1.0 / 70.0))));
  if (cosine < T(-1.0 + 1e-12)) return T(kPi * kPi);  // seen from behind
  const T angle = acos(cosine);
  return angle * angle;
}

// x - centre where the instrument sees d; h = |(d_x, d_y)|, s = |d|.
template <typename T>
T ReadingFrom(double centre, Sensed reading, const Vector3<T>& d, const T& h, const T& s) {
  using std::atan2;
  if (reading == Sensed::kRange) return s - T(centre);
  if (reading == Sensed::kElevation) return atan2(d.z(), h) - T(centre);
  // Of the azimuth from the centre on: within half a turn.
  const double c = std::cos(centre), e = std::sin(centre);
  return atan2(T(c * d.y() - e * d.x()), T(c * d.x() + e * d.y()));
}

// g of what goes with a reading.
template <typename T>
T SightFunction(const SightTerm& term, const Vector3<T>& d, const T& h, const T& s) {
  using std::cos;
  using std::sin;
  if (term.law == SightLaw::kBump) return Bump(ReadingFrom(term.centre, term.over, d, h, s), 0.0, term.width);
  const T phase = T(2.0 * kPi / term.width) * ReadingFrom(0.0, term.over, d, h, s);
  return term.law == SightLaw::kCosWave ? T(cos(phase)) : T(sin(phase));
}

// Whether the displacement has a direction, or goes with one, that a point on the upright axis does not have.
inline bool NeedsAzimuth(const SightTerm& term) {
  const bool by_azimuth = term.law == SightLaw::kCosAzimuth || term.law == SightLaw::kSinAzimuth;
  return term.sensed != Sensed::kRange || by_azimuth || (term.law >= SightLaw::kBump && term.over == Sensed::kAzimuth);
}

// The displacement of the point per unit of the parameter. axis: the marker's, in the measurement frame.
template <typename T>
Vector3<T> SightDisplacement(const SightTerm& term, const Vector3<T>& point, const Vector3<T>& axis) {
  using std::sqrt;
  const Vector3<T> d = point - term.instrument.cast<T>();
  const T squared_h = d.x() * d.x() + d.y() * d.y();
  const bool is_upright = squared_h < T(kNoSight * kNoSight);
  const T squared_s = squared_h + d.z() * d.z();
  if (squared_s < T(kNoSight * kNoSight) || (is_upright && NeedsAzimuth(term))) return Vector3<T>::Zero();
  const T h = is_upright ? T(0) : T(sqrt(squared_h));  // the root has no derivative at zero
  const T s = sqrt(squared_s);
  T times(1);
  if (term.law == SightLaw::kRange) times = s;
  if (term.law == SightLaw::kCosAzimuth) times = d.x() / h;
  if (term.law == SightLaw::kSinAzimuth) times = d.y() / h;
  if (term.law == SightLaw::kCosElevation) times = h / s;
  if (term.law == SightLaw::kSinElevation) times = d.z() / s;
  if (term.law == SightLaw::kSquaredIncidence) times = SquaredAngle(T(-axis.dot(d) / s));
  if (term.law >= SightLaw::kBump) times = SightFunction(term, d, h, s);
  times *= T(term.factor);
  if (term.sensed == Sensed::kAzimuth) return times * Vector3<T>(-d.y(), d.x(), T(0));
  if (term.sensed == Sensed::kElevation) return times * Vector3<T>(-d.z() * d.x() / h, -d.z() * d.y() / h, h);
  return times * Vector3<T>(d / s);
}

// The same with its derivatives.
struct SightGradient {
  Vector3<double> displacement;
  Matrix3<double> by_point, by_axis;
};
// At a point, m, of a marker with that axis.
SightGradient DifferentiateSight(const SightTerm& term, const Vector3<double>& point, const Vector3<double>& axis);

}  // namespace sagitta

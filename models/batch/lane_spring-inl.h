// The gravity compensator's torque and what slots make of theirs, in one register's worth of shots. Compiled once per
// instruction set.
#if defined(SAGITTA_MODELS_BATCH_LANE_SPRING_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SAGITTA_MODELS_BATCH_LANE_SPRING_INL_H_
#undef SAGITTA_MODELS_BATCH_LANE_SPRING_INL_H_
#else
#define SAGITTA_MODELS_BATCH_LANE_SPRING_INL_H_
#endif

#include <hwy/contrib/math/math-inl.h>

#include "models/batch/lanes-inl.h"
#include "models/batch/shot_program.h"
#include "models/constants.h"

HWY_BEFORE_NAMESPACE();
namespace sagitta {
namespace HWY_NAMESPACE {

// phi(T): T, T^3, sign(T) or, with a width, tanh(T / width), or a bump (models/effects/bump.h).
HWY_INLINE V LawAt(const ShotProgram::Elastic& term, V torque) {
  if (term.law == ElasticLaw::kLinear) return torque;
  if (term.law == ElasticLaw::kCubic) return hn::Mul(torque, hn::Mul(torque, torque));
  if (term.law == ElasticLaw::kBump) {
    const V knots = hn::Div(hn::Sub(torque, Of(term.centre)), Of(term.width));
    return hn::Mul(Of(std::pow(kPi, -0.25)), hn::Exp(Tag(), hn::Mul(Of(-0.5), hn::Mul(knots, knots))));
  }
  if (term.width > 0.0) return hn::Tanh(Tag(), hn::Div(torque, Of(term.width)));
  const V zero = Of(0.0);
  return hn::Sub(hn::IfThenElseZero(hn::Lt(zero, torque), Of(1.0)), hn::IfThenElseZero(hn::Lt(torque, zero), Of(1.0)));
}
// d phi / d T, where phi is `value`.
HWY_INLINE V LawDerivativeAt(const ShotProgram::Elastic& term, V torque, V value) {
  if (term.law == ElasticLaw::kLinear) return Of(1.0);
  if (term.law == ElasticLaw::kCubic) return hn::Mul(Of(3.0), hn::Mul(torque, torque));
  if (!(term.width > 0.0)) return Of(0.0);
  const V per_width = Of(1.0 / term.width);
  if (term.law == ElasticLaw::kSign) return hn::Mul(per_width, Fnma(value, value, Of(1.0)));
  return hn::Mul(value, hn::Mul(hn::Mul(per_width, per_width), hn::Sub(Of(term.centre), torque)));
}

// T = -Kc (1 - s0/s) L A,  A = a_x cos q - a_y sin q,  C = a_y cos q + a_x sin q,  s^2 = a^2 + L^2 + 2 L C
// (models/gravity_compensator.h); d s = (L A dq + (L + C) dL + (a_x + L sin q) da_x + (a_y + L cos q) da_y) / s.
struct SpringTorque {
  V torque, by_angle, by[5];
};
// theta: L, a_x, a_y, s0, Kc; sine and cosine of the joint's angle.
HWY_INLINE SpringTorque SpringAt(const double* theta, V sine, V cosine) {
  const V length = Of(theta[0]), ax = Of(theta[1]), ay = Of(theta[2]), rest = Of(theta[3]), rate = Of(theta[4]);
  const V across = Fnma(ay, sine, hn::Mul(ax, cosine)), along = Fma(ay, cosine, hn::Mul(ax, sine));
  const V square = Fma(hn::Add(length, hn::Add(along, along)), length, Fma(ax, ax, hn::Mul(ay, ay)));
  const V per_s = hn::Div(Of(1.0), hn::Sqrt(square));
  const V ratio = hn::Mul(rest, per_s), slack = hn::Sub(Of(1.0), ratio);
  const V by_s = hn::Mul(ratio, hn::Mul(per_s, per_s));  // d slack = (s0 / s^2) ds, ds = (..) / s
  const V arm = hn::Mul(length, across), minus_rate = hn::Neg(rate);
  SpringTorque result;
  result.torque = hn::Mul(hn::Mul(minus_rate, slack), arm);
  const auto by = [&](V ds, V d_arm)
                      HWY_ATTR { return hn::Mul(minus_rate, Fma(hn::Mul(by_s, ds), arm, hn::Mul(slack, d_arm))); };
  result.by_angle = by(arm, hn::Neg(hn::Mul(length, along)));
  result.by[0] = by(hn::Add(length, along), across);
  result.by[1] = by(Fma(length, sine, ax), hn::Mul(length, cosine));
  result.by[2] = by(Fma(length, cosine, ay), hn::Neg(hn::Mul(length, sine)));
  result.by[3] = hn::Mul(hn::Mul(rate, arm), per_s);
  result.by[4] = hn::Neg(hn::Mul(slack, arm));
  return result;
}

}  // namespace HWY_NAMESPACE
}  // namespace sagitta
HWY_AFTER_NAMESPACE();

#endif

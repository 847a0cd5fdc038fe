// Numbers of several shots in one register, and small vectors of them. Compiled once per instruction set.
#if defined(SAGITTA_MODELS_BATCH_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SAGITTA_MODELS_BATCH_LANES_INL_H_
#undef SAGITTA_MODELS_BATCH_LANES_INL_H_
#else
#define SAGITTA_MODELS_BATCH_LANES_INL_H_
#endif

#include <hwy/highway.h>

#include <cmath>

#include "models/batch/shot_program.h"

HWY_BEFORE_NAMESPACE();
namespace sagitta {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<double, kBatchLanes>;
using V = hn::Vec<Tag>;

HWY_INLINE V Of(double value) { return hn::Set(Tag(), value); }
HWY_INLINE V At(const double* p) { return hn::Load(Tag(), p); }
HWY_INLINE void Put(V value, double* p) { hn::Store(value, Tag(), p); }
HWY_INLINE V Fma(V a, V b, V c) { return hn::MulAdd(a, b, c); }      // a b + c
HWY_INLINE V Fnma(V a, V b, V c) { return hn::NegMulAdd(a, b, c); }  // c - a b

struct V3 {
  V x, y, z;
};
HWY_INLINE V3 Zero3() { return {Of(0.0), Of(0.0), Of(0.0)}; }
HWY_INLINE V3 operator+(V3 a, V3 b) { return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)}; }
HWY_INLINE V3 operator-(V3 a, V3 b) { return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)}; }
HWY_INLINE V3 Times(V a, V3 b) { return {hn::Mul(a, b.x), hn::Mul(a, b.y), hn::Mul(a, b.z)}; }
HWY_INLINE V3 Fma(V a, V3 b, V3 c) { return {Fma(a, b.x, c.x), Fma(a, b.y, c.y), Fma(a, b.z, c.z)}; }
HWY_INLINE V3 Fnma(V a, V3 b, V3 c) { return {Fnma(a, b.x, c.x), Fnma(a, b.y, c.y), Fnma(a, b.z, c.z)}; }
HWY_INLINE V Dot(V3 a, V3 b) { return Fma(a.x, b.x, Fma(a.y, b.y, hn::Mul(a.z, b.z))); }
HWY_INLINE V3 Cross(V3 a, V3 b) {
  return {Fnma(a.z, b.y, hn::Mul(a.y, b.z)), Fnma(a.x, b.z, hn::Mul(a.z, b.x)), Fnma(a.y, b.x, hn::Mul(a.x, b.y))};
}
HWY_INLINE V3 At3(const double* data, int index, int lane) {
  const double* p = data + index * kBatchLanes + lane;
  return {At(p), At(p + kBatchLanes), At(p + 2 * kBatchLanes)};
}

struct M3 {
  V3 column[3];
};
HWY_INLINE M3 Zero33() { return {{Zero3(), Zero3(), Zero3()}}; }
HWY_INLINE V3 operator*(const M3& m, V3 v) {
  return Fma(v.x, m.column[0], Fma(v.y, m.column[1], Times(v.z, m.column[2])));
}
HWY_INLINE V3 TransposeTimes(const M3& m, V3 v) {
  return {Dot(m.column[0], v), Dot(m.column[1], v), Dot(m.column[2], v)};
}
HWY_INLINE M3 operator*(const M3& a, const M3& b) { return {{a * b.column[0], a * b.column[1], a * b.column[2]}}; }
HWY_INLINE V Trace(const M3& m) { return hn::Add(m.column[0].x, hn::Add(m.column[1].y, m.column[2].z)); }
template <typename Matrix>
HWY_INLINE M3 Same(const Matrix& m) {
  M3 result;
  for (int c = 0; c < 3; ++c) result.column[c] = {Of(m(0, c)), Of(m(1, c)), Of(m(2, c))};
  return result;
}
// Row by row in the data.
HWY_INLINE M3 AtMatrix(const double* data, int index, int lane) {
  const V3 a = At3(data, index, lane), b = At3(data, index + 3, lane), c = At3(data, index + 6, lane);
  return {{{a.x, b.x, c.x}, {a.y, b.y, c.y}, {a.z, b.z, c.z}}};
}

struct Frame {
  M3 rotation;
  V3 origin;
};
HWY_INLINE V3 operator*(const Frame& frame, V3 point) { return frame.rotation * point + frame.origin; }

struct TwistLanes {
  V3 w, v;
};
// What lies in memory, number by number: GCC copies a whole twist through the stack.
HWY_INLINE TwistLanes Held(const TwistLanes& t) { return {{t.w.x, t.w.y, t.w.z}, {t.v.x, t.v.y, t.v.z}}; }
HWY_INLINE TwistLanes ZeroTwist() { return {Zero3(), Zero3()}; }
HWY_INLINE TwistLanes Fma(V a, const TwistLanes& b, const TwistLanes& c) {
  return {Fma(a, b.w, c.w), Fma(a, b.v, c.v)};
}
HWY_INLINE TwistLanes Fnma(V a, const TwistLanes& b, const TwistLanes& c) {
  return {Fnma(a, b.w, c.w), Fnma(a, b.v, c.v)};
}
HWY_INLINE TwistLanes Times(V a, const TwistLanes& b) { return {Times(a, b.w), Times(a, b.v)}; }
HWY_INLINE V Work(const TwistLanes& twist, V3 moment, V3 force) {
  return hn::Add(Dot(twist.w, moment), Dot(twist.v, force));  // two chains that do not wait for each other
}

// sin and cos of all lanes: Taylor to order 15 below 1/4 (truncated at 1e-19), else one by one.
HWY_INLINE void SinCos(V angle, V* sine, V* cosine) {
  const V limit = Of(0.25);
  if (HWY_LIKELY(hn::AllTrue(Tag(), hn::Lt(hn::Abs(angle), limit)))) {
    const V x2 = hn::Mul(angle, angle);
    V s = Of(-1.0 / 39916800.0), c = Of(-1.0 / 3628800.0);
    s = Fma(Fma(x2, Of(1.0 / 6227020800.0), s), x2, Of(1.0 / 362880.0));
    s = Fma(Fma(s, x2, Of(-1.0 / 5040.0)), x2, Of(1.0 / 120.0));
    s = Fma(Fma(s, x2, Of(-1.0 / 6.0)), x2, Of(1.0));
    c = Fma(Fma(x2, Of(1.0 / 479001600.0), c), x2, Of(1.0 / 40320.0));
    c = Fma(Fma(c, x2, Of(-1.0 / 720.0)), x2, Of(1.0 / 24.0));
    *cosine = Fma(Fma(c, x2, Of(-0.5)), x2, Of(1.0));
    *sine = hn::Mul(s, angle);
    return;
  }
  HWY_ALIGN double values[kBatchLanes], sines[kBatchLanes], cosines[kBatchLanes];
  Put(angle, values);
  for (size_t i = 0; i < hn::Lanes(Tag()); ++i) sines[i] = std::sin(values[i]), cosines[i] = std::cos(values[i]);
  *sine = At(sines), *cosine = At(cosines);
}

}  // namespace HWY_NAMESPACE
}  // namespace sagitta
HWY_AFTER_NAMESPACE();

#endif

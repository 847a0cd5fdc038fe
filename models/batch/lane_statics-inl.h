// The loaded arm of one register's worth of shots: chain, torques, equilibrium and what moves it. Compiled once per
// instruction set. The equations are those of models/elastostatics.h and models/wrench.h, in the axes of the station
// with the arm's base as origin, where wrenches as measured stay as they are; wrenches are summed by the frames that
// bear them before any transform is looked at:
//
//   F = sum F_w,  M0 = sum x_w x F_w + M_w,  Q = sum F_w x_w'        over frames beyond the transform
//   tau_b = xi_b . (M0, F)
//   d tau_b / d v_a = S . w_a + H . v_a,  a >= b   S = Q z - tr(Q) z,  H = F x z        (z = z_b, a rotation)
//                   = before . w_a,       a < b    before = z x (M0 - o x F) + S - ((z . o) F - (o . F) z)
#if defined(SAGITTA_MODELS_BATCH_LANE_STATICS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SAGITTA_MODELS_BATCH_LANE_STATICS_INL_H_
#undef SAGITTA_MODELS_BATCH_LANE_STATICS_INL_H_
#else
#define SAGITTA_MODELS_BATCH_LANE_STATICS_INL_H_
#endif

#include <algorithm>

#include "models/batch/batch_rows.h"
#include "models/batch/lane_chain-inl.h"
#include "models/batch/lane_spring-inl.h"
#include "models/batch/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sagitta {
namespace HWY_NAMESPACE {

// rad or m. What is left is added to first order; derivatives keep as much, at most.
constexpr double kSettled = 1e-8;
// Newton's first step of a loaded arm errs by about half the cube of its size, rad; more than a hundredth of kSettled
// is worth another step by the same factors: torques alone.
constexpr double kWideStep = 6e-4;
constexpr double kFoldedLanes = 0.5;  // rad or m: the reference looks closer
constexpr int kMostNewtonSteps = 8;

class LaneStatics {
 public:
  LaneStatics(const ShotProgram& program, const BatchPoint& at, LaneMemory* memory)
      : p_(program), at_(at), slots_(static_cast<int>(program.slots.size())), chain_(program, at, memory) {
    const std::size_t slots = p_.slots.size(), levels = static_cast<std::size_t>(p_.num_levels);
    sums_ = memory->Take<Sums>(levels + 1);
    own_ = memory->Take<Sums>(levels + 1);
    moves_ = memory->Take<TwistLanes>(slots);
    origins_ = memory->Take<V3>(slots);
    beyond_ = memory->Take<TwistLanes>(slots * levels);
    before_ = memory->Take<V3>(slots);
    turned_ = memory->Take<V3>(slots);
    torque_ = memory->Take<V>(slots);
    own_torque_ = memory->Take<V>(slots);
    flexibility_ = memory->Take<V>(slots);
    deflection_ = memory->Take<V>(slots);
    step_ = memory->Take<V>(slots);
    law_ = memory->Take<V>(slots);
    matrix_ = memory->Take<V>(slots * slots);
    imposed_ = memory->Take<TwistLanes>(slots);
  }

  static std::size_t MemoryFor(const ShotProgram& p) {
    const std::size_t slots = p.slots.size(), levels = static_cast<std::size_t>(p.num_levels);
    return LaneChain::MemoryFor(p) + sizeof(V) * slots * (6 * (2 + levels) + 9 + 6 + slots) +
           2 * (levels + 1) * sizeof(Sums);
  }

  // Finds the equilibrium; a bit for each lane that does not get there. Each lane goes its own way: what it says does
  // not depend on its neighbours.
  unsigned Settle(const double* data, int lane) {
    data_ = data + lane;
    for (int s = 0; s < slots_; ++s) deflection_[s] = step_[s] = Of(0.0);
    if (p_.has_spring && p_.spring.commanded >= 0) {
      idle_ = SpringAt(SpringParameters(), Datum(p_.spring.commanded), Datum(p_.spring.commanded + 1));
    }
    auto settled = hn::Lt(Of(0.0), Of(slots_ > 0 ? 0.0 : 1.0));
    for (int i = 0; i < kMostNewtonSteps && !hn::AllTrue(Tag(), settled); ++i) {
      if (i > 0) {
        Deflect(hn::Not(settled));
        const auto wide = hn::AndNot(settled, hn::Lt(Of(kWideStep), largest_));
        if (!hn::AllFalse(Tag(), wide)) {
          EvaluateLaw(/*with_derivatives=*/false);
          FindStep();
          Deflect(wide);
        }
      }
      EvaluateLaw(/*with_derivatives=*/true);
      FactorResponse();
      FindStep();
      settled = hn::And(hn::Lt(largest_, Of(kSettled)), hn::Lt(bent_, Of(kFoldedLanes)));
    }
    if (!NeedsChain()) chain_.Evaluate(data_, deflection_);
    chain_.CompleteTwists();
    for (int s = 0; s < slots_; ++s) moves_[s] = chain_.Twist(p_.slots[s].twist);
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(Tag(), hn::Not(settled), bits);
    return bits[0];
  }

  const LaneChain& chain() const { return chain_; }
  V Datum(int index) const { return At(data_ + index * kBatchLanes); }
  V Phi(const ShotProgram::Elastic& term) const { return LawAt(term, torque_[term.slot]); }

  // From here on columns are twists of `frame`: imposed = Xi (I - F_u)^-1 over the slots before it, by the factors
  // L U = I - F_u.
  void RespondOn(int frame) {
    const int n = slots_;
    for (int c = 0; c < n; ++c) {
      TwistLanes y = p_.slots[c].transform < frame ? moves_[c] : ZeroTwist();
      for (int k = 0; k < c; ++k) y = Fnma(matrix_[k * n + c], imposed_[k], y);
      imposed_[c] = Times(matrix_[c * n + c], y);
    }
    for (int c = n - 2; c >= 0; --c) {
      TwistLanes x = imposed_[c];
      for (int k = c + 1; k < n; ++k) x = Fnma(matrix_[k * n + c], imposed_[k], x);
      imposed_[c] = x;
    }
  }
  // By a deflection imposed on a slot.
  const TwistLanes& Imposed(int slot) const { return imposed_[slot]; }

  // By the value of a transform.
  HWY_INLINE TwistLanes Total(int twist, int frame) const {
    const ShotProgram::Twist& own = p_.twists[twist];
    const TwistLanes& moves = chain_.Twist(twist);
    TwistLanes total = ZeroTwist();
    if (own.transform < frame) total = Held(moves);
    if (p_.num_levels > 0) {
      total = own.is_rotation ? WithAnswers<true>(own, moves, total) : WithAnswers<false>(own, moves, total);
    }
    if (BearsSpring(own)) total = Fma(SpringLaw(), imposed_[p_.spring.slot], total);
    return total;
  }

  // Adds what one unit of these wrenches does.
  void AddTorques(const ShotProgram::Loads& loads, TwistLanes* column) {
    FindTorques(loads);
    for (int s = 0; s < slots_; ++s) {
      *column = Fma(hn::Mul(flexibility_[s], own_torque_[s]), imposed_[s], *column);
    }
  }
  V TorqueOf(const ShotProgram::Loads& loads, int slot) {
    FindTorques(loads);
    return own_torque_[slot];
  }
  // How far a torque on each slot moves the slots (the largest), by what wrenches or a parameter of the spring do.
  V LargestDeflection(const ShotProgram::Loads& loads) {
    FindTorques(loads);
    return LargestOf([&](int s) HWY_ATTR { return own_torque_[s]; });
  }
  V LargestDeflectionBySpring(int parameter) {
    return LargestOf([&](int s) HWY_ATTR { return s == p_.spring.slot ? by_spring_[parameter] : Of(0.0); });
  }
  V TorqueOn(int slot) const { return torque_[slot]; }
  V LargestForce() const {
    V squared = Of(0.0);
    for (const ShotProgram::Wrench& wrench : p_.loads[0].wrenches) {
      const V3 force = At3(data_, wrench.data + 3, 0);
      squared = hn::Max(squared, Dot(force, force));
    }
    return hn::Sqrt(squared);
  }
  void AddSpring(int parameter, TwistLanes* column) const {
    const int s = p_.spring.slot;
    *column = Fma(hn::Mul(flexibility_[s], by_spring_[parameter]), imposed_[s], *column);
  }

  // By a left perturbation of the base rotation about a station's axis: the arm turns, wrenches that are given in the
  // measurement frame stay.
  HWY_INLINE TwistLanes ByRotation(int axis) const {
    const V one = Of(1.0), zero = Of(0.0);
    TwistLanes total = {{axis == 0 ? one : zero, axis == 1 ? one : zero, axis == 2 ? one : zero}, Zero3()};
    for (int s = 0; s < slots_; ++s) {
      const V3& by = turned_[s];
      total = Fma(axis == 0 ? by.x : axis == 1 ? by.y : by.z, imposed_[s], total);
    }
    return total;
  }

  // Goes by the last Newton step as well, for what asks for the state itself: it is exact then to the step's square.
  void TakeLastStep() {
    for (int s = 0; s < slots_; ++s) deflection_[s] = hn::Add(deflection_[s], step_[s]);
    chain_.Evaluate(data_, deflection_);
    chain_.CompleteTwists();
  }
  // Of wrenches, about the axis of any transform.
  V TorqueAbout(const ShotProgram::Loads& loads, int twist) const {
    V torque = Of(0.0);
    for (const ShotProgram::Wrench& wrench : loads.wrenches) {
      if (wrench.level < p_.twists[twist].level) continue;
      const Applied applied = Apply(wrench);
      const V3 about_base = Cross(applied.point, applied.force) + applied.moment;
      torque = hn::Add(torque, Work(chain_.Twist(twist), about_base, applied.force));
    }
    return torque;
  }

  // What the last Newton step would still move.
  TwistLanes LeftOver(int frame) const {
    TwistLanes total = ZeroTwist();
    for (int s = 0; s < slots_; ++s) {
      if (p_.slots[s].transform < frame) total = Fma(step_[s], moves_[s], total);
    }
    return total;
  }

  // Derivatives of the law by the base rotation; after Settle, where they are asked for. Wrenches given in the base
  // frame turn with the arm.
  void TurnBase() {
    for (int s = 0; s < slots_; ++s) turned_[s] = p_.has_base_loads ? Zero3() : before_[s];
    if (!p_.has_base_loads) return;
    SumLoads(own_, /*with_those_in_base=*/false);
    for (int s = 0; s < slots_; ++s) turned_[s] = Fma(flexibility_[s], Before(own_, s), turned_[s]);
    ForEachSag(/*with_those_in_base=*/false, [&](int s) HWY_ATTR { turned_[s] = turned_[s] + Before(own_, s); });
  }

 private:
  struct Applied {
    V3 point, force, moment;
  };
  // Of all wrenches beyond a frame.
  struct Sums {
    V3 force, about_base;
    M3 q;  // sum of F x'
    V trace;
  };

  template <typename Torque>
  V LargestOf(const Torque& torque_on) {
    for (int s = 0; s < slots_; ++s) law_[s] = hn::Mul(flexibility_[s], torque_on(s));
    Respond(law_);
    V largest = Of(0.0);
    for (int s = 0; s < slots_; ++s) largest = hn::Max(largest, hn::Abs(law_[s]));
    return largest;
  }

  HWY_INLINE Applied Apply(const ShotProgram::Wrench& wrench) const {
    Applied applied = {chain_.KeptFrame(wrench.kept_frame) * At3(data_, wrench.data, 0), At3(data_, wrench.data + 3, 0),
                       At3(data_, wrench.data + 6, 0)};
    if (!wrench.in_base) return applied;
    applied.force = chain_.base() * applied.force;
    applied.moment = chain_.base() * applied.moment;
    return applied;
  }
  void FindTorques(const ShotProgram::Loads& loads) {
    for (int s = 0; s < slots_; ++s) own_torque_[s] = Of(0.0);
    for (const ShotProgram::Wrench& wrench : loads.wrenches) {
      const Applied applied = Apply(wrench);
      const V3 about_base = Cross(applied.point, applied.force) + applied.moment;
      for (int s = 0; s < slots_; ++s) {
        if (wrench.level < p_.slots[s].level) continue;
        own_torque_[s] = hn::Add(own_torque_[s], Work(moves_[s], about_base, applied.force));
      }
    }
  }

  // By the frame that bears them, then from the flange to the base.
  void SumLoads(Sums* sums, bool with_those_in_base) const {
    Clear(sums);
    for (const ShotProgram::Loads& loads : p_.loads) {
      if (loads.parameter >= 0 && at_.theta[loads.parameter] == 0.0) continue;
      Sum(loads, loads.parameter < 0 ? 1.0 : at_.theta[loads.parameter], with_those_in_base, sums);
    }
    Accumulate(sums);
  }
  // The weights that make a slot sag, times their parameters, all in one sum, which `see` finds in own_: the law is
  // linear in them. Those of one slot follow each other.
  template <typename See>
  void ForEachSag(bool with_those_in_base, const See& see) {
    const std::vector<ShotProgram::Loads>& sags = p_.sags;
    for (size_t first = 0, last = 0; first < sags.size(); first = last) {
      bool any = false;
      for (; last < sags.size() && sags[last].slot == sags[first].slot; ++last) {
        const double theta = at_.theta[sags[last].parameter];
        if (theta == 0.0) continue;
        if (!any) Clear(own_);
        any = true;
        Sum(sags[last], theta, with_those_in_base, own_);
      }
      if (!any) continue;
      Accumulate(own_);
      see(sags[first].slot);
    }
  }
  void Clear(Sums* sums) const {
    for (int k = 0; k <= p_.num_levels; ++k) sums[k] = {Zero3(), Zero3(), Zero33(), Of(0.0)};
  }
  void Sum(const ShotProgram::Loads& loads, double times, bool with_those_in_base, Sums* sums) const {
    for (const ShotProgram::Wrench& wrench : loads.wrenches) {
      if (with_those_in_base || !wrench.in_base) Add(Apply(wrench), Of(times), &sums[wrench.level]);
    }
  }
  static HWY_INLINE void Add(const Applied& applied, V times, Sums* sums) {
    const V3 force = Times(times, applied.force);
    sums->force = sums->force + force;
    sums->about_base = sums->about_base + Fma(times, applied.moment, Cross(applied.point, force));
    sums->q.column[0] = Fma(applied.point.x, force, sums->q.column[0]);
    sums->q.column[1] = Fma(applied.point.y, force, sums->q.column[1]);
    sums->q.column[2] = Fma(applied.point.z, force, sums->q.column[2]);
  }
  void Accumulate(Sums* sums) const {
    for (int k = p_.num_levels - 1; k >= 0; --k) {
      if (k + 1 < p_.num_levels) Add(sums[k + 1], &sums[k]);
      sums[k].trace = Trace(sums[k].q);
    }
  }
  static void Add(const Sums& other, Sums* sums) {
    sums->force = sums->force + other.force;
    sums->about_base = sums->about_base + other.about_base;
    for (int c = 0; c < 3; ++c) sums->q.column[c] = sums->q.column[c] + other.q.column[c];
  }

  // Where nothing pulls but the spring, which acts on its own joint, the law does not depend on the rest of the arm.
  bool NeedsChain() const { return slots_ > 0 && p_.num_levels > 0; }

  void FindStep() {
    for (int s = 0; s < slots_; ++s) step_[s] = hn::Sub(law_[s], deflection_[s]);
    Respond(step_);
    V largest = Of(0.0), bent = Of(0.0);
    for (int s = 0; s < slots_; ++s) {
      largest = hn::Add(largest, hn::Abs(step_[s]));
      bent = hn::Add(bent, hn::Abs(hn::Add(deflection_[s], step_[s])));
    }
    largest_ = largest, bent_ = bent;
  }
  template <typename Mask>
  void Deflect(Mask lanes) {
    for (int s = 0; s < slots_; ++s) deflection_[s] = hn::Add(deflection_[s], hn::IfThenElseZero(lanes, step_[s]));
  }

  // f at the current deflections, and F.
  void EvaluateLaw(bool with_derivatives) {
    if (NeedsChain()) {
      chain_.Evaluate(data_, deflection_);
    } else {
      chain_.TurnSpring(data_, deflection_);
    }
    for (int s = 0; s < slots_; ++s) {
      law_[s] = flexibility_[s] = torque_[s] = Of(0.0);
      before_[s] = Zero3();
    }
    if (NeedsChain()) {
      SumLoads(sums_, /*with_those_in_base=*/true);
      for (int s = 0; s < slots_; ++s) {
        const TwistLanes& placed = chain_.Twist(p_.slots[s].twist);
        origins_[s] = placed.v;
        moves_[s] = IsTurned(s) ? TwistLanes{placed.w, Cross(placed.v, placed.w)} : placed;
        torque_[s] = TorqueBy(sums_, s);
      }
    }
    if (p_.has_spring) EvaluateSpring();
    for (const ShotProgram::Elastic& term : p_.elastic) {
      if (term.slot < 0 || at_.theta[term.parameter] == 0.0) continue;
      const V gain = hn::Mul(Of(at_.theta[term.parameter]), Datum(term.data)), phi = Phi(term);
      law_[term.slot] = Fma(gain, phi, law_[term.slot]);
      flexibility_[term.slot] = Fma(gain, LawDerivativeAt(term, torque_[term.slot], phi), flexibility_[term.slot]);
    }
    if (!NeedsChain()) return;
    for (int s = 0; s < slots_ && with_derivatives; ++s) {
      for (int k = 0; k < p_.num_levels; ++k) Beyond(s)[k] = ZeroTwist();
      AddAnswer(sums_, s, flexibility_[s]);
    }
    AddSags(with_derivatives);
  }
  bool IsTurned(int s) const { return p_.twists[p_.slots[s].twist].is_rotation; }
  TwistLanes* Beyond(int s) const { return beyond_ + s * p_.num_levels; }
  V TorqueBy(const Sums* sums, int s) const {
    const Sums& acting = sums[p_.slots[s].level];
    return Work(moves_[s], acting.about_base, acting.force);
  }

  // The derivative of the torque on slot s by every transform, times `factor`.
  void AddAnswer(const Sums* sums, int s, V factor) {
    before_[s] = Fma(factor, Before(sums, s), before_[s]);
    if (!IsTurned(s)) return;
    const V3 z = Times(factor, moves_[s].w);
    for (int k = p_.slots[s].level; k < p_.num_levels; ++k) {
      TwistLanes& beyond = Beyond(s)[k];
      beyond.w = beyond.w + Turned(sums[k], z);
      beyond.v = beyond.v + Cross(sums[k].force, z);
    }
  }
  V3 Before(const Sums* sums, int s) const {
    const Sums& acting = sums[p_.slots[s].level];
    if (!IsTurned(s)) return Cross(moves_[s].v, acting.force);
    const V3 z = moves_[s].w, o = origins_[s];
    const V3 about = acting.about_base - Cross(o, acting.force);
    const V3 shift = Fnma(Dot(o, acting.force), z, Times(Dot(z, o), acting.force));
    return Cross(z, about) + Turned(acting, z) - shift;
  }
  // Q z - tr(Q) z
  static HWY_INLINE V3 Turned(const Sums& sums, V3 z) { return Fnma(sums.trace, z, sums.q * z); }

  void AddSags(bool with_derivatives) {
    ForEachSag(/*with_those_in_base=*/true, [&](int s) HWY_ATTR {
      law_[s] = hn::Add(law_[s], TorqueBy(own_, s));
      if (with_derivatives) AddAnswer(own_, s, Of(1.0));
    });
  }

  // Adds how the slots answer the value of a transform: those before it to wrenches beyond, those after it to where it
  // turns them.
  template <bool kIsRotation>
  HWY_INLINE TwistLanes WithAnswers(const ShotProgram::Twist& own, const TwistLanes& twist, TwistLanes total) const {
    const TwistLanes moves = Held(twist);
    const int before = own.level < p_.num_levels ? own.slots : 0;
    const TwistLanes* beyond = beyond_ + own.level;
    for (int s = 0; s < before; ++s, beyond += p_.num_levels) {
      const V by = kIsRotation ? Work(moves, beyond->w, beyond->v) : Dot(moves.v, beyond->v);
      total = Fma(by, imposed_[s], total);
    }
    for (int s = own.slots; s < slots_ && kIsRotation; ++s) total = Fma(Dot(before_[s], moves.w), imposed_[s], total);
    return total;
  }
  // d f_s / d value of a transform that is slot s or beyond it.
  HWY_INLINE V ByWhatIsBeyond(int s, const ShotProgram::Twist& own, const TwistLanes& moves) const {
    const TwistLanes& beyond = Beyond(s)[own.level];
    return own.is_rotation ? Work(moves, beyond.w, beyond.v) : Dot(moves.v, beyond.v);
  }
  bool BearsSpring(const ShotProgram::Twist& twist) const {
    return p_.has_spring && p_.spring.transform == twist.transform;
  }
  V SpringLaw() const { return hn::Mul(flexibility_[p_.spring.slot], spring_stiffness_); }

  // L U = I - F_u, the diagonal of U as inverse; F_u is small where the arm does not fold, so that no pivots are
  // sought.
  void FactorResponse() {
    const int n = slots_;
    for (int c = 0; c < n; ++c) {
      const ShotProgram::Twist& own = p_.twists[p_.slots[c].twist];
      for (int r = 0; r < n; ++r) {
        V by = Of(0.0);
        if (r > c && own.is_rotation && p_.num_levels > 0) by = Dot(before_[r], moves_[c].w);
        if (r <= c && own.level < p_.num_levels) by = ByWhatIsBeyond(r, own, moves_[c]);
        if (r == c && BearsSpring(own)) by = hn::Add(by, SpringLaw());
        matrix_[r * n + c] = hn::Sub(Of(r == c ? 1.0 : 0.0), by);
      }
    }
    for (int k = 0; k < n; ++k) {
      const V inverse = hn::Div(Of(1.0), matrix_[k * n + k]);
      matrix_[k * n + k] = inverse;
      for (int r = k + 1; r < n; ++r) {
        const V factor = hn::Mul(matrix_[r * n + k], inverse);
        matrix_[r * n + k] = factor;
        for (int c = k + 1; c < n; ++c) matrix_[r * n + c] = Fnma(factor, matrix_[k * n + c], matrix_[r * n + c]);
      }
    }
  }
  // x <- (I - F_u)^-1 x
  void Respond(V* x) const {
    const int n = slots_;
    for (int r = 1; r < n; ++r) {
      V rest = x[r];
      for (int k = 0; k < r; ++k) rest = Fnma(matrix_[r * n + k], x[k], rest);
      x[r] = rest;
    }
    for (int r = n - 1; r >= 0; --r) {
      V rest = x[r];
      for (int k = n - 1; k > r; --k) rest = Fnma(matrix_[r * n + k], x[k], rest);
      x[r] = hn::Mul(rest, matrix_[r * n + r]);
    }
  }

  const double* SpringParameters() const { return at_.theta + p_.spring.first_parameter; }
  void EvaluateSpring() {
    const V sign = Of(p_.spring.sign), cos_offset = Of(p_.spring.cos_offset), sin_offset = Of(p_.spring.sin_offset);
    // q = sign (v - offset)
    const V sine = hn::Mul(sign, Fnma(chain_.spring_cosine(), sin_offset, hn::Mul(chain_.spring_sine(), cos_offset)));
    const V cosine = Fma(chain_.spring_cosine(), cos_offset, hn::Mul(chain_.spring_sine(), sin_offset));
    SpringTorque spring = SpringAt(SpringParameters(), sine, cosine);
    spring_stiffness_ = spring.by_angle;  // sign^2 = 1
    if (p_.spring.commanded >= 0) {
      spring.torque = hn::Sub(spring.torque, idle_.torque);
      for (int i = 0; i < 5; ++i) spring.by[i] = hn::Sub(spring.by[i], idle_.by[i]);
    }
    torque_[p_.spring.slot] = Fma(sign, spring.torque, torque_[p_.spring.slot]);
    for (int i = 0; i < 5; ++i) by_spring_[i] = hn::Mul(sign, spring.by[i]);
  }

  const ShotProgram& p_;
  const BatchPoint& at_;
  const int slots_;
  LaneChain chain_;
  const double* data_ = nullptr;

  Sums *sums_, *own_;
  TwistLanes* moves_;   // twists of the slots
  V3* origins_;         // of the slots' transforms
  TwistLanes* beyond_;  // slots x levels: d law / d value of transforms from the slot on
  V3* before_;          // of transforms before the slot
  V3* turned_;          // of the base
  V *torque_, *own_torque_, *flexibility_, *deflection_, *step_, *law_;
  V* matrix_;
  V largest_, bent_;  // sums over the slots: of the step, of the deflection with it
  TwistLanes* imposed_;
  SpringTorque idle_;  // of the spring at the commanded angle, where only the change acts
  V spring_stiffness_, by_spring_[5];
};

}  // namespace HWY_NAMESPACE
}  // namespace sagitta
HWY_AFTER_NAMESPACE();

#endif

// One register's worth of shots: chain, equilibrium, columns. Compiled once per instruction set; see batch_rows.h.
#if defined(SAGITTA_MODELS_BATCH_LANE_SHOTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SAGITTA_MODELS_BATCH_LANE_SHOTS_INL_H_
#undef SAGITTA_MODELS_BATCH_LANE_SHOTS_INL_H_
#else
#define SAGITTA_MODELS_BATCH_LANE_SHOTS_INL_H_
#endif

#include "models/batch/batch_rows.h"
#include "models/batch/lane_statics-inl.h"
#include "models/batch/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sagitta {
namespace HWY_NAMESPACE {

class LaneShots {
 public:
  LaneShots(const ShotProgram& program, const BatchPoint& at, const BatchLayout& layout, BatchScratch* scratch)
      : p_(program), at_(at), layout_(layout), statics_(program, at, scratch) {
    const int classes = static_cast<int>(p_.classes.size());
    columns_of_class_ = static_cast<int>(p_.twists.size()) + p_.num_parameters + 3;
    columns_ = statics_.Rest<TwistLanes>(static_cast<std::size_t>(classes) * columns_of_class_);
  }

  static std::size_t MemoryFor(const ShotProgram& program) {
    const std::size_t columns = program.twists.size() + program.num_parameters + 3;
    return LaneStatics::MemoryFor(program) + program.classes.size() * columns * sizeof(TwistLanes);
  }

  // Lanes from `lane` on; a bit for each that did not settle.
  unsigned Evaluate(const double* data, int lane, double* rows) {
    const unsigned unsettled = statics_.Settle(data, lane);
    TurnColumns();
    for (size_t m = 0; m < p_.markers.size(); ++m) WriteMarker(static_cast<int>(m), data, lane, rows);
    return unsettled;
  }

 private:
  // Columns of one frame that bears markers, in this order: total twists of the transforms, the parameters', those of
  // the base rotation.
  TwistLanes* Totals(int frame_class) { return columns_ + frame_class * columns_of_class_; }
  TwistLanes* Parameters(int frame_class) { return Totals(frame_class) + p_.twists.size(); }
  TwistLanes* Rotations(int frame_class) { return Parameters(frame_class) + p_.num_parameters; }

  bool IsAskedFor(int transform) const {
    const ShotProgram::Transform& own = p_.transforms[transform];
    bool asked = own.geometry >= 0 && layout_.theta[own.geometry] >= 0;
    for (const ShotProgram::Scaled& term : own.terms) asked = asked || layout_.theta[term.parameter] >= 0;
    for (const int j : layout_.latent_joints) asked = asked || p_.twists[p_.joint_twists[j]].transform == transform;
    return asked;
  }

  void TurnColumns() {
    if (layout_.station >= 0) statics_.TurnBase();
    for (size_t c = 0; c < p_.classes.size(); ++c) {
      const int frame = p_.classes[c].frame;
      const int own = static_cast<int>(c);
      statics_.RespondOn(frame);
      for (size_t k = 0; k < p_.twists.size(); ++k) {
        if (IsAskedFor(p_.twists[k].transform)) Totals(own)[k] = statics_.Total(static_cast<int>(k), frame);
      }
      for (int i = 0; i < p_.num_parameters; ++i) {
        if (layout_.theta[i] >= 0) Parameters(own)[i] = ZeroTwist();
      }
      AddDisplacements(own);
      if (p_.is_elastic()) AddLoads(own);
      if (layout_.station < 0) continue;
      for (int axis = 0; axis < 3; ++axis) Rotations(own)[axis] = statics_.ByRotation(axis);
    }
  }

  void AddDisplacements(int c) {
    for (const ShotProgram::Transform& transform : p_.transforms) {
      if (transform.twist < 0) continue;
      const TwistLanes& total = Totals(c)[transform.twist];
      const auto add = [&](int parameter, V factor) HWY_ATTR {
        if (layout_.theta[parameter] < 0) return;
        Parameters(c)[parameter] = Fma(factor, total, Parameters(c)[parameter]);
      };
      if (transform.geometry >= 0) add(transform.geometry, Of(1.0));
      for (const ShotProgram::Scaled& term : transform.terms) add(term.parameter, statics_.Datum(term.data));
    }
  }

  void AddLoads(int c) {
    const auto is_asked = [&](int parameter) { return parameter >= 0 && layout_.theta[parameter] >= 0; };
    for (const ShotProgram::Elastic& term : p_.elastic) {
      if (term.slot < 0 || !is_asked(term.parameter)) continue;
      TwistLanes& column = Parameters(c)[term.parameter];
      column = Fma(hn::Mul(statics_.Datum(term.data), statics_.Phi(term.law, term.slot)), statics_.Imposed(term.slot),
                   column);
    }
    for (size_t i = 0; i < p_.loads.size(); ++i) {
      const int parameter = p_.loads[i].parameter;
      if (is_asked(parameter)) statics_.AddTorques(p_.loads[i], &Parameters(c)[parameter]);
    }
    for (const ShotProgram::Loads& sag : p_.sags) {
      if (!is_asked(sag.parameter)) continue;
      TwistLanes& column = Parameters(c)[sag.parameter];
      column = Fma(statics_.TorqueOf(sag, sag.slot), statics_.Imposed(sag.slot), column);
    }
    for (int i = 0; i < 5 && p_.has_spring; ++i) {
      const int parameter = p_.spring.first_parameter + i;
      if (is_asked(parameter)) statics_.AddSpring(i, &Parameters(c)[parameter]);
    }
  }

  // The instrument's side of one marker.
  struct Seen {
    M3 from_base;                        // whitened: W B
    M3 from_station;                     // whitened: W d seen / d true
    V3 row_by_turn[3], row_by_shift[3];  // rows of P
  };

  void WriteMarker(int m, const double* data, int lane, double* rows) {
    const ShotProgram::Marker& marker = p_.markers[m];
    const Vector3<double>& given = at_.marker_points[m];
    V3 own = {Of(given.x()), Of(given.y()), Of(given.z())};
    for (const ShotProgram::MarkerDirection& term : marker.terms) {
      own = Fma(Of(at_.theta[term.parameter]), At3(data, term.data, lane), own);
    }
    const Frame& frame = statics_.KeptFrame(marker.kept_frame);
    const V3 in_base = frame * own;
    V scale = Of(1.0);
    for (const ShotProgram::Scaled& term : p_.growth) {
      if (marker.grows) scale = Fma(Of(at_.theta[term.parameter]), statics_.Datum(term.data), scale);
    }
    const M3 base = Same(at_.base_in_station.rotation);
    const Vector3<double>& t = at_.base_in_station.translation;
    const V3 truth = Fma(scale, base * in_base, V3{Of(t.x()), Of(t.y()), Of(t.z())});
    V3 seen = truth;
    M3 from_true = Same(Eigen::Matrix3d::Identity());
    for (const ShotProgram::Station& term : p_.station) {
      const V theta = Of(at_.theta[term.parameter]);
      const M3 gradient = AtMatrix(data, term.data, lane);
      seen = Fma(theta, gradient * truth + At3(data, term.data + 9, lane), seen);
      for (int c = 0; c < 3; ++c) from_true.column[c] = Fma(theta, gradient.column[c], from_true.column[c]);
    }
    const M3 whitener = AtMatrix(data, marker.data, lane);
    Seen s;
    s.from_station = p_.station.empty() ? whitener : whitener * from_true;
    s.from_base = s.from_station * base;
    for (V3& column : s.from_base.column) column = Times(scale, column);
    for (int i = 0; i < 3; ++i) {
      const auto entry = [&](const V3& column) HWY_ATTR { return i == 0 ? column.x : i == 1 ? column.y : column.z; };
      s.row_by_shift[i] = {entry(s.from_base.column[0]), entry(s.from_base.column[1]), entry(s.from_base.column[2])};
      s.row_by_turn[i] = Cross(in_base, s.row_by_shift[i]);
    }
    double* own_rows =
        rows + static_cast<std::size_t>(layout_.first_row + 3 * m) * layout_.columns * kBatchLanes + lane;
    const V3 misfit = whitener * (seen - At3(data, marker.data + 9, lane));
    WriteResidual(s, misfit, statics_.LeftOver(p_.classes[marker.frame_class].frame), own_rows);
    WriteColumns(s, marker.frame_class, own_rows);
    if (layout_.markers[m] >= 0) Write(s.from_base * frame.rotation, layout_.markers[m], own_rows);
    WriteDirect(marker, s, whitener, frame, in_base, scale, truth, data, lane, own_rows);
  }

  double* Cell(double* rows, int row, int column) const {
    return rows + (static_cast<std::size_t>(row) * layout_.columns + column) * kBatchLanes;
  }
  void Write(const M3& block, int first_column, double* rows) {
    for (int c = 0; c < 3; ++c) {
      Put(block.column[c].x, Cell(rows, 0, first_column + c));
      Put(block.column[c].y, Cell(rows, 1, first_column + c));
      Put(block.column[c].z, Cell(rows, 2, first_column + c));
    }
  }
  HWY_INLINE V Move(const Seen& seen, int i, const TwistLanes& twist) {
    return Work(twist, seen.row_by_turn[i], seen.row_by_shift[i]);
  }
  HWY_INLINE void WriteTwist(const Seen& seen, const TwistLanes& twist, int column, double* rows) {
    for (int i = 0; i < 3; ++i) Put(Move(seen, i, twist), Cell(rows, i, column));
  }

  void WriteResidual(const Seen& seen, V3 misfit, const TwistLanes& left_over, double* rows) {
    Put(hn::Add(misfit.x, Move(seen, 0, left_over)), Cell(rows, 0, layout_.residual));
    Put(hn::Add(misfit.y, Move(seen, 1, left_over)), Cell(rows, 1, layout_.residual));
    Put(hn::Add(misfit.z, Move(seen, 2, left_over)), Cell(rows, 2, layout_.residual));
  }

  void WriteColumns(const Seen& seen, int c, double* rows) {
    if (layout_.station >= 0) {
      Write(seen.from_station, layout_.station, rows);
      for (int axis = 0; axis < 3; ++axis) WriteTwist(seen, Rotations(c)[axis], layout_.station + 3 + axis, rows);
    }
    for (int i = 0; i < p_.num_parameters; ++i) {
      if (layout_.theta[i] >= 0) WriteTwist(seen, Parameters(c)[i], layout_.theta[i], rows);
    }
    for (size_t k = 0; k < layout_.latent_joints.size(); ++k) {
      const int j = layout_.latent_joints[k];
      const V factor = Of(layout_.latent_sigmas[k] * p_.joint_signs[j]);
      WriteTwist(seen, Fma(factor, Totals(c)[p_.joint_twists[j]], ZeroTwist()), layout_.latent + static_cast<int>(k),
                 rows);
    }
  }

  // What parameters do at the marker, to the arm's size and in the instrument.
  void WriteDirect(const ShotProgram::Marker& marker, const Seen& seen, const M3& whitener, const Frame& frame,
                   V3 in_base, V scale, V3 truth, const double* data, int lane, double* rows) {
    const auto add = [&](int parameter, V3 column) HWY_ATTR {
      double* cell = Cell(rows, 0, layout_.theta[parameter]);
      const std::size_t next = static_cast<std::size_t>(layout_.columns) * kBatchLanes;
      Put(hn::Add(At(cell), column.x), cell);
      Put(hn::Add(At(cell + next), column.y), cell + next);
      Put(hn::Add(At(cell + 2 * next), column.z), cell + 2 * next);
    };
    for (const ShotProgram::MarkerDirection& term : marker.terms) {
      if (layout_.theta[term.parameter] < 0) continue;
      add(term.parameter, seen.from_base * (frame.rotation * At3(data, term.data, lane)));
    }
    for (const ShotProgram::Scaled& term : p_.growth) {
      if (!marker.grows || layout_.theta[term.parameter] < 0) continue;
      add(term.parameter, Times(hn::Div(statics_.Datum(term.data), scale), seen.from_base * in_base));
    }
    for (const ShotProgram::Station& term : p_.station) {
      if (layout_.theta[term.parameter] < 0) continue;
      add(term.parameter, whitener * (AtMatrix(data, term.data, lane) * truth + At3(data, term.data + 9, lane)));
    }
  }

  const ShotProgram& p_;
  const BatchPoint& at_;
  const BatchLayout& layout_;
  LaneStatics statics_;
  int columns_of_class_ = 0;
  TwistLanes* columns_ = nullptr;
};

const char* TargetOfLanes() { return hwy::TargetName(HWY_TARGET); }

unsigned EvaluateLanes(const ShotProgram& program, const BatchPoint& at, const BatchLayout& layout, const double* data,
                       BatchScratch* scratch, double* rows) {
  scratch->Reserve(LaneShots::MemoryFor(program) / sizeof(double) + 64);
  LaneShots shots(program, at, layout, scratch);
  const int stride = static_cast<int>(hn::Lanes(Tag()));
  unsigned unsettled = 0;
  for (int lane = 0; lane < kBatchLanes; lane += stride) unsettled |= shots.Evaluate(data, lane, rows) << lane;
  return unsettled;
}

}  // namespace HWY_NAMESPACE
}  // namespace sagitta
HWY_AFTER_NAMESPACE();

#endif

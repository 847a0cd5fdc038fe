// One register's worth of shots: chain, equilibrium, columns. Compiled once per instruction set; see batch_rows.h.
#if defined(SAGITTA_MODELS_BATCH_LANE_SHOTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SAGITTA_MODELS_BATCH_LANE_SHOTS_INL_H_
#undef SAGITTA_MODELS_BATCH_LANE_SHOTS_INL_H_
#else
#define SAGITTA_MODELS_BATCH_LANE_SHOTS_INL_H_
#endif

#include "models/batch/batch_rows.h"
#include "models/batch/lane_sights-inl.h"
#include "models/batch/lane_statics-inl.h"
#include "models/batch/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sagitta {
namespace HWY_NAMESPACE {

class LaneShots {
 public:
  LaneShots(const ShotProgram& program, const BatchPoint& at, const BatchPlan& plan, LaneMemory* memory)
      : p_(program),
        at_(at),
        plan_(plan),
        layout_(plan.layout),
        next_row_(layout_.columns * kBatchLanes),
        statics_(program, at, memory) {
    totals_ = memory->Take<TwistLanes>(p_.twists.size());
    sums_ = memory->Take<TwistLanes>(plan.num_columns());
    seen_ = memory->Take<Seen>(p_.markers.size());
    equal_ = memory->Take<EqualMarker>(p_.markers.size());
    others_ = memory->Take<Marker>(p_.markers.size());
    columns_ = memory->Take<Column>(plan.num_columns());
  }

  static std::size_t MemoryFor(const ShotProgram& program, const BatchPlan& plan) {
    return LaneStatics::MemoryFor(program) + program.twists.size() * sizeof(TwistLanes) +
           program.markers.size() * (sizeof(Seen) + sizeof(EqualMarker) + sizeof(Marker)) +
           plan.num_columns() * (sizeof(TwistLanes) + sizeof(Column));
  }

  // Lanes from `lane` on; a bit for each that did not settle.
  unsigned Evaluate(const double* data, int lane, double* rows) {
    const unsigned unsettled = statics_.Settle(data, lane);
    if (layout_.station >= 0) statics_.TurnBase();
    rows_ = rows + lane;
    data_ = data + lane;
    for (const ShotProgram::FrameClass& frame : p_.classes) {
      num_equal_ = num_others_ = 0;
      for (const int m : frame.markers) See(m);
      WriteColumns(frame.frame);
      for (const int m : frame.markers) AddDirect(m);
    }
    return unsettled;
  }

 private:
  // Whitened rows of a marker by what its frame does: P = W [-[p]x | I].
  struct Rows {
    V3 by_turn[3], by_shift[3];
    HWY_INLINE V3 Of(const TwistLanes& twist) const {
      return {Work(twist, by_turn[0], by_shift[0]), Work(twist, by_turn[1], by_shift[1]),
              Work(twist, by_turn[2], by_shift[2])};
    }
  };
  // The same where the noise is the same in all directions, W = s I.
  struct EqualRows {
    V scale;
    V3 point;  // scaled
    HWY_INLINE V3 Of(const TwistLanes& twist) const { return Times(scale, twist.v) + Cross(twist.w, point); }
  };
  struct EqualMarker {
    EqualRows rows;
    V3 misfit;
    double* cells;  // of its first row
  };
  struct Marker {
    Rows rows;
    V3 misfit;
    double* cells;
  };
  // What parameters move directly.
  struct Seen {
    V3 from_base, truth;
    V scale;      // the arm's growth
    M3 from_arm;  // whitened d seen / d true, scaled
  };
  double* CellsOf(int marker) const {
    return rows_ + static_cast<std::size_t>(layout_.first_row + 3 * marker) * layout_.columns * kBatchLanes;
  }

  M3 WhitenerOf(const ShotProgram::Marker& marker) const {
    if (!marker.sees_equally) return AtMatrix(data_, marker.whitener, 0);
    const V w = statics_.Datum(marker.whitener), zero = Of(0.0);
    return {{{w, zero, zero}, {zero, w, zero}, {zero, zero, w}}};
  }

  // The instrument's side of one marker.
  void See(int m) {
    const ShotProgram::Marker& marker = p_.markers[m];
    Seen& seen = seen_[m];
    double* const cells = CellsOf(m);
    const Vector3<double>& given = at_.marker_points[m];
    V3 own = {Of(given.x()), Of(given.y()), Of(given.z())};
    for (const ShotProgram::MarkerDirection& term : marker.terms) {
      own = Fma(Of(at_.theta[term.parameter]), At3(data_, term.data, 0), own);
    }
    const Frame& frame = statics_.chain().KeptFrame(marker.kept_frame);
    const V3 from_base = frame * own;
    V scale = Of(1.0);
    for (const ShotProgram::Scaled& term : p_.growth) {
      if (marker.grows) scale = Fma(Of(at_.theta[term.parameter]), statics_.Datum(term.data), scale);
    }
    const Vector3<double>& t = at_.base_in_station.translation;
    const V3 truth = Fma(scale, from_base, V3{Of(t.x()), Of(t.y()), Of(t.z())});
    const V3 measured = At3(data_, marker.point, 0);
    if (marker.sees_equally && !p_.MovesDirectly(marker)) {
      const V w = statics_.Datum(marker.whitener);
      equal_[num_equal_++] = {{w, Times(w, from_base)}, Times(w, truth - measured), cells};
      if (layout_.station >= 0) Write(WhitenerOf(marker), layout_.station, cells);
      for (int c = 0; c < 3 && layout_.markers[m] >= 0; ++c) {
        Write(Times(w, frame.rotation.column[c]), layout_.markers[m] + c, cells);
      }
      return;
    }
    V3 point = truth;
    M3 from_true = Same(Eigen::Matrix3d::Identity());
    for (const ShotProgram::Station& term : p_.station) {
      const V theta = Of(at_.theta[term.parameter]);
      const M3 gradient = AtMatrix(data_, term.data, 0);
      point = Fma(theta, gradient * truth + At3(data_, term.data + 9, 0), point);
      for (int c = 0; c < 3; ++c) from_true.column[c] = Fma(theta, gradient.column[c], from_true.column[c]);
    }
    M3 by_turn = Zero33();  // of the marker's frame, by its axis
    for (const ShotProgram::Sight& sight : marker.sights) {
      if (at_.theta[sight.term.parameter] == 0.0) continue;
      const V theta = Of(at_.theta[sight.term.parameter]);
      const V3 axis = SightAxis(sight, data_, frame.rotation);
      const SightGradientLanes sees = GradientOfSight(sight, data_, truth, axis);
      const M3 own_turn = ByTurnOfAxis(sees.by_axis, axis);
      point = Fma(theta, sees.displacement, point);
      for (int c = 0; c < 3; ++c) {
        from_true.column[c] = Fma(theta, sees.by_point.column[c], from_true.column[c]);
        by_turn.column[c] = Fnma(theta, own_turn.column[c], by_turn.column[c]);
      }
    }
    const M3 whitener = WhitenerOf(marker), turned = whitener * by_turn;
    const M3 from_station = p_.station.empty() && marker.sights.empty() ? whitener : whitener * from_true;
    seen = {from_base, truth, scale, from_station};
    for (V3& column : seen.from_arm.column) column = Times(scale, column);
    Marker& other = others_[num_others_++];
    other.misfit = whitener * (point - measured);
    other.cells = cells;
    const M3& w = seen.from_arm;
    for (int i = 0; i < 3; ++i) {
      const auto entry = [&](const V3& column) HWY_ATTR { return i == 0 ? column.x : i == 1 ? column.y : column.z; };
      other.rows.by_shift[i] = {entry(w.column[0]), entry(w.column[1]), entry(w.column[2])};
      other.rows.by_turn[i] = Cross(from_base, other.rows.by_shift[i]) +
                              V3{entry(turned.column[0]), entry(turned.column[1]), entry(turned.column[2])};
    }
    if (layout_.station >= 0) Write(from_station, layout_.station, cells);
    if (layout_.markers[m] >= 0) Write(w * frame.rotation, layout_.markers[m], cells);
  }

  HWY_INLINE void Write(V3 numbers, int column, double* cells) const {
    double* const cell = cells + column * kBatchLanes;
    const int next = next_row_;
    Put(numbers.x, cell);
    Put(numbers.y, cell + next);
    Put(numbers.z, cell + 2 * next);
  }
  void Write(const M3& block, int first_column, double* cells) const {
    for (int c = 0; c < 3; ++c) Write(block.column[c], first_column + c, cells);
  }
  // A column of all markers of the frame: what moves it.
  struct Column {
    const TwistLanes* twist;
    int column;
  };
  TwistLanes& AddColumn(int column) {
    TwistLanes& own = sums_[num_columns_];
    columns_[num_columns_++] = {&own, column};
    return own;
  }

  // The residual, and the columns of everything that moves the frame.
  HWY_NOINLINE void WriteColumns(int frame) {
    const TwistLanes left_over = statics_.LeftOver(frame);
    for (int i = 0; i < num_equal_; ++i) {
      Write(equal_[i].misfit + equal_[i].rows.Of(left_over), layout_.residual, equal_[i].cells);
    }
    for (int i = 0; i < num_others_; ++i) {
      Write(others_[i].misfit + others_[i].rows.Of(left_over), layout_.residual, others_[i].cells);
    }
    FindColumns(frame);
    int i = 0;
    for (; i + 3 <= num_equal_; i += 3) WriteColumnsOf<3>(equal_ + i);
    for (; i + 2 <= num_equal_; i += 2) WriteColumnsOf<2>(equal_ + i);
    for (; i < num_equal_; ++i) WriteColumnsOf<1>(equal_ + i);
    for (i = 0; i < num_others_; ++i) WriteColumnsOf<1>(others_ + i);
  }

  void FindColumns(int frame) {
    num_columns_ = 0;
    statics_.RespondOn(frame);
    for (int axis = 0; axis < 3 && layout_.station >= 0; ++axis) {
      AddColumn(layout_.station + 3 + axis) = statics_.ByRotation(axis);
    }
    for (const int k : plan_.twists) totals_[k] = statics_.Total(k, frame);
    for (const BatchPlan::ByTransform& by : plan_.by_transform) {
      columns_[num_columns_++] = {&totals_[by.twist], by.column};
    }
    for (const BatchPlan::Sum& sum : plan_.sums) {
      TwistLanes& column = AddColumn(sum.column) = ZeroTwist();
      for (int i = sum.first_part; i < sum.last_part; ++i) Add(p_.parts[i], &column);
    }
    for (size_t k = 0; k < layout_.latent_joints.size(); ++k) {
      const int j = layout_.latent_joints[k];
      const V factor = Of(layout_.latent_sigmas[k] * p_.joint_signs[j]);
      AddColumn(layout_.latent + static_cast<int>(k)) = Times(factor, totals_[p_.joint_twists[j]]);
    }
  }

  // Of some markers side by side, whose own numbers stay in registers meanwhile.
  template <int kMarkers, typename AnyMarker>
  HWY_NOINLINE void WriteColumnsOf(const AnyMarker* markers) const {
    decltype(markers->rows) rows[kMarkers];
    double* cells[kMarkers];
    for (int m = 0; m < kMarkers; ++m) rows[m] = markers[m].rows, cells[m] = markers[m].cells;
    const std::size_t next = next_row_;
    for (const Column *own = columns_, *const end = columns_ + num_columns_; own != end; ++own) {
      const TwistLanes twist = Held(*own->twist);
      const std::size_t at = static_cast<std::size_t>(own->column) * kBatchLanes;
      for (int m = 0; m < kMarkers; ++m) {
        const V3 numbers = rows[m].Of(twist);
        Put(numbers.x, cells[m] + at);
        Put(numbers.y, cells[m] + at + next);
        Put(numbers.z, cells[m] + at + 2 * next);
      }
    }
  }

  void Add(const ShotProgram::Part& part, TwistLanes* column) {
    switch (part.of) {
      case ShotProgram::PartOf::kTransform: {
        const V factor = part.data < 0 ? Of(1.0) : statics_.Datum(part.data);
        *column = Fma(factor, totals_[part.index], *column);
        break;
      }
      case ShotProgram::PartOf::kElastic: {
        const ShotProgram::Elastic& term = p_.elastic[part.index];
        const V by = hn::Mul(statics_.Datum(term.data), statics_.Phi(term));
        *column = Fma(by, statics_.Imposed(term.slot), *column);
        break;
      }
      case ShotProgram::PartOf::kLoads:
        statics_.AddTorques(p_.loads[part.index], column);
        break;
      case ShotProgram::PartOf::kSag: {
        const ShotProgram::Loads& sag = p_.sags[part.index];
        *column = Fma(statics_.TorqueOf(sag, sag.slot), statics_.Imposed(sag.slot), *column);
        break;
      }
      case ShotProgram::PartOf::kSpring:
        statics_.AddSpring(part.index, column);
        break;
    }
  }

  // What parameters do at the marker, to the arm's size and in the instrument.
  void AddDirect(int m) {
    const ShotProgram::Marker& marker = p_.markers[m];
    if (!p_.MovesDirectly(marker)) return;
    const Seen& seen = seen_[m];
    const auto add = [&](int parameter, V3 column) HWY_ATTR {
      double* const cells = CellsOf(m);
      const double* const cell = cells + layout_.theta[parameter] * kBatchLanes;
      Write(V3{At(cell), At(cell + next_row_), At(cell + 2 * next_row_)} + column, layout_.theta[parameter], cells);
    };
    for (const ShotProgram::MarkerDirection& term : marker.terms) {
      if (layout_.theta[term.parameter] < 0) continue;
      const Frame& frame = statics_.chain().KeptFrame(marker.kept_frame);
      add(term.parameter, seen.from_arm * (frame.rotation * At3(data_, term.data, 0)));
    }
    for (const ShotProgram::Scaled& term : p_.growth) {
      if (!marker.grows || layout_.theta[term.parameter] < 0) continue;
      add(term.parameter, Times(hn::Div(statics_.Datum(term.data), seen.scale), seen.from_arm * seen.from_base));
    }
    for (const ShotProgram::Station& term : p_.station) {
      if (layout_.theta[term.parameter] < 0) continue;
      add(term.parameter,
          WhitenerOf(marker) * (AtMatrix(data_, term.data, 0) * seen.truth + At3(data_, term.data + 9, 0)));
    }
    for (const ShotProgram::Sight& sight : marker.sights) {
      if (layout_.theta[sight.term.parameter] < 0) continue;
      const V3 axis = SightAxis(sight, data_, statics_.chain().KeptFrame(marker.kept_frame).rotation);
      add(sight.term.parameter, WhitenerOf(marker) * DisplacementBySight(sight, data_, seen.truth, axis));
    }
  }

  const ShotProgram& p_;
  const BatchPoint& at_;
  const BatchPlan& plan_;
  const BatchLayout& layout_;
  const int next_row_;
  LaneStatics statics_;
  const double* data_ = nullptr;
  double* rows_ = nullptr;
  // Of one frame that bears markers: twists by the values of transforms, and of columns that are no such twist.
  TwistLanes *totals_, *sums_;
  Column* columns_;
  Seen* seen_;          // of each marker
  EqualMarker* equal_;  // of one frame
  Marker* others_;
  int num_equal_ = 0, num_others_ = 0, num_columns_ = 0;
};

const char* TargetOfLanes() { return hwy::TargetName(HWY_TARGET); }

unsigned EvaluateLanes(const ShotProgram& program, const BatchPoint& at, const BatchPlan& plan, const double* data,
                       BatchScratch* scratch, double* rows) {
  LaneMemory memory(scratch->Reserve(LaneShots::MemoryFor(program, plan) / sizeof(double)));
  LaneShots shots(program, at, plan, &memory);
  const int stride = static_cast<int>(hn::Lanes(Tag()));
  unsigned unsettled = 0;
  for (int lane = 0; lane < kBatchLanes; lane += stride) unsettled |= shots.Evaluate(data, lane, rows) << lane;
  return unsettled;
}

}  // namespace HWY_NAMESPACE
}  // namespace sagitta
HWY_AFTER_NAMESPACE();

#endif

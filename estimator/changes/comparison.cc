#include "estimator/changes/comparison.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "estimator/changes/comparison_columns.h"
#include "estimator/changes/sparse_search.h"
#include "estimator/report/changes_words.h"
#include "models/dense_algebra.h"
#include "problems/input_error.h"

namespace sagitta {
namespace {

// Standard deviations by which the largest change within the design's sizes (the widest of kChangeScales) has to differ
// from what other explanations can do: less is not seen.
constexpr double kStandsOut = 1.0;

// Whether the largest design change along one of `columns` is seen although `others` of that size, in typical sizes,
// may have changed: with errors e ~ N(0, I) and others P a, a ~ N(0, size^2 I), it stands out by c'(I + size^2 P P')^-1
// c squared standard deviations. (By their span alone nearly parallel axes hide anything: metres of one against metres
// of the other.)
bool IsSeenBeyond(const Eigen::MatrixXd& others, double size, const Eigen::MatrixXd& columns) {
  // (I + s^2 P P')^-1 = I - P (I / s^2 + P'P)^-1 P'.
  Eigen::MatrixXd normal = others.transpose() * others;
  normal.diagonal().array() += 1.0 / (size * size);
  const Eigen::MatrixXd across = others.transpose() * columns;
  Eigen::VectorXd squares = columns.colwise().squaredNorm().transpose();
  if (others.cols() > 0) {
    squares -= across.cwiseProduct(Eigen::LLT<Eigen::MatrixXd>(normal).solve(across)).colwise().sum().transpose();
  }
  const double widest = kChangeScales[kNumChangeScales - 1];
  return widest * widest * squares.maxCoeff() >= kStandsOut * kStandsOut;
}

}  // namespace

EstimateComparison::EstimateComparison(const KnownRobot& old_estimate, const KnownRobot& new_estimate)
    : old_(old_estimate), new_(new_estimate) {
  CheckSameRobot(old_, new_);
  own_ = PairCampaigns(old_, &new_);
  // Both in the same conditions, and with each joint's own derivative at hand.
  const bool any_slides = std::any_of(old_.robot.chain.joints.begin(), old_.robot.chain.joints.end(),
                                      [](const Joint& joint) { return joint.type == JointType::kPrismatic; });
  const bool any_turns = std::any_of(old_.robot.chain.joints.begin(), old_.robot.chain.joints.end(),
                                     [](const Joint& joint) { return joint.type == JointType::kRevolute; });
  old_.loading.repeatability = RepeatabilitySpec();
  if (any_turns) old_.loading.repeatability.angle.common = 1.0;
  if (any_slides) old_.loading.repeatability.length.common = 1.0;
  const ConditionOrigins of_new = new_.loading.origins.value_or(ConditionOrigins());
  new_.loading = old_.loading;
  // At one temperature, that of the old campaign; where one of them states none, each at its own.
  if (new_.loading.origins && new_.loading.origins->mean_temperature != 0.0 && of_new.mean_temperature != 0.0) {
    new_.loading.origins->mean_temperature = of_new.mean_temperature;
  }
  const Measurements rows = RowsOfBoth(old_, new_, own_);
  problems_.push_back(PredictionProblem(old_, rows));
  problems_.push_back(PredictionProblem(new_, rows));
  AssumeAlike(0, new_);
  AssumeAlike(1, old_);
  SetMoments();
  start_ = problems_[0].parameters;
  for (const ShotInput& shot : problems_[0].shot_inputs()) start_joints_.push_back(shot.conditions.q);
  rows_.resize(rows.observations.size());
  std::iota(rows_.begin(), rows_.end(), 0);
  groups_ = ListChangeGroups(problems_[0], old_, new_, own_);
  for (const ChangeGroup& group : groups_) applied_.push_back(Eigen::VectorXd::Zero(group.size()));
  AllowForHalves();
  CheckKnown();
  AllowForRegions();
  AllowForClusters();
  NoteWhatOneAssumed();
  FactorCovariance();
}

// The old campaign at its end, the new one at its beginning.
void EstimateComparison::SetMoments() {
  ComparedMoment end = EndOf(old_);
  for (const std::string& station : StationsBegunAnew(old_, new_)) end.station_time.erase(station);
  SetMoment(end, &problems_[0]);
  SetMoment(ComparedMoment(), &problems_[1]);
  moved_by_events_ = MovedByEvents(problems_[0]);
  const std::vector<std::string> before = HappenedWithin(old_), after = HappenedWithin(new_);
  if (!before.empty()) notes_.push_back(ComparedAtItsEnd(old_.file, before));
  if (!after.empty()) notes_.push_back(ComparedAtItsBeginning(new_.file, after));
}

// No change of what the other assumed is determined, however large: deflections of millimetres are not linear in it to
// a micrometre, so that it is set to what the other assumed. A joint without a compliance is rigid.
void EstimateComparison::AssumeAlike(int which, const KnownRobot& other) {
  ParameterSet& parameters = problems_[which].parameters;
  const ParameterSet& others = problems_[1 - which].parameters;
  const KnownRobot& known = which == 0 ? old_ : new_;
  Eigen::VectorXd step = Eigen::VectorXd::Zero(parameters.num_coordinates());
  for (int i = 0; i < parameters.num_coordinates(); ++i) {
    const Coordinate& coordinate = parameters.coordinates()[i];
    const bool is_open = IsFree(known, coordinate.name) && !IsFree(other, coordinate.name);
    if (!is_open || !IsOfCampaign(coordinate.kind) || IsOfItsCourse(known, coordinate.name)) continue;
    const int same = others.FindCoordinate(coordinate.name);
    if (same >= 0) step[i] = others.Value(same) - parameters.Value(i);
    if (same < 0 && coordinate.kind == CoordinateKind::kCompliance) step[i] = -parameters.Value(i);
  }
  parameters.Plus(step);
}

void EstimateComparison::CheckKnown() const {
  for (const KnownRobot* known : {&old_, &new_}) {
    if (!known->uncertainty.covariance.allFinite()) {
      throw InputError({known->file, 0, "sigma"}, "this estimate does not say how well anything is known",
                       "state the noise of the measurements, or measure more than there are unknowns");
    }
  }
}

// p - b and b, with b the base in the station. What stands in the room is at a distance alone.
EstimateComparison::Lengths EstimateComparison::LengthsAt(const Eigen::Matrix3Xd& points) const {
  const Measurements& data = problems_[0].data();
  Lengths lengths{Eigen::Matrix3Xd::Zero(3, points.cols()), points};
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Observation& row = data.observations[rows_[i]];
    if (old_.markers.at(data.markers[row.marker]).on.kind == MarkerPlace::Kind::kWorld) continue;
    lengths.distance.col(i) = problems_[0].parameters.BaseInStation(data.shots[row.shot].station).translation;
    lengths.arm.col(i) = points.col(i) - lengths.distance.col(i);
  }
  return lengths;
}

Eigen::Matrix3Xd EstimateComparison::MovedPoints() const {
  const Eigen::Matrix3Xd points = PredictPoints(problems_[0], problems_[0].parameters, rows_);
  if (arm_grown_ == 0.0 && distance_grown_ == 0.0) return points;
  const Lengths lengths = LengthsAt(points);
  return points + arm_grown_ * lengths.arm + distance_grown_ * lengths.distance;
}

Eigen::VectorXd EstimateComparison::Difference() const {
  const Eigen::Matrix3Xd from = MovedPoints();
  const Eigen::Matrix3Xd to = PredictPoints(problems_[1], problems_[1].parameters, rows_);
  const Eigen::Matrix3Xd difference = to - from;
  return Eigen::Map<const Eigen::VectorXd>(difference.data(), difference.size());
}

double EstimateComparison::Rms() const {
  return std::sqrt(Difference().squaredNorm() / static_cast<double>(rows_.size()));
}

Eigen::MatrixXd EstimateComparison::ColumnsOf(size_t g, const Linearization& all) const {
  const ChangeGroup& group = groups_[g];
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(all.num_rows(), group.size());
  for (size_t i = 0; i < group.coordinates.size(); ++i) {
    columns.col(static_cast<long>(i)) = group.typical[i] * all.jacobian.col(group.coordinates[i]);
  }
  if (group.kind == ChangeKind::kJointZero) {
    columns.col(0) = group.typical[0] * ZeroColumn(problems_[0].model().chain(), all, group.index);
  }
  if (group.kind == ChangeKind::kScale) {
    const Lengths lengths = LengthsAt(PredictPoints(problems_[0], problems_[0].parameters, rows_));
    columns.col(0) = group.typical[0] * lengths.arm.reshaped();
    columns.col(1) = group.typical[1] * lengths.distance.reshaped();
  }
  if (group.carried.empty()) return columns;
  const Matrix3<double> rotation = RotationOf(group, applied_[g]);
  for (const int marker : group.carried) {
    // m' = R m + t + own shift, R = exp(d) R: dm' = dt + d x R m.
    const Vector3<double> arm = rotation * (start_.MarkerPoint(marker) + moved_by_events_[marker]);
    const int first = start_.marker(marker).first_coordinate;
    for (int i = 0; i < 6; ++i) {
      const Vector3<double> unit = Vector3<double>::Unit(i % 3);
      const Vector3<double> way = i < 3 ? unit : Vector3<double>(unit.cross(arm));
      for (int a = 0; a < 3; ++a) columns.col(i) += group.typical[i] * way[a] * all.jacobian.col(first + a);
    }
  }
  return columns;
}

Eigen::MatrixXd EstimateComparison::MetricColumns(const std::vector<size_t>& groups) const {
  const Linearization all = AllColumns(problems_[0], rows_);
  std::vector<Eigen::MatrixXd> parts;
  for (const size_t g : groups) parts.push_back(ColumnsOf(g, all));
  return SideBySide(parts, all.num_rows());
}

EstimateComparison::Linear EstimateComparison::Linearise() const {
  const Linearization all = AllColumns(problems_[0], rows_);
  Linear linear;
  int width = 0;
  for (const ChangeGroup& group : groups_) width += group.size();
  linear.columns.resize(all.num_rows(), width);
  linear.applied.resize(width);
  int first = 0;
  for (size_t g = 0; g < groups_.size(); ++g) {
    const ChangeGroup& group = groups_[g];
    linear.columns.middleCols(first, group.size()) = ColumnsOf(g, all);
    linear.applied.segment(first, group.size()) = applied_[g];
    std::vector<int> indices(group.size());
    std::iota(indices.begin(), indices.end(), first);
    linear.of_group.push_back(indices);
    first += group.size();
  }
  linear.left = Difference();
  const auto lower = whitener_.triangularView<Eigen::Lower>();
  lower.solveInPlace(linear.left);
  lower.solveInPlace(linear.columns);
  return linear;
}

void EstimateComparison::MoveTo(const std::vector<Eigen::VectorXd>& applied) {
  CalibrationProblem& problem = problems_[0];
  std::vector<ShotInput>& inputs = *problem.mutable_shot_inputs();
  for (size_t s = 0; s < inputs.size(); ++s) inputs[s].conditions.q = start_joints_[s];
  ParameterSet& parameters = problem.parameters;
  parameters = start_;
  Eigen::VectorXd step = Eigen::VectorXd::Zero(parameters.num_coordinates());
  for (size_t g = 0; g < groups_.size(); ++g) {
    const ChangeGroup& group = groups_[g];
    if (group.kind == ChangeKind::kJointZero) {
      for (ShotInput& shot : inputs) shot.conditions.q[group.index] += group.typical[0] * applied[g][0];
    }
    if (group.kind == ChangeKind::kScale) {
      arm_grown_ = group.typical[0] * applied[g][0], distance_grown_ = group.typical[1] * applied[g][1];
    }
    // From where the set was made, Plus turns a base by the whole rotation vector.
    for (size_t i = 0; i < group.coordinates.size(); ++i) {
      step[group.coordinates[i]] += group.typical[i] * applied[g][static_cast<long>(i)];
    }
    for (const int marker : group.carried) {
      const Vector3<double> shift(applied[g][0] * group.typical[0], applied[g][1] * group.typical[1],
                                  applied[g][2] * group.typical[2]);
      const Vector3<double>& moved = moved_by_events_[marker];  // what the shots add to a marker's point
      parameters.SetMarkerPoint(marker,
                                RotationOf(group, applied[g]) * (start_.MarkerPoint(marker) + moved) + shift - moved);
    }
  }
  problem.model().Prepare(&inputs);
  parameters.Plus(step);
  applied_ = applied;
}

std::vector<std::string> EstimateComparison::ZerosWithin(const Linear& linear, const std::vector<size_t>& set) const {
  std::vector<int> columns;
  for (const size_t g : set) columns.insert(columns.end(), linear.of_group[g].begin(), linear.of_group[g].end());
  const Eigen::MatrixXd moved = linear.columns(Eigen::all, columns);
  std::vector<std::string> names;
  if (set.empty()) return names;
  for (size_t g = 0; g < groups_.size(); ++g) {
    if (groups_[g].kind != ChangeKind::kJointZero) continue;
    if (!IsSeenBeyond(moved, kAnySize, linear.columns(Eigen::all, linear.of_group[g])))
      names.push_back(groups_[g].target);
  }
  return names;
}

void EstimateComparison::Drop(const std::vector<bool>& stays) {
  std::vector<ChangeGroup> groups;
  std::vector<Eigen::VectorXd> applied;
  for (size_t g = 0; g < groups_.size(); ++g) {
    if (!stays[g]) continue;
    groups.push_back(groups_[g]);
    applied.push_back(applied_[g]);
  }
  groups_ = groups;
  MoveTo(applied);
}

void EstimateComparison::LeaveOutIndistinguishable() {
  const Linear linear = Linearise();
  const auto columns_of = [&](const auto& which) {
    std::vector<int> columns;
    for (size_t g = 0; g < groups_.size(); ++g) {
      if (which(groups_[g])) columns.insert(columns.end(), linear.of_group[g].begin(), linear.of_group[g].end());
    }
    return Eigen::MatrixXd(linear.columns(Eigen::all, columns));
  };
  const Eigen::MatrixXd own = columns_of([](const ChangeGroup& group) { return group.of_campaign; });
  const Eigen::MatrixXd plain = columns_of([](const ChangeGroup& group) { return group.is_plain(); });
  std::vector<bool> stays(groups_.size(), true);
  std::vector<std::string> hidden;
  for (size_t g = 0; g < groups_.size(); ++g) {
    if (groups_[g].of_campaign) continue;
    const Eigen::MatrixXd columns = linear.columns(Eigen::all, linear.of_group[g]);
    stays[g] =
        IsSeenBeyond(own, kAnySize, columns) && (groups_[g].is_plain() || IsSeenBeyond(plain, kLargeSize, columns));
    // Without a campaign's own coordinates, a zero that moves nothing has nothing to be named for, either.
    if (!stays[g] && groups_[g].kind == ChangeKind::kJointZero) hidden.push_back(groups_[g].target);
  }
  // Design parameters that both estimates left free stand for others that would do the same. Of one that either assumed
  // no change is determined, and it is no cause of what others did.
  const auto is_free = [&](const ChangeGroup& group) {
    if (group.coordinates.empty() || group.is_plain()) return true;
    const std::string& name = problems_[0].parameters.coordinates()[group.coordinates[0]].name;
    return IsFree(old_, name) && IsFree(new_, name);
  };
  std::vector<size_t> order(groups_.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_partition(order.begin(), order.end(), [&](size_t g) { return is_free(groups_[g]); });
  for (size_t i = 0; i < order.size(); ++i) {
    ChangeGroup& first = groups_[order[i]];
    if (first.is_plain() || !stays[order[i]]) continue;
    const Eigen::MatrixXd column = linear.columns(Eigen::all, linear.of_group[order[i]]);
    for (size_t k = i + 1; k < order.size(); ++k) {
      const ChangeGroup& second = groups_[order[k]];
      if (second.is_plain() || !stays[order[k]]) continue;
      if (IsSeenBeyond(column, kLargeSize, linear.columns(Eigen::all, linear.of_group[order[k]]))) continue;
      stays[order[k]] = false;
      first.same.push_back(WordOf(second.kind) + " " + second.target);
    }
  }
  for (size_t g = 0; g < groups_.size(); ++g) stays[g] = stays[g] && is_free(groups_[g]);
  if (own_.station) notes_.push_back(StationsAreOwn(old_.file, new_.file));
  if (own_.markers) notes_.push_back(MarkersAreOwn(old_.file, new_.file));
  if (!hidden.empty()) notes_.push_back(ZerosAreHidden(hidden));
  Drop(stays);
}

}  // namespace sagitta

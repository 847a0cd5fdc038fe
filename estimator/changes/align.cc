// EstimateComparison::Align: the old estimate next to the new one, by what can be of any size.
//
// Bases are registered to the predicted points in closed form, then bases and markers, then these and the joints' zeros
// follow by Gauss-Newton on distances. What moves the points alike (the first joint's zero and a turn of the base) is
// left to the base, and to the smallest step after that. Here only the place counts from which columns are derivatives:
// what changed is decided by the search over sets.
#include <algorithm>
#include <cmath>

#include "estimator/alignment/pose_registration.h"
#include "estimator/alignment/starting_values.h"
#include "estimator/changes/comparison.h"
#include "estimator/least_squares/linearization.h"
#include "models/dense_algebra.h"

namespace sagitta {
namespace {

constexpr int kFitRounds = 20;        // Gauss-Newton converges in four after a registration
constexpr double kRegistered = 1e-9;  // m RMS, of a step
// Of the largest pivot: a tool of a centimetre on an arm of three metres. Less are axes that are nearly parallel:
// metres of one against metres of the other would make up for a millimetre.
constexpr double kDependent = 3e-3;

}  // namespace

void EstimateComparison::RegisterBases() {
  const Eigen::Matrix3Xd from = PredictPoints(problems_[0], problems_[0].parameters, rows_);
  const Eigen::Matrix3Xd to = PredictPoints(problems_[1], problems_[1].parameters, rows_);
  const Measurements& data = problems_[0].data();
  std::vector<Eigen::VectorXd> applied = applied_;
  for (size_t g = 0; g < groups_.size(); ++g) {
    const ChangeGroup& group = groups_[g];
    if (group.kind != ChangeKind::kBase) continue;
    std::vector<int> seen;
    for (const int row : rows_) {
      const Observation& observation = data.observations[row];
      const bool in_the_room = old_.markers.at(data.markers[observation.marker]).on.kind == MarkerPlace::Kind::kWorld;
      if (!in_the_room && data.shots[observation.shot].station == group.index) seen.push_back(row);
    }
    const Eigen::Matrix3Xd points = from(Eigen::all, seen), targets = to(Eigen::all, seen);
    if (!SpansAPlane(points)) continue;
    const Pose<double> motion = RegisterRigid(points, targets);
    const Vector3<double> base = start_.BaseInStation(group.index).translation;
    const Vector3<double> shift = motion * base - base, turn = RotationVector(motion.rotation);
    for (int a = 0; a < 3; ++a) {
      applied[g][a] = shift[a] / group.typical[a];
      applied[g][3 + a] = turn[a] / group.typical[3 + a];
    }
  }
  MoveTo(applied);
}

void EstimateComparison::RegisterTool() {
  const auto tool =
      std::find_if(groups_.begin(), groups_.end(), [](const auto& group) { return !group.carried.empty(); });
  if (tool == groups_.end()) return;
  const auto n = static_cast<long>(tool->carried.size());
  Eigen::Matrix3Xd before(3, n), after(3, n);
  for (long i = 0; i < n; ++i) {
    before.col(i) = start_.MarkerPoint(tool->carried[i]);
    after.col(i) = problems_[0].parameters.MarkerPoint(tool->carried[i]);
  }
  // About the line of two markers a turn is not determined.
  if (!SpansAPlane(before) || !SpansAPlane(after)) return;
  const Pose<double> motion = RegisterRigid(before, after);
  const Vector3<double> turn = RotationVector(motion.rotation);
  std::vector<Eigen::VectorXd> applied = applied_;
  Eigen::VectorXd& of_tool = applied[tool - groups_.begin()];
  for (int a = 0; a < 3; ++a) {
    of_tool[a] = motion.translation[a] / tool->typical[a];
    of_tool[3 + a] = turn[a] / tool->typical[3 + a];
  }
  for (size_t g = 0; g < groups_.size(); ++g) {
    const ChangeGroup& group = groups_[g];
    const auto carried = std::find(tool->carried.begin(), tool->carried.end(), group.index);
    if (group.kind != ChangeKind::kMarker || carried == tool->carried.end()) continue;
    const long i = carried - tool->carried.begin();
    const Vector3<double> rest = after.col(i) - motion * Vector3<double>(before.col(i));
    for (int a = 0; a < 3; ++a) applied[g][a] = rest[a] / group.typical[a];
  }
  MoveTo(applied);
}

void EstimateComparison::Fit(const std::vector<ChangeKind>& kinds) {
  std::vector<size_t> fitted;
  for (size_t g = 0; g < groups_.size(); ++g) {
    if (std::find(kinds.begin(), kinds.end(), groups_[g].kind) != kinds.end()) fitted.push_back(g);
  }
  double rms = Rms();
  for (int round = 0; round < kFitRounds; ++round) {
    const Eigen::MatrixXd columns = MetricColumns(fitted);
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> shortest;
    shortest.setThreshold(kDependent);
    shortest.compute(columns);
    const Eigen::VectorXd step = shortest.solve(Difference());
    const std::vector<Eigen::VectorXd> before = applied_;
    std::vector<Eigen::VectorXd> applied = applied_;
    long first = 0;
    for (const size_t g : fitted) {
      const long size = groups_[g].size();
      applied[g] = Further(groups_[g], applied[g], step.segment(first, size));
      first += size;
    }
    MoveTo(applied);
    const double reached = Rms();
    if (!(reached < rms)) {
      MoveTo(before);
      return;
    }
    rms = reached;
    if ((columns * step).squaredNorm() < kRegistered * kRegistered * static_cast<double>(rows_.size())) return;
  }
}

void EstimateComparison::Align(MarkerStart start) {
  std::vector<Eigen::VectorXd> none;
  for (const ChangeGroup& group : groups_) none.push_back(Eigen::VectorXd::Zero(group.size()));
  MoveTo(none);
  RegisterBases();
  Fit({ChangeKind::kBase, ChangeKind::kMarker});
  if (start == MarkerStart::kBody) RegisterTool();
  Fit({ChangeKind::kJointZero, ChangeKind::kBase, ChangeKind::kMarker});
  FactorCovariance();
}

}  // namespace sagitta

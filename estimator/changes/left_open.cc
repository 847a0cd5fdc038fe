// EstimateComparison: what the two estimates leave open of the difference of their predictions, as a covariance.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "estimator/changes/comparison.h"
#include "estimator/changes/comparison_columns.h"
#include "estimator/least_squares/held_influence.h"
#include "estimator/least_squares/row_sums.h"
#include "estimator/report/changes_words.h"
#include "estimator/results/prediction_noise.h"
#include "models/dense_algebra.h"
#include "models/matrix_functions.h"
#include "problems/input_error.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr double kFloor = 2e-6;  // m: less is no change of any robot, and keeps C regular
// Of a covariance found from configurations: beyond, the heavy tails of so small a sample are no correction any more.
// It asks for n = 3 p + 4 of them, three to each parameter.
constexpr double kMostOfClusters = 1.5;

// Base poses and markers were found in the old campaign's frames; moved, their directions turn.
void TurnColumns(const std::vector<int>& coordinates, const Matrix3<double>& rotation, Eigen::MatrixXd* jacobian) {
  for (size_t first = 0; first + 2 < coordinates.size(); first += 3) {
    Eigen::MatrixXd turned(jacobian->rows(), 3);
    for (int a = 0; a < 3; ++a) turned.col(a) = jacobian->col(coordinates[first + a]);
    turned = Eigen::MatrixXd(turned * Eigen::MatrixXd(rotation));
    for (int a = 0; a < 3; ++a) jacobian->col(coordinates[first + a]) = turned.col(a);
  }
}

}  // namespace

// What joints scatter by, and gear waves, differ between two campaigns as between random halves of one, or as its
// configurations do. Intervals of single parameters are wide enough where parts contradict each other
// (between_parts.h); combinations that few of the parts determine are not.
void EstimateComparison::AllowForHalves() {
  for (KnownRobot* known : {&old_, &new_}) {
    if (std::isinf(known->halves)) {
      throw InputError(
          {known->file, 0, "agreement"},
          "its configurations err by more than noise, and are too few to show by how much: chance would look like "
          "changes",
          "calibrate with repeatability_urad: estimate where the joints scatter, or measure more configurations");
    }
    known->uncertainty.covariance = known->campaign_covariance;
    if (known->halves > 1.0) notes_.push_back(ConfigurationsErr(known->file, known->halves));
  }
}

// A covariance of p parameters that was found from n configurations has an inverse that is too large, by
// (n - 1) / (n - p - 2) in the mean (Wishart): a difference of nothing looks like many standard deviations.
void EstimateComparison::AllowForClusters() {
  for (KnownRobot* known : {&old_, &new_}) {
    const double n = known->clusters, p = static_cast<double>(known->uncertainty.estimated.size());
    if (n == 0.0) continue;
    const double factor = n > p + 2.0 ? (n - 1.0) / (n - p - 2.0) : kInfinity;
    if (factor > kMostOfClusters) {
      throw InputError({known->file, 0, "intervals"},
                       "the covariance was found from " + Significant(n, 6) + " configurations, too few for that of " +
                           Significant(p, 6) + " parameters together: chance would look like changes",
                       "calibrate with covariance: model, and repeatability_urad: estimate where the joints scatter");
    }
    known->uncertainty.covariance *= factor;
  }
}

// What the model lacks is in every region another robot. The covariance between parts has that of parts that are halves
// of one joint's range; where the campaigns have less in common, it is open.
void EstimateComparison::AllowForRegions() {
  const CommonRange common = LeastCommonRange(old_, new_);
  if (!common.IsLessThanParts()) return;
  for (const int which : {0, 1}) of_region_ = std::max({of_region_, ModelErrorOf(which), UnseenModelErrorOf(which)});
  if (!(of_region_ > 0.0)) return;
  notes_.push_back(RegionsDiffer(old_.robot.chain.joints[common.joint].name, common.share, of_region_));
}

// m, RMS distance: by how far the predictions of parts of a campaign are apart beyond noise, or what is left of points
// that were not fitted.
double EstimateComparison::ModelErrorOf(int which) const {
  const KnownRobot& known = which == 0 ? old_ : new_;
  const CalibrationProblem& problem = problems_[which];
  const Eigen::MatrixXd columns =
      NamedColumns(known.uncertainty.estimated, problem, AllColumns(problem, rows_).jacobian);
  const Eigen::MatrixXd beyond = known.uncertainty.covariance - known.noise_covariance;
  const double square = (columns * beyond).cwiseProduct(columns).sum() / static_cast<double>(rows_.size());
  return std::max(known.rest, std::sqrt(std::max(0.0, square)));
}

// m, RMS distance: what residuals do not show. With f degrees of freedom a misfit of s times the noise makes chi-square
// larger by f s^2, and chance by sqrt(2 f): two of its standard deviations are s^2 = 2 sqrt(2 / f).
double EstimateComparison::UnseenModelErrorOf(int which) const {
  const KnownRobot& known = which == 0 ? old_ : new_;
  if (!(known.dof > 0.0)) return 0.0;
  const CalibrationProblem& problem = problems_[which];
  double square = 0.0;
  for (const Matrix3<double>& root :
       PredictionRoots(problem, known.noise, PredictPoints(problem, problem.parameters, rows_))) {
    square += root.squaredNorm() / static_cast<double>(rows_.size());
  }
  return known.noise.scale * std::sqrt(square * 2.0 * std::sqrt(2.0 / known.dof));
}

// Any one parameter of the arm may be in one region what moves the points there by what the model leaves of them.
Eigen::MatrixXd EstimateComparison::RegionSpread(const Linearization& all) const {
  std::vector<Eigen::VectorXd> columns;
  const std::vector<Coordinate>& coordinates = start_.coordinates();
  for (size_t i = 0; i < coordinates.size(); ++i) {
    if (coordinates[i].kind == CoordinateKind::kBase || coordinates[i].kind == CoordinateKind::kMarker) continue;
    columns.emplace_back(all.jacobian.col(static_cast<long>(i)));
  }
  for (int j = 0; j < problems_[0].model().chain().num_joints(); ++j) {
    columns.emplace_back(ZeroColumn(problems_[0].model().chain(), all, j));
  }
  columns.emplace_back(LengthsAt(PredictPoints(problems_[0], problems_[0].parameters, rows_)).arm.reshaped());
  Eigen::MatrixXd spread = Eigen::MatrixXd::Zero(all.num_rows(), static_cast<long>(columns.size()));
  for (size_t i = 0; i < columns.size(); ++i) {
    const double rms = columns[i].norm() / std::sqrt(static_cast<double>(rows_.size()));
    if (rms > 0.0) spread.col(static_cast<long>(i)) = of_region_ / rms * columns[i];
  }
  return spread;
}

void EstimateComparison::NoteWhatOneAssumed() {
  for (const auto& [one, other] : {std::pair(&old_, &new_), std::pair(&new_, &old_)}) {
    std::vector<std::string> names;
    for (const std::string& name : one->uncertainty.estimated) {
      const std::optional<CoordinateKind> kind = CoordinateKindOf(name);
      if (!kind || kind == CoordinateKind::kBase || kind == CoordinateKind::kMarker) continue;
      if (!IsFree(*other, name) && !IsOfItsCourse(*one, name)) names.push_back(name);
    }
    if (names.empty()) continue;
    notes_.push_back(ChangesOpen(one->file, names));
  }
}

// Root of an estimate's covariance of the predictions: S with S S' its share of C. jacobian: where the estimate has
// been moved to; where_it_was: before.
Eigen::MatrixXd EstimateComparison::SpreadOf(const CalibrationProblem& problem, const KnownRobot& known,
                                             const KnownRobot& other, const Eigen::MatrixXd& jacobian,
                                             const Eigen::MatrixXd& where_it_was) const {
  const ParameterUncertainty& u = known.uncertainty;
  const Eigen::MatrixXd estimated = NamedColumns(u.estimated, problem, jacobian);
  std::vector<Eigen::MatrixXd> parts;
  if (!u.estimated.empty()) parts.push_back(estimated * RootOf(u.covariance));
  if (!u.held.empty()) {
    Eigen::MatrixXd held = NamedColumns(u.held, problem, jacobian) + estimated * u.slopes;
    const Eigen::MatrixXd unmoved =
        NamedColumns(u.held, problem, where_it_was) + NamedColumns(u.estimated, problem, where_it_was) * u.slopes;
    // What did nothing to the points is a convention (where the flange's frame is); both estimates have the same.
    for (long h = 0; h < held.cols(); ++h) {
      if (unmoved.col(h).norm() * std::sqrt(u.second_moment(h, h)) < kFloor) held.col(h).setZero();
    }
    parts.push_back(held * RootOf(u.second_moment));
  }
  // What only this one estimated, the other assumed; not what happened within this one, which the other has in its
  // zeros, markers and bases.
  for (size_t i = 0; i < u.estimated.size(); ++i) {
    const std::string& name = u.estimated[i];
    const int coordinate = problem.parameters.FindCoordinate(name);
    if (coordinate < 0 || IsFree(other, name) || IsOfItsCourse(known, name)) continue;
    const auto p = static_cast<long>(i);
    if (!(u.covariance(p, p) > 0.0)) continue;
    const Coordinate& assumed = problem.parameters.coordinates()[coordinate];
    const double range = PhysicalRange(assumed);
    // The other's parameters made up for it: regression of all on the one, C_:p / C_pp times how far it may be off.
    parts.push_back(range * (estimated * (u.covariance.col(p) / u.covariance(p, p))));
    // Or nothing made up for it; by how much is between the two columns.
    if (IsOfCampaign(assumed.kind)) parts.push_back(range * jacobian.col(coordinate));
  }
  return SideBySide(parts, jacobian.rows());
}

// Base and marker columns of the old campaign as its parameters' errors move the points now: p' = T p moves by R_T dp.
Eigen::MatrixXd EstimateComparison::TurnedWithTheChanges(Eigen::MatrixXd jacobian) const {
  for (size_t g = 0; g < groups_.size(); ++g) {
    const ChangeGroup& group = groups_[g];
    if (!group.is_motion()) continue;
    const Matrix3<double> rotation = RotationOf(group, applied_[g]);
    if (group.kind == ChangeKind::kBase) TurnColumns(group.coordinates, rotation, &jacobian);
    for (const int marker : group.carried) {
      const int first = start_.marker(marker).first_coordinate;
      TurnColumns({first, first + 1, first + 2}, rotation, &jacobian);
    }
  }
  return jacobian;
}

void EstimateComparison::FactorCovariance() {
  const std::vector<Eigen::VectorXd> applied = applied_;
  std::vector<Eigen::VectorXd> none;
  for (const ChangeGroup& group : groups_) none.push_back(Eigen::VectorXd::Zero(group.size()));
  MoveTo(none);
  const Eigen::MatrixXd before = AllColumns(problems_[0], rows_).jacobian;
  MoveTo(applied);
  const Linearization all = AllColumns(problems_[0], rows_);
  const Eigen::MatrixXd moved = TurnedWithTheChanges(all.jacobian);
  const Eigen::MatrixXd other = AllColumns(problems_[1], rows_).jacobian;
  std::vector<Eigen::MatrixXd> parts = {SpreadOf(problems_[0], old_, new_, moved, before),
                                        SpreadOf(problems_[1], new_, old_, other, other)};
  if (of_region_ > 0.0) parts.push_back(RegionSpread(all));
  spread_ = SideBySide(parts, moved.rows());
  Eigen::MatrixXd covariance = spread_ * spread_.transpose();
  covariance.diagonal().array() += kFloor * kFloor;
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  log_determinant_ = sagitta::LogDeterminant(factor);
  whitener_ = factor.matrixL();
}

double EstimateComparison::NumRandom() const {
  return whitener_.triangularView<Eigen::Lower>().solve(spread_).squaredNorm();
}

}  // namespace sagitta

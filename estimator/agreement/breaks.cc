#include "estimator/agreement/breaks.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <string>

#include "estimator/agreement/splits.h"
#include "estimator/least_squares/all_joints.h"
#include "estimator/least_squares/sample.h"
#include "estimator/statistics/distributions.h"
#include "models/dense_algebra.h"

namespace sagitta {
namespace {

// The most that any break explains of the measured robots next to the tree is 0.08 (UR10, series B); a frame that moves
// by 3 standard deviations in the middle of a campaign explains 0.4.
constexpr double kBeyondArms = 0.25;
constexpr double kLeastOfItself = 1e-6;  // of a column's square, given what is estimated: less is the same

// Of each cause, before the likeliest is looked at closely: the nearest is off by 1 / 400 of the rows, which leaves 1 %
// of what a break in the middle explains (a step that is off by the share e explains 1 - 4 e of it).
constexpr size_t kPlaces = 200;

// Columns that move together.
struct Cause {
  BreakOf of;
  int index;
  std::vector<int> columns;  // positions in the linearization; of a joint its latent column
  Eigen::MatrixXd
      motion{};  // by what of each column it moves, a column for each of its freedoms; empty: each by itself
};

struct Step {
  double gain = 0.0;
  Eigen::VectorXd by;  // per unit of the columns
};

// The likeliest break so far.
struct LikeliestBreak {
  Break found;
  const Cause* cause = nullptr;  // none: nothing has moved
  Eigen::VectorXd by;            // per unit of its columns
  double score = 0.0;            // ScoreOf; 0: nothing has moved
};

class BreakSearch {
 public:
  BreakSearch(const CalibrationProblem& problem, const Estimate& estimate) : problem_(problem), estimate_(estimate) {
    problem_.latent = WithAllJoints(problem.latent, problem.robot().num_joints());
  }

  std::optional<Break> Run() {
    const std::vector<Cause> causes = Causes();
    if (!Prepare()) return std::nullopt;
    LikeliestBreak best;
    const size_t one_in = 1 + order_.size() / kPlaces;
    int tried = 0;
    for (const Cause& cause : causes) tried += Try(cause, one_in, &best);
    if (best.cause == nullptr || ScoreOfPose() < best.score) return std::nullopt;
    if (one_in > 1) tried += Try(*best.cause, 1, &best);
    Break& found = best.found;
    found.p_value = std::min(1.0, found.p_value * tried);
    if (found.share <= kBeyondArms || found.p_value >= problem_.experiment().significance) return std::nullopt;
    found.moved = Moved(best);
    return found;
  }

 private:
  const Shot& ShotOf(int k) const {
    return problem_.data().shots[problem_.data().observations[rows_.observations[k]].shot];
  }

  // Sets columns_: what is estimated first, then what else of stations and markers may move.
  std::vector<Cause> Causes() {
    columns_ = estimate_.estimated;
    const ParameterSet& parameters = estimate_.parameters;
    const auto place = [&](int coordinate) {
      const auto found = std::find(columns_.begin(), columns_.end(), coordinate);
      if (found != columns_.end()) return static_cast<int>(found - columns_.begin());
      columns_.push_back(coordinate);
      return static_cast<int>(columns_.size()) - 1;
    };
    std::vector<Cause> causes;
    const auto add = [&](BreakOf of, int index, const std::vector<const ParameterBlock*>& blocks) {
      Cause cause{of, index, {}};
      for (const ParameterBlock* block : blocks) {
        for (int i = 0; i < block->tangent_size; ++i) cause.columns.push_back(place(block->first_coordinate + i));
      }
      causes.push_back(cause);
    };
    for (int s = 0; s < parameters.num_stations(); ++s)
      add(BreakOf::kStation, s, {&parameters.station_translation(s), &parameters.station_rotation(s)});
    for (int m = 0; m < parameters.num_markers(); ++m) add(BreakOf::kMarker, m, {&parameters.marker(m)});
    if (const std::vector<int> on_flange = problem_.MarkersOnFlange(); on_flange.size() > 1) {
      std::vector<const ParameterBlock*> markers;
      for (const int m : on_flange) markers.push_back(&parameters.marker(m));
      add(BreakOf::kTool, 0, markers);
      causes.back().motion = MotionOf(on_flange);
    }
    for (int j = 0; j < problem_.robot().num_joints(); ++j) causes.push_back({BreakOf::kJoint, j, {j}});
    return causes;
  }

  // Markers as one body in their frame: dp = dt + w x p. Three rows of each marker, columns dt and w.
  Eigen::MatrixXd MotionOf(const std::vector<int>& markers) const {
    Eigen::MatrixXd motion(3 * markers.size(), 6);
    for (size_t i = 0; i < markers.size(); ++i) {
      const Vector3<double> p = estimate_.parameters.MarkerPoint(markers[i]);
      Matrix3<double> turned;  // w x p of each unit w
      turned << 0.0, p.z(), -p.y(), -p.z(), 0.0, p.x(), p.y(), -p.x(), 0.0;
      motion.middleRows<3>(3 * static_cast<Eigen::Index>(i)) << Matrix3<double>::Identity(), turned;
    }
    return motion;
  }

  // What these columns add to the basis: orthogonal to it, and orthonormal.
  Eigen::MatrixXd NewDirections(Eigen::MatrixXd columns) const {
    if (columns.cols() == 0) return columns;
    const Eigen::VectorXd scale = columns.colwise().norm().cwiseMax(1e-300).cwiseInverse();
    columns = columns * scale.asDiagonal();
    const Eigen::MatrixXd shared = basis_.transpose() * columns;
    columns -= basis_ * shared;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(Eigen::MatrixXd(columns.transpose() * columns));
    Eigen::MatrixXd directions(columns.cols(), 0);
    for (Eigen::Index i = 0; i < columns.cols(); ++i) {
      if (!(eigen.eigenvalues()[i] > kLeastOfItself)) continue;
      directions.conservativeResize(Eigen::NoChange, directions.cols() + 1);
      directions.rightCols(1) = eigen.eigenvectors().col(i) / std::sqrt(eigen.eigenvalues()[i]);
    }
    return columns * directions;
  }

  // Rows, projected off what is estimated, and their order.
  bool Prepare() {
    const std::vector<int> fitted =
        SampleConfigurations(problem_.data(), problem_.CalibrationObservations(), columns_.size(), kEnoughNumbers);
    NoiseRoots roots;
    for (const int i : fitted) roots.push_back(estimate_.scatter[i]);
    rows_ = Linearize(problem_, estimate_.parameters, fitted, columns_, roots, LatentTreatment::kIgnore);
    const auto known = static_cast<Eigen::Index>(estimate_.estimated.size());
    if (!rows_.valid || rows_.num_rows() <= known) return false;
    Linearization own = rows_;
    own.jacobian = rows_.jacobian.leftCols(known);
    const LinearSolution solution = SolveLinearization(own);
    if (!solution.full_rank) return false;
    basis_ = TallProduct(own.jacobian, solution.covariance_root);
    residual_ = rows_.residual - basis_ * (basis_.transpose() * rows_.residual);
    squares_ = residual_.squaredNorm();
    Order();
    return squares_ > 0.0;
  }

  // By time where every shot has one, else by rows; shots stay whole.
  void Order() {
    const auto n = static_cast<int>(rows_.observations.size());
    bool timed = true;
    std::set<int> configurations;
    std::map<const Shot*, int> first;  // row of each shot
    std::map<std::string, std::set<int>> of_load;
    for (int k = 0; k < n; ++k) {
      const Shot& shot = ShotOf(k);
      timed = timed && shot.has_time;
      configurations.insert(shot.configuration);
      of_load[shot.load].insert(shot.configuration);
      first.try_emplace(&shot, k);
    }
    num_configurations_ = static_cast<int>(configurations.size());
    for (const auto& [load, some] : of_load) num_states_ += static_cast<int>(some.size());
    for (const auto& [load, some] : of_load) {
      if (some.size() >= 2 * kFewestOfPart) loads_.push_back(load);
    }
    order_.resize(n);
    std::iota(order_.begin(), order_.end(), 0);
    std::stable_sort(order_.begin(), order_.end(), [&](int a, int b) {
      if (timed && ShotOf(a).time != ShotOf(b).time) return ShotOf(a).time < ShotOf(b).time;
      return first.at(&ShotOf(a)) < first.at(&ShotOf(b));
    });
  }

  // Under a load that few configurations have nothing is seen to move.
  bool Concerns(const Cause& cause, int k) const {
    if (std::find(loads_.begin(), loads_.end(), ShotOf(k).load) == loads_.end()) return false;
    if (cause.of == BreakOf::kStation) return ShotOf(k).station == cause.index;
    if (cause.of == BreakOf::kJoint || cause.of == BreakOf::kTool) return true;
    return problem_.data().observations[rows_.observations[k]].marker == cause.index;
  }

  Eigen::MatrixXd ColumnsOf(const Cause& cause) const {
    if (cause.of == BreakOf::kJoint) return rows_.latent.col(cause.index);
    if (cause.of == BreakOf::kTool) return rows_.jacobian(Eigen::all, cause.columns) * cause.motion;
    return rows_.jacobian(Eigen::all, cause.columns);
  }

  // What the columns explain of a load's rows is the load's: where another begins, what the model lacks of loads looks
  // like a step. All loads together are what is off all the time, estimated or not: poses that go with the order of the
  // rows make a constant error look like one that began.
  Eigen::MatrixXd ByLoads(const Cause& cause, const Eigen::MatrixXd& columns) const {
    const auto loads = static_cast<Eigen::Index>(loads_.size()), d = columns.cols();
    Eigen::MatrixXd by_load = Eigen::MatrixXd::Zero(columns.rows(), loads * d);
    for (const int k : order_) {
      if (!Concerns(cause, k)) continue;
      const auto load = std::find(loads_.begin(), loads_.end(), ShotOf(k).load) - loads_.begin();
      by_load.block(3 * k, load * d, 3, d) = columns.middleRows(3 * k, 3);
    }
    return NewDirections(std::move(by_load));
  }

  // Products of the rows from a place on.
  struct Sums {
    Eigen::MatrixXd own, shared;  // D'D, D'Q
    Eigen::VectorXd along;        // D'r
    Sums(Eigen::Index columns, Eigen::Index known)
        : own(Eigen::MatrixXd::Zero(columns, columns)),
          shared(Eigen::MatrixXd::Zero(columns, known)),
          along(Eigen::VectorXd::Zero(columns)) {}
  };

  // One cause at every place (of many: at every `each`-th), from the last row on. Returns how many were tried.
  int Try(const Cause& cause, size_t each, LikeliestBreak* best) const {
    std::vector<int> rows;
    std::map<int, int> left;  // rows of each configuration before the place
    for (const int k : order_) {
      if (Concerns(cause, k)) rows.push_back(k), ++left[ShotOf(k).configuration];
    }
    const Eigen::MatrixXd columns = ColumnsOf(cause), by_loads = ByLoads(cause, columns);
    Eigen::MatrixXd known(basis_.rows(), basis_.cols() + by_loads.cols());
    known << basis_, by_loads;
    const Eigen::VectorXd residual = residual_ - by_loads * (by_loads.transpose() * residual_);
    Sums sums(columns.cols(), known.cols());
    std::set<int> after;
    size_t places = 0;
    int tried = 0;
    for (size_t at = rows.size(); at-- > 1;) {
      const auto part = columns.middleRows(3 * rows[at], 3);
      sums.own += part.transpose() * part;
      sums.shared += part.transpose() * known.middleRows(3 * rows[at], 3);
      sums.along += part.transpose() * residual.segment<3>(3 * rows[at]);
      const Shot& shot = ShotOf(rows[at]);
      after.insert(shot.configuration);
      if (--left[shot.configuration] == 0) left.erase(shot.configuration);
      if (&ShotOf(rows[at - 1]) == &shot || std::min(after.size(), left.size()) < kFewestOfPart) continue;
      if (++places % each != 0) continue;
      ++tried;
      if (!Improves(cause, sums, best)) continue;
      best->found.last = rows_.observations[rows[at - 1]];
      best->found.first = rows_.observations[rows[at]];
    }
    return tried;
  }

  // The best score of a joint that deviates with waves of once and twice per turn of its angle: what a model lacks that
  // follows the pose (a spring, a gear) is no movement, though poses that go with the order of the rows make it look
  // like one.
  double ScoreOfPose() const {
    double best = 0.0;
    for (int j = 0; j < problem_.robot().num_joints(); ++j) {
      Eigen::MatrixXd waves(rows_.num_rows(), 4);
      for (int k = 0; k < static_cast<int>(rows_.observations.size()); ++k) {
        const double q = problem_.data().configurations[ShotOf(k).configuration].q[j];
        waves.middleRows(3 * k, 3) = rows_.latent.col(j).segment<3>(3 * k) *
                                     Eigen::RowVector4d(std::cos(q), std::sin(q), std::cos(2.0 * q), std::sin(2.0 * q));
      }
      const Eigen::MatrixXd own = waves.transpose() * waves, shared = waves.transpose() * basis_;
      const Step step = Explained(own, own - shared * shared.transpose(), waves.transpose() * residual_);
      best = std::min(best, ScoreOf(step, 4.0));
    }
    return best;
  }

  // Schwarz's criterion, over configurations: n log(1 - share) + columns log n.
  double ScoreOf(const Step& step, double columns) const {
    const auto n = static_cast<double>(num_configurations_);
    return n * std::log(1.0 - ShareOf(step)) + columns * std::log(n);
  }

  double ShareOf(const Step& step) const { return std::min(step.gain / squares_, 1.0 - 1e-12); }

  bool Improves(const Cause& cause, const Sums& sums, LikeliestBreak* best) const {
    const auto d = static_cast<double>(sums.along.size()), n = static_cast<double>(num_configurations_);
    // A configuration under several loads is one alone: what the model lacks of it is in all of them.
    const auto by_loads = static_cast<double>(sums.shared.cols() - basis_.cols());
    const double rows = std::min(num_states_ - by_loads, static_cast<double>(rows_.num_rows() - sums.shared.cols()));
    const double freedom = std::min(n, rows) - d;
    if (freedom < 1.0) return false;
    const Step step = Explained(sums.own, sums.own - sums.shared * sums.shared.transpose(), sums.along);
    const double share = ShareOf(step), score = ScoreOf(step, d);
    if (!(score < best->score)) return false;
    best->score = score;
    best->cause = &cause;
    best->by = step.by;
    best->found.of = cause.of;
    best->found.index = cause.index;
    best->found.share = share;
    best->found.p_value = FSurvival(share / d / ((1.0 - share) / freedom), d, freedom);
    return true;
  }

  // Directions that what is estimated makes up for have moved nothing.
  static Step Explained(const Eigen::MatrixXd& own, const Eigen::MatrixXd& beside, const Eigen::VectorXd& along) {
    const Eigen::VectorXd scale = own.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
        Eigen::MatrixXd(scale.asDiagonal() * beside * scale.asDiagonal()));
    const Eigen::VectorXd gradient = eigen.eigenvectors().transpose() * (scale.asDiagonal() * along);
    Eigen::VectorXd step = Eigen::VectorXd::Zero(along.size());
    for (Eigen::Index i = 0; i < along.size(); ++i) {
      if (eigen.eigenvalues()[i] > kLeastOfItself) step[i] = -gradient[i] / eigen.eigenvalues()[i];
    }
    return {-gradient.dot(step), scale.asDiagonal() * (eigen.eigenvectors() * step)};
  }

  // RMS distance over the points after it.
  double Moved(const LikeliestBreak& best) const {
    const Eigen::VectorXd whitened = ColumnsOf(*best.cause) * best.by;
    double sum = 0.0;
    int count = 0;
    bool is_after = false;
    for (const int k : order_) {
      const int observation = rows_.observations[k];
      is_after = is_after || observation == best.found.first;
      const bool is_point = problem_.data().observations[observation].is_point();
      if (!is_after || !Concerns(*best.cause, k) || !is_point) continue;
      sum += (estimate_.scatter[observation] * whitened.segment<3>(3 * k)).squaredNorm();
      ++count;
    }
    return count > 0 ? std::sqrt(sum / count) : 0.0;
  }

  CalibrationProblem problem_;  // with deviations of every joint
  const Estimate& estimate_;
  std::vector<int> columns_;
  Linearization rows_;
  Eigen::MatrixXd basis_;     // orthonormal, of what is estimated
  Eigen::VectorXd residual_;  // given it
  double squares_ = 0.0;
  int num_configurations_ = 0;
  int num_states_ = 0;              // configurations, each load of one counted
  std::vector<std::string> loads_;  // that enough configurations have
  std::vector<int> order_;          // positions in rows_.observations
};

}  // namespace

std::optional<Break> FindBreak(const CalibrationProblem& problem, const Estimate& estimate) {
  if (estimate.scatter.size() != problem.data().observations.size()) return std::nullopt;
  return BreakSearch(problem, estimate).Run();
}

}  // namespace sagitta

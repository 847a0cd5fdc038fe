#include "estimator/diagnosis/outlier_rules.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <numeric>
#include <set>

#include "estimator/diagnosis/noise_check.h"
#include "estimator/explanations/drivers.h"
#include "estimator/noise/rigid_bodies.h"
#include "estimator/random_effects/evidence_score.h"
#include "estimator/statistics/distributions.h"
#include "models/effects/learnt_deviation.h"
#include "models/quantiles.h"

namespace sagitta {
namespace {

constexpr double kMedianOfOne = 0.4549, kMedianOfTwo = 1.3863;  // of chi-square with 1 and 2 degrees of freedom
constexpr double kOfTheWorst = 0.05;  // of its square: a fit gives its neighbours as much of it, by their leverage
constexpr double kAloneInShot = 4.0;  // times the squares of the other markers of the shot: twice as far off
// Times the limit, where no other marker decides: 1.7 times as far off as noise makes the worst row. A choice: what the
// arm does looks the same there.
constexpr double kSingleMarker = 3.0;
// The same where effects that were found say what the arm does: as kHeldOutScatter, what is uncertain in the model.
constexpr double kSingleGivenEffects = 1.5;
// The parameters' own uncertainty adds to the noise: of n equations with p unknowns p / n of its variance in the mean,
// half of it at n = 2 p, below which a caution says that few are fitted (cautions.cc).
constexpr double kHeldOutScatter = 1.5;
// What the arm or the instrument does and no model has moves more than a tenth of the rows, and more than two, by a
// fifth and more of what it moves one by: a square beyond 5^2 times what these exceed is one reading's own.
constexpr double kShareOfACause = 0.1;
constexpr double kBeyondOthers = 25.0;
// Of the rows. A choice, below the tenth that a cause moves and above the 2 % that the practice cases have.
constexpr double kMostOutliers = 0.06;
constexpr size_t kFewOutliers = 2;  // that a cause exceeds, however few rows there are
// Rows whose median says what they scatter by: that of n squares is known to 2.3 / sqrt(n) of itself, to a half here.
// Next to 20 fitted rows a hold-out of 30 % has 8.
constexpr size_t kFewestFitted = 20, kFewestHeldOut = 8;
// As a turn about the base, rad: ten times a joint's deviation, beyond which the evidence weighs no cause. A bump of a
// worn sector moves a few poses alone, too.
constexpr double kNoCause = kScales[std::size(kScales) - 1] * kTypicalTurn;

// An instrument scatters differently along its line of sight and across it, there in proportion to the range (angles)
// or not, or along the axes of its frame, and stated is often one figure for all. Each direction has its own factor,
// the median of the squares over that of chi-square with 1 or 2 degrees of freedom, at least 1 where sigma is stated. A
// point is far off only where it is by each of these descriptions.
struct DirectedScatter {
  double along = 1.0, across = 1.0, by_angle = 1.0;     // of the line of sight; by_angle: at the median range
  double range = 1.0;                                   // median, m
  Eigen::Array3d axes = Eigen::Array3d::Constant(1.0);  // of the station's frame

  double SquareOf(const Eigen::Vector3d& residual, const Eigen::Vector3d& place) const {
    const double at = place.norm(), own = at > 0.0 ? std::pow(residual.dot(place) / at, 2) : 0.0;
    const double other = residual.squaredNorm() - own, nearer = at > 0.0 ? std::pow(range / at, 2) : 1.0;
    return std::min({own / along + other / across, own / along + nearer * other / by_angle,
                     (residual.array().square() / axes).sum()});
  }
  double Most() const { return std::max({along, across, by_angle, axes.maxCoeff()}); }
};

constexpr double kLeastFactor = 1e-12;  // of readings that fit exactly: a millionth of the unit they are counted in

double Factor(const std::vector<double>& squares, double median, double least) {
  return squares.empty() ? 1.0 : std::max(least, Median(squares) / median);
}

DirectedScatter ScatterOf(const std::vector<ShotResidual>& shots, bool is_sigma_stated) {
  const double least = is_sigma_stated ? 1.0 : kLeastFactor;
  std::vector<double> along, across, by_angle, axes[3], ranges;
  for (const ShotResidual& shot : shots) {
    for (size_t i = 0; i < shot.observations.size(); ++i) {
      const Eigen::Vector3d residual = shot.residual.segment<3>(3 * i);
      for (int axis = 0; axis < 3; ++axis) axes[axis].push_back(residual[axis] * residual[axis]);
      const double at = shot.places[i].norm();
      if (!(at > 0.0)) continue;
      along.push_back(std::pow(residual.dot(shot.places[i]) / at, 2));
      across.push_back(residual.squaredNorm() - along.back());
      by_angle.push_back(across.back() / (at * at));
      ranges.push_back(at);
    }
  }
  DirectedScatter scatter;
  if (!ranges.empty()) scatter.range = Median(ranges);
  for (double& square : by_angle) square *= scatter.range * scatter.range;
  scatter.along = Factor(along, kMedianOfOne, least);
  scatter.across = Factor(across, kMedianOfTwo, least);
  scatter.by_angle = Factor(by_angle, kMedianOfTwo, least);
  for (int axis = 0; axis < 3; ++axis) scatter.axes[axis] = Factor(axes[axis], kMedianOfOne, least);
  return scatter;
}

// One point among those of its shot and body; squares over the scatter.
struct Misfit {
  int observation;
  size_t arrival;   // place of shot and body
  double squared;   // 3 degrees of freedom
  double others;    // mean of the other markers on the body; 0: there are none
  double least;     // of them
  double rigid;     // what the body's best motion leaves of all of them, over the larger scatter
  double freedom;   // of that; 0: points are too few
  double together;  // mean of all of them; 0: it is alone
  double turn;      // of the shot
};

std::vector<Misfit> MisfitsOf(const std::vector<ShotResidual>& shots, bool is_sigma_stated) {
  const DirectedScatter scatter = ScatterOf(shots, is_sigma_stated);
  std::vector<Misfit> misfits;
  for (const ShotResidual& shot : shots) {
    const size_t n = shot.observations.size();
    int dof = 0;
    const double rigid = WithoutRigidMotion(shot, &dof).squaredNorm() / scatter.Most();
    std::vector<double> squares;
    for (size_t i = 0; i < n; ++i) {
      squares.push_back(scatter.SquareOf(shot.residual.segment<3>(3 * i), shot.places[i]));
    }
    const double sum = std::accumulate(squares.begin(), squares.end(), 0.0);
    for (size_t i = 0; i < n; ++i) {
      const double others = n > 1 ? (sum - squares[i]) / static_cast<double>(n - 1) : 0.0;
      double least = others;
      for (size_t k = 0; k < n; ++k) {
        if (k != i) least = std::min(least, squares[k]);
      }
      misfits.push_back({shot.observations[i], static_cast<size_t>(&shot - shots.data()), squares[i], others, least,
                         rigid, static_cast<double>(std::max(0, dof)), n > 1 ? sum / static_cast<double>(n) : 0.0,
                         shot.turn});
    }
  }
  return misfits;
}

int ConfigurationOf(const CalibrationProblem& problem, const Misfit& misfit) {
  return problem.data().shots[problem.data().observations[misfit.observation].shot].configuration;
}

double Share(size_t some, size_t all) {
  return static_cast<double>(some) / static_cast<double>(std::max<size_t>(1, all));
}

// Of held-out rows, which have no say in what is found: as many as the share that is allowed has in one of twenty
// hold-outs of this size.
size_t FewHeldOut(size_t rows) {
  const double mean = kMostOutliers * static_cast<double>(rows);
  const double most = mean + NormalQuantile(0.95) * std::sqrt(mean * (1.0 - kMostOutliers));
  return std::max(kFewOutliers, static_cast<size_t>(most));
}

// Squares that are its own, given all others.
double BeyondOthers(std::vector<double> squares) {
  const auto of_a_cause = static_cast<size_t>(kShareOfACause * static_cast<double>(squares.size()));
  const size_t place = std::max(kFewOutliers, of_a_cause);
  if (place >= squares.size()) return std::numeric_limits<double>::infinity();
  std::nth_element(squares.begin(), squares.begin() + static_cast<long>(place), squares.end(), std::greater<>());
  return kBeyondOthers * squares[place];
}

// Whether a body's points are where no motion of it brings them, more than among n points comes about by chance.
// times: what all squares count as.
bool IsNotRigid(const Misfit& misfit, double times, double n, double significance) {
  return misfit.freedom > 0.0 && misfit.rigid > times * ChiSquareLimitOfMany(n, significance, misfit.freedom);
}

// The same of shots, each by all its points.
double BeyondOtherArrivals(const std::vector<Misfit>& misfits) {
  std::map<size_t, double> together;
  for (const Misfit& misfit : misfits) {
    if (misfit.together > 0.0) together[misfit.arrival] = misfit.together;
  }
  std::vector<double> squares;
  for (const auto& [arrival, square] : together) squares.push_back(square);
  return squares.size() < kFewestHeldOut ? std::numeric_limits<double>::infinity() : BeyondOthers(squares);
}

}  // namespace

// limit = chi^2_3(1 - significance / n) for squares over their scatter: among n points one without cause in
// 1 / significance experiments (Bonferroni).
std::vector<int> FindOutliers(const CalibrationProblem& problem, const ParameterSet& parameters,
                              const std::vector<int>& observations, const OutlierLevel& level) {
  const bool held_out = level.held_out;
  const std::vector<Misfit> misfits =
      MisfitsOf(ResidualsByShot(problem, parameters, observations), IsSigmaStated(problem));
  const Measurements& data = problem.data();
  const bool are_fitted = std::none_of(observations.begin(), observations.end(), [&](int i) {
    return data.configurations[data.shots[data.observations[i].shot].configuration].is_validation;
  });
  if (misfits.size() < (are_fitted ? kFewestFitted : kFewestHeldOut)) return {};
  const double n = static_cast<double>(misfits.size()), times = held_out ? kHeldOutScatter : 1.0;
  const double limit = times * ChiSquareLimitOfMany(n, level.significance, 3.0);
  const double alone_limit = (level.given_effects ? kSingleGivenEffects : kSingleMarker) * limit;
  std::vector<double> squares;
  for (const Misfit& misfit : misfits) squares.push_back(misfit.squared);
  // The worst first: they pull the fit, and the others with it.
  const double floor = std::max(limit, kOfTheWorst * *std::max_element(squares.begin(), squares.end()));
  const double beyond_others = BeyondOthers(squares), beyond_arrivals = BeyondOtherArrivals(misfits);
  std::vector<int> outliers;
  std::set<int> all_configurations, wrong;  // a wrong pose is one mistake
  size_t single = level.removed;
  for (const Misfit& misfit : misfits) {
    const bool alone = misfit.squared > (misfit.others > 0.0 ? kAloneInShot * misfit.others : alone_limit);
    // Two in one shot hide each other, but not that the body does not move like this.
    const bool is_no_motion = IsNotRigid(misfit, times, n, level.significance);
    const bool not_rigid = misfit.squared > kAloneInShot * misfit.least && is_no_motion;
    const bool is_its_own = !held_out || is_no_motion || misfit.squared > beyond_others;
    // Joint values that were not those, or a shot of another pose.
    const bool are_all_off = std::min(misfit.squared, misfit.least) > limit && misfit.turn > kNoCause;
    const bool is_arrival = !held_out && are_all_off && misfit.together > std::max(floor, beyond_arrivals);
    const int configuration = ConfigurationOf(problem, misfit);
    all_configurations.insert(configuration);
    const bool is_single = misfit.squared > floor && (alone || not_rigid) && is_its_own;
    if (is_arrival) wrong.insert(configuration);
    if (is_single && !is_arrival) ++single;
    if (is_single || is_arrival) outliers.push_back(misfit.observation);
  }
  // What happens to many points is no outlier but something to explain.
  const double share = Share(single, misfits.size() + level.removed) + Share(wrong.size(), all_configurations.size());
  const bool are_few = !are_fitted && single + wrong.size() <= FewHeldOut(misfits.size() + level.removed);
  return share <= kMostOutliers || are_few ? outliers : std::vector<int>();
}

std::vector<int> RowsOfTheWorst(const CalibrationProblem& problem, const ParameterSet& parameters,
                                double significance) {
  const std::vector<Misfit> misfits =
      MisfitsOf(ResidualsByShot(problem, parameters, problem.CalibrationObservations()), IsSigmaStated(problem));
  struct Worst {
    double excess = 0.0;
    std::vector<int> rows;
  };
  std::map<int, Worst> by_configuration;
  for (const Misfit& misfit : misfits) {
    Worst& own = by_configuration[ConfigurationOf(problem, misfit)];
    own.excess += misfit.squared - 3.0;  // degrees of freedom
    own.rows.push_back(misfit.observation);
  }
  std::vector<Worst> worst;
  double all = 0.0;
  for (const auto& [configuration, own] : by_configuration) {
    all += std::max(0.0, own.excess);
    worst.push_back(own);
  }
  std::sort(worst.begin(), worst.end(), [](const Worst& a, const Worst& b) { return a.excess > b.excess; });
  std::vector<int> rows;
  double seen = 0.0;
  size_t count = 0;
  for (; count < worst.size() && seen <= 0.5 * all; ++count) {
    seen += worst[count].excess;
    rows.insert(rows.end(), worst[count].rows.begin(), worst[count].rows.end());
  }
  // Each of them beyond what the scatter makes of the worst of so many.
  const auto is_by_chance = [&](const Worst& own) {
    const double dof = 3.0 * static_cast<double>(own.rows.size());
    return own.excess + dof < ChiSquareLimitOfMany(static_cast<double>(worst.size()), significance, dof);
  };
  const bool are_few = Share(count, worst.size()) <= kMostOutliers;
  return are_few && std::none_of(worst.begin(), worst.begin() + static_cast<long>(count), is_by_chance)
             ? rows
             : std::vector<int>();
}

std::vector<int> ExplainedOutliers(const CalibrationProblem& problem, const ParameterSet& parameters,
                                   const std::vector<int>& outliers, double significance) {
  std::vector<int> explained;
  if (outliers.empty()) return explained;
  const double n = static_cast<double>(problem.CalibrationObservations().size() + outliers.size());
  const double limit = ChiSquareLimitOfMany(n, significance, 3.0);
  const DirectedScatter scatter =
      ScatterOf(ResidualsByShot(problem, parameters, problem.CalibrationObservations()), IsSigmaStated(problem));
  for (const ShotResidual& shot : ResidualsByShot(problem, parameters, outliers)) {
    for (size_t i = 0; i < shot.observations.size(); ++i) {
      const Eigen::Vector3d residual = shot.residual.segment<3>(3 * i);
      if (scatter.SquareOf(residual, shot.places[i]) < limit) explained.push_back(shot.observations[i]);
    }
  }
  return explained;
}

}  // namespace sagitta

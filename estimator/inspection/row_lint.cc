#include "estimator/inspection/row_lint.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <map>
#include <set>

#include "estimator/inspection/tried_readings.h"
#include "estimator/least_squares/row_sums.h"
#include "models/quantiles.h"

namespace sagitta {
namespace {

constexpr int kReweightings = 12;    // a guard: kStands ends them
constexpr double kStands = 1e-4;     // of the scale: weights that move no point by more
constexpr double kHalfWeight = 1.5;  // median distances, 2.3 sigma: where a row's weight has fallen to a half
constexpr double kGross = 10.0;      // median distances; 15 sigma of normal noise
// Rows that stand alone are wild from half of that: of 20 to 1000 rows of normal noise none in 8000 draws is twice as
// far off as all others; where rows have Student's distribution with five degrees, in 3 % of the draws.
constexpr double kAloneAmongRows = 5.0;  // median distances
constexpr double kAloneBy = 2.0;         // times the farthest of the others
constexpr double kMostRowsAlone = 0.02;  // of the rows: all markers of a visit, or one
constexpr size_t kFewRows = 20;          // of fewer the median says little
// Of the squared residual when two markers are exchanged: as of any other reading.
constexpr double kSwapGain = kReadingImprovement * kReadingImprovement;

std::vector<double> ResidualLengths(const Eigen::Matrix3Xd& residuals) {
  std::vector<double> distances(residuals.cols());
  for (int k = 0; k < residuals.cols(); ++k) distances[k] = residuals.col(k).norm();
  return distances;
}

struct Swap {
  int first, second;  // positions
};

// Pairs of outlying rows of one shot that fit when exchanged.
std::vector<Swap> FindSwaps(const CalibrationProblem& problem, const Linearization& linearization,
                            const Eigen::Matrix3Xd& residuals, const std::vector<int>& outliers) {
  std::map<int, std::vector<int>> of_shot;
  for (const int k : outliers) {
    const Observation& row = problem.data().observations[linearization.observations[k]];
    if (row.is_point()) of_shot[row.shot].push_back(k);
  }
  const auto measured = [&](int k) -> Vector3<double> {
    return problem.data().observations[linearization.observations[k]].point_in_station;
  };
  const auto predicted = [&](int k) -> Vector3<double> { return measured(k) + residuals.col(k); };
  std::vector<Swap> swaps;
  std::set<int> taken;
  for (const auto& [shot, positions] : of_shot) {
    for (size_t a = 0; a < positions.size(); ++a) {
      for (size_t b = a + 1; b < positions.size(); ++b) {
        const int i = positions[a], j = positions[b];
        if (taken.count(i) + taken.count(j) > 0) continue;
        const double as_is = residuals.col(i).squaredNorm() + residuals.col(j).squaredNorm();
        const double exchanged =
            (predicted(i) - measured(j)).squaredNorm() + (predicted(j) - measured(i)).squaredNorm();
        if (exchanged * kSwapGain > as_is) continue;
        swaps.push_back({i, j});
        taken.insert({i, j});
      }
    }
  }
  return swaps;
}

Eigen::VectorXd WeightedStep(const Linearization& rows, const Eigen::VectorXd& root_weights) {
  if (AreMany(rows)) {
    const LinearSolution solution = SolveLinearization(Condense(SumRows(rows, &root_weights)));
    if (solution.full_rank) return solution.step;
  }
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(root_weights.asDiagonal() * rows.jacobian);
  return qr.solve(Eigen::VectorXd(-root_weights.cwiseProduct(rows.residual)));
}

}  // namespace

double TypicalDistance(std::vector<double> distances, int unknowns) {
  const auto passed = static_cast<size_t>((unknowns + 2) / 3);
  if (passed >= distances.size()) return std::numeric_limits<double>::infinity();
  const auto others = distances.begin() + static_cast<std::ptrdiff_t>(passed);
  std::nth_element(distances.begin(), others, distances.end());
  distances.erase(distances.begin(), others);
  return Median(distances);
}

Eigen::Matrix3Xd RobustLinearResiduals(const Linearization& linearization, const NoiseRoots& noise,
                                       Eigen::VectorXd* step) {
  const int n = static_cast<int>(linearization.observations.size());
  const auto residuals_of = [&](const Eigen::VectorXd& whitened) {
    Eigen::Matrix3Xd metres(3, n);  // rotations: rad, that is m over 1 m
    for (int k = 0; k < n; ++k) metres.col(k) = noise[k] * whitened.segment<3>(3 * k);
    return metres;
  };
  Eigen::Matrix3Xd residuals = residuals_of(linearization.residual);
  if (step != nullptr) step->setZero(linearization.num_columns());
  if (linearization.num_columns() == 0) return residuals;
  Eigen::VectorXd root_weights = Eigen::VectorXd::Ones(linearization.num_rows());
  for (int i = 0; i < kReweightings; ++i) {
    const Eigen::VectorXd moved = WeightedStep(linearization, root_weights);
    if (step != nullptr) *step = moved;
    const Eigen::Matrix3Xd before = residuals;
    residuals = residuals_of(linearization.residual + linearization.jacobian * moved);
    const std::vector<double> distances = ResidualLengths(residuals);
    const double scale = kHalfWeight * std::max(1e-12, TypicalDistance(distances, linearization.num_columns()));
    if (i > 0 && (residuals - before).cwiseAbs().maxCoeff() < kStands * scale) break;
    for (int k = 0; k < n; ++k) {
      const double ratio = distances[k] / scale;
      root_weights.segment<3>(3 * k).setConstant(1.0 / std::sqrt(1.0 + ratio * ratio));
    }
  }
  return residuals;
}

namespace {

// The distance of the nearest of those that stand alone; infinite where none does.
double NearestAlone(std::vector<double> distances, double median) {
  if (distances.size() < kFewRows) return std::numeric_limits<double>::infinity();
  const size_t most = std::max<size_t>(1, static_cast<size_t>(kMostRowsAlone * static_cast<double>(distances.size())));
  const auto sorted = distances.begin() + static_cast<std::ptrdiff_t>(most) + 1;
  std::partial_sort(distances.begin(), sorted, distances.end(), std::greater<>());
  for (size_t alone = most; alone > 0; --alone) {
    const double nearest = distances[alone - 1];
    if (nearest >= kAloneAmongRows * median && nearest >= kAloneBy * distances[alone]) return nearest;
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace

std::vector<int> GrossOutliers(const Eigen::Matrix3Xd& residuals, int unknowns) {
  const std::vector<double> distances = ResidualLengths(residuals);
  const double median = TypicalDistance(distances, unknowns);
  if (!std::isfinite(median)) return {};
  const double limit = std::min(kGross * median, NearestAlone(distances, median));
  std::vector<int> outliers;
  for (int k = 0; k < residuals.cols(); ++k) {
    if (distances[k] >= limit && distances[k] > 1e-9) outliers.push_back(k);
  }
  return outliers;
}

std::vector<Finding> LintRows(const CalibrationProblem& problem, const Linearization& linearization,
                              const Eigen::Matrix3Xd& residuals) {
  std::vector<Finding> findings;
  const int unknowns = linearization.num_columns();
  const std::vector<int> outliers = GrossOutliers(residuals, unknowns);
  if (outliers.empty()) return findings;
  const auto observation = [&](int k) -> const Observation& {
    return problem.data().observations[linearization.observations[k]];
  };
  const std::vector<Swap> swaps = FindSwaps(problem, linearization, residuals, outliers);
  std::set<int> swapped;
  std::vector<std::string> exchanged_rows;
  std::set<std::string> pairs;
  for (const Swap& swap : swaps) {
    for (const int k : {swap.first, swap.second}) {
      swapped.insert(k);
      exchanged_rows.push_back(problem.data().SourceOf(observation(k)));
    }
    pairs.insert(problem.data().markers[observation(swap.first).marker] + " and " +
                 problem.data().markers[observation(swap.second).marker]);
  }
  if (!swaps.empty()) {
    findings.push_back(Found(Severity::kSerious, "marker_swap",
                             MarkersAreExchanged(swaps.size(), pairs.size(), *pairs.begin()), exchanged_rows));
  }
  std::vector<std::string> gross_rows;
  double least = 0.0, most = 0.0;
  for (const int k : outliers) {
    if (swapped.count(k) > 0) continue;
    const double distance = residuals.col(k).norm();
    least = gross_rows.empty() ? distance : std::min(least, distance);
    most = std::max(most, distance);
    gross_rows.push_back(problem.data().SourceOf(observation(k)));
  }
  if (gross_rows.empty()) return findings;
  const Advice advice =
      RowsAreOff(gross_rows.size(), least, most, TypicalDistance(ResidualLengths(residuals), unknowns));
  findings.push_back(Found(Severity::kSerious, "outliers", advice, gross_rows));
  return findings;
}

}  // namespace sagitta

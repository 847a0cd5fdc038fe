#include "estimator/intervals/redraw.h"

#include <numeric>

#include "estimator/least_squares/linearization.h"
#include "estimator/least_squares/spring_tie_cost.h"
#include "models/matrix_functions.h"
#include "models/random_bits.h"
#include "problems/simulation.h"

namespace sagitta {

std::uint64_t SeedOf(std::uint64_t seed, std::uint64_t i) {
  // Neighbouring numbers i give unrelated seeds. Seeds go by a multiplier of Steele and Vigna (2022).
  return MixedBits(seed * 0xD1342543DE82EF95ULL + (i + 1) * kGoldenBits);
}

void DrawPriors(const ParameterSet& truth, std::uint64_t seed, ParameterSet* parameters) {
  NormalNumbers normal(seed);
  for (int i = 0; i < parameters->num_coordinates(); ++i) {
    Coordinate& coordinate = parameters->coordinate(i);
    if (coordinate.has_prior()) coordinate.prior_value = truth.Value(i) + coordinate.prior_sigma * normal();
  }
}

ParameterSet DrawTruth(const ParameterSet& truth, std::uint64_t seed) {
  constexpr double kStep = 1e-6;  // m
  constexpr int kRounds = 3;      // the anchors' geometry bends by 1e-4 of a marker's 0.2 mm
  ParameterSet drawn = truth;
  if (!truth.spring_tie()) return drawn;
  const SpringTie& tie = *truth.spring_tie();
  NormalNumbers normal(seed);
  Eigen::Vector3d off;
  for (double& number : off) number = normal();
  off = LowerRoot(tie.covariance) * off;
  const int markers[2] = {tie.lever_marker, tie.anchor_marker};
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::Vector3d misfit = SpringTieMisfit(drawn);
    Eigen::MatrixXd slopes(3, 6);
    for (int i = 0; i < 6; ++i) {
      ParameterSet moved = drawn;
      moved.SetMarkerPoint(markers[i / 3], drawn.MarkerPoint(markers[i / 3]) + kStep * Vector3<double>::Unit(i % 3));
      slopes.col(i) = (SpringTieMisfit(moved) - misfit) / kStep;
    }
    // The least move of the two markers whose tie reads `off`: three equations, six coordinates (minimum norm).
    const Eigen::VectorXd gap = off - misfit;
    const Eigen::MatrixXd squares = slopes * slopes.transpose();
    const Eigen::VectorXd step = slopes.transpose() * squares.llt().solve(gap).eval();
    for (int m = 0; m < 2; ++m) {
      drawn.SetMarkerPoint(markers[m], drawn.MarkerPoint(markers[m]) + step.segment<3>(3 * m));
    }
  }
  return drawn;
}

Simulator RedrawAt(const CalibrationProblem& problem, const ParameterSet& truth, double noise_scale, double fallback) {
  std::vector<int> all(problem.data().observations.size());
  std::iota(all.begin(), all.end(), 0);
  NoiseRoots roots = ObservationNoise(problem, all, fallback);
  for (Matrix3<double>& root : roots) root *= noise_scale;
  return Simulator(problem, truth, std::move(roots), noise_scale);
}

}  // namespace sagitta

// `weights: equal` and `weights: eq14`: the estimate is made with the weights and judged by the noise.
#include "estimator/noise/weighting.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "estimator/calibration/noise_loop.h"
#include "estimator/intervals/coverage.h"
#include "estimator/statistics/distributions.h"
#include "tests/support/noise_experiment.h"

namespace sagitta::weighting_test {
namespace {

// Rows of three qualities, 9 to 1, differing by axis and configuration: no equal weights would be right.
void StateUnequalSigmas(Measurements* data) {
  for (size_t i = 0; i < data->observations.size(); ++i) {
    const int turn = data->shots[data->observations[i].shot].configuration % 3;
    for (int a = 0; a < 3; ++a) data->observations[i].sigma[a] = 2e-5 * std::pow(3.0, (turn + a) % 3);
  }
}

Measurements Unequal(std::uint64_t seed) {
  test::Kr270Design design;
  design.configurations = 24;
  Measurements data = test::DesignMeasurements(design);
  StateUnequalSigmas(&data);
  test::MeasureKr270(test::Kr270Truth(), 0.0, 1, &data);
  NormalNumbers normal(seed);
  for (Observation& observation : data.observations) {
    for (int a = 0; a < 3; ++a) observation.point_in_station[a] += observation.sigma[a] * normal();
  }
  return data;
}

Experiment With(const std::string& weights) {
  Experiment experiment;
  experiment.method.weights = *FindChoice<Weights>(weights);
  return experiment;
}

// Columns in metres at the estimate, scaled to unit norm; what it was scaled by.
Eigen::MatrixXd RawColumns(const ResolvedEstimate& result, Eigen::VectorXd* scale) {
  const std::vector<int> rows = result.problem.CalibrationObservations();
  const NoiseRoots metres(rows.size(), Matrix3<double>::Identity());
  const Eigen::MatrixXd raw =
      Linearize(result.problem, result.estimate.parameters, rows, result.estimate.estimated, metres).jacobian;
  *scale = raw.colwise().norm().cwiseInverse();
  return raw * scale->asDiagonal();
}

// The values are those of a fit that knows of no sigmas; the covariance is eq. (8) written out.
TEST(Weighting, EqualWeightsAreOrdinaryLeastSquaresWithEquationEight) {
  const Measurements data = Unequal(7);
  const ResolvedEstimate equal = EstimateWithNoise(test::Kr270ProblemOf(data, With("equal")));
  ASSERT_EQ(equal.estimate.status, Status::kConverged) << equal.estimate.message;
  Measurements blind = data;
  for (Observation& observation : blind.observations) observation.sigma.setConstant(7e-5);
  const Estimate plain = EstimateWithNoise(test::Kr270ProblemOf(blind, Experiment())).estimate;
  const Estimate sigma = EstimateWithNoise(test::Kr270ProblemOf(data, Experiment())).estimate;
  double farthest = 0.0;
  for (int i = 0; i < plain.parameters.num_coordinates(); ++i) {
    EXPECT_NEAR(equal.estimate.parameters.Value(i), plain.parameters.Value(i), 1e-4 * equal.estimate.table[i].sigma)
        << equal.estimate.table[i].name;
    farthest = std::max(
        farthest, std::abs(sigma.parameters.Value(i) - plain.parameters.Value(i)) / equal.estimate.table[i].sigma);
  }
  EXPECT_GT(farthest, 0.5);  // weighing by sigma is another estimate

  Eigen::VectorXd scale;
  const Eigen::MatrixXd b = RawColumns(equal, &scale);
  Eigen::VectorXd s(b.rows());
  for (int i = 0; i < s.size(); ++i) s[i] = data.observations[i / 3].sigma[i % 3];
  const Eigen::MatrixXd half = s.asDiagonal() * b * (b.transpose() * b).inverse();
  const Eigen::MatrixXd expected = scale.asDiagonal() * half.transpose() * half * scale.asDiagonal();
  ASSERT_FALSE(equal.estimate.sigma.scaled);
  for (int c = 0; c < expected.rows(); ++c) {
    EXPECT_NEAR(equal.estimate.covariance(c, c), expected(c, c), 1e-6 * expected(c, c));
    EXPECT_GE(equal.estimate.covariance(c, c), (1 - 1e-6) * sigma.covariance(c, c));  // Gauss and Markov
  }
}

// Known correlated noise, a tracker's: S has 3 x 3 blocks.
TEST(Weighting, EqualWeightsCountAnInstrumentsCovariance) {
  const test::TrackerTruth tracker;
  test::Kr270Design design;
  Measurements data = test::DesignMeasurements(design);
  for (Observation& observation : data.observations) observation.sigma.setZero();
  test::MeasureByTracker(test::Kr270Truth(), tracker, 5, &data);
  Experiment experiment = test::TrackerExperiment(tracker);
  experiment.method.weights = Weights::kEqual;
  const ResolvedEstimate result = EstimateWithNoise(test::Kr270ProblemOf(data, experiment));
  ASSERT_EQ(result.estimate.status, Status::kConverged) << result.estimate.message;
  ASSERT_FALSE(result.estimate.sigma.scaled);
  Eigen::VectorXd scale;
  const Eigen::MatrixXd b = RawColumns(result, &scale);
  Eigen::MatrixXd middle = Eigen::MatrixXd::Zero(b.cols(), b.cols());
  for (int k = 0; k < b.rows() / 3; ++k) {
    const Matrix3<double> root = result.problem.SqrtCovariance(k);
    middle += b.middleRows(3 * k, 3).transpose() * root * root.transpose() * b.middleRows(3 * k, 3);
  }
  const Eigen::MatrixXd inverse = (b.transpose() * b).inverse();
  const Eigen::MatrixXd expected = scale.asDiagonal() * inverse * middle * inverse * scale.asDiagonal();
  for (int c = 0; c < expected.rows(); ++c) {
    EXPECT_NEAR(result.estimate.covariance(c, c), expected(c, c), 1e-6 * expected(c, c));
  }
}

// Claimed and actual: 60 draws; the misfit test keeps its level although the weights are not those of the noise.
TEST(Weighting, ClaimsAreWhatDrawsShow) {
  constexpr int kDraws = 60;
  for (const char* weights : {"equal", "eq14", "sigma"}) {
    test::IntervalTally tally;
    std::vector<double> shares;
    double chi2 = 0.0, squares = 0.0;
    int dof = 0, coordinates = 0;
    for (int t = 0; t < kDraws; ++t) {
      const Estimate estimate = EstimateWithNoise(test::Kr270ProblemOf(Unequal(300 + t), With(weights))).estimate;
      ASSERT_EQ(estimate.status, Status::kConverged) << estimate.message;
      test::IntervalTally one;
      one.Add(estimate, test::Kr270Truth());
      shares.push_back(one.Coverage());
      chi2 += estimate.chi2;
      dof += estimate.dof;
      for (const int i : estimate.estimated) {
        squares += std::pow(test::NoiseErrorOf(estimate, test::Kr270Truth(), i) / estimate.table[i].sigma, 2);
        ++coordinates;
      }
    }
    double mean = 0.0, variance = 0.0;
    for (const double share : shares) mean += share / kDraws;
    for (const double share : shares) variance += std::pow(share - mean, 2) / (kDraws - 1.0);
    EXPECT_NEAR(mean, 0.95, 4 * std::sqrt(variance / kDraws)) << weights;
    EXPECT_LT(std::sqrt(variance / kDraws), 0.01);  // the test has power
    EXPECT_NEAR(chi2, dof, 4.5 * std::sqrt(2.0 * dof)) << weights;
    // Mean square of error over claim is 1; 39 parameters of a draw move together at worst.
    EXPECT_NEAR(squares / coordinates, 1.0, 4.5 * std::sqrt(2.0 / kDraws)) << weights;
  }
}

// The residuals' own spread with equal weights: eq. (8) with sigmas of groups.
TEST(Weighting, EqualWeightsTakeTheSpreadOfResiduals) {
  Experiment experiment = With("equal");
  experiment.noise.from = NoiseSpec::From::kResiduals;
  experiment.noise.group = ResidualGroup::kAxis;
  const Measurements data = Unequal(11);
  const ResolvedEstimate spread = EstimateWithNoise(test::Kr270ProblemOf(data, experiment));
  const ResolvedEstimate known = EstimateWithNoise(test::Kr270ProblemOf(data, With("equal")));
  ASSERT_EQ(spread.estimate.status, Status::kConverged) << spread.estimate.message;
  for (int i = 0; i < known.estimate.parameters.num_coordinates(); ++i) {
    const ParameterEstimate& row = known.estimate.table[i];
    EXPECT_NEAR(spread.estimate.parameters.Value(i), row.value, 1e-4 * row.sigma) << row.name;
    EXPECT_NEAR(std::log(spread.estimate.table[i].sigma / row.sigma), 0.0, 0.7) << row.name;
  }
  EXPECT_EQ(spread.estimate.noise_report.groups.size(), 3u);
}

TEST(Weighting, AlikeRootsNeedNoOtherWeights) {
  test::Kr270Design design;
  EXPECT_FALSE(WeighsOtherwise(test::Kr270Problem(design, test::Kr270Truth(), 1)));
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(test::Kr270Truth(), design.sigma, 1, &data);
  EXPECT_FALSE(WeighsOtherwise(test::Kr270ProblemOf(data, With("equal"))));
  StateUnequalSigmas(&data);
  EXPECT_TRUE(WeighsOtherwise(test::Kr270ProblemOf(data, With("equal"))));
  EXPECT_FALSE(WeighsOtherwise(test::Kr270ProblemOf(data, With("sigma"))));
}

// What `sagitta coverage` says of the loss: RMSE over the Cramer-Rao bound of the noise, as the covariances predict.
TEST(Weighting, EfficiencyIsAgainstTheBoundOfTheNoise) {
  const Measurements data = Unequal(3);
  const ResolvedEstimate equal = EstimateWithNoise(test::Kr270ProblemOf(data, With("equal")));
  const Estimate sigma = EstimateWithNoise(test::Kr270ProblemOf(data, Experiment())).estimate;
  const CoverageStudy study(equal.problem, equal.estimate, Method::kJoint, 1);
  const std::vector<CoverageRow> rows = study.Summarise({});
  ASSERT_EQ(rows.size(), static_cast<size_t>(sigma.covariance.rows()));
  for (size_t c = 0; c < rows.size(); ++c) {
    EXPECT_NEAR(rows[c].cramer_rao, std::sqrt(sigma.covariance(c, c)), 1e-3 * rows[c].cramer_rao) << rows[c].name;
  }
}

}  // namespace
}  // namespace sagitta::weighting_test

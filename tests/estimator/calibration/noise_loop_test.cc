#include "estimator/calibration/noise_loop.h"

#include <gtest/gtest.h>

#include "estimator/least_squares/linearization.h"
#include "estimator/statistics/distributions.h"
#include "tests/support/noise_experiment.h"

namespace sagitta::noise_loop_test {
namespace {

// Share of intervals that hold the truth in each trial; trials are independent, parameters are not.
struct Coverage {
  std::vector<double> shares;

  void Add(const Estimate& estimate, const test::Kr270Truth& truth) {
    ASSERT_EQ(estimate.status, Status::kConverged) << estimate.message;
    test::IntervalTally one;
    one.Add(estimate, truth);
    shares.push_back(one.Coverage());
  }
  double Mean() const {
    double sum = 0.0;
    for (const double share : shares) sum += share;
    return sum / static_cast<double>(shares.size());
  }
  double Error() const {
    double squares = 0.0;
    for (const double share : shares) squares += (share - Mean()) * (share - Mean());
    return std::sqrt(squares) / static_cast<double>(shares.size());
  }
};

// One visit each, 30 um per coordinate, as stated.
Measurements SixtyConfigurations(std::uint64_t seed) {
  test::Kr270Design design;
  design.configurations = 60;
  design.sigma = 3e-5;
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(test::Kr270Truth(), design.sigma, seed, &data);
  return data;
}

// Short form of sagitta_noise_study: 24 draws, REML, both kinds of repeats.
TEST(NoiseLoop, IntervalsHoldWithVarianceComponentsUnknown) {
  for (const bool reapproached : {false, true}) {
    const test::Kr270Truth truth;
    test::RepeatDesign design;
    design.repeats = 4;
    design.reapproached = reapproached;
    Measurements data = test::RepeatRows(design);
    Experiment unknown, independent;
    unknown.noise.from = NoiseSpec::From::kVarianceComponents;
    independent.method.weights = Weights::kEqual;
    Coverage ours, naive;
    for (int t = 0; t < 24; ++t) {
      test::MeasureRepeated(truth, design, 5000 + t, &data);
      const ResolvedEstimate result = EstimateWithNoise(test::Kr270ProblemOf(data, unknown));
      ours.Add(result.estimate, truth);
      EXPECT_TRUE(result.estimate.noise_report.converged);
      EXPECT_GT(result.estimate.noise_report.robot_rms, 4 * result.estimate.noise_report.instrument_rms);
      naive.Add(EstimateWithNoise(test::Kr270ProblemOf(data, independent)).estimate, truth);
    }
    EXPECT_NEAR(ours.Mean(), 0.95, 4 * ours.Error());
    EXPECT_LT(ours.Error(), 0.02);  // the test has power
    EXPECT_LT(naive.Mean(), ours.Mean() - 4 * (ours.Error() + naive.Error()));
  }
}

TEST(NoiseLoop, TrackerResidualsAreStandardNormalAndIntervalsHold) {
  const test::Kr270Truth truth;
  const test::TrackerTruth tracker;
  test::Kr270Design design;
  design.configurations = 30;
  Measurements data = test::DesignMeasurements(design);
  for (Observation& observation : data.observations) observation.sigma.setZero();
  Coverage coverage;
  std::vector<double> whitened;
  for (int t = 0; t < 12; ++t) {
    test::MeasureByTracker(truth, tracker, 100 + t, &data);
    const CalibrationProblem problem = test::Kr270ProblemOf(data, test::TrackerExperiment(tracker));
    coverage.Add(EstimateWithNoise(problem).estimate, truth);
    test::AppendWhitenedErrors(truth, problem, &whitened);
  }
  EXPECT_GT(KolmogorovSurvival(test::KolmogorovDistance(whitened), static_cast<double>(whitened.size())), 1e-3);
  for (double& u : whitened) u *= 1.2;  // a sigma off by a fifth would be seen
  EXPECT_LT(KolmogorovSurvival(test::KolmogorovDistance(whitened), static_cast<double>(whitened.size())), 1e-3);
  EXPECT_NEAR(coverage.Mean(), 0.95, 4 * coverage.Error());
}

TEST(NoiseLoop, GrossErrorsAreFoundAndDoNotMatter) {
  for (const char* loss : {"huber", "cauchy"}) {
    const test::Kr270Truth truth;
    test::Kr270Design design;
    design.configurations = 40;
    design.sigma = 3e-5;
    Measurements data = test::DesignMeasurements(design);
    Experiment robust;
    robust.method.loss = *FindChoice<LossKind>(loss);
    test::FlagTally flags;
    double squares = 0.0, clean_squares = 0.0;
    for (int t = 0; t < 8; ++t) {
      test::MeasureKr270(truth, design.sigma, 40 + t, &data);
      const Estimate clean = EstimateWithNoise(test::Kr270ProblemOf(data, Experiment())).estimate;
      const std::set<int> rows = test::Spoil(0.05, 900 + t, &data);
      const Estimate estimate = EstimateWithNoise(test::Kr270ProblemOf(data, robust)).estimate;
      ASSERT_EQ(estimate.status, Status::kConverged) << estimate.message;
      EXPECT_TRUE(estimate.noise_report.converged);
      flags.Add(estimate, rows);
      for (int i = 0; i < estimate.parameters.num_coordinates(); ++i) {
        squares += std::pow(test::NoiseErrorOf(estimate, truth, i) / clean.table[i].sigma, 2);
        clean_squares += std::pow(test::NoiseErrorOf(clean, truth, i) / clean.table[i].sigma, 2);
      }
    }
    EXPECT_GE(flags.Precision(), 0.95) << loss;
    EXPECT_GE(flags.Recall(), 0.95) << loss;
    EXPECT_EQ(flags.systematic, 0) << loss;
    EXPECT_GE(flags.exchanged, 8 * 2) << loss;  // every draw exchanges some
    EXPECT_LT(std::sqrt(squares / clean_squares), 1.1) << loss;
  }
}

// Rows beyond a joint angle are off by a millimetre in one direction: a misfit, no outliers.
TEST(NoiseLoop, MisfitIsNotThrownOut) {
  Measurements data = SixtyConfigurations(8);
  int moved = 0;
  for (Observation& observation : data.observations) {
    if (data.ConfigurationOf(observation).q[2] < 105 * kDegree) continue;
    observation.point_in_station += Vector3<double>(3e-3, 0, 0);
    ++moved;
  }
  ASSERT_GE(moved, 9);
  Experiment robust;
  robust.method.loss = LossKind::kCauchy;
  const ResolvedEstimate result = EstimateWithNoise(test::Kr270ProblemOf(data, robust));
  ASSERT_TRUE(IsUsable(result.estimate.status));
  const NoiseReport& report = result.estimate.noise_report;
  EXPECT_GE(static_cast<int>(report.outliers.size()), moved / 2);
  EXPECT_TRUE(report.systematic);
  std::string shared;
  for (const std::string& words : report.shared) shared += words;
  EXPECT_NE(shared.find("joint A3"), std::string::npos) << shared;
  EXPECT_EQ(result.problem.CalibrationObservations().size(), data.observations.size());  // nothing is left out
  EXPECT_TRUE(result.estimate.sigma.scaled);
}

// Two kinds of rows, eq. (14) on their residuals finds both spreads.
TEST(NoiseLoop, SpreadOfResidualsFindsTheGroups) {
  const test::Kr270Truth truth;
  test::Kr270Design design;
  design.configurations = 60;
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(truth, 0.0, 1, &data);
  NormalNumbers normal(17);
  const Vector3<double> sigma(2e-5, 6e-5, 1.8e-4);
  for (Observation& observation : data.observations) {
    for (int a = 0; a < 3; ++a) observation.point_in_station[a] += sigma[a] * normal();
    observation.sigma.setZero();
  }
  Experiment experiment;
  experiment.noise.from = NoiseSpec::From::kResiduals;
  experiment.noise.group = ResidualGroup::kAxis;
  experiment.noise.sigma0 = 1e-6;
  const ResolvedEstimate result = EstimateWithNoise(test::Kr270ProblemOf(data, experiment));
  ASSERT_EQ(result.estimate.status, Status::kConverged);
  ASSERT_EQ(result.estimate.noise_report.groups.size(), 3u);
  for (int a = 0; a < 3; ++a) {
    // 180 rows less a third of 39 unknowns: 167 degrees of freedom, four standard errors.
    EXPECT_NEAR(result.estimate.noise_report.groups[a].sigma, sigma[a], 4 * sigma[a] / std::sqrt(2 * 167.0)) << a;
  }
}

// Three rows share a spread, which is found from these same rows: their weights follow the estimate. Known weights
// would make intervals of two thirds of the length. Over 30 campaigns the mean square of (estimate - truth) / sigma, of
// 18 errors each, is 1 within 4 sqrt(2 / (30 * 18)) if they were independent; what few rows leave open makes it less.
TEST(NoiseLoop, IntervalsAllowForWeightsThatFollowTheResiduals) {
  const test::Kr270Truth truth;
  double sum = 0.0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    test::Kr270Design design;
    design.configurations = 30;
    design.stations = 1;
    design.seed = 900 + seed;
    Measurements data = test::DesignMeasurements(design);
    test::MeasureKr270(truth, 5e-5, seed, &data);
    for (Observation& observation : data.observations) observation.sigma.setZero();
    Experiment experiment;
    experiment.noise.from = NoiseSpec::From::kResiduals;
    const Estimate estimate = EstimateWithNoise(test::Kr270ProblemOf(data, experiment)).estimate;
    ASSERT_TRUE(IsUsable(estimate.status)) << estimate.message;
    for (size_t e = 0; e < truth.errors.size(); ++e) {
      const std::string name = "geometry/" + test::Kr270Errors()[e];
      for (const ParameterEstimate& row : estimate.table) {
        if (row.name != name || !(row.sigma > 0.0)) continue;
        sum += std::pow((row.value - truth.errors[e]) / row.sigma, 2);
        ++count;
      }
    }
  }
  ASSERT_EQ(count, 30 * 18);
  EXPECT_LT(sum / count, 1.0 + 4.0 * std::sqrt(2.0 / count));
  EXPECT_GT(sum / count, 0.3);
}

// weights: eq14 with stated sigmas; the covariance is eq. (11) written out.
TEST(NoiseLoop, Eq14CovarianceIsEquationEleven) {
  const test::Kr270Truth truth;
  test::Kr270Design design;
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(truth, 0.0, 1, &data);
  NormalNumbers normal(18);
  for (Observation& observation : data.observations) {
    observation.sigma = Vector3<double>(2e-5, 6e-5, 1.8e-4);
    for (int a = 0; a < 3; ++a) observation.point_in_station[a] += observation.sigma[a] * normal();
  }
  Experiment experiment;
  experiment.method.weights = Weights::kEq14;
  const ResolvedEstimate result = EstimateWithNoise(test::Kr270ProblemOf(data, experiment));
  ASSERT_EQ(result.estimate.status, Status::kConverged);
  ASSERT_FALSE(result.estimate.sigma.scaled);
  const std::vector<int> rows = result.problem.CalibrationObservations();
  const NoiseRoots metres(rows.size(), Matrix3<double>::Identity());
  const Linearization raw =
      Linearize(result.problem, result.estimate.parameters, rows, result.estimate.estimated, metres);
  Eigen::VectorXd w(raw.num_rows()), s(raw.num_rows());
  for (int i = 0; i < s.size(); ++i) {
    s[i] = data.observations[i / 3].sigma[i % 3];
    w[i] = 1e-5 / (1e-5 + s[i]);
  }
  const Eigen::MatrixXd scale = raw.jacobian.colwise().norm().cwiseInverse().asDiagonal();
  const Eigen::MatrixXd b = w.asDiagonal() * raw.jacobian * scale;
  const Eigen::MatrixXd inverse = (b.transpose() * b).inverse();
  const Eigen::MatrixXd half = (w.cwiseProduct(s)).asDiagonal() * b * inverse;
  const Eigen::MatrixXd expected = scale * half.transpose() * half * scale;
  for (int c = 0; c < expected.rows(); ++c) {
    EXPECT_NEAR(result.estimate.covariance(c, c), expected(c, c), 1e-6 * expected(c, c));
  }
}

// Eq. (14) whitens by sigma0 + lambda sigma; a hold-out row scatters by sigma all the same.
TEST(NoiseLoop, HoldOutIsPredictedByTheNoiseAndNotByTheWeights) {
  const Measurements data = SixtyConfigurations(41);
  Experiment experiment;
  experiment.noise.from = NoiseSpec::From::kResiduals;
  experiment.noise.group = ResidualGroup::kAxis;
  experiment.noise.sigma0 = 6e-5;  // twice the noise: whitened by three times
  experiment.validation.kind = ValidationSpec::Kind::kFraction;
  experiment.validation.fraction = 0.5;
  const Estimate estimate = EstimateWithNoise(test::Kr270ProblemOf(data, experiment)).estimate;
  ASSERT_TRUE(IsUsable(estimate.status)) << estimate.message;
  ASSERT_EQ(estimate.validation.observations, 90);
  // 270 coordinates observed, 231 degrees of freedom behind the prediction.
  EXPECT_NEAR(estimate.validation.rms / estimate.validation_predicted_rms, 1.0, 4 * std::sqrt(0.5 / 270 + 0.5 / 231));
}

}  // namespace
}  // namespace sagitta::noise_loop_test

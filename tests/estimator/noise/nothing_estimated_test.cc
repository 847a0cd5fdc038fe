// Nothing can be determined of anything: rows without columns everywhere. That ends in words, and no matrix is reached
// into that has no memory (which the sanitizers see).
#include <gtest/gtest.h>

#include <cmath>

#include "estimator/noise/variance_components.h"
#include "estimator/noise/weighting.h"
#include "estimator/sagitta.h"
#include "tests/support/kr270_experiment.h"

namespace sagitta::nothing_estimated_test {
namespace {

// Base poses and markers are stated as they are, the geometry is to be estimated from points that scatter by `sigma`.
CalibrationProblem Scattered(double sigma, const Experiment& wanted) {
  const test::Kr270Truth truth;
  test::Kr270Design design;
  design.sigma = sigma;
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(truth, sigma, 11, &data);
  Experiment experiment = wanted;
  experiment.estimate.base = experiment.estimate.markers = false;
  for (int s = 0; s < 2; ++s) {
    StationSpec& station = experiment.stations["S" + std::to_string(s + 1)];
    station.base_xyz = truth.base_xyz[static_cast<size_t>(s)];
    station.base_rotvec = truth.base_rotvec[static_cast<size_t>(s)];
  }
  for (int m = 0; m < 3; ++m) {
    experiment.markers["P" + std::to_string(m + 1)].point = truth.tools[static_cast<size_t>(m)];
  }
  return test::Kr270ProblemOf(data, experiment);
}

void ExpectWords(const Experiment& experiment, const std::string& what) {
  SCOPED_TRACE(what);
  const Calibration result = Calibrate(Scattered(9.0, experiment));
  EXPECT_FALSE(IsUsable(result.estimate.status));
  EXPECT_NE(result.estimate.message.find("every unknown had to be held"), std::string::npos) << result.estimate.message;
}

TEST(NothingEstimated, IsSaidWhateverTheNoiseIsFoundBy) {
  ExpectWords(Experiment(), "as stated");
  for (const std::string weights : {"equal", "eq14"}) {
    Experiment experiment;
    experiment.method.weights = *FindChoice<Weights>(weights);
    ExpectWords(experiment, weights);
  }
  for (const NoiseSpec::From from : {NoiseSpec::From::kResiduals, NoiseSpec::From::kVarianceComponents}) {
    Experiment experiment;
    experiment.noise.from = from;
    ExpectWords(experiment, "noise " + std::to_string(static_cast<int>(from)));
  }
  for (const std::string covariance : {"sandwich", "bootstrap", "profile"}) {
    Experiment experiment;
    experiment.method.covariance = *FindChoice<CovarianceKind>(covariance);
    experiment.method.bootstrap.replicates = 99;
    ExpectWords(experiment, covariance);
  }
  for (const std::string loss : {"huber", "cauchy"}) {
    Experiment experiment;
    experiment.method.loss = *FindChoice<LossKind>(loss);
    ExpectWords(experiment, loss);
  }
}

// Without columns the restricted likelihood is the likelihood: n rows of one variance a have n log a + r'r / a.
TEST(NothingEstimated, VarianceComponentsAreThoseOfTheRows) {
  constexpr double kSigma = 1e-4;  // m
  const CalibrationProblem problem = Scattered(kSigma, Experiment());
  ParameterSet held = problem.parameters;
  for (int i = 0; i < held.num_coordinates(); ++i) held.coordinate(i).held = true;
  ASSERT_TRUE(held.EstimatedCoordinates().empty());
  const RestrictedLikelihood likelihood(problem, held);
  const std::vector<int> rows = problem.CalibrationObservations();
  const Eigen::Matrix3Xd predicted = PredictPoints(problem, held, rows);
  double square = 0.0;
  for (size_t k = 0; k < rows.size(); ++k) {
    const Observation& row = problem.data().observations[static_cast<size_t>(rows[k])];
    square += (row.point_in_station - predicted.col(static_cast<long>(k))).squaredNorm() / (kSigma * kSigma);
  }
  const double n = 3.0 * static_cast<double>(rows.size());
  EXPECT_EQ(likelihood.dof(), static_cast<int>(n));
  const RemlFit fit = likelihood.Maximise(true, {});
  EXPECT_NEAR(fit.variances[0], square / n, 1e-6 * square / n);
  EXPECT_NEAR(likelihood.Deviance(2.0, {}) - likelihood.Deviance(1.0, {}), n * std::log(2.0) - 0.5 * square,
              1e-9 * square);
  EXPECT_EQ(CovarianceOfWeighted(problem, held, {}).size(), 0);
}

}  // namespace
}  // namespace sagitta::nothing_estimated_test

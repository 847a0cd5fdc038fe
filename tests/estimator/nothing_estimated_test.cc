// Everything is known: rows without columns everywhere. The figures that need no columns are those of the residuals,
// and no matrix is reached into that has no memory (the sanitizers' gate runs this too).
#include <gtest/gtest.h>

#include <cmath>

#include "estimator/noise/variance_components.h"
#include "estimator/noise/weighting.h"
#include "estimator/sagitta.h"
#include "tests/support/kr270_experiment.h"

namespace sagitta {
namespace {

constexpr double kSigma = 1e-4;  // m

// The truth's base poses and markers are stated, its geometry is the nominal one; a third is held out.
CalibrationProblem Known(const Experiment& wanted) {
  test::Kr270Truth truth;
  truth.errors.fill(0.0);
  test::Kr270Design design;
  design.sigma = kSigma;
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(truth, kSigma, 11, &data);
  Experiment experiment = wanted;
  experiment.estimate.base = experiment.estimate.markers = false;
  experiment.estimate.geometry.kind = Selection::Kind::kNone;
  experiment.validation.kind = ValidationSpec::Kind::kFraction;
  experiment.validation.fraction = 0.33;
  for (int s = 0; s < 2; ++s) {
    StationSpec& station = experiment.stations["S" + std::to_string(s + 1)];
    station.base_xyz = truth.base_xyz[static_cast<size_t>(s)];
    station.base_rotvec = truth.base_rotvec[static_cast<size_t>(s)];
  }
  for (int m = 0; m < 3; ++m)
    experiment.markers["P" + std::to_string(m + 1)].point = truth.tools[static_cast<size_t>(m)];
  return test::Kr270ProblemOf(data, experiment);
}

void ExpectFiguresOfTheRows(const Experiment& experiment, const std::string& what) {
  SCOPED_TRACE(what);
  const Calibration result = Calibrate(Known(experiment));
  ASSERT_TRUE(IsUsable(result.estimate.status)) << result.estimate.message;
  EXPECT_TRUE(result.estimate.estimated.empty());
  EXPECT_EQ(result.estimate.covariance.size(), 0);
  EXPECT_EQ(result.estimate.dof, result.estimate.rows);
  EXPECT_TRUE(result.estimate.predicted.allFinite());
  // 108 coordinates of 100 um: within four standard errors.
  EXPECT_NEAR(result.estimate.fit.rms, kSigma, 4.0 * kSigma / std::sqrt(2.0 * 108.0));
  EXPECT_TRUE(std::isfinite(result.estimate.chi2));
  EXPECT_FALSE(CalibrationToJson(result, {}).dump().empty());
}

TEST(NothingEstimated, HasTheResidualsFigures) {
  ExpectFiguresOfTheRows(Experiment(), "as stated");
  for (const std::string weights : {"equal", "eq14"}) {
    Experiment experiment;
    experiment.weights = weights;
    ExpectFiguresOfTheRows(experiment, weights);
  }
  for (const NoiseSpec::From from : {NoiseSpec::From::kResiduals, NoiseSpec::From::kVarianceComponents}) {
    Experiment experiment;
    experiment.noise.from = from;
    ExpectFiguresOfTheRows(experiment, "noise " + std::to_string(static_cast<int>(from)));
  }
  for (const std::string covariance : {"sandwich", "bootstrap", "profile"}) {
    Experiment experiment;
    experiment.covariance = covariance;
    experiment.bootstrap.replicates = 19;
    ExpectFiguresOfTheRows(experiment, covariance);
  }
  for (const std::string loss : {"huber", "cauchy"}) {
    Experiment experiment;
    experiment.loss = loss;
    ExpectFiguresOfTheRows(experiment, loss);
  }
  Experiment repeatable;
  repeatable.repeatability.angle.estimate = true;
  ExpectFiguresOfTheRows(repeatable, "repeatability estimated");
}

// Without columns the covariance of a weighted fit has none, and the restricted likelihood is the likelihood: rows of
// one variance a have n log a + r'r / a.
TEST(NothingEstimated, VarianceComponentsAreThoseOfTheRows) {
  const CalibrationProblem problem = Known(Experiment());
  const RestrictedLikelihood likelihood(problem, problem.parameters);
  const std::vector<int> rows = problem.CalibrationObservations();
  const Eigen::Matrix3Xd predicted = PredictPoints(problem, problem.parameters, rows);
  double square = 0.0;
  for (size_t k = 0; k < rows.size(); ++k) {
    square +=
        (problem.data.observations[static_cast<size_t>(rows[k])].point_in_station - predicted.col(static_cast<long>(k)))
            .squaredNorm() /
        (kSigma * kSigma);
  }
  const double n = 3.0 * static_cast<double>(rows.size());
  EXPECT_EQ(likelihood.dof(), static_cast<int>(n));
  const RemlFit fit = likelihood.Maximise(true, {});
  EXPECT_NEAR(fit.variances[0], square / n, 1e-6 * square / n);
  EXPECT_NEAR(likelihood.Deviance(2.0, {}) - likelihood.Deviance(1.0, {}), n * std::log(2.0) - 0.5 * square, 1e-6);
  EXPECT_EQ(CovarianceOfWeighted(problem, problem.parameters, {}).size(), 0);
}

}  // namespace
}  // namespace sagitta

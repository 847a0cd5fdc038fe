// What is drawn anew when an experiment is simulated: everything its intervals are about.
#include "estimator/intervals/redraw.h"

#include <gtest/gtest.h>

#include "estimator/intervals/intervals.h"
#include "estimator/least_squares/sandwich.h"
#include "estimator/least_squares/spring_tie_cost.h"
#include "estimator/statistics/distributions.h"
#include "tests/support/loaded_kr270.h"
#include "tests/support/noise_experiment.h"

namespace sagitta::redraw_test {
namespace {

// Markers on the spring are off its ends by their stated sigmas, anew in every draw, wherever the truth has them.
TEST(Redraw, MarkersOnTheSpringAreOffByTheirSigmas) {
  test::LoadedTruth truth;
  truth.spring = test::SpringTruth();
  const test::SpringTruth& s = *truth.spring;
  const Vector3<double> u(std::cos(0.4), 0, -std::sin(0.4)), v = Vector3<double>::UnitY().cross(u);
  truth.link_markers = {{"L1", {1, s.L * u}},
                        {"L2", {0, Vector3<double>(0.350, 0, 0) - s.a_y * u - s.a_x * v + Vector3<double>(0, 0.3, 0)}}};
  test::LoadedSetup setup = test::SetupFor(truth);
  setup.experiment.markers["L1"].spring_sigma = 2e-5;
  setup.experiment.markers["L2"].spring_sigma = 2.3e-4;
  Measurements data = test::LoadedRows(test::LoadedDesign(), truth);
  test::Measure(test::ExactPoints(truth, data), 0.0, 1, &data);
  CalibrationProblem problem = MakeCalibrationProblem(setup.robot, data, setup.experiment);
  ParameterSet& parameters = problem.parameters;
  for (size_t m = 0; m < problem.data().markers.size(); ++m) {
    const auto own = truth.link_markers.find(problem.data().markers[m]);
    if (own != truth.link_markers.end()) parameters.SetMarkerPoint(m, own->second.second);
  }
  ASSERT_TRUE(parameters.spring_tie());
  constexpr int kDraws = 400;
  double chi2 = 0.0;
  const Eigen::Matrix3d information = parameters.spring_tie()->covariance.inverse();
  for (int i = 0; i < kDraws; ++i) {
    const Eigen::Vector3d off = SpringTieMisfit(DrawTruth(parameters, SeedOf(3, i)));
    chi2 += off.dot(information * off);
  }
  // Chi-square with 3 x 400 degrees of freedom, both tails at 1e-4.
  EXPECT_GT(ChiSquareSurvival(chi2, 3 * kDraws), 1e-4);
  EXPECT_LT(ChiSquareSurvival(chi2, 3 * kDraws), 1 - 1e-4);
}

struct Repeated {
  test::Kr270Truth truth;
  Measurements data;

  Repeated() {
    test::RepeatDesign design;
    design.repeats = 3;
    data = test::RepeatRows(design);
    test::MeasureRepeated(truth, design, 21, &data);
  }
  ResolvedEstimate By(const std::string& covariance) const {
    Experiment experiment;
    experiment.noise.from = NoiseSpec::From::kVarianceComponents;
    experiment.method.covariance = *FindChoice<CovarianceKind>(covariance);
    experiment.method.bootstrap = {BootstrapKind::kParametric, 399, 3};
    ResolvedEstimate result = EstimateWithNoise(test::Kr270ProblemOf(data, experiment));
    AddIntervals(result.problem, {}, &result.estimate);
    return result;
  }
};

// The sandwich does not use the variances: its degrees of freedom are those of clusters, not Satterthwaite's of REML.
TEST(IntervalsWithEstimatedNoise, TheSandwichKeepsItsDegreesOfFreedom) {
  const Repeated repeated;
  const ResolvedEstimate result = repeated.By("sandwich");
  const CalibrationProblem& problem = result.problem;
  const Estimate& estimate = result.estimate;
  const std::vector<int> rows = problem.CalibrationObservations();
  const Linearization fit =
      Linearize(problem, estimate.parameters, rows, estimate.estimated, ObservationNoise(problem, rows, 1e-3));
  const RobustCovariance robust = SandwichCovariance(fit, ConfigurationClusters(problem.data(), rows));
  ASSERT_EQ(estimate.interval_dof.size(), robust.dof.size());
  EXPECT_LT((estimate.interval_dof - robust.dof).cwiseAbs().maxCoeff(), 1e-6 * robust.dof.maxCoeff());
  const ResolvedEstimate model = repeated.By("model");
  EXPECT_GT((model.estimate.interval_dof - robust.dof).cwiseAbs().maxCoeff(), 1.0);
}

// What is refitted at fixed noise has to be widened by what is not known of that noise: Student's quantile.
TEST(IntervalsWithEstimatedNoise, ProfileAndParametricBootstrapCountThatTheNoiseIsEstimated) {
  const Repeated repeated;
  const ResolvedEstimate model = repeated.By("model"), profile = repeated.By("profile"),
                         bootstrap = repeated.By("bootstrap");
  double mean_profile = 0.0, mean_bootstrap = 0.0, widening = 0.0;
  const std::vector<int>& estimated = model.estimate.estimated;
  for (size_t c = 0; c < estimated.size(); ++c) {
    const auto half = [&](const ResolvedEstimate& result) {
      const Interval& interval = result.estimate.table[estimated[c]].ci95;
      return 0.5 * (interval.high - interval.low);
    };
    const double normal = 1.959964 * std::sqrt(model.estimate.model_covariance(c, c));
    const double own = StudentQuantile(0.975, model.estimate.interval_dof[c]) / 1.959964;
    EXPECT_NEAR(half(profile) / normal / own, 1.0, 0.01) << estimated[c];
    mean_profile += half(profile) / normal / estimated.size();
    mean_bootstrap += half(bootstrap) / normal / estimated.size();
    widening += own / estimated.size();
  }
  EXPECT_GT(widening, 1.01);
  EXPECT_NEAR(mean_profile / widening, 1.0, 0.01);
  // A quantile of 399 draws: 3.5 % each, a sixth of that over 33 correlated ones and two ends.
  EXPECT_NEAR(mean_bootstrap / widening, 1.0, 0.03);
}

}  // namespace
}  // namespace sagitta::redraw_test

// The diagnosis on data in which an effect is hidden; the measurements come from
// the generator in tests/support, the effect from its formula written here.
#include "estimator/diagnosis/diagnose.h"

#include <gtest/gtest.h>

#include "tests/support/kr270_experiment.h"

namespace sagitta {
namespace {

using test::Kr270Truth;

constexpr double kSigma = 2e-5;  // m

// 50 configurations from one station, 15 of them held out, joint 3 off by `deviation(q3)`.
template <typename Deviation>
CalibrationProblem Hidden(std::uint64_t seed, const Deviation& deviation) {
  test::Kr270Design design;
  design.configurations = 50;
  design.stations = 1;
  design.sigma = kSigma;
  design.seed = seed;
  Measurements data = test::DesignMeasurements(design);
  Measurements moved = data;
  for (Configuration& configuration : moved.configurations) configuration.q[2] += deviation(configuration.q[2]);
  test::MeasureKr270(Kr270Truth(), kSigma, 100 + seed, &moved);
  for (size_t i = 0; i < data.observations.size(); ++i) {
    data.observations[i].point_in_station = moved.observations[i].point_in_station;
  }
  Robot robot;
  robot.chain = test::Kr270Chain();
  Experiment experiment;
  experiment.validation.kind = ValidationSpec::Kind::kFraction;
  experiment.validation.fraction = 0.3;
  return MakeCalibrationProblem(robot, data, experiment);
}

TEST(Diagnosis, NothingHiddenIsConsistent) {
  const Diagnosis diagnosis = Diagnose(Hidden(1, [](double) { return 0.0; }), DiagnosisOptions());
  EXPECT_EQ(diagnosis.verdict, "consistent");
  EXPECT_TRUE(diagnosis.steps.empty());
}

TEST(Diagnosis, NamesAHarmonicWithItsSizeAndClosesTheGap) {
  const auto harmonic = [](double q) { return 80e-6 * std::cos(2 * q) - 50e-6 * std::sin(2 * q); };
  const Diagnosis diagnosis = Diagnose(Hidden(2, harmonic), DiagnosisOptions());
  EXPECT_EQ(diagnosis.verdict, "explained");
  ASSERT_EQ(diagnosis.steps.size(), 1u);
  EXPECT_EQ(diagnosis.steps[0].chosen.candidate.spec.Path(), "effect/joint_harmonic[order=2]/A3");
  const std::vector<ParameterEstimate>& parameters = diagnosis.steps[0].parameters;
  ASSERT_EQ(parameters.size(), 2u);
  EXPECT_NEAR(parameters[0].value, 80e-6, 5 * parameters[0].sigma);
  EXPECT_NEAR(parameters[1].value, -50e-6, 5 * parameters[1].sigma);
  EXPECT_LT(diagnosis.gap.after, 0.3 * diagnosis.gap.before);
}

TEST(Diagnosis, WrongStatedNoiseIsAFindingAndNoEffect) {
  CalibrationProblem problem = Hidden(3, [](double) { return 0.0; });
  for (Observation& observation : problem.data.observations) observation.sigma *= 0.5;
  const Diagnosis diagnosis = Diagnose(problem, DiagnosisOptions());
  EXPECT_EQ(diagnosis.verdict, "noise");
  EXPECT_TRUE(diagnosis.steps.empty());
  EXPECT_LT(diagnosis.noise.low, 2.0);
  EXPECT_GT(diagnosis.noise.high, 2.0);
}

TEST(Diagnosis, BumpOutsideTheCatalogueIsUnknown) {
  const auto bump = [](double q) { return 300e-6 * std::exp(-0.5 * std::pow((q - 0.3) / 0.15, 2)); };
  const Diagnosis diagnosis = Diagnose(Hidden(4, bump), DiagnosisOptions());
  EXPECT_EQ(diagnosis.verdict, "unknown");
  EXPECT_EQ(diagnosis.unexplained.depends_on, std::vector<std::string>{"A3"});
}

}  // namespace
}  // namespace sagitta

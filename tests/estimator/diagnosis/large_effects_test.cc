// Effects that are far larger than machines show, as mistakes are, and effects that would have to be.
#include <gtest/gtest.h>

#include <cmath>

#include "estimator/diagnosis/diagnose.h"
#include "estimator/explanations/typical_units.h"
#include "tests/support/loaded_kr270.h"
#include "tests/support/moved_kr270.h"

namespace sagitta::large_effects_test {
namespace {

Diagnosis DiagnosisOf(const Measurements& data) {
  Experiment experiment;
  experiment.validation.kind = ValidationSpec::Kind::kFraction;
  experiment.validation.fraction = 0.3;
  return Diagnose(test::Kr270ProblemOf(data, experiment), DiagnosisOptions());
}

// A reflector's radius that is not corrected: every point lies 6.35 mm too near along the line of sight. The interval
// is that of the rows, which no size that is usual widens or holds back.
TEST(LargeEffects, AReflectorsRadiusIsFoundInFull) {
  constexpr double kRadius = 6.35e-3, kSigma = 3e-5;
  Measurements data = test::DesignMeasurements(test::CampaignOf(60, 1, kSigma, 5));
  test::MeasureKr270(test::Kr270Truth(), kSigma, 305, &data);
  for (Observation& row : data.observations) {
    row.point_in_station -= kRadius * row.point_in_station.normalized();
  }
  const Diagnosis diagnosis = DiagnosisOf(data);
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kExplained);
  ASSERT_EQ(diagnosis.effects.size(), 1u);
  const FoundEffect& found = diagnosis.effects[0];
  EXPECT_EQ(found.candidate.spec.effect, "station_range_offset");
  ASSERT_EQ(found.parameters.size(), 1u);
  EXPECT_NEAR(found.parameters[0].value, -kRadius, 5.0 * found.parameters[0].sigma);
  EXPECT_LT(found.parameters[0].sigma, 0.02 * kRadius);
}

// A wrist whose encoders are read before its gears: A5 and A6 go along with A4 by 1/80 and 1/60, some hundred times
// what gears leave. Both are found in full, and the noise is what it is: nothing is held back that would swell it.
TEST(LargeEffects, ACoupledWristIsFoundInFull) {
  const Measurements data = test::MeasuredAfter(test::CampaignOf(80, 1, 3e-5, 5), 305, [](Eigen::VectorXd* q) {
    (*q)[4] += (*q)[3] / 80.0;
    (*q)[5] += (*q)[3] / 60.0;
  });
  const Diagnosis diagnosis = DiagnosisOf(data);
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kExplained);
  ASSERT_EQ(diagnosis.effects.size(), 2u);
  for (const FoundEffect& found : diagnosis.effects) {
    const EffectSpec& spec = found.candidate.spec;
    EXPECT_EQ(spec.effect, "joint_coupling");
    ASSERT_EQ(found.parameters.size(), 1u);
    const double true_ratio = spec.target == "A5" ? 1.0 / 80.0 : 1.0 / 60.0;
    EXPECT_NEAR(found.parameters[0].value, true_ratio, 5.0 * found.parameters[0].sigma) << spec.target;
  }
  const Estimate& final = diagnosis.final.estimate;
  EXPECT_NEAR(final.chi2 / final.dof, 1.0, 5.0 * std::sqrt(2.0 / final.dof));
}

// Nearly upright, the first axis is turned by a hundredth of what the same weight turns the second one by; the link is
// not a hundred times as heavy for that.
TEST(LargeEffects, ALinkIsNoHeavierWhereItsWeightTurnsNothing) {
  test::LoadedTruth truth;
  Measurements data = test::LoadedRows(test::LoadedDesign(), truth);
  test::Measure(test::ExactPoints(truth, data), 3e-5, 1, &data);
  test::LoadedSetup setup = test::SetupFor(truth);
  setup.experiment.gravity_direction = Vector3<double>(0.0, 0.01, -1.0).normalized();
  for (const int joint : {0, 1}) setup.robot.compliances.push_back({joint, {{0.0, 1e-6}}, false});
  const CalibrationProblem problem = MakeCalibrationProblem(setup.robot, data, setup.experiment);
  const std::vector<EffectSpec> effects = {{"link_gravity", "A1", {}, {}}, {"link_gravity", "A2", {}, {}}};
  const CalibrationProblem with = problem.WithEffects(effects);
  const std::vector<double> both = TypicalSizes(with, with.parameters, effects);
  const auto size_of = [&](const std::vector<double>& sizes, const char* name) {
    return sizes[with.parameters.FindCoordinate(name)];
  };
  EXPECT_GT(size_of(both, "effect/link_gravity/A2/mx"), 0.0);
  EXPECT_EQ(size_of(both, "effect/link_gravity/A1/my"), size_of(both, "effect/link_gravity/A2/mx"));
}

}  // namespace
}  // namespace sagitta::large_effects_test

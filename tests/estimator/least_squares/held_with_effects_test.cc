// What the believed model's data do not determine is held, and may be what a missing effect needs.
#include <gtest/gtest.h>

#include "estimator/diagnosis/leading_set.h"
#include "estimator/least_squares/held_influence.h"
#include "models/constants.h"
#include "tests/support/loaded_kr270.h"

namespace sagitta::held_with_effects_test {
namespace {

constexpr double kTilt[2] = {0.08e-6, 0.06e-6};  // rad / (N m), about x and y of the base
constexpr double kSigma = 5e-5;                  // m

// A palletiser's wrist: the flange looks down in every configuration, so that nothing but the height of a marker
// together with that of the station moves, until the foot gives way.
test::LoadedDesign LookingDown() {
  test::LoadedDesign design;
  design.configurations = 45;
  design.stations = 1;
  design.sigma = kSigma;
  design.change = [](std::vector<Configuration>* configurations) {
    for (Configuration& configuration : *configurations) {
      Eigen::VectorXd& q = configuration.q;
      q[1] = -70.0 * kDegree + 0.4 * (q[1] + 70.0 * kDegree);
      q[2] = 60.0 * kDegree + 0.3 * q[2];
      q[3] = 0.0;
      q[4] = 90.0 * kDegree - q[1] - q[2];
    }
  };
  return design;
}

// Stiff joints on a foot that tilts by the moments about its origin.
Measurements OnASoftFoot(test::LoadedTruth truth, const test::LoadedDesign& design) {
  truth.k.fill(0.0);
  Measurements data = test::LoadedRows(design, truth);
  std::vector<Vector3<double>> points = test::ExactPoints(truth, data);
  const Eigen::Matrix3d base = test::BaseRotation(truth, 0);
  const test::LoadTruth& load = truth.loads.at("V250");
  for (size_t i = 0; i < points.size(); ++i) {
    const Shot& shot = data.shots[data.observations[i].shot];
    if (shot.load == "none") continue;
    const test::ArmState arm = test::LoadedState(truth, data.configurations[shot.configuration].q, shot.load, 0);
    const Vector3<double> pulled_at = arm.flange_origin + arm.flange * load.point;
    const Vector3<double> moment = pulled_at.cross(base.transpose() * load.force);
    const Vector3<double> turn(kTilt[0] * moment.x(), kTilt[1] * moment.y(), 0.0);
    const Vector3<double> in_base = base.transpose() * (points[i] - truth.base_xyz[0]);
    points[i] += base * turn.cross(in_base);
  }
  test::Measure(points, design.sigma, 17, &data);
  return data;
}

TEST(HeldWithEffects, TheHeightOfAMarkerThatOnlyATiltingFootShows) {
  test::LoadedTruth truth;
  truth.tools = {{0.4, 0.1, 0.2}, {0.45, -0.2, 0.1}, {0.5, 0.1, -0.25}};  // the held height is far from 0
  const test::LoadedDesign design = LookingDown();
  test::LoadedSetup setup = test::SetupFor(truth);
  setup.robot.compliances.clear();
  const CalibrationProblem problem = MakeCalibrationProblem(setup.robot, OnASoftFoot(truth, design), setup.experiment);
  const DiagnosedModel baseline = FitFully(problem, JointOptions());
  ASSERT_FALSE(HeldCoordinates(baseline.estimate.parameters).empty());
  const PriorMasses prior;
  const JointOptions joint;
  const LeadingSet found = FindLeading({problem, baseline, prior, kInfinity, 0.9, joint, nullptr}, nullptr);
  ASSERT_TRUE(found.is_named);
  ASSERT_EQ(found.refitted.effects.size(), 1u);
  EXPECT_EQ(found.refitted.effects[0].candidate.spec.effect, "base_compliance");
  EXPECT_EQ(found.refitted.model.set.members.size(), 1u);  // and nothing without a name
  const DiagnosedModel& with = found.refitted.with_effects;
  const DiagnosedModel judged =
      JudgeFully(with.problem, with.estimate.parameters, with.problem->parameters, JointOptions());
  const std::vector<ParameterEstimate> rows =
      ParameterRowsOf(found.refitted.effects[0].candidate.spec, judged.estimate);
  ASSERT_EQ(rows.size(), 2u);
  for (int axis = 0; axis < 2; ++axis) {
    EXPECT_LT(rows[axis].ci95.low, kTilt[axis]);
    EXPECT_GT(rows[axis].ci95.high, kTilt[axis]);
  }
}

}  // namespace
}  // namespace sagitta::held_with_effects_test

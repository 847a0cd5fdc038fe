// Remedies of what markers leave open, followed to the letter: they have to help.
#include "estimator/calibration/marker_remedy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estimator/calibration/joint_estimator.h"
#include "tests/support/dh_campaigns.h"

namespace sagitta::marker_remedy_test {
namespace {

using test::DhCampaign;
using ::testing::HasSubstr;

// A UR5 whose only marker is on the axis of the last joint.
DhCampaign OnTheAxis() {
  DhCampaign campaign;
  campaign.tools = {{0.0, 0.0, 0.1}};
  campaign.markers = {"M1"};
  return campaign;
}

TEST(MarkerRemedy, AMarkerOffTheAxisIsTheCure) {
  const Estimate on_axis = EstimateJointly(test::ProblemOf(OnTheAxis()));
  int of_geometry = 0;
  for (const Direction& direction : on_axis.identifiability.unidentifiable) {
    if (CoordinateKindOf(direction.components[0].first) != CoordinateKind::kGeometry) continue;
    ++of_geometry;
    EXPECT_THAT(direction.remedy, HasSubstr("a marker some 50 mm or more off that axis"));
  }
  ASSERT_GT(of_geometry, 0);
  DhCampaign cured = OnTheAxis();
  cured.tools.push_back({0.05, 0.0, 0.1});
  cured.markers.push_back("M2");
  const CalibrationProblem problem = test::ProblemOf(cured);
  const Estimate estimate = EstimateJointly(problem);
  EXPECT_TRUE(estimate.identifiability.unidentifiable.empty()) << estimate.message;
  EXPECT_FALSE(AxisOfAllMarkers(problem, estimate.parameters));
}

// Three parallel axes: heights of markers and base are one number, and a stated point alone is where a search starts.
CalibrationProblem Planar(const std::vector<std::string>& fixed) {
  DhCampaign campaign;
  campaign.nominal = {{0.35, 0, 0.3, 0}, {0.3, 0, 0, 0}, {0.1, 0, 0.05, 0}};
  campaign.rows = campaign.nominal;
  campaign.rows[0].a += 0.2e-3, campaign.rows[1].a -= 0.1e-3;
  Experiment experiment;
  experiment.markers["P1"].point = campaign.tools[0];
  experiment.estimate.fixed = fixed;
  Robot robot;
  robot.chain = test::DhArm(DhConvention::kStandard, campaign.nominal);
  return MakeCalibrationProblem(robot, test::MeasurementsOf(campaign), experiment);
}

TEST(MarkerRemedy, AStatedPointThatIsHeldDeterminesTheHeight) {
  const Estimate stated = EstimateJointly(Planar({}));
  std::vector<std::string> held;
  for (const Direction& direction : stated.identifiability.unidentifiable) {
    ASSERT_THAT(direction.remedy, HasSubstr("hold the coordinate of it that is named here (--fixed=NAME"));
    for (const auto& [name, value] : direction.components) {
      if (name.rfind("marker/P1/", 0) != 0) continue;
      held.push_back(name);
      break;
    }
  }
  ASSERT_EQ(held.size(), stated.identifiability.unidentifiable.size());
  ASSERT_FALSE(held.empty());
  const Estimate followed = EstimateJointly(Planar(held));
  EXPECT_TRUE(followed.identifiability.unidentifiable.empty());
  const int height = followed.parameters.FindCoordinate("base/S1/z");
  EXPECT_NEAR(followed.parameters.Value(height), DhCampaign().base_xyz.z(), 4.0 * followed.table[height].sigma);
  EXPECT_LT(followed.table[height].sigma, 1e-4);
}

}  // namespace
}  // namespace sagitta::marker_remedy_test

// What a plan is made on: the conditions of drawn poses.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "estimator/planning/pose_space.h"
#include "estimator/planning/scene.h"
#include "estimator/statistics/distributions.h"
#include "models/effects/catalogue.h"
#include "tests/support/moved_kr270.h"

namespace sagitta::plan_scene_test {
namespace {

constexpr int kPool = 240;

// Drawn poses of an arm whose rows are of that many times, 10 min apart.
PlanScene SceneOfTimes(int times, std::uint64_t seed) {
  Robot robot = test::Kr270Robot();
  for (Joint& joint : robot.chain.joints) joint.min = -1.5, joint.max = 1.5;
  Measurements data = test::DesignMeasurements(test::CampaignOf(times, 1, 1e-4, 3));
  EffectSpec drift{"station_drift", data.stations[0], {}, {}};
  drift.values.assign(FindEffect(drift.effect)->parameters(robot, drift).size(), 0.0);
  robot.effects = {drift};
  for (Shot& shot : data.shots) shot.has_time = true, shot.time = 600.0 * shot.configuration;
  Experiment experiment;
  for (Observation& row : data.observations) row.point_in_station.setConstant(std::nan(""));
  for (const std::string& marker : data.markers) experiment.markers[marker].point = Vector3<double>(0.28, 0.05, 0.02);
  PlanRequest request;
  request.poses = 20;
  request.pool = kPool;
  request.seed = seed;
  return MakePlanScene(robot, data, experiment, request);
}

// p-value of one mean of joint j at all times (analysis of variance).
double ChanceOfMeans(const PlanScene& scene, int j) {
  const Measurements& data = scene.problem->data();
  const std::vector<std::vector<int>> shots = ShotsByConfiguration(data);
  std::map<double, std::vector<double>> values;
  double mean = 0.0;
  for (const int c : scene.candidates) {
    const double q = data.configurations[c].q[j];
    values[data.shots[shots[c].front()].time].push_back(q);
    mean += q / kPool;
  }
  double between = 0.0, within = 0.0;
  for (const auto& [time, own] : values) {
    EXPECT_NEAR(own.size(), static_cast<double>(kPool) / values.size(), 1.0) << time;
    double own_mean = 0.0;
    for (const double q : own) own_mean += q / own.size();
    between += own.size() * (own_mean - mean) * (own_mean - mean);
    for (const double q : own) within += (q - own_mean) * (q - own_mean);
  }
  const double groups = static_cast<double>(values.size());
  return FSurvival(between / (groups - 1.0) / (within / (kPool - groups)), groups - 1.0, kPool - groups);
}

// Halton's base of the first joint is 2, of the second 3: poses that have their times in turn have, of two, four, eight
// or sixteen times, the first joint in another sector at each. 96 comparisons of a false-alarm rate of 0.001 together.
TEST(PlanScene, TheTimeOfADrawnPoseGoesWithNoJoint) {
  for (const std::uint64_t seed : {1, 2}) {
    for (const int times : {2, 3, 4, 5, 8, 9, 15, 16}) {
      const PlanScene scene = SceneOfTimes(times, seed);
      ASSERT_EQ(scene.candidates.size(), static_cast<size_t>(kPool));
      EXPECT_TRUE(scene.goes_with_time);
      for (int j = 0; j < 6; ++j) EXPECT_GT(ChanceOfMeans(scene, j), 1e-3 / 96) << times << " times, joint " << j + 1;
    }
  }
}

}  // namespace
}  // namespace sagitta::plan_scene_test

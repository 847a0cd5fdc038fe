// Forces, slides and lags that have no name: numbers computed by hand on an arm of two links, not by the code.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "tests/support/two_link.h"

namespace sagitta::learnt_conventions_test {
namespace {

using test::ExpectPoint;
using test::Rotate;
using test::TwoLinkScene;

// Knots at 0 and 1 of gravity's component along the flange's x, which is 0 at q2 = 0: the first bump is pi^(-1/4) =
// 0.75112554, 50 mm of it 37.556277 mm, 3.7556277 N m more than the 40 N m, 0.4 um down for each.
TEST(LearntConventions, LearntSlideOfALoad) {
  TwoLinkScene scene;
  scene.GiveWay(1, 1e-6);
  scene.Load({0.0, 0.0, -100.0});
  scene.Add(
      {"learnt_load_slide",
       "V",
       {{"along", "x"}, {"down_x", "0"}, {"down_y", "0"}, {"down_z", "-1"}, {"from", "0"}, {"to", "1"}, {"knots", "2"}},
       {0.05, 0.0}});
  ExpectPoint(scene.Seen(), 1.4, 0.0, 0.5 - 17.502251e-6, 1e-9);
  scene.robot.effects[0].settings["along"] = "z";  // gravity's component is -1: 0.05 * 0.45558 m with no lever
  ExpectPoint(scene.Seen(), 1.4, 0.0, 0.5 - 16e-6, 1e-9);
  scene.robot.effects[0].target = "another";
  scene.robot.effects[0].settings["along"] = "x";
  ExpectPoint(scene.Seen(), 1.4, 0.0, 0.5 - 16e-6, 1e-9);
}

// Down is -z of the flange: 30 um times that along y, times the load of 50 N over 200 N, or of none.
TEST(LearntConventions, LearntGivingWayOfAMarker) {
  TwoLinkScene scene;
  std::map<std::string, std::string> settings = {
      {"by", "gravity"}, {"down_x", "0"}, {"down_y", "0"}, {"down_z", "-1"}, {"degree", "1"}};
  std::vector<double> values(9, 0.0);
  values[5] = 30e-6;
  scene.Add({"learnt_marker_motion", "M1", settings, values});
  ExpectPoint(scene.Seen(), 1.4, -30e-6, 0.5, 1e-12);
  scene.robot.effects[0].settings["per_N"] = "200";
  ExpectPoint(scene.Seen(), 1.4, 0.0, 0.5, 1e-12);
  scene.Load({30.0, 0.0, -40.0});
  ExpectPoint(scene.Seen(), 1.4, -7.5e-6, 0.5, 1e-12);
}

// The weight of 100 / 9.80665 kg down at 0.4 m: 40 N m, 1 urad/Nm, 16 um down. The flange, at (1.4, 0, 0.5), is 400 mm
// beyond a middle at x = 1 m, four spreads of 100 mm: a quarter of that weight per spread makes the same.
TEST(LearntConventions, LearntPull) {
  TwoLinkScene scene;
  scene.GiveWay(1, 1e-6);
  const double weight = -100.0 / 9.80665;
  std::map<std::string, std::string> settings = {
      {"x_mm", "1000"}, {"y_mm", "0"}, {"z_mm", "500"}, {"spread_mm", "100"}, {"degree", "0"}};
  scene.Add({"learnt_pull", "robot", settings, {0.0, 0.0, weight}});
  ExpectPoint(scene.Seen(), 1.4, 0.0, 0.5 - 16e-6, 1e-9);
  settings["degree"] = "1";
  std::vector<double> values(12, 0.0);
  values[9] = 0.25 * weight;
  scene.robot.effects[0] = {"learnt_pull", "robot", settings, values};
  ExpectPoint(scene.Seen(), 1.4, 0.0, 0.5 - 16e-6, 1e-9);
}

// The flange, at (1.4, 0, 0.5), is two spreads beyond a middle at x = 1 m: u_x is 2 and u_x^2 4. A turn of 5 urad per
// u_x^2 about z is 20 urad and moves it by 28 um along y; with a reach of one spread, 5 urad and 7 um. Of a load, 1
// comes before u_x: half the unit of the load makes 10 urad per u_x, 20 urad of turn, 10.
TEST(LearntConventions, LearntTurnOfTheBaseByPlaceAndLoad) {
  TwoLinkScene scene;
  scene.shot().station = "S1";
  std::map<std::string, std::string> settings = {{"by", "place"}, {"moves", "turn"}, {"x_mm", "1000"},
                                                 {"y_mm", "0"},   {"z_mm", "500"},   {"spread_mm", "200"},
                                                 {"reach", "3"},  {"degree", "2"}};
  std::vector<double> values(27, 0.0);
  values[18 + 3] = 5e-6;
  scene.Add({"learnt_station_motion", "S1", settings, values});
  ExpectPoint(scene.Seen(), 1.4, 28e-6, 0.5, 1e-12);
  scene.robot.effects[0].settings["reach"] = "1";
  ExpectPoint(scene.Seen(), 1.4, 7e-6, 0.5, 1e-12);
  settings["degree"] = "1";
  settings["per_N"] = "200";
  values.assign(12, 0.0);
  values[8 + 1] = 10e-6;
  scene.robot.effects[0] = {"learnt_station_motion", "S1", settings, values};
  ExpectPoint(scene.Seen(), 1.4, 0.0, 0.5, 1e-12);
  AppliedWrench weight;
  weight.force = {0.0, 0.0, -100.0};
  scene.shot().load_wrenches = {weight};
  ExpectPoint(scene.Seen(), 1.4, 14e-6, 0.5, 1e-12);
}

// One ramp of 100 urad is a jump of sqrt(6) times that, 244.94897 urad, half of it in the middle. About z of the flange
// the marker, 100 mm along y of it, moves by 24.494897 um against x, and nothing along y: not about the joint, 400 mm
// away. Along y of the flange 30 um are 73.484692 um.
TEST(LearntConventions, LearntMotionOfTheTool) {
  TwoLinkScene scene;
  scene.marker = {0.0, 0.1, 0.0};
  scene.shot().has_time = true;
  std::map<std::string, std::string> settings = {{"by", "time_s"}, {"from", "100"},    {"to", "200"},
                                                 {"knots", "1"},   {"shape", "ramps"}, {"moves", "rz"}};
  scene.Add({"learnt_tool_motion", "J2", settings, {100e-6}});
  scene.shot().time = 100.0;
  ExpectPoint(scene.Seen(), 1.4, 0.1, 0.5, 1e-12);
  scene.shot().time = 150.0;
  ExpectPoint(scene.Seen(), 1.4 - 12.247449e-6, 0.1, 0.5, 2e-8);
  scene.shot().time = 300.0;
  ExpectPoint(scene.Seen(), 1.4 - 24.494897e-6, 0.1, 0.5, 2e-8);
  settings["moves"] = "y";
  scene.robot.effects[0] = {"learnt_tool_motion", "J2", settings, {30e-6}};
  ExpectPoint(scene.Seen(), 1.4, 0.1 + 73.484692e-6, 0.5, 1e-11);
  // On a flange that is turned by 90 deg about x the marker is upright, and moves as before.
  settings["moves"] = "rz";
  scene.robot.effects[0] = {"learnt_tool_motion", "J2", settings, {100e-6}};
  scene.robot.chain.transforms.push_back(Rotate(Axis::kX, 90.0 * kDegree));
  ExpectPoint(scene.Seen(), 1.4 - 24.494897e-6, 0.0, 0.6, 2e-8);
}

// Three shots 100 s apart, J2 at these angles.
TwoLinkScene ThreeShots(double first_deg, double second_deg, double third_deg) {
  TwoLinkScene scene;
  scene.campaign.resize(3, scene.campaign[0]);
  const double angles[3] = {first_deg, second_deg, third_deg};
  for (size_t k = 0; k < 3; ++k) {
    ShotConditions& shot = scene.campaign[k].conditions;
    shot.q << 0.0, angles[k] * kDegree;
    shot.has_time = true;
    shot.time = 100.0 * static_cast<double>(k);
  }
  return scene;
}

// Upright no weight turns J2, level 100 N do by -40 N m (1 N by -0.4 m). Of a torque that comes evenly over 100 s and
// stays, a lag of 100 s has 1 / e after them, and 100 s later 1 - (1 - 1 / e) / e = 0.76745589: 76.745589 urad less of
// J2, 30.698236 um down.
TEST(LearntConventions, LearntLagBehindATorque) {
  TwoLinkScene scene = ThreeShots(90.0, 0.0, 0.0);
  scene.Add({"learnt_lag",
             "J2",
             {{"by", "weight"}, {"down_x", "0"}, {"down_y", "0"}, {"down_z", "-1"}, {"lag_s", "100"}, {"unit", "0.4"}},
             {100e-6}});
  EXPECT_NEAR(scene.Seen().z(), 0.5 - 30.698236e-6, 1e-10);
  scene.robot.effects[0].settings["by"] = "load";
  scene.robot.effects[0].settings["unit"] = "40";
  EXPECT_NEAR(scene.Seen().z(), 0.5, 1e-12);
  AppliedWrench weight;
  weight.force = {0.0, 0.0, -100.0};
  for (ShotInput& shot : scene.campaign) shot.conditions.load_wrenches = {weight};
  EXPECT_NEAR(scene.Seen().z(), 0.5 - 30.698236e-6, 1e-10);
  for (ShotInput& shot : scene.campaign) shot.conditions.load_wrenches[0].force = {0.0, 100.0, 0.0};  // no weight
  EXPECT_NEAR(scene.Seen().z(), 0.5, 1e-12);
}

// 10 deg in 100 s are 0.1 deg/s; after them a lag of 100 s has 1 - 1 / e of that, 100 s later (1 - 1 / e) / e =
// 0.23254416: 23.254416 urad at 10 deg, 0.4 m cos(10 deg) of each up. 10 deg at once are 10 deg / 100 s, after 100 s 1
// / e.
TEST(LearntConventions, LearntLagBehindHeat) {
  TwoLinkScene scene = ThreeShots(0.0, 10.0, 10.0);
  const double rigid = scene.Seen().z(), lever = 0.4 * std::cos(10.0 * kDegree);
  scene.Add({"learnt_lag", "J2", {{"by", "motion"}, {"lag_s", "100"}, {"unit", "0.1"}}, {100e-6}});
  EXPECT_NEAR(scene.Seen().z(), rigid + lever * 23.254416e-6, 1e-10);
  for (size_t k : {1, 2}) scene.campaign[k].conditions.time -= 100.0;
  EXPECT_NEAR(scene.Seen().z(), rigid + lever * 36.787944e-6, 1e-10);
}

}  // namespace
}  // namespace sagitta::learnt_conventions_test

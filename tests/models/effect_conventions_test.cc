// Signs, axes, middles and frames of the effects of the arm: numbers computed by
// hand on an arm of two links (tests/support/two_link.h), not by the code.
#include <gtest/gtest.h>

#include "models/effects/learnt_deviation.h"
#include "tests/support/two_link.h"

namespace sagitta::effect_conventions_test {
namespace {

using test::ExpectPoint;
using test::TwoLinkScene;

TEST(Conventions, TheArmItself) {
  TwoLinkScene scene;
  ExpectPoint(scene.Seen(), 1.4, 0.0, 0.5);
  scene.shot().q << 90 * kDegree, 30 * kDegree;
  // 1 + 0.4 cos 30 = 1.346410161513775; 0.5 + 0.4 sin 30 = 0.7
  ExpectPoint(scene.Seen(), 0.0, 1.346410161513775, 0.7);
}

TEST(Conventions, FrozenGeometry) {
  TwoLinkScene scene;
  scene.shot().q << 90 * kDegree, 0.0;
  scene.Add({"frozen_geometry", "a1", {}, {2e-3}});
  ExpectPoint(scene.Seen(), 0.0, 1.402, 0.5);
}

// -100 N at 0.4 m: 40 N m that push the boom down. 1 urad/Nm: 40 urad, 0.4 m * 40 urad = 16 um down.
TEST(Conventions, JointCompliance) {
  TwoLinkScene scene;
  scene.Load({0.0, 0.0, -100.0});
  scene.Add({"joint_compliance", "J2", {}, {1e-6}});
  ExpectPoint(scene.Seen(), 1.4, 0.0, 0.5 - 16e-6);
}

// 0.4 kN m: 100 urad/(kN m)^3 * 0.064 (kN m)^3 = 6.4 urad, 2.56 um down. A fourfold lever turns it 64 times as far.
TEST(Conventions, ComplianceHardening) {
  TwoLinkScene scene;
  scene.Load({0.0, 0.0, -1000.0});
  scene.Add({"compliance_hardening", "J2", {}, {100e-6 / 1e9}});
  ExpectPoint(scene.Seen(), 1.4, 0.0, 0.5 - 2.56e-6, 1e-11);
}

// J1 about z: u = x, v = y of the frame right after it. At q1 = 90 deg that frame's y is the base's -x: 100 N down at
// 1.4 m bend the arm about it by 140 N m * 2 urad/Nm = 280 urad; the flange sinks by 1.4 m * 280 urad = 392 um.
TEST(Conventions, TransverseComplianceInTheFrameAfterTheJoint) {
  TwoLinkScene scene;
  scene.shot().q << 90 * kDegree, 0.0;
  scene.Load({0.0, 0.0, -100.0});
  scene.Add({"transverse_compliance", "J1", {}, {0.0, 2e-6}});
  ExpectPoint(scene.Seen(), 0.0, 1.4, 0.5 - 392e-6, 1e-7);
  scene.robot.effects[0].values = {2e-6, 0.0};
  ExpectPoint(scene.Seen(), 0.0, 1.4, 0.5, 1e-9);
}

// J2 about y: u = z, v = x. 50 N along y at 0.4 m: 20 N m about z (u), 20 * 3 urad = 60 urad, 24 um along y.
// -100 N at 0.2 m to the side: -20 N m about x (v), -60 urad, the point at the side sinks by 0.2 * 60 urad = 12 um.
TEST(Conventions, TransverseComplianceCountsTheAxesCyclically) {
  TwoLinkScene scene;
  scene.Load({0.0, 50.0, 0.0});
  scene.Add({"transverse_compliance", "J2", {}, {3e-6, 0.0}});
  ExpectPoint(scene.Seen(), 1.4, 24e-6, 0.5, 2e-9);
  TwoLinkScene beside;
  beside.marker = {0.0, 0.2, 0.0};
  beside.Load({0.0, 0.0, -100.0}, beside.marker);
  beside.Add({"transverse_compliance", "J2", {}, {0.0, 3e-6}});
  ExpectPoint(beside.Seen(), 1.4, 0.2, 0.5 - 12e-6, 2e-9);
}

// gamma = atan2(0.6, 0.3) - 30 deg = 0.5835499422, a = 0.6708203932, s = 0.8449396715:
// torque = -20000 (1 - 0.5 / s) a 0.2 sin gamma = -603.5695306921 N m on the joint, 1 nrad/Nm: -0.6035695 urad.
// The boom's end moves across it, (-sin 30, 0, cos 30) 0.4 m * -0.6035695e-6 = (0.120714, 0, -0.209083) um.
TEST(Conventions, GravityCompensator) {
  TwoLinkScene scene;
  scene.shot().q << 0.0, 30 * kDegree;
  scene.GiveWay(1, 1e-9);
  scene.robot.gravity_compensator = GravityCompensator{1, 0.2, 0.6, 0.3, 0.5, 20000.0, true, {}};
  ExpectPoint(scene.Seen(), 1.346410161513775 + 0.120714e-6, 0.0, 0.7 - 0.209083e-6, 1e-11);
  // Without preload only the change against the commanded angle is left: stiffness times 0.6 urad, nothing to see.
  scene.robot.gravity_compensator->preload = false;
  ExpectPoint(scene.Seen(), 1.346410161513775, 0.0, 0.7, 1e-11);
}

// First moment (2, 0, 1) kg m in the frame after J2. At q2 = 0 it turns J2 by 2 g down; at 90 deg the frame's x is up
// and its z is the base's -x: the weight is then at -1 kg m of the base's x, and lifts towards more q2.
// v = -q2 turns about y: torque_y = -x F_z. 1 urad/Nm at 0.4 m: 19.6133 N m -> 7.84532 um down at q2 = 0;
// 9.80665 N m the other way -> at 90 deg the end moves by 3.92266 um along -x.
TEST(Conventions, LinkGravity) {
  TwoLinkScene scene;
  scene.GiveWay(1, 1e-6);
  scene.Add({"link_gravity", "J2", {}, {0.0, 2.0, 0.0, 1.0}});
  ExpectPoint(scene.Seen(), 1.4, 0.0, 0.5 - 7.84532e-6, 1e-9);
  scene.shot().q << 0.0, 90 * kDegree;
  ExpectPoint(scene.Seen(), 1.0 - 3.92266e-6, 0.0, 0.9, 1e-9);
}

// 10 kg at J2's origin, 1 m in front of the foot: 98.0665 N m about the base's y, 1 urad/Nm: the flange (1.4, 0, 0.5)
// sinks by 1.4 * 98.0665 urad = 137.2931 um and moves forward by 0.5 * 98.0665 urad = 49.03325 um.
TEST(Conventions, WeightOfALinkAtItsJointAndTheFoot) {
  TwoLinkScene scene;
  scene.Add({"link_gravity", "J2", {}, {10.0, 0.0, 0.0, 0.0}});
  scene.Add({"base_compliance", "base", {}, {0.0, 1e-6}});
  ExpectPoint(scene.Seen(), 1.4 + 49.03325e-6, 0.0, 0.5 - 137.2931e-6, 3e-8);
  // A first moment is a couple: 2 g = 19.6133 N m at the foot too, however far out the link is.
  scene.robot.effects[0].values = {0.0, 2.0, 0.0, 0.0};
  ExpectPoint(scene.Seen(), 1.4 + 9.80665e-6, 0.0, 0.5 - 27.45862e-6, 3e-9);
}

// kx: 100 N down at y = 1.4: -140 N m about x at the base's origin, 1 urad/Nm: the flange (0, 1.4, 0.5) sinks by
// 196 um and moves by +0.5 * 140 = 70 um along y.
TEST(Conventions, BaseCompliance) {
  TwoLinkScene scene;
  scene.shot().q << 90 * kDegree, 0.0;
  scene.Load({0.0, 0.0, -100.0});
  scene.Add({"base_compliance", "base", {}, {1e-6, 0.0}});
  ExpectPoint(scene.Seen(), 0.0, 1.4 + 70e-6, 0.5 - 196e-6, 4e-8);
}

// s = (100, 0, 50) urad in the frame after J2, down = -z: (s x down)_y = s_x: 100 urad, 40 um down. At q2 = 90 deg s is
// (-50, 0, 100) in the base: -50 urad; the end, now above, moves by -0.4 * 50 = -20 um along x.
TEST(Conventions, SelfWeightSag) {
  TwoLinkScene scene;
  scene.Add({"self_weight_sag", "J2", {{"about", "axis"}}, {100e-6, 0.0, 50e-6}});
  ExpectPoint(scene.Seen(), 1.4, 0.0, 0.5 - 40e-6, 3e-9);
  scene.shot().q << 0.0, 90 * kDegree;
  ExpectPoint(scene.Seen(), 1.0 - 20e-6, 0.0, 0.9, 3e-9);
}

// About v (y) of J1 by link 2: a couple, so the way from J1 to link 2 does not count: 100 urad, 1.4 m * 100 urad down.
// (Without the force that is removed at the link's origin it would be 1 m + 1 m: 200 urad.)
TEST(Conventions, SagOfALinkFurtherOutIsACouple) {
  TwoLinkScene scene;
  scene.Add({"self_weight_sag", "J1", {{"about", "v"}}, {0.0, 0.0, 0.0, 100e-6, 0.0, 0.0}});
  ExpectPoint(scene.Seen(), 1.4, 0.0, 0.5 - 140e-6, 2e-8);
  scene.robot.effects[0].settings["about"] = "u";  // nothing turns about x: s lies in the plane of the boom
  ExpectPoint(scene.Seen(), 1.4, 0.0, 0.5, 2e-8);
}

// 5 kg more: 5 g * 0.4 m = 19.6133 N m more on top of 40 N m; 1 urad/Nm: 59.6133 urad, 23.84532 um down.
TEST(Conventions, Payload) {
  TwoLinkScene scene;
  scene.GiveWay(1, 1e-6);
  scene.Load({0.0, 0.0, -100.0});
  scene.Add({"payload", "V", {}, {5.0}});
  ExpectPoint(scene.Seen(), 1.4, 0.0, 0.5 - 23.84532e-6, 1e-9);
  scene.robot.effects[0].target = "another";
  ExpectPoint(scene.Seen(), 1.4, 0.0, 0.5 - 16e-6, 1e-9);
}

// The flange lies on its side (foot turned by 90 deg about x: base y is up), gravity stated in the base frame acts
// along the base's -z, stated in the measurement frame along its -z, which is the base's... R = Rx(90): z_base =
// -y_station, so that down in the station is -y in the base: it turns J1, not J2.
TEST(Conventions, GravityInTheBaseFrameAndInTheMeasurementFrame) {
  TwoLinkScene scene;
  scene.base_in_station.rotation = RotationFromVector(Vector3<double>(90 * kDegree, 0.0, 0.0));
  scene.GiveWay(0, 1e-6);
  scene.GiveWay(1, 1e-6);
  scene.Load({0.0, 0.0, 0.0});
  scene.Add({"payload", "V", {}, {5.0}});
  const auto in_base = [&] { return Vector3<double>(scene.base_in_station.rotation.transpose() * scene.Seen()); };
  scene.shot().gravity_frame = WrenchFrame::kBase;
  // 5 g 0.4 m = 19.6133 N m about J2: 7.84532 um along the base's -z.
  ExpectPoint(in_base(), 1.4, 0.0, 0.5 - 7.84532e-6, 2e-9);
  scene.shot().gravity_frame = WrenchFrame::kMeasurement;
  // 5 g 1.4 m = 68.64655 N m about J1: 1.4 * 68.64655 urad = 96.10517 um along the base's -y.
  ExpectPoint(in_base(), 1.4, -96.10517e-6, 0.5, 2e-8);
}

// A load stated in the flange frame turns with it: at q2 = 90 deg the flange's -z is the base's +x.
TEST(Conventions, FramesOfAWrench) {
  TwoLinkScene scene;
  scene.shot().q << 0.0, 90 * kDegree;
  scene.GiveWay(1, 1e-6);
  scene.Load({0.0, 0.0, -100.0}, Vector3<double>::Zero(), WrenchFrame::kFlange);
  ExpectPoint(scene.Seen(), 1.0 + 16e-6, 0.0, 0.9);
  scene.Load({0.0, 0.0, -100.0}, Vector3<double>::Zero(), WrenchFrame::kBase);
  ExpectPoint(scene.Seen(), 1.0, 0.0, 0.9);
}

// 100 N down act at x = 0.4 + 0.05 from J2: 5 N m more, 1 urad/Nm: 2 um more down. dz does nothing at q2 = 0; at 90 deg
// the flange's z is the base's -x: the load, 30 mm along it, hangs at x = 1 - 0.03, 3 N m that lift q2 further:
// 0.4 m * 3 urad = 1.2 um along -x.
void ExpectLoadShifted(const EffectSpec& by_50_and_30_mm) {
  TwoLinkScene scene;
  scene.GiveWay(1, 1e-6);
  scene.Load({0.0, 0.0, -100.0});
  scene.Add(by_50_and_30_mm);
  ExpectPoint(scene.Seen(), 1.4, 0.0, 0.5 - 18e-6);
  scene.shot().q << 0.0, 90 * kDegree;
  ExpectPoint(scene.Seen(), 1.0 - 1.2e-6, 0.0, 0.9);
  scene.robot.effects[0].target = "another";
  ExpectPoint(scene.Seen(), 1.0, 0.0, 0.9);
}

TEST(Conventions, LoadCom) { ExpectLoadShifted({"load_com", "V", {}, {0.05, 0.0, 0.03}}); }

// Gravity is along -z of the flange at q2 = 0 and along -x at 90 deg: weights of -50 mm for z and -30 mm for x are the
// shifts of LoadCom there.
TEST(Conventions, LearntShiftOfALoad) {
  ExpectLoadShifted({"learnt_load_shift",
                     "V",
                     {{"down_x", "0"}, {"down_y", "0"}, {"down_z", "-1"}, {"degree", "1"}},
                     {0.0, 0.0, -0.05, 0.0, 0.0, 0.0, -0.03, 0.0, 0.0}});
}

// Where an axis is identified away from its place on the drawing is no length that grows.
TEST(Conventions, AnIdentifiedRobotHasTheLengthsOfTheDrawing) {
  Chain chain = test::TwoLink().chain;
  chain.transforms.insert(chain.transforms.begin() + 2, test::Translate(Axis::kY, 0.0, "b1"));
  const auto drawn = LengthsByLink(chain);
  ASSERT_EQ(drawn.size(), 3u);
  EXPECT_EQ(drawn[1], std::vector<int>{3});
  for (ElementaryTransform& transform : chain.transforms) {
    if (!transform.error.empty()) transform.nominal += 2e-3;
  }
  EXPECT_EQ(LengthsByLink(chain), drawn);
}

// Order 2 at q1 = 30 deg: 0.02 cos 60 + 0.01 sin 60 = 0.018660254 rad;
// 1.4 cos(30 deg + that) = 1.1991630635, 1.4 sin = 0.7225011745.
TEST(Conventions, JointHarmonic) {
  TwoLinkScene scene;
  scene.shot().q << 30 * kDegree, 0.0;
  scene.Add({"joint_harmonic", "J1", {{"order", "2"}}, {0.02, 0.01}});
  ExpectPoint(scene.Seen(), 1.1991630635244341, 0.7225011744479686, 0.5);
}

// On a joint of sign -1: 100 urad more of q2 lift the boom by 40 um.
TEST(Conventions, EncoderSideHasTheSignOfTheJoint) {
  TwoLinkScene scene;
  scene.Add({"joint_harmonic", "J2", {{"order", "1"}}, {100e-6, 0.0}});
  ExpectPoint(scene.Seen(), 1.4, 0.0, 0.5 + 40e-6, 3e-9);
}

// J1 about z: u = x, v = y of the frame after it. q1 = 60 deg, order 1, v_cos = 100 urad: 50 urad about y': the flange
// sinks by 70 um. u_sin at q1 = 90 deg: 100 urad about x', which is the base's y: a marker 0.2 m along the flange's y
// rises by 20 um.
TEST(Conventions, AxisWobble) {
  TwoLinkScene scene;
  scene.shot().q << 60 * kDegree, 0.0;
  scene.Add({"axis_wobble", "J1", {{"order", "1"}}, {0.0, 0.0, 100e-6, 0.0}});
  EXPECT_NEAR(scene.Seen().z(), 0.5 - 70e-6, 1e-11);
  scene.shot().q << 90 * kDegree, 0.0;
  scene.robot.effects[0].values = {0.0, 100e-6, 0.0, 0.0};
  scene.marker = {0.0, 0.2, 0.0};
  EXPECT_NEAR(scene.Seen().z(), 0.5 + 20e-6, 1e-11);
}

// The middle of -1 to 3 is 1: at q1 = 1.5 a gain of 1000 ppm is 500 urad, across a radius of 1.4 m 700 um.
// 1.4 (cos, sin)(1.5005) = (0.0983338, 1.3965423); J2 has no limits: its middle is 0.
TEST(Conventions, EncoderGainCountsFromTheMiddleOfTheLimits) {
  TwoLinkScene scene;
  scene.shot().q << 1.5, 0.0;
  scene.Add({"encoder_gain", "J1", {}, {1e-3}});
  ExpectPoint(scene.Seen(), 0.09833382349424, 1.39654232272316, 0.5, 1e-9);
  TwoLinkScene free;
  free.shot().q << 0.0, 0.5;
  free.Add({"encoder_gain", "J2", {}, {1e-3}});
  // 0.4 sin(0.5005) = 0.191945708, 0.4 cos(0.5005) = 0.350937096
  ExpectPoint(free.Seen(), 1.35093709577, 0.0, 0.69194570798, 1e-9);
}

// q1 = 0.5, 200 ppm: 100 urad on J2, 40 um up at the end (q2 = 0).
TEST(Conventions, JointCoupling) {
  TwoLinkScene scene;
  scene.shot().q << 0.5, 0.0;
  scene.Add({"joint_coupling", "J2", {{"driver", "J1"}}, {200e-6}});
  EXPECT_NEAR(scene.Seen().z(), 0.5 + 40e-6, 1e-11);
}

// Arriving in the positive direction the arm lags behind: -50 urad of q2, 20 um down.
TEST(Conventions, BacklashByApproach) {
  TwoLinkScene scene;
  scene.Add({"backlash", "J2", {{"by", "approach"}}, {50e-6}});
  scene.shot().approach = {0, 1};
  EXPECT_NEAR(scene.Seen().z(), 0.5 - 20e-6, 1e-12);
  scene.shot().approach = {0, -1};
  EXPECT_NEAR(scene.Seen().z(), 0.5 + 20e-6, 1e-12);
  scene.shot().approach = {1, kApproachNotStated};
  EXPECT_NEAR(scene.Seen().z(), 0.5, 1e-12);
}

// A load that pulls down presses the joint to the lower side of its gap, and it is 50 urad lower. With a deadband of
// 80 N m, 40 N m press it by tanh(0.5) = 0.46211715726: 23.105858 urad, 9.2423431 um.
TEST(Conventions, BacklashByTorque) {
  TwoLinkScene scene;
  scene.Load({0.0, 0.0, -100.0});
  scene.Add({"backlash", "J2", {{"by", "torque"}}, {50e-6}});
  EXPECT_NEAR(scene.Seen().z(), 0.5 - 20e-6, 1e-12);
  scene.Load({0.0, 0.0, 100.0});
  EXPECT_NEAR(scene.Seen().z(), 0.5 + 20e-6, 1e-12);
  scene.robot.effects[0].settings["width_Nm"] = "80";
  EXPECT_NEAR(scene.Seen().z(), 0.5 + 9.2423431e-6, 1e-12);
}

// Knots at 0 and 180 deg of J1, d = 180 deg: at 90 deg the first bump is pi^(-1/4) exp(-1/8) = 0.66286596: 100 urad
// make 66.286596 urad, 26.514638 um. Six distances away it is exp(-18) of that, nothing.
TEST(Conventions, LearntDeviationByAnAngle) {
  TwoLinkScene scene;
  scene.shot().q << 90 * kDegree, 0.0;
  scene.Add({"learnt_deviation",
             "J2",
             {{"by", "q"}, {"driver", "J1"}, {"from", "0"}, {"to", "180"}, {"knots", "2"}},
             {100e-6, 0.0}});
  EXPECT_NEAR(scene.Seen().z(), 0.5 + 26.514638e-6, 1e-11);
  scene.robot.effects[0].settings = {{"by", "q"}, {"driver", "J1"}, {"from", "690"}, {"to", "790"}, {"knots", "2"}};
  EXPECT_NEAR(scene.Seen().z(), 0.5, 1e-11);
}

// 30 deg and 60 deg: cos(90 deg) = 0, sin(90 deg) = 1, cos(-30 deg) = 0.8660254, sin(-30 deg) = -0.5. 100 urad each,
// one after the other, turn J2; at 60 deg the end rises by 0.4 cos 60 = 0.2 m per rad.
TEST(Conventions, LearntDeviationByAPair) {
  const double sines[4] = {0.0, 1.0, 0.86602540378, -0.5};
  for (size_t k = 0; k < 4; ++k) {
    TwoLinkScene scene;
    scene.shot().q << 30 * kDegree, 60 * kDegree;
    const double rigid = scene.Seen().z();
    std::vector<double> values(4, 0.0);
    values[k] = 100e-6;
    scene.Add({"learnt_pair_deviation", "J2", {{"driver", "J1"}, {"with", "J2"}}, values});
    EXPECT_NEAR(scene.Seen().z(), rigid + 20e-6 * sines[k], 4e-9) << k;
  }
}

// Order 2 of J1 at 30 deg: cos(60 deg) = 0.5, sin(60 deg) = 0.8660254; at q2 = 0 the end rises by 0.4 m per rad.
TEST(Conventions, LearntWave) {
  const double sizes[2] = {0.5, 0.86602540378};
  for (size_t k = 0; k < 2; ++k) {
    TwoLinkScene scene;
    scene.shot().q << 30 * kDegree, 0.0;
    const double rigid = scene.Seen().z();
    std::vector<double> values(2, 0.0);
    values[k] = 100e-6;
    scene.Add({"learnt_wave_deviation", "J2", {{"driver", "J1"}, {"order", "2"}}, values});
    EXPECT_NEAR(scene.Seen().z(), rigid + 40e-6 * sizes[k], 4e-9) << k;
  }
}

// Nothing up to 20 deg, half of it at 22 deg, all from 24 deg on.
TEST(Conventions, LearntJump) {
  const double at[5] = {-90.0, 20.0, 22.0, 24.0, 170.0}, share[5] = {0.0, 0.0, 0.5, 1.0, 1.0};
  for (int k = 0; k < 5; ++k) {
    TwoLinkScene scene;
    scene.shot().q << at[k] * kDegree, 0.0;
    const double rigid = scene.Seen().z();
    scene.Add({"learnt_jump_deviation", "J2", {{"driver", "J1"}, {"from", "20"}, {"to", "24"}}, {100e-6}});
    EXPECT_NEAR(scene.Seen().z(), rigid + 40e-6 * share[k], 4e-9) << k;
  }
}

// J1 at 30 deg of [-60, 60] is u = 0.5, J2 at 60 deg of [0, 80] v = 0.5; beyond the ranges both stay 1.
TEST(Conventions, LearntProduct) {
  const double inside[3] = {0.5, 0.5, 0.25}, beyond[3] = {1.0, 1.0, 1.0};
  for (size_t k = 0; k < 3; ++k) {
    std::vector<double> values(3, 0.0);
    values[k] = 100e-6;
    for (const bool is_beyond : {false, true}) {
      TwoLinkScene scene;
      scene.shot().q << (is_beyond ? 80.0 : 30.0) * kDegree, (is_beyond ? 90.0 : 60.0) * kDegree;
      const double rise = 0.4 * std::cos(scene.shot().q[1]), rigid = scene.Seen().z();
      scene.Add(
          {"learnt_product_deviation",
           "J2",
           {{"driver", "J1"}, {"with", "J2"}, {"from", "-60"}, {"to", "60"}, {"from_with", "0"}, {"to_with", "80"}},
           values});
      EXPECT_NEAR(scene.Seen().z(), rigid + rise * 100e-6 * (is_beyond ? beyond : inside)[k], 4e-9) << k;
    }
  }
}

// -100 N at 0.4 m are 40 N m about the transform's axis (y, down). Knots at 40 and 120 N m: the first is at its middle,
// pi^(-1/4) = 0.75112554: 75.112554 urad, 30.045022 um up; the second a distance away, exp(-1/2): 18.223227 um.
TEST(Conventions, LearntDeviationByTheTorque) {
  TwoLinkScene scene;
  scene.Load({0.0, 0.0, -100.0});
  scene.Add(
      {"learnt_deviation", "J2", {{"by", "torque_Nm"}, {"from", "40"}, {"to", "120"}, {"knots", "2"}}, {100e-6, 0.0}});
  EXPECT_NEAR(scene.Seen().z(), 0.5 + 30.045022e-6, 1e-10);
  scene.robot.effects[0].values = {0.0, 100e-6};
  EXPECT_NEAR(scene.Seen().z(), 0.5 + 18.223227e-6, 1e-10);
}

// Play of 2 deg (r = 1 deg) on J2, 100 urad. q2 = 0 -> 3 -> 2.5 -> 1 deg: y = 0, 2, 2, 2 - clamped to [0, 2] at 1 deg;
// (y - q) / r = 0, -1, -0.5, +1. At q2 the end moves by 0.4 cos q2 per rad of q2.
TEST(Conventions, Hysteresis) {
  const double q2[4] = {0.0, 3.0, 2.5, 1.0}, behind[4] = {0.0, -1.0, -0.5, 1.0};
  TwoLinkScene scene;
  scene.Add({"hysteresis", "J2", {{"width_deg", "2"}}, {100e-6}});
  for (int k = 0; k < 4; ++k) {
    if (k > 0) scene.campaign.push_back(ShotInput(Eigen::VectorXd::Zero(2)));
    scene.shot().q << 0.0, q2[k] * kDegree;
    const double rigid = 0.5 + 0.4 * std::sin(q2[k] * kDegree);
    EXPECT_NEAR(scene.Seen().z(), rigid + 0.4 * std::cos(q2[k] * kDegree) * 100e-6 * behind[k], 5e-9) << k;
  }
  // The order is that of time where it is stated: 1 deg is then the first shot, 2.5 deg comes after 0.
  const double time[4] = {10.0, 30.0, 20.0, 0.0};
  for (int k = 0; k < 4; ++k) {
    scene.campaign[k].conditions.has_time = true;
    scene.campaign[k].conditions.time = time[k];
  }
  std::swap(scene.campaign[2], scene.campaign[3]);  // look at 2.5 deg: 1, 0, 2.5: y = 1, 1, 1.5; (1.5 - 2.5) / 1 = -1
  EXPECT_NEAR(scene.Seen().z(), 0.5 + 0.4 * std::sin(2.5 * kDegree) - 0.4 * std::cos(2.5 * kDegree) * 100e-6, 5e-9);
}

// A joint deviation of +1 of J2 (sign -1) lifts the end: 0.4 m per rad; the marker's column does not depend on a load.
TEST(Conventions, DerivativeByTheDeviationOfAJoint) {
  const ForwardModel model(test::TwoLink());
  const std::vector<double> theta = model.NominalValues();
  const double latent[2] = {0.0, 0.0};
  std::vector<PointPrediction> seen;
  ASSERT_TRUE(model.Predict(ShotInput(Eigen::VectorXd::Zero(2)), theta.data(), {}, Pose<double>(),
                            {{model.chain().FlangeFrame(), Vector3<double>::Zero(), 0}}, &seen, latent));
  ExpectPoint(seen[0].d_latent.col(0), 0.0, 1.4, 0.0);
  ExpectPoint(seen[0].d_latent.col(1), 0.0, 0.0, 0.4);
}

}  // namespace
}  // namespace sagitta::effect_conventions_test

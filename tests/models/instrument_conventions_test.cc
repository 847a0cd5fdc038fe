// Clocks, frames and signs of the effects of instrument, reflectors and warmth, and of the ways to describe a robot:
// numbers computed by hand.
#include <gtest/gtest.h>

#include "models/denavit_hartenberg.h"
#include "models/effects/first_order_lag.h"
#include "models/sight.h"
#include "tests/support/two_link.h"

namespace sagitta::instrument_conventions_test {
namespace {

using test::ExpectPoint;
using test::TwoLinkScene;

// The base stands 2 m along the station's y, turned by 90 deg about z: the flange (1.4, 0, 0.5) is seen at (0, 3.4,
// 0.5).
TwoLinkScene Seen2mAway() {
  TwoLinkScene scene;
  scene.base_in_station.rotation = RotationFromVector(Vector3<double>(0.0, 0.0, 90 * kDegree));
  scene.base_in_station.translation = {0.0, 2.0, 0.0};
  scene.shot().station = "S1";
  scene.shot().has_time = scene.shot().has_temperature = true;
  return scene;
}

// So many weights, one of them 100e-6.
std::vector<double> AtWeight(size_t count, size_t which) {
  std::vector<double> weights(count, 0.0);
  weights[which] = 100e-6;
  return weights;
}

TEST(InstrumentConventions, TheScene) { ExpectPoint(Seen2mAway().Seen(), 0.0, 3.4, 0.5); }

// 10 ppm/K, 5 K: 50 ppm of the point in the base frame, (70, 0, 25) um there: (0, 70, 25) um in the station.
TEST(InstrumentConventions, ThermalGrowth) {
  TwoLinkScene scene = Seen2mAway();
  scene.shot().temperature = 5.0;
  scene.Add({"thermal_growth", "robot", {}, {10e-6}});
  ExpectPoint(scene.Seen(), 0.0, 3.4 + 70e-6, 0.5 + 25e-6, 1e-12);
}

// The air is at 0, the arm with it; then 600 s long the air warms to 6 K and stands. tau = 600 s, m tau = 6 K:
// at 600 s the arm is at 6 - 6 + 6 exp(-1) = 2.207276647 K, at 1200 s at 6 - (6 - 2.207276647) exp(-1) = 4.604735052 K.
TEST(InstrumentConventions, ThermalLag) {
  const std::vector<double> arm = LaggedBehind({0.0, 600.0, 1200.0}, {0.0, 6.0, 6.0}, 600.0);
  EXPECT_EQ(arm[0], 0.0);
  EXPECT_NEAR(arm[1], 2.207276647, 1e-9);
  EXPECT_NEAR(arm[2], 4.604735052, 1e-9);
  TwoLinkScene scene = Seen2mAway();
  scene.Add({"thermal_growth", "robot", {{"lag_s", "600"}}, {10e-6}});
  scene.campaign.push_back(scene.campaign[0]);
  scene.shot().time = 600.0;
  scene.shot().temperature = 6.0;
  // One arm, one clock: the first shot may be another station's.
  scene.campaign[0].conditions.station = "S2";
  ExpectPoint(scene.Seen(), 0.0, 3.4 + 1.4 * 22.07276647e-6, 0.5 + 0.5 * 22.07276647e-6, 1e-12);
}

// 30 min after the station's first row: 10 um/h along x are 5 um; 20 urad/h about z are 10 urad, z x (0, 3.4, 0.5) =
// (-3.4, 0, 0): -34 um along x. The campaign's clock is another one.
TEST(InstrumentConventions, StationDriftTurnsAboutTheOriginOnTheStationsClock) {
  TwoLinkScene scene = Seen2mAway();
  scene.shot().time = 7200.0;
  scene.shot().station_time = 1800.0;
  scene.Add({"station_drift", "S1", {}, {10e-6 / 3600, 0.0, 0.0, 0.0, 0.0, 20e-6 / 3600}});
  ExpectPoint(scene.Seen(), 5e-6 - 34e-6, 3.4, 0.5, 1e-12);
  scene.shot().station = "S2";
  ExpectPoint(scene.Seen(), 0.0, 3.4, 0.5, 1e-12);
}

// The instrument stands at (0, 1, 0): 100 ppm of (0, 2.4, 0.5).
TEST(InstrumentConventions, StationScaleIsAboutTheInstrument) {
  TwoLinkScene scene = Seen2mAway();
  scene.shot().instrument = {0.0, 1.0, 0.0};
  scene.Add({"station_scale", "S1", {}, {100e-6}});
  ExpectPoint(scene.Seen(), 0.0, 3.4 + 240e-6, 0.5 + 50e-6, 1e-12);
}

// Only after the moment of the campaign's clock; in the flange frame: its x is the base's x, the station's y.
TEST(InstrumentConventions, MarkerShiftIsOnTheCampaignsClockInTheFlange) {
  TwoLinkScene scene = Seen2mAway();
  scene.Add({"marker_shift", "M1", {{"after_s", "100"}}, {1e-3, 0.0, 0.0}});
  scene.shot().time = 150.0;
  ExpectPoint(scene.Seen(), 0.0, 3.401, 0.5, 1e-12);
  scene.shot().time = 50.0;
  scene.shot().station_time = 150.0;
  ExpectPoint(scene.Seen(), 0.0, 3.4, 0.5, 1e-12);
}

// 100 um times pi^(-1/4) at the first knot, the campaign's second 0; 75.112554 um. The station's own axes; a marker's
// are those of the flange, which looks along the station's y.
TEST(InstrumentConventions, LearntMotionsOfAStationAndAMarker) {
  TwoLinkScene scene = Seen2mAway();
  const std::map<std::string, std::string> by_time = {{"by", "time_s"}, {"from", "0"}, {"to", "100"}, {"knots", "2"}};
  scene.Add({"learnt_station_motion", scene.shot().station, by_time, AtWeight(12, 0)});
  scene.shot().time = 0.0;
  scene.shot().station_time = 100.0;
  ExpectPoint(scene.Seen(), 75.112554e-6, 3.4, 0.5, 1e-11);
  scene.robot.effects.clear();
  scene.Add({"learnt_marker_motion", "M1", by_time, AtWeight(6, 0)});
  ExpectPoint(scene.Seen(), 0.0, 3.4 + 75.112554e-6, 0.5, 1e-11);
}

// Two ramps from 0 to 50 s and to 100 s, of height sqrt(6 / 2): a quarter of the second one at 62.5 s, all of it from
// 100 s on. 100 um times sqrt(3) are 173.205081 um.
TEST(InstrumentConventions, LearntMotionOfAMarkerByRamps) {
  const double times[4] = {50.0, 62.5, 100.0, 1000.0}, share[4] = {0.0, 0.25, 1.0, 1.0};
  for (size_t k = 0; k < 4; ++k) {
    TwoLinkScene scene = Seen2mAway();
    scene.Add({"learnt_marker_motion",
               "M1",
               {{"by", "time_s"}, {"from", "0"}, {"to", "100"}, {"knots", "2"}, {"shape", "ramps"}},
               AtWeight(6, 1)});
    scene.shot().time = times[k];
    ExpectPoint(scene.Seen(), 0.0, 3.4 + share[k] * 173.205081e-6, 0.5, 1e-11);
  }
}

// 100 urad times pi^(-1/4) about z of the station: (0, 3.4) moves by -3.4 * 75.112554 urad along x.
// The nominal flange of the scene turns with J1 and J2 about -y and has the axes of the base at 0 deg: down, -z of the
// base, is -sin of their sum along x of the flange. At q2 = -30 deg that is 0.5, at -20 deg 0.3420201, at 0 nothing.
TEST(InstrumentConventions, LearntSeatOfAMarkerIsTheSideThatIsDown) {
  const double q2[3] = {-30.0, -20.0, 0.0}, share[3] = {1.0, 0.2101007, 0.0};
  for (int k = 0; k < 3; ++k) {
    TwoLinkScene scene;
    scene.shot().q << 0.0, q2[k] * kDegree;
    const Vector3<double> rigid = scene.Seen();
    scene.Add({"learnt_marker_seat",
               "M1",
               {{"along_x", "1"},
                {"along_y", "0"},
                {"along_z", "0"},
                {"down_x", "0"},
                {"down_y", "0"},
                {"down_z", "-1"},
                {"from", "0.3"},
                {"to", "0.5"}},
               {0.0, 30e-6, 0.0}});
    EXPECT_NEAR(scene.Seen().y() - rigid.y(), 30e-6 * share[k], 1e-11) << k;
  }
}

// A sixth of the period: cos(60 deg) = 0.5, sin(60 deg) = 0.8660254.
TEST(InstrumentConventions, LearntWaveOfAStation) {
  const double sizes[2] = {0.5, 0.86602540378};
  for (size_t k = 0; k < 6; ++k) {
    TwoLinkScene scene;
    scene.shot().has_time = true;
    scene.shot().time = 50.0;
    const Vector3<double> rigid = scene.Seen();
    std::vector<double> values(6, 0.0);
    values[k] = 30e-6;
    scene.Add({"learnt_station_wave", scene.shot().station, {{"period_s", "300"}}, values});
    const Vector3<double> moved = scene.Seen() - rigid;
    EXPECT_NEAR(moved[static_cast<long>(k / 2)], 30e-6 * sizes[k % 2], 1e-14) << k;
    EXPECT_NEAR(moved.norm(), 30e-6 * sizes[k % 2], 1e-14) << k;
  }
}

TEST(InstrumentConventions, LearntTurnOfAStationIsAboutTheMeasurementFrame) {
  TwoLinkScene scene = Seen2mAway();
  scene.shot().time = 0.0;
  scene.Add({"learnt_station_motion",
             scene.shot().station,
             {{"by", "time_s"}, {"from", "0"}, {"to", "100"}, {"knots", "2"}},
             AtWeight(12, 10)});
  ExpectPoint(scene.Seen(), -3.4 * 75.112554e-6, 3.4, 0.5, 1e-11);
}

// Seen from (0, 1, 0) the point (0, 3.4, 0.5) is at the azimuth 90 deg and at a range of sqrt(2.4^2 + 0.5^2) =
// 2.4515301 m. 100 urad of azimuth move it by -2.4 m * 100 urad along x, of elevation by (0, -0.5, 2.4) * 100 urad, 100
// um of range by the direction (0, 0.97898042, 0.20395425); all times pi^(-1/4) at the first knot, 0.75112554.
TEST(InstrumentConventions, LearntErrorOfAReading) {
  const struct {
    const char *reads, *by, *from, *to;
    double size;
    Vector3<double> moved;
  } cases[] = {{"azimuth", "azimuth_deg", "450", "510", 100e-6, {-240e-6, 0.0, 0.0}},
               {"elevation", "azimuth_deg", "90", "150", 100e-6, {0.0, -50e-6, 240e-6}},
               {"range", "range_mm", "2451.5301", "3000", 100e-6, {0.0, 97.898042e-6, 20.395425e-6}},
               {"azimuth", "elevation_deg", "11.768288", "40", 100e-6, {-240e-6, 0.0, 0.0}}};
  for (const auto& one : cases) {
    TwoLinkScene scene = Seen2mAway();
    scene.shot().instrument = {0.0, 1.0, 0.0};
    scene.Add({"learnt_reading",
               "S1",
               {{"reads", one.reads}, {"by", one.by}, {"from", one.from}, {"to", one.to}, {"knots", "2"}},
               {one.size, 0.0}});
    const Vector3<double> moved = 0.75112554 * one.moved;
    ExpectPoint(scene.Seen(), moved.x(), 3.4 + moved.y(), 0.5 + moved.z(), 1e-11);
    scene.shot().station = "S2";
    ExpectPoint(scene.Seen(), 0.0, 3.4, 0.5, 1e-12);
  }
}

// From the origin the range is sqrt(3.4^2 + 0.5^2) = 3.43656806 m: 0.43656806 turns of a wave of 1 m and three whole
// ones, along (0, 0.98935914, 0.14549399).
TEST(InstrumentConventions, LearntWaveOfTheRange) {
  const double size[2] = {std::cos(2.0 * kPi * 0.43656806), std::sin(2.0 * kPi * 0.43656806)};
  for (int k = 0; k < 2; ++k) {
    TwoLinkScene scene = Seen2mAway();
    scene.Add({"learnt_range_wave", "S1", {{"period_mm", "1000"}}, {k == 0 ? 100e-6 : 0.0, k == 1 ? 100e-6 : 0.0}});
    const double along = 100e-6 * size[k];
    ExpectPoint(scene.Seen(), 0.0, 3.4 + 0.98935914 * along, 0.5 + 0.14549399 * along, 1e-11);
  }
}

// The column (0.5 m, link 0), the boom (1 m, link 1) and what is after J2 (0.4 m, link 2) have two knots each. 100 ppm
// of the boom at the first: 75.112554 um away from the column, which is along the station's y.
TEST(InstrumentConventions, LearntGrowthIsByLink) {
  TwoLinkScene scene = Seen2mAway();
  scene.shot().time = 0.0;
  scene.Add(
      {"learnt_growth", "robot", {{"by", "time_s"}, {"from", "0"}, {"to", "100"}, {"knots", "2"}}, AtWeight(6, 2)});
  ExpectPoint(scene.Seen(), 0.0, 3.4 + 75.112554e-6, 0.5, 1e-11);
}

// 100 urad on J2 lift the flange by 40 um, after the moment of the campaign's clock.
TEST(InstrumentConventions, JointSlipIsOnTheCampaignsClock) {
  TwoLinkScene scene = Seen2mAway();
  scene.Add({"joint_slip", "J2", {{"after_s", "100"}}, {100e-6}});
  scene.shot().time = 150.0;
  EXPECT_NEAR(scene.Seen().z(), 0.5 + 40e-6, 1e-11);
  scene.shot().time = 50.0;
  scene.shot().station_time = 150.0;
  EXPECT_NEAR(scene.Seen().z(), 0.5, 1e-11);
}

// tau = 1000 s, 500 s after the station's first row: exp(-0.5) = 0.6065306597 is left of 20 um along x and of 10 urad
// about z, which moves (0, 3.4, 0.5) by -34 um along x.
TEST(InstrumentConventions, WarmUp) {
  TwoLinkScene scene = Seen2mAway();
  scene.Add({"warm_up", "S1", {{"tau_s", "1000"}}, {20e-6, 0.0, 0.0, 0.0, 0.0, 10e-6}});
  scene.shot().station_time = 500.0;
  scene.shot().time = 9000.0;
  const double left = 0.6065306597126334;
  ExpectPoint(scene.Seen(), left * (20e-6 - 34e-6), 3.4, 0.5, 1e-12);
  // Poses every 60 s, then none for 3600 s: it begins again. 120 s after that exp(-0.12) = 0.8869204367 is left.
  scene.campaign.clear();
  for (const double t : {0.0, 60.0, 120.0, 180.0, 3780.0, 3840.0, 3900.0}) {
    scene.campaign.push_back(ShotInput(Eigen::VectorXd::Zero(2)));
    scene.shot().q[1] = 1e-12 * t;  // another pose each time
    scene.shot().station = "S1";
    scene.shot().has_time = true;
    scene.shot().time = scene.shot().station_time = t;
  }
  ExpectPoint(scene.Seen(), 0.8869204367171575 * (20e-6 - 34e-6), 3.4, 0.5, 1e-8);
  EXPECT_NEAR(scene.Seen().x(), 0.8869204367171575 * (20e-6 - 34e-6), 1e-12);
  // An instrument that stayed on goes on: exp(-3.9) = 0.0202419114 is left.
  scene.robot.effects[0].settings["pauses"] = "go_on";
  EXPECT_NEAR(scene.Seen().x(), 0.020241911445804391 * (20e-6 - 34e-6), 1e-12);
}

// Instrument at (0, 0.4, 0.5): the flange is seen 3 m along y, azimuth 90 deg, elevation 0. az_sin = 10 urad: the
// azimuth is 10 urad too large, the point -30 um along x. az_cos does nothing there. el_cos = 20 urad: 60 um up.
TEST(InstrumentConventions, StationEccentricity) {
  TwoLinkScene scene = Seen2mAway();
  scene.shot().instrument = {0.0, 0.4, 0.5};
  scene.Add({"station_eccentricity", "S1", {}, {7e-6, 10e-6, 20e-6, 5e-6}});
  ExpectPoint(scene.Seen(), -30e-6, 3.4, 0.5 + 60e-6, 1e-12);
  // From (-3, 3.4, -3.5) the flange is seen at azimuth 0 and elevation 53.13 deg (d = (3, 0, 4), s = 5): az_cos = 7
  // urad move it by 3 m * 7 urad = 21 um along y. The elevation is 20 * 0.6 + 5 * 0.8 = 16 urad too large:
  // (-4, 0, 3) m * 16 urad = (-64, 0, 48) um.
  scene.shot().instrument = {-3.0, 3.4, -3.5};
  ExpectPoint(scene.Seen(), -64e-6, 3.4 + 21e-6, 0.5 + 48e-6, 1e-12);
}

// 25 um along (3, 0, 4) / 5.
TEST(InstrumentConventions, StationRangeOffset) {
  TwoLinkScene scene = Seen2mAway();
  scene.shot().instrument = {-3.0, 3.4, -3.5};
  scene.Add({"station_range_offset", "S1", {}, {25e-6}});
  ExpectPoint(scene.Seen(), 15e-6, 3.4, 0.5 + 20e-6, 1e-12);
}

// Straight above the instrument there is a range and no azimuth: 25 um up; what needs an azimuth does nothing.
TEST(InstrumentConventions, StraightAboveTheInstrument) {
  TwoLinkScene scene = Seen2mAway();
  scene.shot().instrument = {0.0, 3.4, -3.5};
  scene.Add({"station_range_offset", "S1", {}, {25e-6}});
  ExpectPoint(scene.Seen(), 0.0, 3.4, 0.5 + 25e-6, 1e-12);
  const SightTerm range{0, Sensed::kRange, SightLaw::kOne, {0.0, 3.4, -3.5}};
  const SightGradient sight = DifferentiateSight(range, {0.0, 3.4, 0.5}, Vector3<double>::UnitX());
  ExpectPoint(sight.displacement, 0.0, 0.0, 1.0, 1e-12);
  // A step aside turns the line of sight by 1 / 4 m.
  EXPECT_LT((sight.by_point - Vector3<double>(0.25, 0.25, 0.0).asDiagonal().toDenseMatrix()).norm(), 1e-12);
  for (const SightLaw law : {SightLaw::kCosAzimuth, SightLaw::kSinAzimuth}) {
    const SightTerm by_azimuth{0, Sensed::kRange, law, {0.0, 3.4, -3.5}};
    EXPECT_EQ(DifferentiateSight(by_azimuth, {0.0, 3.4, 0.5}, Vector3<double>::UnitX()).displacement.norm(), 0.0);
  }
}

// 2 urad/m over 5 m: the chord of the arc lies 5 urad below its tangent, (-4, 0, 3) m * 5 urad = (-20, 0, 15) um.
TEST(InstrumentConventions, StationRefraction) {
  TwoLinkScene scene = Seen2mAway();
  scene.shot().instrument = {-3.0, 3.4, -3.5};
  scene.Add({"station_refraction", "S1", {}, {2e-6}});
  ExpectPoint(scene.Seen(), -20e-6, 3.4, 0.5 + 15e-6, 1e-12);
}

// The flange's axis is that of J2, y, which the station sees as -x. From (-3, 3.4, -3.5) the direction to the
// instrument is (-3, 0, -4) / 5: cos psi = 0.6, psi = 0.927295218 rad, psi^2 = 0.859876421. 100 um of that along (3, 0,
// 4) / 5: (51.5925853, 0, 68.7901137) um. With axis z of the flange (station z): cos psi = -0.8, psi = 2.498091545,
// psi^2 = 6.240461366.
TEST(InstrumentConventions, MarkerAcceptance) {
  TwoLinkScene scene = Seen2mAway();
  scene.shot().instrument = {-3.0, 3.4, -3.5};
  scene.Add({"marker_acceptance", "M1", {}, {100e-6}});
  ExpectPoint(scene.Seen(), 51.5925853e-6, 3.4, 0.5 + 68.7901137e-6, 1e-12);
  scene.robot.effects[0].settings = {{"axis", "z"}};
  ExpectPoint(scene.Seen(), 374.4276820e-6, 3.4, 0.5 + 499.2369093e-6, 1e-12);
  scene.robot.effects[0].settings = {{"axis", "-x"}};  // the station's -y: 90 deg, psi^2 = 2.467401100
  ExpectPoint(scene.Seen(), 148.0440660e-6, 3.4, 0.5 + 197.3920880e-6, 1e-12);
  scene.robot.effects[0].target = "M2";
  ExpectPoint(scene.Seen(), 0.0, 3.4, 0.5, 1e-12);
}

// acos(0.9995)^2 = 0.03162409...^2 on both sides of where the series begins.
TEST(InstrumentConventions, SquaredAngleIsSmooth) {
  EXPECT_NEAR(SquaredAngle(1.0), 0.0, 1e-300);
  EXPECT_NEAR(SquaredAngle(std::cos(0.03)), 9e-4, 1e-13);
  EXPECT_NEAR(SquaredAngle(std::cos(0.05)), 25e-4, 1e-13);
  EXPECT_NEAR(SquaredAngle(-1.0), 9.869604401089358, 1e-12);
}

// theta = 90, d = 0.3, a = 0.5, alpha = 90, beta = 30 deg. The flange's point (1, 0, 0), from the flange inwards:
// standard: Ry(30) -> (0.8660254, 0, -0.5); Rx(90) -> (0.8660254, 0.5, 0); Tx -> (1.3660254, 0.5, 0);
//           Tz -> z = 0.3; Rz(90) -> (-0.5, 1.3660254, 0.3)
// modified: Tz -> (1, 0, 0.3); Rz(90) -> (0, 1, 0.3); Ry(30) -> (0.15, 1, 0.2598076); Tx -> (0.65, 1, 0.2598076);
//           Rx(90) -> (0.65, -0.2598076, 1)
TEST(DescriptionConventions, BetaComesLastInStandardAndBeforeThetaInModified) {
  for (const DhConvention convention : {DhConvention::kStandard, DhConvention::kModified}) {
    Robot robot;
    robot.chain = test::DhArm(convention, {{0.5, 90, 0.3, 90, JointType::kRevolute, 30}});
    const ForwardModel model(robot);
    const std::vector<double> theta = model.NominalValues();
    const Vector3<double> seen = model.PointInBase<double>(ShotInput(Eigen::VectorXd::Zero(1)), theta.data(),
                                                           model.chain().FlangeFrame(), Vector3<double>::UnitX());
    if (convention == DhConvention::kStandard) {
      ExpectPoint(seen, -0.5, 1.3660254037844386, 0.3, 1e-12);
    } else {
      ExpectPoint(seen, 0.65, -0.25980762113533157, 1.0, 1e-12);
    }
  }
}

// Fixed axes: roll 90 about x first, then pitch 90 about y: y -> z -> x. (0, 1, 0) of the flange is (1, 0, 0).
TEST(DescriptionConventions, RpyIsAboutFixedAxesXFirst) {
  DhTable table;
  table.links.resize(1);
  table.links[0].joint = 0;
  table.flange_xyz = {0.0, 0.0, 0.2};
  table.flange_rpy = {90 * kDegree, 90 * kDegree, 0.0};
  Robot robot;
  robot.chain = ChainFromDhTable(test::Revolutes(1), {}, table);
  const ForwardModel model(robot);
  const std::vector<double> theta = model.NominalValues();
  const Vector3<double> seen = model.PointInBase<double>(ShotInput(Eigen::VectorXd::Zero(1)), theta.data(),
                                                         model.chain().FlangeFrame(), Vector3<double>::UnitY());
  ExpectPoint(seen, 1.0, 0.0, 0.2, 1e-12);
}

}  // namespace
}  // namespace sagitta::instrument_conventions_test

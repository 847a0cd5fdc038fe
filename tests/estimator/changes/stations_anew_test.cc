// What changed between two estimates where the instrument, the tool or both were set up anew, or where something
// happened within a campaign, and what a table's redundant parameters are then called. Measured by kinematics of its
// own (tests/support/dh_campaigns.h, kr270_experiment.h).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "estimator/changes/changes.h"
#include "estimator/changes/sparse_search.h"
#include "estimator/sagitta.h"
#include "problems/failure.h"
#include "tests/support/dh_campaigns.h"
#include "tests/support/moved_kr270.h"

namespace sagitta::stations_anew_test {
namespace {

using test::DhCampaign;
using test::Kr270Truth;
using ::testing::HasSubstr;

KnownRobot Estimated(const DhCampaign& campaign) {
  const CalibrationProblem problem = test::ProblemOf(campaign);
  const Calibration calibration{problem, EstimateJointly(problem), {}};
  EXPECT_TRUE(IsUsable(calibration.estimate.status)) << calibration.estimate.message;
  return KnownFrom(calibration);
}

// Of a first campaign, and of one after it with another seed.
Changes Between(DhCampaign before, DhCampaign after, std::uint64_t seed = 1) {
  before.seed = 2 * seed, after.seed = 2 * seed + 1;
  return FindChanges(Estimated(before), Estimated(after));
}

std::string NamesOf(const Changes& changes) {
  std::string names;
  for (const Change& change : changes.changes) names += WordOf(change.kind) + "/" + change.target + " ";
  return names;
}

// The change of that name; nothing where there is none.
const Change* Find(const Changes& changes, const std::string& name) {
  for (const Change& change : changes.changes) {
    if (WordOf(change.kind) + "/" + change.target == name) return &change;
  }
  return nullptr;
}

// Within four standard deviations, which all but one in 16 000 are.
void ExpectSize(const Change* change, double truth) {
  ASSERT_NE(change, nullptr);
  EXPECT_NEAR(change->value, truth, 2.0 * (change->ci95[1] - change->ci95[0]) + 1e-9) << change->words;
}

TEST(StationsAnewTest, ADistantInstrumentIsAMovedBaseAndNothingElse) {
  const struct {
    Vector3<double> xyz, rotvec;
  } places[] = {{{-1.3, 1.5, 0.21}, {-0.03, 0.01, -0.4}},  {{2.31, -0.8, 0.41}, {0.02, -0.01, 1.101}},
                {{2.35, -0.8, 0.41}, {0.02, -0.01, 1.11}}, {{2.6, -0.8, 0.41}, {0.02, -0.01, 1.2}},
                {{5.3, -0.8, 0.41}, {0.02, -0.01, 1.1}},   {{0.4, 2.4, -0.9}, {0.5, -0.9, 2.4}},
                {{0.1, 0.2, 30.0}, {0.0, 3.1, 0.0}}};
  for (const auto& place : places) {
    DhCampaign after;
    after.base_xyz = place.xyz, after.base_rotvec = place.rotvec;
    const Changes changes = Between({}, after);
    ASSERT_EQ(NamesOf(changes), "base/S1 ") << changes.words;
    ExpectSize(&changes.changes[0], 1e3 * (place.xyz - DhCampaign().base_xyz).norm());
    EXPECT_GT(changes.changes[0].probability, 0.99);
    EXPECT_LT(changes.after_rms, 1e-4);
  }
}

// Where the instrument stands anew, what happened to the robot has the same size and about the same interval.
TEST(StationsAnewTest, ASlipIsFoundFromAnotherPlace) {
  DhCampaign after;
  after.slip_mrad[2] = 0.3;
  const Changes here = Between({}, after);
  ASSERT_EQ(NamesOf(here), "joint_zero/j3 ") << here.words;
  after.base_xyz << -1.3, 1.5, 0.21;
  after.base_rotvec << -0.03, 0.01, -0.4;
  const Changes there = Between({}, after);
  ASSERT_EQ(there.changes.size(), 2u) << there.words;
  ASSERT_NE(Find(there, "base/S1"), nullptr);
  const Change *slip = Find(there, "joint_zero/j3"), *slip_here = Find(here, "joint_zero/j3");
  ExpectSize(slip, 0.3);
  ExpectSize(slip_here, 0.3);
  EXPECT_LT(slip->ci95[1] - slip->ci95[0], 2.0 * (slip_here->ci95[1] - slip_here->ci95[0]));
  EXPECT_THAT(there.notes, ::testing::Contains(HasSubstr("j1")));  // its slip is a turn of the base
}

TEST(StationsAnewTest, IntervalsHoldForASlipAndAKnockFromAnotherPlace) {
  int slips = 0, knocks = 0;
  constexpr int kSeeds = 20;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    DhCampaign after;
    after.slip_mrad[3] = 0.5;
    after.base_xyz << -1.3, 1.5 + 0.1 * seed, 0.21;
    after.base_rotvec << -0.03, 0.01, -3.0 + 0.3 * seed;
    Changes changes = Between({}, after, seed);
    ASSERT_EQ(changes.changes.size(), 2u) << changes.words;
    const Change* slip = Find(changes, "joint_zero/j4");
    ASSERT_NE(slip, nullptr) << changes.words;
    slips += slip->ci95[0] <= 0.5 && 0.5 <= slip->ci95[1];
    after.slip_mrad[3] = 0.0;
    for (Vector3<double>& tool : after.tools) tool += Vector3<double>(0.3e-3, 0.0, 0.2e-3);
    changes = Between({}, after, 100 + seed);
    ASSERT_EQ(changes.changes.size(), 2u) << changes.words;
    const Change* knock = Find(changes, "tool/flange");
    ASSERT_NE(knock, nullptr) << changes.words;
    const double truth[6] = {0.3, 0.0, 0.2, 0.0, 0.0, 0.0};
    for (int i = 0; i < 6; ++i) {
      knocks += knock->parts[i].ci95[0] <= truth[i] && truth[i] <= knock->parts[i].ci95[1];
    }
  }
  // Of 20 (120) at 95 %: fewer than 16 (106) are 1 in 400 (1 in 300).
  EXPECT_GE(slips, 16);
  EXPECT_GE(knocks, 106);
  RecordProperty("slips", slips);
  RecordProperty("knocks", knocks);
}

TEST(StationsAnewTest, OtherStationNamesAreCompared) {
  DhCampaign after;
  after.station = "tracker on the platform";
  after.base_xyz << -1.3, 1.5, 0.21;
  after.base_rotvec << -0.03, 0.01, -0.4;
  Changes changes = Between({}, after);
  EXPECT_EQ(NamesOf(changes), "") << changes.words;
  EXPECT_GT(changes.nothing, 0.5);
  EXPECT_LT(changes.before_rms, 1e-4);  // but for where the instrument stands
  EXPECT_THAT(changes.notes, ::testing::Contains(HasSubstr("no station")));
  EXPECT_THAT(changes.notes, ::testing::Contains(HasSubstr("j1")));
  after.slip_mrad[2] = 0.3;
  changes = Between({}, after);
  ASSERT_EQ(NamesOf(changes), "joint_zero/j3 ") << changes.words;
  ExpectSize(&changes.changes[0], 0.3);
}

TEST(StationsAnewTest, OtherToolsAreCompared) {
  DhCampaign after;
  after.markers = {"T1", "T2", "T3", "T4"};
  after.tools = {{0.1, 0.0, 0.2}, {-0.1, 0.02, 0.2}, {0.0, 0.12, 0.15}, {0.0, 0.0, 0.25}};
  Changes changes = Between({}, after);
  EXPECT_EQ(NamesOf(changes), "") << changes.words;
  EXPECT_THAT(changes.notes, ::testing::Contains(HasSubstr("no marker")));
  after.slip_mrad[2] = 0.3;
  after.station = "S9";
  after.base_xyz << -1.3, 1.5, 0.21;
  changes = Between({}, after);
  ASSERT_EQ(NamesOf(changes), "joint_zero/j3 ") << changes.words;
  ExpectSize(&changes.changes[0], 0.3);
}

// Of a planar arm, heights of base and markers are one.
TEST(StationsAnewTest, NothingInCommonOfAPlanarArm) {
  DhCampaign before;
  before.nominal = {{0.35, 0, 0.4, 0}, {0.3, 0, 0, 0}};
  before.rows = {{0.3503, 0, 0.4, 0}, {0.2998, 0, 0, 0.02}};
  before.slip_mrad = {0, 0};
  DhCampaign after = before;
  after.station = "S2", after.markers = {"T1", "T2", "T3"};
  after.base_xyz << -1.3, 1.5, 0.21;
  Changes changes = Between(before, after);
  EXPECT_EQ(NamesOf(changes), "") << changes.words;
  after.rows[0].a += 0.4e-3;
  changes = Between(before, after);
  ASSERT_EQ(NamesOf(changes), "geometry/j1.a ") << changes.words;
  ExpectSize(&changes.changes[0], 0.4);
}

TEST(StationsAnewTest, AToolMountedAnewIsOneMotion) {
  DhCampaign after;
  const Matrix3<double> turn = RotationFromVector<double>(Vector3<double>(0.2, -0.1, 1.4));
  const Vector3<double> shift(0.02, -0.03, 0.05);
  for (Vector3<double>& tool : after.tools) tool = turn * tool + shift;
  after.base_xyz << -1.3, 1.5, 0.21;
  after.slip_mrad[1] = -0.4;
  const Changes changes = Between({}, after);
  ASSERT_EQ(changes.changes.size(), 3u) << changes.words;
  ExpectSize(Find(changes, "tool/flange"), 1e3 * shift.norm());
  ExpectSize(Find(changes, "joint_zero/j2"), -0.4);
  EXPECT_NE(Find(changes, "base/S1"), nullptr);
}

TEST(StationsAnewTest, MarkersThatChangedPlacesAreReseated) {
  DhCampaign after;
  std::swap(after.tools[0], after.tools[2]);
  const Changes changes = Between({}, after);
  ASSERT_EQ(changes.changes.size(), 2u) << changes.words;
  ExpectSize(Find(changes, "marker/P1"), 1e3 * (after.tools[0] - after.tools[2]).norm());
  ExpectSize(Find(changes, "marker/P3"), 1e3 * (after.tools[0] - after.tools[2]).norm());
  std::swap(after.tools[0], after.tools[1]);
  const Changes three = Between({}, after);
  ASSERT_EQ(three.changes.size(), 1u) << three.words;  // all of them: one cause
  const Change* all = Find(three, "markers/flange");
  ASSERT_NE(all, nullptr) << three.words;
  ASSERT_EQ(all->parts.size(), 9u);
  for (int i = 0; i < 9; ++i) {
    const Change::Part& part = all->parts[i];
    const double moved = 1e3 * (after.tools[i / 3] - DhCampaign().tools[i / 3])[i % 3];
    EXPECT_NEAR(part.value, moved, 2.0 * (part.ci95[1] - part.ci95[0])) << part.name;
  }
}

// A joint that was mastered anew is found at any size, the instrument at its place or not.
TEST(StationsAnewTest, AJointMasteredAnewIsFound) {
  for (const double slip : {20.0, -150.0}) {
    DhCampaign after;
    after.slip_mrad[2] = slip;
    Changes changes = Between({}, after);
    ASSERT_EQ(NamesOf(changes), "joint_zero/j3 ") << changes.words;
    ExpectSize(&changes.changes[0], slip);
    after.base_xyz << -1.3, 1.5, 0.21;
    after.base_rotvec << -0.03, 0.01, -0.4;
    changes = Between({}, after);
    ASSERT_EQ(changes.changes.size(), 2u) << changes.words;
    ExpectSize(Find(changes, "joint_zero/j3"), slip);
  }
}

// Every one of many instruments stands elsewhere.
TEST(StationsAnewTest, ASlipIsFoundAmongManyStationsSetUpAnew) {
  constexpr int kStations = 8;
  const auto estimated = [](double slip, std::uint64_t seed) {
    test::Kr270Truth truth;
    truth.errors[7] += slip;  // dq3
    test::RandomNumbers random(seed);
    truth.base_xyz.clear(), truth.base_rotvec.clear();
    for (int s = 0; s < kStations; ++s) {
      truth.base_xyz.emplace_back(random.Uniform(-5, 5), random.Uniform(-5, 5), random.Uniform(-1, 1));
      truth.base_rotvec.emplace_back(0.0, 0.0, random.Uniform(-3, 3));
    }
    const test::Kr270Design design = test::CampaignOf(48, kStations, 3e-5, seed);
    Measurements data = test::DesignMeasurements(design);
    test::MeasureKr270(truth, design.sigma, 1000 + seed, &data);
    const CalibrationProblem problem = test::Kr270ProblemOf(data, Experiment());
    return KnownFrom(Calibration{problem, EstimateJointly(problem), {}});
  };
  const Changes changes = FindChanges(estimated(0.0, 1), estimated(0.4e-3, 2));
  ASSERT_EQ(changes.changes.size(), 1u + kStations) << changes.words;
  ExpectSize(Find(changes, "joint_zero/A3"), 0.4);
}

// Half an hour of one pose a minute. `moved`: where station S1 sees its points then, t from the first row.
constexpr int kPoses = 30, kFirstLate = 15;
constexpr double kBegin = 5000.0, kBetween = 60.0, kLength = kBetween * (kPoses - 1);  // s

Vector3<double> NotMoved(double) { return Vector3<double>::Zero(); }

// The robot is `early` up to the 15th pose and `late` from there on; `effects` are estimated.
KnownRobot Eventful(const std::vector<EffectSpec>& effects, const Kr270Truth& early, const Kr270Truth& late,
                    std::uint64_t seed, const std::function<Vector3<double>(double)>& moved = NotMoved) {
  const test::Kr270Design design = test::CampaignOf(kPoses, 2, 3e-5, seed);
  Measurements data = test::DesignMeasurements(design), after = data;
  test::MeasureKr270(early, design.sigma, 1000 + seed, &data);
  test::MeasureKr270(late, design.sigma, 1000 + seed, &after);
  for (Shot& shot : data.shots) {
    shot.has_time = true;
    shot.time = kBegin + kBetween * shot.configuration;
  }
  for (size_t i = 0; i < data.observations.size(); ++i) {
    Observation& row = data.observations[i];
    const Shot& shot = data.shots[row.shot];
    if (shot.configuration >= kFirstLate) row.point_in_station = after.observations[i].point_in_station;
    if (shot.station == 0) row.point_in_station += moved(shot.time - kBegin);
  }
  Robot robot = test::Kr270Robot();
  robot.effects = effects;
  const CalibrationProblem problem = MakeCalibrationProblem(robot, data, Experiment());
  return KnownFrom(Calibration{problem, EstimateJointly(problem), {}});
}

const EffectSpec kSlip{"joint_slip", "A3", {{"after_s", "870"}}, {}};
const EffectSpec kReseat{"marker_shift", "P2", {{"after_s", "870"}}, {}};

Kr270Truth Slipped(double by) {
  Kr270Truth truth;
  truth.errors[7] += by;  // dq3
  return truth;
}

Kr270Truth Reseated() {
  Kr270Truth truth;
  truth.tools[1] += Vector3<double>(0.25e-3, -0.15e-3, 0.2e-3);
  return truth;
}

Kr270Truth StationMoved() {
  Kr270Truth truth;
  truth.base_xyz[0] += Vector3<double>(0.3e-3, -0.2e-3, 0.15e-3);
  return truth;
}

// Of day one, in which it happens, and of a day on which nothing more does.
TEST(EventTest, WhatTheOldEstimateHoldsIsNoChange) {
  // One ramp is sqrt(6) times its weight high.
  const Vector3<double> weight = StationMoved().base_xyz[0] - Kr270Truth().base_xyz[0];
  EffectSpec jump{"learnt_station_motion", "S1", {{"by", "time_s"}, {"shape", "ramps"}, {"knots", "1"}}, {}};
  jump.settings.insert({{"from", "840"}, {"to", "900"}, {"moves", "point"}});
  for (int a = 0; a < 3; ++a) jump.values.push_back(weight[a] / std::sqrt(6.0));
  const struct {
    EffectSpec event;
    Kr270Truth after;
    std::string name;
  } cases[] = {{kSlip, Slipped(3e-4), "joint_zero/A3 "},
               {kReseat, Reseated(), "marker/P2 "},
               {jump, StationMoved(), "base/S1 "}};
  for (const auto& one : cases) {
    KnownRobot eventful = Eventful({one.event}, {}, one.after, 1);
    const KnownRobot settled = Eventful({}, one.after, one.after, 2);
    // The event is one of its own day, and not of what it began with.
    const Changes back = FindChanges(settled, eventful);
    EXPECT_EQ(NamesOf(back), one.name) << back.words;
    EXPECT_THAT(back.notes, ::testing::Contains(HasSubstr("at its beginning")));
    for (const bool states_times : {true, false}) {
      if (!states_times) eventful.measured_conditions = {};  // as older files
      const Changes changes = FindChanges(eventful, settled);
      EXPECT_EQ(NamesOf(changes), "") << one.name << changes.words;
      EXPECT_THAT(changes.notes, ::testing::Contains(HasSubstr("at its end")));
      EXPECT_THAT(changes.notes, ::testing::Not(::testing::Contains(HasSubstr("assumed in the other"))));
    }
  }
}

// A joint that slips again is as well seen as one that has not slipped before, and a tool that is mounted anew carries
// its reseated marker.
TEST(EventTest, WhatFollowsAnEventIsNamed) {
  const Changes again =
      FindChanges(Eventful({kSlip}, {}, Slipped(3e-4), 3), Eventful({}, Slipped(6e-4), Slipped(6e-4), 4));
  ASSERT_EQ(NamesOf(again), "joint_zero/A3 ") << again.words;
  ExpectSize(&again.changes[0], 0.3);
  Kr270Truth anew = Reseated();
  for (Vector3<double>& tool : anew.tools) tool = test::Turn(Eigen::Vector3d::UnitZ(), 1.2) * tool;
  const Changes mounted = FindChanges(Eventful({kReseat}, {}, Reseated(), 5), Eventful({}, anew, anew, 6));
  EXPECT_EQ(NamesOf(mounted), "tool/flange ") << mounted.words;
}

// A stand that drifts goes on from where it was; an instrument that warms up begins anew each day.
TEST(EventTest, ADriftGoesOnAndAWarmUpBeginsAnew) {
  const Vector3<double> way(0.3e-3, -0.2e-3, 0.15e-3);
  const EffectSpec drift{"station_drift", "S1", {}, {}}, warm_up{"warm_up", "S1", {{"tau_s", "600"}}, {}};
  const Changes drifted =
      FindChanges(Eventful({drift}, {}, {}, 7, [&](double t) { return t / kLength * way; }),
                  Eventful({drift}, {}, {}, 8, [&](double t) { return (1.0 + t / kLength) * way; }));
  EXPECT_EQ(NamesOf(drifted), "") << drifted.words;
  const auto warming = [&](double t) { return std::exp(-t / 600.0) * way; };
  const Changes warmed = FindChanges(Eventful({warm_up}, {}, {}, 9, warming), Eventful({warm_up}, {}, {}, 10, warming));
  EXPECT_EQ(NamesOf(warmed), "") << warmed.words;
}

// The first link turned over is another robot; nothing is said of what changed on one.
TEST(StationsAnewTest, WhatNoChangesLeadToIsRefused) {
  DhCampaign after;
  after.nominal[0].alpha_deg = -90, after.rows[0].alpha_deg -= 180;
  EXPECT_THROW(Between({}, after), Failure);
}

// On a table, j4's beta is its zero, those of j1 turn the base and those of j6 the tool: such parameters are no causes.
TEST(RedundantParametersTest, PlainCausesAreNamed) {
  for (int joint = 0; joint < 6; ++joint) {
    DhCampaign after;
    after.slip_mrad[joint] = 0.6;
    const Changes changes = Between({}, after, 10 + joint);
    ASSERT_EQ(NamesOf(changes), "joint_zero/j" + std::to_string(joint + 1) + " ") << changes.words;
    ExpectSize(&changes.changes[0], 0.6);
    EXPECT_GT(changes.changes[0].probability, 0.95);
  }
  DhCampaign after;
  for (Vector3<double>& tool : after.tools) tool += Vector3<double>(0.3e-3, 0.0, 0.2e-3);
  const Changes changes = Between({}, after);
  ASSERT_EQ(NamesOf(changes), "tool/flange ") << changes.words;
  EXPECT_GT(changes.changes[0].probability, 0.95);
}

// Offsets along parallel axes are one: d of j2, j3 and j4. The one that was estimated names the others.
TEST(RedundantParametersTest, ParametersThatMoveThePointsAlikeAreListed) {
  DhCampaign after;
  after.rows[2].d += 0.4e-3;
  const Changes changes = Between({}, after);
  ASSERT_EQ(NamesOf(changes), "geometry/j2.d ") << changes.words;
  ExpectSize(&changes.changes[0], 0.4);
  EXPECT_THAT(changes.changes[0].same, ::testing::UnorderedElementsAre("geometry j3.d", "geometry j4.d"));
  EXPECT_THAT(changes.words, HasSubstr("j3.d"));
}

TEST(RedundantParametersTest, ALengthIsStillALength) {
  DhCampaign after;
  after.rows[1].a += 0.3e-3;
  const Changes changes = Between({}, after);
  ASSERT_EQ(NamesOf(changes), "geometry/j2.a ") << changes.words;
  ExpectSize(&changes.changes[0], 0.3);
  EXPECT_TRUE(changes.changes[0].same.empty());
}

// An arm of 210 kg payload by its data sheet, and somewhat off it.
DhCampaign LargeArm() {
  DhCampaign arm;
  arm.nominal = {{0.35, -90, 0.675, 0}, {1.15, 0, 0, 0}, {0.041, -90, 0, -90},
                 {0, 90, 1.2, 0},       {0, -90, 0, 0},  {0, 0, 0.215, 0}};
  arm.rows = arm.nominal;
  arm.rows[1].a += 0.3e-3, arm.rows[3].d -= 0.2e-3, arm.rows[1].theta_deg += 0.02;
  return arm;
}

void SetUpAnew(DhCampaign* campaign) {
  campaign->base_xyz << -1.3, 1.5, 0.21;
  campaign->base_rotvec << -0.03, 0.01, -0.4;
}

// beta of j3 turns about an axis 41 mm from that of the zero: left at nominal in both estimates, it is no cause.
TEST(RedundantParametersTest, WhatNoEstimateFreedIsNotNamed) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    DhCampaign after = LargeArm();
    after.slip_mrad[2] = 0.3;
    SetUpAnew(&after);
    const Changes changes = Between(LargeArm(), after, seed);
    ASSERT_EQ(changes.changes.size(), 2u) << changes.words;
    const Change* slip = Find(changes, "joint_zero/j3");
    ASSERT_NE(slip, nullptr) << changes.words;
    ExpectSize(slip, 0.3);
    EXPECT_GT(slip->probability, 0.9);
    EXPECT_THAT(changes.alternatives, ::testing::IsEmpty());
  }
}

// Lengths measured by another scale, with the instrument where it was and anew: 20 of 20, and nothing in place of it.
TEST(ScaleTest, AnotherScaleIsOneChange) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    DhCampaign after = LargeArm();
    after.scale = 1.0 + 40e-6;
    const bool is_anew = seed % 2 == 0;
    if (is_anew) SetUpAnew(&after);
    const Changes changes = Between(LargeArm(), after, 30 + seed);
    EXPECT_EQ(changes.changes.size(), is_anew ? 2u : 1u) << changes.words;
    const Change* scale = Find(changes, "scale/lengths");
    ASSERT_NE(scale, nullptr) << changes.words;
    ExpectSize(scale, 40.0);
    EXPECT_EQ(scale->unit, "ppm");
    EXPECT_THAT(changes.words, HasSubstr("K warmer, of steel"));
    ASSERT_EQ(scale->parts.size(), 2u);
    const double width = scale->parts[1].ci95[1] - scale->parts[1].ci95[0];
    EXPECT_TRUE(is_anew || std::abs(scale->parts[1].value - 40.0) < width) << scale->parts[1].value;
  }
}

// An arm that is 8 K warmer; its tool too. The distance to the instrument is as before.
TEST(ScaleTest, AWarmArmIsOneChange) {
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    DhCampaign after = LargeArm();
    const double grown = 1.0 + 8 * 11.7e-6;
    for (test::DhRow& row : after.rows) row.a *= grown, row.d *= grown;
    for (Vector3<double>& tool : after.tools) tool *= grown;
    const Changes changes = Between(LargeArm(), after, 60 + seed);
    ASSERT_EQ(NamesOf(changes), "scale/lengths ") << changes.words;
    ExpectSize(&changes.changes[0], 93.6);
    const Change::Part& distance = changes.changes[0].parts[1];
    EXPECT_LT(std::abs(distance.value), distance.ci95[1] - distance.ci95[0]);
  }
}

}  // namespace
}  // namespace sagitta::stations_anew_test

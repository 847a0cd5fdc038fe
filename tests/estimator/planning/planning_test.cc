// Plans: the certificate on a design with a known optimum, and plans of a KR 270 against random ones.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/planning/plan.h"
#include "estimator/planning/pose_space.h"
#include "estimator/report/planning_words.h"
#include "models/effects/catalogue.h"
#include "problems/input_error.h"
#include "tests/support/moved_kr270.h"

namespace sagitta::planning_test {
namespace {

// y = b1 x + b2 x^2 on 0, 0.01 .. 1. det M = w1 w2 x1^2 x2^2 (x2 - x1)^2 is largest at x2 = 1, x1 = 1/2, w = 1/2:
// with two readings ln det C = -ln(1/16) = ln 16.
CandidateSet Parabola() {
  CandidateSet set;
  set.rows.resize(101, 2);
  set.first = {0};
  for (int i = 0; i <= 100; ++i) {
    const double x = i / 100.0;
    set.rows.row(i) << x, x * x;
    set.first.push_back(i + 1);
  }
  return set;
}

Criterion OfBoth(CriterionKind kind) {
  Criterion criterion;
  criterion.kind = kind;
  criterion.interest = {0, 1};
  criterion.weight = Eigen::Matrix2d::Identity();
  return criterion;
}

const Eigen::Matrix2d kNearlyNothing = 1e-9 * Eigen::Matrix2d::Identity();

TEST(PlanningTest, DOptimumOfAParabolaIsTheClosedForm) {
  const CandidateSet set = Parabola();
  const Criterion criterion = OfBoth(CriterionKind::kD);
  const ApproximateDesign design = SolveApproximate(set, kNearlyNothing, criterion, 2, 1e-4, 20000);
  EXPECT_NEAR(design.cost, std::log(16.0), 1e-3);
  EXPECT_LE(design.bound, std::log(16.0) + 1e-6);  // a bound: never above the optimum
  EXPECT_GT(design.bound, std::log(16.0) - 1e-3);
  // Kiefer and Wolfowitz: at the optimum the largest N d_i is the number of parameters.
  EXPECT_NEAR(2.0 * design.gain.maxCoeff(), 2.0, 1e-3);
  const ExactDesign exact = SolveExact(set, kNearlyNothing, criterion, 2, design);
  EXPECT_EQ(exact.picks, (std::vector<int>{50, 100}));
  EXPECT_NEAR(exact.cost, std::log(16.0), 1e-6);
}

TEST(PlanningTest, BoundHoldsFarFromTheOptimum) {
  const CandidateSet set = Parabola();
  for (const CriterionKind kind : {CriterionKind::kI, CriterionKind::kA, CriterionKind::kD, CriterionKind::kO5}) {
    const Criterion criterion = OfBoth(kind);
    const ApproximateDesign early = SolveApproximate(set, kNearlyNothing, criterion, 4, 0.0, 1);
    double least = 1e300;  // of all plans of two poses, twice each
    for (int a = 0; a < set.size(); ++a) {
      for (int b = a + 1; b < set.size(); ++b) {
        least = std::min(least, criterion.Cost(CovarianceOf(set, kNearlyNothing, {a, a, b, b})));
      }
    }
    EXPECT_LT(early.bound, least) << WordOf(kind);
    const ApproximateDesign late = SolveApproximate(set, kNearlyNothing, criterion, 4, 5e-4, 20000);
    EXPECT_LE(late.cost, least + 1e-3 * std::abs(least)) << WordOf(kind);
    EXPECT_LE(late.bound, least) << WordOf(kind);
  }
}

TEST(PlanningTest, SlopesAgreeWithFiniteDifferences) {
  Eigen::Matrix3d information;
  information << 4.0, 0.7, -0.3, 0.7, 3.0, 0.5, -0.3, 0.5, 2.0;
  Eigen::Matrix3d direction;
  direction << 1.0, 0.2, 0.4, 0.2, 2.0, -0.6, 0.4, -0.6, 1.5;
  for (const CriterionKind kind :
       {CriterionKind::kI, CriterionKind::kA, CriterionKind::kD, CriterionKind::kO5, CriterionKind::kDiscriminate}) {
    Criterion criterion;
    criterion.kind = kind;
    criterion.interest = {0, 2};
    criterion.rival_of = {0, 1};
    criterion.size = Eigen::Vector2d(1.5, 0.8);
    criterion.weight = direction;
    const double step = 1e-5;
    const double slope = -(criterion.Cost((information + step * direction).inverse()) -
                           criterion.Cost((information - step * direction).inverse())) /
                         (2.0 * step);
    const double expected = criterion.Slope(information.inverse()).cwiseProduct(direction).sum();
    EXPECT_NEAR(slope, expected, 1e-7 * (1.0 + std::abs(expected))) << WordOf(kind);
  }
}

// A KR 270 with the limits of DesignMeasurements.
Robot Arm() {
  Robot robot;
  robot.name = "KR 270";
  robot.chain = test::Kr270Chain();
  const double low[6] = {-150, -140, -100, -170, -110, -170}, high[6] = {150, 0, 140, 170, 110, 170};
  for (int j = 0; j < 6; ++j) {
    robot.chain.joints[j].min = low[j] * kDegree;
    robot.chain.joints[j].max = high[j] * kDegree;
  }
  return robot;
}

constexpr double kSigma = 1e-4;  // m

Measurements PosesOfOneStation(int poses, std::uint64_t seed) {
  return test::DesignMeasurements(test::CampaignOf(poses, 1, kSigma, seed));
}

Measurements Measured(int configurations, std::uint64_t seed) {
  Measurements data = PosesOfOneStation(configurations, seed);
  test::MeasureKr270(test::Kr270Truth(), kSigma, seed, &data);
  return data;
}

PlanRequest Request(int poses) {
  PlanRequest request;
  request.poses = poses;
  request.pool = 150;
  request.starts = 1;
  return request;
}

// The predicted error of a list of candidates by itself: as many as are listed, all of them.
double PredictedOf(const Measurements& data, const Measurements& list) {
  PlanRequest request = Request(static_cast<int>(list.configurations.size()));
  request.candidates = &list;
  return MakePlan(Arm(), data, Experiment(), request).position_rms;
}

TEST(PlanningTest, BeatsRandomPosesAndComesBackFromItsOwnRows) {
  const Measurements data = Measured(18, 3);
  const Plan plan = MakePlan(Arm(), data, Experiment(), Request(12));
  ASSERT_EQ(plan.rows.configurations.size(), 12u);
  EXPECT_GT(plan.efficiency, 0.0);
  EXPECT_LE(plan.efficiency, 1.0);
  // Whole poses lose against shares of poses what rounding costs, which vanishes with their number (Pukelsheim,
  // Optimal Design of Experiments, section 12.10): 36 rows for 33 unknowns lose much, four times as many little.
  EXPECT_GT(MakePlan(Arm(), data, Experiment(), Request(48)).efficiency, 0.9);
  EXPECT_LE(plan.best_rms, plan.position_rms);
  // The plan's rows as the only candidates predict the same.
  EXPECT_NEAR(PredictedOf(data, plan.rows), plan.position_rms, 1e-6 * plan.position_rms);
  for (std::uint64_t seed = 101; seed < 111; ++seed) {
    EXPECT_GT(PredictedOf(data, Measured(12, seed)), plan.position_rms) << seed;
  }
}

// An arm that follows its thermometer late has at each pose what was before it: of a pose that is moved too, and of the
// times of plan.csv, fewer than those of the candidates.
TEST(PlanningTest, WhatFollowsLateIsThatOfTheWrittenTimes) {
  Measurements data = Measured(18, 3);
  for (size_t s = 0; s < data.shots.size(); ++s) {
    data.shots[s].has_time = data.shots[s].has_temperature = true;
    data.shots[s].time = 300.0 * s;
    data.shots[s].temperature = 20.0 + 6.0 * std::sin(0.7 * s);
  }
  Robot robot = Arm();
  robot.effects = {{"thermal_growth", "", {{"lag_s", "1200"}}, {0.0}}};
  Experiment experiment;
  experiment.estimate.effects.kind = Selection::Kind::kAll;
  const Plan plan = MakePlan(robot, data, experiment, Request(14));
  ASSERT_TRUE(plan.moved);
  PlanRequest request = Request(14);
  request.candidates = &plan.rows;
  request.move = false;
  const Plan again = MakePlan(robot, data, experiment, request);
  EXPECT_NEAR(again.position_rms, plan.position_rms, 1e-6 * plan.position_rms);
  const auto growth = [](const Plan& of) {
    const auto is_it = [](const PlannedParameter& parameter) {
      return parameter.name.find("growth") != std::string::npos;
    };
    return std::find_if(of.parameters.begin(), of.parameters.end(), is_it)->sigma;
  };
  EXPECT_NEAR(growth(again), growth(plan), 1e-6 * growth(plan));
}

// What writes rows copies the cells of their files.
TEST(PlanningTest, NoRowOfAPlanHasTheCellsOfAnotherPose) {
  Measurements data = Measured(18, 3);
  MeasurementFile file;
  file.header = {"config"};
  for (Observation& row : data.observations) {
    row.file = 0;
    row.row = static_cast<int>(file.rows.size());
    file.rows.push_back({row.row + 1, {data.ConfigurationOf(row).id}});
  }
  data.files = {file};
  for (const Measurements* candidates : {static_cast<const Measurements*>(nullptr), &std::as_const(data)}) {
    PlanRequest request = Request(12);
    request.candidates = candidates;
    const Plan plan = MakePlan(Arm(), data, Experiment(), request);
    ASSERT_FALSE(plan.rows.observations.empty());
    for (const Observation& row : plan.rows.observations) {
      const std::string id = plan.rows.ConfigurationOf(row).id;
      EXPECT_EQ(plan.rows.Cell(row, "config"), candidates == nullptr ? "" : id) << id;
    }
  }
}

TEST(PlanningTest, AugmentCountsWhatIsMeasured) {
  const Measurements data = Measured(14, 3);
  PlanRequest request = Request(3);
  EXPECT_THROW(MakePlan(Arm(), data, Experiment(), request), InputError);  // 27 readings, 33 unknowns
  request.augment = true;
  const Plan more = MakePlan(Arm(), data, Experiment(), request);
  EXPECT_EQ(more.measured, 14);
  // All 17 as candidates of a plan without anything measured: the same information.
  Measurements all = data;
  const std::vector<std::vector<int>> shots = ShotsByConfiguration(more.rows);
  for (int c = 0; c < 3; ++c) AppendConfiguration(more.rows, c, shots[c], {}, "", &all);
  EXPECT_NEAR(PredictedOf(data, all), more.position_rms, 1e-6 * more.position_rms);
}

// Rows that lost their reading are no measurement, nor configurations that have no other.
TEST(PlanningTest, RowsWithoutAReadingAreNotMeasured) {
  Measurements data = Measured(14, 3);
  const Vector3<double> lost = Vector3<double>::Constant(std::nan(""));
  for (size_t i = 0; i < data.observations.size(); ++i) {
    if (i / 3 >= 9 || i == 4) data.observations[i].point_in_station = lost;
  }
  PlanRequest request = Request(9);
  request.augment = true;
  request.move = false;
  const Measurements candidates = Measured(40, 5);
  request.candidates = &candidates;
  const Plan plan = MakePlan(Arm(), data, Experiment(), request);
  EXPECT_EQ(plan.measured, 9);
  EXPECT_TRUE(std::any_of(plan.words.begin(), plan.words.end(),
                          [](const std::string& words) { return words.rfind("16 rows have no reading", 0) == 0; }));
  for (Observation& row : data.observations) row.point_in_station = lost;
  Experiment experiment;
  for (const std::string& marker : data.markers) experiment.markers[marker].point = Vector3<double>(0.28, 0.05, 0.02);
  try {
    MakePlan(Arm(), data, experiment, request);
    FAIL() << "nothing is measured";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("nothing is measured"), std::string::npos) << error.what();
  }
}

// Poses of a plan that are measured have its names; the next plan's come after them.
TEST(PlanningTest, PosesAreNumberedOnAfterThoseOfAnEarlierPlan) {
  Measurements data = Measured(14, 3);
  for (size_t c = 0; c < data.configurations.size(); ++c) data.configurations[c].id = "plan" + std::to_string(c + 1);
  PlanRequest request = Request(3);
  request.augment = true;
  const Plan plan = MakePlan(Arm(), data, Experiment(), request);
  ASSERT_EQ(plan.rows.configurations.size(), 3u);
  for (size_t c = 0; c < 3; ++c) EXPECT_EQ(plan.rows.configurations[c].id, "plan" + std::to_string(15 + c));
}

// Where base and markers are along parallel axes no turn about them shows: four parameters share one direction, so that
// each has a quarter of what is open there.
TEST(PlanningTest, ADirectionThatSeveralParametersShareIsNotDetermined) {
  Robot scara;
  scara.name = "two parallel axes";
  scara.chain.joints = {{"j1", JointType::kRevolute, -2.0, 2.0}, {"j2", JointType::kRevolute, -2.0, 2.0}};
  const auto turn = [](int joint) {
    ElementaryTransform motion;
    motion.motion = Motion::kRotation;
    motion.axis = Axis::kZ;
    motion.joint = joint;
    return motion;
  };
  ElementaryTransform link;
  link.motion = Motion::kTranslation;
  link.axis = Axis::kX;
  link.nominal = 0.4;
  link.error = "length";
  scara.chain.transforms = {turn(0), link, turn(1)};
  Measurements data;
  data.stations = {"S1"};
  data.markers = {"M1", "M2", "M3"};
  data.files.resize(1);
  for (int c = 0; c < 12; ++c) {
    Configuration configuration;
    configuration.id = std::to_string(c);
    configuration.q = Eigen::Vector2d(std::sin(1.7 * c), std::cos(2.9 * c));
    data.configurations.push_back(configuration);
    Shot shot;
    shot.configuration = c;
    shot.station = 0;
    test::AddShot(shot, 3, 2e-5, &data);
    for (int m = 0; m < 3; ++m) {
      const double angle = configuration.q.sum(), first = configuration.q[0];
      const Vector3<double> marker(0.1 + 0.1 * m, 0.05 * m * m, 0.03 * m);
      data.observations[static_cast<size_t>(3 * c + m)].point_in_station =
          Vector3<double>(0.4 * std::cos(first), 0.4 * std::sin(first), 0.0) +
          Eigen::AngleAxisd(angle, Vector3<double>::UnitZ()) * marker;
    }
  }
  PlanRequest request = Request(10);
  request.candidates = &data;
  request.move = false;
  const Plan plan = MakePlan(scara, data, Experiment(), request);
  int along = 0;
  for (const PlannedParameter& parameter : plan.parameters) {
    const std::string& name = parameter.name;
    const bool is_along = name == "base/S1/z" || (name.rfind("marker/", 0) == 0 && name.back() == 'z');
    along += is_along ? 1 : 0;
    EXPECT_EQ(parameter.identifiable, !is_along) << name << " " << parameter.sigma;
  }
  EXPECT_EQ(along, 4);
}

// Play of a joint that is always approached from one side is an offset of its encoder: the plan approaches from both.
TEST(PlanningTest, SidesOfApproachAreChosenWhereTheyMatter) {
  Measurements data = Measured(18, 3);
  for (Shot& shot : data.shots) shot.approach.assign(6, 1);
  Robot robot = Arm();
  robot.effects.push_back({"backlash", "A2", {}, {0.0}});
  const auto gap_of = [](const Plan& plan) {
    for (const PlannedParameter& parameter : plan.parameters) {
      if (parameter.name == "effect/backlash/A2/half_gap") return parameter;
    }
    return PlannedParameter();
  };
  PlanRequest request = Request(18);
  request.criterion =
      CriterionKind::kD;  // I asks for no more than the test poses, which are approached as the rows are
  request.move = false;
  request.candidates = &data;
  EXPECT_FALSE(gap_of(MakePlan(robot, data, Experiment(), request)).identifiable);
  request.candidates = nullptr;
  const Plan plan = MakePlan(robot, data, Experiment(), request);
  EXPECT_TRUE(gap_of(plan).identifiable);
  int from_below = 0;
  for (const Shot& shot : plan.rows.shots) from_below += shot.approach[1] > 0 ? 1 : 0;
  EXPECT_GE(from_below, 5);
  EXPECT_LE(from_below, 13);
}

// Joints with random harmonics 1 to 4 of that size, rad, measured without noise.
class BentArm {
 public:
  BentArm(double amplitude, NormalNumbers* normal) {
    for (int i = 0; i < 24; ++i) cosine_[i] = amplitude * (*normal)(), sine_[i] = amplitude * (*normal)();
  }

  void Measure(Measurements* data) const {
    for (Observation& row : data->observations) {
      Eigen::VectorXd q = data->ConfigurationOf(row).q;
      for (int j = 0; j < 6; ++j) {
        const double read = q[j];
        for (int k = 1; k <= 4; ++k)
          q[j] += cosine_[4 * j + k - 1] * std::cos(k * read) + sine_[4 * j + k - 1] * std::sin(k * read);
      }
      row.point_in_station = test::ExactPoint(test::Kr270Truth(), q, row.marker, 0);
    }
  }

 private:
  double cosine_[24], sine_[24];
};

// Calibrated without them at 300 poses, such arms are off by the excess that was stated. 12 arms of 48 coefficients:
// their mean square is known to about a twelfth.
TEST(PlanningTest, TheFieldOfTheModelErrorIsAsLargeAsWhatWasSeen) {
  const Measurements data = Measured(18, 3);
  PlanRequest request = Request(18);
  request.move = false;
  const Plan without = MakePlan(Arm(), data, Experiment(), request);
  request.field = 0.2e-3;
  const Plan with = MakePlan(Arm(), data, Experiment(), request);
  EXPECT_EQ(without.field_amplitude, 0.0);
  EXPECT_GT(with.rms_with_model_error, 1.2 * with.position_rms);
  EXPECT_EQ(with.parameters.size(), without.parameters.size());
  NormalNumbers normal(5);
  double squares = 0.0;
  constexpr int kArms = 12;
  for (int arm = 0; arm < kArms; ++arm) {
    Measurements many = PosesOfOneStation(300, 100 + arm);
    BentArm(with.field_amplitude, &normal).Measure(&many);
    const Estimate estimate = EstimateJointly(test::Kr270ProblemOf(many, Experiment()));
    squares += estimate.fit.rms * estimate.fit.rms / kArms;
  }
  EXPECT_NEAR(std::sqrt(squares), request.field, 0.1 * request.field);
}

// What a plan promises with the model error is what arms with it have that are measured at its poses and calibrated
// without it, at other poses. 24 arms: their mean square, of some ten directions each, is known to a tenth.
TEST(PlanningTest, TheAccuracyWithTheModelErrorIsThatOfACalibrationWithoutIt) {
  const Measurements tests = PosesOfOneStation(60, 77);
  PlanRequest request = Request(24);
  request.move = false;
  request.tests = &tests;
  request.field = 0.2e-3;
  const Plan plan = MakePlan(Arm(), Measured(18, 3), Experiment(), request);
  const double expected = std::sqrt(std::pow(plan.rms_with_model_error, 2) - std::pow(plan.position_rms, 2));
  NormalNumbers normal(6);
  double squares = 0.0;
  constexpr int kArms = 24;
  for (int arm = 0; arm < kArms; ++arm) {
    const BentArm bent(plan.field_amplitude, &normal);
    Measurements measured = plan.rows, others = tests;
    bent.Measure(&measured);
    bent.Measure(&others);
    const Estimate estimate = EstimateJointly(test::Kr270ProblemOf(measured, Experiment()));
    const CalibrationProblem problem = test::Kr270ProblemOf(others, Experiment());
    ParameterSet parameters = problem.parameters;
    parameters.CopyByName(estimate.parameters);
    const std::vector<int> rows = problem.CalibrationObservations();
    const Eigen::Matrix3Xd predicted = PredictPoints(problem, parameters, rows);
    for (size_t i = 0; i < rows.size(); ++i) {
      const Vector3<double> off = predicted.col(i) - others.observations[rows[i]].point_in_station;
      squares += off.squaredNorm() / static_cast<double>(kArms * rows.size());
    }
  }
  EXPECT_NEAR(std::sqrt(squares), expected, 0.15 * expected);
}

// Rivals at the size that the robot file states; the plan's information is that of its own noncentralities.
TEST(PlanningTest, RivalsAreToldApartByWhatTheReadingsTell) {
  const Measurements data = Measured(18, 3);
  PlanRequest request = Request(18);
  request.move = false;
  request.discriminate = {{"joint_harmonic", "A3", {{"order", "1"}}, {0.0, 0.0}}, {"encoder_gain", "A3", {}, {0.0}}};
  const Plan plan = MakePlan(Arm(), data, Experiment(), request);
  EXPECT_NEAR(-plan.cost, plan.information, 1e-9);
  EXPECT_LE(plan.information, std::log(2.0));
  EXPECT_GT(plan.decides, 0.5);
  // Ten times the size is a hundred times the noncentrality: nothing is left open.
  request.discriminate[0].values = {1e-2, 1e-2};
  request.discriminate[1].values = {1e-2};
  EXPECT_GT(MakePlan(Arm(), data, Experiment(), request).decides, 0.999);
}

// What goes with time is not mistaken for what goes with the place: by the definition of an effect, or by its setting.
TEST(PlanningTest, PosesAreMixedWhereWhatGoesWithTimeIsFree) {
  Measurements data = Measured(18, 3);
  for (size_t s = 0; s < data.shots.size(); ++s) data.shots[s].has_time = true, data.shots[s].time = 60.0 * s;
  const std::string station = data.stations[0];
  Experiment experiment;
  experiment.estimate.effects.kind = Selection::Kind::kAll;
  PlanRequest request = Request(18);
  request.move = false;
  const auto order_with = [&](const EffectSpec& spec) {
    Robot robot = Arm();
    robot.effects = {spec};
    robot.effects[0].values.assign(FindEffect(spec.effect)->parameters(robot, spec).size(), 0.0);
    return MakePlan(robot, data, experiment, request).order;
  };
  const std::map<std::string, std::string> by_time = {{"by", "time_s"}, {"from", "0"}, {"to", "1020"}, {"knots", "2"}};
  const std::map<std::string, std::string> by_joint = {
      {"by", "q"}, {"driver", "A2"}, {"from", "-140"}, {"to", "0"}, {"knots", "2"}};
  EXPECT_EQ(order_with({"station_drift", station, {}, {}}), OrderIsMixed());
  EXPECT_EQ(order_with({"learnt_deviation", "A3", by_time, {}}), OrderIsMixed());
  EXPECT_NE(order_with({"learnt_deviation", "A3", by_joint, {}}), OrderIsMixed());
}

TEST(PlanningTest, FewestPosesReachTheAccuracy) {
  const Measurements data = Measured(18, 3);
  PlanRequest request = Request(0);
  request.accuracy = 0.12e-3;
  const Plan plan = MakePlan(Arm(), data, Experiment(), request);
  EXPECT_LE(plan.position_rms, request.accuracy);
  const int poses = static_cast<int>(plan.rows.configurations.size());
  for (const PosesAndAccuracy& point : plan.curve) {
    if (point.poses < poses) {
      EXPECT_GT(point.position_rms, request.accuracy) << point.poses;
    }
  }
}

TEST(PlanningTest, WhatCannotBePlannedIsRefused) {
  const Measurements data = Measured(18, 3);
  EXPECT_THROW(MakePlan(Arm(), data, Experiment(), Request(2)), InputError);
  Robot narrow = Arm();
  narrow.chain.joints[1].max = -139.9 * kDegree;
  PlanRequest request = Request(12);
  const Measurements list = Measured(12, 5);
  request.candidates = &list;
  EXPECT_THROW(MakePlan(narrow, data, Experiment(), request), InputError);
  Robot unlimited = Arm();
  unlimited.chain.joints[0].min.reset();
  EXPECT_THROW(MakePlan(unlimited, data, Experiment(), Request(12)), InputError);
}

}  // namespace
}  // namespace sagitta::planning_test

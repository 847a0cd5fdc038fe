// Members of a problem, places and targets that a program sets and that are none: refused with words at the entry.
// Behind it each would end the program, be read past its end, or be an answer that means nothing.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <type_traits>

#include "estimator/compensation/compensate.h"
#include "estimator/sagitta.h"
#include "tests/support/in_memory.h"

namespace sagitta::misused_problem_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

const Calibration& Calibrated() {
  static const Calibration calibration =
      Calibrate(MakeCalibrationProblem(test::ArmInMemory(), test::ReadingsInMemory(test::ArmInMemory()), {}));
  return calibration;
}

std::string WordsOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.where().key + ": " + error.what();
  } catch (const std::invalid_argument& error) {
    return std::string("invalid: ") + error.what();
  }
  return "";
}

// Of Calibrate and of Diagnose, which are asked the same.
std::string Refused(const std::function<void(CalibrationProblem*)>& change) {
  CalibrationProblem problem =
      MakeCalibrationProblem(test::ArmInMemory(), test::ReadingsInMemory(test::ArmInMemory()), {});
  change(&problem);
  const std::string words = WordsOf([&] { Calibrate(problem); });
  const std::string by_diagnosis = WordsOf([&] { Diagnose(problem, {}); });
  EXPECT_EQ(words.substr(words.find(": ", 9) + 1), by_diagnosis.substr(by_diagnosis.find(": ", 9) + 1));
  return words;
}

TEST(Problem, StartValuesAreNumbers) {
  for (const double value : {kNan, kInf}) {
    EXPECT_THAT(Refused([&](CalibrationProblem* p) { p->parameters.SetModelValue(2, value); }),
                AllOf(StartsWith("invalid: Calibrate: a start value of 'geometry/"), HasSubstr("is no number")));
  }
  Pose<double> place;
  place.translation.setConstant(kNan);
  EXPECT_THAT(Refused([&](CalibrationProblem* p) { p->parameters.SetBaseInStation(0, place); }),
              HasSubstr("'base/S1/position' is no number"));
  EXPECT_THAT(Refused([&](CalibrationProblem* p) {
                p->parameters.station_rotation(0).values = {0.0, 0.0, 0.0, 0.9};
              }),
              HasSubstr("'base/S1/rotation' is no rotation"));
}

TEST(Problem, PriorsAndBoundsAreNumbers) {
  const auto with = [](const std::function<void(Coordinate*)>& change) {
    return Refused([&](CalibrationProblem* p) { change(&p->parameters.coordinate(15)); });
  };
  EXPECT_THAT(with([](Coordinate* c) { c->prior_sigma = 1e-3, c->prior_value = kNan; }), HasSubstr("prior's value"));
  EXPECT_THAT(with([](Coordinate* c) { c->prior_sigma = kNan; }), HasSubstr("prior's standard deviation"));
  EXPECT_THAT(with([](Coordinate* c) { c->prior_sigma = -1.0; }), HasSubstr("prior's standard deviation"));
  EXPECT_THAT(with([](Coordinate* c) { c->lower = kNan; }), HasSubstr("lower bound"));
  EXPECT_THAT(with([](Coordinate* c) { c->hold_limit = kNan; }), HasSubstr("held"));
  EXPECT_THAT(with([](Coordinate* c) { c->block = 999; }), HasSubstr("coordinate 15"));
}

TEST(Problem, ParametersAndDeviationsBelongToIt) {
  EXPECT_THAT(Refused([](CalibrationProblem* p) { p->parameters = ParameterSet(); }), HasSubstr("another problem"));
  EXPECT_THAT(Refused([](CalibrationProblem* p) {
                p->latent.joints = {0, 1};
              }),
              HasSubstr("2 joints deviate, there are 0 standard deviations"));
  const auto with = [](const std::function<void(LatentModel*)>& change) {
    return Refused([&](CalibrationProblem* p) {
      p->latent.joints = {0, 1};
      p->latent.sigmas = Eigen::VectorXd::Constant(2, 1e-5);
      change(&p->latent);
    });
  };
  EXPECT_EQ(with([](LatentModel*) {}), "");
  EXPECT_THAT(with([](LatentModel* l) { l->joints[1] = 6; }), HasSubstr("joint 6 is none of the robot"));
  EXPECT_THAT(with([](LatentModel* l) { l->sigmas[0] = kNan; }), HasSubstr("no number above 0"));
  EXPECT_THAT(with([](LatentModel* l) { l->visit_of_shot.pop_back(); }), HasSubstr("each of 30 shots"));
  EXPECT_THAT(with([](LatentModel* l) { l->num_visits = 3; }), HasSubstr("visit 3 does not exist"));
}

TEST(Problem, RootsAreOfItsRows) {
  const Matrix3<double> root = 2e-5 * Matrix3<double>::Identity();
  const auto with = [&](const std::function<void(CalibrationProblem*)>& change) {
    return Refused([&](CalibrationProblem* p) {
      p->resolved_noise.assign(p->data().observations.size(), root);
      p->weight_roots = p->resolved_noise;
      change(p);
    });
  };
  EXPECT_EQ(with([](CalibrationProblem*) {}), "");
  EXPECT_THAT(with([](CalibrationProblem* p) { p->resolved_noise.resize(3); }),
              HasSubstr("resolved_noise: one for each of 90 observations is expected, there are 3"));
  EXPECT_THAT(with([](CalibrationProblem* p) { p->resolved_noise[4].setConstant(kNan); }),
              HasSubstr("resolved_noise of observation 4"));
  // Zero states nothing; a root with an eigenvalue of 0, exact or rounded, is none.
  EXPECT_EQ(with([](CalibrationProblem* p) { p->resolved_noise[4].setZero(); }), "");
  EXPECT_EQ(with([](CalibrationProblem* p) { p->resolved_noise[4] *= -1.0; }), "");
  const Matrix3<double> turn = Eigen::AngleAxisd(0.7, Vector3<double>(1, 2, 3).normalized()).toRotationMatrix();
  const Matrix3<double> flat = Vector3<double>(2e-5, 3e-5, 0.0).asDiagonal();
  for (const Matrix3<double>& singular : {flat, Matrix3<double>(turn * flat * turn.transpose())}) {
    EXPECT_THAT(with([&](CalibrationProblem* p) { p->resolved_noise[4] = singular; }),
                HasSubstr("resolved_noise of observation 4 is no root of a covariance"));
    EXPECT_THAT(with([&](CalibrationProblem* p) { p->weight_roots[4] = singular; }), HasSubstr("weight_roots of"));
  }
  EXPECT_THAT(with([](CalibrationProblem* p) { p->weight_roots.resize(3); }), HasSubstr("weight_roots"));
  EXPECT_THAT(with([](CalibrationProblem* p) { p->weight_roots[4].setZero(); }), HasSubstr("weight_roots of"));
  EXPECT_THAT(Refused([](CalibrationProblem* p) { p->mutable_shot_inputs()->pop_back(); }), HasSubstr("RenewShots"));
  EXPECT_THAT(Refused([](CalibrationProblem* p) { p->mutable_experiment()->method.loss = static_cast<LossKind>(9); }),
              HasSubstr("no choice number 9"));
}

TEST(KnownPlaces, ArePoses) {
  const Measurements rows = test::ReadingsInMemory(test::ArmInMemory());
  const auto with = [&](const std::function<void(KnownRobot*)>& change) {
    KnownRobot known = KnownFrom(Calibrated());
    change(&known);
    return WordsOf([&] { Predict(known, rows); });
  };
  EXPECT_EQ(with([](KnownRobot*) {}), "");
  EXPECT_THAT(with([](KnownRobot* k) { k->base_in_station["S1"].rotation *= 1.1; }),
              AllOf(StartsWith("station S1"), HasSubstr("no rotation matrix")));
  EXPECT_THAT(with([](KnownRobot* k) { k->base_in_station["S1"].rotation *= -1.0; }), HasSubstr("no rotation matrix"));
  EXPECT_THAT(with([](KnownRobot* k) { k->base_in_station["S1"].translation.x() = kNan; }), HasSubstr("no number"));
  EXPECT_THAT(with([](KnownRobot* k) { k->markers["M2"].point = Vector3<double>(kNan, 0.0, 0.0); }),
              AllOf(StartsWith("marker M2"), HasSubstr("no number")));
  EXPECT_THAT(with([](KnownRobot* k) { k->markers["M2"].point.reset(); }), HasSubstr("no point of marker 'M2'"));
}

TEST(Results, AreOfTheirRows) {
  Calibration other = Calibrated();
  other.problem =
      MakeCalibrationProblem(test::ArmInMemory(), test::ReadingsInMemory(test::ArmInMemory(), 20), Experiment());
  EXPECT_THAT(WordsOf([&] { CalibrationToJson(other, {}); }),
              AllOf(StartsWith("invalid: CalibrationToJson"), HasSubstr("90 rows, there are 60")));
}

Targets TwoTargets(const Robot& robot) {
  Targets targets;
  for (const Joint& joint : robot.chain.joints) targets.joint_types.push_back(joint.type);
  targets.shots.stations = {"S1"};
  for (int i = 0; i < 2; ++i) {
    Target target;
    target.name = "T" + std::to_string(i);
    target.q = Eigen::VectorXd::Constant(6, 0.3);
    target.flange_in_base = Pose<double>{RotationFromVector(Vector3<double>(0.1, 0.2, 0.3)), {0.6, 0.1, 0.9}};
    targets.rows.push_back(target);
    targets.shots.configurations.push_back({target.name, *target.q, false});
    Shot shot;
    shot.configuration = i;
    shot.station = 0;
    shot.observations = {i};
    targets.shots.shots.push_back(shot);
    Observation row;
    row.shot = i;
    row.point_in_station.setConstant(kNan);
    targets.shots.observations.push_back(row);
  }
  return targets;
}

TEST(TargetsInMemory, ArePoses) {
  const KnownRobot known = KnownFrom(Calibrated());
  const auto with = [&](const std::function<void(Target*)>& change) {
    Targets targets = TwoTargets(known.robot);
    change(&targets.rows[1]);
    return WordsOf([&] { Compensate(MakeCompensationInput(known, targets), targets.rows, 1); });
  };
  EXPECT_EQ(with([](Target*) {}), "");
  // From a quaternion 10 % too long: a matrix that is nearly one.
  EXPECT_THAT(with([](Target* t) {
                Eigen::Quaterniond longer(t->flange_in_base->rotation);
                longer.coeffs() *= 1.1;
                t->flange_in_base->rotation = longer.toRotationMatrix();
              }),
              AllOf(StartsWith("target T1"), HasSubstr("no rotation matrix")));
  EXPECT_THAT(with([](Target* t) { t->flange_in_base->rotation *= -1.0; }), HasSubstr("no rotation matrix"));
  EXPECT_THAT(with([](Target* t) { t->flange_in_base->translation.y() = kNan; }),
              AllOf(StartsWith("target T1"), HasSubstr("a coordinate of its pose")));
  EXPECT_THAT(with([](Target* t) { (*t->q)[2] = kNan; }), AllOf(StartsWith("target T1"), HasSubstr("a joint value")));
}

TEST(LoadedArm, HasAValuePerParameterAndAModelThatStays) {
  static_assert(!std::is_constructible_v<LoadedArm, ForwardModel, std::vector<double>>);
  const ForwardModel model(test::ArmInMemory().chain);
  EXPECT_THROW(LoadedArm(model, {}), std::invalid_argument);
  EXPECT_NO_THROW(LoadedArm(model, model.NominalValues()));
}

}  // namespace
}  // namespace sagitta::misused_problem_test

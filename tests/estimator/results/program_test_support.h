// Programs for the KR 270 of tests/support/loaded_kr270.h: written, corrected, run on the true robot.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "estimator/compensation/joint_solutions.h"
#include "estimator/results/program_compensation.h"
#include "models/constants.h"
#include "problems/input_error.h"
#include "problems/io/files.h"
#include "problems/text.h"
#include "tests/support/loaded_kr270.h"

namespace sagitta::program_test {

using test::ArmState;
using test::LoadedTruth;
using ::testing::HasSubstr;

constexpr double kWritten = 2e-7;  // m: what the decimals of a program leave, 0.05 um per coordinate, 0.02 urad x 2.9 m

inline ArmState NominalArm(const Eigen::VectorXd& q) {
  std::array<double, 6> values{};
  for (int j = 0; j < 6; ++j) values[j] = q[j];
  return test::StateOfArm(values, {});
}

inline Pose<double> NominalFlange(const Eigen::VectorXd& q) {
  const ArmState state = NominalArm(q);
  return {state.flange, state.flange_origin};
}

inline Pose<double> TrueFlange(const LoadedTruth& truth, const Eigen::VectorXd& q) {
  const ArmState state = test::LoadedState(truth, q, "none", 0);
  return {state.flange, state.flange_origin};
}

inline KnownRobot TrueRobot(const LoadedTruth& truth) {
  test::LoadedSetup setup = test::SetupFor(truth);
  for (int j = 0; j < 6; ++j) setup.robot.compliances.push_back({j, {{0.0, truth.k[j]}}, false});
  const test::SpringTruth& s = *truth.spring;
  setup.robot.gravity_compensator = GravityCompensator{1, s.L, s.a_x, s.a_y, s.s0, s.Kc, s.preload, 0.0};
  KnownRobot known;
  std::map<std::string, double> errors;
  for (size_t i = 0; i < 18; ++i) {
    errors[test::Kr270Errors()[i]] = truth.errors[i];
    known.parameters["geometry/" + test::Kr270Errors()[i]] = {truth.errors[i], 0.0};
  }
  known.file = "truth";
  known.robot = WithGeometricErrors(setup.robot, errors);
  known.loading = setup.experiment;
  known.base_in_station["S1"] = {test::BaseRotation(truth, 0), truth.base_xyz[0]};
  known.uncertainty.covariance.resize(0, 0);
  known.uncertainty.slopes.resize(0, 0);
  return known;
}

inline Eigen::VectorXd Joints(std::initializer_list<double> degrees) {
  Eigen::VectorXd q(static_cast<Eigen::Index>(degrees.size()));
  std::copy(degrees.begin(), degrees.end(), q.begin());
  return kDegree * q;
}

inline const Pose<double> kToolInFlange = {RotationFromRpy(Vector3<double>(0.2, -0.3, 0.4)), {0.05, -0.02, 0.18}};
inline const Pose<double> kFrameInWorld = {RotationFromRpy(Vector3<double>(0.0, 0.1, 1.2)), {0.7, -0.4, 0.3}};
constexpr char kFrameText[] = "=700,-400,300,0,5.729577951308232,68.75493541569878";
constexpr char kToolText[] = "=50,-20,180,11.459155902616466,-17.188733853924695,22.918311805232932";

inline Pose<double> Back(const Pose<double>& pose) {
  return {pose.rotation.transpose(), -(pose.rotation.transpose() * pose.translation)};
}
inline Pose<double> Times(const Pose<double>& a, const Pose<double>& b) {
  return {a.rotation * b.rotation, a * b.translation};
}

// The pose of the tool in the frame where the nominal robot has the joint values q, as a file writes it.
inline std::string PoseText(PoseNotation notation, const Eigen::VectorXd& q, const Pose<double>& frame,
                            const std::vector<const char*>& names) {
  const std::vector<double> n = NumbersOf(notation, Times(Times(Back(frame), NominalFlange(q)), kToolInFlange));
  std::string text;
  for (size_t i = 0; i < n.size(); ++i) {
    char number[64];
    std::snprintf(number, sizeof number, "%.9f", n[i]);
    text += (i > 0 ? ", " : "") + std::string(names.empty() ? "" : names[i]) + number;
  }
  return text;
}

class ProgramCompensationTest : public ::testing::Test {
 protected:
  ProgramCompensationTest() {
    scene_.tools = FramesFromText(std::string("flange=same; TOOL_DATA[1]") + kToolText + "; UT1" + kToolText + "; GUN" +
                                      kToolText + "; default" + kToolText,
                                  "--tools_mm_deg");
    scene_.frames = FramesFromText(
        std::string("world=same; BASE_DATA[2]") + kFrameText + "; UF2" + kFrameText + "; JIG" + kFrameText,
        "--frames_mm_deg");
  }
  RobotProgram ReadAs(const std::string& ending, const std::string& text) const {
    const std::string path = ::testing::TempDir() + "program" + std::to_string(getpid()) + ending;
    std::ofstream(path, std::ios::binary) << text;
    RobotProgram program = ReadRobotProgram(path, 6);
    std::filesystem::remove(path);
    return program;
  }

  // Of what scene_ states, the names that the program has: others are refused.
  ProgramScene SceneOf(const RobotProgram& program) const {
    ProgramScene scene = scene_;
    const auto is_there = [&](const std::string& name, std::string ProgramPoint::*of) {
      return std::any_of(program.points.begin(), program.points.end(), [&](const auto& p) { return p.*of == name; });
    };
    const auto keep = [&](auto* stated, const char* root, std::string ProgramPoint::*of) {
      for (auto it = stated->begin(); it != stated->end();) {
        const bool is_known = it->first == root || it->first == "default" || is_there(it->first, of);
        it = is_known ? std::next(it) : stated->erase(it);
      }
    };
    keep(&scene.tools, kFlangeName, &ProgramPoint::tool);
    keep(&scene.frames, kWorldName, &ProgramPoint::frame);
    return scene;
  }
  CompensatedProgram Compensated(const KnownRobot& known, const RobotProgram& program) const {
    return CompensateProgram(known, program, SceneOf(program), 1);
  }

  // Runs the corrected program on the true robot: the k-th point has to end where the nominal robot has q[k].
  void ExpectOnTarget(const std::string& ending, const std::string& text, const std::vector<Eigen::VectorXd>& q,
                      const Pose<double>& frame) {
    SCOPED_TRACE(ending);
    const CompensatedProgram result = Compensated(TrueRobot(truth_), ReadAs(ending, text));
    const RobotProgram corrected = ReadAs(ending, result.text);
    ASSERT_EQ(corrected.points.size(), q.size()) << SummaryOf(result);
    const Chain nominal = test::Kr270Chain();
    const ForwardModel model(nominal);
    const LoadedArm arm(model, model.NominalValues());
    for (size_t k = 0; k < q.size(); ++k) {
      SCOPED_TRACE(result.program.points[k].name);
      ASSERT_EQ(result.results[k].untouched, "");
      const ProgramPoint& point = corrected.points[k];
      Eigen::VectorXd commanded;
      if (point.is_joints) {
        const std::vector<double> values = corrected.JointValues(point);
        commanded = Eigen::Map<const Eigen::VectorXd>(values.data(), 6);
      } else {
        std::vector<double> numbers;
        for (const TextNumber& number : point.numbers) numbers.push_back(number.value);
        const Pose<double> flange =
            Times(Times(frame, PoseFrom(corrected.traits().notation, numbers)), Back(kToolInFlange));
        const FlangeSolution solution = SolveFlange(
            nominal,
            [&](const Eigen::VectorXd& at, FlangeState* state) {
              return arm.At(at, ShotInput(at), Matrix3<double>::Identity(), {}, state);
            },
            flange, q[k], false);
        commanded = solution.q;
        EXPECT_LT((NominalFlange(commanded).translation - flange.translation).norm(), 1e-9);
      }
      const Pose<double> goal = NominalFlange(q[k]), there = TrueFlange(truth_, commanded);
      EXPECT_LT((there.translation - goal.translation).norm(), kWritten);
      EXPECT_LT((there.rotation - goal.rotation).norm(), kWritten);
      EXPECT_GT((TrueFlange(truth_, q[k]).translation - goal.translation).norm(), 1e-3);  // without it
      EXPECT_NEAR((commanded - q[k]).norm(), 0.0, 0.05);  // on the branch that was meant
    }
  }

  const LoadedTruth truth_ = test::Everything();
  ProgramScene scene_;
};

inline const std::vector<const char*> kKrlNames = {"X ", "Y ", "Z ", "A ", "B ", "C "};
inline const std::vector<const char*> kFanucNames = {"X = ", "Y = ", "Z = ", "W = ", "P = ", "R = "};

// KUKA's status from the drawing of the arm (Z = forward, forearm 1100 along and -55 across, upper arm 1250): bit 1
// where joint 3 is beyond the angle at which shoulder, elbow and wrist are in line.
inline int KrlStatus(const Eigen::VectorXd& q) {
  const ArmState state = NominalArm(q);
  const Vector3<double> wrist = state.origin[4];
  const Vector3<double> forward(std::cos(q[0]), std::sin(q[0]), 0.0);
  const double stretched = std::atan2(-55.0, 1100.0);  // Ry(A3) turns (1100, -55) down by A3: in line at -atan(55/1100)
  return (wrist.dot(forward) < 0.0 ? 1 : 0) + (q[2] >= stretched ? 2 : 0) + (q[4] < 0.0 ? 4 : 0);
}

inline int KrlTurn(const Eigen::VectorXd& q) {
  int turn = 0;
  for (int j = 0; j < 6; ++j) turn += q[j] < 0.0 ? 1 << j : 0;
  return turn;
}

}  // namespace sagitta::program_test

// An effect of one's own, as docs/ADDING_AN_EFFECT.md adds it: defined
// outside the catalogue, carried by the robot, held to the catalogue's contract,
// read and written, estimated, and found by the diagnosis where it is hidden.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "estimator/diagnosis/diagnose.h"
#include "estimator/results/estimate_json.h"
#include "estimator/sagitta.h"
#include "problems/input_error.h"
#include "problems/io/effect_entries.h"
#include "problems/io/robot_file.h"
#include "tests/support/driven_harmonic.h"
#include "tests/support/effect_contract.h"
#include "tests/support/moved_kr270.h"

namespace sagitta::own_effect_test {
namespace {

const std::vector<const EffectDefinition*>& Own() {
  static const std::vector<const EffectDefinition*> own = {&test::DrivenHarmonic()};
  return own;
}

constexpr double kSigma = 2e-5;                // m
constexpr double kCos = 70e-6, kSin = -40e-6;  // rad
const char* const kPath = "effect/driven_harmonic[driver=A2,order=2]/A3";

// 40 configurations from one station; joint 3 is off with twice the angle of joint 2.
CalibrationProblem Hidden(const Robot& robot) {
  const Measurements data = test::MeasuredAfter(test::CampaignOf(40, 1, kSigma, 31), 131, [](Eigen::VectorXd* q) {
    (*q)[2] += kCos * std::cos(2 * (*q)[1]) + kSin * std::sin(2 * (*q)[1]);
  });
  Experiment experiment;
  experiment.validation.kind = ValidationSpec::Kind::kFraction;
  experiment.validation.fraction = 0.3;
  return MakeCalibrationProblem(robot, data, experiment);
}

Robot ArmThatKnowsIt() {
  Robot robot = test::Kr270Robot();
  robot.own_effects = Own();
  return robot;
}

TEST(OwnEffect, IsNoneOfTheCatalogue) {
  EXPECT_EQ(FindEffect("driven_harmonic"), nullptr);
  EXPECT_EQ(FindEffect(Robot(), "driven_harmonic"), nullptr);
  EXPECT_EQ(FindEffect(ArmThatKnowsIt(), "driven_harmonic"), &test::DrivenHarmonic());
}

TEST(OwnEffect, KeepsTheContract) {
  const std::vector<EffectSpec> uses = test::ContractUses(Own());
  ASSERT_EQ(uses.size(), 2u);  // orders 1 and 3
  for (size_t i = 0; i < uses.size(); ++i) test::ExpectEffectContract(uses[i], 500 + static_cast<int>(i), Own());
}

TEST(OwnEffect, ReadsBackAsWrittenAndIsRefusedWhereNobodyKnowsIt) {
  const std::string text = R"(schema: sagitta/robot/1
joints:
  - {name: A1, type: revolute}
  - {name: A2, type: revolute}
kinematics:
  chain:
    - {Rz: A1}
    - {Tx_mm: 400}
    - {Ry: A2}
effects:
  - {effect: driven_harmonic, joint: A2, driver: A1, order: 3, cos_urad: 12, sin_urad: -7}
)";
  const Robot robot = ReadRobotText(text, "robot.yaml", Own());
  const Robot again = ReadRobotText(RobotToYaml(robot), "again.yaml", Own());
  ASSERT_EQ(again.effects.size(), 1u);
  EXPECT_EQ(again.effects[0].Path(), "effect/driven_harmonic[driver=A1,order=3]/A2");
  EXPECT_EQ(SettingsToJson(again, again.effects[0]).dump(), R"({"driver":"A1","order":3})");
  EXPECT_NEAR(again.effects[0].values[0], 12e-6, 1e-15);
  EXPECT_NEAR(again.effects[0].values[1], -7e-6, 1e-15);
  EXPECT_THROW(ReadRobotText(text, "robot.yaml"), InputError);
}

TEST(OwnEffect, IsEstimatedWithinItsInterval) {
  Robot robot = ArmThatKnowsIt();
  robot.effects = {{"driven_harmonic", "A3", {{"driver", "A2"}, {"order", "2"}}, {}}};
  const Estimate estimate = EstimateJointly(Hidden(robot));
  ASSERT_EQ(estimate.status, Status::kConverged);
  int found = 0;
  for (const ParameterEstimate& row : estimate.table) {
    if (row.name.rfind(kPath, 0) != 0) continue;
    const double truth = row.name.back() == 's' ? kCos : kSin;  // …/cos, …/sin
    EXPECT_LT(std::abs(row.value - truth), 4 * row.sigma) << row.name;
    EXPECT_GT(row.sigma, 0.0);
    ++found;
  }
  EXPECT_EQ(found, 2);
}

TEST(OwnEffect, EstimatesThatHaveItAreReadBackAndPredictWithIt) {
  Robot robot = ArmThatKnowsIt();
  robot.effects = {{"driven_harmonic", "A3", {{"driver", "A2"}, {"order", "2"}}, {}}};
  const Calibration calibration = Calibrate(Hidden(robot));
  ASSERT_TRUE(IsUsable(calibration.estimate.status));
  const std::string text = DumpJson(CalibrationToJson(calibration, {}));
  EXPECT_THROW(ReadEstimateText(text, "estimate.json"), InputError);
  const Measurements& rows = calibration.problem.data();
  for (const KnownRobot& known : {ReadEstimateText(text, "estimate.json", Own()), KnownFrom(calibration)}) {
    ASSERT_EQ(known.robot.effects.size(), 1u);
    EXPECT_EQ(known.robot.effects[0].Path(), kPath);
    EXPECT_LT((Predict(known, rows).points - calibration.estimate.predicted).cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST(OwnEffect, IsFoundByScreeningAndNamed) {
  const Diagnosis diagnosis = Diagnose(Hidden(ArmThatKnowsIt()), DiagnosisOptions());
  ASSERT_FALSE(diagnosis.candidates.empty());
  EXPECT_EQ(diagnosis.candidates[0].spec.Path(), kPath);
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kExplained);
  ASSERT_EQ(diagnosis.effects.size(), 1u);
  EXPECT_EQ(diagnosis.effects[0].candidate.spec.Path(), kPath);
}

}  // namespace
}  // namespace sagitta::own_effect_test

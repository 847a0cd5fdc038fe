// Effects by their names, as --discriminate has them.
#include "problems/io/effect_names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "problems/input_error.h"
#include "problems/io/robot_file.h"

namespace sagitta::effect_names_test {
namespace {

using ::testing::HasSubstr;

const char* kRobot = R"(schema: sagitta/robot/1
joints:
  - {name: A1, type: revolute}
  - {name: A2, type: revolute}
  - {name: A3, type: revolute}
kinematics:
  chain:
    - {Rz: A1}
    - {Tx_mm: 400}
    - {Ry: A2}
    - {Tx_mm: 400}
    - {Ry: A3}
)";

TEST(RivalEffects, AreReadWithTheirSettings) {
  const Robot robot = ReadRobotText(kRobot, "robot.yaml");
  EXPECT_TRUE(RivalEffects(robot, "", "--discriminate").empty());
  const std::vector<EffectSpec> rivals =
      RivalEffects(robot, "joint_harmonic[order=2]/A3,joint_coupling[driver=A2]/A3", "--discriminate");
  ASSERT_EQ(rivals.size(), 2U);
  EXPECT_EQ(rivals[0].effect, "joint_harmonic");
  EXPECT_EQ(rivals[0].settings.at("order"), "2");
  EXPECT_EQ(rivals[0].target, "A3");
  EXPECT_EQ(rivals[1].Path(), "effect/joint_coupling[driver=A2]/A3");
}

// A name that leaves a setting out means its default; one that states it is the same effect.
TEST(RivalEffects, AreNamedAsOfARobotFile) {
  const Robot robot = ReadRobotText(kRobot, "robot.yaml");
  const std::vector<EffectSpec> rivals = RivalEffects(
      robot, "joint_harmonic/A3,backlash[by=torque,width_Nm=30]/A3,thermal_growth[lag_s=0]/robot", "rivals");
  ASSERT_EQ(rivals.size(), 3U);
  EXPECT_EQ(rivals[0].Path(), "effect/joint_harmonic[order=1]/A3");
  EXPECT_EQ(rivals[1].Path(), "effect/backlash[by=torque,width_Nm=30]/A3");
  EXPECT_EQ(rivals[2].Path(), "effect/thermal_growth/robot");
}

TEST(RivalEffects, NamesAreSplitOutsideOfBrackets) {
  EXPECT_EQ(SplitOutsideBrackets("base/S1,effect/backlash[by=torque,width_Nm=30]/A3,marker"),
            (std::vector<std::string>{"base/S1", "effect/backlash[by=torque,width_Nm=30]/A3", "marker"}));
  EXPECT_EQ(SplitOutsideBrackets(""), std::vector<std::string>{""});
}

TEST(RivalEffects, MistakesAreNamed) {
  const Robot robot = ReadRobotText(kRobot, "robot.yaml");
  const std::pair<const char*, const char*> cases[] = {
      {"joint_harmonic", "does not say what the effect acts on"},
      {"joint_harmonic[order=2/A3,encoder_gain/A3", "lacks a ']'"},
      {"joint_harmonic[two]/A3,encoder_gain/A3", "'two' is no setting"},
      {"joint_rattle/A3,encoder_gain/A3", "there is no effect 'joint_rattle'"},
      {"gravity_compensator/A2,encoder_gain/A3", "state it in the robot file"},
      {"joint_harmonic[orders=2]/A3,encoder_gain/A3", "has no setting 'orders'"},
      {"joint_coupling/A3,encoder_gain/A3", "needs the setting 'driver'"},
      {"joint_harmonic[order=2]/A9,encoder_gain/A3", "no joint 'A9'"},
      {"joint_harmonic[order=abc]/A3,encoder_gain/A3", "--discriminate.order: a finite number is expected"},
      {"axis_wobble[order=1.9]/A3,encoder_gain/A3", "a whole number from 1 to 1000 is needed"},
      {"joint_harmonic[order=1,order=2]/A3,encoder_gain/A3", "states 'order' twice"},
      {"hysteresis[width_deg=0]/A3,encoder_gain/A3", "a number above 0 is needed"},
      {"self_weight_sag[about=w]/A3,encoder_gain/A3", "'w' is not known here"},
      {"backlash[by=torqe]/A3,encoder_gain/A3", "did you mean 'torque'?"},
      {"backlash[by=approach,width_Nm=30]/A3,encoder_gain/A3", "goes with by=torque only"},
      {"marker_acceptance[axis=w]/M1,encoder_gain/A3", "'w' is not known here"},
      {"learnt_deviation[by=time_s,from=1,to=1,knots=2]/A3,encoder_gain/A3", "must be greater than 'from'"},
      {"learnt_deviation[by=time_s,from=0,to=1,knots=999999999]/A3,encoder_gain/A3", "from 1 to 1000"},
      {"joint_harmonic/A3,joint_harmonic[order=1]/A3", "cannot be distinguished from itself"},
      {"encoder_gain/A3,encoder_gain/A3", "cannot be distinguished from itself"},
      {"encoder_gain/A3", "two effects are expected"}};
  for (const auto& [names, words] : cases) {
    try {
      RivalEffects(robot, names, "--discriminate");
      ADD_FAILURE() << names;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(words)) << names;
    }
  }
}

}  // namespace
}  // namespace sagitta::effect_names_test

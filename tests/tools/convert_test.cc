// sagitta convert: what an effect counts from stays, or the conversion is refused.
#include <gmock/gmock.h>

#include "tests/tools/program.h"

namespace sagitta::test {
namespace {

using ::testing::HasSubstr;

class ConvertTest : public ProgramTest {
 protected:
  // The published KR 270, a chain, with more lines.
  std::string RobotWith(const std::string& lines) const {
    return Write("robot.yaml", ReadAll(Published("kr270/robot.yaml")) + lines);
  }
};

// The frame right after a joint is turned by a DH table: its u and v axes are others.
TEST_F(ConvertTest, EffectsInTheFrameOfAJointAreNotConvertedIntoAnother) {
  const std::pair<std::string, std::string> effects[] = {
      {"transverse_compliance", "effects: [{effect: transverse_compliance, joint: A2, ku_urad_per_Nm: 0.5}]\n"},
      {"axis_wobble",
       "effects: [{effect: axis_wobble, joint: A3, order: 1, u_cos_urad: 200, u_sin_urad: 0, v_cos_urad: 0, "
       "v_sin_urad: 300}]\n"},
      {"link_gravity",
       "compliance: {A2: {k_urad_per_Nm: 0.3}}\n"
       "effects: [{effect: link_gravity, joint: A2, mass_kg: 300, mx_kgm: 150, my_kgm: 10, mz_kgm: 30}]\n"}};
  for (const auto& [name, lines] : effects) {
    const std::string robot = RobotWith(lines);
    for (const std::string as : {"--as=dh", "--as=mdh"}) {
      const Outcome outcome = Run({"convert", robot, Path("table.yaml"), as});
      EXPECT_EQ(outcome.status, 2) << name << outcome.out;
      EXPECT_THAT(outcome.err, HasSubstr(name));
      EXPECT_THAT(outcome.err, HasSubstr("--as=chain"));
      EXPECT_FALSE(Exists("table.yaml"));
    }
    EXPECT_EQ(Run({"convert", robot, Path("chain.yaml"), "--as=chain"}).status, 0) << name;
  }
}

TEST_F(ConvertTest, EffectsAboutTheAxisOfAJointAre) {
  const std::string robot = RobotWith(
      "compliance: {A2: {k_urad_per_Nm: 0.3}, A5: {k_urad_per_Nm: 3}}\n"
      "effects: [{effect: joint_harmonic, joint: A3, order: 1, cos_urad: 200, sin_urad: 100}, "
      "{effect: encoder_gain, joint: A2, gain_ppm: 500}, {effect: backlash, joint: A2, by: torque, half_gap_urad: "
      "100}, "
      "{effect: base_compliance, kx_urad_per_Nm: 0.1, ky_urad_per_Nm: 0.2}, "
      "{effect: hysteresis, joint: A4, width_deg: 3, amplitude_urad: 80}, "
      "{effect: thermal_growth, growth_ppm_per_K: 11}]\n");
  for (const std::string as : {"dh", "mdh", "chain"}) {
    const Outcome outcome = Run({"convert", robot, Path(as + ".yaml"), "--as=" + as});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("moves as before"));
  }
}

// An error of the file that is never written would name a place that nobody can look up.
TEST_F(ConvertTest, ErrorsNameTheFileThatIsRead) {
  const std::string text = Write("ets.txt", "Tz(0.4) Rz(q1)\nTx(0.1) Ry(q1) Tx(0.3)\n");
  const Outcome outcome = Run({"convert", text, Path("robot.yaml")});
  EXPECT_EQ(outcome.status, 2) << outcome.out;
  EXPECT_THAT(outcome.err, HasSubstr(text + ":2: joint 1 moves two transforms"));
  EXPECT_THAT(outcome.err, ::testing::Not(HasSubstr("robot.yaml")));
  EXPECT_FALSE(Exists("robot.yaml"));
}

TEST_F(ConvertTest, ColumnsThatAreNotReadAreSaid) {
  const std::string table =
      Write("table.csv", "joint,a_mm,alpha_deg,d_mm,theta_deg,gear\n1,0,90,400,0,100\n2,5,0,0,0,-100\n");
  const Outcome outcome = Run({"convert", table, Path("robot.yaml"), "--convention=standard"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("columns not read: 'gear'"));
}

}  // namespace
}  // namespace sagitta::test

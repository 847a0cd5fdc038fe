#include "problems/io/robot_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "models/forward_model.h"
#include "tests/problems/file_test_support.h"
#include "tests/support/paths.h"

namespace sagitta::robot_file_test {
namespace {

constexpr double kDeg = M_PI / 180.0;

constexpr char kChainRobot[] = R"(schema: sagitta/robot/1
name: "Test: arm #1"
joints:
  - {name: A1, type: revolute, min_deg: -185, max_deg: 185}
  - {name: L2, type: prismatic, min_mm: 0, max_m: 1.5}
  - {name: A3, type: revolute}
kinematics:
  chain:
    - {Tz_mm: 750}
    - {Rz: A1, sign: -1, offset_deg: 12.5}
    - {Tx_m: 0.35, error: p_x1}
    - {Ry_mrad: 1.25, error: phi_y1}
    - {Ty: L2, offset_mm: 30, error: dq2}
    - {Rx: A3}
coupling: [{joint: A3, driver: A1, ratio: 0.5}]
compliance:
  A3: {table: [{q_deg: -25, k_urad_per_Nm: 0.41}, {q_rad: 0.7, k_urad_per_Nm: 0.42}]}
  A1: {k_urad_per_Nm: 0.302}
  L2: {k_um_per_N: 0.05}
gravity_compensator:
  {joint: A1, type: spring, L_mm: 184.72, a_x_mm: 685.93, a_y_mm: 123.30, s0_mm: 458, Kc_N_per_mm: 15, preload: false, prior_sigma: {a_x_mm: 300, Kc_N_per_mm: 2}}
effects: []
)";

constexpr char kDhRobot[] = R"(schema: sagitta/robot/1
name: DH arm
joints:
  - {name: j1, type: revolute}
  - {name: j2, type: prismatic}
kinematics:
  dh:
    convention: standard
    links:
      - {joint: j1, a_mm: -425.1, alpha_deg: 90, d_mm: 89.159, theta_deg: 10, beta_deg: 0.01}
      - {joint: j2, a_mm: 0, alpha_rad: 0.1, d_m: 0.2, theta_deg: 0}
    flange: {xyz_mm: [1, 2, 3.3], rpy_deg: [10, -20, 30]}
)";

void ExpectSame(const Robot& a, const Robot& b) {
  EXPECT_EQ(a.name, b.name);
  ASSERT_EQ(a.num_joints(), b.num_joints());
  for (int j = 0; j < a.num_joints(); ++j) {
    EXPECT_EQ(a.chain.joints[j].name, b.chain.joints[j].name);
    EXPECT_EQ(a.chain.joints[j].type, b.chain.joints[j].type);
    ASSERT_EQ(a.chain.joints[j].min.has_value(), b.chain.joints[j].min.has_value());
    EXPECT_NEAR(a.chain.joints[j].min.value_or(0), b.chain.joints[j].min.value_or(0), 1e-12);
    ASSERT_EQ(a.chain.joints[j].max.has_value(), b.chain.joints[j].max.has_value());
    EXPECT_NEAR(a.chain.joints[j].max.value_or(0), b.chain.joints[j].max.value_or(0), 1e-12);
  }
  ASSERT_EQ(a.chain.num_transforms(), b.chain.num_transforms());
  for (int e = 0; e < a.chain.num_transforms(); ++e) {
    EXPECT_EQ(a.chain.transforms[e].motion, b.chain.transforms[e].motion);
    EXPECT_EQ(a.chain.transforms[e].axis, b.chain.transforms[e].axis);
    EXPECT_NEAR(a.chain.transforms[e].nominal, b.chain.transforms[e].nominal, 1e-12);
    EXPECT_EQ(a.chain.transforms[e].joint, b.chain.transforms[e].joint);
    EXPECT_EQ(a.chain.transforms[e].sign, b.chain.transforms[e].sign);
    EXPECT_EQ(a.chain.transforms[e].error, b.chain.transforms[e].error);
  }
  ASSERT_EQ(a.chain.couplings.size(), b.chain.couplings.size());
  for (size_t i = 0; i < a.chain.couplings.size(); ++i) {
    EXPECT_EQ(a.chain.couplings[i].joint, b.chain.couplings[i].joint);
    EXPECT_EQ(a.chain.couplings[i].driver, b.chain.couplings[i].driver);
    EXPECT_EQ(a.chain.couplings[i].ratio, b.chain.couplings[i].ratio);
  }
  ASSERT_EQ(a.compliances.size(), b.compliances.size());
  for (size_t i = 0; i < a.compliances.size(); ++i) {
    EXPECT_EQ(a.compliances[i].joint, b.compliances[i].joint);
    EXPECT_EQ(a.compliances[i].is_table, b.compliances[i].is_table);
    ASSERT_EQ(a.compliances[i].nodes.size(), b.compliances[i].nodes.size());
    for (size_t n = 0; n < a.compliances[i].nodes.size(); ++n) {
      EXPECT_NEAR(a.compliances[i].nodes[n].q, b.compliances[i].nodes[n].q, 1e-12);
      EXPECT_NEAR(a.compliances[i].nodes[n].k, b.compliances[i].nodes[n].k, 1e-18);
    }
  }
  ASSERT_EQ(a.gravity_compensator.has_value(), b.gravity_compensator.has_value());
  if (!a.gravity_compensator) return;
  EXPECT_EQ(a.gravity_compensator->joint, b.gravity_compensator->joint);
  EXPECT_EQ(a.gravity_compensator->preload, b.gravity_compensator->preload);
  EXPECT_NEAR(a.gravity_compensator->L, b.gravity_compensator->L, 1e-12);
  EXPECT_NEAR(a.gravity_compensator->a_x, b.gravity_compensator->a_x, 1e-12);
  EXPECT_NEAR(a.gravity_compensator->a_y, b.gravity_compensator->a_y, 1e-12);
  EXPECT_NEAR(a.gravity_compensator->s0, b.gravity_compensator->s0, 1e-12);
  EXPECT_NEAR(a.gravity_compensator->Kc, b.gravity_compensator->Kc, 1e-9);
  EXPECT_EQ(a.gravity_compensator->prior_sigmas, b.gravity_compensator->prior_sigmas);
}

TEST(RobotFileTest, ReadsAChain) {
  const Robot robot = ReadRobotText(kChainRobot, "robot.yaml");
  EXPECT_EQ(robot.name, "Test: arm #1");
  ASSERT_EQ(robot.num_joints(), 3);
  EXPECT_NEAR(*robot.chain.joints[0].min, -185 * kDeg, 1e-15);
  EXPECT_EQ(robot.chain.joints[1].type, JointType::kPrismatic);
  EXPECT_EQ(*robot.chain.joints[1].max, 1.5);
  EXPECT_FALSE(robot.chain.joints[2].min.has_value());

  ASSERT_EQ(robot.chain.num_transforms(), 6);
  EXPECT_EQ(robot.chain.transforms[0].nominal, 0.75);
  const ElementaryTransform& a1 = robot.chain.transforms[1];
  EXPECT_EQ(a1.motion, Motion::kRotation);
  EXPECT_EQ(a1.axis, Axis::kZ);
  EXPECT_EQ(a1.joint, 0);
  EXPECT_EQ(a1.sign, -1.0);
  EXPECT_NEAR(a1.nominal, 12.5 * kDeg, 1e-15);
  EXPECT_EQ(robot.chain.transforms[2].nominal, 0.35);
  EXPECT_EQ(robot.chain.transforms[2].error, "p_x1");
  EXPECT_EQ(robot.chain.transforms[3].nominal, 1.25e-3);
  EXPECT_EQ(robot.chain.transforms[4].motion, Motion::kTranslation);
  EXPECT_EQ(robot.chain.transforms[4].joint, 1);
  EXPECT_EQ(robot.chain.transforms[4].nominal, 0.03);
  EXPECT_EQ(robot.chain.transforms[4].error, "dq2");
}

TEST(RobotFileTest, ReadsCouplingComplianceAndCompensator) {
  const Robot robot = ReadRobotText(kChainRobot, "robot.yaml");
  ASSERT_EQ(robot.chain.couplings.size(), 1u);
  EXPECT_EQ(robot.chain.couplings[0].joint, 2);
  EXPECT_EQ(robot.chain.couplings[0].driver, 0);
  EXPECT_EQ(robot.chain.couplings[0].ratio, 0.5);

  ASSERT_EQ(robot.compliances.size(), 3u);
  EXPECT_EQ(robot.compliances[0].joint, 2);
  EXPECT_TRUE(robot.compliances[0].is_table);
  ASSERT_EQ(robot.compliances[0].nodes.size(), 2u);
  EXPECT_NEAR(robot.compliances[0].nodes[0].q, -25 * kDeg, 1e-15);
  EXPECT_NEAR(robot.compliances[0].nodes[1].k, 0.42e-6, 1e-20);
  EXPECT_FALSE(robot.compliances[1].is_table);
  EXPECT_NEAR(robot.compliances[1].nodes.at(0).k, 0.302e-6, 1e-20);
  EXPECT_NEAR(robot.compliances[2].nodes.at(0).k, 0.05e-6, 1e-20);

  ASSERT_TRUE(robot.gravity_compensator.has_value());
  EXPECT_EQ(robot.gravity_compensator->joint, 0);
  EXPECT_NEAR(robot.gravity_compensator->L, 0.18472, 1e-15);
  EXPECT_EQ(robot.gravity_compensator->Kc, 15e3);
  EXPECT_FALSE(robot.gravity_compensator->preload);
  EXPECT_EQ(robot.gravity_compensator->prior_sigmas, (std::vector<double>{0.0, 0.3, 0.0, 0.0, 2e3}));
}

TEST(RobotFileTest, ReadsDhTables) {
  const Robot robot = ReadRobotText(kDhRobot, "robot.yaml");
  ASSERT_TRUE(robot.dh.has_value());
  EXPECT_EQ(robot.dh->convention, DhConvention::kStandard);
  EXPECT_EQ(robot.dh->links[0].d, 0.089159);
  EXPECT_NEAR(robot.dh->links[0].beta, 0.01 * kDeg, 1e-18);
  EXPECT_EQ(robot.dh->links[1].alpha, 0.1);
  EXPECT_EQ(robot.dh->links[1].d, 0.2);
  EXPECT_EQ(robot.dh->links[1].theta, 0.0);
  EXPECT_NEAR(robot.dh->flange_rpy.y(), -20 * kDeg, 1e-15);
  EXPECT_EQ(robot.chain.num_transforms(), 5 + 5 + 6);
  EXPECT_GE(robot.chain.FindError("j2.d"), 0);
  const Robot modified = ReadRobotText(Replaced(kDhRobot, "standard", "modified"), "robot.yaml");
  EXPECT_EQ(modified.dh->convention, DhConvention::kModified);
  EXPECT_EQ(modified.chain.transforms[0].error, "j1.alpha");
}

TEST(RobotFileTest, RoundTrips) {
  const std::string modified = Replaced(kDhRobot, "standard", "modified");
  for (const std::string& text : {std::string(kChainRobot), std::string(kDhRobot), modified}) {
    const Robot robot = ReadRobotText(text, "robot.yaml");
    ExpectSame(robot, ReadRobotText(RobotToYaml(robot), "yaml"));
    ExpectSame(robot, ReadRobotText(RobotToJson(robot).dump(), "compact json"));
    ExpectSame(robot, ReadRobotText(RobotToJson(robot).dump(2), "json"));
    EXPECT_EQ(robot.dh.has_value(), RobotToJson(robot)["kinematics"].contains("dh"));
  }
}

TEST(RobotFileTest, RoundTripsEstimatedValues) {
  Robot robot = WithGeometricErrors(ReadRobotText(kDhRobot, "robot.yaml"),
                                    {{"j1.a", 1e-3 / 3}, {"j1.theta", -M_PI / 700}, {"j2.beta", 1e-5 / 7}});
  ExpectSame(robot, ReadRobotText(RobotToYaml(robot), "yaml"));
  robot = WithGeometricErrors(ReadRobotText(kChainRobot, "robot.yaml"),
                              {{"p_x1", 1e-3 / 3}, {"phi_y1", -M_PI / 700}, {"dq2", 1e-5 / 7}});
  ExpectSame(robot, ReadRobotText(RobotToYaml(robot), "yaml"));
}

TEST(RobotFileTest, KeepsOddNames) {
  for (const char* name : {"null", "12", "true", "a: b", "# x", "\"q\"", "- x", "\xC3\xA4rm", "[a]", "~", "a\\b"}) {
    Robot robot = ReadRobotText(kDhRobot, "robot.yaml");
    robot.name = name;
    EXPECT_EQ(ReadRobotText(RobotToYaml(robot), "yaml").name, name);
    EXPECT_EQ(ReadRobotText(RobotToJson(robot).dump(), "json").name, name);
  }
}

TEST(RobotFileTest, YamlKeepsShortMapsOnOneLine) {
  const std::string yaml = RobotToYaml(ReadRobotText(kChainRobot, "robot.yaml"));
  EXPECT_NE(yaml.find("    - {Rz: A1, sign: -1, offset_deg: 12.5}\n"), std::string::npos) << yaml;
  EXPECT_NE(yaml.find("  - {name: A1, type: revolute, min_deg: -185, max_deg: 185}\n"), std::string::npos) << yaml;
  EXPECT_NE(yaml.find("  A1: {k_urad_per_Nm: 0.302}\n"), std::string::npos) << yaml;
}

TEST(RobotFileTest, ReadsTheSharedRobots) {
  const std::string folder = test::SharedFolder() + "/data/";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "the shared data are not here: " << folder;
  for (const char* file : {"ur5_gts3800/robot.yaml", "ur10_leica/robot.yaml", "practice/case000/robot.yaml",
                           "practice/case007/robot.yaml", "practice/case021/robot.yaml"}) {
    const Robot robot = ReadRobotFile(folder + file);
    EXPECT_EQ(robot.num_joints(), 6) << file;
    ExpectSame(robot, ReadRobotText(RobotToYaml(robot), file));
  }
}

struct BadRobot {
  const char* name;
  const char* text;  // of which robot
  const char* from;
  const char* to;
  std::vector<std::string> says;  // in this order
};

class BadRobotTest : public ::testing::TestWithParam<BadRobot> {};

TEST_P(BadRobotTest, IsRefusedWithWords) {
  const BadRobot& bad = GetParam();
  const std::string text = Replaced(bad.text, bad.from, bad.to);
  const std::string message = ErrorOf([&] { ReadRobotText(text, "robot.yaml"); });
  std::vector<std::string> says = {"robot.yaml:"};
  says.insert(says.end(), bad.says.begin(), bad.says.end());
  EXPECT_TRUE(SaysInOrder(message, says));
}

INSTANTIATE_TEST_SUITE_P(
    Top, BadRobotTest,
    ::testing::Values(
        BadRobot{"schema",
                 kDhRobot,
                 "sagitta/robot/1",
                 "sagitta/robot/2",
                 {"1: schema", "sagitta/robot/2", "sagitta/robot/1"}},
        BadRobot{"experiment", kDhRobot, "sagitta/robot/1", "sagitta/experiment/1", {"1: schema"}},
        BadRobot{"no_schema", kDhRobot, "schema: sagitta/robot/1\n", "", {"schema", "missing"}},
        BadRobot{"unknown_key", kDhRobot, "name: DH arm", "nmae: DH arm", {"2: nmae", "unknown", "name"}},
        BadRobot{"unknown_key_far", kDhRobot, "name: DH arm", "colour: red", {"2: colour", "unknown", "known: schema"}},
        BadRobot{"joints_misspelt", kDhRobot, "joints:", "jonts:", {"3: jonts", "unknown", "'joints'"}},
        BadRobot{"twice", kDhRobot, "name: DH arm", "name: DH arm\nname: b", {"3: name", "twice"}},
        BadRobot{"no_yaml", kDhRobot, "name: DH arm", "name: [", {"not YAML"}},
        BadRobot{"list", kDhRobot, "schema: sagitta/robot/1\n", "- a\n", {"1: ", "a map", "a list"}},
        BadRobot{"name_empty", kDhRobot, "name: DH arm", "name:", {"2: name", "empty"}},
        BadRobot{"effect",
                 kChainRobot,
                 "effects: []",
                 "effects: [{effect: joint_harmonc, joint: A3, order: 1}]",
                 {"22: effects[0].effect", "no effect 'joint_harmonc'", "joint_harmonic"}}),
    [](const auto& param) { return std::string(param.param.name); });

INSTANTIATE_TEST_SUITE_P(
    Joints, BadRobotTest,
    ::testing::Values(
        BadRobot{
            "type", kDhRobot, "type: prismatic", "type: prismtic", {"5: joints[1].type", "prismtic", "'prismatic'"}},
        BadRobot{"same_name", kDhRobot, "name: j2", "name: j1", {"5: joints[1]", "j1"}},
        BadRobot{"limits_swapped", kChainRobot, "max_deg: 185", "max_deg: -190", {"4: joints[0]", "A1", "min"}},
        BadRobot{
            "limit_unit", kChainRobot, "min_mm: 0", "min_deg: 0", {"5: joints[1].min_deg", "unit", "min_mm, min_m"}},
        BadRobot{"limit_no_unit", kChainRobot, "min_mm: 0", "min: 0", {"5: joints[1].min", "unit", "min_mm, min_m"}},
        BadRobot{"limit_text", kChainRobot, "-185", "left", {"4: joints[0].min_deg", "'left'"}},
        BadRobot{"limit_nan", kChainRobot, "-185", ".nan", {"4: joints[0].min_deg", "finite"}},
        BadRobot{"limit_inf", kChainRobot, "-185", "-.inf", {"4: joints[0].min_deg", "finite"}},
        BadRobot{"two_units",
                 kChainRobot,
                 "min_deg: -185",
                 "min_deg: -185, min_rad: -3",
                 {"4: joints[0].min_rad", "two units"}},
        BadRobot{"no_name", kChainRobot, "name: A1, type", "type", {"4: joints[0].name", "missing"}}),
    [](const auto& param) { return std::string(param.param.name); });

INSTANTIATE_TEST_SUITE_P(
    Kinematics, BadRobotTest,
    ::testing::Values(
        BadRobot{"convention",
                 kDhRobot,
                 "convention:",
                 "conventoin:",
                 {"8: kinematics.dh.conventoin", "unknown", "'convention'"}},
        BadRobot{"convention_value", kDhRobot, "standard", "standart", {"8: kinematics.dh.convention", "'standard'"}},
        BadRobot{"centimetres",
                 kDhRobot,
                 "a_mm: -425.1",
                 "a_cm: -42.51",
                 {"10: kinematics.dh.links[0].a_cm", "unit", "a_mm, a_m"}},
        BadRobot{"degrees",
                 kDhRobot,
                 "alpha_deg",
                 "alpha_grad",
                 {"10: kinematics.dh.links[0].alpha_grad", "alpha_deg, alpha_rad, alpha_mrad, alpha_urad"}},
        BadRobot{"link_joint",
                 kDhRobot,
                 "joint: j2",
                 "joint: J2",
                 {"11: kinematics.dh.links[1].joint", "no joint 'J2'", "'j2'"}},
        BadRobot{"link_order", kDhRobot, "joint: j1", "joint: j2", {"10: kinematics.dh.links[0]", "j2", "j1"}},
        BadRobot{"a_missing", kDhRobot, "a_mm: 0, ", "", {"11: kinematics.dh.links[1].a_mm", "missing", "a_m"}},
        BadRobot{"a_missing_next_to_d", kDhRobot, "a_mm: -425.1, ", "", {"10: kinematics.dh.links[0].a_mm", "missing"}},
        BadRobot{"alpha_missing", kDhRobot, "alpha_deg: 90, ", "", {"10: kinematics.dh.links[0].alpha_deg", "missing"}},
        BadRobot{"a_x_missing", kChainRobot, "a_x_mm: 685.93, ", "", {"gravity_compensator.a_x_mm", "missing"}},
        BadRobot{"theta_missing", kDhRobot, ", theta_deg: 0", "", {"11: kinematics.dh.links[1].theta_deg", "missing"}},
        BadRobot{"link_missing",
                 kDhRobot,
                 "      - {joint: j2, a_mm: 0, alpha_rad: 0.1, d_m: 0.2, theta_deg: 0}\n",
                 "",
                 {"9: kinematics.dh.links", "1 links and 2 joints"}},
        BadRobot{"flange", kDhRobot, "[1, 2, 3.3]", "[1, 2]", {"12: kinematics.dh.flange.xyz_mm", "three"}},
        BadRobot{"flange_text", kDhRobot, "[1, 2, 3.3]", "[1, 2, x]", {"12: kinematics.dh.flange.xyz_mm[2]", "'x'"}},
        BadRobot{"urdf", kDhRobot, "  dh:", "  urdf: {file: kr270.urdf}\n  x_dh:", {"kinematics.x_dh"}},
        BadRobot{
            "both", kDhRobot, "  dh:", "  chain: [{Rz: j1}]\n  dh:", {"kinematics", "exactly one", "chain, dh, urdf"}},
        BadRobot{"chain_unit",
                 kChainRobot,
                 "Tz_mm: 750",
                 "Tz_cm: 75",
                 {"9: kinematics.chain[0].Tz_cm", "unit", "Tz_mm, Tz_m"}},
        BadRobot{"chain_two",
                 kChainRobot,
                 "{Tz_mm: 750}",
                 "{Tz_mm: 750, Tx_mm: 1}",
                 {"9: kinematics.chain[0]", "exactly one", "this has 2"}},
        BadRobot{
            "chain_none", kChainRobot, "{Tz_mm: 750}", "{error: x}", {"9: kinematics.chain[0]", "this has 0", "Tx_mm"}},
        BadRobot{"chain_number", kChainRobot, "Tz_mm: 750", "Tz: 750", {"9: kinematics.chain[0].Tz", "joint's name"}},
        BadRobot{"chain_joint", kChainRobot, "Rx: A3", "Rx: A4", {"14: kinematics.chain[5].Rx", "'A4'", "A1, L2, A3"}},
        BadRobot{"chain_kind", kChainRobot, "Rx: A3", "Tx: A3", {"14: kinematics.chain[5].Tx", "'A3' is revolute"}},
        BadRobot{"chain_kind_2", kChainRobot, "Ty: L2", "Ry: L2", {"13: kinematics.chain[4].Ry", "'L2' is prismatic"}},
        BadRobot{"chain_twice", kChainRobot, "Rx: A3", "Rx: A1", {"14: kinematics.chain[5]", "'A1' is on two"}},
        BadRobot{"chain_lost", kChainRobot, "    - {Rx: A3}\n", "", {"kinematics", "'A3' is on no transform"}},
        BadRobot{"chain_error", kChainRobot, "phi_y1", "p_x1", {"12: kinematics.chain[3]", "'p_x1'", "two"}},
        BadRobot{"chain_sign", kChainRobot, "sign: -1", "sign: 2", {"10: kinematics.chain[1].sign", "1 or -1"}},
        BadRobot{"chain_offset",
                 kChainRobot,
                 "offset_deg: 12.5",
                 "offset_mm: 12.5",
                 {"10: kinematics.chain[1].offset_mm", "offset_deg"}},
        BadRobot{"chain_key", kChainRobot, "error: p_x1", "eror: p_x1", {"11: kinematics.chain[2].eror", "'error'"}}),
    [](const auto& param) { return std::string(param.param.name); });

INSTANTIATE_TEST_SUITE_P(
    Rest, BadRobotTest,
    ::testing::Values(
        BadRobot{"coupling_self", kChainRobot, "driver: A1", "driver: A3", {"15: coupling[0]", "itself"}},
        BadRobot{"coupling_kind", kChainRobot, "driver: A1", "driver: L2", {"15: coupling[0]", "revolute"}},
        BadRobot{"coupling_key", kChainRobot, "ratio", "ration", {"15: coupling[0].ration", "'ratio'"}},
        BadRobot{
            "compliance_joint", kChainRobot, "  A1: {k_urad", "  A7: {k_urad", {"18: compliance.A7", "no joint", "A1"}},
        BadRobot{"compliance_unit",
                 kChainRobot,
                 "k_urad_per_Nm: 0.302",
                 "k_mrad_per_Nm: 0.302",
                 {"18: compliance.A1.k_mrad_per_Nm", "'k_urad_per_Nm'"}},
        BadRobot{"compliance_prismatic",
                 kChainRobot,
                 "k_um_per_N",
                 "k_urad_per_Nm",
                 {"19: compliance.L2.k_urad_per_Nm", "'L2' slides", "k_um_per_N"}},
        BadRobot{"table_order", kChainRobot, "q_deg: -25", "q_deg: 45", {"17: compliance.A3.table[1]", "increase"}},
        BadRobot{"table_misspelt", kChainRobot, "{table:", "{tabel:", {"17: compliance.A3.tabel", "'table'"}},
        BadRobot{"compensator_key",
                 kChainRobot,
                 "Kc_N_per_mm",
                 "Kc_N_per_m",
                 {"gravity_compensator.Kc_N_per_m", "Kc_N_per_mm"}},
        BadRobot{"compensator_type", kChainRobot, "spring", "gas", {"gravity_compensator.type", "spring"}},
        BadRobot{"compensator_preload", kChainRobot, "preload: false", "preload: 2", {"preload", "true or false"}},
        BadRobot{"compensator_L", kChainRobot, "L_mm: 184.72", "L_mm: 0", {"gravity_compensator", "above 0"}}),
    [](const auto& param) { return std::string(param.param.name); });

class RobotFileErrorTest : public FileTest {};

TEST_F(RobotFileErrorTest, NamesTheFile) {
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { ReadRobotFile(Path("absent.yaml")); }), {"absent.yaml", "no such file"}));
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { ReadRobotFile(Write("e.yaml", "")); }), {"e.yaml", "empty"}));
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { ReadRobotFile(Write("t.yaml", "text")); }), {"t.yaml:1", "map", "'text'"}));
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { ReadRobotFile(folder_); }), {folder_, "folder"}));
}

}  // namespace
}  // namespace sagitta::robot_file_test

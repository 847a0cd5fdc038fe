// Sizes and numbers beyond what a robot can be are refused at the reader, with words (problems/limits.h).
#include "problems/limits.h"

#include "problems/io/csv_table.h"
#include "problems/io/experiment_file.h"
#include "problems/io/import/robot_reading.h"
#include "problems/io/measurement_file.h"
#include "problems/io/robot_file.h"
#include "problems/io/yaml_reader.h"
#include "tests/problems/file_test_support.h"

namespace sagitta::limits_test {
namespace {

std::string RobotOf(int joints) {
  std::string text = "schema: sagitta/robot/1\njoints:\n", chain = "kinematics:\n  chain:\n";
  for (int j = 0; j < joints; ++j) {
    const std::string name = "j" + std::to_string(j);
    text += "  - {name: " + name + ", type: revolute}\n";
    chain += "    - {Rz: " + name + "}\n    - {Tx_mm: 100}\n";
  }
  return text + chain;
}

std::string RobotError(const std::string& text) {
  return ErrorOf([&] { ReadRobotText(text, "r.yaml"); });
}

TEST(LimitsTest, Joints) {
  EXPECT_EQ(RobotError(RobotOf(64)), "");
  EXPECT_TRUE(SaysInOrder(RobotError(RobotOf(65)), {"r.yaml", "joints", "64 joints"}));
  // Counted before anything is looked up by name, which would need minutes.
  EXPECT_TRUE(SaysInOrder(RobotError(RobotOf(20000)), {"r.yaml", "joints", "64 joints"}));
}

TEST(LimitsTest, AliasesThatStandForBillions) {
  std::string bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 12; ++i) {
    const std::string alias = "*a" + std::to_string(i - 1);
    bomb += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " {";
    for (int k = 0; k < 9; ++k) bomb += (k > 0 ? ", k" : "k") + std::to_string(k) + ": " + alias;
    bomb += "}\n";
  }
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { ParseYaml(bomb, "e.yaml"); }), {"e.yaml", "1000000 values", "aliases"}));
  EXPECT_NE(ErrorOf([] { ParseYaml("a: &a [*a]\n", "e.yaml"); }), "");
  EXPECT_EQ(ErrorOf([] { ParseYaml("a: &a [1]\nb: *a\n", "e.yaml"); }), "");
}

TEST(LimitsTest, DepthAndLength) {
  const auto error = [](const std::string& text) { return ErrorOf([&] { ParseYaml(text, "e.yaml"); }); };
  EXPECT_TRUE(SaysInOrder(error(std::string(70, '[') + std::string(70, ']')), {"e.yaml:1", "64 deep"}));
  EXPECT_NE(error(std::string(100000, '[')), "");
  EXPECT_NE(error(std::string(100000, '{')), "");
  EXPECT_TRUE(SaysInOrder(error("a: '" + std::string(9 << 20, 'x') + "'"), {"e.yaml", "8 MB"}));
}

// As of a file: tables of programs are read by the same rules.
TEST(LimitsTest, TablesInMemory) {
  const auto error = [](const std::vector<std::string>& header, const std::vector<std::vector<std::string>>& columns) {
    return ErrorOf([&] { CsvTableOf("rows", header, columns); });
  };
  EXPECT_EQ(error({"config", "q1_deg"}, {{"C1", "C2"}, {"1", "2"}}), "");
  EXPECT_EQ(error({"config"}, {{"a\tb"}}), "");
  EXPECT_TRUE(SaysInOrder(error({}, {}), {"rows", "no rows"}));
  EXPECT_TRUE(SaysInOrder(error({"config", "config"}, {{"C1"}, {"C2"}}), {"rows", "config", "twice"}));
  EXPECT_TRUE(SaysInOrder(error({"config"}, {{"C1", "C\x1b[2J"}}), {"rows:2", "config", "U+001B"}));
  EXPECT_TRUE(SaysInOrder(error({"config"}, {{"C\xff"}}), {"rows:1", "config", "UTF-8"}));
  EXPECT_TRUE(SaysInOrder(error({"con\nfig"}, {{"C1"}}), {"rows", "U+000A"}));
  std::vector<std::string> header;
  for (size_t c = 0; c <= limits::kColumns; ++c) header.push_back("c" + std::to_string(c));
  EXPECT_TRUE(SaysInOrder(error(header, std::vector<std::vector<std::string>>(header.size(), {""})), {"4096 columns"}));
  const std::string megabytes(16 << 20, 'x');
  EXPECT_TRUE(SaysInOrder(error({"config"}, {std::vector<std::string>(17, megabytes)}), {"rows", "256 MB"}));
}

TEST(LimitsTest, NamesHoldNoControlCharacters) {
  std::string robot = RobotOf(2);
  EXPECT_TRUE(SaysInOrder(RobotError(Replaced(robot, "name: j1", "name: \"j\\e[2J\"")), {"r.yaml:4", "U+001B"}));
  EXPECT_NE(RobotError(Replaced(robot, "name: j1", "\"na\\0me\": j1")), "");
}

TEST(LimitsTest, LengthsAndAngles) {
  const std::string robot = RobotOf(2);
  EXPECT_TRUE(SaysInOrder(RobotError(Replaced(robot, "Tx_mm: 100", "Tx_mm: 1e12")), {"r.yaml:8", "km"}));
  EXPECT_NE(RobotError(Replaced(robot, "Tx_mm: 100", "Tx_mm: 1e308")), "");
  EXPECT_NE(RobotError(Replaced(robot, "Tx_mm: 100", "Rx_rad: 1e300")), "");
  EXPECT_NE(RobotError(robot + "compliance:\n  j0: {k_urad_per_Nm: 1e-300}\n"), "");
  EXPECT_NE(RobotError(robot + "compliance:\n  j0: {k_urad_per_Nm: 1e12}\n"), "");
  EXPECT_EQ(RobotError(robot + "compliance:\n  j0: {k_urad_per_Nm: 0}\n"), "");
}

std::string RowError(const std::string& header, const std::string& cells) {
  const Robot robot = ReadRobotText(RobotOf(1), "r.yaml");
  return ErrorOf([&] {
    ReadMeasurementsText(robot, "config,marker,q1_deg,x_mm,y_mm,z_mm," + header + "\nc,m,1,2,3,4," + cells + "\n",
                         "m.csv");
  });
}

TEST(LimitsTest, StandardDeviations) {
  const auto error = [](const std::string& sigma) {
    return RowError("sigma_x_mm,sigma_y_mm,sigma_z_mm", sigma + ",0.1,0.1");
  };
  EXPECT_EQ(error("0.1"), "");
  EXPECT_EQ(error("1e-6"), "");
  for (const char* sigma : {"0", "-1", "1e-300", "1e-12", "1e308", "1e9", "4.9e-324"}) {
    EXPECT_TRUE(SaysInOrder(error(sigma), {"m.csv:2: sigma_x_mm", "standard deviation"})) << sigma;
  }
}

TEST(LimitsTest, Quantities) {
  EXPECT_EQ(RowError("load,fz_N", "L,-2600"), "");
  EXPECT_TRUE(SaysInOrder(RowError("load,fz_N", "L,1e30"), {"m.csv:2: fz_N", "beyond", "at most 1e+07"}));
  EXPECT_TRUE(SaysInOrder(RowError("time_s", "1.7e12"), {"m.csv:2: time_s"}));
  EXPECT_EQ(RowError("time_s", "1.7e9"), "");
  EXPECT_NE(RowError("temperature_degC", "1e5"), "");
  const Robot robot = ReadRobotText(RobotOf(1), "r.yaml");
  EXPECT_TRUE(SaysInOrder(
      ErrorOf([&] { ReadMeasurementsText(robot, "config,marker,q1_deg,x_mm,y_mm,z_mm\nc,m,1,2,3,1e12\n", "m.csv"); }),
      {"m.csv:2: z_mm", "beyond"}));
}

class LimitsOfExperimentTest : public FileTest {
 protected:
  std::string Error(const std::string& text) const {
    const std::string head = "schema: sagitta/experiment/1\nrobot: r.yaml\nmeasurements: [m.csv]\n";
    return ErrorOf([&] { ReadExperimentFile(Write("e.yaml", head + text)); });
  }
};

TEST_F(LimitsOfExperimentTest, Numbers) {
  EXPECT_EQ(Error("noise: {sigma_mm: 0.1}\n"), "");
  for (const char* sigma : {"1e-300", "1e-9", "1e6", "1e308"}) {
    EXPECT_NE(Error("noise: {sigma_mm: " + std::string(sigma) + "}\n"), "") << sigma;
  }
  EXPECT_EQ(Error("priors: {geometry/a: {value: 0, sigma: 1}}\n"), "");
  for (const char* sigma : {"1e14", "1e155", "1e-200"}) {
    EXPECT_TRUE(SaysInOrder(Error("priors: {geometry/a: {value: 0, sigma: " + std::string(sigma) + "}}\n"),
                            {"e.yaml:4", "geometry/a.sigma"}));
  }
  EXPECT_NE(Error("loads: {L: {mass_kg: 1e12}}\n"), "");
}

// std::regex recurses once per character: such files ended the program.
TEST(LimitsTest, ScriptsAreShort) {
  const auto error = [](const std::string& text) { return ErrorOf([&] { ReadAnyRobotText(text, "robot.conf"); }); };
  std::string list = "1", rows;
  for (int i = 0; i < 100000; ++i) list += ",1", rows += "1 2 3 4; ";
  EXPECT_TRUE(SaysInOrder(error("[DH]\na = [" + list + "]\nd = [1]\nalpha = [1]\n"), {"robot.conf"}));
  EXPECT_NE(error("[DH]\na = [" + std::string(1000000, ' ') + "]\nd = [1]\nalpha = [1]\n"), "");
  EXPECT_NE(error("dhparams = [" + rows + "];\n"), "");
  EXPECT_NE(error(std::string(1000000, '\n') + "a = [1]\n"), "");
  EXPECT_NE(error("joint,a,alpha,d,theta\nj,1,2,3," + std::string(1000000, '1') + "pi\n"), "");
  EXPECT_NE(error("joint,a,alpha,d,theta\nj,1,2,3,q99999999999999999999\n"), "");
  EXPECT_NE(
      error("joint," + std::string(1000000, ' ') + "a" + std::string(1000000, '_') + "i,alpha,d,theta\nj,1,2,3,4\n"),
      "");
  EXPECT_TRUE(SaysInOrder(RowError(std::string(1000000, 'q') + "_deg", "1"), {"m.csv:1", "column 7", "bytes"}));
}

TEST(LimitsTest, UrdfOfAnyShape) {
  const auto error = [](const std::string& text) { return ErrorOf([&] { ReadAnyRobotText(text, "r.urdf"); }); };
  std::string deep, wide = "<robot name='r'><link name='l0'/>";
  for (int i = 0; i < 100000; ++i) deep += "<a>";
  EXPECT_TRUE(SaysInOrder(error("<robot name='r'>" + deep), {"r.urdf:1", "64 deep"}));
  for (int i = 1; i < 3000; ++i) {
    const std::string n = std::to_string(i);
    wide += "<link name='l" + n + "'/><joint name='j" + n + "' type='revolute'><parent link='l0'/><child link='l" + n +
            "'/><axis xyz='0 0 1'/><limit lower='0' upper='1' effort='0' velocity='0'/></joint>";
  }
  EXPECT_TRUE(SaysInOrder(error(wide + "</robot>"), {"r.urdf", "2000 links"}));
  EXPECT_TRUE(SaysInOrder(error("<robot name='r'>\n<link"), {"r.urdf:2", "not a valid URDF"}));
  // Entities that stand for entities.
  std::string bomb = "<!DOCTYPE robot [<!ENTITY a0 \"xxxxxxxxxx\">";
  for (int i = 1; i < 12; ++i) {
    bomb += "<!ENTITY a" + std::to_string(i) + " \"";
    for (int k = 0; k < 10; ++k) bomb += "&a" + std::to_string(i - 1) + ";";
    bomb += "\">";
  }
  EXPECT_NE(error(bomb + "]><robot name='&a11;'><link name='l'/></robot>"), "");
}

}  // namespace
}  // namespace sagitta::limits_test

// What a refusal says to somebody who has never seen the program: the place, the matter, and what to do about it.
#include <gmock/gmock.h>

#include "tests/tools/program.h"

namespace sagitta::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr char kRobot[] = R"(schema: sagitta/robot/1
name: two links
joints:
  - {name: A1, type: revolute}
  - {name: A2, type: revolute}
kinematics:
  dh:
    convention: standard
    links:
      - {joint: A1, a_mm: 350, alpha_deg: -90, d_mm: 750, theta_deg: 0}
      - {joint: A2, a_mm: 1250, alpha_deg: 0, d_mm: 0, theta_deg: 0}
)";
// The rows of README.
constexpr char kRows[] = R"(config,marker,q1_deg,q2_deg,x_mm,y_mm,z_mm
c1,M1,-80,-75,70.968,-742.784,2063.596
c2,M1,-80,-20,228.507,-1637.230,1181.149
c3,M1,-80,40,179.653,-1364.178,-161.574
c4,M1,-25,-75,649.135,-367.849,2063.568
c5,M1,-25,-20,1472.220,-751.831,1181.179
c6,M1,-25,40,1220.489,-635.308,-161.613
c7,M1,30,-75,673.659,320.822,2063.578
c8,M1,30,-20,1460.293,774.760,1181.201
)";

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

std::string ReplacedEverywhere(std::string text, const std::string& from, const std::string& to) {
  for (size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

class RefusalWords : public ProgramTest {
 protected:
  std::string Robot(const std::string& text = kRobot) const { return Write("r.yaml", text); }
  std::string Rows(const std::string& text = kRows) const { return Write("m.csv", text); }
  std::string Experiment(const std::string& more) const {
    return Write("e.yaml", "schema: sagitta/experiment/1\nrobot: r.yaml\n" + more);
  }
  std::string Estimate() const {
    EXPECT_EQ(Run({"calibrate", Robot(), Rows(), "--quiet", "--out=" + Path("known")}).status, 0);
    return Path("known/estimate.json");
  }

  // Words on stderr of a run that writes nothing.
  std::string Refusal(std::vector<std::string> arguments) const {
    arguments.push_back("--out=" + Path("out"));
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.status, 2) << outcome.out << outcome.err;
    EXPECT_FALSE(Exists("out"));
    return outcome.err;
  }
};

TEST_F(RefusalWords, FlagsAreAskedForInPlainWords) {
  EXPECT_THAT(Refusal({"calibrate", Robot(), Rows(), "--holdout=some"}), HasSubstr("--holdout: 'some'"));
  EXPECT_THAT(Refusal({"calibrate", Robot(), Rows(), "--sigma_mm=0,1"}), HasSubstr("a number is expected"));
  EXPECT_THAT(Refusal({"calibrate", Robot(), Rows(), "--seed=-3"}), HasSubstr("a whole number from 0 on is expected"));
  EXPECT_THAT(Refusal({"calibrate", Robot(), Rows(), "--threads=two"}), HasSubstr("a whole number is expected"));
  EXPECT_THAT(Refusal({"calibrate", Robot(), Rows(), "--quiet=maybe"}), HasSubstr("true or false is expected"));
}

TEST_F(RefusalWords, OneHyphenIsTwo) {
  const std::string words = Refusal({"calibrate", Robot(), Rows(), "-sigma_mm=0.1"});
  EXPECT_THAT(words, HasSubstr("two hyphens"));
  EXPECT_THAT(words, HasSubstr("--sigma_mm=0.1"));
}

TEST_F(RefusalWords, FilesThatAnExperimentNames) {
  Robot();
  Rows();
  const std::string rows = Refusal({"calibrate", Experiment("measurements: [m.csv, absent.csv]\n")});
  EXPECT_THAT(rows, HasSubstr("e.yaml:3: measurements: "));
  EXPECT_THAT(rows, HasSubstr("absent.csv"));
  const std::string experiment = "schema: sagitta/experiment/1\nrobot: absent.yaml\nmeasurements: m.csv\n";
  EXPECT_THAT(Refusal({"inspect", Write("e.yaml", experiment)}), HasSubstr("e.yaml:2: robot: "));
}

TEST_F(RefusalWords, OneFileAlone) {
  EXPECT_THAT(Refusal({"calibrate", Robot()}), HasSubstr("the measurements are missing"));
  EXPECT_THAT(Refusal({"calibrate", Rows()}), HasSubstr("the robot is missing"));
  EXPECT_THAT(Refusal({"calibrate", Write("e.yaml", "robot: r.yaml\nmeasurements: [m.csv]\n")}),
              HasSubstr("e.yaml: schema: this key is missing"));
  const std::string wrong = "robot: r.yaml\nschema: sagitta/robot/1\nmeasurements: [m.csv]\n";
  EXPECT_THAT(Refusal({"calibrate", Write("e.yaml", wrong)}),
              AllOf(HasSubstr("e.yaml:2: schema: this is another schema"), HasSubstr("schema: sagitta/experiment/1")));
}

TEST_F(RefusalWords, WhatIsNoYaml) {
  const std::string tab = Refusal({"calibrate", Experiment("measurements: [m.csv]\nnoise:\n\tsigma_mm: 0.1\n")});
  EXPECT_THAT(tab, HasSubstr("line 5 begins with a tab"));
  const std::string indent = Refusal({"calibrate", Robot(Replaced(kRobot, "    convention", "   convention")), Rows()});
  EXPECT_THAT(indent, HasSubstr("r.yaml:9"));
  EXPECT_THAT(indent, HasSubstr("the same indent"));
  EXPECT_THAT(indent, Not(HasSubstr("illegal map value")));
}

TEST_F(RefusalWords, ASecondDocument) {
  EXPECT_THAT(Refusal({"calibrate", Robot(std::string(kRobot) + "---\nfoo: bar\n"), Rows()}),
              AllOf(HasSubstr("r.yaml:13: a second document begins here"), HasSubstr("remove the ---")));
  const std::string closed = Robot("---\n" + std::string(kRobot) + "...\n---\n");
  EXPECT_EQ(Run({"inspect", closed, Rows(), "--quiet"}).status, 0);
}

TEST_F(RefusalWords, AUrdfThatIsNotThere) {
  const std::string robot = "schema: sagitta/robot/1\nname: x\nkinematics:\n  urdf: {file: nope.urdf}\n";
  EXPECT_THAT(Refusal({"calibrate", Robot(robot), Rows()}),
              AllOf(HasSubstr("r.yaml:4: kinematics.urdf.file: there is no file"), HasSubstr("nope.urdf")));
}

// Every command has these flags.
TEST_F(RefusalWords, ConvertHasTheFlagsOfAllCommands) {
  const Outcome outcome = Run({"convert", Robot(), "--out=" + Path("copy.yaml"), "--seed=3", "--threads=1", "--quiet"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(Exists("copy.yaml"));
  EXPECT_THAT(Run({"convert", Robot(), Path("a.yaml"), "--out=" + Path("b.yaml")}).err, HasSubstr("given twice"));
  EXPECT_THAT(Run({"convert", Robot()}).err, HasSubstr("an argument is missing"));
  EXPECT_THAT(Run({"import", Robot(), "--seed=1", "--threads=1", "--out=" + Path("job")}).err,
              Not(HasSubstr("--seed")));
}

TEST_F(RefusalWords, TablesOfSpreadsheets) {
  const auto refusal = [&](const std::string& rows) { return Refusal({"calibrate", Robot(), Rows(rows)}); };
  EXPECT_THAT(refusal(ReplacedEverywhere(kRows, ",", ";")), HasSubstr("sagitta import"));
  EXPECT_THAT(refusal(Replaced(kRows, "c3", "c\xFC")), HasSubstr("sagitta import"));
  EXPECT_THAT(refusal(ReplacedEverywhere(kRows, "\n", ",\n")), HasSubstr("end with a comma"));
  for (const char* number : {"\"179,653\"", "\"1,179.653\""}) {
    const std::string words = refusal(Replaced(kRows, "179.653", number));
    EXPECT_THAT(words, HasSubstr("m.csv:4: x_mm"));
    EXPECT_THAT(words, HasSubstr("decimal point"));
    EXPECT_THAT(words, Not(HasSubstr("lost reading")));
  }
}

// A key that the result does not have is named before what nobody measured.
TEST_F(RefusalWords, MisspeltRequirement) {
  const auto refusal = [&](const std::string& what) {
    return Refusal({"calibrate", Robot(), Rows(), "--require=" + what});
  };
  EXPECT_THAT(refusal("validation.distance_rms<0.3"), HasSubstr("did you mean 'distance_rms_mm'"));
  EXPECT_THAT(refusal("validation.distance_rms_mm<0.3"), HasSubstr("observations is 0"));
}

TEST_F(RefusalWords, WhatIsNoEstimate) {
  const std::string estimate = Estimate();
  EXPECT_THAT(Refusal({"predict", Robot(), Rows()}), HasSubstr("estimate.json belongs here"));
  const std::string half = ReadAll(estimate).substr(0, 2000);
  EXPECT_THAT(Refusal({"predict", Write("half.json", half), Rows()}), HasSubstr("is the file complete"));
}

// Neither command has a flag that states a load.
TEST_F(RefusalWords, LoadsThatTheEstimateDoesNotKnow) {
  const std::string estimate = Estimate();
  const std::string targets = Write("t.csv", "target,q1_deg,q2_deg,load\na,1,4,V250\n");
  const std::string rows = Write("l.csv", "config,marker,q1_deg,q2_deg,load\na,M1,1,4,V250\n");
  for (const std::string& words : {Refusal({"compensate", estimate, targets}), Refusal({"predict", estimate, rows})}) {
    EXPECT_THAT(words, HasSubstr(":2: load: load 'V250' is none of those in"));
    EXPECT_THAT(words, Not(HasSubstr("--load_point_mm")));
  }
}

// The estimate knows where the load acts; what is missing is the row's wrench.
TEST_F(RefusalWords, ALoadWithoutItsWrench) {
  std::string loaded = ReplacedEverywhere(kRows, "\n", ",V,0,0,-100\n");
  loaded = Replaced(loaded, "z_mm,V,0,0,-100", "z_mm,load,fx_N,fy_N,fz_N");
  ASSERT_EQ(
      Run({"calibrate", Robot(), Rows(loaded), "--quiet", "--load_point_mm=0,0,50", "--out=" + Path("known")}).status,
      0);
  const std::string rows = Write("l.csv", "config,marker,q1_deg,q2_deg,load\na,M1,1,4,V\n");
  EXPECT_THAT(
      Refusal({"predict", Path("known/estimate.json"), rows}),
      AllOf(HasSubstr(":2: load: load 'V' has no weight here"), HasSubstr("fx_N"), Not(HasSubstr("knows no load"))));
}

TEST_F(RefusalWords, AComplianceThatIsNotListed) {
  std::string loaded = ReplacedEverywhere(kRows, "\n", ",V,0,0,-100\n");
  Rows(Replaced(loaded, "z_mm,V,0,0,-100", "z_mm,load,fx_N,fy_N,fz_N"));
  Robot();
  const std::string experiment =
      Experiment("measurements: [m.csv]\nload_point_mm: [0, 0, 50]\nestimate: {compliance: [A1]}\n");
  EXPECT_THAT(Refusal({"calibrate", experiment, "--free=compliance/A2"}),
              AllOf(HasSubstr("joint 'A2' has no compliance in this estimate"), HasSubstr("estimate.compliance")));
  EXPECT_THAT(Refusal({"calibrate", experiment, "--free=compliance/A9"}), HasSubstr("no parameter 'compliance/A9'"));
}

TEST_F(RefusalWords, AValidationColumnThatIsMissing) {
  Robot();
  Rows();
  const std::string words = Refusal({"calibrate", Experiment("measurements: [m.csv]\nvalidation: {column: set}\n")});
  EXPECT_THAT(words, HasSubstr("the validation column 'set' is not in this file"));
}

constexpr char kGantry[] = R"(schema: sagitta/robot/1
name: gantry
joints:
  - {name: X, type: prismatic, min_mm: 0, max_mm: 2000}
  - {name: A1, type: revolute, min_deg: -90, max_deg: 90}
kinematics:
  chain: [{Tx: X}, {Tz_mm: 500}, {Rz: A1}, {Tx_mm: 300, error: dx}]
)";

TEST_F(RefusalWords, LinearJointsInAnotherUnit) {
  std::string poses = "config,marker,q1_mm,q2_deg\n";
  for (int i = 0; i < 12; ++i) {
    const std::string joints = "," + std::to_string(150 * i) + "," + std::to_string((47 * i) % 160 - 80) + "\n";
    for (const char* marker : {"P", "Q"}) poses += "c" + std::to_string(i) + "," + marker + joints;
  }
  Robot(kGantry);
  Rows(poses);
  const std::string truth = Experiment(
      "measurements: [m.csv]\nmarkers: {P: {xyz_mm: [100, 20, 30]}, Q: {xyz_mm: [90, -50, -40]}}\n"
      "stations: {S1: {xyz_mm: [10, 20, 30], rotvec_mrad: [3, 4, 50]}}\n");
  ASSERT_EQ(Run({"simulate", truth, "--sigma_mm=0.02", "--out=" + Path("s.csv")}).status, 0);
  const std::string rows = Write("metres.csv", Replaced(Read("s.csv"), "q1_mm", "q1_m"));
  EXPECT_THAT(Refusal({"calibrate", Path("r.yaml"), rows}),
              AllOf(HasSubstr("linear joints as millimetres"), HasSubstr("name them so (q1_mm)")));
}

TEST_F(RefusalWords, TheColumnOfALinearJointIsNamed) {
  Robot(R"(schema: sagitta/robot/1
name: scara
joints:
  - {name: A1, type: revolute, min_deg: -130, max_deg: 130}
  - {name: A2, type: revolute, min_deg: -140, max_deg: 140}
  - {name: Z, type: prismatic, min_mm: 0, max_mm: 300}
kinematics:
  chain: [{Rz: A1}, {Tx_mm: 400, error: a1}, {Rz: A2}, {Tx_mm: 250}, {Tz: Z}]
)");
  std::string poses = "config,marker,q1_deg,q2_deg,q3_mm\n";
  for (int i = 0; i < 12; ++i) {
    const std::string joints = "," + std::to_string((53 * i) % 200 - 100) + "," + std::to_string((47 * i) % 160 - 80) +
                               "," + std::to_string(25 * i) + "\n";
    for (const char* marker : {"P", "Q"}) poses += "c" + std::to_string(i) + "," + marker + joints;
  }
  Rows(poses);
  const std::string truth = Experiment(
      "measurements: [m.csv]\nmarkers: {P: {xyz_mm: [100, 20, 30]}, Q: {xyz_mm: [90, -50, -40]}}\n"
      "stations: {S1: {xyz_mm: [10, 20, 30], rotvec_mrad: [3, 4, 50]}}\n");
  ASSERT_EQ(Run({"simulate", truth, "--sigma_mm=0.02", "--out=" + Path("s.csv")}).status, 0);
  const std::string rows = Write("metres.csv", Replaced(Read("s.csv"), "q3_mm", "q3_m"));
  EXPECT_THAT(Refusal({"calibrate", Path("r.yaml"), rows}), HasSubstr("name them so (q3_mm)"));
}

TEST_F(RefusalWords, ColumnsThatAreNotReadAreSaid) {
  const std::string unread = "Columns not read: load_id and x_target.";
  std::string rows = ReplacedEverywhere(kRows, "\n", ",a,7\n");
  rows = Rows(Replaced(rows, "z_mm,a,7", "z_mm,load_id,x_target"));
  EXPECT_THAT(Run({"calibrate", Robot(), rows, "--quiet", "--out=" + Path("out")}).out, HasSubstr(unread));
  EXPECT_THAT(Read("out/report.html"), HasSubstr(unread));
  EXPECT_THAT(Run({"inspect", Robot(), rows, "--quiet", "--out=" + Path("out")}).out, HasSubstr(unread));
  EXPECT_THAT(Read("out/report.html"), HasSubstr(unread));
  EXPECT_EQ(ReadJson("out/inspect.json")["data"]["not_read"], (nlohmann::json{"load_id", "x_target"}));
  EXPECT_THAT(Run({"diagnose", Robot(), rows, "--quiet", "--out=" + Path("out")}).out, HasSubstr(unread));
  EXPECT_THAT(Read("out/report.html"), HasSubstr(unread));
}

TEST_F(RefusalWords, LabelsThatDifferInLetterCaseAreDoubted) {
  const std::string rows = Rows(Replaced(kRows, "c3,M1", "c3,m1"));
  ASSERT_EQ(Run({"calibrate", Robot(), rows, "--quiet", "--out=" + Path("out")}).status, 0);
  EXPECT_THAT(ReadJson("out/estimate.json")["warnings"].dump(),
              HasSubstr("markers 'M1' and 'm1' differ in letter case"));
}

TEST_F(RefusalWords, ALabelInOneRowAloneIsDoubted) {
  const std::string rows = Rows(Replaced(kRows, "c3,M1", "c3,M7"));
  ASSERT_EQ(Run({"calibrate", Robot(), rows, "--quiet", "--out=" + Path("out")}).status, 0);
  EXPECT_THAT(ReadJson("out/estimate.json")["warnings"].dump(),
              HasSubstr("marker 'M7' is in one row alone (" + rows + ":4)"));
}

TEST_F(RefusalWords, ALabelInTwoRowsIsNot) {
  const std::string rows = Rows(Replaced(Replaced(kRows, "c3,M1", "c3,M7"), "c4,M1", "c4,M7"));
  ASSERT_EQ(Run({"calibrate", Robot(), rows, "--quiet", "--out=" + Path("out")}).status, 0);
  EXPECT_EQ(Read("out/estimate.json").find("in one row alone"), std::string::npos);
}

TEST_F(RefusalWords, JointsBeyondTheirLimitsAreNamed) {
  const std::string narrow = Replaced(kRobot, "{name: A1, type: revolute}", "{name: A1, type: revolute, max_deg: 10}");
  ASSERT_EQ(Run({"inspect", Robot(narrow), Rows(), "--out=" + Path("out")}).status, 0);
  const nlohmann::json inspection = ReadJson("out/inspect.json");
  nlohmann::json found;
  for (const auto& finding : inspection["findings"]) {
    if (finding["code"] == "beyond_limits") found = finding;
  }
  ASSERT_TRUE(found.is_object());
  EXPECT_THAT(found["words"].get<std::string>(), HasSubstr("joint A1 was at -80.0 to 30.0 deg"));
  EXPECT_THAT(found["words"].get<std::string>(), HasSubstr("up to 10.0 deg"));
  EXPECT_EQ(found["rows"].size(), 2u);  // c7 and c8
}

}  // namespace
}  // namespace sagitta::test

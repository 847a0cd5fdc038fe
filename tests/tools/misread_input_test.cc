// What somebody hands over without knowing that it is misread: rotations in another convention, sigmas in another unit,
// a robot in mm, tables of two stations in one, the same readings twice. The first sentence names it.
#include <gmock/gmock.h>

#include <functional>
#include <random>

#include "models/constants.h"
#include "models/geometry.h"
#include "tests/tools/program.h"

namespace sagitta::test::misread_input_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;
using Rows = std::vector<std::vector<std::string>>;
using Numbers = std::vector<double>;

constexpr char kRobot[] = R"(schema: sagitta/robot/1
name: six joints
joints:
  - {name: j1, type: revolute}
  - {name: j2, type: revolute}
  - {name: j3, type: revolute}
  - {name: j4, type: revolute}
  - {name: j5, type: revolute}
  - {name: j6, type: revolute}
kinematics:
  dh:
    convention: standard
    links:
      - {joint: j1, a_mm: 0, alpha_deg: 90, d_mm: 89, theta_deg: 0}
      - {joint: j2, a_mm: -425, alpha_deg: 0, d_mm: 0, theta_deg: 0}
      - {joint: j3, a_mm: -392, alpha_deg: 0, d_mm: 0, theta_deg: 0}
      - {joint: j4, a_mm: 0, alpha_deg: 90, d_mm: 109, theta_deg: 0}
      - {joint: j5, a_mm: 0, alpha_deg: -90, d_mm: 95, theta_deg: 0}
      - {joint: j6, a_mm: 0, alpha_deg: 0, d_mm: 82, theta_deg: 0}
)";
constexpr char kScene[] = R"(schema: sagitta/experiment/1
robot: truth.yaml
measurements: poses.csv
stations: {S1: {xyz_mm: [2300, -800, 410], rotvec_mrad: [20, -12, 1100]}}
markers: {M: {xyz_mm: [40, 10, 60], rotvec_mrad: [100, 200, 300]}}
)";

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

std::string Shown(double number) {
  std::ostringstream text;
  text.precision(12);
  text << number;
  return text.str();
}

class MisreadInput : public ProgramTest {
 protected:
  // The arm of kRobot with errors of 0.3 mm and 0.02 deg, 60 poses and one marker.
  void SetUp() override {
    ProgramTest::SetUp();
    robot_ = Write("robot.yaml", kRobot);
    Write("truth.yaml",
          Replaced(Replaced(kRobot, "a_mm: -425", "a_mm: -424.7"), "alpha_deg: -90", "alpha_deg: -89.98"));
  }
  Rows Measured(const std::string& extra_header, const std::string& extra, int poses = 60) const {
    std::mt19937_64 random(5);
    const auto angle = [&] {
      return Shown(std::round(1e3 * (static_cast<double>(random() % 2000) / 10.0 - 100.0)) / 1e3);
    };
    std::string text = "config,marker,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,sigma_x_mm,sigma_y_mm,sigma_z_mm";
    text += extra_header + "\n";
    for (int c = 0; c < poses; ++c) {
      text += "c" + std::to_string(c) + ",M";
      for (int j = 0; j < 6; ++j) text += "," + angle();
      text += ",0.03,0.03,0.03" + extra + "\n";
    }
    Write("poses.csv", text);
    EXPECT_EQ(Run({"simulate", Path("scene.yaml"), "--out=" + Path("rows.csv"), "--seed=4"}).status, 0);
    return Cells(Read("rows.csv"));
  }
  Rows Points() const {
    Write("scene.yaml", Replaced(kScene, ", rotvec_mrad: [100, 200, 300]", ""));
    return Measured("", "");
  }
  Rows Poses(int count = 60) const {
    Write("scene.yaml", kScene);
    return Measured(",sigma_rot_urad", ",50", count);
  }

  // Rows with the numbers of these columns changed.
  static Rows Changed(Rows rows, const std::vector<std::string>& columns, const std::vector<std::string>& names,
                      const std::function<Numbers(const Numbers&)>& change) {
    std::vector<size_t> at;
    for (const std::string& column : columns) at.push_back(static_cast<size_t>(Column(rows, column)));
    for (size_t r = 1; r < rows.size(); ++r) {
      Numbers numbers;
      for (const size_t c : at) numbers.push_back(std::stod(rows[r][c]));
      numbers = change(numbers);
      for (size_t i = 0; i < at.size(); ++i) rows[r][at[i]] = Shown(numbers[i]);
      for (size_t i = at.size(); i < numbers.size(); ++i) rows[r].push_back(Shown(numbers[i]));
    }
    for (size_t i = 0; i < names.size(); ++i) {
      if (i < at.size()) rows[0][at[i]] = names[i];
      if (i >= at.size()) rows[0].push_back(names[i]);
    }
    return rows;
  }

  Outcome Calibrated(const Rows& rows, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"calibrate", robot_, Write("m.csv", Csv(rows)), "--out=" + Path("out")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Run(arguments);
  }
  std::string Refusal(const Rows& rows) const {
    const Outcome outcome = Calibrated(rows);
    EXPECT_EQ(outcome.status, 2) << outcome.out << outcome.err;
    EXPECT_FALSE(Exists("out/estimate.json"));
    return outcome.err;
  }
  // What `inspect` says first of them.
  std::string FirstFinding(const Rows& rows) const {
    EXPECT_EQ(Run({"inspect", robot_, Write("m.csv", Csv(rows)), "--out=" + Path("inspection")}).status, 0);
    const nlohmann::json inspection = ReadJson("inspection/inspect.json");
    return inspection["findings"][0]["code"].get<std::string>() + ": " +
           inspection["findings"][0]["words"].get<std::string>();
  }

  std::string robot_;
};

// rx_mrad … of the target as a rotation.
Matrix3<double> RotationOf(const Numbers& mrad) {
  return RotationFromVector(Vector3<double>(1e-3 * mrad[0], 1e-3 * mrad[1], 1e-3 * mrad[2]));
}

class MisreadRotations : public MisreadInput {
 protected:
  const std::vector<std::string> vector_ = {"rx_mrad", "ry_mrad", "rz_mrad"};
  void ExpectNamed(const Rows& rows, const std::string& reading) const {
    const auto named = AllOf(HasSubstr("the points fit within"), HasSubstr("the rotations do not"), HasSubstr(reading),
                             Not(HasSubstr("signs")));
    EXPECT_THAT(Refusal(rows), named);
    EXPECT_THAT(FirstFinding(rows), AllOf(StartsWith("rotation_convention: "), named));
  }
};

TEST_F(MisreadRotations, AsTheyAreMeantTheyFit) { EXPECT_EQ(Calibrated(Poses()).status, 0); }

TEST_F(MisreadRotations, RollPitchYaw) {
  ExpectNamed(Changed(Poses(), vector_, vector_,
                      [](const Numbers& read) -> Numbers {
                        const Matrix3<double> r = RotationOf(read);
                        return {1e3 * std::atan2(r(2, 1), r(2, 2)),
                                1e3 * std::atan2(-r(2, 0), std::hypot(r(0, 0), r(1, 0))),
                                1e3 * std::atan2(r(1, 0), r(0, 0))};
                      }),
              "as angles in mrad of RzRyRx by");
}

TEST_F(MisreadRotations, Inverse) {
  ExpectNamed(Changed(Poses(), vector_, vector_,
                      [](const Numbers& read) -> Numbers {
                        return {-read[0], -read[1], -read[2]};
                      }),
              "as a rotation vector in mrad, of the measurement frame in the target's by");
}

// A sample of so many poses has the rotations too, not every other reading.
TEST_F(MisreadRotations, InverseOfFortyPoses) {
  ExpectNamed(Changed(Poses(40), vector_, vector_,
                      [](const Numbers& read) -> Numbers {
                        return {-read[0], -read[1], -read[2]};
                      }),
              "as a rotation vector in mrad, of the measurement frame in the target's by");
}

TEST_F(MisreadRotations, Degrees) {
  ExpectNamed(Changed(Poses(), vector_, vector_,
                      [](const Numbers& read) -> Numbers {
                        const double factor = 1e-3 / kDegree;
                        return {factor * read[0], factor * read[1], factor * read[2]};
                      }),
              "as a rotation vector in deg by");
}

TEST_F(MisreadRotations, ScalarLast) {
  ExpectNamed(Changed(Poses(), vector_, {"ow", "ox", "oy", "oz"},
                      [](const Numbers& read) -> Numbers {
                        const Eigen::Quaterniond q(RotationOf(read));
                        return {q.x(), q.y(), q.z(), q.w()};
                      }),
              "as a quaternion, scalar last by");
}

TEST_F(MisreadRotations, NoneFits) {
  std::mt19937_64 random(3);
  const Rows rows = Changed(Poses(), vector_, vector_, [&](const Numbers&) -> Numbers {
    const auto any = [&] { return static_cast<double>(random() % 3000) - 1500.0; };
    return {any(), any(), any()};
  });
  EXPECT_THAT(Refusal(rows), AllOf(HasSubstr("the rotations do not"), HasSubstr("no other kind of rotation")));
}

const std::vector<std::string> kSigmas = {"sigma_x_mm", "sigma_y_mm", "sigma_z_mm"};

TEST_F(MisreadInput, SigmasInMicrometresAreNamedFirst) {
  const Rows rows = Changed(Points(), kSigmas, kSigmas, [](const Numbers&) -> Numbers { return {30, 30, 30}; });
  const Outcome outcome = Calibrated(rows);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const nlohmann::json estimate = ReadJson("out/estimate.json");
  EXPECT_THAT(estimate["verdict"]["words"].get<std::string>(),
              AllOf(StartsWith("The stated standard deviations are about "),
                    HasSubstr("were micrometres written as millimetres?"), Not(HasSubstr("moved"))));
  EXPECT_THAT(outcome.out, AllOf(Not(HasSubstr("ot measured")), HasSubstr("Held for the stated standard deviations")));
  EXPECT_THAT(estimate["message"].get<std::string>(), Not(HasSubstr("do not determine")));
}

TEST_F(MisreadInput, SigmasAHundredTimesTooLargeLeaveNothingUnmeasured) {
  const Outcome outcome = Calibrated(Points(), {"--sigma_mm=3"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(ReadJson("out/estimate.json")["verdict"]["words"].get<std::string>(),
              AllOf(StartsWith("The stated standard deviations are about "), Not(HasSubstr("not measured")),
                    Not(HasSubstr("micrometres"))));
}

// Three times is a caution that people exercise.
TEST_F(MisreadInput, SigmasThreeTimesTooLargeAreNoMistake) {
  ASSERT_EQ(Calibrated(Points(), {"--sigma_mm=0.1"}).status, 0);
  EXPECT_THAT(ReadJson("out/estimate.json")["verdict"]["words"].get<std::string>(), StartsWith("On poses"));
}

TEST_F(MisreadInput, ARobotInMillimetresIsNamed) {
  const Rows rows = Points();
  std::string text = kRobot;
  for (size_t at = 0; (at = text.find("_mm", at)) != std::string::npos; at += 2) text.replace(at, 3, "_m");
  Write("robot.yaml", text);
  EXPECT_THAT(Refusal(rows), AllOf(HasSubstr("the robot's lengths as millimetres"), HasSubstr("1000 times"),
                                   Not(HasSubstr("all the same"))));
}

TEST_F(MisreadInput, OnePointInAllRowsIsNoRobotInMillimetres) {
  const std::vector<std::string> point = {"x_mm", "y_mm", "z_mm"};
  double digit = 0.0;
  const Rows rows = Changed(Points(), point, point, [&](const Numbers&) -> Numbers {
    digit += 1e-4;
    return {1000.0 + digit, 200.0, 300.0 - digit};
  });
  EXPECT_THAT(Refusal(rows), HasSubstr("all the same"));
}

// From row 32 of the file on another instrument, or the same after a knock.
TEST_F(MisreadInput, AMoveInTheMiddleIsNamedToTheRow) {
  for (const double by : {50.0, 1000.0}) {
    int row = 1;
    const Rows rows = Changed(Points(), {"x_mm", "y_mm"}, {"x_mm", "y_mm"}, [&](const Numbers& p) -> Numbers {
      return ++row > 31 ? Numbers{p[0] + by, p[1] - 0.5 * by} : p;
    });
    for (const std::string& words : {Refusal(rows), FirstFinding(rows)}) {
      EXPECT_THAT(words, HasSubstr("between " + Path("m.csv") + ":31 and " + Path("m.csv") + ":32 station S1")) << by;
    }
  }
}

TEST_F(MisreadInput, TheSameReadingsTwiceAreRefused) {
  ASSERT_EQ(Calibrated(Points()).status, 0);
  const std::string residuals = Path("out/residuals.csv");
  const Outcome outcome = Run({"calibrate", robot_, Path("m.csv"), residuals, "--out=" + Path("again")});
  EXPECT_EQ(outcome.status, 2) << outcome.out;
  EXPECT_THAT(outcome.err, AllOf(HasSubstr(residuals + ":2"), HasSubstr("60 rows have the point of an earlier row"),
                                 HasSubstr("given twice")));
}

// A coarse instrument reads the same point again, at another time.
TEST_F(MisreadInput, RepeatsThatReadAlikeAtAnotherTimeAreNot) {
  Rows rows = Points();
  const size_t count = rows.size();
  for (size_t i = 1; i < count; ++i) rows.push_back(rows[i]);
  rows[0].push_back("time_s");
  for (size_t i = 1; i < rows.size(); ++i) rows[i].push_back(std::to_string(10 * i));
  const Outcome outcome = Calibrated(rows);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.err + outcome.out, HasSubstr("they count as repeated"));
}

TEST_F(MisreadInput, RepeatsOfOneNoiseAreNot) {
  Rows rows = Points();
  const Rows again = Changed(rows, {"x_mm"}, {"x_mm"}, [](const Numbers& x) -> Numbers { return {x[0] + 0.01}; });
  rows.insert(rows.end(), again.begin() + 1, again.end());
  EXPECT_EQ(Calibrated(rows).status, 0);
}

// What is outside the measured ranges is said by every command that relies on an estimate.
TEST_F(MisreadInput, PosesOutsideTheMeasuredRangesAreSaid) {
  const Rows rows = Points();
  ASSERT_EQ(Calibrated(rows).status, 0);
  const std::string estimate = Path("out/estimate.json");
  const std::string inside = Path("m.csv");
  const std::string poses = "c1,M,10,20,30,40,50,60\nc2,M,10,20,230,40,50,60\n";
  const std::string outside = Write("o.csv", "config,marker,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg\n" + poses);
  const auto said =
      AllOf(HasSubstr("1 of 2 configurations lies outside the measured joint ranges"), HasSubstr("j3 by 1"));
  EXPECT_THAT(Run({"predict", estimate, outside, "--out=" + Path("p.csv")}).out, said);
  EXPECT_THAT(Run({"predict", estimate, inside, "--out=" + Path("p.csv")}).out, Not(HasSubstr("outside")));
  EXPECT_THAT(Run({"validate", estimate, inside}).out, Not(HasSubstr("outside")));
  const std::string targets = Write("t.csv",
                                    "target,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg\n"
                                    "a,10,20,30,40,50,60\nb,10,20,230,40,50,60\n");
  const Outcome compensated = Run({"compensate", estimate, targets, "--out=" + Path("c.csv")});
  EXPECT_THAT(compensated.out, HasSubstr("1 target lies outside the measured joint ranges"));
  const Rows corrected = Cells(Read("c.csv"));
  const auto words = static_cast<size_t>(Column(corrected, "words"));
  EXPECT_EQ(corrected[1][words], "");
  EXPECT_THAT(corrected[2][words], StartsWith("outside the measured joint ranges: j3 by 1"));
}

TEST_F(MisreadInput, AnotherStationHasARemedy) {
  Rows rows = Points();
  ASSERT_EQ(Calibrated(rows).status, 0);
  rows[0].emplace_back("station");
  for (size_t r = 1; r < rows.size(); ++r) rows[r].emplace_back("elsewhere");
  const Outcome outcome = Run({"validate", Path("out/estimate.json"), Write("other.csv", Csv(rows))});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("known: S1"), HasSubstr("sagitta calibrate robot.calibrated.yaml")));
}

TEST_F(MisreadInput, AMethodThatIsNotRunHasThatStatus) {
  const std::string rows = Write("m.csv", Csv(Points()));
  const Outcome outcome = Run({"compare", robot_, rows, "--methods=joint,differencing", "--out=" + Path("out")});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const nlohmann::json methods = ReadJson("out/comparison.json")["methods"];
  EXPECT_EQ(methods[1]["status"], "not_run");
  EXPECT_THAT(methods[1]["message"].get<std::string>(), StartsWith("not run: "));
}

// `fingers`: two slide on the tool, which else carries nothing.
std::string UrdfOfArm(bool has_fingers) {
  std::string text = "<robot name='arm'>";
  for (const char* link : {"base", "one", "two", "tool", "camera"}) text += "<link name='" + std::string(link) + "'/>";
  const auto joint = [](const char* name, const char* type, const char* parent, const char* child) {
    return "<joint name='" + std::string(name) + "' type='" + type + "'><parent link='" + parent + "'/><child link='" +
           child + "'/><origin xyz='0.1 0 0.3'/><axis xyz='0 0 1'/>" +
           "<limit lower='-1' upper='1' effort='1' velocity='1'/></joint>";
  };
  text += joint("a1", "revolute", "base", "one") + joint("a2", "revolute", "one", "two") +
          joint("flange", "fixed", "two", "tool") + joint("bracket", "fixed", "one", "camera");
  if (has_fingers) {
    text += "<link name='left'/><link name='right'/>" + joint("l", "prismatic", "tool", "left") +
            joint("r", "prismatic", "tool", "right");
  }
  return text + "</robot>";
}

TEST_F(MisreadInput, AnArmWithAGripperMayEndWhereTheFingersPart) {
  const Outcome outcome = Run({"convert", Write("arm.urdf", UrdfOfArm(true)), Path("arm.yaml")});
  EXPECT_EQ(outcome.status, 2) << outcome.out;
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("any of: tool (2 joints), left (3 joints), right (3 joints)"),
                                 HasSubstr("tip_link: tool}")));
}

TEST_F(MisreadInput, ConvertSaysWhereTheChainEnds) {
  const Outcome outcome = Run({"convert", Write("arm.urdf", UrdfOfArm(false)), Path("arm.yaml")});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("the chain runs from base to tool, not to camera (--tip_link says another)"));
}

// A link that only follows another joint may be a finger, or the flange that a rod keeps level: nobody but the user
// knows.
TEST_F(MisreadInput, AChainDoesNotEndAtAFingerForItsJointThatFollows) {
  std::string text = UrdfOfArm(false);
  text.replace(text.find("</robot>"), std::string::npos,
               "<link name='finger'/><joint name='f' type='revolute'><parent link='two'/><child link='finger'/>"
               "<axis xyz='0 0 1'/><mimic joint='a2'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint>"
               "</robot>");
  const Outcome outcome = Run({"convert", Write("arm.urdf", text), Path("arm.yaml")});
  EXPECT_EQ(outcome.status, 2) << outcome.out;
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("tool (2 joints)"), HasSubstr("finger (3 joints)")));
}

// Seven poses determine no two noises.
TEST_F(MisreadInput, OneNoiseOfPointsAndRotationsIsSaidToBeOfBoth) {
  Rows rows = Changed(Poses(), {}, {}, [](const Numbers& none) { return none; });
  rows.resize(8);
  for (const char* column : {"sigma_x_mm", "sigma_y_mm", "sigma_z_mm", "sigma_rot_urad"}) {
    const auto at = Column(rows, column);
    for (auto& row : rows) row.erase(row.begin() + at);
  }
  const Outcome outcome = Calibrated(rows);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("of every axis of a rotation"));
}

}  // namespace
}  // namespace sagitta::test::misread_input_test

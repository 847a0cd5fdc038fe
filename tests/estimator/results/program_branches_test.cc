// Which joint solution a program means, and what becomes of it where a correction would leave it.
#include "problems/text.h"
#include "tests/estimator/results/program_test_support.h"

namespace sagitta::program_branches_test {
namespace {

using namespace program_test;
using ProgramBranches = ProgramCompensationTest;

// KUKA's home: joint 5 at 0, joints 4 and 6 in line. The last bit of orientation would swing both by tens of degrees.
TEST_F(ProgramBranches, JointTargetsAtASingularityAreNotSwung) {
  const std::string home = "PTP {A1 0,A2 -90,A3 90,A4 0,A5 0,A6 0}\n";
  const std::string text = home + "PTP {A1 0,A2 -90,A3 90,A4 0,A5 0.3,A6 0}\nPTP {A1 0,A2 -90,A3 90,A4 0,A5 30,A6 0}\n";
  const CompensatedProgram result = Compensated(TrueRobot(truth_), ReadAs(".src", text));
  for (const size_t k : {0U, 1U}) {
    EXPECT_NE(result.results[k].untouched, "");
    EXPECT_THAT(SummaryOf(result), HasSubstr("line " + std::to_string(k + 1) + ", PTP of line"));
  }
  EXPECT_THAT(result.results[1].untouched, HasSubstr("close to a singularity: the correction would turn"));
  EXPECT_EQ(result.results[2].untouched, "");
  const size_t last = text.rfind("PTP");
  EXPECT_EQ(result.text.substr(0, last), text.substr(0, last));
}

TEST_F(ProgramBranches, NamesAreTheProgramsOwn) {
  const Eigen::VectorXd q = Joints({20, -95, 100, 30, 40, -60});
  const std::vector<std::string> n = SplitText(PoseText(PoseNotation::kQuaternion, q, Pose<double>(), {}), ',');
  const std::string text = "MODULE M\nCONST robtarget p:=[[" + n[0] + "," + n[1] + "," + n[2] + "],[" + n[3] + "," +
                           n[4] + "," + n[5] + "," + n[6] + "],[0,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n" +
                           "PERS tooldata tGun:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];\n" +
                           "PROC main()\nMoveJ p,v100,fine,tGun;\nENDPROC\nENDMODULE\n";
  const auto run = [&](const std::string& tools) {
    ProgramScene scene;
    scene.tools = FramesFromText("flange=same" + tools, "--tools_mm_deg");
    scene.frames = FramesFromText("world=same", "--frames_mm_deg");
    return CompensateProgram(TrueRobot(truth_), ReadAs(".mod", text), scene, 1).text;
  };
  // RAPID ignores case: what the user states of the file's tool comes before what the file states.
  const std::string own = run(std::string("; tGun") + kToolText);
  EXPECT_EQ(own, run(std::string("; TGUN") + kToolText));
  EXPECT_NE(own, text);
  EXPECT_NE(own, run(""));
  for (const auto& [tools, words] : {std::pair{"; tGum=same", "no tool 'tGum'"},
                                     {"; nonsense=same", "no tool 'nonsense'"},
                                     {"; tgun=same; TGUN=same", "given twice"}}) {
    try {
      run(tools);
      ADD_FAILURE() << tools;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(words));
    }
  }
}

// The solution is the one nearest to qnear, for tcp, wherever the arm is and whatever set_tcp says.
TEST_F(ProgramBranches, UrScriptGoesByQnearAndTcp) {
  const std::vector<Eigen::VectorXd> q = {Joints({20, -95, 100, 30, 40, -60}), Joints({22, -90, 95, -147, -37, 118})};
  const auto list = [](const Eigen::VectorXd& joints) {
    std::string text = "[";
    for (int j = 0; j < 6; ++j) text += (j > 0 ? "," : "") + FormatNumber(std::round(1e6 * joints[j]) / 1e6);
    return text + "]";
  };
  std::string tool;
  for (const double number : NumbersOf(PoseNotation::kRotationVectorMetres, kToolInFlange))
    tool += (tool.empty() ? "" : ",") + FormatNumber(number);
  const std::string pose = "p[" + PoseText(PoseNotation::kRotationVectorMetres, q[1], Pose<double>(), {}) + "]";
  const std::string text = "set_tcp(p[0.3,0,0,0,0,0])\nmovej(" + list(q[0]) + ")\nmovej(get_inverse_kin(" + pose +
                           ", qnear=" + list(q[1]) + ", tcp=p[" + tool + "]))\n";
  std::vector<Eigen::VectorXd> rounded = q;
  for (double& angle : rounded[0]) angle = std::round(1e6 * angle) / 1e6;
  ExpectOnTarget(".script", text, rounded, Pose<double>());
}

// Joints 4 and 6 at 0, poses with three decimals: the bits of T stand at an edge, and either is what is meant.
TEST_F(ProgramBranches, RoundedPosesAtTheEdgeOfTheirTurns) {
  const Eigen::VectorXd q = Joints({20, -95, 100, 0, 40, 0});
  const std::vector<double> n =
      NumbersOf(PoseNotation::kAbcDegrees, Times(Times(Back(kFrameInWorld), NominalFlange(q)), kToolInFlange));
  std::string pose;
  for (size_t i = 0; i < 6; ++i) {
    char number[64];
    std::snprintf(number, sizeof number, "%s%s%.3f", i > 0 ? "," : "", kKrlNames[i], n[i]);
    pose += number;
  }
  std::string text = "$BASE=BASE_DATA[2]\n$TOOL=TOOL_DATA[1]\n";
  for (const int bits : {0, 8, 32, 40})
    text += "PTP {" + pose + ",S " + std::to_string(KrlStatus(q)) + ",T " + std::to_string(2 + bits) + "}\n";
  const CompensatedProgram result = Compensated(TrueRobot(truth_), ReadAs(".src", text));
  for (const ProgramPointResult& point : result.results) {
    ASSERT_EQ(point.untouched, "");
    EXPECT_NEAR(point.solution->solution.q[3], 0.0, 0.02);
    EXPECT_NEAR(point.solution->solution.q[5], 0.0, 0.02);
  }
  // The correction moves both joints off 0 to one side: bits of the other are no longer theirs.
  EXPECT_GE(
      std::count_if(result.results.begin(), result.results.end(), [](const auto& p) { return !p.leaves.empty(); }), 3);
  EXPECT_THAT(SummaryOf(result), HasSubstr("just outside of what status, turn"));
}

// From the pose before, the search ends where it ends from all over.
TEST_F(ProgramBranches, ThePoseBeforeLeadsToTheSameSolution) {
  const Chain nominal = test::Kr270Chain();
  for (const Eigen::VectorXd& q : {Joints({20, -95, 100, 30, 40, -60}), Joints({-60, -60, 80, -170, -35, 200})}) {
    const int status = KrlStatus(q);
    StatedBranch branch;
    branch.wrist_behind = (status & 1) != 0;
    branch.elbow_past_stretch = (status & 2) != 0;
    branch.wrist_negative = (status & 4) != 0;
    for (int j = 0; j < 6; ++j)
      branch.ranges.push_back({j, q[j] < 0.0 ? std::make_pair(-6.2, 0.0) : std::make_pair(0.0, 6.2)});
    const BranchFound cold = FindBranch(nominal, NominalFlange(q), branch, {});
    ASSERT_EQ(cold.why_not, "");
    EXPECT_LT((cold.q - q).norm(), 1e-8);
    // Near it, and on another branch.
    for (const Eigen::VectorXd& before : {Eigen::VectorXd(q.array() + 0.1), Joints({20, -95, 100, -150, -40, 120})}) {
      const BranchFound warm = FindBranch(nominal, NominalFlange(q), branch, before);
      ASSERT_EQ(warm.why_not, "");
      EXPECT_LT((warm.q - cold.q).norm(), 1e-8);
    }
  }
}

// 'F U T, 0, 0, 0' with joint 4 next to half a turn: beyond it the controller would come from the other side.
TEST_F(ProgramBranches, ACorrectionThatNeedsAnotherTurnIsLeft) {
  const auto program = [](const std::vector<Eigen::VectorXd>& all) {
    std::string text = "/PROG P\n/POS\n";
    for (size_t k = 0; k < all.size(); ++k) {
      // Elbow up as at the zero pose, but where joint 3 is beyond the folded arm (177 deg).
      const std::string elbow = all[k][2] > 177 * kDegree ? "D" : "U";
      const std::string position = PoseText(PoseNotation::kWprDegrees, all[k], kFrameInWorld, kFanucNames);
      const std::vector<std::string> parts = SplitText(position, ',');
      text +=
          "P[" + std::to_string(k + 1) + "]{\n   GP1:\n\tUF : 2, UT : 1,\t\tCONFIG : 'F " + elbow + " T, 0, 0, 0',\n\t";
      for (size_t i = 0; i < 6; ++i) text += parts[i] + (i < 3 ? "  mm" : " deg") + (i < 5 ? ",\t" : "\n};\n");
    }
    return text + "/END\n";
  };
  KnownRobot robot = TrueRobot(truth_);
  robot.robot.chain.joints[2].max = 200 * kDegree;
  robot.robot.chain.joints[2].min = -100 * kDegree;
  robot.robot.chain.joints[3].max = 350 * kDegree;
  robot.robot.chain.joints[3].min = -350 * kDegree;
  const CompensatedProgram result = Compensated(
      robot, ReadAs(".ls", program({Joints({20, -95, 100, 179.999, 40, -60}), Joints({20, -95, 100, -179.999, 40, -60}),
                                    Joints({20, -95, 188, 30, 40, -60})})));
  const std::string words[2] = {result.results[0].untouched, result.results[1].untouched};
  EXPECT_NE(words[0].empty(), words[1].empty());
  EXPECT_THAT(words[0] + words[1], HasSubstr("other status, turn or configuration numbers"));
  // Joint 3 beyond half a turn is not among those that are counted.
  ASSERT_EQ(result.results[2].untouched, "");
  EXPECT_NEAR(result.results[2].solution->solution.q[2], 188 * kDegree, 0.05);
}

TEST_F(ProgramBranches, PosesOfWhichAJointMovesFarAreListed) {
  const Eigen::VectorXd q = Joints({20, -95, 100, 40, 0.35, -60});
  const std::string text = "$BASE=BASE_DATA[2]\n$TOOL=TOOL_DATA[1]\nPTP {" +
                           PoseText(PoseNotation::kAbcDegrees, q, kFrameInWorld, kKrlNames) + ",S " +
                           std::to_string(KrlStatus(q)) + ",T " + std::to_string(KrlTurn(q)) + "}\n";
  const CompensatedProgram result = Compensated(TrueRobot(truth_), ReadAs(".src", text));
  ASSERT_EQ(result.results[0].untouched, "");
  const double move = (result.results[0].solution->solution.q - q).lpNorm<Eigen::Infinity>() / kDegree;
  ASSERT_GT(move, 2.0);
  EXPECT_THAT(SummaryOf(result), HasSubstr("a joint then stands elsewhere"));
  EXPECT_THAT(result.results[0].moves, HasSubstr(Significant(move, 3) + " deg"));
}

// "Nearest to the point before": where that one has no numbers, stands in another routine or in one of two branches,
// there is no solution that the text decides.
TEST_F(ProgramBranches, ThePointBeforeIsTheOneThatTheArmComesFrom) {
  const std::string near = "PTP {A1 20,A2 -95,A3 100,A4 30,A5 40,A6 -60}\n",
                    flipped = "PTP {A1 20,A2 -95,A3 100,A4 -150,A5 -40,A6 120}\n";
  const std::string point =
      "LIN {" + PoseText(PoseNotation::kAbcDegrees, Joints({22, -93, 98, 32, 38, -58}), kFrameInWorld, kKrlNames) +
      "}\n";
  const std::string scene = "DEF P()\n$BASE=BASE_DATA[2]\n$TOOL=TOOL_DATA[1]\n";
  const auto untouched = [&](const std::string& body) {
    const CompensatedProgram result = Compensated(TrueRobot(truth_), ReadAs(".src", scene + body + "END\n"));
    std::string words;
    for (const ProgramPointResult& one : result.results) {
      if (result.program.points[static_cast<size_t>(one.point)].name.find("LIN") == 0) words = one.untouched;
    }
    return words;
  };
  EXPECT_EQ(untouched(near + point), "");
  EXPECT_THAT(untouched(near + "PTP XP9\n" + point), HasSubstr("--start_deg"));
  EXPECT_THAT(untouched("IF $IN[1] THEN\n" + near + "ELSE\n" + flipped + "ENDIF\n" + point),
              HasSubstr("more than one joint solution"));
  EXPECT_EQ(untouched("IF $IN[1] THEN\n" + near + "ELSE\n" + near + "ENDIF\n" + point), "");
  const std::string sub = "END\nDEF S1()\n" + point;
  EXPECT_EQ(untouched(near + "S1()\n" + flipped + sub), "");
  EXPECT_THAT(untouched(near + "S1()\n" + flipped + "S1()\n" + sub), HasSubstr("more than one joint solution"));
}

}  // namespace
}  // namespace sagitta::program_branches_test

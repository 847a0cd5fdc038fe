// Robot programs, round trip: a program of every dialect is corrected, a controller that computes with the nominal
// robot runs it, and the true robot (tests/support/loaded_kr270.h, of another derivation) is on target.
#include "problems/text.h"
#include "tests/estimator/results/program_test_support.h"

namespace sagitta::program_compensation_test {
namespace {

using namespace program_test;

TEST_F(ProgramCompensationTest, KrlOnEveryBranch) {
  std::vector<Eigen::VectorXd> q = {Joints({20, -95, 100, 30, 40, -60}), Joints({-60, -60, 80, -170, -35, 200}),
                                    Joints({10, -150, -60, 20, 50, 10}), Joints({170, -80, 120, -300, 60, -10})};
  std::string text = "DEF P( )\r\n$BASE=BASE_DATA[2]\r\n$TOOL=TOOL_DATA[1]\r\n";
  for (const Eigen::VectorXd& joints : q) {
    text += "PTP {" + PoseText(PoseNotation::kAbcDegrees, joints, kFrameInWorld, kKrlNames) + ",S " +
            std::to_string(KrlStatus(joints)) + ",T " + std::to_string(KrlTurn(joints)) + "}\r\n";
  }
  text += "PTP {A1 12.5,A2 -88.25,A3 95,A4 10,A5 -20,A6 3}\r\n";
  q.push_back(Joints({12.5, -88.25, 95, 10, -20, 3}));
  text += "LIN {" + PoseText(PoseNotation::kAbcDegrees, Joints({13, -88, 95, 11, -21, 4}), kFrameInWorld, kKrlNames) +
          "}\r\nEND\r\n";
  q.push_back(Joints({13, -88, 95, 11, -21, 4}));
  ExpectOnTarget(".src", text, q, kFrameInWorld);
}

TEST_F(ProgramCompensationTest, RapidOnEveryBranch) {
  scene_.load = "none";  // the gun is of another module, and so is its load
  // Elbow on the side of the zero pose where joint 3 is below the stretched angle: the forearm is a little above there.
  const std::vector<Eigen::VectorXd> q = {Joints({20, -95, 100, 30, 40, -60}), Joints({-60, -60, 80, -170, -35, 100}),
                                          Joints({10, -100, -60, 20, 50, 10})};
  const double stretched = std::atan2(-55.0, 1100.0);
  std::string text = "MODULE M\n";
  for (size_t k = 0; k < q.size(); ++k) {
    const Eigen::VectorXd& j = q[k];
    const int elbow = (j[2] > stretched) == (0.0 > stretched) ? 0 : 2;
    const int shape = (j[4] < 0.0 ? 1 : 0) + elbow + ((KrlStatus(j) & 1) != 0 ? 4 : 0);
    const std::string position = PoseText(PoseNotation::kQuaternion, j, kFrameInWorld, {});
    std::vector<std::string> parts = SplitText(position, ',');
    text += "CONST robtarget p" + std::to_string(k) + ":=[[" + parts[0] + "," + parts[1] + "," + parts[2] + "],[" +
            parts[3] + "," + parts[4] + "," + parts[5] + "," + parts[6] + "],[";
    for (const int joint : {0, 3, 5}) text += std::to_string(static_cast<int>(std::floor(j[joint] / (kPi / 2)))) + ",";
    text += std::to_string(shape) + "],[9E9,9E9,9E9,9E9,9E9,9E9]];\n";
  }
  text += "PROC main()\n";
  for (size_t k = 0; k < q.size(); ++k) text += "MoveJ p" + std::to_string(k) + ",v1000,z50,gun\\WObj:=jig;\n";
  ExpectOnTarget(".mod", text + "ENDPROC\nENDMODULE\n", q, kFrameInWorld);
}

TEST_F(ProgramCompensationTest, UrScriptGoesByWhereTheArmIs) {
  const std::vector<Eigen::VectorXd> q = {Joints({20, -95, 100, 30, 40, -60}), Joints({22, -90, 95, 33, 37, -62}),
                                          Joints({25, -93, 90, 40, 30, -70})};
  std::string text = "movej([";
  for (int j = 0; j < 6; ++j) text += (j > 0 ? "," : "") + std::to_string(q[0][j]);
  text += "], a=1)\nmovel(p[" + PoseText(PoseNotation::kRotationVectorMetres, q[1], Pose<double>(), {}) +
          "], a=1)\nmovel(p[" + PoseText(PoseNotation::kRotationVectorMetres, q[2], Pose<double>(), {}) + "], a=1)\n";
  std::vector<Eigen::VectorXd> rounded = q;
  for (double& angle : rounded[0]) angle = std::stod(std::to_string(angle));
  ExpectOnTarget(".script", text, rounded, Pose<double>());
  // Without the motion before, the branch is asked for.
  text.erase(0, text.find('\n') + 1);
  const CompensatedProgram asked = Compensated(TrueRobot(truth_), ReadAs(".script", text));
  EXPECT_THAT(asked.results[0].untouched, HasSubstr("--start_deg"));
  EXPECT_EQ(asked.text, text);
  scene_.start = q[0];
  ExpectOnTarget(".script", text, {q[1], q[2]}, Pose<double>());
}

TEST_F(ProgramCompensationTest, FanucOnEveryBranch) {
  const std::vector<Eigen::VectorXd> q = {Joints({20, -95, 100, 30, 40, -60}), Joints({-60, -60, 80, -170, -35, 100}),
                                          Joints({10, -100, -60, 20, 50, 10})};
  const double stretched = std::atan2(-55.0, 1100.0);
  std::string text = "/PROG P\n/POS\n";
  for (size_t k = 0; k < q.size(); ++k) {
    const Eigen::VectorXd& j = q[k];
    const bool up = (j[2] > stretched) == (0.0 > stretched);
    text += "P[" + std::to_string(k + 1) + "]{\n   GP1:\n\tUF : 2, UT : 1,\t\tCONFIG : '" + (j[4] < 0.0 ? "N " : "F ") +
            (up ? "U " : "D ") + ((KrlStatus(j) & 1) != 0 ? "B" : "T") + ", 0, 0, 0',\n\t";
    std::string position = PoseText(PoseNotation::kWprDegrees, j, kFrameInWorld, kFanucNames);
    std::vector<std::string> parts = SplitText(position, ',');
    for (size_t i = 0; i < 6; ++i) text += parts[i] + (i < 3 ? "  mm" : " deg") + (i < 5 ? ",\t" : "\n};\n");
  }
  ExpectOnTarget(".ls", text + "/END\n", q, kFrameInWorld);
}

TEST_F(ProgramCompensationTest, WhatTheFileDoesNotStateIsAskedFor) {
  const std::string text = "$BASE=BASE_DATA[2]\nLIN {X 1000,Y 0,Z 800,A 0,B 90,C 0,S 2,T 2}\n";
  try {
    CompensateProgram(TrueRobot(truth_), ReadAs(".src", text), ProgramScene(), 1);
    FAIL();
  } catch (const InputError& error) {
    for (const char* part : {"tool 'default'", "tool 'flange'", "frame 'BASE_DATA[2]'", "frame 'world'"})
      EXPECT_THAT(error.what(), HasSubstr(part));
    EXPECT_THAT(error.hint(), HasSubstr("BASE_DATA[2]=x,y,z,roll,pitch,yaw"));
  }
  // Joint values need none.
  EXPECT_EQ(CompensateProgram(TrueRobot(truth_), ReadAs(".src", "PTP {A1 1,A2 -90,A3 90,A4 0,A5 9,A6 0}\n"),
                              ProgramScene(), 1)
                .results[0]
                .untouched,
            "");
  EXPECT_THROW(FramesFromText("a=1,2,3", "--frames_mm_deg"), InputError);
  EXPECT_THROW(FramesFromText("a=same; a=same", "--frames_mm_deg"), InputError);
}

// Loads that programs state. The truth was measured with a tool of 20 kg, which is off the arm where the program states
// what hangs there.
class ProgramLoadTest : public ProgramCompensationTest {
 protected:
  ProgramLoadTest() {
    measured_.tool_mass = 20.0;
    for (const auto& [name, kg, point] :
         {std::tuple{"ALL", 250.0, kAll}, {"GUN", 40.0, Vector3<double>(0.01, 0.0, 0.09)}, {"BOTH", 0.0, kAll}}) {
      loaded_.loads[name] = {{0, 0, -9.80665 * kg}, {0, 0, 0}, point};
    }
    const Vector3<double> piece = kToolInFlange.translation + kToolInFlange.rotation * Vector3<double>(0.02, 0.03, 0.3);
    loaded_.loads["BOTH"] = {{0, 0, -9.80665 * 200.0}, {0, 0, 0}, 0.2 * loaded_.loads["GUN"].point + 0.8 * piece};
  }
  CompensatedProgram Run(const std::string& ending, const std::string& text) {
    return Compensated(TrueRobot(measured_), ReadAs(ending, text));
  }
  // Joint points of the corrected program, run under these loads; "none": nothing hangs there, "tool": what was
  // measured with.
  void ExpectUnder(const std::string& ending, const std::string& text, const std::vector<std::string>& loads) {
    SCOPED_TRACE(ending);
    const CompensatedProgram result = Run(ending, text);
    const RobotProgram original = ReadAs(ending, text), corrected = ReadAs(ending, result.text);
    ASSERT_EQ(corrected.points.size(), loads.size()) << SummaryOf(result);
    for (size_t k = 0; k < loads.size(); ++k) {
      SCOPED_TRACE(result.program.points[k].name);
      ASSERT_EQ(result.results[k].untouched, "");
      const std::vector<double> asked = original.JointValues(original.points[k]),
                                sent = corrected.JointValues(corrected.points[k]);
      const bool is_tool = loads[k] == "tool";
      const ArmState there =
          test::LoadedState(is_tool ? measured_ : loaded_, Eigen::Map<const Eigen::VectorXd>(sent.data(), 6),
                            is_tool ? "none" : loads[k], 0);
      const Pose<double> goal = NominalFlange(Eigen::Map<const Eigen::VectorXd>(asked.data(), 6));
      EXPECT_LT((there.flange_origin - goal.translation).norm(), kWritten) << loads[k];
      EXPECT_LT((there.flange - goal.rotation).norm(), kWritten) << loads[k];
    }
  }

  const Vector3<double> kAll = {0.28, 0.06, -0.15};
  LoadedTruth measured_ = test::Everything(), loaded_ = test::Everything();
};

TEST_F(ProgramLoadTest, KrlStatesAllThatHangsOnTheFlange) {
  ExpectUnder(".src",
              "LOAD_DATA[3]={M 40.0,CM {X 10.0,Y 0.0,Z 90.0,A 0.0,B 0.0,C 0.0},J {X 0.0,Y 0.0,Z 0.0}}\n"
              "PTP {A1 5,A2 -95,A3 90,A4 0,A5 10,A6 0}\n"
              "$LOAD={M 250,CM {X 280,Y 60,Z -150,A 0,B 0,C 0},J {X 0,Y 0,Z 0}}\n"
              "PTP {A1 10,A2 -95,A3 90,A4 0,A5 10,A6 0}\n"
              "BAS(#TOOL,3)\nPTP {A1 12,A2 -90,A3 80,A4 0,A5 10,A6 0}\n"
              "$LOAD={M 0,CM {X 0,Y 0,Z 0,A 0,B 0,C 0},J {X 0,Y 0,Z 0}}\n"
              "PTP {A1 14,A2 -90,A3 80,A4 0,A5 10,A6 0}\n",
              {"tool", "ALL", "GUN", "none"});
}

// The loads of the program are none of the estimate's.
TEST_F(ProgramLoadTest, LoadsBeyondTheMeasuredOnesAreSaid) {
  const std::string move = "PTP {A1 5,A2 -95,A3 90,A4 0,A5 10,A6 0}\n";
  KnownRobot known = TrueRobot(measured_);
  known.measured_conditions.are_stated = true;
  known.measured_conditions.load_force = 500.0;
  const auto beyond = [&](const std::string& kg) {
    return Compensated(known, ReadAs(".src", "$LOAD={M " + kg + ",CM {X 280,Y 60,Z -150}}\n" + move)).beyond;
  };
  ASSERT_EQ(beyond("250").size(), 1U);
  EXPECT_THAT(beyond("250")[0], HasSubstr("at most 500 N"));
  EXPECT_TRUE(beyond("50").empty());
  EXPECT_TRUE(Compensated(known, ReadAs(".src", "$LOAD=X\n" + move)).beyond.empty());  // nothing is corrected
}

// As those of a table of targets are, with the line of the program.
TEST_F(ProgramLoadTest, PointsOutsideTheMeasuredJointRangesAreSaid) {
  KnownRobot known = TrueRobot(measured_);
  for (int j = 0; j < 6; ++j) known.measured_joints.push_back({-120.0 * kDegree, 120.0 * kDegree});
  known.measured_joints[0] = {-20.0 * kDegree, 20.0 * kDegree};
  const std::string load = "$LOAD={M 250,CM {X 280,Y 60,Z -150}}\n";
  const auto compensated = [&](const std::string& moves) { return Compensated(known, ReadAs(".src", load + moves)); };
  const std::string inside = "PTP {A1 5,A2 -95,A3 90,A4 0,A5 10,A6 0}\n";
  const CompensatedProgram far = compensated(inside + "PTP {A1 80,A2 -95,A3 90,A4 0,A5 10,A6 0}\n");
  EXPECT_THAT(far.beyond, Contains(HasSubstr("1 of 2 configurations lies outside the measured joint ranges")));
  EXPECT_THAT(SummaryOf(far), HasSubstr("Outside the measured joint ranges\n  line 3, PTP of line 3: A1 by 60 deg\n"));
  EXPECT_THAT(far.solved[1].words, HasSubstr("A1 by 60 deg"));
  EXPECT_EQ(SummaryOf(compensated(inside)).find("Outside the measured"), std::string::npos);
}

TEST_F(ProgramLoadTest, RapidAddsWhatTheToolGrips) {
  scene_.tools.erase("GUN");
  const std::vector<double> tool = NumbersOf(PoseNotation::kQuaternion, kToolInFlange);
  std::string frame;
  for (size_t i = 0; i < 7; ++i) frame += (i == 0 ? "[" : i == 3 ? "],[" : ",") + FormatNumber(tool[i]);
  const std::string external = ",[9E9,9E9,9E9,9E9,9E9,9E9]]";
  ExpectUnder(".mod",
              "PERS tooldata gun:=[TRUE,[" + frame + "]],[40,[10,0,90],[1,0,0,0],0,0,0]];\n" +
                  "PERS loaddata piece:=[160,[20,30,300],[1,0,0,0],0,0,0];\n" +
                  "PROC main()\n  MoveAbsJ [[5,-95,90,0,10,0]" + external + ",v100,fine,tool0;\n" +
                  "  MoveAbsJ [[10,-95,90,0,10,0]" + external + ",v100,fine,gun;\n  GripLoad piece;\n" +
                  "  MoveAbsJ [[12,-90,80,0,10,0]" + external + ",v100,fine,gun;\n  GripLoad load0;\n" +
                  "  MoveAbsJ [[14,-90,80,0,10,0]" + external + ",v100,fine,gun;\nENDPROC\n",
              {"tool", "GUN", "BOTH", "GUN"});
}

TEST_F(ProgramLoadTest, UrScriptStatesThePayload) {
  ExpectUnder(".script",
              "movej([0.1,-1.5,1.5,0.0,0.3,0.0])\nset_payload(250, [0.28, 0.06, -0.15])\n"
              "movej([0.2,-1.5,1.4,0.0,0.3,0.0])\nset_tcp(p[0.01,0,0.09,0,0,0])\nset_payload(40)\n"
              "movej([0.3,-1.5,1.4,0.0,0.3,0.0])\nset_target_payload(250, cog=[0.28, 0.06, -0.15])\n"
              "movej([0.4,-1.5,1.4,0.0,0.3,0.0])\n",
              {"tool", "ALL", "GUN", "ALL"});
}

TEST_F(ProgramLoadTest, FanucNamesALoadThatTheUserStates) {
  const auto point = [](int number, const std::string& a1) {
    return "P[" + std::to_string(number) + "]{\n GP1:\n UF : 0, UT : 1,\n J1= " + a1 +
           " deg, J2= -95 deg, J3= 90 deg,\n J4= 0 deg, J5= 10 deg, J6= 0 deg\n};\n";
  };
  const std::string text = "/PROG P\n/MN\n   1:J P[2] 100% FINE ;\n   2:  !PAYLOAD[7] P[2] ;\n   3:  PAYLOAD[1] ;\n" +
                           std::string("   4:J P[1] 100% FINE ;\n/POS\n") + point(1, "10") + point(2, "20") + "/END\n";
  const CompensatedProgram unknown = Run(".ls", text);
  EXPECT_THAT(SummaryOf(unknown), HasSubstr("names the load PAYLOAD[1] at 1 point"));
  EXPECT_THAT(SummaryOf(unknown), HasSubstr("--loads_kg_mm='PAYLOAD[1]="));
  EXPECT_THAT(unknown.results[0].untouched, HasSubstr("its load PAYLOAD[1] is not known"));
  EXPECT_EQ(unknown.results[1].untouched, "");
  scene_.load = "none";
  ExpectUnder(".ls", text, {"tool", "tool"});
  scene_.load.clear();
  scene_.loads = LoadsFromText("PAYLOAD[1]=250,280,60,-150", "--loads_kg_mm");
  ExpectUnder(".ls", text, {"ALL", "tool"});
  EXPECT_THROW(LoadsFromText("PAYLOAD[1]=250,280,60", "--loads_kg_mm"), InputError);
  EXPECT_THROW(LoadsFromText("a=-1,0,0,0", "--loads_kg_mm"), InputError);
  EXPECT_THROW(LoadsFromText("a=1,0,0,0;a=1,0,0,0", "--loads_kg_mm"), InputError);
}

TEST_F(ProgramLoadTest, WhatIsStatedOtherwiseOrTwice) {
  const std::string load = "$LOAD={M 250,CM {X 280,Y 60,Z -150,A 0,B 0,C 0},J {X 0,Y 0,Z 0}}\n";
  const std::string home = "DECL E6AXIS XHOME={A1 5,A2 -95,A3 90,A4 0,A5 10,A6 0}\nPTP XHOME\n";
  const CompensatedProgram twice = Run(".src", home + load + "PTP XHOME\n");
  EXPECT_THAT(twice.results[0].untouched, HasSubstr("more than one load (none and $LOAD of line 3)"));
  EXPECT_THAT(SummaryOf(Run(".src", load + home)), HasSubstr("250 kg at (280, 60, -150) mm"));
  // What \TLoad names stands in the file, in a frame that nobody knows.
  const CompensatedProgram total =
      Run(".mod",
          "PERS loaddata ld:=[80,[0,0,50],[1,0,0,0],0,0,0];\nPROC main()\n  MoveAbsJ "
          "[[5,-95,90,0,10,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0\\TLoad:=ld;\nENDPROC\n");
  EXPECT_THAT(total.results[0].untouched, HasSubstr("its load LD is not known: of what \\TLoad names"));
  // The user's word for all points comes before that of the program.
  scene_.load = "none";
  ExpectUnder(".src", home + load + "PTP XHOME\n", {"tool"});
  // Where the flange is not stated, nobody knows where the load hangs; a rigid arm does not care.
  scene_ = ProgramScene();
  EXPECT_THROW(Run(".src", load + home), InputError);
  KnownRobot rigid = TrueRobot(measured_);
  rigid.robot.compliances.clear();
  rigid.robot.gravity_compensator.reset();
  EXPECT_EQ(Compensated(rigid, ReadAs(".src", load + home)).results[0].untouched, "");
}

// 'N U T, 0, 0, 1': one of three joints stands beyond 180 deg. Limits decide which, or the user does.
TEST_F(ProgramCompensationTest, FanucTurns) {
  const Eigen::VectorXd q = Joints({20, -95, 100, 30, 40, 200});
  std::string text = "/PROG P\n/POS\nP[1]{\n   GP1:\n\tUF : 2, UT : 1,\t\tCONFIG : 'F U T, 0, 0, 1',\n\t";
  const std::vector<std::string> parts =
      SplitText(PoseText(PoseNotation::kWprDegrees, q, kFrameInWorld, kFanucNames), ',');
  for (size_t i = 0; i < 6; ++i) text += parts[i] + (i < 3 ? "  mm" : " deg") + (i < 5 ? ",\t" : "\n};\n");
  KnownRobot robot = TrueRobot(truth_);
  for (Joint& joint : robot.robot.chain.joints) joint.min.reset(), joint.max.reset();
  const CompensatedProgram open = Compensated(robot, ReadAs(".ls", text));
  EXPECT_THAT(open.results[0].untouched, HasSubstr("--turn_joints"));
  EXPECT_EQ(open.text, text);
  scene_.turn_joints = TurnJointsFrom({1, 4, 6}, 6, "--turn_joints");
  const CompensatedProgram stated = Compensated(robot, ReadAs(".ls", text));
  ASSERT_EQ(stated.results[0].untouched, "");
  EXPECT_NEAR(stated.results[0].solution->solution.q[5], q[5], 0.05);
  scene_.turn_joints.clear();
  for (size_t j = 0; j < 6; ++j) {
    robot.robot.chain.joints[j].min = (j == 5 ? -350 : -170) * kDegree;
    robot.robot.chain.joints[j].max = (j == 5 ? 350 : 170) * kDegree;
  }
  const CompensatedProgram limited = Compensated(robot, ReadAs(".ls", text));
  ASSERT_EQ(limited.results[0].untouched, "");
  EXPECT_NEAR(limited.results[0].solution->solution.q[5], q[5], 0.05);
  EXPECT_THROW(TurnJointsFrom({1, 4}, 6, "--turn_joints"), InputError);
  EXPECT_THROW(TurnJointsFrom({1, 4, 7}, 6, "--turn_joints"), InputError);
  EXPECT_THROW(TurnJointsFrom({1, 1, 6}, 6, "--turn_joints"), InputError);
  scene_.turn_joints = {0, 3, 5};
  EXPECT_THROW(Compensated(robot, ReadAs(".src", "PTP {A1 1,A2 -90,A3 90,A4 0,A5 9,A6 0}\n")), InputError);
}

// A program has no columns, and the robot is the estimate's: what can be done is said, of a table it is the column.
TEST_F(ProgramCompensationTest, AnEffectThatNeedsAColumnIsNamed) {
  KnownRobot known = TrueRobot(truth_);
  known.robot.effects = {{"thermal_growth", "robot", {}, {11.5e-6}}};
  try {
    Compensated(known, ReadAs(".src", "PTP {A1 1,A2 -90,A3 90,A4 0,A5 9,A6 0}\n"));
    ADD_FAILURE() << "a growth without a temperature is not known";
  } catch (const InputError& error) {
    const std::string words = error.what();
    for (const char* part : {"thermal_growth/robot needs temperature_degC", "no robot program states",
                             "a table of its points", "calibrate without the effect"})
      EXPECT_THAT(words, HasSubstr(part));
    EXPECT_THAT(words, ::testing::Not(HasSubstr("robot file")));
  }
}

TEST_F(ProgramCompensationTest, WhatCannotBeReachedStaysAndIsSaid) {
  const std::string text = "PTP {X 9000,Y 0,Z 800,A 0,B 90,C 0,S 2,T 2}\nPTP {A1 1,A2 -90,A3 90,A4 0,A5 9,A6 0}\n";
  ProgramScene scene = SceneOf(ReadAs(".src", text));
  scene.frames["default"] = Pose<double>();
  const CompensatedProgram result = CompensateProgram(TrueRobot(truth_), ReadAs(".src", text), scene, 1);
  EXPECT_THAT(result.results[0].untouched, HasSubstr("does not reach"));
  EXPECT_EQ(result.text.substr(0, text.find('\n')), text.substr(0, text.find('\n')));
  EXPECT_NE(result.text, text);
  EXPECT_THAT(SummaryOf(result), HasSubstr("1 of 2 points corrected"));
  EXPECT_THAT(SummaryOf(result), HasSubstr("line 1, PTP of line 1"));
}

}  // namespace
}  // namespace sagitta::program_compensation_test

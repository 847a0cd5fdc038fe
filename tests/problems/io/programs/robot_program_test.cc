// Points of robot programs: what is read of each dialect, and that nothing but their numbers changes.
#include "problems/io/programs/robot_program.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "models/constants.h"
#include "tests/problems/io/programs/robot_program_test_support.h"

namespace sagitta::robot_program_test {
namespace {

using ::testing::HasSubstr;

Matrix3<double> About(int axis, double degrees) {
  return Eigen::AngleAxisd(degrees * kDegree, Vector3<double>::Unit(axis)).toRotationMatrix();
}

constexpr char kKrl[] = R"(&ACCESS RVO
DEF WELD( )
; XOLD={X 1,Y 2,Z 3,A 0,B 0,C 0} is a comment
DECL E6POS XP1={X 1200.5,Y -30.0,Z 900.25,A 10.0,B 80.0,C -5.0,S 2,T 35,E1 0.0}
DECL FDAT FP1={TOOL_NO 2,BASE_NO 0,IPO_FRAME #BASE,POINT2[] " ",TQ_STATE FALSE}
DECL E6AXIS XHOME={A1 5.0,A2 -90.0,A3 95.0,A4 0.0,A5 10.0,A6 -3.5,E1 0.0}
$BASE=BASE_DATA[3]
$TOOL={X 0,Y 0,Z 120,A 0,B 0,C 0}
PTP XHOME
PTP {A1 1,A2 -91,A3 91,A4 0,A5 0,A6 0}
LIN {X 1000,Y 0,Z 800,A 0,B 90,C 0} C_DIS
LIN_REL {X 10,Y 0,Z 0,A 0,B 0,C 0}
PTP {A3 45}
BAS(#TOOL,4)
LIN {POS: X 1001, Y 1, Z 801, A 0, B 90, C 0}
END
)";

TEST_F(RobotProgramTest, Krl) {
  const RobotProgram program = ReadAs("weld.src", kKrl);
  ASSERT_EQ(program.points.size(), 7U);
  const ProgramPoint& taught = PointNamed(program, "XP1");
  EXPECT_THAT(ValuesOf(taught), ::testing::ElementsAre(1200.5, -30.0, 900.25, 10.0, 80.0, -5.0));
  EXPECT_EQ(taught.line, 4);
  EXPECT_EQ(taught.tool, "TOOL_DATA[2]");
  EXPECT_EQ(taught.frame, kWorldName);
  EXPECT_EQ(taught.branch.wrist_behind, false);  // S 2 = 010
  EXPECT_EQ(taught.branch.elbow_past_stretch, true);
  EXPECT_EQ(taught.branch.wrist_negative, false);
  std::string negative;  // T 35 = 100011
  for (const auto& [joint, range] : taught.branch.ranges) negative += range.first < 0.0 ? '-' : '+';
  EXPECT_EQ(negative, "--+++-");
  EXPECT_THAT(ValuesOf(PointNamed(program, "XHOME")), ::testing::ElementsAre(5, -90, 95, 0, 10, -3.5));
  EXPECT_TRUE(PointNamed(program, "PTP of line 10").is_joints);
  const ProgramPoint& line = PointNamed(program, "LIN of line 11");
  EXPECT_EQ(line.frame, "BASE_DATA[3]");
  EXPECT_NEAR(program.tools.at(line.tool).translation.z(), 0.120, 1e-15);
  EXPECT_TRUE(line.branch.from_before);
  EXPECT_THAT(PointNamed(program, "LIN_REL of line 12").untouched, HasSubstr("relative"));
  EXPECT_THAT(PointNamed(program, "PTP of line 13").untouched, HasSubstr("some of the joints"));
  EXPECT_EQ(PointNamed(program, "LIN of line 15").tool, "TOOL_DATA[4]");
}

constexpr char kRapid[] = R"(MODULE Weld
  PERS tooldata gun:=[TRUE,[[97.4,0,223.1],[0.924,0,0.383,0]],[5,[23,0,75],[1,0,0,0],0,0,0]];
  TASK PERS wobjdata jig:=[FALSE,TRUE,"",[[300,0,100],[1,0,0,0]],[[0,50,0],[0.707106781,0,0,0.707106781]]];
  PERS wobjdata turntable:=[FALSE,FALSE,"STN1",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
  ! CONST robtarget pOld:=[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget p10:=[[600,-500,225.3],[0.5,-0.5,0.5,-0.5],[-1,0,1,3],[9E+09,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST robtarget p20:=[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget pMany{2}:=[[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]];
  CONST jointtarget home:=[[0,-20,20.5,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget p30:=[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PROC main()
  MoveAbsJ home\NoEOffs,v1000,z50,gun\WObj:=jig;
  IF x=1 THEN MoveJ p30,v100,fine,tool0; ENDIF
  MoveL p10,
    v1000,z50,gun\WObj:=jig;
  MoveL Offs(p10,0,0,50),v100,fine,gun\WObj:=jig;
  MoveJ p20,v100,fine,gun;
  MoveL p20,v100,fine,tool0;
  MoveJ [[11,12,13],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,gun\WObj:=turntable;
ENDPROC
ENDMODULE
)";

TEST_F(RobotProgramTest, Rapid) {
  const RobotProgram program = ReadAs("weld.mod", kRapid);
  const ProgramPoint& p10 = PointNamed(program, "p10");
  EXPECT_THAT(ValuesOf(p10), ::testing::ElementsAre(600, -500, 225.3, 0.5, -0.5, 0.5, -0.5));
  EXPECT_EQ(p10.untouched, "");
  EXPECT_EQ(p10.tool, "GUN");
  EXPECT_EQ(p10.frame, "JIG");
  EXPECT_NEAR(program.tools.at("GUN").translation.z(), 0.2231, 1e-15);
  // uframe * oframe: a turn of 90 deg about z at (300, 50, 100)
  EXPECT_LT((program.frames.at("JIG").translation - Vector3<double>(0.3, 0.05, 0.1)).norm(), 1e-12);
  EXPECT_LT((program.frames.at("JIG").rotation - About(2, 90)).norm(), 1e-8);
  EXPECT_EQ(p10.branch.wrist_negative, true);  // cfx 3
  EXPECT_EQ(p10.branch.elbow_of_zero, false);
  EXPECT_EQ(p10.branch.wrist_behind, false);
  EXPECT_NEAR(p10.branch.ranges[0].second.first, -kPi / 2, 1e-15);  // cf1 -1: joint 1 from -90 to 0
  EXPECT_EQ(p10.branch.ranges[2].first, 5);
  EXPECT_NEAR(p10.branch.ranges[2].second.first, kPi / 2, 1e-15);
  EXPECT_THAT(ValuesOf(PointNamed(program, "home")), ::testing::ElementsAre(0, -20, 20.5, 0, 30, 0));
  EXPECT_THAT(PointNamed(program, "p20").untouched, HasSubstr("more than one tool"));
  EXPECT_THAT(PointNamed(program, "pMany").untouched, HasSubstr("array"));
  EXPECT_THAT(PointNamed(program, "MOVEJ of line 19").untouched, HasSubstr("moved by another unit"));
  EXPECT_EQ(program.points.size(), 6U);
  EXPECT_THAT(program.notes, ::testing::IsEmpty());
  std::vector<int> lines;
  for (const ProgramMotion& motion : program.motions) {
    if (motion.is_offset) lines.push_back(motion.line);
  }
  EXPECT_THAT(lines, ::testing::ElementsAre(16));
}

constexpr char kUr[] = R"(def weld():
  set_tcp(p[0,0,0.15,0,0,0])
  set_payload(2.5, [0,0,0.05])
  global feature=p[0.1,0.2,0.3,0,0,0]
  global Waypoint_1_p=p[0.4, -0.2, 0.3, 2.2, -2.2, 0.1]
  global Waypoint_1_q=[-1.1, -1.9, -1.2, -1.5, 1.57, 0.2]
  # movej([9,9,9,9,9,9])
  movej([0.1,-1.5,1.5,-1.6,-1.57,0], a=1.4, v=1.05)
  movej(get_inverse_kin(Waypoint_1_p, qnear=Waypoint_1_q), a=1.4, v=1.05)
  movel(pose_trans(feature, p[0,0,0.1,0,0,0]), a=1.2)
  set_tcp(tool_from_elsewhere)
  movel(p[0.5,-0.2,0.3,3.14,0,0], a=1.2)
end
)";

TEST_F(RobotProgramTest, UrScript) {
  const RobotProgram program = ReadAs("weld.script", kUr);
  const ProgramPoint& joints = PointNamed(program, "movej of line 8");
  EXPECT_TRUE(joints.is_joints);
  EXPECT_DOUBLE_EQ(program.JointValues(joints)[1], -1.5);
  const ProgramPoint& waypoint = PointNamed(program, "Waypoint_1_p");
  EXPECT_EQ(waypoint.untouched, "");
  EXPECT_NEAR(program.tools.at(waypoint.tool).translation.z(), 0.15, 1e-15);
  EXPECT_THAT(PointNamed(program, "Waypoint_1_q").untouched, HasSubstr("inverse kinematics"));
  EXPECT_THAT(PointNamed(program, "feature").untouched, HasSubstr("no motion"));
  EXPECT_THAT(PointNamed(program, "movel of line 10").untouched, HasSubstr("computed"));
  EXPECT_EQ(PointNamed(program, "movel of line 12").tool, "tool_from_elsewhere");
  EXPECT_EQ(program.points.size(), 6U);
}

// get_inverse_kin(x, qnear, maxPositionError, maxOrientationError, tcp) of the script manual.
TEST_F(RobotProgramTest, UrScriptInverseKinematicsStatesSolutionAndTool) {
  const std::string pose = "p[0.5,-0.2,0.3,3.14,0,0]", near = "[0.1,-1.5,1.5,-1.6,-1.57,0.25]";
  const auto read = [&](const std::string& arguments) {
    return ReadAs("ik.script", "set_tcp(p[0,0,0.1,0,0,0])\nq=" + near + "\nr=[1,2,3,4,5,6]\nr[0]=0\nx=" + pose +
                                   "\nmovej(get_inverse_kin(" + arguments + "))\n");
  };
  const std::vector<double> joints = {0.1, -1.5, 1.5, -1.6, -1.57, 0.25};
  for (const std::string& given : std::vector<std::string>{"x, q", "x, qnear=q", "x, " + near, "x=x, qnear=" + near}) {
    const RobotProgram program = read(given);
    EXPECT_EQ(PointNamed(program, "x").branch.near, joints) << given;
    EXPECT_EQ(PointNamed(program, "x").untouched, "") << given;
    EXPECT_NEAR(program.tools.at(PointNamed(program, "x").tool).translation.z(), 0.1, 1e-15) << given;
  }
  for (const std::string given : {"x, q, 1e-10, 1e-10, p[0,0,0.3,0,0,0]", "x, q, tcp=p[0,0,0.3,0,0,0]"}) {
    const RobotProgram program = read(given);
    EXPECT_NEAR(program.tools.at(PointNamed(program, "x").tool).translation.z(), 0.3, 1e-15) << given;
  }
  EXPECT_EQ(PointNamed(read("x, q, tcp=my_tool"), "x").tool, "my_tool");
  // What the arm's place is needs no numbers.
  EXPECT_EQ(PointNamed(read("x, get_actual_joint_positions()"), "x").untouched, "");
  for (const std::string given : {"x, r", "x, elsewhere", "x, f(1)", "x, [1,2,a,4,5,6]", "x, q, tcp=f(1)"})
    EXPECT_THAT(PointNamed(read(given), "x").untouched, HasSubstr("is no number")) << given;
  EXPECT_THAT(PointNamed(read("x, q))\nmovej(get_inverse_kin(x, [0,0,0,0,1,0]"), "x").untouched,
              HasSubstr("more than one qnear"));
}

TEST_F(RobotProgramTest, UrScriptOptimisedMotionsAreMotions) {
  const RobotProgram program = ReadAs("opt.script", "optimovel(p[0.5,-0.2,0.3,3.14,0,0])\noptimovej([0,0,1,0,1,0])\n");
  ASSERT_EQ(program.motions.size(), 2U);
  EXPECT_TRUE(program.points[1].is_joints);
}

// A load or a tool that the program changes as it runs holds nowhere for certain: the name is there, no value.
TEST_F(RobotProgramTest, WhatChangesAsTheProgramRunsIsNotStated) {
  const std::string load = "{M 5,CM {X 0,Y 0,Z 100},J {X 0,Y 0,Z 0}}",
                    other = "{M 9,CM {X 0,Y 0,Z 100},J {X 0,Y 0,Z 0}}";
  const std::string points = "PTP {A1 0,A2 -90,A3 90,A4 0,A5 0,A6 0}\n";
  const auto krl = [&](const std::string& change) {
    return ReadAs("switch.src", "DEF SWITCH()\nLOAD_DATA[1]=" + load + "\nDECL LOAD GRIPPER=" + load +
                                    "\nTOOL_DATA[1]={X 0,Y 0,Z 100,A 0,B 0,C 0}\nBAS(#TOOL,1)\n" + points + change +
                                    "\n" + points + "END\n");
  };
  EXPECT_EQ(krl("").loads.count("LOAD_DATA[1]"), 1U);
  EXPECT_EQ(krl("LOAD_DATA[1]=" + load).loads.count("LOAD_DATA[1]"), 1U);
  for (const std::string& change :
       {"LOAD_DATA[1]=" + other, std::string("LOAD_DATA[1].M=9"), std::string("LOAD_DATA[1]=GRIPPER")}) {
    const RobotProgram program = krl(change);
    EXPECT_EQ(program.loads.count("LOAD_DATA[1]"), 0U) << change;
    EXPECT_EQ(program.points[0].load, "LOAD_DATA[1]") << change;
  }
  EXPECT_EQ(krl("GRIPPER.CM.X=10").loads.count("GRIPPER"), 0U);
  EXPECT_EQ(krl("TOOL_DATA[1].Z=200").tools.count("TOOL_DATA[1]"), 0U);
  EXPECT_EQ(krl("TOOL_DATA[1]={X 0,Y 0,Z 200,A 0,B 0,C 0}").tools.count("TOOL_DATA[1]"), 0U);

  const auto ur = [&](const std::string& change) {
    return ReadAs("switch.script",
                  "set_payload(2.5, [0,0,0.05])\nmovej([0,0,0,0,0,0])\n" + change + "\nmovej([1,0,0,0,0,0])\n");
  };
  EXPECT_EQ(ur("").points[1].load, "set_payload of line 1");
  for (const std::string change : {"set_payload_mass(4)", "set_payload_cog([0,0,0.1])"}) {
    const RobotProgram program = ur(change);
    EXPECT_EQ(program.points[1].load, change.substr(0, change.find('(')) + " of line 3");
    EXPECT_EQ(program.loads.count(program.points[1].load), 0U);
  }

  const std::string loaddata = "PERS loaddata piece:=[5,[0,0,100],[1,0,0,0],0,0,0];\n";
  const std::string tooldata = "PERS tooldata gun:=[TRUE,[[0,0,100],[1,0,0,0]],[3,[0,0,50],[1,0,0,0],0,0,0]];\n";
  const auto rapid = [&](const std::string& change) {
    return ReadAs(
        "switch.mod",
        "MODULE M\n" + tooldata + loaddata +
            "PROC main()\nGripLoad piece;\nMoveAbsJ [[0,0,0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,gun;\n" +
            change + "\nENDPROC\nENDMODULE\n");
  };
  EXPECT_EQ(rapid("").loads.count("GUN and PIECE"), 1U);
  for (const std::string change : {"piece.mass:=9;", "piece := other;", "gun.tload.mass := 4;"}) {
    EXPECT_EQ(rapid(change).loads.count("GUN and PIECE"), 0U) << change;
  }
  EXPECT_EQ(rapid("gun.tframe.trans.z := 4;").tools.count("GUN"), 0U);
}

TEST_F(RobotProgramTest, PayloadByARegisterIsNamed) {
  const RobotProgram program = ReadAs("switch.ls", R"(/PROG  SWITCH
/MN
   1:  PAYLOAD[1] ;
   2:J P[1] 100% FINE    ;
   3:  PAYLOAD[R[7]] ;
   4:J P[2] 100% FINE    ;
/POS
P[1]{
   GP1:
	UF : 0, UT : 1,
	J1=     1.000 deg,	J2=   -20.000 deg,	J3=    10.500 deg,
	J4=     0.000 deg,	J5=   -60.000 deg,	J6=     5.000 deg
};
P[2]{
   GP1:
	UF : 0, UT : 1,
	J1=     2.000 deg,	J2=   -20.000 deg,	J3=    10.500 deg,
	J4=     0.000 deg,	J5=   -60.000 deg,	J6=     5.000 deg
};
/END
)");
  EXPECT_EQ(program.points[0].load, "PAYLOAD[1]");
  EXPECT_EQ(program.points[1].load, "PAYLOAD[R[7]]");
}

constexpr char kFanuc[] = R"(/PROG  WELD
/MN
   1:J P[1] 100% FINE    ;
   2:L P[2:"seam P[9]{"] 250mm/sec CNT100    ;
/POS
P[1]{
   GP1:
	UF : 0, UT : 1,
	J1=     1.000 deg,	J2=   -20.000 deg,	J3=    10.500 deg,
	J4=     0.000 deg,	J5=   -60.000 deg,	J6=     5.000 deg
};
P[2:"seam"]{
   GP1:
	UF : 2, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =   600.125  mm,	Y =   -10.000  mm,	Z =   500.000  mm,
	W =   180.000 deg,	P =    -1.500 deg,	R =    30.000 deg
};
P[3]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'F D B, 0, 0, 1',
	X =   600.125  mm,	Y =   -10.000  mm,	Z =   500.000  mm,
	W =   180.000 deg,	P =    -1.500 deg,	R =    30.000 deg
};
P[4]{
   GP1:
	UF : F, UT : F,		CONFIG : 'N U T, 0, 0, 0',
	X = ********  mm,	Y =   -10.000  mm,	Z =   500.000  mm,
	W =   180.000 deg,	P =    -1.500 deg,	R =    30.000 deg
};
/END
)";

TEST_F(RobotProgramTest, Fanuc) {
  const RobotProgram program = ReadAs("weld.ls", kFanuc);
  ASSERT_EQ(program.points.size(), 4U);
  EXPECT_THAT(ValuesOf(PointNamed(program, "P[1]")), ::testing::ElementsAre(1, -20, 10.5, 0, -60, 5));
  const ProgramPoint& seam = PointNamed(program, "P[2]");
  EXPECT_THAT(ValuesOf(seam), ::testing::ElementsAre(600.125, -10, 500, 180, -1.5, 30));
  EXPECT_EQ(seam.frame, "UF2");
  EXPECT_EQ(seam.tool, "UT1");
  EXPECT_EQ(seam.branch.wrist_negative, true);
  EXPECT_EQ(seam.branch.elbow_of_zero, true);
  EXPECT_EQ(seam.branch.wrist_behind, false);
  EXPECT_THAT(PointNamed(program, "P[3]").branch.turns, ::testing::ElementsAre(0, 0, 1));
  EXPECT_TRUE(PointNamed(program, "P[3]").branch.ranges.empty());
  EXPECT_TRUE(seam.branch.turns.empty());
  EXPECT_THAT(PointNamed(program, "P[4]").untouched, HasSubstr("not taught"));
}

// Numbers that are put back as they were leave the bytes between them; others change nothing else.
TEST_F(RobotProgramTest, OnlyTheNumbersOfAPointChange) {
  struct Case {
    const char *name, *text, *point;
  };
  for (const Case& c : {Case{"a.src", kKrl, "XHOME"},
                        {"a.mod", kRapid, "home"},
                        {"a.script", kUr, "movej of line 8"},
                        {"a.ls", kFanuc, "P[1]"}}) {
    std::string windows = c.text;
    for (size_t i = 0; (i = windows.find('\n', i)) != std::string::npos; i += 2) windows.replace(i, 1, "\r\n");
    for (const std::string& text : {std::string(c.text), windows}) {
      const RobotProgram program = ReadAs(c.name, text);
      EXPECT_EQ(WithCorrectedPoints(program, {}), text);
      const ProgramPoint& point = PointNamed(program, c.point);
      const int index = static_cast<int>(&point - program.points.data());
      const std::vector<double> joints = {0.11, -0.22, 0.33, -0.44, 0.55, -0.66};
      const std::string changed = WithOne(program, index, joints, nullptr);
      const RobotProgram again = ReadAs(c.name, changed);
      ASSERT_EQ(again.points.size(), program.points.size());
      for (size_t j = 0; j < 6; ++j) EXPECT_NEAR(again.JointValues(again.points[index])[j], joints[j], 1e-8);
      // Between the numbers of the point, and around them, the same bytes.
      size_t old_end = 0, new_end = 0;
      for (size_t j = 0; j < 6; ++j) {
        const TextNumber &before = point.numbers[j], &after = again.points[index].numbers[j];
        EXPECT_EQ(text.substr(old_end, before.begin - old_end), changed.substr(new_end, after.begin - new_end));
        old_end = before.end, new_end = after.end;
      }
      EXPECT_EQ(text.substr(old_end), changed.substr(new_end));
    }
  }
}

// A target without numbers in this file is a point too: one that stays as it is.
TEST_F(RobotProgramTest, EveryMotionIsCounted) {
  EXPECT_THAT(MotionsOf(ReadAs("a.script",
                               "movej([d2r(10), 0, 0, 0, 0, 0])\nmovej(q1, a=1)\nmovej([q1, 0, 0, 0, 0, 0])\n"
                               "movec(p[1,2,3,0,0,0], pose=p[1,2,4,0,0,0])\nservoc(there())\n")),
              ::testing::ElementsAre("1 movej [d2r(10), 0, 0, 0, 0, 0]: it is computed: [d2r(10), 0, 0, 0, 0, 0]",
                                     "2 movej q1: this file gives it no numbers",
                                     "3 movej [q1, 0, 0, 0, 0, 0]: it is computed: [q1, 0, 0, 0, 0, 0]",
                                     "4 movec p[1,2,3,0,0,0]", "4 movec p[1,2,4,0,0,0]",
                                     "5 servoc there(): it is computed: there()"));
  EXPECT_THAT(
      MotionsOf(ReadAs("a.src",
                       "XP2={A1 1,A2 2,A3 3,A4 4,A5 5,A6 6}\nPTP XP1 C_PTP\nPTP XP2\nPTP XP2:XOFF\nLIN XP[3] "
                       "C_DIS\nSCIRC XP2, XP1, CA 90\nPTP_REL XREL\nPTP {E1 100}\n")),
      ::testing::ElementsAre("2 PTP XP1 C_PTP: this file gives it no numbers", "3 PTP XP2",
                             "4 PTP XP2:XOFF: it is computed: XP2:XOFF", "5 LIN XP[3] C_DIS: it is one of an array",
                             "6 SCIRC XP2", "6 SCIRC XP1: this file gives it no numbers",
                             "7 PTP_REL XREL: a relative motion: it goes on from where the arm is",
                             "8 PTP {E1 100}: it states only a part of the pose"));
  const std::string p1 = "CONST robtarget p1:=[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n";
  EXPECT_THAT(MotionsOf(ReadAs(
                  "a.mod", p1 + "VAR robtarget p2;\nMoveL p2,v100,fine,tool0;\nMoveL \\Conc,p1,v100,fine,tool0;\n"
                                "MoveC p1,pElsewhere,v100,fine,tool0;\nMoveJ pMany{2},v100,fine,tool0;\n"
                                "MoveL Offs(p2,0,0,1),v100,fine,tool0;\nSearchL di1,found,p1,v100,tool0;\n"
                                "TriggIO gunon,0.2;\nMoveJ CRobT(),v100,fine,tool0;\nArcL p3,v100,s,w,fine,tool0;\n")),
              ::testing::ElementsAre(
                  "3 MoveL p2: this file gives it no numbers", "4 MoveL p1", "5 MoveC p1",
                  "5 MoveC pElsewhere: this file gives it no numbers", "6 MoveJ pMany{2}: it is one of an array",
                  "7 MoveL Offs(p2,0,0,1): this file gives it no numbers", "8 SearchL p1",
                  "10 MoveJ CRobT(): it is computed: CRobT()", "11 ArcL p3: this file gives it no numbers"));
  std::string fanuc = kFanuc;
  fanuc.replace(fanuc.find("/POS"), 0,
                "   3:L PR[3] 100mm/sec FINE Offset,PR[4]    ;\n   4:C P[1]    \n    :  P[9] 100mm/sec FINE    ;\n"
                "   5:L P[R[1]] 100mm/sec FINE    ;\n   6:L P[3] 100mm/sec FINE INC    ;\n   7:  PR[1]=P[2]    ;\n");
  EXPECT_THAT(MotionsOf(ReadAs("a.ls", fanuc)),
              ::testing::ElementsAre("3 J P[1]", "4 L P[2: ]", "5 L PR[3]: its numbers are in the controller",
                                     "6 C P[1]", "7 C P[9]: this file gives it no numbers",
                                     "8 L P[R[1]]: which point it is, is chosen as the program runs",
                                     "9 L P[3]: an incremental motion goes on from where the arm is"));
}

// A point of which the program changes a part does not hold its numbers everywhere.
TEST_F(RobotProgramTest, PointsThatChangeAsTheProgramRunsStay) {
  const std::string joints = "{A1 1,A2 2,A3 3,A4 4,A5 5,A6 6}\n";
  EXPECT_THAT(MotionsOf(ReadAs("a.src", "XP1=" + joints + "XP1.A1=2\nPTP XP1\nPTP " + joints))[0],
              HasSubstr("changes"));
  EXPECT_THAT(MotionsOf(ReadAs("a.script", "a=[1,2,3,4,5,6]\na[1] = 0.2\nmovej(a)\n"))[0], HasSubstr("more than once"));
  const std::string home = "VAR jointtarget home:=[[0,0,0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n";
  for (const char* change : {"home:=CJointT();\n", "home.robax.rax_1 := 3;\n"})
    EXPECT_THAT(MotionsOf(ReadAs("a.mod", home + change + "MoveAbsJ home,v100,fine,tool0;\n"))[0],
                HasSubstr("changes"));
}

TEST_F(RobotProgramTest, BadProgramsAreNamed) {
  EXPECT_TRUE(SaysInOrder(
      ErrorOf([&] { ReadAs("a.txt", kKrl); }),
      {".txt", ".src .dat .sub (KUKA)", ".mod .modx .prg .sys (ABB)", ".script .urscript (UR)", ".ls (FANUC)"}));
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { ReadAs("a.src", "PTP XP1\n"); }), {"a.src", "no target", ".dat"}));
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { ReadAs("a.src", "\nPTP {A1 0,A2 1"); }), {"a.src:2", "not closed"}));
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { ReadAs("a.mod", "CONST robtarget p:=[[1,2"); }), {"a.mod:1", "not closed"}));
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { ReadAs("a.script", "movej([1,2"); }), {"a.script:1", "not closed"}));
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { ReadAs("a.ls", "/POS\nP[1]{ GP1:"); }), {"a.ls:2", "not closed"}));
}

TEST_F(RobotProgramTest, UrScriptToolsInVariables) {
  const std::string tool = "my_tcp=p[0,0,0.15,0,0,0]\n", move = "movel(p[0.5,-0.2,0.3,3.14,0,0])\n";
  const auto read = [&](const std::string& body) { return ReadAs("a.script", "def main():\n" + body + "end\n"); };
  const RobotProgram program = read("global " + tool + "set_tcp(my_tcp)\n" + move);
  ASSERT_EQ(program.tools.count("my_tcp"), 1U);
  EXPECT_EQ(program.tools.at("my_tcp").translation.z(), 0.15);
  EXPECT_EQ(program.points.back().tool, "my_tcp");
  EXPECT_EQ(program.points.back().untouched, "");
  EXPECT_EQ(read(tool + "set_tcp(my_tcp)\n" + move + "my_tcp[2]=0.2\n").tools.count("my_tcp"), 0U);
  EXPECT_EQ(read("my_tcp=pose_trans(a,b)\nset_tcp(my_tcp)\n" + move).tools.count("my_tcp"), 0U);
  EXPECT_EQ(PointNamed(read(tool + "set_tcp(my_tcp)\nmovel(my_tcp)\n"), "my_tcp").untouched, "it is a tool, too");
  EXPECT_THAT(read("def go(my_tcp):\nset_tcp(my_tcp)\n" + move + "end\ngo(a)\n").points.back().untouched,
              HasSubstr("more than one tool"));
}

TEST_F(RobotProgramTest, UrScriptRoutinesThatSoundLikeFunctionsAreNamed) {
  const RobotProgram program =
      ReadAs("a.script",
             "def main():\n movej([0,-1,1,0,1,0])\n tool_change(2)\n set_gripper(1)\n get_part()\n move_home()\n"
             " set_digital_out(1, True)\n sleep(0.5)\n zero_ftsensor()\n socket_close(\"a\")\nend\n");
  EXPECT_EQ(program.calls_elsewhere,
            (std::map<std::string, int>{{"tool_change", 3}, {"set_gripper", 4}, {"get_part", 5}, {"move_home", 6}}));
}

TEST_F(RobotProgramTest, UrScriptBranchesAndThreads) {
  const std::string pose = "p[0.5,-0.2,0.3,3.14,0,0]", other = "set_tcp(p[0,0,0.15,0,0,0])\n";
  const auto why = [&](const std::string& body, const std::string& before = "") {
    const RobotProgram program =
        ReadAs("a.script", before + "def main():\nset_tcp(p[0,0,0.1,0,0,0])\np1=" + pose + "\n" + body + "end\n");
    return PointNamed(program, "p1").untouched;
  };
  EXPECT_EQ(why("movel(p1)\n"), "");
  EXPECT_THAT(why("if (x == 1):\n" + other + "end\nmovel(p1)\n"), HasSubstr("more than one tool"));
  EXPECT_THAT(why("movel(p1)\n", "thread t():\n" + other + "end\n"), HasSubstr("more than one tool"));
  const auto of_offset = [&](const std::string& before) {
    return ReadAs("a.script", "p1=" + pose + "\n" + before + "movel(pose_trans(p1, p[0,0,0.05,0,0,0]))\n")
        .points.back()
        .untouched;
  };
  EXPECT_THAT(of_offset("movel(p1)\n"), HasSubstr("it moves with p1, which is corrected"));
  EXPECT_THAT(of_offset(""), ::testing::Not(HasSubstr("it moves with")));  // a frame, say
  EXPECT_THAT(why("set_tcp(pose_trans(a, b))\nmovel(p1)\n"), HasSubstr("more than one tool"));
  EXPECT_EQ(why("def go():\nmovel(p1)\nend\nwhile True:\ngo()\nend\n"), "");  // the one tool of the program
  EXPECT_THAT(why("def go(p1):\nmovel(p1)\nend\ngo(p2)\n"), HasSubstr("by this name"));
  EXPECT_THAT(why("if x == 1: p1=p[0.3,0.2,0.4,0,3.1,0] end\nmovel(p1)\n"), HasSubstr("more than once"));
  EXPECT_THAT(why("x=1; p1[2]=0.1; movel(p1)\n"), HasSubstr("more than once"));
  const std::string name(300000, 'a');
  EXPECT_THAT(ErrorOf([&] { ReadAs("a.script", name + " = [1,2,3]\nmovej([0,0,1,0,1,0])\n"); }), HasSubstr("words"));
}

}  // namespace
}  // namespace sagitta::robot_program_test

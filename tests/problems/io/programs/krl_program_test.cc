// KRL: what a program does not say for certain of a point stays as it is, with the reason.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/problems/io/programs/robot_program_test_support.h"

namespace sagitta::krl_program_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::string kPose = "X 493,Y -83,Z 754,A -151,B 19,C 26";
const std::string kJoints = "{A1 10,A2 -80,A3 100,A4 15,A5 40,A6 25}";

class KrlProgramTest : public RobotProgramTest {
 protected:
  RobotProgram Main(const std::string& body) { return ReadAs("a.src", "DEF MAIN( )\n" + body + "END\n"); }
  ProgramPoint LastOf(const RobotProgram& program) {
    return program.points.empty() ? ProgramPoint() : program.points.back();
  }
  ProgramPoint Last(const std::string& body) { return LastOf(Main(body)); }
};

TEST_F(KrlProgramTest, WithHoldsForItsMotion) {
  const std::string scene = "$TOOL=TOOL_DATA[1]\n$BASE=BASE_DATA[1]\n", point = "{" + kPose + ",S 2,T 2}";
  const RobotProgram program =
      Main(scene + "SLIN " + point + " WITH $VEL={CP 0.2}, $BASE=BASE_DATA[2], $TOOL=$NULLFRAME, $LOAD=PIECE\nSPTP " +
           point + "\n");
  ASSERT_EQ(program.points.size(), 2U);
  EXPECT_EQ(program.points[0].tool, kFlangeName);
  EXPECT_EQ(program.points[0].frame, "BASE_DATA[2]");
  EXPECT_EQ(program.points[0].load, "PIECE");
  EXPECT_EQ(program.points[1].tool, "TOOL_DATA[1]");
  EXPECT_EQ(program.points[1].frame, "BASE_DATA[1]");
  EXPECT_EQ(program.points[1].load, "");
  const std::string named = "XP1=" + point + "\nPTP XP1\nSPTP XP1 WITH $BASE=BASE_DATA[2]\n";
  EXPECT_THAT(Last(scene + named).untouched, HasSubstr("more than one tool or base"));
}

TEST_F(KrlProgramTest, TheCallersBaseIsNotKnown) {
  const std::string point = "PTP {" + kPose + ",S 2,T 2}\n";
  const auto call = [&](const std::string& calls) {
    return ReadAs("a.src", "DEF MAIN()\n$TOOL=$NULLFRAME\n$BASE=BASE_DATA[1]\nSUB()\n$BASE=BASE_DATA[2]\n" + calls +
                               "END\nDEF SUB()\n" + point + "END\n");
  };
  EXPECT_THAT(call("SUB()\n").points[0].untouched, HasSubstr("more than one tool or base"));
  const RobotProgram called = call("");
  EXPECT_EQ(called.points[0].frame, "BASE_DATA[1]");
  EXPECT_EQ(called.points[0].tool, kFlangeName);  // the one that the whole file has
  const std::string branches = "IF X==1 THEN\n$BASE=BASE_DATA[1]\nELSE\n$BASE=BASE_DATA[2]\nENDIF\n";
  EXPECT_THAT(Last(branches + point).untouched, HasSubstr("more than one tool or base"));
  EXPECT_EQ(Last(branches + "$BASE=BASE_DATA[3]\n" + point).frame, "BASE_DATA[3]");
  EXPECT_EQ(Last("IF X==1 THEN\n$BASE=BASE_DATA[2]\nELSE\n$BASE=BASE_DATA[2]\nENDIF\n" + point).frame, "BASE_DATA[2]");
  EXPECT_THAT(Last("SWITCH X\nCASE 1\n$BASE=BASE_DATA[1]\nDEFAULT\n$BASE=BASE_DATA[2]\nENDSWITCH\n" + point).untouched,
              HasSubstr("more than one"));
  EXPECT_THAT(Last("$BASE=BASE_DATA[1]\nLOOP\n" + point + "$BASE=BASE_DATA[2]\nENDLOOP\n").untouched,
              HasSubstr("more than one"));
  EXPECT_EQ(Last("LOOP\n$BASE=BASE_DATA[2]\n" + point + "ENDLOOP\n").frame, "BASE_DATA[2]");
  EXPECT_EQ(Last("IF X==1 THEN\nBAS(#TOOL,1)\nENDIF\nPTP " + kJoints + "\n").other_load, "LOAD_DATA[1]");
}

TEST_F(KrlProgramTest, ExternalAxes) {
  EXPECT_EQ(Last("PTP {" + kPose + ",S 2,T 2,E1 0.0}\n").untouched, "");
  EXPECT_THAT(Last("PTP {" + kPose + ",S 2,T 2,E1 100.0}\n").untouched, HasSubstr("E1 stands at 100.0"));
  EXPECT_THAT(Last("PTP {" + kPose + ",S 2,T 2,E2 RAIL}\n").untouched, HasSubstr("E2"));
  const RobotProgram rail = ReadRobotProgram(Write("r.src", "LIN {" + kPose + "}\n"), 7);
  EXPECT_THAT(rail.points[0].untouched, HasSubstr("more than six joints"));
}

TEST_F(KrlProgramTest, StatusAndTurnInEveryNotation) {
  for (const char* written : {",S 6,T 58}", ",S 'B 110',T 'B 111010'}", ",S 'B110',T 'H3A'}"}) {
    const StatedBranch branch = Last("PTP {" + kPose + written + "\n").branch;
    EXPECT_EQ(branch.wrist_negative, true) << written;
    EXPECT_EQ(branch.wrist_behind, false) << written;
    ASSERT_EQ(branch.ranges.size(), 6U) << written;
    EXPECT_EQ(branch.ranges[1].second.second, 0.0) << written;
    EXPECT_FALSE(branch.from_before) << written;
  }
  for (const char* written : {",S STATE,T 2}", ",S 2,T 'B 12'}"})
    EXPECT_THAT(Last("PTP {" + kPose + written + "\n").untouched, HasSubstr("status or turn")) << written;
}

TEST_F(KrlProgramTest, LinearMotionsKeepTheBranch) {
  const std::string before = "PTP " + kJoints + "\n";
  EXPECT_THAT(Last(before + "LIN {" + kPose + ",S 6,T 58}\n").untouched, HasSubstr("status is another"));
  EXPECT_EQ(Last(before + "LIN {" + kPose + ",S 2,T 2}\n").untouched, "");
  EXPECT_EQ(Last(before + "PTP {" + kPose + ",S 6,T 58}\n").untouched, "");
  EXPECT_THAT(Last("PTP {" + kPose + ",S 2,T 2}\nLIN {" + kPose + ",S 3,T 2}\n").untouched,
              HasSubstr("status is another"));
}

TEST_F(KrlProgramTest, PointsAreFoundHoweverTheyAreWritten) {
  EXPECT_THAT(Last("PL[1]={" + kPose + ",S 2,T 2}\n").untouched, HasSubstr("array"));
  EXPECT_THAT(MotionsOf(Main("PTP" + kJoints + "\nPTP\t{A1\t10,\tA2 -80,A3 100,A4 15,A5 40,A6 25}\n")),
              ElementsAre(HasSubstr("25}"), ::testing::Not(HasSubstr("only some"))));
  const std::string data = "DECL FDAT FP1={TOOL_NO 1,BASE_NO 2,IPO_FRAME #BASE}\n",
                    point = "DECL E6POS XP1={" + kPose + ",S 2,T 2}\n";
  for (const std::string& text : {data + point, point + data}) {
    const RobotProgram program = ReadAs("a.dat", "DEFDAT D\n" + text + "ENDDAT\n");
    EXPECT_EQ(program.points[0].tool, "TOOL_DATA[1]");
    EXPECT_EQ(program.points[0].frame, "BASE_DATA[2]");
  }
}

TEST_F(KrlProgramTest, FramesAreTargetsOnlyOfMotions) {
  const std::string frame = "DECL FRAME F={" + kPose + "}\n", home = "PTP " + kJoints + "\n";
  const auto why = [&](const std::string& body) { return PointNamed(Main(frame + home + body), "F").untouched; };
  EXPECT_EQ(why("LIN F\n"), "");
  EXPECT_THAT(why(""), HasSubstr("no motion"));
  EXPECT_THAT(why("LIN XP1:F\n"), HasSubstr("computed of it"));
  EXPECT_THAT(why("LIN F\n$BASE=F\n"), HasSubstr("computed of it"));
  EXPECT_THAT(why("LIN F\nLIN F:XP1\n"), HasSubstr("computed of it"));
}

TEST_F(KrlProgramTest, ToolsInTheRoom) {
  const std::string point = "PTP {" + kPose + ",S 2,T 2}\n";
  EXPECT_THAT(Last("$IPO_MODE=#TCP\n" + point).untouched, HasSubstr("tool stands in the room"));
  EXPECT_EQ(Last("$IPO_MODE=#TCP\n$IPO_MODE=#BASE\n" + point).untouched, "");
  EXPECT_THAT(Last("IF A THEN\n$IPO_MODE=#TCP\nENDIF\n" + point).untouched, HasSubstr("$IPO_MODE"));
}

// What is set in a loop, by a call in it or below, is not forgotten behind it, and neither is where EXIT leaves it.
TEST_F(KrlProgramTest, LoopsForgetNothing) {
  const std::string point = "PTP {" + kPose + ",S 2,T 2}\n", first = "$TOOL=$NULLFRAME\n$BASE=BASE_DATA[1]\n";
  const auto why = [&](const std::string& body, const std::string& routine = "") {
    return ReadAs("a.src", "DEF MAIN()\n" + first + body + "END\n" + routine).points[0].untouched;
  };
  const std::string sub = "DEF SUB()\n$BASE=BASE_DATA[2]\nEND\n", mode = "DEF SUB()\n$IPO_MODE=#TCP\nEND\n";
  EXPECT_THAT(why("FOR I=1 TO 2\nSUB()\nENDFOR\n" + point, sub), HasSubstr("as the program runs"));
  EXPECT_THAT(why("REPEAT\nSUB()\nUNTIL $IN[1]\n" + point, mode), HasSubstr("$IPO_MODE"));
  EXPECT_THAT(why("WHILE $IN[1]\nL:\nENDWHILE\n" + point + "$BASE=BASE_DATA[2]\nGOTO L\n"),
              HasSubstr("as the program runs"));
  const std::string leave = "IF $IN[1] THEN\nEXIT\nENDIF\n";
  EXPECT_THAT(why("$BASE=BASE_DATA[2]\nLOOP\n$BASE=BASE_DATA[1]\n" + leave + "$BASE=BASE_DATA[2]\nENDLOOP\n" + point),
              HasSubstr("more than one tool or base"));
  EXPECT_EQ(why("FOR I=1 TO 2\n$BASE=BASE_DATA[1]\nENDFOR\n" + point), "");
}

TEST_F(KrlProgramTest, ARoutineStartsWithWhatItsCallsHave) {
  const auto why = [&](const std::string& body) {
    const RobotProgram program =
        ReadAs("a.src", "DEF MAIN()\n$TOOL=$NULLFRAME\n" + body + "END\nDEF SUB()\nPTP {" + kPose + ",S 2,T 2}\nEND\n");
    return PointNamed(program, program.points.back().name).untouched;
  };
  EXPECT_EQ(why("$BASE=BASE_DATA[1]\nSUB()\n"), "");
  EXPECT_NE(why("IF $IN[1] THEN\n$BASE=BASE_DATA[1]\nENDIF\nSUB()\n"), "");
  EXPECT_EQ(PointNamed(ReadAs("a.src",
                              "DEF MAIN()\n$TOOL=$NULLFRAME\nSLIN XP9 WITH $BASE=BASE_DATA[1]\nSUB()\nEND\n"
                              "DEF SUB()\nPTP {" +
                                  kPose + ",S 2,T 2}\nEND\n"),
                       "PTP of line 7")
                .frame,
            "");
  const std::string armed = "INTERRUPT DECL 3 WHEN $IN[1] DO STOPPED()\n$BASE=BASE_DATA[1]\n",
                    stopped = "DEF STOPPED()\n$BASE=BASE_DATA[2]\nEND\n";
  EXPECT_THAT(
      LastOf(ReadAs("a.src", "DEF MAIN()\n" + armed + "PTP {" + kPose + ",S 2,T 2}\nEND\n" + stopped)).untouched,
      HasSubstr("as the program runs"));
}

// BAS sets tool and base by the FDAT of an inline form, or by a number that the text may not state.
TEST_F(KrlProgramTest, ToolAndBaseOfInlineForms) {
  const std::string scene = "$TOOL=TOOL_DATA[1]\n$BASE=BASE_DATA[1]\n", point = "LIN {" + kPose + ",S 2,T 2}\n";
  const std::string data = "DECL FDAT FP2={TOOL_NO 1,BASE_NO 2,IPO_FRAME #BASE}\n";
  EXPECT_EQ(Last(data + scene + "FDAT_ACT=FP2\nBAS(#PTP_PARAMS,100)\n" + point).frame, "BASE_DATA[2]");
  for (const std::string set : {"FDAT_ACT=FP9\nBAS(#PTP_PARAMS,100)\n", "BAS(#CP_PARAMS,2)\n", "BAS(#BASE,NB)\n",
                                "$BASE=BASE_DATA[N]\n", "$BASE=$BASE:OFFS\n", "$BASE.Z=3\n", "B=X\n$BASE=B\n"})
    EXPECT_THAT(Last(scene + set + point).untouched, HasSubstr("decided as the program runs")) << set;
  const RobotProgram block =
      Main(scene + "SPLINE WITH $BASE = BASE_DATA [ 2 ]\nSPL {" + kPose + "}\nENDSPLINE\n" + point);
  EXPECT_EQ(block.points[0].frame, "BASE_DATA[2]");
  EXPECT_EQ(block.points[1].frame, "BASE_DATA[1]");
}

TEST_F(KrlProgramTest, NumbersOfTheTablesHoldFromTheStartOrNowhere) {
  const std::string frame = "{X 1,Y 2,Z 3,A 0,B 0,C 0}\n",
                    use = "$TOOL=$NULLFRAME\n$BASE=BASE_DATA[1]\nLIN {" + kPose + "}\n";
  EXPECT_EQ(Last("BASE_DATA[1]=" + frame + use).untouched, "");
  for (const std::string& body :
       {"IF $IN[1] THEN\nBASE_DATA[1]=" + frame + "ENDIF\n" + use, use + "BASE_DATA[1]=" + frame,
        "BASE_DATA[1]=" + frame + "I=1\nBASE_DATA[I]=" + frame + use, "BASE_DATA[I]=OTHER\n" + use})
    EXPECT_THAT(Last(body).untouched, HasSubstr("changes BASE_DATA[1]")) << body;
  const std::string twice = "IF $IN[1] THEN\nXA={" + kPose + "}\nELSE\nXA={" + kPose + "}\nENDIF\nLIN XA\n";
  for (const ProgramPoint& point : Main(twice).points) EXPECT_THAT(point.untouched, HasSubstr("more than once"));
  EXPECT_THAT(PointNamed(Main("DECL FRAME SHIFT\nSHIFT={" + kPose + "}\nLIN SHIFT:XQ\n"), "SHIFT").untouched,
              HasSubstr("computed of it"));
}

TEST_F(KrlProgramTest, RoutinesOfOtherFilesAreNamed) {
  const RobotProgram program =
      Main("BAS(#INITMOV,0)\nSUB()\nSETBASE(2)\nSETBASE(3)\nPTP " + kJoints + "\nEND\nDEF SUB()\n");
  EXPECT_EQ(program.calls_elsewhere, (std::map<std::string, int>{{"SETBASE", 4}}));
}

TEST_F(KrlProgramTest, LoadsAndFramesThatTheCodeAssigns) {
  const std::string big = "BIG={M 260,CM {X 80,Y 60,Z 280,A 0,B 0,C 0},J {X 0,Y 0,Z 0}}\n",
                    move = "PTP " + kJoints + "\n";
  const RobotProgram program = Main("DECL LOAD BIG\n" + big + "$LOAD=BIG\n" + move);
  EXPECT_EQ(LastOf(program).load, "BIG");
  ASSERT_EQ(program.loads.count("BIG"), 1U);
  EXPECT_EQ(program.loads.at("BIG").mass, 260.0);
  EXPECT_EQ(Main("DECL LOAD BIG\n" + big + "$LOAD=BIG\n" + move + "BIG.M=5\n").loads.count("BIG"), 0U);
  EXPECT_NE(Last("DECL LOAD BIG\n" + big + "FILL(BIG)\n$LOAD=BIG\n" + move).other_load, "");
  const std::string frame = "DECL FRAME MYT\nMYT={X 60,Y -30,Z 210,A 20,B -15,C 35}\n";
  const std::string pose = "$BASE=$NULLFRAME\n$TOOL=MYT\nPTP {" + kPose + ",S 2,T 2}\n";
  const RobotProgram named = Main(frame + pose);
  EXPECT_EQ(LastOf(named).untouched, "");
  EXPECT_EQ(LastOf(named).tool, "MYT");
  ASSERT_EQ(named.tools.count("MYT"), 1U);
  EXPECT_NEAR(named.tools.at("MYT").translation.z(), 0.21, 1e-12);
  for (const char* change :
       {"MYT.Z=5\n", "MYT=OTHER\n", "CALC(MYT)\n", "IF A THEN\nMYT={X 1,Y 2,Z 3,A 0,B 0,C 0}\nENDIF\n"})
    EXPECT_THAT(Last(frame + change + pose).untouched, HasSubstr("decided as the program runs")) << change;
  EXPECT_EQ(Main(pose).tools.count("MYT"), 0U);  // of another file: it is asked for
  EXPECT_EQ(LastOf(Main(pose)).untouched, "");
}

TEST_F(KrlProgramTest, PointsThatARoutineIsHandedStay) {
  const auto why = [&](const std::string& line, const std::string& below = "") {
    const RobotProgram program =
        ReadAs("a.src", "DEF MAIN( )\nXP1={" + kPose + ",S 2,T 2}\n" + line + "\nPTP XP1\nEND\n" + below);
    return PointNamed(program, "XP1").untouched;
  };
  const std::string routine = "DEF CALC(P:OUT)\nP.Z=P.Z+100\nEND\n";
  EXPECT_THAT(why("CALC(XP1)", routine), HasSubstr("a routine is handed it (line 3)"));
  EXPECT_THAT(why("CALC( 2, XP1.Z )"), HasSubstr("a routine is handed it"));
  EXPECT_THAT(why("TRIGGER WHEN DISTANCE=0 DELAY=0 DO CALC(XP1) PRIO=-1"), HasSubstr("a routine is handed it"));
  for (const char* value : {"", "CALC(XP1.Z+1)", "IF (XP1.Z>3) THEN\nENDIF", "XA=INVERSE(XP1,XHOME,ERR)", "CALC(XP11)"})
    EXPECT_EQ(why(value, routine), "") << value;
}

TEST_F(KrlProgramTest, AbsolutelyAccurateRobotsCorrectThemselves) {
  const std::string scene = "$BASE=$NULLFRAME\n$TOOL=$NULLFRAME\n";
  EXPECT_THAT(Last(scene + "PTP {" + kPose + ",S 18,T 2}\n").untouched, HasSubstr("absolutely accurate"));
  EXPECT_THAT(Last(scene + "$ABS_ACCUR=TRUE\nPTP {" + kPose + ",S 2,T 2}\n").untouched, HasSubstr("$ABS_ACCUR"));
  EXPECT_EQ(Last(scene + "$ABS_ACCUR=FALSE\nPTP {" + kPose + ",S 2,T 2}\n").untouched, "");
  EXPECT_EQ(Last("$ABS_ACCUR=TRUE\nPTP " + kJoints + "\n").untouched, "");
}

TEST_F(KrlProgramTest, LongLinesAreRefusedAndLongCommentsAreNot) {
  const std::string comments = ";" + std::string(100000, 'c') + "\n";
  EXPECT_EQ(Last("FR=$BASE\n" + comments + comments + "PTP " + kJoints + "\n").untouched, "");
  std::string sum = "$BASE=B";
  while (sum.size() < 300000) sum += ": B";
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { Main(sum + "\n"); }), {"a.src:2", "lines"}));
}

}  // namespace
}  // namespace sagitta::krl_program_test

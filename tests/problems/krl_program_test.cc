// KRL: what a program does not say for certain of a point stays as it is, with the reason.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/problems/robot_program_test_support.h"

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
  const RobotProgram called = ReadAs("a.src",
                                     "DEF MAIN()\n$TOOL=$NULLFRAME\n$BASE=BASE_DATA[1]\nSUB()\n"
                                     "$BASE=BASE_DATA[2]\nEND\nDEF SUB()\n" +
                                         point + "END\n");
  EXPECT_EQ(called.points[0].frame, "");
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

}  // namespace
}  // namespace sagitta::krl_program_test

// RAPID: what a program does not say for certain of a point stays as it is, with the reason.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "problems/io/text_checks.h"
#include "tests/problems/io/programs/robot_program_test_support.h"

namespace sagitta::rapid_program_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string Target(const std::string& name, const std::string& external = "9E9") {
  return "CONST robtarget " + name + ":=[[500,117,432],[0.289408322,0.186309935,0.915164453,0.209774775],[0,0,0,0],[" +
         external + ",9E9,9E9,9E9,9E9,9E9]];\n";
}

class RapidProgramTest : public RobotProgramTest {
 protected:
  RobotProgram Module(const std::string& declarations, const std::string& routines) {
    return ReadAs("a.mod", "MODULE M\n" + declarations + routines + "ENDMODULE\n");
  }
  RobotProgram Main(const std::string& body, const std::string& declarations = Target("p1")) {
    return Module(declarations, "PROC main()\n" + body + "ENDPROC\n");
  }
  std::string WhyOf(const std::string& body) { return PointNamed(Main(body), "p1").untouched; }
};

TEST_F(RapidProgramTest, MotionsStandAnywhereInALine) {
  const std::string first = "MoveL p1,v100,fine,tA;\n", two_tools = "more than one tool";
  for (const char* second : {"IF di1=1 MoveL p1,v100,fine,tB;\n", "TEST a\nCASE 1: MoveL p1,v100,fine,tB;\nENDTEST\n",
                             "TEST a\nDEFAULT: MoveL p1,v100,fine,tB;\nENDTEST\n", "label1: MoveL p1,v100,fine,tB;\n",
                             "WaitTime 1; MoveL p1,v100,fine,tB;\n"}) {
    const RobotProgram program = Main(first + second);
    EXPECT_EQ(program.motions.size(), 2U) << second;
    EXPECT_THAT(PointNamed(program, "p1").untouched, HasSubstr(two_tools)) << second;
  }
}

TEST_F(RapidProgramTest, TheToolIsCountedFromTheFront) {
  EXPECT_EQ(PointNamed(Main("MoveLDO p1,v100,fine,tA,do1,1;\n"), "p1").tool, "TA");
  EXPECT_EQ(PointNamed(Main("MoveJGO p1,v100,fine,tA\\WObj:=w1,go1,\\Value:=5;\n"), "p1").frame, "W1");
  EXPECT_EQ(PointNamed(Main("MoveLSync p1,v100,z10,tA,\"pr1\";\n"), "p1").tool, "TA");
  EXPECT_EQ(PointNamed(Main("TriggL p1,v100,gunon,fine,tA;\n"), "p1").tool, "TA");
  EXPECT_THAT(WhyOf("MoveLDO p1,v100,fine,tA,do1,1;\nMoveLDO p1,v100,fine,tB,do1,1;\n"), HasSubstr("one tool"));
  for (const char* chosen : {"MoveL p1,v100,fine,ts{1};\n", "MoveL p1,v100,fine,cell.tool;\n",
                             "MoveL p1,v100,fine,tA\\WObj:=ws{2};\n", "MoveL p1,v100,fine,tA\\WObj?w;\n"})
    EXPECT_THAT(WhyOf(chosen), HasSubstr("chosen as the program runs")) << chosen;
}

TEST_F(RapidProgramTest, InstructionsThatAreNotKnownAreListed) {
  const RobotProgram program = Main(
      "MoveJ p1,v100,fine,tA;\nCapL p1,v100,cap1,z10,tB;\nEGMMoveL e1,p2,v10,z1,tB;\nMoveL p3,v10,z1,tB;\n"
      "q:=p3;\nx:=CalcJointT(p3,tA);\n",
      Target("p1") + Target("p2") + Target("p3"));
  EXPECT_THAT(PointNamed(program, "p1").untouched, HasSubstr("not known as a motion"));
  EXPECT_THAT(PointNamed(program, "p2").untouched, HasSubstr("not known as a motion"));
  EXPECT_EQ(PointNamed(program, "p3").untouched, "");
  EXPECT_EQ(program.motions.size(), 4U);
}

TEST_F(RapidProgramTest, DisplacedPointsStay) {
  const std::string move = "MoveL p1,v100,fine,tA;\n";
  for (const char* set : {"PDispSet frame1;\n", "PDispOn\\ExeP:=pe,ps,tA;\n", "EOffsSet eo;\n", "EOffsOn ps;\n"}) {
    EXPECT_THAT(WhyOf(set + move), HasSubstr("displacement")) << set;
    EXPECT_THAT(WhyOf("IF a THEN\n" + std::string(set) + "ENDIF\n" + move), HasSubstr("displacement")) << set;
  }
  EXPECT_EQ(WhyOf("PDispSet frame1;\nPDispOff;\n" + move), "");
  EXPECT_EQ(WhyOf(move + "PDispSet frame1;\n"), "");
  EXPECT_THAT(WhyOf(move + "PDispOn p1,tA;\n"), HasSubstr("PDispOn computes"));
}

TEST_F(RapidProgramTest, ExternalAxes) {
  const RobotProgram program = Main("", Target("unused") + Target("zero", "0") + Target("track", "100"));
  EXPECT_EQ(PointNamed(program, "unused").untouched, "");
  EXPECT_EQ(PointNamed(program, "zero").untouched, "");
  EXPECT_THAT(PointNamed(program, "track").untouched, HasSubstr("eax_a stands at 100"));
  const RobotProgram rail = ReadRobotProgram(Write("rail.mod", "MODULE M\n" + Target("p1") + "ENDMODULE\n"), 7);
  EXPECT_THAT(PointNamed(rail, "p1").untouched, HasSubstr("more than six joints"));
}

TEST_F(RapidProgramTest, WithoutMonitoringTheNearestSolutionIsMeant) {
  const std::string joint = "MoveJ p1,v100,fine,tA;\n", linear = "MoveL p1,v100,fine,tA;\n";
  const auto is_from_before = [&](const std::string& body) { return PointNamed(Main(body), "p1").branch.from_before; };
  EXPECT_FALSE(is_from_before(linear));
  EXPECT_TRUE(is_from_before("ConfL\\Off;\n" + linear));
  EXPECT_FALSE(is_from_before("ConfL\\Off;\n" + joint));
  EXPECT_TRUE(is_from_before("ConfJ \\Off;\n" + joint));
  EXPECT_FALSE(is_from_before("ConfL\\Off;\nConfL\\On;\n" + linear));
  EXPECT_THAT(WhyOf("ConfL\\Off;\n" + linear + "ConfL\\On;\n" + linear), HasSubstr("with and without"));
  EXPECT_THAT(WhyOf("IF a ConfL\\Off;\n" + linear), HasSubstr("with and without"));
  const RobotProgram called =
      Module(Target("p1"), "PROC main()\ninit;\n" + linear + "ENDPROC\nPROC init()\nConfL\\Off;\nENDPROC\n");
  EXPECT_TRUE(PointNamed(called, "p1").branch.from_before);
  EXPECT_EQ(PointNamed(called, "p1").untouched, "");
}

TEST_F(RapidProgramTest, WhatARoutineGripsHoldsNotInTheNextOne) {
  const std::string piece = "PERS loaddata piece:=[6,[5,-10,40],[1,0,0,0],0,0,0];\n" + Target("p1") + Target("p2");
  const RobotProgram program = Module(
      piece + Target("p3") + Target("p4"),
      "PROC main()\nMoveL p3,v100,fine,tA;\npick;\nMoveL p4,v100,fine,tA;\nplace;\nENDPROC\nPROC place()\nMoveL "
      "p2,v100,fine,tA;\nGripLoad load0;\nENDPROC\nPROC pick()\nGripLoad piece;\nMoveL p1,v100,fine,tA;\nENDPROC\n");
  EXPECT_EQ(PointNamed(program, "p3").load, "TA");
  EXPECT_EQ(PointNamed(program, "p3").other_load, "");
  EXPECT_EQ(PointNamed(program, "p4").other_load, "TA and one that another line sets");
  EXPECT_EQ(PointNamed(program, "p2").other_load, "TA and one that another line sets");
  EXPECT_EQ(PointNamed(program, "p1").load, "TA and PIECE");
  EXPECT_EQ(PointNamed(program, "p1").other_load, "");
  const std::string motion = "MoveL p1,v100,fine,tA;\n";
  EXPECT_EQ(PointNamed(Main("IF a THEN\nGripLoad piece;\nENDIF\n" + motion, piece), "p1").other_load, "TA and PIECE");
  EXPECT_EQ(PointNamed(Main("IF a GripLoad piece;\n" + motion, piece), "p1").other_load, "TA and PIECE");
  EXPECT_EQ(PointNamed(Main("IF a THEN\nGripLoad piece;\nELSE\nGripLoad piece;\nENDIF\n" + motion, piece), "p1").load,
            "TA and PIECE");
  EXPECT_EQ(PointNamed(Main("WHILE a DO\n" + motion + "GripLoad piece;\nENDWHILE\n", piece), "p1").other_load,
            "TA and one that is set further down in the loop");
}

TEST_F(RapidProgramTest, NamesOfARoutineAreItsOwn) {
  const std::string local = "VAR" + Target("p1").substr(5), move = "MoveL p1,v100,fine,";
  const RobotProgram program = Module("", "PROC a()\n" + local + move + "tA;\nENDPROC\nPROC b()\n" + local + move +
                                              "tB;\nENDPROC\n" + "PROC c(robtarget p1)\n" + move + "tC;\nENDPROC\n");
  ASSERT_EQ(program.points.size(), 3U);
  EXPECT_EQ(program.points[0].tool, "TA");
  EXPECT_EQ(program.points[1].tool, "TB");
  EXPECT_EQ(program.points[1].untouched, "");
  EXPECT_THAT(program.points[2].untouched, HasSubstr("handed to the routine"));
}

TEST_F(RapidProgramTest, LinesMayEndWithACarriageReturn) {
  std::string text = "MODULE M\n! a remark\n" + Target("p1") + "PROC main()\nMoveL p1,v100,fine,tA;\nENDPROC\n";
  for (char& c : text) c = c == '\n' ? '\r' : c;
  const RobotProgram program = ReadAs("a.mod", text);
  EXPECT_THAT(MotionsOf(program), ElementsAre("5 MoveL p1"));
  EXPECT_EQ(WithCorrectedPoints(program, {}), text);
  const std::string wide = std::string("\xff\xfe") + "M" + std::string(1, '\0');
  EXPECT_THAT(ErrorOf([&] { ReadAs("b.mod", wide); }), HasSubstr("UTF-16"));
}

TEST_F(RapidProgramTest, LongStretchesAreRead) {
  std::string remarks;
  for (int i = 0; i < 5000; ++i) remarks += "! MoveL p" + std::to_string(i) + ",v100,fine,tA;\n";
  const std::string blanks(300000, ' ');
  EXPECT_EQ(
      PointNamed(Module(remarks + Target("p1"), "PROC main()\nMoveL p1,v100,fine" + blanks + ",tA;\nENDPROC\n"), "p1")
          .tool,
      "TA");
  std::string words;
  while (words.size() < 100000) words += "x y ";
  EXPECT_NE(PointNamed(Main("GripLoad " + words + "\nMoveL p1,v100,fine,tA;\n"), "p1").other_load, "");
  EXPECT_THAT(ErrorOf([&] { Module(Target("p1"), "PROC main(\n" + words + "\nENDPROC\n"); }), HasSubstr("not closed"));
}

// Behind a loop as behind a single call: what the routine has gripped or displaced.
TEST_F(RapidProgramTest, WhatACallInALoopLeaves) {
  const std::string move = "MoveL p1,v100,fine,tA;\n";
  const auto point = [&](const std::string& body, const std::string& routine) {
    return PointNamed(Module(Target("p1"), "PROC main()\n" + body + "ENDPROC\n" + routine + "ENDPROC\n"), "p1");
  };
  const std::string grip = "PROC pick()\nGripLoad piece;\n", shift = "PROC shift()\nPDispSet pz;\n";
  const std::string open = "PROC place()\nGripLoad load0;\nENDPROC\n";
  EXPECT_EQ(point("WHILE a DO\npick;\nENDWHILE\n" + move, open + grip).other_load, "TA and one that another line sets");
  EXPECT_THAT(point("FOR i FROM 1 TO 3 DO\nshift;\nENDFOR\n" + move + "PDispOff;\n", shift).untouched,
              HasSubstr("displacement"));
  // What one branch, a trap, or a later line sets.
  const std::string work = "PROC work()\n" + move;
  EXPECT_EQ(point("IF a THEN\nGripLoad piece;\nENDIF\nwork;\n", work).other_load, "TA and PIECE");
  EXPECT_THAT(point("work;\nConfL\\Off;\nlast;\n", "PROC last()\nENDPROC\n" + work).untouched, "");
  EXPECT_FALSE(point("work;\nConfL\\Off;\nlast;\n", "PROC last()\nENDPROC\n" + work).branch.from_before);
  EXPECT_THAT(point("init;\nwork;\n", "PROC init()\nIF a THEN\nConfL\\Off;\nENDIF\nENDPROC\n" + work).untouched,
              HasSubstr("with and without"));
  EXPECT_NE(PointNamed(Module(Target("p1"),
                              "PROC main()\nGripLoad load0;\n" + move + "ENDPROC\nTRAP tr\nGripLoad piece;\nENDTRAP\n"),
                       "p1")
                .other_load,
            "");
  EXPECT_NE(PointNamed(Module(Target("p1"), "PROC place()\n" + move + "GripLoad load0;\nENDPROC\n"), "p1").other_load,
            "");
}

TEST_F(RapidProgramTest, MotionsWithoutABlankAndJointsThatAreUnused) {
  const RobotProgram program = Main(
      "MoveL[[500,117,432],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tA;\n"
      "MoveExtJ j1,v100,fine;\nGripperClose;\n",
      "CONST jointtarget j1:=[[9E9,9E9,9E9,9E9,9E9,9E9],[100,9E9,9E9,9E9,9E9,9E9]];\n");
  EXPECT_EQ(program.motions.size(), 1U);
  EXPECT_THAT(PointNamed(program, "j1").untouched, HasSubstr("some of the joints"));
  EXPECT_EQ(program.calls_elsewhere.count("GRIPPERCLOSE"), 1U);
  EXPECT_EQ(program.calls_elsewhere.size(), 1U);
}

// By a text that is the name of a routine, by an error handler, or by SetSysData: what hangs there then is not certain.
TEST_F(RapidProgramTest, TheLoadIsSetByWhatIsCalledByName) {
  const std::string data = Target("p1") + "PERS loaddata piece:=[80,[0,0,50],[1,0,0,0],0,0,0];\n" +
                           "PERS tooldata tA:=[TRUE,[[0,0,0],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];\n" +
                           "VAR string sName:=\"grip\";\n";
  const std::string move = "MoveL p1,v100,fine,tA;\n", grip = "ENDPROC\nPROC grip()\nGripLoad piece;\n";
  const auto read = [&](const std::string& body) { return Module(data, "PROC main()\n" + body + "ENDPROC\n"); };
  const auto is_certain = [&](const std::string& body) { return PointNamed(read(body), "p1").other_load.empty(); };
  for (const char* call : {"%\"grip\"%;\n", "IF a = 1 THEN %\"M:GRIP\"%; ENDIF\n", "%\"gri\"+ValToStr(a)%;\n",
                           "IF a = 1 %sName%;\n", "CallByVar sName,1;\n"}) {
    EXPECT_FALSE(is_certain(call + move + grip)) << call;
    EXPECT_TRUE(is_certain(call + move)) << call;
  }
  const std::string numbered = "ENDPROC\nPROC grip12()\nGripLoad piece;\n";
  EXPECT_FALSE(is_certain("CallByVar \"grip\",12;\n" + move + numbered));
  EXPECT_FALSE(is_certain("CallByVar \"grip\",a;\n" + move + numbered));
  EXPECT_TRUE(is_certain("CallByVar \"grip\",1;\n" + move + numbered));
  EXPECT_TRUE(is_certain("%\"drop\"%;\n" + move + grip));
  EXPECT_TRUE(is_certain("TPWrite \"grip\";\n" + move + grip));
  // On the way, while the program goes on.
  EXPECT_FALSE(is_certain(move + "MoveLSync p1,v100,z10,tA,\"grip\";\n" + grip));
  EXPECT_FALSE(is_certain(move + "SMoveJSync p9,v100,z10,tA,\"grip\"\\TLoad:=piece;\n" + grip));
  EXPECT_TRUE(is_certain(move + "MoveLSync p1,v100,z10,tA,\"drop\";\n" + grip));
  EXPECT_FALSE(is_certain(move + "ERROR\nGripLoad piece;\nTRYNEXT;\n"));
  EXPECT_TRUE(is_certain(move + "ERROR\nGripLoad piece;\nRETURN;\n"));
  EXPECT_FALSE(is_certain("SetSysData piece;\n" + move));
  EXPECT_FALSE(is_certain("SetSysData other;\n" + move));
  EXPECT_TRUE(is_certain("SetSysData tA;\n" + move));
  EXPECT_FALSE(is_certain("SetDataVal \"tA\",other;\n" + move));
  EXPECT_TRUE(is_certain("SetDataVal \"tB\",other;\n" + move));
  EXPECT_EQ(read("%\"drop\"%;\n" + move + grip).calls_elsewhere, (std::map<std::string, int>{{"DROP", 7}}));
  EXPECT_EQ(read("%sName%;\n" + move).calls_elsewhere.count("one whose name is computed"), 1U);
  EXPECT_TRUE(read("%\"grip\"%;\n" + move + grip).calls_elsewhere.empty());
}

TEST_F(RapidProgramTest, RoutinesThatSoundLikeInstructionsAreNamed) {
  const RobotProgram program = Main(
      "MoveL p1,v100,fine,tA;\nLoadPart;\nSetGripper 1;\nUnloadTool;\nPathHome;\nMoveHome \"a\",2;\nWaitPick;\n"
      "SetDO do1,1;\nWaitTime 0.5;\nTPWrite \"Done\";\nStopMove;\nTriggIO gun,0\\DOp:=do1,1;\nIDelete i1;\n");
  std::vector<std::string> names;
  for (const auto& [name, line] : program.calls_elsewhere) names.push_back(name);
  EXPECT_THAT(names, ElementsAre("LOADPART", "MOVEHOME", "PATHHOME", "SETGRIPPER", "UNLOADTOOL", "WAITPICK"));
}

TEST_F(RapidProgramTest, TargetsThatNoMotionGoesToStay) {
  const RobotProgram program = Main("MoveL p1,v100,fine,tA;\n", Target("p1") + Target("p2"));
  EXPECT_EQ(PointNamed(program, "p1").untouched, "");
  EXPECT_THAT(PointNamed(program, "p2").untouched, HasSubstr("no motion in this file goes to it"));
  EXPECT_EQ(PointNamed(Module(Target("p1"), ""), "p1").untouched, "");  // motions of other files, all with one tool
}

// Letters of RAPID are those of ISO 8859-1; a file is in it or in UTF-8.
TEST_F(RapidProgramTest, NamesHaveLettersBeyondAscii) {
  const auto declared = [](const std::string& name, const std::string& first) {
    return "CONST jointtarget " + name + ":=[[" + first + ",-80,90,5,20,3],[9E9,9E9,9E9,9E9,9E9,9E9]];\n";
  };
  const std::string utf8[] = {"jH\u00F6he", "jH\u00E4he", "pGr\u00FCn"};
  const std::string latin[] = {"jH\xF6he", "jH\xE4he", "pGr\xFCn"};
  for (const auto* names : {utf8, latin}) {
    const std::string long_offset = "Offs(" + names[2] + ",1000000000,1000000000,1000000" + names[2] + ",0)";
    const RobotProgram program = Main("! " + names[2] + "\nMoveAbsJ " + names[0] + ",v100,fine,tool0;\nMoveAbsJ " +
                                          names[1] + ",v100,fine,tool0;\nMoveL " + names[2] +
                                          ",v100,fine,tool0;\nMoveL " + long_offset + ",v100,fine,tool0;\n",
                                      declared(names[0], "10") + declared(names[1], "20"));
    for (int i = 0; i < 2; ++i) {
      const ProgramPoint point = PointNamed(program, utf8[i]);
      EXPECT_EQ(point.untouched, "");
      ASSERT_EQ(point.numbers.size(), 6U);
      EXPECT_EQ(point.numbers[0].value, 10.0 * (i + 1));
      EXPECT_EQ(program.text.substr(point.numbers[0].begin, 2), i == 0 ? "10" : "20");
    }
    EXPECT_EQ(PointNamed(program, utf8[2]).untouched, kPointElsewhere);
    for (const ProgramMotion& motion : program.motions) EXPECT_EQ(ValidUtf8(motion.name), motion.name);
    for (const ProgramPoint& point : program.points) EXPECT_EQ(ValidUtf8(point.name), point.name);
    EXPECT_EQ(program.motions.size(), 4U);
  }
}

}  // namespace
}  // namespace sagitta::rapid_program_test

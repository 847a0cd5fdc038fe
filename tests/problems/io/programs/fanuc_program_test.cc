// FANUC LS: what a program does not say for certain of a point stays as it is, with the reason.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/problems/io/programs/robot_program_test_support.h"

namespace sagitta::fanuc_program_test {
namespace {

using ::testing::HasSubstr;

class FanucProgramTest : public RobotProgramTest {
 protected:
  std::string WhyOf(const std::string& motions, const std::string& external = "", int joints = 6) {
    const std::string text =
        "/PROG X\n/MN\n" + motions + "/POS\nP[1]{\n   GP1:\n\tUF : 0, UT : 0,\t\tCONFIG : 'F U T, 0, 0, 0'," +
        "\n\tX = 563.9 mm,\tY = 112.9 mm,\tZ = 727.4 mm,\n\tW = 159.8 deg,\tP = 11.2 deg,\tR = -26.8 deg" + external +
        "\n};\n/END\n";
    return PointNamed(ReadRobotProgram(Write("a.ls", text), joints), "P[1]").untouched;
  }
};

TEST_F(FanucProgramTest, DisplacedPointsStay) {
  EXPECT_EQ(WhyOf("   1:L P[1] 100mm/sec FINE    ;\n"), "");
  for (const char* words : {"Offset,PR[1]", "Tool_Offset,PR[2]", "Offset", "VOFFSET,VR[1]", "COORD"})
    EXPECT_THAT(WhyOf("   1:L P[1] 100mm/sec FINE " + std::string(words) + "    ;\n"), HasSubstr("displaced")) << words;
  // With and without.
  EXPECT_THAT(WhyOf("   1:L P[1] 100mm/sec FINE ;\n   2:L P[1] 100mm/sec FINE Offset,PR[1] ;\n"),
              HasSubstr("displaced"));
}

TEST_F(FanucProgramTest, FramesAndToolsThatTheProgramChanges) {
  const std::string move = "   2:L P[1] 100mm/sec FINE ;\n";
  const auto why = [&](const std::string& line) {
    const std::string text =
        "/PROG X\n/MN\n   1:  " + line + " ;\n" + move +
        "/POS\nP[1]{\n   GP1:\n\tUF : 1, UT : 2,\t\tCONFIG : 'F U T, 0, 0, 0',\n\tX = 563.9 mm,\tY = "
        "112.9 mm,\tZ = 727.4 mm,\n\tW = 159.8 deg,\tP = 11.2 deg,\tR = -26.8 deg\n};\n/END\n";
    return PointNamed(ReadAs("a.ls", text), "P[1]").untouched;
  };
  for (const char* line : {"UFRAME[1]=PR[2]", "UFRAME[1:jig] = PR[2]", "UFRAME[R[3]]=PR[2]", "$MNUFRAME[1,1]=PR[2]"})
    EXPECT_THAT(why(line), HasSubstr("the program changes UF1 as it runs")) << line;
  for (const char* line : {"P[1]=LPOS", "P[R[1]]=PR[2]"})
    EXPECT_THAT(why(line), HasSubstr("the program changes P[1] as it runs")) << line;
  EXPECT_EQ(why("P[2]=LPOS"), "");
  for (const char* line : {"UTOOL[2]=PR[2]", "UTOOL[GP1:2]=PR[2]"})
    EXPECT_THAT(why(line), HasSubstr("the program changes UT2 as it runs")) << line;
  for (const char* line : {"UFRAME[2]=PR[2]", "UTOOL[1]=PR[2]", "PR[2]=UFRAME[1]", "!UFRAME[1]=PR[2]", "UFRAME_NUM=1"})
    EXPECT_EQ(why(line), "") << line;
}

TEST_F(FanucProgramTest, MacrosAreNamed) {
  const RobotProgram program = ReadAs(
      "a.ls",
      "/PROG X\n/MN\n   1:J P[1] 100% FINE ;\n   2:  CLOSE_HAND ;\n   3:  Hand 1 open(2,'a') ;\n   4:  WAIT 1.00(sec) "
      ";\n"
      "   5:  IF R[1]=1,CALL GRIP ;\n   6:  LOCK PREG ;\n   7:  COL DETECT ON ;\n   8:  !remark here ;\n   9:  END ;\n "
      " 10:  ;\n"
      "  11:  ENDIF ;\n  12:  R[1]=2 ;\n  13:  LBL[1] ;\n/POS\nP[1]{\n   GP1:\n UF : 0, UT : 0,\n J1= 1 deg, J2= 2 deg,"
      " J3= 3 deg,\n J4= 4 deg, J5= 5 deg, J6= 6 deg\n};\n/END\n");
  EXPECT_EQ(program.calls_elsewhere, (std::map<std::string, int>{{"CLOSE_HAND", 4}, {"HAND 1 OPEN", 5}, {"GRIP", 7}}));
}

TEST_F(FanucProgramTest, ExternalAxes) {
  EXPECT_EQ(WhyOf("", ",\n\tE1=     0.000  mm"), "");
  EXPECT_THAT(WhyOf("", ",\n\tE1=   100.000  mm"), HasSubstr("E1 stands at 100.000"));
  EXPECT_THAT(WhyOf("", "", 7), HasSubstr("more than six joints"));
}

TEST_F(FanucProgramTest, TheSectionOfPositionsBeginsALine) {
  EXPECT_THAT(WhyOf("   1:  ! see section /POS ;\n   2:L P[1] 10mm/sec FINE INC  ;\n"), HasSubstr("incremental"));
}

TEST_F(FanucProgramTest, WhatIsNotUnderstoodStays) {
  for (const char* config : {"'F U T, 0, 0'", "'FUT 000'"}) {
    const std::string text =
        "/PROG X\n/MN\n   1:J P[1] 100% FINE ;\n   2:  CALL GRIP ;\n/POS\nP[1]{\n GP1:\n UF : 0, UT : 0, CONFIG : " +
        std::string(config) +
        ",\n X = 563.9 mm, Y = 112.9 mm, Z = 727.4 mm,\n W = 159.8 deg, P = 11.2 deg, R = -26.8 "
        "deg\n};\n/END\n";
    const RobotProgram program = ReadAs("a.ls", text);
    EXPECT_THAT(program.points[0].untouched, HasSubstr("CONFIG")) << config;
    EXPECT_EQ(program.calls_elsewhere.count("GRIP"), 1U);
  }
  EXPECT_THAT(WhyOf("   1:L P[1] 100mm/sec FINE RTCP ;\n"), HasSubstr("in the room"));
}

TEST_F(FanucProgramTest, APayloadOfABranchIsNotCertain) {
  const auto other = [&](const std::string& lines) {
    const std::string text = "/PROG X\n/MN\n" + lines +
                             "   9:J P[1] 100% FINE ;\n/POS\nP[1]{\n GP1:\n J1= 10 deg, J2= 20 deg, J3= 30 "
                             "deg,\n J4= 1 deg, J5= 4 deg, J6= 5 deg\n};\n/END\n";
    return ReadAs("a.ls", text).points[0].other_load;
  };
  EXPECT_EQ(other("   1:  PAYLOAD[1] ;\n"), "");
  EXPECT_EQ(other("   1:  PAYLOAD[1] ;\n   2:  IF DI[1]=ON,PAYLOAD[2] ;\n"), "PAYLOAD[2]");
  EXPECT_EQ(other("   1:  IF (DI[1]) THEN ;\n   2:  PAYLOAD[1] ;\n   3:  ENDIF ;\n"), "PAYLOAD[1]");
  EXPECT_NE(other("   1:  PAYLOAD[1] ;\n   2:  LBL[1] ;\n"), "");
}

}  // namespace
}  // namespace sagitta::fanuc_program_test

// `sagitta compensate --program`: what it writes, what it says, and what it refuses.
#include <gmock/gmock.h>

#include "tests/tools/program.h"

namespace sagitta::program_command_test {
namespace {

using ::testing::HasSubstr;

class ProgramCommandTest : public test::ProgramTest {
 protected:
  void SetUp() override {
    test::ProgramTest::SetUp();
    ASSERT_EQ(Run({"calibrate", test::Published("kr270/experiment.yaml"), "--out=" + Path("e"), "--quiet"}).status, 0);
  }
  test::Outcome Compensate(const std::vector<std::string>& flags) const {
    std::vector<std::string> arguments = {"compensate", Path("e/estimate.json")};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    return Run(arguments);
  }
};

constexpr char kJoints[] = "DEF P( )\r\nPTP {A1 5,A2 -90,A3 95,A4 0,A5 10,A6 -3.5} ; home\r\nPTP_REL {A1 1}\r\nEND\r\n";

// The joint values of the command for rows of a table, put where the program has them.
TEST_F(ProgramCommandTest, SameCorrectionAsOfATable) {
  Write("p.src", kJoints);
  Write("t.csv", "target,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg\nhome,5,-90,95,0,10,-3.5\n");
  ASSERT_EQ(Compensate({Path("t.csv"), "--out=" + Path("t_out.csv")}).status, 0);
  const test::Outcome done =
      Compensate({"--program=" + Path("p.src"), "--program_out=" + Path("new/p.src"), "--out=" + Path("rows.csv")});
  ASSERT_EQ(done.status, 0) << done.err;
  EXPECT_THAT(done.out, HasSubstr("1 of 2 points corrected"));
  EXPECT_THAT(done.out, HasSubstr("Motions: 1 of 2 go to corrected points"));
  EXPECT_THAT(done.out, HasSubstr("line 3, PTP_REL of line 3"));
  const auto rows = test::Cells(Read("t_out.csv")), of_program = test::Cells(Read("rows.csv"));
  std::string expected = kJoints;
  expected.replace(expected.find("{A1 5"), std::string("{A1 5,A2 -90,A3 95,A4 0,A5 10,A6 -3.5}").size(), "{");
  std::string numbers;
  for (int j = 1; j <= 6; ++j) {
    const std::string column = "q" + std::to_string(j) + "_cmd_deg";
    const double value = std::stod(rows[1][test::Column(rows, column)]);
    EXPECT_NEAR(std::stod(of_program[1][test::Column(of_program, column)]), value, 1e-9);
    char text[32];
    std::snprintf(text, sizeof text, "%.6f", value);
    numbers += (j > 1 ? ",A" : "A") + std::to_string(j) + " " + text;
  }
  expected.insert(expected.find('{') + 1, numbers + "}");
  EXPECT_EQ(Read("new/p.src"), expected);
}

TEST_F(ProgramCommandTest, WhatIsNotStatedIsAskedForAndNothingIsWritten) {
  Write("p.src", "LIN {X 1500,Y 0,Z 1500,A 0,B 90,C 0}\n");
  const std::string program = "--program=" + Path("p.src"), out = "--program_out=" + Path("new/p.src");
  const test::Outcome asked = Compensate({program, out});
  EXPECT_EQ(asked.status, 2);
  for (const char* part : {"p.src", "tool 'default'", "frame 'world'", "--frames_mm_deg"})
    EXPECT_THAT(asked.err, HasSubstr(part));
  const std::vector<std::vector<std::string>> refused = {
      {program},
      {program, "--program_out=" + Path("p.src")},
      {program, out, Path("e/estimate.json")},
      {program, out, "--tools_mm_deg=flange=1,2,3"},
      {program, out, "--start_deg=1,2"},
      {program, out, "--start_deg=0,1e300,0,0,0,0"},
      {"--program=" + Path("absent.src"), out},
      {program, "--tools_mm_deg=default=same", "--frames_mm_deg=world=same", "--program_out=" + Path("x.csv"),
       "--out=" + Path("./x.csv")},
      {Path("e/estimate.json"), "--program_out=" + Path("new/p.src"), "--out=" + Path("x.csv")}};
  for (const std::vector<std::string>& flags : refused) EXPECT_EQ(Compensate(flags).status, 2) << flags.back();
  EXPECT_FALSE(Exists("new"));
  EXPECT_EQ(Read("p.src"), "LIN {X 1500,Y 0,Z 1500,A 0,B 90,C 0}\n");
}

// A program has no columns for a force: the words say what a user can do.
TEST_F(ProgramCommandTest, ALoadOfUnknownWeightIsAskedForByItsName) {
  Write("p.src", kJoints);
  const test::Outcome asked =
      Compensate({"--program=" + Path("p.src"), "--program_out=" + Path("new/p.src"), "--load=V250"});
  EXPECT_EQ(asked.status, 2);
  for (const char* part : {"--load", "what load 'V250' weighs", "loads: {V250: {mass_kg"})
    EXPECT_THAT(asked.err, HasSubstr(part));
  EXPECT_FALSE(Exists("new"));
}

// A motion to a point that stays is listed where it stands, and no offset adopts what is not there.
TEST_F(ProgramCommandTest, NoMotionIsLeftOutOfTheList) {
  Write("p.mod",
        "MODULE M\nCONST robtarget p1:=[[1519,969,888],[1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n"
        "MoveAbsJ [[10,-80,80,0,45,0],[9E9,9E9,9E9,9E9,9E9,9E9]]\\NoEOffs,v100,fine,tool0;\n"
        "MoveL Offs(p1,0,0,100),v100,fine,tool0;\nMoveL p2,v100,fine,tool0;\nMoveL p2,v50,fine,tool0;\nENDMODULE\n");
  const test::Outcome done = Compensate({"--program=" + Path("p.mod"), "--program_out=" + Path("o.mod")});
  ASSERT_EQ(done.status, 0) << done.err;
  for (const char* part :
       {"1 of 3 points corrected", "Motions: 1 of 4 go to corrected points",
        "  line 4, MoveL Offs(p1,0,0,100): p1 stays as it is (line 2)\n",
        "  line 5, p2: this file gives it no numbers\n", "  line 6, MoveL p2: p2 stays as it is (line 5)\n"}) {
    EXPECT_THAT(done.out, HasSubstr(part));
  }
  EXPECT_THAT(done.out, ::testing::Not(HasSubstr("adopts")));
}

TEST_F(ProgramCommandTest, NothingCorrectedIsANumericalFailure) {
  Write("p.src", "LIN {X 9500,Y 0,Z 1500,A 0,B 90,C 0}\n");
  const test::Outcome done = Compensate({"--program=" + Path("p.src"), "--program_out=" + Path("p2.src"),
                                         "--tools_mm_deg=flange=same;default=same",
                                         "--frames_mm_deg=world=same;default=same", "--start_deg=0,-90,90,0,20,0"});
  EXPECT_EQ(done.status, 3) << done.err;
  EXPECT_THAT(done.out, HasSubstr("0 of 1 points corrected"));
  EXPECT_EQ(Read("p2.src"), Read("p.src"));
}

}  // namespace
}  // namespace sagitta::program_command_test

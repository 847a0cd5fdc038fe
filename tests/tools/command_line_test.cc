// The command line itself: help, exit statuses, flags, hints.
#include "tests/tools/program.h"

namespace sagitta::test::command_line_test {
namespace {

using CommandLineTest = ProgramTest;

const std::string kExperiment = Published("kr270/experiment.yaml");

TEST_F(CommandLineTest, HelpAndVersion) {
  for (const std::vector<std::string>& arguments : {std::vector<std::string>{"--help"},
                                                    {"help"},
                                                    {"help", "help"},
                                                    {"help", "calibrate"},
                                                    {"calibrate", "--help"},
                                                    {"--version"}}) {
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.status, 0) << arguments[0];
    EXPECT_NE(outcome.out.find("sagitta"), std::string::npos);
    EXPECT_EQ(outcome.err, "");
  }
}

TEST_F(CommandLineTest, EveryCommandHasHelpWithAnExample) {
  for (const char* command : {"calibrate", "predict", "simulate", "compare", "coverage"}) {
    const Outcome outcome = Run({command, "--help"});
    EXPECT_EQ(outcome.status, 0);
    EXPECT_NE(outcome.out.find("Examples"), std::string::npos) << command;
    EXPECT_NE(outcome.out.find("--out"), std::string::npos) << command;
    EXPECT_EQ(outcome.out, Run({"help", command}).out);
  }
}

TEST_F(CommandLineTest, WithoutCommandIsAUsageError) { EXPECT_EQ(Run({}).status, 2); }

TEST_F(CommandLineTest, UnknownCommandNamesTheNearest) {
  const Outcome outcome = Run({"calibrat"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_NE(outcome.err.find("did you mean 'calibrate'"), std::string::npos) << outcome.err;
  EXPECT_EQ(outcome.out, "");
}

TEST_F(CommandLineTest, UnknownFlagNamesTheNearest) {
  const Outcome outcome = Run({"calibrate", kExperiment, "--sigmamm=0.1", "--out=" + Path("out")});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_NE(outcome.err.find("did you mean '--sigma_mm'"), std::string::npos) << outcome.err;
  EXPECT_FALSE(Exists("out"));
}

TEST_F(CommandLineTest, FlagsOfLibrariesAndOtherCommandsAreNotTaken) {
  for (const char* flag : {"--logtostderr", "--methods=joint", "--flagfile=x"}) {
    EXPECT_EQ(Run({"calibrate", kExperiment, flag}).status, 2) << flag;
  }
}

TEST_F(CommandLineTest, BadValuesAreUsageErrors) {
  for (const char* flag :
       {"--sigma_mm=abc", "--sigma_mm=nan", "--sigma_mm=0", "--sigma_mm=-1", "--seed=-1", "--threads=0",
        "--holdout=1.5", "--validation=group", "--load_point_mm=1,2", "--significance=2", "--method=joynt",
        "--require=fit.rms_mm", "--require=fit.rms_mm<x", "--quiet=maybe", "--free=geometry/p_x11", "--out"}) {
    const Outcome outcome = Run({"calibrate", kExperiment, flag});
    EXPECT_EQ(outcome.status, 2) << flag << outcome.err;
    EXPECT_EQ(outcome.out, "") << flag;
  }
}

// As in --out="$DIR" of a shell that knows no DIR: results would be nowhere, and status 0 would say that all is well.
TEST_F(CommandLineTest, AFlagWithNothingBehindItIsAUsageError) {
  for (const char* command : {"calibrate", "diagnose", "predict", "simulate", "validate", "compare", "inspect",
                              "coverage", "plan", "compensate", "reproduce", "import", "changed"}) {
    for (const std::vector<std::string>& flag : {std::vector<std::string>{"--out="}, {"--out", ""}, {"--out= "}}) {
      std::vector<std::string> arguments = {command, kExperiment};
      arguments.insert(arguments.end(), flag.begin(), flag.end());
      const Outcome outcome = Run(arguments);
      EXPECT_EQ(outcome.status, 2) << command << outcome.err;
      EXPECT_EQ(outcome.out, "") << command;
      EXPECT_NE(outcome.err.find("--out: the flag needs a value"), std::string::npos) << command << outcome.err;
    }
  }
  EXPECT_EQ(Run({"compensate", kExperiment, kExperiment, "--out=" + Path("a"), "--program_out="}).status, 2);
  EXPECT_EQ(Run({"calibrate", kExperiment, "--fixed=", "--out=" + Path("a")}).status, 2);
  EXPECT_FALSE(Exists("a"));
}

TEST_F(CommandLineTest, AnEmptyArgumentIsSaid) {
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"calibrate", ""}, {"calibrate", kExperiment, " "}, {"convert", kExperiment, ""}}) {
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.status, 2) << arguments[0];
    EXPECT_NE(outcome.err.find("sagitta " + arguments[0] + ": an argument is empty"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("hint: sagitta " + arguments[0] + " "), std::string::npos) << outcome.err;
  }
}

TEST_F(CommandLineTest, NoCommandRunsOnNoThread) {
  for (const char* command : {"compare", "inspect", "diagnose"}) {
    EXPECT_EQ(Run({command, kExperiment, "--threads=0"}).status, 2) << command;
  }
}

TEST_F(CommandLineTest, AnUnknownParameterIsAnsweredByItsFamily) {
  const Outcome outcome = Run({"calibrate", kExperiment, "--free=geometry/p_x11"});
  EXPECT_NE(outcome.err.find("known: geometry/p_x1, "), std::string::npos) << outcome.err;
  EXPECT_EQ(outcome.err.find("marker/"), std::string::npos) << outcome.err;
}

// An effect that has two settings has a comma in its name.
TEST_F(CommandLineTest, AParameterWithSettingsIsOneName) {
  for (const char* flag : {"--free=", "--fixed="}) {
    const Outcome outcome =
        Run({"calibrate", kExperiment, std::string(flag) + "effect/backlash[by=torque,width_Nm=30]/A3"});
    EXPECT_EQ(outcome.status, 2);
    EXPECT_NE(outcome.err.find("no parameter 'effect/backlash[by=torque,width_Nm=30]/A3'"), std::string::npos)
        << outcome.err;
  }
}

TEST_F(CommandLineTest, AParameterIsFreeOrFixed) {
  const Outcome outcome =
      Run({"calibrate", kExperiment, "--free=geometry/dq2", "--fixed=geometry/dq2", "--out=" + Path("out")});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_NE(outcome.err.find("'geometry/dq2' is asked to be free and fixed"), std::string::npos) << outcome.err;
  EXPECT_FALSE(Exists("out/estimate.json"));
}

TEST_F(CommandLineTest, BothSpellingsOfAFlagAndTheEndOfFlags) {
  EXPECT_EQ(Run({"calibrate", "--out", Path("a"), "--quiet", "--", kExperiment}).status, 0);
  EXPECT_EQ(Run({"calibrate", kExperiment, "--noquiet", "--out=" + Path("b")}).status, 0);
  EXPECT_TRUE(Exists("a/estimate.json"));
  EXPECT_TRUE(Exists("b/estimate.json"));
  EXPECT_EQ(Run({"calibrate", kExperiment, "--seed=1", "--seed=2"}).status, 2);
}

TEST_F(CommandLineTest, NegativeNumbersAreValues) {
  const Outcome outcome = Run({"calibrate", kExperiment, "--load_point_mm", "-280,0,-5.5"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
}

TEST_F(CommandLineTest, AnExperimentNamesItsOwnMeasurements) {
  const std::string robot = Published("kr270/robot.yaml"), rows = Published("kr270/geometric.csv");
  for (const std::vector<std::string>& files :
       {std::vector<std::string>{kExperiment, rows}, {robot, rows, kExperiment}}) {
    std::vector<std::string> arguments = {"calibrate"};
    arguments.insert(arguments.end(), files.begin(), files.end());
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.status, 2);
    EXPECT_NE(outcome.err.find("names its own robot and measurements"), std::string::npos) << outcome.err;
  }
  EXPECT_EQ(Run({"calibrate", Published("kr270/robot.yaml")}).status, 2);
  EXPECT_EQ(Run({"calibrate"}).status, 2);
}

}  // namespace
}  // namespace sagitta::test::command_line_test

// What the commands do with files: inputs stay, sets are of one run, pipes work, texts are texts.
#include <fcntl.h>
#include <sys/file.h>

#include "problems/io/files.h"
#include "tests/tools/program.h"

namespace sagitta::test::outputs_test {
namespace {

class OutputsTest : public ProgramTest {
 protected:
  const std::string robot_ = Published("kr270/robot.yaml");
  const std::string experiment_ = Published("kr270/experiment.yaml");
  const std::string data_ = Published("kr270/geometric.csv");

  std::string Copy(const std::string& from, const std::string& name) const { return Write(name, ReadAll(from)); }
  int Shell(const std::string& command) const {
    const int status = std::system(("bash -c " + Quoted(command)).c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  static std::string Quoted(const std::string& text) {
    std::string quoted = "'";
    for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return quoted + "'";
  }
  std::string Sagitta(const std::string& arguments) const {
    return Quoted(test::Program()) + " " + arguments + " >" + Quoted(Path("stdout")) + " 2>" + Quoted(Path("stderr"));
  }
  void ExpectInputKept(const std::vector<std::string>& arguments, const std::string& input) const {
    const std::string before = ReadAll(input);
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.status, 2) << arguments[0] << outcome.out;
    EXPECT_NE(outcome.err.find("would be overwritten"), std::string::npos) << arguments[0] << ": " << outcome.err;
    EXPECT_EQ(ReadAll(input), before) << arguments[0];
  }
};

TEST_F(OutputsTest, NoCommandWritesOntoItsInputs) {
  const std::string rows = Copy(data_, "rows.csv"), robot = Copy(robot_, "robot.yaml");
  const std::string experiment =
      Write("e.yaml", "schema: sagitta/experiment/1\nrobot: robot.yaml\nmeasurements: [rows.csv]\n");
  ASSERT_EQ(Run({"calibrate", experiment, "--out=" + Path("out")}).status, 0);
  const std::string estimate = Path("out/estimate.json");
  std::filesystem::create_symlink(rows, Path("link.csv"));
  ExpectInputKept({"simulate", experiment, "--truth=" + estimate, "--out=" + rows}, rows);
  ExpectInputKept({"simulate", experiment, "--truth=" + estimate, "--out=" + Path("link.csv")}, rows);
  ExpectInputKept({"simulate", experiment, "--truth=" + estimate, "--out=" + estimate}, estimate);
  ExpectInputKept({"predict", estimate, rows, "--out=" + rows}, rows);
  ExpectInputKept({"predict", estimate, rows, "--out=" + estimate}, estimate);
  ExpectInputKept({"calibrate", robot, Path("out/residuals.csv"), "--out=" + Path("out")}, Path("out/residuals.csv"));
  ExpectInputKept({"diagnose", robot, Path("out/residuals.csv"), "--out=" + Path("out")}, Path("out/residuals.csv"));
  ExpectInputKept({"validate", estimate, Path("out/residuals.csv"), "--out=" + Path("out")}, Path("out/residuals.csv"));
  ExpectInputKept({"convert", robot, robot}, robot);
  std::filesystem::copy_file(rows, Path("measurements.csv"));
  ExpectInputKept({"import", robot, Path("measurements.csv"), "--out=" + Path("")}, Path("measurements.csv"));
  std::filesystem::copy_file(rows, Path("plan.csv"));
  ExpectInputKept({"plan", robot, Path("plan.csv"), "--poses=3", "--out=" + Path("")}, Path("plan.csv"));
  std::filesystem::copy_file(estimate, Path("changed.json"));
  ExpectInputKept({"changed", estimate, Path("changed.json"), "--out=" + Path("")}, Path("changed.json"));
  std::filesystem::copy_file(rows, Path("coverage.json"));
  ExpectInputKept({"coverage", robot, Path("coverage.json"), "--out=" + Path("")}, Path("coverage.json"));
  const std::string targets = Write("t.csv", "target,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg\nT1,0,0,0,0,0,0\n");
  ExpectInputKept({"compensate", estimate, targets, "--out=" + targets}, targets);
}

TEST_F(OutputsTest, AllFilesOfASetNameTheirRun) {
  ASSERT_EQ(Run({"calibrate", experiment_, "--out=" + Path("out")}).status, 0);
  const std::string run = ReadJson("out/estimate.json")["run"];
  EXPECT_EQ(run.size(), 16u);
  EXPECT_EQ(Read("out/robot.calibrated.yaml").rfind("# run: " + run + "\n", 0), 0u);
  EXPECT_NE(Read("out/report.html").find(run), std::string::npos);
  ASSERT_EQ(Run({"calibrate", experiment_, "--seed=2", "--out=" + Path("out")}).status, 0);
  EXPECT_NE(ReadJson("out/estimate.json")["run"], run);
}

TEST_F(OutputsTest, TwoRunsDoNotShareAFolder) {
  std::filesystem::create_directory(Path("out"));
  const int folder = open(Path("out").c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  ASSERT_EQ(flock(folder, LOCK_EX), 0);
  const Outcome refused = Run({"calibrate", experiment_, "--out=" + Path("out")});
  EXPECT_EQ(refused.status, 2);
  EXPECT_NE(refused.err.find("another run is writing"), std::string::npos) << refused.err;
  close(folder);
  EXPECT_EQ(Run({"calibrate", experiment_, "--out=" + Path("out")}).status, 0);
}

TEST_F(OutputsTest, AFailedRunLeavesNoFolder) {
  EXPECT_EQ(Run({"calibrate", robot_, Path("absent.csv"), "--out=" + Path("a/b")}).status, 2);
  EXPECT_FALSE(Exists("a"));
  EXPECT_EQ(Run({"predict", Path("absent.json"), data_, "--out=" + Path("a/p.csv")}).status, 2);
  EXPECT_FALSE(Exists("a"));
}

TEST_F(OutputsTest, AFullStandardOutputIsSaid) {
  for (const std::string& arguments : {std::string("--version"), "inspect " + Quoted(experiment_)}) {
    EXPECT_EQ(Shell(Quoted(test::Program()) + " " + arguments + " >/dev/full 2>" + Quoted(Path("stderr"))), 2);
    EXPECT_NE(Read("stderr").find("standard output cannot be written"), std::string::npos) << Read("stderr");
  }
}

// What was read is what is hashed, of a pipe too, which can be read once only.
TEST_F(OutputsTest, PipesAreReadOnce) {
  ASSERT_EQ(Shell("cat " + Quoted(data_) + " | " +
                  Sagitta("calibrate " + Quoted(robot_) + " /dev/stdin --out=" + Quoted(Path("out")))),
            0)
      << Read("stderr");
  const auto json = ReadJson("out/estimate.json");
  EXPECT_EQ(json["inputs"][1]["sha256"], Sha256(ReadAll(data_)));
  ASSERT_EQ(Shell(Sagitta("calibrate <(cat " + Quoted(robot_) + ") <(cat " + Quoted(data_) +
                          ") --out=" + Quoted(Path("fifo")))),
            0)
      << Read("stderr");
  EXPECT_EQ(ReadJson("fifo/estimate.json")["inputs"][0]["sha256"], Sha256(ReadAll(robot_)));
}

// The command that stands in the results does again what it did, whatever the files are called.
TEST_F(OutputsTest, TheRecordedCommandIsSafe) {
  const std::string rows = Copy(data_, "it's `touch planted` $(touch planted).csv");
  ASSERT_EQ(Shell(Sagitta("calibrate " + Quoted(robot_) + " " + Quoted(rows) + " --out=" + Quoted(Path("out")))), 0)
      << Read("stderr");
  std::string command = ReadJson("out/estimate.json")["command"];
  ASSERT_EQ(command.rfind("sagitta ", 0), 0u);
  std::filesystem::remove_all(Path("out"));
  EXPECT_EQ(Shell("cd " + Quoted(Path("")) + " && " + Quoted(test::Program()) + command.substr(7) + " >/dev/null"), 0);
  EXPECT_TRUE(Exists("out/estimate.json"));
  EXPECT_FALSE(Exists("planted"));
}

TEST_F(OutputsTest, FormulasAreWrittenAsTexts) {
  auto rows = Cells(ReadAll(data_));
  for (auto& row : rows) row.push_back("=cmd|'/C calc'!A0");
  rows[0].back() = "note";
  const int marker = Column(rows, "marker");
  for (size_t i = 1; i < rows.size(); ++i) rows[i][marker] = "+" + rows[i][marker];
  const std::string file = Write("rows.csv", Csv(rows));
  ASSERT_EQ(Run({"calibrate", robot_, file, "--out=" + Path("out")}).status, 0);
  const auto residuals = Cells(Read("out/residuals.csv"));
  EXPECT_EQ(residuals[1][Column(residuals, "note")], "'=cmd|'/C calc'!A0");
  EXPECT_EQ(residuals[1][Column(residuals, "marker")], "'" + rows[1][marker]);
  EXPECT_EQ(residuals[1][Column(residuals, "x_mm")], rows[1][Column(rows, "x_mm")]);
  // And read back as they were.
  EXPECT_EQ(Run({"predict", Path("out/estimate.json"), Path("out/residuals.csv"), "--out=" + Path("p.csv")}).status, 0);
}

TEST_F(OutputsTest, NothingMovesTheCursor) {
  auto rows = Cells(ReadAll(data_));
  rows[2][Column(rows, "marker")] = "M\x1b[2J";
  const Outcome refused = Run({"calibrate", robot_, Write("m.csv", Csv(rows)), "--out=" + Path("out")});
  EXPECT_EQ(refused.status, 2);
  EXPECT_NE(refused.err.find("m.csv:3"), std::string::npos) << refused.err;
  const Outcome named = Run({"calibrate", robot_, Path("no\x1b[2J.csv"), "--out=" + Path("out")});
  EXPECT_EQ(named.status, 2);
  EXPECT_EQ((refused.err + named.err).find('\x1b'), std::string::npos);
  EXPECT_NE(named.err.find("no\\x1b[2J.csv"), std::string::npos) << named.err;
}

TEST_F(OutputsTest, AReportIsUtf8WhateverAFileIsCalled) {
  const std::string rows = Copy(data_, "a\xFF\x1b.csv");
  ASSERT_EQ(Run({"calibrate", robot_, rows, "--out=" + Path("out")}).status, 0);
  EXPECT_EQ(LineOfInvalidUtf8(Read("out/report.html")), 0);
  EXPECT_EQ(LineOfInvalidUtf8(Read("out/estimate.json")), 0);
  EXPECT_EQ(Read("out/report.html").find('\x1b'), std::string::npos);
}

TEST_F(OutputsTest, CountsAreBounded) {
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"coverage", experiment_, "--trials=2147483647", "--out=" + Path("out")},
        {"plan", experiment_, "--poses=2147483647", "--out=" + Path("out")},
        {"plan", experiment_, "--poses=3", "--pool=2147483647", "--out=" + Path("out")},
        {"calibrate", experiment_, "--threads=2147483647"},
        {"calibrate", experiment_, "--sigma_mm=1e-300"},
        {"calibrate", experiment_, "--sigma_mm=1e308"},
        {"calibrate", robot_, "/dev/zero"}}) {
    const Outcome outcome = Run(command);
    EXPECT_EQ(outcome.status, 2) << command[0] << " " << command.back() << outcome.err;
    EXPECT_FALSE(Exists("out"));
  }
}

}  // namespace
}  // namespace sagitta::test::outputs_test

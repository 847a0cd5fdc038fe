#include <gmock/gmock.h>

#include "tests/support/paths.h"
#include "tests/tools/program.h"

namespace sagitta::test::inspect_test {
namespace {

using ::testing::HasSubstr;

class InspectTest : public ProgramTest {};

// Codes of the serious findings.
std::vector<std::string> Serious(const nlohmann::json& json) {
  std::vector<std::string> codes;
  for (const auto& finding : json["findings"]) {
    if (finding["severity"] == "serious") codes.push_back(finding["code"]);
  }
  return codes;
}

TEST_F(InspectTest, PublishedExperimentIsClean) {
  const Outcome outcome =
      Run({"inspect", Published("kr270/experiment.yaml"), "--out=" + Path("out"), "--quiet", "--require=serious==0"});
  ASSERT_EQ(outcome.status, 0) << outcome.err << outcome.out;
  const nlohmann::json json = ReadJson("out/inspect.json");
  EXPECT_EQ(json["schema"], "sagitta/inspection/1");
  EXPECT_EQ(json["identifiability"]["rank"], json["identifiability"]["unknowns"]);
  EXPECT_EQ(json["parameters"].size(), json["identifiability"]["unknowns"].get<size_t>());
  EXPECT_EQ(json["joints"].size(), 6u);
  EXPECT_EQ(json["leverage"].size(), json["data"]["configurations"].get<size_t>());
  EXPECT_THAT(Read("out/report.html"), HasSubstr("Joint ranges covered"));
  EXPECT_FALSE(Exists("out/estimate.json"));
}

TEST_F(InspectTest, LoadedExperimentIsClean) {
  const Outcome outcome =
      Run({"inspect", Published("kr270/all_stages.yaml"), "--out=" + Path("out"), "--quiet", "--require=serious==0"});
  EXPECT_EQ(outcome.status, 0) << outcome.err << outcome.out;
}

TEST_F(InspectTest, AWrongUnitIsAFindingNotAnError) {
  std::string csv = ReadAll(Published("kr270/geometric.csv"));
  for (char j = '1'; j <= '6'; ++j) {
    const std::string name = std::string("q") + j + "_deg";
    csv.replace(csv.find(name), name.size(), std::string("q") + j + "_rad");
  }
  const std::string path = Write("rad.csv", csv);
  const Outcome outcome = Run({"inspect", Published("kr270/robot.yaml"), path, "--sigma_mm=0.1", "--quiet",
                               "--out=" + Path("out"), "--require=serious==0"});
  EXPECT_EQ(outcome.status, 1) << outcome.err;
  EXPECT_EQ(Serious(ReadJson("out/inspect.json")), std::vector<std::string>{"unit"});
}

TEST_F(InspectTest, RealDataRaiseNoSeriousAlarm) {
  const std::string shared = test::SharedFolder() + "/data/";
  if (!std::filesystem::exists(shared)) GTEST_SKIP() << "the real measurements are not next to this checkout";
  const std::vector<std::vector<std::string>> sets = {
      {shared + "ur5_gts3800/robot.yaml", shared + "ur5_gts3800/measurements.csv"},
      {shared + "ur10_leica/robot.yaml", shared + "ur10_leica/series_B.csv", shared + "ur10_leica/series_D.csv"}};
  for (const auto& set : sets) {
    std::vector<std::string> arguments = {"inspect"};
    arguments.insert(arguments.end(), set.begin(), set.end());
    arguments.insert(arguments.end(), {"--quiet", "--out=" + Path("out")});
    const Outcome outcome = Run(arguments);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const nlohmann::json json = ReadJson("out/inspect.json");
    EXPECT_EQ(Serious(json), std::vector<std::string>{}) << outcome.out;
  }
}

}  // namespace
}  // namespace sagitta::test::inspect_test

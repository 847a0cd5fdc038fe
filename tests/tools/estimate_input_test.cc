// An estimate.json that contradicts itself is refused with file and key, by whatever command reads it.
#include "estimator/results/estimate_json.h"
#include "problems/input_error.h"
#include "tests/tools/program.h"

namespace sagitta::test::estimate_input_test {
namespace {

using Json = nlohmann::ordered_json;

class EstimateInputTest : public ProgramTest {
 protected:
  const std::string data_ = Published("kr270/geometric.csv");

  void SetUp() override {
    ProgramTest::SetUp();
    ASSERT_EQ(Run({"calibrate", Published("kr270/experiment.yaml"), "--out=" + Path("out")}).status, 0);
    good_ = Json::parse(Read("out/estimate.json"));
  }

  Outcome Predict(const std::string& estimate) const {
    return Run({"predict", Write("bad.json", estimate), data_, "--out=" + Path("p.csv")});
  }

  void ExpectRefused(const std::string& estimate, const std::vector<std::string>& words) const {
    const Outcome outcome = Predict(estimate);
    EXPECT_EQ(outcome.status, 2) << words[0] << "\n" << outcome.out;
    for (const std::string& word : words)
      EXPECT_NE(outcome.err.find(word), std::string::npos) << word << "\n" << outcome.err;
    EXPECT_NE(outcome.err.find("bad.json"), std::string::npos) << outcome.err;
    EXPECT_FALSE(Exists("p.csv"));
  }
  template <typename Change>
  void ExpectChangedIsRefused(const Change& change, const std::vector<std::string>& words) const {
    Json json = good_;
    change(json);
    ExpectRefused(json.dump(), words);
  }

  Json good_;
};

TEST_F(EstimateInputTest, ShapesAndValues) {
  ASSERT_EQ(Predict(good_.dump()).status, 0);
  std::filesystem::remove(Path("p.csv"));
  const auto refused = [this](const auto& change, const std::vector<std::string>& words) {
    ExpectChangedIsRefused(change, words);
  };
  refused([](Json& j) { j["parameters"] = Json::object(); }, {"parameters", "list"});
  refused([](Json& j) { j["parameters"] = Json::array(); }, {"parameters", "no parameters"});
  refused([](Json& j) { j["parameters"].push_back(j["parameters"][0]); }, {"parameters[", "twice"});
  refused([](Json& j) { j["parameters"][0]["sigma"] = -0.1; }, {"parameters[0].sigma"});
  refused([](Json& j) { j["parameters"][0]["sigma"] = "0.1"; }, {"parameters[0].sigma"});
  refused([](Json& j) { j["parameters"][0]["unit"] = "furlong"; }, {"parameters[0].unit"});
  refused([](Json& j) { j["parameters"][0].erase("nominal"); }, {"parameters[0].nominal", "missing"});
  refused([](Json& j) { j["parameters"].erase(0); }, {"correlation.names", "none of the parameters"});
  refused([](Json& j) { j["correlation"]["names"][1] = j["correlation"]["names"][0]; }, {"correlation.names[1]"});
  refused([](Json& j) { j["correlation"]["matrix"].erase(0); }, {"correlation.matrix"});
  refused([](Json& j) { j["correlation"]["matrix"][0].erase(0); }, {"correlation.matrix"});
  refused([](Json& j) { j["correlation"]["matrix"][0][1] = 1.5; }, {"correlation.matrix", "row"});
  refused([](Json& j) { j["correlation"]["matrix"][0][1] = nullptr; }, {"correlation.matrix"});
  refused(
      [](Json& j) {
        j["correlation"]["names"].erase(0);
        j["correlation"]["matrix"].erase(0);
        for (Json& row : j["correlation"]["matrix"]) row.erase(0);
      },
      {"correlation.names", "missing"});
  for (const char* status : {"no_convergence", "singular", "equilibrium_diverged", "", "fine"}) {
    refused([status](Json& j) { j["status"] = status; }, {"status", "usable"});
  }
  refused([](Json& j) { j.erase("status"); }, {"status", "missing"});
  refused([](Json& j) { j["stations"] = 3; }, {"stations", "map"});
  refused([](Json& j) { j["model_error"]["factor"] = 0.5; }, {"model_error.factor", "at least 1"});
  refused([](Json& j) { j["model_error"]["between_parts"] = {{1.0}}; }, {"model_error.between_parts"});
  refused([](Json& j) { j["loading"]["gravity"]["direction"] = {0, 0}; }, {"loading.gravity.direction"});
  refused([](Json& j) { j["loading"]["gravity"]["frame"] = "Base"; }, {"loading.gravity.frame", "'Base'", "base"});
  refused([](Json& j) { j["loading"]["torques"] = "measurd"; }, {"loading.torques", "'measurd'", "measured"});
  refused([](Json& j) { j["prediction_noise"]["scale"] = 0; }, {"prediction_noise.scale"});
}

// Rows of the held parameters that do not fit their names were read beyond their end.
TEST(HeldInEstimateTest, RowsFitTheNames) {
  const Json good = Json::parse(ReadAll(SourceFolder() + "/tests/fuzz/corpus/estimate/held.json"));
  ASSERT_EQ(good["held"]["names"].size(), 3u);
  const auto refused = [&good](const auto& change, const std::string& key) {
    Json json = good;
    change(json);
    try {
      ReadEstimateText(json.dump(), "e.json");
    } catch (const InputError& error) {
      return error.where().key.rfind(key, 0) == 0 && error.where().file == "e.json";
    }
    return false;
  };
  EXPECT_NO_THROW(ReadEstimateText(good.dump(), "e.json"));
  EXPECT_TRUE(refused([](Json& j) { j["held"]["names"].push_back("geometry/x"); }, "held."));
  EXPECT_TRUE(refused([](Json& j) { j["held"]["correlation"] = Json::array(); }, "held.correlation"));
  EXPECT_TRUE(refused([](Json& j) { j["held"]["correlation"][0] = {1.0, 2.0, 3.0, 4.0}; }, "held.correlation"));
  EXPECT_TRUE(refused([](Json& j) { j["held"]["correlation"][0][1] = 7.0; }, "held.correlation"));
  EXPECT_TRUE(refused([](Json& j) { j["held"]["slopes"].erase(0); }, "held.slopes"));
  EXPECT_TRUE(refused([](Json& j) { j["held"]["slopes"][0] = Json::array(); }, "held.slopes"));
  EXPECT_TRUE(refused([](Json& j) { j["held"]["slopes"] = 1; }, "held.slopes"));
  EXPECT_TRUE(refused([](Json& j) { j["held"]["sigma"][0] = -1.0; }, "held.sigma"));
  EXPECT_TRUE(refused([](Json& j) { j["held"]["sigma"].erase(0); }, "held.sigma"));
  EXPECT_TRUE(refused([](Json& j) { j["held"]["unit"][0] = "x"; }, "held.unit"));
  EXPECT_TRUE(refused([](Json& j) { j["held"]["estimated_unit"].erase(0); }, "held.estimated_unit"));
  EXPECT_TRUE(refused([](Json& j) { j["held"]["estimated"].erase(0); }, "held.estimated"));
  EXPECT_TRUE(refused([](Json& j) { j["held"]["names"][0] = j["correlation"]["names"][0]; }, "held.names"));
  EXPECT_TRUE(refused([](Json& j) { j["held"]["names"][1] = j["held"]["names"][0]; }, "held.names"));
}

TEST_F(EstimateInputTest, WhatIsNoEstimate) {
  ExpectRefused("", {"not JSON"});
  ExpectRefused("{\"schema\": \"sagitta/estimate/1\"", {"not JSON"});
  ExpectRefused("{}", {"schema", "missing"});
  ExpectRefused("[]", {"estimate is expected"});
  ExpectRefused(std::string(100000, '['), {"64 deep"});
  std::string deep = "{\"schema\": \"sagitta/estimate/1\", \"x\": ";
  for (int i = 0; i < 100000; ++i) deep += "{\"a\":";
  ExpectRefused(deep, {"64 deep"});
}

TEST_F(EstimateInputTest, EveryCommandRefusesAFailure) {
  good_["status"] = "no_convergence";
  const std::string failed = Write("failed.json", good_.dump());
  const std::string targets = Write("t.csv", "target,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg\nT1,0,0,0,0,0,0\n");
  const std::string out = "--out=" + Path("result");
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"predict", failed, data_, out},
        {"compensate", failed, targets, out},
        {"simulate", Published("kr270/robot.yaml"), data_, "--truth=" + failed, out},
        {"validate", failed, data_, out},
        {"changed", failed, failed, out}}) {
    const Outcome outcome = Run(command);
    EXPECT_EQ(outcome.status, 2) << command[0];
    EXPECT_NE(outcome.err.find("failed.json: status"), std::string::npos) << outcome.err;
    EXPECT_FALSE(Exists("result")) << command[0];
  }
}

TEST_F(EstimateInputTest, DeepStateOfACoverageRun) {
  std::filesystem::create_directory(Path("cov"));
  Write("cov/coverage.state.jsonl", std::string(100000, '[') + "\n");
  const Outcome outcome = Run({"coverage", Published("kr270/experiment.yaml"), "--trials=2", "--out=" + Path("cov")});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_NE(outcome.err.find("state of a coverage run"), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace sagitta::test::estimate_input_test

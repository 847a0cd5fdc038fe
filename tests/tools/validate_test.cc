#include <gmock/gmock.h>

#include "tests/tools/program.h"

namespace sagitta::test {
namespace {

using ::testing::HasSubstr;

class ValidateTest : public ProgramTest {
 protected:
  // Calibrates with a part held out and writes that part to a file of its own.
  void SetUp() override {
    ProgramTest::SetUp();
    ASSERT_EQ(Run({"calibrate", Published("kr270/experiment.yaml"), "--holdout=0.3", "--seed=1", "--quiet",
                   "--out=" + Path("fit")})
                  .status,
              0);
    const auto rows = Cells(Read("fit/residuals.csv"));
    const int set = Column(rows, "set");
    std::vector<std::vector<std::string>> unseen = {rows[0]};
    for (size_t r = 1; r < rows.size(); ++r) {
      if (rows[r][set] == "validation") unseen.push_back(rows[r]);
    }
    ASSERT_GT(unseen.size(), 3u);
    Write("unseen.csv", Csv(unseen));
  }
};

// calibrate's own hold-out figures come from the estimate in memory, these from its file.
TEST_F(ValidateTest, FiguresAreThoseOfTheHoldOut) {
  const Outcome outcome =
      Run({"validate", Path("fit/estimate.json"), Path("unseen.csv"), "--out=" + Path("out"), "--quiet"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const nlohmann::json held_out = ReadJson("fit/estimate.json")["validation"];
  const nlohmann::json validation = ReadJson("out/validation.json")["validation"];
  EXPECT_EQ(validation["observations"], held_out["observations"]);
  for (const char* key : {"rms_mm", "max_mm", "distance_rms_mm", "distance_max_mm", "predicted_rms_mm"}) {
    EXPECT_NEAR(validation[key].get<double>(), held_out[key].get<double>(), 1e-7) << key;
  }
  for (const char* key : {"rms_mm", "distance_max_mm"}) {
    EXPECT_NEAR(validation["before"][key].get<double>(), held_out["before"][key].get<double>(), 1e-7) << key;
  }
  EXPECT_LT(validation["rms_mm"].get<double>(), validation["before"]["rms_mm"].get<double>());
  EXPECT_THAT(Read("out/report.html"), HasSubstr("validation"));
  EXPECT_THAT(Read("out/residuals.csv"), HasSubstr("res_x_mm"));
}

TEST_F(ValidateTest, RequirementsAndSeenDataAreSaid) {
  const std::string estimate = Path("fit/estimate.json");
  EXPECT_EQ(Run({"validate", estimate, Path("unseen.csv"), "--require=validation.rms_mm<1e-9"}).status, 1);
  EXPECT_EQ(Run({"validate", estimate, Path("unseen.csv"), "--require=validation.rms_mm<10"}).status, 0);
  const Outcome seen = Run({"validate", estimate, Published("kr270/geometric.csv")});
  EXPECT_THAT(seen.out, HasSubstr("is an input of the estimate"));
}

TEST_F(ValidateTest, WhatIsNotKnownIsRefused) {
  std::string text = Read("unseen.csv");
  const auto rows = Cells(text);
  auto other = rows;
  other[1][Column(rows, "marker")] = "P9";
  Write("other.csv", Csv(other));
  const Outcome outcome = Run({"validate", Path("fit/estimate.json"), Path("other.csv"), "--out=" + Path("out")});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_THAT(outcome.err, HasSubstr("no point of marker 'P9'"));
  EXPECT_FALSE(Exists("out/validation.json"));
  EXPECT_EQ(Run({"validate", Path("fit/estimate.json")}).status, 2);
}

}  // namespace
}  // namespace sagitta::test

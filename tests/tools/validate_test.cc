#include <gmock/gmock.h>

#include "tests/support/measured_arms.h"
#include "tests/tools/program.h"

namespace sagitta::test::validate_test {
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

// The columns of calibrate's own, which the rows bring along, are made anew: of rows that were not fitted.
// A second validation replaces its own files alone, the first one the report of the estimate.
TEST_F(ValidateTest, WhatItReplacesInTheFolderOfTheEstimateIsSaid) {
  const auto validate = [this](const char* folder) {
    return Run({"validate", Path("fit/estimate.json"), Path("unseen.csv"), "--out=" + Path(folder), "--quiet"});
  };
  EXPECT_EQ(validate("out").err, "");
  EXPECT_EQ(validate("out").err, "");
  EXPECT_THAT(validate("fit").err, HasSubstr("report.html and residuals.csv of the estimate"));
}

TEST_F(ValidateTest, ResidualsHaveTheColumnsOfTheContract) {
  const std::string rows = Path("unseen.csv");
  ASSERT_EQ(Run({"validate", Path("fit/estimate.json"), rows, "--out=" + Path("out"), "--quiet"}).status, 0);
  const auto before = Cells(Read("unseen.csv")), after = Cells(Read("out/residuals.csv"));
  ASSERT_EQ(after.size(), before.size());
  for (size_t r = 1; r < after.size(); ++r) {
    for (const char* name : {"whitened_x", "whitened_y", "whitened_z"}) {
      const double expected = std::stod(before[r][Column(before, name)]);
      EXPECT_NEAR(std::stod(after[r][Column(after, name)]), expected, 1e-5 * (1.0 + std::abs(expected))) << r << name;
    }
    EXPECT_EQ(std::stod(after[r][Column(after, "leverage")]), 0.0);
    EXPECT_EQ(after[r][Column(after, "set")], "validation");
  }
}

TEST_F(ValidateTest, RequirementsAndSeenDataAreSaid) {
  const std::string estimate = Path("fit/estimate.json");
  EXPECT_EQ(Run({"validate", estimate, Path("unseen.csv"), "--require=validation.rms_mm<1e-9"}).status, 1);
  EXPECT_EQ(Run({"validate", estimate, Path("unseen.csv"), "--require=validation.rms_mm<10"}).status, 0);
  const Outcome seen = Run({"validate", estimate, Published("kr270/geometric.csv")});
  EXPECT_THAT(seen.out, HasSubstr("is an input of the estimate"));
}

// What rows say that the robot cannot have made: of another arm (a UR10 whose kinematics is written out in
// tests/support/measured_arms.h), of another place, read in another way.
class OtherReadingsTest : public ValidateTest {
 protected:
  using Rows = std::vector<std::vector<std::string>>;
  Rows Unseen() const { return Cells(Read("unseen.csv")); }
  // Rows whose point is `change` of joint values (rad) and point (mm).
  Rows Changed(
      const std::function<Vector3<double>(const Eigen::VectorXd& q, const Vector3<double>& p)>& change,
      const std::function<bool(const std::string& marker)>& which = [](const std::string&) { return true; }) {
    Rows rows = Unseen();
    for (size_t r = 1; r < rows.size(); ++r) {
      if (!which(rows[r][Column(rows, "marker")])) continue;
      Eigen::VectorXd q(6);
      for (int j = 0; j < 6; ++j)
        q[j] = std::stod(rows[r][Column(rows, "q" + std::to_string(j + 1) + "_deg")]) * kDegree;
      Vector3<double> p;
      for (int i = 0; i < 3; ++i) p[i] = std::stod(rows[r][Column(rows, std::string(1, "xyz"[i]) + "_mm")]);
      p = change(q, p);
      for (int i = 0; i < 3; ++i) rows[r][Column(rows, std::string(1, "xyz"[i]) + "_mm")] = std::to_string(p[i]);
    }
    return rows;
  }
  // Both commands end with status 2 and these words, and nothing is written; --force goes on and says it all the same.
  void ExpectRefused(const Rows& rows, const std::vector<std::string>& words) {
    const std::string file = Write("other.csv", Csv(rows)), estimate = Path("fit/estimate.json");
    for (const Outcome& outcome : {Run({"validate", estimate, file, "--out=" + Path("out")}),
                                   Run({"predict", estimate, file, "--out=" + Path("other_predicted.csv")})}) {
      EXPECT_EQ(outcome.status, 2) << outcome.out;
      EXPECT_THAT(outcome.err, HasSubstr("the robot of this estimate cannot have made these readings"));
      EXPECT_THAT(outcome.err, HasSubstr("--force"));
      for (const std::string& word : words) EXPECT_THAT(outcome.err, HasSubstr(word));
    }
    EXPECT_FALSE(Exists("out/validation.json"));
    EXPECT_FALSE(Exists("other_predicted.csv"));
    const Outcome forced = Run({"validate", estimate, file, "--force", "--out=" + Path("forced")});
    EXPECT_EQ(forced.status, 0) << forced.err;
    EXPECT_THAT(forced.out, HasSubstr("cannot have made these readings"));
    EXPECT_THAT(forced.out, ::testing::Not(HasSubstr("Within ")));
    EXPECT_THAT(ReadJson("forced/validation.json")["warnings"].dump(), HasSubstr(words.front()));
    EXPECT_EQ(Run({"predict", estimate, file, "--force", "--out=" + Path("forced.csv")}).status, 0);
  }
};

TEST_F(OtherReadingsTest, OfAnotherRobot) {
  ExpectRefused(Changed([](const Eigen::VectorXd& q, const Vector3<double>&) -> Vector3<double> {
                  Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
                  for (int j = 0; j < 6; ++j) pose = pose * Link(Ur10Rows()[j], q[j]);
                  return 1e3 * (pose * Eigen::Vector4d(0.03, -0.02, 0.06, 1)).head<3>();
                }),
                {"this is not the robot of the estimate, or these are not its readings"});
}

TEST_F(OtherReadingsTest, OfAnotherPlace) {
  const Eigen::AngleAxisd turn(0.4, Eigen::Vector3d(0.1, 0.2, 1.0).normalized());
  ExpectRefused(Changed([&](const Eigen::VectorXd&, const Vector3<double>& p) -> Vector3<double> {
                  return turn * p + Vector3<double>(300, -50, 20);
                }),
                {"stands elsewhere", "calibrate the new place"});
}

// By how much is the median: some rows that are off by more do not move it.
TEST_F(OtherReadingsTest, OfOneMarkerThatWasMoved) {
  int row = 0;
  ExpectRefused(Changed([&row](const Eigen::VectorXd&, const Vector3<double>& p)
                            -> Vector3<double> { return p + Vector3<double>(0, 0, ++row % 4 == 0 ? 400.0 : 60.5); },
                        [](const std::string& marker) { return marker == "P2"; }),
                {"marker 'P2' from station", "off by 60."});
}

TEST_F(OtherReadingsTest, InAnotherUnit) {
  ExpectRefused(Changed([](const Eigen::VectorXd&, const Vector3<double>& p) -> Vector3<double> { return p / 1e3; }),
                {"metres"});
}

// One bad row is no other robot; it is said where it spoils the figures.
TEST_F(OtherReadingsTest, OneRowIsNamedAndNotRefused) {
  Rows rows = Unseen();
  rows[3][Column(rows, "x_mm")] = std::to_string(std::stod(rows[3][Column(rows, "x_mm")]) + 500.0);
  const Outcome outcome =
      Run({"validate", Path("fit/estimate.json"), Write("bad.csv", Csv(rows)), "--out=" + Path("out")});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const std::string warnings = ReadJson("out/validation.json")["warnings"].dump();
  EXPECT_THAT(warnings, HasSubstr("1 of " + std::to_string(rows.size() - 1) + " rows is off by more than"));
  EXPECT_THAT(warnings, HasSubstr("bad.csv:4 by 500 mm"));
  rows[6][Column(rows, "y_mm")] = std::to_string(std::stod(rows[6][Column(rows, "y_mm")]) - 700.0);
  ASSERT_EQ(Run({"validate", Path("fit/estimate.json"), Write("bad.csv", Csv(rows)), "--out=" + Path("two")}).status,
            0);
  EXPECT_THAT(ReadJson("two/validation.json")["warnings"].dump(),
              HasSubstr("2 of " + std::to_string(rows.size() - 1) + " rows are off by more than"));
}

// A robot that is only worse than its file: said, and no input error.
TEST_F(OtherReadingsTest, WorseThanNominalIsSaid) {
  const Outcome good = Run({"validate", Path("fit/estimate.json"), Path("unseen.csv")});
  EXPECT_THAT(good.out, ::testing::Not(HasSubstr("by more than the nominal one")));
  // Where the nominal robot would be.
  ASSERT_EQ(Run({"calibrate", Published("kr270/experiment.yaml"), "--fixed=geometry", "--holdout=0.3", "--seed=1",
                 "--out=" + Path("nominal")})
                .status,
            0);
  ASSERT_EQ(Run({"predict", Path("nominal/estimate.json"), Path("unseen.csv"), "--out=" + Path("nominal.csv")}).status,
            0);
  const Rows predicted = Cells(Read("nominal.csv"));
  Rows rows = Unseen();
  for (const char* axis : {"x_mm", "y_mm", "z_mm"}) {
    for (size_t r = 1; r < rows.size(); ++r)
      rows[r][Column(rows, axis)] = predicted[r][Column(predicted, std::string("pred_") + axis)];
  }
  const Outcome worse = Run({"validate", Path("fit/estimate.json"), Write("worse.csv", Csv(rows))});
  EXPECT_EQ(worse.status, 0) << worse.err;
  EXPECT_THAT(worse.out, HasSubstr("the calibrated robot misses these points by more than the nominal one"));
}

// Joint 1 slipped by half a milliradian: points turn about the base's z (the base frame is the station's but for 0.1 mm
// and 0.1 mrad), by a millimetre where a tenth was predicted.
TEST_F(OtherReadingsTest, ASlippedJointRefutesTheEstimate) {
  const Outcome good = Run({"validate", Path("fit/estimate.json"), Path("unseen.csv"), "--out=" + Path("good")});
  EXPECT_THAT(good.out, ::testing::Not(HasSubstr("refute")));
  EXPECT_THAT(good.out, HasSubstr("Within "));
  const nlohmann::json of_good = ReadJson("good/validation.json");
  EXPECT_FALSE(of_good["validation"]["refuted"].get<bool>());
  EXPECT_GT(of_good["validation"]["prediction_p_value"].get<double>(), 0.01);
  const Eigen::AngleAxisd turn(5e-4, Eigen::Vector3d::UnitZ());
  const Rows rows =
      Changed([&](const Eigen::VectorXd&, const Vector3<double>& p) -> Vector3<double> { return turn * p; });
  const Outcome slipped =
      Run({"validate", Path("fit/estimate.json"), Write("slipped.csv", Csv(rows)), "--out=" + Path("slipped")});
  EXPECT_EQ(slipped.status, 0) << slipped.err;
  EXPECT_THAT(slipped.out, HasSubstr("these rows refute the estimate"));
  EXPECT_THAT(slipped.out, HasSubstr("Off by "));
  const nlohmann::json json = ReadJson("slipped/validation.json");
  EXPECT_TRUE(json["validation"]["refuted"].get<bool>());
  EXPECT_LT(json["validation"]["prediction_p_value"].get<double>(), 1e-10);
  EXPECT_NEAR(json["validation"]["excess"].get<double>(),
              json["validation"]["rms_mm"].get<double>() / json["validation"]["predicted_rms_mm"].get<double>(), 1e-9);
  EXPECT_THAT(json["warnings"].dump(), HasSubstr("these rows refute the estimate"));
}

// Placeholders where none are asked for; validate asks for points.
TEST_F(OtherReadingsTest, PointsOfZeroAreAbsentForPredict) {
  const std::string file =
      Write("zero.csv",
            Csv(Changed([](const Eigen::VectorXd&, const Vector3<double>&) { return Vector3<double>(0, 0, 0); })));
  EXPECT_EQ(Run({"predict", Path("fit/estimate.json"), file, "--out=" + Path("zero_predicted.csv")}).status, 0);
  const Outcome validated = Run({"validate", Path("fit/estimate.json"), file});
  EXPECT_EQ(validated.status, 2);
  EXPECT_THAT(validated.err, HasSubstr("all the same"));
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
}  // namespace sagitta::test::validate_test

// What the commands write: complete, consistent, and readable by the next one.
#include <gmock/gmock.h>

#include <cmath>
#include <map>
#include <sstream>

#include "tests/tools/program.h"

namespace sagitta::test::results_test {
namespace {

class ResultsTest : public ProgramTest {
 protected:
  const std::string experiment_ = Published("kr270/experiment.yaml");
  const std::string robot_ = Published("kr270/robot.yaml");
  const std::string data_ = Published("kr270/geometric.csv");
};

TEST_F(ResultsTest, CalibrateWritesFourFilesThatAgree) {
  ASSERT_EQ(Run({"calibrate", experiment_, "--holdout=0.3", "--out=" + Path("out")}).status, 0);
  const auto estimate = ReadJson("out/estimate.json");
  EXPECT_EQ(estimate["status"], "converged");
  EXPECT_EQ(estimate["inputs"].size(), 3);
  const auto rows = Cells(Read("out/residuals.csv"));
  double squares = 0.0;
  int coordinates = 0;
  for (size_t i = 1; i < rows.size(); ++i) {
    for (const std::string axis : {"x", "y", "z"}) {
      const double measured = std::stod(rows[i][Column(rows, axis + "_mm")]);
      const double predicted = std::stod(rows[i][Column(rows, "pred_" + axis + "_mm")]);
      const double residual = std::stod(rows[i][Column(rows, "res_" + axis + "_mm")]);
      EXPECT_NEAR(measured - predicted, residual, 1e-9);
      EXPECT_NEAR(std::stod(rows[i][Column(rows, "whitened_" + axis)]), residual / 0.1, 1e-9);
      if (rows[i][Column(rows, "set")] != "calibration") continue;
      squares += residual * residual;
      ++coordinates;
    }
  }
  EXPECT_EQ(coordinates, 3 * estimate["fit"]["observations"].get<int>());
  EXPECT_NEAR(std::sqrt(squares / coordinates), estimate["fit"]["rms_mm"].get<double>(), 1e-9);
  EXPECT_NE(Read("out/report.html").find("</html>"), std::string::npos);
}

// The table as people read it: nominal + correction = calibrated, against the robot file and estimate.json.
TEST_F(ResultsTest, TheParameterTableShowsNominalCorrectionAndCalibratedValue) {
  const Outcome outcome = Run({"calibrate", experiment_, "--out=" + Path("out")});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const size_t start = outcome.out.find("\nParameters\n");
  ASSERT_NE(start, std::string::npos);
  std::istringstream lines(outcome.out.substr(start + 12));
  std::string line;
  std::getline(lines, line);
  EXPECT_THAT(line, ::testing::MatchesRegex(" *name +nominal +correction +calibrated +± +unit"));
  const auto estimate = ReadJson("out/estimate.json");
  std::map<std::string, nlohmann::json> stated;
  for (const auto& parameter : estimate["parameters"]) stated[parameter["name"]] = parameter;
  // Lengths of the robot file (paper 002, Table II), mm: where the errors sit.
  const std::map<std::string, double> nominal = {
      {"geometry/p_x1", 350.0}, {"geometry/p_x2", 1250.0}, {"geometry/dq2", 0.0}};
  int seen = 0;
  while (std::getline(lines, line) && line.find("±:") == std::string::npos) {
    std::istringstream cells(line);
    std::string name, half, unit;
    double before = 0.0, correction = 0.0, after = 0.0;
    cells >> name >> before >> correction >> after >> half >> unit;
    ASSERT_EQ(stated.count(name), 1u) << line;
    const double value = stated[name]["value"], rounding = 2e-3 * std::stod(half) + 1e-9;
    const double digits = 0.06 * std::stod(half);  // two digits of ± are shown
    EXPECT_NEAR(before + correction, after, 2 * digits) << line;
    EXPECT_NEAR(correction, value - stated[name]["nominal"].get<double>(), digits) << line;
    EXPECT_NEAR(2.0 * std::stod(half), stated[name]["ci95"][1].get<double>() - stated[name]["ci95"][0].get<double>(),
                2 * digits + rounding);
    EXPECT_EQ(unit, stated[name]["unit"]) << line;
    if (nominal.count(name) == 0) continue;
    EXPECT_NEAR(before, nominal.at(name), digits) << line;
    ++seen;
  }
  EXPECT_EQ(seen, 3);
  EXPECT_THAT(outcome.out, ::testing::HasSubstr("coverage factor k = 2"));
}

// Where a pose was visited again its repeatability has the name that the standard gives it.
TEST_F(ResultsTest, AccuracyAndRepeatabilityHaveTheNamesOfIso9283) {
  auto rows = Cells(ReadAll(data_));
  const size_t n = rows.size();
  rows[0].push_back("visit");
  for (size_t i = 1; i < n; ++i) rows[i].push_back("1");
  const auto arrive = [&](const char* visit, double off) {
    for (size_t i = 1; i < n; ++i) {
      std::vector<std::string> again = rows[i];
      again.back() = visit;
      again[Column(rows, "z_mm")] = std::to_string(std::stod(again[Column(rows, "z_mm")]) + off);
      rows.push_back(again);
    }
  };
  arrive("2", 0.2);
  const Outcome twice =
      Run({"calibrate", robot_, Write("twice.csv", Csv(rows)), "--sigma_mm=0.1", "--out=" + Path("twice")});
  ASSERT_EQ(twice.status, 0) << twice.err;
  const auto none = ReadJson("twice/estimate.json")["iso9283"];
  EXPECT_TRUE(none["rp_mm"].is_null()) << "two arrivals are equally far from their mean";
  EXPECT_THAT(none["rp_words"].get<std::string>(), ::testing::HasSubstr("visited more than twice"));
  EXPECT_THAT(twice.out, ::testing::HasSubstr("no pose was visited more than twice"));
  arrive("3", 0.1);
  const Outcome outcome =
      Run({"calibrate", robot_, Write("thrice.csv", Csv(rows)), "--sigma_mm=0.1", "--out=" + Path("out")});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto iso = ReadJson("out/estimate.json")["iso9283"];
  // Arrivals at 0, 0.1 and 0.2 mm: 0.1, 0 and 0.1 mm from their barycentre; mean 0.0667, S = sqrt(0.01 / 3) mm.
  EXPECT_EQ(iso["rp_mm"]["poses"], 18);
  EXPECT_EQ(iso["rp_mm"]["positions"], n - 1);  // three markers
  EXPECT_NEAR(iso["rp_mm"]["max"].get<double>(), 0.2 / 3.0 + 3.0 * std::sqrt(0.01 / 3.0), 2e-5);
  EXPECT_NEAR(iso["rp_mm"]["mean"].get<double>(), 0.2 / 3.0 + 3.0 * std::sqrt(0.01 / 3.0), 2e-5);
  EXPECT_EQ(iso["ap_mm"]["poses"], 18);
  EXPECT_EQ(iso["ap_mm"]["positions"], n - 1);
  EXPECT_GT(iso["ap_mm"]["max"].get<double>(), iso["ap_mm"]["mean"].get<double>());
  EXPECT_THAT(outcome.out, ::testing::HasSubstr("repeatability RP 0.240 mm in the mean"));
  ASSERT_EQ(Run({"calibrate", experiment_, "--out=" + Path("once")}).status, 0);
  EXPECT_TRUE(ReadJson("once/estimate.json")["iso9283"]["rp_mm"].is_null());
}

// The steps of the folds are those of the joint fit: under another method's name their figures would be another
// estimate's, better than what the method fits.
TEST_F(ResultsTest, AMethodIsNotCrossValidatedByAnother) {
  for (const std::string method : {"full-pose", "two-step-literal"}) {
    const Outcome outcome = Run({"calibrate", experiment_, "--method=" + method, "--out=" + Path(method)});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const Outcome required = Run({"calibrate", experiment_, "--method=" + method, "--out=" + Path("required"),
                                  "--require=cross_validation.distance_rms_mm<1000"});
    EXPECT_EQ(required.status, 2) << required.out;
    const auto estimate = ReadJson(method + "/estimate.json");
    EXPECT_TRUE(estimate["cross_validation"]["distance_rms_mm"].is_null());
    EXPECT_THAT(estimate["cross_validation"]["not_run"].get<std::string>(), ::testing::HasSubstr("--holdout"));
    EXPECT_FALSE(estimate["verdict"]["trusted"].get<bool>());
    EXPECT_EQ(outcome.out.find("10-fold"), std::string::npos);
  }
  const Outcome held_out =
      Run({"calibrate", experiment_, "--method=full-pose", "--holdout=0.3", "--out=" + Path("part")});
  ASSERT_EQ(held_out.status, 0) << held_out.err;
  const auto part = ReadJson("part/estimate.json");
  EXPECT_THAT(part["verdict"]["words"].get<std::string>(), ::testing::HasSubstr("On poses it has not seen"));
  EXPECT_FALSE(part["validation"]["distance_p95_mm"].is_null());
  for (const std::string method : {"joint", "two-step"}) {
    ASSERT_EQ(Run({"calibrate", experiment_, "--method=" + method, "--out=" + Path(method)}).status, 0);
    const auto cross_validation = ReadJson(method + "/estimate.json")["cross_validation"];
    EXPECT_EQ(cross_validation["folds"], 10);
    EXPECT_EQ(cross_validation["not_run"], "");
    EXPECT_GT(cross_validation["distance_rms_mm"].get<double>(), 0.0);
  }
}

TEST_F(ResultsTest, TheCalibratedRobotLoadsAgainAndHasNothingLeftToFind) {
  ASSERT_EQ(Run({"calibrate", experiment_, "--out=" + Path("a")}).status, 0);
  ASSERT_EQ(Run({"calibrate", Path("a/robot.calibrated.yaml"), data_, "--sigma_mm=0.1", "--out=" + Path("b")}).status,
            0);
  const auto first = ReadJson("a/estimate.json"), second = ReadJson("b/estimate.json");
  EXPECT_NEAR(first["fit"]["rms_mm"].get<double>(), second["fit"]["rms_mm"].get<double>(), 1e-8);
  for (const auto& parameter : second["parameters"]) {
    if (parameter["name"].get<std::string>().rfind("geometry/", 0) != 0 || !parameter["free"]) continue;
    EXPECT_LT(std::abs(parameter["value"].get<double>()), 1e-3 * parameter["sigma"].get<double>()) << parameter["name"];
  }
}

TEST_F(ResultsTest, PredictGivesTheSameNumbersAsResiduals) {
  ASSERT_EQ(Run({"calibrate", experiment_, "--out=" + Path("out")}).status, 0);
  // configurations.csv: the rows of geometric.csv without points.
  const std::string poses = Published("kr270/configurations.csv");
  const Outcome outcome = Run({"predict", Path("out/estimate.json"), poses, "--out=" + Path("new/predicted.csv")});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto residuals = Cells(Read("out/residuals.csv")), predicted = Cells(Read("new/predicted.csv"));
  ASSERT_EQ(residuals.size(), predicted.size());
  for (size_t i = 1; i < residuals.size(); ++i) {
    for (const std::string axis : {"x", "y", "z"}) {
      const std::string name = "pred_" + axis + "_mm";
      EXPECT_NEAR(std::stod(residuals[i][Column(residuals, name)]), std::stod(predicted[i][Column(predicted, name)]),
                  1e-9);
      const double sigma = std::stod(predicted[i][Column(predicted, "psig_" + axis + "_mm")]);
      EXPECT_GT(sigma, 0.01);
      EXPECT_LT(sigma, 0.1);  // the noise of one coordinate: a fit of 162 rows by 39 unknowns averages
    }
  }
}

TEST_F(ResultsTest, PredictedSigmasAreThoseOfTheLeverage) {
  ASSERT_EQ(Run({"calibrate", experiment_, "--out=" + Path("out")}).status, 0);
  ASSERT_EQ(Run({"predict", Path("out/estimate.json"), data_, "--out=" + Path("p.csv")}).status, 0);
  const auto residuals = Cells(Read("out/residuals.csv")), predicted = Cells(Read("p.csv"));
  for (size_t i = 1; i < residuals.size(); ++i) {
    double variance = 0.0;
    for (const std::string axis : {"x", "y", "z"}) {
      variance += std::pow(std::stod(predicted[i][Column(predicted, "psig_" + axis + "_mm")]), 2) / 3.0;
    }
    EXPECT_NEAR(variance / (0.1 * 0.1), std::stod(residuals[i][Column(residuals, "leverage")]), 1e-6);
  }
}

TEST_F(ResultsTest, PredictRefusesWhatTheEstimateDoesNotKnow) {
  ASSERT_EQ(Run({"calibrate", experiment_, "--out=" + Path("out")}).status, 0);
  for (const std::string column : {"station", "marker"}) {
    auto rows = Cells(ReadAll(data_));
    rows[5][Column(rows, column)] = "Nowhere";
    const std::string file = Write("odd.csv", Csv(rows));
    const Outcome outcome = Run({"predict", Path("out/estimate.json"), file, "--out=" + Path("p.csv")});
    EXPECT_EQ(outcome.status, 2);
    EXPECT_NE(outcome.err.find("odd.csv:6: " + column), std::string::npos) << outcome.err;
    EXPECT_FALSE(Exists("p.csv"));
  }
  EXPECT_EQ(Run({"predict", robot_, data_, "--out=" + Path("p.csv")}).status, 2);
  EXPECT_EQ(Run({"predict", Write("x.json", "{\"schema\": \"sagitta/diagnosis/1\"}"), data_, "--out=" + Path("p.csv")})
                .status,
            2);
}

TEST_F(ResultsTest, SimulatedMeasurementsGiveTheTruthBack) {
  ASSERT_EQ(Run({"calibrate", experiment_, "--out=" + Path("truth")}).status, 0);
  const std::string truth = "--truth=" + Path("truth/estimate.json");
  const Outcome exact = Run({"simulate", robot_, data_, truth, "--sigma_mm=0", "--out=" + Path("exact.csv")});
  ASSERT_EQ(exact.status, 0) << exact.err;
  EXPECT_NE(exact.out.find("exact: no standard deviation above 0 is stated"), std::string::npos) << exact.out;
  const std::string repeats = Write("repeats.yaml", "schema: sagitta/experiment/1\nrobot: " + robot_ +
                                                        "\nmeasurements: [" + data_ + "]\nrepeatability_urad: 8\n");
  const Outcome deviating = Run({"simulate", repeats, truth, "--sigma_mm=0", "--out=" + Path("deviating.csv")});
  ASSERT_EQ(deviating.status, 0) << deviating.err;
  EXPECT_EQ(deviating.out.find("exact"), std::string::npos) << deviating.out;
  ASSERT_EQ(Run({"calibrate", robot_, Path("exact.csv"), "--sigma_mm=0.1", "--out=" + Path("again")}).status, 0);
  const auto a = ReadJson("truth/estimate.json"), b = ReadJson("again/estimate.json");
  for (size_t i = 0; i < a["parameters"].size(); ++i) {
    EXPECT_EQ(a["parameters"][i]["name"], b["parameters"][i]["name"]);
    EXPECT_NEAR(a["parameters"][i]["value"].get<double>(), b["parameters"][i]["value"].get<double>(), 1e-6);
  }
}

// Whoever calibrates the file weighs its rows by the noise that they were given, not by the one of the design.
TEST_F(ResultsTest, SimulatedRowsStateTheNoiseThatTheyWereGiven) {
  ASSERT_EQ(Run({"calibrate", experiment_, "--out=" + Path("out")}).status, 0);
  auto rows = Cells(ReadAll(data_));
  for (const char* axis : {"x", "y", "z"}) {
    for (size_t r = 0; r < rows.size(); ++r) rows[r].push_back(r == 0 ? std::string("sigma_") + axis + "_mm" : "0.01");
  }
  const std::string design = Write("design.csv", Csv(rows)), truth = "--truth=" + Path("out/estimate.json");
  const auto simulated = [&](const std::string& sigma) {
    const Outcome outcome =
        Run({"simulate", robot_, design, truth, "--sigma_mm=" + sigma, "--out=" + Path(sigma + ".csv")});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return Cells(Read(sigma + ".csv"));
  };
  for (const auto& [sigma, cell] : std::map<std::string, std::string>{{"0.25", "0.25"}, {"0", ""}}) {
    const auto noisy = simulated(sigma);
    ASSERT_EQ(noisy.size(), rows.size());
    for (size_t r = 1; r < noisy.size(); ++r) EXPECT_EQ(noisy[r][Column(noisy, "sigma_y_mm")], cell);
  }
  ASSERT_EQ(Run({"calibrate", robot_, Path("0.25.csv"), "--out=" + Path("again")}).status, 0);
  EXPECT_LT(ReadJson("again/estimate.json")["fit"]["reduced_chi2"].get<double>(), 2.0);
}

TEST_F(ResultsTest, SimulationIsReproducible) {
  ASSERT_EQ(Run({"calibrate", experiment_, "--out=" + Path("truth")}).status, 0);
  const std::string truth = "--truth=" + Path("truth/estimate.json");
  for (const std::string name : {"a", "b"}) {
    ASSERT_EQ(Run({"simulate", experiment_, truth, "--seed=5", "--out=" + Path(name)}).status, 0);
  }
  ASSERT_EQ(Run({"simulate", experiment_, truth, "--seed=6", "--out=" + Path("c")}).status, 0);
  EXPECT_EQ(Read("a"), Read("b"));
  EXPECT_NE(Read("a"), Read("c"));
}

TEST_F(ResultsTest, SimulateWithoutASceneSaysWhatIsMissing) {
  const Outcome outcome = Run({"simulate", robot_, data_, "--out=" + Path("s.csv")});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_NE(outcome.err.find("stations"), std::string::npos) << outcome.err;
}

TEST_F(ResultsTest, RequirementMetUnmetAndUnknown) {
  EXPECT_EQ(
      Run({"calibrate", experiment_, "--require=fit.rms_mm<0.2,fit.reduced_chi2 >= 0.5", "--out=" + Path("a")}).status,
      0);
  const Outcome unmet = Run({"calibrate", experiment_, "--require=fit.rms_mm<0.01", "--out=" + Path("b")});
  EXPECT_EQ(unmet.status, 1);
  EXPECT_NE(unmet.err.find("fit.rms_mm"), std::string::npos);
  EXPECT_TRUE(Exists("b/estimate.json"));
  // Of no measurements every figure is 0, and that is no proof.
  for (const std::string figure :
       {"validation.distance_rms_mm", "deflection.after.rms_mm", "validation.before.rms_mm"}) {
    const Outcome empty = Run({"calibrate", experiment_, "--require=" + figure + "<0.3", "--out=" + Path("e")});
    EXPECT_EQ(empty.status, 2) << figure;
    EXPECT_FALSE(Exists("e/estimate.json"));
  }
  EXPECT_EQ(Run({"calibrate", experiment_, "--holdout=0.3", "--require=validation.distance_rms_mm<1"}).status, 0);
  const Outcome unknown = Run({"calibrate", experiment_, "--require=fit.rms_m<0.2", "--out=" + Path("c")});
  EXPECT_EQ(unknown.status, 2);
  EXPECT_NE(unknown.err.find("rms_mm"), std::string::npos) << unknown.err;
  EXPECT_FALSE(Exists("c/estimate.json"));
}

TEST_F(ResultsTest, FixedParametersStayAndHaveNoInterval) {
  ASSERT_EQ(Run({"calibrate", experiment_, "--fixed=geometry/dq2", "--out=" + Path("out")}).status, 0);
  const auto read = ReadJson("out/estimate.json");
  for (const auto& parameter : read["parameters"]) {
    if (parameter["name"] != "geometry/dq2") continue;
    EXPECT_EQ(parameter["value"], 0.0);
    EXPECT_EQ(parameter["free"], false);
    EXPECT_EQ(parameter["identifiable"], true);
    EXPECT_TRUE(parameter["sigma"].is_null());
  }
}

TEST_F(ResultsTest, NamesAreEscapedInTheReport) {
  auto rows = Cells(ReadAll(data_));
  for (size_t i = 1; i < rows.size(); ++i) {
    if (rows[i][Column(rows, "marker")] == "P1") rows[i][Column(rows, "marker")] = "<b>&P1";
  }
  ASSERT_EQ(Run({"calibrate", robot_, Write("m.csv", Csv(rows)), "--out=" + Path("out")}).status, 0);
  const std::string report = Read("out/report.html");
  EXPECT_EQ(report.find("<b>"), std::string::npos);
  EXPECT_NE(report.find("&lt;b&gt;&amp;P1"), std::string::npos);
}

TEST_F(ResultsTest, CompareListsEveryMethod) {
  const Outcome outcome = Run({"compare", experiment_, "--methods=joint,two-step", "--out=" + Path("out")});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto methods = ReadJson("out/comparison.json")["methods"];
  ASSERT_EQ(methods.size(), 2);
  EXPECT_EQ(methods[0]["name"], "joint");
  EXPECT_LT(methods[1]["max_deviation_sigma"].get<double>(), 1e-5);
  for (const char* key :
       {"status", "iterations", "seconds", "cost", "rms_mm", "parameters", "rate_measured", "rate_predicted"}) {
    EXPECT_TRUE(methods[1].contains(key)) << key;
  }
}

// Poor data is not bad input: what an unmoved joint hides is held, said in words, and marked.
// An arm that gives way, carries a load and knows little of where its centre of gravity is, by a simulation that shares
// no code with the model: at its optimum the residuals' own curvature is more than J'J, and whole steps swing.
TEST_F(ResultsTest, StepsThatSwingArrive) {
  const std::string campaign = SourceFolder() + "/tests/tools/swinging_load/";
  const Outcome outcome = Run({"calibrate", campaign + "experiment.yaml", "--out=" + Path("out")});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(ReadJson("out/estimate.json")["status"], "converged");
}

// Weights do not turn the upright first axis: the mass of the second link, at that joint's origin, moves nothing, and
// what rounding leaves of it is no measurement.
TEST_F(ResultsTest, AMassThatMovesNothingIsHeld) {
  const std::string campaign = SourceFolder() + "/tests/tools/swinging_load/";
  std::string robot = ReadAll(campaign + "robot.yaml");
  robot.resize(robot.find("effects:"));
  Write("robot.yaml", robot + "effects: [{effect: link_gravity, joint: R2}]\n");
  Write("measurements.csv", ReadAll(campaign + "measurements.csv"));
  std::string experiment = ReadAll(campaign + "experiment.yaml");
  experiment.replace(experiment.find("[R2, "), 5, "[R1, R2, ");
  const Outcome outcome = Run({"calibrate", Write("experiment.yaml", experiment), "--out=" + Path("out")});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto estimate = ReadJson("out/estimate.json");
  int found = 0;
  for (const auto& parameter : estimate["parameters"]) {
    if (parameter["name"] != "effect/link_gravity/R2/mass") continue;
    ++found;
    EXPECT_FALSE(parameter["identifiable"]);
    EXPECT_EQ(parameter["value"], 0.0);
  }
  EXPECT_EQ(found, 1);
}

TEST_F(ResultsTest, AnUnmovedJointEndsInHeldParameters) {
  ASSERT_EQ(Run({"calibrate", experiment_, "--out=" + Path("truth")}).status, 0);
  auto rows = Cells(ReadAll(data_));
  for (size_t i = 1; i < rows.size(); ++i) rows[i][Column(rows, "q6_deg")] = "10";
  const std::string poses = Write("poses.csv", Csv(rows));
  ASSERT_EQ(Run({"simulate", robot_, poses, "--truth=" + Path("truth/estimate.json"), "--sigma_mm=0.1",
                 "--out=" + Path("still.csv")})
                .status,
            0);
  const Outcome outcome = Run({"calibrate", robot_, Path("still.csv"), "--out=" + Path("out")});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const auto estimate = ReadJson("out/estimate.json");
  EXPECT_EQ(estimate["status"], "converged_with_held_parameters");
  size_t held = 0;
  for (const auto& parameter : estimate["parameters"]) {
    if (parameter["identifiable"]) continue;
    ++held;
    EXPECT_EQ(parameter["free"], false);
    EXPECT_TRUE(parameter["sigma"].is_null());
  }
  EXPECT_GT(held, 0u);
  EXPECT_EQ(held, estimate["identifiability"]["unidentifiable"].size());
  for (const auto& direction : estimate["identifiability"]["unidentifiable"]) {
    EXPECT_NE(outcome.out.find(direction["direction"].begin().key()), std::string::npos);
    EXPECT_FALSE(direction["words"].get<std::string>().empty());
  }
}

// Figures of the fit are of what was fitted.
TEST_F(ResultsTest, DeflectionsAreThoseOfTheCalibrationRows) {
  const std::string all_stages = Published("kr270/all_stages.yaml");
  ASSERT_EQ(Run({"calibrate", all_stages, "--out=" + Path("all")}).status, 0);
  ASSERT_EQ(Run({"calibrate", all_stages, "--holdout=0.3", "--out=" + Path("part")}).status, 0);
  const int all = ReadJson("all/estimate.json")["deflection"]["pairs"];
  const int part = ReadJson("part/estimate.json")["deflection"]["pairs"];
  EXPECT_LT(part, 0.85 * all);
  EXPECT_GT(part, 0.5 * all);
}

// 1 mm instead of 0.02: the compliance of the last joint is worse known than half its value.
TEST_F(ResultsTest, WhatIsKnownWorseThanHalfItsValueIsWeak) {
  ASSERT_EQ(Run({"calibrate", Published("kr270/all_stages.yaml"), "--sigma_mm=1", "--out=" + Path("out")}).status, 0);
  const auto weak = ReadJson("out/estimate.json")["identifiability"]["weak"];
  EXPECT_NE(weak.dump().find("compliance/A6"), std::string::npos) << weak;
}

// A rigid arm, read unloaded and with 2500 N: methods that know no bounds put some of its compliances below 0, and no
// command reads such a robot again.
TEST_F(ResultsTest, ARobotThatCannotBeReadAgainIsNotWritten) {
  ASSERT_EQ(Run({"calibrate", experiment_, "--out=" + Path("truth")}).status, 0);
  std::vector<std::vector<std::string>> all;
  for (const std::string load : {"none", "L"}) {
    const std::string out = load + ".csv", seed = load == "L" ? "--seed=2" : "--seed=1";
    ASSERT_EQ(Run({"simulate", robot_, data_, "--truth=" + Path("truth/estimate.json"), "--sigma_mm=0.1", seed,
                   "--out=" + Path(out)})
                  .status,
              0);
    const auto rows = Cells(Read(out));
    for (size_t r = 0; r < rows.size(); ++r) {
      if (r == 0 && !all.empty()) continue;
      all.push_back(rows[r]);
      const bool loaded = load == "L";
      for (const std::string& cell :
           {r == 0 ? std::string("load") : load, std::string(r == 0 ? "fx_N" : "0"), std::string(r == 0 ? "fy_N" : "0"),
            std::string(r == 0   ? "fz_N"
                        : loaded ? "-2500"
                                 : "0")}) {
        all.back().push_back(cell);
      }
    }
  }
  const std::string rows = Write("all.csv", Csv(all));
  for (const std::string method : {"full-pose", "two-step-literal", "joint"}) {
    const Outcome outcome = Run({"calibrate", robot_, rows, "--load_point_mm=280,60,-150", "--sigma_mm=0.1",
                                 "--method=" + method, "--out=" + Path(method)});
    EXPECT_EQ(outcome.status, method == "joint" ? 0 : 3) << outcome.err;
    EXPECT_EQ(Exists(method + "/robot.calibrated.yaml"), method == "joint");
    EXPECT_EQ(Exists(method + "/estimate.json"), method == "joint");
    if (method == "joint") continue;
    EXPECT_THAT(outcome.err, ::testing::HasSubstr("puts compliance/"));
    EXPECT_THAT(outcome.err, ::testing::HasSubstr("below 0"));
  }
  EXPECT_EQ(Run({"predict", Path("joint/estimate.json"), rows, "--out=" + Path("p.csv")}).status, 0);
}

TEST_F(ResultsTest, NumericalFailureSaysWhyAndWritesNoEstimate) {
  auto rows = Cells(ReadAll(data_));
  std::vector<std::vector<std::string>> one_marker = {rows[0]};
  for (const auto& row : rows) {
    if (row[Column(rows, "marker")] == "P1") one_marker.push_back(row);
  }
  const std::string file = Write("one.csv", Csv(one_marker));
  const Outcome outcome = Run({"calibrate", robot_, file, "--method=full-pose", "--out=" + Path("out")});
  EXPECT_EQ(outcome.status, 3);
  EXPECT_NE(outcome.err.find("three markers"), std::string::npos) << outcome.err;
  EXPECT_FALSE(Exists("out/estimate.json"));
}

// A joint that counts the other way is refused with its cure; whoever insists learns that nothing fits.
TEST_F(ResultsTest, ARobotThatDoesNotFitTheDataIsSaidSo) {
  auto rows = Cells(ReadAll(data_));
  for (size_t i = 1; i < rows.size(); ++i) {
    std::string& cell = rows[i][Column(rows, "q2_deg")];
    cell = std::to_string(-std::stod(cell));
  }
  const std::vector<std::string> command = {"calibrate", robot_, Write("sign.csv", Csv(rows)), "--out=" + Path("out")};
  const Outcome refused = Run(command);
  EXPECT_EQ(refused.status, 2) << refused.err;
  EXPECT_NE(refused.err.find("with joint A2 counted the other way"), std::string::npos) << refused.err;
  EXPECT_FALSE(Exists("out/estimate.json"));
  std::vector<std::string> insisting = command;
  insisting.push_back("--force");
  const Outcome outcome = Run(insisting);
  EXPECT_EQ(outcome.status, 3) << outcome.err;
  EXPECT_NE(outcome.err.find("check signs"), std::string::npos) << outcome.err;
  EXPECT_FALSE(Exists("out/estimate.json"));
}

}  // namespace
}  // namespace sagitta::test::results_test

// Every lint fires on data made for it by a generator that shares nothing with the model, and keeps silent on clean
// data; rank, expected sigmas and leverage against what theory and the estimate say.
#include "estimator/inspection/inspect.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <set>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/inspection/row_lint.h"
#include "estimator/report/inspection_words.h"
#include "tests/support/arms.h"
#include "tests/support/loaded_kr270.h"

namespace sagitta::inspect_test {
namespace {

using test::Kr270Design;
using test::Kr270Truth;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const Finding* Find(const Inspection& inspection, const std::string& code) {
  for (const Finding& finding : inspection.findings) {
    if (finding.code == code) return &finding;
  }
  return nullptr;
}

std::string WordsOf(const Inspection& inspection) {
  std::string words;
  for (const Finding& finding : inspection.findings) words += finding.code + ": " + finding.words + "\n";
  for (const ReadingMisfit& reading : inspection.reading.readings)
    words += reading.reading + " " + std::to_string(1e3 * reading.rms) + " mm\n";
  return words;
}

std::set<std::string> Codes(const Inspection& inspection, Severity severity) {
  std::set<std::string> codes;
  for (const Finding& finding : inspection.findings) {
    if (finding.severity == severity) codes.insert(finding.code);
  }
  return codes;
}

using Change = std::function<void(Measurements*)>;

// `before`: of the poses, then the arm is measured, then `after`.
CalibrationProblem ProblemOf(const Kr270Design& design, const Change& before, const Change& after) {
  Measurements data = test::DesignMeasurements(design);
  if (before) before(&data);
  test::MeasureKr270(Kr270Truth(), design.sigma, 7, &data);
  if (after) after(&data);
  return test::Kr270ProblemOf(data, Experiment());
}

Inspection InspectKr270(const Change& before, const Change& after, const Kr270Design& design = Kr270Design()) {
  return Inspect(ProblemOf(design, before, after));
}

TEST(Inspect, CleanDataRaiseNoAlarm) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    Kr270Design design;
    design.seed = seed;
    const Inspection inspection = InspectKr270({}, {}, design);
    EXPECT_THAT(Codes(inspection, Severity::kSerious), ElementsAre());
    EXPECT_THAT(Codes(inspection, Severity::kWarning), ElementsAre());
    EXPECT_EQ(inspection.unknowns, 39);  // PUBLISHED.md section 6: 2 bases, 9 tool, 18 geometry
    EXPECT_EQ(inspection.identifiability.rank, 39);
    EXPECT_FALSE(inspection.reading.is_suspicious);
  }
}

TEST(Inspect, ExpectedSigmasAreThoseOfTheEstimate) {
  const CalibrationProblem problem = ProblemOf({}, {}, {});
  const Inspection inspection = Inspect(problem);
  const Estimate estimate = EstimateJointly(problem);
  int compared = 0;
  for (const ParameterEstimate& row : inspection.parameters) {
    const ParameterEstimate& later = estimate.table[estimate.parameters.FindCoordinate(row.name)];
    // Stated sigmas; a chance excess of the scatter may scale them by a few per cent here.
    EXPECT_NEAR(row.sigma / later.sigma, 1.0, 0.15) << row.name;
    ++compared;
  }
  EXPECT_EQ(compared, 39);
}

TEST(Inspect, LeveragesAddUpToTheRank) {
  const Inspection inspection = InspectKr270({}, {});
  double sum = 0.0;
  for (const ConfigurationLeverage& entry : inspection.leverage) {
    sum += 9 * entry.mean;  // 3 markers
    EXPECT_LE(entry.mean, entry.most);
    EXPECT_LE(entry.most, 1.0 + 1e-12);
  }
  EXPECT_NEAR(sum, 39.0, 1e-8);
}

void Turn(Measurements* data, const std::function<void(Eigen::VectorXd*)>& change) {
  for (Configuration& configuration : data->configurations) change(&configuration.q);
}

TEST(Inspect, FlippedJointsAreNamed) {
  for (int j = 0; j < 6; ++j) {
    const Inspection inspection =
        InspectKr270({}, [j](Measurements* data) { Turn(data, [j](auto* q) { (*q)[j] *= -1; }); });
    const Finding* finding = Find(inspection, "sign_flip");
    ASSERT_NE(finding, nullptr) << j;
    EXPECT_EQ(finding->severity, Severity::kSerious);
    EXPECT_THAT(finding->words, HasSubstr("joint A" + std::to_string(j + 1) + " counted the other way"));
  }
}

TEST(Inspect, TwoFlippedJointsAreNamed) {
  const Inspection inspection = InspectKr270({}, [](Measurements* data) {
    Turn(data, [](auto* q) {
      (*q)[1] *= -1;
      (*q)[3] *= -1;
    });
  });
  const Finding* finding = Find(inspection, "sign_flip");
  ASSERT_NE(finding, nullptr) << WordsOf(inspection);
  EXPECT_THAT(finding->words, HasSubstr("A2 and A4"));
}

TEST(Inspect, AnotherZeroIsNamed) {
  for (const int j : {1, 2, 3, 4}) {  // the base absorbs the first, the markers the last
    const Inspection inspection =
        InspectKr270({}, [j](Measurements* data) { Turn(data, [j](auto* q) { (*q)[j] += kPi / 2; }); });
    const Finding* finding = Find(inspection, "joint_offset");
    ASSERT_NE(finding, nullptr) << j;
    EXPECT_THAT(finding->words, HasSubstr("joint A" + std::to_string(j + 1) + " with its zero -90 deg away"));
  }
}

TEST(Inspect, WhatNoReadingExplainsIsSaidToBeUnexplained) {
  const Inspection inspection = InspectKr270({}, [](Measurements* data) {
    for (size_t c = 0; 2 * c + 1 < data->configurations.size(); ++c)
      std::swap(data->configurations[c].q, data->configurations[data->configurations.size() - 1 - c].q);
  });
  EXPECT_NE(Find(inspection, "misfit"), nullptr);
}

TEST(Inspect, ExchangedJointColumnsAreNamed) {
  const Inspection inspection =
      InspectKr270({}, [](Measurements* data) { Turn(data, [](auto* q) { std::swap((*q)[1], (*q)[4]); }); });
  const Finding* finding = Find(inspection, "joint_order");
  ASSERT_NE(finding, nullptr) << WordsOf(inspection);
  EXPECT_THAT(finding->words, HasSubstr("joints A2 and A5 exchanged"));
}

// DH by 4 x 4 matrices of its own.
Eigen::Matrix4d StandardLink(const test::DhRow& row, double q) {
  const double t = row.theta_deg * kDegree + q, a = row.alpha_deg * kDegree;
  Eigen::Matrix4d m;
  m << std::cos(t), -std::sin(t) * std::cos(a), std::sin(t) * std::sin(a), row.a * std::cos(t),  //
      std::sin(t), std::cos(t) * std::cos(a), -std::cos(t) * std::sin(a), row.a * std::sin(t),   //
      0, std::sin(a), std::cos(a), row.d,                                                        //
      0, 0, 0, 1;
  return m;
}

TEST(Inspect, TheOtherDhConventionIsNamed) {
  Measurements data = test::DesignMeasurements(Kr270Design());
  for (Observation& observation : data.observations) {
    const Eigen::VectorXd& q = data.ConfigurationOf(observation).q;
    Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
    for (int j = 0; j < 6; ++j) pose = pose * StandardLink(test::Ur5Rows()[j], q[j]);
    const Eigen::Vector4d marker(0.05 * observation.marker, 0.1, 0.08 - 0.06 * observation.marker, 1);
    observation.point_in_station = (pose * marker).head<3>();
  }
  for (const bool right : {true, false}) {
    Robot robot;
    DhTable table;
    table.convention = right ? DhConvention::kStandard : DhConvention::kModified;
    for (int j = 0; j < 6; ++j) {
      const test::DhRow row = test::Ur5Rows()[j];
      table.links.push_back({j, row.a, row.alpha_deg * kDegree, row.d, 0.0, 0.0});
    }
    robot.chain = ChainFromDhTable(test::Revolutes(6), {}, table);
    robot.dh = table;
    const Inspection inspection = Inspect(MakeCalibrationProblem(robot, data, Experiment()));
    const Finding* finding = Find(inspection, "dh_convention");
    ASSERT_EQ(finding == nullptr, right) << WordsOf(inspection);
    if (!right) {
      EXPECT_THAT(finding->words, HasSubstr("standard DH"));
    }
  }
}

// Of few rows the nominal robot cannot have made them all; of many two shots are not noticed before the others fit.
TEST(Inspect, ExchangedMarkersAreFoundByRow) {
  for (const int configurations : {18, 300}) {
    Kr270Design design;
    design.configurations = configurations;
    const auto exchange = [](Measurements* data) {
      for (const int shot : {3, 7}) {
        auto& o = data->observations;
        std::swap(o[3 * shot].point_in_station, o[3 * shot + 1].point_in_station);
      }
    };
    const Inspection inspection = InspectKr270({}, exchange, design);
    const Finding* finding = Find(inspection, "marker_swap");
    ASSERT_NE(finding, nullptr) << WordsOf(inspection);
    EXPECT_THAT(finding->words, HasSubstr(configurations == 18 ? "of markers P1 and P2 of 2 shots" : "2 shots fit"));
    EXPECT_THAT(finding->rows,
                ElementsAre("simulated.csv:11", "simulated.csv:12", "simulated.csv:23", "simulated.csv:24"));
    EXPECT_EQ(Find(inspection, "outliers"), nullptr);
  }
}

TEST(Inspect, GrossOutliersAreFoundByRow) {
  const Inspection inspection = InspectKr270({}, [](Measurements* data) {
    data->observations[10].point_in_station.x() += 5e-3;
    data->observations[30].point_in_station.y() -= 50e-3;
  });
  const Finding* finding = Find(inspection, "outliers");
  ASSERT_NE(finding, nullptr) << WordsOf(inspection);
  std::set<std::string> rows;
  for (const Finding& each : inspection.findings) {
    if (each.code == "outliers") rows.insert(each.rows.begin(), each.rows.end());
  }
  EXPECT_THAT(rows, ElementsAre("simulated.csv:12", "simulated.csv:32"));
}

// Normal noise, of the residuals of 60 rows, m.
Eigen::Matrix3Xd Residuals60(unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, 3e-5);
  return Eigen::Matrix3Xd::NullaryExpr(3, 60, [&] { return normal(random); });
}

TEST(RowLint, RowsThatStandAloneAreFound) {
  for (unsigned seed = 1; seed <= 100; ++seed) {
    Eigen::Matrix3Xd residuals = Residuals60(seed);
    EXPECT_THAT(GrossOutliers(residuals, 0), ElementsAre()) << seed;
    residuals.col(18) = Eigen::Vector3d(4e-4, 0.0, 0.0);  // 13 sigma, 9 median distances
    EXPECT_THAT(GrossOutliers(residuals, 0), ElementsAre(18)) << seed;
  }
}

TEST(RowLint, RowsThatHaveNeighboursDoNotStandAlone) {
  Eigen::Matrix3Xd residuals = Residuals60(1);
  for (int k = 0; k < 12; ++k) residuals.col(k) *= 1.0 + 0.4 * k;  // a tail
  EXPECT_THAT(GrossOutliers(residuals, 0), ElementsAre());
}

TEST(Inspect, CopiedPointsAndDuplicatedPoses) {
  Inspection inspection = InspectKr270({}, [](Measurements* data) {
    data->observations[12].point_in_station = data->observations[0].point_in_station;  // station S1, marker P1
  });
  ASSERT_NE(Find(inspection, "copied_points"), nullptr);
  EXPECT_THAT(Find(inspection, "copied_points")->rows, ElementsAre("simulated.csv:14"));
  inspection = InspectKr270([](Measurements* data) { data->configurations[5].q = data->configurations[2].q; }, {});
  ASSERT_NE(Find(inspection, "duplicated_poses"), nullptr);
  EXPECT_EQ(Find(inspection, "duplicated_poses")->rows.size(), 1u);
}

// Axes 2, 3 and 5 are parallel: q5 = -q2 - q3 keeps the flange as it is.
void KeepOrientation(bool turn_base, Measurements* data) {
  Turn(data, [turn_base](auto* q) {
    if (!turn_base) (*q)[0] = 0.0;
    (*q)[3] = (*q)[5] = 0.0;
    (*q)[4] = -(*q)[1] - (*q)[2];
  });
}

TEST(Inspect, OneIsNotMany) {
  EXPECT_THAT(PointsAreCopied(1).words, ::testing::HasSubstr("1 row has the point"));
  EXPECT_THAT(PointsAreCopied(2).words, ::testing::HasSubstr("2 rows have the point"));
  EXPECT_THAT(PosesAreRepeated(1).words,
              ::testing::HasSubstr("1 configuration has the joint values of another one: it"));
  EXPECT_THAT(PosesAreRepeated(2).words, ::testing::HasSubstr("2 configurations have the joint values"));
  EXPECT_THAT(LoadedWithoutUnloaded(1).words, ::testing::HasSubstr("1 loaded shot has"));
  EXPECT_THAT(LoadedWithoutUnloaded(2).words, ::testing::HasSubstr("2 loaded shots have"));
}

TEST(Inspect, ConstantOrientationIsSaidInWords) {
  const Inspection inspection = InspectKr270([](Measurements* data) { KeepOrientation(false, data); }, {});
  const Finding* finding = Find(inspection, "constant_orientation");
  ASSERT_NE(finding, nullptr) << WordsOf(inspection);
  EXPECT_EQ(finding->severity, Severity::kSerious);
  EXPECT_LT(inspection.identifiability.rank, inspection.unknowns);
  const Inspection turned = InspectKr270([](Measurements* data) { KeepOrientation(true, data); }, {});
  EXPECT_EQ(Find(turned, "constant_orientation"), nullptr);
  ASSERT_NE(Find(turned, "one_axis_orientation"), nullptr);
  EXPECT_NEAR(std::abs(turned.orientation.still.z()), 1.0, 1e-9);
}

TEST(Inspect, JointsThatHardlyMoveAreNamed) {
  const Inspection inspection = InspectKr270(
      [](Measurements* data) {
        Turn(data, [](auto* q) {
          (*q)[3] = 0.4;
          (*q)[1] *= 0.1;  // 14 degrees
        });
      },
      {});
  ASSERT_NE(Find(inspection, "joint_never_moved"), nullptr);
  EXPECT_THAT(Find(inspection, "joint_never_moved")->words, HasSubstr("joint A4"));
  ASSERT_NE(Find(inspection, "narrow_joint_range"), nullptr);
  EXPECT_THAT(Find(inspection, "narrow_joint_range")->words, HasSubstr("joint A2"));
  EXPECT_NE(Find(inspection, "unidentifiable"), nullptr);
}

TEST(Inspect, FewConfigurationsAndOneThatCarriesAStation) {
  Kr270Design few;
  few.configurations = 8;
  EXPECT_NE(Find(InspectKr270({}, {}, few), "few_configurations"), nullptr);
  const Inspection lonely = InspectKr270(
      [](Measurements* data) {
        for (Shot& shot : data->shots) shot.station = shot.configuration == 4 ? 1 : 0;
      },
      {});
  const Finding* finding = Find(lonely, "alone");
  ASSERT_NE(finding, nullptr) << WordsOf(lonely);
  EXPECT_THAT(finding->words, HasSubstr("(C4)"));
}

TEST(Inspect, LoadsWithoutCounterpartAndCompliancesWithoutTorque) {
  test::LoadedTruth truth;
  truth.base_rotvec = {Vector3<double>::Zero(), Vector3<double>::Zero()};  // axis 1 along gravity: no torque on it
  const test::LoadedDesign design;
  Measurements data = test::LoadedRows(design, truth);
  test::Measure(test::ExactPoints(truth, data), design.sigma, 3, &data);
  const test::LoadedSetup setup = test::SetupFor(truth);
  const CalibrationProblem problem = MakeCalibrationProblem(setup.robot, data, setup.experiment);
  Inspection inspection = Inspect(problem);
  // The nominal robot before, loaded rows included, is what an estimate calls before.
  const double before = EstimateJointly(problem).fit_before.distance_rms;
  EXPECT_NEAR(inspection.aligned.distance_rms / before, 1.0, 1e-9);
  EXPECT_THAT(Codes(inspection, Severity::kSerious), ElementsAre());
  EXPECT_EQ(Find(inspection, "load_without_unloaded"), nullptr);
  const Finding* finding = Find(inspection, "unidentifiable");
  ASSERT_NE(finding, nullptr) << WordsOf(inspection);
  EXPECT_THAT(finding->words, HasSubstr("compliance/A1"));
  for (Shot& shot : data.shots) {
    if (shot.configuration != 4 || shot.load != "none") continue;
    shot.load = "V250";
    shot.repeat = "2";
    shot.wrench.force = truth.loads["V250"].force;
    for (const int i : shot.observations)
      data.observations[i].point_in_station = data.observations[i + 3].point_in_station;  // the loaded shot follows
  }
  inspection = Inspect(MakeCalibrationProblem(setup.robot, data, setup.experiment));
  EXPECT_NE(Find(inspection, "load_without_unloaded"), nullptr);
}

TEST(Inspect, AbsentColumnsAreNoted) {
  const Inspection bare = InspectKr270({}, {});
  const Inspection full = InspectKr270({}, [](Measurements* data) {
    for (Shot& shot : data->shots) {
      shot.has_time = shot.has_temperature = true;
      shot.approach.assign(6, 1);
    }
  });
  for (const char* code : {"no_time", "no_temperature", "no_approach"}) {
    EXPECT_NE(Find(bare, code), nullptr) << code;
    EXPECT_EQ(Find(full, code), nullptr) << code;
  }
  EXPECT_EQ(Find(bare, "no_sigma"), nullptr);
}

}  // namespace
}  // namespace sagitta::inspect_test

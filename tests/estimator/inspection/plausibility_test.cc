// Wrong robot files and rows are refused with their cure, robots that only need calibration never: on points of a
// generator that knows nothing of the model's kinematics.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "estimator/alignment/aligned_misfit.h"
#include "estimator/calibration/joint_estimator.h"
#include "estimator/inspection/reading_lint.h"
#include "estimator/inspection/sampled_problem.h"
#include "estimator/inspection/wild_rows.h"
#include "estimator/validation/suspects.h"
#include "tests/support/judged.h"
#include "tests/support/kr270_experiment.h"
#include "tests/support/measured_arms.h"
#include "tests/support/real_data.h"

namespace sagitta::plausibility_test {
namespace {

using test::DhRow;
using test::Measure;
using test::ProblemOf;
using ::testing::HasSubstr;

struct Arm {
  const char* name;
  std::vector<DhRow> rows;
};
std::vector<Arm> Arms() { return {{"UR5", test::Ur5Rows()}, {"UR10", test::Ur10Rows()}}; }

struct WrongInput {
  const char* code;
  const char* cure;  // in words or remedy
  std::function<void(Eigen::VectorXd*)> joints;
  std::function<void(Vector3<double>*)> point;
};

TEST(Plausibility, WrongRowsAreRefusedWithTheirCure) {
  const std::vector<WrongInput> wrong = {
      {"sign_flip", "joint j2 counted the other way", [](auto* q) { (*q)[1] *= -1; }, {}},
      {"joint_offset", "joint j3 with its zero -90 deg away", [](auto* q) { (*q)[2] += kPi / 2; }, {}},
      {"joint_order", "joints j2 and j3 exchanged", [](auto* q) { std::swap((*q)[1], (*q)[2]); }, {}},
      {"joint_order", "reverse order", [](auto* q) { *q = q->reverse().eval(); }, {}},
      {"mirrored", "mirrored", {}, [](auto* p) { p->y() *= -1; }},
      {"mirrored", "mirrored", {}, [](auto* p) { std::swap(p->x(), p->z()); }},
      {"unit", "inches", {}, [](auto* p) { *p /= 25.4; }},
      {"coupling", "joint j3 coupled to j2 by 1", [](auto* q) { (*q)[2] -= (*q)[1]; }, {}},
  };
  for (const Arm& arm : Arms()) {
    for (const WrongInput& input : wrong) {
      Measurements data = Measure(arm.rows, 3);
      for (Configuration& configuration : data.configurations) {
        if (input.joints) input.joints(&configuration.q);
      }
      for (Observation& row : data.observations) {
        if (input.point) input.point(&row.point_in_station);
      }
      const Plausibility found = test::CheckPlausible(ProblemOf(arm.rows, data));
      ASSERT_FALSE(found.plausible) << arm.name << " " << input.cure;
      EXPECT_EQ(found.finding.code, input.code) << arm.name << ": " << found.finding.words;
      EXPECT_THAT(found.finding.words + found.finding.remedy, HasSubstr(input.cure)) << arm.name;
    }
  }
}

TEST(Plausibility, WrongTablesAreRefusedWithTheirCure) {
  for (const Arm& arm : Arms()) {
    const Measurements data = Measure(arm.rows, 4);
    Plausibility found = test::CheckPlausible(ProblemOf(arm.rows, data, DhConvention::kModified));
    ASSERT_FALSE(found.plausible);
    EXPECT_THAT(found.finding.words, HasSubstr("the table as standard DH"));
    std::vector<DhRow> turned = arm.rows;
    turned[0].alpha_deg *= -1;
    found = test::CheckPlausible(ProblemOf(turned, data));
    ASSERT_FALSE(found.plausible);
    EXPECT_THAT(found.finding.remedy, HasSubstr("alpha_deg in the row of j1"));
  }
  // The other arm: no reading explains it, and it would have to be off by centimetres.
  for (const bool first : {true, false}) {
    const std::vector<Arm> arms = Arms();
    const Plausibility found =
        test::CheckPlausible(ProblemOf(arms[first ? 0 : 1].rows, Measure(arms[first ? 1 : 0].rows, 5)));
    ASSERT_FALSE(found.plausible);
    EXPECT_EQ(found.finding.code, "misfit");
    EXPECT_THAT(found.finding.remedy, HasSubstr("is it this robot?"));
  }
}

// The instrument was moved and its station kept its name: rows of one station are asked whether they are. Rows of two,
// of another arm, are not.
TEST(Plausibility, PlacesOfOneNameAreAskedFor) {
  Measurements data = Measure(test::Ur5Rows(), 5);
  for (size_t i = 0; i < data.observations.size(); i += 2) {
    Vector3<double>& point = data.observations[i].point_in_station;
    point = Eigen::AngleAxisd(1.0, Vector3<double>::UnitZ()) * point + Vector3<double>(2.0, -3.0, 0.1);
  }
  const Plausibility one = test::CheckPlausible(ProblemOf(test::Ur5Rows(), data));
  ASSERT_FALSE(one.plausible);
  EXPECT_EQ(one.finding.code, "misfit") << one.finding.words;
  EXPECT_THAT(one.finding.remedy, HasSubstr("several places"));
  Measurements other = Measure(test::Ur10Rows(), 5);
  other.stations.push_back("S2");
  for (size_t i = 0; i < other.shots.size(); i += 2) other.shots[i].station = 1;
  const Plausibility two = test::CheckPlausible(ProblemOf(test::Ur5Rows(), other));
  ASSERT_FALSE(two.plausible);
  EXPECT_THAT(two.finding.remedy, ::testing::Not(HasSubstr("several places")));
}

// Each error of an arm drawn up to 5 mm and 1 deg; alone, and with rows in addition that are far off.
TEST(Plausibility, RobotsWithLargeErrorsAreNotRefused) {
  for (int seed = 0; seed < 40; ++seed) {
    const Plausibility found = test::CheckPlausible(test::ArmWithLargeErrors(seed));
    EXPECT_TRUE(found.plausible) << seed << ": " << found.finding.words;
  }
}

// A refusal of many rows goes by some hundred configurations: the same cure, and every marker in it.
TEST(Plausibility, ManyRowsAreJudgedByAFewHundredConfigurations) {
  Measurements data = Measure(test::Ur5Rows(), 6, 2000);
  data.markers.push_back("P2");  // seen once
  data.observations[1234].marker = 1;
  for (Configuration& configuration : data.configurations) configuration.q[1] *= -1.0;
  const CalibrationProblem problem = ProblemOf(test::Ur5Rows(), data);
  const CalibrationProblem sampled = SampledProblem(problem);
  EXPECT_EQ(sampled.data().configurations.size(), 300u);
  std::set<int> markers;
  for (size_t i = 0; i < sampled.data().observations.size(); ++i) {
    const Observation& row = sampled.data().observations[i];
    markers.insert(row.marker);
    const int whole = std::stoi(sampled.data().ConfigurationOf(row).id.substr(1));
    EXPECT_EQ(row.point_in_station, data.observations[whole].point_in_station);
    EXPECT_EQ(sampled.data().SourceOf(row), data.SourceOf(data.observations[whole]));
  }
  EXPECT_EQ(markers.size(), 2u);
  const Plausibility found = test::CheckPlausible(problem);
  ASSERT_FALSE(found.plausible);
  EXPECT_THAT(found.finding.words, HasSubstr("joint j2 counted the other way"));
}

// Points written one configuration too late: neighbours are those of all rows, not of the sample.
TEST(Plausibility, ManyRowsShiftedByOneAreRefusedWithTheirCure) {
  Measurements data = Measure(test::Ur5Rows(), 8, 900);
  for (size_t i = data.observations.size() - 1; i > 0; --i)
    data.observations[i].point_in_station = data.observations[i - 1].point_in_station;
  const Plausibility found = test::CheckPlausible(ProblemOf(test::Ur5Rows(), data));
  ASSERT_FALSE(found.plausible);
  EXPECT_EQ(found.finding.code, "row_shift") << found.finding.words;
}

// A lost reading at the end is left out where each point is read with the configuration after its own: that the others
// fit says nothing for it.
TEST(Plausibility, ALostReadingIsNoShift) {
  for (const bool is_last : {true, false}) {
    Measurements data = Measure(test::Ur5Rows(), 8, 12);
    data.observations[is_last ? 11 : 0].point_in_station.setConstant(-9.999);
    const Plausibility found = test::CheckPlausible(ProblemOf(test::Ur5Rows(), data));
    EXPECT_NE(found.finding.code, "row_shift") << found.finding.words;
  }
}

// The rows of one configuration are a pose, wherever its joints are: that a station of their own fits them says
// nothing.
TEST(Plausibility, RowsOfOneConfigurationAreNoOtherStations) {
  test::Kr270Design design;
  design.configurations = 40;
  design.stations = 1;
  Measurements data = test::DesignMeasurements(design);
  Shot again = data.shots.back();
  again.repeat = "2";
  test::AddShot(again, 3, design.sigma, &data);
  test::MeasureKr270(test::Kr270Truth(), design.sigma, 7, &data);
  Eigen::VectorXd& q = data.configurations.back().q;
  std::swap(q[1], q[2]);
  const CalibrationProblem problem = test::Kr270ProblemOf(data, Experiment());
  EXPECT_THAT(test::CheckPlausible(problem).finding.words, ::testing::Not(HasSubstr("another station")));
  EXPECT_EQ(FindSuspects(problem, EstimateJointly(problem)).size(), 6u);
}

// Rows of another station, another marker, and a marker on a link: said, with what to write; a few wild rows are not.
TEST(Plausibility, RowsUnderAnotherLabelAreNamed) {
  for (const Arm& arm : Arms()) {
    const Measurements clean = Measure(arm.rows, 9, 60);
    const auto elsewhere = [](const Vector3<double>& p) {
      return Vector3<double>(1.5 - p.y(), p.x() - 0.7, p.z() + 0.25);
    };
    Measurements two = clean;
    for (size_t i = 0; i < 60; i += 3)
      two.observations[i].point_in_station = elsewhere(clean.observations[i].point_in_station);
    const auto found = test::CheckPlausible(ProblemOf(arm.rows, two)).finding;
    EXPECT_EQ(found.code, "station_moved") << found.words;
    EXPECT_THAT(found.words, HasSubstr("20 of 60 rows"));
    EXPECT_THAT(found.words, HasSubstr("90 deg away"));

    Measurements exchanged = two;
    exchanged.stations.push_back("S2");
    for (size_t i = 0; i < 60; ++i) exchanged.shots[i].station = (i % 3 == 0) != (i % 10 == 0);
    const auto labels = test::CheckPlausible(ProblemOf(arm.rows, exchanged)).finding;
    EXPECT_EQ(labels.code, "station_label") << labels.words;
    EXPECT_THAT(labels.words, HasSubstr("station S2 in place of S1 in 2 rows and station S1 in place of S2 in 4 rows"));
    EXPECT_THAT(labels.remedy, HasSubstr("correct the column station"));

    Measurements marker = clean;
    for (size_t i = 0; i < 60; i += 4) {  // 80 mm farther out along the flange's x
      Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
      for (size_t j = 0; j < arm.rows.size(); ++j)
        pose = pose * test::Link(arm.rows[j], clean.configurations[i].q[static_cast<Eigen::Index>(j)]);
      marker.observations[i].point_in_station += 0.08 * pose.block<3, 1>(0, 0);
    }
    const auto moved = test::CheckPlausible(ProblemOf(arm.rows, marker)).finding;
    EXPECT_EQ(moved.code, "marker_moved") << moved.words;
    EXPECT_THAT(moved.words, HasSubstr("80 mm away"));

    Measurements link = clean;
    link.markers.push_back("K1");  // on the second link, said to be on the flange
    for (size_t i = 0; i < 60; i += 6) {
      Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
      for (int j = 0; j < 2; ++j)
        pose = pose * test::Link(arm.rows[static_cast<size_t>(j)], clean.configurations[i].q[j]);
      link.observations[i].marker = 1;
      link.observations[i].point_in_station = (pose * Eigen::Vector4d(0.2, 0.1, -0.1, 1)).head<3>();
    }
    const auto on = test::CheckPlausible(ProblemOf(arm.rows, link)).finding;
    EXPECT_EQ(on.code, "marker_frame") << on.words;
    EXPECT_THAT(on.remedy, HasSubstr("K1: {on: j2}"));

    Measurements one = clean;
    for (Observation& row : one.observations) row.point_in_station = clean.observations[0].point_in_station;
    EXPECT_EQ(test::CheckPlausible(ProblemOf(arm.rows, one)).finding.code, "one_point");

    Measurements wild = clean;
    for (const size_t i : {7u, 11u, 31u, 50u})
      wild.observations[i].point_in_station.x() += 0.3 + 0.05 * static_cast<double>(i);
    EXPECT_TRUE(test::CheckPlausible(ProblemOf(arm.rows, wild)).plausible);
  }
}

// Of 1200 rows 200 are looked at first: drawn, for every third is wrong, and of every sixth all or none would be.
TEST(Plausibility, FarRowsOfALongTableAreAllFound) {
  Measurements data = Measure(test::Ur5Rows(), 5, 1200);
  std::vector<int> wrong;
  for (int i = 0; i < 1200; i += 3) {
    const Vector3<double> p = data.observations[i].point_in_station;
    data.observations[i].point_in_station = Vector3<double>(1.5 - p.y(), p.x() - 0.7, p.z() + 0.25);
    wrong.push_back(i);
  }
  const std::optional<FarRows> rows = FindFarRows(ProblemOf(test::Ur5Rows(), data));
  ASSERT_TRUE(rows);
  EXPECT_EQ(rows->far, wrong);
  EXPECT_EQ(rows->near.size(), 800u);
  EXPECT_LT(rows->near_rms, 2e-4);  // uniform within 0.1 mm: 0.1 mm RMS
}

// The sample that the nominal robot is aligned to first may hold none of the wrong rows, and all rows together may lead
// nowhere; and each of these rows is a suspect where it is gone on with.
TEST(Plausibility, LabelsThatTheSampleMissesAreNamed) {
  for (const Arm& arm : Arms()) {
    Measurements data = Measure(arm.rows, 10, 900);
    data.stations.push_back("S2");
    for (size_t i = 0; i < 900; i += 3) {
      Vector3<double>& p = data.observations[i].point_in_station;
      p = Vector3<double>(1.5 - p.y(), p.x() - 0.7, p.z() + 0.25);
    }
    for (size_t i = 0; i < 900; ++i) data.shots[i].station = i % 3 == 0;
    std::vector<int> wrong;
    const std::vector<int> sample = SampleOfRows(ProblemOf(arm.rows, data));
    for (int i = 4; i < 900; i += 10) {
      if (std::find(sample.begin(), sample.end(), i) == sample.end()) wrong.push_back(i);
    }
    for (const int i : wrong) data.observations[static_cast<size_t>(i)].point_in_station *= -1.0;
    EXPECT_TRUE(test::CheckPlausible(ProblemOf(arm.rows, data)).plausible);  // wild rows: suspects
    for (const int i : wrong) data.observations[static_cast<size_t>(i)].point_in_station *= -1.0;
    for (const int i : wrong) data.shots[static_cast<size_t>(i)].station ^= 1;
    const CalibrationProblem problem = ProblemOf(arm.rows, data);
    const auto found = test::CheckPlausible(problem).finding;
    EXPECT_EQ(found.code, "station_label") << found.words;
    ASSERT_EQ(found.rows.size(), wrong.size()) << arm.name;
    for (size_t k = 0; k < wrong.size(); ++k) EXPECT_EQ(found.rows[k], "arm.csv:" + std::to_string(wrong[k] + 2));
    std::vector<std::string> suspects;
    for (const Suspect& suspect : FindSuspects(problem, EstimateJointly(problem))) {
      suspects.push_back(suspect.row);
      EXPECT_THAT(suspect.words, HasSubstr("fits as read from station S")) << suspect.row;
    }
    EXPECT_EQ(suspects, found.rows) << arm.name;
  }
}

// Zeros in place of what a joint did: where the robot cannot be explained, that joint is asked for.
TEST(Plausibility, AJointThatWasNotRecordedIsNamed) {
  for (const Arm& arm : Arms()) {
    Measurements data = Measure(arm.rows, 11, 60);
    for (Configuration& configuration : data.configurations) configuration.q[3] = 0.0;
    const Plausibility found = test::CheckPlausible(ProblemOf(arm.rows, data));
    ASSERT_FALSE(found.plausible);
    EXPECT_THAT(found.finding.words, HasSubstr("joint j4 stands still in all rows (0.0 to 0.0 deg): was it recorded?"));
  }
}

TEST(Plausibility, RealRobotsAreNotRefused) {
  if (!test::HasRealData()) GTEST_SKIP() << "no measured robots at " << test::RealData("");
  EXPECT_TRUE(test::CheckPlausible(test::RealProblem("ur5_gts3800", {"measurements.csv"}, Experiment())).plausible);
  for (const char* series : {"series_A.csv", "series_B.csv", "series_C.csv", "series_D.csv"})
    EXPECT_TRUE(test::CheckPlausible(test::RealProblem("ur10_leica", {series}, Experiment())).plausible) << series;
}

}  // namespace
}  // namespace sagitta::plausibility_test

// A mistake in a part of the rows is named with the part; rows that are sound, or wild, have none.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <numeric>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/diagnosis/cautions.h"
#include "estimator/inspection/inspect.h"
#include "estimator/inspection/reading_lint.h"
#include "tests/support/judged.h"
#include "tests/support/measured_arms.h"

namespace sagitta::wrong_part_test {
namespace {

using test::DhRow;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

// Two markers from one or two stations in each of `configurations`, of an arm with small errors.
Measurements TwoMarkers(const std::vector<DhRow>& nominal, int configurations, int stations = 1) {
  std::vector<DhRow> real = nominal;
  for (DhRow& row : real) row.a += 4e-4, row.theta_deg += 0.03;
  const Measurements drawn = test::Measure(real, 11, configurations);
  const std::vector<Eigen::Vector4d> markers = {{0.03, -0.02, 0.06, 1}, {-0.05, 0.04, 0.09, 1}};
  Measurements data = drawn;
  data.markers = {"M1", "M2"};
  data.stations = {"S1", "S2"};
  data.stations.resize(static_cast<size_t>(stations));
  data.shots.clear(), data.observations.clear(), data.files[0].rows.clear();
  for (int c = 0; c < configurations; ++c) {
    Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
    for (size_t j = 0; j < real.size(); ++j)
      pose = pose * test::Link(real[j], drawn.configurations[c].q[static_cast<Eigen::Index>(j)]);
    for (int s = 0; s < stations; ++s) {
      Shot shot = drawn.shots[c];
      shot.station = s;
      shot.observations.clear();
      for (int m = 0; m < 2; ++m) {
        Observation row = drawn.observations[c];
        const Vector3<double> p = (pose * markers[m]).head<3>();
        row.point_in_station = s == 0 ? p : Vector3<double>(1.2 - p.y(), p.x() + 0.4, p.z() + 0.1);
        row.shot = static_cast<int>(data.shots.size());
        row.marker = m;
        row.row = static_cast<int>(data.observations.size());
        data.files[0].rows.push_back({row.row + 2, {}});
        shot.observations.push_back(row.row);
        data.observations.push_back(row);
      }
      data.shots.push_back(shot);
    }
  }
  return data;
}

Finding FindingOf(const std::vector<DhRow>& rows, const Measurements& data) {
  const Plausibility found = test::CheckPlausible(test::ProblemOf(rows, data));
  return found.plausible ? Finding() : found.finding;
}

std::vector<std::vector<DhRow>> Arms() { return {test::Ur5Rows(), test::IiwaRows()}; }

TEST(WrongPart, SoundRowsHaveNone) {
  for (const std::vector<DhRow>& arm : Arms()) {
    EXPECT_EQ(FindingOf(arm, TwoMarkers(arm, 40)).words, "");
    EXPECT_EQ(FindingOf(arm, TwoMarkers(arm, 20, 2)).words, "");
  }
}

TEST(WrongPart, MarkersThatAreExchangedFromAShotOnAreNamed) {
  for (const std::vector<DhRow>& arm : Arms()) {
    Measurements data = TwoMarkers(arm, 40);
    for (size_t i = 50; i < 80; ++i) data.observations[i].marker ^= 1;
    Finding found = FindingOf(arm, data);
    EXPECT_EQ(found.code, "marker_swap") << found.words;
    EXPECT_THAT(found.words, HasSubstr("30 of 80 rows, those from arm.csv:52 on, miss"));
    EXPECT_THAT(found.words, HasSubstr("with markers M1 and M2 exchanged"));
    EXPECT_EQ(found.rows.size(), 30u);

    data = TwoMarkers(arm, 40);  // here and there, and what the other rows say is shown all the same
    for (const size_t i : {10u, 11u, 30u, 31u, 60u, 61u}) data.observations[i].marker ^= 1;
    found = FindingOf(arm, data);
    EXPECT_THAT(found.words, HasSubstr("6 of 80 rows, those of 3 shots (the first: arm.csv:12, the last: arm.csv:63)"));
    const Inspection inspection = Inspect(test::ProblemOf(arm, data));
    EXPECT_LT(inspection.linear.point, 1e-3);
    EXPECT_EQ(inspection.Count(Severity::kSerious), 1);
  }
}

TEST(WrongPart, PointsThatStandARowLateFromAShotOnAreNamed) {
  for (const std::vector<DhRow>& arm : Arms()) {
    for (const size_t first : {12u, 40u, 60u}) {
      Measurements data = TwoMarkers(arm, 40);
      for (size_t i = first; i < 78; ++i)
        data.observations[i].point_in_station = data.observations[i + 2].point_in_station;
      const Finding found = FindingOf(arm, data);
      EXPECT_EQ(found.code, "row_shift") << first << ": " << found.words;
      EXPECT_THAT(found.words, HasSubstr("those from arm.csv:" + std::to_string(first + 2) + " "));
    }
    Measurements data = TwoMarkers(arm, 40);
    for (const size_t i : {20u, 21u})
      std::swap(data.observations[i].point_in_station, data.observations[i + 2].point_in_station);
    EXPECT_THAT(FindingOf(arm, data).words, HasSubstr("with the points of these two shots exchanged"));
  }
}

TEST(WrongPart, AStationThatIsMirroredOrInMetresIsNamed) {
  for (const std::vector<DhRow>& arm : Arms()) {
    Measurements mirrored = TwoMarkers(arm, 20, 2), metres = mirrored;
    for (size_t i = 0; i < mirrored.observations.size(); ++i) {
      if (mirrored.shots[mirrored.observations[i].shot].station != 1) continue;
      mirrored.observations[i].point_in_station.y() *= -1.0;
      metres.observations[i].point_in_station *= 1e-3;
    }
    Finding found = FindingOf(arm, mirrored);
    EXPECT_EQ(found.code, "mirrored") << found.words;
    EXPECT_THAT(found.words, HasSubstr("40 of 80 rows, those of station S2"));
    EXPECT_THAT(found.remedy, HasSubstr("for these rows alone"));
    found = FindingOf(arm, metres);
    EXPECT_EQ(found.code, "unit") << found.words;
    EXPECT_THAT(found.words, HasSubstr("metres in place of millimetres"));
  }
}

// One row of each shot in the order of a coordinate, the joint values as they were.
TEST(WrongPart, PointsThatWereSortedAloneAreNamed) {
  const std::vector<DhRow> arm = test::Ur5Rows();
  for (const int axis : {0, 1, 2}) {
    Measurements data = TwoMarkers(arm, 40);
    const Measurements stated = data;
    std::vector<size_t> order(40);
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(), [&](size_t a, size_t b) {
      return stated.observations[2 * a].point_in_station[axis] < stated.observations[2 * b].point_in_station[axis];
    });
    for (size_t k = 0; k < 80; ++k)
      data.observations[k].point_in_station = stated.observations[2 * order[k / 2] + k % 2].point_in_station;
    const Finding found = FindingOf(arm, data);
    EXPECT_EQ(found.code, "row_order") << axis << ": " << found.words;
    EXPECT_THAT(found.words, HasSubstr(std::string("were sorted by ") + "xyz"[axis]));
  }
}

// What is held out judges the calibration: a mistake in it is one.
TEST(WrongPart, HeldOutRowsAreNamedToo) {
  const std::vector<DhRow> arm = test::Ur5Rows();
  Measurements data = TwoMarkers(arm, 40);
  for (const size_t i : {10u, 11u, 30u, 31u, 60u, 61u}) data.observations[i].marker ^= 1;
  CalibrationProblem problem = test::ProblemOf(arm, data);
  for (const size_t c : {3u, 5u, 15u, 17u, 30u}) problem.mutable_data()->configurations[c].is_validation = true;
  const Plausibility found = test::CheckPlausible(problem);
  ASSERT_FALSE(found.plausible);
  EXPECT_THAT(found.finding.words, HasSubstr("6 of 80 rows, those of 3 shots"));
}

// Where a diagnosis goes on with such rows, it says the same, and names the rows.
TEST(WrongPart, ADiagnosisSaysWhatIsKnownOfTheRows) {
  const std::vector<DhRow> arm = test::Ur5Rows();
  Measurements data = TwoMarkers(arm, 40);
  for (const size_t i : {10u, 11u, 30u, 31u, 60u, 61u}) data.observations[i].marker ^= 1;
  const auto problem = std::make_shared<CalibrationProblem>(test::ProblemOf(arm, data));
  EXPECT_THAT(CautionsOfReadings(*problem), ElementsAre(HasSubstr("with markers M1 and M2 exchanged")));
  DiagnosedModel believed;
  believed.problem = problem;
  believed.estimate = EstimateJointly(*problem);
  EXPECT_THAT(FindCautions(*problem, believed)[0],
              AllOf(HasSubstr("6 rows are suspect (arm.csv:12: "), HasSubstr("fits as marker M1 of the same shot")));
}

// Of readings that fit alike, the one that the joint limits allow.
TEST(WrongPart, JointLimitsDecideBetweenEqualReadings) {
  Measurements data = test::Measure(test::PumaStandardRows(), 3, 40);
  for (Configuration& configuration : data.configurations) configuration.q[4] += kPi;
  EXPECT_THAT(FindingOf(test::PumaStandardRows(), data).words,
              HasSubstr("with alpha of joint j5 of the other sign, and"));
  Robot robot = test::ProblemOf(test::PumaStandardRows(), data).robot();
  for (Joint& joint : robot.chain.joints) joint.min = -125.0 * kDegree, joint.max = 125.0 * kDegree;
  const Finding found = test::CheckPlausible(MakeCalibrationProblem(robot, data, Experiment())).finding;
  EXPECT_THAT(found.words,
              HasSubstr("with joint j5 with its zero 180 deg away; what else fits goes beyond the limits"));
}

// Rows that are off by what no reading explains.
TEST(WrongPart, WildRowsAreNoPart) {
  for (const std::vector<DhRow>& arm : Arms()) {
    Measurements data = TwoMarkers(arm, 40);
    for (size_t i = 50; i < 80; ++i)
      data.observations[i].point_in_station.x() += 0.1 + 0.02 * static_cast<double>(i * 7 % 11);
    EXPECT_THAT(FindingOf(arm, data).words, Not(HasSubstr("they fit within")));
  }
}

}  // namespace
}  // namespace sagitta::wrong_part_test

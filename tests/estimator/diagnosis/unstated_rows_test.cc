// A few empty cells cost their rows, not what their column drives.
#include "estimator/diagnosis/unstated_rows.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/kr270_experiment.h"

namespace sagitta::unstated_rows_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Every shot but the first `unstated` has its minute.
CalibrationProblem WithTimes(int unstated) {
  Measurements data = test::DesignMeasurements(test::Kr270Design());
  test::MeasureKr270(test::Kr270Truth(), 1e-5, 3, &data);
  for (int s = 0; s < static_cast<int>(data.shots.size()); ++s) {
    data.shots[s].has_time = s >= unstated;
    data.shots[s].time = s >= unstated ? 60.0 * s : 0.0;
  }
  return test::Kr270ProblemOf(data, Experiment());
}

TEST(UnstatedRows, OfAFewShotsAreLeftOut) {
  const CalibrationProblem problem = WithTimes(2);
  std::vector<std::string> cautions;
  const std::optional<CalibrationProblem> without = WithoutUnstatedRows(problem, &cautions);
  ASSERT_TRUE(without);
  EXPECT_THAT(cautions,
              ElementsAre(HasSubstr("2 of " + std::to_string(problem.data().shots.size()) + " shots (time_s)")));
  for (const Observation& row : without->data().observations) EXPECT_EQ(row.excluded, row.shot < 2);
  for (const ShotInput& shot : without->shot_inputs()) EXPECT_TRUE(shot.conditions.has_time);
  EXPECT_FALSE(problem.shot_inputs()[0].conditions.has_time);
  EXPECT_EQ(without->CalibrationObservations().size(), problem.CalibrationObservations().size() -
                                                           problem.data().shots[0].observations.size() -
                                                           problem.data().shots[1].observations.size());
}

TEST(UnstatedRows, OfManyShotsOrNoneStay) {
  std::vector<std::string> cautions;
  const int all = static_cast<int>(WithTimes(0).data().shots.size());
  for (const int unstated : {0, 3 + all / 4, all}) EXPECT_FALSE(WithoutUnstatedRows(WithTimes(unstated), &cautions));
  EXPECT_THAT(cautions, ElementsAre());
}

}  // namespace
}  // namespace sagitta::unstated_rows_test

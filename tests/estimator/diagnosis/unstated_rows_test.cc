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

// A quarter of all and less, but all that there is of a station, of a marker or of the hold-out: what is calibrated
// would no longer be determined, or no longer judged.
TEST(UnstatedRows, OfOnePartStay) {
  std::vector<std::string> cautions;
  const Measurements timed = WithTimes(0).data();
  const int all = static_cast<int>(timed.shots.size()), few = all / 6;
  const auto problem_of = [&](const std::function<void(Measurements*)>& change) {
    Measurements data = timed;
    for (int s = 0; s < few; ++s) data.shots[s].has_time = false;
    change(&data);
    return test::Kr270ProblemOf(data, Experiment());
  };
  EXPECT_TRUE(WithoutUnstatedRows(problem_of([](Measurements*) {}), &cautions));
  EXPECT_EQ(cautions.size(), 1u);
  const std::function<void(Measurements*)> changes[] = {[few](Measurements* data) {
                                                          for (int s = 0; s < static_cast<int>(data->shots.size()); ++s)
                                                            data->shots[s].station = s < few ? 0 : 1;
                                                        },
                                                        [few](Measurements* data) {
                                                          for (Observation& row : data->observations)
                                                            row.excluded =
                                                                row.excluded || (row.marker == 1 && row.shot >= few);
                                                        }};
  for (const auto& change : changes) EXPECT_FALSE(WithoutUnstatedRows(problem_of(change), &cautions));
  Experiment experiment;
  experiment.validation.kind = ValidationSpec::Kind::kFraction;
  experiment.validation.fraction = 0.2;
  CalibrationProblem held_out = test::Kr270ProblemOf(timed, experiment);
  for (Shot& shot : held_out.mutable_data()->shots) {
    shot.has_time = !held_out.data().configurations[shot.configuration].is_validation;
  }
  held_out.RenewShots();
  EXPECT_FALSE(WithoutUnstatedRows(held_out, &cautions));
  EXPECT_EQ(cautions.size(), 1u);
}

}  // namespace
}  // namespace sagitta::unstated_rows_test

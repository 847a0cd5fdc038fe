// What passes over all rows ends at the next one where it is interrupted.
#include <gtest/gtest.h>

#include "estimator/inspection/inspect.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/results/residuals_csv.h"
#include "tests/support/interruptible.h"
#include "tests/support/kr270_experiment.h"

namespace sagitta::interruption_test {
namespace {

using test::ExpectInterruptible;

class InterruptionOfRows : public ::testing::Test {
 protected:
  InterruptionOfRows() : problem_(test::Kr270Problem({}, {}, 1)) {}

  CalibrationProblem problem_;
};

TEST_F(InterruptionOfRows, Predictions) {
  ExpectInterruptible([&] { PredictPoints(problem_, problem_.parameters, problem_.CalibrationObservations()); });
}

TEST_F(InterruptionOfRows, Linearizations) {
  const std::vector<int> rows = problem_.CalibrationObservations();
  const NoiseRoots roots(rows.size(), Matrix3<double>::Identity());
  ExpectInterruptible([&] {
    Linearize(problem_, problem_.parameters, rows, problem_.parameters.EstimatedCoordinates(), roots,
              LatentTreatment::kIgnore);
  });
}

TEST_F(InterruptionOfRows, Shots) {
  ExpectInterruptible([&] { CalibrationProblem(problem_).RenewShots(); });
}

TEST_F(InterruptionOfRows, Tables) {
  ExpectInterruptible([&] { RowsToCsv(problem_.data(), {}); });
}

TEST_F(InterruptionOfRows, Inspections) {
  ExpectInterruptible([&] { Inspect(problem_); });
}

}  // namespace
}  // namespace sagitta::interruption_test

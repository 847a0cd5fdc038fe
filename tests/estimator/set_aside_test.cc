// Outliers that no model gives are left out of every figure that is compared.
#include "estimator/diagnosis/set_aside.h"

#include <gtest/gtest.h>

#include "estimator/diagnosis/gap.h"
#include "tests/support/moved_kr270.h"

namespace sagitta::set_aside_test {
namespace {

CalibrationProblem WithOneHeldOutReadingOff() {
  Measurements data = test::MeasuredAfter(test::CampaignOf(30, 1, 2e-5, 7), 107, [](Eigen::VectorXd*) {});
  Experiment experiment;
  experiment.validation.kind = ValidationSpec::Kind::kFraction;
  experiment.validation.fraction = 0.25;
  CalibrationProblem problem = MakeCalibrationProblem(test::Kr270Robot(), data, experiment);
  const int off = problem.ValidationObservations().front();
  problem.mutable_data()->observations[off].point_in_station.x() += 5e-3;
  return problem;
}

TEST(SetAside, NoModelThatIsComparedCountsAHeldOutOutlier) {
  const DiagnosedModel fitted = FitFully(WithOneHeldOutReadingOff(), {});
  const double with = HoldoutRms(fitted);
  DiagnosedModel baseline = fitted, final = fitted, lacking = fitted;
  std::vector<DiagnosedModel> prefixes = {fitted, fitted};
  SetAside aside(0.01, {});
  aside.FromHeldOut(false, &baseline, &final, &lacking, &prefixes);
  ASSERT_EQ(aside.held_out(), 1);
  for (const DiagnosedModel* model : {&baseline, &final, &lacking, &prefixes[0], &prefixes[1]}) {
    EXPECT_LT(HoldoutRms(*model), 3.0 * 2e-5);
  }
  EXPECT_EQ(HoldoutRms(fitted), with);  // models share problems: others keep theirs
}

}  // namespace
}  // namespace sagitta::set_aside_test

// Evidence is weighed where the model is linear: about what was found.
#include "estimator/diagnosis/leading_set.h"

#include <gtest/gtest.h>

#include <cmath>

#include "estimator/diagnosis/refit_order.h"
#include "estimator/statistics/distributions.h"
#include "tests/support/kr270_experiment.h"
#include "tests/support/moved_kr270.h"

namespace sagitta::leading_set_test {
namespace {

// Joint 2 swings by 2 mrad: what that moves the points by differs from the linear model's by up to theta^2 / 2 times 2
// m of arm, four times sigma. Joint 4 deviates by little more than the noise.
CalibrationProblem Campaign() {
  const test::Kr270Design design = test::CampaignOf(60, 1, 1e-6, 11);
  const Measurements data = test::MeasuredAfter(design, 411, [](Eigen::VectorXd* q) {
    (*q)[3] += 5e-6 * std::cos(2.0 * (*q)[3]);
    (*q)[1] += 2e-3 * std::cos(2.0 * (*q)[1]);
  });
  return MakeCalibrationProblem(test::Kr270Robot(), data, Experiment());
}

TEST(LeadingSet, IsWeighedAboutWhatWasFound) {
  const CalibrationProblem problem = Campaign();
  const DiagnosedModel baseline = FitFully(problem, JointOptions());
  const PriorMasses prior;
  const JointOptions joint;
  const ParameterSet& believed = baseline.estimate.parameters;
  const CandidateList candidates = ListCandidates(problem, believed);
  const LeadingSet found = FindLeading({problem, baseline, prior, kInfinity, 0.9, joint, nullptr}, nullptr);
  ASSERT_TRUE(found.is_named);
  ASSERT_TRUE(found.refitted.IsUsable());
  std::vector<std::string> paths;
  for (const SelectedEffect& effect : found.refitted.effects) paths.push_back(effect.candidate.spec.Path());
  EXPECT_EQ(paths,
            (std::vector<std::string>{"effect/joint_harmonic[order=2]/A2", "effect/joint_harmonic[order=2]/A4"}));
  EXPECT_FALSE(found.is_refuted);
  EXPECT_LT(std::abs(LogFullOverLinear(*found.evidence, found.refitted)), kInDoubt);

  // About the believed model the same set is off by far more.
  const Evidence about_believed(problem, believed, candidates, prior, kInfinity, nullptr);
  Posterior posterior = PosteriorOf(about_believed, about_believed.models());
  ASSERT_FALSE(posterior.sets.empty());
  const WeightedModel& leading = about_believed.models()[posterior.sets[posterior.Leading(0.9)].best];
  const RefittedSet refitted = RefitSet(about_believed, leading, problem, baseline, joint);
  ASSERT_TRUE(refitted.IsUsable());
  EXPECT_GT(std::abs(LogFullOverLinear(about_believed, refitted)), 5.0 * kInDoubt);
}

// The first linearization is off by far more than is in doubt (as above): a search that ends there has to say so.
TEST(LeadingSet, SaysWhereTheLinearModelStaysWrong) {
  const CalibrationProblem problem = Campaign();
  const DiagnosedModel baseline = FitFully(problem, JointOptions());
  const PriorMasses prior;
  const JointOptions joint;
  const LeadingSet found = FindLeading({problem, baseline, prior, kInfinity, 0.9, joint, nullptr, 0}, nullptr);
  ASSERT_TRUE(found.is_named);
  EXPECT_TRUE(found.is_refuted);
}

// 30 poses, one a minute, 45 minutes of lunch, 30 more, in which the tripod stands elsewhere than before. A drift and a
// warming up that begins anew fit that too, with twelve numbers whose slopes cancel.
TEST(LeadingSet, ATripodThatWasKnockedInAPauseNeitherDriftsNorWarmsUp) {
  const test::Kr270Design design = test::CampaignOf(60, 1, 5e-5, 12);
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(test::Kr270Truth(), design.sigma, 413, &data);
  for (Shot& shot : data.shots) {
    shot.has_time = true;
    shot.time = 60.0 * shot.configuration + (shot.configuration < 30 ? 0.0 : 2700.0);
  }
  const Vector3<double> moved(-58e-6, -22e-6, -34e-6), turned(59e-6, 30e-6, 16e-6);
  for (Observation& row : data.observations) {
    if (data.shots[row.shot].configuration < 30) continue;
    row.point_in_station += moved + turned.cross(row.point_in_station);
  }
  const CalibrationProblem problem = MakeCalibrationProblem(test::Kr270Robot(), data, Experiment());
  const DiagnosedModel baseline = FitFully(problem, JointOptions());
  const PriorMasses prior;
  const JointOptions joint;
  const LeadingSet found = FindLeading({problem, baseline, prior, kInfinity, 0.9, joint, nullptr}, nullptr);
  ASSERT_TRUE(found.is_named);
  EXPECT_TRUE(found.refitted.effects.empty());
  ASSERT_EQ(found.refitted.model.set.members.size(), 1u);
  const int member = found.refitted.model.set.members[0];
  ASSERT_TRUE(found.evidence->list().IsUnnamed(member));
  const UnnamedFunction& function = found.evidence->list().functions[found.evidence->list().unnamed[member]];
  EXPECT_EQ(function.acts_on, "S1");
  EXPECT_EQ(function.sources.size(), 6u);
  EXPECT_EQ(function.kind, "step");
}

}  // namespace
}  // namespace sagitta::leading_set_test

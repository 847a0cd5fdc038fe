// How the prior of an effect is shared by its settings.
#include <gtest/gtest.h>

#include "estimator/explanations/explanations.h"
#include "tests/support/kr270_experiment.h"
#include "tests/support/moved_kr270.h"

namespace sagitta::prior_shares_test {
namespace {

constexpr double kCatalogue = 0.38 / 0.5;  // of the probability that something is missing

// An effect on this target with each of these settings, where nothing else may be missing.
ExplanationList Listed(const std::string& effect, const std::string& target,
                       const std::vector<std::map<std::string, std::string>>& settings) {
  const Measurements data = test::MeasuredAfter(test::CampaignOf(40, 1, 2e-5, 7), 107, [](Eigen::VectorXd*) {});
  const CalibrationProblem problem = MakeCalibrationProblem(test::Kr270Robot(), data, Experiment());
  CandidateList candidates;
  for (const auto& own : settings) candidates.candidates.push_back({{effect, target, own, {}}});
  EvidenceColumns columns(problem, problem.parameters, candidates.candidates);
  const bool with_unnamed = false;
  return ListExplanations(problem, problem.parameters, candidates, PriorMasses(), &columns, with_unnamed);
}

std::vector<double> SharesOf(const std::string& effect,
                             const std::vector<std::map<std::string, std::string>>& settings) {
  std::vector<double> shares;
  for (const Explanation& explanation : Listed(effect, "A1", settings).math) shares.push_back(explanation.share);
  return shares;
}

// Play by torque is of one width or another, play by approach has none: either has half of what play on a joint has.
TEST(PriorShares, ScannedWidthsShareWhatIsOneExplanation) {
  const std::vector<double> shares = SharesOf("backlash", {{{"by", "approach"}},
                                                           {{"by", "torque"}, {"width_Nm", "10"}},
                                                           {{"by", "torque"}, {"width_Nm", "100"}},
                                                           {{"by", "torque"}, {"width_Nm", "1000"}}});
  ASSERT_EQ(shares.size(), 4u);
  for (size_t k = 0; k < 4; ++k) EXPECT_NEAR(shares[k], kCatalogue / (k == 0 ? 2.0 : 6.0), 1e-12);
}

// Six orders are equally likely, those beyond evenly over the logarithm.
TEST(PriorShares, ManyOrdersLeaveTheFirstItsShare) {
  const std::vector<double> shares =
      SharesOf("joint_harmonic", {{{"order", "1"}}, {{"order", "6"}}, {{"order", "60"}}});
  ASSERT_EQ(shares.size(), 3u);
  for (size_t k = 0; k < 3; ++k) EXPECT_NEAR(shares[k], kCatalogue / 2.1 * (k == 2 ? 0.1 : 1.0), 1e-12);
}

// A reflector has one axis: the directions are names of their own, each with its share, of which one can hold. A joint
// may have two periodic errors.
TEST(PriorShares, AReflectorHasOneAxis) {
  const ExplanationList axes = Listed("marker_acceptance", "P1", {{{"axis", "y"}}, {{"axis", "z"}}});
  ASSERT_EQ(axes.math.size(), 2u);
  EXPECT_NE(axes.name[0], axes.name[1]);
  EXPECT_EQ(axes.math[0].excludes, axes.math[1].excludes);
  for (const Explanation& axis : axes.math) EXPECT_NEAR(axis.share, kCatalogue / 2.0, 1e-12);
  const ExplanationList orders = Listed("joint_harmonic", "A1", {{{"order", "1"}}, {{"order", "2"}}});
  EXPECT_NE(orders.math[0].excludes, orders.math[1].excludes);
}

}  // namespace
}  // namespace sagitta::prior_shares_test

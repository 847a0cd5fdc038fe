// How probable a spring is before any row is seen follows from what it does to the arm's weight.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "estimator/diagnosis/selected_effects.h"
#include "estimator/explanations/compensator_shapes.h"
#include "tests/support/spring_campaign.h"

namespace sagitta::spring_prior_test {
namespace {

TEST(SpringShares, AreOfWhatPullsAgainstTheWeight) {
  SpringShares shares{Eigen::Vector3d(3.0, 4.0, 0.0), 0.5, 0.01};
  EXPECT_NEAR(shares.Of(Eigen::Vector3d(-6.0, -8.0, 0.0)), 0.51, 1e-12);
  EXPECT_NEAR(shares.Of(Eigen::Vector3d(-1.0, 0.0, 0.0)), 0.01 + 0.5 * 0.36, 1e-12);
  EXPECT_NEAR(shares.Of(Eigen::Vector3d(6.0, 8.0, 0.0)), 0.01, 1e-12);
  EXPECT_NEAR(shares.Of(Eigen::Vector3d::Zero()), 0.01, 1e-12);
}

// The best of the shapes by itself.
WeightedModel SpringAlone(const Evidence& evidence) {
  WeightedModel best;
  const SetSearch search = evidence.SearchIn(0);
  best.set.log_weight = -std::numeric_limits<double>::infinity();
  for (size_t k = 0; k < evidence.list().math.size(); ++k) {
    const EffectSpec& start = evidence.list().start[k];
    if (!IsNewSpring(start) || start.target != "A2") continue;
    const WeightedSet set = search.Evaluate({static_cast<int>(k)});
    if (set.log_weight > best.set.log_weight) best.set = set;
  }
  return best;
}

// A spring with its anchor on the other side, which pulls along the weight, is none that carries any.
TEST(SpringPrior, IsOfTheSpringThatWasFitted) {
  const CalibrationProblem problem = test::SpringCampaign(test::WithSpring(), true, {"A2", "A3", "A4", "A5", "A6"});
  const JointOptions options;
  const DiagnosedModel baseline = FitFully(problem, options);
  const ParameterSet& believed = baseline.estimate.parameters;
  const Evidence evidence(problem, believed, ListCandidates(problem, believed), PriorMasses(),
                          std::numeric_limits<double>::infinity(), nullptr);
  RefittedSet refitted = RefitSet(evidence, SpringAlone(evidence), problem, baseline, options);
  ASSERT_TRUE(refitted.IsUsable());
  const double against = LogPriorOfFitted(evidence, refitted, refitted.effects[0]);
  EXPECT_GT(against, -3.0);
  ParameterSet& parameters = refitted.with_effects.estimate.parameters;
  Eigen::VectorXd turn = Eigen::VectorXd::Zero(parameters.num_coordinates());
  for (const CompensatorPart part : {CompensatorPart::kAx, CompensatorPart::kAy}) {
    const int i = parameters.FindCoordinate(part);
    turn[i] = -2.0 * parameters.Value(i);
  }
  parameters.Plus(turn);
  const double elsewhere = evidence.list().springs.at("A2").elsewhere;
  const double weight = evidence.list().place[refitted.effects[0].explanation].weight;
  EXPECT_NEAR(LogPriorOfFitted(evidence, refitted, refitted.effects[0]),
              LogPriorOfSpring(parameters) + std::log(elsewhere / weight), 1e-9);
  EXPECT_LT(std::log(elsewhere / weight), -3.0);
}

}  // namespace
}  // namespace sagitta::spring_prior_test

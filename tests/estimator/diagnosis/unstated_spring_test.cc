// A spring on a joint whose compliance the robot file does not state: it is found together with that compliance.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "estimator/diagnosis/diagnose.h"
#include "estimator/diagnosis/selected_effects.h"
#include "estimator/explanations/compensator_shapes.h"
#include "estimator/results/diagnosis_json.h"
#include "tests/support/spring_campaign.h"

namespace sagitta::unstated_spring_test {
namespace {

const std::vector<std::string> kAllButA2 = {"A3", "A4", "A5", "A6"};

bool IsSpringListed(const CandidateList& list, const std::string& joint) {
  return std::any_of(list.candidates.begin(), list.candidates.end(), [&](const Candidate& candidate) {
    return IsGravityCompensator(candidate.spec) && candidate.spec.target == joint;
  });
}

// An arm with a spring on A2, of which every other compliance is stated.
struct Weighed {
  CalibrationProblem problem = test::SpringCampaign(test::WithSpring(), true, kAllButA2);
  DiagnosedModel baseline = FitFully(problem, JointOptions());
  Evidence evidence{problem,
                    baseline.estimate.parameters,
                    ListCandidates(problem, baseline.estimate.parameters),
                    PriorMasses(),
                    std::numeric_limits<double>::infinity(),
                    nullptr};
};

TEST(UnstatedSpring, IsACandidateWhereLoadsShowTheCompliance) {
  const CalibrationProblem loaded = test::SpringCampaign(test::WithSpring(), true, kAllButA2),
                           unloaded = test::SpringCampaign(test::WithSpring(), false, {});
  EXPECT_TRUE(IsSpringListed(ListCandidates(loaded, loaded.parameters), "A2"));
  const CandidateList list = ListCandidates(unloaded, unloaded.parameters);
  EXPECT_FALSE(IsSpringListed(list, "A2"));
  EXPECT_TRUE(std::any_of(list.not_testable.begin(), list.not_testable.end(), [](const NotTestable& entry) {
    return entry.effect == kGravityCompensator && entry.target == "A2" && entry.lack == Lack::kCompliance;
  }));
}

// All shapes on A2 need it, those on A3, of which the model has a compliance, need none.
TEST(UnstatedSpring, NeedsTheComplianceInItsSet) {
  const Weighed weighed;
  const Evidence& evidence = weighed.evidence;
  const ExplanationList& list = evidence.list();
  int springs = 0, elsewhere = 0;
  for (int k = 0; k < static_cast<int>(list.math.size()); ++k) {
    if (!IsNewSpring(list.start[k])) {
      EXPECT_EQ(list.math[k].needs, kNoExplanation);
    } else if (list.start[k].target == "A2") {
      ++springs;
      ASSERT_GE(list.math[k].needs, 0);
      EXPECT_EQ(list.name[list.math[k].needs], ComplianceEffectOf("A2").Path());
    } else if (list.start[k].target != "A1") {
      ++elsewhere;
      EXPECT_EQ(list.math[k].needs, kNoExplanation);
    }
  }
  EXPECT_GT(springs, 100);
  EXPECT_GT(elsewhere, 100);
  for (const WeightedModel& model : evidence.models()) {
    for (const int m : model.set.members) {
      EXPECT_TRUE(list.math[m].needs == kNoExplanation ||
                  std::binary_search(model.set.members.begin(), model.set.members.end(), list.math[m].needs));
    }
  }
}

// The compliance starts from its value in the set, directly before the spring, whatever else is strong.
TEST(UnstatedSpring, ComesDirectlyAfterTheCompliance) {
  const Weighed weighed;
  const Evidence& evidence = weighed.evidence;
  const ExplanationList& list = evidence.list();
  const auto first = [&](const std::string& effect, const std::string& target) {
    const auto is_it = [&](const EffectSpec& spec) { return spec.effect == effect && spec.target == target; };
    return static_cast<int>(std::find_if(list.start.begin(), list.start.end(), is_it) - list.start.begin());
  };
  const int compliance = first("joint_compliance", "A2"), spring = first(kGravityCompensator, "A2");
  for (const char* other : {"A1", "A2", "A3", "A5"}) {
    const std::vector<int> members = EachOnce({compliance, spring, first("encoder_gain", other)});
    const WeightedModel model{0, evidence.SearchIn(0).Evaluate(members), 0.0, 0.0};
    const std::vector<SelectedEffect> effects = SelectedEffectsOf(evidence, model, weighed.baseline);
    ASSERT_EQ(effects.size(), 3u);
    const size_t at = effects[0].explanation == compliance ? 0 : 1;
    EXPECT_EQ(effects[at].explanation, compliance);
    EXPECT_EQ(effects[at + 1].explanation, spring);
    ASSERT_EQ(effects[at].candidate.spec.values.size(), 1u);
    EXPECT_GT(effects[at].candidate.spec.values[0], 0.0);
    EXPECT_GE(effects[at].loss, effects[at + 1].loss);
  }
}

// Of less than nothing, the spring would do the same the other way round.
TEST(UnstatedSpring, ActsThroughNoNegativeCompliance) {
  const CalibrationProblem problem = test::SpringCampaign(test::WithSpring(), true, kAllButA2);
  const JointOptions options;
  const DiagnosedModel baseline = FitFully(problem, options);
  Candidate compliance{ComplianceEffectOf("A2")}, spring{CompensatorShapes("A2")[40]};
  compliance.spec.values = {3e-7};
  spring.spec.values[3] = 0.3;
  spring.spec.values[4] = 1e4;
  const auto lower = [&](const std::vector<Candidate>& added) {
    const DiagnosedModel extended = Extend(baseline, added, options);
    const ParameterSet& parameters = extended.problem->parameters;
    return parameters.coordinates()[parameters.FindCoordinate(ComplianceEffectOf("A2").Path() + "/k")].lower;
  };
  EXPECT_EQ(lower({compliance}), -std::numeric_limits<double>::infinity());
  EXPECT_EQ(lower({compliance, spring}), 0.0);
}

TEST(UnstatedSpring, IsNamedWithTheComplianceThatItActsThrough) {
  const test::LoadedTruth truth = test::WithSpring();
  const Diagnosis diagnosis = Diagnose(test::SpringCampaign(truth, true, kAllButA2), DiagnosisOptions());
  std::vector<std::string> named;
  for (const FoundEffect& effect : diagnosis.effects) {
    named.push_back(effect.candidate.spec.effect + " " + effect.candidate.spec.target);
  }
  EXPECT_THAT(named, ::testing::ElementsAre("joint_compliance A2", "gravity_compensator A2"));
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kExplained);
  const Robot robot = RobotOf(diagnosis.final);
  ASSERT_TRUE(robot.gravity_compensator);
  const auto own = std::find_if(robot.compliances.begin(), robot.compliances.end(),
                                [](const JointCompliance& compliance) { return compliance.joint == 1; });
  ASSERT_NE(own, robot.compliances.end());
  EXPECT_NEAR(own->nodes[0].k, truth.k[1], 0.05 * truth.k[1]);
}

}  // namespace
}  // namespace sagitta::unstated_spring_test

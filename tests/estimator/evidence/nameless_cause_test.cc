// One cause without a name against several causes: what may be a piece of what, the odds by hand, and whole diagnoses
// of data whose cause the catalogue does not hold.
#include "estimator/evidence/nameless_cause.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "estimator/diagnosis/diagnose.h"
#include "estimator/report/diagnosis_words.h"
#include "tests/support/moved_kr270.h"

namespace sagitta::nameless_cause_test {
namespace {

// Everything in it has one column and its share.
class List {
 public:
  int Named(const std::string& effect, const std::string& target, double share) {
    list.candidates.push_back(Candidate{EffectSpec{effect, target, {}, {}}});
    return Append(static_cast<int>(list.candidates.size()) - 1, -1, share);
  }
  int Nameless(const std::string& acts_on, const std::vector<std::string>& depends_on, DriverKind kind, double share) {
    UnnamedFunction function;
    function.acts_on = acts_on;
    function.depends_on = depends_on;
    function.driver.kind = kind;
    list.functions.push_back(function);
    return Append(-1, static_cast<int>(list.functions.size()) - 1, share);
  }

  ExplanationList list;

 private:
  int Append(int candidate, int unnamed, double share) {
    list.math.push_back({{{0}, {}}, share, static_cast<int>(list.math.size())});
    list.candidate.push_back(candidate);
    list.unnamed.push_back(unnamed);
    return static_cast<int>(list.math.size()) - 1;
  }
};

TEST(NamelessCause, PiecesAreOfTheSamePartOrHaveTheSameDriver) {
  List all;
  const int gain1 = all.Named("encoder_gain", "A1", 0.1), gain2 = all.Named("encoder_gain", "A2", 0.1);
  const int payload = all.Named("payload", "H", 0.1), growth = all.Named("thermal_growth", "robot", 0.1);
  const int slip = all.Named("joint_slip", "A3", 0.1), shift = all.Named("marker_shift", "M1", 0.1);
  const int angle = all.Nameless("A1", {"A2"}, DriverKind::kAngle, 0.1);
  const int torque = all.Nameless("A4", {"A4"}, DriverKind::kTorque, 0.1);
  const int heat = all.Nameless("links", {"temperature"}, DriverKind::kTemperature, 0.1);
  const int time = all.Nameless("S1", {"time"}, DriverKind::kTime, 0.1);
  const int seat = all.Nameless("M1", {"gravity"}, DriverKind::kOther, 0.1);
  const Robot robot = test::Kr270Robot();
  NamelessCauses causes(robot, all.list, 0.3);
  const std::vector<int> named = {gain1, gain2, payload, growth, slip, shift};
  const auto pieces_beside = [&](int function) {
    std::vector<int> members = named;
    members.push_back(function);
    const NamelessCauses::Cause cause = causes.OneOf(members);
    EXPECT_EQ(cause.functions, std::vector<int>{function});
    return cause.pieces;
  };
  EXPECT_EQ(pieces_beside(angle), (std::vector<int>{gain1, gain2}));
  EXPECT_EQ(pieces_beside(torque), std::vector<int>{payload});
  EXPECT_EQ(pieces_beside(heat), std::vector<int>{growth});
  EXPECT_EQ(pieces_beside(time), (std::vector<int>{slip, shift}));
  EXPECT_EQ(pieces_beside(seat), (std::vector<int>{payload, shift}));
  EXPECT_TRUE(causes.OneOf(named).pieces.empty());
}

TEST(NamelessCause, OddsAreThoseOfTheTwoPriors) {
  List all;
  const int gain = all.Named("encoder_gain", "A1", 0.02), wobble = all.Named("axis_wobble", "A1", 0.05);
  const int other = all.Named("encoder_gain", "A2", 0.4);
  const int angle = all.Nameless("A1", {"A1"}, DriverKind::kAngle, 0.1);
  const Robot robot = test::Kr270Robot();
  NamelessCauses causes(robot, all.list, 0.3);
  const auto odds = [&](const std::vector<int>& members) {
    return std::exp(causes.LogPriorOdds(members, causes.OneOf(members)));
  };
  // Two causes, drawn in either order, with 0.3 for the second: 0.3 2 0.02 of the gain with the function. One cause
  // with a piece like it: 0.3 0.02 / (0.02 + 0.05).
  EXPECT_NEAR(odds({gain, angle}), (0.3 * 0.02 / 0.07) / (0.3 * 2.0 * 0.02), 1e-12);
  // Of three causes one further one was seen: (0.3 + 1) / 2 that there is one more.
  EXPECT_NEAR(odds({gain, other, angle}), (0.3 / 0.07) / (0.65 * 3.0), 1e-12);
  EXPECT_NEAR(odds({gain, wobble, angle}), std::pow((0.3 / 0.07) / (0.65 * 3.0), 2), 1e-12);
  EXPECT_EQ(odds({gain, wobble}), 1.0);
  EXPECT_EQ(odds({other, angle}), 1.0);
}

template <typename Move>
Diagnosis DiagnosisOf(const Move& move) {
  Measurements data = test::MeasuredAfter(test::CampaignOf(60, 1, 2e-5, 21), 22, move);
  Experiment experiment;
  experiment.validation.kind = ValidationSpec::Kind::kFraction;
  experiment.validation.fraction = 0.25;
  return Diagnose(MakeCalibrationProblem(test::Kr270Robot(), data, experiment), DiagnosisOptions());
}

// A ripple beyond the orders of the catalogue with a slow part that looks like a wrong encoder gain.
TEST(NamelessCause, ARippleWithASlowPartIsNotAnEncoderGain) {
  const Diagnosis diagnosis = DiagnosisOf(
      [](Eigen::VectorXd* q) { (*q)[1] += 6e-5 * std::cos(45.0 * (*q)[1]) + 6e-5 * std::sin(2.0 / 3.0 * (*q)[1]); });
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kUnknown);
  for (const auto& [spec, probability] : diagnosis.posterior.explanations) EXPECT_LT(probability, 0.5) << spec.Path();
  const std::vector<std::string>& leading = diagnosis.posterior.sets.at(0).unnamed;
  const auto piece = std::find_if(leading.begin(), leading.end(), [](const std::string& words) {
    return words.find("in part like ") == 0 && words.find(" on A2") != std::string::npos;
  });
  ASSERT_NE(piece, leading.end());
  EXPECT_NE(UnexplainedInWords(diagnosis).find("; " + *piece), std::string::npos) << UnexplainedInWords(diagnosis);
}

// A wrong encoder gain alone is one.
TEST(NamelessCause, AnEncoderGainIsAnEncoderGain) {
  const Diagnosis diagnosis = DiagnosisOf([](Eigen::VectorXd* q) { (*q)[1] += 1.5e-4 * (*q)[1]; });
  ASSERT_EQ(diagnosis.effects.size(), 1u);
  EXPECT_EQ(diagnosis.effects[0].candidate.spec.effect, "encoder_gain");
  EXPECT_GT(diagnosis.effects[0].probability, 0.8);
}

}  // namespace
}  // namespace sagitta::nameless_cause_test

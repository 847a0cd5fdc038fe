// A number that the list of candidates holds few values of: found between them, and its doubt part of the intervals.
#include "estimator/diagnosis/scanned_settings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "estimator/diagnosis/leading_set.h"
#include "models/constants.h"
#include "tests/support/moved_kr270.h"
#include "tests/support/random_vector.h"

namespace sagitta::scanned_settings_test {
namespace {

constexpr double kSigma = 1e-5;       // m
constexpr double kAmplitude = 60e-6;  // rad
constexpr double kWidth = 15.0;       // deg, between 10 and 30 of the list
constexpr int kJoint = 4;             // A5

// Joint A5 wanders by 6 deg from pose to pose. A stop that is dragged along by a fork of this width, written as a
// machine would do it: it moves when one of the fork's two ends meets it.
CalibrationProblem Dragged(std::uint64_t seed) {
  Measurements data = test::DesignMeasurements(test::CampaignOf(80, 1, kSigma, seed));
  test::RandomNumbers steps(seed + 1);
  double angle = 0.0;
  for (Configuration& configuration : data.configurations) {
    angle += steps.Uniform(-12.0, 12.0);
    angle = std::min(100.0, std::max(-100.0, angle));
    configuration.q[kJoint] = angle * kDegree;
  }
  Measurements moved = data;
  const double half = 0.5 * kWidth * kDegree;
  double stop = data.configurations[0].q[kJoint];
  for (Configuration& configuration : moved.configurations) {
    double& q = configuration.q[kJoint];
    if (q - half > stop) stop = q - half;
    if (q + half < stop) stop = q + half;
    q += kAmplitude * (stop - q) / half;
  }
  test::MeasureKr270(test::Kr270Truth(), kSigma, seed + 2, &moved);
  for (size_t i = 0; i < data.observations.size(); ++i)
    data.observations[i].point_in_station = moved.observations[i].point_in_station;
  return MakeCalibrationProblem(test::Kr270ProblemOf(data, Experiment()).robot(), data, Experiment());
}

LeadingSet FindIn(const CalibrationProblem& problem, const DiagnosedModel& baseline) {
  const PriorMasses prior;
  const JointOptions joint;
  return FindLeading({problem, baseline, prior, kInfinity, 0.9, joint, nullptr}, nullptr);
}

// By the nearest listed width the rest would look like further effects.
TEST(ScannedSettings, AWidthBetweenThoseListedIsFound) {
  const CalibrationProblem problem = Dragged(7);
  const DiagnosedModel baseline = FitFully(problem, JointOptions());
  const LeadingSet found = FindIn(problem, baseline);
  ASSERT_TRUE(found.is_named);
  ASSERT_EQ(found.refitted.effects.size(), 1u);
  ASSERT_EQ(found.refitted.model.set.members.size(), 1u);
  const EffectSpec& spec = found.refitted.effects[0].candidate.spec;
  EXPECT_EQ(spec.effect, "hysteresis");
  EXPECT_EQ(spec.target, "A5");
  EXPECT_NEAR(spec.NumberSetting("width_deg", 0.0), kWidth, 2.0);
}

// 60 poses, one a minute, and a stop of `stop` seconds after the 30th: the instrument's stand shifts by exp(-t / 850
// s), stop or not.
CalibrationProblem WarmingUpThrough(double stop) {
  Measurements data = test::DesignMeasurements(test::CampaignOf(60, 1, kSigma, 1));
  test::MeasureKr270(test::Kr270Truth(), kSigma, 5, &data);
  for (Shot& shot : data.shots) {
    shot.has_time = true;
    shot.time = 60.0 * shot.configuration + (shot.configuration < 30 ? 0.0 : stop);
  }
  for (Observation& row : data.observations)
    row.point_in_station += std::exp(-data.shots[row.shot].time / 850.0) * Vector3<double>(6e-4, -4.5e-4, 3e-4);
  return MakeCalibrationProblem(test::Kr270ProblemOf(data, Experiment()).robot(), data, Experiment());
}

// 850 s is between 600 and 1200 of the list. What such rows hardly determine of the effect (how it turns) keeps its
// prior under the new number, too.
TEST(ScannedSettings, WhatIsDeterminedPoorlyGoesWithTheEffect) {
  const CalibrationProblem problem = WarmingUpThrough(0.0);
  const DiagnosedModel baseline = FitFully(problem, JointOptions());
  const LeadingSet found = FindIn(problem, baseline);
  ASSERT_TRUE(found.is_named);
  ASSERT_EQ(found.refitted.effects.size(), 1u);
  const Candidate& candidate = found.refitted.effects[0].candidate;
  EXPECT_EQ(candidate.spec.effect, "warm_up");
  EXPECT_EQ(candidate.spec.settings.count("pauses"), 0u);  // there are none
  EXPECT_NEAR(candidate.spec.NumberSetting("tau_s", 0.0), 850.0, 100.0);
  for (const std::string& name : candidate.loose) EXPECT_TRUE(IsParameterOf(candidate.spec, name)) << name;
}

// A change of load that lasts 15 minutes interrupts no warming up of an instrument that stays on.
TEST(ScannedSettings, AnInstrumentThatStaysOnWarmsUpThroughAPause) {
  const CalibrationProblem problem = WarmingUpThrough(900.0);
  const LeadingSet found = FindIn(problem, FitFully(problem, JointOptions()));
  ASSERT_TRUE(found.is_named);
  ASSERT_EQ(found.refitted.effects.size(), 1u);
  const EffectSpec& spec = found.refitted.effects[0].candidate.spec;
  EXPECT_EQ(spec.effect, "warm_up");
  EXPECT_EQ(spec.TextSetting("pauses", "begin_anew"), "go_on");
  EXPECT_NEAR(spec.NumberSetting("tau_s", 0.0), 850.0, 150.0);
}

struct Amplitude {
  ParameterEstimate before, after;
};

// Of the model with this width, as judged.
Amplitude JudgeAt(const CalibrationProblem& problem, const std::string& width) {
  Candidate hysteresis;
  hysteresis.spec = {"hysteresis", "A5", {{"width_deg", width}}, {}};
  DiagnosedModel model = Extend(FitFully(problem, JointOptions()), {hysteresis}, JointOptions());
  model = JudgeFully(model.problem, model.estimate.parameters, model.estimate.parameters, JointOptions());
  std::vector<ParameterEstimate> rows;
  for (const ParameterEstimate& row : model.estimate.table) {
    if (IsParameterOf(hysteresis.spec, row.name)) rows.push_back(row);
  }
  Amplitude amplitude;
  amplitude.before = rows.at(0);
  AllowForSetting(model, hysteresis.spec, &rows);
  amplitude.after = rows.at(0);
  return amplitude;
}

bool Holds(const Interval& interval, double value) { return interval.low <= value && value <= interval.high; }

TEST(ScannedSettings, TheIntervalAllowsForOtherWidths) {
  const CalibrationProblem problem = Dragged(7);
  const Amplitude amplitude = JudgeAt(problem, "10");
  EXPECT_FALSE(Holds(amplitude.before.ci95, kAmplitude)) << amplitude.before.ci95.high;
  EXPECT_TRUE(Holds(amplitude.after.ci95, kAmplitude)) << amplitude.after.ci95.high;
  EXPECT_EQ(amplitude.after.value, amplitude.before.value);
  EXPECT_NEAR(
      amplitude.after.sigma / amplitude.before.sigma,
      (amplitude.after.ci95.high - amplitude.after.ci95.low) / (amplitude.before.ci95.high - amplitude.before.ci95.low),
      1e-9);
}

TEST(ScannedSettings, AnEffectWithoutSuchANumberIsLeftAlone) {
  const CalibrationProblem problem = Dragged(7);
  const DiagnosedModel baseline = FitFully(problem, JointOptions());
  std::vector<ParameterEstimate> rows = {baseline.estimate.table[0]};
  AllowForSetting(baseline, {"joint_harmonic", "A5", {{"order", "2"}}, {}}, &rows);
  EXPECT_EQ(rows[0].ci95.high, baseline.estimate.table[0].ci95.high);
}

}  // namespace
}  // namespace sagitta::scanned_settings_test

// Of which effects the way to a target is said to matter; how a moment is written.
#include <gtest/gtest.h>

#include "estimator/explanations/moments.h"
#include "estimator/report/results_words.h"
#include "estimator/results/estimate_json.h"
#include "estimator/results/remembering_effects.h"
#include "problems/io/files.h"
#include "problems/text.h"
#include "tests/support/moved_kr270.h"

namespace sagitta::way_words_test {
namespace {

KnownRobot With(const std::vector<EffectSpec>& effects) {
  KnownRobot known;
  known.robot = test::Kr270Robot();
  known.robot.effects = effects;
  for (const EffectSpec& spec : effects) known.parameters[spec.Path() + "/x"].value = 1e-4;
  return known;
}

// An instrument that warms up remembers, and its memory moves what it reads; the arm stands where it stands.
TEST(WayWords, AnInstrumentThatWarmsUpMovesNoTarget) {
  const EffectSpec station{"warm_up", "S1", {{"tau_s", "900"}}, {1e-4, 0.0, 0.0}}, play{"hysteresis", "A2", {}, {1e-4}};
  EXPECT_EQ(WhatTheWayDoes(With({station})), "");
  EXPECT_EQ(RememberingEffects(With({station})).size(), 1u);  // what is read at a row it does move
  const std::string both = WhatTheWayDoes(With({station, play}));
  EXPECT_NE(both.find("hysteresis"), std::string::npos) << both;
  EXPECT_EQ(both.find("warm_up"), std::string::npos) << both;
}

// A moment is part of a parameter's name: written as robot.extended.yaml has it when it is read again.
TEST(WayWords, AMomentIsWrittenAsAFileHasIt) {
  test::Kr270Design design = test::CampaignOf(40, 1, 2e-5, 7);
  Measurements data = test::DesignMeasurements(design);
  for (size_t s = 0; s < data.shots.size(); ++s) {
    data.shots[s].has_time = true;
    data.shots[s].time = 60.0 * static_cast<double>(s);
  }
  const auto points = ChangePoints(MakeCalibrationProblem(test::Kr270Robot(), data, Experiment()));
  ASSERT_FALSE(points.empty());
  EXPECT_EQ(points[0], "30");  // between the first two shots, at 0 and 60 s
  for (const std::string& point : points) EXPECT_EQ(point.find_first_not_of("0123456789"), std::string::npos) << point;
}

}  // namespace
}  // namespace sagitta::way_words_test

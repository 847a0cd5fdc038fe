// What goes with a learnt function where poses are few.
#include "estimator/diagnosis/learnt_model.h"

#include <gtest/gtest.h>

namespace sagitta::learnt_model_test {
namespace {

EffectSpec BumpsOver240Degrees(const std::string& knots) {
  return {"learnt_deviation", "A1", {{"knots", knots}, {"from", "-120"}, {"to", "120"}}, {}};
}

// 25 bumps over 240 degrees lie 10 degrees apart, 10 lie 26.7 and 4 lie 80.
TEST(LearntLevels, WiderBumpsCarryAFunctionOverGapsThatNarrowOnesLeave) {
  const auto knots = [](const std::string& own, double gap) {
    std::vector<std::string> levels;
    for (const auto& [spec, scale] : LevelsOf(BumpsOver240Degrees(own), 0.3, gap)) {
      levels.push_back(spec.settings.at("knots"));
    }
    return levels;
  };
  using Levels = std::vector<std::string>;
  EXPECT_EQ(knots("25", 9.0), (Levels{"25"}));
  EXPECT_EQ(knots("25", 11.0), (Levels{"25", "10"}));
  EXPECT_EQ(knots("25", 26.0), (Levels{"25", "10"}));
  EXPECT_EQ(knots("25", 27.0), (Levels{"25", "10", "4"}));
  EXPECT_EQ(knots("10", 27.0), (Levels{"10", "4"}));
  EXPECT_EQ(knots("4", 100.0), (Levels{"4"}));  // nothing is wider
}

// A walk lies between its visits by itself.
TEST(LearntLevels, RampsNeedNothingBeside) {
  EffectSpec walk{"learnt_deviation", "A1", {{"knots", "50"}, {"from", "0"}, {"to", "50"}, {"shape", "ramps"}}, {}};
  EXPECT_EQ(LevelsOf(walk, 0.3, 90.0).size(), 1u);
  walk.settings.erase("shape");
  EXPECT_EQ(LevelsOf(walk, 0.3, 90.0).size(), 3u);
}

// A bump of height h and width w is as steep as h / w: twice as wide, twice as high.
TEST(LearntLevels, AreEquallySteep) {
  const auto levels = LevelsOf(BumpsOver240Degrees("25"), 0.3, 90.0);
  ASSERT_EQ(levels.size(), 3u);
  EXPECT_DOUBLE_EQ(levels[0].second, 0.3);
  EXPECT_DOUBLE_EQ(levels[1].second, 0.3 * 25.0 / 10.0);
  EXPECT_DOUBLE_EQ(levels[2].second, 0.3 * 25.0 / 4.0);
}

}  // namespace
}  // namespace sagitta::learnt_model_test

#include "problems/text.h"

#include <gtest/gtest.h>

#include <clocale>

#include "models/constants.h"
#include "models/forward_model.h"
#include "tests/support/kr270.h"

namespace sagitta::text_test {
namespace {

TEST(TextTest, NumbersBelowTheNormalRangeAreNumbers) {
  EXPECT_EQ(Significant(3.5e-310, 2), "3.5e-310");
  EXPECT_EQ(Significant(0.0, 3), "0");
  EXPECT_EQ(Significant(1664.0, 3), "1660");
}

// A program that uses the library may run under a locale that writes 0,5.
TEST(TextTest, NumbersHaveAPointInEveryLocale) {
  const std::string before = std::setlocale(LC_NUMERIC, nullptr);
  bool found = false;
  for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "it_IT.UTF-8"}) {
    found = found || std::setlocale(LC_NUMERIC, name) != nullptr;
  }
  if (!found) GTEST_SKIP() << "no locale with a decimal comma is installed";
  const EffectSpec spec{"hysteresis", "A2", {{"width_deg", "2.5"}}, {}};
  Robot robot;
  robot.chain = test::Kr270Chain();
  robot.compliances = {{1, {{0.5 * kDegree, 1e-6}, {1.0, 1e-6}}, true}};
  EXPECT_EQ(spec.NumberSetting("width_deg", 0.0), 2.5);
  EXPECT_EQ(Significant(2.56, 2), "2.6");
  EXPECT_EQ(Significant(12345.6, 2), "12000");
  EXPECT_EQ(ForwardModel(robot).parameters().back().name, "compliance/A2@57.2958");
  std::setlocale(LC_NUMERIC, before.c_str());
}

}  // namespace
}  // namespace sagitta::text_test

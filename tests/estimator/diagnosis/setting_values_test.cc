// Values of scanned settings between and beyond those that are listed.
#include "estimator/diagnosis/setting_values.h"

#include <gtest/gtest.h>

#include "tests/support/moved_kr270.h"

namespace sagitta::setting_values_test {
namespace {

EffectSpec Play(const std::map<std::string, std::string>& settings) { return {"backlash", "A3", settings, {}}; }

TEST(SettingValues, TheSignOfATorqueIsRoundedByLessThanTheLeastListedWidth) {
  const Robot robot = test::Kr270Robot();
  std::vector<std::string> widths;
  for (const EffectSpec& spec : Rounded(robot, Play({{"by", "torque"}})))
    widths.push_back(spec.settings.at("width_Nm"));
  EXPECT_EQ(widths, (std::vector<std::string>{"0.333", "0.111", "0.037"}));
  EXPECT_TRUE(Rounded(robot, Play({{"by", "torque"}, {"width_Nm", "3"}})).empty());
  EXPECT_TRUE(Rounded(robot, Play({{"by", "approach"}})).empty());
  EXPECT_TRUE(Rounded(robot, {"joint_slip", "A3", {{"time_s", "100"}}, {}}).empty());
  EXPECT_TRUE(Rounded(robot, {"gravity_compensator", "A2", {}, {}}).empty());
}

// Four between each two, equal in the logarithm, one beyond each end, and its own.
TEST(SettingValues, AScanHasTheOwnValueOnce) {
  SettingDefinition setting{"width_Nm", SettingDefinition::Kind::kNumber, "0", {"10", "1"}};
  const std::vector<double> scan = ScanOf(setting, 2.0);
  ASSERT_EQ(scan.size(), 14u);  // 0.1 to 100 in twelve steps
  EXPECT_NEAR(scan.front(), 0.1, 1e-12);
  EXPECT_NEAR(scan.back(), 100.0, 1e-10);
  EXPECT_TRUE(std::is_sorted(scan.begin(), scan.end()));
  EXPECT_EQ(std::count(scan.begin(), scan.end(), 2.0), 1);
  EXPECT_EQ(ScanOf(setting, 10.0).size(), 13u);
}

}  // namespace
}  // namespace sagitta::setting_values_test

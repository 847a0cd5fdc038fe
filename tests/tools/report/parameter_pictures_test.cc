// What a report says of one parameter it says everywhere.
#include "tools/report/parameter_pictures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "models/constants.h"
#include "tests/support/kr270_experiment.h"
#include "tools/report/command_words.h"
#include "tools/report/first_screen.h"
#include "tools/report/parameter_section.h"

namespace sagitta::parameter_pictures_test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

// One length with the standard deviation 0.01 mm, which moves with a held one in whose direction it is too small to be
// named.
Estimate Conditional() {
  Estimate estimate;
  ParameterEstimate row;
  row.name = "geometry/J2.a";
  row.value = 1e-3;
  row.sigma = 1e-5;
  row.free = true;
  row.conditional = true;
  row.ci95 = {1e-3 - 1.96e-5, 1e-3 + 1.96e-5};
  row.unconditional_ci95 = {1e-3 - 1.96e-3, 1e-3 + 1.96e-3};
  estimate.table = {row};
  return estimate;
}

TEST(ParameterPictures, HaveTheIntervalOfTheTable) {
  const Estimate estimate = Conditional();
  const std::vector<Picture> pictures = KnownParameters(estimate);
  ASSERT_EQ(pictures.size(), 1u);
  // Half of it over k is 1 mm: just what counts as weak.
  const std::vector<std::string> expected = {"geometry/J2.a", "1", "-0.96", "2.96", "mm", "1", "conditional"};
  ASSERT_EQ(pictures[0].rows.size(), 1u);
  EXPECT_EQ(pictures[0].rows[0], expected);
  const ParameterEstimate shown = AsShown(estimate.table[0]);
  EXPECT_EQ(shown.ci95.high, estimate.table[0].unconditional_ci95.high);
}

// Model error widens ci95 and leaves sigma: the factor goes by the former.
TEST(ParameterPictures, TheFactorIsThatOfTheIntervalShown) {
  Estimate estimate = Conditional();
  estimate.table[0].conditional = false;
  EXPECT_EQ(KnownParameters(estimate)[0].rows[0][5], "100");
  estimate.table[0].ci95 = {1e-3 - 3.92e-5, 1e-3 + 3.92e-5};
  EXPECT_EQ(KnownParameters(estimate)[0].rows[0][5], "50");
  estimate.table[0].open_high = true;
  EXPECT_EQ(KnownParameters(estimate)[0].rows[0][5], "-");
  EXPECT_EQ(KnownParameters(estimate)[0].rows[0][3], "open");
}

TEST(CommandWords, WhatIsNothingIsNotGivenANumber) {
  EXPECT_THAT(CompensationInWords(1e-3, 2.5e-16, 1e-4), HasSubstr("less than 0.001 µm"));
  EXPECT_THAT(CompensationInWords(1e-3, 2.5e-6, 1e-4), HasSubstr("0.0025 mm"));
  Changes changes;
  changes.before_rms = changes.after_rms = 4e-5;
  EXPECT_THAT(ComparisonInWords(changes), Not(HasSubstr("removed")));
  changes.changes.emplace_back();
  EXPECT_THAT(ComparisonInWords(changes), HasSubstr("with that removed"));
}

// A loss leaves outliers out of what is said below; those that share a cause stay in it.
TEST(SuspectRows, AreSaidToBeLeftOutWhereALossDidThat) {
  Calibration calibration{test::Kr270Problem({}, test::Kr270Truth(), 1), {}, {}};
  calibration.trust.suspects = {{3, "m.csv:5", "off"}, {4, "m.csv:6", "off"}};
  const auto words = [&] { return SuspectRows(calibration, "").paragraphs.back(); };
  EXPECT_THAT(words(), HasSubstr("holds with them"));
  calibration.estimate.noise_report.outliers.resize(1);
  calibration.estimate.noise_report.outliers[0].observation = 3;
  EXPECT_THAT(words(), HasSubstr("1 is left out of all figures"));
  calibration.estimate.noise_report.outliers.resize(2);
  calibration.estimate.noise_report.outliers[1].observation = 4;
  EXPECT_THAT(words(), HasSubstr("the others alone"));
  calibration.estimate.noise_report.systematic = true;
  EXPECT_THAT(words(), HasSubstr("holds with them"));
}

// Of 0.0005 mm four decimals have one digit.
TEST(ResidualSection, ShowsThreeDigitsOfWhatIsLeft) {
  ResidualSize before, after;
  before.rms = 1e-5;
  after.rms = 5.123e-7;
  EXPECT_THAT(ResidualSection("", before, after).rows[1], Contains("0.000512"));
  after.rms = 5e-5;
  EXPECT_THAT(ResidualSection("", before, after).rows[1], Contains("0.0500"));
}

}  // namespace
}  // namespace sagitta::parameter_pictures_test

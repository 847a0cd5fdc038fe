// Words of choices: files that are written say what is read back.
#include "problems/choices.h"

#include <gtest/gtest.h>

#include <set>

#include "models/denavit_hartenberg.h"
#include "problems/experiment.h"
#include "problems/reading_group.h"

namespace sagitta::choices_test {
namespace {

template <typename Choice>
class ChoiceTest : public ::testing::Test {};
using Choices = ::testing::Types<Weights, CovarianceKind, BootstrapKind, LossKind, ResidualGroup, SpringEnd,
                                 DhConvention, ReadingGroup::Kind, MarkerPlace::Kind>;
TYPED_TEST_SUITE(ChoiceTest, Choices);

TYPED_TEST(ChoiceTest, EveryWordIsReadBackAsWhatItSays) {
  const std::vector<TypeParam> choices = ChoicesOf<TypeParam>();
  ASSERT_GE(choices.size(), 2U);
  for (const TypeParam choice : choices) EXPECT_EQ(FindChoice<TypeParam>(WordOf(choice)), choice) << WordOf(choice);
  const std::vector<std::string> words = WordsOf<TypeParam>();
  EXPECT_EQ(std::set<std::string>(words.begin(), words.end()).size(), choices.size());
}

TYPED_TEST(ChoiceTest, NoOtherWordNamesOne) {
  for (const char* word : {"", "nothing of the kind"}) EXPECT_FALSE(FindChoice<TypeParam>(word)) << word;
  EXPECT_EQ(WordOf(static_cast<TypeParam>(1000)), "");
}

// The words that files of today have, in the order of the enum.
TEST(ChoiceWordsTest, AreThoseOfTheFiles) {
  using Words = std::vector<std::string>;
  EXPECT_EQ(WordsOf<Weights>(), (Words{"sigma", "equal", "eq14"}));
  EXPECT_EQ(WordsOf<CovarianceKind>(), (Words{"model", "sandwich", "bootstrap", "profile"}));
  EXPECT_EQ(WordsOf<ResidualGroup>(), (Words{"axis", "config-axis", "marker-axis", "station-axis", "residual"}));
  EXPECT_EQ(WordsOf<DhConvention>(), (Words{"standard", "modified"}));
  EXPECT_EQ(WordsOf<ReadingGroup::Kind>(), (Words{"station", "marker", "rotations", "axis", "sight"}));
  EXPECT_EQ(MarkerPlace::Words(), (Words{"flange", "base", "world"}));
}

}  // namespace
}  // namespace sagitta::choices_test

// Sentences with the same remedy are one paragraph, however many there are.
#include "tools/report/remedies.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sagitta::remedies_test {
namespace {

using ::testing::ElementsAre;

TEST(Remedies, SentencesThatShareOneAreGroupedAndCounted) {
  std::vector<WordsAndRemedy> sentences = {{"a is not measured", "turn the wrist"},
                                           {"b is not measured", "hang a load"}};
  for (int i = 0; i < 98; ++i) sentences.emplace_back("c" + std::to_string(i) + " is not measured", "turn the wrist");
  EXPECT_THAT(GroupedByRemedy(sentences, 2),
              ElementsAre("- a is not measured; c0 is not measured; and 97 more like these. Remedy: turn the wrist.",
                          "- b is not measured. Remedy: hang a load."));
  EXPECT_THAT(GroupedByRemedy({}, 2), ElementsAre());
}

}  // namespace
}  // namespace sagitta::remedies_test

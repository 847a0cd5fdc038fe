#include "problems/io/import/pose_names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sagitta::pose_names_test {
namespace {

std::vector<std::string> Names(const std::string& cell, PoseNameAt at) {
  std::vector<std::string> names;
  for (const NameInCell& part : NamesIn(cell, at, false)) names.push_back(part.name);
  return names;
}

TEST(PoseNames, PartsOfANameTheLongestFirst) {
  EXPECT_THAT(Names("P_07_SMR2", PoseNameAt::kWhole), testing::ElementsAre("p_7_smr2"));
  EXPECT_THAT(Names("P_07_SMR2", PoseNameAt::kBefore), testing::ElementsAre("p_7_smr2", "p_7", "p"));
  EXPECT_THAT(Names("P_07_SMR2", PoseNameAt::kBehind), testing::ElementsAre("p_7_smr2", "7_smr2", "smr2"));
  EXPECT_THAT(Names("P_07_SMR2", PoseNameAt::kWithin), testing::Contains("7"));
}

// Its pairs of separators would need memory by the square of them, and the text of each: gigabytes for one cell.
TEST(PoseNames, ARemarkOfManyPartsIsNotTakenApart) {
  const std::string remark(200, '-');
  for (const PoseNameAt at : {PoseNameAt::kBefore, PoseNameAt::kBehind, PoseNameAt::kWithin}) {
    EXPECT_THAT(Names(remark, at), testing::ElementsAre(remark));
  }
}

}  // namespace
}  // namespace sagitta::pose_names_test

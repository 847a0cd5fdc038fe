#include "problems/text.h"

#include <gtest/gtest.h>

namespace sagitta::text_test {
namespace {

TEST(TextTest, NumbersBelowTheNormalRangeAreNumbers) {
  EXPECT_EQ(Significant(3.5e-310, 2), "3.5e-310");
  EXPECT_EQ(Significant(0.0, 3), "0");
  EXPECT_EQ(Significant(1664.0, 3), "1660");
}

}  // namespace
}  // namespace sagitta::text_test

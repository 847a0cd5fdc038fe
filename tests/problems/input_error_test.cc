#include "problems/input_error.h"

#include <gtest/gtest.h>

namespace sagitta::input_error_test {
namespace {

TEST(InputErrorTest, MessageNamesWhatIsKnown) {
  EXPECT_STREQ(InputError({"a.csv", 7, "x_mm"}, "no number", "a point?").what(), "a.csv:7: x_mm: no number (a point?)");
  EXPECT_STREQ(InputError({"a.csv", 0, ""}, "is empty").what(), "a.csv: is empty");
  EXPECT_STREQ(InputError({"", 0, "robot"}, "missing").what(), "robot: missing");
  EXPECT_STREQ(InputError({"", 0, ""}, "missing").what(), "missing");
}

TEST(InputErrorTest, KeepsItsParts) {
  const InputError error({"a.csv", 7, "x_mm"}, "no number", "a point?");
  EXPECT_EQ(error.where().file, "a.csv");
  EXPECT_EQ(error.where().line, 7);
  EXPECT_EQ(error.where().key, "x_mm");
  EXPECT_EQ(error.hint(), "a point?");
}

TEST(NearestNameTest, FindsSlips) {
  const std::vector<std::string> names = {"convention", "links", "flange", "a_mm", "a_m", "x_mm", "q1_deg", "time_s"};
  EXPECT_EQ(NearestName("conventoin", names), "convention");
  EXPECT_EQ(NearestName("Convention", names), "convention");
  EXPECT_EQ(NearestName("link", names), "links");
  EXPECT_EQ(NearestName("a_cm", names), "a_mm");
  EXPECT_EQ(NearestName("x", names), "x_mm");
  EXPECT_EQ(NearestName("x_mmm", names), "x_mm");
  EXPECT_EQ(NearestName("X_MM", names), "x_mm");
  EXPECT_EQ(NearestName("q1", names), "q1_deg");
  EXPECT_EQ(NearestName("q1_dge", names), "q1_deg");
  EXPECT_EQ(NearestName("q01_deg", names), "q1_deg");
  EXPECT_EQ(NearestName("time_ms", names), "time_s");
}

TEST(NearestNameTest, OtherNamesAreNoSlips) {
  const std::vector<std::string> names = {"convention", "a_mm", "x_mm", "q1_deg", "A1", "set"};
  for (const char* name : {"q2_deg", "A2", "group", "net", "", "_", "b"})
    EXPECT_EQ(NearestName(name, names), "") << name;
}

TEST(NearestNameTest, PrefersTheNearest) {
  EXPECT_EQ(NearestName("sigma_x_mn", {"sigma_y_mm", "sigma_x_mm"}), "sigma_x_mm");
  EXPECT_EQ(NearestName("huberr", {"cauchy", "hubris", "huber"}), "huber");
}

TEST(SpellingHintTest, SuggestsOrLists) {
  EXPECT_EQ(SpellingHint("hubr", {"none", "huber", "cauchy"}), "did you mean 'huber'?");
  EXPECT_EQ(SpellingHint("tukey", {"none", "huber", "cauchy"}), "known: none, huber, cauchy");
  EXPECT_EQ(SpellingHint("tukey", {}), "");
}

}  // namespace
}  // namespace sagitta::input_error_test

// Names of the unknowns, as files have them.
#include "problems/parameter_set.h"

#include <gtest/gtest.h>

namespace sagitta::parameter_set_test {
namespace {

TEST(ParameterNames, AreThoseOfTheCoordinates) {
  const ParameterSet set({"S1"}, {"M1", "M2"}, {}, {false, true});
  const std::vector<std::string> expected = {"base/S1/x",    "base/S1/y",    "base/S1/z",   "base/S1/rx",
                                             "base/S1/ry",   "base/S1/rz",   "marker/M1/x", "marker/M1/y",
                                             "marker/M1/z",  "marker/M2/x",  "marker/M2/y", "marker/M2/z",
                                             "marker/M2/rx", "marker/M2/ry", "marker/M2/rz"};
  std::vector<std::string> names;
  for (const Coordinate& coordinate : set.coordinates()) names.push_back(coordinate.name);
  EXPECT_EQ(names, expected);
  EXPECT_EQ(BaseNames("S1")[4], "base/S1/ry");
  EXPECT_EQ(MarkerNames("M2")[5], "marker/M2/rz");
}

TEST(ParameterNames, SayWhatTheyAreOf) {
  EXPECT_EQ(CoordinateKindOf("base/S1/x"), CoordinateKind::kBase);
  EXPECT_EQ(CoordinateKindOf("effect/payload/L1/dmass"), CoordinateKind::kEffect);
  EXPECT_EQ(CoordinateKindOf("compensator/Kc"), CoordinateKind::kCompensator);
  EXPECT_FALSE(CoordinateKindOf("bases/S1/x"));
  EXPECT_EQ(NameWithinKind("geometry/A2.theta"), "A2.theta");
  EXPECT_EQ(NameWithinKind("geometry"), "");
  EXPECT_TRUE(IsWithin("base/S1/x", "base/S1"));
  EXPECT_TRUE(IsWithin("base/S1", "base/S1"));
  EXPECT_FALSE(IsWithin("base/S12/x", "base/S1"));
}

TEST(ParameterNames, PriorsPullByStandardDeviations) {
  Coordinate coordinate;
  EXPECT_FALSE(coordinate.has_prior());
  coordinate.prior_value = 2e-3;
  coordinate.prior_sigma = 5e-4;
  EXPECT_TRUE(coordinate.has_prior());
  EXPECT_DOUBLE_EQ(PriorResidual(coordinate, 3e-3), 2.0);
  EXPECT_DOUBLE_EQ(PriorResidual(coordinate, 1e-3), -2.0);
}

}  // namespace
}  // namespace sagitta::parameter_set_test

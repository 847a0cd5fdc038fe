// A learnt surface over two joints: the i-th knot is of the one that drives it, the k-th of the one that goes with it.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "models/constants.h"
#include "models/effects/catalogue.h"
#include "models/robot.h"
#include "tests/support/kr270.h"

namespace sagitta::learnt_surface_test {
namespace {

// What the weight of each pair of knots does to the joint, by name.
std::map<std::string, double> ShareOfWeights(double driver, double with) {
  Robot robot;
  robot.chain = test::Kr270Chain();
  const EffectSpec spec{"learnt_surface_deviation",
                        "A4",
                        {{"driver", "A2"},
                         {"with", "A3"},
                         {"from", "-90"},
                         {"to", "0"},
                         {"from_with", "0"},
                         {"to_with", "60"},
                         {"knots", "2"}},
                        {}};
  const EffectDefinition* definition = FindEffect(robot, spec.effect);
  ShotConditions shot;
  shot.q = Eigen::VectorXd::Zero(6);
  shot.q[1] = driver;
  shot.q[2] = with;
  const std::vector<std::string> markers;
  ShotTerms terms;
  definition->apply({&robot, &spec, &shot, &markers, 0}, &terms);
  std::map<std::string, double> shares;
  const std::vector<EffectParameter> parameters = definition->parameters(robot, spec);
  for (const SlotTerm& term : terms.slots) shares[parameters[term.parameter].name] = term.factor;
  return shares;
}

// At the driver's first knot and the other's second the bumps of both are pi^(-1/4) each, and the others are what is
// left a knot away.
TEST(LearntSurface, EachJointIsAtItsOwnAngle) {
  const std::map<std::string, double> shares = ShareOfWeights(-90.0 * kDegree, 60.0 * kDegree);
  ASSERT_EQ(shares.size(), 4u);
  const double there = std::abs(shares.at("w1_2"));
  EXPECT_NEAR(there, 1.0 / std::sqrt(kPi), 1e-12);
  for (const auto& [name, share] : shares) {
    if (name == "w1_2") continue;
    EXPECT_LT(std::abs(share), 0.7 * there) << name;
  }
  EXPECT_NEAR(std::abs(ShareOfWeights(0.0, 0.0).at("w2_1")), there, 1e-12);
}

}  // namespace
}  // namespace sagitta::learnt_surface_test

// Which poses are chosen, and what is expected of them, by closed forms of a few readings.
#include "estimator/evidence/pose_choice.h"

#include <gtest/gtest.h>

#include <cmath>

#include "estimator/statistics/mutual_information.h"

namespace sagitta::pose_choice_test {
namespace {

constexpr double kSpread = 3.0;  // of a coefficient that moves readings, in their sigma

RivalRows Rival(double probability, int name, const Eigen::VectorXd& means, const Eigen::MatrixXd& spread) {
  return {probability, name, means, spread};
}

// Two rivals of the same probability that many readings leave D apart.
double DecidesAt(double apart) { return InformationOfTwo(apart).decides; }

// Readings 0 and 1 differ by 1, but one unknown coefficient of both rivals moves them together. Then
// V = I + s^2 [1 1; 1 1] and D of both is 2 / (1 + 2 s^2), of one of them 1 / (1 + s^2).
TEST(PoseChoice, ASecondReadingOfWhatTheCoefficientsFollowSaysLittle) {
  const Eigen::Vector2d same(0.0, 0.0), other(1.0, 1.0);
  const Eigen::RowVector2d spread(kSpread, kSpread);
  PoseChoice choice({Rival(0.5, 0, same, spread), Rival(0.5, 1, other, spread)}, {0, 1, 2});
  choice.Take();
  EXPECT_NEAR(choice.Decides(), DecidesAt(1.0 / (1.0 + kSpread * kSpread)), 1e-9);
  choice.Take();
  EXPECT_NEAR(choice.Decides(), DecidesAt(2.0 / (1.0 + 2.0 * kSpread * kSpread)), 1e-9);
  // However often they are read: D stays below 1 / s^2.
  EXPECT_LT(choice.Decides(1e6), DecidesAt(1.0 / (kSpread * kSpread)) + 1e-9);
  EXPECT_EQ(choice.Needed(0.9, 60), 0);
}

// The coefficient moves the readings against each other: what they have in common is not its doing, and both together
// say more than twice one. V = I + s^2 [1 -1; -1 1], d = (1, 1): D = 2.
TEST(PoseChoice, ReadingsCountTogether) {
  const Eigen::Vector2d same(0.0, 0.0), other(1.0, 1.0);
  const Eigen::RowVector2d spread(kSpread, -kSpread);
  PoseChoice choice({Rival(0.5, 0, same, spread), Rival(0.5, 1, other, spread)}, {0, 1, 2});
  choice.Take();
  choice.Take();
  EXPECT_NEAR(choice.Decides(), DecidesAt(2.0), 1e-9);
  // n visits to two poses: D = n.
  const int needed = choice.Needed(0.9, 60);
  EXPECT_GE(DecidesAt(needed), 0.9);
  EXPECT_LT(DecidesAt(needed - 1), 0.9);
}

// The pose that separates two shapes of one name is worth nothing.
TEST(PoseChoice, ShapesOfOneNameNeedNotBeToldApart) {
  const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(1, 2);
  PoseChoice choice({Rival(0.3, 0, Eigen::Vector2d(0.0, 0.0), none), Rival(0.3, 0, Eigen::Vector2d(50.0, 0.0), none),
                     Rival(0.4, 1, Eigen::Vector2d(25.0, 1.0), none)},
                    {0, 1, 2});
  EXPECT_EQ(choice.Take(), 0u);  // 25 sigma between the names
  PoseChoice alike({Rival(0.3, 0, Eigen::Vector2d(0.0, 0.0), none), Rival(0.3, 0, Eigen::Vector2d(0.0, 0.0), none),
                    Rival(0.4, 1, Eigen::Vector2d(0.0, 1.0), none)},
                   {0, 1, 2});
  EXPECT_EQ(alike.Take(), 1u);
}

// Poses of several rows: the one that differs most in the covariance of its rows, not in their number.
TEST(PoseChoice, PosesMayHaveSeveralRows) {
  const Eigen::VectorXd here = Eigen::VectorXd::Zero(5);
  Eigen::VectorXd there(5);
  there << 1.0, 1.0, 1.0, 2.0, 2.0;
  const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(1, 5);
  PoseChoice choice({Rival(0.5, 0, here, none), Rival(0.5, 1, there, none)}, {0, 3, 5});
  EXPECT_EQ(choice.Take(), 1u);
  EXPECT_NEAR(choice.Decides(), DecidesAt(8.0), 1e-9);
  EXPECT_EQ(choice.Take(), 0u);
  EXPECT_NEAR(choice.Decides(), DecidesAt(11.0), 1e-9);
}

}  // namespace
}  // namespace sagitta::pose_choice_test

// What the search knows of springs: their columns against the law itself, and where the arm's weight asks for one.
#include <gtest/gtest.h>

#include <cmath>

#include "estimator/diagnosis/diagnosed_model.h"
#include "estimator/explanations/compensator_shapes.h"
#include "estimator/explanations/driver_functions.h"
#include "estimator/explanations/drivers.h"
#include "models/gravity_compensator.h"
#include "tests/support/kr270_experiment.h"

namespace sagitta::spring_columns_test {
namespace {

// N m per N/m, of a spring with lever L, anchor at a, alpha, and rest length s0.
Eigen::VectorXd Torques(double lever, double a, double alpha, double s0, const Eigen::VectorXd& angles) {
  return angles.unaryExpr([&](double q) {
    const double s = std::sqrt(a * a + lever * lever + 2.0 * a * lever * std::cos(alpha - q));
    return -(1.0 - s0 / s) * a * lever * std::sin(alpha - q);
  });
}

TEST(SpringColumns, ReachTheSpringsOfTheGridsCell) {
  const Eigen::VectorXd angles = Eigen::VectorXd::LinSpaced(60, -2.4, 0.6);
  for (const EffectSpec& shape : CompensatorShapes("A2")) {
    const double lever = shape.values[0], a = std::hypot(shape.values[1], shape.values[2]);
    const double alpha = std::atan2(shape.values[1], shape.values[2]);
    if (a / lever < 1.5) continue;  // nearly slack where the lever points at the anchor: no Taylor series
    const Eigen::MatrixXd columns = SpringColumns(shape, Wave(angles));
    const double rest = kUsualRest * a;
    EXPECT_LT((columns.col(0) - Torques(lever, a, alpha, rest, angles)).norm(), 1e-9 * columns.col(0).norm());
    // One standard deviation of each, and what the other columns leave of it.
    const double turned = alpha + 15.0 / std::sqrt(12.0) * M_PI / 180.0;
    const Eigen::VectorXd other[] = {Torques(lever, a, alpha, rest + kRestDeviation * a, angles),
                                     Torques(lever, a, turned, rest, angles)};
    for (int k = 0; k < 2; ++k) {
      const Eigen::VectorXd change = other[k] - columns.col(0);
      EXPECT_LT((columns.col(k + 1) - change).norm(), 0.15 * change.norm()) << k << " a " << a << " alpha " << alpha;
    }
  }
}

// What of a stated spring may be off, and what is freed of it: never L, nor what is estimated anyway.
TEST(StatedSpring, IsFreedWhereItIsHeld) {
  Robot robot;
  robot.chain = test::Kr270Chain();
  robot.gravity_compensator = GravityCompensator{1, 0.2, 0.1, 0.7, 0.5, 1e4, true};
  const ParameterSet all({"S1"}, {"P1"}, ForwardModel(robot, {"P1"}).parameters());
  const std::vector<CompensatorPart> parts = {CompensatorPart::kAx, CompensatorPart::kAy, CompensatorPart::kS0,
                                              CompensatorPart::kKc};
  const double typical[] = {3e-3, 3e-3, 0.05, 1e3};
  for (size_t free = 0; free <= parts.size(); ++free) {  // the first so many are estimated
    ParameterSet parameters = all;
    for (int i = 0; i < parameters.num_coordinates(); ++i) parameters.coordinate(i).free = false;
    for (size_t k = 0; k < free; ++k) parameters.coordinate(parameters.FindCoordinate(parts[k])).free = true;
    EXPECT_EQ(HeldSpring(parameters).size(), parts.size() - free);
    for (const bool rate_alone : {false, true}) {
      ParameterSet freed = parameters;
      FreeSpring(rate_alone, 3.0, &freed);
      EXPECT_FALSE(freed.coordinates()[freed.FindCoordinate(CompensatorPart::kL)].free);
      for (size_t k = 0; k < parts.size(); ++k) {
        const int i = freed.FindCoordinate(parts[k]);
        const bool is_freed = k >= free && (!rate_alone || parts[k] == CompensatorPart::kKc);
        EXPECT_EQ(freed.coordinates()[i].free, k < free || is_freed) << free << k << rate_alone;
        if (!is_freed) continue;
        EXPECT_NEAR(freed.coordinates()[i].prior_sigma, 3.0 * typical[k], 1e-9 * typical[k]);
        EXPECT_EQ(freed.coordinates()[i].prior_value, freed.Value(i));
      }
    }
  }
}

// Ratio of two densities of x = (s0 / longer - usual) / deviation, each of which integrates to 1: by quadrature the
// mean of the ratio over the second one is 1. Lever and anchor are alike.
TEST(SpringColumns, RestLengthsAreThoseOfRealSprings) {
  Robot robot;
  robot.chain = test::Kr270Chain();
  robot.gravity_compensator = GravityCompensator{1, 0.2, 0.1, 0.7, 0.5, 1e4, true};
  ParameterSet parameters({"S1"}, {"P1"}, ForwardModel(robot, {"P1"}).parameters());
  const auto log_prior = [&](double lever, double anchor, double x) {
    const double longer = std::max(lever, anchor);
    const std::pair<CompensatorPart, double> wanted[] = {{CompensatorPart::kL, lever},
                                                         {CompensatorPart::kAx, 0.6 * anchor},
                                                         {CompensatorPart::kAy, 0.8 * anchor},
                                                         {CompensatorPart::kS0, (0.65 + 0.25 * x) * longer}};
    Eigen::VectorXd step = Eigen::VectorXd::Zero(parameters.num_coordinates());
    for (const auto& [part, value] : wanted) {
      const int i = parameters.FindCoordinate(part);
      step[i] = value - parameters.Value(i);
    }
    parameters.Plus(step);
    return LogPriorOfSpring(parameters);
  };
  double sum = 0.0;
  constexpr double kStep = 0.01;
  for (double x = -40.0; x <= 40.0; x += kStep)
    sum += kStep * std::exp(log_prior(0.2, 0.7, x)) / (M_PI * (1.0 + x * x));
  EXPECT_NEAR(sum, 1.0, 1e-4);
  EXPECT_NEAR(log_prior(0.7, 0.2, 1.5), log_prior(0.2, 0.7, 1.5), 1e-9);
  EXPECT_LT(log_prior(0.2, 0.02, 7.0), -15.0);  // two and a half times the longer of the two
  EXPECT_EQ(log_prior(0.2, 0.199, 0.0), -std::numeric_limits<double>::infinity());  // it would pass through no length
}

TEST(Compress, KeepsFunctionsOfAnyNumberOfShots) {
  Eigen::MatrixXd few(12, 3), mixed(3, 40);
  for (long i = 0; i < few.size(); ++i) few(i) = std::sin(1.7 * static_cast<double>(i * i + 1));
  for (long i = 0; i < mixed.size(); ++i) mixed(i) = std::cos(2.3 * static_cast<double>(i * i + 2));
  const Eigen::MatrixXd wide = few * mixed, tall = wide.transpose();
  for (const Eigen::MatrixXd& functions : {wide, tall}) {
    const Compressed compressed = Compress(functions, 1e-6);
    EXPECT_EQ(compressed.basis.cols(), 3);
    EXPECT_LT((compressed.basis * compressed.mixing - functions).norm(), 1e-9 * functions.norm());
  }
}

// Virtual work: a weight of 1 N turns a joint by the slope of the flange's height.
TEST(TorquesPerWeight, AreTheSlopesOfTheFlangesHeight) {
  test::Kr270Design design;
  design.configurations = 6;
  design.stations = 1;
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(test::Kr270Truth(), 1e-5, 3, &data);
  Robot robot;
  robot.chain = test::Kr270Chain();
  const DiagnosedModel model = FitFully(MakeCalibrationProblem(robot, data, Experiment()), JointOptions());
  const CalibrationProblem& problem = *model.problem;
  const ParameterSet& parameters = model.estimate.parameters;
  const Eigen::MatrixXd torques = TorquesPerWeight(problem, parameters);
  const auto height = [&](size_t shot, const Eigen::VectorXd& q) {
    ShotInput input = problem.shot_inputs()[shot];
    input.conditions.q = q;
    const std::vector<double> theta = parameters.ModelValues();
    const auto base = parameters.BaseInStation(data.shots[shot].station);
    const Equilibrium equilibrium = problem.model().Equilibrate(input, theta.data(), base.rotation);
    return (base * equilibrium.state.frames[robot.chain.FlangeFrame()].translation)[2];
  };
  for (size_t s = 0; s < problem.shot_inputs().size(); ++s) {
    for (int j = 0; j < robot.num_joints(); ++j) {
      constexpr double kStep = 1e-5;
      Eigen::VectorXd up = problem.shot_inputs()[s].conditions.q, down = up;
      up[j] += kStep;
      down[j] -= kStep;
      const double slope = (height(s, up) - height(s, down)) / (2.0 * kStep);
      const double sign = robot.chain.transforms[robot.chain.JointTransform(j)].sign;
      EXPECT_NEAR(sign * torques(static_cast<long>(s), j), -slope, 1e-6) << "shot " << s << " joint " << j;
    }
  }
}

}  // namespace
}  // namespace sagitta::spring_columns_test

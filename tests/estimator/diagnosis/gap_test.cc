// What untouched rows say: of an effect, of the floor, and how many they are.
#include "estimator/diagnosis/gap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "estimator/least_squares/linearization.h"
#include "tests/support/moved_kr270.h"

namespace sagitta::gap_test {
namespace {

// 40 configurations of three markers, every fourth held out.
CalibrationProblem Healthy() {
  const Measurements data = test::MeasuredAfter(test::CampaignOf(40, 1, 2e-5, 7), 107, [](Eigen::VectorXd*) {});
  Experiment experiment;
  experiment.validation.kind = ValidationSpec::Kind::kFraction;
  experiment.validation.fraction = 0.25;
  return MakeCalibrationProblem(test::Kr270Robot(), data, experiment);
}

// A model whose held-out points are off by `distance(k)` of the k-th held-out configuration, along one axis.
template <typename Distance>
DiagnosedModel OffBy(const Distance& distance) {
  CalibrationProblem problem = Healthy();
  const std::vector<int> held_out = problem.ValidationObservations();
  const Eigen::Matrix3Xd predicted = PredictPoints(problem, problem.parameters, held_out);
  std::map<int, int> numbers;  // of the configurations, in order
  for (size_t k = 0; k < held_out.size(); ++k) {
    Observation& row = problem.mutable_data()->observations[static_cast<size_t>(held_out[k])];
    const int c = problem.data().shots[static_cast<size_t>(row.shot)].configuration;
    const int number = numbers.emplace(c, static_cast<int>(numbers.size())).first->second;
    row.point_in_station = predicted.col(static_cast<long>(k)) + distance(number) * Vector3<double>::UnitY();
  }
  DiagnosedModel model{std::make_shared<CalibrationProblem>(problem), {}};
  model.estimate.parameters = problem.parameters;
  model.estimate.validation.observations = static_cast<int>(held_out.size());
  return model;
}

TEST(Gap, UntouchedRowsSpeakAgainstAnEffectBeyondChance) {
  const DiagnosedModel before = OffBy([](int) { return 1e-3; });
  // All a little worse: the differences do not scatter. Or a little better.
  EXPECT_TRUE(MakesHoldoutWorse(before, OffBy([](int k) { return 1.01e-3 + 1e-6 * k; })));
  EXPECT_FALSE(MakesHoldoutWorse(before, OffBy([](int k) { return 0.98e-3 - 1e-6 * k; })));
  // One of ten alone: its difference is as large as the scatter. The root mean square of ten may grow by 2.326 /
  // sqrt(60) by chance.
  const double limit = std::pow(1.0 + 2.3263478740408408 / std::sqrt(60.0), 2);
  const auto one_worse = [&](double growth_of_squares) {
    const double squares = 10.0 * growth_of_squares - 9.0;  // of the one, 1 each of the others
    return OffBy([=](int k) { return 1e-3 * (k == 4 ? std::sqrt(squares) : 1.0); });
  };
  EXPECT_FALSE(MakesHoldoutWorse(before, one_worse(0.99 * limit)));
  EXPECT_TRUE(MakesHoldoutWorse(before, one_worse(1.01 * limit)));
}

// Ten configurations with gains g_k:  sum g / |g|,  and the upper twentieth of a normal distribution is at 1.6449.
TEST(Gap, UntouchedRowsSpeakForAnEffectBeyondChance) {
  const DiagnosedModel before = OffBy([](int) { return 1e-3; });
  EXPECT_NEAR(HoldoutGain(before, OffBy([](int) { return 0.9e-3; })), std::sqrt(10.0), 1e-6);
  EXPECT_NEAR(HoldoutGain(before, OffBy([](int) { return 1.1e-3; })), -std::sqrt(10.0), 1e-6);
  // Six gain half of their square, four lose as much.
  const auto six_of_ten = OffBy([](int k) { return 1e-3 * std::sqrt(k < 6 ? 0.5 : 1.5); });
  EXPECT_NEAR(HoldoutGain(before, six_of_ten), 2.0 / std::sqrt(10.0), 1e-6);
  EXPECT_EQ(HoldoutGain(before, before), 0.0);
  EXPECT_FALSE(IsBeyondChance(1.644));
  EXPECT_TRUE(IsBeyondChance(1.646));
}

// All ten gain, one of them most: by the scatter 1.39, by the signs 1 of 2^10, at 3.097 of a normal distribution. One
// that gains while the others lose as much together as half of it is chance: its own sign is P = 1/2.
TEST(Gap, OneConfigurationThatShowsMostIsNotAgainstTheOthers) {
  const DiagnosedModel before = OffBy([](int) { return 1e-3; });
  const auto gains = [&](double of_one, double of_others) {
    return HoldoutGain(before, OffBy([=](int k) { return 1e-3 * std::sqrt(1.0 - (k == 4 ? of_one : of_others)); }));
  };
  const double by_scatter = (0.9 + 9 * 0.04) / std::hypot(0.9, 3 * 0.04);
  ASSERT_LT(by_scatter, 1.6449);
  EXPECT_NEAR(gains(0.9, 0.04), 3.097, 0.4);  // of 2000 draws 2 +- 1.4
  EXPECT_LT(gains(0.9, -0.05), 0.7);
}

// Ten configurations held out count 30: chi-square's upper thousandth is 59.703.
TEST(Gap, FarFromTheFloorIsATestOfSquares) {
  DiagnosedModel model = OffBy([](int) { return 1e-3; });
  model.estimate.noise_floor = 1e-4;
  const auto far = [&model](double square) {
    model.estimate.validation.rms = 1e-4 * std::sqrt(square / 30.0);
    return IsFarFromFloor(model, true, 0.01);
  };
  EXPECT_FALSE(far(59.6));
  EXPECT_TRUE(far(59.8));
  // Where four repeats of each axis state it, F of 30 and 12: its upper thousandth is 6.09 (tables).
  CalibrationProblem repeated = *model.problem;
  repeated.repeat_scatter = RepeatScatter{Vector3<double>::Constant(1e-4), 4};
  model.problem = std::make_shared<CalibrationProblem>(repeated);
  EXPECT_FALSE(far(30.0 * 6.08));
  EXPECT_TRUE(far(30.0 * 6.10));
  // Where nothing states the noise, F of 30 and 30: its upper thousandth is 3.217 (tables).
  model.estimate.dof = 30;
  const auto far_of_scatter = [&model](double ratio) {
    model.estimate.validation.rms = 1e-4 * std::sqrt(ratio);
    return IsFarFromFloor(model, false, 0.01);
  };
  EXPECT_FALSE(far_of_scatter(3.21));
  EXPECT_TRUE(far_of_scatter(3.22));
}

// Twelve configurations for over thirty unknowns: what three untouched ones are off by is the parameters' more than the
// noise, and goes together. (tr V)^2 / tr V^2 with V = J C J' + s^2, J by differences.
TEST(Gap, FewConfigurationsLeaveLittleFreedom) {
  const Measurements data = test::MeasuredAfter(test::CampaignOf(12, 1, 2e-5, 7), 107, [](Eigen::VectorXd*) {});
  Experiment experiment;
  experiment.validation.kind = ValidationSpec::Kind::kFraction;
  experiment.validation.fraction = 0.25;
  const DiagnosedModel model = FitFully(MakeCalibrationProblem(test::Kr270Robot(), data, experiment), JointOptions());
  const std::vector<int> held_out = model.problem->ValidationObservations();
  const auto n = static_cast<Eigen::Index>(held_out.size());
  ASSERT_TRUE(model.estimate.held.coordinates.empty());
  Eigen::MatrixXd jacobian(3 * n, static_cast<Eigen::Index>(model.estimate.estimated.size()));
  const auto points_at = [&](int coordinate, double step) {
    ParameterSet parameters = model.estimate.parameters;
    Eigen::VectorXd move = Eigen::VectorXd::Zero(parameters.num_coordinates());
    move[coordinate] = step;
    parameters.Plus(move);
    return Eigen::MatrixXd(PredictPoints(*model.problem, parameters, held_out)).reshaped().eval();
  };
  for (Eigen::Index p = 0; p < jacobian.cols(); ++p) {
    const int c = model.estimate.estimated[static_cast<size_t>(p)];
    jacobian.col(p) = (points_at(c, 1e-7) - points_at(c, -1e-7)) / 2e-7;
  }
  Eigen::MatrixXd v = jacobian * model.estimate.covariance * jacobian.transpose();
  for (Eigen::Index k = 0; k < n; ++k) {
    const Matrix3<double>& noise = model.estimate.noise[static_cast<size_t>(held_out[static_cast<size_t>(k)])];
    v.block<3, 3>(3 * k, 3 * k) += noise * noise.transpose();
  }
  const double freedom = v.trace() * v.trace() / v.squaredNorm();
  ASSERT_LT(freedom, 0.7 * 3.0 * CountHeldOut(model));
  EXPECT_NEAR(FreedomOfHoldout(model), freedom, 1e-4 * freedom);
}

// Loads on one pose under names of their own share what the model lacks there: ten poses are ten, however many names.
TEST(Gap, ConfigurationsWithEqualJointValuesCountOnce) {
  DiagnosedModel model = OffBy([](int) { return 1e-3; });
  ASSERT_EQ(CountHeldOut(model), 10);
  Measurements& data = *model.problem->mutable_data();
  std::vector<int> held_out;
  for (size_t c = 0; c < data.configurations.size(); ++c) {
    if (data.configurations[c].is_validation) held_out.push_back(static_cast<int>(c));
  }
  for (size_t k = 5; k < held_out.size(); ++k) {
    data.configurations[held_out[k]].q = data.configurations[held_out[k - 5]].q;
  }
  EXPECT_EQ(CountHeldOut(model), 5);
  EXPECT_NEAR(SumHoldout(model).coordinates.maxCoeff(), 2.0 * SumHoldout(model).coordinates.sum() / 10.0, 1e-9);
}

// Points 0.1 mm off and a floor of 1 mm: there is no gap of which a share could be closed. With a floor of 0.01 mm
// there is one: 1 - (0.05^2 / 3 - 0.01^2) / (0.1^2 / 3 - 0.01^2) of it is closed by points 0.05 mm off along one axis.
TEST(Gap, OfNoGapNothingIsClosed) {
  const DiagnosedModel before = OffBy([](int) { return 1e-4; }), after = OffBy([](int) { return 5e-5; });
  const GapReport none = JudgeGap(before, after, 1e-3, true);
  EXPECT_EQ(none.before, 0.0);
  EXPECT_TRUE(std::isnan(none.closed));
  EXPECT_TRUE(std::isnan(none.closed_ci95.low));
  EXPECT_NEAR(JudgeGap(before, after, 1e-5, true).closed, 1.0 - (25.0 / 3.0 - 1.0) / (100.0 / 3.0 - 1.0), 1e-6);
}

}  // namespace
}  // namespace sagitta::gap_test

// What a set leaves on poses that are left out of the fit, against the closed form of a linear fit: with the rows A of
// all poses and N = A'A of these and the priors, the residual e of the fit and its rows i of one pose,
//
//   e left out = (I - A_i N^-1 A_i')^-1 e_i
#include "estimator/evidence/pose_groups.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "estimator/diagnosis/diagnosed_model.h"
#include "estimator/diagnosis/effect_checks.h"
#include "estimator/explanations/typical_units.h"
#include "tests/support/moved_kr270.h"

namespace sagitta::pose_groups_test {
namespace {

constexpr double kSigma = 2e-5;  // m

// Joint 3 off by a harmonic.
CalibrationProblem Campaign(int configurations) {
  const auto move = [](Eigen::VectorXd* q) { (*q)[2] += 120e-6 * std::cos(2.0 * (*q)[2]); };
  const Measurements data = test::MeasuredAfter(test::CampaignOf(configurations, 1, kSigma, 12), 121, move);
  return MakeCalibrationProblem(test::Kr270Robot(), data, Experiment());
}

// Of each pose, ascending. scales: prior standard deviations of the effects, in typical sizes.
std::vector<double> ErrorsLeftOut(const CalibrationProblem& problem, const ParameterSet& believed,
                                  const std::vector<EffectSpec>& effects, const std::vector<double>& scales) {
  CalibrationProblem with = problem.WithEffects(effects);
  with.parameters.CopyByName(believed);
  const std::vector<double> sizes = TypicalSizes(with, with.parameters, effects);
  for (int i = 0; i < with.parameters.num_coordinates(); ++i) {
    Coordinate& coordinate = with.parameters.coordinate(i);
    for (size_t k = 0; k < effects.size(); ++k) {
      if (IsParameterOf(effects[k], coordinate.name))
        coordinate.prior_sigma = scales[k] * sizes[static_cast<size_t>(i)];
    }
  }
  const std::vector<int> fitted = with.CalibrationObservations();
  Linearization rows = Linearize(with, with.parameters, fitted, with.parameters.EstimatedCoordinates(),
                                 ObservationNoise(with, fitted, kSigma), LatentTreatment::kIgnore);
  AppendPriors(with.parameters, &rows);
  const Eigen::LDLT<Eigen::MatrixXd> normal(rows.jacobian.transpose() * rows.jacobian);
  const Eigen::VectorXd left = rows.residual - rows.jacobian * normal.solve(rows.jacobian.transpose() * rows.residual);
  std::vector<double> errors;
  for (size_t c = 0; c < with.data().configurations.size(); ++c) {
    std::vector<long> own;
    for (size_t k = 0; k < fitted.size(); ++k) {
      if (with.data().shots[with.data().observations[fitted[k]].shot].configuration != static_cast<int>(c)) continue;
      for (long axis = 0; axis < 3; ++axis) own.push_back(3 * static_cast<long>(k) + axis);
    }
    const Eigen::MatrixXd here = rows.jacobian(own, Eigen::all);
    const Eigen::MatrixXd hat = here * normal.solve(here.transpose());
    const Eigen::VectorXd own_left = left(own);
    errors.push_back(
        (Eigen::MatrixXd::Identity(hat.rows(), hat.cols()) - hat).partialPivLu().solve(own_left).squaredNorm());
  }
  std::sort(errors.begin(), errors.end());
  return errors;
}

void ExpectErrors(const PoseGroups& groups, const WeightedSet& set, const std::vector<double>& errors) {
  Eigen::VectorXd found = groups.ErrorsLeftOut(set);
  std::sort(found.begin(), found.end());
  ASSERT_EQ(found.size(), static_cast<long>(errors.size()));
  for (size_t k = 0; k < errors.size(); ++k) EXPECT_NEAR(found[static_cast<long>(k)], errors[k], 1e-5 * errors[k]);
}

TEST(PoseGroups, ErrorsLeftOutAreThoseOfRefits) {
  const CalibrationProblem problem = Campaign(18);  // each pose is a group
  const ParameterSet believed = FitFully(problem, JointOptions()).estimate.parameters;
  const Evidence evidence(problem, believed, ListCandidates(problem, believed), PriorMasses(),
                          std::numeric_limits<double>::infinity(), nullptr);
  const WeightedModel& leading = evidence.models()[0];
  ASSERT_FALSE(leading.set.members.empty());
  std::vector<EffectSpec> effects;
  for (const int member : leading.set.members) {
    ASSERT_FALSE(evidence.list().IsUnnamed(member)) << evidence.list().name[member];
    effects.push_back(evidence.list().SpecOf(member));
  }
  const PoseGroups groups(evidence, leading, InPlaces(evidence, leading));
  EXPECT_TRUE(groups.HasFewPoses());
  const std::vector<double> without = ErrorsLeftOut(problem, believed, {}, {});
  const std::vector<double> with = ErrorsLeftOut(problem, believed, effects, leading.set.scales);
  ExpectErrors(groups, {}, without);
  ExpectErrors(groups, leading.set, with);
  EXPECT_LT(with.back(), 0.5 * without.back());
}

TEST(PoseGroups, ManyPosesAreTwentyGroups) {
  const CalibrationProblem problem = Campaign(40);
  const ParameterSet believed = FitFully(problem, JointOptions()).estimate.parameters;
  const Evidence evidence(problem, believed, ListCandidates(problem, believed), PriorMasses(),
                          std::numeric_limits<double>::infinity(), nullptr);
  const WeightedModel& leading = evidence.models()[0];
  const PoseGroups groups(evidence, leading, InPlaces(evidence, leading));
  EXPECT_FALSE(groups.HasFewPoses());
  EXPECT_EQ(groups.ErrorsLeftOut({}).size(), 20);
  EXPECT_LT(groups.ErrorsLeftOut(leading.set).sum(), 0.7 * groups.ErrorsLeftOut({}).sum());
}

}  // namespace
}  // namespace sagitta::pose_groups_test

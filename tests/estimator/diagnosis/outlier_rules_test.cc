// Rules of outliers: bodies with many markers, and untouched rows.
#include "estimator/diagnosis/outlier_rules.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "estimator/diagnosis/diagnose.h"
#include "tests/support/dh_campaigns.h"
#include "tests/support/hidden_kr270.h"
#include "tests/support/random_vector.h"

namespace sagitta::outlier_rules_test {
namespace {

// Ten markers on one body have 24 degrees of freedom without its motion: noise makes 24 of them, more than what is the
// limit of three one time in five. One shot of forty is moved and turned, which no reading is to blame for.
TEST(OutlierRules, ManyMarkersOnABodyThatMovedAreNoOutliers) {
  test::DhCampaign campaign;
  campaign.nominal = campaign.rows;
  campaign.tools.clear();
  campaign.markers.clear();
  for (int m = 0; m < 10; ++m) {
    campaign.tools.push_back({0.02 * m - 0.09, m % 2 == 0 ? 0.01 : -0.01, 0.05});
    campaign.markers.push_back("P" + std::to_string(m));
  }
  const DiagnosedModel fit = FitFully(test::ProblemOf(campaign), JointOptions());
  const std::vector<int> rows = fit.problem->CalibrationObservations();
  const Eigen::Matrix3Xd& points = fit.estimate.predicted;
  const Eigen::Matrix3Xd turned = points(Eigen::all, fit.problem->data().shots[17].observations);
  const Vector3<double> middle = turned.rowwise().mean();
  const Vector3<double> axis = (turned.col(9) - turned.col(0)).unitOrthogonal();
  const Vector3<double> most = axis.cross(turned.col(9) - middle);
  NormalNumbers normal(78);
  int found = 0;
  for (int trial = 0; trial < 100; ++trial) {
    CalibrationProblem problem = *fit.problem;
    for (const int i : rows) {
      Observation& row = problem.mutable_data()->observations[static_cast<size_t>(i)];
      row.point_in_station = points.col(i) + campaign.sigma * test::RandomVector(normal);
      if (row.shot != 17) continue;
      const Vector3<double> move = 0.7 * most + 0.3 * axis.cross(points.col(i) - middle);
      row.point_in_station += std::sqrt(60.0) * campaign.sigma / most.norm() * move;
    }
    found += !FindOutliers(problem, fit.estimate.parameters, rows, {1e-3}).empty();
  }
  EXPECT_LE(found, 3);
}

// Four of 45 held-out readings are wrong, as many as a share of six in a hundred has in one of twenty hold-outs: an
// effect is judged by the others, and nothing is left because of them.
TEST(OutlierRules, AnEffectIsJudgedWithoutWrongReadingsAmongUntouchedRows) {
  CalibrationProblem problem = test::Hidden(3, [](double q) { return 400e-6 * std::cos(q); });
  const std::vector<int> held_out = problem.ValidationObservations();
  ASSERT_EQ(held_out.size(), 45u);
  for (const int k : {1, 12, 23, 38}) {
    Observation& row = problem.mutable_data()->observations[static_cast<size_t>(held_out[static_cast<size_t>(k)])];
    row.point_in_station += Vector3<double>(0.0, 0.0, 25.0 * row.sigma.z());
  }
  const Diagnosis diagnosis = Diagnose(problem, DiagnosisOptions());
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kExplained);
  EXPECT_EQ(diagnosis.effects.size(), 1u);
  EXPECT_EQ(diagnosis.noise.outliers_held_out, 4);
}

// Of one marker, three readings by 9.5 sigma: the arm could do the like, until what it does is in the model.
TEST(OutlierRules, WrongReadingsOfASingleMarkerAreFoundGivenEffects) {
  const auto move = [](Eigen::VectorXd* q) { (*q)[2] += 400e-6 * std::cos((*q)[2]); };
  CalibrationProblem problem = test::Moved(5, move, 120);
  for (size_t i = 0; i < problem.data().observations.size(); ++i) {
    if (problem.data().observations[i].marker > 0) problem.mutable_data()->ExcludeRow(static_cast<int>(i));
  }
  const std::vector<int> fitted = problem.CalibrationObservations();
  for (const size_t k : {5u, 20u, 66u}) {
    Observation& row = problem.mutable_data()->observations[static_cast<size_t>(fitted[k])];
    row.point_in_station += 9.5 / std::sqrt(3.0) * row.sigma;
  }
  const Diagnosis diagnosis = Diagnose(problem, DiagnosisOptions());
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kExplained);
  EXPECT_EQ(diagnosis.effects.size(), 1u);
  EXPECT_EQ(diagnosis.noise.outliers.size(), 3u);
}

}  // namespace
}  // namespace sagitta::outlier_rules_test

// Products that are made as they are asked for, against those of all rows at once.
#include "estimator/diagnosis/evidence_columns.h"

#include <gtest/gtest.h>

#include <set>

#include "estimator/diagnosis/driver_functions.h"
#include "estimator/diagnosis/explanations.h"
#include "tests/support/moved_kr270.h"

namespace sagitta {
namespace {

// Two stations see each pose, so that rows of one visit and of one pose are not the same.
CalibrationProblem Campaign() {
  const test::Kr270Design design = test::CampaignOf(25, 2, 2e-5, 1);
  Measurements data = test::DesignMeasurements(design);
  for (size_t s = 0; s < data.shots.size(); ++s) {
    data.shots[s].has_time = true;
    data.shots[s].time = 100.0 * static_cast<double>(s);
  }
  test::MeasureKr270(test::Kr270Truth(), design.sigma, 302, &data);
  return MakeCalibrationProblem(test::Kr270Robot(), data, Experiment());
}

JointScatter Scatter(int joints, double visit, double pose) {
  return {Eigen::VectorXd::Constant(joints, visit), Eigen::VectorXd::Constant(joints, pose)};
}

TEST(EvidenceColumns, ProductsThatAreAskedForAreThoseOfAllRows) {
  const CalibrationProblem problem = Campaign();
  const CandidateList candidates = ListCandidates(problem, problem.parameters);
  EvidenceColumns columns(problem, problem.parameters, candidates.candidates);
  const ExplanationList list = ListExplanations(problem, problem.parameters, candidates, PriorMasses(), &columns);
  std::set<std::vector<int>> own;
  for (const Explanation& explanation : list.math) own.insert(explanation.group.columns);
  const int joints = problem.robot().num_joints();
  for (const JointScatter& scatter :
       {StatedScatter(problem), Scatter(joints, 3e-5, 0.0), Scatter(joints, 2e-5, 4e-5)}) {
    const BesideBelieved whole = columns.Project(columns.Sum(scatter));
    const BesideBelieved asked = columns.ProjectAll(scatter, own);
    EXPECT_NEAR(asked.log_constant, whole.log_constant, 1e-9 * std::abs(whole.log_constant));
    EXPECT_EQ(asked.normal.dof, whole.normal.dof);
    EXPECT_NEAR(asked.normal.residual, whole.normal.residual, 1e-9 * whole.normal.residual);
    EXPECT_LT((asked.normal.gradient - whole.normal.gradient).norm(), 1e-9 * whole.normal.gradient.norm());
    for (const std::vector<int>& group : own) {
      const Eigen::MatrixXd block = whole.normal.information.Own(group);
      EXPECT_LE((asked.normal.information.Own(group) - block).norm(), 1e-8 * block.norm());
    }
    for (int c = 0; c < columns.num_columns(); c += 97) {
      const Eigen::MatrixXd row = whole.normal.information.Rows({c});
      EXPECT_LE((asked.normal.information.Rows({c}) - row).norm(), 1e-8 * row.norm()) << c;
      EXPECT_LE(
          (asked.normal.information.Between({c - c % 2}, {c}) - whole.normal.information.Between({c - c % 2}, {c}))
              .norm(),
          1e-8 * row.norm());
    }
  }
}

// Rows of what is fitted are those of a problem with the same rows.
TEST(EvidenceColumns, RowsOfTheSameProblemAreNotLinearizedAgain) {
  const CalibrationProblem problem = Campaign();
  const EvidenceColumns columns(problem, problem.parameters, {});
  const EvidenceColumns again(problem, problem.parameters, {}, &columns);
  const JointScatter scatter = StatedScatter(problem);
  EXPECT_EQ(columns.FittedProducts(scatter, {}), again.FittedProducts(scatter, {}));
}

// F is made again from few directions, however many columns it has: sines of 200 phases are two functions.
TEST(DriverFunctions, FewDirectionsAreKept) {
  for (const long shots : {40L, 500L}) {
    Eigen::MatrixXd functions(shots, 200);
    for (long c = 0; c < 200; ++c) {
      for (long s = 0; s < shots; ++s) {
        functions(s, c) = std::sin(0.1 * static_cast<double>(s) + 0.7 * static_cast<double>(c));
      }
    }
    const Compressed compressed = Compress(functions, 1e-5);
    EXPECT_EQ(compressed.basis.cols(), 2);
    EXPECT_LT((compressed.basis * compressed.mixing - functions).norm(), 1e-9 * functions.norm());
  }
}

}  // namespace
}  // namespace sagitta

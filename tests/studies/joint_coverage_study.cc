// Monte Carlo of the main job: KR-270, 18 configurations, two stations, three
// markers, sigma 0.1 mm, 39 unknowns. Prints, for every parameter, how often
// its 95 % interval covers the truth, its RMSE over the predicted sigma, and the
// RMSE over that of the linear least squares at the truth on the same draws.
//
//   sagitta_joint_coverage_study [trials=2000] [first seed=1000]
//
// The measurements come from the generator in tests/support, not from models/.
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/statistics/distributions.h"
#include "tests/support/kr270_experiment.h"
#include "tests/support/linear_bound.h"

int main(int argc, char** argv) {
  using namespace sagitta;  // NOLINT: a program of one page
  const int trials = argc > 1 ? std::atoi(argv[1]) : 2000;
  const int first_seed = argc > 2 ? std::atoi(argv[2]) : 1000;
  const test::Kr270Truth truth;
  const test::Kr270Design design;
  CalibrationProblem problem = test::Kr270Problem(design, truth, 1);
  const int n = problem.parameters.num_coordinates();
  const test::LinearBound bound(problem, test::TrueParameters(problem.parameters, truth, [&](const std::string& name) {
                                  return test::TrueValue(truth, name);
                                }));
  test::EfficiencyTally efficiency;
  std::vector<int> covered(n, 0);
  std::vector<double> squared_z(n, 0.0);
  int failed = 0;
  for (int trial = 0; trial < trials; ++trial) {
    test::MeasureKr270(truth, design.sigma, first_seed + trial, problem.mutable_data());
    const Estimate estimate = EstimateJointly(problem);
    if (estimate.status != Status::kConverged) {
      ++failed;
      continue;
    }
    efficiency.Add(bound.ErrorsOf(estimate), bound.Errors(problem));
    for (int i = 0; i < n; ++i) {
      const ParameterEstimate& row = estimate.table[i];
      const double value = test::TrueValue(truth, row.name);
      covered[i] += row.ci95.low <= value && value <= row.ci95.high;
      squared_z[i] += std::pow((row.value - value) / row.sigma, 2);
    }
    if ((trial + 1) % 200 == 0) std::fprintf(stderr, "%d of %d trials\n", trial + 1, trials);
  }
  const int used = trials - failed;
  const double error = std::sqrt(0.95 * 0.05 / used);
  int outside = 0, inefficient = 0;
  const Eigen::ArrayXd ratio = efficiency.Ratio(), over_bound = efficiency.OverBound(bound.sigma());
  for (int i = 0; i < n; ++i) {
    const double coverage = covered[i] / static_cast<double>(used);
    outside += coverage < 0.93 || coverage > 0.97;
    inefficient += ratio[i] > 1.01;
    std::printf("%-18s coverage %.4f  rmse/sigma %.3f  rmse / linear %.5f  rmse / bound %.4f\n",
                problem.parameters.coordinates()[i].name.c_str(), coverage, std::sqrt(squared_z[i] / used), ratio[i],
                over_bound[i]);
  }
  std::printf(
      "%d trials (seeds %d..%d), %d not converged, Monte-Carlo error of a coverage %.4f, outside 0.93-0.97: %d of %d\n",
      trials, first_seed, first_seed + trials - 1, failed, error, outside, n);
  std::printf("rmse over the linear one on the same draws: %.5f at most; above 1.01: %d of %d\n", ratio.maxCoeff(),
              inefficient, n);
  return failed > 0 || outside > 0 || inefficient > 0;
}

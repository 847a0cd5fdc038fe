// Monte Carlo of the joint solve with loads: KR-270, 20 configurations, two
// stations, three markers on the flange and one on A1 and A2, 250 kg, two
// sideways pulls in three configurations, spring of paper 002 with L measured.
// The measurements come from the generator in tests/support, not from models/.
//
//   sagitta_loaded_study [trials=2000] [paired=200] [seeds=200]
//
// Prints how often the distance of all parameters to the truth has p > 1e-5
// (`seeds`), the coverage of every 95 % interval and the RMSE over that of the
// linear least squares at the truth on the same draws (`trials`), and the RMSE of
// joint over exact two-step with its standard error (`paired`).
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "estimator/baselines/compare_methods.h"
#include "estimator/calibration/joint_estimator.h"
#include "estimator/statistics/distributions.h"
#include "tests/support/linear_bound.h"
#include "tests/support/loaded_kr270.h"

namespace {

using namespace sagitta;  // NOLINT: a program of two pages

struct Tally {
  int covered = 0;
  double z2 = 0.0;                               // sum of (error / sigma)^2
  double joint2 = 0.0, two2 = 0.0;               // sums of squared errors, paired
  double cross = 0.0, joint4 = 0.0, two4 = 0.0;  // of their squares, for the standard error
};

// Standard error of sqrt(sum a / sum b) from paired squared errors a, b.
double RatioError(const Tally& t, int n) {
  const double ratio2 = t.joint2 / t.two2;
  const double variance = (t.joint4 - 2 * ratio2 * t.cross + ratio2 * ratio2 * t.two4) / n;
  return std::sqrt(std::max(0.0, variance) / n) / (t.two2 / n) / (2 * std::sqrt(ratio2));
}

}  // namespace

int main(int argc, char** argv) {
  const int trials = argc > 1 ? std::atoi(argv[1]) : 2000;
  const int paired = argc > 2 ? std::atoi(argv[2]) : 200;
  const int seeds = argc > 3 ? std::atoi(argv[3]) : 200;
  const test::LoadedTruth truth = test::Everything();
  const test::LoadedDesign design = test::WithPulls();
  test::LoadedSetup setup = test::SetupFor(truth);
  setup.robot.compliances.push_back({1, {{0.0, 0.25e-6}}, false});  // where the two-step method starts
  Measurements data = test::LoadedRows(design, truth);
  const std::vector<Vector3<double>> exact = test::ExactPoints(truth, data);
  test::Measure(exact, design.sigma, 1, &data);
  CalibrationProblem problem = MakeCalibrationProblem(setup.robot, data, setup.experiment);
  const test::LinearBound bound(problem, test::TrueParameters(problem.parameters, truth, [&](const std::string& name) {
                                  return test::TrueLoadedValue(truth, name);
                                }));
  test::EfficiencyTally efficiency;
  std::vector<Tally> tallies(problem.parameters.num_coordinates());
  std::vector<int> estimated;
  int failed = 0, near = 0, two_step_failed = 0, used_pairs = 0;
  double largest_deviation = 0.0;
  const int runs = std::max(trials, std::max(paired, seeds));
  for (int run = 0; run < runs; ++run) {
    test::Measure(exact, design.sigma, 1000 + run, problem.mutable_data());
    const Estimate joint = EstimateJointly(problem);
    if (joint.status != Status::kConverged) {
      ++failed;
      continue;
    }
    estimated = joint.estimated;
    const double p = ChiSquareSurvival(test::SquaredDistanceToTruth(joint, truth), estimated.size());
    if (run < seeds) near += p > 1e-5;
    if (run < trials) efficiency.Add(bound.ErrorsOf(joint), bound.Errors(problem));
    const double quantile = joint.sigma.scaled ? StudentQuantile(0.975, joint.dof) : NormalQuantile(0.975);
    for (const int i : estimated) {
      const double z = test::ErrorOf(joint, truth, i) / joint.table[i].sigma;
      if (run >= trials) continue;
      tallies[i].covered += std::abs(z) <= quantile;
      tallies[i].z2 += z * z;
    }
    if ((run + 1) % 200 == 0) std::fprintf(stderr, "%d of %d\n", run + 1, runs);
    if (run >= paired) continue;
    const MethodResult two_step = RunMethod(problem, Method::kTwoStep, joint);
    if (!IsUsable(two_step.estimate.status)) {
      ++two_step_failed;
      continue;
    }
    ++used_pairs;
    largest_deviation = std::max(largest_deviation, two_step.max_deviation_sigma);
    for (const int i : estimated) {
      const double a = std::pow(test::ErrorOf(joint, truth, i), 2);
      const double b = std::pow(test::ErrorOf(two_step.estimate, truth, i), 2);
      Tally& t = tallies[i];
      t.joint2 += a, t.two2 += b, t.cross += a * b, t.joint4 += a * a, t.two4 += b * b;
    }
  }
  int outside = 0, worse = 0;
  const Eigen::ArrayXd over_linear = efficiency.Ratio(), over_bound = efficiency.OverBound(bound.sigma());
  for (int c = 0; c < over_linear.size(); ++c) {
    std::printf("%-18s rmse / linear %.5f  rmse / bound %.4f\n",
                problem.parameters.coordinates()[bound.columns()[c]].name.c_str(), over_linear[c], over_bound[c]);
  }
  const auto inefficient = static_cast<int>((over_linear > 1.01).count());
  std::printf("rmse over the linear one on the same draws: %.5f at most; above 1.01: %d of %d\n",
              over_linear.maxCoeff(), inefficient, static_cast<int>(over_linear.size()));
  for (const int i : estimated) {
    const Tally& t = tallies[i];
    const double coverage = t.covered / static_cast<double>(trials - failed);
    const double ratio = std::sqrt(t.joint2 / t.two2), error = RatioError(t, std::max(1, used_pairs));
    outside += coverage < 0.93 || coverage > 0.97;
    worse += ratio > 1 + std::max(1e-6, 2 * error);
    std::printf("%-18s coverage %.4f  rmse/sigma %.3f  rmse joint / two-step %.9f +- %.1e\n",
                problem.parameters.coordinates()[i].name.c_str(), coverage, std::sqrt(t.z2 / (trials - failed)), ratio,
                error);
  }
  std::printf("%zu unknowns; p > 1e-5 in %d of %d seeds; %d of %d runs not converged; coverage outside 0.93-0.97: %d\n",
              estimated.size(), near, seeds, failed, runs, outside);
  std::printf("two-step: %d pairs, %d not converged, at most %.1e standard deviations from joint, joint worse in %d\n",
              used_pairs, two_step_failed, largest_deviation, worse);
  return failed > 0 || near < seeds || outside > 0 || worse > 0 || inefficient > 0;
}

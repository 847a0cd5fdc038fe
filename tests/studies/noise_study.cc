// Monte Carlo of noise: are intervals true where joints do not repeat, where a
// tracker reads ranges and angles, and where readings are spoilt?
//
//   sagitta_noise_study common|reapproached [trials=200] [first seed=1000] [draws of the configurations=1]
//   sagitta_noise_study tracker             [trials=200] [first seed=1000]
//   sagitta_noise_study outliers-huber|outliers-cauchy [trials=200] [first seed=1000]
//
// Truth and measurements come from generators in tests/support, not from models/.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "estimator/statistics/distributions.h"
#include "tests/support/noise_experiment.h"

namespace sagitta {
namespace {

using test::IntervalTally;

struct Range {
  int trials = 200;
  int first = 1000;
};

void Print(const char* name, const IntervalTally& tally) {
  std::printf("%-34s coverage %.3f [%.3f, %.3f]  failed %d\n", name, tally.Coverage(), tally.LeastCoverage(),
              tally.MostCoverage(), tally.failed);
}

// RMS over the coordinates of unseen configurations, noise-free truth, m.
double ValidationRms(const CalibrationProblem& unseen, const Estimate& estimate) {
  ParameterSet parameters = unseen.parameters;
  parameters.CopyByName(estimate.parameters);
  const std::vector<int> rows = unseen.CalibrationObservations();
  const Eigen::Matrix3Xd predicted = PredictPoints(unseen, parameters, rows);
  double sum = 0.0;
  for (size_t k = 0; k < rows.size(); ++k) {
    sum += (unseen.data().observations[rows[k]].point_in_station - predicted.col(k)).squaredNorm();
  }
  return std::sqrt(sum / (3.0 * rows.size()));
}

constexpr double kPerAxis = 6e-5;  // m, RMS: what the joints' deviations move a coordinate by

// What one draw of the 18 configurations gives.
struct RepeatFigures {
  std::vector<IntervalTally> tallies;
  std::vector<double> validation;  // m, RMS
  double joint = 0.0;              // rad, true
  double found = 0.0, tracker = 0.0;
  int covered = 0, per_joint = 0;
};

std::vector<std::pair<const char*, Experiment>> RepeatMethods(double joint) {
  Experiment stated, estimated, known, unknown;
  stated.noise = {NoiseSpec::From::kSigma, 1e-4, true};
  estimated.method.weights = Weights::kEqual;
  known.repeatability.angle.common = joint;
  unknown.noise.from = NoiseSpec::From::kVarianceComponents;
  return {{"independent, sigma 0.1 mm", stated},
          {"independent, sigma estimated", estimated},
          {"joint deviations known", known},
          {"variance components (REML)", unknown}};
}

RepeatFigures RunRepeats(bool reapproached, int design_seed, const Range& range) {
  const test::Kr270Truth truth;
  test::RepeatDesign design;
  design.reapproached = reapproached;
  design.seed = design_seed;
  Measurements data = test::RepeatRows(design);
  design.joint = test::JointDeviationFor(kPerAxis, truth, data);
  const auto methods = RepeatMethods(design.joint);
  test::RepeatDesign elsewhere;
  elsewhere.configurations = 40;
  elsewhere.repeats = 1;
  elsewhere.seed = 99;
  elsewhere.joint = elsewhere.tracker = 0.0;
  Measurements unseen_data = test::RepeatRows(elsewhere);
  for (Observation& observation : unseen_data.observations) observation.sigma.setConstant(1e-5);
  test::MeasureRepeated(truth, elsewhere, 1, &unseen_data);
  const CalibrationProblem unseen = test::Kr270ProblemOf(unseen_data, Experiment());
  RepeatFigures figures;
  figures.joint = design.joint;
  figures.tallies.resize(methods.size());
  figures.validation.assign(methods.size(), 0.0);
  for (int t = 0; t < range.trials; ++t) {
    test::MeasureRepeated(truth, design, range.first + t, &data);
    for (size_t m = 0; m < methods.size(); ++m) {
      const ResolvedEstimate result = EstimateWithNoise(test::Kr270ProblemOf(data, methods[m].second));
      figures.tallies[m].Add(result.estimate, truth);
      figures.validation[m] += std::pow(ValidationRms(unseen, result.estimate), 2) / range.trials;
      if (m != 3) continue;
      const NoiseReport& report = result.estimate.noise_report;
      figures.per_joint += report.per_joint;
      figures.tracker += report.components[0].value * design.tracker / range.trials;
      figures.found += report.components[1].value / range.trials;
      figures.covered += report.components[1].low <= design.joint && design.joint <= report.components[1].high;
    }
  }
  for (double& mean_square : figures.validation) mean_square = std::sqrt(mean_square);
  return figures;
}

void PrintRange(const char* name, std::vector<double> values) {
  std::sort(values.begin(), values.end());
  std::printf("%-52s %.3f  [%.3f, %.3f]\n", name, values[values.size() / 2], values.front(), values.back());
}

// Over several draws of the configurations: what a table of one draw may say.
void StudyRepeats(bool reapproached, const Range& range, int designs) {
  std::vector<RepeatFigures> all;
  for (int design = 1; design <= designs; ++design) {
    all.push_back(RunRepeats(reapproached, design, range));
    const RepeatFigures& own = all.back();
    std::printf("design %d: joints deviate by %.1f urad, which move a coordinate by 60 um RMS\n", design,
                1e6 * own.joint);
    const auto methods = RepeatMethods(own.joint);
    for (size_t m = 0; m < methods.size(); ++m) {
      Print(methods[m].first, own.tallies[m]);
      std::printf("%-34s rmse over that with known components %.3f (median), validation %.1f um\n", "",
                  test::MedianRatio(own.tallies[m], own.tallies[2]), 1e6 * own.validation[m]);
    }
    std::printf("REML: joints %.1f urad, interval covers %.3f, tracker %.2f um, one per joint chosen %d times\n",
                1e6 * own.found, own.covered / static_cast<double>(range.trials), 1e6 * own.tracker, own.per_joint);
    std::fflush(stdout);
  }
  const auto over_designs = [&](const char* name, const auto& figure) {
    std::vector<double> values;
    for (const RepeatFigures& own : all) values.push_back(figure(own));
    PrintRange(name, values);
  };
  std::printf("\n%d designs, %d trials each: median [least, most]\n", designs, range.trials);
  over_designs("coverage, independent, sigma 0.1 mm", [](const auto& f) { return f.tallies[0].Coverage(); });
  over_designs("coverage, independent, sigma estimated", [](const auto& f) { return f.tallies[1].Coverage(); });
  over_designs("coverage, joint deviations known", [](const auto& f) { return f.tallies[2].Coverage(); });
  over_designs("coverage, variance components", [](const auto& f) { return f.tallies[3].Coverage(); });
  over_designs("rmse, independent over joint deviations known",
               [](const auto& f) { return test::MedianRatio(f.tallies[0], f.tallies[2]); });
  over_designs("rmse, variance components over known",
               [](const auto& f) { return test::MedianRatio(f.tallies[3], f.tallies[2]); });
  over_designs("validation um, independent", [](const auto& f) { return 1e6 * f.validation[0]; });
  over_designs("validation um, variance components", [](const auto& f) { return 1e6 * f.validation[3]; });
}

void StudyTracker(const Range& range) {
  const test::Kr270Truth truth;
  const test::TrackerTruth tracker;
  test::Kr270Design design;
  design.configurations = 30;
  Measurements data = test::DesignMeasurements(design);
  for (Observation& observation : data.observations) observation.sigma.setZero();
  Experiment per_axis;
  per_axis.noise = {NoiseSpec::From::kSigma, 4e-5};
  const std::vector<std::pair<const char*, Experiment>> methods = {
      {"range and angles", test::TrackerExperiment(tracker)},
      {"one sigma per axis, stated", per_axis},
      {"one sigma, estimated", Experiment()}};
  std::vector<IntervalTally> tallies(methods.size());
  std::vector<double> whitened;
  for (int t = 0; t < range.trials; ++t) {
    test::MeasureByTracker(truth, tracker, range.first + t, &data);
    for (size_t m = 0; m < methods.size(); ++m) {
      const CalibrationProblem problem = test::Kr270ProblemOf(data, methods[m].second);
      tallies[m].Add(EstimateWithNoise(problem).estimate, truth);
      if (m == 0) test::AppendWhitenedErrors(truth, problem, &whitened);
    }
  }
  double nearest = 1e9, farthest = 0.0;
  for (const Observation& row : data.observations) {
    const Vector3<double> place = test::TrackerPlaces()[data.shots[row.shot].station];
    const double r = (test::ExactPoint(truth, data, row) - place).norm();
    nearest = std::min(nearest, r);
    farthest = std::max(farthest, r);
  }
  std::printf("ranges %.1f to %.1f m, %zu whitened coordinates: Kolmogorov p = %.3f\n", nearest, farthest,
              whitened.size(),
              KolmogorovSurvival(test::KolmogorovDistance(whitened), static_cast<double>(whitened.size())));
  for (size_t m = 0; m < methods.size(); ++m) {
    Print(methods[m].first, tallies[m]);
    std::printf("%-34s rmse over that with range and angles %.3f (median)\n", "",
                test::MedianRatio(tallies[m], tallies[0]));
  }
}

void StudyOutliers(const std::string& loss, const Range& range) {
  const test::Kr270Truth truth;
  test::Kr270Design design;
  design.configurations = 40;
  design.sigma = 3e-5;
  Measurements data = test::DesignMeasurements(design);
  Experiment robust;
  robust.method.loss = *FindChoice<LossKind>(loss);
  IntervalTally clean, spoilt, plain;
  test::FlagTally flags;
  for (int t = 0; t < range.trials; ++t) {
    test::MeasureKr270(truth, design.sigma, range.first + t, &data);
    clean.Add(EstimateWithNoise(test::Kr270ProblemOf(data, Experiment())).estimate, truth);
    const std::set<int> rows = test::Spoil(0.05, 77 + range.first + t, &data);
    const Estimate estimate = EstimateWithNoise(test::Kr270ProblemOf(data, robust)).estimate;
    spoilt.Add(estimate, truth);
    flags.Add(estimate, rows);
  }
  Print("clean, least squares", clean);
  Print(("5 % spoilt, " + loss).c_str(), spoilt);
  std::printf("rmse over that of the clean fit %.3f (median)\n", test::MedianRatio(spoilt, clean));
  std::printf("precision %.4f, recall %.4f, called systematic %d times, %d rows recognised as exchanged\n",
              flags.Precision(), flags.Recall(), flags.systematic, flags.exchanged);
}

}  // namespace
}  // namespace sagitta

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "";
  sagitta::Range range;
  if (argc > 2) range.trials = std::atoi(argv[2]);
  if (argc > 3) range.first = std::atoi(argv[3]);
  if (what == "common" || what == "reapproached") {
    sagitta::StudyRepeats(what == "reapproached", range, argc > 4 ? std::atoi(argv[4]) : 1);
  } else if (what == "tracker") {
    sagitta::StudyTracker(range);
  } else if (what == "outliers-huber" || what == "outliers-cauchy") {
    sagitta::StudyOutliers(what.substr(9), range);
  } else {
    std::fprintf(stderr, "which: common, reapproached, tracker, outliers-huber or outliers-cauchy\n");
    return 2;
  }
  return 0;
}

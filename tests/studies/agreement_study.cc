// Real data: do intervals from disjoint parts of the measurements agree?
//
//   sagitta_agreement_study [splits=50] [seed=1]
//
// UR10, series B, C and D (../shared/data/ur10_leica): random halves of the
// configurations; the series against each other; halves of the workspace against
// each other. For each: the share of differences within their joint 95 % interval
// and the inflation, the factor on the intervals with which 95 % would be. Random
// halves share every model error, regions do not: what they ask for beyond 1 is
// what the model's error adds. UR5: predicted against observed validation RMS.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "tests/support/agreement.h"
#include "tests/support/real_data.h"

namespace {

using namespace sagitta;  // NOLINT: a program of two pages
using test::Agreement;

const std::vector<std::string> kSeries = {"B", "C", "D"};

CalibrationProblem Ur10(const std::string& covariance) {
  Experiment experiment;
  experiment.method.covariance = *FindChoice<CovarianceKind>(covariance);
  return test::RealProblem("ur10_leica", {"series_B.csv", "series_C.csv", "series_D.csv"}, experiment);
}

void Print(const char* what, const std::string& covariance, const Agreement& agreement) {
  std::printf("%-34s %-9s %5d differences, within 95 %% interval: %.3f, inflation %.2f\n", what, covariance.c_str(),
              agreement.compared, agreement.share(), agreement.Inflation());
}

// Each series alone; geometry is what they have in common.
Agreement BetweenSeries(const std::string& covariance) {
  std::vector<CalibrationProblem> problems;
  std::vector<Estimate> estimates;
  Experiment experiment;
  experiment.method.covariance = *FindChoice<CovarianceKind>(covariance);
  for (const std::string& series : kSeries) {
    problems.push_back(test::RealProblem("ur10_leica", {"series_" + series + ".csv"}, experiment));
    estimates.push_back(EstimateJointly(problems.back()));
  }
  Agreement all;
  for (size_t a = 0; a < kSeries.size(); ++a) {
    for (size_t b = a + 1; b < kSeries.size(); ++b) {
      Agreement pair;
      const int coordinates =
          std::min(estimates[a].parameters.num_coordinates(), estimates[b].parameters.num_coordinates());
      if (coordinates == 0) continue;
      test::Compare(estimates[a], estimates[b], "geometry/", &pair);
      Print(("series " + kSeries[a] + " against " + kSeries[b]).c_str(), covariance, pair);
      all.Add(pair);
    }
  }
  return all;
}

// Halves by a joint or by where the marker is, at the median of each station.
Agreement BetweenRegions(const CalibrationProblem& problem, const std::string& covariance) {
  Agreement all;
  const ParameterSet start = EstimateJointly(problem).parameters;
  for (const char* by : {"A1", "A2", "A3", "x", "y", "z"}) {
    std::vector<std::vector<double>> values(problem.data().stations.size());
    const auto value_of = [&](const Observation& observation) {
      if (by[0] == 'A') return problem.data().ConfigurationOf(observation).q[by[1] - '1'];
      return observation.point_in_station[by[0] - 'x'];
    };
    const auto station_of = [&](const Observation& observation) {
      return problem.data().shots[observation.shot].station;
    };
    for (const Observation& observation : problem.data().observations) {
      values[station_of(observation)].push_back(value_of(observation));
    }
    for (std::vector<double>& own : values) std::nth_element(own.begin(), own.begin() + own.size() / 2, own.end());
    const auto half = [&](bool above) {
      return test::EstimatePart(problem, start, [&](const Observation& observation) {
        const std::vector<double>& own = values[station_of(observation)];
        return (value_of(observation) >= own[own.size() / 2]) == above;
      });
    };
    const Estimate a = half(true), b = half(false);
    Agreement pair;
    if (IsUsable(a.status) && IsUsable(b.status)) test::Compare(a, b, "geometry/", &pair);
    Print((std::string("halves of the workspace by ") + by).c_str(), covariance, pair);
    all.Add(pair);
  }
  return all;
}

void PredictedRms(const std::string& covariance) {
  Experiment experiment;
  experiment.method.covariance = *FindChoice<CovarianceKind>(covariance);
  experiment.validation.kind = ValidationSpec::Kind::kColumn;
  experiment.validation.column = "group";
  experiment.validation.values = {"random"};
  const Estimate estimate = EstimateJointly(test::RealProblem("ur5_gts3800", {"measurements.csv"}, experiment));
  std::printf("UR5 grid -> random, %s: predicted %.4f mm, observed %.4f mm, ratio %.3f\n", covariance.c_str(),
              1e3 * estimate.validation_predicted_rms, 1e3 * estimate.validation.rms,
              estimate.validation_predicted_rms / estimate.validation.rms);
}

}  // namespace

int main(int argc, char** argv) {
  const int splits = argc > 1 ? std::atoi(argv[1]) : 50;
  const int seed = argc > 2 ? std::atoi(argv[2]) : 1;
  if (!test::HasRealData()) {
    std::printf("no ../shared/data: nothing to study\n");
    return 0;
  }
  for (const char* covariance : {"model", "sandwich"}) {
    PredictedRms(covariance);
    const CalibrationProblem problem = Ur10(covariance);
    const auto progress = [&](int done) { std::fprintf(stderr, "split %d of %d\n", done, splits); };
    Print("random halves", covariance, test::CompareRandomHalves(problem, splits, seed, progress));
    Print("between series", covariance, BetweenSeries(covariance));
    Print("between halves of the workspace", covariance, BetweenRegions(problem, covariance));
    std::fflush(stdout);
  }
  return 0;
}

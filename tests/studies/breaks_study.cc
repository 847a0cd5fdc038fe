// How far must something move halfway through a campaign before the verdict says so (estimator/agreement/breaks.h)?
//
//   sagitta_breaks_study [campaigns=10]
//
// A KR-270 of a generator of its own (tests/support/loaded_kr270.h), one station, three markers, 50 um of noise, 60
// configurations, each under one load: the loads in turn. For each thing that moves: the smallest of the sizes tried
// (RMS of the points after it, in standard deviations of a coordinate) that is named, with its place to three shots, in
// nine of ten campaigns, and how often something is named where nothing moved.
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "estimator/agreement/breaks.h"
#include "estimator/calibration/joint_estimator.h"
#include "tests/support/loaded_kr270.h"

namespace {

using namespace sagitta;  // NOLINT: a program of two pages

constexpr int kShots = 60, kAt = 36;
constexpr double kSigma = 5e-5;  // m

struct Loading {
  const char* words;
  std::vector<std::string> loads;
};
const Loading kLoadings[] = {
    {"no load", {}}, {"a load on and off", {"V250"}}, {"three loads and none in turn", {"V250", "PX", "PY"}}};

struct Mover {
  const char* words;
  BreakOf of;
  int index;
  void (*move)(double by, test::LoadedTruth* truth);  // m
};
const Mover kMovers[] = {
    {"the station", BreakOf::kStation, 0,
     [](double by, auto* t) { t->base_xyz[0] += Vector3<double>(0.6, 0, -0.8) * by; }},
    {"one marker of three", BreakOf::kMarker, 1, [](double by, auto* t) { t->tools[1] += Vector3<double>(0, by, 0); }},
    {"the zero of A3", BreakOf::kJoint, 2, [](double by, auto* t) { t->errors[7] += by / 1.3; }},  // lever of 1.3 m
};

// Configurations under the loads in turn.
Measurements Rows(const Loading& loading, const test::LoadedTruth& truth, std::uint64_t seed) {
  test::LoadedDesign design;
  design.configurations = kShots;
  design.stations = 1;
  design.seed = seed;
  design.sigma = kSigma;
  Measurements data = test::DesignMeasurements(design);
  for (size_t s = 0; s < data.shots.size(); ++s) {
    const size_t state = s % (1 + loading.loads.size());
    if (state == 0) continue;
    data.shots[s].load = loading.loads[state - 1];
    data.shots[s].wrench.force = truth.loads.at(data.shots[s].load).force;
  }
  return data;
}

CalibrationProblem Measured(const Loading& loading, const Mover& mover, double by, std::uint64_t seed) {
  test::LoadedTruth truth = test::Everything();
  truth.spring.reset();
  truth.link_markers.clear();
  Measurements data = Rows(loading, truth, seed);
  test::LoadedTruth after = truth;
  mover.move(by, &after);
  std::vector<Vector3<double>> points = test::ExactPoints(truth, data), later = test::ExactPoints(after, data);
  for (size_t i = 0; i < points.size(); ++i) {
    if (data.observations[i].shot >= kAt) points[i] = later[i];
  }
  test::Measure(points, kSigma, 500 + seed, &data);
  test::LoadedSetup setup = test::SetupFor(truth);
  if (loading.loads.empty()) setup.experiment.loads.clear();
  return MakeCalibrationProblem(setup.robot, data, setup.experiment);
}

std::optional<Break> Find(const CalibrationProblem& problem) { return FindBreak(problem, EstimateJointly(problem)); }

bool IsNamed(const CalibrationProblem& problem, const Mover& mover) {
  const std::optional<Break> found = Find(problem);
  if (!found || found->of != mover.of || found->index != mover.index) return false;
  return std::abs(problem.data().observations[found->first].shot - kAt) <= 3;
}

void Print(const Loading& loading, int campaigns) {
  int by_chance = 0;
  for (int seed = 1; seed <= campaigns; ++seed)
    by_chance += Find(Measured(loading, kMovers[0], 0.0, static_cast<std::uint64_t>(seed))).has_value();
  std::printf("%s: nothing moved, named in %d of %d\n", loading.words, by_chance, campaigns);
  for (const Mover& mover : kMovers) {
    std::printf("  %-20s", mover.words);
    for (const double sigmas : {1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0}) {
      int named = 0;
      for (int seed = 1; seed <= campaigns; ++seed)
        named += IsNamed(Measured(loading, mover, sigmas * kSigma, static_cast<std::uint64_t>(seed)), mover);
      std::printf("  %2.0f: %d", sigmas, named);
      std::fflush(stdout);
      if (10 * named >= 9 * campaigns) break;
    }
    std::printf("\n");
  }
}

}  // namespace

int main(int argc, char** argv) {
  const int campaigns = argc > 1 ? std::atoi(argv[1]) : 10;
  for (const Loading& loading : kLoadings) Print(loading, campaigns);
  return 0;
}

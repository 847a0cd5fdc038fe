// Monte Carlo of `sagitta changed`: how often does it name a change where there is none, and does it name the right
// one?
//
//   sagitta_changed_study [pairs=200] [first seed=1] [nothing|A3|tool|base|lengths|anew|scatter: only these]
//
// Two calibrations of one KR 270 that a generator of its own measures (tests/support/kr270_experiment.h): 24
// configurations at two stations, three markers, 0.03 mm, other poses and other noise each time. The robot's errors are
// drawn anew for every pair, the second calibration's robot has the change. `anew`: both stations stand metres and
// radians elsewhere the second time, and are to be named in addition. `scatter`: every joint stops 30 urad (standard
// deviation) off its reading at each configuration, which no estimate was given.
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "estimator/changes/changes.h"
#include "estimator/sagitta.h"
#include "estimator/statistics/distributions.h"
#include "problems/text.h"
#include "tests/support/kr270_experiment.h"

namespace sagitta {
namespace {

using test::Kr270Truth;

constexpr double kSigma = 3e-5;    // m
constexpr double kScatter = 3e-5;  // rad

// Errors of 0.3 mm and 0.3 mrad (standard deviations) in addition to the published ones.
Kr270Truth RandomTruth(std::uint64_t seed) {
  Kr270Truth truth;
  NormalNumbers normal(seed);
  for (double& error : truth.errors) error += 3e-4 * normal();
  return truth;
}

struct Case {
  std::string words, name;  // name: what has to be named, "" where nothing changed
  std::function<void(Kr270Truth*)> change;
  double size = 0.0;     // in the unit of the change's value
  bool anew = false;     // stations
  double scale = 1.0;    // of all that the second instruments measure
  bool scatter = false;  // of the joints
};

KnownRobot Calibrated(const Kr270Truth& truth, std::uint64_t seed, double scale, bool scatter) {
  test::Kr270Design design;
  design.seed = seed;
  design.configurations = 24;
  design.sigma = kSigma;
  Measurements data = test::DesignMeasurements(design), moved = data;
  NormalNumbers normal(seed + 300000);
  for (Configuration& configuration : moved.configurations) {
    for (double& joint : configuration.q) joint += scatter ? kScatter * normal() : 0.0;
  }
  test::MeasureKr270(truth, kSigma, seed + 500000, &moved);
  for (size_t i = 0; i < data.observations.size(); ++i) {
    data.observations[i].point_in_station = scale * moved.observations[i].point_in_station;
  }
  return KnownFrom(Calibrate(test::Kr270ProblemOf(data, Experiment())));
}

void SetUpAnew(std::uint64_t seed, Kr270Truth* truth) {
  NormalNumbers normal(seed);
  for (size_t s = 0; s < truth->base_xyz.size(); ++s) {
    truth->base_xyz[s] += 2.0 * test::RandomVector(normal);
    truth->base_rotvec[s] += test::RandomVector(normal);
  }
}

std::vector<Case> Cases() {
  std::vector<Case> cases = {{"nothing changed", "", [](Kr270Truth*) {}}};
  for (const double size : {0.1, 0.2, 0.4}) {  // mrad
    const auto slip = [size](Kr270Truth* truth) { truth->errors[7] += 1e-3 * size; };
    cases.push_back({"A3 slipped by " + Significant(size, 2) + " mrad", "joint_zero/A3", slip, size});
  }
  for (const double size : {0.1, 0.2, 0.4}) {  // mm, and as many mrad
    const auto knock = [size](Kr270Truth* truth) {
      const Vector3<double> turn = 1e-3 * size * Vector3<double>(0.6, 0.0, 0.8);
      for (Vector3<double>& tool : truth->tools)
        tool = RotationFromVector(turn) * tool + 1e-3 * size * Vector3<double>(0.6, -0.8, 0.0);
    };
    cases.push_back({"tool knocked by " + Significant(size, 2) + " mm, mrad", "tool/flange", knock, size});
  }
  for (const double size : {0.1, 0.2, 0.4}) {
    const auto move = [size](Kr270Truth* truth) {
      truth->base_xyz[0] += 1e-3 * size * Vector3<double>(0.8, -0.6, 0.0);
      truth->base_rotvec[0] += 1e-3 * size * Vector3<double>(0.0, 0.6, 0.8);
    };
    cases.push_back({"base moved by " + Significant(size, 2) + " mm, mrad", "base/S1", move, size});
  }
  for (const double ppm : {10.0, 20.0, 40.0}) {
    cases.push_back({"lengths measured by " + Significant(ppm, 2) + " ppm more", "scale/lengths", [](Kr270Truth*) {},
                     ppm, false, 1.0 + 1e-6 * ppm});
  }
  std::vector<Case> anew;
  for (const Case& one : cases) {
    if (one.name.rfind("base", 0) == 0 || one.scale > 1.0 || one.size > 0.25 || (one.size > 0.0 && one.size < 0.15))
      continue;
    anew.push_back({"anew: " + one.words, one.name, one.change, one.size, true});
  }
  for (const Case& one : cases) {
    const bool is_seen = one.size == 0.0 || (one.name == "joint_zero/A3" && one.size > 0.25);
    if (is_seen) anew.push_back({"scatter: " + one.words, one.name, one.change, one.size, false, 1.0, true});
  }
  cases.insert(cases.end(), anew.begin(), anew.end());
  return cases;
}

std::string Rate(int count, int of) {
  const BinomialInterval interval = ClopperPearson(count, of);
  char text[80];
  std::snprintf(text, sizeof text, "%3d of %d (%.1f %%; 95 %%: %.1f to %.1f %%)", count, of, 100.0 * count / of,
                100.0 * interval.low, 100.0 * interval.high);
  return text;
}

void Run(const Case& one, int pairs, std::uint64_t first) {
  int said = 0, sure = 0, right = 0, among = 0, covered = 0, known = 0, moved = 0;
  for (int pair = 0; pair < pairs; ++pair) {
    const std::uint64_t seed = first + 2 * static_cast<std::uint64_t>(pair);
    const Kr270Truth before = RandomTruth(900000 + seed);
    Kr270Truth after = before;
    one.change(&after);
    if (one.anew) SetUpAnew(700000 + seed, &after);
    const Changes found =
        FindChanges(Calibrated(before, seed, 1.0, one.scatter), Calibrated(after, seed + 1, one.scale, one.scatter));
    bool any = false, any_sure = false, is_among = false;
    size_t others = found.changes.size(), stations = 0;
    for (const Change& change : found.changes) {
      if (one.anew && change.kind == ChangeKind::kBase) {
        ++stations;
        continue;
      }
      any |= change.probability > 0.5;
      any_sure |= change.probability > 0.95;
      const bool is_right = WordOf(change.kind) + "/" + change.target == one.name;
      is_among |= is_right;
      if (!is_right) continue;
      ++known;
      covered += change.ci95[0] <= one.size && one.size <= change.ci95[1];
    }
    others -= stations;
    said += one.anew ? any : found.nothing < 0.5;
    sure += any_sure;
    among += is_among;
    right += is_among && others == 1;
    moved += stations == before.base_xyz.size();
  }
  std::printf("%s\n  a change is named          %s\n  with more than 95 %%        %s\n", one.words.c_str(),
              Rate(said, pairs).c_str(), Rate(sure, pairs).c_str());
  if (!one.name.empty()) {
    std::printf("  the right one is named     %s\n  the right one and no other %s\n", Rate(among, pairs).c_str(),
                Rate(right, pairs).c_str());
    if (known > 0) std::printf("  its interval holds         %s\n", Rate(covered, known).c_str());
  }
  if (one.anew) std::printf("  both stations are named    %s\n", Rate(moved, pairs).c_str());
  std::fflush(stdout);
}

}  // namespace
}  // namespace sagitta

int main(int argc, char** argv) {
  const int pairs = argc > 1 ? std::atoi(argv[1]) : 200;
  const std::uint64_t first = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  if (pairs < 1) return 2;
  const std::string only = argc > 3 ? argv[3] : "";
  for (const sagitta::Case& one : sagitta::Cases()) {
    if (one.words.rfind(only, 0) == 0) sagitta::Run(one, pairs, first);
  }
}

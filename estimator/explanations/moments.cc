#include "estimator/explanations/moments.h"

#include <algorithm>
#include <limits>
#include <map>
#include <set>

#include "estimator/explanations/evidence_columns.h"
#include "estimator/explanations/scan.h"
#include "estimator/random_effects/sweep.h"
#include "models/effects/catalogue.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr size_t kChangePoints = 30;    // at least, and less than twice as many, where the visits allow
constexpr double kWorthRefining = 3.0;  // log evidence over nothing: 20 to 1
constexpr size_t kMostAround = 20;      // on either side, in one round
constexpr size_t kMostCentres = 4;      // of one effect: a single visit on the wrong side may cost more than three

// Times at which a fitted shot was measured, ascending.
std::vector<double> FittedTimes(const CalibrationProblem& problem) {
  std::set<double> times;
  for (size_t s = 0; s < problem.shot_inputs().size(); ++s) {
    const bool held_out = problem.data().configurations[problem.data().shots[s].configuration].is_validation;
    if (problem.shot_inputs()[s].conditions.has_time && !held_out)
      times.insert(problem.shot_inputs()[s].conditions.time);
  }
  return {times.begin(), times.end()};
}

size_t StrideOf(const std::vector<double>& times) { return std::max<size_t>(1, times.size() / kChangePoints); }

// Before the i-th time, as files that are read back have it: an effect's settings are a part of its name.
std::string MomentBefore(const std::vector<double>& times, size_t i) {
  return FormatNumber(0.5 * (times[i - 1] + times[i]));  // as a robot file has it: settings are part of names
}

// Of each effect on each target, the others of its settings alike: the moments that alone explain most.
std::vector<Candidate> BestMoments(const CalibrationProblem& problem, const ParameterSet& parameters,
                                   const std::vector<Candidate>& candidates) {
  EvidenceColumns columns(problem, parameters, candidates);
  std::set<std::vector<int>> own;
  for (size_t c = 0; c < candidates.size(); ++c) own.insert(columns.ColumnsOf(static_cast<int>(c)));
  const GivenBelieved given_believed = columns.ProjectAll(StatedScatter(problem), own);
  const ResidualLikelihood known_sigma(given_believed.normal.dof, std::numeric_limits<double>::infinity(), 0.0);
  std::map<std::string, Scan<Candidate>> moments;
  for (size_t c = 0; c < candidates.size(); ++c) {
    const ColumnGroup group{columns.ColumnsOf(static_cast<int>(c)), {}};
    if (group.columns.empty()) continue;
    const double log_evidence = AverageGain(known_sigma, GivenNothing(given_believed.normal, group));
    if (!(log_evidence > kWorthRefining)) continue;
    EffectSpec others = candidates[c].spec;
    others.settings.erase(MomentOf(problem.robot(), others));
    moments[others.Path()].Try(log_evidence, candidates[c]);
  }
  std::vector<Candidate> best;
  for (auto& [others, scan] : moments) {
    for (Candidate& candidate : scan.Best(kMostCentres)) best.push_back(std::move(candidate));
  }
  return best;
}

}  // namespace

std::vector<std::string> ChangePoints(const CalibrationProblem& problem) {
  const std::vector<double> times = FittedTimes(problem);
  std::vector<std::string> points;
  const size_t stride = StrideOf(times);
  for (size_t i = stride; i + 1 < times.size(); i += stride) points.push_back(MomentBefore(times, i));
  return points;
}

std::vector<Candidate> RefinedMoments(const CalibrationProblem& problem, const ParameterSet& parameters,
                                      const CandidateList& list) {
  const std::vector<double> times = FittedTimes(problem);
  std::vector<Candidate> tried, refined;
  for (const Candidate& candidate : list.candidates) {
    if (!MomentOf(problem.robot(), candidate.spec).empty()) tried.push_back(candidate);
  }
  for (size_t stride = StrideOf(times); stride > 1 && !tried.empty();) {
    const size_t finer = std::max<size_t>(1, stride / kMostAround);
    std::vector<Candidate> centres = BestMoments(problem, parameters, tried);
    std::set<std::string> known;  // moments of one effect may be near each other
    for (const Candidate& candidate : tried) known.insert(candidate.spec.Path());
    std::vector<Candidate> around;
    for (const Candidate& centre : centres) {
      const std::string setting = MomentOf(problem.robot(), centre.spec);
      const double moment = centre.spec.NumberSetting(setting, 0.0);
      const auto after = static_cast<size_t>(std::lower_bound(times.begin(), times.end(), moment) - times.begin());
      for (size_t off = finer; off < stride; off += finer) {
        for (const size_t i : {after - off, after + off}) {
          if (i < 1 || i >= times.size()) continue;  // after - off wraps around below 0
          Candidate near = centre;
          near.spec.settings[setting] = MomentBefore(times, i);
          if (known.insert(near.spec.Path()).second) around.push_back(std::move(near));
        }
      }
    }
    refined.insert(refined.end(), around.begin(), around.end());
    tried = std::move(centres);
    tried.insert(tried.end(), around.begin(), around.end());
    stride = finer;
  }
  return refined;
}

}  // namespace sagitta

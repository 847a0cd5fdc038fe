#include "estimator/diagnosis/alternatives.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "models/effects/catalogue.h"

namespace sagitta {
namespace {

constexpr double kOverlapListed = 0.8;

// The change points, widths and time constants of one effect are many candidates and one alternative.
std::string WithoutNumbers(const Robot& robot, EffectSpec spec) {
  const EffectDefinition* definition = FindEffect(robot, spec.effect);
  if (definition == nullptr) return spec.Path();
  for (const SettingDefinition& setting : definition->settings) {
    const bool is_number =
        setting.kind == SettingDefinition::Kind::kMoment || setting.kind == SettingDefinition::Kind::kNumber;
    if (is_number) spec.settings.erase(setting.name);
  }
  return spec.Path();
}

}  // namespace

std::vector<Alternative> FindAlternatives(const StepBench& bench, const ChosenStep& step,
                                          const Eigen::VectorXd& neutral_residual, double tie) {
  const CandidateBench& candidates = bench.whole().candidates;
  const WithoutStep without = bench.Without(step, neutral_residual, bench.whole());
  const ProjectedResidual& residual = without.residual;
  const Screening screening(candidates, residual, without.has_spring);
  const Eigen::VectorXd found = residual.Reproduce(without.own, residual.residual());
  const double n = std::log(static_cast<double>(residual.residual().size()));
  const double size = std::max(1e-300, found.squaredNorm());
  const double own_penalised =
      found.squaredNorm() - step.parameters * n - 2.0 * std::log(static_cast<double>(step.candidate.settings));
  std::vector<Alternative> alternatives;
  for (size_t i = 0; i < candidates.candidates().size(); ++i) {
    const EffectSpec& spec = candidates.candidates()[i].spec;
    const CandidateScore scored = screening.Of(static_cast<int>(i));
    if (scored.score.rank == 0 || spec.Path() == step.candidate.spec.Path()) continue;
    const bool ties = scored.score.penalised > own_penalised - tie;
    const double overlap = screening.Reproduced(scored, found) / size;
    const bool tied = ties && overlap >= kOverlapOfRivals;
    if (overlap >= kOverlapListed || tied) alternatives.push_back({spec, std::min(1.0, overlap), tied});
  }
  std::stable_sort(alternatives.begin(), alternatives.end(),
                   [](const auto& a, const auto& b) { return a.overlap > b.overlap; });
  const Robot& robot = bench.model().problem->robot;
  std::set<std::string> seen = {WithoutNumbers(robot, step.candidate.spec)};
  const auto is_neighbour = [&](const Alternative& entry) {
    const bool is_first = seen.insert(WithoutNumbers(robot, entry.spec)).second;
    return !entry.tied && !is_first;
  };
  alternatives.erase(std::remove_if(alternatives.begin(), alternatives.end(), is_neighbour), alternatives.end());
  return alternatives;
}

}  // namespace sagitta

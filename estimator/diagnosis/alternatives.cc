#include "estimator/diagnosis/alternatives.h"

#include <algorithm>

#include "estimator/diagnosis/compensator_search.h"

namespace sagitta {
namespace {

constexpr double kOverlapListed = 0.8;
constexpr double kOverlapOfRivals = 0.2;  // below, it explains something else
constexpr size_t kMostListed = 12;

}  // namespace

std::vector<Alternative> FindAlternatives(const DiagnosedModel& without, const ChosenStep& step,
                                          const std::vector<Candidate>& candidates, double tie) {
  const CalibrationProblem& problem = *without.problem;
  const ParameterSet& parameters = without.estimate.parameters;
  const ProjectedResidual residual(LinearizeEstimate(problem, parameters));
  const Eigen::MatrixXd deviations = JointDeviationColumns(problem, parameters);
  std::vector<EffectSpec> specs = SpecsOf(candidates);
  const EffectSpec& own = step.candidate.spec;
  specs.push_back(own);
  std::vector<CandidateColumns> columns = ColumnsOf(problem, parameters, specs);
  for (CandidateColumns& candidate : columns) DropUninformed(residual, &candidate);
  const auto shapes_of = [&](const EffectSpec& spec) {
    const int j = problem.robot.chain.FindJoint(spec.target);
    return ScanCompensator(problem, parameters, residual, deviations.col(j), spec.target);
  };
  if (own.effect == "gravity_compensator") {
    const auto shapes = shapes_of(own);
    if (shapes.empty()) return {};
    columns.back().columns = shapes[0].columns;
  }
  const Eigen::VectorXd found = residual.Reproduce(columns.back().columns, residual.residual());
  const double size = std::max(1e-300, found.squaredNorm());
  const double n = std::log(static_cast<double>(residual.residual().size()));
  const Score own_score = residual.Test(columns.back().columns, step.candidate.settings);
  const double own_penalised = own_score.reduction - step.parameters * n - 2.0 * std::log(step.candidate.settings);
  std::vector<Alternative> alternatives;
  const auto consider = [&](const EffectSpec& spec, double overlap, double penalised) {
    const bool tied = penalised > own_penalised - tie && overlap >= kOverlapOfRivals;
    if (overlap >= kOverlapListed || tied) alternatives.push_back({spec, std::min(1.0, overlap), tied});
  };
  for (size_t i = 0; i < candidates.size(); ++i) {
    if (specs[i].Path() == own.Path()) continue;
    if (specs[i].effect == "gravity_compensator") {
      double overlap = 0.0, penalised = -1e300;
      for (const CompensatorShape& shape : shapes_of(specs[i])) {
        const double here = residual.Reproduce(shape.columns, found).squaredNorm() / size;
        overlap = std::max(overlap, here);
        penalised = std::max(penalised, shape.reduction - 4.0 * n);
      }
      consider(specs[i], overlap, penalised);
      continue;
    }
    const Score score = residual.Test(columns[i].columns, candidates[i].settings);
    if (score.rank == 0) continue;
    const double overlap = residual.Reproduce(columns[i].columns, found).squaredNorm() / size;
    consider(specs[i], overlap, score.penalised);
  }
  std::stable_sort(alternatives.begin(), alternatives.end(),
                   [](const auto& a, const auto& b) { return a.overlap > b.overlap; });
  if (alternatives.size() > kMostListed) alternatives.resize(kMostListed);
  return alternatives;
}

}  // namespace sagitta

#include "estimator/diagnosis/confirmation.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "estimator/diagnosis/quick_refit.h"
#include "estimator/distributions.h"
#include "problems/split.h"

namespace sagitta {
namespace {

constexpr int kFolds = 5;

// Group of each configuration: groups are dealt in order of appearance, so that
// each part covers the whole time.
std::vector<int> PartOfConfiguration(const Measurements& data, int parts) {
  std::vector<int> part(data.configurations.size(), 0);
  int next = 0;
  for (const std::vector<int>& group : GroupsOfEqualJointValues(data)) {
    if (data.configurations[group.front()].is_validation) continue;
    for (const int c : group) part[c] = next;
    next = (next + 1) % parts;
  }
  return part;
}

int PartOf(const CalibrationProblem& problem, const std::vector<int>& parts, int observation) {
  return parts[problem.data.shots[problem.data.observations[observation].shot].configuration];
}

// The model on the calibration configurations of one part alone.
DiagnosedModel OnPart(const DiagnosedModel& model, const std::vector<int>& parts, int part) {
  CalibrationProblem problem = *model.problem;
  for (const int i : model.problem->CalibrationObservations()) {
    problem.data.observations[i].excluded = PartOf(problem, parts, i) != part;
  }
  problem.parameters = model.estimate.parameters;
  DiagnosedModel half;
  half.problem = std::make_shared<CalibrationProblem>(std::move(problem));
  half.estimate = QuickEstimate(RefitQuickly(*half.problem, half.problem->parameters));
  return half;
}

// Values and covariance of the step's parameters, without those that only a prior holds.
void ReadValues(const DiagnosedModel& with, const ChosenStep& step, HalfResult* half) {
  const Linearization here = LinearizeEstimate(*with.problem, with.estimate.parameters);
  Linearization complete = here;
  AppendPriors(with.estimate.parameters, &complete);
  const LinearSolution solution = SolveLinearization(complete);
  if (!solution.full_rank) return;
  const std::string prefix = ParametersOf(step.candidate.spec) + "/";
  const std::vector<std::string>& vague = step.candidate.vague;
  std::vector<int> own;
  for (int c = 0; c < complete.num_columns(); ++c) {
    const std::string& name = with.estimate.parameters.coordinates()[complete.columns[c]].name;
    if (name.rfind(prefix, 0) == 0 && std::find(vague.begin(), vague.end(), name) == vague.end()) own.push_back(c);
  }
  half->values.resize(own.size());
  for (size_t i = 0; i < own.size(); ++i) half->values[i] = with.estimate.parameters.Value(complete.columns[own[i]]);
  half->covariance = solution.covariance(own, own);
}

HalfResult NameAgain(const DiagnosedModel& half, const ChosenStep& step, const std::vector<Candidate>& candidates,
                     const SelectionOptions& options) {
  HalfResult result;
  double best = 0.0, own = -1e300;
  for (const ScreenedCandidate& entry : Screen(half, candidates, options.most_tests)) {
    if (entry.score.rank == 0) continue;
    const std::string path = entry.candidate.spec.Path();
    if (path == step.candidate.spec.Path()) own = entry.score.penalised;
    if (entry.score.penalised <= best) continue;
    best = entry.score.penalised;
    result.best = path;
  }
  result.telling = best > 0.0;
  result.named = own > 0.0 && own > best - options.tie;
  const DiagnosedModel with = Extend(half, {step.candidate}, options.joint);
  if (IsUsable(with.estimate.status)) ReadValues(with, step, &result);
  return result;
}

double CompatibleP(const HalfResult& a, const HalfResult& b) {
  if (a.values.size() == 0 || a.values.size() != b.values.size()) return 1.0;
  const Eigen::VectorXd difference = a.values - b.values;
  const Eigen::LLT<Eigen::MatrixXd> joint(a.covariance + b.covariance);
  if (joint.info() != Eigen::Success) return 1.0;
  return ChiSquareSurvival(difference.dot(joint.solve(difference)), static_cast<double>(difference.size()));
}

// Chi-square per row of configurations left out of the fit, from one
// linearization at the optimum: with N = J'J, g = J'r, and those of a fold f,
//   e_f = r_f - J_f (N - N_f)^-1 (g - g_f).
double CrossValidated(const DiagnosedModel& model, const std::vector<int>& parts) {
  Linearization here = LinearizeEstimate(*model.problem, model.estimate.parameters);
  const auto rows = static_cast<int>(3 * here.observations.size());
  AppendPriors(model.estimate.parameters, &here);
  const Eigen::VectorXd scale = here.jacobian.colwise().norm().cwiseMax(1e-300).cwiseInverse();
  const Eigen::MatrixXd jacobian = here.jacobian * scale.asDiagonal();
  const Eigen::MatrixXd information = jacobian.transpose() * jacobian;
  const Eigen::VectorXd gradient = jacobian.transpose() * here.residual;
  double sum = 0.0;
  for (int fold = 0; fold < kFolds; ++fold) {
    std::vector<int> own;
    for (int row = 0; row < rows; ++row) {
      if (PartOf(*model.problem, parts, here.observations[row / 3]) == fold) own.push_back(row);
    }
    const Eigen::MatrixXd left_out = jacobian(own, Eigen::all);
    const Eigen::VectorXd residual = here.residual(own);
    const Eigen::LDLT<Eigen::MatrixXd> rest(information - left_out.transpose() * left_out);
    sum += (residual - left_out * rest.solve(gradient - left_out.transpose() * residual)).squaredNorm();
  }
  return rows > 0 ? sum / rows : 0.0;
}

}  // namespace

Confirmation ConfirmStep(const DiagnosedModel& without, const DiagnosedModel& with, const ChosenStep& step,
                         const std::vector<Candidate>& candidates, const SelectionOptions& options) {
  Confirmation confirmation;
  const std::vector<int> halves = PartOfConfiguration(without.problem->data, 2);
  for (int half = 0; half < 2; ++half) {
    const DiagnosedModel model = OnPart(without, halves, half);
    confirmation.halves.push_back(IsUsable(model.estimate.status) ? NameAgain(model, step, candidates, options)
                                                                  : HalfResult());
  }
  confirmation.compatible_p = CompatibleP(confirmation.halves[0], confirmation.halves[1]);
  const std::vector<int> folds = PartOfConfiguration(without.problem->data, kFolds);
  confirmation.folds = kFolds;
  confirmation.cv_before = CrossValidated(without, folds);
  confirmation.cv_after = CrossValidated(with, folds);
  return confirmation;
}

}  // namespace sagitta

#include "estimator/diagnosis/step_bench.h"

#include <algorithm>
#include <numeric>

namespace sagitta {
namespace {

Linearization OnRows(const Linearization& all, const std::vector<int>& rows) {
  Linearization part;
  part.residual = all.residual(rows);
  part.jacobian = all.jacobian(rows, Eigen::all);
  part.columns = all.columns;
  return part;
}

std::vector<int> AllRows(const Linearization& linearization) {
  std::vector<int> rows(linearization.num_rows());
  std::iota(rows.begin(), rows.end(), 0);
  return rows;
}

}  // namespace

StepBench::StepBench(const DiagnosedModel& with, const std::vector<Candidate>& candidates)
    : with_(with),
      whole_{{},
             CandidateBench(*with.problem, with.estimate.parameters, candidates),
             LinearizeEstimate(*with.problem, with.estimate.parameters)} {
  whole_.rows = AllRows(whole_.believed);
}

BenchPart StepBench::PartOfRows(std::vector<int> rows) const {
  BenchPart part{{}, whole_.candidates.OnRows(rows), OnRows(whole_.believed, rows)};
  part.rows = std::move(rows);
  return part;
}

Eigen::VectorXd StepBench::Contribution(const ChosenStep& step) const {
  const bool spring = step.candidate.spec.effect == "gravity_compensator";
  Eigen::VectorXd contribution = Eigen::VectorXd::Zero(whole_.believed.num_rows());
  for (int c = 0; c < whole_.believed.num_columns(); ++c) {
    if (!IsParameterOf(step.candidate.spec, NameOf(c)) || (spring && NameOf(c) != "compensator/Kc")) continue;
    contribution += whole_.believed.jacobian.col(c) * with_.estimate.parameters.Value(whole_.believed.columns[c]);
  }
  return contribution;
}

WithoutStep StepBench::Without(const ChosenStep& step, const Eigen::VectorXd& neutral_residual,
                               const BenchPart& part) const {
  const bool is_spring = step.candidate.spec.effect == "gravity_compensator";
  return {ProjectedResidual(part.believed.jacobian(Eigen::all, OtherColumns(step)), neutral_residual(part.rows)),
          part.believed.jacobian(Eigen::all, OwnColumns(step)),
          with_.problem->robot.gravity_compensator.has_value() && !is_spring};
}

std::vector<int> StepBench::OwnColumns(const ChosenStep& step) const {
  const std::vector<std::string>& vague = step.candidate.vague;
  std::vector<int> own;
  for (int c = 0; c < whole_.believed.num_columns(); ++c) {
    const bool is_vague = std::find(vague.begin(), vague.end(), NameOf(c)) != vague.end();
    if (IsParameterOf(step.candidate.spec, NameOf(c)) && !is_vague) own.push_back(c);
  }
  return own;
}

std::vector<int> StepBench::OtherColumns(const ChosenStep& step) const {
  std::vector<int> others;
  for (int c = 0; c < whole_.believed.num_columns(); ++c) {
    if (!IsParameterOf(step.candidate.spec, NameOf(c))) others.push_back(c);
  }
  return others;
}

const std::string& StepBench::NameOf(int column) const {
  return with_.estimate.parameters.coordinates()[whole_.believed.columns[column]].name;
}

}  // namespace sagitta

// Where simulation and measurement disagree: excess chi-square by group.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>

#include "estimator/diagnosis/diagnose.h"
#include "estimator/diagnosis/model_rows.h"

namespace sagitta {
namespace {

constexpr int kTimeSlices = 6;

struct Group {
  double chi2 = 0.0;
  double expected = 0.0;
};

void AppendShares(const std::string& by, const std::map<std::string, Group>& groups, std::vector<WhereShare>* where) {
  double total = 0.0;
  for (const auto& [key, group] : groups) total += std::max(0.0, group.chi2 - group.expected);
  std::vector<WhereShare> shares;
  for (const auto& [key, group] : groups) {
    const double excess = std::max(0.0, group.chi2 - group.expected);
    if (excess > 0.0 && total > 0.0) shares.push_back({by, key, excess / total});
  }
  std::stable_sort(shares.begin(), shares.end(), [](const auto& a, const auto& b) { return a.share > b.share; });
  if (shares.size() > 10) shares.resize(10);
  where->insert(where->end(), shares.begin(), shares.end());
}

// The residual mapped into joint space: per visit, what a deviation of one joint
// alone would explain, (l' r)^2 / l' l, chi-square of one where nothing is wrong.
std::map<std::string, Group> ByJoint(const DiagnosedModel& model, const Linearization& here) {
  const CalibrationProblem& problem = *model.problem;
  const Eigen::MatrixXd deviations = JointDeviationColumns(problem, model.estimate.parameters);
  std::map<std::string, Group> groups;
  for (const Joint& joint : problem.robot().chain.joints) {
    const Eigen::VectorXd l = deviations.col(problem.robot().chain.FindJoint(joint.name));
    std::map<int, std::pair<double, double>> sums;
    for (size_t k = 0; k < here.observations.size(); ++k) {
      auto& sum = sums[problem.latent.visit_of_shot[problem.data().observations[here.observations[k]].shot]];
      sum.first += l.segment<3>(3 * k).dot(here.residual.segment<3>(3 * k));
      sum.second += l.segment<3>(3 * k).squaredNorm();
    }
    Group& group = groups[joint.name];
    for (const auto& [visit, sum] : sums) {
      if (sum.second <= 0.0) continue;
      group.chi2 += sum.first * sum.first / sum.second;
      group.expected += 1.0;
    }
  }
  return groups;
}

// First and last, s; both 0 where no shot states one.
Interval TimesOf(const CalibrationProblem& problem) {
  std::vector<double> times;
  for (const ShotInput& shot : problem.shot_inputs()) {
    if (shot.conditions.has_time) times.push_back(shot.conditions.time);
  }
  if (times.empty()) return {0.0, 0.0};
  const auto [first, last] = std::minmax_element(times.begin(), times.end());
  return {*first, *last};
}

// What each row has of chi-square, r'C^-1 r = sum of r_i (C^-1 r)_i: whatever the order of the rows that share a
// visit's deviations, C = I + L L'. A row that others explain may have less than none.
// here: whitened by the root of C, w = root^-1 r.
Eigen::VectorXd ShareOfRows(const CalibrationProblem& problem, const Linearization& here) {
  Eigen::VectorXd shares = here.residual.cwiseAbs2();
  if (here.latent.cols() == 0) return shares;
  for (const auto& [visit, rows] : RowsByVisit(problem, here.observations)) {
    const Eigen::MatrixXd l = here.latent(rows, Eigen::all);
    const Eigen::MatrixXd c = Eigen::MatrixXd::Identity(l.rows(), l.rows()) + l * l.transpose();
    const Eigen::LLT<Eigen::MatrixXd> root(c);
    const Eigen::VectorXd whitened = here.residual(rows);
    const Eigen::VectorXd residual = root.matrixL() * whitened;
    shares(rows) = residual.cwiseProduct(root.matrixU().solve(whitened));
  }
  return shares;
}

}  // namespace

std::vector<WhereShare> FindWhere(const DiagnosedModel& model) {
  const CalibrationProblem& problem = *model.problem;
  const Linearization here = LinearizeEstimate(problem, model.estimate.parameters);
  const Eigen::VectorXd shares = ShareOfRows(problem, here);
  const double per_row = model.estimate.dof / std::max(1.0, static_cast<double>(model.estimate.rows));
  std::map<std::string, std::map<std::string, Group>> by;
  const Interval times = TimesOf(problem);
  const double slice_length = (times.high - times.low) / kTimeSlices;
  for (size_t k = 0; k < here.observations.size(); ++k) {
    const Observation& observation = problem.data().observations[here.observations[k]];
    const Shot& shot = problem.data().shots[observation.shot];
    const auto add = [&](const std::string& family, const std::string& key, double chi2, double rows) {
      Group& group = by[family][key];
      group.chi2 += chi2;
      group.expected += rows * per_row;
    };
    const Eigen::Vector3d of_axis = shares.segment<3>(3 * static_cast<long>(k));
    const double chi2 = of_axis.sum();
    add("config", problem.data().configurations[shot.configuration].id, chi2, 3.0);
    add("marker", problem.data().markers[observation.marker], chi2, 3.0);
    add("load", shot.load, chi2, 3.0);
    add("station", problem.data().stations[shot.station], chi2, 3.0);
    for (int axis = 0; axis < 3; ++axis) {
      add("axis", (observation.is_point() ? "" : "r") + std::string(1, "xyz"[axis]), of_axis[axis], 1.0);
    }
    const ShotConditions& conditions = problem.shot_inputs()[observation.shot].conditions;
    if (!conditions.has_time || !(slice_length > 0.0)) continue;
    const int slice = std::min(kTimeSlices - 1, static_cast<int>((conditions.time - times.low) / slice_length));
    add("time", std::to_string(std::lround(times.low + slice * slice_length)) + " s", chi2, 3.0);
  }
  by["joint"] = ByJoint(model, here);
  std::vector<WhereShare> where;
  for (const auto& [family, groups] : by) AppendShares(family, groups, &where);
  return where;
}

}  // namespace sagitta

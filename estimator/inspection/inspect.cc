#include "estimator/inspection/inspect.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/calibration/load_remedy.h"
#include "estimator/calibration/marker_remedy.h"
#include "estimator/estimate/parameter_table.h"
#include "estimator/inspection/linear_state.h"
#include "estimator/inspection/load_direction.h"
#include "estimator/least_squares/ceres_problem.h"
#include "estimator/least_squares/held_influence.h"
#include "estimator/report/inspection_words.h"
#include "problems/interruption.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr double kClose = 0.95;       // |correlation| that makes a group: each alone is known 3 times worse (1 / 0.31)
constexpr double kUnchecked = 0.999;  // leverage of a configuration that nothing else checks: a thousandth of it shows

// With the experiments that would determine compliances and spring, as an estimate proposes them.
Identifiability IdentifiabilityOf(const LinearState& state, const LinearSolution& solution) {
  Estimate expected;
  expected.parameters = state.parameters;
  for (const int c : state.lost.columns) expected.parameters.coordinate(state.all.columns[c]).held = true;
  expected.estimated = state.estimated.columns;
  expected.identifiability = {state.estimated.num_columns(), solution.condition, state.lost.directions,
                              FindWeak(state.estimated, state.parameters, state.scale)};
  if (!solution.full_rank) return expected.identifiability;
  expected.covariance = state.scale * state.scale * solution.covariance;
  expected.model_covariance = expected.covariance;
  expected.sigma.stated = state.problem.sigma_is_stated();
  expected.sigma.a_posteriori = expected.sigma.stated ? state.scale : 1.0;
  expected.sigma.scaled = expected.sigma.a_posteriori > 1.0;
  expected.sigma.estimated = expected.sigma.stated ? 0.0 : kUnstatedSigma * state.scale;
  AddLoadRemedies(state.problem, &expected);
  AddMarkerRemedies(state.problem, &expected);
  return expected.identifiability;
}

// What may be lost moves of the rest, G S G' (held_influence.h).
Eigen::VectorXd AddedByLost(const LinearState& state) {
  const std::vector<int>& lost = state.lost.columns;
  if (lost.empty()) return Eigen::VectorXd::Zero(state.estimated.num_columns());
  std::vector<int> places(state.all.columns.size());  // what is estimated, then what is lost
  std::iota(places.begin(), places.end(), 0);
  std::stable_partition(places.begin(), places.end(),
                        [&](int c) { return std::count(lost.begin(), lost.end(), c) == 0; });
  Linearization both = state.all;
  both.jacobian = state.all.jacobian(Eigen::all, places);
  for (size_t k = 0; k < places.size(); ++k) both.columns[k] = state.all.columns[places[k]];
  return AddedCovariance(FindHeldInfluence(both, state.parameters, state.estimated.num_columns(), state.scale))
      .diagonal();
}

void FillInspectedParameters(const LinearState& state, Inspection* inspection) {
  const LinearSolution solution = SolveLinearization(state.estimated);
  inspection->identifiability = IdentifiabilityOf(state, solution);
  const Eigen::VectorXd added = AddedByLost(state);
  for (const int i : state.all.columns) {
    const Coordinate& coordinate = state.parameters.coordinates()[i];
    ParameterEstimate row;
    row.name = coordinate.name;
    row.quantity = coordinate.quantity;
    row.value = row.nominal = state.parameters.Value(i);
    row.free = true;
    const auto column = std::find(state.estimated.columns.begin(), state.estimated.columns.end(), i);
    row.identifiable = column != state.estimated.columns.end();
    if (row.identifiable && solution.full_rank) {
      const int c = static_cast<int>(column - state.estimated.columns.begin());
      row.sigma = state.scale * std::sqrt(solution.covariance(c, c));
      row.unconditional_sigma = std::sqrt(row.sigma * row.sigma + added[c]);
      row.conditional = IsWidened(row.sigma, added[c]);
      const double limit = TraitsOf(row.quantity).weak_limit;
      row.weak = limit > 0.0 && row.sigma > limit;
    }
    inspection->parameters.push_back(row);
  }
}

// Connected by |correlation| above kClose.
std::vector<CorrelationGroup> FindGroups(const LinearState& state) {
  const LinearSolution solution = SolveLinearization(state.estimated);
  std::vector<CorrelationGroup> groups;
  if (!solution.full_rank) return groups;
  const int n = state.estimated.num_columns();
  const Eigen::VectorXd inverse = solution.covariance.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd correlation = inverse.asDiagonal() * solution.covariance * inverse.asDiagonal();
  std::vector<int> group(n);
  std::iota(group.begin(), group.end(), 0);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < i; ++j) {
      if (std::abs(correlation(i, j)) <= kClose || group[i] == group[j]) continue;
      const int from = std::max(group[i], group[j]), to = std::min(group[i], group[j]);
      std::replace(group.begin(), group.end(), from, to);
    }
  }
  for (int g = 0; g < n; ++g) {
    CorrelationGroup found;
    for (int i = 0; i < n; ++i) {
      if (group[i] != g) continue;
      found.names.push_back(state.parameters.coordinates()[state.estimated.columns[i]].name);
      for (int j = 0; j < i; ++j) {
        if (group[j] == g) found.largest = std::max(found.largest, std::abs(correlation(i, j)));
      }
    }
    if (found.names.size() > 1) groups.push_back(found);
  }
  std::stable_sort(groups.begin(), groups.end(), [](const auto& a, const auto& b) { return a.largest > b.largest; });
  return groups;
}

std::vector<ConfigurationLeverage> FindLeverage(const LinearState& state) {
  std::vector<ConfigurationLeverage> leverage;
  const int n = state.estimated.num_columns();
  if (n == 0) return leverage;
  const Eigen::VectorXd scale = state.estimated.jacobian.colwise().norm().cwiseMax(1e-300);
  const Eigen::MatrixXd scaled = state.estimated.jacobian * scale.cwiseInverse().asDiagonal();
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(scaled);
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(state.estimated.num_rows(), n);
  const Eigen::MatrixXd q = qr.householderQ() * identity;
  std::map<int, std::vector<int>> rows;
  for (size_t k = 0; k < state.estimated.observations.size(); ++k) {
    const Observation& observation = state.problem.data().observations[state.estimated.observations[k]];
    for (int axis = 0; axis < 3; ++axis)
      rows[state.problem.data().shots[observation.shot].configuration].push_back(static_cast<int>(3 * k) + axis);
  }
  for (const auto& [configuration, own] : rows) {
    CheckInterruption();
    const Eigen::MatrixXd block = q(own, Eigen::all);
    const Eigen::MatrixXd smaller =
        block.rows() < n ? Eigen::MatrixXd(block * block.transpose()) : Eigen::MatrixXd(block.transpose() * block);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(smaller, Eigen::EigenvaluesOnly);
    leverage.push_back({configuration, block.squaredNorm() / block.rows(), eigen.eigenvalues().tail(1)[0]});
  }
  std::stable_sort(leverage.begin(), leverage.end(), [](const auto& a, const auto& b) { return a.mean > b.mean; });
  return leverage;
}

void AddDirectionFindings(const Inspection& inspection, std::vector<Finding>* findings) {
  for (const Direction& direction : inspection.identifiability.unidentifiable)
    findings->push_back({Severity::kWarning, "unidentifiable", direction.words, direction.remedy, {}});
  for (const Direction& direction : inspection.identifiability.weak)
    findings->push_back({Severity::kNote, "weak", direction.words, direction.remedy, {}});
}

void AddLeverageFinding(const CalibrationProblem& problem, const Inspection& inspection,
                        std::vector<Finding>* findings) {
  const Measurements& data = problem.data();
  std::vector<int> first(data.configurations.size(), -1);  // observation
  for (size_t i = data.observations.size(); i-- > 0;)
    first[data.shots[data.observations[i].shot].configuration] = static_cast<int>(i);
  std::vector<std::string> rows, names;
  for (const ConfigurationLeverage& entry : inspection.leverage) {
    if (entry.most < kUnchecked) continue;
    if (rows.size() < 6) names.push_back(data.configurations[entry.configuration].id);
    rows.push_back(data.SourceOf(data.observations[first[entry.configuration]]));
  }
  if (rows.empty()) return;
  findings->push_back(Found(Severity::kWarning, "alone",
                            RestsOnOneConfiguration(Joined(names) + (rows.size() > 6 ? ", …" : "")), rows));
}

// What `calibrate` calls before: base poses and markers of the nominal robot fitted to the calibration rows.
ResidualSize AlignedSize(const CalibrationProblem& problem) {
  ParameterSet nominal = problem.parameters;
  AlignNominal(problem, &nominal);
  const std::vector<int> rows = problem.CalibrationObservations();
  return MeasureReadings(problem.data(), rows, PredictPoints(problem, nominal, rows));
}

// Lengths and angles apart. squares: of the three numbers of each of the linearization's observations.
template <typename Squares>
Inspection::RmsOfReadings RmsOf(const CalibrationProblem& problem, const std::vector<int>& observations,
                                const Squares& squares) {
  double sums[2] = {0.0, 0.0};
  int counts[2] = {0, 0};
  for (size_t k = 0; k < observations.size(); ++k) {
    const int kind = problem.data().observations[observations[k]].is_point() ? 0 : 1;
    sums[kind] += squares(k);
    counts[kind] += 3;
  }
  return {std::sqrt(sums[0] / std::max(1, counts[0])), std::sqrt(sums[1] / std::max(1, counts[1]))};
}

// What a linear fit leaves, unweighted.
Inspection::RmsOfReadings LinearRms(const LinearState& state, const NoiseRoots& noise) {
  Eigen::VectorXd residual = state.estimated.residual;
  const LinearSolution solution = SolveLinearization(state.estimated);
  if (solution.step.size() == state.estimated.num_columns()) residual += state.estimated.jacobian * solution.step;
  return RmsOf(state.problem, state.estimated.observations,
               [&](size_t k) { return (noise[k] * residual.segment<3>(3 * k)).squaredNorm(); });
}

void FillNoise(const LinearState& state, Inspection* inspection) {
  const ResidualSelection rows = FittedResiduals(state.problem, kUnstatedSigma);
  const Inspection::RmsOfReadings stated =
      RmsOf(state.problem, rows.observations, [&](size_t k) { return rows.noise[k].squaredNorm(); });
  inspection->sigma_is_stated = state.problem.sigma_is_stated();
  for (size_t k = 0; k < rows.noise.size() && inspection->sigma_is_stated; ++k) {
    const bool is_point = state.problem.data().observations[rows.observations[k]].is_point();
    const double equal = is_point ? stated.point : stated.rotation;
    const Matrix3<double> covariance = rows.noise[k] * rows.noise[k].transpose();
    inspection->sigma_differs |= !covariance.isApprox(equal * equal * Matrix3<double>::Identity(), 1e-6);
  }
  if (inspection->sigma_is_stated) inspection->stated = stated;
  inspection->scale = state.scale;
  if (state.all.valid) inspection->linear = LinearRms(state, rows.noise);
}

}  // namespace

int Inspection::Count(Severity severity) const {
  return static_cast<int>(std::count_if(findings.begin(), findings.end(),
                                        [&](const Finding& finding) { return finding.severity == severity; }));
}

Inspection Inspect(const CalibrationProblem& problem, const std::function<void(const std::string&)>& progress) {
  const auto say = [&](const std::string& what) {
    if (progress) progress(what);
  };
  Inspection inspection;
  inspection.findings = LintData(problem);
  inspection.joints = MeasuredRangesOf(problem);
  inspection.orientation = OrientationVarietyOf(problem);
  say(ReadingOtherwise());
  inspection.reading = LintReadingsOfGoodRows(problem);
  inspection.findings.insert(inspection.findings.end(), inspection.reading.findings.begin(),
                             inspection.reading.findings.end());
  say(LinearizingAtNominal());
  // Rows that weights moved another way than they are said to pull are good rows.
  // Rows that were read in another way than the others are named: what the others can determine is shown.
  CalibrationProblem good = problem;
  for (const int i : inspection.reading.wrong_rows) good.mutable_data()->ExcludeRow(i);
  const bool is_misread = inspection.reading.is_suspicious && inspection.reading.wrong_rows.empty();
  const bool is_misfit = is_misread || FindLoadDirection(problem).has_value();
  const LinearState state = Align(good, is_misfit, &inspection.findings);
  inspection.aligned = AlignedSize(problem);
  inspection.torques = CompareTorques(state.problem, state.parameters);
  if (!inspection.torques.joints.empty()) {
    std::string words = inspection.torques.words;
    if (!words.empty() && words.back() == '.') words.pop_back();  // findings end without
    inspection.findings.push_back({Severity::kNote, "torques", words, "", {}});
  }
  FillNoise(state, &inspection);
  inspection.unknowns = state.all.num_columns();
  if (!state.all.valid) {
    inspection.findings.push_back(
        Found(Severity::kSerious, "folded", ArmFolds(FoldedShot(problem, problem.parameters))));
  } else {
    FillInspectedParameters(state, &inspection);
    inspection.groups = FindGroups(state);
    inspection.leverage = FindLeverage(state);
    AddDirectionFindings(inspection, &inspection.findings);
    AddLeverageFinding(problem, inspection, &inspection.findings);
  }
  std::stable_sort(inspection.findings.begin(), inspection.findings.end(),
                   [](const Finding& a, const Finding& b) { return a.severity < b.severity; });
  return inspection;
}

}  // namespace sagitta

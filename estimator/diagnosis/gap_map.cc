#include "estimator/diagnosis/gap_map.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "estimator/diagnosis/diagnosed_model.h"
#include "estimator/explanations/compensator_shapes.h"
#include "estimator/least_squares/linearization.h"
#include "models/constants.h"
#include "models/effects/catalogue.h"

namespace sagitta {
namespace {

constexpr int kTimeSlices = 6;  // of a day an hour and more each
// Of l' l: too small a part to divide by, which would draw noise.
constexpr double kHardlySeen = 1e-3;  // of the shot (visit) that sees it best: 30 times its standard deviation
constexpr double kUnseen = 1e-12;     // of the joint seen best: rounding
constexpr size_t kMostShares = 10;    // listed: of excesses in descending order the next is an eleventh at most

// A model's fitted rows, whitened, for its estimated coordinates; and how a deviation of each joint on its encoder side
// moves them, per urad (um), a column per joint.
struct ModelRows {
  Linearization here;
  Eigen::MatrixXd deviations;
};

// Order 0: the cosine column of a wave is that of a constant joint deviation.
ModelRows RowsOf(const DiagnosedModel& model, LatentTreatment treatment, double unstated_sigma = kFallbackSigma) {
  const auto linearize = [=](const CalibrationProblem& problem, const ParameterSet& parameters,
                             const std::vector<int>& columns) {
    const std::vector<int> observations = problem.CalibrationObservations();
    return Linearize(problem, parameters, observations, columns,
                     ObservationNoise(problem, observations, unstated_sigma), treatment);
  };
  const ParameterSet& parameters = model.estimate.parameters;
  std::vector<EffectSpec> specs;
  for (const Joint& joint : model.problem->robot().chain.joints) {
    specs.push_back({LearntWaveDeviation().name, joint.name, {{"driver", joint.name}, {"order", "0"}}, {}});
  }
  CalibrationProblem extended = model.problem->WithEffects(specs);
  extended.parameters.CopyByName(parameters);
  std::vector<int> cosines;
  for (const EffectSpec& spec : specs) cosines.push_back(extended.parameters.FindCoordinate(spec.Path() + "/cos"));
  return {linearize(*model.problem, parameters, parameters.EstimatedCoordinates()),
          kMicro * linearize(extended, extended.parameters, cosines).jacobian};
}

// Of one joint (or effect), per group of shots: how a deviation l moves the rows, and what they have of it.
struct AlongJoint {
  Eigen::VectorXd information;  // l' l
  Eigen::VectorXd gradient;     // l' y
};

// group: of each shot.
AlongJoint Along(const CalibrationProblem& problem, const Linearization& here, const std::vector<int>& group,
                 const Eigen::VectorXd& l, const Eigen::VectorXd& y) {
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(1 + *std::max_element(group.begin(), group.end()));
  AlongJoint along{none, none};
  for (size_t k = 0; k < here.observations.size(); ++k) {
    const int g = group[problem.data().observations[here.observations[k]].shot];
    along.information[g] += l.segment<3>(3 * k).squaredNorm();
    along.gradient[g] += l.segment<3>(3 * k).dot(y.segment<3>(3 * k));
  }
  return along;
}

// Of every joint, of measured - predicted.
std::vector<AlongJoint> AlongJoints(const CalibrationProblem& problem, const ModelRows& model,
                                    const std::vector<int>& group) {
  std::vector<AlongJoint> along;
  for (const auto& l : model.deviations.colwise()) {
    along.push_back(Along(problem, model.here, group, l, -model.here.residual));
  }
  return along;
}

double BestInformation(const std::vector<AlongJoint>& along) {
  double best = 0.0;
  for (const AlongJoint& joint : along) best = std::max(best, joint.information.maxCoeff());
  return best;
}

std::vector<Driver> DriversOf(const CalibrationProblem& problem, int joint, const Eigen::MatrixXd& torques) {
  std::vector<Driver> drivers = {AngleOf(problem, joint), TorqueOf(problem, joint, torques), ApproachOf(problem, joint),
                                 TimeOf(problem)};
  const auto is_constant = [](const Driver& driver) { return !driver.Varies(); };
  drivers.erase(std::remove_if(drivers.begin(), drivers.end(), is_constant), drivers.end());
  return drivers;
}

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
  if (shares.size() > kMostShares) shares.resize(kMostShares);
  where->insert(where->end(), shares.begin(), shares.end());
}

// The residual mapped into joint space: per visit, what a deviation of one joint alone would explain, (l' r)^2 / l' l,
// chi-square of one where nothing is wrong.
std::map<std::string, Group> ByJoint(const CalibrationProblem& problem, const ModelRows& rows) {
  const std::vector<AlongJoint> along = AlongJoints(problem, rows, problem.latent.visit_of_shot);
  std::map<std::string, Group> groups;
  for (size_t j = 0; j < along.size(); ++j) {
    Group& group = groups[problem.robot().chain.joints[j].name];
    for (long visit = 0; visit < along[j].information.size(); ++visit) {
      if (along[j].information[visit] <= 0.0) continue;
      group.chi2 += along[j].gradient[visit] * along[j].gradient[visit] / along[j].information[visit];
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

// The effect's contribution to the whitened rows: its columns times its values (neutral: 0). The torque of a
// compensator is proportional to its rate; of one that the robot states in another way, what differs counts.
Eigen::VectorXd Contribution(const DiagnosedModel& with, const EffectSpec& spec, const Linearization& here) {
  const bool spring = IsNewSpring(spec), is_correction = IsGravityCompensator(spec) && !spring;
  Eigen::VectorXd contribution = Eigen::VectorXd::Zero(here.num_rows());
  for (int c = 0; c < here.num_columns(); ++c) {
    const Coordinate& coordinate = with.estimate.parameters.coordinates()[here.columns[c]];
    if (!IsParameterOf(spec, coordinate.name)) continue;
    if (spring && coordinate.compensator_part != CompensatorPart::kKc) continue;
    const double neutral = is_correction ? coordinate.prior_value : 0.0;
    if (is_correction && !coordinate.has_prior()) continue;  // believed
    contribution += here.jacobian.col(c) * (with.estimate.parameters.Value(here.columns[c]) - neutral);
  }
  return contribution;
}

EffectView ViewEffect(const DiagnosedModel& with, const ModelRows& of_model, const EffectSpec& spec) {
  const CalibrationProblem& problem = *with.problem;
  const Linearization& here = of_model.here;
  const Eigen::VectorXd contribution = Contribution(with, spec, here);
  const Driver driver = DriverOf(problem, spec);
  EffectView view{driver.name, driver.unit, "share of what was found", "", {}, {}, {}};
  Eigen::VectorXd along = contribution;
  const int joint = problem.robot().chain.FindJoint(spec.target);
  if (joint >= 0) {
    const bool turns = IsRevolute(problem, joint);
    along = of_model.deviations.col(joint);
    view.quantity = "deviation of " + spec.target;
    view.unit = turns ? "urad" : "um";
  }
  const std::vector<int>& visit = problem.latent.visit_of_shot;
  const AlongJoint says = Along(problem, here, visit, along, contribution);
  const AlongJoint left = Along(problem, here, visit, along, -here.residual);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(says.information.size());
  for (const int i : here.observations) {
    const int s = problem.data().observations[i].shot;
    x[visit[s]] = driver.of_shot[s];
  }
  const double least = kHardlySeen * says.information.maxCoeff();
  for (long v = 0; v < x.size(); ++v) {
    const double information = says.information[v];
    if (!(information > 0.0) || information < least) continue;  // hardly seen in this visit
    view.x.push_back(x[v]);
    view.measured.push_back((says.gradient[v] + left.gradient[v]) / information);
    view.simulated.push_back(says.gradient[v] / information);
  }
  return view;
}

}  // namespace

std::vector<WhereShare> FindWhere(const DiagnosedModel& model, double unstated_sigma) {
  const CalibrationProblem& problem = *model.problem;
  const ModelRows rows = RowsOf(model, LatentTreatment::kMarginalise, unstated_sigma);
  const Linearization& here = rows.here;
  const Eigen::VectorXd shares = ShareOfRows(problem, here);
  const double per_row = model.estimate.dof / std::max(1.0, static_cast<double>(model.estimate.rows));
  std::map<std::string, std::map<std::string, Group>> by;
  const Interval times = TimesOf(problem);
  const double slice_length = (times.high - times.low) / kTimeSlices;
  for (size_t k = 0; k < here.observations.size(); ++k) {
    const Observation& observation = problem.data().observations[here.observations[k]];
    const Shot& shot = problem.data().shots[observation.shot];
    const auto add = [&](const std::string& family, const std::string& key, double chi2, double count) {
      Group& group = by[family][key];
      group.chi2 += chi2;
      group.expected += count * per_row;
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
  by["joint"] = ByJoint(problem, rows);
  std::vector<WhereShare> where;
  for (const auto& [family, groups] : by) AppendShares(family, groups, &where);
  return where;
}

std::vector<JointGap> MapGap(const DiagnosedModel& baseline, const DiagnosedModel& final) {
  const CalibrationProblem& problem = *baseline.problem;
  std::vector<int> shots(problem.data().shots.size());
  std::iota(shots.begin(), shots.end(), 0);
  // The rows as they are: what the joints of one visit share is part of what is looked for.
  const LatentTreatment as_they_are = LatentTreatment::kIgnore;
  const std::vector<AlongJoint> before = AlongJoints(problem, RowsOf(baseline, as_they_are), shots),
                                after = AlongJoints(*final.problem, RowsOf(final, as_they_are), shots);
  const Eigen::MatrixXd torques = JointTorques(problem, baseline.estimate.parameters);
  const double rounding = kUnseen * BestInformation(before);
  std::vector<JointGap> gaps;
  for (size_t j = 0; j < before.size(); ++j) {
    const Joint& joint = problem.robot().chain.joints[j];
    JointGap gap{joint.name, joint.type == JointType::kRevolute ? "urad" : "um", {}, {}, {}, {}};
    const double least = std::max(rounding, kHardlySeen * before[j].information.maxCoeff());
    for (long s = 0; s < before[j].information.size(); ++s) {
      const double information = before[j].information[s], later = after[j].information[s];
      if (!(information > least) || !(later > 0.0)) continue;
      gap.shots.push_back(static_cast<int>(s));
      gap.before.push_back(before[j].gradient[s] / information);
      gap.after.push_back(after[j].gradient[s] / later);
    }
    if (gap.shots.empty()) continue;
    gap.over = DriversOf(problem, static_cast<int>(j), torques);
    gaps.push_back(std::move(gap));
  }
  return gaps;
}

std::vector<EffectView> ViewEffects(const DiagnosedModel& with, const std::vector<EffectSpec>& specs) {
  std::vector<EffectView> views;
  if (specs.empty()) return views;
  const ModelRows rows = RowsOf(with, LatentTreatment::kMarginalise);
  for (const EffectSpec& spec : specs) views.push_back(ViewEffect(with, rows, spec));
  return views;
}

}  // namespace sagitta

#include "estimator/calibration/load_remedy.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>

#include "estimator/estimate/parameter_table.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/report/calibration_words.h"
#include "models/constants.h"
#include "problems/loads.h"

namespace sagitta {
namespace {

constexpr double kMostPull = 500.0;         // N, of an arm that carries more (paper 003 pulls with as much)
constexpr double kOffAxis = 0.1;            // m, a hook next to the flange: with kMostPull a moment of 50 N m
constexpr int kPulls = 3;                   // nine coordinates of one marker to the compliances of six joints
constexpr int kHeadings = 8;                // the nearest is 22 degrees off at most, and pulls by 92 % of it
constexpr size_t kMostConfigurations = 60;  // tried: all of a usual campaign

// Where and how the data's loads act: the first loaded shot's own wrench.
AppliedWrench LoadAtHand(const CalibrationProblem& problem) {
  for (size_t s = 0; s < problem.data().shots.size(); ++s) {
    if (IsLoaded(problem.data().shots[s])) return problem.shot_inputs()[s].wrenches.back();
  }
  AppliedWrench at_flange;
  at_flange.frame = problem.robot().chain.FlangeFrame();
  return at_flange;
}

// N: no more than the heaviest load of the data weighs, which the arm is known to carry.
double PullAtHand(const CalibrationProblem& problem) {
  double heaviest = 0.0;
  for (size_t s = 0; s < problem.data().shots.size(); ++s) {
    if (!IsLoaded(problem.data().shots[s])) continue;
    heaviest = std::max(heaviest, problem.shot_inputs()[s].wrenches.back().force.norm());
  }
  return heaviest > 0.0 ? std::min(kMostPull, heaviest) : kMostPull;
}

// One shot of each configuration that is fitted, unloaded where there is one.
std::vector<int> ShotPerConfiguration(const CalibrationProblem& problem) {
  std::vector<int> shot_of(problem.data().configurations.size(), -1);
  for (size_t s = 0; s < problem.data().shots.size(); ++s) {
    const Shot& shot = problem.data().shots[s];
    int& chosen = shot_of[shot.configuration];
    if (problem.data().configurations[shot.configuration].is_validation) continue;
    if (chosen < 0 || (IsLoaded(problem.data().shots[chosen]) && !IsLoaded(shot))) chosen = static_cast<int>(s);
  }
  std::vector<int> shots;
  for (const int s : shot_of) {
    if (s >= 0) shots.push_back(s);
  }
  const size_t stride = (shots.size() + kMostConfigurations - 1) / kMostConfigurations;
  std::vector<int> thinned;
  for (size_t i = 0; i < shots.size(); i += stride) thinned.push_back(shots[i]);
  return thinned;
}

// What the data at hand say of the held coordinate.
struct Background {
  std::vector<int> columns;    // estimated, then the held one
  Eigen::MatrixXd covariance;  // C, of what is estimated, whitened units
  Eigen::VectorXd follow;      // w
  double information = 0.0;    // i0
};

Background MakeBackground(const CalibrationProblem& problem, const Estimate& estimate, int held) {
  Background background;
  background.columns = estimate.estimated;
  background.columns.push_back(held);
  const double scale = AppliedNoise(estimate.sigma);
  background.covariance = estimate.model_covariance / (scale * scale);
  const std::vector<int> rows = problem.CalibrationObservations();
  Linearization here = Linearize(problem, estimate.parameters, rows, background.columns,
                                 ObservationNoise(problem, rows, kFallbackSigma));
  AppendPriors(estimate.parameters, &here);
  const int n = static_cast<int>(estimate.estimated.size());
  const Eigen::VectorXd column = here.jacobian.col(n);
  // w = C J'J_k and i0 = |J_k - J w|^2: the part of column k that no estimated column can absorb.
  background.follow = background.covariance * (here.jacobian.leftCols(n).transpose() * column);
  background.information = std::max(0.0, (column - here.jacobian.leftCols(n) * background.follow).squaredNorm());
  return background;
}

struct LoadCandidate {
  int configuration;
  AppliedWrench wrench;
  Eigen::VectorXd held;       // b~
  Eigen::MatrixXd others;     // A
  Eigen::MatrixXd deviation;  // L
};

// Rows of `shot`'s markers with `wrench` in place of its load.
LoadCandidate MakeCandidate(const CalibrationProblem& problem, const Estimate& estimate, const Background& background,
                            int shot, const AppliedWrench& wrench, CalibrationProblem* scratch) {
  ShotInput& input = (*scratch->mutable_shot_inputs())[shot];
  const ShotInput original = problem.shot_inputs()[shot];
  input = original;
  if (IsLoaded(problem.data().shots[shot])) input.wrenches.pop_back();
  input.wrenches.push_back(wrench);
  const std::vector<int>& rows = problem.data().shots[shot].observations;
  const Linearization there = Linearize(*scratch, estimate.parameters, rows, background.columns,
                                        ObservationNoise(problem, rows, kFallbackSigma), LatentTreatment::kIgnore);
  input = original;
  LoadCandidate candidate{problem.data().shots[shot].configuration, wrench, {}, {}, {}};
  if (!there.valid) return candidate;  // folds the arm
  const int n = static_cast<int>(background.columns.size()) - 1;
  candidate.others = there.jacobian.leftCols(n);
  candidate.held = there.jacobian.col(n) - candidate.others * background.follow;
  candidate.deviation = there.latent;
  return candidate;
}

double Information(const std::vector<const LoadCandidate*>& chosen, const Background& background) {
  int rows = 0;
  for (const LoadCandidate* c : chosen) rows += static_cast<int>(c->held.size());
  Eigen::VectorXd held(rows);
  Eigen::MatrixXd others(rows, background.covariance.cols());
  Eigen::MatrixXd noise = Eigen::MatrixXd::Identity(rows, rows);
  int row = 0;
  for (const LoadCandidate* c : chosen) {
    const int size = static_cast<int>(c->held.size());
    held.segment(row, size) = c->held;
    others.middleRows(row, size) = c->others;
    noise.block(row, row, size, size) += c->deviation * c->deviation.transpose();
    row += size;
  }
  noise += others * background.covariance * others.transpose();
  // i0 + b~' (1 + A C A' + L L')^-1 b~ of the header, the rows of all pulls together.
  return background.information + held.dot(noise.llt().solve(held));
}

LoadPlan ChooseBest(const CalibrationProblem& problem, const Estimate& estimate, const Background& background,
                    const std::vector<LoadCandidate>& candidates, int count) {
  LoadPlan plan;
  plan.sigma = kInfinity;
  std::vector<const LoadCandidate*> chosen;
  for (int i = 0; i < count; ++i) {
    const LoadCandidate* best = nullptr;
    double most = 0.0;
    for (const LoadCandidate& candidate : candidates) {
      const bool used = std::any_of(chosen.begin(), chosen.end(), [&](const LoadCandidate* c) {
        return c->configuration == candidate.configuration;
      });
      if (used || candidate.held.size() == 0) continue;
      chosen.push_back(&candidate);
      const double information = Information(chosen, background);
      chosen.pop_back();
      if (information > most * (1 + 1e-9)) {
        most = information;
        best = &candidate;
      }
    }
    if (best == nullptr) return plan;
    chosen.push_back(best);
    plan.configurations.push_back(problem.data().configurations[best->configuration].id);
    plan.wrenches.push_back(best->wrench);
    plan.sigma = AppliedNoise(estimate.sigma) / std::sqrt(most);
  }
  return plan;
}

LoadPlan PlanLoads(const CalibrationProblem& problem, const Estimate& estimate, int held,
                   const std::vector<AppliedWrench>& wrenches, int count) {
  const auto estimated = static_cast<Eigen::Index>(estimate.estimated.size());
  if (estimate.model_covariance.rows() != estimated) return {{}, {}, kInfinity};  // no intervals, no plan
  const Background background = MakeBackground(problem, estimate, held);
  CalibrationProblem scratch = problem;
  std::vector<LoadCandidate> candidates;
  for (const int shot : ShotPerConfiguration(problem)) {
    for (const AppliedWrench& wrench : wrenches) {
      candidates.push_back(MakeCandidate(problem, estimate, background, shot, wrench, &scratch));
    }
  }
  return ChooseBest(problem, estimate, background, candidates, count);
}

// The load at hand, 100 mm to each side of where it acts.
LoadPlan PlanDisplacedLoad(const CalibrationProblem& problem, const Estimate& estimate, int held) {
  std::vector<AppliedWrench> wrenches;
  for (int side = 0; side < 6; ++side) {
    AppliedWrench wrench = LoadAtHand(problem);
    if (wrench.force.isZero()) wrench.force = kMostPull * problem.experiment().gravity_direction;
    wrench.point[side / 2] += side % 2 == 0 ? kOffAxis : -kOffAxis;
    wrenches.push_back(wrench);
  }
  return PlanLoads(problem, estimate, held, wrenches, kPulls);
}

std::string Outcome(const Coordinate& coordinate, double sigma) {
  const QuantityTraits& traits = TraitsOf(coordinate.quantity);
  return ReachedInWords(coordinate.name, sigma / traits.si_per_unit, traits.unit);
}

std::string ComplianceRemedy(const CalibrationProblem& problem, const Estimate& estimate, int held) {
  const Coordinate& coordinate = estimate.parameters.coordinates()[held];
  const double limit = coordinate.hold_limit;
  const double force = PullAtHand(problem);
  const LoadPlan pulls = PlanPulls(problem, estimate, held, force, kPulls);
  if (pulls.sigma < limit) {
    return PullSideways(force, pulls.configurations, Outcome(coordinate, pulls.sigma));
  }
  const LoadPlan displaced = PlanDisplacedLoad(problem, estimate, held);
  if (displaced.sigma < limit) {
    return HangOffAxis(displaced.wrenches[0].point, displaced.configurations, Outcome(coordinate, displaced.sigma));
  }
  return NoLoadDetermines();
}

std::string SpringRemedy(const Direction& direction, const ParameterSet& parameters) {
  if (parameters.spring_tie()) return SpringRemedyInWords(SpringDoubt::kTied);
  const std::string length = NameOf(CompensatorPart::kL);
  const bool is_length = std::any_of(direction.components.begin(), direction.components.end(),
                                     [&](const auto& component) { return component.first == length; });
  return SpringRemedyInWords(is_length ? SpringDoubt::kLength : SpringDoubt::kOther);
}

}  // namespace

LoadPlan PlanPulls(const CalibrationProblem& problem, const Estimate& estimate, int held, double force, int count) {
  const Vector3<double> down = problem.experiment().gravity_direction;
  const Vector3<double> u = down.unitOrthogonal(), v = down.cross(u);
  std::vector<AppliedWrench> wrenches;
  for (int heading = 0; heading < kHeadings; ++heading) {
    const double angle = heading * 2 * EIGEN_PI / kHeadings;
    AppliedWrench wrench = LoadAtHand(problem);
    wrench.force = force * (std::cos(angle) * u + std::sin(angle) * v);
    wrench.moment.setZero();
    wrench.expressed_in = problem.experiment().gravity_in_base ? WrenchFrame::kBase : WrenchFrame::kMeasurement;
    wrenches.push_back(wrench);
  }
  return PlanLoads(problem, estimate, held, wrenches, count);
}

void AddLoadRemedies(const CalibrationProblem& problem, Estimate* estimate) {
  const ParameterSet& parameters = estimate->parameters;
  for (Direction& direction : estimate->identifiability.weak) {
    const bool is_spring = CoordinateKindOf(direction.components[0].first) == CoordinateKind::kCompensator;
    if (is_spring) direction.remedy = SpringRemedy(direction, parameters);
  }
  for (Direction& direction : estimate->identifiability.unidentifiable) {
    int held = -1;
    bool compliance = false, spring = false;
    for (const auto& [name, value] : direction.components) {
      const int i = parameters.FindCoordinate(name);
      const Coordinate& coordinate = parameters.coordinates()[i];
      if (held < 0 && coordinate.held) held = i;
      compliance |= coordinate.kind == CoordinateKind::kCompliance;
      spring |= coordinate.kind == CoordinateKind::kCompensator;
    }
    if (held < 0 || !(compliance || spring)) continue;
    const bool spring_held = parameters.coordinates()[held].kind == CoordinateKind::kCompensator;
    direction.remedy = spring_held ? SpringRemedy(direction, parameters) : ComplianceRemedy(problem, *estimate, held);
  }
}

std::string FoldedShot(const CalibrationProblem& problem, const ParameterSet& parameters) {
  const std::vector<double> theta = parameters.ModelValues();
  for (size_t s = 0; s < problem.data().shots.size(); ++s) {
    const Shot& shot = problem.data().shots[s];
    const Matrix3<double> rotation = parameters.BaseInStation(shot.station).rotation;
    if (problem.model().Equilibrate(problem.shot_inputs()[s], theta.data(), rotation).converged) continue;
    return ShotThatFolds(IsLoaded(shot) ? shot.load : "", problem.data().configurations[shot.configuration].id,
                         problem.data().SourceOf(problem.data().observations[shot.observations.front()]));
  }
  return "";
}

std::string FoldedInWords(const CalibrationProblem& problem, const ParameterSet& parameters) {
  return FoldedShotInWords(FoldedShot(problem, parameters));
}

}  // namespace sagitta

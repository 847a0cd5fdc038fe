#include "estimator/diagnosis/noise_check.h"

#include <cmath>
#include <set>

#include "estimator/noise/repeat_spread.h"
#include "estimator/noise/rigid_bodies.h"
#include "estimator/noise/rotation_noise.h"
#include "estimator/noise/variance_components.h"
#include "estimator/statistics/distributions.h"

namespace sagitta {
namespace {

constexpr int kFewestDof = 20;      // that determine a scale: to a sixth
constexpr size_t kSharedRows = 10;  // beyond one per visit: 30 coordinates say what is shared to an eighth

}  // namespace

bool IsSigmaStated(const CalibrationProblem& problem) {
  return problem.sigma_is_stated() && problem.experiment().noise.from != NoiseSpec::From::kVarianceComponents;
}

// scale^2 = sum / dof: c F(dof, nu) as the stated sigma is known (repeat_spread.h).
NoiseScale ScaleOf(double sum, int dof, const CalibrationProblem& stated) {
  const RatioOfSpreads ratio = RatioByRepeats(stated.repeat_scatter, dof);
  const double scale = std::sqrt(sum / dof);
  const auto end = [&](double level) { return scale / std::sqrt(ratio.factor * FQuantile(level, dof, ratio.dof)); };
  return {scale, end(kUpperOf95), end(1.0 - kUpperOf95), dof};
}

// Of what rigid motions leave.
std::optional<NoiseScale> InstrumentNoiseScale(const CalibrationProblem& problem, const ParameterSet& parameters) {
  int all = -ShapeCost(problem);
  double sum = 0.0;
  for (const ShotResidual& shot : ResidualsByShot(problem, parameters, problem.CalibrationObservations())) {
    int dof = 0;
    sum += WithoutRigidMotion(shot, &dof).squaredNorm();
    all += dof;
  }
  if (all < kFewestDof) return std::nullopt;
  return ScaleOf(sum, all, problem);
}

namespace {

// Points as the problem states them, rotations by what is left of them.
std::optional<CalibrationProblem> WithRotationsFound(const CalibrationProblem& stated, const DiagnosedModel& baseline) {
  const auto scatter = FindRotationScatter(stated, *baseline.problem, baseline.estimate, !IsSigmaStated(stated));
  if (!scatter) return std::nullopt;
  CalibrationProblem weighed = *baseline.problem;
  KeepRotationNoise(*scatter, &weighed);
  return weighed;
}

// Both by what is left of them.
std::optional<CalibrationProblem> WithBothFound(const DiagnosedModel& baseline) {
  const std::optional<TwoNoises> noises = TwoSpreads(*baseline.problem, baseline.estimate);
  if (!noises) return std::nullopt;
  CalibrationProblem weighed = *baseline.problem;
  weighed.resolved_noise = noises->roots;
  weighed.noise_origin = NoiseOrigin::kFound;
  weighed.mutable_experiment()->noise.sigma = noises->components[0].value;  // of rows that are predicted
  weighed.rotation_noise = noises->components[1].value;
  return weighed;
}

}  // namespace

void WeighPointsAndRotations(const CalibrationProblem& problem, const JointOptions& joint, DiagnosedModel* baseline) {
  if (!NoRotationIsStated(problem)) return;
  const bool are_points_stated = problem.sigma_is_stated();
  for (int round = 0; round < kMostScatterRounds && ShowsSpread(baseline->estimate); ++round) {
    const std::optional<CalibrationProblem> weighed =
        are_points_stated ? WithRotationsFound(problem, *baseline) : WithBothFound(*baseline);
    if (!weighed) return;
    DiagnosedModel refit = RefitFully(*weighed, baseline->estimate, joint);
    if (!IsUsable(refit.estimate.status)) return;
    *baseline = std::move(refit);
  }
}

CalibrationProblem WithScaledSigmas(const CalibrationProblem& problem, double factor) {
  CalibrationProblem scaled =
      WithRoots(problem, [&](int i) { return Matrix3<double>(factor * problem.SqrtCovariance(i)); });
  std::optional<double>& common = scaled.mutable_experiment()->noise.sigma;  // of rows that are predicted
  if (common) *common *= factor;
  scaled.rotation_noise *= factor;
  if (scaled.noise_origin != NoiseOrigin::kFound) scaled.noise_origin = NoiseOrigin::kScaled;
  return scaled;
}

CalibrationProblem WithRepeatability(const CalibrationProblem& problem, const JointSigmas& sigmas) {
  CalibrationProblem with = problem;
  RepeatabilitySpec& spec = with.mutable_experiment()->repeatability;
  spec.angle = spec.length = {};
  for (const Joint& joint : with.robot().chain.joints) {
    const bool turns = joint.type == JointType::kRevolute;
    const double sigma = turns ? sigmas.turn : sigmas.travel;
    if (sigma > 0.0) (turns ? spec.angle : spec.length).per_joint[joint.name] = sigma;
  }
  with.latent = MakeLatentModel(with.robot().chain, with.data(), with.experiment());
  return with;
}

RepeatabilityFit FitRepeatability(const CalibrationProblem& problem, const ParameterSet& parameters, bool sigma_is_open,
                                  bool with_interval) {
  DeviationGroup turning, sliding;
  for (int j = 0; j < problem.robot().num_joints(); ++j) {
    (IsRevolute(problem, j) ? turning : sliding).joints.push_back(j);
  }
  RepeatabilityFit fit;
  std::vector<DeviationGroup> groups;
  std::vector<SizeFit*> sizes;
  const auto add = [&](const DeviationGroup& group, SizeFit* size) {
    if (group.joints.empty()) return;
    groups.push_back(group);
    sizes.push_back(size);
  };
  add(turning, &fit.turn);
  add(sliding, &fit.travel);
  const RestrictedLikelihood reml(problem, parameters);
  if (reml.dof() <= 0 || groups.empty()) return fit;
  const RemlFit all = reml.Maximise(sigma_is_open, groups);
  fit.instrument = std::sqrt(all.variances[0]);
  for (size_t g = 0; g < groups.size(); ++g) {
    sizes[g]->sigma = std::sqrt(all.variances[g + 1]);
    if (with_interval)
      reml.ProfileInterval(all, sigma_is_open, groups, static_cast<int>(g) + 1, &sizes[g]->low, &sizes[g]->high);
  }
  return fit;
}

bool RowsShareVisits(const CalibrationProblem& problem) {
  std::set<int> visits;
  const std::vector<int> observations = problem.CalibrationObservations();
  for (const int i : observations) {
    visits.insert(problem.latent.visit_of_shot[problem.data().observations[i].shot]);
  }
  return observations.size() >= visits.size() + kSharedRows;
}

}  // namespace sagitta

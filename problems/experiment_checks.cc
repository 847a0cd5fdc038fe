#include "problems/experiment_checks.h"

#include <cmath>

#include "problems/choices.h"
#include "problems/problem_checks.h"
#include "problems/range.h"

namespace sagitta {
namespace {

constexpr double kUnitDirection = 1e-6;  // of a direction, off 1: components of seven digits

class Checks {
 public:
  explicit Checks(const Experiment& experiment) : experiment_(experiment) {}

  void In(const Range& range, double value, const std::string& key) const {
    if (!range.Has(value)) FailProblem(experiment_, key, range.Refusal(value));
  }
  void In(const Range& range, const std::optional<double>& value, const std::string& key) const {
    if (value) In(range, *value, key);
  }
  void In(const Range& range, const std::optional<Vector3<double>>& values, const std::string& key) const {
    if (!values) return;
    for (const double value : *values) In(range, value, key);
  }

  // Of a number that was made an enum.
  template <typename Choice>
  void IsChoice(Choice choice, const std::string& key) const {
    const auto index = static_cast<size_t>(choice);
    if (index < WordsOf<Choice>().size()) return;
    FailProblem(experiment_, key, "there is no choice number " + std::to_string(static_cast<int>(choice)));
  }

  const Experiment& experiment() const { return experiment_; }

 private:
  const Experiment& experiment_;
};

void CheckNoiseNumbers(const NoiseSpec& noise, const Checks& check) {
  check.In(allowed::kSigma, noise.sigma, "noise.sigma");
  if (noise.from == NoiseSpec::From::kSigma && !noise.sigma) {
    FailProblem(check.experiment(), "noise.sigma", "the noise is said to be stated and is not", "set NoiseSpec::sigma");
  }
  check.In(allowed::kFactor, noise.lambda, "noise.lambda");
  check.In(allowed::kSigma, noise.sigma0, "noise.sigma0");
  check.In(allowed::kNoiseIterations, noise.iterations, "noise.iterations");
  check.In(allowed::kSigmaOrZero, noise.range, "noise.instrument.range");
  check.In(allowed::kSigmaOrZero, noise.range_per_m, "noise.instrument.range_per_m");
  check.In(allowed::kSigmaOrZero, noise.angle, "noise.instrument.angle");
  check.In(allowed::kSigmaOrZero, noise.angle_per_m, "noise.instrument.angle_per_m");
}

void CheckRepeatability(const Range& range, const RepeatabilitySpec::OfKind& kind, const Checks& check) {
  check.In(range, kind.common, "repeatability");
  for (const auto& [joint, sigma] : kind.per_joint) check.In(range, sigma, "repeatability." + joint);
}

void CheckScene(const Experiment& experiment, const Checks& check) {
  check.In(allowed::kCoordinate, experiment.load_point, "load_point");
  for (const auto& [id, load] : experiment.loads) {
    check.In(allowed::kMass, load.mass, "loads." + id + ".mass_kg");
    check.In(allowed::kCoordinate, load.point, "loads." + id + ".point");
  }
  check.In(allowed::kMass, experiment.tool_mass, "tool.mass_kg");
  check.In(allowed::kCoordinate, experiment.tool_com, "tool.com");
  check.In(allowed::kGravity, experiment.gravity, "gravity.m_per_s2");
  if (!(std::abs(experiment.gravity_direction.norm() - 1.0) < kUnitDirection)) {
    FailProblem(experiment, "gravity.direction", "a direction of length 1 is expected");
  }
  for (const auto& [id, marker] : experiment.markers) {
    check.In(allowed::kCoordinate, marker.point, "markers." + id + ".xyz");
    check.In(allowed::kAngle, marker.rotvec, "markers." + id + ".rotvec");
    check.In(allowed::kSigma, marker.spring_sigma, "markers." + id + ".spring_sigma");
  }
  for (const auto& [id, station] : experiment.stations) {
    check.In(allowed::kCoordinate, station.base_xyz, "stations." + id + ".xyz");
    check.In(allowed::kAngle, station.base_rotvec, "stations." + id + ".rotvec");
    check.In(allowed::kCoordinate, station.instrument_xyz, "stations." + id + ".instrument");
  }
}

}  // namespace

void CheckExperiment(const Experiment& experiment) {
  const Checks check(experiment);
  CheckScene(experiment, check);
  CheckNoiseNumbers(experiment.noise, check);
  CheckRepeatability(allowed::kAngleSigmaOrZero, experiment.repeatability.angle, check);
  CheckRepeatability(allowed::kSigmaOrZero, experiment.repeatability.length, check);
  check.IsChoice(experiment.method.weights, "weights");
  check.IsChoice(experiment.method.loss, "loss");
  check.IsChoice(experiment.method.covariance, "covariance");
  check.IsChoice(experiment.method.bootstrap.kind, "bootstrap.kind");
  check.IsChoice(experiment.noise.group, "noise.group");
  check.In(allowed::kReplicates, experiment.method.bootstrap.replicates, "bootstrap.replicates");
  for (const auto& [name, prior] : experiment.priors) {
    check.In(allowed::kPriorValue, prior.value, "priors." + name + ".value");
    check.In(allowed::kPriorSigma, prior.sigma, "priors." + name + ".sigma");
  }
  if (experiment.validation.kind == ValidationSpec::Kind::kFraction) {
    check.In(allowed::kFraction, experiment.validation.fraction, "validation.fraction");
  }
  check.In(allowed::kLevel, experiment.significance, "significance");
}

}  // namespace sagitta

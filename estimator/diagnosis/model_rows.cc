#include "estimator/diagnosis/model_rows.h"

#include "models/constants.h"

namespace sagitta {
namespace {}  // namespace

Linearization LinearizeEstimate(const CalibrationProblem& problem, const ParameterSet& parameters,
                                LatentTreatment treatment) {
  const std::vector<int> observations = problem.CalibrationObservations();
  return Linearize(problem, parameters, observations, parameters.EstimatedCoordinates(),
                   ObservationNoise(problem, observations, kFallbackSigma), treatment);
}

// Order 0: the cosine column of a harmonic is that of a constant joint deviation.
Eigen::MatrixXd JointDeviationColumns(const CalibrationProblem& problem, const ParameterSet& parameters,
                                      LatentTreatment treatment) {
  std::vector<EffectSpec> specs;
  for (const Joint& joint : problem.robot().chain.joints) {
    specs.push_back({"joint_harmonic", joint.name, {{"order", "0"}}, {}});
  }
  CalibrationProblem extended = problem.WithEffects(specs);
  extended.parameters.CopyByName(parameters);
  std::vector<int> cosines;
  for (const EffectSpec& spec : specs) cosines.push_back(extended.parameters.FindCoordinate(spec.Path() + "/cos"));
  const std::vector<int> observations = extended.CalibrationObservations();
  return kMicro * Linearize(extended, extended.parameters, observations, cosines,
                            ObservationNoise(extended, observations, kFallbackSigma), treatment)
                      .jacobian;
}

}  // namespace sagitta

// estimate.json (sagitta/estimate/1, FORMATS section 4): writing, and reading
// what predict and simulate need of it.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "estimator/estimate/estimate.h"
#include "estimator/intervals/prediction.h"
#include "estimator/report/results_words.h"
#include "estimator/results/prediction_noise.h"
#include "estimator/results/provenance.h"
#include "problems/calibration_problem.h"
#include "problems/measurements.h"

namespace sagitta {

nlohmann::ordered_json EstimateToJson(const CalibrationProblem& problem, const Estimate& estimate,
                                      const Provenance& provenance);

// What the data can determine, as estimate.json has it.
nlohmann::ordered_json IdentifiabilityToJson(const CalibrationProblem& problem, const Identifiability& identifiability);

// Pretty enough to read, one line per parameter.
std::string DumpJson(const nlohmann::ordered_json& json);

// From the least to the most while the robot was measured.
struct MeasuredInterval {
  double least = 0.0, most = 0.0;
};

// When, how warm and under which loads the robot was measured.
struct MeasuredConditions {
  bool are_stated = false;                      // by the file of the estimate
  std::optional<MeasuredInterval> time;         // s, as in the files of the rows; absent: no row states it
  std::optional<MeasuredInterval> temperature;  // degC
  double load_force = 0.0;                      // N, of the heaviest load; 0: none
  // Between which readings something happened, by the moment that its effect states; s of the campaign's clock.
  std::map<double, MeasuredInterval> moments;
};

// A robot with its surroundings, as an estimate or an experiment states it; SI.
struct KnownRobot {
  // Compiled once (estimate_reader.cc), not in each file that holds one.
  KnownRobot();
  KnownRobot(const KnownRobot&);
  KnownRobot(KnownRobot&&) noexcept;
  KnownRobot& operator=(const KnownRobot&);
  KnownRobot& operator=(KnownRobot&&) noexcept;
  ~KnownRobot();

  std::string file;
  Robot robot;
  std::map<std::string, Pose<double>> base_in_station;
  std::map<std::string, MarkerSpec> markers;  // points are set, rotations where poses were read
  Experiment loading;                         // loads, tool, gravity, noise; nothing else of it
  ParameterUncertainty uncertainty;
  // In place of uncertainty.covariance between this campaign and another one, which differ in every combination of the
  // parameters by no less than its configurations err.
  Eigen::MatrixXd campaign_covariance;
  Eigen::MatrixXd noise_covariance;  // of noise alone, as the same names have it
  double halves = 1.0;               // factor by which configurations err beyond noise; infinite: they do not show it
  PredictionNoise noise;
  double model_error = 1.0;  // factor by which model error widens the parameters' intervals (model_error.factor)
  double rest = 0.0;         // m, RMS distance: what is left on points that were not fitted beyond noise and parameters
  double dof = 0.0;          // degrees of freedom of the fit; 0: not stated
  double clusters = 0.0;     // configurations that the covariance was found from (sandwich, bootstrap); 0: by the model
  struct Parameter {
    double value = 0.0, nominal = 0.0;  // SI
  };
  std::map<std::string, Parameter> parameters;    // by coordinate name
  std::vector<MeasuredInterval> measured_joints;  // rad or m, one per joint; empty: the file does not state them
  MeasuredConditions measured_conditions;
  std::vector<std::string> input_hashes;  // SHA-256 of the files it was estimated from
};

// In mm and mrad.
nlohmann::ordered_json SizeToJson(const ResidualSize& size);

// Throws InputError. own_effects: as of ReadRobotFile, where the estimated robot has effects of one's own.
KnownRobot ReadEstimateFile(const std::string& path, const std::vector<const EffectDefinition*>& own_effects = {});
KnownRobot ReadEstimateText(const std::string& text, const std::string& file_in_messages,
                            const std::vector<const EffectDefinition*>& own_effects = {});

// The robot before the estimate: nominal, with base poses and markers aligned to the rows it was estimated from.
// `problem`: a PredictionProblem of `known`.
ParameterSet NominalParameters(const KnownRobot& known, const CalibrationProblem& problem);

// The problem of predicting `data`: stations and markers of the data placed
// where `known` has them, robot at its calibrated nominal, noise as at the predicted
// points. Throws InputError for a station, marker or load that is not known.
CalibrationProblem PredictionProblem(const KnownRobot& known, Measurements data);

// Makes a pose of every row whose target's rotation is known: what it would be is to be predicted.
void AddKnownRotations(const KnownRobot& known, Measurements* data);

}  // namespace sagitta

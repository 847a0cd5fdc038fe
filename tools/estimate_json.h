// estimate.json (sagitta/estimate/1, FORMATS section 4): writing, and reading
// what predict and simulate need of it.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "estimator/estimate.h"
#include "estimator/intervals/prediction.h"
#include "problems/calibration_problem.h"
#include "tools/problem_from_arguments.h"

namespace sagitta {

struct Provenance {
  std::string command;
  std::string method = "joint";
  std::vector<InputFile> inputs;
};

nlohmann::ordered_json EstimateToJson(const CalibrationProblem& problem, const Estimate& estimate,
                                      const Provenance& provenance);

// Pretty enough to read, one line per parameter.
std::string DumpJson(const nlohmann::ordered_json& json);

// A robot with its surroundings, as an estimate or an experiment states it; SI.
struct KnownRobot {
  std::string file;
  Robot robot;
  std::map<std::string, Pose<double>> base_in_station;
  std::map<std::string, MarkerSpec> markers;  // points are set
  Experiment loading;                         // loads, tool, gravity, noise; nothing else of it
  ParameterUncertainty uncertainty;
  double noise_scale = 1.0;  // of stated sigmas and repeatability
};

// Throws InputError.
KnownRobot ReadEstimateFile(const std::string& path);

// The problem of predicting `data`: stations and markers of the data placed
// where `known` has them, robot at its calibrated nominal. Throws InputError
// for a station, marker or load that is not known.
CalibrationProblem PredictionProblem(const KnownRobot& known, Measurements data);

}  // namespace sagitta

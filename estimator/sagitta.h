// Sagitta as a library: robot calibration from measured points. This header is the front door; installed as
// <sagitta/sagitta.h>, linked as sagitta::sagitta. The program `sagitta` does what these functions do.
//
//   const sagitta::CalibrationProblem problem = sagitta::ReadExperiment({"robot.yaml", "measurements.csv"});
//   const sagitta::Calibration result = sagitta::Calibrate(problem);
//   sagitta::WriteCalibration(result, "results");
//
// What to measure next: MakePlan (estimator/planning/plan.h). Corrected targets: MakeCompensationInput, Compensate
// (estimator/results/compensation_csv.h). Long work ends early where an Interruptible scope says so.
//
// Units are SI (m, rad, N, kg, s) but for Prior and LargestDeviation; a rotation's standard deviation is that of a left
// perturbation, R = exp(delta) R_hat. Input that cannot be used throws InputError {file, line, key, what, hint}, an
// option out of its range one whose key is Struct.field. A numerical failure of an estimate is a Status with a message;
// Predict, Validate and Simulate throw Failure where a load folds the arm. What was interrupted throws Interruption.
// What asks for results that do not exist, of a calibration that is not usable for example, and members of a problem
// that do not fit together are std::invalid_argument. Nothing here prints. Functions that return nlohmann::ordered_json
// need <nlohmann/json.hpp> where they are called.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "estimator/baselines/compare_methods.h"
#include "estimator/diagnosis/diagnose.h"
#include "estimator/estimate/estimate.h"
#include "estimator/inspection/finding.h"
#include "estimator/intervals/prediction.h"
#include "estimator/least_squares/ceres_problem.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/planning/plan.h"
#include "estimator/results/compensation_csv.h"
#include "estimator/results/estimate_json.h"
#include "estimator/validation/trust.h"
#include "problems/calibration_problem.h"
#include "problems/failure.h"
#include "problems/input_error.h"
#include "problems/interruption.h"
#include "problems/io/experiment_inputs.h"
#include "problems/io/robot_file.h"
#include "problems/range.h"
#include "problems/simulation.h"

namespace sagitta {

// An experiment file, or ROBOT.yaml MEAS.csv…, read and put together. Throws InputError. Problems of one's own, without
// files: MakeCalibrationProblem (problems/calibration_problem.h).
CalibrationProblem ReadExperiment(const std::vector<std::string>& paths);

// What every estimating command asks first. Throws InputError where numbers are in another unit than their column says,
// or where the nominal robot cannot have made the readings; `remedy` is what the caller offers for going on all the
// same.
void CheckReadings(const CalibrationProblem& problem, const std::string& remedy);

// Sets 30 % of the configurations aside where the experiment does not say which, as a diagnosis needs.
void HoldOutForDiagnosis(const Measurements& data, Experiment* experiment);

// How Calibrate goes about it.
struct CalibrateOptions {
  Method method = Method::kJoint;
  int num_threads = 1;
  std::uint64_t seed = 1;  // of the random halves that are compared
  std::function<void(const std::string&)> progress = {};
};
// Throws InputError that names the option (problems/range.h).
void CheckOptions(const CalibrateOptions& options);

// What Calibrate found.
struct Calibration {
  // With the noise that was found (per row, or found_noise for all of them) and outliers excluded: judge, refit and
  // AddToProblem with this one.
  CalibrationProblem problem;
  Estimate estimate;
  Trust trust;  // of a usable estimate: what its verdict says, and on what grounds; else the suspect rows
};

// Everything that is unknown in one solve, with the noise, the intervals that the experiment asks for, the agreement
// between parts of the data, and the verdict. Judge it by estimate.status (IsUsable). Throws InputError where the
// method cannot honour what the problem states, and std::invalid_argument where members of the problem that were set
// since it was made do not fit together, or hold what is no number.
Calibration Calibrate(CalibrationProblem problem, const CalibrateOptions& options = {});

// The extended model of a usable diagnosis, judged as Calibrate judges: verdict, cross-validation, suspect rows, model
// error in the intervals. Throws std::invalid_argument where the diagnosis has no model.
Calibration ExtendedCalibration(const Diagnosis& diagnosis, std::uint64_t seed = 1);

// estimate.learnt.json as written. diagnosis.learnt: not null.
nlohmann::ordered_json LearntEstimateToJson(const Diagnosis& diagnosis, const Provenance& provenance);

// estimate.json as written: the estimate, its verdict, cross-validation and suspect rows. This and the next two throw
// std::invalid_argument where the estimate is not usable or is one of other rows than the problem's.
nlohmann::ordered_json CalibrationToJson(const Calibration& calibration, const Provenance& provenance);

// estimate.json, robot.calibrated.yaml and residuals.csv (FORMATS section 4) in a folder that is made if it is absent.
// Rows that are of no file have their configuration and marker as columns in tables. Throws InputError where one of
// these is a file that the problem was read from.
void WriteCalibration(const Calibration& calibration, const std::string& folder, const Provenance& provenance = {});

// What prediction needs of a calibration: as ReadEstimateFile gives it of an estimate.json.
KnownRobot KnownFrom(const Calibration& calibration);

// A truth that an experiment states: its robot, `stations` and `markers`. Throws InputError where one is missing.
KnownRobot KnownFrom(const std::string& file, const Robot& robot, const Experiment& experiment);

// Predicted readings, one per row.
struct Prediction {
  // m, one column per observation, in its station's frame; of a rotation its rotation vector, rad.
  Eigen::Matrix3Xd points;
  std::vector<PredictionCovariance> covariances;  // m^2, by where they come from
  NoiseRoots instrument;                          // root of one measurement's covariance, m; zero: not known
  PredictedSquares together;                      // of all points and their readings
  std::vector<std::string> beyond;                // sentences on rows beyond what the estimate was measured at
};

// Points of the rows (x, y, z may be absent), and rotations of those that are poses (AddKnownRotations makes poses of
// rows whose target's rotation is known). Throws InputError for a station, marker or load that is not known, and
// Failure where a load folds the arm.
Prediction Predict(const KnownRobot& known, const Measurements& rows);

// The rows with what was predicted: the file of `sagitta predict`.
std::string PredictionToCsv(const Measurements& rows, const Prediction& prediction);
// mm, the largest standard deviation of a predicted coordinate; not finite: not known.
double LargestDeviation(const Prediction& prediction, const Measurements& rows);

// Where most of what is uncertain at these rows is what the calibration did not measure (held parameters): that in
// words; else empty.
std::string LeftOpenInWords(const KnownRobot& known, const Measurements& rows, const Prediction& prediction);
// That, rows outside the measured joint ranges, and effects with a memory: what to know before these predictions are
// used, in words.
std::vector<std::string> WarningsOf(const KnownRobot& known, const Measurements& rows, const Prediction& prediction);

// Why the robot of an estimate, where it stands, cannot have made the readings; nothing: it can, or the rows have none.
// predicted: of these rows (Prediction::points, Validation::predicted).
std::optional<Finding> Contradiction(const KnownRobot& known, const Measurements& rows,
                                     const Eigen::Matrix3Xd& predicted);
// All points are (0, 0, 0): placeholders, where none are asked for.
bool PointsAreZero(const Measurements& rows);
// Throws InputError where there is a contradiction; `remedy` is what the caller offers for going on all the same.
void CheckReadings(const KnownRobot& known, const Measurements& rows, const Eigen::Matrix3Xd& predicted,
                   const std::string& remedy);

// Before (nominal robot; base and markers fitted to the calibration rows) and after, on rows that were not calibrated.
struct Validation {
  ResidualSize before, after;
  double predicted_rms = 0.0;  // m, per coordinate: noise and parameters; 0: the noise is not known
  double p_value = 1.0;        // that errors as large as these come about although the prediction is right
  Eigen::Matrix3Xd predicted;  // m
  NoiseRoots scatter;          // root of what one reading scatters by, instrument and joints, m; zero: not known
  std::string contradiction;   // why the robot cannot have made these readings; empty: it can
  std::string refutation;      // that the errors are larger than predicted; empty: they are not, at the significance
  std::vector<std::string> warnings;
};

// The estimate against rows that it has not seen; rows that are excluded or have no reading do not judge. Throws
// InputError for a station, marker or load that it does not know and where no row judges, Failure where a load folds
// the arm.
Validation Validate(const KnownRobot& known, const Measurements& rows);
// validation.json, and the rows with prediction and residual.
nlohmann::ordered_json ValidationToJson(const Validation& validation, const Provenance& provenance);
std::string ValidationToCsv(const Measurements& rows, const Validation& validation);

// The rows with points, and of targets of known rotation poses, as the instrument would have read them. Noise: `sigma`
// (m) on every axis (rotations: that of their rows), else what rows or experiment state; a stated repeatability moves
// each joint once per arrival. The same seed gives the same numbers on every machine.
struct SimulateOptions {
  std::optional<double> sigma = {};
  std::uint64_t seed = 1;
};
// Throws InputError that names the option (problems/range.h).
void CheckOptions(const SimulateOptions& options);
// Rows with simulated readings: the known robot, with noise and repeatability as the experiment states them. Throws
// InputError where the truth lacks a station or marker, and Failure where a load or a joint's deviation folds the arm.
Measurements Simulate(const KnownRobot& known, const Measurements& rows, const Experiment& experiment,
                      const SimulateOptions& options = {});

}  // namespace sagitta

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "estimator/agreement/agreement.h"
#include "estimator/baselines/compare_methods.h"
#include "estimator/calibration/coupled_joints.h"
#include "estimator/calibration/noise_loop.h"
#include "estimator/calibration/unit_guess.h"
#include "estimator/diagnosis/learnt_model.h"
#include "estimator/diagnosis/undecided.h"
#include "estimator/inspection/load_direction.h"
#include "estimator/inspection/reading_lint.h"
#include "estimator/intervals/intervals.h"
#include "estimator/report/baselines_words.h"
#include "estimator/report/calibration_words.h"
#include "estimator/report/diagnosis_words.h"
#include "estimator/report/noise_words.h"
#include "estimator/report/validation_words.h"
#include "estimator/results/residuals_csv.h"
#include "estimator/results/trust_json.h"
#include "estimator/sagitta.h"
#include "models/effects/catalogue.h"
#include "problems/io/files.h"
#include "problems/io/output_files.h"
#include "problems/range.h"
#include "problems/whole_problem.h"

namespace sagitta {
namespace {

// Random halves to compare: each costs two fits of half the rows, all together those of 40 000 rows, as far as four
// halves allow: of forty parameters these are 160 differences. A choice of time.
int RandomHalves(const CalibrationProblem& problem) {
  constexpr int kRowsOfHalves = 40000, kLeastHalves = 4, kMostHalves = 20;
  return std::clamp(kRowsOfHalves / static_cast<int>(problem.data().observations.size() + 1), kLeastHalves,
                    kMostHalves);
}

}  // namespace

CalibrationProblem ReadExperiment(const std::vector<std::string>& paths) {
  ExperimentInputs inputs = ReadExperimentInputs(paths);
  CalibrationProblem problem =
      MakeCalibrationProblem(std::move(inputs.robot), std::move(inputs.data), std::move(inputs.experiment));
  CheckUnits(problem, AlignedSample(problem));
  return problem;
}

void CheckReadings(const CalibrationProblem& problem, const std::string& remedy) {
  const AlignedSample aligned(problem);
  CheckUnits(problem, aligned);
  const Plausibility found = CheckPlausible(problem, aligned);
  if (found.plausible) return;
  throw InputError({}, "the nominal robot cannot have made these readings: " + found.finding.words,
                   found.finding.remedy + "; " + remedy);
}

void HoldOutForDiagnosis(const Measurements& data, Experiment* experiment) {
  constexpr double kFraction = 0.3;  // of 20 configurations six, the fewest whose gains confirm an effect (kFewGains)
  ValidationSpec& validation = experiment->validation;
  bool has_set_column = false;
  for (const MeasurementFile& file : data.files) has_set_column |= file.FindColumn("set") >= 0;
  if (validation.kind != ValidationSpec::Kind::kSetColumn || validation.needs_column || has_set_column) return;
  validation = ValidationSpec();
  validation.kind = ValidationSpec::Kind::kFraction;
  validation.fraction = kFraction;
}

namespace {

// A reading in metres leaves nothing that could be determined: the rows are the cause, what they hide is not.
void NameSuspects(Calibration* failed) {
  Estimate& estimate = failed->estimate;
  if (estimate.status == Status::kEquilibriumDiverged || estimate.aligned.num_coordinates() == 0) return;
  failed->trust.suspects = FindSuspects(failed->problem, estimate);
  if (failed->trust.suspects.empty()) return;
  const Suspect& first = failed->trust.suspects.front();
  estimate.message += "; " + RowsAreSuspect(failed->trust.suspects.size(), first.row + ": " + first.words);
  estimate.identifiability.unidentifiable.clear();
}

// What a method that knows no bounds put below one: "" where nothing is. No robot file may hold it.
std::string NameBelowItsBound(const ParameterSet& parameters) {
  for (int i = 0; i < parameters.num_coordinates(); ++i) {
    const Coordinate& coordinate = parameters.coordinates()[i];
    if (parameters.Value(i) < coordinate.lower) return coordinate.name;
  }
  return "";
}

// The problem keeps what is known of its noise now (CalibrationResiduals).
void KeepFoundNoise(Calibration* result) {
  const SigmaReport& sigma = result->estimate.sigma;
  result->problem.found_noise.sigma = sigma.stated ? 0.0 : sigma.estimated;
  result->problem.found_noise.factor = TimesStated(result->estimate);
}

// Results of what is not usable would be numbers without a meaning.
void CheckIsUsable(const Estimate& estimate, const std::string& what) {
  if (IsUsable(estimate.status)) return;
  const std::string why = estimate.message.empty() ? "" : ": " + estimate.message;
  throw std::invalid_argument(what + ": the estimate is not usable, " + StatusName(estimate.status) + why);
}

// "": the robot has no learnt function.
std::string WarningOfLearnt(const Robot& robot) {
  std::vector<std::string> learnt;
  for (const EffectSpec& spec : robot.effects) {
    if (FindEffect(robot, spec.effect)->is_learnt) learnt.push_back(Title(robot, spec));
  }
  return learnt.empty() ? "" : LearntFunctionsAreHeld(learnt);
}

// All that judges a usable estimate. rows: that were fitted, or null.
void JudgeCalibration(const CalibrateOptions& options, std::shared_ptr<const RowBatches> rows, Calibration* result) {
  const auto say = [&](const std::string& what) {
    if (options.progress) options.progress(what);
  };
  Estimate& estimate = result->estimate;
  AddIntervals(result->problem, {options.num_threads, options.progress}, &estimate);
  BetweenParts between;
  const FittedStream fitted(result->problem, std::move(rows), options.num_threads);
  // The folds' steps are those of the joint fit, at whose minimum the exact halves end too.
  FoldPlan folds;
  folds.is_of_joint_fit = options.method == Method::kJoint || options.method == Method::kTwoStep;
  if (folds.is_of_joint_fit) folds = PlanFolds(result->problem, fitted, options.seed);
  if (options.method == Method::kJoint) {
    say("comparing parts of the data");
    between =
        CheckAgreement(result->problem, {options.seed, RandomHalves(result->problem)}, &estimate, &fitted, &folds.rows);
  }
  const bool is_held_for_noise = LeftOpen(estimate).size() < estimate.identifiability.unidentifiable.size();
  if (is_held_for_noise) estimate.message = HeldAtStatedNoise(estimate.identifiability.unidentifiable.size());
  say("cross-validating");
  result->trust = JudgeTrust(result->problem, fitted, folds, &estimate, between);
  const std::string misfit = WarningOfMisfit(result->problem, estimate.fit.distance_rms);
  if (!misfit.empty()) estimate.warnings.push_back(misfit);
  if (result->trust.across) {
    const Finding across = LoadDirectionInWords(*result->trust.across);
    estimate.warnings.push_back(across.words + "; " + across.remedy);
  }
  for (const std::string& coupled : WarningsOfCouplings(result->problem)) estimate.warnings.push_back(coupled);
  const std::string learnt = WarningOfLearnt(result->problem.robot());
  if (!learnt.empty()) estimate.warnings.push_back(learnt);
  const std::string large = WarningOfLargeCorrections(result->problem, estimate.table);
  if (!large.empty()) estimate.warnings.push_back(large);
}

}  // namespace

void CheckOptions(const CalibrateOptions& options) {
  CheckIn(allowed::kThreads, options.num_threads, "CalibrateOptions.num_threads");
}

Calibration Calibrate(CalibrationProblem problem, const CalibrateOptions& options) {
  CheckOptions(options);
  CheckIsWhole(problem, "Calibrate");
  CheckMethod(problem, options.method);
  const auto say = [&](const std::string& what) {
    if (options.progress) options.progress(what);
  };
  JointOptions joint;
  joint.num_threads = options.num_threads;
  joint.progress = options.progress;
  ResolvedEstimate resolved = EstimateWithNoise(std::move(problem), joint);
  Calibration result{std::move(resolved.problem), std::move(resolved.estimate), {}};
  Estimate& estimate = result.estimate;
  if (options.method != Method::kJoint && IsUsable(estimate.status)) {
    say("running " + WordOf(options.method));
    estimate = RunMethod(result.problem, options.method, estimate, options.progress).estimate;
    const std::string below = IsUsable(estimate.status) ? NameBelowItsBound(estimate.parameters) : "";
    if (!below.empty()) {
      estimate.status = Status::kNotRun;
      estimate.message = NoRobotHasThis(WordOf(options.method), below);
      estimate.identifiability.unidentifiable.clear();
      return result;
    }
  }
  if (!IsUsable(estimate.status)) {
    NameSuspects(&result);
    return result;
  }
  JudgeCalibration(options, std::move(resolved.rows), &result);
  KeepFoundNoise(&result);
  return result;
}

Calibration ExtendedCalibration(const Diagnosis& diagnosis, std::uint64_t seed) {
  if (diagnosis.final.problem == nullptr) {
    throw std::invalid_argument("ExtendedCalibration: the diagnosis has no model, " +
                                std::string(StatusName(diagnosis.status)));
  }
  Calibration extended{*diagnosis.final.problem, diagnosis.final.estimate, {}};
  const FittedStream fitted(extended.problem);
  FoldPlan folds = PlanFolds(extended.problem, fitted, seed);
  BetweenParts between = CheckAgreement(extended.problem, {seed, RandomHalves(extended.problem)}, &extended.estimate,
                                        &fitted, &folds.rows);
  AddTo(diagnosis.choice, &between);
  extended.trust = JudgeTrust(extended.problem, fitted, folds, &extended.estimate, between);
  DescribeOrigin(extended.problem, &extended.estimate);
  KeepFoundNoise(&extended);
  return extended;
}

// Held-out points say what it lacks; folds and halves of a model with hundreds of weights would cost as much again as
// the diagnosis.
nlohmann::ordered_json LearntEstimateToJson(const Diagnosis& diagnosis, const Provenance& provenance) {
  if (diagnosis.learnt == nullptr) throw std::invalid_argument("LearntEstimateToJson: the diagnosis learnt nothing");
  const CalibrationProblem& problem = *diagnosis.learnt->model.problem;
  Estimate estimate = diagnosis.learnt->model.estimate;
  const Trust trust = JudgeByHoldout(problem, &estimate);
  nlohmann::ordered_json json = EstimateToJson(problem, estimate, provenance);
  if (trust.holdout.points > 0) AddModelErrorTo(estimate, trust, &json);
  return json;
}

nlohmann::ordered_json CalibrationToJson(const Calibration& calibration, const Provenance& provenance) {
  CheckIsUsable(calibration.estimate, "CalibrationToJson");
  CheckAreOf(calibration.problem.data(), static_cast<size_t>(calibration.estimate.predicted.cols()),
             "CalibrationToJson");
  nlohmann::ordered_json json = EstimateToJson(calibration.problem, calibration.estimate, provenance);
  AddTrustTo(calibration.estimate, calibration.trust, &json);
  return json;
}

void WriteCalibration(const Calibration& calibration, const std::string& folder, const Provenance& provenance) {
  CheckIsUsable(calibration.estimate, "WriteCalibration");
  const CalibrationProblem& problem = calibration.problem;
  const Estimate& estimate = calibration.estimate;
  std::vector<NamedText> files;
  files.emplace_back("robot.calibrated.yaml",
                     RunComment(provenance) + RobotToYaml(problem.RobotWith(estimate.parameters)));
  files.emplace_back("estimate.json", DumpJson(CalibrationToJson(calibration, provenance)));
  const std::vector<std::string> names = {"robot.calibrated.yaml", "residuals.csv", "estimate.json"};
  CheckInputsAreKept(problem.InputPaths(), folder, names);
  const OutputFolder out(folder, names);
  out.Write(files, {ResidualsFile(problem, estimate)});
}

KnownRobot KnownFrom(const Calibration& calibration) {
  CheckIsUsable(calibration.estimate, "KnownFrom");
  return ReadEstimateText(DumpJson(CalibrationToJson(calibration, {})), "estimate",
                          calibration.problem.robot().own_effects);
}

}  // namespace sagitta

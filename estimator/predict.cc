#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>

#include "estimator/calibration/load_remedy.h"
#include "estimator/inspection/known_lint.h"
#include "estimator/inspection/reading_lint.h"
#include "estimator/report/inspection_known_words.h"
#include "estimator/results/measured_conditions.h"
#include "estimator/results/measured_joints.h"
#include "estimator/results/remembering_effects.h"
#include "estimator/results/residuals_csv.h"
#include "estimator/sagitta.h"
#include "models/matrix_functions.h"
#include "problems/failure.h"

namespace sagitta {
namespace {

std::string MemoryInWords(const KnownRobot& known) {
  const std::vector<std::string> effects = RememberingEffects(known);
  return effects.empty() ? "" : BeginAtTheFirstRow(effects);
}

// m: no instrument sees less; exact simulations have no noise compared with which anything is little.
constexpr double kMatters = 1e-6;
// Times what is expected of readings, RMS: with however few rows and model error no chance.
constexpr double kContradicted = 5.0;
constexpr double kWorse = 1.05;  // of a hundred points an RMS is known to some 5 %

std::vector<int> AllRows(const Measurements& rows) {
  std::vector<int> all(rows.observations.size());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

// Rows with a reading that is not set aside.
std::vector<int> RowsThatJudge(const Measurements& rows) {
  std::vector<int> judging;
  for (const int i : AllRows(rows)) {
    if (rows.observations[i].IsRead() && !rows.observations[i].excluded) judging.push_back(i);
  }
  return judging;
}

Eigen::Matrix3Xd PointsOrThrow(const CalibrationProblem& problem, const ParameterSet& parameters) {
  const Eigen::Matrix3Xd points = PredictPoints(problem, parameters, AllRows(problem.data()));
  if (!points.allFinite()) {
    throw Failure("nothing predicted: equilibrium_diverged: " + FoldedInWords(problem, parameters));
  }
  return points;
}

Prediction PredictWith(const CalibrationProblem& problem, const KnownRobot& known) {
  const std::vector<int> all = AllRows(problem.data());
  Prediction prediction;
  prediction.points = PointsOrThrow(problem, problem.parameters);
  for (const int k : all) prediction.instrument.push_back(known.noise.scale * problem.SqrtCovariance(k));
  prediction.covariances = PredictionCovariances(problem, known.uncertainty, all, known.noise.scale,
                                                 prediction.instrument, &prediction.together);
  for (const int k : all) {
    PredictionCovariance& covariance = prediction.covariances[k];
    if (problem.data().observations[k].is_point()) covariance.model = AddedByRest(covariance.mean(), known.rest);
  }
  prediction.beyond = BeyondMeasuredInWords(known, problem);
  return prediction;
}

// A root of S S' + C, as calibrate has it: S chol(1 + S^-1 C S^-T).
Matrix3<double> RootWith(const Matrix3<double>& instrument, const Matrix3<double>& arm) {
  if (instrument.isZero(0.0) || arm.isZero(0.0)) return instrument;
  const Matrix3<double> inverse = instrument.inverse();
  return instrument * LowerRoot(Matrix3<double>::Identity() + inverse * arm * inverse.transpose());
}

// m^2, mean square distance of a row that parameters, repeatability and instrument predict; held parameters add
// theirs.
double SquareWithoutHeld(const Prediction& prediction, size_t k) {
  return prediction.covariances[k].parameters.trace() + prediction.covariances[k].arm.trace() +
         prediction.instrument[k].squaredNorm();
}
double ExpectedSquare(const Prediction& prediction, size_t k) {
  return prediction.covariances[k].held.trace() + SquareWithoutHeld(prediction, k);
}

// m, RMS distance of each observation that noise, joints and parameters let expect. What the calibration left on unseen
// points (PredictionCovariance::model) is not in it: rows are judged by whether they contradict the model.
std::vector<double> ExpectedDistances(const Prediction& prediction) {
  std::vector<double> expected;
  for (size_t k = 0; k < prediction.covariances.size(); ++k)
    expected.push_back(std::sqrt(ExpectedSquare(prediction, k)));
  return expected;
}

// What the errors say other than their size.
void JudgeErrors(const KnownRobot& known, const Measurements& rows, const Prediction& prediction,
                 Validation* validation) {
  if (const std::optional<Finding> found = Contradiction(known, rows, validation->predicted)) {
    validation->contradiction = RobotDidNotMakeThese(found->words);
    return;
  }
  const Chain& chain = known.robot.chain;
  const KnownMisfit misfit = MisfitOfKnown(chain, rows, validation->predicted, ExpectedDistances(prediction));
  if (!misfit.far.empty()) {
    const std::string first = rows.SourceOf(rows.observations[misfit.far.front()]);
    validation->warnings.push_back(
        RowsAreFarOff(misfit.far.size(), rows.NumRows(), SuspiciousMisfit(chain), first, misfit.first));
  }
  const std::string open = LeftOpenInWords(known, rows, prediction);
  if (!open.empty()) {
    validation->warnings.push_back(open);
    return;  // no judgement of the robot is
  }
  const double after = validation->after.distance_rms, before = validation->before.distance_rms;
  if (after > kWorse * before) validation->warnings.push_back(WorseThanNominalOnThese(after, before));
}

// RMS to expect over coordinates of points: parameters, repeatability, instrument, and with_rest what the calibration
// left on unseen points; 0 where nothing states the noise of a row.
double ExpectedRms(const Measurements& rows, const std::vector<int>& judging, const Prediction& prediction,
                   bool with_rest = false) {
  double sum = 0.0;
  int points = 0;
  for (const int k : judging) {
    if (!rows.observations[k].is_point()) continue;
    if (!IsStated(prediction.instrument[k])) return 0.0;
    sum += ExpectedSquare(prediction, k) + (with_rest ? prediction.covariances[k].model.trace() : 0.0);
    ++points;
  }
  return std::isfinite(sum) && points > 0 ? std::sqrt(sum / (3.0 * points)) : 0.0;
}

// Of the rows that judge alone.
PredictedSquares SquaresOf(const CalibrationProblem& problem, const KnownRobot& known, const std::vector<int>& judging,
                           const Prediction& prediction) {
  if (judging.size() == prediction.instrument.size()) return prediction.together;
  NoiseRoots instrument;
  for (const int k : judging) instrument.push_back(prediction.instrument[k]);
  PredictedSquares together;
  PredictionCovariances(problem, known.uncertainty, judging, known.noise.scale, instrument, &together);
  return together;
}

// That coordinates are off by `rms` and more where `expected` is predicted.
double PValueOf(const KnownRobot& known, double rms, double expected, const PredictedSquares& together) {
  if (!(expected > 0.0 && together.trace_of_square > 0.0)) return 1.0;
  const double ratio = std::pow(rms / expected, 2);
  if (!std::isfinite(ratio * together.Freedom())) return 1.0;
  const bool is_estimated = known.noise.freedom > 0.0;
  return ChanceOf(together, ratio, is_estimated ? known.noise.freedom : std::numeric_limits<double>::infinity());
}

}  // namespace

Prediction Predict(const KnownRobot& known, const Measurements& rows) {
  return PredictWith(PredictionProblem(known, rows), known);
}

std::string LeftOpenInWords(const KnownRobot& known, const Measurements& rows, const Prediction& prediction) {
  CheckAreOf(rows, prediction.covariances.size(), "LeftOpenInWords");
  double held = 0.0, rest = 0.0;
  for (size_t k = 0; k < prediction.covariances.size(); ++k) {
    if (!rows.observations[k].is_point()) continue;
    held += prediction.covariances[k].held.trace();
    rest += SquareWithoutHeld(prediction, k);
  }
  const double open = std::sqrt(held / rows.NumRows());
  if (!(held > rest) || !(open > kMatters)) return "";
  return CalibrationLeftOpen(open, known.uncertainty.held);
}

namespace {

// Of rows that have readings. `predict` does not judge an estimate, but numbers that its own rows contradict are not
// handed out without a word.
std::string ContradictedInWords(const Measurements& rows, const Prediction& prediction) {
  const std::vector<int> judging = RowsThatJudge(rows);
  const double expected = ExpectedRms(rows, judging, prediction);
  if (PointsAreZero(rows) || !(expected > 0.0)) return "";
  const double off = MeasureReadings(rows, judging, prediction.points(Eigen::all, judging)).rms;
  return off > std::max(kMatters, kContradicted * expected) ? ReadingsContradict(off, off / expected) : "";
}

}  // namespace

std::vector<std::string> WarningsOf(const KnownRobot& known, const Measurements& rows, const Prediction& prediction) {
  CheckAreOf(rows, prediction.covariances.size(), "WarningsOf");
  std::vector<std::string> warnings;
  for (const std::string& words : {ContradictedInWords(rows, prediction), LeftOpenInWords(known, rows, prediction),
                                   OutsideMeasuredInWords(known, rows.configurations), MemoryInWords(known)}) {
    if (!words.empty()) warnings.push_back(words);
  }
  warnings.insert(warnings.end(), prediction.beyond.begin(), prediction.beyond.end());
  return warnings;
}

std::optional<Finding> Contradiction(const KnownRobot& known, const Measurements& rows,
                                     const Eigen::Matrix3Xd& predicted) {
  CheckAreOf(rows, static_cast<size_t>(predicted.cols()), "Contradiction");
  const Chain& chain = known.robot.chain;
  if (!MisfitOfKnown(chain, rows, predicted).is_far) return std::nullopt;
  const CalibrationProblem problem = PredictionProblem(known, rows);
  const KnownMisfit misfit = MisfitOfKnown(chain, rows, predicted, ExpectedDistances(PredictWith(problem, known)));
  if (!misfit.is_far) return std::nullopt;
  return ExplainKnown(problem, misfit);
}

void CheckReadings(const KnownRobot& known, const Measurements& rows, const Eigen::Matrix3Xd& predicted,
                   const std::string& remedy) {
  const std::optional<Finding> found = Contradiction(known, rows, predicted);
  if (!found) return;
  throw InputError({known.file, 0, ""}, RobotDidNotMakeThese(found->words), found->remedy + "; " + remedy);
}

bool PointsAreZero(const Measurements& rows) {
  return std::all_of(rows.observations.begin(), rows.observations.end(),
                     [](const Observation& row) { return row.point_in_station.isZero(0.0); });
}

Validation Validate(const KnownRobot& known, const Measurements& rows) {
  const std::vector<int> judging = RowsThatJudge(rows);
  if (judging.empty()) {
    throw InputError({"", 0, "measurements"}, "no row has a reading that is not excluded: nothing judges the estimate");
  }
  const CalibrationProblem problem = PredictionProblem(known, rows);
  const Prediction prediction = PredictWith(problem, known);
  Validation validation;
  validation.predicted = prediction.points;
  const std::vector<int> all = AllRows(problem.data());
  const Eigen::Matrix3Xd nominal = PointsOrThrow(problem, NominalParameters(known, problem));
  for (size_t k = 0; k < all.size(); ++k) {
    validation.scatter.push_back(RootWith(prediction.instrument[k], prediction.covariances[k].arm));
  }
  validation.before = MeasureReadings(rows, judging, nominal(Eigen::all, judging));
  validation.after = MeasureReadings(rows, judging, validation.predicted(Eigen::all, judging));
  validation.predicted_rms = ExpectedRms(rows, judging, prediction);
  const PredictedSquares together = SquaresOf(problem, known, judging, prediction);
  const double rms = validation.after.rms, significance = problem.experiment().significance;
  validation.p_value = PValueOf(known, rms, validation.predicted_rms, together);
  if (validation.p_value < significance) {
    const double with_rest = ExpectedRms(rows, judging, prediction, true);
    const bool is_known = known.rest > 0.0 && PValueOf(known, rms, with_rest, together) >= significance;
    validation.refutation = RowsRefuteTheEstimate(rms, rms / validation.predicted_rms, validation.p_value,
                                                  is_known ? known.rest : 0.0, RememberingEffects(known));
  }
  validation.warnings = rows.warnings;
  const std::string outside = OutsideMeasuredInWords(known, rows.configurations);
  if (!outside.empty()) validation.warnings.push_back(outside);
  validation.warnings.insert(validation.warnings.end(), prediction.beyond.begin(), prediction.beyond.end());
  const std::string memory = MemoryInWords(known);
  if (!memory.empty()) validation.warnings.push_back(memory);
  JudgeErrors(known, rows, prediction, &validation);
  for (const MeasurementFile& file : rows.files) {
    const auto& seen = known.input_hashes;
    if (std::find(seen.begin(), seen.end(), file.sha256) == seen.end()) continue;
    validation.warnings.push_back(InputOfTheEstimate(file.path));
  }
  return validation;
}

nlohmann::ordered_json ValidationToJson(const Validation& validation, const Provenance& provenance) {
  nlohmann::ordered_json json = {{"schema", "sagitta/validation/1"},
                                 {"version", SAGITTA_VERSION},
                                 {"command", provenance.command},
                                 {"run", RunId(provenance)}};
  json["inputs"] = nlohmann::ordered_json::array();
  for (const InputFile& input : provenance.inputs)
    json["inputs"].push_back({{"file", input.path}, {"sha256", input.sha256}});
  json["validation"] = {{"observations", validation.after.observations}};
  json["validation"].update(SizeToJson(validation.after));
  json["validation"]["before"] = SizeToJson(validation.before);
  const auto predicted = [&](double figure) {
    return validation.predicted_rms > 0.0 ? nlohmann::ordered_json(figure) : nlohmann::ordered_json(nullptr);
  };
  json["validation"]["predicted_rms_mm"] = predicted(1e3 * validation.predicted_rms);
  json["validation"]["prediction_p_value"] = predicted(validation.p_value);
  json["validation"]["excess"] = predicted(validation.after.rms / validation.predicted_rms);
  json["validation"]["refuted"] = !validation.refutation.empty();
  std::vector<std::string> warnings = validation.warnings;
  if (!validation.refutation.empty()) warnings.insert(warnings.begin(), validation.refutation);
  if (!validation.contradiction.empty()) warnings.insert(warnings.begin(), validation.contradiction);
  json["warnings"] = warnings;
  return json;
}

std::string ValidationToCsv(const Measurements& rows, const Validation& validation) {
  CheckAreOf(rows, validation.scatter.size(), "ValidationToCsv");
  std::vector<AddedColumn> added = ReadingColumns("pred_", rows, validation.predicted);
  for (const AddedColumn& column : ResidualColumns(rows, validation.predicted)) added.push_back(column);
  for (const AddedColumn& column : WhitenedColumns(rows, validation.predicted, validation.scatter))
    added.push_back(column);
  const size_t count = rows.observations.size();
  added.push_back({"leverage", std::vector<std::string>(count, "0")});  // none of them was fitted
  added.push_back({"set", std::vector<std::string>(count, "validation")});
  return RowsToCsv(rows, added);
}

}  // namespace sagitta

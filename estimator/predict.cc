#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "estimator/calibration/load_remedy.h"
#include "estimator/results/residuals_csv.h"
#include "estimator/sagitta.h"
#include "problems/failure.h"

namespace sagitta {
namespace {

std::vector<int> AllRows(const CalibrationProblem& problem) {
  std::vector<int> all(problem.data().observations.size());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

Eigen::Matrix3Xd PointsOrThrow(const CalibrationProblem& problem, const ParameterSet& parameters) {
  const Eigen::Matrix3Xd points = PredictPoints(problem, parameters, AllRows(problem));
  if (!points.allFinite()) {
    throw Failure("nothing predicted: equilibrium_diverged: " + FoldedInWords(problem, parameters));
  }
  return points;
}

Prediction PredictWith(const CalibrationProblem& problem, const KnownRobot& known) {
  const std::vector<int> all = AllRows(problem);
  Prediction prediction;
  prediction.points = PointsOrThrow(problem, problem.parameters);
  prediction.covariances = PredictionCovariances(problem, known.uncertainty, all, known.noise.scale);
  for (const int k : all) prediction.instrument.push_back(known.noise.scale * problem.SqrtCovariance(k));
  return prediction;
}

// RMS to expect over coordinates of points: parameters, repeatability, instrument; 0 where nothing states the noise of
// a row.
double ExpectedRms(const Measurements& rows, const Prediction& prediction) {
  double sum = 0.0;
  for (size_t k = 0; k < prediction.instrument.size(); ++k) {
    if (!rows.observations[k].is_point()) continue;
    if (!IsStated(prediction.instrument[k])) return 0.0;
    sum += prediction.covariances[k].mean().trace() + prediction.covariances[k].arm.trace() +
           prediction.instrument[k].squaredNorm();
  }
  return std::isfinite(sum) ? std::sqrt(sum / (3.0 * rows.NumRows())) : 0.0;
}

}  // namespace

Prediction Predict(const KnownRobot& known, const Measurements& rows) {
  return PredictWith(PredictionProblem(known, rows), known);
}

Validation Validate(const KnownRobot& known, const Measurements& rows) {
  const CalibrationProblem problem = PredictionProblem(known, rows);
  const Prediction prediction = PredictWith(problem, known);
  Validation validation;
  validation.predicted = prediction.points;
  const std::vector<int> all = AllRows(problem);
  const Eigen::Matrix3Xd nominal = PointsOrThrow(problem, NominalParameters(known, problem));
  validation.before = MeasureReadings(rows, all, nominal);
  validation.after = MeasureReadings(rows, all, validation.predicted);
  validation.predicted_rms = ExpectedRms(rows, prediction);
  validation.warnings = rows.warnings;
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
  json["validation"]["predicted_rms_mm"] = validation.predicted_rms > 0.0
                                               ? nlohmann::ordered_json(1e3 * validation.predicted_rms)
                                               : nlohmann::ordered_json(nullptr);
  json["warnings"] = validation.warnings;
  return json;
}

std::string ValidationToCsv(const Measurements& rows, const Validation& validation) {
  std::vector<AddedColumn> added = ReadingColumns("pred_", rows, validation.predicted);
  for (const AddedColumn& column : ResidualColumns(rows, validation.predicted)) added.push_back(column);
  return RowsToCsv(rows, added);
}

}  // namespace sagitta

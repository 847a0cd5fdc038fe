#include "tools/problem_from_arguments.h"

#include <gflags/gflags.h>

#include "estimator/calibration/unit_guess.h"
#include "estimator/sagitta.h"
#include "problems/input_error.h"
#include "problems/io/effect_names.h"
#include "problems/range.h"
#include "problems/significance.h"
#include "tools/command_line.h"

DEFINE_double(sigma_mm, 0.0, "standard deviation of every coordinate; replaces those of the rows");
DEFINE_double(holdout, 0.0, "fraction of the configurations kept for validation");
DEFINE_string(validation, "", "COLUMN=VALUE[,VALUE]: rows kept for validation; none: hold nothing out");
DEFINE_string(load_point_mm, "", "x,y,z where loads act, flange frame");
DEFINE_string(free, "", "NAME,…: parameters to estimate in addition");
DEFINE_string(fixed, "", "NAME,…: parameters held at their file or nominal value");
DEFINE_string(method, "joint", "joint, two-step, two-step-literal, two-step-relinearised, full-pose or differencing");
DEFINE_bool(force, false, "go on where the nominal robot cannot have made these readings");
DEFINE_double(significance, sagitta::kDefaultSignificance, "level of every test");

namespace sagitta {

namespace {

void ApplyNoiseFlags(Experiment* experiment) {
  if (!IsGiven("sigma_mm")) return;
  CheckIn(allowed::kSigma, FLAGS_sigma_mm / 1e3, "--sigma_mm");
  experiment->noise.from = NoiseSpec::From::kSigma;
  experiment->noise.sigma = FLAGS_sigma_mm / 1e3;
  experiment->noise.replaces_rows = true;
}

ValidationSpec FractionHeldOut(double fraction) {
  CheckIn(allowed::kFraction, fraction, "--holdout");
  ValidationSpec spec;
  spec.kind = ValidationSpec::Kind::kFraction;
  spec.fraction = fraction;
  return spec;
}

// rows: COLUMN=VALUE[,VALUE] or none.
ValidationSpec HeldOut(const std::string& rows) {
  ValidationSpec spec;
  spec.kind = ValidationSpec::Kind::kNone;
  if (rows == "none") return spec;
  const size_t equals = rows.find('=');
  if (equals == 0 || equals == std::string::npos || equals + 1 == rows.size()) {
    throw InputError({"", 0, "--validation"}, "'" + rows + "' does not say which rows",
                     "--validation=COLUMN=VALUE, for example --validation=group=random, or none");
  }
  spec.kind = ValidationSpec::Kind::kColumn;
  spec.column = rows.substr(0, equals);
  spec.values = SplitText(rows.substr(equals + 1), ',');
  return spec;
}

void ApplyValidationFlags(Experiment* experiment) {
  if (IsGiven("holdout") && IsGiven("validation")) {
    throw InputError({"", 0, "--holdout"}, "--holdout and --validation exclude each other");
  }
  if (IsGiven("holdout")) experiment->validation = FractionHeldOut(FLAGS_holdout);
  if (IsGiven("validation")) experiment->validation = HeldOut(FLAGS_validation);
  if (IsGiven("holdout") || IsGiven("seed")) experiment->validation.seed = FLAGS_seed;
}

void ApplyEstimateFlags(Experiment* experiment) {
  if (IsGiven("free")) experiment->estimate.free = SplitOutsideBrackets(FLAGS_free);
  if (IsGiven("fixed")) experiment->estimate.fixed = SplitOutsideBrackets(FLAGS_fixed);
  if (IsGiven("load_point_mm")) experiment->load_point = LoadPointOfFlag(FLAGS_load_point_mm);
  if (!IsGiven("significance")) return;
  CheckIn(allowed::kLevel, FLAGS_significance, "--significance");
  experiment->significance = FLAGS_significance;
}

}  // namespace

Vector3<double> LoadPointOfFlag(const std::string& x_y_z) {
  const std::vector<double> point = NumbersOfFlag("load_point_mm", x_y_z);
  if (point.size() != 3) throw InputError({"", 0, "--load_point_mm"}, "three numbers are expected: x,y,z");
  for (const double x_mm : point) CheckIn(allowed::kCoordinate, x_mm / 1e3, "--load_point_mm");
  return Vector3<double>(point[0], point[1], point[2]) / 1e3;
}

std::vector<std::string> WithProblemFlags(std::vector<std::string> flags) {
  for (const char* flag : {"sigma_mm", "holdout", "validation", "free", "fixed", "load_point_mm", "significance",
                           "force", "out", "seed", "threads", "quiet", "verbose"}) {
    flags.push_back(flag);
  }
  return flags;
}

ExperimentInputs ReadInputs(const std::vector<std::string>& paths) {
  MeasurementReadOptions options;
  options.row_sigmas_used = !IsGiven("sigma_mm");
  return ReadExperimentInputs(paths, options);
}

CalibrationProblem ProblemAsStated(ExperimentInputs inputs) {
  ApplyNoiseFlags(&inputs.experiment);
  ApplyValidationFlags(&inputs.experiment);
  ApplyEstimateFlags(&inputs.experiment);
  return MakeCalibrationProblem(std::move(inputs.robot), std::move(inputs.data), std::move(inputs.experiment));
}

CalibrationProblem ProblemFromInputs(ExperimentInputs inputs) {
  CalibrationProblem problem = ProblemAsStated(std::move(inputs));
  CheckUnits(problem, AlignedSample(problem));
  return problem;
}

CalibrationProblem PlausibleProblem(ExperimentInputs inputs) {
  if (FLAGS_force) return ProblemAsStated(std::move(inputs));
  CalibrationProblem problem = ProblemAsStated(std::move(inputs));
  CheckReadings(problem, "--force goes on as stated");
  return problem;
}

}  // namespace sagitta

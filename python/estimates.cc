// calibrate, and what is done with an estimate: predict, validate, simulate, compensate.
#include <pybind11/stl.h>

#include <memory>
#include <numeric>

#include "estimator/changes/changes.h"
#include "estimator/estimate/parameter_table.h"
#include "estimator/report/compensation_words.h"
#include "estimator/report/results_words.h"
#include "estimator/results/measured_conditions.h"
#include "estimator/results/measured_joints.h"
#include "estimator/results/program_compensation.h"
#include "estimator/results/residuals_csv.h"
#include "problems/failure.h"
#include "problems/io/files.h"
#include "problems/io/output_files.h"
#include "problems/range.h"
#include "python/inputs.h"
#include "python/interruptible.h"
#include "tools/report/calibration_report.h"
#include "tools/report/validation_report.h"

namespace sagitta::python {

namespace py = pybind11;

namespace {

struct CalibratedExperiment {
  Calibration calibration;
  Provenance provenance;

  std::string Json() const { return DumpJson(CalibrationToJson(calibration, provenance)); }
  std::string ReportHtml() const { return CalibrationToHtml(calibration, provenance); }
  std::string RobotYaml() const { return RobotToYaml(calibration.problem.RobotWith(calibration.estimate.parameters)); }
  // The files of `sagitta calibrate`, all or none.
  void Write(const std::string& folder) const {
    const std::vector<NamedText> files = {{"robot.calibrated.yaml", RunComment(provenance) + RobotYaml()},
                                          {"report.html", ReportHtml()},
                                          {"estimate.json", Json()}};
    const std::vector<std::string> names = {"robot.calibrated.yaml", "residuals.csv", "report.html", "estimate.json"};
    CheckInputsAreKept(calibration.problem.InputPaths(), folder, names);
    OutputFolder(folder, names).Write(files, {ResidualsFile(calibration.problem, calibration.estimate)});
  }
};

// What was said, and the model error that figures of this estimate carry, where there is any: what commands print.
std::vector<std::string> WithModelError(std::vector<std::string> warnings, const KnownRobot& known) {
  const std::string words = WhatFiguresCarry(known);
  if (!words.empty()) warnings.push_back(words);
  return warnings;
}

// The same of corrected targets, after the way to them.
std::vector<std::string> WarningsOfTargets(std::vector<std::string> warnings, const KnownRobot& known) {
  const std::string words = WhatTheWayDoes(known);
  if (!words.empty()) warnings.insert(warnings.begin(), words);
  return WithModelError(std::move(warnings), known);
}

struct PredictedRows {
  Measurements rows;
  Prediction prediction;
  std::vector<std::string> warnings;
};

struct ValidatedRows {
  KnownRobot known;
  Measurements rows;
  Validation validation;
  Provenance provenance;

  std::string ReportHtml() const { return ValidationToHtml(known, rows, validation, provenance); }
};

struct CompensatedRows {
  Targets targets;
  std::vector<CompensatedTarget> results;
  std::vector<std::string> warnings;
};

std::shared_ptr<CalibratedExperiment> CalibrateInputs(const ExperimentInputs& inputs, const std::string& method,
                                                      int threads, std::uint64_t seed, bool force,
                                                      const std::string& command, const py::object& progress) {
  CheckIn(allowed::kThreads, threads, "threads");
  Calibration calibration = ResultOf<Calibration>(progress, [&](const Say& say) {
    return Calibrate(ProblemOf(inputs, force), {MethodNamed(method, "method"), threads, seed, say});
  });
  const Estimate& estimate = calibration.estimate;
  if (!IsUsable(estimate.status)) {
    std::string message = estimate.message;
    for (const Direction& d : estimate.identifiability.unidentifiable) message += "; " + d.words + ": " + d.remedy;
    throw NumericalFailure(StatusName(estimate.status), message);
  }
  return std::make_shared<CalibratedExperiment>(
      CalibratedExperiment{std::move(calibration), {command, method, inputs.files}});
}

py::array LeverageOf(const py::object& self) {
  const auto& c = py::cast<const CalibratedExperiment&>(self).calibration;
  const Eigen::VectorXd& leverage = c.estimate.leverage;
  if (leverage.size() != c.problem.data().NumRows()) {
    const std::vector<double> of_rows = LeverageOfRows(c.problem.data(), c.estimate);
    const Eigen::Map<const Eigen::RowVectorXd> row(of_rows.data(), leverage.size());
    return PointsOf(c.problem.data(), row.replicate(3, 1), self).attr("__getitem__")(py::make_tuple(py::ellipsis(), 0));
  }
  py::array_t<double> view(leverage.size(), leverage.data(), self);
  view.attr("setflags")(py::arg("write") = false);
  return std::move(view);
}

void BindEstimate(py::module_& module) {
  const auto of = [](const py::object& self) -> const Calibration& {
    return py::cast<const CalibratedExperiment&>(self).calibration;
  };
  py::class_<CalibratedExperiment, std::shared_ptr<CalibratedExperiment>>(module, "Estimate")
      .def_property_readonly("covariance_si",
                             [of](const py::object& self) { return ViewOf(of(self).estimate.covariance, self); })
      .def_property_readonly(
          "predicted_m",
          [of](const py::object& self) { return PointsOf(of(self).problem.data(), of(self).estimate.predicted, self); })
      .def_property_readonly("whitened",
                             [of](const py::object& self) {
                               const Eigen::Matrix3Xd all = WhitenedResiduals(of(self).problem, of(self).estimate);
                               return PointsOf(of(self).problem.data(), all, self).attr("copy")();
                             })
      .def_property_readonly("leverage", &LeverageOf)
      .def_property_readonly("rows", [](const CalibratedExperiment& e) { return Rows{e.calibration.problem.data()}; })
      .def("json", &CalibratedExperiment::Json)
      .def("residuals_csv",
           [](const CalibratedExperiment& e) { return ResidualsToCsv(e.calibration.problem, e.calibration.estimate); })
      .def("robot_yaml", &CalibratedExperiment::RobotYaml)
      .def("report_html", &CalibratedExperiment::ReportHtml)
      .def("write", &CalibratedExperiment::Write)
      .def("known", [](const CalibratedExperiment& e) {
        return std::make_shared<KnownRobot>(ReadEstimateText(e.Json(), "estimate"));
      });
}

// Readings and what moves them, SI: measured - predicted, and d predicted / d parameter.
struct LinearizedRows {
  std::vector<std::string> names;  // of the columns
  Eigen::MatrixXd jacobian;        // one column per coordinate of a reading, one row per name
  Eigen::MatrixXd residuals;       // one row; not a number where nothing was measured
  std::vector<int> rows;           // of each coordinate: which reading it is of
  std::vector<bool> turns;         // whether it is an angle, rad, and no length
};

// Points count; the rotation of a pose is of the row of its point.
std::vector<int> RowsOfObservations(const Measurements& data) {
  std::vector<int> row_of(data.observations.size(), -1);
  int rows = 0;
  for (size_t k = 0; k < row_of.size(); ++k) {
    if (data.observations[k].is_point()) row_of[k] = rows++;
  }
  for (size_t k = 0; k < row_of.size(); ++k) {
    const int partner = data.observations[k].partner;
    if (!data.observations[k].is_point() && partner >= 0) row_of[k] = row_of[static_cast<size_t>(partner)];
  }
  return row_of;
}

// Columns of names that the problem does not have, as of other stations and markers, are 0.
LinearizedRows LinearizedAt(const CalibrationProblem& problem, const ParameterSet& parameters,
                            const std::vector<int>& observations, const std::vector<std::string>& names,
                            bool is_whitened) {
  std::vector<int> columns, places;
  for (size_t i = 0; i < names.size(); ++i) {
    const int column = parameters.FindCoordinate(names[i]);
    if (column < 0) continue;
    columns.push_back(column);
    places.push_back(static_cast<int>(i));
  }
  const NoiseRoots roots = is_whitened ? ObservationNoise(problem, observations, kFallbackSigma)
                                       : NoiseRoots(observations.size(), Matrix3<double>::Identity());
  const Linearization found = Linearize(problem, parameters, observations, columns, roots,
                                        is_whitened ? LatentTreatment::kMarginalise : LatentTreatment::kIgnore);
  if (!found.valid) throw Failure("nothing linearized: equilibrium_diverged: " + LoadFoldsArm());
  LinearizedRows result;
  result.names = names;
  result.jacobian = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(names.size()), found.num_rows());
  for (size_t i = 0; i < columns.size(); ++i) {
    result.jacobian.row(places[i]) = found.jacobian.col(static_cast<Eigen::Index>(i)).transpose();
  }
  result.residuals = -found.residual.transpose();
  const std::vector<int> row_of = RowsOfObservations(problem.data());
  for (const int k : found.observations) {
    result.rows.insert(result.rows.end(), 3, row_of[static_cast<size_t>(k)]);
    result.turns.insert(result.turns.end(), 3, !problem.data().observations[static_cast<size_t>(k)].is_point());
  }
  return result;
}

LinearizedRows LinearizeFit(const CalibratedExperiment& e, bool is_whitened) {
  const CalibrationProblem& problem = e.calibration.problem;
  const ParameterSet& parameters = e.calibration.estimate.parameters;
  std::vector<std::string> names;
  for (const int c : parameters.EstimatedCoordinates()) names.push_back(parameters.coordinates()[c].name);
  const OthersMayRun others_may_run;
  LinearizedRows rows = Numerically(
      [&] { return LinearizedAt(problem, parameters, problem.CalibrationObservations(), names, is_whitened); });
  // By the noise that the covariance goes by.
  const double noise = AppliedNoise(e.calibration.estimate.sigma);
  if (!is_whitened || !(noise > 0.0)) return rows;
  rows.jacobian /= noise;
  rows.residuals /= noise;
  return rows;
}

LinearizedRows LinearizeRows(const KnownRobot& known, const py::list& sources) {
  Measurements rows = RowsFrom(known.robot, sources, false, nullptr);
  AddKnownRotations(known, &rows);
  const OthersMayRun others_may_run;
  return Numerically([&] {
    const CalibrationProblem problem = PredictionProblem(known, std::move(rows));
    std::vector<int> all(problem.data().observations.size());
    std::iota(all.begin(), all.end(), 0);
    return LinearizedAt(problem, problem.parameters, all, known.uncertainty.estimated, false);
  });
}

void BindLinearization(py::module_& module) {
  py::class_<LinearizedRows>(module, "Linearization")
      .def_property_readonly(
          "jacobian",
          [](const py::object& self) { return ViewOf(py::cast<const LinearizedRows&>(self).jacobian, self); })
      .def_property_readonly(
          "residuals",
          [](const py::object& self) { return ViewOf(py::cast<const LinearizedRows&>(self).residuals, self); })
      .def_readonly("names", &LinearizedRows::names)
      .def_readonly("rows", &LinearizedRows::rows)
      .def_readonly("turns", &LinearizedRows::turns);
  module.def("linearize", &LinearizeRows);
  module.def("linearize_fit", &LinearizeFit);
}

PredictedRows PredictRows(const KnownRobot& known, const py::list& sources, bool force) {
  PredictedRows result{RowsFrom(known.robot, sources, false, nullptr), {}, {}};
  AddKnownRotations(known, &result.rows);
  const OthersMayRun others_may_run;
  result.prediction = Numerically([&] { return Predict(known, result.rows); });
  if (!force && !PointsAreZero(result.rows)) CheckReadings(known, result.rows, result.prediction.points, kForce);
  result.warnings = WithModelError(WarningsOf(known, result.rows, result.prediction), known);
  return result;
}

py::array_t<double> CovariancesOf(const PredictedRows& p) {
  py::array_t<double> all({static_cast<py::ssize_t>(p.rows.NumRows()), py::ssize_t{3}, py::ssize_t{3}});
  auto at = all.mutable_unchecked<3>();
  py::ssize_t row = 0;
  for (size_t k = 0; k < p.prediction.covariances.size(); ++k) {
    if (!p.rows.observations[k].is_point()) continue;
    const Matrix3<double> mean = p.prediction.covariances[k].mean();
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) at(row, i, j) = mean(i, j);
    }
    ++row;
  }
  return all;
}

void BindPrediction(py::module_& module) {
  py::class_<PredictedRows>(module, "Prediction")
      .def_property_readonly("points_m",
                             [](const py::object& self) {
                               const auto& p = py::cast<const PredictedRows&>(self);
                               return PointsOf(p.rows, p.prediction.points, self);
                             })
      .def_property_readonly("covariance_m2", &CovariancesOf)
      .def_readonly("warnings", &PredictedRows::warnings)
      .def("csv", [](const PredictedRows& p) { return PredictionToCsv(p.rows, p.prediction); });
  py::class_<ValidatedRows>(module, "Validation")
      .def_property_readonly("predicted_m",
                             [](const py::object& self) {
                               const auto& v = py::cast<const ValidatedRows&>(self);
                               return PointsOf(v.rows, v.validation.predicted, self);
                             })
      .def("with_model_error",
           [](const ValidatedRows& v, std::vector<std::string> warnings) { return WithModelError(warnings, v.known); })
      .def("report_html", &ValidatedRows::ReportHtml)
      .def("csv", [](const ValidatedRows& v) { return ValidationToCsv(v.rows, v.validation); })
      .def("json", [](const ValidatedRows& v) { return DumpJson(ValidationToJson(v.validation, v.provenance)); });
}

ValidatedRows ValidateRows(const KnownRobot& known, const py::list& sources, bool force) {
  ValidatedRows result;
  result.known = known;
  result.provenance = {"sagitta.validate", "validation", {}};
  result.rows = RowsFrom(known.robot, sources, true, &result.provenance.inputs);
  const OthersMayRun others_may_run;
  result.validation = Numerically([&] { return Validate(known, result.rows); });
  if (!force) CheckReadings(known, result.rows, result.validation.predicted, kForce);
  return result;
}

Rows SimulateRows(const KnownRobot& truth, const ExperimentInputs& inputs, const std::optional<double>& sigma_mm,
                  std::uint64_t seed) {
  SimulateOptions options;
  if (sigma_mm) {
    CheckIn(allowed::kSigmaOrZero, *sigma_mm / 1e3, "sigma_mm");
    options.sigma = *sigma_mm / 1e3;
  }
  options.seed = seed;
  const OthersMayRun others_may_run;
  return {Numerically([&] { return Simulate(truth, inputs.data, inputs.experiment, options); })};
}

CompensatedRows CompensateTargets(const KnownRobot& known, const py::object& source, int threads) {
  CompensatedRows rows;
  const std::string station = StationOfTargets(known);
  rows.targets = py::isinstance<py::str>(source) ? ReadTargets(py::cast<std::string>(source), known.robot, station)
                                                 : TargetsFromTable(TableFrom(source, nullptr), known.robot, station);
  const CompensationInput input = MakeCompensationInput(known, rows.targets);
  rows.results = ResultOf<std::vector<CompensatedTarget>>(
      py::none(), [&](const Say&) { return Compensate(input, rows.targets.rows, threads); });
  const size_t outside = AddOutsideMeasured(known, &rows.results);
  if (rows.targets.may_be_no_vector) rows.warnings.push_back(TargetsHaveRotationVectors());
  if (outside > 0) rows.warnings.push_back(TargetsOutsideMeasured(outside));
  const std::vector<std::string> beyond = BeyondMeasuredInWords(known, input.problem);
  rows.warnings.insert(rows.warnings.end(), beyond.begin(), beyond.end());
  rows.warnings = WarningsOfTargets(std::move(rows.warnings), known);
  return rows;
}

// Corrected joint values, rad and m; not a number where no equilibrium was found.
py::array_t<double> CommandedJoints(const CompensatedRows& rows) {
  const auto n = static_cast<py::ssize_t>(rows.results.size());
  const auto joints = static_cast<py::ssize_t>(rows.targets.joint_types.size());
  py::array_t<double> values({n, joints});
  auto at = values.mutable_unchecked<2>();
  for (py::ssize_t i = 0; i < n; ++i) {
    const FlangeSolution& s = rows.results[static_cast<size_t>(i)].solution;
    for (py::ssize_t j = 0; j < joints; ++j) {
      at(i, j) = s.status == TargetStatus::kEquilibriumDiverged ? std::nan("") : s.q[j];
    }
  }
  return values;
}

void BindCompensation(py::module_& module) {
  py::class_<CompensatedRows>(module, "Compensation")
      .def_property_readonly("status",
                             [](const CompensatedRows& rows) {
                               std::vector<std::string> names;
                               for (const CompensatedTarget& r : rows.results)
                                 names.push_back(StatusName(r.solution.status));
                               return names;
                             })
      .def_property_readonly("joint_values", &CommandedJoints)
      .def_readonly("warnings", &CompensatedRows::warnings)
      .def("csv", [](const CompensatedRows& rows) { return CompensationToCsv(rows.targets, rows.results); });
}

struct CorrectedProgram : CompensatedProgram {
  std::vector<std::string> warnings;
};

CorrectedProgram CompensateProgramOf(const KnownRobot& known, const std::string& program, const std::string& tools,
                                     const std::string& frames, const std::vector<double>& start_deg,
                                     const std::string& load, const std::string& loads,
                                     const std::vector<double>& turn_joints, int threads) {
  const Chain& chain = known.robot.chain;
  CheckProgramLoad(known, load, "load");
  ProgramScene scene;
  scene.tools = FramesFromText(tools, "tools_mm_deg");
  scene.frames = FramesFromText(frames, "frames_mm_deg");
  scene.start = StartFrom(start_deg, chain, "start_deg");
  scene.load = load;
  scene.loads = LoadsFromText(loads, "loads_kg_mm");
  scene.turn_joints = TurnJointsFrom(turn_joints, chain.num_joints(), "turn_joints");
  CorrectedProgram corrected;
  static_cast<CompensatedProgram&>(corrected) = ResultOf<CompensatedProgram>(py::none(), [&](const Say&) {
    return CompensateProgram(known, ReadRobotProgram(program, chain.num_joints()), scene, threads);
  });
  corrected.warnings = WarningsOfTargets(corrected.beyond, known);
  return corrected;
}

void BindPrograms(py::module_& module) {
  py::class_<CorrectedProgram>(module, "Program")
      .def_property_readonly("text", [](const CorrectedProgram& p) { return py::bytes(p.text); })
      .def_readonly("warnings", &CorrectedProgram::warnings)
      .def_property_readonly("summary", [](const CorrectedProgram& p) { return SummaryOf(p); })
      .def_property_readonly("points",
                             [](const CorrectedProgram& p) {
                               py::list points;
                               for (const ProgramPointResult& result : p.results) {
                                 const ProgramPoint& point = p.program.points[static_cast<size_t>(result.point)];
                                 points.append(py::make_tuple(point.name, point.line, result.untouched));
                               }
                               return points;
                             })
      .def("csv",
           [](const CorrectedProgram& p) {
             return p.solved.empty() ? std::string() : CompensationToCsv(p.targets, p.solved);
           })
      .def("write", [](const CorrectedProgram& p, const std::string& path) {
        CheckProgramIsKept(p.program.path, path, "path");
        OutputFile(path).Write(p.text);
      });
  module.def("compensate_program", &CompensateProgramOf);
  py::class_<Changes>(module, "Changes").def("json", [](const Changes& c) { return DumpJson(ChangesToJson(c)); });
  module.def("changed", [](const KnownRobot& before, const KnownRobot& after) {
    const OthersMayRun others_may_run;
    return FindChanges(before, after);
  });
}

}  // namespace

void BindEstimates(py::module_& module) {
  py::class_<KnownRobot, std::shared_ptr<KnownRobot>>(module, "Known")
      .def_property_readonly("robot_name", [](const KnownRobot& k) { return k.robot.name; })
      .def_property_readonly("robot_yaml", [](const KnownRobot& k) { return RobotToYaml(k.robot); });
  BindEstimate(module);
  BindLinearization(module);
  BindPrediction(module);
  BindCompensation(module);
  BindPrograms(module);
  module.def("calibrate", &CalibrateInputs);
  module.def("load", [](const std::string& path) { return std::make_shared<KnownRobot>(ReadEstimateFile(path)); });
  // The truth that an experiment states; the loads of rows are those of the experiment.
  module.def("truth_of", [](const ExperimentInputs& inputs) {
    return std::make_shared<KnownRobot>(KnownFrom(inputs.experiment.file, inputs.robot, inputs.experiment));
  });
  module.def("with_loads_of", [](const KnownRobot& known, const ExperimentInputs& inputs) {
    auto truth = std::make_shared<KnownRobot>(known);
    if (inputs.experiment.file.empty()) return truth;
    truth->loading = inputs.experiment;
    truth->loading.origins = known.loading.origins;
    return truth;
  });
  module.def("predict", &PredictRows);
  module.def("validate", &ValidateRows);
  module.def("simulate", &SimulateRows);
  module.def("compensate", &CompensateTargets);
}

}  // namespace sagitta::python

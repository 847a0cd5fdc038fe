// diagnose, plan and inspect.
#include <pybind11/stl.h>

#include <memory>
#include <optional>

#include "estimator/diagnosis/learnt_model.h"
#include "estimator/inspection/inspect.h"
#include "estimator/results/diagnosis_json.h"
#include "estimator/results/inspection_json.h"
#include "estimator/results/next_campaign.h"
#include "estimator/results/plan_json.h"
#include "problems/io/cell_file.h"
#include "problems/io/effect_names.h"
#include "problems/io/files.h"
#include "problems/io/measurement_file.h"
#include "problems/io/output_files.h"
#include "problems/range.h"
#include "python/inputs.h"
#include "python/interruptible.h"
#include "tools/report/diagnosis_report.h"
#include "tools/report/inspection_report.h"
#include "tools/report/plan_report.h"

namespace sagitta::python {

namespace py = pybind11;

namespace {

struct DiagnosedExperiment {
  Diagnosis diagnosis;
  double significance = 0.01;
  Provenance provenance;

  std::string ReportHtml() const { return DiagnosisToHtml(diagnosis, ExtendedCalibration(diagnosis), provenance); }
  // Of the estimate.json of `sagitta diagnose`.
  KnownRobot Known() const {
    return ReadEstimateText(DumpJson(CalibrationToJson(ExtendedCalibration(diagnosis), provenance)), "diagnosis");
  }
};

struct PlannedExperiment {
  Plan plan;
  Robot robot;
  std::optional<Cell> cell;
  Provenance provenance;

  std::string ReportHtml() const { return PlanReportToHtml(robot, cell ? &*cell : nullptr, plan, provenance); }
};

struct InspectedExperiment {
  CalibrationProblem problem;
  Inspection inspection;
  Provenance provenance;

  std::string Json() const { return DumpJson(InspectionToJson(problem, inspection, provenance)); }
  std::string ReportHtml() const { return InspectionToHtml(problem, inspection, provenance); }
};

std::shared_ptr<InspectedExperiment> InspectInputs(const ExperimentInputs& inputs, const std::string& command,
                                                   const py::object& progress) {
  CalibrationProblem problem = MakeCalibrationProblem(inputs.robot, inputs.data, inputs.experiment);
  Inspection inspection = ResultOf<Inspection>(progress, [&](const Say& say) { return Inspect(problem, say); });
  return std::make_shared<InspectedExperiment>(
      InspectedExperiment{std::move(problem), std::move(inspection), {command, "inspection", inputs.files}});
}

std::shared_ptr<DiagnosedExperiment> DiagnoseInputs(ExperimentInputs inputs, int threads, bool force,
                                                    const std::string& command, const py::object& progress) {
  CheckIn(allowed::kThreads, threads, "threads");
  HoldOutForDiagnosis(inputs.data, &inputs.experiment);
  Diagnosis diagnosis = ResultOf<Diagnosis>(progress, [&](const Say& say) {
    DiagnosisOptions options;
    options.significance = inputs.experiment.significance;
    options.prior = inputs.prior;
    options.joint.num_threads = threads;
    options.progress = say;
    return Diagnose(ProblemOf(inputs, force), options);
  });
  if (!IsUsable(diagnosis.status)) {
    throw NumericalFailure(StatusName(diagnosis.status), "the believed model does not fit: " + diagnosis.message);
  }
  return std::make_shared<DiagnosedExperiment>(
      DiagnosedExperiment{std::move(diagnosis), inputs.experiment.significance, {command, "joint", inputs.files}});
}

// As plan.csv states them. Those that a plan was made of have the readings that are expected, of no measurement.
Rows RowsOf(const PlannedExperiment& planned) {
  MeasurementReadOptions options;
  options.points_required = false;
  return {ReadMeasurementsText(planned.robot, PlanToCsv(planned.robot.chain, planned.plan), "plan", options)};
}

std::shared_ptr<PlannedExperiment> PlanInputs(const ExperimentInputs& inputs, const py::dict& wishes,
                                              const std::string& command, const py::object& progress) {
  PlanRequest request;
  if (const auto poses = py::cast<std::optional<int>>(wishes["poses"])) {
    CheckIn(allowed::kPoses, *poses, "poses");
    request.poses = *poses;
  }
  if (const auto accuracy_mm = py::cast<std::optional<double>>(wishes["accuracy_mm"])) {
    CheckIn(allowed::kAccuracy, *accuracy_mm / 1e3, "accuracy_mm");
    request.accuracy = *accuracy_mm / 1e3;
  }
  CheckIn(allowed::kPool, py::cast<int>(wishes["pool"]), "pool");
  request.augment = py::cast<bool>(wishes["augment"]);
  request.criterion = CriterionNamed(py::cast<std::string>(wishes["criterion"]), "criterion");
  request.discriminate = RivalEffects(inputs.robot, py::cast<std::string>(wishes["discriminate"]), "discriminate");
  request.pool = py::cast<int>(wishes["pool"]);
  request.seed = py::cast<std::uint64_t>(wishes["seed"]);
  request.random_tests = py::cast<bool>(wishes["random_tests"]);
  const auto rows_of = [&](const char* key) -> std::optional<Measurements> {
    const auto sources = py::cast<py::list>(wishes[key]);
    if (sources.empty()) return std::nullopt;
    return RowsFrom(inputs.robot, sources, false, nullptr);
  };
  const std::optional<Measurements> candidates = rows_of("candidates"), tests = rows_of("tests");
  request.candidates = candidates ? &*candidates : nullptr;
  request.tests = tests ? &*tests : nullptr;
  const auto [cell_text, is_text] = py::cast<std::pair<std::string, bool>>(wishes["cell"]);
  std::optional<Cell> cell;
  if (!cell_text.empty()) {
    cell = is_text ? ReadCellText(cell_text, "cell", inputs.robot.chain) : ReadCellFile(cell_text, inputs.robot.chain);
  }
  request.cell = cell ? &*cell : nullptr;
  request.move = py::cast<bool>(wishes["move"]);
  const auto [former, former_name] = py::cast<std::pair<std::string, std::string>>(wishes["model_error"]);
  if (!former.empty()) ReadModelError(former, former_name, &request);
  Plan plan = ResultOf<Plan>(progress, [&](const Say& say) {
    request.progress = say;
    return MakePlan(inputs.robot, inputs.data, inputs.experiment, request);
  });
  return std::make_shared<PlannedExperiment>(
      PlannedExperiment{std::move(plan), inputs.robot, std::move(cell), {command, "plan", inputs.files}});
}

}  // namespace

void BindResults(py::module_& module) {
  py::class_<DiagnosedExperiment, std::shared_ptr<DiagnosedExperiment>>(module, "Diagnosis")
      .def("json", [](const DiagnosedExperiment& d) { return DumpJson(DiagnosisToJson(d.diagnosis, d.significance)); })
      .def("report_html", &DiagnosedExperiment::ReportHtml)
      .def("robot_yaml", [](const DiagnosedExperiment& d) { return RobotToYaml(RobotOf(d.diagnosis.final)); })
      .def("learnt_robot_yaml",
           [](const DiagnosedExperiment& d) -> std::optional<std::string> {
             if (!d.diagnosis.learnt) return std::nullopt;
             return RobotToYaml(RobotOf(d.diagnosis.learnt->model));
           })
      .def("next_robot_yaml",
           [](const DiagnosedExperiment& d) -> std::optional<std::string> {
             const std::optional<Robot> next = RobotOfTheNextCampaign(RobotOf(d.diagnosis.final));
             if (!next) return std::nullopt;
             return RobotToYaml(*next);
           })
      .def("known", [](const DiagnosedExperiment& d) {
        const OthersMayRun others_may_run;
        return std::make_shared<KnownRobot>(d.Known());
      });
  py::class_<PlannedExperiment, std::shared_ptr<PlannedExperiment>>(module, "Plan")
      .def_property_readonly("rows", &RowsOf)
      .def("json", [](const PlannedExperiment& p) { return DumpJson(PlanToJson(p.plan)); })
      .def("report_html", &PlannedExperiment::ReportHtml)
      .def("csv", [](const PlannedExperiment& p) { return PlanToCsv(p.robot.chain, p.plan); });
  py::class_<InspectedExperiment, std::shared_ptr<InspectedExperiment>>(module, "Inspection")
      .def("json", &InspectedExperiment::Json)
      .def("report_html", &InspectedExperiment::ReportHtml)
      .def("write", [](const InspectedExperiment& i, const std::string& folder) {
        OutputFolder(folder, {"report.html", "inspect.json"})
            .Write({{"report.html", i.ReportHtml()}, {"inspect.json", i.Json()}});
      });
  module.def("inspect", &InspectInputs);
  module.def("diagnose", &DiagnoseInputs);
  module.def("plan", &PlanInputs);
  module.def("text_of", &ReadTextFile);
}

}  // namespace sagitta::python

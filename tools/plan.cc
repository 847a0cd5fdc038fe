// sagitta plan: which poses to measure, how many, and how good the calibration will be.
#include "estimator/planning/plan.h"

#include <gflags/gflags.h>

#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>

#include "estimator/results/estimate_json.h"
#include "estimator/results/plan_json.h"
#include "problems/input_error.h"
#include "problems/io/cell_file.h"
#include "problems/io/effect_names.h"
#include "problems/io/experiment_inputs.h"
#include "problems/io/files.h"
#include "problems/io/import/robot_reading.h"
#include "problems/io/output_files.h"
#include "problems/io/robot_file.h"
#include "problems/range.h"
#include "tools/commands.h"
#include "tools/problem_from_arguments.h"
#include "tools/progress.h"
#include "tools/report/command_words.h"
#include "tools/report/plan_report.h"
#include "tools/report/summary.h"

DEFINE_int32(poses, 0, "how many poses to plan");
DEFINE_double(accuracy_mm, 0.0, "as few poses as reach this RMS position error at the test poses");
DEFINE_bool(augment, false, "the calibration rows of EXP are measured already; plan further ones");
DEFINE_string(criterion, "I", "I, D, A, E, or an observability index O1 to O5");
DEFINE_string(discriminate, "", "EFFECT[SETTINGS]/TARGET,…: poses that distinguish these effects");
DEFINE_string(
    candidates, "",
    "FILE.csv: rows (config, marker, q1_deg …; one for each marker, station and load) among whose configurations "
    "to choose, not the joint limits");
DEFINE_string(tests, "", "FILE.csv: the test poses; random: drawn in the joint limits");
DEFINE_int32(pool, 500, "poses drawn in the joint limits as candidates");
DEFINE_string(cell, "", "CELL.yaml: floor, boxes, bodies of the arm, lines of sight that poses must keep to");
DEFINE_string(model_error, "", "estimate.json of a former calibration: what is known to be wrong with the model");
DEFINE_bool(move, true, "drawn poses may move to where they are more informative; --nomove: they stay");

namespace sagitta {
namespace {

void CheckPlanFlags() {
  if (FLAGS_out.empty()) throw InputError({"", 0, "--out"}, "where to write is missing", "--out=DIR");
  if (IsGiven("poses") == IsGiven("accuracy_mm")) {
    throw InputError({"", 0, "--poses"}, "one of --poses and --accuracy_mm says how many", "--poses=20");
  }
  if (IsGiven("poses")) CheckIn(allowed::kPoses, FLAGS_poses, "--poses");
  if (IsGiven("accuracy_mm")) CheckIn(allowed::kAccuracy, FLAGS_accuracy_mm / 1e3, "--accuracy_mm");
  CheckIn(allowed::kPool, FLAGS_pool, "--pool");
  if (IsGiven("sigma_mm")) CheckIn(allowed::kSigma, FLAGS_sigma_mm / 1e3, "--sigma_mm");
}

std::string LineOf(const PosesAndAccuracy& point) {
  return "  " + Plural(point.poses, "pose") + ": " + Significant(1e3 * point.position_rms, 3) + " mm\n";
}

Plan PlanWithProgress(const ExperimentInputs& inputs, PlanRequest request, bool quiet) {
  // Shares as measured on the KR270 with 5000 candidates; how many numbers an accuracy needs is not known before.
  std::vector<ProgressPhase> phases;
  if (request.poses > 0) phases = {{"drawing", 1.0}, {"best", 8.0}, {"moving", 8.0}, {"accuracy", 6.0}};
  Progress progress(quiet, phases);
  request.progress = [&progress](const std::string& what) { progress.Say(what); };
  std::string found;
  request.found = [&found](const PosesAndAccuracy& point) { found += LineOf(point); };
  Plan plan;
  SayingWhatWasFound(
      [&] {
        progress.Say("drawing poses that can be measured");
        plan = MakePlan(inputs.robot, inputs.data, inputs.experiment, request);
      },
      [&] { return found; });
  return plan;
}

void Summarise(const Plan& plan) {
  std::cout << PlanInWords(plan);
  if (!plan.curve.empty()) std::cout << CurveInWords(plan) << "\n";
  for (const PosesAndAccuracy& point : plan.curve) std::cout << LineOf(point);
  for (const std::string& words : plan.words) std::cout << words << "\n";
}

// Without what files hold.
PlanRequest RequestFromFlags(const Robot& robot) {
  PlanRequest request;
  request.poses = IsGiven("poses") ? FLAGS_poses : 0;
  request.accuracy = FLAGS_accuracy_mm / 1e3;
  request.augment = FLAGS_augment;
  request.criterion = CriterionNamed(FLAGS_criterion);
  request.discriminate = RivalEffects(robot, FLAGS_discriminate, "--discriminate");
  request.pool = FLAGS_pool;
  request.seed = FLAGS_seed;
  request.random_tests = FLAGS_tests == "random";
  request.move = FLAGS_move;
  return request;
}

// A robot alone: what a plan needs next to it, for this robot.
void CheckRowsAreThere(const std::vector<std::string>& paths) {
  if (paths.size() > 1 || IsExperimentFile(paths[0]) || !LooksLikeRobot(paths[0])) return;
  const Chain chain = ReadRobotFile(paths[0]).chain;
  std::string row = "a,M1,S1";
  for (int j = 0; j < chain.num_joints(); ++j) row += ",0";
  throw InputError({paths[0], 0, ""}, "nothing says how a pose is measured",
                   "rows.csv: '" + PlanColumns(chain) + "', below it '" + row +
                       "', and so a row for every marker, station and load; plan.yaml: 'schema: sagitta/experiment/1', "
                       "'robot: " +
                       std::filesystem::path(paths[0]).filename().string() +
                       "', 'measurements: [rows.csv]', 'markers: {M1: {xyz_mm: [0, 0, 100]}}', 'noise: {sigma_mm: "
                       "0.05}'; then sagitta plan plan.yaml");
}

int RunPlan(const CommandLine& line) {
  ExpectArguments(line, PlanCommand(), 1, 1000);
  CheckPlanFlags();
  const OutputFolder out(FLAGS_out, {"plan.csv", "plan.json", "report.html"});
  MeasurementReadOptions options;
  options.points_required = false;
  CheckRowsAreThere(line.arguments);
  ExperimentInputs inputs = ReadExperimentInputs(line.arguments, options);
  if (IsGiven("sigma_mm")) {
    inputs.experiment.noise.from = NoiseSpec::From::kSigma;
    inputs.experiment.noise.sigma = FLAGS_sigma_mm / 1e3;
    inputs.experiment.noise.replaces_rows = true;
  }
  if (IsGiven("load_point_mm")) inputs.experiment.load_point = LoadPointOfFlag(FLAGS_load_point_mm);
  PlanRequest request = RequestFromFlags(inputs.robot);
  std::optional<Measurements> candidates, tests;
  if (!FLAGS_candidates.empty()) candidates = ReadMeasurementsFor(inputs.robot, {FLAGS_candidates}, options);
  if (!FLAGS_tests.empty() && !request.random_tests) {
    tests = ReadMeasurementsFor(inputs.robot, {FLAGS_tests}, options);
  }
  request.candidates = candidates ? &*candidates : nullptr;
  request.tests = tests ? &*tests : nullptr;
  std::optional<Cell> cell;
  if (!FLAGS_cell.empty()) cell = ReadCellFile(FLAGS_cell, inputs.robot.chain);
  request.cell = cell ? &*cell : nullptr;
  if (!FLAGS_model_error.empty()) {
    ReadModelError(ReadTextFile(FLAGS_model_error), FLAGS_model_error, &request);
  }
  const Plan plan = PlanWithProgress(inputs, request, FLAGS_quiet);
  nlohmann::ordered_json json = PlanToJson(plan);
  json["version"] = SAGITTA_VERSION;
  json["command"] = line.text;
  const Provenance provenance{line.text, "plan", inputs.files};
  out.Write({{"plan.csv", PlanToCsv(inputs.robot.chain, plan)},
             {"plan.json", DumpJson(json)},
             {"report.html", PlanReportToHtml(inputs.robot, request.cell, plan, provenance)}});
  Summarise(plan);
  std::cout << ResultsIn(FLAGS_out, {"plan.csv", "plan.json", "report.html"});
  return 0;
}

}  // namespace

Command PlanCommand() {
  return {"plan",
          "which poses to measure, how many, and how good the calibration will be",
          R"(sagitta plan EXP --poses=N|--accuracy_mm=A [--augment] [--discriminate=EFFECT,EFFECT] --out=DIR

EXP is an experiment file, or ROBOT.yaml MEAS.csv…; x, y, z of its rows may be absent. Its rows say how a pose is
measured (stations, markers, loads; of a listed candidate its own rows do) and where accuracy is wanted: the validation
rows, else all, are the test poses. Written are plan.csv, a measurement file without x, y, z, report.html, the arm drawn
in each pose, and plan.json with the criterion, how near the plan is to the best possible one of the candidates, the
predicted accuracy, the expected sigma of every parameter and the accuracy over the number of poses.

The criterion I is the mean squared position error at the test poses after compensation; D, A, E and O1 to O5 are
explained in docs/PLAN.md. --discriminate names effects as results do, joint_harmonic[order=1]/A3. Poses are within the
joint limits and in equilibrium under their load; floor, boxes, collisions of the arm's bodies, the tool's cone, lines
of sight and acceptance angles of reflectors are checked where --cell states them. What is not checked is said.
--model_error lets the plan know by how much a former calibration was off at points it had not fitted.

Examples
  sagitta plan experiment.yaml --poses=20 --out=plan
  sagitta plan experiment.yaml --accuracy_mm=0.1 --tests=welding_spots.csv --out=plan
  sagitta plan experiment.yaml --poses=40 --cell=cell.yaml --model_error=former/estimate.json --out=plan
  sagitta plan experiment.yaml --augment --poses=6 --candidates=reachable.csv --out=plan
  sagitta plan experiment.yaml --poses=6 --discriminate='joint_harmonic[order=1]/A3,encoder_gain/A3' --out=plan
)",
          {"poses", "accuracy_mm", "augment", "discriminate", "criterion", "candidates", "tests", "pool", "cell",
           "model_error", "move", "sigma_mm", "load_point_mm", "out", "seed", "threads", "quiet"},
          RunPlan};
}

}  // namespace sagitta

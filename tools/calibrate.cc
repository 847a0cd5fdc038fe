// sagitta calibrate: the main job.
#include <gflags/gflags.h>

#include <algorithm>
#include <iostream>

#include "estimator/agreement/agreement.h"
#include "estimator/baselines/compare_methods.h"
#include "estimator/calibration/noise_loop.h"
#include "estimator/calibration/unit_guess.h"
#include "estimator/intervals/intervals.h"
#include "estimator/results/estimate_json.h"
#include "estimator/results/residuals_csv.h"
#include "problems/input_error.h"
#include "problems/io/files.h"
#include "problems/io/robot_file.h"
#include "tools/commands.h"
#include "tools/problem_from_arguments.h"
#include "tools/progress.h"
#include "tools/report/report_html.h"
#include "tools/report/summary.h"
#include "tools/requirement.h"
#include "tools/run_command.h"

DEFINE_string(method, "joint", "joint, two-step, two-step-literal, two-step-relinearised or full-pose");
DEFINE_string(require, "", "'PATH<NUMBER,…' in the result JSON (< <= > >= ==); not met: exit status 1");

namespace sagitta {
namespace {

constexpr size_t kShownDirections = 5;
// Random halves to compare: each costs two fits of half the rows.
int RandomHalves(const CalibrationProblem& problem) {
  return std::clamp(40000 / static_cast<int>(problem.data.observations.size() + 1), 4, 20);
}

void CheckMethod() {
  for (const std::string& method : MethodNames()) {
    if (FLAGS_method == method) return;
  }
  throw InputError({"", 0, "--method"}, "there is no method '" + FLAGS_method + "'",
                   SpellingHint(FLAGS_method, MethodNames()));
}

void CheckMethodKnowsNoise(const CalibrationProblem& problem) {
  const std::string obstacle = MethodObstacle(problem, FLAGS_method);
  if (!obstacle.empty()) throw InputError({"", 0, "--method"}, obstacle, "use --method=joint, or state sigma_mm alone");
}

ResolvedEstimate RunEstimate(const CalibrationProblem& problem, Progress* progress) {
  JointOptions options;
  options.num_threads = FLAGS_threads;
  options.progress = [progress](const std::string& what) { progress->Say(what); };
  ResolvedEstimate joint = EstimateWithNoise(problem, options);
  if (FLAGS_method == "joint" || !IsUsable(joint.estimate.status)) return joint;
  progress->Say("running " + FLAGS_method);
  joint.estimate = RunMethod(joint.problem, FLAGS_method, joint.estimate, options.progress).estimate;
  return joint;
}

int ReportFailure(const Estimate& estimate) {
  std::cerr << "sagitta: no estimate: " << StatusName(estimate.status) << ": " << estimate.message << "\n";
  const std::vector<Direction>& directions = estimate.identifiability.unidentifiable;
  for (size_t i = 0; i < std::min(kShownDirections, directions.size()); ++i) {
    std::cerr << "  " << directions[i].words << "; " << directions[i].remedy << "\n";
  }
  return kNumericalFailure;
}

// Everything is text before the first file is written.
struct ResultFiles {
  nlohmann::ordered_json json;
  std::string residuals, robot, report;

  ResultFiles(const CalibrationProblem& problem, const Estimate& estimate, const Provenance& provenance)
      : json(EstimateToJson(problem, estimate, provenance)),
        residuals(ResidualsToCsv(problem, estimate)),
        robot(RobotToYaml(problem.model.WithValues(estimate.parameters.ModelValues()))),
        report(ReportToHtml(problem, estimate, provenance)) {}

  // The estimate last: where it is, the others are.
  void Write(const std::string& folder) const {
    WriteTextFile(folder + "/robot.calibrated.yaml", robot);
    WriteTextFile(folder + "/residuals.csv", residuals);
    WriteTextFile(folder + "/report.html", report);
    WriteTextFile(folder + "/estimate.json", DumpJson(json));
  }
};

int RunCalibrate(const CommandLine& line) {
  ExpectArguments(line, CalibrateCommand(), 1, 1000);
  CheckMethod();
  const std::vector<Requirement> requirements = ParseRequirements(FLAGS_require);
  if (!FLAGS_out.empty()) PrepareOutputFolder(FLAGS_out);

  const ExperimentInputs inputs = ReadExperimentInputs(line.arguments);
  ResolvedEstimate resolved{ProblemFromInputs(inputs), {}};
  CheckMethodKnowsNoise(resolved.problem);
  CheckIntervalsFit(resolved.problem, FLAGS_method);
  {
    Progress progress(FLAGS_quiet);
    resolved = RunEstimate(resolved.problem, &progress);
    const IntervalOptions options{FLAGS_threads, [&progress](const std::string& what) { progress.Say(what); }};
    if (IsUsable(resolved.estimate.status)) {
      AddIntervals(resolved.problem, options, &resolved.estimate);
      progress.Say("comparing parts of the data");
      if (FLAGS_method == "joint")
        CheckAgreement(resolved.problem, {FLAGS_seed, RandomHalves(resolved.problem)}, &resolved.estimate);
    }
  }
  const CalibrationProblem& problem = resolved.problem;
  Estimate& estimate = resolved.estimate;
  if (!IsUsable(estimate.status)) return ReportFailure(estimate);

  const std::string misfit = WarningOfMisfit(problem, estimate.fit.distance_rms);
  if (!misfit.empty()) estimate.warnings.push_back(misfit);
  const ResultFiles files(problem, estimate, {line.text, FLAGS_method, inputs.files});
  const std::vector<std::string> unmet = UnmetRequirements(requirements, files.json);
  std::cout << SectionsToText(Summarise(problem, estimate));
  if (FLAGS_out.empty()) {
    std::cout << "\nNothing is written; --out=DIR keeps the results.\n";
  } else {
    files.Write(FLAGS_out);
    std::cout << "\nResults in " << FLAGS_out << ": report.html, estimate.json, robot.calibrated.yaml, residuals.csv\n";
  }
  for (const std::string& sentence : unmet) std::cerr << "sagitta: " << sentence << "\n";
  return unmet.empty() ? 0 : kRequirementNotMet;
}

}  // namespace

Command CalibrateCommand() {
  return {"calibrate", "estimates geometry, base poses and markers from measured points",
          R"(sagitta calibrate EXP --out=DIR

EXP is an experiment file, or ROBOT.yaml MEAS.csv…: then base poses, markers and the default geometric errors
are estimated, with the standard deviations of the rows, else an estimated one. No starting values are needed.
Writes estimate.json, robot.calibrated.yaml, residuals.csv and report.html to DIR.

Keys of an experiment file that state the noise and ask for intervals (docs/NOISE_AND_INTERVALS.md):
  noise:   {sigma_mm: 0.05} | {from: rows} | {from: repeats} | {from: variance-components}
           {from: residuals, lambda: 1, sigma0_mm: 0.01, group: config-axis, iterations: 10}
                group: axis | config-axis | marker-axis | station-axis | residual
           {instrument: {range_um: 10, range_um_per_m: 0.5, angle_um: 15, angle_um_per_m: 6}}
                with stations: {S1: {instrument_mm: [0, 0, 0]}}
  repeatability_urad:   8 | {A1: 8, A2: 12} | estimate      (prismatic joints: repeatability_um)
  weights:      sigma | equal | eq14
  loss:         none | huber | cauchy
  covariance:   model | sandwich | bootstrap | profile
  bootstrap:    {kind: automatic | parametric | configurations, replicates: 999, seed: 1}
The report compares parts of the data (halves of the workspace, stations) and says by how much model error widens
the intervals; random halves are drawn with --seed.

Examples
  sagitta calibrate robot.yaml measurements.csv --out=results
  sagitta calibrate robot.yaml measurements.csv --holdout=0.3 --seed=1 --out=results
  sagitta calibrate robot.yaml a.csv b.csv --sigma_mm=0.05 --fixed=geometry/j1.d,base/S1 --out=results
  sagitta calibrate experiment.yaml --out=results --require='validation.distance_rms_mm<0.3'
)",
          WithProblemFlags({"method", "require"}), RunCalibrate};
}

}  // namespace sagitta

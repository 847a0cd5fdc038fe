// sagitta calibrate: the main job.
#include <algorithm>
#include <iostream>
#include <optional>

#include "estimator/results/residuals_csv.h"
#include "estimator/sagitta.h"
#include "problems/io/output_files.h"
#include "tools/commands.h"
#include "tools/problem_from_arguments.h"
#include "tools/progress.h"
#include "tools/report/calibration_report.h"
#include "tools/report/command_words.h"
#include "tools/report/first_screen.h"
#include "tools/report/summary.h"
#include "tools/requirement.h"
#include "tools/run_command.h"

namespace sagitta {
namespace {

constexpr size_t kShownDirections = 5;

int ReportFailure(const Calibration& failed) {
  const Estimate& estimate = failed.estimate;
  std::cerr << "sagitta: no estimate: " << StatusName(estimate.status) << ": " << estimate.message << "\n";
  const std::vector<Direction>& directions = estimate.identifiability.unidentifiable;
  for (size_t i = 0; i < std::min(kShownDirections, directions.size()); ++i) {
    std::cerr << "  " << directions[i].words << "; " << directions[i].remedy << "\n";
  }
  if (!failed.trust.suspects.empty()) std::cerr << SectionsToText({SuspectRows(failed, "")});
  return kNumericalFailure;
}

// Everything but the rows is text before the first file is written.
struct ResultFiles {
  nlohmann::ordered_json json;
  std::string robot, report;

  ResultFiles(const Calibration& calibration, const std::vector<Section>& sections, const Provenance& provenance)
      : json(CalibrationToJson(calibration, provenance)),
        robot(RunComment(provenance) + RobotToYaml(calibration.problem.RobotWith(calibration.estimate.parameters))),
        report(CalibrationToHtml(calibration, sections, provenance)) {}

  static std::vector<std::string> Names() {
    return {"robot.calibrated.yaml", "residuals.csv", "report.html", "estimate.json"};
  }
  void Write(const OutputFolder& folder, const Calibration& calibration, int num_threads) {
    std::vector<NamedText> files;
    files.emplace_back("robot.calibrated.yaml", robot);
    files.emplace_back("report.html", std::move(report));
    files.emplace_back("estimate.json", DumpJson(json));
    folder.Write(files, {ResidualsFile(calibration.problem, calibration.estimate, num_threads)});
  }
};

Calibration CalibrateWithProgress(CalibrationProblem problem, CalibrateOptions options, bool quiet) {
  // Shares as measured on UR5 and UR10 series; solving and alignment grow with the rows alike.
  Progress progress(
      quiet,
      {{"aligning", 2.0}, {"solving", 3.0}, {"intervals", 1.0}, {"comparing parts", 4.0}, {"cross-validating", 2.0}});
  options.progress = [&progress](const std::string& what) { progress.Say(what); };
  return Calibrate(std::move(problem), options);
}

int RunCalibrate(const CommandLine& line) {
  ExpectArguments(line, CalibrateCommand(), 1, 1000);
  const std::vector<Requirement> requirements = ParseRequirements(FLAGS_require);
  std::optional<OutputFolder> out;
  if (!FLAGS_out.empty()) out.emplace(FLAGS_out, ResultFiles::Names());

  ExperimentInputs inputs = ReadInputs(line.arguments);
  const std::vector<InputFile> input_files = inputs.files;
  const Calibration result = CalibrateWithProgress(PlausibleProblem(std::move(inputs)),
                                                   {MethodNamed(FLAGS_method), FLAGS_threads, FLAGS_seed}, FLAGS_quiet);
  if (!IsUsable(result.estimate.status)) return ReportFailure(result);

  CheckInterruption();
  const std::vector<Section> sections = CalibrationSections(result);
  ResultFiles files(result, sections, {line.text, FLAGS_method, input_files});
  const std::vector<std::string> unmet = UnmetRequirements(requirements, files.json);
  std::cout << SectionsToText(sections);
  if (FLAGS_out.empty()) {
    std::cout << NothingIsWritten();
  } else {
    files.Write(*out, result, FLAGS_threads);
    std::cout << "\n"
              << ResultsIn(FLAGS_out, {"report.html", "estimate.json", "robot.calibrated.yaml", "residuals.csv"});
  }
  return EndWith(unmet);
}

}  // namespace

Command CalibrateCommand() {
  return {"calibrate", "estimates geometry, base poses and markers from measured points",
          R"(sagitta calibrate EXP --out=DIR

EXP is an experiment file, or ROBOT.yaml MEAS.csv…: then base poses, markers and the default geometric errors
are estimated, with the standard deviations of the rows, else an estimated one. Where the rows' are the instrument's
and the robot scatters by far more, rows are weighed by both together ({from: rows}: by the rows' alone). No starting
values are needed. Writes estimate.json, robot.calibrated.yaml, residuals.csv and report.html to DIR.

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
the intervals; random halves are drawn with --seed. Where the nominal robot cannot have made the readings (wrong
signs, zeros, joint order, units, DH convention, another robot) it says so and ends with status 2; --force goes on.
Ctrl-C writes nothing.

Examples
  sagitta calibrate robot.yaml measurements.csv --out=results
  sagitta calibrate robot.yaml measurements.csv --holdout=0.3 --seed=1 --out=results
  sagitta calibrate robot.yaml a.csv b.csv --sigma_mm=0.05 --fixed=geometry/j1.d,base/S1 --out=results
  sagitta calibrate experiment.yaml --out=results --require='validation.distance_rms_mm<0.3'
)",
          WithProblemFlags({"method", "require"}), RunCalibrate};
}

}  // namespace sagitta

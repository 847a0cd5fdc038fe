// sagitta diagnose: finds, names and adds the missing effect.
#include <gflags/gflags.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <optional>
#include <set>
#include <utility>

#include "estimator/diagnosis/learnt_model.h"
#include "estimator/diagnosis/simulation_baseline.h"
#include "estimator/report/diagnosis_words.h"
#include "estimator/results/diagnosis_json.h"
#include "estimator/results/estimate_json.h"
#include "estimator/results/next_campaign.h"
#include "estimator/results/next_csv.h"
#include "estimator/results/residuals_csv.h"
#include "estimator/sagitta.h"
#include "models/effects/catalogue.h"
#include "problems/input_error.h"
#include "problems/io/csv_table.h"
#include "problems/io/files.h"
#include "problems/io/output_files.h"
#include "problems/io/robot_file.h"
#include "tools/commands.h"
#include "tools/problem_from_arguments.h"
#include "tools/progress.h"
#include "tools/report/command_words.h"
#include "tools/report/diagnosis_report.h"
#include "tools/requirement.h"
#include "tools/run_command.h"

DEFINE_string(simulation, "model", "what the gap is measured from: model, or columns (sim_x_mm, sim_y_mm, sim_z_mm)");

namespace sagitta {
namespace {

constexpr double kFarFromSimulation = 3.0;  // of the gap

// A part of the configurations is set aside for the verdict, unless the experiment says which or none.
ExperimentInputs WithHoldout(ExperimentInputs inputs) {
  HoldOutForDiagnosis(inputs.data, &inputs.experiment);
  return inputs;
}

// Against a foreign simulation base and markers stay free; more only where the
// experiment asks for it by name.
ExperimentInputs OnlyBaseAndMarkers(ExperimentInputs inputs) {
  EstimateSpec& estimate = inputs.experiment.estimate;
  for (Selection* selection :
       {&estimate.geometry, &estimate.compliance, &estimate.gravity_compensator, &estimate.effects}) {
    if (selection->kind == Selection::Kind::kDefault) selection->kind = Selection::Kind::kNone;
  }
  return inputs;
}

bool AgainstColumnsFromFlags() {
  if (FLAGS_simulation == "model" || FLAGS_simulation == "columns") return FLAGS_simulation == "columns";
  throw InputError({"", 0, "--simulation"}, "'" + FLAGS_simulation + "' is no baseline", "model or columns");
}

// Against the model itself nothing is shifted.
SimulationBaseline BaselineOf(const ExperimentInputs& inputs, bool against_columns) {
  if (against_columns) return AgainstSimulation(ProblemFromInputs(OnlyBaseAndMarkers(inputs)));
  return {PlausibleProblem(inputs), {}, 0.0};
}

// Says what the gap is measured from. What the simulation holds and the robot file does not cancels in the points, but
// the effects' columns are those of the file: where the two differ by more than the gap itself, effects that act
// through the difference are not seen.
void CautionOfSimulation(const SimulationBaseline& baseline, Diagnosis* diagnosis) {
  diagnosis->cautions.push_back(AgainstColumns(baseline.reproduced));
  if (baseline.reproduced < kFarFromSimulation * diagnosis->baseline.estimate.fit.distance_rms) return;
  diagnosis->cautions.push_back(FarFromColumns());
}

// What an interrupted run knows.
std::string InWords(const Robot& robot, const FoundSoFar& found) {
  std::string words;
  for (const auto& [spec, probability] : found)
    words += "  " + Title(robot, spec) + ", " + Significant(100.0 * probability, 3) + " %, not confirmed yet\n";
  return words;
}

// Against another simulation it is no calibrated robot, however well it fits.
Calibration Extended(const Diagnosis& diagnosis, std::uint64_t seed, bool against_columns) {
  Calibration extended = ExtendedCalibration(diagnosis, seed);
  if (!against_columns) return extended;
  const std::string reason = CorrectionsToSimulation();
  Verdict& verdict = extended.trust.verdict;
  verdict.trusted = false;
  verdict.reasons.push_back(reason);
  verdict.words += " Its " + reason + ".";
  return extended;
}

// Everything but the rows is text before the first file is written.
// Columns that a simulation wrote are no robot, which no campaign measures next.
std::optional<Robot> RobotMeasuredNext(const Diagnosis& diagnosis, bool against_columns) {
  if (against_columns) return std::nullopt;
  return RobotOfTheNextCampaign(RobotOf(diagnosis.final));
}

void WriteResults(const Provenance& provenance, Calibration extended, const SimulationBaseline& baseline,
                  const Diagnosis& diagnosis, const nlohmann::ordered_json& json, const OutputFolder& out) {
  const bool against_columns = !provenance.simulation.empty();
  const std::string robot =
      RunComment(provenance) + (against_columns ? NotACalibratedRobot() : "") + RobotToYaml(RobotOf(diagnosis.final));
  const std::string report = DiagnosisToHtml(diagnosis, extended, provenance);
  const std::string estimate_json = DumpJson(CalibrationToJson(extended, provenance));
  if (against_columns) baseline.Unshift(&extended.problem, &extended.estimate);
  nlohmann::ordered_json with_run = json;
  with_run["run"] = RunId(provenance);
  std::vector<NamedText> files = {{"robot.extended.yaml", robot},
                                  {"report.html", report},
                                  {"estimate.json", estimate_json},
                                  {"diagnosis.json", DumpJson(with_run)}};
  if (diagnosis.next) files.push_back({kNextFile, NextToCsv(diagnosis)});
  if (const std::optional<Robot> next = RobotMeasuredNext(diagnosis, against_columns))
    files.push_back({kNextRobotFile, RunComment(provenance) + RobotToYaml(*next)});
  if (diagnosis.learnt) {
    const DiagnosedModel& learnt = diagnosis.learnt->model;
    files.push_back({kLearntEstimateFile, DumpJson(LearntEstimateToJson(diagnosis, provenance))});
    files.push_back({kLearntFile, RunComment(provenance) + LearntFunctionsInFile() + RobotToYaml(RobotOf(learnt))});
  }
  out.Write(files, {ResidualsFile(extended.problem, extended.estimate)});
}

// Of a measured point or rotation, in any unit, or of a torque.
bool IsReading(const std::string& column) {
  static const std::set<std::string> stems = {"x", "y", "z", "rx", "ry", "rz", "ow", "ox", "oy", "oz"};
  return stems.count(column.substr(0, column.find('_'))) > 0 || column.rfind("tau", 0) == 0;
}

// The proposed poses of an earlier run may have been measured since, in place: such a file is not replaced.
void RefuseToReplaceReadings(const std::string& folder) {
  const std::string path = (std::filesystem::path(folder) / kNextFile).string();
  if (!std::filesystem::exists(path)) return;
  const MeasurementFile file = ParseCsvTable(ReadOwnFile(path), path).file;
  for (const MeasurementRows::Row row : file.rows) {
    for (size_t c = 0; c < file.header.size(); ++c) {
      if (!IsReading(file.header[c]) || row.cells[c].find_first_not_of(" \t") == std::string_view::npos) continue;
      throw InputError({path, row.line, file.header[c]}, "holds readings, which this run would replace",
                       "move the file out of this folder and list it under measurements, or choose another --out");
    }
  }
}

// Where no poses are proposed, those of an earlier run are out of date: what nobody measured is of no use.
void RemoveOlderProposal(const Diagnosis& diagnosis, const std::string& folder) {
  if (diagnosis.next) return;
  RefuseToReplaceReadings(folder);
  std::filesystem::remove(std::filesystem::path(folder) / kNextFile);
}

// Files that only some diagnoses have, of an earlier run into the same folder.
std::vector<std::string> OlderFiles(const Diagnosis& diagnosis, const std::string& folder, bool against_columns) {
  std::vector<std::string> unwritten, older;
  if (!RobotMeasuredNext(diagnosis, against_columns)) unwritten.push_back(kNextRobotFile);
  if (!diagnosis.learnt) unwritten.insert(unwritten.end(), {kLearntFile, kLearntEstimateFile});
  for (const std::string& name : unwritten) {
    if (std::filesystem::exists(std::filesystem::path(folder) / name)) older.push_back(name);
  }
  return older;
}

DiagnosisOptions OptionsFor(const CalibrationProblem& problem, const PriorMasses& prior, bool against_columns,
                            int threads) {
  DiagnosisOptions options;
  options.significance = problem.experiment().significance;
  options.prior = prior;
  options.points_are_measured = !against_columns;
  options.joint.num_threads = threads;
  return options;
}

Diagnosis DiagnoseWithProgress(const CalibrationProblem& problem, bool quiet, DiagnosisOptions options) {
  // Per cent, the means of the UR5 and of series D and B + C + D of the UR10; how often it is weighed anew is not
  // known before.
  Progress progress(quiet, {{"fitting the believed model", 3.0},
                            {"listing", 3.0},
                            {"weighing", 54.0},
                            {"fitting the extended model", 5.0},
                            {"alternatives and halves", 9.0},
                            {"learning", 26.0}});
  FoundSoFar found;
  options.progress = [&progress](const std::string& what) { progress.Say(what); };
  options.found = [&found](const FoundSoFar& now) { found = now; };
  Diagnosis diagnosis;
  SayingWhatWasFound([&] { diagnosis = Diagnose(problem, options); }, [&] { return InWords(problem.robot(), found); });
  return diagnosis;
}

// Effects that go with times, which count anew in each campaign.
std::vector<std::string> OfThisCampaign(const Robot& robot) {
  std::vector<std::string> names;
  for (const EffectSpec& spec : robot.effects) {
    if (GoesWithTime(robot, spec)) names.push_back(Title(robot, spec));
  }
  return names;
}

void SayWhereResultsAre(const Diagnosis& diagnosis, const std::string& folder, bool against_columns) {
  std::cout << "\n"
            << ResultsIn(folder,
                         {"diagnosis.json", "robot.extended.yaml", "estimate.json", "residuals.csv", "report.html"});
  if (!diagnosis.effects.empty() && !against_columns) {
    std::cout << HowToGoOnWithEffects(OfThisCampaign(RobotOf(diagnosis.final)));
  }
  const std::vector<std::string> older = OlderFiles(diagnosis, folder, against_columns);
  if (!older.empty()) std::cout << OlderFilesIn(folder, older);
}

int RunDiagnose(const CommandLine& line) {
  ExpectArguments(line, DiagnoseCommand(), 1, 1000);
  const std::vector<Requirement> requirements = ParseRequirements(FLAGS_require);
  std::optional<OutputFolder> out;
  if (!FLAGS_out.empty()) {
    out.emplace(FLAGS_out, std::vector<std::string>{"robot.extended.yaml", "residuals.csv", "report.html",
                                                    "estimate.json", "diagnosis.json", kNextFile, kNextRobotFile,
                                                    kLearntFile, kLearntEstimateFile});
    RefuseToReplaceReadings(FLAGS_out);
  }
  const ExperimentInputs inputs = WithHoldout(ReadInputs(line.arguments));
  const bool against_columns = AgainstColumnsFromFlags();
  const SimulationBaseline baseline = BaselineOf(inputs, against_columns);
  const CalibrationProblem& problem = baseline.problem;
  Diagnosis diagnosis =
      DiagnoseWithProgress(problem, FLAGS_quiet, OptionsFor(problem, inputs.prior, against_columns, FLAGS_threads));
  if (!IsUsable(diagnosis.status)) {
    std::cerr << "sagitta: no diagnosis: the believed model does not fit: " << StatusName(diagnosis.status) << ": "
              << diagnosis.message << "\n";
    return kNumericalFailure;
  }
  if (against_columns) CautionOfSimulation(baseline, &diagnosis);
  std::cout << DiagnosisToText(diagnosis);
  const nlohmann::ordered_json json = DiagnosisToJson(diagnosis, problem.experiment().significance);
  const std::vector<std::string> unmet = UnmetRequirements(requirements, json);
  if (FLAGS_out.empty()) {
    std::cout << NothingIsWritten();
  } else {
    const Provenance provenance{line.text, "joint", inputs.files, against_columns ? "columns" : ""};
    WriteResults(provenance, Extended(diagnosis, FLAGS_seed, against_columns), baseline, diagnosis, json, *out);
    RemoveOlderProposal(diagnosis, FLAGS_out);
    SayWhereResultsAre(diagnosis, FLAGS_out, against_columns);
  }
  return EndWith(unmet);
}

}  // namespace

Command DiagnoseCommand() {
  return {"diagnose", "finds, names and adds the missing effect",
          R"(sagitta diagnose EXP --out=DIR

Fits the believed model, asks whether simulation and measurement disagree, weighs every effect of the catalogue
and what has no name against each other, says what is missing with its probability, adds it and shows the gap on
configurations that nothing was fitted to; next.csv holds poses that would decide what is still open. Without a
validation of its own the experiment holds out 30 % of the configurations. Verdicts: consistent, noise,
explained, partly, unknown. Ctrl-C writes nothing and says what was found so far.

Examples
  sagitta diagnose experiment.yaml --out=results
  sagitta diagnose robot.yaml measurements.csv --sigma_mm=0.05 --out=results
  sagitta diagnose experiment.yaml --simulation=columns --out=results    # the gap to another simulation
  sagitta diagnose experiment.yaml --out=results --require='final.holdout_distance_rms_mm<0.2'
)",
          WithProblemFlags({"simulation", "require"}), RunDiagnose};
}

}  // namespace sagitta

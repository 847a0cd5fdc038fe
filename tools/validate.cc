// sagitta validate: before and after on configurations that the estimate has not seen.
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <optional>

#include "estimator/sagitta.h"
#include "problems/interruption.h"
#include "problems/io/experiment_inputs.h"
#include "problems/io/output_files.h"
#include "tools/commands.h"
#include "tools/progress.h"
#include "tools/report/command_words.h"
#include "tools/report/validation_report.h"
#include "tools/requirement.h"

namespace sagitta {
namespace {

namespace fs = std::filesystem;

// Those of the files that are in a folder, where that is the folder of `path`.
std::vector<std::string> FilesNextTo(const std::string& path, const std::string& folder,
                                     const std::vector<std::string>& names) {
  std::error_code ignored;
  const fs::path own = fs::path(path).parent_path();
  std::vector<std::string> files;
  const bool is_own = fs::equivalent(own.empty() ? fs::path(".") : own, folder, ignored);
  if (!is_own || fs::exists(fs::path(folder) / "validation.json", ignored)) return files;  // another one's already
  std::copy_if(names.begin(), names.end(), std::back_inserter(files),
               [&](const std::string& name) { return fs::exists(fs::path(folder) / name, ignored); });
  return files;
}

int RunValidate(const CommandLine& line) {
  ExpectArguments(line, ValidateCommand(), 2, 1000);
  const std::vector<Requirement> requirements = ParseRequirements(FLAGS_require);
  std::optional<OutputFolder> out;
  if (!FLAGS_out.empty())
    out.emplace(FLAGS_out, std::vector<std::string>{"residuals.csv", "report.html", "validation.json"});
  const KnownRobot known = ReadEstimateFile(line.arguments[0]);
  std::optional<Progress> progress;  // shares as measured on 390000 rows of the KR 270
  progress.emplace(FLAGS_quiet, std::vector<ProgressPhase>{{"reading", 2.0}, {"comparing", 3.0}, {"writing", 2.0}});
  progress->Say("reading the rows");
  const std::vector<std::string> files(line.arguments.begin() + 1, line.arguments.end());
  const Measurements rows = ReadMeasurementsFor(known.robot, files);
  Provenance provenance{line.text, "validation", {}};
  for (const std::string& path : line.arguments) provenance.inputs.push_back(DescribeInput(path));
  progress->Say("comparing " + std::to_string(rows.NumRows()) + " points");
  const Validation validation = Validate(known, rows);
  if (!FLAGS_force) CheckReadings(known, rows, validation.predicted, "--force goes on as stated");
  const nlohmann::ordered_json json = ValidationToJson(validation, provenance);
  const std::vector<std::string> unmet = UnmetRequirements(requirements, json);
  const std::string words = SectionsToText(ValidationSections(known, rows, validation));
  std::vector<std::string> replaced;
  if (out) {
    progress->Say("writing the rows");
    replaced = FilesNextTo(line.arguments[0], FLAGS_out, {"report.html", "residuals.csv"});
    const std::string csv = ValidationToCsv(rows, validation);
    const std::string page = ValidationToHtml(known, rows, validation, provenance);
    CheckInterruption();
    out->Write({{"residuals.csv", csv}, {"report.html", page}, {"validation.json", DumpJson(json)}});
  }
  progress.reset();
  std::cout << words;
  if (!out) {
    std::cout << NothingIsWritten();
  } else {
    std::cout << "\n" << ResultsIn(FLAGS_out, {"report.html", "validation.json", "residuals.csv"});
    if (!replaced.empty()) std::cerr << ReplacedThoseOfTheEstimate(replaced);
  }
  return EndWith(unmet);
}

}  // namespace

Command ValidateCommand() {
  return {"validate",
          "before and after on unseen configurations",
          R"(sagitta validate ESTIMATE.json MEAS.csv… [--out=DIR]

Compares measured points with those of the calibrated and of the nominal robot, on rows that were not used in the
fit, and with what the parameters' uncertainty and the noise predict. Writes validation.json,
residuals.csv and report.html to DIR. Rows that the robot of the estimate, where it stood, cannot have made are refused
with the reason (another robot, a place that has moved, another unit or sign); --force goes on.

Examples
  sagitta validate results/estimate.json unseen.csv --out=validation
  sagitta validate results/estimate.json unseen.csv --require='validation.distance_rms_mm<0.3'
)",
          {"force", "out", "require", "seed", "threads", "quiet"},
          RunValidate};
}

}  // namespace sagitta

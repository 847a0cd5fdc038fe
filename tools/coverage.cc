// sagitta coverage: do the intervals of the user's own experiment hold what they promise?
#include "estimator/intervals/coverage.h"

#include <gflags/gflags.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iostream>

#include "estimator/baselines/compare_methods.h"
#include "estimator/calibration/noise_loop.h"
#include "estimator/intervals/intervals.h"
#include "estimator/least_squares/parallel.h"
#include "estimator/results/estimate_json.h"
#include "estimator/statistics/distributions.h"
#include "problems/input_error.h"
#include "problems/io/output_files.h"
#include "problems/range.h"
#include "tools/commands.h"
#include "tools/coverage_state.h"
#include "tools/problem_from_arguments.h"
#include "tools/progress.h"
#include "tools/report/command_words.h"
#include "tools/report/summary.h"
#include "tools/run_command.h"

DEFINE_int32(trials, 2000, "of the Monte-Carlo study");

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kLevel = 0.95;

struct CoverageRequest {
  int trials, threads;
  std::uint64_t seed;
  Method method;
  std::string folder;
};

CoverageRequest RequestFromFlags() {
  CheckIn(allowed::kTrials, FLAGS_trials, "--trials");
  if (FLAGS_out.empty()) throw InputError({"", 0, "--out"}, "where to write is missing", "--out=DIR");
  return {FLAGS_trials, FLAGS_threads, FLAGS_seed, MethodNamed(FLAGS_method), FLAGS_out};
}

// What makes two runs the same: everything but how many trials, threads and words.
Json IdentityOf(const CoverageRequest& request, const ExperimentInputs& inputs, const CalibrationProblem& problem) {
  Json identity = {{"schema", "sagitta/coverage-state/1"},
                   {"version", SAGITTA_VERSION},
                   {"seed", request.seed},
                   {"method", WordOf(request.method)},
                   {"covariance", WordOf(problem.experiment().method.covariance)},
                   {"inputs", Json::array()},
                   {"flags", Json::object()}};
  for (const InputFile& input : inputs.files) identity["inputs"].push_back(input.sha256);
  for (const std::string& flag : WithProblemFlags({})) {
    const bool is_way = flag == "out" || flag == "threads" || flag == "quiet" || flag == "verbose" || flag == "seed";
    if (is_way || !IsGiven(flag)) continue;
    std::string value;
    gflags::GetCommandLineOption(flag.c_str(), &value);
    identity["flags"][flag] = value;
  }
  return identity;
}

void RunTrials(const CoverageRequest& request, const CoverageStudy& study, const CalibrationProblem& problem,
               CoverageState* state, Progress* progress) {
  std::vector<int> missing;
  for (int i = 0; i < request.trials; ++i) {
    if (state->trials().count(i) == 0) missing.push_back(i);
  }
  std::vector<CalibrationProblem> own(std::min<size_t>(request.threads, std::max<size_t>(1, missing.size())), problem);
  const std::string all = " of " + std::to_string(missing.size()), seed = ", seed " + std::to_string(request.seed);
  std::atomic<int> done{0};
  ParallelFor(static_cast<int>(missing.size()), request.threads, [&](int i, int worker) {
    state->Add(study.Run(missing[i], &own[worker]));
    progress->Say("trials: " + std::to_string(++done) + all + seed);
  });
}

std::vector<CoverageTrial> FirstTrials(const CoverageState& state, int count) {
  std::vector<CoverageTrial> trials;
  for (const auto& [number, trial] : state.trials()) {
    if (number < count) trials.push_back(trial);
  }
  return trials;
}

std::string FoundInTrials(const CoverageRequest& request, const CoverageStudy& study,
                          const std::vector<CoverageTrial>& trials) {
  int covered = 0, of = 0;
  for (const CoverageRow& row : study.Summarise(trials)) {
    covered += row.covered;
    of += row.trials;
  }
  if (of == 0) return "";
  return TrialsAreKept(static_cast<int>(trials.size()), request.trials, covered / (1.0 * of), request.folder);
}

Json RowToJson(const CoverageRow& row) {
  const double unit = TraitsOf(row.quantity).si_per_unit;
  Json json = {{"name", row.name}, {"unit", TraitsOf(row.quantity).unit}, {"trials", row.trials}};
  const auto number = [&](const char* key, bool known, double value) {
    json[key] = known && std::isfinite(value) ? Json(value) : Json(nullptr);
  };
  const bool any = row.trials > 0;
  const BinomialInterval interval = ClopperPearson(row.covered, std::max(1, row.trials), kLevel);
  number("coverage", any, row.covered / std::max(1.0, static_cast<double>(row.trials)));
  json["coverage_ci95"] = any ? Json::array({interval.low, interval.high}) : Json(nullptr);
  number("rmse", any, row.rmse / unit);
  number("bias", any, row.bias / unit);
  number("predicted_sigma", any, row.predicted_sigma / unit);
  number("cramer_rao_sigma", !row.conditional, row.cramer_rao / unit);
  number("efficiency", any && !row.conditional, row.rmse / row.cramer_rao);
  number("efficiency_same_draws", any && !row.conditional, row.rmse / row.linear_rmse);
  json["conditional"] = row.conditional;
  return json;
}

Json ResultToJson(const std::string& command, const CoverageRequest& request, const ExperimentInputs& inputs,
                  const CalibrationProblem& problem, const std::vector<CoverageTrial>& trials,
                  const std::vector<CoverageRow>& rows) {
  Json json = {{"schema", "sagitta/coverage/1"}, {"version", SAGITTA_VERSION}, {"command", command}};
  json["inputs"] = Json::array();
  for (const InputFile& input : inputs.files)
    json["inputs"].push_back({{"file", input.path}, {"sha256", input.sha256}});
  json["trials"] = trials.size();
  json["level"] = kLevel;
  json["seed"] = request.seed;
  json["method"] = WordOf(request.method);
  json["covariance"] = WordOf(problem.experiment().method.covariance);
  json["status"] = Json::object();
  for (const CoverageTrial& trial : trials) json["status"][trial.status] = json["status"].value(trial.status, 0) + 1;
  json["parameters"] = Json::array();
  for (const CoverageRow& row : rows) json["parameters"].push_back(RowToJson(row));
  return json;
}

std::string InWords(const Json& json, const std::vector<CoverageRow>& rows) {
  Section section;
  section.title = "Coverage of the 95 % intervals, " + json.at("trials").dump() + " trials, seed " +
                  json.at("seed").dump() + ", method " + json.at("method").get<std::string>() + ", covariance " +
                  json.at("covariance").get<std::string>();
  section.header = {"name", "coverage", "RMSE", "reported", "bound", "RMSE/bound", "same draws", "unit", ""};
  int outside = 0;
  for (size_t i = 0; i < rows.size(); ++i) {
    const Json& row = json.at("parameters")[i];
    const auto cell = [&](const char* key, int digits) {
      return row.at(key).is_null() ? std::string("-") : Significant(row.at(key).get<double>(), digits);
    };
    const Json& interval = row.at("coverage_ci95");
    const bool is_off =
        !interval.is_null() && (interval[0].get<double>() > kLevel || interval[1].get<double>() < kLevel);
    outside += is_off;
    section.rows.push_back({rows[i].name, cell("coverage", 4), cell("rmse", 3), cell("predicted_sigma", 3),
                            cell("cramer_rao_sigma", 3), cell("efficiency", 4), cell("efficiency_same_draws", 5),
                            row.at("unit").get<std::string>(),
                            rows[i].conditional ? "conditional"
                            : is_off            ? "not 95 %"
                                                : ""});
  }
  section.paragraphs = CoverageLegend(outside, rows.size());
  for (const auto& [status, count] : json.at("status").items()) {
    section.paragraphs.push_back("Status " + status + ": " + count.dump() + " trials.");
  }
  return SectionsToText({section});
}

int RunCoverage(const CommandLine& line) {
  ExpectArguments(line, CoverageCommand(), 1, 1000);
  const CoverageRequest request = RequestFromFlags();
  const OutputFolder out(request.folder, {"coverage.json"});
  const ExperimentInputs inputs = ReadInputs(line.arguments);
  const CalibrationProblem problem = PlausibleProblem(inputs);
  CheckMethod(problem, request.method);
  // Shares as measured on 250 rows of a UR10 and 2000 trials.
  Progress progress(FLAGS_quiet, {{"aligning", 0.01}, {"trials", 1.0}});
  JointOptions options;
  options.num_threads = request.threads;
  options.progress = [&progress](const std::string& what) { progress.Say(what); };
  const ResolvedEstimate resolved = EstimateWithNoise(problem, options);
  const Estimate& truth = resolved.estimate;
  if (!IsUsable(truth.status)) {
    std::cerr << "sagitta: no estimate to simulate at: " << StatusName(truth.status) << ": " << truth.message << "\n";
    return kNumericalFailure;
  }
  const CoverageStudy study(resolved.problem, truth, request.method, request.seed);
  CoverageState state(request.folder, IdentityOf(request, inputs, problem), study.coordinates().size());
  SayingWhatWasFound([&] { RunTrials(request, study, problem, &state, &progress); },
                     [&] { return FoundInTrials(request, study, FirstTrials(state, request.trials)); });
  const std::vector<CoverageTrial> trials = FirstTrials(state, request.trials);
  const std::vector<CoverageRow> rows = study.Summarise(trials);
  const Json json = ResultToJson(line.text, request, inputs, problem, trials, rows);
  out.Write({{"coverage.json", DumpJson(json)}});
  std::cout << InWords(json, rows) << "\n" << ResultsIn(request.folder, {"coverage.json"});
  return 0;
}

}  // namespace

Command CoverageCommand() {
  return {"coverage", "do the intervals hold what they promise: coverage and efficiency, simulated",
          R"(sagitta coverage EXP --trials=N --out=DIR

EXP is an experiment file, or ROBOT.yaml MEAS.csv…. The experiment is estimated; then it is simulated N times
at that estimate, loads, effects, repeatability and noise included, and estimated each time by --method with
the intervals that its `covariance` asks for. coverage.json says for every parameter how often the 95 %
interval holds the truth (with the Clopper-Pearson interval of that share), and the RMSE over the Cramér-Rao
bound. The same seed gives the same result, however many threads; a run that was interrupted goes on where it
stopped (coverage.state.jsonl in DIR).

Examples
  sagitta coverage experiment.yaml --trials=2000 --threads=2 --out=coverage
  sagitta coverage robot.yaml measurements.csv --sigma_mm=0.05 --method=two-step --trials=500 --out=coverage
)",
          WithProblemFlags({"trials", "method"}), RunCoverage};
}

}  // namespace sagitta

// sagitta compare: methods side by side on the same problem.
#include <gflags/gflags.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <optional>

#include "estimator/baselines/compare_methods.h"
#include "estimator/calibration/noise_loop.h"
#include "estimator/results/estimate_json.h"
#include "problems/input_error.h"
#include "problems/io/output_files.h"
#include "problems/loads.h"
#include "tools/commands.h"
#include "tools/problem_from_arguments.h"
#include "tools/progress.h"
#include "tools/report/command_words.h"
#include "tools/report/summary.h"
#include "tools/run_command.h"

DEFINE_string(methods, "",
              "the methods to compare, separated by commas; default: all, differencing where rows are loaded");

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

std::vector<Method> MethodsNamed(const std::string& names) {
  std::vector<Method> methods;
  if (names.empty()) return methods;
  for (const std::string& word : SplitText(names, ',')) methods.push_back(MethodNamed(word, "--methods"));
  return methods;
}

// All of them; differences exist where rows are loaded.
std::vector<Method> DefaultMethods(const Measurements& data) {
  std::vector<Method> methods = {Method::kJoint, Method::kTwoStep, Method::kTwoStepLiteral,
                                 Method::kTwoStepRelinearised, Method::kFullPose};
  if (std::any_of(data.shots.begin(), data.shots.end(), IsLoaded)) methods.push_back(Method::kDifferencing);
  return methods;
}

Json NumberIf(bool known, double value) { return known ? Json(value) : Json(nullptr); }

Json MethodToJson(const MethodResult& result) {
  const Estimate& estimate = result.estimate;
  const bool has_run = estimate.fit.observations > 0;
  Json json = {{"name", result.name},
               {"status", StatusName(estimate.status)},
               {"message", estimate.message},
               {"iterations", estimate.iterations},
               {"seconds", estimate.seconds}};
  json["cost"] = NumberIf(has_run, estimate.cost);
  json["rms_mm"] = NumberIf(has_run, 1e3 * estimate.fit.rms);
  json["distance_rms_mm"] = NumberIf(has_run, 1e3 * estimate.fit.distance_rms);
  json["parameters"] = Json::object();
  for (const ParameterEstimate& row : estimate.table) {
    json["parameters"][row.name] = row.value / TraitsOf(row.quantity).si_per_unit;
  }
  json["sigmas"] = Json::object();
  for (const ParameterEstimate& row : estimate.table) {
    if (row.free) json["sigmas"][row.name] = row.sigma / TraitsOf(row.quantity).si_per_unit;
  }
  json["max_deviation_sigma"] = result.max_deviation_sigma;
  json["rate_measured"] = result.rate_measured;
  json["rate_predicted"] = result.rate_predicted;
  return json;
}

std::string OrDash(double value, int digits) { return std::isfinite(value) ? Significant(value, digits) : "-"; }

Section Table(const std::vector<MethodResult>& results) {
  Section section;
  section.title = "Methods on the same data";
  section.header = {"method", "status", "iterations", "seconds", "cost", "RMS mm", "off by sigma", "rate", "predicted"};
  for (const MethodResult& result : results) {
    const Estimate& estimate = result.estimate;
    section.rows.push_back({result.name, StatusName(estimate.status), std::to_string(estimate.iterations),
                            Fixed(estimate.seconds, 3), estimate.fit.observations > 0 ? OrDash(estimate.cost, 8) : "-",
                            estimate.fit.observations > 0 ? Fixed(1e3 * estimate.fit.rms, 5) : "-",
                            OrDash(result.max_deviation_sigma, 3), OrDash(result.rate_measured, 4),
                            OrDash(result.rate_predicted, 4)});
  }
  section.paragraphs = MethodsLegend();
  for (const MethodResult& result : results) {
    if (!IsUsable(result.estimate.status)) section.paragraphs.push_back(result.name + ": " + result.estimate.message);
    for (const std::string& warning : result.estimate.warnings)
      section.paragraphs.push_back(result.name + ": " + warning);
  }
  return section;
}

Json ComparisonToJson(const CommandLine& line, const ExperimentInputs& inputs,
                      const std::vector<MethodResult>& results) {
  Json json = {{"schema", "sagitta/comparison/1"}, {"version", SAGITTA_VERSION}, {"command", line.text}};
  json["inputs"] = Json::array();
  for (const InputFile& input : inputs.files)
    json["inputs"].push_back({{"file", input.path}, {"sha256", input.sha256}});
  json["units"] = Json::object();  // of parameters and sigmas of every method
  for (const MethodResult& result : results) {
    for (const ParameterEstimate& row : result.estimate.table) json["units"][row.name] = TraitsOf(row.quantity).unit;
  }
  json["methods"] = Json::array();
  for (const MethodResult& result : results) json["methods"].push_back(MethodToJson(result));
  return json;
}

int RunCompare(const CommandLine& line) {
  ExpectArguments(line, CompareCommand(), 1, 1000);
  std::vector<Method> methods = MethodsNamed(FLAGS_methods);
  std::optional<OutputFolder> out;
  if (!FLAGS_out.empty()) out.emplace(FLAGS_out, std::vector<std::string>{"comparison.json"});
  const ExperimentInputs inputs = ReadInputs(line.arguments);
  if (methods.empty()) methods = DefaultMethods(inputs.data);
  const CalibrationProblem problem = PlausibleProblem(inputs);

  std::vector<MethodResult> results;
  {
    std::vector<ProgressPhase> phases = {{"fitting jointly", 1.0}};
    for (const Method method : methods) phases.push_back({"running " + WordOf(method), 1.0});
    Progress progress(FLAGS_quiet, phases);
    progress.Say("fitting jointly, to compare with");
    JointOptions options;
    options.num_threads = FLAGS_threads;
    const ResolvedEstimate resolved = EstimateWithNoise(problem, options);
    const Estimate& joint = resolved.estimate;
    if (!IsUsable(joint.status)) {
      std::cerr << "sagitta: no joint estimate to compare with: " << StatusName(joint.status) << ": " << joint.message
                << "\n";
      return kNumericalFailure;
    }
    const auto run = [&] {
      for (const Method method : methods) {
        progress.Say("running " + WordOf(method));
        results.push_back(
            RunMethod(resolved.problem, method, joint, [&progress](const std::string& what) { progress.Say(what); }));
      }
    };
    SayingWhatWasFound(run, [&] { return results.empty() ? "" : SectionsToText({Table(results)}); });
  }
  std::cout << SectionsToText({Table(results)});
  if (FLAGS_out.empty()) {
    std::cout << NothingIsWritten();
    return 0;
  }
  out->Write({{"comparison.json", DumpJson(ComparisonToJson(line, inputs, results))}});
  std::cout << "\n" << ResultsIn(FLAGS_out, {"comparison.json"});
  return 0;
}

}  // namespace

Command CompareCommand() {
  return {"compare", "methods side by side: optimum, bias, iterations, time",
          R"(sagitta compare EXP --methods=joint,two-step,… --out=DIR

EXP is an experiment file, or ROBOT.yaml MEAS.csv…. Methods: joint; two-step (exact halves), two-step-literal
(as papers 000 and 002 print it), two-step-relinearised; full-pose; differencing (the papers' way with loads:
compliances and compensator from loaded minus unloaded points). Writes comparison.json to DIR.

Examples
  sagitta compare experiment.yaml --out=results
  sagitta compare robot.yaml measurements.csv --sigma_mm=0.1 --methods=joint,two-step-literal --out=results
  sagitta compare loaded.yaml --methods=joint,differencing --out=results
)",
          WithProblemFlags({"methods"}), RunCompare};
}

}  // namespace sagitta

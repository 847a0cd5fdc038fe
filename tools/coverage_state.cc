#include "tools/coverage_state.h"

#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

#include "problems/input_error.h"
#include "problems/io/files.h"
#include "problems/io/json_reader.h"
#include "problems/io/output_files.h"
#include "problems/limits.h"

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kAnotherFolder = "give another --out, or delete this file to start anew";

Json NumbersToJson(const std::vector<double>& numbers) {
  Json json = Json::array();
  for (const double number : numbers) json.push_back(std::isfinite(number) ? Json(number) : Json(nullptr));
  return json;
}

std::vector<double> NumbersFrom(const JsonValue& json, size_t count) {
  std::vector<double> numbers;
  for (const JsonValue& number : json.Items()) {
    numbers.push_back(number.NumberOrNull().value_or(std::numeric_limits<double>::quiet_NaN()));
  }
  if (numbers.size() != count) json.Fail("one number per coordinate is expected");
  return numbers;
}

Json TrialToJson(const CoverageTrial& trial) {
  return {{"trial", trial.number},
          {"status", trial.status},
          {"error", NumbersToJson(trial.error)},
          {"linear_error", NumbersToJson(trial.linear_error)},
          {"sigma", NumbersToJson(trial.sigma)},
          {"covered", trial.covered}};
}

CoverageTrial TrialFrom(const JsonValue& json, size_t coordinates) {
  CoverageTrial trial;
  const double number = json.Get("trial").NotNegativeNumber();
  if (number > limits::kTrials) json.Fail("there are not so many trials");
  trial.number = static_cast<int>(number);
  trial.status = json.Get("status").Text();
  trial.error = NumbersFrom(json.Get("error"), coordinates);
  trial.linear_error = NumbersFrom(json.Get("linear_error"), coordinates);
  trial.sigma = NumbersFrom(json.Get("sigma"), coordinates);
  for (const double covered : NumbersFrom(json.Get("covered"), coordinates)) trial.covered.push_back(covered == 1.0);
  return trial;
}

// Nothing for a line that was cut off: that trial is run again.
std::optional<CoverageTrial> ReadTrial(const std::string& line, const std::string& path, size_t coordinates) {
  try {
    const Json json = ParseJson(line, path);
    return TrialFrom(JsonValue(json, path), coordinates);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

Json ReadIdentity(const std::string& line, const std::string& path) {
  try {
    const Json json = ParseJson(line, path);
    if (json.is_object()) return json;
  } catch (const InputError&) {  // said below
  }
  throw InputError({path, 1, ""}, "this is not the state of a coverage run", kAnotherFolder);
}

}  // namespace

CoverageState::CoverageState(const std::string& folder, const Json& identity, size_t coordinates)
    : path_(folder + "/coverage.state.jsonl") {
  if (std::filesystem::exists(path_)) Read(identity, coordinates);
  // Whole lines only, from here on appended to.
  std::string text = identity.dump() + "\n";
  for (const auto& [number, trial] : trials_) text += TrialToJson(trial).dump() + "\n";
  WriteTextFile(path_, text);
  file_.open(path_, std::ios::app | std::ios::binary);
  if (!file_) throw InputError({path_, 0, ""}, "the state of the run cannot be written");
}

void CoverageState::Read(const Json& identity, size_t coordinates) {
  std::istringstream lines(ReadOwnFile(path_));
  std::string line;
  std::getline(lines, line);
  const Json theirs = ReadIdentity(line, path_);
  for (const auto& [key, value] : identity.items()) {
    if (theirs.contains(key) && theirs.at(key) == value) continue;
    throw InputError({path_, 1, key},
                     "this folder holds another run: " + key + " " +
                         (theirs.contains(key) ? theirs.at(key).dump() : "not stated") + " there, " + value.dump() +
                         " here",
                     kAnotherFolder);
  }
  while (std::getline(lines, line)) {
    if (std::optional<CoverageTrial> trial = ReadTrial(line, path_, coordinates)) {
      trials_[trial->number] = std::move(*trial);
    }
  }
}

void CoverageState::Add(const CoverageTrial& trial) {
  const std::lock_guard<std::mutex> lock(mutex_);
  trials_[trial.number] = trial;
  file_ << TrialToJson(trial).dump() << "\n" << std::flush;
  if (!file_) throw InputError({path_, 0, ""}, "the state of the run cannot be written");
}

}  // namespace sagitta

#include "tools/coverage_state.h"

#include <cmath>
#include <filesystem>
#include <limits>
#include <sstream>

#include "problems/input_error.h"
#include "problems/io/files.h"

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

Json NumbersToJson(const std::vector<double>& numbers) {
  Json json = Json::array();
  for (const double number : numbers) json.push_back(std::isfinite(number) ? Json(number) : Json(nullptr));
  return json;
}

std::vector<double> NumbersFrom(const Json& json) {
  std::vector<double> numbers;
  for (const Json& number : json) {
    numbers.push_back(number.is_null() ? std::numeric_limits<double>::quiet_NaN() : number.get<double>());
  }
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

// False for a line that was cut off.
bool ReadTrial(const std::string& line, size_t coordinates, CoverageTrial* trial) {
  const Json json = Json::parse(line, nullptr, false);
  if (!json.is_object()) return false;
  try {
    trial->number = json.at("trial").get<int>();
    trial->status = json.at("status").get<std::string>();
    trial->error = NumbersFrom(json.at("error"));
    trial->linear_error = NumbersFrom(json.at("linear_error"));
    trial->sigma = NumbersFrom(json.at("sigma"));
    trial->covered = json.at("covered").get<std::vector<int>>();
  } catch (const nlohmann::json::exception&) {
    return false;
  }
  return trial->error.size() == coordinates && trial->linear_error.size() == coordinates &&
         trial->sigma.size() == coordinates && trial->covered.size() == coordinates;
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
}

void CoverageState::Read(const Json& identity, size_t coordinates) {
  std::istringstream lines(ReadTextFile(path_));
  std::string line;
  std::getline(lines, line);
  const Json theirs = Json::parse(line, nullptr, false);
  const char* hint = "give another --out, or delete this file to start anew";
  if (!theirs.is_object()) throw InputError({path_, 1, ""}, "this is not the state of a coverage run", hint);
  for (const auto& [key, value] : identity.items()) {
    if (theirs.contains(key) && theirs.at(key) == value) continue;
    throw InputError({path_, 1, key},
                     "this folder holds another run: " + key + " " +
                         (theirs.contains(key) ? theirs.at(key).dump() : "not stated") + " there, " + value.dump() +
                         " here",
                     hint);
  }
  while (std::getline(lines, line)) {
    CoverageTrial trial;
    if (ReadTrial(line, coordinates, &trial)) trials_[trial.number] = std::move(trial);
  }
}

void CoverageState::Add(const CoverageTrial& trial) {
  const std::lock_guard<std::mutex> lock(mutex_);
  trials_[trial.number] = trial;
  file_ << TrialToJson(trial).dump() << "\n" << std::flush;
  if (!file_) throw InputError({path_, 0, ""}, "the state of the run cannot be written");
}

}  // namespace sagitta

// What a coverage run has done so far, so that an interrupted one goes on:
// coverage.state.jsonl in the output folder, a line that says which run, then one
// line per finished trial, in the order in which they finished.
#pragma once

#include <fstream>
#include <map>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "estimator/intervals/coverage.h"

namespace sagitta {

class CoverageState {
 public:
  // `identity`: what makes two runs the same ("seed", "method", … -> value). Reads
  // what the folder has; throws InputError if that is of another run.
  CoverageState(const std::string& folder, const nlohmann::ordered_json& identity, size_t coordinates);

  const std::map<int, CoverageTrial>& trials() const { return trials_; }
  // Thread-safe; with the operating system when it returns: it outlives this program, not a power failure.
  void Add(const CoverageTrial& trial);

 private:
  void Read(const nlohmann::ordered_json& identity, size_t coordinates);

  std::string path_;
  std::map<int, CoverageTrial> trials_;
  std::mutex mutex_;
  std::ofstream file_;
};

}  // namespace sagitta

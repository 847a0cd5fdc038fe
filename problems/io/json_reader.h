// The one reader of JSON: strict, with limits, and typed access whose errors name file and key.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "models/geometry.h"

namespace sagitta {

// UTF-8, at most limits::kFileBytes long and limits::kDepth deep, no key twice in one map, numbers that a double
// holds. Throws InputError with the line.
nlohmann::ordered_json ParseJson(const std::string& text, const std::string& file_in_messages);

// A value with its place: "held.sigma[2]". Throws InputError for what is not as asked. The JSON has to outlive it.
class JsonValue {
 public:
  using Json = nlohmann::ordered_json;
  JsonValue(const Json& json, std::string file, std::string path = "")
      : json_(&json), file_(std::move(file)), path_(std::move(path)) {}

  [[noreturn]] void Fail(const std::string& what, const std::string& hint = "") const;

  bool IsNull() const;
  bool IsMap() const;
  const Json& json() const { return *json_; }
  const std::string& path() const { return path_; }

  // Keys of a map. Find: nothing where it is absent.
  JsonValue Get(const std::string& key) const;
  std::optional<JsonValue> Find(const std::string& key) const;
  std::vector<std::pair<std::string, JsonValue>> Entries() const;
  std::vector<JsonValue> Items() const;

  std::string Text() const;                // without control characters
  std::vector<std::string> Names() const;  // a list of texts, none twice
  bool Flag() const;
  double Number() const;  // finite
  double PositiveNumber() const;
  double NotNegativeNumber() const;
  std::optional<double> NumberOrNull() const;
  Vector3<double> Triple() const;
  // rows x columns numbers; null is NaN where `nulls`, else refused.
  Eigen::MatrixXd Matrix(Eigen::Index rows, Eigen::Index columns, bool nulls) const;
  // A square matrix of correlations: symmetric, 1 on the diagonal, none beyond 1, no variance below 0. Symmetrised.
  Eigen::MatrixXd Correlation(Eigen::Index size, bool nulls) const;

 private:
  const Json* json_;
  std::string file_, path_;
};

}  // namespace sagitta

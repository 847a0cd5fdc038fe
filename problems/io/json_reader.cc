#include "problems/io/json_reader.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "problems/input_error.h"
#include "problems/io/text_checks.h"
#include "problems/limits.h"

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

// Rounding of numbers that were written with all their digits, with room for files whose digits were cut to ten.
constexpr double kRounding = 1e-9;

int LineOf(const std::string& text, size_t byte) {
  return 1 + static_cast<int>(std::count(text.begin(), text.begin() + std::min(byte, text.size()), '\n'));
}

// Before the parser sees them: its values are destroyed, copied and written by recursion.
void CheckDepth(const std::string& text, const std::string& file) {
  int depth = 0;
  bool in_text = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_text) {
      if (c == '\\') ++i;
      in_text = c != '"';
    } else if (c == '"') {
      in_text = true;
    } else if (c == '[' || c == '{') {
      if (++depth > limits::kDepth) {
        throw InputError({file, LineOf(text, i), ""},
                         "lists and maps are nested more than " + std::to_string(limits::kDepth) + " deep");
      }
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
}

std::string QuotedName(const std::string& name) { return "'" + Printable(name.substr(0, 60)) + "'"; }

std::string KindOfJson(const Json& json) {
  if (json.is_object()) return "a map";
  if (json.is_array()) return "a list of " + std::to_string(json.size());
  if (json.is_string()) return "the text " + QuotedName(json.get_ref<const std::string&>());
  return json.is_null() ? "null" : json.dump();
}

// Correlations of nothing below zero: the pivots of a Cholesky decomposition, with room for rounding.
bool IsPositive(const Eigen::MatrixXd& correlation) {
  if (correlation.size() == 0) return true;
  const Eigen::Index n = correlation.rows();
  const Eigen::MatrixXd raised = correlation + 1e-6 * Eigen::MatrixXd::Identity(n, n);
  return raised.llt().info() == Eigen::Success;
}

}  // namespace

Json ParseJson(const std::string& text, const std::string& file) {
  if (text.size() > limits::kFileBytes) {
    throw InputError({file, 0, ""}, "the file is longer than " + std::to_string(limits::kFileBytes >> 20) + " MB");
  }
  CheckDepth(text, file);
  std::vector<std::set<std::string>> keys;  // of the maps that are open
  const auto refuse_twice = [&](int, Json::parse_event_t event, Json& parsed) {
    if (event == Json::parse_event_t::object_start) keys.emplace_back();
    if (event == Json::parse_event_t::object_end) keys.pop_back();
    if (event != Json::parse_event_t::key) return true;
    const std::string& key = parsed.get_ref<const std::string&>();
    if (!keys.back().insert(key).second)
      throw InputError({file, 0, Printable(key)}, "this key stands twice in one map");
    return true;
  };
  try {
    return Json::parse(text, refuse_twice);
  } catch (const Json::parse_error& error) {
    const size_t first = text.find_first_not_of(" \t\r\n");
    const bool begins = first != std::string::npos && (text[first] == '{' || text[first] == '[');
    throw InputError({file, LineOf(text, error.byte), ""}, "this is not JSON, from here on at the latest",
                     begins ? "is the file complete?" : "a file as estimate.json belongs here");
  } catch (const Json::exception&) {
    throw InputError({file, 0, ""}, "this is not JSON: a number in it is larger than any that can be computed with");
  }
}

void JsonValue::Fail(const std::string& what, const std::string& hint) const {
  throw InputError({file_, 0, path_}, what, hint);
}

bool JsonValue::IsNull() const { return json_->is_null(); }

bool JsonValue::IsMap() const { return json_->is_object(); }

std::optional<JsonValue> JsonValue::Find(const std::string& key) const {
  if (!json_->is_object()) Fail("a map is expected, this is " + KindOfJson(*json_));
  const auto found = json_->find(key);
  if (found == json_->end()) return std::nullopt;
  return JsonValue(*found, file_, path_.empty() ? key : path_ + "." + key);
}

JsonValue JsonValue::Get(const std::string& key) const {
  const std::optional<JsonValue> found = Find(key);
  if (!found) throw InputError({file_, 0, path_.empty() ? key : path_ + "." + key}, "this key is missing");
  return *found;
}

std::vector<std::pair<std::string, JsonValue>> JsonValue::Entries() const {
  if (!json_->is_object()) Fail("a map is expected, this is " + KindOfJson(*json_));
  std::vector<std::pair<std::string, JsonValue>> entries;
  for (const auto& [key, value] : json_->items()) {
    if (HasControlCharacter(key)) Fail("the name " + QuotedName(key) + " holds a control character");
    entries.emplace_back(key, JsonValue(value, file_, path_.empty() ? key : path_ + "." + key));
  }
  return entries;
}

std::vector<JsonValue> JsonValue::Items() const {
  if (!json_->is_array()) Fail("a list is expected, this is " + KindOfJson(*json_));
  std::vector<JsonValue> items;
  items.reserve(json_->size());
  for (const Json& item : *json_) items.emplace_back(item, file_, path_ + "[" + std::to_string(items.size()) + "]");
  return items;
}

std::string JsonValue::Text() const {
  if (!json_->is_string()) Fail("a text is expected, this is " + KindOfJson(*json_));
  const std::string& text = json_->get_ref<const std::string&>();
  if (HasControlCharacter(text)) Fail(QuotedName(text) + " holds a control character");
  return text;
}

std::vector<std::string> JsonValue::Names() const {
  std::vector<std::string> names;
  std::set<std::string> seen;
  for (const JsonValue& item : Items()) {
    names.push_back(item.Text());
    if (!seen.insert(names.back()).second) item.Fail(QuotedName(names.back()) + " stands twice");
  }
  return names;
}

bool JsonValue::Flag() const {
  if (!json_->is_boolean()) Fail("true or false is expected, this is " + KindOfJson(*json_));
  return json_->get<bool>();
}

double JsonValue::Number() const {
  const double number = json_->is_number() ? json_->get<double>() : std::numeric_limits<double>::quiet_NaN();
  if (!std::isfinite(number)) Fail("a finite number is expected, this is " + KindOfJson(*json_));
  return number;
}

double JsonValue::PositiveNumber() const {
  const double number = Number();
  if (!(number > 0.0)) Fail("a number above 0 is expected, this is " + KindOfJson(*json_));
  return number;
}

double JsonValue::NotNegativeNumber() const {
  const double number = Number();
  if (number < 0.0) Fail("a number of 0 or more is expected, this is " + KindOfJson(*json_));
  return number;
}

std::optional<double> JsonValue::NumberOrNull() const {
  if (json_->is_null()) return std::nullopt;
  return Number();
}

Vector3<double> JsonValue::Triple() const {
  if (!json_->is_array() || json_->size() != 3) Fail("three numbers are expected, this is " + KindOfJson(*json_));
  return Vector3<double>(Items()[0].Number(), Items()[1].Number(), Items()[2].Number());
}

Eigen::MatrixXd JsonValue::Matrix(Eigen::Index rows, Eigen::Index columns, bool nulls) const {
  const auto list_of = [this](const Json& json, Eigen::Index size, const std::string& of) {
    if (json.is_array() && static_cast<Eigen::Index>(json.size()) == size) return;
    Fail(of + " of " + std::to_string(size) + " is expected, this is " + KindOfJson(json));
  };
  list_of(*json_, rows, "a list of rows");
  Eigen::MatrixXd matrix(rows, columns);
  for (Eigen::Index r = 0; r < rows; ++r) {
    const Json& row = (*json_)[r];
    list_of(row, columns, "row " + std::to_string(r + 1) + ": a list");
    for (Eigen::Index c = 0; c < columns; ++c) {
      const bool unknown = nulls && row[c].is_null();
      matrix(r, c) = row[c].is_number() ? row[c].get<double>() : std::numeric_limits<double>::quiet_NaN();
      if (!unknown && !std::isfinite(matrix(r, c))) {
        Fail("row " + std::to_string(r + 1) + ", column " + std::to_string(c + 1) +
             ": a finite number is expected, this is " + KindOfJson(row[c]));
      }
    }
  }
  return matrix;
}

Eigen::MatrixXd JsonValue::Correlation(Eigen::Index size, bool nulls) const {
  Eigen::MatrixXd matrix = Matrix(size, size, nulls);
  const auto fail = [this](Eigen::Index r, Eigen::Index c, const std::string& what) {
    Fail("row " + std::to_string(r + 1) + ", column " + std::to_string(c + 1) + ": " + what);
  };
  for (Eigen::Index r = 0; r < size; ++r) {
    for (Eigen::Index c = 0; c <= r; ++c) {
      const double a = matrix(r, c), b = matrix(c, r);
      if (std::isnan(a) != std::isnan(b)) fail(r, c, "known on one side of the diagonal only");
      if (std::abs(a - b) > kRounding) fail(r, c, "not the number on the other side of the diagonal");
      if (r == c && std::abs(a - 1.0) > kRounding) fail(r, c, "a correlation with itself is 1");
      if (std::abs(a) > 1.0 + kRounding) fail(r, c, "a correlation lies between -1 and 1");
      matrix(r, c) = matrix(c, r) = std::clamp(0.5 * (a + b), -1.0, 1.0);
    }
  }
  if (!matrix.hasNaN() && !IsPositive(matrix)) {
    Fail("these correlations contradict each other: a combination of the values would have a variance below 0");
  }
  return matrix;
}

}  // namespace sagitta

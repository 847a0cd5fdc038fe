#include "problems/io/import/imported_rows.h"

#include <algorithm>
#include <cstdio>
#include <set>

#include "problems/input_error.h"
#include "problems/interruption.h"
#include "problems/io/text_checks.h"

namespace sagitta {

void ImportedRows::Add(const TextTable& table, const ImportPlan& plan, const RowDefaults& defaults, size_t stride) {
  TableRows reader(table, plan, defaults, &names_);
  std::vector<ImportedRow> rows = reader.Read(stride);
  for (const std::string& note : reader.Notes()) notes_.push_back(note);
  if (rows.empty()) throw InputError({table.path, 0, ""}, "no row holds a reading", "");
  int joints = 0;
  while (plan.Find("q" + std::to_string(joints + 1))) ++joints;
  NameConfigurations(&rows, plan.Find("config") != nullptr, joints);
  rows_.insert(rows_.end(), rows.begin(), rows.end());
}

// The joint values of a row, as text: equal ones are one configuration.
void ImportedRows::NameConfigurations(std::vector<ImportedRow>* rows, bool has_column, int joints) {
  const auto joint_key = [joints](const ImportedRow& row) {
    std::string key;
    for (int j = 1; j <= joints; ++j) {
      const auto at = row.lower_bound("q" + std::to_string(j) + "_");
      key += at->first + "=" + at->second + ";";
    }
    return key;
  };
  std::map<std::string, std::string> config_of, joints_of;
  for (const ImportedRow& row : rows_) {
    CheckInterruption();
    config_of.emplace(joint_key(row), row.at("config"));
    joints_of.emplace(row.at("config"), joint_key(row));
  }
  // A stated id is kept where it means one set of joint values, here and in the files before.
  bool keep = has_column;
  if (has_column) {
    std::map<std::string, std::string> stated = joints_of;
    for (const ImportedRow& row : *rows) {
      CheckInterruption();
      const std::string& id = row.at("config");
      keep = keep && !id.empty() && stated.emplace(id, joint_key(row)).first->second == joint_key(row);
    }
    if (!keep) notes_.push_back("the ids of configurations are not used: one id stands for different joint values");
  }
  size_t number = config_of.size();
  for (ImportedRow& row : *rows) {
    CheckInterruption();
    if (keep) break;
    const auto [config, is_new] = config_of.emplace(joint_key(row), "");
    bool is_taken = is_new;  // a file before may state the very id that comes next
    while (is_taken) {
      char name[32];
      std::snprintf(name, sizeof name, "c%05zu", ++number);
      config->second = name;
      is_taken = joints_of.count(name) > 0;
    }
    row["config"] = config->second;
  }
}

std::string ImportedRows::SourceOf(size_t row) const {
  return row < rows_.size() && rows_[row].count("source") > 0 ? rows_[row].at("source") : "";
}

std::string ImportedRows::ToCsv(int joints) const {
  std::set<std::string> present;
  for (const ImportedRow& row : rows_) {
    CheckInterruption();
    for (const auto& [column, cell] : row) present.insert(column);
  }
  std::vector<std::string> order = {"config", "marker", "station", "visit", "repeat", "load", "set"};
  const auto add_all = [&](const std::string& stem) {
    for (const std::string& column : present) {
      if (column.rfind(stem + "_", 0) == 0) order.push_back(column);
    }
  };
  for (int j = 1; j <= joints; ++j) add_all("q" + std::to_string(j));
  for (const char* stem :
       {"x",        "y",        "z",  "sigma_x", "sigma_y", "sigma_z", "rx", "ry", "rz",   "sigma_rx",
        "sigma_ry", "sigma_rz", "fx", "fy",      "fz",      "mx",      "my", "mz", "time", "temperature"})
    add_all(stem);
  for (int j = 1; j <= joints; ++j) add_all("tau" + std::to_string(j));
  for (int j = 1; j <= joints; ++j) order.push_back("approach" + std::to_string(j));
  order.push_back("source");
  order.erase(std::remove_if(order.begin(), order.end(), [&](const std::string& c) { return !present.count(c); }),
              order.end());
  std::string text;
  for (const std::string& column : order) text += (text.empty() ? "" : ",") + column;
  text += "\n";
  for (const ImportedRow& row : rows_) {
    CheckInterruption();
    for (size_t c = 0; c < order.size(); ++c) {
      const auto cell = row.find(order[c]);
      const std::string value = cell == row.end() ? "" : cell->second;
      text += (c == 0 ? "" : ",") + CsvCell(value);
    }
    text += "\n";
  }
  return text;
}

}  // namespace sagitta

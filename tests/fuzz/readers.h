// What the fuzzers feed: one function per reader. Each may throw InputError and nothing else.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "problems/input_error.h"
#include "problems/io/csv_table.h"
#include "problems/io/experiment_file.h"
#include "problems/io/import/column_meaning.h"
#include "problems/io/import/expressions.h"
#include "problems/io/import/import_plan.h"
#include "problems/io/import/imported_rows.h"
#include "problems/io/import/joined_tables.h"
#include "problems/io/import/robot_reading.h"
#include "problems/io/json_reader.h"
#include "problems/io/measurement_file.h"
#include "problems/io/measurement_writer.h"
#include "problems/io/robot_file.h"
#include "problems/io/text_checks.h"
#include "problems/io/units.h"
#include "problems/io/urdf_robot.h"
#include "problems/text.h"

namespace sagitta::fuzz {

inline const Robot& TwoJoints() {
  static const Robot robot = ReadRobotText(
      "schema: sagitta/robot/1\njoints: [{name: a, type: revolute}, {name: b, type: prismatic}]\n"
      "kinematics: {chain: [{Rz: a}, {Tx_mm: 100}, {Tx: b}]}\n",
      "two.yaml");
  return robot;
}

// Of what must hold: ends the program where it does not.
inline void Require(bool holds, const char* what_else) {
  if (holds) return;
  std::fprintf(stderr, "%s\n", what_else);
  std::abort();
}

// A robot that was read is written, and what was written is read.
inline void ReadRobot(const std::string& text) {
  const Robot robot = ReadRobotText(text, "robot.yaml");
  ReadRobotText(RobotToYaml(robot), "again.yaml", robot.own_effects);
}

inline void ReadUrdf(const std::string& text) { RobotToYaml(ReadUrdfText(text, "robot.urdf")); }

inline void ReadMeasurements(const std::string& text) {
  MeasurementReadOptions options;
  options.points_required = text.size() % 2 == 0;
  const Measurements rows = ReadMeasurementsText(TwoJoints(), text, "rows.csv", options);
  ReadMeasurementsText(TwoJoints(), MeasurementsToCsv(rows), "again.csv", options);
}

inline void ReadExperiment(const std::string& text) { ReadExperimentText(text, "experiment.yaml"); }

inline void ReadForeignRobot(const std::string& text) { RobotToYaml(ReadAnyRobotText(text, "robot.csv").robot); }

inline void ImportTable(const TextTable& table) {
  for (const ImportPlan& plan : PossiblePlans(table, TwoJoints().chain.joints, {})) {
    ImportedRows rows;
    rows.Add(table, plan, {});
    rows.ToCsv(2);
  }
}

inline void ReadForeignTable(const std::string& text) { ImportTable(ParseTextTable(text, "table.txt")); }

// Several files with a form feed between them: points, and lists of the poses.
inline void ReadJoinedTables(const std::string& text) {
  std::vector<TextTable> tables;
  for (size_t at = 0; at <= text.size();) {
    const size_t end = std::min(text.find('\f', at), text.size());
    tables.push_back(ParseTextTable(text.substr(at, end - at), std::to_string(tables.size()) + ".txt"));
    at = end + 1;
  }
  for (const TextTable& joined : JoinPosesByName(tables, TwoJoints().chain.joints)) {
    for (const TextTable::Row& row : joined.rows) {
      Require(row.cells.size() == joined.header.size(), "a joined row of another length than the header");
    }
    ImportTable(joined);
  }
}

// What is read is written, and reads as the same.
inline void ReadJson(const std::string& text) {
  const nlohmann::ordered_json json = ParseJson(text, "e.json");
  Require(ParseJson(json.dump(), "again.json") == json, "a JSON text reads otherwise after it was written");
}

inline void ReadCsv(const std::string& text) {
  const CsvTable table = ParseCsvTable(text, "rows.csv");
  Require(!table.file.rows.empty(), "a table without rows");
  for (const MeasurementFile::Row& row : table.file.rows) {
    Require(row.cells.size() == table.file.header.size(), "a row of another length than the header");
  }
}

// Numbers as people type them into tables: pi/2, 90°, q1 + 90.
inline void ReadExpression(const std::string& text) {
  for (const bool comma : {false, true}) {
    const std::optional<TypedNumber> typed = ParseTypedNumber(text, comma);
    Require(!typed || std::isfinite(typed->value), "a typed number that is not finite");
    const std::optional<JointExpression> joint = ParseJointExpression(text, comma);
    Require(!joint || std::isfinite(joint->offset.value), "an offset that is not finite");
  }
}

// One number: against the C library's reading of it, and through every unit and back.
inline void ReadNumber(const std::string& text) {
  for (const bool comma : {false, true}) {
    const std::optional<double> local = ParseLocalNumber(text, comma);
    Require(!local || std::isfinite(*local), "a number of a table that is not finite");
  }
  const std::optional<double> number = ParseNumber(text);
  if (!number) return;
  char* end = nullptr;
  Require(*number == std::strtod(text.c_str(), &end), "a number is not that of the C library");
  Require(end == text.c_str() + text.size(), "a number ends elsewhere than that of the C library");
  Require(ParseNumber(FormatNumber(*number)) == number, "a number reads otherwise after it was written");
  for (const Dimension dimension : {Dimension::kSmallLength, Dimension::kAngle}) {
    for (const Unit& unit : UnitsOf(dimension)) {
      const double si = unit.ToSi(*number), size = std::abs(si);
      if (size < 1e-290 || size > 1e290) continue;  // where units themselves lose digits
      Require(std::abs(unit.ToSi(ToUnit(si, unit)) - si) <= 4e-16 * size, "a quantity changes by its unit");
    }
  }
}

// For LLVMFuzzerTestOneInput.
template <typename Reader>
int Feed(const Reader& reader, const unsigned char* data, size_t size) {
  try {
    reader(std::string(reinterpret_cast<const char*>(data), size));
  } catch (const InputError&) {  // refused with words: as it has to be
  }
  return 0;
}

}  // namespace sagitta::fuzz

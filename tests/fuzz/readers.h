// What the fuzzers feed: one function per reader. Each may throw InputError and nothing else.
#pragma once

#include <string>

#include "problems/input_error.h"
#include "problems/io/experiment_file.h"
#include "problems/io/import/column_meaning.h"
#include "problems/io/import/import_plan.h"
#include "problems/io/import/imported_rows.h"
#include "problems/io/import/robot_reading.h"
#include "problems/io/json_reader.h"
#include "problems/io/measurement_file.h"
#include "problems/io/measurement_writer.h"
#include "problems/io/robot_file.h"
#include "problems/io/urdf_robot.h"

namespace sagitta::fuzz {

inline const Robot& TwoJoints() {
  static const Robot robot = ReadRobotText(
      "schema: sagitta/robot/1\njoints: [{name: a, type: revolute}, {name: b, type: prismatic}]\n"
      "kinematics: {chain: [{Rz: a}, {Tx_mm: 100}, {Tx: b}]}\n",
      "two.yaml");
  return robot;
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

inline void ReadForeignTable(const std::string& text) {
  const TextTable table = ParseTextTable(text, "table.txt");
  for (const ImportPlan& plan : PossiblePlans(table, TwoJoints().chain.joints, {})) {
    ImportedRows rows;
    rows.Add(table, plan, {});
    rows.ToCsv(2);
  }
}

inline void ReadJson(const std::string& text) { ParseJson(text, "e.json"); }

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

// The files of a case: what the workflow is given, and the sealed answer.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/hidden_effects/generator/hidden_effect.h"

namespace hidden {

struct CaseOptions {
  std::uint64_t study = 1, number = 0;
  std::string robot = "kr270";
  std::vector<std::string> kinds;  // empty: nothing hidden
  std::vector<double> scales;      // one per kind
  DesignOptions design;
  int markers = 3;
  double repeatability = 0.0;             // rad per joint, declared
  double stated_factor = 1.0;             // of it, what is declared instead
  double undeclared_repeatability = 0.0;  // rad per joint
  double sigma_factor = 1.0;              // true over stated sigma
  std::string group;                      // readings whose noise has a factor of its own: station, marker, axis, sight
  double group_factor = 1.0;              // of the last station, the second marker, z, the line of sight
  double outliers = 0.0;                  // share of the rows
  std::string noise = "rows";             // what states it: rows, repeats, none
  int repeated = 0;                       // configurations that are shot twice
  std::string folder, answer_folder;
};

struct Case {
  CaseOptions options;
  RobotKind robot;
  Design design;
  Nature nature;
  LeftOut left_out;
  std::vector<HiddenEffect> effects;
};

Case MakeCase(const CaseOptions& options);

// robot.yaml, measurements.csv and experiment.yaml to `folder`; the same without
// noise, and answer.json, to `answer_folder`.
void WriteCase(const Case& made);

}  // namespace hidden

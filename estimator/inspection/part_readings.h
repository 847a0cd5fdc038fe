// Ways to read a part of the rows, the others read as stated: markers exchanged, the points in another order than the
// joint values, and what is tried on whole files (readings.h), but for what would change the robot. What joints did is
// not tried where rows of the same configuration are not of the part.
#pragma once

#include <string>
#include <vector>

#include "estimator/inspection/readings.h"

namespace sagitta {

// Rows of some stations or markers, those that follow one another, or those of shots here and there.
struct PartOfRows {
  enum class Kind { kStations, kMarkers, kBlock, kShots };
  Kind kind = Kind::kBlock;
  std::vector<std::string> labels;  // of the stations or markers; else of the markers where it is not of all
  std::vector<int> rows;            // observations of points, fitted
  std::vector<int> with_held_out;   // the same with those that are held out between them, in their order in the files
  std::vector<int> others;          // fitted, not of the part
  ParameterSet parameters;          // places as the others have them
  double others_rms = 0.0;          // m, of distances there
};

// Simple ones first.
std::vector<Reading> ReadingsOfPart(const CalibrationProblem& problem, const PartOfRows& part);

}  // namespace sagitta

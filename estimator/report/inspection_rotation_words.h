// Rotations that do not fit where the points do (inspection/rotation_lint.h). Numbers come in SI.
#pragma once

#include <string>
#include <vector>

#include "estimator/report/inspection_words.h"

namespace sagitta {

// How the nominal robot that fits the points within `points` (m, RMS) misses the rotations.
struct RotationsAsStated {
  double points = 0.0;               // m
  std::vector<std::string> columns;  // that state them
  std::string reading;               // what these say: "a rotation vector in mrad"
  double misfit = 0.0;               // rad, RMS
};

// fitting: readings that fit within `misfit` (rad), the best first; none: no reading fits, `misfit` is the best.
Advice RotationsMiss(const RotationsAsStated& stated, const std::vector<std::string>& fitting, double misfit);

}  // namespace sagitta

// Do loads pull where the experiment says? A force F = f d at a point p_L turns the joints by their compliances k_j and
// moves a marker at p_M by
//
//   u = sum_j k_j B_j F,   B_j = (z_j x (p_M - o_j)) (z_j x (p_L - o_j))',   a sliding joint: B_j = z_j z_j'
//
// of the aligned nominal robot. That is linear in k >= 0 for a direction d and in d for k; the direction that fits best
// is compared with the stated one. No average over poses would do: an arm on a slope gives way across the force.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "estimator/inspection/finding.h"
#include "problems/calibration_problem.h"

namespace sagitta {

struct LoadDirection {
  int station = 0;
  bool stated_in_base = false;           // gravity's frame
  bool in_columns = false;               // the rows state the forces; else they are masses times gravity
  Vector3<double> stated, fitted;        // unit, base frame
  Vector3<double> fitted_in_frame;       // of the stated gravity
  double angle = 0.0;                    // rad, between them
  double left_stated = 0.0, left = 0.0;  // m RMS per coordinate, of the deflections
};

// Of weights (forces along the stated gravity) at one station, loaded minus unloaded: nothing where they pull as
// stated, or where the deflections do not say otherwise beyond doubt.
std::optional<LoadDirection> FindLoadDirection(const CalibrationProblem& problem);

// The finding that says so.
Finding LoadDirectionInWords(const LoadDirection& found);
std::optional<Finding> LintLoadDirection(const CalibrationProblem& problem);

}  // namespace sagitta

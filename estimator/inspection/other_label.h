// Rows that are far off and yet belong together: the label of another station or marker, an instrument that stood
// elsewhere, another target under one name. Each leaves the other rows as they are (wild_rows.h) and fits these as
// well,
//
//   p = b_s' + R_s' (o + R_F m)      with the pose of another station s', or one of their own,
//   p = b_s + R_s (o + R_F m')       with the point of another marker, or one of their own,
//   p = b_s + R_s (o_L + R_L m')     all rows of a marker, on the link L and not on the flange,
//
// o, R: the nominal flange or link. A pose of their own by Umeyama, a point of their own by their mean.
#pragma once

#include <optional>

#include "estimator/inspection/finding.h"
#include "estimator/inspection/wild_rows.h"
#include "problems/calibration_problem.h"

namespace sagitta {

// What the far rows fit with.
struct OtherLabel {
  enum class Kind { kOtherStation, kOtherMarker, kOwnStation, kOwnMarker, kOtherFrame };
  Kind kind = Kind::kOwnStation;
  std::string stated, fits;  // labels; fits: "" of one of their own; of a frame the marker, and what it rides on
  MarkerPlace place;         // kOtherFrame: what `fits` names
  std::vector<std::string> fits_of_row;  // kOtherStation: label for each of `far`
  double moved = 0.0;       // m: between the instruments, or the markers' points; of a frame what is left, RMS
  double turned = 0.0;      // rad, of the instruments
  std::vector<int> far;     // observations
  size_t rows = 0;          // of all that were compared
  double far_median = 0.0;  // m, as stated; of a frame RMS
  // kOwnStation: the observations between which the station moved, where all far rows are on one side; -1: they are
  // not.
  int last_before = -1, first_after = -1;
};

std::optional<OtherLabel> FindOtherLabel(const CalibrationProblem& problem, FarRows rows);

// A marker, among others, whose rows fit on the base or after a joint, and not where it is said to be: an `on` that is
// missing or wrong.
std::optional<OtherLabel> FindOtherFrame(const CalibrationProblem& problem);

// Points that lie nearly on one place although the robot's do not: a column that was copied. spread: RMS distance from
// their mean, m.
bool AreAllOnePoint(const CalibrationProblem& problem, double* spread);

}  // namespace sagitta

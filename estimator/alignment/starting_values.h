// Base poses and marker points without a guess from the user.
//
// For a robot at nominal, point_station = t + R (p_f + R_f m) with the frame
// (R_f, p_f) of a marker known. Given the markers m, each station's (t, R) is a
// rigid registration in closed form (Kabsch 1976, Umeyama 1991); given the
// stations, each m is a mean. The two alternate from several marker starts; the
// best are polished by Levenberg-Marquardt on base and markers alone.
// The registration is global in the rotation: any base orientation converges.
#pragma once

#include <vector>

#include "problems/calibration_problem.h"

namespace sagitta {

class NormalEquations;

enum class StartsTried { kSeveral, kFew };  // kFew: one random start, the best one is polished

// Sets base and markers of `parameters` (its model values are kept); what is
// fixed keeps its value. Returns the RMS of the 3-D distances, m.
double FindStartingValues(const CalibrationProblem& problem, const std::vector<int>& observations,
                          ParameterSet* parameters, StartsTried tried = StartsTried::kSeveral);

// The same of all rows of `equations`, where these are at hand; they count joints as exact.
void FindStartingValues(const CalibrationProblem& problem, const NormalEquations& equations, ParameterSet* parameters);

// The pose that maps `points` best onto `targets` (3 x N, least squares, no
// scale, no reflection).
Pose<double> RegisterRigid(const Eigen::Matrix3Xd& points, const Eigen::Matrix3Xd& targets);

}  // namespace sagitta

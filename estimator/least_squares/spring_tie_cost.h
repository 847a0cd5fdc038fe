// The rows that tie the compensator's geometry to the markers on its spring (problems/spring_tie.h):
//
//   r = W ((L, a_x, a_y) of the markers - (L, a_x, a_y) of the robot),   W' W = C^-1
//
// over those of the three that are estimated (C: their part of the tie's covariance).
#pragma once

#include <ceres/problem.h>

#include <string>

#include "estimator/least_squares/linearization.h"

namespace sagitta {

// Appends the rows to a linearization; what is estimated other than its columns stands still.
void AppendSpringTie(const ParameterSet& parameters, Linearization* linearization);

// Adds them to a problem that does not have them yet.
void AddSpringTie(const ParameterSet* parameters, ceres::Problem* ceres_problem);

// Drops an assumed tie where the markers, as they are placed now, are farther than 20 % from the geometry in the
// robot file: they are something else on those links.
void DropImplausibleTie(ParameterSet* parameters);

// Sets the tie's covariance to that of ends where the markers are; true where it moves by more than a twentieth. For
// solved parameters: it stays as it is while they are solved for, and what it begins with is as wrong as the robot
// file.
bool WeighSpringTie(ParameterSet* parameters);

// (L, a_x, a_y) of the markers minus those of the robot, m; of a set that has a tie.
Eigen::Vector3d SpringTieMisfit(const ParameterSet& parameters);

// What the reader of an estimate must know of a tie that nobody stated; "": nothing.
std::string TieInWords(const CalibrationProblem& problem, const ParameterSet& estimated);

}  // namespace sagitta

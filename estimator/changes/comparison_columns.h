// Columns of a comparison: what parameters and joint zeros do to the points that are compared.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "estimator/least_squares/linearization.h"
#include "estimator/results/estimate_json.h"

namespace sagitta {

// Asked for, whether or not the data determined it; else assumed.
bool IsFree(const KnownRobot& known, const std::string& coordinate);

// Geometry moves every point of every campaign. A load, a time or a temperature need not have been in the other's.
bool IsOfCampaign(CoordinateKind kind);

// Every coordinate's column, m per SI unit; `latent` has those of the joints.
Linearization AllColumns(const CalibrationProblem& problem, const std::vector<int>& rows);

// Points by a joint's encoder: the joints that are coupled to it move too.
Eigen::VectorXd ZeroColumn(const Chain& chain, const Linearization& all, int joint);

// Of the named coordinates; zero where the problem has none of that name.
Eigen::MatrixXd NamedColumns(const std::vector<std::string>& names, const CalibrationProblem& problem,
                             const Eigen::MatrixXd& jacobian);

Eigen::MatrixXd SideBySide(const std::vector<Eigen::MatrixXd>& parts, long rows);

}  // namespace sagitta

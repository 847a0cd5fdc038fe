// Which of the joint solutions of a pose a robot program means: by what the file says of wrist, elbow and turns, or,
// where controllers go by the arm's place, the solution that is nearest to where it is.
#pragma once

#include <string>

#include "estimator/compensation/flange_solver.h"
#include "problems/io/programs/robot_program.h"

namespace sagitta {

struct BranchFound {
  Eigen::VectorXd q;
  std::string why_not;  // in words; "": q is the one that is meant
};

// flange_in_base: by the nominal chain. before: where the arm is when it moves there; empty: not known.
BranchFound FindBranch(const Chain& nominal, const Pose<double>& flange_in_base, const StatedBranch& branch,
                       const Eigen::VectorXd& before);

}  // namespace sagitta

// Which of the joint solutions of a pose a robot program means: by what the file says of wrist, elbow and turns, or,
// where controllers go by the arm's place, the solution that is nearest to where it is.
#pragma once

#include <string>
#include <vector>

#include "estimator/compensation/flange_solver.h"
#include "problems/io/programs/robot_program.h"

namespace sagitta {

struct BranchFound {
  Eigen::VectorXd q;
  std::string why_not;  // in words; "": q is the one that is meant
};

// flange_in_base: by the nominal chain. before: where the arm is when it moves there; empty: not known. Solutions
// within 0.1 deg of what is stated count where none is within it: poses are rounded.
BranchFound FindBranch(const Chain& nominal, const Pose<double>& flange_in_base, const StatedBranch& branch,
                       const Eigen::VectorXd& before);

// Whether joint values q are still what the file states of them, as those that are `meant` are.
struct BranchKept {
  std::vector<int> out;  // joints (from 0) outside of the range stated for them
  bool is_shape = true;  // wrist, elbow and side are as stated
  bool is_near = true;   // ... and the joints outside are next to their ranges, not a turn away
  bool is_exact() const { return is_shape && out.empty(); }
};
BranchKept KeepsBranch(const Chain& nominal, const StatedBranch& branch, const Eigen::VectorXd& meant,
                       const Eigen::VectorXd& q);

}  // namespace sagitta

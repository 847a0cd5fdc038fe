// How the unknowns of a problem meet in its readings. One reading sees its station, its marker and the robot; where
// there are many stations or markers, most unknowns never meet, and sparse factors (CHOLMOD's ordering) win over dense
// ones.
#pragma once

#include "estimator/least_squares/ceres_problem.h"

namespace sagitta {

struct Structure {
  int unknowns = 0;      // estimated, deviations of joints not counted
  int rows = 0;          // three per reading
  double touched = 1.0;  // share of the unknowns that a reading depends on, mean over the readings

  // Sparse factors of the rows win over dense ones.
  bool IsSparse() const;
  // And over the rows' sums, which cost little per row but are a dense matrix of all unknowns.
  bool IsSparserThanSums() const;
};

// Of the readings that are fitted.
Structure StructureOf(const CalibrationProblem& problem, const ResidualSelection& selection,
                      const ParameterSet& parameters);

}  // namespace sagitta

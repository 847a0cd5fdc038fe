// Many rows that are far off while the others fit: then it is the rows, and neither signs nor zero positions.
//
// Base poses and markers of the nominal robot are aligned to the better half of every marker's rows at every station,
// in turns with the choice of that half (concentration steps of least trimmed squares: Rousseeuw, Van Driessen, A fast
// algorithm for the minimum covariance determinant estimator, Technometrics 41 (1999) 212), from all rows and from
// many small draws of them: all together may lead to a half that fits in a corner. Of long tables that is done with
// some rows of each, and what is found there is followed on all.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <vector>

#include "estimator/inspection/finding.h"
#include "problems/calibration_problem.h"

namespace sagitta {

// Points of the calibration rows, those that fit the nominal robot and the others.
struct FarRows {
  std::vector<int> near, far;         // observations
  std::vector<double> far_distances;  // m
  double limit = 0.0;                 // m, between them
  double near_rms = 0.0;              // distances, m
  double far_median = 0.0;
  ParameterSet parameters;  // base poses and markers of the nearer half
};

constexpr double kNearHalf = 5.0;  // of the RMS distance of the half that is aligned to: what fits

constexpr double kFarApart = 10.0;  // of the RMS distance of the rows that fit: rows that are clear of them

// Markers of the rows; the rows of every station, in their order.
std::set<int> MarkersOfRows(const Measurements& data, const std::vector<int>& rows);
std::map<int, std::vector<int>> ByStation(const Measurements& data, const std::vector<int>& rows);

// m, from the points that are predicted; 1e300 where none can be.
std::vector<double> DistancesFromPoints(const CalibrationProblem& problem, const std::vector<int>& points,
                                        const ParameterSet& parameters);

// Rows by whether they are within the limit, m; far_median is 0 where none is far. distances: of each row, m.
FarRows SplitByDistance(const std::vector<int>& rows, const std::vector<double>& distances, double limit,
                        ParameterSet parameters);

// Nothing where no row is far, or as many as fit.
std::optional<FarRows> FindFarRows(const CalibrationProblem& problem);

// Rows that the nominal robot alone misses by somewhat more than others are no group of their own: those that are clear
// of the others stay far.
FarRows OnlyThoseApart(FarRows rows);

// Whether those that fit do so as a robot's do, and the others are clear of them.
bool AreApart(const FarRows& rows, const CalibrationProblem& problem);

// Nothing where no half of the rows fits as a robot's do, or where the rows that are left go over into those that fit:
// a wrong model misses everywhere by something.
std::optional<Finding> FindWildRows(const CalibrationProblem& problem, const FarRows& rows);

}  // namespace sagitta

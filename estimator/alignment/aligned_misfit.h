// How far the nominal robot misses the measured points at best: base poses and markers fitted to a sample of the
// rows. What distinguishes a wrong unit, sign or convention from a robot that only needs calibration.
#pragma once

#include <string>
#include <vector>

#include "problems/calibration_problem.h"

namespace sagitta {

// The length that misfits are measured by, m: the sum of the arm's nominal translations or the travel of its sliding
// joints, whichever is more. An angle that is off moves points by its share of either, and of an arm on a long rail
// misfits are those of the arm. Without limits a joint travels as far as it was measured, or a metre.
double Reach(const Chain& chain);
double Reach(const CalibrationProblem& problem);

// Calibration rows that see every station and marker, at most 40 of each pair; of a pose both readings.
std::vector<int> SampleOfRows(const CalibrationProblem& problem);

// RMS of the 3-D distances, m, of the aligned nominal robot on these rows, with or without what its loads deflect it
// by, whichever is less: starting values are judged by the arm without, which a load moves by millimetres, and a load
// that is stated wrongly is no reason to doubt robot or instrument.
double AlignedMisfit(const CalibrationProblem& problem, const std::vector<int>& rows);

// The nominal robot aligned to SampleOfRows: what every check of readings begins with.
struct AlignedSample {
  // Throws InputError where a row has no reading.
  explicit AlignedSample(const CalibrationProblem& problem);

  std::vector<int> rows;
  ParameterSet parameters;
  double misfit = 0.0;  // AlignedMisfit, m
};

// Whether the misfit of these rows of points is more than `limit` where the sample puts the robot: what the sample may
// have missed.
bool MissesRows(const CalibrationProblem& problem, const AlignedSample& aligned, const std::vector<int>& points,
                double limit);

// Where the nominal robot has the frame of each observation of a point, base poses fitted to a sample of the points:
// station_from_frame.
std::vector<Matrix3<double>> AlignedOrientations(const CalibrationProblem& problem);

// The same of the listed observations, at base poses that are given.
std::vector<Matrix3<double>> OrientationsAt(const CalibrationProblem& problem, const ParameterSet& parameters,
                                            const std::vector<int>& observations);

// RMS angle, rad, of readings R_k from frames F_k T; T, the target in the frame it rides on, is fitted, one for each
// marker. Nothing to compare: infinity.
struct TargetRotation {
  int marker = -1;
  Matrix3<double> station_from_frame = Matrix3<double>::Identity();
  Matrix3<double> station_from_target = Matrix3<double>::Identity();
};
double RotationMisfit(const std::vector<TargetRotation>& readings);

}  // namespace sagitta

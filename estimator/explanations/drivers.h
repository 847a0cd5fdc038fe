// What a deviation of the arm may depend on, per shot, in the units that people read.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "problems/calibration_problem.h"

namespace sagitta {

// What kind of thing drives.
enum class DriverKind { kAngle, kTravel, kTorque, kTime, kTemperature, kOther };

// One of them, with its values.
struct Driver {
  std::string name, unit;
  DriverKind kind = DriverKind::kOther;
  Eigen::VectorXd of_shot;  // one per Measurements::shots

  bool Varies() const { return of_shot.size() > 0 && of_shot.maxCoeff() > of_shot.minCoeff(); }
};

// Shots of which a row is fitted, ascending.
std::vector<int> FittedShots(const CalibrationProblem& problem);

// value(conditions) of every shot.
template <typename Value>
Eigen::VectorXd OfShots(const CalibrationProblem& problem, const Value& value) {
  Eigen::VectorXd values(static_cast<long>(problem.shot_inputs().size()));
  for (long s = 0; s < values.size(); ++s) values[s] = value(problem.shot_inputs()[s].conditions);
  return values;
}

// Joint values, rad or m, commanded.
Eigen::VectorXd JointValues(const CalibrationProblem& problem, int joint);
// A revolute joint, whose angle is read; of the others a length is.
bool IsRevolute(const CalibrationProblem& problem, int joint);

// Of what a shot may leave open all are 0 where one does.
Driver AngleOf(const CalibrationProblem& problem, int joint);     // deg or mm, commanded
Driver ApproachOf(const CalibrationProblem& problem, int joint);  // +1, -1 or 0
Driver TimeOf(const CalibrationProblem& problem);                 // s since the station's first row
Driver TemperatureOf(const CalibrationProblem& problem);          // K above the mean
Driver ConfigurationNumberOf(const CalibrationProblem& problem);  // from 1

// What drives an effect: its joint, or the one that a setting names, time or temperature; else the configurations in
// their order.
Driver DriverOf(const CalibrationProblem& problem, const EffectSpec& spec);

// What puts the visits in order: time, or where not every row states it the configuration's number.
Driver OrderOf(const CalibrationProblem& problem);

// Torque (force) of the known wrenches on each joint's axis, N m (N), at the equilibrium of these parameters: shots x
// joints. The spring of a compensator is left out. Zero where the equilibrium diverges.
// shots: those that are asked for (null: all); the others repeat the first of them.
Eigen::MatrixXd JointTorques(const CalibrationProblem& problem, const ParameterSet& parameters,
                             const std::vector<int>* shots = nullptr);
// The same of a weight of 1 N at the flange, shots x joints, m: what gravity makes of the arm's posture.
Eigen::MatrixXd TorquesPerWeight(const CalibrationProblem& problem, const ParameterSet& parameters);
// Unit vector of gravity in the base frame, as the stations say together.
Vector3<double> DownInBase(const CalibrationProblem& problem, const ParameterSet& parameters);
Driver TorqueOf(const CalibrationProblem& problem, int joint, const Eigen::MatrixXd& joint_torques);

}  // namespace sagitta

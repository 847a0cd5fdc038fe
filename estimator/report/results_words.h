// What is said of an estimate that is read back, and of programs that it corrects.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace sagitta {

struct KnownRobot;
struct ProgramLoad;

// Of predictions: the model error that their standard deviations carry, and what they do not where the covariance was
// found from few configurations. "": neither.
std::string WhatFiguresCarry(const KnownRobot& known);

// Of corrected targets: the effects that depend on the way to one. "": none acts.
std::string WhatTheWayDoes(const KnownRobot& known);

// Shots beyond what the calibration rows were measured at: times (most: s) and temperatures (most: K) that the named
// effects go with, loads (N; calibrated: the heaviest one of the calibration, 0: none).
std::string ShotsBeyondTime(size_t beyond, size_t shots, double most, const std::vector<std::string>& effects);
std::string ShotsBeyondTemperature(size_t beyond, size_t shots, double most, const std::vector<std::string>& effects);
std::string ShotsAroundMoment(size_t around, size_t shots, const std::string& effect);
std::string ShotsBeyondLoads(size_t beyond, size_t shots, double largest, double calibrated);

// Learnt functions of a robot file that is calibrated; effects: their titles.
std::string LearntFunctionsAreHeld(const std::vector<std::string>& effects);

// Poses outside the joint ranges of the calibration; joints: "j1 by 100 deg".
std::string PosesOutsideMeasured(size_t outside, size_t poses, const std::vector<std::string>& joints);
std::string TargetOutsideMeasured(const std::vector<std::string>& joints);
std::string TargetsOutsideMeasured(size_t outside);

// A measurement file that is validated against although the estimate was made of it.
std::string InputOfTheEstimate(const std::string& file);

// Of a program's points; of the flange there the largest distance off target before, m, and the largest 95 %
// uncertainty, m and rad.
std::string PointsAreCorrected(const std::string& dialect, int corrected, size_t points, double before, double u95,
                               double u95_rotation);

// Of the targets of all motions of the program; a circle has two.
std::string MotionsAreCorrected(int corrected, size_t motions);

// What a motion to it says of a point that is not corrected, where the point is listed.
std::string PointStaysInWords(const std::string& point, int line);

// A motion that goes on from a corrected point.
std::string OffsetAdoptsInWords(int line, const std::string& motion, const std::string& point);

// Routines that are not in the file of the program, and the line of the first call of each.
std::string CallsElsewhereInWords(const std::map<std::string, int>& calls);

// Of corrections of a program's points; angles in rad.
std::string JointTargetStaysInWords(const std::string& joint, double move, bool is_singular);
std::string JointMovesInWords(const std::string& joint, double move);
std::string JointStandsInWords(const std::string& joint, double value);
std::string PosesWithLargeMoves(double move);
std::string PosesWithOtherTurns();
std::string OtherConfigurationInWords(const std::vector<std::string>& joints);  // that left it

// Which load a program's points are corrected for, and why one is not known; tool_mass: kg.
std::string LoadUsedInWords(const std::string& name, const ProgramLoad& load, int points);
// Why a point with a load that the program names stays; `why` may be empty.
std::string LoadNotStatedInWords(const std::string& name, const std::string& why);
std::string LoadUnknownInWords(const std::string& name, int points);
std::string LoadOfTwoInWords(const std::string& one, const std::string& other);
std::string ToolReplacedInWords(double tool_mass);

}  // namespace sagitta

// Other ways to read the same robot file and rows (inspection/readings.h), in words that complete "it would fit with
// …", and what to change then.
#pragma once

#include <string>
#include <vector>

#include "estimator/report/inspection_words.h"
#include "models/denavit_hartenberg.h"

namespace sagitta {

// Joints counted the other way; one whose zero is `quarters` of a turn away.
Advice JointsFlipped(const std::vector<std::string>& joints);
Advice ZeroTurned(const std::string& joint, int quarters, bool is_flipped);

// The DH table in the other convention, with a and alpha of the row before, with other signs.
Advice TableIn(DhConvention convention);
Advice TableOneRowOff();
Advice BetaTurned();
Advice AlphaTurned(const std::string& joint);

// The order of the joint columns; `first`: the joint that they begin with.
Advice ColumnsExchanged(const std::string& one, const std::string& other);
Advice ColumnsInCyclicOrder(const std::vector<std::string>& joints);
Advice ColumnsReversed();
Advice ColumnsBeginWith(const std::string& first);

// joint value + ratio (-1 or 1) times the driver's.
Advice JointCoupled(const std::string& joint, const std::string& driver, int ratio);

Advice FrameMirrored();

// The numbers of the robot file in another unit; measured points in inches; one joint in radians.
enum class RobotNumbers { kMetres, kMillimetres, kInches, kRadians };
Advice RobotReadIn(RobotNumbers unit);
Advice PointsInInches();
Advice JointInRadians(const std::string& joint);
Advice LinearJointsIn(bool metres, const std::vector<int>& joints);  // or millimetres; joints: from 0

// Every point read with the configuration after (else before) its own.
Advice RowsShifted(bool is_after);

// How the nominal robot that fits the points within `points` (m, RMS) misses the rotations.
struct RotationsAsStated {
  double points = 0.0;               // m
  std::vector<std::string> columns;  // that state them
  std::string reading;               // what these say: "a rotation vector in mrad"
  double misfit = 0.0;               // rad, RMS
};

// fitting: readings that fit within `misfit` (rad), the best first; none: no reading fits, `misfit` is the best.
Advice RotationsMiss(const RotationsAsStated& stated, const std::vector<std::string>& fitting, double misfit);

}  // namespace sagitta

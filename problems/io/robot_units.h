// Files whose format prescribes m and rad: numbers that no robot has in these are in another unit.
#pragma once

#include "models/chain.h"
#include "models/constants.h"
#include "models/denavit_hartenberg.h"
#include "problems/input_error.h"
#include "problems/io/urdf_chain.h"

namespace sagitta {

// m: longer than any link; rad: a full turn, with room for digits that were rounded.
inline constexpr double kLongestLink = 10.0, kFullTurn = 2.0 * kPi + 1e-6;

// A length of a link or an angle of its frames, called `name` in messages. Throws InputError.
void CheckMetres(double value, const std::string& name, const InputError::Where& where);
void CheckRadians(double value, const std::string& name, const InputError::Where& where);

// One row of a table in m and rad. Along a joint's axis, d, calibrated tables run far where axes are nearly parallel,
// and back in the next row: where the flange is says in which unit they are (CheckReach). Throws InputError.
void CheckRowUnits(const DhLink& row, const InputError::Where& where);

// No flange is 30 m from its first joint where all joints are at zero: in mm every one is. Throws InputError.
void CheckReach(double distance, const InputError::Where& where);
void CheckReach(const Chain& chain, const InputError::Where& where);

// A limit of a joint that slides, m: none is 200 m long. Throws InputError.
void CheckTrack(double limit, const InputError::Where& where);

// Limits of a joint in rad or m. Throws InputError.
void CheckLimitUnits(const UrdfJoint& joint, const InputError::Where& where);

}  // namespace sagitta

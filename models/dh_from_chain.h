// The DH table of a chain that was described otherwise, and the best table without Hayati's beta.
//
// Link i leads from axis i to axis i + 1 (lines at joint values 0, their
// directions those of positive motion). Axes that are not parallel have a common
// normal, which gives theta, d, a and alpha (Denavit, Hartenberg, 1955). Within 3
// degrees of parallel (default_free_set.h) the normal is ill-defined: there d = 0,
// the next axis is met where it passes the plane d = 0, and alpha and beta turn onto
// it (Hayati, Mirmirani, 1985). Because Rx(alpha) and Tx(a) commute, the modified
// table is the standard one with alpha, a, beta moved to the next row.
#pragma once

#include <optional>
#include <string>

#include "models/robot.h"

namespace sagitta {

// What joint 1 .. n and the flange leave when a table cannot hold the chain goes
// to *why_not, in words: the first axis has to be the base's z axis, and count along it in a standard table.
std::optional<DhTable> DhTableFromChain(const Chain& chain, DhConvention convention, std::string* why_not);

// A standard table without beta that holds the chain exactly, as controllers without beta have it after a calibration:
// d runs along two nearly parallel axes to where they are nearest to each other, metres away (100 m and more).
std::optional<DhTable> ExactPlainTable(const Chain& chain, std::string* why_not);

// The same table in the other convention; nothing where the first row of a
// modified table is not zero before its joint.
std::optional<DhTable> InConvention(const DhTable& table, DhConvention convention, std::string* why_not);

// The table without beta that comes nearest to a robot: least squares over a, alpha, d
// and theta at points 100 mm from the flange in random poses within the limits (half a
// turn, 1 m where there are none). Parameters are held near their values by 5 mm and 5 mrad, the
// bounds beyond which a value means nothing here (FORMATS section 4).
struct PlainDhFit {
  DhTable table;
  double rms = 0.0;                    // m: distance of the flange from where the exact table has it
  double max = 0.0;                    // m, of all poses within the limits: searched uphill from the worst drawn
  double largest_length_change = 0.0;  // m
};
PlainDhFit FitPlainDh(const Chain& chain, const DhTable& with_beta);

}  // namespace sagitta

// DH tables as CSV (one row per joint, units in the header), written and read again.
#pragma once

#include <string>

#include "models/robot.h"

namespace sagitta {

// Columns joint, type, theta_deg, d_mm, a_mm, alpha_deg[, beta_deg][, limits]; comment
// lines state name, convention, couplings and the flange.
std::string DhTableToCsv(const Robot& robot, const DhTable& table);

}  // namespace sagitta

// What follows a quantity late: Newton's law of cooling of a link of heat capacity C that exchanges heat at W per
// kelvin,
//
//   dA/dt = (T(t) - A) / tau,   tau = C / W.
#pragma once

#include <vector>

namespace sagitta {

// A at `time` (s, rising) of T = `value`, linear between; at equilibrium at the first. tau: s.
std::vector<double> LaggedBehind(const std::vector<double>& time, const std::vector<double>& value, double tau);

}  // namespace sagitta

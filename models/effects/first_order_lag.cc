#include "models/effects/first_order_lag.h"

#include <cmath>

namespace sagitta {

// Over an interval dt with T = T0 + m t the solution is A = T - m tau + (A0 - T0 + m tau) exp(-dt / tau).
std::vector<double> LaggedBehind(const std::vector<double>& time, const std::vector<double>& value, double tau) {
  std::vector<double> lagged;
  for (size_t i = 0; i < time.size(); ++i) {
    if (i == 0) {
      lagged.push_back(value[0]);
      continue;
    }
    const double dt = time[i] - time[i - 1];
    const double behind = dt > 0.0 ? (value[i] - value[i - 1]) / dt * tau : 0.0;
    lagged.push_back(value[i] - behind + (lagged.back() - value[i - 1] + behind) * std::exp(-dt / tau));
  }
  return lagged;
}

}  // namespace sagitta

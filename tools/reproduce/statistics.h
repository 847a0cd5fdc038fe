// Checks of distributions, for the figures of paper 002.
#pragma once

#include <vector>

namespace sagitta {

double MeanOf(const std::vector<double>& values);
// About the mean, divisor n - 1.
double DeviationOf(const std::vector<double>& values);
double RmsOf(const std::vector<double>& values);
double LargestOf(const std::vector<double>& values);  // absolute

// Jarque and Bera 1980: n/6 (skewness^2 + excess^2 / 4) is chi-square with 2 dof for
// normal values. Returns P of a larger one.
double NormalityPValue(const std::vector<double>& values);

// Lengths of isotropic normal vectors are Maxwell distributed; sigma = RMS / sqrt(3).
// Largest gap of the distribution functions (Kolmogorov) and the P of a larger one,
// as if sigma were known: on the generous side.
struct MaxwellFit {
  double sigma = 0.0;
  double gap = 0.0;
  double p_value = 1.0;
};
MaxwellFit FitMaxwell(std::vector<double> lengths);

}  // namespace sagitta

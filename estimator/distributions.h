// Distribution functions, on Eigen's incomplete gamma and beta functions.
#pragma once

namespace sagitta {

// P(chi2_dof > x).
double ChiSquareSurvival(double x, double dof);
// x with P(chi2_dof <= x) = p.
double ChiSquareQuantile(double p, double dof);
double NormalQuantile(double p);
// t with P(T_dof <= t) = p; the normal quantile for infinite dof.
double StudentQuantile(double p, double dof);
// P(largest distance between an empirical distribution of n numbers and the true one > d), Kolmogorov's series with
// Stephens' correction for finite n; two samples: n = n1 n2 / (n1 + n2).
double KolmogorovSurvival(double d, double n);

}  // namespace sagitta

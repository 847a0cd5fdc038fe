// The sum of squares that errors of predicted points are expected to have. The points do not err apart: with A = J R of
// all of them, C = R R' the covariance of the parameters, and the arm's deviations shared by the points of an arrival,
//
//   V = A A' + N,   N = blockdiag over arrivals of diag(S S') + L L',
//
// S a root of the instrument's noise, L what the joints' deviations move. A sum of squares of Gaussian errors with the
// covariance V has the mean tr V and the variance 2 tr V^2; by Satterthwaite (1946) it is tr V chi^2_nu / nu, nu =
// (tr V)^2 / tr V^2, and F with the degrees of freedom of the noise where that is estimated.
#pragma once

namespace sagitta {

struct PredictedSquares {
  double trace = 0.0;            // tr V, m^2
  double of_noise = 0.0;         // of this tr N
  double trace_of_square = 0.0;  // tr V^2, m^4

  // nu.
  double Freedom() const { return trace * trace / trace_of_square; }
};

// Probability of a sum of squares that is `ratio` times tr V or more. noise_dof: degrees of freedom of the noise;
// infinite where it is stated.
double ChanceOf(const PredictedSquares& predicted, double ratio, double noise_dof);

}  // namespace sagitta

// How fast an alternation between two halves of the unknowns must converge.
//
// Let A and B be the whitened columns of the two halves at the optimum, Qa and
// Qb orthonormal bases of their spans. Solving for one half and then the other
// projects the residual on the complement of span(A), then of span(B); the error
// shrinks per iteration by c1^2, c1 the largest singular value of Qa' Qb: the
// largest canonical correlation of the two spans (Bjorck and Golub 1973; Ruhe and
// Wedin 1980 for alternating least squares). For the two-step identification of
// paper 000 the halves are base and markers (step 1) and geometry (step 2).
#pragma once

#include "estimator/least_squares/linearization.h"

namespace sagitta {

// Cosines of the principal angles between the column spans, largest first.
// Columns may be of any scale and linearly dependent; empty if a span is empty.
Eigen::VectorXd CanonicalCorrelations(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

// c1^2 of base and marker columns against model columns; 0 if a half is empty.
double PredictTwoStepRate(const Linearization& linearization, const ParameterSet& parameters);

}  // namespace sagitta

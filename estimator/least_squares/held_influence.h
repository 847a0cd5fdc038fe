// What held parameters do to everything else. A held parameter is not known, it
// was put somewhere; others have moved with it. With e for the estimated and h
// for the held ones, the data leave
//
//   e - e_hat = n + G (h - h_hat),    n ~ N(0, C) as reported,
//   G = -(J_e' J_e)^-1 J_e' J_h       (how e moves to keep the fit)
//
// and what is known of h: the little the data say, and how far such a parameter
// can be off at all (a stated prior, else PhysicalRange). With the information
// I = P^-1 + J_h' (1 - J_e J_e^+) J_h / scale^2 and the pull of the data
// m = -I^-1 J_h' r / scale^2, the second moment of h about where it is held is
// S = I^-1 + m m'. Unconditional moments of e are C + G S G'; those of a
// prediction p are p_e C p_e' + (p_e G + p_h) S (p_e G + p_h)', in which a
// prediction that does not depend on the held direction cancels.
#pragma once

#include <vector>

#include "estimator/least_squares/linearization.h"

namespace sagitta {

struct HeldInfluence {
  std::vector<int> coordinates;   // held ones, indices into ParameterSet
  Eigen::MatrixXd slopes;         // G, SI: one row per estimated, one column per held coordinate
  Eigen::MatrixXd second_moment;  // S, SI
};

// Held coordinates of a set: asked for, but the data do not determine them.
std::vector<int> HeldCoordinates(const ParameterSet& parameters);

// Standard deviation of a parameter of which nothing is known but what it is,
// SI: 1 m and 1 rad for base and markers (anywhere about the arm), for all
// others the size beyond which a value has no physical meaning.
double PhysicalRange(const Coordinate& coordinate);

// both: columns of the estimated coordinates, then those of the held ones; at the
// optimum. noise_scale: of the whitened noise (1: as stated).
HeldInfluence FindHeldInfluence(const Linearization& both, const ParameterSet& parameters, int estimated,
                                double noise_scale);

// G S G': what the held ones add to the covariance of the estimated ones.
Eigen::MatrixXd AddedCovariance(const HeldInfluence& held);

}  // namespace sagitta

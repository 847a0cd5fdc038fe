// From the compliances of joint 2 at several q2 (k21 ... k25) to the joint's own
// compliance and the compensator's spring, paper 002 eq. (13), (14):
//
//   1 / k2i = K0 + Kc a L eta_i
//           = K0 + Kc (-a L cos g_i) + Kc s0 (a L / s_i) (a L sin^2 g_i / s_i^2 + cos g_i)
//
// linear in (K0, Kc, Kc s0) where L, a_x, a_y are measured; g = alpha - q2,
// s^2 = a^2 + L^2 + 2 a L cos g (models/gravity_compensator.h).
#pragma once

#include <Eigen/Core>
#include <vector>

namespace sagitta {

struct JointTwoNode {
  double q = 0.0;      // rad
  double k = 0.0;      // rad/(N m)
  double sigma = 0.0;  // of k; 0: unknown
};

struct SpringMounting {
  double L = 0.0, a_x = 0.0, a_y = 0.0;  // m
};

struct EquivalentSpring {
  bool solved = false;                                   // three nodes at least, of full rank, Kc not zero
  double K0 = 0.0;                                       // N m/rad
  double Kc = 0.0;                                       // N/m
  double s0 = 0.0;                                       // m
  double k0 = 0.0;                                       // 1 / K0, rad/(N m)
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // of (k0, Kc, s0), from the nodes' sigmas
  double rms = 0.0;                                      // of the nodes' k, rad/(N m), no degrees of freedom subtracted
  double condition = 0.0;                                // of the column-normalised system
};

// Weight of node i: 1, as the papers do, or its own variance of 1/k.
enum class SpringWeights { kEqual, kSigma };

EquivalentSpring FitEquivalentSpring(const std::vector<JointTwoNode>& nodes, const SpringMounting& geometry,
                                     SpringWeights weights = SpringWeights::kEqual);

}  // namespace sagitta

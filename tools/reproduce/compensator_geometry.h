// Where the compensator's spring is fixed, from markers on the links: P1, the
// lever end, on link 2, and P2, the anchor, on link 1 (paper 002, III.D).
//
// P1 runs on a circle as joint 2 turns: p_i = c + L R u_i, u_i = (cos q_i,
// sin q_i, 0). With centred p~, u~ (eq. 6)
//
//   R = V U' from the SVD of sum u~ p~',   L = sum p~' R u~ / sum |u~|^2,
//
// the least-squares fit. The anchor is at (-a_y, -a_x) in the plane of R:
// R'(P2 - c) = -(a_y, a_x, .), the sense of s^2 = a^2 + L^2 + 2 a L cos(alpha - q)
// with alpha from the vertical (models/gravity_compensator.h). The joint solve ties
// the same markers to the spring inside (estimator/least_squares/spring_tie_cost.h).
#pragma once

#include <vector>

#include "models/geometry.h"

namespace sagitta {

struct CompensatorMarkers {
  std::vector<double> q;           // of joint 2, rad, one per lever point
  Eigen::Matrix3Xd lever_points;   // P1, m; joint 1 stands still
  Eigen::Matrix3Xd anchor_points;  // P2, m, same frame; at least one
  double point_sigma = 0.0;        // m, per coordinate of every point
  double anchor_sigma = 0.0;       // m, on top: how well P2 stands for the anchor
};

struct CompensatorGeometry {
  bool solved = false;                                   // at least three distinct angles, an anchor
  double L = 0.0, a_x = 0.0, a_y = 0.0;                  // m
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // of (L, a_x, a_y)
  Vector3<double> center = Vector3<double>::Zero();      // m
  Matrix3<double> rotation = Matrix3<double>::Identity();
  double sum_of_directions = 0.0;  // sum |u~|^2: var(L) = sigma^2 / this
  double rms = 0.0;                // of the lever points' coordinates about the circle, m
  double center_sigma = 0.0;       // m, the larger one in the plane
};

CompensatorGeometry FitCompensatorGeometry(const CompensatorMarkers& markers);

}  // namespace sagitta

// Markers on the two ends of the compensator's spring tie its geometry to their points: (L, a_x, a_y) of
// models/spring_anchors.h equal those of the robot, as well as the markers sit on the ends.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "models/spring_anchors.h"

namespace sagitta {

class CalibrationProblem;

struct SpringTie {
  int lever_marker = -1;                             // P1, right after the joint
  int anchor_marker = -1;                            // P2, before it
  SpringAnchors anchors;                             // P2's frame to the joint
  std::vector<int> errors;                           // model parameter on each transform between, -1: none
  std::array<int, 3> geometry = {-1, -1, -1};        // model parameters L, a_x, a_y
  double lever_sigma = 0.0, anchor_sigma = 0.0;      // m: how well the markers sit on the ends
  Eigen::Matrix3d covariance;                        // of (L, a_x, a_y), m^2, by these (CovarianceOfEnds)
  Eigen::Vector3d stated = Eigen::Vector3d::Zero();  // (L, a_x, a_y) of the robot file, m
  bool is_assumed = false;       // no `spring:` names them: only where they agree with the robot file
  bool sigma_is_stated = false;  // else they are assumed to be the ends themselves
};

// A spring_sigma not stated: the marker is the end.
constexpr double kMarkerIsTheEnd = 1e-6;  // m

// Of (L, a_x, a_y), m^2, where they are `geometry`, m. An end off by e moves L by its radial part; its tangential part
// turns u and v by e / L, hence d(a_x, a_y) = (-a_y, a_x) e / L. The anchor's shift moves a_x and a_y as it is.
Eigen::Matrix3d CovarianceOfEnds(const Eigen::Vector3d& geometry, const SpringTie& tie);

// Ties problem->parameters where the experiment says `spring: lever` and `spring: anchor`, or says nothing, one
// marker rides right after the compensator's joint and one on the frame of the joint before. Throws InputError
// for an end on a frame where it cannot be.
void TieSpringMarkers(CalibrationProblem* problem);

}  // namespace sagitta

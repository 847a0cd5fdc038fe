// The flange that corrected targets are about: a frame in which the markers on the flange stand as the estimate says.
//
// Where markers are estimated to be off by d_i (in the flange, about their mean c), the frame in which they stand is
// off as a rigid body: the least-squares turn about c and the mean shift,
//
//   w = I^+ sum (m_i - c) x d_i,    t(origin) = mean(d_i) - w x c,    I = sum |m_i - c|^2 E - (m_i - c)(m_i - c)'
//
// (I^+: a single marker shows no turn, markers on a line none about it). Markers whose rotations are read show the turn
// by themselves: w is the mean of theirs.
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "models/geometry.h"
#include "problems/experiment.h"

namespace sagitta {

struct FlangeOfMarkers {
  // m and rad, in the flange's own axes at its origin, by each of the names of what is uncertain; 0 of what is no
  // marker.
  Eigen::Matrix<double, 6, Eigen::Dynamic> by_names;
  Vector3<double> centre = Vector3<double>::Zero();  // of the markers in the flange, m
};

// names: of the coordinates, "marker/M1/x", "marker/M1/rx" among them. Markers without a point and those that are not
// on the flange do not count.
FlangeOfMarkers FlangeFromMarkers(const std::map<std::string, MarkerSpec>& markers,
                                  const std::vector<std::string>& names);

}  // namespace sagitta

// What full poses lose against marker coordinates: paper 000, section IV, Table I.
//
// For random sets of configurations and a marker layout, the standard deviations of
// the geometric errors with base and tool known, from linear covariances:
//
//   markers     sigma^2 (A'A)^-1, the rows of all marker coordinates (approach #2)
//   full pose   sandwich H^-1 B'W C W B H^-1, H = B'WB, of least squares on position
//               (weight 1) and orientation (w, m/rad) with the pose covariance
//               C = sigma^2 (G'G)^-1 of the rigid registration (approach #1)
//
// A = G B: markers move rigidly with the tool. With W = C^-1 the two are equal (the
// pose is a sufficient statistic), so the improvement factor full pose / markers is
// never below 1: what is gained is bad weighting avoided, not information. Factors
// do not depend on sigma.
#pragma once

#include <string>
#include <vector>

#include "models/robot.h"

namespace sagitta {

// Points in the flange frame, m; the pose's position is that of the flange origin.
struct MarkerLayout {
  std::string name;
  std::vector<Vector3<double>> points;
};

// Three markers at 120 degrees on a circle in a plane across the flange's x axis.
MarkerLayout DiscLayout(const std::string& name, double radius, double ahead);

// What stands in the orientation rows: the rotation vector of the residual, or the
// angles of R = Rz Ry Rx as paper 000 eq. (21) writes phi. The angles are worst where
// Ry comes near 90 degrees; the propagated covariance makes both the same.
enum class OrientationRows { kRotationVector, kEulerAngles };

struct PoseStudyOptions {
  OrientationRows orientation = OrientationRows::kEulerAngles;
  std::vector<double> weights = {0.001, 0.1, 0.3, 1.0};  // m/rad
  int configurations = 3;                                // per set
  int sets = 2000;
  unsigned long long seed = 1;
};
// Throws InputError that names the option (problems/range.h).
void CheckOptions(const PoseStudyOptions& options);

struct PoseStudyRow {
  std::string layout;
  double weight = 0.0;            // m/rad
  std::vector<double> median;     // improvement factor per parameter
  std::vector<double> low, high;  // its 10 % and 90 % quantiles
  double smallest = 0.0;          // over all sets and parameters: not below 1
  double largest_gap = 0.0;       // |sigma(6x6 covariance) / sigma(markers) - 1|, likewise
};

struct PoseStudy {
  std::vector<std::string> parameters;  // error names
  int sets = 0;                         // random sets that determine all parameters
  std::vector<PoseStudyRow> rows;       // layouts, weights within
};

// All named errors of the robot are unknown. Joint values are uniform within the
// joint limits, [-pi, pi] where there are none.
PoseStudy StudyPoses(const Robot& robot, const std::vector<MarkerLayout>& layouts,
                     const PoseStudyOptions& options = {});

}  // namespace sagitta

// Denavit-Hartenberg tables as elementary transforms (Hayati's beta included).
//
//   standard: Rz(theta + q) Tz(d) Tx(a) Rx(alpha) [Ry(beta)]
//   modified: Rx(alpha) Tx(a) [Ry(beta)] Rz(theta + q) Tz(d)
//
// A prismatic joint moves Tz(d + q). The error parameters are called
// <joint>.a, .d, .alpha, .theta, .beta. Source of beta: S. Hayati, M. Mirmirani,
// "Improving the absolute positioning accuracy of robot manipulators", 1985.
#pragma once

#include <string>
#include <vector>

#include "models/chain.h"

namespace sagitta {

enum class DhConvention { kStandard, kModified };

// "standard", "modified": the word of files, flags and pages (problems/choices.h finds the convention of a word).
std::string WordOf(DhConvention convention);

// One row of a DH table, m and rad.
struct DhLink {
  int joint = -1;      // index into the joints
  double a = 0.0;      // m
  double alpha = 0.0;  // rad
  double d = 0.0;      // m
  double theta = 0.0;  // rad
  double beta = 0.0;   // rad
};

// Appends the link's five transforms to the chain.
void AppendDhLink(DhConvention convention, const DhLink& link, Chain* chain);

// Appends a fixed pose (no error parameters); rpy are fixed-axis x-y-z angles.
void AppendFixedPose(const Vector3<double>& xyz_m, const Vector3<double>& rpy_rad, Chain* chain);

}  // namespace sagitta

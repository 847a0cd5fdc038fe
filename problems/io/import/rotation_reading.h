// What three angles, or four numbers, of a foreign table mean as a rotation.
//
// Tables say rx, ry, rz or roll, pitch, yaw and mean a rotation vector or one of six products of rotations about the
// axes, each in one of two directions. Which it is, the robot decides (tools/import.cc) or the user says.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "models/geometry.h"

namespace sagitta {

struct RotationReading {
  enum class Kind { kVector, kProduct, kQuaternion };
  Kind kind = Kind::kVector;
  std::array<int, 3> order = {0, 1, 2};  // of kProduct: R = R_order[0] R_order[1] R_order[2], each about that axis
  std::string unit = "rad";              // of the angles
  bool is_inverse = false;               // the table has target_from_station
  bool scalar_is_last = false;           // of kQuaternion: in a table whose header does not say which is which

  // numbers: angles about x, y, z or vector (rad); quaternion of any length above 0, scalar first unless
  // scalar_is_last.
  Matrix3<double> StationFromTarget(const std::vector<double>& numbers) const;

  // Standard deviations of the left perturbation from those of the angles (rad), which are assumed to be independent:
  // roots of the diagonal of E S^2 E', E the columns about which each angle turns.
  Vector3<double> PerturbationSigmas(const std::vector<double>& numbers, const Vector3<double>& sigmas) const;

  std::string Words() const;
};

// All readings of the columns; `unit`: "" where the header does not say; scalar_is_open: nor which of the four numbers
// of a quaternion is the scalar.
std::vector<RotationReading> PossibleRotations(bool is_quaternion, const std::string& unit, bool scalar_is_open);

// vector, RxRyRz, RzRyRx, … : what --rotation says. Throws InputError.
RotationReading RotationNamed(const std::string& name);

}  // namespace sagitta

#include "problems/io/import/rotation_reading.h"

#include <algorithm>

#include "problems/input_error.h"
#include "problems/text.h"

namespace sagitta {
namespace {

Matrix3<double> About(int axis, double angle) {
  return Eigen::AngleAxisd(angle, Vector3<double>::Unit(axis)).toRotationMatrix();
}

std::string ProductName(const std::array<int, 3>& order) {
  std::string name;
  for (const int axis : order) name += std::string("R") + kAxisLetters[axis];
  return name;
}

std::vector<std::array<int, 3>> Orders() {
  std::vector<std::array<int, 3>> orders;
  std::array<int, 3> order = {0, 1, 2};
  do orders.push_back(order);
  while (std::next_permutation(order.begin(), order.end()));
  return orders;
}

}  // namespace

Matrix3<double> RotationReading::StationFromTarget(const std::vector<double>& numbers) const {
  Matrix3<double> rotation = Matrix3<double>::Identity();
  if (kind == Kind::kQuaternion) {
    const size_t w = scalar_is_last ? 3 : 0, x = scalar_is_last ? 0 : 1;
    rotation =
        Eigen::Quaterniond(numbers[w], numbers[x], numbers[x + 1], numbers[x + 2]).normalized().toRotationMatrix();
  } else if (kind == Kind::kVector) {
    rotation = RotationFromVector(Vector3<double>(numbers[0], numbers[1], numbers[2]));
  } else {
    for (const int axis : order) rotation = Matrix3<double>(rotation * About(axis, numbers[static_cast<size_t>(axis)]));
  }
  return is_inverse ? Matrix3<double>(rotation.transpose()) : rotation;
}

Vector3<double> RotationReading::PerturbationSigmas(const std::vector<double>& numbers,
                                                    const Vector3<double>& sigmas) const {
  Matrix3<double> turns;  // columns: left perturbation by each angle
  if (kind == Kind::kVector) {
    turns = LeftJacobian(Vector3<double>(numbers[0], numbers[1], numbers[2]));
  } else {
    // R_a R_b R_c: a turns about its own axis, b about that axis as a has turned it, and so on.
    Matrix3<double> before = Matrix3<double>::Identity();
    for (const int axis : order) {
      turns.col(axis) = before.col(axis);
      before = Matrix3<double>(before * About(axis, numbers[static_cast<size_t>(axis)]));
    }
  }
  // R' is perturbed from the left by -R' delta.
  if (is_inverse) turns = Matrix3<double>(StationFromTarget(numbers) * turns);
  return (turns * sigmas.asDiagonal()).rowwise().norm();
}

std::string RotationReading::Words() const {
  const std::string direction = is_inverse ? ", of the measurement frame in the target's" : "";
  if (kind == Kind::kQuaternion)
    return std::string("a quaternion") + (scalar_is_last ? ", scalar last" : "") + direction;
  if (kind == Kind::kVector) return "a rotation vector in " + unit + direction;
  return "angles in " + unit + " of " + ProductName(order) + direction;
}

std::vector<RotationReading> PossibleRotations(bool is_quaternion, const std::string& unit, bool scalar_is_open) {
  std::vector<RotationReading> readings;
  const std::vector<std::string> units = unit.empty() ? std::vector<std::string>{"deg", "rad"} : std::vector{unit};
  for (const bool is_inverse : {false, true}) {
    if (is_quaternion) {
      readings.push_back({RotationReading::Kind::kQuaternion, {0, 1, 2}, "", is_inverse});
      if (!scalar_is_open) continue;
      readings.push_back({RotationReading::Kind::kQuaternion, {0, 1, 2}, "", is_inverse, true});
      continue;
    }
    for (const std::string& one : units) {
      readings.push_back({RotationReading::Kind::kVector, {0, 1, 2}, one, is_inverse});
      for (const auto& order : Orders()) {
        readings.push_back({RotationReading::Kind::kProduct, order, one, is_inverse});
      }
    }
  }
  return readings;
}

RotationReading RotationNamed(const std::string& name) {
  RotationReading reading;
  if (name == "vector") return reading;
  reading.kind = RotationReading::Kind::kProduct;
  std::string names = "vector";
  for (const auto& order : Orders()) {
    reading.order = order;
    if (name == ProductName(order)) return reading;
    names += ", " + ProductName(order);
  }
  throw InputError({"", 0, "--rotation"}, "'" + name + "' is no way to write a rotation",
                   names + " (R = Rx(rx) Ry(ry) Rz(rz) and so on; RzRyRx is roll, pitch, yaw of a URDF)");
}

}  // namespace sagitta

#include "models/effects/pose_functions.h"

#include <cmath>

#include "models/kinematics.h"

namespace sagitta {

int NumDirectionFunctions(int degree) {
  int count = 0;
  for (int d = 1; d <= degree; ++d) count += (d + 1) * (d + 2) / 2;
  return count;
}

// (u . v)^d is the sum over i + j + k = d of d! / (i! j! k!) (u_x v_x)^i (u_y v_y)^j (u_z v_z)^k.
Eigen::VectorXd DirectionFunctions(const Vector3<double>& direction, int degree) {
  Eigen::VectorXd functions(NumDirectionFunctions(degree));
  int next = 0;
  for (int d = 1; d <= degree; ++d) {
    for (int i = d; i >= 0; --i) {
      for (int j = d - i; j >= 0; --j) {
        const int k = d - i - j;
        const double ways = std::tgamma(d + 1) / (std::tgamma(i + 1) * std::tgamma(j + 1) * std::tgamma(k + 1));
        functions[next++] = std::sqrt(ways / degree) * std::pow(direction.x(), i) * std::pow(direction.y(), j) *
                            std::pow(direction.z(), k);
      }
    }
  }
  return functions;
}

Eigen::VectorXd FieldFunctions(const Vector3<double>& place) {
  const double x = place.x(), y = place.y(), z = place.z();
  Eigen::VectorXd functions(kNumFieldFunctions);
  functions << x, y, z, x * x, y * y, z * z, x * y, x * z, y * z;
  return functions;
}

Vector3<double> WithinReach(const Vector3<double>& place, double reach) {
  const double off = place.norm();
  return off > reach ? Vector3<double>(place * (reach / off)) : place;
}

Vector3<double> DownInFlange(const Chain& chain, const Eigen::VectorXd& q, const Vector3<double>& down_in_base) {
  const Pose<double> flange = NominalFrames(chain, q)[static_cast<size_t>(chain.FlangeFrame())];
  return flange.rotation.transpose() * down_in_base.normalized();
}

double SizeOfForces(const std::vector<AppliedWrench>& wrenches) {
  double size = 0.0;
  for (const AppliedWrench& wrench : wrenches) size += wrench.force.norm();
  return size;
}

Vector3<double> FlangePlace(const Chain& chain, const Eigen::VectorXd& q) {
  return NominalFrames(chain, q)[static_cast<size_t>(chain.FlangeFrame())].translation;
}

}  // namespace sagitta

#include "models/sight.h"

#include <unsupported/Eigen/AutoDiff>

namespace sagitta {

// Six derivatives in one pass.
SightGradient DifferentiateSight(const SightTerm& term, const Vector3<double>& point, const Vector3<double>& axis) {
  using Dual = Eigen::AutoDiffScalar<Eigen::Matrix<double, 6, 1>>;
  Vector3<Dual> p, a;
  for (int i = 0; i < 3; ++i) {
    p[i] = Dual(point[i], 6, i);
    a[i] = Dual(axis[i], 6, 3 + i);
  }
  const Vector3<Dual> moved = SightDisplacement(term, p, a);
  SightGradient gradient;
  for (int i = 0; i < 3; ++i) {
    gradient.displacement[i] = moved[i].value();
    gradient.by_point.row(i) = moved[i].derivatives().head<3>().transpose();
    gradient.by_axis.row(i) = moved[i].derivatives().tail<3>().transpose();
  }
  return gradient;
}

}  // namespace sagitta

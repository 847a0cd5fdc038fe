// Points that rows show of one marker, as they depend on where the marker is.
#pragma once

#include <array>
#include <vector>

#include "estimator/least_squares/linearization.h"
#include "problems/calibration_problem.h"

namespace sagitta {

// p = at_zero + sum_axis m_axis along[axis]: points of the listed rows, affine in their marker's point m.
struct AffineInMarker {
  AffineInMarker() = default;
  AffineInMarker(const CalibrationProblem& problem, const ParameterSet& at, const std::vector<int>& rows, int marker) {
    ParameterSet parameters = at;
    const auto points = [&](const Vector3<double>& point) -> Eigen::Matrix3Xd {
      parameters.SetMarkerPoint(marker, point);
      return PredictPoints(problem, parameters, rows);
    };
    at_zero = points(Vector3<double>::Zero());
    for (int axis = 0; axis < 3; ++axis) along[axis] = points(Vector3<double>::Unit(axis)) - at_zero;
  }

  Eigen::Matrix3Xd At(const Vector3<double>& m) const {
    return at_zero + m[0] * along[0] + m[1] * along[1] + m[2] * along[2];
  }

  // Least squares: the columns along the axes are orthonormal in every row.
  Vector3<double> Best(const Eigen::Matrix3Xd& measured) const {
    Vector3<double> mean;
    for (int axis = 0; axis < 3; ++axis) mean[axis] = along[axis].cwiseProduct(measured - at_zero).sum();
    return mean / static_cast<double>(measured.cols());
  }

  Eigen::Matrix3Xd at_zero;
  std::array<Eigen::Matrix3Xd, 3> along;
};

}  // namespace sagitta

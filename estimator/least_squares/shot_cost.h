// The residuals of one shot: all markers seen at one configuration share the
// kinematics. One marker per cost is the same class with one observation.
//
//   r = S^-1 (predicted - measured), 3 rows per reading (models/reading.h); S S' is its covariance
//
// Parameter blocks, in order: station translation (3, m), station rotation (4,
// quaternion x y z w), the marker's part of each reading (a point, 3, m, or, of a
// rotation, a quaternion, 4; both readings of a pose have one of their own), then one
// scalar per active model parameter (SI), then, where `latent_joints` are given,
// the visit's joint deviations (one block, rad or m). Derivatives are exact (geometric and
// implicit through the equilibrium). Evaluate fails where a load folds the arm.
#pragma once

#include <ceres/cost_function.h>

#include <memory>
#include <vector>

#include "models/forward_model.h"

namespace sagitta {

struct MarkerMeasurement {
  int frame = 0;                     // chain frame the marker rides on
  Vector3<double> point_in_station;  // m
  Matrix3<double> whitener;          // S^-1, 1/m
  int id = -1;                       // index of the marker, for effects on it
  ReadingKind kind = ReadingKind::kPoint;
  Matrix3<double> rotation_in_station = Matrix3<double>::Identity();  // of kRotation; then the whitener is in 1/rad
};

class ShotCost : public ceres::CostFunction {
 public:
  // `model` outlives the cost. `theta` gives the values of the parameters that
  // are not active; `active` lists those that are blocks.
  static std::unique_ptr<ShotCost> Create(const ForwardModel* model, ShotInput shot,
                                          std::vector<MarkerMeasurement> markers, std::vector<double> theta,
                                          std::vector<int> active, std::vector<int> latent_joints = {});

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;
  // The visit's joint deviations are its last block.
  bool has_deviations() const { return !latent_joints_.empty(); }

 private:
  ShotCost(const ForwardModel* model, ShotInput shot, std::vector<MarkerMeasurement> markers, std::vector<double> theta,
           std::vector<int> active, std::vector<int> latent_joints);

  int FirstActiveBlock() const { return 2 + static_cast<int>(markers_.size()); }
  int LatentBlock() const { return FirstActiveBlock() + static_cast<int>(active_.size()); }
  std::vector<MarkerInFrame> MarkersAt(double const* const* parameters) const;
  // The three rows of reading m in all blocks. whiten: d r / d prediction.
  void WriteJacobians(int m, const Matrix3<double>& whiten, const PointPrediction& prediction,
                      double const* const* parameters, double** jacobians) const;

  const ForwardModel* model_;
  ShotInput shot_;
  std::vector<MarkerMeasurement> markers_;
  std::vector<double> theta_;
  std::vector<int> active_;
  std::vector<int> latent_joints_;
};

}  // namespace sagitta

#include "estimator/least_squares/shot_cost.h"

#include <utility>

#include "estimator/least_squares/rotation_manifold.h"

namespace sagitta {
namespace {

// Ceres wants row-major Jacobians; a single column counts as either.
using RowMajorBlock = Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;

}  // namespace

std::unique_ptr<ShotCost> ShotCost::Create(const ForwardModel* model, ShotInput shot,
                                           std::vector<MarkerMeasurement> markers, std::vector<double> theta,
                                           std::vector<int> active, std::vector<int> latent_joints) {
  return std::unique_ptr<ShotCost>(new ShotCost(model, std::move(shot), std::move(markers), std::move(theta),
                                                std::move(active), std::move(latent_joints)));
}

ShotCost::ShotCost(const ForwardModel* model, ShotInput shot, std::vector<MarkerMeasurement> markers,
                   std::vector<double> theta, std::vector<int> active, std::vector<int> latent_joints)
    : model_(model),
      shot_(std::move(shot)),
      markers_(std::move(markers)),
      theta_(std::move(theta)),
      active_(std::move(active)),
      latent_joints_(std::move(latent_joints)) {
  set_num_residuals(3 * static_cast<int>(markers_.size()));
  mutable_parameter_block_sizes()->assign({3, 4});
  for (const MarkerMeasurement& marker : markers_) {
    mutable_parameter_block_sizes()->push_back(marker.kind == ReadingKind::kPoint ? 3 : 4);
  }
  mutable_parameter_block_sizes()->insert(mutable_parameter_block_sizes()->end(), active_.size(), 1);
  if (!latent_joints_.empty()) mutable_parameter_block_sizes()->push_back(static_cast<int>(latent_joints_.size()));
}

bool ShotCost::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  const Eigen::Map<const Eigen::Quaterniond> rotation(parameters[1]);
  Pose<double> base_in_station;
  base_in_station.translation = Eigen::Map<const Vector3<double>>(parameters[0]);
  base_in_station.rotation = rotation.normalized().toRotationMatrix();
  std::vector<double> theta = theta_;
  for (size_t i = 0; i < active_.size(); ++i) theta[active_[i]] = *parameters[FirstActiveBlock() + i];
  std::vector<double> latent(latent_joints_.empty() ? 0 : model_->chain().num_joints(), 0.0);
  for (size_t i = 0; i < latent_joints_.size(); ++i) latent[latent_joints_[i]] = parameters[LatentBlock()][i];

  static const std::vector<int> kNone;
  std::vector<PointPrediction> predictions;
  if (!model_->Predict(shot_, theta.data(), jacobians != nullptr ? active_ : kNone, base_in_station,
                       MarkersAt(parameters), &predictions, latent.empty() ? nullptr : latent.data())) {
    return false;
  }
  for (size_t m = 0; m < markers_.size(); ++m) {
    const MarkerMeasurement& read = markers_[m];
    const Vector3<double> misfit =
        -MeasuredMinusPredicted({read.kind, read.point_in_station, read.rotation_in_station}, predictions[m].point);
    Eigen::Map<Vector3<double>>(residuals + 3 * m) = read.whitener * misfit;
    if (jacobians == nullptr) continue;
    // d r / d x = S^-1 (dm/dp) (dp/dx), as in linearization.cc.
    WriteJacobians(static_cast<int>(m), read.whitener * MisfitByPrediction(read.kind, misfit), predictions[m],
                   parameters, jacobians);
  }
  return true;
}

std::vector<MarkerInFrame> ShotCost::MarkersAt(double const* const* parameters) const {
  std::vector<MarkerInFrame> markers(markers_.size());
  for (size_t m = 0; m < markers.size(); ++m) {
    markers[m].frame = markers_[m].frame;
    markers[m].id = markers_[m].id;
    markers[m].kind = markers_[m].kind;
    if (markers_[m].kind == ReadingKind::kPoint) {
      markers[m].point = Eigen::Map<const Vector3<double>>(parameters[2 + m]);
    } else {
      markers[m].rotation = Eigen::Map<const Eigen::Quaterniond>(parameters[2 + m]).normalized().toRotationMatrix();
    }
  }
  return markers;
}

void ShotCost::WriteJacobians(int m, const Matrix3<double>& whiten, const PointPrediction& prediction,
                              double const* const* parameters, double** jacobians) const {
  const auto write = [&](int block, int size, const auto& derivative) {
    if (jacobians[block] != nullptr) {
      RowMajorBlock(jacobians[block], num_residuals(), size).middleRows(3 * m, 3) = derivative;
    }
  };
  // Ambient = tangent * pseudo-inverse of PlusJacobian (orthogonal columns of norm 1/2).
  const auto tangent_from_ambient = [&](int block) -> Eigen::Matrix<double, 3, 4> {
    return 4.0 * QuaternionPlusJacobian(parameters[block]).transpose();
  };
  write(0, 3, whiten * prediction.d_translation);
  write(1, 4, whiten * prediction.d_rotation * tangent_from_ambient(1));
  for (int other = 0; other < static_cast<int>(markers_.size()); ++other) {
    const Matrix3<double> own = other == m ? Matrix3<double>(whiten * prediction.d_marker) : Matrix3<double>::Zero();
    if (markers_[other].kind == ReadingKind::kRotation) {
      write(2 + other, 4, own * tangent_from_ambient(2 + other));
    } else {
      write(2 + other, 3, own);
    }
  }
  for (size_t i = 0; i < active_.size(); ++i) {
    write(FirstActiveBlock() + static_cast<int>(i), 1, whiten * prediction.d_theta.col(i));
  }
  if (latent_joints_.empty()) return;
  Eigen::Matrix3Xd d_latent(3, latent_joints_.size());
  for (size_t i = 0; i < latent_joints_.size(); ++i) d_latent.col(i) = prediction.d_latent.col(latent_joints_[i]);
  write(LatentBlock(), static_cast<int>(d_latent.cols()), whiten * d_latent);
}

}  // namespace sagitta

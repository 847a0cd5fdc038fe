// What an instrument sees of a robot: marker points in a station's frame, with
// exact derivatives.
//
//   point_station = t + R * point_base(q, theta),   base_in_station = (t, R)
//
// paper 000, eq. (6) and (8). theta holds one value per model parameter. A
// marker rides on a frame of the chain (flange, a link, the base).
#pragma once

#include <string>
#include <vector>

#include "models/chain.h"
#include "models/geometry.h"
#include "models/kinematics.h"

namespace sagitta {

enum class ParameterKind { kLength, kAngle };

// One scalar unknown of the robot model, neutral at 0.
struct ModelParameter {
  std::string name;  // geometry/<error>
  ParameterKind kind = ParameterKind::kLength;
  int transform = -1;  // the transform whose value it adds to
};

// One marker of a shot: `point` in the frame it rides on.
struct MarkerInFrame {
  int frame = 0;
  Vector3<double> point;  // m
};

// A predicted point with its derivatives, all in the station frame, SI.
struct PointPrediction {
  Vector3<double> point;                           // m
  Matrix3<double> d_rotation;                      // d point / d left perturbation of R
  Matrix3<double> d_marker;                        // d point / d marker point
  Eigen::Matrix<double, 3, Eigen::Dynamic> d_theta;  // one column per active parameter
  // d point / d t is the identity.
};

class ForwardModel {
 public:
  explicit ForwardModel(Chain chain);

  const Chain& chain() const { return chain_; }
  const std::vector<ModelParameter>& parameters() const { return parameters_; }
  int num_parameters() const { return static_cast<int>(parameters_.size()); }

  // Transform values v_e at commanded joint values q and parameters theta.
  // `latent` (one per joint, or null) is added on the encoder side.
  template <typename T>
  std::vector<T> TransformValues(const Eigen::VectorXd& q, const T* theta, const T* latent = nullptr) const;

  // A marker point in the base frame; the templated reference for Predict.
  template <typename T>
  Vector3<T> PointInBase(const Eigen::VectorXd& q, const T* theta, int frame, const Vector3<T>& point) const;

  // All markers of one shot from one kinematic pass. `active` lists the
  // parameters to differentiate by, by index into parameters().
  void Predict(const Eigen::VectorXd& q, const double* theta, const std::vector<int>& active,
               const Pose<double>& base_in_station, const std::vector<MarkerInFrame>& markers,
               std::vector<PointPrediction>* predictions) const;

 private:
  Chain chain_;
  std::vector<ModelParameter> parameters_;
};

template <typename T>
std::vector<T> ForwardModel::TransformValues(const Eigen::VectorXd& q, const T* theta, const T* latent) const {
  const Eigen::VectorXd coupled = chain_.CoupledJointValues(q);
  std::vector<T> values(chain_.transforms.size());
  for (int e = 0; e < chain_.num_transforms(); ++e) {
    const ElementaryTransform& transform = chain_.transforms[e];
    values[e] = T(transform.nominal);
    if (!transform.has_joint()) continue;
    T joint_value = T(coupled[transform.joint]);
    if (latent != nullptr) joint_value += latent[transform.joint];
    values[e] += transform.sign * joint_value;
  }
  for (int i = 0; i < num_parameters(); ++i) values[parameters_[i].transform] += theta[i];
  return values;
}

template <typename T>
Vector3<T> ForwardModel::PointInBase(const Eigen::VectorXd& q, const T* theta, int frame,
                                     const Vector3<T>& point) const {
  ChainState<T> state;
  EvaluateChain(chain_, TransformValues(q, theta).data(), &state);
  return state.frames[frame] * point;
}

}  // namespace sagitta

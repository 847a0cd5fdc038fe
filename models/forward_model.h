// What an instrument sees of a robot: marker points in a station's frame, with
// exact derivatives.
//
//   point_station = t + R * point_base(q, theta, loads),   base_in_station = (t, R)
//
// paper 000, eq. (6) and (8). theta holds one value per model parameter:
// geometric errors, joint compliances, the gravity compensator. A marker rides
// on a frame of the chain (flange, a link, the base).
#pragma once

#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "models/chain.h"
#include "models/elastostatics.h"
#include "models/geometry.h"
#include "models/kinematics.h"
#include "models/quantity.h"
#include "models/robot.h"
#include "models/wrench.h"

namespace sagitta {

enum class ParameterLaw { kGeometry, kCompliance, kCompensator };

// One scalar unknown of the robot model.
struct ModelParameter {
  std::string name;  // geometry/<error>, compliance/<joint>[@<q_deg>], compensator/L ...
  Quantity quantity = Quantity::kLength;
  ParameterLaw law = ParameterLaw::kGeometry;
  int index = -1;        // the transform, the elastic joint, or 0..4 of L, a_x, a_y, s0, Kc
  double nominal = 0.0;  // SI, as the robot file states it; 0 for geometric errors
  double lower = -std::numeric_limits<double>::infinity();
};

// What one shot commands and hangs on the arm; data, no unknowns.
struct ShotInput {
  ShotInput() = default;
  ShotInput(Eigen::VectorXd joint_values) : q(std::move(joint_values)) {}  // NOLINT: an unloaded shot

  Eigen::VectorXd q;                    // commanded, rad or m, one per joint
  std::vector<AppliedWrench> wrenches;  // load, tool weight
};

// One marker of a shot: `point` in the frame it rides on.
struct MarkerInFrame {
  int frame = 0;
  Vector3<double> point;  // m
};

// A predicted point with its derivatives, all in the station frame, SI.
struct PointPrediction {
  Vector3<double> point;                             // m
  Matrix3<double> d_rotation;                        // d point / d left perturbation of R
  Matrix3<double> d_marker;                          // d point / d marker point
  Eigen::Matrix<double, 3, Eigen::Dynamic> d_theta;  // one column per active parameter
  Eigen::Matrix<double, 3, Eigen::Dynamic> d_latent;  // one column per joint, where a deviation was given
  // d point / d t is the identity.
};

class ForwardModel {
 public:
  explicit ForwardModel(const Robot& robot);
  explicit ForwardModel(Chain chain);  // rigid

  const Chain& chain() const { return chain_; }
  const ElasticSystem& elastic_system() const { return elastic_; }
  const std::vector<ModelParameter>& parameters() const { return parameters_; }
  int num_parameters() const { return static_cast<int>(parameters_.size()); }
  std::vector<double> NominalValues() const;

  // Transform values v_e of the undeflected arm at commanded joint values q and
  // parameters theta. `latent` (one per joint, or null) is added on the encoder
  // side.
  template <typename T>
  std::vector<T> TransformValues(const Eigen::VectorXd& q, const T* theta, const T* latent = nullptr) const;

  // A marker point in the base frame; the templated reference for Predict.
  template <typename T>
  Vector3<T> PointInBase(const ShotInput& shot, const T* theta, int frame, const Vector3<T>& point,
                         const Matrix3<T>& base_rotation = Matrix3<T>::Identity()) const;

  // All markers of one shot from one kinematic pass and one equilibrium.
  // `active` lists the parameters to differentiate by, by index into
  // parameters(). `latent`: joint deviations (rad or m, one per joint), null for
  // none. False when the equilibrium diverges (a load folds the arm).
  bool Predict(const ShotInput& shot, const double* theta, const std::vector<int>& active,
               const Pose<double>& base_in_station, const std::vector<MarkerInFrame>& markers,
               std::vector<PointPrediction>* predictions, const double* latent = nullptr) const;

  // The loaded state of the arm: deflections, torques, derivatives.
  Equilibrium Equilibrate(const ShotInput& shot, const double* theta, const Matrix3<double>& base_rotation,
                          const double* latent = nullptr) const;

 private:
  void AddGeometry();
  void AddCompliances(const Robot& robot);
  void AddCompensator(const GravityCompensator& compensator);
  bool IsElastic(const ShotInput& shot) const {
    return !elastic_.empty() && (!shot.wrenches.empty() || elastic_.compensator);
  }

  Chain chain_;
  ElasticSystem elastic_;
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
  for (int i = 0; i < num_parameters(); ++i) {
    if (parameters_[i].law == ParameterLaw::kGeometry) values[parameters_[i].index] += theta[i];
  }
  return values;
}

template <typename T>
Vector3<T> ForwardModel::PointInBase(const ShotInput& shot, const T* theta, int frame, const Vector3<T>& point,
                                     const Matrix3<T>& base_rotation) const {
  std::vector<T> values = TransformValues(shot.q, theta);
  if (IsElastic(shot)) {
    const Eigen::VectorXd coupled = chain_.CoupledJointValues(shot.q);
    values = IterateEquilibrium({&chain_, &elastic_, &coupled, &shot.wrenches}, theta, values, base_rotation);
  }
  ChainState<T> state;
  EvaluateChain(chain_, values.data(), &state);
  return state.frames[frame] * point;
}

}  // namespace sagitta

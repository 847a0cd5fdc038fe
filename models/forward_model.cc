#include "models/forward_model.h"

#include <cstdio>

namespace sagitta {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;

std::string ShortNumber(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

// dp / dv_e of a point at the loaded arm: the slot moves the point, and bends
// the arm by changing the torques (elastostatics.h).
class LoadedVelocities {
 public:
  LoadedVelocities(const Chain& chain, const ElasticSystem& system, const Equilibrium& equilibrium)
      : chain_(chain), system_(system), equilibrium_(equilibrium) {
    if (system_.empty() || equilibrium_.response.size() == 0) return;
    by_torque_ = equilibrium_.response * equilibrium_.compliance.asDiagonal();
    by_value_ = by_torque_ * equilibrium_.torque_by_value;
  }

  // 3 x joints: how deflections move the point.
  Eigen::Matrix3Xd ByDeflection(const Vector3<double>& point_in_base, int frame) const {
    Eigen::Matrix3Xd velocities = Eigen::Matrix3Xd::Zero(3, is_loaded() ? system_.joints.size() : 0);
    for (int j = 0; j < velocities.cols(); ++j) {
      const int e = system_.joints[j].transform;
      if (e < frame) velocities.col(j) = PointVelocity(chain_, equilibrium_.state, e, point_in_base);
    }
    return velocities;
  }
  Vector3<double> BySlot(int e, const Vector3<double>& point_in_base, int frame,
                         const Eigen::Matrix3Xd& by_deflection) const {
    Vector3<double> velocity = Vector3<double>::Zero();
    if (e < frame) velocity = PointVelocity(chain_, equilibrium_.state, e, point_in_base);
    if (is_loaded()) velocity += by_deflection * by_value_.col(e);
    return velocity;
  }

  bool is_loaded() const { return by_torque_.size() > 0; }
  const Eigen::MatrixXd& by_torque() const { return by_torque_; }  // d u / d tau at fixed values

 private:
  const Chain& chain_;
  const ElasticSystem& system_;
  const Equilibrium& equilibrium_;
  Eigen::MatrixXd by_torque_;  // A K
  Eigen::MatrixXd by_value_;   // A K T
};

}  // namespace

ForwardModel::ForwardModel(Chain chain) : chain_(std::move(chain)) { AddGeometry(); }

ForwardModel::ForwardModel(const Robot& robot) : chain_(robot.chain) {
  AddGeometry();
  AddCompliances(robot);
  if (robot.gravity_compensator) AddCompensator(*robot.gravity_compensator);
}

void ForwardModel::AddGeometry() {
  for (int e = 0; e < chain_.num_transforms(); ++e) {
    const ElementaryTransform& transform = chain_.transforms[e];
    if (transform.error.empty()) continue;
    const Quantity quantity = transform.is_rotation() ? Quantity::kAngle : Quantity::kLength;
    parameters_.push_back({"geometry/" + transform.error, quantity, ParameterLaw::kGeometry, e});
  }
}

void ForwardModel::AddCompliances(const Robot& robot) {
  for (const JointCompliance& compliance : robot.compliances) {
    const Joint& joint = chain_.joints[compliance.joint];
    const bool turns = joint.type == JointType::kRevolute;
    ElasticJoint elastic;
    elastic.joint = compliance.joint;
    elastic.transform = chain_.JointTransform(compliance.joint);
    for (const JointCompliance::Node& node : compliance.nodes) {
      std::string name = "compliance/" + joint.name;
      if (compliance.is_table) name += "@" + ShortNumber(turns ? node.q / kDegree : node.q / 1e-3);
      elastic.node_q.push_back(node.q);
      elastic.node_parameter.push_back(num_parameters());
      const Quantity quantity = turns ? Quantity::kCompliance : Quantity::kLinearCompliance;
      const int index = static_cast<int>(elastic_.joints.size());
      parameters_.push_back({name, quantity, ParameterLaw::kCompliance, index, node.k, 0.0});
    }
    elastic_.joints.push_back(elastic);
  }
}

void ForwardModel::AddCompensator(const GravityCompensator& compensator) {
  for (size_t j = 0; j < elastic_.joints.size(); ++j) {
    if (elastic_.joints[j].joint != compensator.joint) continue;
    const ElementaryTransform& transform = chain_.transforms[elastic_.joints[j].transform];
    elastic_.compensator = CompensatorOnJoint{static_cast<int>(j), num_parameters(), transform.nominal, transform.sign,
                                              compensator.preload};
    const double nominal[5] = {compensator.L, compensator.a_x, compensator.a_y, compensator.s0, compensator.Kc};
    const char* names[5] = {"L", "a_x", "a_y", "s0", "Kc"};
    for (int i = 0; i < 5; ++i) {
      const Quantity quantity = i < 4 ? Quantity::kLength : Quantity::kSpringRate;
      parameters_.push_back({std::string("compensator/") + names[i], quantity, ParameterLaw::kCompensator, i, nominal[i]});
    }
    parameters_.back().lower = 0.0;  // Kc
  }
}

std::vector<double> ForwardModel::NominalValues() const {
  std::vector<double> theta;
  for (const ModelParameter& parameter : parameters_) theta.push_back(parameter.nominal);
  return theta;
}

Equilibrium ForwardModel::Equilibrate(const ShotInput& shot, const double* theta,
                                      const Matrix3<double>& base_rotation, const double* latent) const {
  std::vector<double> values = TransformValues(shot.q, theta, latent);
  if (IsElastic(shot)) {
    const Eigen::VectorXd coupled = chain_.CoupledJointValues(shot.q);
    return SolveEquilibrium({&chain_, &elastic_, &coupled, &shot.wrenches}, theta, std::move(values), base_rotation);
  }
  Equilibrium rigid;
  rigid.converged = true;
  rigid.values = std::move(values);
  EvaluateChain(chain_, rigid.values.data(), &rigid.state);
  return rigid;
}

bool ForwardModel::Predict(const ShotInput& shot, const double* theta, const std::vector<int>& active,
                           const Pose<double>& base_in_station, const std::vector<MarkerInFrame>& markers,
                           std::vector<PointPrediction>* predictions, const double* latent) const {
  const Equilibrium equilibrium = Equilibrate(shot, theta, base_in_station.rotation, latent);
  if (!equilibrium.converged) return false;
  const LoadedVelocities velocities(chain_, elastic_, equilibrium);
  const Eigen::VectorXd coupled = chain_.CoupledJointValues(shot.q);
  predictions->resize(markers.size());
  for (size_t m = 0; m < markers.size(); ++m) {
    const MarkerInFrame& marker = markers[m];
    PointPrediction& prediction = (*predictions)[m];
    const Pose<double>& base_from_frame = equilibrium.state.frames[marker.frame];
    const Vector3<double> point_in_base = base_from_frame * marker.point;
    const Vector3<double> arm = base_in_station.rotation * point_in_base;
    const Eigen::Matrix3Xd by_deflection = velocities.ByDeflection(point_in_base, marker.frame);
    prediction.point = arm + base_in_station.translation;
    prediction.d_rotation = -Skew(arm);
    prediction.d_marker = base_in_station.rotation * base_from_frame.rotation;
    prediction.d_theta.setZero(3, active.size());
    if (velocities.is_loaded()) {
      prediction.d_rotation += base_in_station.rotation * by_deflection * velocities.by_torque() * equilibrium.torque_by_rotation;
    }
    for (size_t i = 0; i < active.size(); ++i) {
      const ModelParameter& parameter = parameters_[active[i]];
      Vector3<double> velocity = Vector3<double>::Zero();
      if (parameter.law == ParameterLaw::kGeometry) {
        velocity = velocities.BySlot(parameter.index, point_in_base, marker.frame, by_deflection);
      } else if (velocities.is_loaded() && parameter.law == ParameterLaw::kCompliance) {
        const ElasticJoint& joint = elastic_.joints[parameter.index];
        for (const ElasticJoint::Weight& w : joint.WeightsAt(coupled[joint.joint])) {
          if (w.parameter != active[i]) continue;
          velocity = by_deflection * equilibrium.response.col(parameter.index) * (w.weight * equilibrium.torque[parameter.index]);
        }
      } else if (velocities.is_loaded()) {
        velocity = by_deflection * (velocities.by_torque() * equilibrium.torque_by_spring.col(parameter.index));
      }
      prediction.d_theta.col(i) = base_in_station.rotation * velocity;
    }
    prediction.d_latent.resize(3, latent != nullptr ? chain_.num_joints() : 0);
    for (int j = 0; j < prediction.d_latent.cols(); ++j) {
      const int e = chain_.JointTransform(j);
      prediction.d_latent.col(j) = base_in_station.rotation * chain_.transforms[e].sign *
                                   velocities.BySlot(e, point_in_base, marker.frame, by_deflection);
    }
  }
  return true;
}

}  // namespace sagitta

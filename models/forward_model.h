// What an instrument sees of a robot: marker points in a station's frame, with
// exact derivatives.
//
//   point_station = t + R * point_base(q, theta, loads),   base_in_station = (t, R)
//
// paper 000, eq. (6) and (8). theta holds one value per model parameter:
// geometric errors, joint compliances, the gravity compensator, the effects of
// the robot. A marker rides on a frame of the chain (flange, a link, the base).
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
#include "models/reading.h"
#include "models/robot.h"
#include "models/sight.h"
#include "models/wrench.h"

namespace sagitta {

enum class ParameterLaw { kGeometry, kCompliance, kCompensator, kEffect };

// One scalar unknown of the robot model.
struct ModelParameter {
  std::string name;  // geometry/<error>, compliance/<joint>[@<q_deg>], compensator/L, effect/... of FORMATS section 4
  Quantity quantity = Quantity::kLength;
  ParameterLaw law = ParameterLaw::kGeometry;
  int index = -1;        // the transform, index into compliances, CompensatorPart, index into effects
  double nominal = 0.0;  // SI, as the robot file states it; 0 for geometric errors
  double lower = -std::numeric_limits<double>::infinity();
  // SI, as the robot file states it: of an effect about 0, of a spring about its nominal value; 0: none.
  double prior_sigma = 0.0;
};
// Name of a geometric error among the unknowns.
inline std::string GeometryName(const std::string& error) { return "geometry/" + error; }

// What one shot commands and hangs on the arm; data, no unknowns.
struct ShotInput {
  // Compiled once (forward_model.cc), not in each file that holds one.
  ShotInput();
  ShotInput(Eigen::VectorXd joint_values) { conditions.q = std::move(joint_values); }  // NOLINT: an unloaded shot
  ShotInput(const ShotInput&);
  ShotInput(ShotInput&&) noexcept;
  ShotInput& operator=(const ShotInput&);
  ShotInput& operator=(ShotInput&&) noexcept;
  ~ShotInput();

  ShotConditions conditions;
  std::vector<AppliedWrench> wrenches;  // load, tool weight
  std::vector<double> memory;           // of each effect of that model: what the shots before left (MemoriesOf)
  ShotTerms terms;                      // of one model's compliances and effects, by ForwardModel::Prepare
  bool prepared = false;                // false: the model prepares a copy for every call
};

// What an effect remembers at each shot, of those that were measured before it in its campaign: by time where every
// shot states it, else as given. 0 for an effect that remembers nothing.
std::vector<double> MemoriesOf(const Robot& robot, const EffectDefinition& definition, const EffectSpec& spec,
                               const std::vector<ShotInput>& shots);

// One reading of a shot: `point` or `rotation` of the target in the frame it rides on.
struct MarkerInFrame {
  int frame = 0;
  Vector3<double> point;  // m
  int id = -1;            // index of the marker, for effects on it
  ReadingKind kind = ReadingKind::kPoint;
  Matrix3<double> rotation = Matrix3<double>::Identity();  // frame_from_target, of kRotation
};

// A predicted reading with its derivatives, all in the station frame, SI. Derivatives of a rotation are left
// perturbations, rad.
struct PointPrediction {
  Vector3<double> point;                              // m; of a rotation its rotation vector, rad
  Matrix3<double> d_translation;                      // d point / d t: the identity, but for instrument effects
  Matrix3<double> d_rotation;                         // d point / d left perturbation of R
  Matrix3<double> d_marker;                           // d point / d marker point, or left perturbation of its rotation
  Eigen::Matrix<double, 3, Eigen::Dynamic> d_theta;   // one column per active parameter
  Eigen::Matrix<double, 3, Eigen::Dynamic> d_latent;  // one column per joint, where a deviation was given
};

class MarkerVelocities;  // forward_model.cc

// Predicts readings of one robot, with their derivatives.
class ForwardModel {
 public:
  // `markers`: names, for effects that act on one. Throws std::invalid_argument for an effect that there is not, and
  // for a term of an own effect that leads nowhere.
  explicit ForwardModel(const Robot& robot, std::vector<std::string> markers = {});
  explicit ForwardModel(Chain chain);  // rigid

  const Robot& robot() const { return robot_; }
  const Chain& chain() const { return robot_.chain; }
  const std::vector<ModelParameter>& parameters() const { return parameters_; }
  int num_parameters() const { return static_cast<int>(parameters_.size()); }
  // Transforms that may deflect: the order of Equilibrium's torques.
  const std::vector<int>& elastic_slots() const { return elastic_slots_; }
  std::vector<double> NominalValues() const;

  // Fills the terms of the shots of a campaign: compliances and effects of this model. Effects that remember the
  // shots before do so in the order of time, where every shot states it, else in the order given. Throws
  // std::invalid_argument where a shot has another number of joint values than the robot has joints; every function
  // below does so for a shot that is not prepared.
  void Prepare(std::vector<ShotInput>* campaign) const;
  // The same for a shot with nothing before it.
  void Prepare(ShotInput* shot) const;
  // The same for a shot whose joint values were changed by little: what the shots before left stays as it was.
  void PrepareAgain(ShotInput* shot) const;
  // Whether an effect of the robot goes with what was done before.
  bool Remembers() const;

  // Transform values v_e of the undeflected arm. `latent` (one per joint, or
  // null) is added on the encoder side.
  template <typename T>
  std::vector<T> TransformValues(const ShotInput& shot, const T* theta, const T* latent = nullptr) const;

  // Whether the marker rides on the arm: markers on the world or the foot do not grow with it.
  bool Grows(const MarkerInFrame& marker) const { return marker.frame > chain().BaseFrame(); }

  // A marker point in the station frame; the templated reference for Predict, as are the next two. They iterate the
  // equilibrium a fixed number of times and do not judge it: where a load folds the arm, what comes out is the last
  // iterate, which means nothing. Predict and Equilibrate say whether there is an equilibrium.
  template <typename T>
  Vector3<T> PointInStation(const ShotInput& shot, const T* theta, const MarkerInFrame& marker, const Vector3<T>& point,
                            const Matrix3<T>& rotation, const Vector3<T>& translation) const;
  template <typename T>
  Vector3<T> PointInBase(const ShotInput& shot, const T* theta, int frame, const Vector3<T>& point,
                         const Matrix3<T>& base_rotation = Matrix3<T>::Identity()) const;
  // base_from_frame of the loaded arm.
  template <typename T>
  Pose<T> FrameInBase(const ShotInput& shot, const T* theta, int frame,
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

  // What loads, effects and the compensator ask of each joint at the loaded arm, N m (N where it slides) about the
  // joint's positive direction; measured torques are left aside. Empty where a load folds the arm.
  Eigen::VectorXd ModelledJointTorques(ShotInput shot, const double* theta, const Matrix3<double>& base_rotation) const;

  // The robot with theta in its homes: nominal values, compliances, compensator, effects.
  Robot WithValues(const std::vector<double>& theta) const;

 private:
  void AddGeometry();
  void AddCompliances();
  void AddCompensator();
  void AddEffects();
  ShotInput Prepared(ShotInput shot) const {
    Prepare(&shot);
    return shot;
  }
  void AddTerms(ShotInput* shot) const;
  // Adds the terms of the i-th effect in a shot; those of an effect of the user's own are checked.
  void ApplyEffect(size_t i, const ShotConditions& shot, double memory, ShotTerms* terms) const;
  void PredictTurn(const ShotInput& shot, const double* theta, const std::vector<int>& column_of,
                   const Equilibrium& equilibrium, const Matrix3<double>& base_rotation, const MarkerInFrame& marker,
                   PointPrediction* prediction) const;
  bool IsElastic(const ShotInput& shot) const;
  ElasticQuery Query(const ShotInput& shot, const Eigen::VectorXd& coupled) const;
  template <typename Add>
  void AddDisplacements(const ShotInput& shot, const std::vector<int>& column_of, const MarkerVelocities& velocities,
                        const Add& add) const;
  template <typename Add>
  void AddLoads(const ShotInput& shot, const Equilibrium& equilibrium, const std::vector<int>& column_of,
                const Matrix3<double>& rotation, const MarkerVelocities& velocities, const Add& add) const;

  Robot robot_;
  std::vector<std::string> markers_;
  std::vector<ModelParameter> parameters_;
  std::vector<int> elastic_slots_;
  std::optional<CompensatorOnJoint> compensator_;
  std::vector<int> first_of_compliance_;              // parameter of its first node
  std::vector<const EffectDefinition*> definitions_;  // of robot_.effects
  std::vector<int> first_of_effect_;
};

template <typename T>
std::vector<T> ForwardModel::TransformValues(const ShotInput& shot, const T* theta, const T* latent) const {
  if (!shot.prepared) return TransformValues(Prepared(shot), theta, latent);
  const Chain& chain = robot_.chain;
  const Eigen::VectorXd coupled = chain.CoupledJointValues(shot.conditions.q);
  std::vector<T> values(chain.transforms.size());
  for (int e = 0; e < chain.num_transforms(); ++e) {
    const ElementaryTransform& transform = chain.transforms[e];
    values[e] = T(transform.nominal);
    if (!transform.has_joint()) continue;
    T joint_value = T(coupled[transform.joint]);
    if (latent != nullptr) joint_value += latent[transform.joint];
    values[e] += transform.sign * joint_value;
  }
  for (int i = 0; i < num_parameters(); ++i) {
    if (parameters_[i].law == ParameterLaw::kGeometry) values[parameters_[i].index] += theta[i];
  }
  for (const SlotTerm& term : shot.terms.slots) values[term.transform] += term.factor * theta[term.parameter];
  return values;
}

template <typename T>
Vector3<T> ForwardModel::PointInBase(const ShotInput& shot, const T* theta, int frame, const Vector3<T>& point,
                                     const Matrix3<T>& base_rotation) const {
  return FrameInBase(shot, theta, frame, base_rotation) * point;
}

template <typename T>
Pose<T> ForwardModel::FrameInBase(const ShotInput& shot, const T* theta, int frame,
                                  const Matrix3<T>& base_rotation) const {
  if (!shot.prepared) return FrameInBase(Prepared(shot), theta, frame, base_rotation);
  std::vector<T> values = TransformValues(shot, theta);
  if (IsElastic(shot)) {
    const Eigen::VectorXd coupled = robot_.chain.CoupledJointValues(shot.conditions.q);
    values = IterateEquilibrium(Query(shot, coupled), theta, values, base_rotation);
  }
  ChainState<T> state;
  EvaluateChain(robot_.chain, values.data(), &state);
  return state.frames[frame];
}

template <typename T>
Vector3<T> ForwardModel::PointInStation(const ShotInput& shot, const T* theta, const MarkerInFrame& marker,
                                        const Vector3<T>& point, const Matrix3<T>& rotation,
                                        const Vector3<T>& translation) const {
  if (!shot.prepared) return PointInStation(Prepared(shot), theta, marker, point, rotation, translation);
  Vector3<T> own = point;
  for (const MarkerTerm& term : shot.terms.markers) {
    if (term.marker == marker.id) own += theta[term.parameter] * term.direction.cast<T>();
  }
  const Pose<T> base_from_frame = FrameInBase(shot, theta, marker.frame, rotation);
  const Vector3<T> in_base = base_from_frame * own;
  T scale(1);
  if (Grows(marker)) {
    for (const BaseTerm& term : shot.terms.base) scale += theta[term.parameter] * term.factor;
  }
  const Vector3<T> truth = rotation * Vector3<T>(scale * in_base) + translation;
  Vector3<T> seen = truth;
  for (const StationTerm& term : shot.terms.station) {
    seen += theta[term.parameter] * (term.gradient.cast<T>() * truth + term.offset.cast<T>());
  }
  for (const SightTerm& term : shot.terms.sights) {
    if (term.marker >= 0 && term.marker != marker.id) continue;
    const Vector3<T> axis = rotation * Vector3<T>(base_from_frame.rotation * term.axis.cast<T>());
    seen += theta[term.parameter] * SightDisplacement(term, truth, axis);
  }
  return seen;
}

// Compiled once (forward_model.cc).
extern template std::vector<double> ForwardModel::TransformValues(const ShotInput& shot, const double* theta,
                                                                  const double* latent) const;
extern template Pose<double> ForwardModel::FrameInBase(const ShotInput& shot, const double* theta, int frame,
                                                       const Matrix3<double>& base_rotation) const;

}  // namespace sagitta

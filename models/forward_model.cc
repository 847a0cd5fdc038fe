#include "models/forward_model.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <numeric>
#include <stdexcept>

#include "models/effects/catalogue.h"

namespace sagitta {

template std::vector<double> ForwardModel::TransformValues(const ShotInput& shot, const double* theta,
                                                           const double* latent) const;
template Pose<double> ForwardModel::FrameInBase(const ShotInput& shot, const double* theta, int frame,
                                                const Matrix3<double>& base_rotation) const;

ShotInput::ShotInput() = default;
ShotInput::ShotInput(const ShotInput&) = default;
ShotInput::ShotInput(ShotInput&&) noexcept = default;
ShotInput& ShotInput::operator=(const ShotInput&) = default;
ShotInput& ShotInput::operator=(ShotInput&&) noexcept = default;
ShotInput::~ShotInput() = default;

namespace {

// Indices of the shots as they were measured: by time where every one states it, else as given.
std::vector<size_t> OrderOfTime(const std::vector<ShotInput>& shots) {
  std::vector<size_t> order(shots.size());
  std::iota(order.begin(), order.end(), size_t{0});
  const auto is_timed = [](const ShotInput& shot) { return shot.conditions.has_time; };
  if (!std::all_of(shots.begin(), shots.end(), is_timed)) return order;
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return shots[a].conditions.time < shots[b].conditions.time; });
  return order;
}

// Weights of a compliance's nodes at q: piecewise linear, constant outside.
std::vector<std::pair<int, double>> NodeWeights(const JointCompliance& compliance, double q) {
  const auto& nodes = compliance.nodes;
  size_t above = 0;
  while (above < nodes.size() && nodes[above].q <= q) ++above;
  if (above == 0) return {{0, 1.0}};
  if (above == nodes.size()) return {{static_cast<int>(nodes.size()) - 1, 1.0}};
  const double t = (q - nodes[above - 1].q) / (nodes[above].q - nodes[above - 1].q);
  return {{static_cast<int>(above) - 1, 1.0 - t}, {static_cast<int>(above), t}};
}

// The chain with every tilt slot that an effect of the robot needs.
Robot WithTiltSlots(Robot robot) {
  for (const EffectSpec& spec : robot.effects) {
    const EffectDefinition* definition = FindEffect(robot, spec.effect);
    if (definition == nullptr) throw std::invalid_argument("ForwardModel: there is no effect '" + spec.effect + "'");
    if (!definition->tilts) continue;
    AddTiltSlots(definition->target == EffectTarget::kJoint ? robot.chain.FindJoint(spec.target) : -1, &robot.chain);
  }
  return robot;
}

bool IsOf(const SightTerm& term, const MarkerInFrame& marker) { return term.marker < 0 || term.marker == marker.id; }

// How far the arm and its markers have grown.
double ScaleOf(const ShotTerms& terms, const double* theta) {
  double scale = 1.0;
  for (const BaseTerm& term : terms.base) scale += theta[term.parameter] * term.factor;
  return scale;
}

// What the station sees of a true point: the point, and how it follows the truth.
struct SeenPoint {
  // station_from_frame: rotation of the frame that the marker rides on.
  SeenPoint(const ShotTerms& terms, const double* theta, const MarkerInFrame& marker, const Vector3<double>& truth,
            const Matrix3<double>& station_from_frame)
      : point(truth) {
    for (const StationTerm& term : terms.station) {
      point += theta[term.parameter] * (term.gradient * truth + term.offset);
      from_true += theta[term.parameter] * term.gradient;
    }
    for (const SightTerm& term : terms.sights) {
      if (!IsOf(term, marker) || theta[term.parameter] == 0.0) continue;
      const Vector3<double> axis = station_from_frame * term.axis;
      const SightGradient sight = DifferentiateSight(term, truth, axis);
      point += theta[term.parameter] * sight.displacement;
      from_true += theta[term.parameter] * sight.by_point;
      // An axis turned by omega moves by omega x axis.
      if (term.law == SightLaw::kSquaredIncidence) by_turn -= theta[term.parameter] * sight.by_axis * Skew(axis);
    }
  }

  Vector3<double> point;
  Matrix3<double> from_true = Matrix3<double>::Identity();  // of a displacement of the truth, station frame
  Matrix3<double> by_turn = Matrix3<double>::Zero();        // of a small rotation of the marker's frame, station frame
  bool turns() const { return !by_turn.isZero(0.0); }
};

Vector3<double> OwnPoint(const ShotTerms& terms, const double* theta, const MarkerInFrame& marker) {
  Vector3<double> own = marker.point;
  for (const MarkerTerm& term : terms.markers) {
    if (term.marker == marker.id) own += theta[term.parameter] * term.direction;
  }
  return own;
}

// By how much the measurement frame itself turns what it sees: a gradient G moves points by theta G p, its skew part
// turns them, its symmetric part (a scale) does not.
Vector3<double> TurnOf(const StationTerm& term) {
  const Matrix3<double> skew = 0.5 * (term.gradient - term.gradient.transpose());
  return {skew(2, 1), skew(0, 2), skew(1, 0)};
}

Vector3<double> TurnOfStation(const ShotTerms& terms, const double* theta) {
  Vector3<double> turn = Vector3<double>::Zero();
  for (const StationTerm& term : terms.station) turn += theta[term.parameter] * TurnOf(term);
  return turn;
}

}  // namespace

// d point_base of one marker, or the small rotation of its frame, by everything, at the loaded arm.
class MarkerVelocities {
 public:
  enum class Of { kPoint, kTurn };
  MarkerVelocities(const Chain& chain, const std::vector<int>& slots, const Equilibrium& equilibrium,
                   const Vector3<double>& point_in_base, int frame, Of of = Of::kPoint)
      : chain_(chain), equilibrium_(equilibrium), point_(point_in_base), frame_(frame), of_(of) {
    by_deflection_.setZero(3, equilibrium.response.rows());
    for (int s = 0; s < by_deflection_.cols(); ++s) by_deflection_.col(s) = Direct(slots[s]);
  }

  // By a slot's value: it moves the point, and bends the arm by changing the torques.
  Vector3<double> BySlot(int e) const {
    Vector3<double> velocity = Direct(e);
    if (by_deflection_.cols() > 0) velocity += by_deflection_ * equilibrium_.by_value.col(e);
    return velocity;
  }
  Vector3<double> ByTorques(const Eigen::VectorXd& torques) const {
    return by_deflection_ * (equilibrium_.by_torque * torques);
  }
  // By a deflection imposed on slot s (the arm responds).
  Vector3<double> ByDeflection(int s) const { return by_deflection_ * equilibrium_.response.col(s); }
  Matrix3<double> ByRotation() const {
    if (by_deflection_.cols() == 0) return Matrix3<double>::Zero();
    return by_deflection_ * equilibrium_.by_rotation;
  }

 private:
  Vector3<double> Direct(int e) const {
    if (e >= frame_) return Vector3<double>::Zero();
    if (of_ == Of::kTurn) {
      return chain_.transforms[e].is_rotation() ? equilibrium_.state.axis[e] : Vector3<double>(Vector3<double>::Zero());
    }
    return PointVelocity(chain_, equilibrium_.state, e, point_);
  }

  const Chain& chain_;
  const Equilibrium& equilibrium_;
  const Vector3<double> point_;
  const int frame_;
  const Of of_;
  Eigen::Matrix3Xd by_deflection_;
};

ForwardModel::ForwardModel(Chain chain) {
  robot_.chain = std::move(chain);
  AddGeometry();
}

ForwardModel::ForwardModel(const Robot& robot, std::vector<std::string> markers)
    : robot_(WithTiltSlots(robot)), markers_(std::move(markers)) {
  AddGeometry();
  AddCompliances();
  AddCompensator();
  AddEffects();
  std::sort(elastic_slots_.begin(), elastic_slots_.end());
  elastic_slots_.erase(std::unique(elastic_slots_.begin(), elastic_slots_.end()), elastic_slots_.end());
}

std::vector<double> MemoriesOf(const Robot& robot, const EffectDefinition& definition, const EffectSpec& spec,
                               const std::vector<ShotInput>& shots) {
  std::vector<double> memories(shots.size(), 0.0);
  if (definition.remember == nullptr) return memories;
  std::map<int, std::vector<size_t>> campaigns;
  for (const size_t s : OrderOfTime(shots)) campaigns[shots[s].conditions.campaign].push_back(s);
  for (const auto& [campaign, order] : campaigns) {
    std::vector<const ShotConditions*> in_order;
    for (const size_t s : order) in_order.push_back(&shots[s].conditions);
    const std::vector<double> own = definition.remember(robot, spec, in_order);
    if (own.size() != order.size()) {
      throw std::invalid_argument("effect '" + definition.name + "': remember returns " + std::to_string(own.size()) +
                                  " numbers for " + std::to_string(order.size()) + " shots: it is one per shot");
    }
    for (size_t k = 0; k < order.size(); ++k) memories[order[k]] = own[k];
  }
  return memories;
}

void ForwardModel::Prepare(ShotInput* shot) const {
  std::vector<ShotInput> alone = {std::move(*shot)};
  Prepare(&alone);
  *shot = std::move(alone[0]);
}

namespace {

void CheckJointValues(const Chain& chain, const Eigen::VectorXd& q) {
  if (q.size() == chain.num_joints()) return;
  throw std::invalid_argument("ForwardModel: " + std::to_string(q.size()) + " joint values, the robot has " +
                              std::to_string(chain.num_joints()) + " joints");
}

}  // namespace

void ForwardModel::Prepare(std::vector<ShotInput>* campaign) const {
  for (const ShotInput& shot : *campaign) CheckJointValues(chain(), shot.conditions.q);
  std::vector<std::vector<double>> memories;  // of each effect
  for (size_t i = 0; i < robot_.effects.size(); ++i)
    memories.push_back(MemoriesOf(robot_, *definitions_[i], robot_.effects[i], *campaign));
  for (size_t s = 0; s < campaign->size(); ++s) {
    ShotInput& shot = (*campaign)[s];
    shot.memory.resize(memories.size());
    for (size_t i = 0; i < memories.size(); ++i) shot.memory[i] = memories[i][s];
    AddTerms(&shot);
  }
}

void ForwardModel::PrepareAgain(ShotInput* shot) const {
  CheckJointValues(chain(), shot->conditions.q);
  if (shot->prepared && shot->memory.size() == robot_.effects.size()) return AddTerms(shot);
  Prepare(shot);
}

bool ForwardModel::Remembers() const {
  return std::any_of(definitions_.begin(), definitions_.end(), [](const auto* effect) { return effect->remember; });
}

void ForwardModel::AddTerms(ShotInput* shot) const {
  shot->terms = ShotTerms();
  shot->prepared = true;
  const Eigen::VectorXd coupled = chain().CoupledJointValues(shot->conditions.q);
  for (size_t c = 0; c < robot_.compliances.size(); ++c) {
    const JointCompliance& compliance = robot_.compliances[c];
    for (const auto& [node, weight] : NodeWeights(compliance, coupled[compliance.joint])) {
      shot->terms.elastic.push_back(
          {chain().JointTransform(compliance.joint), first_of_compliance_[c] + node, weight, ElasticLaw::kLinear});
    }
  }
  // v = sign q, and torque times motion is the same work in both.
  for (long j = 0; j < shot->conditions.joint_torques.size(); ++j) {
    const int e = chain().JointTransform(static_cast<int>(j));
    shot->terms.torques.push_back({e, chain().transforms[e].sign * shot->conditions.joint_torques[j]});
  }
  for (size_t i = 0; i < robot_.effects.size(); ++i) {
    ApplyEffect(i, shot->conditions, shot->memory[i], &shot->terms);
  }
}

bool ForwardModel::IsElastic(const ShotInput& shot) const {
  if (!shot.terms.sags.empty()) return true;
  const auto acts_unloaded = [](const ElasticTerm& term) { return term.law == ElasticLaw::kBump; };
  if (std::any_of(shot.terms.elastic.begin(), shot.terms.elastic.end(), acts_unloaded)) return true;
  const bool is_loaded = !shot.wrenches.empty() || !shot.terms.wrenches.empty() || !shot.terms.torques.empty();
  return !shot.terms.elastic.empty() && (is_loaded || compensator_);
}

ElasticQuery ForwardModel::Query(const ShotInput& shot, const Eigen::VectorXd& coupled) const {
  return {&robot_.chain, &elastic_slots_, compensator_ ? &*compensator_ : nullptr,
          &coupled,      &shot.wrenches,  &shot.terms};
}

Equilibrium ForwardModel::Equilibrate(const ShotInput& shot, const double* theta, const Matrix3<double>& base_rotation,
                                      const double* latent) const {
  if (!shot.prepared) return Equilibrate(Prepared(shot), theta, base_rotation, latent);
  std::vector<double> values = TransformValues(shot, theta, latent);
  if (IsElastic(shot)) {
    const Eigen::VectorXd coupled = chain().CoupledJointValues(shot.conditions.q);
    return SolveEquilibrium(Query(shot, coupled), theta, std::move(values), base_rotation);
  }
  Equilibrium rigid;
  rigid.converged = true;
  rigid.values = std::move(values);
  EvaluateChain(chain(), rigid.values.data(), &rigid.state);
  return rigid;
}

bool ForwardModel::Predict(const ShotInput& shot, const double* theta, const std::vector<int>& active,
                           const Pose<double>& base_in_station, const std::vector<MarkerInFrame>& markers,
                           std::vector<PointPrediction>* predictions, const double* latent) const {
  if (!shot.prepared) return Predict(Prepared(shot), theta, active, base_in_station, markers, predictions, latent);
  const Equilibrium equilibrium = Equilibrate(shot, theta, base_in_station.rotation, latent);
  if (!equilibrium.converged) return false;
  std::vector<int> column_of(num_parameters(), -1);
  for (size_t i = 0; i < active.size(); ++i) column_of[active[i]] = static_cast<int>(i);
  const double grown = ScaleOf(shot.terms, theta);
  const Matrix3<double>& rotation = base_in_station.rotation;
  predictions->resize(markers.size());
  for (size_t m = 0; m < markers.size(); ++m) {
    const MarkerInFrame& marker = markers[m];
    const double scale = Grows(marker) ? grown : 1.0;
    PointPrediction& prediction = (*predictions)[m];
    if (marker.kind == ReadingKind::kRotation) {
      prediction.d_theta.setZero(3, active.size());
      prediction.d_latent.setZero(3, latent != nullptr ? chain().num_joints() : 0);
      PredictTurn(shot, theta, column_of, equilibrium, base_in_station.rotation, marker, &prediction);
      continue;
    }
    const Pose<double>& base_from_frame = equilibrium.state.frames[marker.frame];
    const Vector3<double> in_base = base_from_frame * OwnPoint(shot.terms, theta, marker);
    const Vector3<double> arm = scale * (rotation * in_base);
    const Vector3<double> truth = arm + base_in_station.translation;
    const Matrix3<double> station_from_frame = rotation * base_from_frame.rotation;
    const SeenPoint seen(shot.terms, theta, marker, truth, station_from_frame);
    const Matrix3<double> from_base = scale * seen.from_true * rotation;
    prediction.point = seen.point;
    prediction.d_translation = seen.from_true;
    prediction.d_rotation = -seen.from_true * Skew(arm);
    prediction.d_marker = from_base * base_from_frame.rotation;
    prediction.d_theta.setZero(3, active.size());
    prediction.d_latent.setZero(3, latent != nullptr ? chain().num_joints() : 0);
    // What moves the point in the base, and what turns the marker's axis there.
    const auto add_motion = [&](const MarkerVelocities& velocities, const Matrix3<double>& seen_from_base) {
      const auto add = [&](int parameter, const Vector3<double>& velocity_in_base) {
        prediction.d_theta.col(column_of[parameter]) += seen_from_base * velocity_in_base;
      };
      AddDisplacements(shot, column_of, velocities, add);
      AddLoads(shot, equilibrium, column_of, rotation, velocities, add);
      prediction.d_rotation += seen_from_base * velocities.ByRotation();
      for (int j = 0; j < prediction.d_latent.cols(); ++j) {
        const int e = chain().JointTransform(j);
        prediction.d_latent.col(j) += seen_from_base * chain().transforms[e].sign * velocities.BySlot(e);
      }
    };
    add_motion(MarkerVelocities(chain(), elastic_slots_, equilibrium, in_base, marker.frame), from_base);
    if (seen.turns()) {
      prediction.d_rotation += seen.by_turn;
      add_motion(
          MarkerVelocities(chain(), elastic_slots_, equilibrium, in_base, marker.frame, MarkerVelocities::Of::kTurn),
          seen.by_turn * rotation);
    }
    const auto add_seen = [&](int parameter, const Vector3<double>& displacement) {
      if (column_of[parameter] >= 0) prediction.d_theta.col(column_of[parameter]) += displacement;
    };
    for (const MarkerTerm& term : shot.terms.markers) {
      if (term.marker == marker.id) add_seen(term.parameter, from_base * (base_from_frame.rotation * term.direction));
    }
    for (const BaseTerm& term : shot.terms.base) {
      if (Grows(marker)) add_seen(term.parameter, term.factor / scale * (from_base * in_base));
    }
    for (const StationTerm& term : shot.terms.station) add_seen(term.parameter, term.gradient * truth + term.offset);
    for (const SightTerm& term : shot.terms.sights) {
      if (!IsOf(term, marker)) continue;
      const Vector3<double> axis = station_from_frame * term.axis;
      add_seen(term.parameter, SightDisplacement(term, truth, axis));
    }
  }
  return true;
}

// R_seen = exp(phi) R_b R_f R_target, phi the turn of the measurement frame. What turns the frame f by omega (in the
// base) turns the target by exp(phi) R_b omega; where a target sits, and how the arm grows, does not turn it.
void ForwardModel::PredictTurn(const ShotInput& shot, const double* theta, const std::vector<int>& column_of,
                               const Equilibrium& equilibrium, const Matrix3<double>& base_rotation,
                               const MarkerInFrame& marker, PointPrediction* prediction) const {
  const Matrix3<double>& base_from_frame = equilibrium.state.frames[marker.frame].rotation;
  const MarkerVelocities velocities(chain(), elastic_slots_, equilibrium, Vector3<double>::Zero(), marker.frame,
                                    MarkerVelocities::Of::kTurn);
  const Vector3<double> turn = TurnOfStation(shot.terms, theta);
  const Matrix3<double> seen = RotationFromVector(turn);
  const Matrix3<double> from_base = seen * base_rotation;
  prediction->point = RotationVector(Matrix3<double>(from_base * base_from_frame * marker.rotation));
  prediction->d_translation.setZero();
  prediction->d_rotation = seen + from_base * velocities.ByRotation();
  prediction->d_marker = from_base * base_from_frame;
  const auto add = [&](int parameter, const Vector3<double>& velocity_in_base) {
    prediction->d_theta.col(column_of[parameter]) += from_base * velocity_in_base;
  };
  AddDisplacements(shot, column_of, velocities, add);
  AddLoads(shot, equilibrium, column_of, base_rotation, velocities, add);
  for (const StationTerm& term : shot.terms.station) {
    if (column_of[term.parameter] < 0) continue;
    prediction->d_theta.col(column_of[term.parameter]) += LeftJacobian(turn) * TurnOf(term);
  }
  for (int j = 0; j < prediction->d_latent.cols(); ++j) {
    const int e = chain().JointTransform(j);
    prediction->d_latent.col(j) = from_base * chain().transforms[e].sign * velocities.BySlot(e);
  }
}

// Columns of everything that moves a transform value by data alone.
template <typename Add>
void ForwardModel::AddDisplacements(const ShotInput& shot, const std::vector<int>& column_of,
                                    const MarkerVelocities& velocities, const Add& add) const {
  for (int i = 0; i < num_parameters(); ++i) {
    if (column_of[i] < 0 || parameters_[i].law != ParameterLaw::kGeometry) continue;
    add(i, velocities.BySlot(parameters_[i].index));
  }
  for (const SlotTerm& term : shot.terms.slots) {
    if (column_of[term.parameter] >= 0) add(term.parameter, term.factor * velocities.BySlot(term.transform));
  }
}

// Columns of everything that acts through torques: compliances, loads, springs.
template <typename Add>
void ForwardModel::AddLoads(const ShotInput& shot, const Equilibrium& equilibrium, const std::vector<int>& column_of,
                            const Matrix3<double>& rotation, const MarkerVelocities& velocities, const Add& add) const {
  if (equilibrium.response.size() == 0) return;
  const auto slot_index = [&](int transform) {
    return std::lower_bound(elastic_slots_.begin(), elastic_slots_.end(), transform) - elastic_slots_.begin();
  };
  const Eigen::VectorXd coupled = chain().CoupledJointValues(shot.conditions.q);
  const ElasticQuery query = Query(shot, coupled);
  const auto torques_of = [&](const std::vector<AppliedWrench>& wrenches) {
    return TorquesOf(query, equilibrium.state, wrenches, rotation);
  };
  for (int i = 0; i < num_parameters(); ++i) {
    if (column_of[i] < 0 || parameters_[i].law != ParameterLaw::kCompensator) continue;
    add(i, velocities.ByTorques(equilibrium.torque_by_spring.col(parameters_[i].index)));
  }
  for (const ElasticTerm& term : shot.terms.elastic) {
    if (column_of[term.parameter] < 0) continue;
    const long s = slot_index(term.transform);
    add(term.parameter, term.factor * ElasticPhi(term, equilibrium.torque[s]) * velocities.ByDeflection(s));
  }
  for (const WrenchTerm& term : shot.terms.wrenches) {
    if (column_of[term.parameter] >= 0) add(term.parameter, velocities.ByTorques(torques_of(term.wrenches)));
  }
  for (const SagTerm& term : shot.terms.sags) {
    if (column_of[term.parameter] < 0) continue;
    const double torque = GeneralisedForce(chain(), equilibrium.state, term.transform, term.wrenches, rotation);
    add(term.parameter, torque * velocities.ByDeflection(slot_index(term.transform)));
  }
}

Eigen::VectorXd ForwardModel::ModelledJointTorques(ShotInput shot, const double* theta,
                                                   const Matrix3<double>& base_rotation) const {
  if (!shot.prepared) Prepare(&shot);
  shot.terms.torques.clear();
  const Equilibrium equilibrium = Equilibrate(shot, theta, base_rotation);
  if (!equilibrium.converged) return {};
  const Eigen::VectorXd coupled = chain().CoupledJointValues(shot.conditions.q);
  Eigen::VectorXd torques(chain().num_joints());
  for (int j = 0; j < chain().num_joints(); ++j) {
    const int e = chain().JointTransform(j);
    const auto torque_of = [&](const std::vector<AppliedWrench>& wrenches) {
      return GeneralisedForce(chain(), equilibrium.state, e, wrenches, base_rotation);
    };
    double torque = torque_of(shot.wrenches);
    for (const WrenchTerm& load : shot.terms.wrenches) torque += theta[load.parameter] * torque_of(load.wrenches);
    if (compensator_ && compensator_->transform == e) {
      torque += compensator_->Torque(theta, equilibrium.values[e], coupled[j]);
    }
    torques[j] = chain().transforms[e].sign * torque;  // v = sign q
  }
  return torques;
}

}  // namespace sagitta

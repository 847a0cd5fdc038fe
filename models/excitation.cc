#include "models/excitation.h"

#include <algorithm>
#include <cmath>

namespace sagitta {
namespace {

double LargestForce(const ShotInput& shot) {
  double largest = 0.0;
  for (const AppliedWrench& wrench : shot.wrenches) largest = std::max(largest, wrench.force.norm());
  return largest;
}

// Of one shot at its loaded state.
class ShotMotion {
 public:
  ShotMotion(const ForwardModel& model, const ShotInput& shot, const double* theta, const Pose<double>& base_in_station)
      : model_(model),
        shot_(shot),
        base_in_station_(base_in_station),
        state_(model.Equilibrate(shot, theta, base_in_station.rotation)) {}

  bool valid() const { return state_.converged; }

  void AddSlots(std::vector<double>* motion) const {
    for (int i = 0; i < model_.num_parameters(); ++i) {
      if (model_.parameters()[i].law == ParameterLaw::kGeometry) (*motion)[i] = 1.0;
    }
    for (const SlotTerm& term : shot_.terms.slots) Raise(term.parameter, term.factor, motion);
  }

  void AddTorques(std::vector<double>* motion) const {
    if (state_.response.size() == 0) return;
    const double none = kNoLever * LargestForce(shot_);
    for (const ElasticTerm& term : shot_.terms.elastic) {
      const double torque = state_.torque[SlotIndex(term.transform)];
      if (std::abs(torque) > none) Raise(term.parameter, term.factor * ElasticPhi(term, torque), motion);
    }
    for (const SagTerm& sag : shot_.terms.sags) Raise(sag.parameter, TorqueOf(sag.wrenches, sag.transform), motion);
    for (const WrenchTerm& term : shot_.terms.wrenches) {
      Eigen::VectorXd torques(state_.torque.size());
      for (int s = 0; s < torques.size(); ++s) torques[s] = TorqueOf(term.wrenches, model_.elastic_slots()[s]);
      Raise(term.parameter, Largest(state_.by_torque * torques), motion);
    }
    for (int i = 0; i < model_.num_parameters() && state_.torque_by_spring.cols() > 0; ++i) {
      const ModelParameter& parameter = model_.parameters()[i];
      if (parameter.law != ParameterLaw::kCompensator) continue;
      Raise(i, Largest(state_.by_torque * state_.torque_by_spring.col(parameter.index)), motion);
    }
  }

  void AddPoints(const MarkerInFrame& marker, std::vector<double>* motion) const {
    const Pose<double>& base_from_frame = state_.state.frames[marker.frame];
    const Vector3<double> in_base = base_from_frame * marker.point;
    const Vector3<double> seen = base_in_station_ * in_base;
    const Matrix3<double> station_from_frame = base_in_station_.rotation * base_from_frame.rotation;
    for (const MarkerTerm& term : shot_.terms.markers) {
      if (term.marker == marker.id) Raise(term.parameter, term.direction.norm(), motion);
    }
    for (const BaseTerm& term : shot_.terms.base) {
      if (model_.Grows(marker)) Raise(term.parameter, term.factor * in_base.norm(), motion);
    }
    for (const StationTerm& term : shot_.terms.station) {
      Raise(term.parameter, (term.gradient * seen + term.offset).norm(), motion);
    }
    for (const SightTerm& term : shot_.terms.sights) {
      if (term.marker >= 0 && term.marker != marker.id) continue;
      const Vector3<double> axis = station_from_frame * term.axis;
      Raise(term.parameter, SightDisplacement(term, seen, axis).norm(), motion);
    }
  }

 private:
  static void Raise(int parameter, double value, std::vector<double>* motion) {
    (*motion)[parameter] = std::max((*motion)[parameter], std::abs(value));
  }
  static double Largest(const Eigen::VectorXd& values) { return values.cwiseAbs().maxCoeff(); }
  long SlotIndex(int transform) const {
    const std::vector<int>& slots = model_.elastic_slots();
    return std::lower_bound(slots.begin(), slots.end(), transform) - slots.begin();
  }
  double TorqueOf(const std::vector<AppliedWrench>& wrenches, int transform) const {
    return GeneralisedForce(model_.chain(), state_.state, transform, wrenches, base_in_station_.rotation);
  }

  const ForwardModel& model_;
  const ShotInput& shot_;
  const Pose<double>& base_in_station_;
  const Equilibrium state_;
};

}  // namespace

std::vector<double> MotionPerUnit(const ForwardModel& model, const ShotInput& shot, const double* theta,
                                  const Pose<double>& base_in_station, const std::vector<MarkerInFrame>& markers) {
  std::vector<double> motion(model.num_parameters(), 0.0);
  const ShotMotion here(model, shot, theta, base_in_station);
  if (!here.valid()) return motion;
  here.AddSlots(&motion);
  here.AddTorques(&motion);
  for (const MarkerInFrame& marker : markers) here.AddPoints(marker, &motion);
  return motion;
}

}  // namespace sagitta

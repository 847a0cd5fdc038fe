#include "models/forward_model.h"

#include <utility>

namespace sagitta {

ForwardModel::ForwardModel(Chain chain) : chain_(std::move(chain)) {
  for (int e = 0; e < chain_.num_transforms(); ++e) {
    const ElementaryTransform& transform = chain_.transforms[e];
    if (transform.error.empty()) continue;
    const ParameterKind kind = transform.is_rotation() ? ParameterKind::kAngle : ParameterKind::kLength;
    parameters_.push_back({"geometry/" + transform.error, kind, e});
  }
}

void ForwardModel::Predict(const Eigen::VectorXd& q, const double* theta, const std::vector<int>& active,
                           const Pose<double>& base_in_station, const std::vector<MarkerInFrame>& markers,
                           std::vector<PointPrediction>* predictions) const {
  ChainState<double> state;
  EvaluateChain(chain_, TransformValues(q, theta).data(), &state);
  predictions->resize(markers.size());
  for (size_t m = 0; m < markers.size(); ++m) {
    const MarkerInFrame& marker = markers[m];
    PointPrediction& prediction = (*predictions)[m];
    const Pose<double>& base_from_frame = state.frames[marker.frame];
    const Vector3<double> point_in_base = base_from_frame * marker.point;
    const Vector3<double> arm = base_in_station.rotation * point_in_base;
    prediction.point = arm + base_in_station.translation;
    prediction.d_rotation = -Skew(arm);
    prediction.d_marker = base_in_station.rotation * base_from_frame.rotation;
    prediction.d_theta.resize(3, active.size());
    for (size_t i = 0; i < active.size(); ++i) {
      const int e = parameters_[active[i]].transform;
      if (e < marker.frame) {
        prediction.d_theta.col(i) = base_in_station.rotation * PointVelocity(chain_, state, e, point_in_base);
      } else {
        prediction.d_theta.col(i).setZero();
      }
    }
  }
}

}  // namespace sagitta

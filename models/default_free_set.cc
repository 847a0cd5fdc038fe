#include "models/default_free_set.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "models/constants.h"
#include "models/forward_model.h"

namespace sagitta {
namespace {

constexpr double kParallelTolerance = 3.0 * kDegree;
constexpr double kIndependence = 1e-7;  // sine of the angle between a column and the kept span
constexpr int kConfigurationsPerUnknown = 2;
constexpr int kNuisance = 6 + 9;  // base and three markers

Chain SnapToRightAngles(const Chain& chain) {
  Chain snapped = chain;
  for (ElementaryTransform& transform : snapped.transforms) {
    if (!transform.is_rotation() || transform.has_joint()) continue;
    const double nearest = std::round(transform.nominal / (0.5 * kPi)) * 0.5 * kPi;
    if (std::abs(transform.nominal - nearest) < kParallelTolerance) transform.nominal = nearest;
  }
  return snapped;
}

bool IsBeta(const std::string& error) {
  const size_t dot = error.rfind('.');
  return dot != std::string::npos && error.substr(dot) == ".beta";
}

// The turn at which an error may join: offsets of joints, other errors, betas.
int TurnOfChoice(const ElementaryTransform& transform) {
  return transform.has_joint() ? 0 : IsBeta(transform.error) ? 2 : 1;
}

// Gram-Schmidt, twice for accuracy; keeps a column only if it is independent.
class IndependentColumns {
 public:
  explicit IndependentColumns(int rows) : basis_(rows, 0) {}

  bool Add(const Eigen::VectorXd& column) {
    const double norm = column.norm();
    if (norm < 1e-9) return false;
    Eigen::VectorXd rest = column / norm;
    for (int pass = 0; pass < 2; ++pass) rest -= basis_ * (basis_.transpose() * rest);
    if (rest.norm() < kIndependence) return false;
    basis_.conservativeResize(Eigen::NoChange, basis_.cols() + 1);
    basis_.rightCols(1) = rest.normalized();
    return true;
  }

 private:
  Eigen::MatrixXd basis_;
};

// Columns: base (6), three marker points (9), then one per error; generic joint
// values. Three points: where they are known they show the flange's whole pose.
Eigen::MatrixXd GenericJacobian(const Chain& chain) {
  const ForwardModel model(chain);
  const int p = model.num_parameters();
  const int configurations = kConfigurationsPerUnknown * (p + kNuisance);
  std::vector<int> active(p);
  for (int i = 0; i < p; ++i) active[i] = i;
  const std::vector<double> theta(p, 0.0);
  const int flange = chain.FlangeFrame();
  const std::vector<MarkerInFrame> markers = {
      {flange, {0.31, -0.17, 0.23}}, {flange, {-0.22, 0.37, 0.11}}, {flange, {0.13, 0.29, -0.41}}};
  std::mt19937_64 random(20130828);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(9 * configurations, kNuisance + p);
  for (int c = 0; c < configurations; ++c) {
    Eigen::VectorXd q(chain.num_joints());
    for (int j = 0; j < q.size(); ++j)
      q[j] = uniform(random) * (chain.joints[j].type == JointType::kRevolute ? kPi : 1.0);
    std::vector<PointPrediction> predictions;
    model.Predict(q, theta.data(), active, Pose<double>(), markers, &predictions);
    for (int m = 0; m < 3; ++m) {
      auto rows = jacobian.middleRows(9 * c + 3 * m, 3);
      rows.leftCols<3>().setIdentity();
      rows.middleCols<3>(3) = predictions[m].d_rotation;
      rows.middleCols<3>(6 + 3 * m) = predictions[m].d_marker;
      rows.rightCols(p) = predictions[m].d_theta;
    }
  }
  return jacobian;
}

}  // namespace

FreeSet DefaultFreeSet(const Chain& chain, const FreeSetContext& context) {
  const Chain snapped = SnapToRightAngles(chain);
  const Eigen::MatrixXd jacobian = GenericJacobian(snapped);
  IndependentColumns kept(jacobian.rows());
  for (int i = 0; i < kNuisance; ++i) {
    if (i < 6 ? context.base_free : context.markers_free) kept.Add(jacobian.col(i));
  }
  const ForwardModel model(snapped);
  std::vector<bool> is_free(model.num_parameters(), false);
  for (const int turn : {0, 1, 2}) {
    for (int i = 0; i < model.num_parameters(); ++i) {
      if (TurnOfChoice(snapped.transforms[model.parameters()[i].index]) != turn) continue;
      is_free[i] = kept.Add(jacobian.col(kNuisance + i));
    }
  }
  FreeSet result;
  for (int i = 0; i < model.num_parameters(); ++i) {
    const std::string& error = snapped.transforms[model.parameters()[i].index].error;
    (is_free[i] ? result.free : result.redundant).push_back(error);
  }
  return result;
}

}  // namespace sagitta

#include "tools/report/workspace.h"

#include <algorithm>
#include <cmath>

#include "models/constants.h"

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kNear = 1.2;  // times the size: how far from the middle a box is drawn

Json PointToJson(const Vector3<double>& point) {
  return {Rounded(point.x(), 5), Rounded(point.y(), 5), Rounded(point.z(), 5)};
}

// Where the joints are, without those that coincide.
std::vector<Vector3<double>> ArmOf(const ForwardModel& model, const std::vector<double>& theta,
                                   const Eigen::VectorXd& q) {
  const std::vector<double> values = model.TransformValues(ShotInput(q), theta.data());
  ChainState<double> state;
  EvaluateChain(model.chain(), values.data(), &state);
  std::vector<Vector3<double>> arm;
  for (const Pose<double>& frame : state.frames) {
    const Vector3<double> point = kMillimetresPerMetre * frame.translation;
    if (arm.empty() || (point - arm.back()).norm() > 0.5) arm.push_back(point);
  }
  return arm;
}

}  // namespace

Workspace::Workspace(const ForwardModel& model, const std::vector<double>& theta,
                     const std::vector<Configuration>& configurations)
    : arms_({{"names", Json::array()}, {"poses", Json::array()}, {"polylines", Json::array()}}) {
  const size_t stride = (configurations.size() + kMostArms - 1) / kMostArms;
  std::vector<std::vector<Vector3<double>>> arms;
  for (size_t c = 0; c < configurations.size(); c += stride) {
    arms.push_back(ArmOf(model, theta, configurations[c].q));
    for (const Vector3<double>& point : arms.back()) Include(point);
  }
  for (size_t c = 0; c < configurations.size(); c += stride) {
    Json polyline = Json::array();
    for (const Vector3<double>& point : arms[c / stride]) {
      for (const double coordinate : point) polyline.push_back(Drawn(coordinate));
    }
    arms_["names"].push_back(configurations[c].id);
    arms_["poses"].push_back(c);
    arms_["polylines"].push_back(std::move(polyline));
  }
}

void Workspace::Include(const Vector3<double>& point_in_base) {
  low_ = low_.cwiseMin(point_in_base);
  high_ = high_.cwiseMax(point_in_base);
}

double Workspace::size() const { return std::max(1.0, (high_ - low_).maxCoeff()); }

// A thousandth of the picture and finer, in powers of ten, 1 mm at most.
Json Workspace::Drawn(double coordinate) const {
  const double grid = std::pow(10.0, std::min(0.0, std::floor(std::log10(size())) - 3.0));
  return grid < 1.0 ? Rounded(std::round(coordinate / grid) * grid, 8) : Json(std::lround(coordinate));
}

void Workspace::Draw(const Cell* cell, Picture* picture) const {
  const Vector3<double> middle = 0.5 * (low_ + high_);
  Json boxes = Json::array();
  for (const CellBox& box : cell != nullptr ? cell->keep_out : std::vector<CellBox>()) {
    // As much of it as is near, in its own frame.
    const Matrix3<double>& rotation = box.base_from_box.rotation;
    const Vector3<double> here =
        rotation.transpose() * Vector3<double>(middle - kMillimetresPerMetre * box.base_from_box.translation);
    const Vector3<double> half = kMillimetresPerMetre * box.half_size,
                          reach = Vector3<double>::Constant(kNear * size());
    const Vector3<double> low = (-half).cwiseMax(here - reach), high = half.cwiseMin(here + reach);
    if ((high - low).minCoeff() <= 0.0) continue;
    const Eigen::Quaterniond turn(rotation);
    boxes.push_back({{"name", box.name},
                     {"at", PointToJson(kMillimetresPerMetre * box.base_from_box.translation +
                                        rotation * Vector3<double>(0.5 * (low + high)))},
                     {"turn", {turn.x(), turn.y(), turn.z(), turn.w()}},
                     {"size", PointToJson(high - low)}});
  }
  picture->kind = "workspace";
  picture->data["arms"] = arms_;
  picture->data["boxes"] = boxes;
  picture->data["reach"] = {{"middle", PointToJson(middle)}, {"size", Rounded(size())}};
  if (!picture->data.contains("rows")) picture->data["rows"] = {{"x", Json::array()}};
}

}  // namespace sagitta

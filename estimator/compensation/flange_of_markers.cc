#include "estimator/compensation/flange_of_markers.h"

#include <Eigen/QR>
#include <algorithm>

#include "problems/parameter_set.h"

namespace sagitta {
namespace {

struct OnFlange {
  std::string name;
  Vector3<double> point;
  bool turns = false;  // its rotation is read
};

std::vector<OnFlange> MarkersOnFlange(const std::map<std::string, MarkerSpec>& markers) {
  std::vector<OnFlange> found;
  for (const auto& [name, marker] : markers) {
    if (!marker.point || marker.on.kind != MarkerPlace::Kind::kFlange) continue;
    found.push_back({name, *marker.point, marker.rotvec.has_value()});
  }
  return found;
}

Vector3<double> CentreOf(const std::vector<OnFlange>& markers) {
  Vector3<double> centre = Vector3<double>::Zero();
  for (const OnFlange& marker : markers) centre += marker.point / static_cast<double>(markers.size());
  return centre;
}

Matrix3<double> InertiaOf(const std::vector<OnFlange>& markers, const Vector3<double>& centre) {
  Matrix3<double> inertia = Matrix3<double>::Zero();
  for (const OnFlange& marker : markers) {
    const Vector3<double> arm = marker.point - centre;
    inertia += arm.squaredNorm() * Matrix3<double>::Identity() - arm * arm.transpose();
  }
  return inertia;
}

}  // namespace

FlangeOfMarkers FlangeFromMarkers(const std::map<std::string, MarkerSpec>& markers,
                                  const std::vector<std::string>& names) {
  FlangeOfMarkers flange;
  flange.by_names.setZero(6, static_cast<Eigen::Index>(names.size()));
  const std::vector<OnFlange> on_flange = MarkersOnFlange(markers);
  if (on_flange.empty()) return flange;
  flange.centre = CentreOf(on_flange);
  const auto turning = static_cast<double>(
      std::count_if(on_flange.begin(), on_flange.end(), [](const OnFlange& marker) { return marker.turns; }));
  Eigen::CompleteOrthogonalDecomposition<Matrix3<double>> inertia;
  inertia.setThreshold(1e-9);  // of the largest arm's square: a micrometre's arm of a tool of some centimetres
  inertia.compute(InertiaOf(on_flange, flange.centre));
  const auto add = [&](const std::string& name, const Vector3<double>& shift, const Vector3<double>& turn) {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) return;
    flange.by_names.col(found - names.begin()) << shift - turn.cross(flange.centre), turn;
  };
  for (const OnFlange& marker : on_flange) {
    const std::array<std::string, 6> own = MarkerNames(marker.name);
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3<double> unit = Vector3<double>::Unit(axis);
      const Vector3<double> turn = inertia.solve((marker.point - flange.centre).cross(unit));
      add(own[axis], unit / static_cast<double>(on_flange.size()),
          turning > 0.0 ? Vector3<double>::Zero().eval() : turn);
      if (marker.turns) add(own[3 + axis], Vector3<double>::Zero(), unit / turning);
    }
  }
  return flange;
}

}  // namespace sagitta

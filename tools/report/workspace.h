// The arm in 3-D, mm, in the robot's base frame, unloaded: what the picture "workspace" is made of.
#pragma once

#include <vector>

#include "models/forward_model.h"
#include "problems/cell.h"
#include "problems/measurements.h"
#include "tools/report/picture.h"

namespace sagitta {

// The polyline of the joints, base to flange, of configurations by index; of more than kMostArms every so many.
constexpr size_t kMostArms = 2000;

class Workspace {
 public:
  Workspace(const ForwardModel& model, const std::vector<double>& theta,
            const std::vector<Configuration>& configurations);
  void Include(const Vector3<double>& point_in_base);
  // Fills data: arms, reach, boxes (of `cell`, which may be null, as far as they are near), and no rows.
  void Draw(const Cell* cell, Picture* picture) const;
  double size() const;  // mm, of all that is shown
  // A coordinate in mm with as many digits as the picture can show.
  nlohmann::ordered_json Drawn(double coordinate) const;

 private:
  nlohmann::ordered_json arms_;
  Vector3<double> low_ = Vector3<double>::Zero(), high_ = Vector3<double>::Zero();  // the base is always in sight
};

}  // namespace sagitta

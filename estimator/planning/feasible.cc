#include "estimator/planning/feasible.h"

#include <algorithm>
#include <cmath>

#include "estimator/report/planning_words.h"
#include "models/kinematics.h"
#include "problems/input_error.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr double kRounding = 1e-9;  // rad or m: a limit written in degrees

template <typename T>
std::vector<const T*> StatedByName(const std::vector<std::pair<std::string, T>>& stated,
                                   const std::vector<std::string>& names, const std::string& file, const char* key,
                                   const char* kind) {
  std::vector<const T*> found(names.size(), nullptr);
  for (const auto& [name, value] : stated) {
    const auto place = std::find(names.begin(), names.end(), name);
    if (place == names.end()) {
      throw InputError({file, 0, std::string(key) + "." + name},
                       std::string("no row has the ") + kind + " '" + name + "'", SpellingHint(name, names));
    }
    found[place - names.begin()] = &value;
  }
  return found;
}

bool IsInside(const DirectionCone& cone, const Vector3<double>& axis, const Vector3<double>& direction) {
  return axis.dot(direction) >= std::cos(cone.half_angle) - kRounding;
}

}  // namespace

std::vector<Sight> SightsOf(const Measurements& data, const std::vector<int>& shots) {
  std::vector<Sight> sights;
  for (const int s : shots) {
    const Shot& shot = data.shots[s];
    for (const int k : shot.observations) {
      const Sight sight{shot.station, data.observations[k].marker};
      const auto same = [&](const Sight& other) {
        return other.station == sight.station && other.marker == sight.marker;
      };
      if (std::none_of(sights.begin(), sights.end(), same)) sights.push_back(sight);
    }
  }
  return sights;
}

FeasiblePoses::FeasiblePoses(const CalibrationProblem& placed, const Cell* cell) : placed_(placed), cell_(cell) {
  if (cell == nullptr) return;
  range_of_station_ = StatedByName(cell->sights, placed.data().stations, cell->file, "sight", "station");
  cone_of_marker_ = StatedByName(cell->reflectors, placed.data().markers, cell->file, "reflectors", "marker");
  if (!cell->capsules.empty() || !cell->keep_out.empty()) bodies_.emplace(placed.model().chain(), *cell);
}

std::string FeasiblePoses::OutsideJoints(const Eigen::VectorXd& q) const {
  const Chain& chain = placed_.robot().chain;
  for (int j = 0; j < chain.num_joints(); ++j) {
    const Joint& joint = chain.joints[j];
    if (joint.min && q[j] < *joint.min - kRounding) return BelowItsLimit(joint.name);
    if (joint.max && q[j] > *joint.max + kRounding) return AboveItsLimit(joint.name);
    if (cell_ == nullptr) continue;
    const JointRange& range = cell_->joints[j];
    const bool is_outside =
        (range.min && q[j] < *range.min - kRounding) || (range.max && q[j] > *range.max + kRounding);
    if (is_outside) return OutsideItsRange(joint.name);
    const auto here = [&](double level) { return std::abs(level - q[j]) < 1e-6; };
    if (!range.levels.empty() && std::none_of(range.levels.begin(), range.levels.end(), here)) {
      return AtNoneOfItsLevels(joint.name);
    }
  }
  return "";
}

Vector3<double> FeasiblePoses::MarkerInBase(const std::vector<Pose<double>>& frames, int marker) const {
  return frames[placed_.marker_frames()[marker]] * placed_.parameters.MarkerPoint(marker);
}

std::string FeasiblePoses::OutsideBoxes(const std::vector<Pose<double>>& frames,
                                        const std::vector<Sight>& sights) const {
  std::vector<std::pair<std::string, Vector3<double>>> points = {{"the flange", frames.back().translation}};
  for (const Sight& sight : sights) {
    if (placed_.marker_frames()[sight.marker] <= placed_.model().chain().BaseFrame()) continue;  // does not move
    points.emplace_back("marker " + placed_.data().markers[sight.marker], MarkerInBase(frames, sight.marker));
  }
  for (const auto& [name, point] : points) {
    const Vector3<double>& p = point;
    if (cell_->floor && p.z() < *cell_->floor) return name + " is below the floor";
    const auto contains = [&](const CellBox& box) { return box.Contains(p); };
    if (!cell_->stay_in.empty() && std::none_of(cell_->stay_in.begin(), cell_->stay_in.end(), contains)) {
      return LeavesItsBoxes(name);
    }
    const auto box = std::find_if(cell_->keep_out.begin(), cell_->keep_out.end(), contains);
    if (box != cell_->keep_out.end()) return name + " is inside " + box->name;
  }
  return "";
}

std::string FeasiblePoses::Unseen(const std::vector<Pose<double>>& frames, const Sight& sight) const {
  const std::string& station = placed_.data().stations[sight.station];
  const std::string& marker = placed_.data().markers[sight.marker];
  const Pose<double> base = placed_.parameters.BaseInStation(sight.station);
  const Vector3<double> instrument = InstrumentPlace(placed_.experiment(), station);
  const Vector3<double> reflector = MarkerInBase(frames, sight.marker);
  const Vector3<double> line = base * reflector - instrument;  // measurement frame
  const Vector3<double> instrument_in_base = base.rotation.transpose() * (instrument - base.translation);
  if (const SightRange* range = range_of_station_[sight.station]) {
    const double distance = line.norm();
    const double elevation = std::atan2(line.z(), line.head<2>().norm());
    if (distance < range->min_range || distance > range->max_range) {
      return OutOfRange(marker, station);
    }
    if (elevation < range->min_elevation || elevation > range->max_elevation) {
      return OutOfElevations(marker, station);
    }
  }
  if (const DirectionCone* cone = cone_of_marker_[sight.marker]) {
    const Vector3<double> axis = frames[placed_.marker_frames()[sight.marker]].rotation * cone->axis;
    if (!IsInside(*cone, axis, (instrument_in_base - reflector).normalized())) {
      return FacesAway(marker, station);
    }
  }
  if (range_of_station_[sight.station] == nullptr || !bodies_) return "";
  const std::string between = bodies_->Obstruction(frames, instrument_in_base, reflector);
  return between.empty() ? "" : StandsBetween(between, station, marker);
}

std::string FeasiblePoses::WhyNot(const Eigen::VectorXd& q, const std::vector<Sight>& sights) const {
  std::string why = OutsideJoints(q);
  if (cell_ == nullptr || !why.empty()) return why;
  const std::vector<double> theta = placed_.parameters.ModelValues();
  const std::vector<double> values = placed_.model().TransformValues(ShotInput(q), theta.data());
  ChainState<double> state;
  EvaluateChain(placed_.model().chain(), values.data(), &state);
  if (cell_->tool &&
      !IsInside(*cell_->tool, state.frames.back().rotation * cell_->tool->axis, cell_->tool->direction)) {
    return "the tool leaves its cone";
  }
  why = OutsideBoxes(state.frames, sights);
  if (why.empty() && bodies_) why = bodies_->Collision(state.frames);
  for (size_t i = 0; i < sights.size() && why.empty(); ++i) why = Unseen(state.frames, sights[i]);
  return why;
}

std::vector<std::string> FeasiblePoses::Checked() const {
  std::vector<std::string> checked = {"joint limits", "that the arm holds its load"};
  if (cell_ == nullptr) return checked;
  const bool has_bodies = !cell_->capsules.empty();
  const std::string of_what =
      has_bodies ? "of the arm's " + std::to_string(cell_->capsules.size()) + " capsules, " : "of ";
  if (cell_->floor) checked.push_back(FloorIsChecked(of_what));
  if (!cell_->stay_in.empty()) checked.push_back(StayInIsChecked());
  if (!cell_->keep_out.empty()) checked.push_back(KeepOutIsChecked(of_what));
  if (has_bodies) checked.push_back(CapsulesAreChecked());
  if (cell_->tool) checked.push_back("the tool's cone");
  for (const auto& [station, range] : cell_->sights) {
    checked.push_back(SightIsChecked(station));
  }
  for (const auto& [marker, cone] : cell_->reflectors) checked.push_back("the acceptance of reflector " + marker);
  return checked;
}

std::vector<std::string> FeasiblePoses::NotChecked() const {
  std::vector<std::string> open;
  const bool has_bodies = cell_ != nullptr && !cell_->capsules.empty();
  if (!has_bodies) open.push_back(BodiesAreNotStated());
  if (cell_ != nullptr) open.insert(open.end(), cell_->without_body.begin(), cell_->without_body.end());
  if (cell_ == nullptr || cell_->keep_out.empty()) open.push_back(BoxesAreNotStated());
  if (cell_ == nullptr || !cell_->floor) open.push_back("the floor");
  std::vector<std::string> stations, markers;
  for (size_t s = 0; s < placed_.data().stations.size(); ++s) {
    if (cell_ == nullptr || range_of_station_[s] == nullptr) stations.push_back(placed_.data().stations[s]);
  }
  for (size_t m = 0; m < placed_.data().markers.size(); ++m) {
    if (cell_ == nullptr || cone_of_marker_[m] == nullptr) markers.push_back(placed_.data().markers[m]);
  }
  if (!stations.empty()) open.push_back(SightsAreOpen(Enumerate(stations, 6)));
  if (!markers.empty()) open.push_back("the acceptance of reflector " + Enumerate(markers, 6));
  open.push_back(WaysAreOpen());
  return open;
}

}  // namespace sagitta

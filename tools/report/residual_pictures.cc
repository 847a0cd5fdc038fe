#include "tools/report/residual_pictures.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include "estimator/explanations/drivers.h"
#include "problems/text.h"
#include "tools/report/workspace.h"

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kMostColours = 12;  // more groups than these nobody distinguishes
constexpr int kSlices = 8;           // of an axis, in the table
constexpr size_t kMostColumns = 64;  // of the points, with room to spare: a map that grows copies them
constexpr size_t kWorstShown = 20;
constexpr double kArrowOfSize = 0.08;  // an arrow of the 95th percentile, of all that is shown

// Everything that may drive an error and differs between shots.
std::vector<Driver> DriversOf(const CalibrationProblem& problem, const ParameterSet& parameters,
                              const std::vector<ResidualRow>& rows) {
  std::vector<Driver> drivers;
  const auto add = [&drivers](Driver driver) {
    if (driver.Varies()) drivers.push_back(std::move(driver));
  };
  const int joints = problem.robot().chain.num_joints();
  for (int j = 0; j < joints; ++j) add(AngleOf(problem, j));
  std::vector<int> shots;
  for (const ResidualRow& row : rows) shots.push_back(problem.data().observations[row.observation].shot);
  const Eigen::MatrixXd torques = JointTorques(problem, parameters, &shots);
  for (int j = 0; j < joints; ++j) add(TorqueOf(problem, j, torques));
  for (int j = 0; j < joints; ++j) add(ApproachOf(problem, j));
  add(TimeOf(problem));
  add(TemperatureOf(problem));
  add(ConfigurationNumberOf(problem));
  return drivers;
}

std::string Labelled(const Driver& driver) {
  return driver.unit.empty() ? driver.name : driver.name + ", " + driver.unit;
}

// The distances over equal slices of each driver.
void AddSlices(const Driver& driver, const std::vector<double>& x, const std::vector<double>& distances,
               std::vector<std::vector<std::string>>* table) {
  if (x.empty()) return;
  const auto ends = std::minmax_element(x.begin(), x.end());
  const double low = *ends.first, width = (*ends.second - low) / kSlices;
  struct Slice {
    int points = 0;
    double squares = 0.0, most = 0.0;
  };
  std::vector<Slice> slices(kSlices);
  for (size_t i = 0; i < x.size(); ++i) {
    const double position = width > 0.0 ? (x[i] - low) / width : 0.0;
    Slice& slice = slices[static_cast<int>(std::clamp(position, 0.0, kSlices - 1.0))];
    ++slice.points;
    slice.squares += distances[i] * distances[i];
    slice.most = std::max(slice.most, distances[i]);
  }
  for (int s = 0; s < kSlices; ++s) {
    if (slices[s].points == 0) continue;
    table->push_back({Labelled(driver), Significant(low + s * width, 3), Significant(low + (s + 1) * width, 3),
                      std::to_string(slices[s].points), Significant(std::sqrt(slices[s].squares / slices[s].points), 3),
                      Significant(slices[s].most, 3)});
  }
}

// Names of groups that rows fall into; a menu entry where there are some, and not too many.
void AddGroups(const std::string& name, const CalibrationProblem& problem, const std::vector<ResidualRow>& rows,
               const std::function<std::string(const Observation&)>& group_of, Picture* picture, PictureMenu* menu) {
  std::vector<std::string> own;
  own.reserve(rows.size());
  std::set<std::string> groups;
  for (const ResidualRow& row : rows) {
    own.push_back(group_of(problem.data().observations[row.observation]));
    if (own.size() == 1 || own.back() != own[own.size() - 2]) groups.insert(own.back());
  }
  if (groups.size() < 2 || groups.size() > kMostColours) return;
  Json column = Json::array();
  for (std::string& group : own) column.push_back(std::move(group));
  picture->data["rows"][name] = std::move(column);
  menu->options.emplace_back(name, name);
}

void AddColours(const CalibrationProblem& problem, const std::vector<ResidualRow>& rows, Picture* picture) {
  const Measurements& data = problem.data();
  PictureMenu menu{"colour", "colour", {}};
  const auto add = [&](const std::string& name, const std::function<std::string(const Observation&)>& group_of) {
    AddGroups(name, problem, rows, group_of, picture, &menu);
  };
  add("set", [&](const Observation& row) { return data.IsValidation(row) ? "held out" : "fitted"; });
  add("marker", [&](const Observation& row) { return data.markers[row.marker]; });
  add("station", [&](const Observation& row) { return data.stations[data.shots[row.shot].station]; });
  add("load", [&](const Observation& row) { return data.shots[row.shot].load; });
  if (menu.options.empty()) menu.options.emplace_back("none", "none");
  picture->menus.push_back(menu);
}

}  // namespace

Picture ResidualsOverDrivers(const DrawnReadings& readings) {
  const CalibrationProblem& problem = readings.problem;
  const std::vector<ResidualRow>& rows = readings.rows;
  Picture picture;
  picture.kind = "scatter";
  picture.title =
      "What is left of each point, over what may drive it; the line is the mean" + LeftOutInWords(problem, rows.size());
  picture.header = {"over, and its unit", "from", "to", "points", "RMS distance, mm", "largest, mm"};
  Json& data = picture.data["rows"];
  Json names = Json::array(), poses = Json::array();
  std::vector<double> distances, xyz[3];
  for (const ResidualRow& row : rows) {
    const Observation& observation = problem.data().observations[row.observation];
    names.push_back(NameOfRow(problem.data(), observation));
    poses.push_back(problem.data().shots[observation.shot].configuration);
    distances.push_back(row.distance());
    for (int axis = 0; axis < 3; ++axis) xyz[axis].push_back(row.residual_in_base[axis]);
  }
  data = {{"id", std::move(names)}, {"pose", std::move(poses)}};
  data.get_ref<Json::object_t&>().reserve(kMostColumns);
  PictureMenu down{"y", "what", {}}, across{"x", "over", {}};
  const auto add = [&](const std::string& name, const std::vector<double>& values, const std::string& label,
                       PictureMenu* menu) {
    data[name] = RoundedColumn(values);
    picture.settings["labels"][name] = label;
    menu->options.emplace_back(name, label);
  };
  add("distance", distances, "distance, mm", &down);
  for (int axis = 0; axis < 3; ++axis) {
    const std::string name(1, "xyz"[axis]);
    add("residual " + name, xyz[axis], "residual in " + name + " of the base, mm", &down);
  }
  for (const Driver& driver : DriversOf(problem, readings.parameters, rows)) {
    std::vector<double> x;
    for (const ResidualRow& row : rows) x.push_back(driver.of_shot[problem.data().observations[row.observation].shot]);
    add("over " + driver.name, x, Labelled(driver), &across);
    AddSlices(driver, x, distances, &picture.rows);
  }
  picture.menus = {across, down};
  AddColours(problem, rows, &picture);
  return picture;
}

Picture ResidualsInWorkspace(const DrawnReadings& readings) {
  const CalibrationProblem& problem = readings.problem;
  std::vector<ResidualRow> rows = readings.rows;
  Picture picture;
  Workspace workspace(problem.model(), readings.parameters.ModelValues(), problem.data().configurations);
  Json x[3], d[3], poses = Json::array(), held_out = Json::array();
  bool any_held_out = false;
  for (const ResidualRow& row : rows) {
    const Observation& observation = problem.data().observations[row.observation];
    workspace.Include(row.predicted_in_base);
    for (int axis = 0; axis < 3; ++axis) {
      x[axis].push_back(workspace.Drawn(row.predicted_in_base[axis]));
      d[axis].push_back(Rounded(row.residual_in_base[axis], 3));
    }
    poses.push_back(problem.data().shots[observation.shot].configuration);
    held_out.push_back(problem.data().IsValidation(observation) ? 1 : 0);
    any_held_out |= problem.data().IsValidation(observation);
  }
  picture.title = std::string("What is left of each point as an arrow from where the model sees it") +
                  (any_held_out ? "; held-out points in the second colour" : "") +
                  ". Drag to turn, click an arrow to see the arm in its pose" + LeftOutInWords(problem, rows.size());
  Json& data = picture.data["rows"];
  for (int axis = 0; axis < 3; ++axis) data[std::string(1, "xyz"[axis])] = std::move(x[axis]);
  for (int axis = 0; axis < 3; ++axis) data[std::string("d") + "xyz"[axis]] = std::move(d[axis]);
  data["pose"] = std::move(poses);
  data["heldOut"] = std::move(held_out);
  workspace.Draw(nullptr, &picture);
  std::stable_sort(rows.begin(), rows.end(),
                   [](const ResidualRow& a, const ResidualRow& b) { return a.distance() > b.distance(); });
  const double usual = rows.empty() ? 0.0 : rows[rows.size() / 20].distance();
  picture.settings = {{"arrows", usual > 0.0 ? Rounded(kArrowOfSize * workspace.size() / usual, 2) : Json(1)}};
  picture.header = {"the largest", "x, mm", "y, mm", "z, mm", "Δx, mm", "Δy, mm", "Δz, mm", "distance, mm"};
  for (size_t i = 0; i < std::min(kWorstShown, rows.size()); ++i) {
    const ResidualRow& row = rows[i];
    std::vector<std::string> cells = {NameOfRow(problem.data(), problem.data().observations[row.observation])};
    for (int axis = 0; axis < 3; ++axis) cells.push_back(Fixed(row.predicted_in_base[axis], 1));
    for (int axis = 0; axis < 3; ++axis) cells.push_back(Fixed(row.residual_in_base[axis], 4));
    cells.push_back(Fixed(row.distance(), 4));
    picture.rows.push_back(cells);
  }
  return picture;
}

}  // namespace sagitta

#include <algorithm>
#include <cmath>
#include <set>

#include "estimator/explanations/driver_functions.h"
#include "estimator/explanations/unnamed_list.h"
#include "estimator/report/explanations_words.h"
#include "models/constants.h"
#include "models/effects/pose_functions.h"
#include "problems/text.h"

namespace sagitta {
namespace {

// Waves in time, in halves over the campaign, and how many of them are weighed.
constexpr int kMostWaves = 200;
constexpr size_t kWaves = 6;
constexpr int kMarkerRamps = 16;  // in time, along three axes: jumps are marker_shift
constexpr int kSeats = 25;        // stretches of visits in which a loose part stays in its seat

constexpr int kPlateAxes = 6;
constexpr double kStill = 1e-3;  // of gravity's component along an axis: 1 mrad of turn
// Of the seats of a loose part: directions 10 degrees apart, and gaps between shots.
constexpr int kDirections = 200;
constexpr int kMostGaps = 50;
constexpr int kFewestOfASide = 3;  // shots: of fewer it is a few bad rows
constexpr size_t kSides = 6;

// A jump of gravity's component along a direction of the flange.
struct Side {
  Vector3<double> along;
  Gap gap;
};

std::string NumberInMillimetres(double value) { return Significant(1e3 * value, kDigits); }

class PlaceFunctions : public UnnamedList {
 public:
  PlaceFunctions(const CalibrationProblem& problem, const ParameterSet& parameters, EvidenceColumns* columns)
      : UnnamedList(problem, columns),
        parameters_(parameters),
        down_in_base_(DownInBase(problem, parameters)),
        along_(columns->SumAlong(LooseParts())) {
    for (const ShotInput& shot : problem.shot_inputs()) {
      down_.push_back(DownInFlange(problem.robot().chain, shot.conditions.q, down_in_base_));
    }
    SetOfDown();
  }

  void Add() {
    AddStations();
    AddLinks();
    AddMarkers();
    AddPlate();
    AddLoads();
    AddPull();
  }

 private:
  EffectSpec OfStation(const Driver& driver, const std::string& station, const std::string& moves) const {
    EffectSpec spec = Over(driver, "learnt_station_motion", station);
    spec.settings["moves"] = moves;
    return spec;
  }

  static std::vector<Source> Axes(Source::Kind kind, int owner) {
    return {{kind, owner, 0}, {kind, owner, 1}, {kind, owner, 2}};
  }

  // A station's points move with time, or with where they are.
  void AddStations() {
    const Driver time = TimeOf(problem_);
    for (size_t s = 0; s < problem_.data().stations.size(); ++s) {
      const std::string& station = problem_.data().stations[s];
      const int owner = static_cast<int>(s);
      GroupedFunctions functions;
      if (Smooth(time.of_shot, "time", &functions)) {
        EffectSpec turn = OfStation(time, station, "turn");
        const Vector3<double> foot = parameters_.BaseInStation(owner).translation;
        turn.settings["about_x_mm"] = NumberInMillimetres(foot.x());
        turn.settings["about_y_mm"] = NumberInMillimetres(foot.y());
        turn.settings["about_z_mm"] = NumberInMillimetres(foot.z());
        GroupedFunctions of_scale = functions;
        AppendRamps(time.of_shot, "time", kFineBumps, &functions);
        AppendRamps(time.of_shot, "time", kRamps, &of_scale);
        const UnnamedFunction moves{"",
                                    station,
                                    {"time"},
                                    StationMoves(station),
                                    Axes(Source::Kind::kStation, owner),
                                    time,
                                    {OfStation(time, station, "point")}};
        AddFunctions(WavesOf(time.of_shot, moves.sources), moves, "station in time");
        AddFunctions(functions, moves, "station in time");
        AddFunctions(
            functions,
            {"", station, {"time"}, BaseTurnsInStation(station), Axes(Source::Kind::kStationTurn, owner), time, {turn}},
            "station in time");
        AddFunctions(of_scale,
                     {"",
                      station,
                      {"time"},
                      StationGrows(station),
                      {{Source::Kind::kStationScale, owner, 0}},
                      time,
                      {OfStation(time, station, "scale")}},
                     "station in time");
        for (const Source& axis : Axes(Source::Kind::kStation, owner)) {
          const char name = "xyz"[axis.axis];
          AddFunctions(functions,
                       {"",
                        station,
                        {"time"},
                        StationMovesAlong(station, name),
                        {axis},
                        time,
                        {OfStation(time, station, std::string(1, name))}},
                       "station in time");
        }
      }
      AddField(owner);
    }
  }

  // Waves in time: of all periods down to two visits those that the rows say most of, each by itself; half a wave more
  // over the campaign is another one.
  GroupedFunctions WavesOf(const Eigen::VectorXd& time, const std::vector<Source>& axes) const {
    const AlongSources along = columns_->SumAlong(axes);
    const Eigen::VectorXd fitted = OnFitted(time);
    const double span = fitted.maxCoeff() - fitted.minCoeff();
    const int count =
        std::min<int>(kMostWaves, static_cast<int>(std::set<double>(fitted.begin(), fitted.end()).size()));
    Scan<double> periods;
    for (int n = 2; n <= count; ++n) {
      const double period = 2.0 * span / n;
      const Eigen::ArrayXd phase = 2.0 * kPi / period * time.array();
      double reduction = 0.0;
      for (long axis = 0; axis < static_cast<long>(axes.size()); ++axis) {
        reduction += along.Reduction(phase.cos(), axis, true) + along.Reduction(phase.sin(), axis, true);
      }
      periods.Try(reduction, period);
    }
    const std::vector<double> best = periods.Best(kWaves);
    const double listed = static_cast<double>(best.size()) / static_cast<double>(std::max<size_t>(1, periods.size()));
    GroupedFunctions functions;
    for (const double each : best) {
      const std::string period = Significant(each, kDigits);
      functions.Append(Waves(2.0 * kPi / std::stod(period) * time, 1), "time", {{"period_s", period}},
                       "learnt_station_wave", listed);
    }
    return functions;
  }

  // Where the nominal flange is, from the middle of the fitted ones of some shots and in units of their spread; zero of
  // the others.
  struct Field {
    Eigen::MatrixXd places;  // shots x 3
    Settings settings;
  };
  Field FieldOf(const std::vector<bool>& is_in) const {
    Field field{Eigen::MatrixXd::Zero(static_cast<long>(is_in.size()), 3), {}};
    Eigen::RowVector3d middle = Eigen::RowVector3d::Zero();
    double count = 0.0, square = 0.0;
    for (size_t s = 0; s < is_in.size(); ++s) {
      field.places.row(static_cast<long>(s)) =
          FlangePlace(problem_.robot().chain, problem_.shot_inputs()[s].conditions.q).transpose();
    }
    for (const int s : fitted_) {
      if (is_in[static_cast<size_t>(s)]) middle += (field.places.row(s) - middle) / ++count;
    }
    for (const int s : fitted_) {
      if (is_in[static_cast<size_t>(s)]) square += (field.places.row(s) - middle).squaredNorm() / (3.0 * count);
    }
    const double spread = std::max(1e-3, std::sqrt(square));
    for (size_t s = 0; s < is_in.size(); ++s) {
      auto place = field.places.row(static_cast<long>(s));
      place = is_in[s] ? Eigen::RowVector3d((place - middle) / spread) : Eigen::RowVector3d::Zero();
    }
    field.settings = {{"x_mm", NumberInMillimetres(middle.x())},
                      {"y_mm", NumberInMillimetres(middle.y())},
                      {"z_mm", NumberInMillimetres(middle.z())},
                      {"spread_mm", NumberInMillimetres(spread)}};
    return field;
  }

  // Where the readings of a station are is where the flange is: linear and quadratic functions of that.
  void AddField(int station) {
    const Measurements& data = problem_.data();
    const std::string& name = data.stations[static_cast<size_t>(station)];
    std::vector<bool> is_own;
    for (const Shot& shot : data.shots) is_own.push_back(shot.station == station);
    const Field field = FieldOf(is_own);
    Eigen::MatrixXd functions(field.places.rows(), kNumFieldFunctions);
    for (long s = 0; s < functions.rows(); ++s) {
      functions.row(s) = FieldFunctions(field.places.row(s).transpose()).transpose();
    }
    GroupedFunctions distorted;
    distorted.Append(functions, "other", field.settings);
    AddFunctions(distorted,
                 {"",
                  name,
                  {name},
                  StationIsDistorted(name),
                  Axes(Source::Kind::kStation, station),
                  {},
                  {{"learnt_station_field", name, {}, {}}}},
                 "station field");
  }

  // Links grow with time or temperature, each in its own way: one of them, or all.
  void AddLinks() {
    std::vector<Source> links;
    for (int joint = -1; joint < joints(); ++joint) {
      if (!columns_->LengthsOf(joint).empty()) links.push_back({Source::Kind::kLink, joint, 0});
    }
    for (const auto& [driver, name] : {std::pair{TimeOf(problem_), "time"}, {TemperatureOf(problem_), "temperature"}}) {
      const Eigen::VectorXd seen = OnFitted(driver.of_shot);
      if (links.empty() || !(seen.maxCoeff() > seen.minCoeff())) continue;
      GroupedFunctions functions;
      AppendBumps(driver.of_shot, "time", kUnnamedBumps[0], &functions);
      const EffectSpec effect = Over(driver, "learnt_growth", "robot");
      for (const Source& link : links) {
        const std::string where = link.owner < 0 ? "the foot" : "the link after " + JointName(link.owner);
        AddFunctions(functions, {"", where, {name}, where + " grows with " + name, {link}, driver, {effect}},
                     "link in time");
      }
      AddFunctions(functions,
                   {"", "links", {name}, std::string("each link grows with ") + name, links, driver, {effect}},
                   "links in time");
    }
  }

  // A marker moves in its frame with time or with a joint's angle, or sits loose.
  void AddMarkers() {
    for (size_t m = 0; m < problem_.data().markers.size(); ++m) {
      const std::string& marker = problem_.data().markers[m];
      const std::vector<Source> sources = Axes(Source::Kind::kMarker, static_cast<int>(m));
      std::vector<Driver> drivers = {TimeOf(problem_)};
      for (int j = 0; j < joints(); ++j) drivers.push_back(AngleOf(problem_, j));
      for (const Driver& driver : drivers) {
        GroupedFunctions functions;
        const Eigen::VectorXd fitted = OnFitted(driver.of_shot);
        const double low = fitted.minCoeff(), high = fitted.maxCoeff();
        if (!(high - low > 1e-9 * (1.0 + std::abs(high)))) continue;
        const bool is_time = driver.kind == DriverKind::kTime;
        if (is_time) {
          AppendRamps(driver.of_shot, "time", kMarkerRamps, &functions);
        } else {
          AppendBumps(driver.of_shot, "smooth", kUnnamedBumps[0], &functions);
        }
        AddFunctions(functions,
                     {"",
                      marker,
                      {driver.name},
                      MarkerMovesWith(marker, driver.name),
                      sources,
                      driver,
                      {Over(driver, "learnt_marker_motion", marker)}},
                     "marker");
      }
      AddLoose("marker " + marker, marker, {static_cast<int>(m)}, 3 * static_cast<int>(m), 3);
    }
  }

  // Along the axes of every marker, then of what carries them.
  std::vector<Source> LooseParts() const {
    std::vector<Source> sources;
    for (size_t m = 0; m < problem_.data().markers.size(); ++m) {
      for (const Source& axis : Axes(Source::Kind::kMarker, static_cast<int>(m))) sources.push_back(axis);
    }
    for (int axis = 0; axis < kPlateAxes; ++axis) sources.push_back({Source::Kind::kPlate, 0, axis});
    return sources;
  }

  // What sits loose goes to the side that is down, smoothly or at once, or to another seat between visits. first,
  // count: of its axes among LooseParts.
  void AddLoose(const std::string& what, const std::string& acts_on, const std::vector<int>& markers, int first,
                int count) {
    const std::vector<Source> all = LooseParts();
    const std::vector<Source> sources(all.begin() + first, all.begin() + first + count);
    UnnamedFunction falls{"", acts_on, {"gravity"}, FallsIntoAnotherSeat(what), sources, {}, {}};
    for (const int m : markers) {
      falls.effects.push_back({"learnt_marker_seat", problem_.data().markers[static_cast<size_t>(m)], {}, {}});
    }
    AddFunctions(Sides(first, count), falls, "loose");
    UnnamedFunction leans{"", acts_on, {"gravity"}, MovesWithGravity(what), sources, {}, {}};
    UnnamedFunction jumps{"", acts_on, {"visits"}, ChangesItsSeat(what), sources, {}, {}};
    const Driver order = OrderOf(problem_);
    for (const int m : markers) {
      const std::string& marker = problem_.data().markers[static_cast<size_t>(m)];
      leans.effects.push_back({"learnt_marker_motion", marker, DownSettings(down_in_base_), {}});
      leans.effects.back().settings["by"] = "gravity";
      if (order.kind == DriverKind::kTime) jumps.effects.push_back(Over(order, "learnt_marker_motion", marker));
    }
    AddFunctions(of_down_, leans, "loose");
    GroupedFunctions seats;
    seats.Append(Stretches(order.of_shot, kSeats), "other", Fine());
    AddFunctions(seats, jumps, "loose");
  }

  // Smooth functions of the direction of gravity in the flange.
  void SetOfDown() {
    for (const int degree : {1, 3}) {
      Eigen::MatrixXd functions(static_cast<long>(down_.size()), NumDirectionFunctions(degree));
      for (size_t s = 0; s < down_.size(); ++s) {
        functions.row(static_cast<long>(s)) = DirectionFunctions(down_[s], degree);
      }
      of_down_.Append(functions, "other", {{"degree", std::to_string(degree)}});
    }
  }

  // What a load holds slides to the side that is down.
  void AddLoads() {
    for (size_t i = 0; i < columns_->loads().size(); ++i) {
      const int owner = static_cast<int>(i);
      if (columns_->LoadPointOf(owner, 0) < 0) continue;
      const std::string& load = columns_->loads()[i];
      AddFunctions(of_down_,
                   {"",
                    load,
                    {"gravity"},
                    LoadShiftsWithGravity(load),
                    Axes(Source::Kind::kLoad, owner),
                    {},
                    {{"learnt_load_shift", load, DownSettings(down_in_base_), {}}}},
                   "load shift");
      AddSlides(owner);
    }
  }

  // The same along an axis of the flange by gravity's component along it alone, as in a guide or a tank; along all
  // three, each by its own.
  void AddSlides(int owner) {
    const std::string& load = columns_->loads()[static_cast<size_t>(owner)];
    UnnamedFunction each{"", load, {"gravity"}, LoadSlides(load, "each axis"), {}, {}, {}};
    std::vector<GroupedFunctions> of_axes;
    for (const Source& axis : Axes(Source::Kind::kLoad, owner)) {
      const Eigen::VectorXd along = Component(Vector3<double>::Unit(axis.axis)), seen = OnFitted(along);
      if (!(seen.maxCoeff() - seen.minCoeff() > kStill)) continue;
      const std::string name(1, "xyz"[axis.axis]);
      EffectSpec slide{"learnt_load_slide", load, DownSettings(down_in_base_), {}};
      slide.settings["along"] = name;
      slide.settings["from"] = Significant(seen.minCoeff(), kDigits);
      slide.settings["to"] = Significant(seen.maxCoeff(), kDigits);
      of_axes.emplace_back();
      AppendBumps(along, "other", kUnnamedBumps[0], &of_axes.back());
      AddFunctions(of_axes.back(), {"", load, {"gravity"}, LoadSlides(load, name), {axis}, {}, {slide}}, "load shift");
      each.sources.push_back(axis);
      each.effects.push_back(slide);
    }
    AddEach(of_axes, each, "load shift");
  }

  // A hose, a hung cable or a balancer pulls at the flange: evenly, or by where it is.
  void AddPull() {
    if (columns_->PullAlong(0) < 0) return;
    const Field field = FieldOf(std::vector<bool>(problem_.data().shots.size(), true));
    Eigen::MatrixXd functions(field.places.rows(), 4);
    functions << Eigen::VectorXd::Ones(field.places.rows()), field.places;
    GroupedFunctions pulls;
    pulls.Append(functions.leftCols(1), "other", {{"degree", "0"}});
    pulls.Append(functions, "other", {{"degree", "1"}});
    AddFunctions(pulls,
                 {"",
                  "flange",
                  {"place"},
                  ForcePulls(),
                  Axes(Source::Kind::kPull, 0),
                  {},
                  {{"learnt_pull", "robot", field.settings, {}}}},
                 "pull");
  }

  // A jump of gravity's component along a direction: of all directions and gaps between shots those that the rows say
  // most of, each by itself.
  GroupedFunctions Sides(int first, int count) const {
    Scan<Side> scan;  // the best gap of each direction
    size_t tried = 0;
    for (const Vector3<double>& along : HalfOfAllDirections(kDirections)) {
      const std::vector<TriedJump> jumps =
          TryJumps(along_, fitted_, Component(along), {kMostGaps, kFewestOfASide, first, count});
      tried += jumps.size();
      const auto best = std::max_element(
          jumps.begin(), jumps.end(), [](const TriedJump& a, const TriedJump& b) { return a.reduction < b.reduction; });
      if (best != jumps.end()) scan.Try(best->reduction, {along, best->gap});
    }
    const std::vector<Side> sides = scan.Best(kSides);
    GroupedFunctions functions;
    for (const Side& side : sides) {
      Settings settings = DownSettings(down_in_base_);
      settings["along_x"] = Significant(side.along.x(), kDigits);
      settings["along_y"] = Significant(side.along.y(), kDigits);
      settings["along_z"] = Significant(side.along.z(), kDigits);
      settings["from"] = Significant(side.gap.first, kDigits);
      settings["to"] = Significant(side.gap.second, kDigits);
      functions.Append(Jump(Component(side.along), side.gap), "step", settings, "learnt_marker_seat",
                       static_cast<double>(sides.size()) / static_cast<double>(tried));
    }
    return functions;
  }

  Eigen::VectorXd Component(const Vector3<double>& along) const {
    Eigen::VectorXd component(static_cast<long>(down_.size()));
    for (size_t s = 0; s < down_.size(); ++s) component[static_cast<long>(s)] = along.dot(down_[s]);
    return component;
  }

  // With one marker it is that marker. As an effect it is one of each marker.
  void AddPlate() {
    const std::vector<int> markers = MarkersOnFlange(problem_);
    if (markers.size() < 2) return;
    AddLoose("what carries the markers", "flange", markers, 3 * static_cast<int>(problem_.data().markers.size()),
             kPlateAxes);
    AddGivingWay(markers);
  }

  // What carries the markers gives way to the load, or opens under it: functions of the direction of gravity times the
  // load, in units of the largest.
  void AddGivingWay(const std::vector<int>& markers) {
    const Eigen::VectorXd load =
        OfShots(problem_, [](const ShotConditions& shot) { return SizeOfForces(shot.load_wrenches); });
    const Eigen::VectorXd seen = OnFitted(load);
    if (!(seen.maxCoeff() > seen.minCoeff())) return;
    Settings settings = DownSettings(down_in_base_);
    settings["by"] = "gravity";
    settings["per_N"] = Significant(seen.maxCoeff(), kDigits);
    GroupedFunctions functions;
    for (const GroupedFunctions::Group& group : of_down_.groups) {
      const Eigen::MatrixXd unloaded = of_down_.columns.middleCols(group.first, group.count);
      functions.Append(load.asDiagonal() * unloaded / std::stod(settings["per_N"]), group.kind, group.settings);
    }
    const std::vector<Source> all = LooseParts();
    UnnamedFunction gives{"", "flange", {"gravity"}, PlateGivesWay(), {all.end() - kPlateAxes, all.end()}, {}, {}};
    for (const int m : markers) {
      gives.effects.push_back({"learnt_marker_motion", problem_.data().markers[static_cast<size_t>(m)], settings, {}});
    }
    AddFunctions(functions, gives, "loose");
  }

  const ParameterSet& parameters_;
  const Vector3<double> down_in_base_;
  const AlongSources along_;           // LooseParts
  std::vector<Vector3<double>> down_;  // of each shot, in the flange
  GroupedFunctions of_down_;
};

}  // namespace

std::vector<UnnamedGroup> ListUnnamedPlaces(const CalibrationProblem& problem, const ParameterSet& parameters,
                                            EvidenceColumns* columns) {
  PlaceFunctions functions(problem, parameters, columns);
  functions.Add();
  return functions.Take();
}

}  // namespace sagitta

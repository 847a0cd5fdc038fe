#include <algorithm>
#include <cmath>

#include "estimator/explanations/driver_functions.h"
#include "estimator/explanations/unnamed_list.h"
#include "estimator/report/explanations_words.h"
#include "models/constants.h"
#include "models/effects/pose_functions.h"
#include "problems/io/units.h"

namespace sagitta {
namespace {

// Waves in time, in halves over the campaign, and how many of them are weighed.
constexpr int kMostWaves = 200;
constexpr size_t kWaves = 6;      // the best ones
constexpr int kMarkerRamps = 16;  // in time, along three axes: jumps are marker_shift
constexpr int kSeats = 25;        // stretches of visits in which a loose part stays in its seat

constexpr int kPlateAxes = 6;
constexpr double kStandingGravity = 1e-3;  // of gravity's component along an axis: 1 mrad of turn
// Of the seats of a loose part: directions 10 degrees apart, and gaps between shots.
constexpr int kDirections = 200;
constexpr int kMostGaps = 50;
constexpr int kFewestOfASide = 3;  // shots: of fewer it is a few bad rows
constexpr size_t kSides = 6;       // the best ones

// A jump of gravity's component along a direction of the flange.
struct Side {
  Vector3<double> along;
  Gap gap;
};

class PlaceFunctions : public UnnamedList {
 public:
  PlaceFunctions(const CalibrationProblem& problem, const ParameterSet& parameters, EvidenceColumns* columns)
      : UnnamedList(problem, columns),
        parameters_(parameters),
        down_in_base_(DownInBase(problem, parameters)),
        down_settings_(VectorSettings("down_", down_in_base_)) {
    for (const ShotInput& shot : problem.shot_inputs()) {
      down_.push_back(DownInFlange(problem.robot().chain, shot.conditions.q, down_in_base_));
    }
    SetOfDown();
  }

  std::vector<UnnamedGroup> List() {
    AddStations();
    AddLinks();
    AddMarkers();
    AddPlate();
    AddLoads();
    AddPull();
    return Take();
  }

 private:
  static std::vector<Source> Axes(Source::Kind kind, int owner) {
    return {{kind, owner, 0}, {kind, owner, 1}, {kind, owner, 2}};
  }

  void AddStations() {
    for (int s = 0; s < static_cast<int>(problem_.data().stations.size()); ++s) {
      AddInTime(s);
      AddWithTemperature(s);
      AddField(s);
      AddBase(s);
    }
  }

  // A station's points move with time.
  void AddInTime(int owner) {
    const Driver time = TimeOf(problem_);
    const std::string& station = problem_.data().stations[owner];
    GroupedFunctions functions;
    if (!Smooth(time.of_shot, "time", &functions)) return;
    GroupedFunctions of_scale = functions;
    AppendRamps(time.of_shot, kFineBumps, &functions);
    AppendRamps(time.of_shot, kRamps, &of_scale);
    const auto add = [&](const GroupedFunctions& each, const std::string& words, const std::vector<Source>& sources,
                         const EffectSpec& effect) {
      AddFunctions(each, UnnamedFunction(station, {"time"}, words, sources, {effect}, time), "station in time");
    };
    const std::vector<Source> axes = Axes(Source::Kind::kStation, owner),
                              scale = {{Source::Kind::kStationScale, owner, 0}};
    add(WavesOf(time.of_shot, axes), StationMoves(station), axes, MotionOf(owner, "point", time));
    add(WithJumps(functions, axes), StationMoves(station), axes, MotionOf(owner, "point", time));
    const std::vector<Source> turns = Axes(Source::Kind::kStationTurn, owner);
    add(WithJumps(functions, turns), BaseTurnsInStation(station), turns, TurnOf(owner, time));
    // A tripod that was knocked, or set anew in a pause: it moves as a body, at once.
    AddFunctions(WithJumps({}, BodyOf(owner)), BodyMoves(owner, time, "time", StationMovesAsABody(station)),
                 "station in time");
    add(WithJumps(of_scale, scale), StationGrows(station), scale, MotionOf(owner, "scale", time));
    for (const Source& axis : axes) {
      const char name = "xyz"[axis.axis];
      add(functions, StationMovesAlong(station, name), {axis}, MotionOf(owner, std::string(1, name), time));
    }
  }

  // A base plate or a tripod that warms: as a body, with the thermometer.
  void AddWithTemperature(int owner) {
    const Driver temperature = TemperatureOf(problem_);
    if (!RangeOf(temperature.of_shot).Varies()) return;
    GroupedFunctions functions;
    AppendBumps(temperature.of_shot, "smooth", kUnnamedBumps[0], &functions);
    const std::string& station = problem_.data().stations[owner];
    AddFunctions(functions, BodyMoves(owner, temperature, "temperature", StationMovesWithTemperature(station)),
                 "station in time");
  }

  static std::vector<Source> BodyOf(int station) {
    std::vector<Source> body = Axes(Source::Kind::kStation, station);
    for (const Source& turn : Axes(Source::Kind::kStationTurn, station)) body.push_back(turn);
    return body;
  }

  EffectSpec MotionOf(int station, const std::string& moves, const Driver& driver) const {
    EffectSpec spec = Over(driver, "learnt_station_motion", problem_.data().stations[station]);
    spec.settings["moves"] = moves;
    return spec;
  }

  Settings AboutTheBase(int station) const {
    return VectorSettings("about_", 1e3 * parameters_.BaseInStation(station).translation, "_mm");
  }

  EffectSpec TurnOf(int station, const Driver& driver) const {
    EffectSpec spec = MotionOf(station, "turn", driver);
    spec.settings.merge(AboutTheBase(station));
    return spec;
  }

  UnnamedFunction BodyMoves(int station, const Driver& driver, const std::string& driven_by,
                            const std::string& words) const {
    const std::vector<EffectSpec> effects = {MotionOf(station, "point", driver), TurnOf(station, driver)};
    return UnnamedFunction(problem_.data().stations[station], {driven_by}, words, BodyOf(station), effects, driver);
  }

  GroupedFunctions WithJumps(GroupedFunctions functions, const std::vector<Source>& sources) const {
    if (OrderOf(problem_).kind == DriverKind::kTime) AppendJumpsInTime(columns_->SumAlong(sources), 1, &functions);
    return functions;
  }

  // Waves in time: of all periods down to two visits those that the rows say most of, each by itself; half a wave more
  // over the campaign is another one.
  GroupedFunctions WavesOf(const Eigen::VectorXd& time, const std::vector<Source>& axes) const {
    const AlongSources along = columns_->SumAlong(axes);
    const double span = RangeOf(time).high - RangeOf(time).low;
    const int count = std::min<int>(kMostWaves, Distinct(time(fitted_)).size());
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
      const std::string period = AsSetting(each);
      functions.Append(Wave(2.0 * kPi / ParseNumber(period).value() * time), "time", {{"period_s", period}},
                       "learnt_station_wave", listed);
    }
    return functions;
  }

  // Where the readings of a station are is where the flange is: linear and quadratic functions of that.
  void AddField(int station) {
    const Measurements& data = problem_.data();
    const std::string& name = data.stations[station];
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
                 UnnamedFunction(name, {name}, StationIsDistorted(name), Axes(Source::Kind::kStation, station),
                                 {{"learnt_station_field", name, {}, {}}}),
                 "station field");
  }

  // A foot, its anchors and what they stand on give way to the arm and its load: the base turns by where the flange is,
  // and by that times the load.
  void AddBase(int station) {
    const std::string& name = problem_.data().stations[station];
    const Eigen::VectorXd load =
        OfShots(problem_, [](const ShotConditions& shot) { return SizeOfForces(shot.load_wrenches); });
    Field field = FieldOf(std::vector<bool>(problem_.data().shots.size(), true));
    field.settings["reach"] = AsSetting(field.places(fitted_, Eigen::all).rowwise().norm().maxCoeff());
    for (auto place : field.places.rowwise()) {
      place = WithinReach(place.transpose(), ParseNumber(field.settings["reach"]).value()).transpose();
    }
    EffectSpec turn{"learnt_station_motion", name, field.settings, {}};
    turn.settings.merge(AboutTheBase(station));
    turn.settings.merge(Settings{{"by", "place"}, {"moves", "turn"}});
    AddTurns(station, OfPlace(field, false), "place", turn);
    if (!RangeOf(load).Varies()) return;
    turn.settings["per_N"] = AsSetting(RangeOf(load).high);
    GroupedFunctions loaded = OfPlace(field, true);
    loaded.columns.array().colwise() *= load.array() / turn.NumberSetting("per_N", 1.0);
    AddTurns(station, loaded, "load", turn);
  }

  void AddTurns(int station, const GroupedFunctions& functions, const std::string& driver, const EffectSpec& effect) {
    const std::string& name = effect.target;
    AddFunctions(functions,
                 UnnamedFunction(name, {driver}, BaseTurnsWith(name, driver), Axes(Source::Kind::kStationTurn, station),
                                 {effect}),
                 "base by place");
  }

  // Linear and quadratic functions of place; with_one: a constant before them.
  static GroupedFunctions OfPlace(const Field& field, bool with_one) {
    const long shots = field.places.rows(), one = with_one ? 1 : 0;
    Eigen::MatrixXd functions = Eigen::MatrixXd::Ones(shots, one + kNumFieldFunctions);
    for (long s = 0; s < shots; ++s) {
      functions.row(s).tail(kNumFieldFunctions) = FieldFunctions(field.places.row(s).transpose()).transpose();
    }
    GroupedFunctions of_place;
    of_place.Append(functions.leftCols(one + 3), "other", {{"degree", "1"}});
    of_place.Append(functions, "other", {{"degree", "2"}});
    return of_place;
  }

  // Links grow with time or temperature, each in its own way: one of them, or all.
  void AddLinks() {
    std::vector<Source> links;
    for (int joint = -1; joint < joints(); ++joint) {
      if (!columns_->LengthsOf(joint).empty()) links.push_back({Source::Kind::kLink, joint, 0});
    }
    for (const auto& [driver, name] : {std::pair{TimeOf(problem_), "time"}, {TemperatureOf(problem_), "temperature"}}) {
      if (links.empty() || !RangeOf(driver.of_shot).Varies()) continue;
      GroupedFunctions functions;
      AppendBumps(driver.of_shot, driver.kind == DriverKind::kTime ? "time" : "smooth", kUnnamedBumps[0], &functions);
      const EffectSpec effect = Over(driver, "learnt_growth", "robot");
      for (const Source& link : links) {
        const std::string where = link.owner < 0 ? "the foot" : "the link after " + JointName(link.owner);
        AddFunctions(functions, UnnamedFunction(where, {name}, where + " grows with " + name, {link}, {effect}, driver),
                     "link in time");
      }
      AddFunctions(
          functions,
          UnnamedFunction("links", {name}, std::string("each link grows with ") + name, links, {effect}, driver),
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
        if (!RangeOf(driver.of_shot).Varies()) continue;
        if (driver.kind == DriverKind::kTime) {
          AppendRamps(driver.of_shot, kMarkerRamps, &functions);
        } else {
          AppendBumps(driver.of_shot, "smooth", kUnnamedBumps[0], &functions);
        }
        AddFunctions(functions,
                     UnnamedFunction(marker, {driver.name}, MarkerMovesWith(marker, driver.name), sources,
                                     {Over(driver, "learnt_marker_motion", marker)}, driver),
                     "marker");
      }
      AddLoose("marker " + marker, marker, {static_cast<int>(m)}, sources);
    }
  }

  // What sits loose goes to the side that is down, smoothly or at once, or to another seat between visits.
  void AddLoose(const std::string& what, const std::string& acts_on, const std::vector<int>& markers,
                const std::vector<Source>& sources) {
    UnnamedFunction falls(acts_on, {"gravity"}, FallsIntoAnotherSeat(what), sources, {});
    UnnamedFunction leans(acts_on, {"gravity"}, MovesWithGravity(what), sources, {});
    UnnamedFunction jumps(acts_on, {"visits"}, ChangesItsSeat(what), sources, {});
    const Driver order = OrderOf(problem_);
    for (const int m : markers) {
      const std::string& marker = problem_.data().markers[m];
      falls.effects.push_back({"learnt_marker_seat", marker, {}, {}});
      leans.effects.push_back({"learnt_marker_motion", marker, down_settings_, {}});
      leans.effects.back().settings["by"] = "gravity";
      const bool is_of_it = order.kind == DriverKind::kTime && !IsTool(markers);
      if (is_of_it) jumps.effects.push_back(Over(order, "learnt_marker_motion", marker));
    }
    if (order.kind == DriverKind::kTime && IsTool(markers)) jumps.effects = {ToolMotion()};
    AddFunctions(Sides(sources), falls, "loose");
    AddFunctions(of_down_, leans, "loose");
    GroupedFunctions seats;
    seats.Append(Stretches(order.of_shot, kSeats), "other", {{"knots", std::to_string(kSeats)}, {"shape", "ramps"}});
    const size_t fewest = markers.size() > 1 ? 1 : 2;  // one jump of one marker is marker_shift
    if (order.kind == DriverKind::kTime) AppendJumpsInTime(columns_->SumAlong(sources), fewest, &seats);
    AddFunctions(seats, jumps, "loose");
  }

  // Smooth functions of the direction of gravity in the flange.
  void SetOfDown() {
    for (const int degree : {1, 3}) {
      Eigen::MatrixXd functions(static_cast<long>(down_.size()), NumDirectionFunctions(degree));
      for (size_t s = 0; s < down_.size(); ++s) {
        functions.row(s) = DirectionFunctions(down_[s], degree);
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
                   UnnamedFunction(load, {"gravity"}, LoadShiftsWithGravity(load), Axes(Source::Kind::kLoad, owner),
                                   {{"learnt_load_shift", load, down_settings_, {}}}),
                   "load shift");
      AddSlides(owner);
    }
  }

  // The same along an axis of the flange by gravity's component along it alone, as in a guide or a tank; along all
  // three, each by its own. Their means over the shots are load_com's: a centre of gravity that is off along one axis
  // would be a slide that hardly slides, of which one axis is asked and not three.
  void AddSlides(int owner) {
    const std::string& load = columns_->loads()[owner];
    UnnamedFunction each(load, {"gravity"}, LoadSlides(load, "each axis"), {}, {});
    std::vector<GroupedFunctions> of_axes;
    for (const Source& axis : Axes(Source::Kind::kLoad, owner)) {
      const Eigen::VectorXd along = Component(Vector3<double>::Unit(axis.axis));
      const auto [low, high] = RangeOf(along);
      if (!(high - low > kStandingGravity)) continue;
      const std::string name(1, "xyz"[axis.axis]);
      EffectSpec slide{"learnt_load_slide", load, down_settings_, {}};
      slide.settings["along"] = name;
      slide.settings["from"] = AsSetting(low);
      slide.settings["to"] = AsSetting(high);
      of_axes.emplace_back();
      AppendBumps(along, "other", kUnnamedBumps[0], &of_axes.back());
      Eigen::MatrixXd& functions = of_axes.back().columns;
      functions.rowwise() -= functions(fitted_, Eigen::all).colwise().mean().eval();
      AddFunctions(of_axes.back(), UnnamedFunction(load, {"gravity"}, LoadSlides(load, name), {axis}, {slide}),
                   "load shift");
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
                 UnnamedFunction("flange", {"place"}, ForcePulls(), Axes(Source::Kind::kPull, 0),
                                 {{"learnt_pull", "robot", field.settings, {}}}),
                 "pull");
  }

  // A jump of gravity's component along a direction: of all directions and gaps between shots those that the rows say
  // most of, each by itself.
  GroupedFunctions Sides(const std::vector<Source>& sources) const {
    const AlongSources along_sources = columns_->SumAlong(sources);
    Scan<Side> scan;  // the best gap of each direction
    size_t tried = 0;
    for (const Vector3<double>& along : HalfOfAllDirections(kDirections)) {
      const std::vector<TriedJump> jumps = TryJumps(along_sources, fitted_, Component(along),
                                                    {kMostGaps, kFewestOfASide, 0, static_cast<long>(sources.size())});
      tried += jumps.size();
      const auto best = std::max_element(
          jumps.begin(), jumps.end(), [](const TriedJump& a, const TriedJump& b) { return a.reduction < b.reduction; });
      if (best != jumps.end()) scan.Try(best->reduction, {along, best->gap});
    }
    const std::vector<Side> sides = scan.Best(kSides);
    GroupedFunctions functions;
    for (const Side& side : sides) {
      Settings settings = VectorSettings("along_", side.along);
      settings.insert(down_settings_.begin(), down_settings_.end());
      settings["from"] = AsSetting(side.gap.first);
      settings["to"] = AsSetting(side.gap.second);
      functions.Append(Jump(Component(side.along), side.gap), "step", settings, "learnt_marker_seat",
                       static_cast<double>(sides.size()) / static_cast<double>(tried));
    }
    return functions;
  }

  Eigen::VectorXd Component(const Vector3<double>& along) const {
    Eigen::VectorXd component(static_cast<long>(down_.size()));
    for (size_t s = 0; s < down_.size(); ++s) component[s] = along.dot(down_[s]);
    return component;
  }

  // With one marker it is that marker. As an effect it is one of each marker.
  void AddPlate() {
    const std::vector<int> markers = problem_.MarkersOnFlange();
    if (markers.size() < 2) return;
    std::vector<Source> plate;
    for (int axis = 0; axis < kPlateAxes; ++axis) plate.push_back({Source::Kind::kPlate, 0, axis});
    AddLoose("what carries the markers", "flange", markers, plate);
    AddGivingWay(markers, plate);
    if (IsTool(markers) && OrderOf(problem_).kind == DriverKind::kTime) AddToolInTime(plate);
  }

  // Whether all markers ride on the flange: with them the tool moves.
  bool IsTool(const std::vector<int>& markers) const {
    return markers.size() > 1 && markers.size() == problem_.data().markers.size();
  }

  EffectSpec ToolMotion() const { return Over(TimeOf(problem_), "learnt_tool_motion", JointName(joints() - 1)); }

  // The tool warms up, is pushed or slips: it moves as a body, or along or about one axis of the flange.
  void AddToolInTime(const std::vector<Source>& plate) {
    const Driver time = TimeOf(problem_);
    GroupedFunctions functions;
    if (!Smooth(time.of_shot, "time", &functions)) return;
    const auto add = [&](const std::string& words, const std::vector<Source>& sources, const EffectSpec& effect) {
      AddFunctions(functions, UnnamedFunction("flange", {"time"}, words, sources, {effect}, time), "tool in time");
    };
    add(ToolMoves(), plate, ToolMotion());
    AppendRamps(time.of_shot, kRamps, &functions);
    for (const Source& axis : plate) {
      const std::string name(1, "xyz"[axis.axis % 3]);
      EffectSpec effect = ToolMotion();
      effect.settings["moves"] = (axis.axis < 3 ? "" : "r") + name;
      add(axis.axis < 3 ? ToolMovesAlong(name) : ToolTurnsAbout(name), {axis}, effect);
    }
  }

  // What carries the markers gives way to the load, or opens under it: functions of the direction of gravity times the
  // load, in units of the largest.
  void AddGivingWay(const std::vector<int>& markers, const std::vector<Source>& plate) {
    const Eigen::VectorXd load =
        OfShots(problem_, [](const ShotConditions& shot) { return SizeOfForces(shot.load_wrenches); });
    if (!RangeOf(load).Varies()) return;
    Settings settings = down_settings_;
    settings["by"] = "gravity";
    settings["per_N"] = AsSetting(RangeOf(load).high);
    GroupedFunctions functions;
    for (const GroupedFunctions::Group& group : of_down_.groups) {
      const Eigen::MatrixXd unloaded = of_down_.columns.middleCols(group.first, group.count);
      functions.Append(load.asDiagonal() * unloaded / ParseNumber(settings["per_N"]).value(), group.kind,
                       group.settings);
    }
    UnnamedFunction gives("flange", {"gravity"}, PlateGivesWay(), plate, {});
    for (const int m : markers) {
      gives.effects.push_back({"learnt_marker_motion", problem_.data().markers[m], settings, {}});
    }
    AddFunctions(functions, gives, "loose");
  }

  const ParameterSet& parameters_;
  const Vector3<double> down_in_base_;
  const Settings down_settings_;       // of an effect that asks which way is down
  std::vector<Vector3<double>> down_;  // of each shot, in the flange
  GroupedFunctions of_down_;
};

}  // namespace

std::vector<UnnamedGroup> ListUnnamedPlaces(const CalibrationProblem& problem, const ParameterSet& parameters,
                                            EvidenceColumns* columns) {
  return PlaceFunctions(problem, parameters, columns).List();
}

}  // namespace sagitta

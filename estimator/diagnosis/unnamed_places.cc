#include <algorithm>
#include <cmath>

#include "estimator/diagnosis/driver_functions.h"
#include "estimator/diagnosis/unnamed_list.h"
#include "estimator/report/diagnosis_function_words.h"
#include "models/constants.h"
#include "models/effects/pose_functions.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr int kPeriods = 8;  // of waves over the time of the campaign
constexpr int kSeats = 25;   // stretches of visits in which a loose part stays in its seat

std::string InMillimetres(double value) { return Significant(1e3 * value, kDigits); }

class PlaceFunctions : public UnnamedList {
 public:
  PlaceFunctions(const CalibrationProblem& problem, const ParameterSet& parameters, EvidenceColumns* columns)
      : UnnamedList(problem, columns), parameters_(parameters), down_in_base_(DownInBase(problem, parameters)) {}

  void Add() {
    AddStations();
    AddLinks();
    AddMarkers();
    AddPlate();
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
        turn.settings["about_x_mm"] = InMillimetres(foot.x());
        turn.settings["about_y_mm"] = InMillimetres(foot.y());
        turn.settings["about_z_mm"] = InMillimetres(foot.z());
        const double span = time.of_shot.maxCoeff() - time.of_shot.minCoeff();
        AppendBumps(time.of_shot, "time", kFineBumps, &functions);
        for (int n = 1; n <= kPeriods; ++n) {
          functions.Append(Waves(2.0 * kPi * n / span * time.of_shot, 1), "time", Fine());
        }
        AddFunctions(functions,
                     {"",
                      station,
                      {"time"},
                      StationMoves(station),
                      Axes(Source::Kind::kStation, owner),
                      time,
                      {OfStation(time, station, "point")}},
                     "station in time");
        AddFunctions(
            functions,
            {"", station, {"time"}, BaseTurnsInStation(station), Axes(Source::Kind::kStationTurn, owner), time, {turn}},
            "station in time");
        AddFunctions(functions,
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

  // Where the readings of a station are is where the flange is: linear and quadratic functions of that, from the middle
  // of its shots and in units of their spread.
  void AddField(int station) {
    const Measurements& data = problem_.data();
    const std::string& name = data.stations[static_cast<size_t>(station)];
    std::vector<Vector3<double>> places(data.shots.size(), Vector3<double>::Zero());
    Vector3<double> middle = Vector3<double>::Zero();
    double count = 0.0, square = 0.0;
    for (size_t s = 0; s < data.shots.size(); ++s) {
      places[s] = FlangePlace(problem_.robot().chain, problem_.shot_inputs()[s].conditions.q);
    }
    for (const int s : fitted_) {
      if (data.shots[s].station != station) continue;
      middle += (places[s] - middle) / ++count;
    }
    for (const int s : fitted_) {
      if (data.shots[s].station == station) square += (places[s] - middle).squaredNorm() / (3.0 * count);
    }
    const double spread = std::max(1e-3, std::sqrt(square));
    Eigen::MatrixXd functions = Eigen::MatrixXd::Zero(static_cast<long>(places.size()), kNumFieldFunctions);
    for (size_t s = 0; s < places.size(); ++s) {
      if (data.shots[s].station != station) continue;
      functions.row(static_cast<long>(s)) = FieldFunctions((places[s] - middle) / spread);
    }
    GroupedFunctions field;
    field.Append(functions, "other", {});
    const EffectSpec effect{"learnt_station_field",
                            name,
                            {{"x_mm", InMillimetres(middle.x())},
                             {"y_mm", InMillimetres(middle.y())},
                             {"z_mm", InMillimetres(middle.z())},
                             {"spread_mm", InMillimetres(spread)}},
                            {}};
    AddFunctions(field,
                 {"", name, {name}, StationIsDistorted(name), Axes(Source::Kind::kStation, station), {}, {effect}},
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
        AppendBumps(driver.of_shot, is_time ? "time" : "smooth", kUnnamedBumps[is_time ? 1 : 0], &functions);
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
      AddLoose("marker " + marker, marker, sources, {static_cast<int>(m)});
    }
  }

  // What sits loose goes to the side that is down, or to another seat between visits.
  void AddLoose(const std::string& what, const std::string& acts_on, const std::vector<Source>& sources,
                const std::vector<int>& markers) {
    UnnamedFunction leans{"", acts_on, {"gravity"}, MovesWithGravity(what), sources, {}, {}};
    UnnamedFunction jumps{"", acts_on, {"visits"}, ChangesItsSeat(what), sources, {}, {}};
    const Driver order = OrderOf(problem_);
    for (const int m : markers) {
      const std::string& marker = problem_.data().markers[static_cast<size_t>(m)];
      leans.effects.push_back({"learnt_marker_motion",
                               marker,
                               {{"by", "gravity"},
                                {"down_x", Significant(down_in_base_.x(), kDigits)},
                                {"down_y", Significant(down_in_base_.y(), kDigits)},
                                {"down_z", Significant(down_in_base_.z(), kDigits)}},
                               {}});
      if (order.kind == DriverKind::kTime) jumps.effects.push_back(Over(order, "learnt_marker_motion", marker));
    }
    GroupedFunctions down;
    for (const int degree : {1, 3}) {
      Eigen::MatrixXd functions(static_cast<long>(problem_.shot_inputs().size()), NumDirectionFunctions(degree));
      for (long s = 0; s < functions.rows(); ++s) {
        const Eigen::VectorXd& q = problem_.shot_inputs()[static_cast<size_t>(s)].conditions.q;
        functions.row(s) = DirectionFunctions(DownInFlange(problem_.robot().chain, q, down_in_base_), degree);
      }
      down.Append(functions, "other", {{"degree", std::to_string(degree)}});
    }
    AddFunctions(down, leans, "loose");
    GroupedFunctions seats;
    seats.Append(Stretches(order.of_shot, kSeats), "other", Fine());
    AddFunctions(seats, jumps, "loose");
  }

  // With one marker it is that marker. As an effect it is one of each marker.
  void AddPlate() {
    const std::vector<int> markers = MarkersOnFlange(problem_);
    if (markers.size() < 2) return;
    std::vector<Source> axes;
    for (int axis = 0; axis < 6; ++axis) axes.push_back({Source::Kind::kPlate, 0, axis});
    AddLoose("what carries the markers", "flange", axes, markers);
  }

  const ParameterSet& parameters_;
  Vector3<double> down_in_base_;
};

}  // namespace

std::vector<UnnamedGroup> ListUnnamedPlaces(const CalibrationProblem& problem, const ParameterSet& parameters,
                                            EvidenceColumns* columns) {
  PlaceFunctions functions(problem, parameters, columns);
  functions.Add();
  return functions.Take();
}

}  // namespace sagitta

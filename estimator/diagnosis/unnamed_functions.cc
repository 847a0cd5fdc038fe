#include "estimator/diagnosis/unnamed_functions.h"

#include <algorithm>
#include <cmath>

#include "estimator/diagnosis/driver_functions.h"
#include "estimator/report/diagnosis_function_words.h"
#include "models/constants.h"

namespace sagitta {
namespace {

// Random smooth functions bend over a third or a ninth of the driver's range: a sag and a ripple.
constexpr int kBumps[] = {4, 10};
constexpr int kOrders = 6;       // of waves over another joint's angle, as of the catalogue's harmonics (candidates.cc)
constexpr int kPeriods = 8;      // of waves over the time of the campaign
constexpr int kPlaces = 24;      // of a jump along a joint's angle
constexpr int kFineBumps = 25;   // of a joint's own angle: a bump of 10 degrees
constexpr int kSeats = 25;       // stretches of visits in which a loose part stays in its seat
constexpr double kAlike = 1e-3;  // of the largest: directions of functions that add less are dropped

class UnnamedBuilder {
 public:
  UnnamedBuilder(const CalibrationProblem& problem, const ParameterSet& parameters, EvidenceColumns* columns)
      : problem_(problem), parameters_(parameters), columns_(columns), fitted_(FittedShots(problem)) {}

  std::vector<UnnamedGroup> Build() {
    AddJointFunctions();
    AddPairs();
    AddStations();
    AddLinks();
    AddMarkers();
    AddPlate();
    return std::move(list_);
  }

 private:
  Eigen::MatrixXd OnFitted(const Eigen::MatrixXd& functions) const { return functions(fitted_, Eigen::all); }

  // What functions one driver has, and which of them go together.
  struct Functions {
    Eigen::MatrixXd columns;
    struct Group {
      std::string kind;
      int first, count;
    };
    std::vector<Group> groups;

    void Append(const Eigen::MatrixXd& more, const std::string& kind, int per_group) {
      const long before = columns.cols();
      columns.conservativeResize(more.rows(), before + more.cols());
      columns.rightCols(more.cols()) = more;
      for (int c = 0; c < more.cols(); c += per_group) {
        groups.push_back({kind, static_cast<int>(before) + c, per_group});
      }
    }
  };

  // Smooth functions of x over the range of the fitted shots. False: it does not vary.
  bool Smooth(const Eigen::VectorXd& x, const std::string& kind, Functions* functions) const {
    const Eigen::VectorXd fitted = OnFitted(x);
    const double low = fitted.minCoeff(), high = fitted.maxCoeff();
    if (!(high - low > 1e-9 * (1.0 + std::abs(high)))) return false;
    for (const int count : kBumps) functions->Append(Bumps(x, low, high, count), kind, count);
    return true;
  }

  // Every group of functions on one source or on several that move together.
  void AddFunctions(const Functions& functions, const UnnamedFunction& what, const std::string& family) {
    const Compressed compressed = Compress(functions.columns, kAlike);
    std::vector<std::vector<int>> own;
    for (const Source& source : what.sources) own.push_back(columns_->Add({source, compressed.basis}));
    const long height = compressed.basis.cols();
    for (const Functions::Group& group : functions.groups) {
      ColumnGroup columns;
      columns.mixing.setZero(height * static_cast<long>(own.size()), group.count * static_cast<long>(own.size()));
      for (size_t s = 0; s < own.size(); ++s) {
        columns.columns.insert(columns.columns.end(), own[s].begin(), own[s].end());
        columns.mixing.block(height * static_cast<long>(s), group.count * static_cast<long>(s), height, group.count) =
            compressed.mixing.middleCols(group.first, group.count);
      }
      UnnamedFunction function = what;
      function.kind = group.kind;
      list_.push_back({std::move(columns), std::move(function), family});
    }
  }

  std::string JointName(int j) const { return problem_.robot().chain.joints[j].name; }
  int joints() const { return problem_.robot().num_joints(); }

  // A joint deviates with a driver.
  void AddJointFunctions() {
    const bool loaded = std::any_of(problem_.shot_inputs().begin(), problem_.shot_inputs().end(),
                                    [](const ShotInput& shot) { return !shot.wrenches.empty(); });
    const Eigen::MatrixXd torques = loaded ? JointTorques(problem_, parameters_) : Eigen::MatrixXd();
    std::vector<std::pair<Driver, std::string>> common = {{TimeOf(problem_), "time"},
                                                          {TemperatureOf(problem_), "temperature"}};
    for (int j = 0; j < joints(); ++j) {
      const Source source{Source::Kind::kJoint, j, 0};
      for (int k = 0; k < joints(); ++k) {
        Functions functions;
        const Eigen::VectorXd q = OfShots(problem_, [k](const ShotConditions& shot) { return shot.q[k]; });
        if (!Smooth(q, "smooth", &functions)) continue;
        if (k == j) {
          const Eigen::VectorXd seen = OnFitted(q);
          functions.Append(Bumps(q, seen.minCoeff(), seen.maxCoeff(), kFineBumps), "smooth", kFineBumps);
        }
        if (k == j) functions.Append(Jumps(q, PlacesBetween(OnFitted(q), kPlaces)), "step", 1);
        if (k != j && IsRevolute(problem_, k)) functions.Append(Waves(q, kOrders), "periodic", 2);
        AddFunctions(functions,
                     {"",
                      JointName(j),
                      {JointName(k)},
                      DeviatesWith(JointName(j), JointName(k)),
                      {source},
                      AngleOf(problem_, k)},
                     k == j ? "own angle" : "other angle");
      }
      std::vector<std::pair<Driver, std::string>> drivers = common;
      if (loaded) drivers.push_back({TorqueOf(problem_, j, torques), "torque"});
      for (const auto& [driver, family] : drivers) {
        Functions functions;
        if (!Smooth(driver.of_shot, driver.kind == DriverKind::kTime ? "time" : "smooth", &functions)) continue;
        const bool is_torque = driver.kind == DriverKind::kTorque;
        AddFunctions(functions,
                     {"",
                      JointName(j),
                      {is_torque ? JointName(j) : family},
                      DeviatesWith(JointName(j), is_torque ? "the torque on it" : family),
                      {source},
                      driver},
                     family);
      }
    }
  }

  // A joint deviates with two joints' angles together.
  void AddPairs() {
    for (int a = 0; a < joints(); ++a) {
      for (int b = a + 1; b < joints(); ++b) {
        const Eigen::VectorXd p = OfShots(problem_, [a](const ShotConditions& shot) { return shot.q[a]; });
        const Eigen::VectorXd q = OfShots(problem_, [b](const ShotConditions& shot) { return shot.q[b]; });
        const Eigen::ArrayXd u = p.array() - OnFitted(p).mean(), v = q.array() - OnFitted(q).mean();
        if (!(OnFitted(p).maxCoeff() > OnFitted(p).minCoeff()) || !(OnFitted(q).maxCoeff() > OnFitted(q).minCoeff())) {
          continue;
        }
        Functions functions;
        functions.Append((u * v).matrix(), "other", 1);
        Eigen::MatrixXd turning(p.size(), 4);
        turning << (p + q).array().cos().matrix(), (p + q).array().sin().matrix(), (p - q).array().cos().matrix(),
            (p - q).array().sin().matrix();
        if (IsRevolute(problem_, a) && IsRevolute(problem_, b)) functions.Append(turning, "other", 4);
        for (int j = 0; j < joints(); ++j) {
          const std::string words = DeviatesWithBoth(JointName(j), JointName(a), JointName(b));
          AddFunctions(functions,
                       {"", JointName(j), {JointName(a), JointName(b)}, words, {{Source::Kind::kJoint, j, 0}}, {}},
                       "two angles");
        }
      }
    }
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
      Functions functions;
      if (Smooth(time.of_shot, "time", &functions)) {
        const double span = time.of_shot.maxCoeff() - time.of_shot.minCoeff();
        functions.Append(Waves(2.0 * kPi / span * time.of_shot, kPeriods), "time", 2);
        AddFunctions(functions,
                     {"", station, {"time"}, StationMoves(station), Axes(Source::Kind::kStation, owner), time},
                     "station in time");
        AddFunctions(
            functions,
            {"", station, {"time"}, BaseTurnsInStation(station), Axes(Source::Kind::kStationTurn, owner), time},
            "station in time");
        for (const Source& axis : Axes(Source::Kind::kStation, owner)) {
          AddFunctions(functions, {"", station, {"time"}, StationMovesAlong(station, "xyz"[axis.axis]), {axis}, time},
                       "station in time");
        }
      }
      Functions field;
      field.Append(Field(owner), "other", 9);
      AddFunctions(field,
                   {"", station, {station}, StationIsDistorted(station), Axes(Source::Kind::kStation, owner), {}},
                   "station field");
    }
  }

  // Of the points of a shot that were read, in the station; not a number where none was.
  Vector3<double> MeanPoint(const Shot& shot) const {
    Vector3<double> sum = Vector3<double>::Zero();
    int count = 0;
    for (const int i : shot.observations) {
      const Observation& row = problem_.data().observations[i];
      if (!row.is_point() || !row.point_in_station.allFinite()) continue;
      sum += row.point_in_station;
      ++count;
    }
    return sum / count;
  }

  // Linear and quadratic functions of where the shot's points were read, their mean, over the spread of all shots.
  Eigen::MatrixXd Field(int station) const {
    const Measurements& data = problem_.data();
    Eigen::MatrixXd points = Eigen::MatrixXd::Zero(static_cast<long>(data.shots.size()), 3);
    Eigen::RowVector3d mean = Eigen::RowVector3d::Zero(), spread = Eigen::RowVector3d::Zero();
    double count = 0.0;
    for (const bool second : {false, true}) {
      for (size_t s = 0; s < data.shots.size(); ++s) {
        if (data.shots[s].station != station || data.shots[s].observations.empty()) continue;
        points.row(static_cast<long>(s)) = MeanPoint(data.shots[s]).transpose();
        if (!points.row(static_cast<long>(s)).allFinite()) points.row(static_cast<long>(s)) = mean;
        if (!std::binary_search(fitted_.begin(), fitted_.end(), static_cast<int>(s))) continue;
        const Eigen::RowVector3d off = points.row(static_cast<long>(s)) - mean;
        if (second) {
          spread += off.cwiseAbs2();
        } else {
          count += 1.0;
          mean += off / count;
        }
      }
    }
    spread = (spread / std::max(1.0, count)).cwiseSqrt().cwiseMax(1e-3);
    Eigen::MatrixXd functions = Eigen::MatrixXd::Zero(points.rows(), 9);
    for (size_t s = 0; s < data.shots.size(); ++s) {
      if (data.shots[s].station != station) continue;
      const Eigen::RowVector3d x = (points.row(static_cast<long>(s)) - mean).cwiseQuotient(spread);
      functions.row(static_cast<long>(s)) << x, x[0] * x[0], x[1] * x[1], x[2] * x[2], x[0] * x[1], x[0] * x[2],
          x[1] * x[2];
    }
    return functions;
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
      Functions functions;
      functions.Append(Bumps(driver.of_shot, seen.minCoeff(), seen.maxCoeff(), kBumps[0]), "time", kBumps[0]);
      for (const Source& link : links) {
        const std::string where = link.owner < 0 ? "the foot" : "the link after " + JointName(link.owner);
        AddFunctions(functions, {"", where, {name}, where + " grows with " + name, {link}, driver}, "link in time");
      }
      AddFunctions(functions, {"", "links", {name}, std::string("each link grows with ") + name, links, driver},
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
        Functions functions;
        const Eigen::VectorXd fitted = OnFitted(driver.of_shot);
        const double low = fitted.minCoeff(), high = fitted.maxCoeff();
        if (!(high - low > 1e-9 * (1.0 + std::abs(high)))) continue;
        const bool is_time = driver.kind == DriverKind::kTime;
        functions.Append(Bumps(driver.of_shot, low, high, kBumps[is_time ? 1 : 0]), is_time ? "time" : "smooth",
                         kBumps[is_time ? 1 : 0]);
        AddFunctions(functions, {"", marker, {driver.name}, MarkerMovesWith(marker, driver.name), sources, driver},
                     "marker");
      }
      AddLoose("marker " + marker, marker, sources);
    }
  }

  // What sits loose goes to the side that is down, or to another seat between visits.
  void AddLoose(const std::string& what, const std::string& acts_on, const std::vector<Source>& sources) {
    if (down_.size() == 0) down_ = DownInFlange(problem_, parameters_);
    Functions down;
    for (const int degree : {1, 3}) {
      const Eigen::MatrixXd functions = OfDirection(down_, degree);
      down.Append(functions, "other", static_cast<int>(functions.cols()));
    }
    AddFunctions(down, {"", acts_on, {"gravity"}, MovesWithGravity(what), sources, {}}, "loose");
    Functions seats;
    const Eigen::MatrixXd stretches = Stretches(OrderOf(problem_).of_shot, kSeats);
    seats.Append(stretches, "other", static_cast<int>(stretches.cols()));
    AddFunctions(seats, {"", acts_on, {"visits"}, ChangesItsSeat(what), sources, {}}, "loose");
  }

  // With one marker it is that marker.
  void AddPlate() {
    if (MarkersOnFlange(problem_).size() < 2) return;
    std::vector<Source> axes;
    for (int axis = 0; axis < 6; ++axis) axes.push_back({Source::Kind::kPlate, 0, axis});
    AddLoose("what carries the markers", "flange", axes);
  }

  const CalibrationProblem& problem_;
  const ParameterSet& parameters_;
  EvidenceColumns* columns_;
  std::vector<int> fitted_;  // shots
  std::vector<UnnamedGroup> list_;
  Eigen::MatrixXd down_;  // shots x 3, in the flange frame
};

}  // namespace

std::vector<UnnamedGroup> ListUnnamed(const CalibrationProblem& problem, const ParameterSet& parameters,
                                      EvidenceColumns* columns) {
  return UnnamedBuilder(problem, parameters, columns).Build();
}

}  // namespace sagitta

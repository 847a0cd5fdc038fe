// A second list of causes outside the catalogue that real robots, cells and trackers have; none is in foreign.cc.
#include <algorithm>
#include <cmath>
#include <utility>

#include "tests/hidden_effects/generator/causes.h"

namespace hidden {
namespace {

// The drives hold the first shot of a configuration; then the brakes close and the load is hung on. A brake's hub has
// play on its shaft: what is left of it towards the side to which the torque turns, s - u with s = sign T and u where
// the hub was when it closed, is lost as far as the gear's friction F lets it: T^2 / (T^2 + F^2).
void BrakeDrop(Draw d) {
  const std::vector<double> arrived = Arrivals(d.design);
  for (const int j : d.MainAxes()) {
    std::vector<double> hub;
    for (size_t c = 0; c < arrived.size(); ++c) hub.push_back(d.random->Uniform(-1.0, 1.0));
    const double friction = d.TypicalTorque() * d.random->Uniform(0.1, 0.4);
    const double half_play = d.scale * 0.3 * kTypicalAngle * d.random->Uniform(0.5, 1.5);
    d.nature->gears.push_back({j, [=](const Shot& shot, double torque) {
                                 if (shot.since_first <= arrived[shot.config]) return 0.0;
                                 const double pushed = torque * torque / (torque * torque + friction * friction);
                                 return half_play * pushed * (std::copysign(1.0, torque) - hub[shot.config]);
                               }});
  }
  d.effect->target = d.Name(d.MainAxes().front());
  d.effect->words = "the brakes of the three main axes have play and close after the first shot";
}

// A joint's bearing has lost its preload: the axis lies on the side to which the moment across it presses, by all of
// the play once the rollers carry, m / (|m| + m0). What hangs beyond turns with the next joint.
void BearingPlay(Draw d) {
  const int j = RevoluteJoint(d.robot, d.random);
  const double mass = d.robot.heavy.mass * d.random->Uniform(0.5, 1.5);
  const Weight beyond{std::min(j + 1, d.robot.arm.size() - 1), mass, d.random->NormalVector(d.Reach())};
  const double carries = d.TypicalTorque() * d.random->Uniform(0.05, 0.3);  // N m
  const double play = d.scale * 0.5 * kTypicalAngle;
  d.effect->target = d.Name(j);
  d.effect->words = "bearing without preload, carries from " + std::to_string(carries) + " N m";
  d.nature->bearings.push_back(
      {j, beyond, [=](const Vector3d& across) -> Vector3d { return play * across / (across.norm() + carries); }});
}

// The heavy load is a box that is not full: what is in it slides to the low side, as far along each side of the box as
// there is room, way * tanh(down / repose).
void ShiftingLoad(Draw d) {
  Vector3d way;
  for (int axis = 0; axis < 3; ++axis) way[axis] = d.scale * 0.02 * d.random->Uniform(0.3, 1.0);
  const double repose = d.random->Uniform(0.2, 0.6);  // sine of the slope at which it begins to slide
  const std::string box = d.robot.heavy.name;
  d.effect->target = box;
  d.effect->words = "its contents slide to the low side, from a slope of " + std::to_string(repose);
  d.nature->load_shift = [=](const Shot& shot, const Vector3d& down) -> Vector3d {
    if (shot.load != box) return Vector3d::Zero();
    return way.cwiseProduct((down / repose).array().tanh().matrix());
  };
}

// A bar that is fixed at the flange bends under the weight at its end: by softness across it, in two directions, and
// the end turns by 3/2 of the sag over its length. It carries one marker, or all of them.
void SoftTool(Draw d) {
  const bool whole = d.random->Chance(0.5);
  const std::string soft = d.Marker();
  const Vector3d along = d.random->Direction(), across = along.cross(d.random->Direction()).normalized();
  const Vector3d other = along.cross(across);
  const double length = d.robot.marker_spread * d.random->Uniform(1.0, 2.0), flat = d.random->Uniform(0.1, 1.0);
  const Matrix3d softness =
      d.scale * 2.0 * kTypicalLength * (across * across.transpose() + flat * other * other.transpose());  // m per g
  const std::map<std::string, Vector3d> markers = d.nature->markers;
  Vector3d end = Vector3d::Zero();
  for (const auto& entry : markers) end += entry.second / static_cast<double>(markers.size());
  const Arm arm = d.nature->arm;
  const auto stations = d.nature->stations;
  d.effect->target = whole ? "flange" : soft;
  d.effect->words = "a bar that sags, one way by " + std::to_string(flat) + " of the other";
  d.nature->seats.push_back([=](const Shot& shot, const std::string& marker) -> Vector3d {
    if (!whole && marker != soft) return Vector3d::Zero();
    const Vector3d down = -stations.at(shot.station).turn.row(2).transpose();  // base frame
    const Vector3d sag = softness * (PlaceAsCommanded(arm, shot).flange.turn.transpose() * down);
    if (!whole) return sag;
    return sag + 1.5 / length * along.cross(sag).cross(markers.at(marker) - end);
  });
}

// A drive is heated by the way it turns, and the heat flows off in the time constant tau: after moves by w_i at t_i,
// h = sum w_i exp(-(t - t_i) / tau), here over what it tends to at the mean pace. The zero of the joint goes with it.
std::function<double(const Shot&)> HeatOf(const Design& design, int joint, double tau) {
  const std::vector<double> arrived = Arrivals(design);
  std::vector<double> way(arrived.size(), 0.0);
  double sum = 0.0;
  for (size_t c = 1; c < arrived.size(); ++c) {
    const double turning = design.turning_points[c][joint];
    way[c] = std::abs(turning - design.arrivals[c - 1][joint]) + std::abs(design.arrivals[c][joint] - turning);
    sum += way[c];
  }
  const double settled = sum / arrived.back() * tau;
  return [=](const Shot& shot) {
    double heat = 0.0;
    for (int c = 0; c <= shot.config; ++c) heat += way[c] * std::exp((arrived[c] - shot.since_first) / tau);
    return heat / settled;
  };
}

void DriveHeat(Draw d) {
  for (const int j : d.RevoluteJoints()) {
    const double tau = 60.0 * d.LogUniform(8.0, 60.0), size = d.scale * d.random->Normal(0.5 * kTypicalAngle);
    const auto heat = HeatOf(d.design, j, tau);
    d.nature->encoder.push_back({j, [=](const Shot& shot) { return size * heat(shot); }});
  }
  d.effect->target = "robot";
  d.effect->words = "the zero of each joint goes with the heat of its drive, time constants 8 to 60 min";
}

// What a controller adds to a joint, from entries at every `step` of two joints.
struct Table {
  double first_a = 0.0, first_b = 0.0, step = 1.0;  // rad
  bool interpolates = true;
  Eigen::MatrixXd entries;

  double At(double a, double b) const {
    const double x = (a - first_a) / step, y = (b - first_b) / step;
    if (!interpolates) return entries(std::lround(x), std::lround(y));
    const int i = std::clamp(static_cast<int>(x), 0, static_cast<int>(entries.rows()) - 2);
    const int k = std::clamp(static_cast<int>(y), 0, static_cast<int>(entries.cols()) - 2);
    const double u = x - i, v = y - k;
    return (1.0 - u) * ((1.0 - v) * entries(i, k) + v * entries(i, k + 1)) +
           u * ((1.0 - v) * entries(i + 1, k) + v * entries(i + 1, k + 1));
  }
};

Table DrawTable(const Draw& d, int a, int b, double step, bool interpolates) {
  const JointLimits &of_a = d.robot.arm.joints[a], &of_b = d.robot.arm.joints[b];
  Table table{of_a.low, of_b.low, step, interpolates, {}};
  const auto entries = [step](const JointLimits& limits) {
    return 2 + static_cast<int>((limits.high - limits.low) / step);
  };
  table.entries.resize(entries(of_a), entries(of_b));
  for (double& entry : table.entries.reshaped()) entry = d.scale * d.random->Normal(0.5 * kTypicalAngle);
  return table;
}

// The controller still corrects two joints by the table of another arm, or of this one before its gears were changed:
// between the entries along straight lines, or by the nearest.
void CorrectionTable(Draw d) {
  const std::vector<int> joints = d.RevoluteJoints();
  const int first = d.random->Below(static_cast<int>(joints.size()) - 1), a = joints[first], b = joints[first + 1];
  const double step = d.random->Uniform(30.0, 60.0) * kTurn / 360.0;
  const bool interpolates = d.random->Chance(0.5);
  for (const int j : {a, b}) {
    const Table table = DrawTable(d, a, b, step, interpolates);
    d.nature->encoder.push_back({j, [=](const Shot& shot) { return table.At(shot.q[a], shot.q[b]); }});
  }
  d.effect->target = d.Name(a);
  d.effect->words = "table over " + d.Name(a) + " and " + d.Name(b) + ", an entry per " + std::to_string(step) +
                    " rad, " + (interpolates ? "interpolated" : "the nearest");
}

// Robot and instrument stand on one slab, which tilts under the arm's overturning moment: more about one direction
// than about the other. The stand goes with it, from a hinge between the foot and itself.
void SharedSlab(Draw d) {
  const double mass = 3.0 * d.robot.heavy.mass;  // of what moves, at half the way to the flange
  const double typical = mass * kGravity, hinge = d.random->Uniform(0.2, 0.6);
  const Matrix3d aside = SmallTurn(d.random->Uniform(0.0, kTurn) * Vector3d::UnitZ());
  const Vector3d about(1.0, d.random->Uniform(0.3, 1.0), 0.0);
  const Matrix3d softness = d.scale * 0.3 * kTypicalAngle / typical * aside * about.asDiagonal() * aside.transpose();
  const Arm arm = d.nature->arm;
  const auto stations = d.nature->stations;
  const Vector3d load_point = d.nature->load_point;
  d.effect->target = d.design.shots.front().station;
  d.effect->words = "tilts with the slab under the arm's moment, from " + std::to_string(hinge) + " of the way to it";
  d.nature->disturbance = [=](const Shot& shot, const std::string&, const Vector3d& point) -> Vector3d {
    const StationPose& station = stations.at(shot.station);
    const Frame flange = PlaceAsCommanded(arm, shot).flange;
    const Vector3d moment = (0.5 * flange.origin).cross(Vector3d(0.0, 0.0, -mass * kGravity)) +
                            flange.Map(load_point).cross(station.turn.transpose() * shot.force);
    const Vector3d tilt = station.turn * (softness * moment);
    // The stand moves by tilt x (from hinge to stand), and what it sees turns the other way: the foot is at `origin`.
    return -tilt.cross(point - (1.0 - hinge) * station.origin);
  };
}

// The instrument loses its weather station now and then, and computes the wavelength with the standard pressure: the
// air of a cell at an altitude of 500 m is thinner by 60 hPa, at 0.27 ppm each.
void WeatherDropouts(Draw d) {
  const int times = 2 + d.random->Below(3);
  std::vector<std::pair<double, double>> lost;  // s
  std::string words;
  for (int i = 0; i < times; ++i) {
    const double from = d.random->Uniform(0.0, 0.9) * d.Duration(), to = from + d.LogUniform(300.0, 2400.0);
    lost.push_back({from, to});
    words += (i > 0 ? ", " : "") + std::to_string(from) + " to " + std::to_string(to) + " s";
  }
  const double scale = d.scale * 16e-6 * d.random->Sign();
  d.effect->target = d.design.shots.front().station;
  d.effect->words = "without the weather of the cell at " + words;
  d.nature->disturbance = [=](const Shot& shot, const std::string&, const Vector3d& point) -> Vector3d {
    const double t = shot.since_first;
    const bool off = std::any_of(lost.begin(), lost.end(), [t](const auto& l) { return t > l.first && t < l.second; });
    return off ? Vector3d(scale * point) : Vector3d::Zero();
  };
}

// A distance meter that compares phases: crosstalk in its electronics makes an error that repeats with half the
// wavelength of the modulation (0.25 to 2.5 GHz), and reflections one of half that period.
void RangeCycles(Draw d) {
  const double period = d.LogUniform(0.06, 0.6), share = d.random->Uniform(0.0, 0.5);  // m
  const double phase = d.random->Uniform(0.0, kTurn), further = d.random->Uniform(0.0, kTurn);
  const double size = d.scale * kTypicalLength;
  d.effect->target = d.design.shots.front().station;
  d.effect->words = "period " + std::to_string(period) + " m of range, and " + std::to_string(share) + " of it at half";
  d.nature->disturbance = [=](const Shot&, const std::string&, const Vector3d& point) -> Vector3d {
    const double cycles = kTurn * point.norm() / period;
    return size * (std::sin(cycles + phase) + share * std::sin(2.0 * cycles + further)) * point.normalized();
  };
}

// A servo hunts: its integral part builds up until the gear breaks loose, and overshoots. In some configurations the
// joint swings to and fro in seconds, and each reading meets it somewhere on its way.
void HuntingServo(Draw d) {
  const std::vector<int> main = d.MainAxes();
  const int j = main[d.random->Below(static_cast<int>(main.size()))];
  const double chance = d.random->Uniform(0.3, 0.8), size = d.scale * 0.5 * kTypicalAngle;
  std::vector<double> amplitude;
  for (size_t c = 0; c < d.design.arrivals.size(); ++c) {
    amplitude.push_back(d.random->Chance(chance) ? size * d.random->Uniform(0.5, 1.5) : 0.0);
  }
  std::map<std::pair<double, std::string>, double> away;  // rad, by time of the shot and marker
  for (const Shot& shot : d.design.shots) {
    for (const auto& entry : d.nature->markers) {
      away[{shot.time, entry.first}] = amplitude[shot.config] * std::sin(d.random->Uniform(0.0, kTurn));
    }
  }
  const Arm arm = d.nature->arm;
  const auto stations = d.nature->stations;
  d.effect->target = d.Name(j);
  d.effect->words = "swings while it is read, in " + std::to_string(chance) + " of the configurations";
  d.nature->disturbance = [=](const Shot& shot, const std::string& marker, const Vector3d& point) -> Vector3d {
    const auto angle = away.find({shot.time, marker});
    if (angle == away.end()) return Vector3d::Zero();
    const StationPose& station = stations.at(shot.station);
    const Placement placement = PlaceAsCommanded(arm, shot);
    const Vector3d lever = point - station.origin - station.turn * placement.after_joint[j].origin;
    return angle->second * (station.turn * placement.axis[j]).cross(lever);
  };
}

const Makers& All() {
  static const Makers makers = {{"brake_drop", BrakeDrop},       {"bearing_play", BearingPlay},
                                {"shifting_load", ShiftingLoad}, {"soft_tool", SoftTool},
                                {"drive_heat", DriveHeat},       {"correction_table", CorrectionTable},
                                {"shared_slab", SharedSlab},     {"weather_dropouts", WeatherDropouts},
                                {"range_cycles", RangeCycles},   {"hunting_servo", HuntingServo}};
  return makers;
}

}  // namespace

std::vector<std::string> StrangerKinds() { return KindsOf(All()); }

HiddenEffect HideStranger(const std::string& kind, double scale, const RobotKind& robot, const Design& design,
                          Stream* random, Nature* nature) {
  return HideOneOf(All(), kind, scale, robot, design, random, nature);
}

}  // namespace hidden

// A third list of causes outside the catalogue that real robots, cells and trackers have; none is in the other two.
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "tests/hidden_effects/generator/causes.h"

namespace hidden {
namespace {

Vector3d FlangeFromStation(const Draw& d, const Shot& shot) {
  const StationPose& station = d.nature->stations.at(shot.station);
  return station.origin + station.turn * PlaceAsCommanded(d.nature->arm, shot).flange.origin;
}

// A counterbalance with gas on the second axis: a cylinder between an anchor at a and the link's point at l from the
// axis, of length s = sqrt(l^2 + a^2 + 2 l a cos(q - q0)), longest at q0. Pulled out by x = s - (a - l) of at most 2 l
// it presses the gas to p = p0 (1 - fill x / 2 l)^-n, n between isothermal and adiabatic. The gas warms with the arm,
// p0 ~ 273 degC + T, and the seals rub: it pulls more when it was drawn out last than when it was let in. Its torque is
// -F ds/dq, and the joint gives way to it.
void GasBalancer(Draw d) {
  const int j = d.MainAxes()[1];
  const double l = d.random->Uniform(0.15, 0.25), a = d.random->Uniform(0.5, 0.8);  // m
  const double longest = d.random->Uniform(-0.2, 0.2), fill = d.random->Uniform(0.3, 0.6);
  const double exponent = d.random->Uniform(1.0, 1.3), seals = d.random->Uniform(0.03, 0.1);
  const double size = d.scale * kTypicalAngle;
  d.effect->target = d.Name(j);
  d.effect->words = "gas pressed to " + std::to_string(1.0 - fill) + " of its volume, exponent " +
                    std::to_string(exponent) + ", seals rub with " + std::to_string(seals) + " of the force";
  d.nature->encoder.push_back({j, [=](const Shot& shot) {
                                 const double angle = shot.q[j] - longest;
                                 const double length = std::sqrt(l * l + a * a + 2.0 * l * a * std::cos(angle));
                                 const double lever = -l * a * std::sin(angle) / length;  // ds/dq
                                 const double pressed = fill * (length - (a - l)) / (2.0 * l);
                                 const double warm = (273.15 + shot.arm_temperature) / 293.15;
                                 const double rubs = 1.0 + std::copysign(seals, lever * shot.approach[j]);
                                 return -size * warm * rubs * std::pow(1.0 - pressed, -exponent) * lever / l;
                               }});
}

// A gear that gives way at once and then a little more, by share m: m follows the torque T in the time constant tau,
// dm/dt = (T - m) / tau. What hangs on the arm changes halfway between two shots: m remembers the loads and postures
// before.
void CreepingGear(Draw d) {
  const int j = d.MainAxes()[1 + d.random->Below(2)];
  const double tau = d.LogUniform(120.0, 1200.0), own = d.robot.heavy.mass * d.random->Uniform(0.5, 1.5);  // s, kg
  const double softness = d.scale * kTypicalAngle / d.TypicalTorque();                                     // rad/(N m)
  std::map<double, double> creep;  // rad, by the time of the shot
  double remembered = 0.0, torque = 0.0, last = 0.0;
  for (const Shot& shot : d.design.shots) {
    const Placement placement = PlaceAsCommanded(d.nature->arm, shot);
    const Matrix3d base_from_station = d.nature->stations.at(shot.station).turn.transpose();
    const Vector3d middle = 0.5 * (placement.after_joint[j].origin + placement.flange.origin);
    const double before = torque, half = 0.5 * (shot.time - last);
    torque = TorqueOf(placement, j, placement.flange.Map(d.nature->load_point), base_from_station * shot.force) +
             TorqueOf(placement, j, middle, base_from_station * Vector3d(0.0, 0.0, -own * kGravity));
    if (creep.empty()) remembered = torque;
    if (!creep.empty()) {
      const double kept = std::exp(-half / tau);
      remembered = before + (remembered - before) * kept;
      remembered = torque + (remembered - torque) * kept;
    }
    creep[shot.time] = softness * remembered;
    last = shot.time;
  }
  d.effect->target = d.Name(j);
  d.effect->words = "creeps under torque, time constant " + std::to_string(tau) + " s";
  d.nature->encoder.push_back({j, [=](const Shot& shot) { return creep.at(shot.time); }});
}

// The shrink disc between a gear and the link slips when the drive stops the arm from full speed: by what the torque
// of the stop, J times the deceleration, is beyond its hold, and the way the arm was going. J ~ r^2, r of the flange
// from the axis. The drive stops like that at the turning point; the short way from there is slow.
void SlippingClamp(Draw d) {
  const std::vector<int> main = d.MainAxes();
  const int j = main[d.random->Below(static_cast<int>(main.size()))];
  const double holds = d.random->Uniform(0.3, 0.8), size = 0.4 * d.scale * kTypicalAngle;  // of the mean J
  std::vector<double> inertia;                                                             // m^2
  double mean = 0.0;
  for (const VectorXd& turning : d.design.turning_points) {
    const Placement placement = PlaceAt(d.nature->arm, turning);
    inertia.push_back(placement.axis[j].cross(placement.flange.origin - placement.after_joint[j].origin).squaredNorm());
    mean += inertia.back() / static_cast<double>(d.design.turning_points.size());
  }
  std::vector<double> slipped = {0.0};
  for (size_t c = 1; c < inertia.size(); ++c) {
    const double way = d.design.turning_points[c][j] - d.design.arrivals[c - 1][j];
    const double beyond = std::max(0.0, inertia[c] / mean - holds);
    slipped.push_back(slipped.back() + std::copysign(size * beyond, way));
  }
  d.effect->target = d.Name(j);
  d.effect->words = "slips at each stop from full speed, holds " + std::to_string(holds) + " of the mean inertia";
  d.nature->encoder.push_back({j, [=](const Shot& shot) { return slipped[shot.config]; }});
}

// The controller says that it has arrived when its interpolator has; the integral parts of the drives make up the
// rest of the following error in their time constants tau. Each joint is short of its goal, on the side it came from,
// by e exp(-t / tau); the markers of a shot are read one after the other, at equal gaps from the arrival on.
void SlowTail(Draw d) {
  const std::vector<double> arrived = Arrivals(d.design);
  const double gap = d.random->Uniform(4.0, 12.0);  // s
  std::map<int, std::pair<double, double>> tails;   // rad, s
  for (const int j : d.RevoluteJoints()) {
    const double size = d.scale * kTypicalAngle * d.random->Uniform(0.3, 1.0), tau = d.LogUniform(5.0, 40.0);
    tails[j] = {size, tau};
  }
  std::map<std::string, double> later;  // s
  for (const auto& entry : d.nature->markers) later[entry.first] = gap * static_cast<double>(later.size());
  const Arm arm = d.nature->arm;
  const auto stations = d.nature->stations;
  d.effect->target = "robot";
  d.effect->words =
      "joints still settle when they are read, time constants 5 to 40 s, a marker per " + std::to_string(gap) + " s";
  d.nature->disturbance = [=](const Shot& shot, const std::string& marker, const Vector3d& point) -> Vector3d {
    const StationPose& station = stations.at(shot.station);
    const Placement placement = PlaceAsCommanded(arm, shot);
    const double since = shot.since_first - arrived[shot.config] + later.at(marker);
    Vector3d moved = Vector3d::Zero();
    for (const auto& [j, tail] : tails) {
      const double angle = -shot.approach[j] * tail.first * std::exp(-since / tail.second);
      const Vector3d lever = point - station.origin - station.turn * placement.after_joint[j].origin;
      moved += angle * (station.turn * placement.axis[j]).cross(lever);
    }
    return moved;
  };
}

// The tool's cables hang on a spring balancer under the ceiling, which pulls the flange towards its hook: a force that
// is nearly the same at every length of the rope, F (1 + rise (s / mean - 1)), and more when the drum was drawn out
// last than when it wound up. The joints give way as to a load.
void ToolBalancer(Draw d) {
  const Arm arm = d.nature->arm;
  double reach = 0.0;
  for (const VectorXd& q : d.design.arrivals) reach = std::max(reach, PlaceAt(arm, q).flange.origin.norm());
  const double heading = d.random->Uniform(0.0, kTurn), aside = d.random->Uniform(0.2, 0.6);
  const double height = d.random->Uniform(1.1, 1.5);
  const Vector3d hook = reach * (aside * Horizontal(heading) + height * Vector3d::UnitZ());
  const double rise = d.random->Uniform(0.0, 0.3), drum = d.random->Uniform(0.05, 0.15);
  const double typical = d.scale * 0.1 * d.robot.heavy.mass * kGravity;  // N
  std::vector<double> rope, tension;                                     // m, N
  double mean = 0.0;
  for (const VectorXd& q : d.design.arrivals) {
    rope.push_back((hook - PlaceAt(arm, q).flange.origin).norm());
    mean += rope.back() / static_cast<double>(d.design.arrivals.size());
  }
  for (size_t c = 0; c < rope.size(); ++c) {
    const double before = (hook - PlaceAt(arm, d.design.turning_points[c]).flange.origin).norm();
    tension.push_back(typical * (1.0 + rise * (rope[c] / mean - 1.0)) * (1.0 + std::copysign(drum, rope[c] - before)));
  }
  d.effect->target = "flange";
  d.effect->words = "pulled to a hook " + std::to_string(hook.z()) + " m high, by " + std::to_string(typical) +
                    " N, the drum rubs with " + std::to_string(drum) + " of it";
  for (const int j : d.RevoluteJoints()) {
    const double compliance = d.robot.compliance[j];
    d.nature->encoder.push_back({j, [=](const Shot& shot) {
                                   const Placement placement = PlaceAsCommanded(arm, shot);
                                   const Vector3d at = placement.flange.origin;
                                   const Vector3d force = tension[shot.config] * (hook - at).normalized();
                                   return compliance * TorqueOf(placement, j, at, force);
                                 }});
  }
}

// The faces of a tool changer part where the moment across it, of tool and load, is more than its piston holds:
// by the angle c (|m| - m0) about the moment, over the edge that stays in contact. The piston's air comes from a tank
// whose pressure sags until its compressor starts again: m0 falls by a part of itself in each cycle.
void LiftingCoupling(Draw d) {
  const Vector3d out = Vector3d::Unit(d.robot.arm.AxisOf(d.robot.arm.size() - 1)), load_point = d.nature->load_point;
  const double typical = d.TypicalTorque() * load_point.norm(), edge = 0.4 * load_point.norm();  // N m, m
  const double holds = typical * d.random->Uniform(0.3, 0.7), own = d.robot.heavy.mass * d.random->Uniform(0.1, 0.3);
  const double sags = d.random->Uniform(0.1, 0.4), period = d.LogUniform(300.0, 1500.0),
               phase = d.random->Uniform(0, 1);
  const double softness = d.scale * 3.0 * kTypicalAngle / typical;  // rad/(N m)
  const Arm arm = d.nature->arm;
  const auto stations = d.nature->stations;
  const std::map<std::string, Vector3d> markers = d.nature->markers;
  d.effect->target = "flange";
  d.effect->words = "parts from " + std::to_string(holds) + " N m, less by " + std::to_string(sags) +
                    " at the end of each " + std::to_string(period) + " s";
  d.nature->seats.push_back([=](const Shot& shot, const std::string& marker) -> Vector3d {
    const Matrix3d base_from_station = stations.at(shot.station).turn.transpose();
    const Vector3d force = shot.force + Vector3d(0.0, 0.0, -own * kGravity);
    Vector3d across =
        load_point.cross(PlaceAsCommanded(arm, shot).flange.turn.transpose() * (base_from_station * force));
    across -= out.dot(across) * out;
    const double cycles = shot.since_first / period + phase;
    const double beyond = across.norm() - holds * (1.0 - sags * (cycles - std::floor(cycles)));
    if (beyond <= 0.0) return Vector3d::Zero();
    const Vector3d tilt = softness * beyond * across.normalized();
    return tilt.cross(markers.at(marker)) + edge * tilt.norm() * out;
  });
}

// Two balls whose centres are not equally high above their nests. The operator cleans them now and then, and may put
// each into the other's nest: one centre goes up along the axis of its nest, the other down along its own, until the
// next time. Where there is one nest alone, the other ball is a spare.
void SwappedBalls(Draw d) {
  const int n = static_cast<int>(d.nature->markers.size());
  const int first = d.random->Below(n), further = n > 1 ? 1 + d.random->Below(n - 1) : 0;
  const std::string one = std::next(d.nature->markers.begin(), first)->first;
  const std::string other = std::next(d.nature->markers.begin(), (first + further) % n)->first;
  const double higher = d.scale * 2.0 * kTypicalLength;
  const Vector3d axis_of_one = d.random->Direction(), axis_of_other = d.random->Direction();
  const int times = 2 + d.random->Below(3);
  std::vector<double> swaps;  // s
  std::string words;
  for (int i = 0; i < times; ++i) {
    swaps.push_back((i + d.random->Uniform(0.2, 0.9)) / times * d.Duration());
    words += (i > 0 ? ", " : "") + std::to_string(swaps.back());
  }
  d.effect->target = one;
  d.effect->words = "changes its ball with " + other + " at " + words + " s";
  d.nature->seats.push_back([=](const Shot& shot, const std::string& marker) -> Vector3d {
    int done = 0;
    for (const double at : swaps) done += shot.since_first > at ? 1 : 0;
    if (done % 2 == 0) return Vector3d::Zero();
    if (marker == one) return higher * axis_of_one;
    return marker == other ? Vector3d(-higher * axis_of_other) : Vector3d::Zero();
  });
}

// An instrument that is read in one face only, and not always in the same: the arm hides the target when its first
// axis turns far, and the instrument plunges on its search. Its ray is off the transit axis' normal by c, that axis
// off the normal of the standing axis by i, the index of the vertical circle by e: in face f = +1 or -1 it reads the
// azimuth off by f (c / cos E + i tan E), and the elevation by f e.
void TwoFaces(Draw d) {
  const double typical = d.scale * kTypicalLength / 3.0;  // rad: at a range of 3 m
  double error[3];
  for (double& angle : error) {
    const double sign = d.random->Sign();
    angle = typical * sign * d.random->Uniform(0.5, 1.5);
  }
  const double c = error[0], i = error[1], e = error[2], far = d.random->Uniform(1.0, 2.5);
  const int j = d.MainAxes().front();
  std::vector<double> face = {1.0};
  for (size_t k = 1; k < d.design.arrivals.size(); ++k) {
    const bool hidden = std::abs(d.design.arrivals[k][j] - d.design.arrivals[k - 1][j]) > far;
    face.push_back(hidden ? -face.back() : face.back());
  }
  d.effect->target = d.design.shots.front().station;
  d.effect->words = "collimation " + std::to_string(c / kMicro) + ", axis " + std::to_string(i / kMicro) + ", index " +
                    std::to_string(e / kMicro) + " urad, plunges when " + d.Name(j) + " turns by " +
                    std::to_string(far) + " rad";
  d.nature->disturbance = [=](const Shot& shot, const std::string&, const Vector3d& point) -> Vector3d {
    const Vector3d left = Horizontal(AzimuthOf(point) + 0.25 * kTurn), ray = point.normalized();
    const double azimuth_times_cosine = c + i * ray.z();
    return face[shot.config] * point.norm() * (azimuth_times_cosine * left + e * ray.cross(left));
  };
}

// Warm air rises in a sheet above the vents of a cabinet or an oven, between instrument and arm. Its index of
// refraction has a trough there, a Gaussian across the sheet, and rays bend by its slope: by b u exp((1 - u^2) / 2) to
// the side, u the azimuth off the sheet's middle over its half width. A point beyond it at r, the sheet at s, seems
// to lie aside by the bend times r - s. Ten degrees over 0.2 m make b about 10 urad.
void WarmSheet(Draw d) {
  const Shot& middle = d.design.shots[d.random->Below(static_cast<int>(d.design.shots.size()))];
  const Vector3d seen = FlangeFromStation(d, middle);
  const double at = AzimuthOf(seen), distance = seen.norm() * d.random->Uniform(0.3, 0.7);
  const double half_width = d.random->Uniform(0.1, 0.3) / distance;  // rad
  const double bend = d.scale * 2.0 * kTypicalLength / (seen.norm() - distance);
  const std::string station = middle.station;
  d.effect->target = station;
  d.effect->words = "sheet at azimuth " + std::to_string(at) + " rad, half as wide as " + std::to_string(half_width) +
                    " rad, " + std::to_string(distance) + " m away, bends by " + std::to_string(bend / kMicro) +
                    " urad";
  d.nature->disturbance = [=](const Shot& shot, const std::string&, const Vector3d& point) -> Vector3d {
    const double beyond = point.norm() - distance;
    if (shot.station != station || beyond <= 0.0) return Vector3d::Zero();
    const double u = std::remainder(AzimuthOf(point) - at, kTurn) / half_width;
    return bend * u * std::exp(0.5 * (1.0 - u * u)) * beyond * Horizontal(AzimuthOf(point) + 0.25 * kTurn);
  };
}

// A furnace next to the cell, or the sun through a gate: each link is warmer on the side that faces it, grows there
// and bends away. Along a, with the part s across a of the direction g to the furnace, its end turns by c (s x a), of
// about alpha dT L / h; heat needs tau to go through the casting, d(bend)/dt = (c (s x a) - bend) / tau. s turns with
// the arm, which stays in a configuration until it arrives in the next. The furnace opens with the first shot.
void RadiantHeat(Draw d) {
  const Arm arm = d.nature->arm;
  const std::vector<double> arrived = Arrivals(d.design);
  const double heading = d.random->Uniform(0.0, kTurn), height = d.random->Uniform(-0.2, 0.5);
  const Vector3d furnace = (Horizontal(heading) + height * Vector3d::UnitZ()).normalized();  // base frame
  const double tau = 60.0 * d.LogUniform(5.0, 30.0);
  struct Link {
    std::vector<Vector3d> goal, bend;  // rad, by configuration; the latter on arrival
  };
  std::map<int, Link> links;
  const Placement zero = PlaceAt(arm, VectorXd::Zero(arm.size()));
  for (int j = 0; j + 1 < arm.size(); ++j) {
    const Vector3d link = zero.after_joint[j + 1].origin - zero.after_joint[j].origin;
    if (arm.joints[j].prismatic || link.norm() < 0.2) continue;
    const Vector3d along = zero.after_joint[j].turn.transpose() * link.normalized();
    const double size = d.scale * kTypicalAngle * d.random->Uniform(0.5, 1.5);
    Vector3d bend = Vector3d::Zero();
    for (size_t c = 0; c < arrived.size(); ++c) {
      const Vector3d facing = PlaceAt(arm, d.design.arrivals[c]).after_joint[j].turn.transpose() * furnace;
      if (c > 0) {
        const Vector3d& before = links[j].goal.back();
        bend = before + (bend - before) * std::exp((arrived[c - 1] - arrived[c]) / tau);
      }
      links[j].goal.push_back(size * facing.cross(along));
      links[j].bend.push_back(bend);
    }
  }
  d.effect->target = "robot";
  d.effect->words = "links bend away from a furnace, time constant " + std::to_string(tau) + " s";
  d.nature->warp = [=](const Shot& shot, int link) -> Vector3d {
    const auto found = links.find(link);
    if (found == links.end()) return Vector3d::Zero();
    const Vector3d &goal = found->second.goal[shot.config], &bend = found->second.bend[shot.config];
    return goal + (bend - goal) * std::exp((arrived[shot.config] - shot.since_first) / tau);
  };
}

const Makers& All() {
  static const Makers makers = {{"gas_balancer", GasBalancer},     {"creeping_gear", CreepingGear},
                                {"slipping_clamp", SlippingClamp}, {"slow_tail", SlowTail},
                                {"tool_balancer", ToolBalancer},   {"lifting_coupling", LiftingCoupling},
                                {"swapped_balls", SwappedBalls},   {"two_faces", TwoFaces},
                                {"warm_sheet", WarmSheet},         {"radiant_heat", RadiantHeat}};
  return makers;
}

}  // namespace

std::vector<std::string> NewcomerKinds() { return KindsOf(All()); }

HiddenEffect HideNewcomer(const std::string& kind, double scale, const RobotKind& robot, const Design& design,
                          Stream* random, Nature* nature) {
  return HideOneOf(All(), kind, scale, robot, design, random, nature);
}

}  // namespace hidden

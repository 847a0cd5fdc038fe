// A fourth list of causes outside the catalogue that real robots, cells and trackers have; none is in the other three.
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "tests/hidden_effects/generator/causes.h"

namespace hidden {
namespace {

// About a joint: by the stated force at the load point, and by what the arm itself weighs beyond the joint, halfway
// between it and the flange.
struct Pulls {
  Arm arm;
  std::map<std::string, StationPose> stations;
  Vector3d load_point;
  double own;  // kg

  Pulls(const Draw& d, double of_heavy)
      : arm(d.nature->arm),
        stations(d.nature->stations),
        load_point(d.nature->load_point),
        own(of_heavy * d.robot.heavy.mass) {}

  double Torque(const Shot& shot, int joint) const {
    const Placement placement = PlaceAsCommanded(arm, shot);
    const Matrix3d base_from_station = stations.at(shot.station).turn.transpose();
    const Vector3d middle = 0.5 * (placement.after_joint[joint].origin + placement.flange.origin);
    return TorqueOf(placement, joint, placement.flange.Map(load_point), base_from_station * shot.force) +
           TorqueOf(placement, joint, middle, base_from_station * Vector3d(0.0, 0.0, -own * kGravity));
  }
};

// Configurations at whose arrival something is changed by hand, in order: one in each of `times` equal parts.
std::vector<int> Changes(const Draw& d, int times) {
  std::vector<int> changes;
  for (int i = 0; i < times; ++i) {
    const double part = (i + d.random->Uniform(0.2, 0.9)) / times;
    changes.push_back(std::max(1, static_cast<int>(part * d.Configurations())));
  }
  return changes;
}

// How many of them were before.
int Epoch(const std::vector<int>& changes, int config) {
  return static_cast<int>(std::count_if(changes.begin(), changes.end(), [=](int at) { return at <= config; }));
}

std::string TimesOf(const Draw& d, const std::vector<int>& changes) {
  const std::vector<double> arrived = Arrivals(d.design);
  std::string words;
  for (const int at : changes) words += (words.empty() ? "" : ", ") + std::to_string(arrived[at]);
  return words + " s";
}

// A gear that has done one task for years is worn where the task was: in a sector about c of half width w it has play,
// half the gap h exp(-((q - c) / w)^4). The link lies at the end to which it is pushed: by the torque T, against the
// friction F of the last motion, sign(T - F approach). New reducers have a lost motion of up to 1 arc minute, 290 urad
// (Nabtesco RV); worn ones are renewed at some of these.
void WornSector(Draw d) {
  const int j = RevoluteJoint(d.robot, d.random);
  const JointLimits& limits = d.robot.arm.joints[j];
  const double centre = limits.low + d.random->Uniform(0.25, 0.75) * (limits.high - limits.low);
  const double half_width = d.random->Uniform(0.1, 0.2) * (limits.high - limits.low);
  const double friction = d.TypicalTorque() * d.random->Uniform(0.05, 0.2), half_gap = d.scale * kTypicalAngle;
  const Pulls pulls(d, d.random->Uniform(0.5, 1.5));
  d.effect->target = d.Name(j);
  d.effect->words = "play about " + std::to_string(centre) + " rad, half as wide as " + std::to_string(half_width) +
                    " rad, friction " + std::to_string(friction) + " N m";
  d.nature->encoder.push_back({j, [=](const Shot& shot) {
                                 const double worn = std::exp(-std::pow((shot.q[j] - centre) / half_width, 4));
                                 const double push = pulls.Torque(shot, j) - friction * shot.approach[j];
                                 return std::copysign(half_gap * worn, push);
                               }});
}

// A hollow wrist drives its last two joints by shafts one inside the other, in the same bearings: the torque about one
// winds up the other too. Each turns by k times the torque about the other, the same k both ways (Maxwell), and smaller
// than the root of the product of their own compliances, or the wrist could not stand.
void WristWindup(Draw d) {
  const int b = d.robot.arm.size() - 1, a = b - 1;
  const double bound = std::sqrt(d.robot.compliance[a] * d.robot.compliance[b]);
  const double sign = d.random->Sign(), share = d.random->Uniform(0.05, 0.15);
  const double k = d.scale * sign * share * bound;  // rad/(N m)
  const Pulls pulls(d, d.random->Uniform(0.2, 0.5));
  d.effect->target = d.Name(a);
  d.effect->words = "winds up with " + d.Name(b) + ", " + std::to_string(k / kMicro) + " urad/(N m) both ways";
  d.nature->encoder.push_back({a, [=](const Shot& shot) { return k * pulls.Torque(shot, b); }});
  d.nature->encoder.push_back({b, [=](const Shot& shot) { return k * pulls.Torque(shot, a); }});
}

// One anchor of the base plate is loose. Where the arm leans away from it, the plate lifts there as soon as the moment
// M over the far edge is more than the robot's own weight holds down, m0: tilt c (M - m0), else none.
void RockingFoot(Draw d) {
  const Pulls pulls(d, 3.0);
  const Vector3d towards = PlaceAt(pulls.arm, d.design.arrivals[d.random->Below(d.Configurations())]).flange.origin;
  const Vector3d over = Vector3d::UnitZ().cross(Horizontal(AzimuthOf(towards)));
  const auto moment = [=](const Shot& shot) {
    const Frame flange = PlaceAsCommanded(pulls.arm, shot).flange;
    const Vector3d force = pulls.stations.at(shot.station).turn.transpose() * shot.force;
    const Vector3d of_arm = (0.5 * flange.origin).cross(Vector3d(0.0, 0.0, -pulls.own * kGravity));
    return over.dot(of_arm + flange.Map(pulls.load_point).cross(force));
  };
  double largest = 0.0;
  for (const Shot& shot : d.design.shots) largest = std::max(largest, moment(shot));
  const double holds = largest * d.random->Uniform(0.1, 0.4);
  const double softness = d.scale * kTypicalAngle / largest;  // rad/(N m)
  d.effect->target = "base";
  d.effect->words = "lifts from " + std::to_string(holds) + " N m towards azimuth " +
                    std::to_string(AzimuthOf(towards)) + " rad of the base";
  d.nature->floor = [=](const Shot& shot) -> Vector3d { return softness * std::max(0.0, moment(shot) - holds) * over; };
}

// A motor spindle on the flange runs between the measurements and stands in between: its heat is dh/dt = (r - h) / tau,
// r = 1 where it runs, else 0. It pushes its nose out by 25 to 40 um in the 15 to 30 min of a warm-up, its steel
// (12e-6/K) grows about the axis by 180e-6 at 15 K, and it tilts by 50 urad as its sides are not equally warm (Grama
// et al., Procedia CIRP 58, 2017). The markers sit on it.
void SpindleHeat(Draw d) {
  const double tau = d.LogUniform(300.0, 1200.0), size = d.scale * kTypicalLength;  // s, m
  std::vector<double> switches;                                                     // s: on, off, on, ...
  std::string words;
  for (double t = d.random->Uniform(0.0, 900.0); t < d.Duration(); t += d.random->Uniform(900.0, 2700.0)) {
    switches.push_back(t);
    words += (words.empty() ? "" : ", ") + std::to_string(t);
  }
  const Vector3d out = Vector3d::Unit(d.robot.arm.AxisOf(d.robot.arm.size() - 1));
  const Vector3d aside = out.cross(d.random->Direction()).normalized(), tilt = d.scale * 50e-6 * aside;
  const double growth = d.scale * 180e-6;
  const auto heat = [=](double t) {
    double h = 0.0;
    for (size_t i = 0; i < switches.size() && switches[i] < t; ++i) {
      const double until = i + 1 < switches.size() ? std::min(t, switches[i + 1]) : t;
      const double tends_to = i % 2 == 0 ? 1.0 : 0.0;
      h = tends_to + (h - tends_to) * std::exp((switches[i] - until) / tau);
    }
    return h;
  };
  const std::map<std::string, Vector3d> markers = d.nature->markers;
  d.effect->target = "flange";
  d.effect->words = "a spindle, time constant " + std::to_string(tau) + " s, is turned on and off at " + words + " s";
  d.nature->seats.push_back([=](const Shot& shot, const std::string& marker) -> Vector3d {
    const Vector3d& at = markers.at(marker);
    const Vector3d whole = size * out + growth * (at - out.dot(at) * out) + tilt.cross(at);
    return heat(shot.since_first) * whole;
  });
}

// The tool is removed two to four times and put back on, and lies elsewhere within the clearance of its dowels, 5 to
// 29 um for H7/g6 at 10 mm (ISO 286), and as its face lies on a chip: 10 um over 100 mm make 100 urad.
void ReseatedTool(Draw d) {
  const int times = 2 + d.random->Below(3);
  const std::vector<int> changes = Changes(d, times);
  std::vector<Vector3d> shift = {Vector3d::Zero()}, tilt = {Vector3d::Zero()};
  for (int i = 0; i < times; ++i) {
    shift.push_back(d.random->NormalVector(d.scale * 0.5 * kTypicalLength));
    tilt.push_back(d.random->NormalVector(d.scale * 0.5 * kTypicalAngle));
  }
  const std::map<std::string, Vector3d> markers = d.nature->markers;
  d.effect->target = "flange";
  d.effect->words = "put on again at " + TimesOf(d, changes);
  d.nature->seats.push_back([=](const Shot& shot, const std::string& marker) -> Vector3d {
    const int epoch = Epoch(changes, shot.config);
    return shift[epoch] + tilt[epoch].cross(markers.at(marker));
  });
}

// The load hangs on a chain and still swings when it is read: at the angle a it pulls aside by its weight times a, and
// the joints give way. 5 mm on a metre of chain are 5 mrad. It swings to and fro in about two seconds, in a plane of
// each shot's own, and each reading meets it somewhere on its way.
void SwingingLoad(Draw d) {
  std::map<std::pair<double, std::string>, Vector3d> aside;  // by time of the shot and marker; rad, measurement frame
  for (const Shot& shot : d.design.shots) {
    const double heading = d.random->Uniform(0.0, kTurn), size = d.scale * 5e-3 * d.random->Uniform(0.3, 1.5);
    for (const auto& entry : d.nature->markers) {
      const double phase = d.random->Uniform(0.0, kTurn);
      aside[{shot.time, entry.first}] = size * std::sin(phase) * Horizontal(heading);
    }
  }
  const Pulls pulls(d, 0.0);
  const std::vector<int> joints = d.RevoluteJoints();
  const VectorXd compliance = d.robot.compliance;
  d.effect->target = "loads";
  d.effect->words = "swing while they are read";
  d.nature->disturbance = [=](const Shot& shot, const std::string& marker, const Vector3d& point) -> Vector3d {
    const auto angle = aside.find({shot.time, marker});
    if (angle == aside.end() || shot.force.z() >= 0.0) return Vector3d::Zero();
    const StationPose& station = pulls.stations.at(shot.station);
    const Placement placement = PlaceAsCommanded(pulls.arm, shot);
    const Vector3d pull = station.turn.transpose() * (-shot.force.z() * angle->second);  // base frame
    const Vector3d seen = station.turn.transpose() * (point - station.origin);
    Vector3d moved = Vector3d::Zero();
    for (const int j : joints) {
      const double turn = compliance[j] * TorqueOf(placement, j, placement.flange.Map(pulls.load_point), pull);
      moved += turn * placement.axis[j].cross(seen - placement.after_joint[j].origin);
    }
    return station.turn * moved;
  };
}

// The bearings of a turning head drag its stand along, and the stand stays where it was dragged until the head turns
// back: of its full twist a it has s, ds = (sign - s) |d azimuth| / w, and azimuths read too little by a s. 0.3 um
// between the plates of a tribrach are 1 arc second, 5 urad, and good ones come back to 1 to 3 of them (Nindl,
// Surveying Tribrachs, Leica 2010). The readings follow each other by shot and marker.
void StandTwist(Draw d) {
  const double twist = d.scale * kTypicalLength / 3.0, width = d.LogUniform(0.1, 1.0);  // rad; 10 urad at the scale 1
  std::map<std::pair<double, std::string>, double> twisted;  // by time of the shot and marker
  std::map<std::string, std::pair<double, double>> last;     // azimuth and s, by station
  for (const Shot& shot : d.design.shots) {
    const StationPose& station = d.nature->stations.at(shot.station);
    const Frame flange = PlaceAsCommanded(d.nature->arm, shot).flange;
    for (const auto& [marker, on_flange] : d.nature->markers) {
      const double azimuth = AzimuthOf(station.origin + station.turn * flange.Map(on_flange));
      auto& [before, s] = last.insert({shot.station, {azimuth, 0.0}}).first->second;
      const double turned = std::remainder(azimuth - before, kTurn), sign = std::copysign(1.0, turned);
      s = sign + (s - sign) * std::exp(-std::abs(turned) / width);
      before = azimuth;
      twisted[{shot.time, marker}] = twist * s;
    }
  }
  d.effect->target = d.design.shots.front().station;
  d.effect->words = "twists by " + std::to_string(twist / kMicro) + " urad over " + std::to_string(width) + " rad";
  d.nature->disturbance = [=](const Shot& shot, const std::string& marker, const Vector3d& point) -> Vector3d {
    const auto found = twisted.find({shot.time, marker});
    if (found == twisted.end()) return Vector3d::Zero();
    return -found->second * Vector3d::UnitZ().cross(point);
  };
}

// The software brings all points to 20 degC, as if a workpiece was measured: by its coefficient of expansion, 1e-6/K of
// carbon fibre to 23.6e-6/K of aluminium, and its temperature, which is typed in at the start and three to five times
// later on, from the thermometer in the air. Points shrink towards the instrument by 1 - alpha (T - 20 degC).
void ThermalScaling(Draw d) {
  const double alpha = d.scale * 3e-6;  // 1/K
  const int times = 3 + d.random->Below(3);
  const std::vector<int> changes = Changes(d, times);
  std::vector<double> typed;  // degC
  for (const Shot& shot : d.design.shots) {
    if (typed.empty() || Epoch(changes, shot.config) == static_cast<int>(typed.size())) typed.push_back(shot.air);
  }
  d.effect->target = d.design.shots.front().station;
  d.effect->words = "scaled to 20 degC by " + std::to_string(alpha / kMicro) + " ppm/K, the temperature typed in at " +
                    TimesOf(d, changes);
  d.nature->disturbance = [=](const Shot& shot, const std::string&, const Vector3d& point) -> Vector3d {
    return -alpha * (typed[Epoch(changes, shot.config)] - 20.0) * point;
  };
}

// A pallet next to the robot is filled part by part and then removed: the floor tilts towards it by what stands
// there, a saw in time. A slab of h = 0.2 m of concrete (E = 30 GPa, nu = 0.15) on ground of k = 50 MPa/m has the
// length l = (E h^3 / 12 (1 - nu^2) k)^(1/4) = 0.8 m and at the distance l from a weight P the slope P / (8 k l^3) 4/pi
// |kei'(1)|: 22 urad for a ton (Westergaard).
void StackedPallet(Draw d) {
  const double fills = d.LogUniform(900.0, 3600.0), phase = d.random->Uniform(0.0, 1.0);
  const Vector3d over = Vector3d::UnitZ().cross(Horizontal(d.random->Uniform(0.0, kTurn)));
  const Vector3d full = d.scale * 22e-6 * over;
  d.effect->target = "base";
  d.effect->words =
      "tilts towards a pallet, filled in " + std::to_string(fills) + " s, at first by " + std::to_string(phase);
  d.nature->floor = [=](const Shot& shot) -> Vector3d {
    const double filled = shot.since_first / fills + phase;
    return (filled - std::floor(filled)) * full;
  };
}

// A controller with an elastic model of the arm turns the joints against the deflection by the load whose number is
// chosen on the pendant, compliance times torque, and does not show it in the joint values. The numbers of other jobs
// are left chosen, none at first: grippers of up to a tenth of the largest load.
void LoadNumber(Draw d) {
  const int times = 2 + d.random->Below(3);
  const std::vector<int> changes = Changes(d, times);
  std::vector<double> mass = {0.0};                       // kg
  std::vector<Vector3d> centre = {d.nature->load_point};  // m, flange frame
  for (int i = 0; i < times; ++i) {
    const double of_heavy = i % 2 == 0 ? d.random->Uniform(0.03, 0.1) : d.random->Uniform(0.0, 0.03);
    mass.push_back(d.scale * of_heavy * d.robot.heavy.mass);
    centre.push_back(d.nature->load_point + d.random->NormalVector(0.3 * d.Reach()));
  }
  const Pulls pulls(d, 0.0);
  d.effect->target = "robot";
  d.effect->words = "the controller corrects for loads that are not there, chosen at " + TimesOf(d, changes);
  for (const int j : d.RevoluteJoints()) {
    const double compliance = d.robot.compliance[j];
    d.nature->encoder.push_back({j, [=](const Shot& shot) {
                                   const int epoch = Epoch(changes, shot.config);
                                   const Placement placement = PlaceAsCommanded(pulls.arm, shot);
                                   const Vector3d at = placement.flange.Map(centre[epoch]);
                                   const Vector3d weight(0.0, 0.0, -mass[epoch] * kGravity);
                                   return -compliance * TorqueOf(placement, j, at, weight);
                                 }});
  }
}

const Makers& All() {
  static const Makers makers = {{"worn_sector", WornSector},       {"wrist_windup", WristWindup},
                                {"rocking_foot", RockingFoot},     {"spindle_heat", SpindleHeat},
                                {"reseated_tool", ReseatedTool},   {"swinging_load", SwingingLoad},
                                {"stand_twist", StandTwist},       {"thermal_scaling", ThermalScaling},
                                {"stacked_pallet", StackedPallet}, {"load_number", LoadNumber}};
  return makers;
}

}  // namespace

std::vector<std::string> LatecomerKinds() { return KindsOf(All()); }

HiddenEffect HideLatecomer(const std::string& kind, double scale, const RobotKind& robot, const Design& design,
                           Stream* random, Nature* nature) {
  return HideOneOf(All(), kind, scale, robot, design, random, nature);
}

}  // namespace hidden

// Causes outside the catalogue that real robots, cells and trackers have.
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "tests/hidden_effects/generator/causes.h"

namespace hidden {
namespace {

// Values of single readings, drawn once: by time of the shot and marker.
using Readings = std::map<std::pair<double, std::string>, Vector3d>;

// A screw has lost its preload: the part slides to the other end of its hole where the weight along the hole is more
// than friction holds. Ends by configuration, 0 or 1; slot in the flange frame.
std::vector<int> EndsByGravity(const Draw& d, const Vector3d& slot, double grip) {
  std::vector<int> ends(d.Configurations(), 0);
  int end = 0;
  for (const Shot& shot : d.design.shots) {
    Posture posture(d.robot.arm.size());
    posture.values = shot.q;
    const Vector3d down = -d.nature->stations.at(shot.station).turn.row(2).transpose();  // base frame
    const double along = slot.dot(Place(d.nature->arm, posture).flange.turn.transpose() * down);
    if (std::abs(along) > grip) end = along > 0.0 ? 1 : 0;
    ends[shot.config] = end;
  }
  return ends;
}

// Or it jumps when the arm passes a shock on the way to a configuration.
std::vector<int> EndsAtRandom(const Draw& d, double chance) {
  std::vector<int> ends;
  int end = 0;
  for (int c = 0; c < d.Configurations(); ++c) {
    if (d.random->Chance(chance)) end = 1 - end;
    ends.push_back(end);
  }
  return ends;
}

// A loose bolt: a marker's nest, or the flange plate with all of them, has two seats. The plate tilts as well.
void LooseBolt(Draw d) {
  const bool plate = d.random->Chance(0.5), by_gravity = d.random->Chance(0.5);
  const Vector3d slot = d.random->Direction();
  const double grip = d.random->Uniform(0.1, 0.5), chance = d.random->Uniform(0.1, 0.3);
  const Vector3d shift = d.scale * 2.0 * kTypicalLength * slot;
  const Vector3d tilt = d.scale * kTypicalAngle * d.random->Direction();
  const std::string loose = d.Marker();
  const std::vector<int> ends = by_gravity ? EndsByGravity(d, slot, grip) : EndsAtRandom(d, chance);
  const std::map<std::string, Vector3d> markers = d.nature->markers;
  d.effect->target = plate ? "flange" : loose;
  d.effect->words = by_gravity ? "two seats by gravity" : "two seats at random visits";
  d.nature->seats.push_back([=](const Shot& shot, const std::string& marker) -> Vector3d {
    if (ends[shot.config] == 0 || (!plate && marker != loose)) return Vector3d::Zero();
    return plate ? Vector3d(shift + tilt.cross(markers.at(marker))) : shift;
  });
}

// Teeth that come into contact one after the other: lost motion without corners, off zero by the weight of the links
// that keeps one flank pressed, and with friction in the gear, which holds a part of the torque of the last motion.
void SoftLostMotion(Draw d) {
  const int j = RevoluteJoint(d.robot, d.random);
  const double torque = d.robot.heavy.mass * kGravity;  // N m at 1 m
  const double width = torque * d.LogUniform(0.05, 0.3), pressed = torque * d.random->Uniform(-0.2, 0.2);
  const double friction = torque * d.random->Uniform(0.0, 0.1), half_gap = d.scale * kTypicalAngle;
  d.effect->target = d.Name(j);
  d.effect->words = "width " + std::to_string(width) + " N m, centre " + std::to_string(pressed) + " N m, friction " +
                    std::to_string(friction) + " N m";
  d.nature->gears.push_back({j, [=](const Shot& shot, double load) {
                               const double x = (load + friction * shot.approach[j] - pressed) / width;
                               return half_gap * x / std::sqrt(1.0 + x * x);
                             }});
}

// A link whose cross-section is no circle and whose principal directions are not along its axes: it bends sideways
// under a moment upright. What hangs beyond turns with the next joint, so two joints' postures make the moment.
void LinkBending(Draw d) {
  Posture zero(d.robot.arm.size());
  const Placement placement = Place(d.robot.arm, zero);
  std::vector<int> links;
  for (int j = 0; j + 1 < d.robot.arm.size(); ++j) {
    const double length = (placement.after_joint[j + 1].origin - placement.after_joint[j].origin).norm();
    if (length > 0.2 && !d.robot.arm.joints[j].prismatic) links.push_back(j);
  }
  if (links.empty()) throw std::invalid_argument("no link that is long enough to bend");
  const int link = links[d.random->Below(static_cast<int>(links.size()))];
  const double mass = d.robot.heavy.mass * d.random->Uniform(0.5, 1.0);
  const double reach = d.robot.heavy.mass > 50 ? 0.4 : 0.15;  // m
  const Weight beyond{link + 1, mass, d.random->NormalVector(reach)};
  const Vector3d axis_of_turn = d.random->Direction();
  const Matrix3d principal = SmallTurn(d.random->Uniform(0.3, 1.2) * axis_of_turn);
  Vector3d softness;
  for (int axis = 0; axis < 3; ++axis) softness[axis] = d.random->Uniform(0.2, 1.0);
  const double typical = d.scale * kTypicalAngle / (d.robot.heavy.mass * kGravity);  // rad/(N m)
  const Matrix3d flexibility = typical * principal * softness.asDiagonal() * principal.transpose();
  d.effect->target = d.Name(link);
  d.effect->words = "the link after it bends, " + std::to_string(mass) + " kg of its own beyond";
  d.nature->bendings.push_back({link, beyond, flexibility});
}

// A hose from the forearm to the flange, over two wrist joints: it pulls once its slack is used up, by
// p = softplus(s - s0), s = 1 - cos((q_a + f q_b - c) / 2), on both joints by its levers ds/dq; it drags in its
// clamps, so that it pulls more when it was drawn out than when it was let in.
void CableDrag(Draw d) {
  const int n = d.robot.arm.size();
  const int a = n - 1 - d.random->Below(2), b = a - 1 - d.random->Below(a - (n - 3));
  const double f = d.random->Sign() * d.random->Uniform(0.4, 1.0), centre = d.random->Uniform(-0.8, 0.8);
  const double slack = d.random->Uniform(0.1, 0.5), drag = d.random->Uniform(0.2, 0.6);
  const double softer = d.random->Uniform(0.5, 1.5), size = d.scale * 3.0 * kTypicalAngle * d.random->Sign();
  const auto pull = [=](const Shot& shot) {
    const double angle = 0.5 * (shot.q[a] + f * shot.q[b] - centre), lever = 0.5 * std::sin(angle);
    const double stretch = 1.0 - std::cos(angle) - slack;
    const double tension = 0.1 * std::log1p(std::exp(stretch / 0.1));
    const double drawn_out = std::tanh(3.0 * lever * (shot.approach[a] + f * shot.approach[b]));
    return tension * (1.0 + drag * drawn_out) * lever;
  };
  d.effect->target = d.Name(a);
  d.effect->words = "hose over " + d.Name(b) + " and " + d.Name(a) + ", slack " + std::to_string(slack);
  d.nature->encoder.push_back({a, [=](const Shot& shot) { return size * pull(shot); }});
  d.nature->encoder.push_back({b, [=](const Shot& shot) { return size * softer * f * pull(shot); }});
}

// Tooth mesh of the last stage: some tens of waves per turn; and a stage before it that meets the same teeth again
// only after two or three turns.
void GearRipple(Draw d) {
  const int j = RevoluteJoint(d.robot, d.random);
  const int order = 35 + d.random->Below(26);
  const double part = d.random->Chance(0.5) ? 1.0 / 2.0 : 2.0 / 3.0;  // waves per turn
  const double mesh = d.random->Uniform(0.0, kTurn), slow = d.random->Uniform(0.0, kTurn);
  const double share = d.random->Uniform(0.3, 1.0), size = d.scale * kTypicalAngle;
  d.effect->target = d.Name(j);
  d.effect->words = "order " + std::to_string(order) + ", and " + std::to_string(share) + " of it at order " +
                    (part < 0.6 ? "1/2" : "2/3");
  d.nature->encoder.push_back({j, [=](const Shot& shot) {
                                 const double q = shot.q[j];
                                 return size * (std::cos(order * q + mesh) + share * std::cos(part * q + slow));
                               }});
}

// Motors and gears heat the links that carry them: each its own rise of temperature, after a time constant of its
// own; steel to aluminium.
void LinkHeating(Draw d) {
  std::vector<double> growth, time_constant;
  for (int link = 0; link <= d.robot.arm.size(); ++link) {
    const double per_kelvin = d.random->Uniform(11e-6, 23e-6), rise = d.random->Uniform(1.0, 8.0);  // 1/K, K
    growth.push_back(d.scale * per_kelvin * rise);
    time_constant.push_back(60.0 * d.LogUniform(5.0, 40.0));
  }
  d.effect->target = "robot";
  d.effect->words = "each link with a time constant of its own, 5 to 40 min";
  d.nature->lengthening = [=](const Shot& shot, int link) {
    return growth[link] * (1.0 - std::exp(-shot.since_first / time_constant[link]));
  };
}

// Student's t of three degrees of freedom: a normal over the root of a third of a chi-square.
double HeavyTailed(Stream* random) {
  const Vector3d below = random->NormalVector(1.0);
  return random->Normal() / std::sqrt(below.squaredNorm() / 3.0);
}

Vector3d HeavyTailedVector(Stream* random) {
  Vector3d value;
  for (int axis = 0; axis < 3; ++axis) value[axis] = HeavyTailed(random);
  return value;
}

// A crane, a press, a draught: for some shots in a row the readings are bad, with heavy tails, and what is bad in one
// shot lasts into the next (first-order autoregression); the markers of a shot share the larger part.
void ReadingBursts(Draw d) {
  const int bursts = 2 + d.random->Below(4), shots = static_cast<int>(d.design.shots.size());
  const double lasting = d.random->Uniform(0.4, 0.8), size = d.scale * kTypicalLength;
  Readings readings;
  for (int burst = 0; burst < bursts; ++burst) {
    const int first = d.random->Below(shots), length = 4 + d.random->Below(12);
    Vector3d shared = HeavyTailedVector(d.random);
    for (int i = first; i < std::min(shots, first + length); ++i) {
      for (const auto& entry : d.nature->markers) {
        readings[{d.design.shots[i].time, entry.first}] = size * (shared + 0.5 * HeavyTailedVector(d.random));
      }
      shared = lasting * shared + std::sqrt(1.0 - lasting * lasting) * HeavyTailedVector(d.random);
    }
  }
  d.effect->target = "readings";
  d.effect->words = std::to_string(bursts) + " bursts, autoregression " + std::to_string(lasting);
  d.nature->disturbance = [=](const Shot& shot, const std::string& marker, const Vector3d&) -> Vector3d {
    const auto found = readings.find({shot.time, marker});
    return found == readings.end() ? Vector3d::Zero() : found->second;
  };
}

// Turbulent air bends the ray: the angle of arrival has a variance that grows with the range, so the point scatters
// across the ray by range to the power 1.5, and hardly along it.
void AirTurbulence(Draw d) {
  Readings readings;
  for (const Shot& shot : d.design.shots) {
    for (const auto& entry : d.nature->markers) readings[{shot.time, entry.first}] = d.random->NormalVector(1.0);
  }
  const double size = d.scale * 0.5 * kTypicalLength, range = 3.0;  // m
  d.effect->target = "readings";
  d.effect->words = "scatter across the ray by range to the power 1.5";
  d.nature->disturbance = [=](const Shot& shot, const std::string& marker, const Vector3d& point) -> Vector3d {
    const auto found = readings.find({shot.time, marker});
    if (found == readings.end()) return Vector3d::Zero();
    const Vector3d ray = point.normalized();
    const Vector3d across = found->second - 0.9 * ray.dot(found->second) * ray;
    return size * std::pow(point.norm() / range, 1.5) * across;
  };
}

// Glue or a magnet nest that creeps under the reflector's weight: fast at first, by the logarithm of time.
void SeatWear(Draw d) {
  const std::string worn = d.Marker();
  const double start = d.LogUniform(30.0, 600.0), all = std::log1p(d.Duration() / start);
  const Vector3d move = d.scale * 2.0 * kTypicalLength * d.random->Direction();
  d.effect->target = worn;
  d.effect->words = "creep by log(1 + t / " + std::to_string(start) + " s)";
  d.nature->seats.push_back([=](const Shot& shot, const std::string& marker) -> Vector3d {
    if (marker != worn) return Vector3d::Zero();
    return move * (std::log1p(shot.since_first / start) / all);
  });
}

// The rail or the floor under the robot gives way at once, in one direction, and then creeps in another.
void FloorSettling(Draw d) {
  const double at = d.random->Uniform(0.2, 0.7) * d.Duration(), creep = d.LogUniform(100.0, 1000.0);
  const double all = std::log1p((d.Duration() - at) / creep), share = d.random->Uniform(0.3, 0.7);
  const double towards = d.random->Uniform(0.0, kTurn), later = towards + d.random->Uniform(-1.5, 1.5);
  const double size = d.scale * 0.5 * kTypicalAngle;
  const Vector3d step = size * share * Vector3d(std::cos(towards), std::sin(towards), 0.0);
  const Vector3d slow = size * (1.0 - share) * Vector3d(std::cos(later), std::sin(later), 0.0);
  d.effect->target = "base";
  d.effect->words = "tilt: step of " + std::to_string(share) + " at " + std::to_string(at) + " s, then creep";
  d.nature->floor = [=](const Shot& shot) -> Vector3d {
    const double since = shot.since_first - at;
    if (since < 0.0) return Vector3d::Zero();
    return step + slow * (std::log1p(since / creep) / all);
  };
}

const Makers& All() {
  static const Makers makers = {{"loose_bolt", LooseBolt},         {"soft_lost_motion", SoftLostMotion},
                                {"link_bending", LinkBending},     {"cable_drag", CableDrag},
                                {"gear_ripple", GearRipple},       {"link_heating", LinkHeating},
                                {"reading_bursts", ReadingBursts}, {"air_turbulence", AirTurbulence},
                                {"seat_wear", SeatWear},           {"floor_settling", FloorSettling}};
  return makers;
}

}  // namespace

std::vector<std::string> ForeignKinds() { return KindsOf(All()); }

HiddenEffect HideForeign(const std::string& kind, double scale, const RobotKind& robot, const Design& design,
                         Stream* random, Nature* nature) {
  return HideOneOf(All(), kind, scale, robot, design, random, nature);
}

}  // namespace hidden

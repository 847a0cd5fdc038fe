#include "tests/hidden_effects/generator/nature.h"

#include <cmath>
#include <stdexcept>

namespace hidden {
namespace {

constexpr int kMostIterations = 1000;
constexpr double kStands = 1e-15;  // rad

struct Pull {
  int link;  // acts on links up to this one's joint
  Vector3d at, force;
};

// Base frame, m/s^2.
Vector3d Gravity(const Nature& nature, const Shot& shot) {
  return nature.stations.at(shot.station).turn.transpose() * Vector3d(0.0, 0.0, -kGravity);
}

Pull PullOf(const Weight& weight, const Placement& placement, const Vector3d& gravity) {
  return {weight.link, placement.after_joint[weight.link].Map(weight.centre), weight.mass * gravity};
}

// All forces at a placement, base frame.
std::vector<Pull> Forces(const Nature& nature, const Shot& shot, const Placement& placement) {
  const Matrix3d base_from_station = nature.stations.at(shot.station).turn.transpose();
  const Vector3d down = Gravity(nature, shot);
  std::vector<Pull> pulls;
  Vector3d force = base_from_station * shot.force;
  const auto extra = nature.extra_mass.find(shot.load);
  if (extra != nature.extra_mass.end()) force += extra->second * down;
  if (force.squaredNorm() > 0.0) {
    Vector3d at = nature.load_point;
    const auto off = nature.centre_off_point.find(shot.load);
    if (off != nature.centre_off_point.end()) at += off->second;
    if (nature.load_shift) at += nature.load_shift(shot, placement.flange.turn.transpose() * down / kGravity);
    pulls.push_back({nature.arm.size() - 1, placement.flange.Map(at), force});
  }
  for (const Weight& weight : nature.weights) pulls.push_back(PullOf(weight, placement, down));
  return pulls;
}

// Force of the spring times the lever of its end on the link. Link and frame
// coincide at q = 0, angles from the vertical: link end (L sin q, L cos q),
// anchor (-a_x, -a_y).
double SpringTorque(const Spring& spring, double q) {
  const Eigen::Vector2d stretch(spring.a_x + spring.L * std::sin(q), spring.a_y + spring.L * std::cos(q));
  const double length = stretch.norm();
  const Eigen::Vector2d force = -spring.Kc * (length - spring.s0) / length * stretch;
  return force.dot(Eigen::Vector2d(spring.L * std::cos(q), -spring.L * std::sin(q)));
}

Vector3d MomentAbout(const Vector3d& centre, int joint, const std::vector<Pull>& pulls) {
  Vector3d moment = Vector3d::Zero();
  for (const Pull& pull : pulls) {
    if (pull.link >= joint) moment += (pull.at - centre).cross(pull.force);
  }
  return moment;
}

// About the middle of the link, from everything that hangs beyond its end.
Vector3d BendOf(const Nature::Bending& bending, const Nature& nature, const Shot& shot, const Placement& placement,
                std::vector<Pull> pulls) {
  const Frame& start = placement.after_joint[bending.link];
  const Vector3d middle = 0.5 * (start.origin + placement.after_joint[bending.link + 1].origin);
  pulls.push_back(PullOf(bending.beyond, placement, Gravity(nature, shot)));
  return bending.flexibility * (start.turn.transpose() * MomentAbout(middle, bending.link + 1, pulls));
}

// By the part of the moment that does not turn the joint.
Vector3d TiltOf(const Nature::Bearing& bearing, const Nature& nature, const Shot& shot, const Placement& placement,
                std::vector<Pull> pulls) {
  const Frame& frame = placement.after_joint[bearing.joint];
  pulls.push_back(PullOf(bearing.beyond, placement, Gravity(nature, shot)));
  Vector3d across = frame.turn.transpose() * MomentAbout(frame.origin, bearing.joint, pulls);
  across[nature.arm.AxisOf(bearing.joint)] = 0.0;
  return bearing.tilt(across);
}

// What the encoder does not show: everything that does not depend on torque.
Posture Undeflected(const Nature& nature, const Shot& shot) {
  Posture posture(nature.arm.size());
  posture.values = shot.q;
  if (!nature.latent.empty()) posture.values += nature.latent[shot.config];
  for (const auto& encoder : nature.encoder) posture.values[encoder.joint] += encoder.deviation(shot);
  for (const auto& wobble : nature.wobble) posture.tilt[wobble.joint][wobble.about] += wobble.tilt(shot);
  if (nature.floor) posture.foot += nature.floor(shot);
  for (int link = 0; nature.warp && link < nature.arm.size(); ++link) posture.bend[link] += nature.warp(shot, link);
  for (int link = 0; nature.lengthening && link <= nature.arm.size(); ++link) {
    posture.lengthening[link] = nature.lengthening(shot, link);
  }
  return posture;
}

}  // namespace

Posture Equilibrium(const Nature& nature, const Shot& shot) {
  const Posture rigid = Undeflected(nature, shot);
  Posture posture = rigid;
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    const Placement placement = Place(nature.arm, posture);
    const std::vector<Pull> pulls = Forces(nature, shot, placement);
    Posture next = rigid;
    for (int j = 0; j < nature.arm.size(); ++j) {
      if (nature.arm.joints[j].prismatic) continue;
      const Frame& frame = placement.after_joint[j];
      const Vector3d moment = MomentAbout(frame.origin, j, pulls);
      double torque = placement.axis[j].dot(moment);
      if (nature.spring && nature.spring->joint == j) {
        // Angle of the link: actual joint value, its zero error included.
        torque += SpringTorque(*nature.spring, posture.values[j] + nature.arm.ElementOf(j).deviation);
      }
      next.values[j] += nature.compliance[j] * torque + nature.hardening[j] * std::pow(torque / 1e3, 3);
      const auto play = nature.torque_play.find(j);
      if (play != nature.torque_play.end() && std::abs(torque) > 1e-9) {
        const double pressed = play->second.width > 0.0 ? std::exp(-2.0 * std::abs(torque) / play->second.width) : 0.0;
        next.values[j] += std::copysign(play->second.half_gap * (1.0 - pressed) / (1.0 + pressed), torque);
      }
      for (const auto& gear : nature.gears) {
        if (gear.joint == j) next.values[j] += gear.deviation(shot, torque);
      }
      next.tilt[j] += nature.tilt_compliance[j].cwiseProduct(frame.turn.transpose() * moment);
    }
    next.foot += nature.foot_compliance.cwiseProduct(MomentAbout(Vector3d::Zero(), 0, pulls));
    for (const auto& bending : nature.bendings) {
      next.bend[bending.link] += BendOf(bending, nature, shot, placement, pulls);
    }
    for (const auto& bearing : nature.bearings) {
      next.tilt[bearing.joint] += TiltOf(bearing, nature, shot, placement, pulls);
    }
    double change = (next.values - posture.values).lpNorm<Eigen::Infinity>();
    change = std::max(change, (next.foot - posture.foot).lpNorm<Eigen::Infinity>());
    for (int j = 0; j < nature.arm.size(); ++j) {
      change = std::max(change, (next.tilt[j] - posture.tilt[j]).lpNorm<Eigen::Infinity>());
      change = std::max(change, (next.bend[j] - posture.bend[j]).lpNorm<Eigen::Infinity>());
    }
    posture = next;
    if (change < kStands) return posture;
  }
  throw std::runtime_error("no equilibrium");
}

Vector3d SeenAt(const Nature& nature, const Shot& shot, const std::string& marker) {
  const Placement placement = Place(nature.arm, Equilibrium(nature, shot));
  Vector3d on_flange = nature.markers.at(marker);
  for (const auto& reseat : nature.reseats) {
    if (reseat.marker == marker && shot.since_first > reseat.after) on_flange += reseat.shift;
  }
  for (const auto& seat : nature.seats) on_flange += seat(shot, marker);
  const double grown = 1.0 + nature.growth * (shot.arm_temperature - nature.reference_temperature);
  const StationPose& station = nature.stations.at(shot.station);
  Vector3d point = station.origin + station.turn * (grown * placement.flange.Map(on_flange));
  const auto drift = nature.drift.find(shot.station);
  if (drift != nature.drift.end()) {
    const double t = shot.since_start;
    point = SmallTurn(t * drift->second.turn) * point + t * drift->second.move;
  }
  if (nature.shake) point += nature.shake(shot);
  const auto scale = nature.scale.find(shot.station);
  if (scale != nature.scale.end()) point *= 1.0 + scale->second;
  const auto settling = nature.settling.find(shot.station);
  if (settling != nature.settling.end()) {
    const double left = LeftOf(settling->second, shot.since_start);
    point = SmallTurn(left * settling->second.turn) * point + left * settling->second.move;
  }
  const auto reflector = nature.reflectors.find(marker);
  if (reflector != nature.reflectors.end()) {
    const Vector3d axis = station.turn * (placement.flange.turn * reflector->second.axis);
    point = SeenAtAnAngle(reflector->second.offset, axis, point);
  }
  const auto instrument = nature.instruments.find(shot.station);
  if (instrument != nature.instruments.end()) point = Read(instrument->second, point);
  if (nature.disturbance) point += nature.disturbance(shot, marker, point);
  return point;
}

}  // namespace hidden

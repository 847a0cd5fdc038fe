#include "tests/hidden_effects/generator/hidden_effect.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace hidden {
namespace {

constexpr double kHour = 3600.0;  // s

struct Draw {
  const RobotKind& robot;
  const Design& design;
  double scale;
  Stream* random;
  Nature* nature;
  LeftOut* left_out;
  HiddenEffect* effect;

  // A size in the unit of the file: typical size, within a factor 1.5, sign free.
  double Size(const std::string& name, double typical) {
    const double value = scale * typical * random->Sign() * random->Uniform(0.67, 1.5);
    effect->parameters.push_back({name, value});
    return value;
  }
  double Positive(const std::string& name, double typical) {
    const double value = scale * typical * random->Uniform(0.67, 1.5);
    effect->parameters.push_back({name, value});
    return value;
  }
  int Joint(int first = 0) {
    int j = 0;
    do {
      j = first + random->Below(robot.arm.size() - first);
    } while (robot.arm.joints[j].prismatic);
    effect->target = robot.arm.joints[j].name;
    return j;
  }
  // A typical compliance of the joint, urad/(N m).
  double TypicalCompliance(int j) const { return robot.compliance[j] / kMicro; }
  // A typical torque on the arm, N m.
  double TypicalTorque() const { return robot.heavy.mass * kGravity; }
  double Middle(int j) const { return 0.5 * (robot.arm.joints[j].low + robot.arm.joints[j].high); }
  double RandomTime() const {
    const auto& shots = design.shots;
    const size_t n = shots.size();
    const size_t i = n / 4 + random->Below(static_cast<int>(n / 2));
    return 0.5 * (shots[i - 1].since_first + shots[i].since_first);
  }
};

// u and v of a joint: its two other axes in cyclic order.
int Across(const RobotKind& robot, int joint, int which) { return (robot.arm.AxisOf(joint) + 1 + which) % 3; }

void FrozenGeometry(Draw d) {
  const std::string name = d.robot.free_errors[d.random->Below(static_cast<int>(d.robot.free_errors.size()))];
  d.effect->target = name;
  for (Element& element : d.nature->arm.elements) {
    if (element.error != name) continue;
    const bool angle = IsTurn(element.move);
    element.deviation = angle ? std::acos(-1.0) / 180.0 * d.Size("value_deg", 0.02) : 1e-3 * d.Size("value_mm", 0.3);
  }
  d.left_out->errors.push_back(name);
}

void JointCompliance(Draw d) {
  const int j = d.Joint();
  d.nature->compliance[j] = kMicro * d.Positive("k_urad_per_Nm", d.TypicalCompliance(j));
  d.left_out->compliances.push_back(d.robot.arm.joints[j].name);
}

void Hardening(Draw d) {
  const int j = d.Joint();
  const double torque = d.TypicalTorque() / 1e3;
  d.nature->hardening[j] = kMicro * d.Size("k3_urad_per_kNm3", 100.0 / std::pow(torque, 3));
}

void Transverse(Draw d) {
  const int j = d.Joint();
  d.nature->tilt_compliance[j][Across(d.robot, j, 0)] =
      kMicro * d.Positive("ku_urad_per_Nm", 0.1 * d.TypicalCompliance(j));
  d.nature->tilt_compliance[j][Across(d.robot, j, 1)] =
      kMicro * d.Positive("kv_urad_per_Nm", 0.1 * d.TypicalCompliance(j));
}

void Compensator(Draw d) {
  Spring spring = d.robot.spring;
  d.effect->target = d.robot.arm.joints[spring.joint].name;
  for (double* length : {&spring.L, &spring.a_x, &spring.a_y, &spring.s0}) *length *= d.random->Uniform(0.9, 1.1);
  d.effect->parameters = {
      {"L_mm", spring.L * 1e3}, {"a_x_mm", spring.a_x * 1e3}, {"a_y_mm", spring.a_y * 1e3}, {"s0_mm", spring.s0 * 1e3}};
  spring.Kc = 1e3 * d.Positive("Kc_N_per_mm", 15.0);
  d.nature->spring = spring;
}

Weight LinkWeight(Draw d, int link) {
  const double typical = 0.2 * d.robot.heavy.mass;  // kg
  const double reach = 0.12 * (d.robot.heavy.mass > 50 ? 3.0 : 1.0);
  return {link, d.scale * typical * d.random->Uniform(0.67, 1.5), d.random->NormalVector(reach)};
}

void LinkGravity(Draw d) {
  const int j = d.Joint(1);
  const Weight weight = LinkWeight(d, j);
  d.nature->weights.push_back(weight);
  d.effect->parameters = {{"mass_kg", weight.mass}};
  const char* names[3] = {"mx_kgm", "my_kgm", "mz_kgm"};
  for (int axis = 0; axis < 3; ++axis) d.effect->parameters.push_back({names[axis], weight.mass * weight.centre[axis]});
}

// One compliant joint under the weights of the links beyond it. Their lever about
// it is the sum over the links of R_i s_i, s_i from everything beyond link i.
void SelfWeight(Draw d) {
  const int j = d.Joint(1);
  for (int link = j; link < d.robot.arm.size(); ++link) {
    Weight weight = LinkWeight(d, link);
    weight.mass /= std::max(1e-12, d.scale);
    d.nature->weights.push_back(weight);
  }
  const int about = d.random->Below(3);
  const double k = kMicro * d.scale * 0.5 * std::max(1.0, d.TypicalCompliance(j)) * d.random->Uniform(0.67, 1.5);
  d.effect->settings["about"] = about == 0 ? "axis" : about == 1 ? "u" : "v";
  if (about == 0) d.nature->compliance[j] = k;
  if (about > 0) d.nature->tilt_compliance[j][Across(d.robot, j, about - 1)] = k;
}

void Foot(Draw d) {
  d.effect->target = "base";
  const double typical = 0.1 * d.robot.compliance.maxCoeff() / kMicro;
  d.nature->foot_compliance.x() = kMicro * d.Positive("kx_urad_per_Nm", typical);
  d.nature->foot_compliance.y() = kMicro * d.Positive("ky_urad_per_Nm", typical);
}

void Payload(Draw d) {
  const LoadState& load = d.random->Chance(0.5) ? d.robot.heavy : d.robot.light;
  d.effect->target = load.name;
  d.nature->extra_mass[load.name] = d.Size("dmass_kg", 0.05 * load.mass);
}

// A gear with several harmonics: one dominant order, others a few per cent of it.
void Harmonic(Draw d) {
  const int j = d.Joint(1);
  const int order = 1 + d.random->Below(4);
  d.effect->settings["order"] = std::to_string(order);
  const double c = kMicro * d.Size("cos_urad", 60.0), s = kMicro * d.Size("sin_urad", 60.0);
  const double size = std::hypot(c, s);
  struct Wave {
    int order;
    double c, s;
  };
  std::vector<Wave> waves = {{order, c, s}};
  for (const int further : {order + 1, order + 2}) {
    waves.push_back({further, d.random->Normal(0.03 * size), d.random->Normal(0.03 * size)});
    d.effect->further_orders.push_back(further);
  }
  d.nature->encoder.push_back({j, [waves, j](const Shot& shot) {
                                 double sum = 0.0;
                                 for (const Wave& w : waves) {
                                   sum += w.c * std::cos(w.order * shot.q[j]) + w.s * std::sin(w.order * shot.q[j]);
                                 }
                                 return sum;
                               }});
}

void Wobble(Draw d) {
  const int j = d.Joint(1);
  const int order = 1 + d.random->Below(2);
  d.effect->settings["order"] = std::to_string(order);
  const char* names[2][2] = {{"u_cos_urad", "u_sin_urad"}, {"v_cos_urad", "v_sin_urad"}};
  for (int which = 0; which < 2; ++which) {
    const double c = kMicro * d.Size(names[which][0], 60.0), s = kMicro * d.Size(names[which][1], 60.0);
    d.nature->wobble.push_back({j, Across(d.robot, j, which), [=](const Shot& shot) {
                                  return c * std::cos(order * shot.q[j]) + s * std::sin(order * shot.q[j]);
                                }});
  }
}

void Gain(Draw d) {
  const int j = d.Joint(1);
  const double gain = kMicro * d.Size("gain_ppm", 100.0), middle = d.Middle(j);
  d.nature->encoder.push_back({j, [=](const Shot& shot) { return gain * (shot.q[j] - middle); }});
}

// A wrist gear: the motor of one joint turns a neighbour.
void Coupling(Draw d) {
  const int n = d.robot.arm.size();
  const int j = d.Joint(n - 3);
  int driver = j;
  while (driver == j) driver = n - 3 + d.random->Below(3);
  d.effect->settings["driver"] = d.robot.arm.joints[driver].name;
  const double ratio = kMicro * d.Size("ratio_ppm", 100.0);
  d.nature->encoder.push_back({j, [=](const Shot& shot) { return ratio * shot.q[driver]; }});
}

// The output of a gear with play follows its input only at the ends of the play.
std::vector<double> PlayBehindInput(const Design& design, int joint, double half_gap) {
  std::vector<double> behind;
  double output = design.turning_points.front()[joint];
  const auto follow = [&](double input) { output = std::clamp(output, input - half_gap, input + half_gap); };
  for (size_t c = 0; c < design.arrivals.size(); ++c) {
    follow(design.turning_points[c][joint]);
    follow(design.arrivals[c][joint]);
    behind.push_back(output - design.arrivals[c][joint]);
  }
  return behind;
}

void Backlash(Draw d) {
  const bool by_torque = d.design.options.loaded && d.random->Chance(0.25);
  const int j = d.Joint();
  const double half_gap = kMicro * d.Positive("half_gap_urad", 50.0);
  d.effect->settings["by"] = by_torque ? "torque" : "approach";
  if (by_torque) {
    Nature::TorquePlay& play = d.nature->torque_play[j];
    play.half_gap = half_gap;
    if (!d.random->Chance(0.5)) return;
    play.width = 0.3 * d.TypicalTorque() * d.random->Uniform(0.67, 1.5);
    d.effect->settings["width_Nm"] = std::to_string(play.width);
    return;
  }
  const std::vector<double> behind = PlayBehindInput(d.design, j, half_gap);
  d.nature->encoder.push_back({j, [behind](const Shot& shot) { return behind[shot.config]; }});
}

void Slip(Draw d) {
  const int j = d.Joint(1);
  const double after = d.RandomTime(), jump = kMicro * d.Size("jump_urad", 80.0);
  d.effect->settings["after_s"] = std::to_string(after);
  d.nature->encoder.push_back({j, [=](const Shot& shot) { return shot.since_first > after ? jump : 0.0; }});
}

void Growth(Draw d) {
  d.effect->target = "robot";
  d.nature->growth = kMicro * d.Positive("growth_ppm_per_K", 10.0);
}

void StationDrift(Draw d) {
  const std::string station = d.design.shots[d.random->Below(static_cast<int>(d.design.shots.size()))].station;
  d.effect->target = station;
  Drift& drift = d.nature->drift[station];
  for (const char axis : {'x', 'y', 'z'})
    drift.move[axis - 'x'] = kMicro / kHour * d.Size(std::string(1, axis) + "_um_per_h", 15.0);
  for (const char axis : {'x', 'y', 'z'}) {
    drift.turn[axis - 'x'] = kMicro / kHour * d.Size(std::string("r") + axis + "_urad_per_h", 5.0);
  }
}

void StationScale(Draw d) {
  const std::string station = d.design.shots[d.random->Below(static_cast<int>(d.design.shots.size()))].station;
  d.effect->target = station;
  d.nature->scale[station] = kMicro * d.Size("scale_ppm", 30.0);
}

void MarkerShift(Draw d) {
  const std::string marker = "M" + std::to_string(1 + d.random->Below(static_cast<int>(d.nature->markers.size())));
  d.effect->target = marker;
  const double after = d.RandomTime();
  d.effect->settings["after_s"] = std::to_string(after);
  Vector3d shift;
  for (const char axis : {'x', 'y', 'z'}) shift[axis - 'x'] = 1e-3 * d.Size(std::string(1, axis) + "_mm", 0.05);
  d.nature->reseats.push_back({marker, after, shift});
}

std::string AnyStation(const Draw& d) {
  return d.design.shots[d.random->Below(static_cast<int>(d.design.shots.size()))].station;
}

std::string AnyMarker(const Draw& d) {
  return "M" + std::to_string(1 + d.random->Below(static_cast<int>(d.nature->markers.size())));
}

void WarmUp(Draw d) {
  d.effect->target = AnyStation(d);
  Settling& settling = d.nature->settling[d.effect->target];
  settling.time_constant = std::exp(d.random->Uniform(std::log(400.0), std::log(4000.0)));
  d.effect->settings["tau_s"] = std::to_string(settling.time_constant);
  for (const char axis : {'x', 'y', 'z'}) {
    settling.move[axis - 'x'] = kMicro * d.Size(std::string(1, axis) + "_um", 30.0);
  }
  for (const char axis : {'x', 'y', 'z'}) {
    settling.turn[axis - 'x'] = kMicro * d.Size(std::string("r") + axis + "_urad", 10.0);
  }
}

// A pointer at angle a reads a + (c_x sin a - c_y cos a) where the circle's centre is at c.
void Eccentricity(Draw d) {
  d.effect->target = AnyStation(d);
  Instrument& instrument = d.nature->instruments[d.effect->target];
  instrument.azimuth_centre.y() = -kMicro * d.Size("az_cos_urad", 15.0);
  instrument.azimuth_centre.x() = kMicro * d.Size("az_sin_urad", 15.0);
  instrument.elevation_centre.y() = -kMicro * d.Size("el_cos_urad", 15.0);
  instrument.elevation_centre.x() = kMicro * d.Size("el_sin_urad", 15.0);
}

void RangeOffset(Draw d) {
  d.effect->target = AnyStation(d);
  d.nature->instruments[d.effect->target].too_far = kMicro * d.Size("offset_um", 15.0);
}

void Refraction(Draw d) {
  d.effect->target = AnyStation(d);
  d.nature->instruments[d.effect->target].curvature = kMicro * d.Size("curvature_urad_per_m", 1.0);
}

void LoadOffPoint(Draw d) {
  d.effect->target = (d.random->Chance(0.5) ? d.robot.heavy : d.robot.light).name;
  Vector3d& off = d.nature->centre_off_point[d.effect->target];
  for (const char axis : {'x', 'y', 'z'}) off[axis - 'x'] = 1e-3 * d.Size(std::string("d") + axis + "_mm", 20.0);
}

// A peg in a slot of a slide: the slide stays until the peg meets an end.
void Memory(Draw d) {
  const int j = d.Joint();
  const double slot = std::exp(d.random->Uniform(std::log(0.02), std::log(0.5)));  // rad
  d.effect->settings["width_deg"] = std::to_string(slot * 180.0 / std::acos(-1.0));
  const double amplitude = kMicro * d.Positive("amplitude_urad", 50.0);
  std::vector<double> middle_before_peg;
  double end = d.design.arrivals.front()[j] - 0.5 * slot;
  for (const VectorXd& q : d.design.arrivals) {
    if (q[j] < end) end = q[j];
    if (q[j] > end + slot) end = q[j] - slot;
    middle_before_peg.push_back((end + 0.5 * slot - q[j]) / (0.5 * slot));
  }
  d.nature->encoder.push_back({j, [=](const Shot& shot) { return amplitude * middle_before_peg[shot.config]; }});
}

void Acceptance(Draw d) {
  d.effect->target = AnyMarker(d);
  Reflector& reflector = d.nature->reflectors[d.effect->target];
  reflector.axis = Vector3d::Unit(d.robot.arm.AxisOf(d.robot.arm.size() - 1));
  reflector.offset = kMicro * d.Size("offset_um", 50.0);
}

const std::vector<std::pair<std::string, void (*)(Draw)>>& Makers() {
  static const std::vector<std::pair<std::string, void (*)(Draw)>> makers = {{"frozen_geometry", FrozenGeometry},
                                                                             {"joint_compliance", JointCompliance},
                                                                             {"compliance_hardening", Hardening},
                                                                             {"transverse_compliance", Transverse},
                                                                             {"gravity_compensator", Compensator},
                                                                             {"link_gravity", LinkGravity},
                                                                             {"self_weight_sag", SelfWeight},
                                                                             {"base_compliance", Foot},
                                                                             {"payload", Payload},
                                                                             {"joint_harmonic", Harmonic},
                                                                             {"axis_wobble", Wobble},
                                                                             {"encoder_gain", Gain},
                                                                             {"joint_coupling", Coupling},
                                                                             {"backlash", Backlash},
                                                                             {"joint_slip", Slip},
                                                                             {"thermal_growth", Growth},
                                                                             {"station_drift", StationDrift},
                                                                             {"station_scale", StationScale},
                                                                             {"marker_shift", MarkerShift},
                                                                             {"warm_up", WarmUp},
                                                                             {"station_eccentricity", Eccentricity},
                                                                             {"station_range_offset", RangeOffset},
                                                                             {"load_com", LoadOffPoint},
                                                                             {"hysteresis", Memory},
                                                                             {"marker_acceptance", Acceptance},
                                                                             {"station_refraction", Refraction}};
  return makers;
}

bool Holds(const std::vector<std::string>& kinds, const std::string& kind) {
  return std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
}

}  // namespace

std::vector<std::string> CatalogueKinds() {
  std::vector<std::string> kinds;
  for (const auto& maker : Makers()) kinds.push_back(maker.first);
  return kinds;
}

HiddenEffect Hide(const std::string& kind, double scale, const RobotKind& robot, const Design& design, Stream* random,
                  Nature* nature, LeftOut* left_out) {
  for (const auto& [name, make] : Makers()) {
    if (name != kind) continue;
    HiddenEffect effect;
    effect.kind = kind;
    make({robot, design, scale, random, nature, left_out, &effect});
    return effect;
  }
  if (Holds(ForeignKinds(), kind)) return HideForeign(kind, scale, robot, design, random, nature);
  if (Holds(StrangerKinds(), kind)) return HideStranger(kind, scale, robot, design, random, nature);
  if (Holds(NewcomerKinds(), kind)) return HideNewcomer(kind, scale, robot, design, random, nature);
  if (Holds(LatecomerKinds(), kind)) return HideLatecomer(kind, scale, robot, design, random, nature);
  return HideOutside(kind, scale, robot, design, random, nature);
}

}  // namespace hidden

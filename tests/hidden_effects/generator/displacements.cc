#include "tests/hidden_effects/generator/displacements.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <vector>

#include "tests/hidden_effects/generator/answer_json.h"

namespace hidden {
namespace {

using nlohmann::json;

constexpr double kOvershoot = 0.05;  // rad: a joint comes from this far

Vector3d VectorOf(const json& list) {
  const double x = list.at(0), y = list.at(1), z = list.at(2);
  return {x, y, z};
}

RobotKind RobotOf(const json& input) {
  RobotKind robot;
  robot.arm.name = "measured arm";
  robot.arm.is_dh = true;
  const Move moves[5] = {Move::kRz, Move::kTz, Move::kTx, Move::kRx, Move::kRy};
  const char* quantities[5] = {"theta", "d", "a", "alpha", "beta"};
  for (size_t link = 0; link < input.at("dh").size(); ++link) {
    const json& joint = input.at("joints").at(link);
    robot.arm.joints.push_back({joint.at("name"), false, joint.at("low_rad"), joint.at("high_rad")});
    for (int i = 0; i < 5; ++i) {
      Element element{moves[i], input.at("dh").at(link).at(quantities[i]), -1, "", 0.0, static_cast<int>(link), ""};
      if (i == 0) element.joint = static_cast<int>(link);
      robot.arm.elements.push_back(element);
    }
  }
  robot.compliance = VectorXd::Zero(robot.arm.size());
  return robot;
}

Design DesignOf(const json& input) {
  Design design;
  design.options.loaded = false;
  for (const json& row : input.at("rows")) {
    Shot shot;
    shot.config = static_cast<int>(design.shots.size());
    shot.station = row.at("station");
    const auto q = row.at("q_rad").get<std::vector<double>>();
    shot.q = Eigen::Map<const VectorXd>(q.data(), static_cast<int>(q.size()));
    shot.time = row.at("time_s");
    shot.since_start = row.at("since_start_s");
    shot.since_first = shot.time - (design.shots.empty() ? shot : design.shots.front()).time;
    shot.air = shot.arm_temperature = row.at("temperature_degC");
    shot.approach = row.at("approach").get<std::vector<int>>();
    VectorXd turning = shot.q;
    for (int j = 0; j < shot.q.size(); ++j) turning[j] -= kOvershoot * shot.approach[j];
    design.arrivals.push_back(shot.q);
    design.turning_points.push_back(turning);
    design.shots.push_back(shot);
  }
  return design;
}

Nature NatureOf(const json& input, const RobotKind& robot, const Design& design) {
  Nature nature;
  nature.arm = robot.arm;
  for (const auto& [name, pose] : input.at("stations").items()) {
    nature.stations[name].origin = VectorOf(pose.at("origin_m"));
    nature.stations[name].turn = SmallTurn(VectorOf(pose.at("rotvec_rad")));
  }
  for (const auto& [name, point] : input.at("markers").items()) nature.markers[name] = VectorOf(point);
  nature.compliance = nature.hardening = VectorXd::Zero(robot.arm.size());
  nature.tilt_compliance.assign(robot.arm.size(), Vector3d::Zero());
  for (const Shot& shot : design.shots) {
    nature.reference_temperature += shot.air / static_cast<double>(design.shots.size());
  }
  return nature;
}

}  // namespace

void WriteDisplacements(const DisplacementOptions& options) {
  std::ifstream file(options.input);
  if (!file) throw std::runtime_error("cannot read " + options.input);
  const json input = json::parse(file);
  const RobotKind robot = RobotOf(input);
  const Design design = DesignOf(input);
  const Nature without = NatureOf(input, robot, design);
  Nature with = without;
  LeftOut left_out;
  Stream random(options.study, options.number, Purpose::kEffect);
  const HiddenEffect effect = Hide(options.kind, options.scale, robot, design, &random, &with, &left_out);
  if (!left_out.errors.empty() || !left_out.compliances.empty()) {
    throw std::invalid_argument("cannot be injected: " + options.kind);
  }
  json output = {{"hidden", AnswerOf(effect)}, {"displacement_mm", json::array()}};
  for (size_t i = 0; i < design.shots.size(); ++i) {
    const std::string marker = input.at("rows").at(i).at("marker");
    const Vector3d moved = 1e3 * (SeenAt(with, design.shots[i], marker) - SeenAt(without, design.shots[i], marker));
    output["displacement_mm"].push_back({moved.x(), moved.y(), moved.z()});
  }
  std::ofstream out(options.output);
  out << output.dump() << "\n";
  if (!out) throw std::runtime_error("cannot write " + options.output);
}

}  // namespace hidden

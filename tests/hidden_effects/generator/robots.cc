#include "tests/hidden_effects/generator/robots.h"

#include <stdexcept>

namespace hidden {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;

struct Builder {
  Arm arm;
  void Fixed(Move move, double value, const std::string& error = "") {
    arm.elements.push_back({move, value, -1, error, 0.0, -1, ""});
  }
  void Joint(Move move, const std::string& name, double low, double high, const std::string& error = "") {
    const bool prismatic = !IsTurn(move);
    const double unit = prismatic ? 1e-3 : kDegree;
    arm.joints.push_back({name, prismatic, low * unit, high * unit});
    arm.elements.push_back({move, 0.0, arm.size() - 1, error, 0.0, -1, ""});
  }
  void DhLink(const std::string& joint, double a, double alpha_deg, double d, double limit_deg) {
    const int link = arm.size();
    arm.joints.push_back({joint, false, -limit_deg * kDegree, limit_deg * kDegree});
    const auto add = [&](Move move, double value, int j, const std::string& quantity) {
      arm.elements.push_back({move, value, j, joint + "." + quantity, 0.0, link, quantity});
    };
    add(Move::kRz, 0.0, link, "theta");
    add(Move::kTz, d, -1, "d");
    add(Move::kTx, a, -1, "a");
    add(Move::kRx, alpha_deg * kDegree, -1, "alpha");
    add(Move::kRy, 0.0, -1, "beta");
  }
};

void AddKr270(Builder* b) {
  b->Fixed(Move::kTz, 0.750);
  b->Joint(Move::kRz, "A1", -150, 150);
  b->Fixed(Move::kTx, 0.350, "p_x1");
  b->Fixed(Move::kTy, 0.0, "p_y1");
  b->Fixed(Move::kRx, 0.0, "phi_x1");
  b->Joint(Move::kRy, "A2", -135, -5, "dq2");
  b->Fixed(Move::kTx, 1.250, "p_x2");
  b->Fixed(Move::kRx, 0.0, "phi_x2");
  b->Fixed(Move::kRz, 0.0, "phi_z2");
  b->Joint(Move::kRy, "A3", -100, 140, "dq3");
  b->Fixed(Move::kTx, 1.100, "p_x3");
  b->Fixed(Move::kTz, -0.055, "p_z3");
  b->Fixed(Move::kRz, 0.0, "phi_z3");
  b->Joint(Move::kRx, "A4", -170, 170, "dq4");
  b->Fixed(Move::kTy, 0.0, "p_y4");
  b->Fixed(Move::kTz, 0.0, "p_z4");
  b->Fixed(Move::kRz, 0.0, "phi_z4");
  b->Joint(Move::kRy, "A5", -110, 110, "dq5");
  b->Fixed(Move::kTz, 0.0, "p_z5");
  b->Fixed(Move::kRz, 0.0, "phi_z5");
  b->Joint(Move::kRx, "A6", -170, 170);
  b->Fixed(Move::kTx, 0.230);
}

std::vector<std::string> ErrorNames(const Arm& arm) {
  std::vector<std::string> names;
  for (const Element& element : arm.elements) {
    if (!element.error.empty()) names.push_back(element.error);
  }
  return names;
}

VectorXd Micro(std::vector<double> values) {
  return kMicro * Eigen::Map<VectorXd>(values.data(), static_cast<int>(values.size()));
}

void SetHeavyIndustry(RobotKind* robot) {
  robot->load_point = {0.28, 0.06, -0.15};
  robot->heavy = {"V250", 250.0, 0.0};
  robot->light = {"V120", 120.0, 0.0};
  robot->sideways = {"H", 0.0, 700.0};
}

void SetLightArm(RobotKind* robot) {
  robot->load_point = {0.06, 0.08, 0.12};
  robot->heavy = {"W10", 10.0, 0.0};
  robot->light = {"W5", 5.0, 0.0};
  robot->sideways = {"P", 0.0, 60.0};
  robot->marker_spread = 0.12;
}

RobotKind Kr270(bool spring, bool track) {
  RobotKind robot;
  Builder b;
  if (track) {
    b.Joint(Move::kTy, "E1", 0, 3000);
    b.Fixed(Move::kRx, 0.0, "phi_x0");
  }
  AddKr270(&b);
  b.arm.name = track ? "KUKA KR 270 on a track" : "KUKA KR 270";
  robot.arm = b.arm;
  robot.free_errors = ErrorNames(b.arm);
  std::vector<double> k = {0.62, 0.30, 0.42, 2.8, 3.5, 2.1};
  if (track) k.insert(k.begin(), 0.0);
  robot.compliance = Micro(k);
  SetHeavyIndustry(&robot);
  robot.has_spring = spring;
  robot.spring = {robot.arm.Find("A2"), 0.18472, 0.68593, 0.12330, 0.458, 15e3};
  return robot;
}

RobotKind Ur10() {
  RobotKind robot;
  Builder b;
  b.arm.name = "UR10";
  b.arm.is_dh = true;
  b.DhLink("J1", 0.0, 90, 0.1273, 170);
  b.DhLink("J2", -0.612, 0, 0.0, 170);
  b.DhLink("J3", -0.5723, 0, 0.0, 150);
  b.DhLink("J4", 0.0, 90, 0.163941, 170);
  b.DhLink("J5", 0.0, -90, 0.1157, 170);
  b.DhLink("J6", 0.0, 0, 0.0922, 170);
  robot.arm = b.arm;
  // The base absorbs J1's theta and d, the markers all of J6; joints 2 and 3 are
  // parallel to the next: beta in place of d.
  robot.free_errors = {"J1.a",     "J1.alpha", "J2.theta", "J2.a",    "J2.alpha", "J2.beta",
                       "J3.theta", "J3.a",     "J3.alpha", "J3.beta", "J4.theta", "J4.d",
                       "J4.a",     "J4.alpha", "J5.theta", "J5.d",    "J5.a",     "J5.alpha"};
  robot.compliance = Micro({4.0, 5.0, 7.0, 14.0, 14.0, 20.0});
  SetLightArm(&robot);
  return robot;
}

RobotKind SevenAxes() {
  RobotKind robot;
  Builder b;
  b.arm.name = "seven-axis arm";
  const double lengths[8] = {0.36, 0.0, 0.42, 0.0, 0.40, 0.0, 0.126, 0.0};
  for (int j = 0; j < 7; ++j) {
    const std::string n = std::to_string(j + 1);
    if (j == 0) b.Fixed(Move::kTz, lengths[0]);
    const bool bends = j % 2 == 1;
    const double limit = bends ? 115 : 165;
    b.Joint(bends ? Move::kRy : Move::kRz, "J" + n, -limit, limit, j == 0 || j == 6 ? "" : "dq" + n);
    if (j == 6) continue;
    // d along the own axis, a and twist along x; the base absorbs J1's d and theta,
    // the markers all of J7.
    b.Fixed(Move::kTx, 0.0, "x" + n);
    if (bends) b.Fixed(Move::kTy, 0.0, "y" + n);
    b.Fixed(Move::kTz, lengths[j + 1], bends || j == 0 ? "" : "z" + n);
    b.Fixed(Move::kRx, 0.0, "rx" + n);
  }
  robot.arm = b.arm;
  robot.free_errors = ErrorNames(b.arm);
  robot.compliance = Micro({6.0, 6.0, 8.0, 8.0, 14.0, 14.0, 20.0});
  SetLightArm(&robot);
  return robot;
}

}  // namespace

RobotKind MakeRobot(const std::string& name) {
  if (name == "kr270") return Kr270(false, false);
  if (name == "kr270_compensator") return Kr270(true, false);
  if (name == "track") return Kr270(false, true);
  if (name == "ur10") return Ur10();
  if (name == "seven") return SevenAxes();
  throw std::invalid_argument("no robot " + name);
}

}  // namespace hidden

// A robot as its description file states it: chain, compliances, compensator.
// The values are a starting point; what is unknown is in problems/parameter_set.h.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "models/chain.h"
#include "models/denavit_hartenberg.h"
#include "models/effects/effect_spec.h"

namespace sagitta {

// The table a chain was made from, kept so that it can be written again.
struct DhTable {
  DhConvention convention = DhConvention::kStandard;
  std::vector<DhLink> links;
  Vector3<double> flange_xyz = Vector3<double>::Zero();  // m
  Vector3<double> flange_rpy = Vector3<double>::Zero();  // rad
};

// Rotation (translation) of a joint about (along) its own axis per torque (force).
// Constant, or piecewise linear in q and constant outside the table.
struct JointCompliance {
  int joint = -1;
  struct Node {
    double q = 0.0;  // rad or m
    double k = 0.0;  // rad/(N m) or m/N
  };
  std::vector<Node> nodes;  // one node: a constant
  bool is_table = false;
};

// Spring between link and base, papers 000 and 002: gamma = alpha - q,
// alpha = atan2(a_x, a_y), s^2 = a^2 + L^2 + 2 a L cos(gamma).
struct GravityCompensator {
  int joint = -1;
  double L = 0.0;    // m
  double a_x = 0.0;  // m
  double a_y = 0.0;  // m
  double s0 = 0.0;   // m
  double Kc = 0.0;   // N/m
  bool preload = true;
  // Value of the joint's transform at which the spring's q is 0, rad; absent: its nominal value. A calibrated robot
  // carries the joint's error in that, and the spring keeps its own.
  std::optional<double> zero = {};
  // SI, of L, a_x, a_y, s0 and Kc: of priors about these values, where they are known no better; 0: none. Empty: none.
  std::vector<double> prior_sigmas = {};
};

struct EffectDefinition;  // models/effects/effect.h

// How the joints move the flange, and the table that this came from.
struct Kinematics {
  Chain chain;
  std::optional<DhTable> dh;
};

// A robot as its file states it: geometry, elasticity, effects; SI.
struct Robot {
  // Compiled once (robot.cc), not in each file that holds one.
  Robot();
  Robot(const Robot&);
  Robot(Robot&&) noexcept;
  Robot& operator=(const Robot&);
  Robot& operator=(Robot&&) noexcept;
  ~Robot();

  std::string name;
  Chain chain;
  std::optional<DhTable> dh;
  // What the robot's controller computes with, where `chain` is what a calibration found; absent: `chain`.
  std::optional<Kinematics> controller;
  std::vector<JointCompliance> compliances;
  std::optional<GravityCompensator> gravity_compensator;
  std::vector<EffectSpec> effects;  // all other effects, with values
  // degC, from which temperature counts for its effects; absent: from the mean of whatever rows are measured.
  std::optional<double> reference_temperature;
  // Definitions of the user's own that `effects` and the diagnosis may use in addition to the catalogue.
  std::vector<const EffectDefinition*> own_effects;

  int num_joints() const { return chain.num_joints(); }
};

// The chain of a table of DH rows, one joint per row.
Chain ChainFromDhTable(const std::vector<Joint>& joints, const std::vector<Coupling>& couplings, const DhTable& table);

// The robot with geometric errors (SI, by error name) moved into its nominal
// values, in the chain and in the table it came from.
Robot WithGeometricErrors(const Robot& robot, const std::map<std::string, double>& errors);

}  // namespace sagitta

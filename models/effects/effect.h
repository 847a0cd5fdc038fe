// What every physical effect is made of.
//
// An effect is a plain definition: name, target, settings, parameters, the
// columns it needs, and Apply, a few lines that say what one unit of each
// parameter does in one shot. Every effect of the catalogue is linear in its
// parameters given the state of the arm, so what it does is a list of *terms*
// of three laws, and one piece of code (forward_model.cc) turns terms into
// predictions and exact derivatives:
//
//   displacement  a slot's value v_e moves: by data (SlotTerm), by the torque on
//                 the slot (ElasticTerm), by a wrench of its own (SagTerm)
//   load          a wrench hangs on a frame (WrenchTerm)
//   instrument    marker, base-frame or station-frame points move
//
// A new effect is one file with one definition, declared in catalogue.h and
// listed in catalogue.cc.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "models/effects/effect_spec.h"
#include "models/quantity.h"
#include "models/robot.h"
#include "models/wrench.h"

namespace sagitta {

// v_e += factor * theta
struct SlotTerm {
  int transform;
  int parameter;
  double factor;
};

enum class ElasticLaw { kLinear, kCubic, kSign };  // phi(tau) = tau, tau^3, sign(tau)

// v_e += factor * theta * phi(tau_e)
struct ElasticTerm {
  int transform;
  int parameter;
  double factor;
  ElasticLaw law = ElasticLaw::kLinear;
};

// v_e += theta * (torque of these wrenches alone on e)
struct SagTerm {
  int transform;
  int parameter;
  std::vector<AppliedWrench> wrenches;
};

// theta times these wrenches load the arm.
struct WrenchTerm {
  int parameter;
  std::vector<AppliedWrench> wrenches;
};

// Marker point += theta * direction, in the frame it is on.
struct MarkerTerm {
  int marker;
  int parameter;
  Vector3<double> direction;
};

// Point in the base frame += theta * factor * point, where it rides on the arm.
struct BaseTerm {
  int parameter;
  double factor;
};

// Measured point += theta * (gradient * p + offset), p the true point in the station.
struct StationTerm {
  int parameter;
  Matrix3<double> gradient;
  Vector3<double> offset;
};

// The torque on e was measured: tau_e is this, whatever hangs on the arm.
struct StatedTorque {
  int transform;
  double torque;  // N m, or N
};

struct ShotTerms {
  std::vector<SlotTerm> slots;
  std::vector<ElasticTerm> elastic;
  std::vector<SagTerm> sags;
  std::vector<WrenchTerm> wrenches;
  std::vector<MarkerTerm> markers;
  std::vector<BaseTerm> base;
  std::vector<StationTerm> station;
  std::vector<StatedTorque> torques;
};

constexpr int kApproachNotStated = 2;

// What a shot is, beside its wrenches: all that an effect may look at.
struct ShotConditions {
  Eigen::VectorXd q;  // commanded, as in the file
  std::string station;
  std::string load = "none";
  bool has_time = false;
  double time = 0.0;  // s since the station's first row
  bool has_temperature = false;
  double temperature = 0.0;   // K above the mean of the data
  std::vector<int> approach;  // -1, 0, +1 per joint, or kApproachNotStated; empty: none is stated
  Vector3<double> gravity = Vector3<double>(0.0, 0.0, -9.80665);  // m/s^2
  WrenchFrame gravity_frame = WrenchFrame::kMeasurement;
  Vector3<double> instrument = Vector3<double>::Zero();  // m, where it stands in the measurement frame
  std::vector<AppliedWrench> load_wrenches;              // of the shot's own load
  Eigen::VectorXd joint_torques;  // N m or N about each joint's positive direction, measured; empty: the model's count

  // False too where only other joints' directions are stated.
  bool StatesApproachOf(int joint) const { return !approach.empty() && approach[joint] != kApproachNotStated; }
};

enum class EffectTarget { kJoint, kError, kBase, kRobot, kStation, kLoad, kMarker };

struct EffectParameter {
  std::string name;  // cos; with its unit cos_urad in files
  Quantity quantity;
};

struct SettingDefinition {
  enum class Kind { kInteger, kNumber, kJoint, kChoice };
  std::string name;
  Kind kind = Kind::kInteger;
  std::string fallback;              // "" : required
  std::vector<std::string> choices;  // of kChoice
  int most_scanned = 0;              // of kInteger, by the diagnosis; 0: as many as the configurations resolve
};

// What must be among the data or in the model before an effect can be told.
enum class EffectNeeds { kNothing, kLoads, kCompliances, kNoCompliances };

// What drives it, for plots: the angle of its joint (or of the joint that a setting names), time or temperature. The
// latter two must be among the columns.
enum class EffectDriver { kJoint, kTime, kTemperature };

// What Apply is given: the model's chain (with tilt slots), the targets by
// index, and where this use's parameters start.
struct EffectContext {
  const Robot* robot;
  const EffectSpec* spec;
  const ShotConditions* shot;
  const std::vector<std::string>* markers;
  int first_parameter;

  const Chain& chain() const { return robot->chain; }
  int joint() const { return chain().FindJoint(spec->target); }
  // Slot of the joint itself, and its sign (encoder-side effects).
  int joint_slot() const { return chain().JointTransform(joint()); }
  double joint_sign() const { return chain().transforms[joint_slot()].sign; }
};

// All that anybody asks about an effect: the models, the files, the diagnosis and its words.
struct EffectDefinition {
  std::string name;
  std::string title;      // for reports
  std::string reference;  // equation or source
  EffectTarget target;
  std::vector<EffectParameter> (*parameters)(const Robot& robot, const EffectSpec& spec);
  void (*apply)(const EffectContext& context, ShotTerms* terms);

  std::vector<SettingDefinition> settings = {};
  bool tilts = false;  // needs the tilt slots of its joint, or of the foot
  EffectNeeds needs = EffectNeeds::kNothing;
  EffectDriver driven_by = EffectDriver::kJoint;
  // "" or the column that this shot lacks, e.g. "approach3"; null: none but what drives it.
  std::string (*missing)(const EffectContext& context) = nullptr;
  std::string separate_by = {};  // which data tell it from its rivals; {target} is replaced
  std::string note = {};         // what to bear in mind where it is named
  bool on_prismatic = false;     // of kJoint: what it does to a joint that slides is defined
  double largest = 5.0;          // that machines show, in hold limits (QuantityTraits) of its parameters
};

// Silent Rx, Ry, Rz right after a joint (joint >= 0) or at the foot (-1).
void AddTiltSlots(int joint, Chain* chain);
// The slot about `axis` (x, y, z) there.
int TiltSlot(const Chain& chain, int joint, Axis axis);
// A joint's own axis and its two others in cyclic order: about z, u = x, v = y.
Axis AxisOf(const Chain& chain, int joint);
Axis OtherAxis(Axis axis, int which);  // which: 0 = u, 1 = v

}  // namespace sagitta

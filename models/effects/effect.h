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
//   instrument    marker, base-frame or station-frame points move, or the
//                 instrument reads an angle or a range wrong (SightTerm)
//
// An effect that depends on what came before a shot (play, heat) says by
// `remember` what it keeps of it: one number per shot, from all shots in the order
// they were measured.
//
// A new effect is one file with one definition, declared in catalogue.h and
// listed in catalogue.cc.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "models/constants.h"
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

// phi(tau) = tau, tau^3, tanh(tau / width), which is sign(tau) where the width is 0, or a bump (bump.h).
enum class ElasticLaw { kLinear, kCubic, kSign, kBump };

// v_e += factor * theta * phi(tau_e)
struct ElasticTerm {
  int transform;
  int parameter;
  double factor;
  ElasticLaw law = ElasticLaw::kLinear;
  double width = 0.0;   // N m, of kSign and kBump
  double centre = 0.0;  // N m, of kBump
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

// What the instrument reads: azimuth and elevation (rad; the measurement frame's z is up, azimuth from its x towards
// its y) and the range (m) along the line of sight.
enum class Sensed { kAzimuth, kElevation, kRange };
// What the error of a reading goes with.
enum class SightLaw {
  kOne,
  kRange,
  kCosAzimuth,
  kSinAzimuth,
  kCosElevation,
  kSinElevation,
  kSquaredIncidence,
  kBump,
  kCosWave,
  kSinWave
};

// The reading is too large by factor * theta * g: g = 1, the range, a harmonic of the angle, the square (rad^2) of the
// angle between the line of sight and a marker's axis, or a bump (bump.h) or a wave of a reading (models/sight.h).
struct SightTerm {
  int parameter;
  Sensed sensed;
  SightLaw law;
  Vector3<double> instrument;  // m, in the measurement frame
  double factor = 1.0;
  int marker = -1;                                  // -1: every marker
  Vector3<double> axis = Vector3<double>::UnitZ();  // of kSquaredIncidence, unit, in the marker's frame
  Sensed over = Sensed::kRange;                     // of kBump, kCosWave, kSinWave, as the next two: rad or m
  double centre = 0.0;                              // of the bump
  double width = 1.0;                               // of the bump; the wave's period
};

// The torque on e was measured: tau_e is this, whatever hangs on the arm.
struct StatedTorque {
  int transform;
  double torque;  // N m, or N
};

// All terms of all effects in one shot.
struct ShotTerms {
  // Compiled once (effect.cc), not in each file that holds one.
  ShotTerms();
  ShotTerms(const ShotTerms&);
  ShotTerms(ShotTerms&&) noexcept;
  ShotTerms& operator=(const ShotTerms&);
  ShotTerms& operator=(ShotTerms&&) noexcept;
  ~ShotTerms();

  std::vector<SlotTerm> slots;
  std::vector<ElasticTerm> elastic;
  std::vector<SagTerm> sags;
  std::vector<WrenchTerm> wrenches;
  std::vector<MarkerTerm> markers;
  std::vector<BaseTerm> base;
  std::vector<StationTerm> station;
  std::vector<SightTerm> sights;
  std::vector<StatedTorque> torques;
};

constexpr int kApproachNotStated = 2;

// What a shot is, other than its wrenches: all that an effect may look at.
struct ShotConditions {
  Eigen::VectorXd q;  // commanded, as in the file
  std::string station;
  std::string load = kNoLoad;
  bool has_time = false;
  double time = 0.0;          // s since the earliest row of all: one clock for the whole campaign
  double station_time = 0.0;  // s since the station's earliest row
  int campaign = 0;           // shots of another one are not remembered
  bool has_temperature = false;
  double temperature = 0.0;   // K above the mean of the data
  std::vector<int> approach;  // -1, 0, +1 per joint, or kApproachNotStated; empty: none is stated
  Vector3<double> gravity = -kStandardGravity * Vector3<double>::UnitZ();  // m/s^2
  WrenchFrame gravity_frame = WrenchFrame::kMeasurement;
  Vector3<double> instrument = Vector3<double>::Zero();  // m, where it stands in the measurement frame
  std::vector<AppliedWrench> load_wrenches;              // of the shot's own load
  Eigen::VectorXd joint_torques;  // N m or N about each joint's positive direction, measured; empty: the model's count

  // False too where only other joints' directions are stated.
  bool StatesApproachOf(int joint) const { return !approach.empty() && approach[joint] != kApproachNotStated; }
};

// What kind of thing an effect acts on; its specs name one of these.
enum class EffectTarget { kJoint, kError, kBase, kRobot, kStation, kLoad, kMarker };

// An unknown of an effect, linear in its terms.
struct EffectParameter {
  std::string name;  // cos; with its unit cos_urad in files
  Quantity quantity;
  // Size that machines show (source: EffectDefinition::sizes), SI. `of_motion`: what it turns (rad) or moves (m) at the
  // largest excitation among the rows, because its own size goes with the machine's: 70 urad/Nm on the wrist of a
  // small arm are 0.3 urad/Nm on a large one. 0: not stated.
  double typical = 0.0;
  bool of_motion = false;
  // A mass, a gap, what a part gives way or grows by: no machine has less than nothing of it.
  bool not_negative = false;
};
// The same parameter, with that sign alone.
inline EffectParameter NotNegative(EffectParameter parameter) {
  parameter.not_negative = true;
  return parameter;
}

// A choice that is made in the robot file and not estimated.
struct SettingDefinition {
  // kMoment: s of the campaign's clock.
  enum class Kind { kInteger, kNumber, kMoment, kJoint, kChoice };
  std::string name;
  Kind kind = Kind::kInteger;
  std::string fallback;              // "" : required, unless fallback_of says it
  std::vector<std::string> choices;  // of kChoice; of kNumber: what the diagnosis scans
  int most_scanned = 0;              // of kInteger, by the diagnosis; 0: as many as the configurations resolve
  // The fallback is not written out: an effect that has it is the one without the setting.
  bool silent = false;
  bool one_each =
      false;  // a target has one value of it: two uses of the effect there that differ in it cannot both hold
  std::string (*fallback_of)(const Robot& robot) = nullptr;  // where it depends on the robot
  double above = -1e300;                                     // of kNumber: values are greater, but for the fallback
  int least = 1, most = 1000;                                // of kInteger
  std::string greater_than = {};                             // of kNumber: another setting, stated before it
  std::string only_with = {};  // "by=torque": means something only where that setting has that value
  // It acts by what is remembered alone (EffectDefinition::remember): a choice that remembers what the fallback does is
  // the same effect.
  bool is_of_memory = false;
  bool turns = false;  // of kJoint: one that turns, as the effect's own

  bool MeansSomethingFor(const EffectSpec& spec) const;
  std::string FallbackFor(const Robot& robot) const { return fallback_of != nullptr ? fallback_of(robot) : fallback; }
};

// What must be among the data or in the model before an effect can be determined.
enum class EffectNeeds { kNothing, kLoads, kCompliances, kNoCompliances };

// What an effect of a joint is on one that slides.
enum class OnSlide {
  kUndefined,  // its law or its units are those of a joint that turns: refused
  kStated,     // as on any other, where a file states it
  kDiagnosed   // and weighed as a cause
};

// What drives it, for plots: the angle of its joint (or of the joint that a setting names), time or temperature. The
// latter two must be among the columns.
enum class EffectDriver { kJoint, kTime, kTemperature };

// What a definition states of all its uses. What drives one use only EffectDefinition::DrivenBy says: a setting of it
// may say otherwise.
class StatedDriver {
 public:
  StatedDriver& operator=(EffectDriver driver) {
    driver_ = driver;
    return *this;
  }

 private:
  friend struct EffectDefinition;
  EffectDriver driver_ = EffectDriver::kJoint;
};

// What says which way an effect's joint is pressed: the rows' column approach, or the torque on it.
enum class PressedBy { kNothing, kApproach, kTorque };

// What Apply is given: the model's chain (with tilt slots), the targets by
// index, and where this use's parameters start.
struct EffectContext {
  const Robot* robot;
  const EffectSpec* spec;
  const ShotConditions* shot;
  const std::vector<std::string>* markers;
  int first_parameter;
  double memory = 0.0;  // of EffectDefinition::remember

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
  EffectTarget target = EffectTarget::kJoint;
  // Both are needed: null is refused where a robot carries the definition.
  std::vector<EffectParameter> (*parameters)(const Robot& robot, const EffectSpec& spec) = nullptr;
  void (*apply)(const EffectContext& context, ShotTerms* terms) = nullptr;

  std::vector<SettingDefinition> settings = {};
  bool tilts = false;  // needs the tilt slots of its joint, or of the foot
  EffectNeeds needs = EffectNeeds::kNothing;
  // Sizes that are stated as a motion are those of the target that moves most: what a link weighs does not grow where
  // its weight turns its joint little, about a nearly vertical axis.
  bool one_size = false;
  bool is_weight = false;  // a force or a moment: it acts only where something gives way
  StatedDriver driven_by = {};
  // "" or the column that this shot lacks, e.g. "approach3"; null: none but what drives it.
  std::string (*missing)(const EffectContext& context) = nullptr;
  PressedBy (*pressed_by)(const EffectSpec& spec) = nullptr;  // null: it asks for no such thing
  std::string separate_by = {};  // which data distinguish it from its rivals; {target} is replaced
  std::string note = {};         // what to bear in mind where it is named
  std::string sizes = {};        // where the typical sizes are from
  // What this use keeps of the shots before each: one number per shot. `campaign` is in the order it was measured.
  // Null: nothing of the kind.
  std::vector<double> (*remember)(const Robot& robot, const EffectSpec& spec,
                                  const std::vector<const ShotConditions*>& campaign) = nullptr;
  // A description for what no effect explains: the diagnosis does not weigh it against the others.
  bool is_learnt = false;
  OnSlide on_slide = OnSlide::kUndefined;
  double largest = 5.0;  // that machines show, in hold limits (QuantityTraits) of its parameters

  PressedBy PressedByOf(const EffectSpec& spec) const { return pressed_by ? pressed_by(spec) : PressedBy::kNothing; }
  // What the setting `by` of a learnt one says, or else driven_by.
  EffectDriver DrivenBy(const EffectSpec& spec) const;
  // Something that happens at a moment: as it is from there on, whatever comes.
  bool IsOfAMoment() const;
};

// The joint of this use that slides although the effect is of joints that turn; "": none. All its joints are there.
std::string JointThatSlides(const Chain& chain, const EffectDefinition& definition, const EffectSpec& spec);

// Silent Rx, Ry, Rz right after a joint (joint >= 0) or at the foot (-1).
void AddTiltSlots(int joint, Chain* chain);
// The slot about `axis` (x, y, z) there.
int TiltSlot(const Chain& chain, int joint, Axis axis);
// A joint's own axis and its two others in cyclic order: about z, u = x, v = y.
Axis AxisOf(const Chain& chain, int joint);
Axis OtherAxis(Axis axis, int which);  // which: 0 = u, 1 = v

}  // namespace sagitta

#include "problems/io/import/column_meaning.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <optional>
#include <set>

#include "problems/io/import/header_words.h"
#include "problems/io/import/joint_columns.h"
#include "problems/io/import/mapped_columns.h"
#include "problems/io/trimmed.h"
#include "problems/text.h"

namespace sagitta {
namespace {

using Words = std::vector<std::string>;

const std::set<std::string> kMeasuredWords = {"measurement", "measured", "meas",    "actual",   "act",   "ist",  "mess",
                                              "messwert",    "gemessen", "tracker", "lt",       "leica", "faro", "smr",
                                              "reading",     "mesuré",   "mesure",  "misurato", "medido"};
const std::set<std::string> kTargetWords = {
    "goal",     "target",   "tgt",       "nominal",   "nom",         "commanded", "command",    "cmd",
    "desired",  "des",      "ref",       "reference", "setpoint",    "soll",      "planned",    "plan",
    "t",        "model",    "predicted", "pred",      "theoretical", "theo",      "calculated", "calc",
    "computed", "expected", "sim",       "simulated", "fk",          "controller"};
const std::set<std::string> kDifferenceWords = {"dif", "diff",      "difference", "delta", "error", "err",
                                                "dev", "deviation", "residual",   "d",     "res",   "offset"};
const std::set<std::string> kSigmaWords = {"std",   "sigma",       "stddev", "sd",      "sdev",
                                           "stdev", "uncertainty", "unc",    "standard"};
const std::set<std::string> kUnclearWords = {"uncertainty", "unc"};  // a standard deviation, or twice that
// Words that go with a position and say nothing about whose it is.
const std::set<std::string> kPointWords = {"point", "pos", "position", "coordinate", "coord", "p", "xyz"};

bool IsNumber(const std::string& word) {
  return !word.empty() && word.find_first_not_of("0123456789") == std::string::npos;
}

ColumnMeaning Unused(const std::string& why) {
  ColumnMeaning meaning;
  meaning.why = why;
  return meaning;
}

ColumnMeaning OfJoint(int index) {
  ColumnMeaning meaning;
  meaning.role = Role::kJoint;
  meaning.index = index;
  return meaning;
}

// Exactly as the robot calls it: what its words and its end mean elsewhere (joint_1_s, in seconds) they do not mean
// here.
std::optional<ColumnMeaning> AsOwnJoint(const std::string& name, const std::vector<std::string>& joints) {
  for (size_t j = 0; j < joints.size(); ++j) {
    if (LowerCaseOf(joints[j]) == name && AxisNamed(name) < 0) return OfJoint(static_cast<int>(j));
  }
  return std::nullopt;
}

// Universal Robots' joints in the order of their description, wherever the name has them.
std::optional<int> UniversalJoint(const std::string& name) {
  static const Words kUniversal = {"shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3"};
  for (size_t j = 0; j < kUniversal.size(); ++j) {
    if (name.find(kUniversal[j]) != std::string::npos) return static_cast<int>(j);
  }
  return std::nullopt;
}

// joint_1, q1, A1, "Axis 1", "J1", "actual_q_1", "joint 1 angle": the number, as written.
std::optional<int> NumberedJoint(const Words& words) {
  static const std::set<std::string> kJoint = {
      "q",  "j",   "joint",        "joints",       "axis",   "achse",  "axe",  "a",   "theta", "θ",
      "th", "jnt", "articulation", "articulación", "gelenk", "giunto", "asse", "eje", "rax"};
  static const std::set<std::string> kAround = {"angle", "pos", "position", "value", "robot", "encoder", "robax"};
  std::optional<int> number;
  bool named = false;
  for (const std::string& word : words) {
    if (IsNumber(word) && !number && named) {
      number = std::stoi(word.substr(0, 3));
    } else if (kJoint.count(word)) {
      named = true;
    } else if (!kAround.count(word) && !kTargetWords.count(word) && !kMeasuredWords.count(word)) {
      return std::nullopt;
    }
  }
  return named ? number : std::nullopt;
}

std::optional<ColumnMeaning> AsJoint(const std::string& name, const Words& words,
                                     const std::vector<std::string>& joints) {
  static const std::set<std::string> kOtherQuantities = {
      "velocity",        "velocities",    "vel",   "speed",       "qd",           "rate",    "acceleration",
      "accelerations",   "acc",           "accel", "qdd",         "jerk",         "current", "currents",
      "strom",           "voltage",       "power", "temperature", "temperatures", "temp",    "temperatur",
      "geschwindigkeit", "beschleunigung"};
  if (Has(words, kSigmaWords) || Has(words, kDifferenceWords)) return std::nullopt;
  if (const auto own = AsOwnJoint(name, joints)) return own;
  const std::optional<int> universal = UniversalJoint(name);
  if (universal && Has(words, kOtherQuantities)) return Unused("of a joint, and not its angle or travel");
  const std::optional<int> number = universal ? std::nullopt : NumberedJoint(words);
  if (!universal && !number) return std::nullopt;
  // Counted from 1; a table that counts from 0 has a joint -1.
  ColumnMeaning meaning = OfJoint(universal ? *universal : *number - 1);
  meaning.is_numbered = !universal;
  meaning.is_actual = Has(words, kMeasuredWords);
  meaning.is_commanded = Has(words, kTargetWords);
  return meaning;
}

constexpr char kExpanded[] =
    "an expanded uncertainty (U = 2 sigma), which is not read: a column sigma_x_mm of half its values is";

// "U95 X", "Uncertainty X (k=2)", "expanded unc. x"
bool IsExpanded(const Words& words) {
  if (Has(words, {"expanded", "erweitert", "erweiterte"})) return true;
  for (size_t i = 0; i + 1 < words.size(); ++i) {
    if (words[i] == "u" && words[i + 1] == "95") return true;
    if (words[i] == "k" && words[i + 1] == "2") return true;
  }
  return false;
}

std::optional<ColumnMeaning> AsPoint(const Words& words) {
  int axis = -1;
  bool foreign = false;
  for (const std::string& word : words) {
    if (AxisNamed(word) >= 0 && axis < 0) {
      axis = AxisNamed(word);
    } else if (AxisNamed(word) >= 0) {
      return std::nullopt;
    } else if (word.size() == 2 && word[0] == 'd' && AxisNamed(word.substr(1)) >= 0) {
      ColumnMeaning difference;
      difference.role = Role::kDifference;
      difference.index = AxisNamed(word.substr(1));
      return difference;
    } else if (!kMeasuredWords.count(word) && !kTargetWords.count(word) && !kDifferenceWords.count(word) &&
               !kSigmaWords.count(word) && !kPointWords.count(word)) {
      foreign = true;
    }
  }
  if (axis < 0) return std::nullopt;
  if (IsExpanded(words)) return Unused(kExpanded);
  ColumnMeaning meaning;
  meaning.index = axis;
  meaning.says_measured = Has(words, kMeasuredWords);
  if (Has(words, kSigmaWords)) {
    meaning.role = foreign ? Role::kOther : Role::kSigma;
    meaning.may_be_expanded = Has(words, kUnclearWords) && !Has(words, {"std", "standard", "sigma"});
  } else if (Has(words, kDifferenceWords)) {
    meaning.role = Role::kDifference;
  } else if (Has(words, kTargetWords)) {
    meaning.role = Role::kTarget;
  } else {
    meaning.role = foreign ? Role::kOther : Role::kPoint;
  }
  if (meaning.role == Role::kOther) meaning.why = "whose coordinate this is the name does not say";
  return meaning;
}

// {0 .. 2 of an angle, or 0 .. 3 of a quaternion, whether it is one}: rx, yaw, "Rotation X", qw, "quat x".
std::optional<std::pair<int, bool>> RotationPart(const std::string& word, bool after_rotation, bool after_quaternion) {
  static const Words kAngles = {"rx", "ry", "rz", "roll", "pitch", "yaw"};
  static const Words kParts = {"qw", "qx", "qy", "qz", "ow", "ox", "oy", "oz"};
  static const Words kLetters = {"w", "x", "y", "z"};
  const auto place = [&word](const Words& names) {
    const auto found = std::find(names.begin(), names.end(), word);
    return found == names.end() ? -1 : static_cast<int>(found - names.begin());
  };
  if (place(kAngles) >= 0) return std::make_pair(place(kAngles) % 3, false);
  if (place(kParts) >= 0) return std::make_pair(place(kParts) % 4, true);
  if (after_quaternion && place(kLetters) >= 0) return std::make_pair(place(kLetters), true);
  // "Rotation W" makes a quaternion of its neighbours (TakeRotation).
  if (after_rotation && word == "w") return std::make_pair(0, true);
  if (after_rotation && AxisNamed(word) >= 0) return std::make_pair(AxisNamed(word), false);
  return std::nullopt;
}

std::optional<ColumnMeaning> AsRotation(const Words& words) {
  static const std::set<std::string> kRotation = {"rot", "rotation", "orientation", "euler", "angle"};
  static const std::set<std::string> kQuaternion = {"quat", "quaternion"};
  std::optional<std::pair<int, bool>> part;
  bool rotation = false, quaternion = false, foreign = false;
  for (const std::string& word : words) {
    const auto found = RotationPart(word, rotation, quaternion);
    rotation |= kRotation.count(word) > 0;
    quaternion |= kQuaternion.count(word) > 0;
    if (found && !part) {
      part = found;
    } else if (found) {
      return std::nullopt;
    } else if (!kRotation.count(word) && !kQuaternion.count(word) && !kMeasuredWords.count(word) &&
               !kTargetWords.count(word) && !kSigmaWords.count(word) && !kDifferenceWords.count(word)) {
      foreign = true;
    }
  }
  if (!part) return std::nullopt;
  ColumnMeaning meaning;
  meaning.index = part->first;
  meaning.says_measured = Has(words, kMeasuredWords);
  if (Has(words, kTargetWords) || Has(words, kDifferenceWords)) {
    meaning.why = "a rotation that was meant, or a difference";
  } else if (foreign) {
    meaning.why = "whose rotation this is the name does not say";
  } else if (Has(words, kSigmaWords)) {
    meaning.role = part->second ? Role::kOther : Role::kAngleSigma;
    meaning.why = part->second ? "a standard deviation of a part of a quaternion" : "";
  } else {
    meaning.role = part->second ? Role::kQuaternion : Role::kRotation;
  }
  return meaning;
}

// tau1, "joint 1 torque", torque_1, "effort[0]"; of motor currents nothing follows without the gear.
std::optional<ColumnMeaning> AsTorque(const std::string& name, const Words& words,
                                      const std::vector<std::string>& joints) {
  static const std::set<std::string> kTorque = {"tau", "torque", "torques", "drehmoment", "effort"};
  static const std::set<std::string> kAround = {"joint", "j", "axis", "a", "achse", "sensor", "ext", "external"};
  if (!Has(words, kTorque)) return std::nullopt;
  ColumnMeaning meaning;
  const std::optional<int> universal = UniversalJoint(name);
  if (universal) meaning.index = *universal;
  if (universal) meaning.role = Role::kTorque;
  bool foreign = Has(words, {"ext", "external"});  // without the arm's own weight: other torques than those asked for
  for (const std::string& word : words) {
    const auto named = std::find_if(joints.begin(), joints.end(),
                                    [&word](const std::string& joint) { return LowerCaseOf(joint) == word; });
    if (universal) break;
    if (IsNumber(word) && meaning.role != Role::kTorque) {
      meaning.index = std::stoi(word.substr(0, 3)) - 1;
      meaning.role = Role::kTorque;
    } else if (named != joints.end() && meaning.role != Role::kTorque) {
      meaning.index = static_cast<int>(named - joints.begin());
      meaning.role = Role::kTorque;
    } else if (!kTorque.count(word) && !kAround.count(word) && !kMeasuredWords.count(word)) {
      foreign = true;
    }
  }
  if (Has(words, kTargetWords)) return Unused("a torque that was meant, not measured");
  if (foreign || meaning.role != Role::kTorque) return Unused("whose torque this is the name does not say");
  return meaning;
}

// Names that measurements.csv has, and what people call them.
std::optional<std::string> TextColumn(const Words& words) {
  static const std::vector<std::pair<std::string, std::set<std::string>>> kNames = {
      {"config", {"config", "configuration", "pose"}},
      {"marker", {"marker", "reflector", "reflektor", "nest", "smr", "prism", "prisma", "ball", "kugel"}},
      {"station", {"station", "setup", "placement", "standpunkt", "aufstellung"}},
      {"visit", {"visit"}},
      {"repeat", {"repeat", "repetition", "shot"}},
      {"load", {"load", "payload", "last", "traglast", "nutzlast"}},
      {"set", {"set"}}};
  static const std::set<std::string> kAround = {"id", "nr", "no", "number", "name", "index"};
  if (words.empty()) return std::nullopt;
  for (const auto& [name, synonyms] : kNames) {
    if (!synonyms.count(words[0])) continue;
    if (std::all_of(words.begin() + 1, words.end(), [](const std::string& word) { return kAround.count(word) > 0; }))
      return name;
  }
  return std::nullopt;
}

std::optional<ColumnMeaning> AsLoadOrApproach(const std::string& name, const Words& words) {
  const Words& wrench = WrenchNames();
  const auto found = std::find(wrench.begin(), wrench.end(), name);
  ColumnMeaning meaning;
  if (found != wrench.end()) {
    meaning.role = Role::kWrench;
    meaning.index = static_cast<int>(found - wrench.begin());
    return meaning;
  }
  if (words.size() == 2 && words[0] == "approach" && IsNumber(words[1])) {
    meaning.role = Role::kApproach;
    meaning.index = std::stoi(words[1]) - 1;
    return meaning;
  }
  return std::nullopt;
}

// "xact", "ynom", "zmeas" as two words each.
Words Parted(const Words& words) {
  Words parted;
  for (const std::string& word : words) {
    const std::string rest = word.substr(1);
    const bool is_known = kMeasuredWords.count(rest) || kTargetWords.count(rest) || kDifferenceWords.count(rest);
    if (AxisNamed(word.substr(0, 1)) >= 0 && rest.size() > 2 && is_known) {
      parted.push_back(word.substr(0, 1));
      parted.push_back(rest);
    } else {
      parted.push_back(word);
    }
  }
  return parted;
}

ColumnMeaning ByName(const std::string& header, const std::vector<std::string>& joints) {
  const std::string name = NameWithoutUnit(header);
  const Words words = Parted(WordsOf(StemOf(header)));
  if (words.empty()) return Unused("no name");
  if (words.size() == 1 && words[0].size() == 2 && words[0][0] == 'u' && AxisNamed(words[0].substr(1)) >= 0) {
    return Unused("an uncertainty; whether it is a standard deviation the name does not say");
  }
  if (const auto text = TextColumn(words)) {
    ColumnMeaning meaning;
    meaning.role = Role::kText;
    meaning.name = *text;
    return meaning;
  }
  if (const auto load = AsLoadOrApproach(name, words)) return *load;
  if (const auto torque = AsTorque(name, words, joints)) return *torque;
  if (const auto joint = AsJoint(name, words, joints)) return *joint;
  if (const auto rotation = AsRotation(words)) return *rotation;
  static const std::set<std::string> kTemperature = {"temperature", "temp", "temperatur"};
  static const std::set<std::string> kTime = {"time", "timestamp", "datetime", "date", "datum", "uhrzeit", "zeit"};
  // How long something lasts, and what a part of the machine has.
  static const std::set<std::string> kLasts = {"exposure", "integration", "cycle",      "dwell",  "settling",
                                               "duration", "delay",       "processing", "flight", "averaging"};
  static const std::set<std::string> kParts = {"motor",      "gear",  "gearbox", "joint",   "axis", "achse",
                                               "drive",      "cpu",   "board",   "winding", "oil",  "encoder",
                                               "controller", "elbow", "wrist",   "shoulder"};
  ColumnMeaning meaning;
  Words others;
  std::copy_if(words.begin(), words.end(), std::back_inserter(others),
               [](const std::string& word) { return kTemperature.count(word) == 0; });
  if (Has(words, kTemperature) && (Has(words, kParts) || NumberedJoint(others)))
    return Unused("the temperature of a part");
  if (Has(words, kTime) && Has(words, kLasts)) return Unused("how long something lasts");
  if (Has(words, kTemperature)) meaning.role = Role::kTemperature;
  if (Has(words, kTime)) meaning.role = Role::kTime;
  if (meaning.role != Role::kOther) return meaning;
  if (const auto point = AsPoint(words)) return *point;
  return Unused("not known");
}

}  // namespace

namespace {

// Texts have none; times are looked at together with their numbers (time_column.h).
bool HasUnitsOfItsOwn(Role role) { return role == Role::kText || role == Role::kTime; }

// Whether what looks like a unit that is not read is one, and no remark: in square brackets, by its word, or a share.
bool IsForeignUnit(const std::string& header, const NameWithUnreadUnit& unread) {
  return IsUnit(unread.unit) || unread.unit == "%" || header.find("[" + unread.unit + "]") != std::string::npos;
}

}  // namespace

ColumnMeaning MeaningOf(const std::string& header, const std::vector<std::string>& joints) {
  static const std::string kPosition = "position.";
  const std::string whole = LowerCaseOf(std::string(Trimmed(header)));
  if (const auto own = AsOwnJoint(whole, joints)) return *own;
  if (whole.rfind(kPosition, 0) == 0) {
    if (const auto own = AsOwnJoint(whole.substr(kPosition.size()), joints)) return *own;
  }
  ColumnMeaning meaning = ByName(header, joints);
  meaning.unit = UnitInHeader(header);
  const NameWithUnreadUnit unread = UnreadUnitIn(header);
  const bool is_known = meaning.role == Role::kOther ? ByName(unread.name, joints).role != Role::kOther
                                                     : !HasUnitsOfItsOwn(meaning.role) && IsForeignUnit(header, unread);
  if (!unread.unit.empty() && is_known) {
    const bool is_commanded = meaning.is_commanded;
    meaning = ColumnMeaning();
    meaning.is_commanded = is_commanded;
    meaning.unread_unit = unread.unit;
    meaning.why = "'" + unread.unit + "' is no unit that is read";
  }
  const auto foreign = ForeignUnitOf(LowerCaseOf(header), {"temperature_degC"});
  if (meaning.role == Role::kTemperature && meaning.unit.empty() && foreign) meaning = Unused(foreign->Words());
  if (meaning.role == Role::kTarget) meaning.why = "a position that was meant, not measured";
  if (meaning.role == Role::kDifference) meaning.why = "a difference, not a position";
  return meaning;
}

namespace {

// tx, ty, tz are a translation where no column is called a point; torques of that name are, by the robot, none.
void NameTranslations(const std::vector<std::string>& headers, std::vector<ColumnMeaning>* meanings) {
  const auto is_of_point = [](const ColumnMeaning& meaning) {
    return meaning.role == Role::kPoint || meaning.role == Role::kTarget || meaning.role == Role::kDifference;
  };
  if (std::any_of(meanings->begin(), meanings->end(), is_of_point)) return;
  std::array<std::vector<size_t>, 3> columns;
  for (size_t c = 0; c < headers.size(); ++c) {
    const ColumnMeaning& meaning = (*meanings)[c];
    const Words words = WordsOf(StemOf(headers[c]));
    if (meaning.role != Role::kOther || (!meaning.unit.empty() && !IsLengthUnit(meaning.unit))) continue;
    const bool is_one = words.size() == 1 && words[0].size() == 2 && words[0][0] == 't';
    const int axis = is_one ? AxisNamed(words[0].substr(1)) : -1;
    if (axis >= 0) columns[static_cast<size_t>(axis)].push_back(c);
  }
  for (const std::vector<size_t>& each : columns) {
    if (each.size() != 1) return;
  }
  for (size_t axis = 0; axis < columns.size(); ++axis) {
    ColumnMeaning& meaning = (*meanings)[columns[axis][0]];
    meaning.role = Role::kPoint;
    meaning.index = static_cast<int>(axis);
    meaning.why.clear();
  }
}

}  // namespace

std::vector<ColumnMeaning> MeaningsOf(const std::vector<std::string>& headers, const std::vector<Joint>& joints) {
  const Words names = JointNames(joints);
  std::vector<ColumnMeaning> meanings;
  for (const std::string& header : headers) meanings.push_back(MeaningOf(header, names));
  NameJointsTogether(headers, joints, &meanings);
  NameTranslations(headers, &meanings);
  return meanings;
}

}  // namespace sagitta

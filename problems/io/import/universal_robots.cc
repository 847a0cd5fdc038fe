// Universal Robots' kinematics: ROS' calibration.yaml (ur_calibration) and the controller's .conf files.
//
//   calibration.yaml   kinematics: {shoulder: {x, y, z, roll, pitch, yaw}, upper_arm: …}; m, rad. Origins as in a URDF,
//                      every joint turns about z; the base is the controller's, the last frame its flange.
//   urcontrol.conf     [DH] a, d, alpha (theta absent: 0), standard convention; m, rad
//   calibration.conf   [mounting] delta_theta, delta_a, delta_d, delta_alpha: added to the robot's [DH]
#include "problems/io/import/universal_robots.h"

#include <algorithm>
#include <array>
#include <map>
#include <sstream>

#include "models/dh_from_chain.h"
#include "problems/input_error.h"
#include "problems/io/import/robot_reading.h"
#include "problems/io/pattern.h"
#include "problems/io/robot_units.h"
#include "problems/io/trimmed.h"
#include "problems/io/units.h"
#include "problems/io/urdf_robot.h"
#include "problems/io/yaml_reader.h"
#include "problems/limits.h"
#include "problems/text.h"

namespace sagitta {
namespace {

struct UrJoint {
  const char* link;
  const char* joint;
};
constexpr UrJoint kUrJoints[] = {{"shoulder", "shoulder_pan_joint"}, {"upper_arm", "shoulder_lift_joint"},
                                 {"forearm", "elbow_joint"},         {"wrist_1", "wrist_1_joint"},
                                 {"wrist_2", "wrist_2_joint"},       {"wrist_3", "wrist_3_joint"}};

// One list of a .conf: "delta_a = [ 0.1, -2e-05 ]   # comment".
using ConfLists = std::map<std::string, std::vector<double>>;

std::vector<double> NumbersOfList(const std::string& text, const std::string& path, int line, const std::string& name) {
  std::vector<double> list;
  std::istringstream cells(text);
  for (std::string cell; std::getline(cells, cell, ',');) {
    cell = std::string(Trimmed(cell));
    const std::optional<double> value = ParseNumber(cell);
    if (!value) throw InputError({path, line, name}, "'" + cell + "' is no number");
    list.push_back(*value);
  }
  return list;
}

// A list may go on over the lines that follow it.
ConfLists ReadConfLists(const std::string& text, const std::string& path) {
  static const std::regex kList =
      MakePattern(R"(^\s*(delta_theta|delta_a|delta_d|delta_alpha|theta|a|d|alpha)\s*=\s*\[)");
  ConfLists lists;
  std::istringstream lines(text);
  const auto without_comment = [](const std::string& line) { return line.substr(0, line.find('#')); };
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::smatch match;
    line = without_comment(line);
    if (!SearchPattern(line, &match, kList)) continue;
    const std::string name = match[1];
    const int first = number;
    std::string list = match.suffix();
    while (list.find(']') == std::string::npos && std::getline(lines, line)) list += without_comment(line), ++number;
    if (list.find(']') == std::string::npos) throw InputError({path, first, name}, "the list is not closed");
    lists[name] = NumbersOfList(list.substr(0, list.find(']')), path, first, name);
  }
  return lists;
}

// Of lists that belong together: none counts as zeros.
void CheckTogether(const ConfLists& lists, const std::vector<std::string>& names, const std::string& path) {
  const auto is_there = [&](const std::string& name) { return lists.count(name) > 0; };
  if (std::none_of(names.begin(), names.end(), is_there)) return;
  for (const std::string& name : names) {
    if (!is_there(name)) throw InputError({path, 0, name}, "this list is missing, and others of the table are there");
  }
}

void AddTo(const ConfLists& lists, const std::string& name, double DhLink::*field, const std::string& path,
           DhTable* table) {
  const auto found = lists.find(name);
  if (found == lists.end()) return;
  if (found->second.size() != table->links.size()) {
    throw InputError({path, 0, name}, "the list has " + std::to_string(found->second.size()) + " numbers, " +
                                          std::to_string(table->links.size()) + " joints are expected");
  }
  for (size_t i = 0; i < table->links.size(); ++i) table->links[i].*field += found->second[i];
}

std::vector<Joint> UrJoints(size_t count) {
  std::vector<Joint> joints;
  for (size_t j = 0; j < count; ++j) joints.push_back({"j" + std::to_string(j + 1), JointType::kRevolute, {}, {}});
  return joints;
}

// Along z, the axis before, origins may run far where axes are nearly parallel.
void CheckOrigin(const Vector3<double>& xyz, const Vector3<double>& rpy, const InputError::Where& where) {
  for (int i = 0; i < 2; ++i) CheckMetres(xyz[i], std::string(1, "xy"[i]), where);
  for (int i = 0; i < 3; ++i) CheckRadians(rpy[i], std::array{"roll", "pitch", "yaw"}[i], where);
}

// The nominal lists, m and rad; of the differences, d may be 100 m.
void CheckUnits(const ConfLists& lists, const std::string& path) {
  for (const auto& [name, list] : lists) {
    const bool is_length = name == "a" || name == "d", is_angle = name == "alpha" || name == "theta";
    for (size_t i = 0; i < list.size(); ++i) {
      const std::string number = "number " + std::to_string(i + 1);
      if (is_length) CheckMetres(list[i], number, {path, 0, name});
      if (is_angle) CheckRadians(list[i], number, {path, 0, name});
    }
  }
}

// The table that the deltas belong to.
Robot NominalOf(const ConfLists& lists, const std::string& path, const std::string& nominal_file) {
  if (lists.count("a") && lists.count("d") && lists.count("alpha")) {
    DhTable table;
    table.links.resize(lists.at("a").size());
    for (size_t j = 0; j < table.links.size(); ++j) table.links[j].joint = static_cast<int>(j);
    return RobotOfTable(UrJoints(table.links.size()), {}, table);
  }
  if (nominal_file.empty()) {
    throw InputError({path, 0, ""}, "this file holds differences from the nominal table only",
                     "--nominal=urcontrol.conf (or any file with the nominal standard DH table)");
  }
  const Robot nominal = ReadAnyRobot(nominal_file).robot;
  if (!nominal.dh || nominal.dh->convention != DhConvention::kStandard) {
    throw InputError({nominal_file, 0, ""}, "the nominal robot has no standard DH table, which the differences are of");
  }
  return nominal;
}

// With a point: 1e-04 is a text to readers of YAML 1.1, and so to ROS.
std::string YamlNumber(double value) {
  std::string text = FormatNumber(value);
  const size_t exponent = text.find('e');
  if (exponent != std::string::npos && text.find('.') == std::string::npos) text.insert(exponent, ".0");
  return text;
}

std::string Six(const Pose<double>& pose) {
  const Vector3<double> rpy = RpyFromRotation(pose.rotation);
  std::string text;
  for (int i = 0; i < 3; ++i) text += std::string("    ") + "xyz"[i] + ": " + YamlNumber(pose.translation[i]) + "\n";
  const char* names[] = {"roll", "pitch", "yaw"};
  for (int i = 0; i < 3; ++i) text += std::string("    ") + names[i] + ": " + YamlNumber(rpy[i]) + "\n";
  return text;
}

}  // namespace

bool LooksLikeUrCalibration(const std::string& text) {
  // The pattern last: on a long table it needs seconds.
  return text.find("shoulder:") != std::string::npos && text.find("wrist_3:") != std::string::npos &&
         SearchPattern(text, MakePattern(R"((^|\n)kinematics:)"));
}

RobotReading ReadUrCalibration(const std::string& text, const std::string& path) {
  YamlMap root(ParseYaml(text, path));
  YamlMap kinematics(root.Get("kinematics"));
  kinematics.Find("hash");
  UrdfChain chain;
  chain.robot_name = "Universal Robots";
  for (const UrJoint& name : kUrJoints) {
    YamlMap map(kinematics.Get(name.link));
    UrdfJoint joint;
    joint.name = name.joint;
    joint.type = UrdfJoint::Type::kRevolute;
    Vector3<double> rpy;
    for (int i = 0; i < 3; ++i) joint.parent_from_joint.translation[i] = map.Get(std::string(1, "xyz"[i])).Number();
    // One by one: Eigen's << is not to be left by an exception.
    for (int i = 0; i < 3; ++i) rpy[i] = map.Get(std::array{"roll", "pitch", "yaw"}[i]).Number();
    joint.parent_from_joint.rotation = RotationFromRpy(rpy);
    map.Finish();
    CheckOrigin(joint.parent_from_joint.translation, rpy, {path, 0, name.link});
    chain.joints.push_back(joint);
  }
  kinematics.Finish();
  RobotReading reading;
  reading.robot = RobotFromUrdf(chain, path);
  reading.format = "calibration.yaml of Universal Robots";
  reading.notes.push_back("base and flange are the controller's");
  return reading;
}

bool LooksLikeUrConf(const std::string& text) {
  return SearchPattern(text, MakePattern(R"(\n\s*(delta_a|alpha)\s*=\s*\[)")) ||
         SearchPattern(text, MakePattern(R"(^\s*(delta_a|alpha)\s*=\s*\[)"));
}

RobotReading ReadUrConf(const std::string& text, const std::string& path, const RobotReadOptions& options) {
  const ConfLists lists = ReadConfLists(text, path);
  CheckTogether(lists, {"a", "d", "alpha"}, path);
  CheckUnits(lists, path);
  CheckTogether(lists, {"delta_theta", "delta_a", "delta_d", "delta_alpha"}, path);
  RobotReading reading;
  Robot robot = NominalOf(lists, path, options.nominal_file);
  for (const char* prefix : {"", "delta_"}) {
    AddTo(lists, std::string(prefix) + "a", &DhLink::a, path, &*robot.dh);
    AddTo(lists, std::string(prefix) + "d", &DhLink::d, path, &*robot.dh);
    AddTo(lists, std::string(prefix) + "alpha", &DhLink::alpha, path, &*robot.dh);
    AddTo(lists, std::string(prefix) + "theta", &DhLink::theta, path, &*robot.dh);
  }
  reading.robot = RobotOfTable(robot.chain.joints, robot.chain.couplings, *robot.dh);
  reading.robot.name = robot.name.empty() ? "Universal Robots" : robot.name;
  reading.format = "configuration file of Universal Robots";
  reading.notes.push_back(lists.count("delta_a") ? "standard DH, nominal plus the calibration's differences"
                                                 : "standard DH, nominal");
  return reading;
}

std::string RobotToUrConf(const Robot& robot, const DhTable& nominal, const std::string& kept,
                          const std::string& kept_path) {
  std::string why_not;
  const std::optional<DhTable> table = ExactPlainTable(robot.chain, &why_not);
  const auto refuse = [](const std::string& why) -> InputError {
    return InputError(
        {"", 0, ""}, "this robot does not fit into a calibration.conf: " + why,
        "the file has the differences of six standard DH rows, base and flange as the controller has them");
  };
  if (!table) throw refuse(why_not);
  const bool turns = std::all_of(robot.chain.joints.begin(), robot.chain.joints.end(),
                                 [](const Joint& joint) { return joint.type == JointType::kRevolute; });
  if (table->links.size() != 6 || nominal.links.size() != 6 || !turns || !robot.chain.couplings.empty())
    throw refuse("six revolute joints without couplings are expected, of robot and nominal table");
  if (!table->flange_xyz.isZero(0.0) || !table->flange_rpy.isZero(0.0))
    throw refuse("the flange does not lie where a sixth row of a, alpha, d and theta can have it");
  const std::pair<const char*, double DhLink::*> lists[] = {{"delta_theta", &DhLink::theta},
                                                            {"delta_a", &DhLink::a},
                                                            {"delta_d", &DhLink::d},
                                                            {"delta_alpha", &DhLink::alpha}};
  if (kept.size() > limits::kScriptBytes)
    throw InputError({kept_path, 0, ""}, "this is too large for a calibration.conf");
  std::string text = kept.empty() ? "[mounting]\n" : kept;
  for (const auto& [name, field] : lists) {
    std::string list = "[";
    for (size_t j = 0; j < 6; ++j) {
      list += (j == 0 ? " " : ", ") + FormatNumber(table->links[j].*field - nominal.links[j].*field);
    }
    list += " ]";
    if (kept.empty()) {
      text += std::string(name) + " = " + list + "\n";
      continue;
    }
    std::smatch match;
    const std::regex old_list = MakePattern("(^|\n)([ \t]*" + std::string(name) + "[ \t]*=[ \t]*)\\[[^\\]\n]*\\]");
    if (!SearchPattern(text, &match, old_list)) {
      throw InputError({kept_path, 0, name}, "the file has no such list",
                       "a calibration.conf of the same arm is expected");
    }
    text = match.prefix().str() + match[1].str() + match[2].str() + list + match.suffix().str();
  }
  return text;
}

std::string HashOfUrCalibration(const std::string& text, const std::string& path) {
  if (!LooksLikeUrCalibration(text)) return "";
  YamlMap root(ParseYaml(text, path));
  const std::optional<YamlValue> hash = YamlMap(root.Get("kinematics")).Find("hash");
  return hash ? hash->Text() : "";
}

std::string RobotToUrCalibration(const Robot& robot, const std::string& hash) {
  const Chain& chain = robot.chain;
  const auto refuse = [](const std::string& why) -> InputError {
    return InputError({"", 0, ""}, "this robot does not fit into a calibration.yaml: " + why,
                      "the file has six revolute joints, base and flange as the controller has them");
  };
  if (chain.num_joints() != 6 || !chain.couplings.empty())
    throw refuse("it has another number of joints, or coupled ones");
  std::vector<double> values;
  for (const ElementaryTransform& transform : chain.transforms) values.push_back(transform.nominal);
  ChainState<double> state;
  EvaluateChain(chain, values.data(), &state);
  std::string text = "kinematics:\n";
  Pose<double> parent;
  for (int j = 0; j < 6; ++j) {
    const int e = chain.JointTransform(j);
    const ElementaryTransform& joint = chain.transforms[e];
    if (chain.joints[j].type != JointType::kRevolute) throw refuse("joint '" + chain.joints[j].name + "' slides");
    Pose<double> link = state.frames[e + 1];
    if (j == 5) link = state.frames.back();
    // The frame's z has to be the axis: turn it there, the next origin absorbs the rest.
    const Vector3<double> axis = joint.sign * state.frames[e].rotation.col(static_cast<int>(joint.axis));
    if (j == 5) {
      const Vector3<double> away = link.translation - state.frames[e].translation;
      if ((link.rotation.col(2) - axis).norm() > 1e-9 || away.cross(axis).norm() > 1e-9) {
        throw refuse("the flange does not lie on the last axis");
      }
    } else {
      link.rotation = RotationBetween(link.rotation.col(2), axis) * link.rotation;
    }
    const Matrix3<double> back = parent.rotation.transpose();
    text += std::string("  ") + kUrJoints[j].link + ":\n" +
            Six({back * link.rotation, back * (link.translation - parent.translation)});
    parent = link;
  }
  if (!hash.empty()) text += "  hash: " + hash + "\n";
  return text;
}

}  // namespace sagitta

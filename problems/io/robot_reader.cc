#include <algorithm>
#include <filesystem>

#include "problems/choices.h"
#include "problems/compliance_home.h"
#include "problems/input_error.h"
#include "problems/io/effect_entries.h"
#include "problems/io/files.h"
#include "problems/io/robot_checks.h"
#include "problems/io/robot_file.h"
#include "problems/io/robot_parts.h"
#include "problems/io/text_checks.h"
#include "problems/io/urdf_robot.h"
#include "problems/io/yaml_reader.h"
#include "problems/limits.h"
#include "problems/robot_structure.h"
#include "problems/text.h"

namespace sagitta {
namespace {

void ReadLimits(YamlMap* map, Joint* joint) {
  const Dimension dimension = DimensionOf(joint->type);
  joint->min = map->Find("min", dimension);
  joint->max = map->Find("max", dimension);
}

Joint ReadJoint(const YamlValue& value) {
  YamlMap map(value);
  Joint joint;
  joint.name = map.Get("name").Text();
  const bool revolute = map.Get("type").OneOf({"revolute", "prismatic"}) == "revolute";
  joint.type = revolute ? JointType::kRevolute : JointType::kPrismatic;
  ReadLimits(&map, &joint);
  map.Finish();
  if (joint.min && joint.max && *joint.min > *joint.max) {
    value.Fail("the limits of joint '" + joint.name + "' are swapped",
               "min has to be below max; where they are equal, the joint has that value only");
  }
  return joint;
}

std::vector<Joint> ReadJoints(const YamlValue& value) {
  std::vector<Joint> joints;
  const std::vector<YamlValue> items = value.Items();
  if (items.size() > limits::kJoints) value.Fail("a chain has at most " + std::to_string(limits::kJoints) + " joints");
  for (const YamlValue& item : items) {
    const Joint joint = ReadJoint(item);
    for (const Joint& other : joints) {
      if (other.name == joint.name) item.Fail("two joints are called '" + joint.name + "'");
    }
    joints.push_back(joint);
  }
  if (joints.empty()) value.Fail("a robot has at least one joint");
  return joints;
}

// What a joint adds for another is stated once: two statements would add up.
void CheckStatedOnce(const YamlValue& item, const Coupling& coupling, const std::vector<Joint>& joints,
                     const std::vector<Coupling>& in_urdf, const std::vector<Coupling>& before) {
  const auto is_same = [&](const Coupling& other) {
    return other.joint == coupling.joint && other.driver == coupling.driver;
  };
  const std::string pair = "'" + joints[coupling.driver].name + "' drives '" + joints[coupling.joint].name + "'";
  if (std::any_of(in_urdf.begin(), in_urdf.end(), is_same)) {
    item.Fail(pair + " in the URDF already, by <mimic>", "leave it out here: the two would add up");
  }
  if (std::any_of(before.begin(), before.end(), is_same)) {
    item.Fail(pair + " above already", "one ratio per pair of joints: the two would add up");
  }
}

std::vector<Coupling> ReadCouplings(const YamlValue& value, const std::vector<Joint>& joints,
                                    const std::vector<Coupling>& in_urdf) {
  std::vector<Coupling> couplings;
  for (const YamlValue& item : value.Items()) {
    YamlMap map(item);
    Coupling coupling;
    coupling.joint = ReadJointIndex(map.Get("joint"), joints);
    coupling.driver = ReadJointIndex(map.Get("driver"), joints);
    coupling.ratio = map.Get("ratio").Number();
    map.Finish();
    if (coupling.joint == coupling.driver) item.Fail("a joint cannot drive itself");
    if (joints[coupling.joint].type != joints[coupling.driver].type) {
      item.Fail("a coupling joins two revolute or two prismatic joints");
    }
    CheckStatedOnce(item, coupling, joints, in_urdf, couplings);
    couplings.push_back(coupling);
  }
  return couplings;
}

DhLink ReadDhLink(const YamlValue& value, const std::vector<Joint>& joints) {
  YamlMap map(value);
  DhLink link;
  link.joint = ReadJointIndex(map.Get("joint"), joints);
  link.a = map.GetLength("a");  // a number that is left out is no zero: it may be a small one that was forgotten
  link.alpha = map.GetAngle("alpha");
  link.d = map.GetLength("d");
  link.theta = map.GetAngle("theta");
  link.beta = map.Angle("beta").value_or(0.0);
  map.Finish();
  return link;
}

void CheckLinkOrder(const YamlValue& links, const DhTable& table, const std::vector<Joint>& joints) {
  if (table.links.size() != joints.size()) {
    links.Fail(
        "there are " + std::to_string(table.links.size()) + " links and " + std::to_string(joints.size()) + " joints",
        "one link per joint, in the order of the joints");
  }
  for (size_t i = 0; i < table.links.size(); ++i) {
    if (table.links[i].joint == static_cast<int>(i)) continue;
    links.Items()[i].Fail(
        "joint '" + joints[table.links[i].joint].name + "' stands where '" + joints[i].name + "' is expected",
        "one link per joint, in the order of the joints");
  }
}

DhTable ReadDhTable(const YamlValue& value, const std::vector<Joint>& joints) {
  YamlMap map(value);
  DhTable table;
  table.convention = *FindChoice<DhConvention>(map.Get("convention").OneOf(WordsOf<DhConvention>()));
  const YamlValue links = map.Get("links");
  for (const YamlValue& link : links.Items()) table.links.push_back(ReadDhLink(link, joints));
  if (const auto flange = map.Find("flange")) {
    YamlMap pose(*flange);
    table.flange_xyz = pose.FindTriple("xyz", Dimension::kLength).value_or(Vector3<double>::Zero());
    table.flange_rpy = pose.FindTriple("rpy", Dimension::kAngle).value_or(Vector3<double>::Zero());
    pose.Finish();
  }
  map.Finish();
  CheckLinkOrder(links, table, joints);
  return table;
}

struct KinematicsKeys {
  std::optional<YamlValue> chain, dh, urdf;
};

KinematicsKeys ReadKinematicsKeys(const YamlValue& value) {
  YamlMap map(value);
  KinematicsKeys keys{map.Find("chain"), map.Find("dh"), map.Find("urdf")};
  map.Finish();
  if (keys.chain.has_value() + keys.dh.has_value() + keys.urdf.has_value() != 1) {
    value.Fail("exactly one description of the kinematics is expected", "one of: chain, dh, urdf");
  }
  return keys;
}

// Joints that the robot file states in addition to its URDF: the same ones; their limits come first.
void TakeLimits(const YamlValue& value, const std::vector<Joint>& stated, Chain* chain) {
  const std::vector<std::string> names = JointNames(chain->joints);
  const std::string hint = "the URDF has " + Joined(names) + "; joints: may be left out";
  if (stated.size() != chain->joints.size()) value.Fail("these are not the joints of the URDF", hint);
  for (size_t j = 0; j < stated.size(); ++j) {
    Joint& joint = chain->joints[j];
    if (stated[j].name != joint.name) value.Items()[j].Fail("'" + joint.name + "' is expected here", hint);
    if (stated[j].type != joint.type) value.Items()[j].Fail("the joint is of the other type in the URDF");
    const bool has_other =
        (stated[j].min && stated[j].min != joint.min) || (stated[j].max && stated[j].max != joint.max);
    if (joint.IsHeld() && has_other)
      value.Items()[j].Fail("'" + joint.name + "' mimics another joint in the URDF: by itself it does not move",
                            "leave its limits out");
    if (stated[j].min) joint.min = stated[j].min;
    if (stated[j].max) joint.max = stated[j].max;
  }
}

void ReadKinematics(const YamlValue& value, const KinematicsKeys& keys, const std::vector<Coupling>& couplings,
                    const std::vector<Joint>& joints, Robot* robot) {
  const auto& [chain, dh, urdf] = keys;
  if (urdf) {
    robot->chain.couplings.insert(robot->chain.couplings.end(), couplings.begin(), couplings.end());
  } else if (dh) {
    robot->dh = ReadDhTable(*dh, joints);
    robot->chain = ChainFromDhTable(joints, couplings, *robot->dh);
  } else {
    robot->chain.joints = joints;
    robot->chain.couplings = couplings;
    robot->chain.transforms = ReadChain(*chain, joints);
  }
  const std::string defect = robot->chain.Defect();
  if (!defect.empty()) value.Fail(defect);
}

// Of the same joints and couplings as the chain.
Kinematics ReadController(const YamlValue& value, const Chain& chain) {
  const KinematicsKeys keys = ReadKinematicsKeys(value);
  if (keys.urdf) value.Fail("a chain or a DH table is expected here", "one of: chain, dh");
  Robot described;
  ReadKinematics(value, keys, chain.couplings, chain.joints, &described);
  return {described.chain, described.dh};
}

Robot ReadRobot(const YamlValue& root, const std::string& file,
                const std::vector<const EffectDefinition*>& own_effects) {
  YamlMap map(root);
  map.ExpectSchema("sagitta/robot/1");
  Robot robot;
  robot.own_effects = own_effects;
  const auto name = map.Find("name");
  const YamlValue kinematics = map.Get("kinematics");
  const KinematicsKeys keys = ReadKinematicsKeys(kinematics);
  const auto joints_value = keys.urdf ? map.Find("joints") : map.Get("joints");
  const auto coupling = map.Find("coupling");
  const auto compliance = map.Find("compliance");
  const auto compensator = map.Find("gravity_compensator");
  const auto effects = map.Find("effects");
  const auto reference = map.Find("reference_temperature_degC");
  const auto controller = map.Find("controller_kinematics");
  map.Finish();

  std::vector<Joint> joints;
  if (joints_value) joints = ReadJoints(*joints_value);
  if (keys.urdf) {
    const UrdfSource source = ReadUrdfSource(*keys.urdf, file);
    const Robot described = ReadUrdfFile(source.path, source.ends);
    robot.name = described.name;
    robot.chain = described.chain;
    if (joints_value) TakeLimits(*joints_value, joints, &robot.chain);
    joints = robot.chain.joints;
  }
  if (name) robot.name = name->Text();
  std::vector<Coupling> couplings;
  if (coupling) couplings = ReadCouplings(*coupling, joints, robot.chain.couplings);
  ReadKinematics(kinematics, keys, couplings, joints, &robot);
  if (controller) robot.controller = ReadController(*controller, robot.chain);
  if (compliance) robot.compliances = ReadCompliances(*compliance, joints);
  if (compensator) robot.gravity_compensator = ReadGravityCompensator(*compensator, joints);
  if (effects) robot.effects = ReadEffects(*effects, robot);
  MoveCompliancesHome(PriorOfCompliance::kStays, &robot);
  if (reference) robot.reference_temperature = reference->Number();
  return robot;
}

}  // namespace

Dimension DimensionOf(JointType type) { return type == JointType::kRevolute ? Dimension::kAngle : Dimension::kLength; }

int ReadJointIndex(const YamlValue& value, const std::vector<Joint>& joints) {
  const std::string name = value.Text();
  const std::vector<std::string> names = JointNames(joints);
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) value.Fail("there is no joint '" + name + "'", SpellingHint(name, names));
  return static_cast<int>(found - names.begin());
}

UrdfSource ReadUrdfSource(const YamlValue& value, const std::string& stated_in) {
  YamlMap map(value);
  const YamlValue file = map.Get("file");
  UrdfSource source;
  if (const auto link = map.Find("base_link")) source.ends.base_link = link->Text();
  if (const auto link = map.Find("tip_link")) source.ends.tip_link = link->Text();
  map.Finish();
  source.path = (std::filesystem::path(stated_in).parent_path() / file.Text()).string();
  std::error_code error;
  if (!std::filesystem::exists(source.path, error)) {
    file.Fail("there is no file '" + Printable(source.path) + "'", "paths are relative to this file");
  }
  return source;
}

Robot ReadRobotText(const std::string& text, const std::string& file_in_messages,
                    const std::vector<const EffectDefinition*>& own_effects) {
  CheckOwnEffects(own_effects);
  if (IsUrdf(file_in_messages, text)) {
    Robot robot = ReadUrdfText(text, file_in_messages);
    robot.own_effects = own_effects;
    CheckRobot(robot, file_in_messages);
    return robot;
  }
  Robot robot = ReadRobot(ParseYaml(text, file_in_messages), file_in_messages, own_effects);
  CheckRobot(robot, file_in_messages);
  return robot;
}

Robot ReadRobotFile(const std::string& path, const std::vector<const EffectDefinition*>& own_effects) {
  return ReadRobotText(ReadTextFile(path), path, own_effects);
}

}  // namespace sagitta

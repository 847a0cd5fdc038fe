#include "problems/io/robot_parts.h"

#include "problems/input_error.h"
#include "problems/io/effect_entries.h"
#include "problems/limits.h"

namespace sagitta {
namespace {

constexpr char kTransformHint[] = "one of Tx_mm, Ty_mm, Tz_mm, Rx_deg, Ry_deg, Rz_deg or, with a joint, Tx .. Rz";

// Tx .. Rz by letters: what a chain entry's key may start with.
struct TransformName {
  const char* name;
  Motion motion;
  Axis axis;
};
constexpr TransformName kTransformNames[] = {
    {"Tx", Motion::kTranslation, Axis::kX}, {"Ty", Motion::kTranslation, Axis::kY},
    {"Tz", Motion::kTranslation, Axis::kZ}, {"Rx", Motion::kRotation, Axis::kX},
    {"Ry", Motion::kRotation, Axis::kY},    {"Rz", Motion::kRotation, Axis::kZ}};

Dimension DimensionOf(Motion motion) { return motion == Motion::kRotation ? Dimension::kAngle : Dimension::kLength; }

// The joint's own keys: {Rz: A1, sign: -1, offset_deg: 12.5}.
void ReadJointTransform(const YamlValue& joint_name, const std::vector<Joint>& joints, YamlMap* map,
                        ElementaryTransform* transform) {
  if (ParseNumber(joint_name.Text())) {
    const std::string unit = transform->is_rotation() ? "_deg" : "_mm";
    joint_name.Fail("a joint's name is expected, this is " + joint_name.Text(),
                    "a fixed transform has its unit in the key, as in Tx_mm or Rz_deg; here: ..." + unit);
  }
  transform->joint = ReadJointIndex(joint_name, joints);
  const Joint& joint = joints[transform->joint];
  if (transform->is_rotation() != (joint.type == JointType::kRevolute)) {
    joint_name.Fail(
        "joint '" + joint.name + "' is " + (transform->is_rotation() ? "prismatic" : "revolute"),
        transform->is_rotation() ? "Tx, Ty or Tz carry a prismatic joint" : "Rx, Ry or Rz carry a revolute joint");
  }
  if (const auto sign = map->Find("sign")) {
    transform->sign = sign->Number();
    if (transform->sign != 1.0 && transform->sign != -1.0) sign->Fail("the sign is 1 or -1");
  }
  transform->nominal = map->Find("offset", DimensionOf(transform->motion)).value_or(0.0);
}

ElementaryTransform ReadTransform(const YamlValue& value, const std::vector<Joint>& joints) {
  YamlMap map(value);
  std::vector<ElementaryTransform> found;
  for (const TransformName& name : kTransformNames) {
    ElementaryTransform transform;
    transform.motion = name.motion;
    transform.axis = name.axis;
    if (const auto joint = map.Find(name.name)) {
      ReadJointTransform(*joint, joints, &map, &transform);
      found.push_back(transform);
    }
    if (const auto fixed = map.Find(name.name, DimensionOf(name.motion))) {
      transform.joint = -1;
      transform.nominal = *fixed;
      found.push_back(transform);
    }
  }
  const auto error = map.Find("error");
  map.Finish();
  if (found.size() != 1) {
    value.Fail("an entry of the chain has exactly one transform, this has " + std::to_string(found.size()),
               kTransformHint);
  }
  if (error) found.front().error = error->Text();
  return found.front();
}

JointCompliance::Node ReadComplianceNode(const YamlValue& value, const Joint& joint, bool in_table) {
  YamlMap map(value);
  JointCompliance::Node node;
  if (!in_table) map.Find("table");  // for the spelling hint; read by the caller
  if (in_table) {
    const YamlMap::Quantity q = map.GetQuantity("q", DimensionOf(joint.type));
    node.q = q.value.NumberIn(q.unit);
  }
  // A rotation per torque, or a travel per force: 1e-6 rad/(N m) or 1e-6 m/N.
  const bool turns = joint.type == JointType::kRevolute;
  const std::string key = turns ? "k_urad_per_Nm" : "k_um_per_N", other = turns ? "k_um_per_N" : "k_urad_per_Nm";
  if (const auto wrong = map.Find(other)) {
    wrong->Fail("'" + joint.name + (turns ? "' turns" : "' slides"), "state its compliance as " + key);
  }
  const YamlValue k = map.Get(key);
  node.k = k.NumberIn(UnitNamed("urad"));
  map.Finish();
  if (node.k < 0.0) k.Fail("a compliance is not below 0", "0 is rigid; leave the joint out where it is");
  if (node.k > limits::kCompliance) k.Fail("no joint is so soft", "at most 1e8, in the unit of the key");
  if (node.k > 0.0 && node.k < limits::kLeastCompliance) k.Fail("no joint is so stiff", "0 is rigid");
  return node;
}

std::vector<JointCompliance::Node> ReadComplianceTable(const YamlValue& value, const Joint& joint) {
  std::vector<JointCompliance::Node> nodes;
  for (const YamlValue& item : value.Items()) {
    nodes.push_back(ReadComplianceNode(item, joint, true));
    if (nodes.size() > 1 && nodes[nodes.size() - 2].q >= nodes.back().q) {
      item.Fail("the joint values of a table have to increase");
    }
  }
  if (nodes.empty()) value.Fail("the table is empty");
  return nodes;
}

JointCompliance ReadCompliance(const YamlValue& value, const Joint& joint) {
  JointCompliance compliance;
  YamlMap map(value);
  const auto table = map.Find("table");
  if (!table) {
    compliance.nodes = {ReadComplianceNode(value, joint, false)};
    return compliance;
  }
  map.Finish();
  compliance.is_table = true;
  compliance.nodes = ReadComplianceTable(*table, joint);
  return compliance;
}

}  // namespace

std::vector<ElementaryTransform> ReadChain(const YamlValue& value, const std::vector<Joint>& joints) {
  std::vector<ElementaryTransform> transforms;
  std::set<std::string> errors;
  std::set<int> carried;
  for (const YamlValue& item : value.Items()) {
    const ElementaryTransform transform = ReadTransform(item, joints);
    if (!transform.error.empty() && !errors.insert(transform.error).second) {
      item.Fail("the error name '" + transform.error + "' stands on two transforms", "give each its own name");
    }
    if (transform.has_joint() && !carried.insert(transform.joint).second) {
      item.Fail("joint '" + joints[transform.joint].name + "' is on two transforms");
    }
    transforms.push_back(transform);
  }
  return transforms;
}

std::vector<JointCompliance> ReadCompliances(const YamlValue& value, const std::vector<Joint>& joints) {
  std::vector<JointCompliance> compliances;
  const std::vector<std::string> names = JointNames(joints);
  for (const auto& [name, entry] : value.Entries()) {
    int joint = 0;
    while (joint < static_cast<int>(names.size()) && names[joint] != name) ++joint;
    if (joint == static_cast<int>(names.size())) {
      entry.Fail("there is no joint '" + name + "'", SpellingHint(name, names));
    }
    compliances.push_back(ReadCompliance(entry, joints[joint]));
    compliances.back().joint = joint;
  }
  return compliances;
}

GravityCompensator ReadGravityCompensator(const YamlValue& value, const std::vector<Joint>& joints) {
  YamlMap map(value);
  GravityCompensator compensator;
  const YamlValue joint = map.Get("joint");
  compensator.joint = ReadJointIndex(joint, joints);
  if (joints[compensator.joint].type != JointType::kRevolute) joint.Fail("a compensator acts on a revolute joint");
  if (const auto type = map.Find("type")) type->OneOf({"spring"});
  compensator.L = map.GetLength("L");
  compensator.a_x = map.GetLength("a_x");
  compensator.a_y = map.GetLength("a_y");
  compensator.s0 = map.GetLength("s0");
  compensator.Kc = map.Get("Kc_N_per_mm").Number() * 1e3;
  if (const auto preload = map.Find("preload")) compensator.preload = preload->Flag();
  compensator.zero = map.Find("zero", Dimension::kAngle);
  compensator.prior_sigmas = ReadPriors(SpringParameters(), &map);
  map.Finish();
  if (compensator.L <= 0.0) value.Fail("the lever L has to be above 0");
  if (compensator.s0 <= 0.0) {
    value.Fail("the spring's free length s0 has to be above 0",
               "state it in mm: s0_mm; without a spring leave the key out");
  }
  if (compensator.Kc < 0.0) value.Fail("the spring's stiffness Kc is not below 0", "state it in N/mm: Kc_N_per_mm");
  return compensator;
}

}  // namespace sagitta

#include "problems/io/cell_file.h"

#include <algorithm>

#include "models/constants.h"
#include "problems/input_error.h"
#include "problems/io/files.h"
#include "problems/io/robot_parts.h"
#include "problems/io/urdf_bodies.h"
#include "problems/io/yaml_reader.h"
#include "problems/text.h"

namespace sagitta {
namespace {

JointRange ReadRange(const YamlValue& value, JointType type) {
  const Dimension dimension = type == JointType::kRevolute ? Dimension::kAngle : Dimension::kLength;
  YamlMap map(value);
  JointRange range;
  range.min = map.Find("min", dimension);
  range.max = map.Find("max", dimension);
  if (const auto levels = map.FindQuantity("levels", dimension)) {
    for (const YamlValue& level : levels->value.Items()) range.levels.push_back(level.NumberIn(levels->unit));
    if (range.levels.empty()) value.Fail("the list of levels is empty");
  }
  map.Finish();
  if (range.min && range.max && *range.min > *range.max) value.Fail("min is above max");
  return range;
}

std::vector<JointRange> ReadRanges(const YamlValue& value, const Chain& chain) {
  std::vector<JointRange> ranges(chain.num_joints());
  const std::vector<std::string> names = JointNames(chain.joints);
  for (const auto& [name, entry] : value.Entries()) {
    const int joint = chain.FindJoint(name);
    if (joint < 0) entry.Fail("the robot has no joint '" + name + "'", SpellingHint(name, names));
    ranges[joint] = ReadRange(entry, chain.joints[joint].type);
  }
  return ranges;
}

// min_mm and max_mm of two corners, or size_mm with xyz_mm and rpy_deg of the centre.
CellBox ReadBox(const YamlValue& value) {
  YamlMap map(value);
  CellBox box;
  box.name = map.Get("name").Text();
  const auto low = map.FindTriple("min", Dimension::kLength), high = map.FindTriple("max", Dimension::kLength);
  const auto size = map.FindTriple("size", Dimension::kLength);
  const auto centre = map.FindTriple("xyz", Dimension::kLength);
  const auto rpy = map.FindTriple("rpy", Dimension::kAngle);
  map.Finish();
  if (low && high && !size && !centre && !rpy) {
    box.base_from_box.translation = 0.5 * (*low + *high);
    box.half_size = 0.5 * (*high - *low);
  } else if (size && centre && !low && !high) {
    box.base_from_box.translation = *centre;
    box.half_size = 0.5 * *size;
    if (rpy) box.base_from_box.rotation = RotationFromRpy(*rpy);
  } else {
    value.Fail("a box has min_mm and max_mm, or size_mm and xyz_mm (and rpy_deg)");
  }
  if (!(box.half_size.minCoeff() > 0.0)) value.Fail("the box has no extent", "state min_mm below max_mm on every axis");
  return box;
}

std::vector<CellBox> ReadBoxes(const YamlValue& value) {
  std::vector<CellBox> boxes;
  for (const YamlValue& item : value.Items()) boxes.push_back(ReadBox(item));
  return boxes;
}

int BodyNamed(const YamlValue& value, const Chain& chain) {
  const std::string name = value.Text();
  const int joint = chain.FindJoint(name);
  const bool is_base = name == "base", is_flange = name == "flange";
  if (joint >= 0 && (is_base || is_flange)) {
    value.Fail("'" + name + "' is a joint of this robot too", "give the joint another name in the robot file");
  }
  if (is_base) return LinkCapsule::kBase;
  if (is_flange) return LinkCapsule::kFlange;
  if (joint >= 0) return joint;
  std::vector<std::string> names = {"base", "flange"};
  for (const Joint& own : chain.joints) names.push_back(own.name);
  value.Fail("'" + name + "' is no place on this robot", SpellingHint(name, names));
}

LinkCapsule ReadCapsule(const YamlValue& value, const Chain& chain) {
  YamlMap map(value);
  LinkCapsule capsule;
  capsule.name = map.Get("name").Text();
  capsule.on = BodyNamed(map.Get("on"), chain);
  const auto from = map.FindTriple("from", Dimension::kLength), to = map.FindTriple("to", Dimension::kLength);
  capsule.radius = map.GetLength("radius");
  map.Finish();
  if (!from || !to) value.Fail("a capsule lies between from_mm and to_mm");
  if (!(capsule.radius > 0.0)) value.Fail("the radius must be above 0");
  capsule.from = *from;
  capsule.to = *to;
  return capsule;
}

int CapsuleNamed(const YamlValue& value, const std::vector<LinkCapsule>& capsules) {
  const std::string name = value.Text();
  std::vector<std::string> names;
  for (size_t i = 0; i < capsules.size(); ++i) {
    if (capsules[i].name == name) return static_cast<int>(i);
    names.push_back(capsules[i].name);
  }
  value.Fail("there is no capsule '" + name + "'", SpellingHint(name, names));
}

Vector3<double> ReadDirection(const YamlValue& value) {
  const Vector3<double> given = value.Triple(Unit{"", 1.0, 1.0});
  if (given.norm() < 1e-9) value.Fail("the direction has no length");
  return given.normalized();
}

DirectionCone ReadCone(const YamlValue& value, bool has_direction) {
  YamlMap map(value);
  DirectionCone cone;
  cone.axis = ReadDirection(map.Get("axis"));
  if (has_direction) cone.direction = ReadDirection(map.Get("direction"));
  const auto angle = map.GetQuantity("half_angle", Dimension::kAngle);
  cone.half_angle = angle.value.NumberIn(angle.unit);
  map.Finish();
  if (!(cone.half_angle > 0.0 && cone.half_angle <= kPi)) value.Fail("a half angle lies between 0 and 180 deg");
  return cone;
}

SightRange ReadSight(const YamlValue& value) {
  YamlMap map(value);
  SightRange range;
  range.min_range = map.Length("min_range").value_or(range.min_range);
  range.max_range = map.Length("max_range").value_or(range.max_range);
  range.min_elevation = map.Angle("min_elevation").value_or(range.min_elevation);
  range.max_elevation = map.Angle("max_elevation").value_or(range.max_elevation);
  map.Finish();
  if (range.min_range >= range.max_range || range.min_elevation >= range.max_elevation) {
    value.Fail("a minimum lies below its maximum");
  }
  return range;
}

double ReadNotNegative(YamlMap* map, const std::string& stem, double otherwise) {
  const auto quantity = map->FindQuantity(stem, Dimension::kLength);
  if (!quantity) return otherwise;
  const double value = quantity->value.NumberIn(quantity->unit);
  if (value < 0.0) quantity->value.Fail("a length of 0 or more is expected");
  return value;
}

// urdf: {file, base_link, tip_link}: the arm's bodies as its URDF has them.
void ReadUrdfBodies(const YamlValue& value, const std::string& cell_file, const Chain& chain, Cell* cell) {
  const UrdfSource source = ReadUrdfSource(value, cell_file);
  const std::string& path = source.path;
  const UrdfBodies bodies = BodiesFromUrdf(ReadUrdfChain(ReadTextFile(path), path, source.ends), chain, path);
  cell->capsules = bodies.capsules;
  const auto open = [cell](const std::vector<std::string>& links, const std::string& why) {
    if (!links.empty()) cell->without_body.push_back("the bodies of " + Enumerate(links, 8) + " (" + why + ")");
  };
  open(bodies.meshes, "meshes of the URDF are not read: state capsules for them");
  open(bodies.moving, "of the URDF, outside the chain: they move on their own");
  open(bodies.bare, "the URDF has no collision geometry for them");
}

void ReadBodies(YamlMap* map, const Chain& chain, Cell* cell) {
  if (const auto urdf = map->Find("urdf")) ReadUrdfBodies(*urdf, cell->file, chain, cell);
  if (const auto capsules = map->Find("capsules")) {
    for (const YamlValue& item : capsules->Items()) {
      cell->capsules.push_back(ReadCapsule(item, chain));
      const auto same = [&](const LinkCapsule& other) { return other.name == cell->capsules.back().name; };
      if (std::count_if(cell->capsules.begin(), cell->capsules.end(), same) > 1) item.Fail("the name is used already");
    }
  }
  if (const auto pairs = map->Find("may_touch")) {
    for (const YamlValue& pair : pairs->Items()) {
      const std::vector<YamlValue> both = pair.Items();
      if (both.size() != 2) pair.Fail("two capsules are expected", "may_touch: [[upper arm, forearm]]");
      cell->may_touch.push_back({CapsuleNamed(both[0], cell->capsules), CapsuleNamed(both[1], cell->capsules)});
    }
  }
  cell->clearance = ReadNotNegative(map, "clearance", cell->clearance);
}

}  // namespace

Cell ReadCellText(const std::string& text, const std::string& file, const Chain& chain) {
  YamlMap map(ParseYaml(text, file));
  map.ExpectSchema("sagitta/cell/1");
  Cell cell;
  cell.file = file;
  cell.joints.resize(chain.num_joints());
  if (const auto joints = map.Find("joints")) cell.joints = ReadRanges(*joints, chain);
  cell.floor = map.Length("floor");
  if (const auto boxes = map.Find("stay_in")) cell.stay_in = ReadBoxes(*boxes);
  if (const auto boxes = map.Find("keep_out")) cell.keep_out = ReadBoxes(*boxes);
  ReadBodies(&map, chain, &cell);
  if (const auto tool = map.Find("tool_cone")) cell.tool = ReadCone(*tool, true);
  if (const auto sights = map.Find("sight")) {
    for (const auto& [station, entry] : sights->Entries()) cell.sights.emplace_back(station, ReadSight(entry));
  }
  if (const auto reflectors = map.Find("reflectors")) {
    for (const auto& [marker, entry] : reflectors->Entries()) {
      cell.reflectors.emplace_back(marker, ReadCone(entry, false));
    }
  }
  cell.beam_radius = ReadNotNegative(&map, "beam_radius", cell.beam_radius);
  cell.beam_end = ReadNotNegative(&map, "beam_end", cell.beam_end);
  map.Finish();
  return cell;
}

Cell ReadCellFile(const std::string& path, const Chain& chain) { return ReadCellText(ReadTextFile(path), path, chain); }

}  // namespace sagitta

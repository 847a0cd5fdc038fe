#include "problems/io/programs/rapid_tools.h"

#include <optional>

namespace sagitta {
namespace {

Pose<double> PoseOf(const std::vector<TextNumber>& numbers, size_t first) {
  std::vector<double> values;
  for (size_t i = first; i < first + 7; ++i) values.push_back(numbers[i].value);
  return PoseFrom(PoseNotation::kQuaternion, values);
}

// [mass, [x, y, z], [q1..q4], ix, iy, iz]. Nothing: it is not stated; tools that nobody has weighed have the mass -1.
std::optional<ProgramLoad> LoadOf(const std::vector<TextNumber>& numbers) {
  if (numbers.size() != 11 || numbers[0].value < 0.0) return std::nullopt;
  ProgramLoad load;
  load.mass = numbers[0].value;
  for (int a = 0; a < 3; ++a) load.centre[a] = numbers[1 + static_cast<size_t>(a)].value / 1e3;
  return load;
}

}  // namespace

// [robhold, [[x, y, z], [q1..q4]], [mass, ...]]
void RapidTools::AddTool(const std::string& name, size_t open) {
  tools_and_objects_.insert(name);
  declared_.insert(name);
  const std::vector<TextRange> parts = PartsOf(code_, open + 1, EndOfBracket(code_, open) - 1);
  if (parts.size() < 2) return;
  const std::vector<TextNumber> numbers = NumbersInBracket(code_, parts[1].first);
  if (code_.compare(parts[0].first, 4, "TRUE") != 0)
    refused_[name] = "its tool stands in the room and the robot holds the workpiece";
  if (numbers.size() == 7) stated_tools_.State(name, PoseOf(numbers, 0), &program_.tools);
  if (parts.size() < 3 || code_[parts[2].first] != '[') return;
  if (const auto load = LoadOf(NumbersInBracket(code_, parts[2].first))) {
    stated_tool_loads_.State(name, *load, &tool_loads_);
  }
}

std::string RapidTools::LoadWith(const std::string& tool, const std::string& total, const std::string& gripped) {
  if (!total.empty() && total != "LOAD0") return total;
  std::vector<ProgramLoad> bodies;
  std::string name;
  bool is_stated = true;
  if (tool != kFlangeName) {
    name = tool;
    const auto found = tool_loads_.find(tool);
    is_stated = found != tool_loads_.end();
    if (is_stated) bodies.push_back(found->second);
  }
  if (!gripped.empty()) {
    name += (name.empty() ? "" : " and ") + gripped;
    const auto found = payloads_.find(gripped);
    const auto held_by = program_.tools.find(tool);
    is_stated &= found != payloads_.end() && (tool == kFlangeName || held_by != program_.tools.end());
    if (is_stated) {
      bodies.push_back(found->second);
      if (tool != kFlangeName) bodies.back().centre = held_by->second * found->second.centre;
    }
  }
  if (bodies.empty() || !is_stated) return name;
  ProgramLoad all;
  all.centre.setZero();
  for (const ProgramLoad& body : bodies) {
    all.mass += body.mass;
    all.centre += body.mass * body.centre;
  }
  if (all.mass > 0.0) all.centre /= all.mass;
  program_.loads[name] = all;
  return name;
}

// [robhold, ufprog, ufmec, uframe, oframe]
void RapidTools::AddWorkObject(const std::string& name, size_t open) {
  tools_and_objects_.insert(name);
  declared_.insert(name);
  const std::vector<TextRange> parts = PartsOf(code_, open + 1, EndOfBracket(code_, open) - 1);
  if (parts.size() != 5) return;
  if (code_.compare(parts[0].first, 5, "FALSE") != 0) refused_[name] = "the robot holds its work object";
  if (code_.compare(parts[1].first, 4, "TRUE") != 0) refused_[name] = "its work object is moved by another unit";
  const std::vector<TextNumber> user = NumbersInBracket(code_, parts[3].first),
                                object = NumbersInBracket(code_, parts[4].first);
  if (user.size() != 7 || object.size() != 7) return;
  const Pose<double> u = PoseOf(user, 0), o = PoseOf(object, 0);
  stated_frames_.State(name, {u.rotation * o.rotation, u * o.translation}, &program_.frames);
}

void RapidTools::AddPayload(const std::string& name, size_t open) {
  declared_.insert(name);
  if (const auto load = LoadOf(NumbersInBracket(code_, open))) stated_payloads_.State(name, *load, &payloads_);
}

void RapidTools::Change(const std::string& name, const std::string& part) {
  if (name.empty()) {
    for (const std::string& one : declared_) Change(one, "");
    return;
  }
  stated_payloads_.Change(name, &payloads_);
  if (part.find("TFRAME") == std::string::npos) stated_tool_loads_.Change(name, &tool_loads_);
  if (part.find("TLOAD") == std::string::npos) stated_tools_.Change(name, &program_.tools);
  stated_frames_.Change(name, &program_.frames);
}

bool RapidTools::IsLoadChanged(const std::string& tool, const std::string& gripped) const {
  return stated_payloads_.IsChanged(gripped) || stated_tool_loads_.IsChanged(tool);
}

std::string RapidTools::WhyNot(const std::string& tool, const std::string& frame, bool is_joints) const {
  for (const std::string& name : {tool, frame}) {
    if (refused_.count(name) > 0) return refused_.at(name);
  }
  const bool is_tool = stated_tools_.IsChanged(tool);
  if (is_joints || (!is_tool && !stated_frames_.IsChanged(frame))) return "";
  return "the program gives " + (is_tool ? tool : frame) + " more than one value";
}

}  // namespace sagitta

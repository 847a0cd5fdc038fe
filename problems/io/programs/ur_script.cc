// URScript: p[x, y, z, rx, ry, rz] in the base, m and rad, for the tool that set_tcp states; [j1, ..., j6] in rad. Only
// what a motion goes to is a target: other lists and poses are tools, frames. set_payload(m, [x, y, z]) states all that
// hangs on the flange, in m of the flange; without the list its centre of mass is the tool centre point. After
// set_payload_mass or set_payload_cog, which change a part of it, the user states it.
#include <algorithm>
#include <optional>
#include <set>

#include "problems/input_error.h"
#include "problems/io/pattern.h"
#include "problems/io/programs/program_text.h"

namespace sagitta {
namespace {

class UrReader {
 public:
  UrReader(int joints, RobotProgram* program)
      : joints_(joints), program_(*program), code_(WithoutComments(program->text, "#", '"')) {}

  void Read();

 private:
  void ReadAssignments();
  void RefuseChanged();
  void ReadCalls();
  void ReadArgument(const std::string& motion, TextRange argument);
  void ReadTarget(const std::string& motion, TextRange argument);
  void ReadStart(TextRange argument);
  TextRange WithoutKeyword(TextRange argument) const;
  int PointOf(const std::string& motion, TextRange argument);
  void SetTool(size_t open);
  void SetLoad(const std::string& call, size_t open);
  std::string LoadHere();
  int AddLiteral(const std::string& name, size_t at);

  const int joints_;
  RobotProgram& program_;
  const std::string code_;
  std::string tool_, load_;
  std::optional<double> mass_at_tool_;  // of a load that is in the tool centre point, wherever that is
  std::set<int> used_;                  // points that a motion goes to
  std::map<std::string, int> named_;    // index of a point
};

constexpr const char* kOnlyStarts = "it only starts an inverse kinematics";

bool IsPoseAt(const std::string& code, size_t at) { return code.compare(at, 2, "p[") == 0; }

// The literal at `at` as a point; -1: it is none.
int UrReader::AddLiteral(const std::string& name, size_t at) {
  const bool is_pose = IsPoseAt(code_, at);
  const size_t open = at + (is_pose ? 1 : 0);
  if (open >= code_.size() || code_[open] != '[') return -1;
  if (EndOfBracket(code_, open) == std::string::npos) {
    throw InputError({program_.path, LineAt(code_, at), name}, "the bracket of this list is not closed");
  }
  ProgramPoint point;
  point.name = name;
  point.line = LineAt(code_, at);
  point.used_at = at;
  point.is_joints = !is_pose;
  point.numbers = NumbersInBracket(code_, open);
  point.branch.from_before = is_pose;
  point.frame = is_pose ? kWorldName : "";
  if (static_cast<int>(point.numbers.size()) != (is_pose ? 6 : joints_)) return -1;
  program_.points.push_back(point);
  return static_cast<int>(program_.points.size()) - 1;
}

// name = p[...]: a target once a motion uses it. A name that is set again, to anything, or in part (name[2] = 0.1),
// does not hold these numbers everywhere.
void UrReader::ReadAssignments() {
  static const std::regex assignment =
      MakePattern("(?:^|\\n)[ \\t]*(?:global[ \\t]+|local[ \\t]+)?([A-Za-z_]\\w*)[ \\t]*=[ \\t]*(p?\\[)");
  for (const std::smatch& match : AllMatches(code_.begin(), code_.end(), assignment)) {
    const int index = AddLiteral(match[1], static_cast<size_t>(match.position(2)));
    if (index < 0) continue;
    program_.points.back().untouched = "no motion in this file goes to it";
    named_[match[1]] = index;
  }
  RefuseChanged();
}

void UrReader::RefuseChanged() {
  static const std::regex any = MakePattern(
      "(?:^|\\n)[ \\t]*(?:global[ \\t]+|local[ \\t]+)?([A-Za-z_]\\w*)[ \\t]*(?:\\[[^\\]\\n]*\\])?[ \\t]*=(?!=)");
  std::map<std::string, int> times;
  for (const std::smatch& match : AllMatches(code_.begin(), code_.end(), any)) ++times[match[1]];
  for (ProgramPoint& point : program_.points) {
    if (times[point.name] > 1) point.untouched = "the variable is set more than once";
  }
}

void UrReader::SetTool(size_t open) {
  const std::vector<TextRange> parts = PartsOf(code_, open + 1, EndOfBracket(code_, open) - 1);
  tool_ = code_.substr(parts[0].first, parts[0].second - parts[0].first);
  if (!IsPoseAt(code_, parts[0].first)) return;
  const std::vector<TextNumber> numbers = NumbersInBracket(code_, parts[0].first + 1);
  if (numbers.size() != 6) return;
  std::vector<double> values;
  for (const TextNumber& number : numbers) values.push_back(number.value);
  tool_ = "set_tcp of line " + std::to_string(LineAt(code_, open));
  program_.tools[tool_] = PoseFrom(PoseNotation::kRotationVectorMetres, values);
}

void UrReader::SetLoad(const std::string& call, size_t open) {
  const std::vector<TextRange> parts = PartsOf(code_, open + 1, EndOfBracket(code_, open) - 1);
  load_ = call + " of line " + std::to_string(LineAt(code_, open));
  mass_at_tool_.reset();
  if (call == "set_payload_mass" || call == "set_payload_cog") return;
  TextNumber mass;
  if (!NumberAt(code_, parts[0], &mass) || mass.value < 0.0) return;
  if (parts.size() < 2) {
    mass_at_tool_ = mass.value;
    return;
  }
  const size_t bracket = code_.find('[', parts[1].first);  // "[0, 0, 0.05]", "cog=[0, 0, 0.05]"
  if (bracket >= parts[1].second) return;
  const std::vector<TextNumber> centre = NumbersInBracket(code_, bracket);
  if (centre.size() != 3) return;
  program_.loads[load_] = {mass.value, {centre[0].value, centre[1].value, centre[2].value}};
}

std::string UrReader::LoadHere() {
  if (!mass_at_tool_) return load_;
  const std::string name = load_ + (tool_.empty() ? "" : " at " + tool_);
  const auto tool = program_.tools.find(tool_);
  if (tool != program_.tools.end()) program_.loads[name] = {*mass_at_tool_, tool->second.translation};
  return name;
}

// The point of a target; what has no numbers here is one that stays as it is.
int UrReader::PointOf(const std::string& motion, TextRange argument) {
  const std::string text = code_.substr(argument.first, argument.second - argument.first);
  if (const auto found = named_.find(text); found != named_.end()) return found->second;
  const int line = LineAt(code_, argument.first);
  const std::string name = motion + " of line " + std::to_string(line);
  if (!text.empty() && (text[0] == '[' || IsPoseAt(code_, argument.first))) {
    const int index = AddLiteral(name, argument.first);
    if (index >= 0) return index;
  }
  if (std::all_of(text.begin(), text.end(), IsWordCharacter)) {
    return named_[text] = AddPointElsewhere(text, line, argument.first, &program_);
  }
  return AddComputedPoint(name, line, argument.first, "it is computed: " + Quoted(code_, argument), &program_);
}

void UrReader::ReadTarget(const std::string& motion, TextRange argument) {
  ProgramMotion to = MotionTo(motion, code_, argument);
  const int index = to.point = PointOf(motion, argument);
  program_.motions.push_back(to);
  ProgramPoint& point = program_.points[static_cast<size_t>(index)];
  if (!point.is_joints && point.untouched.empty() && !point.tool.empty() && point.tool != tool_) {
    point.untouched = "the program moves to it with more than one tool";
    return;
  }
  UseLoad(LoadHere(), used_.insert(index).second, &point);
  if (!point.untouched.empty()) point.used_at = argument.first;
  if (point.untouched.find("no motion") == 0 || point.untouched.find(kOnlyStarts) == 0) point.untouched.clear();
  if (!point.is_joints) point.tool = tool_;
}

// Where an inverse kinematics starts from.
void UrReader::ReadStart(TextRange argument) {
  const auto found = named_.find(code_.substr(argument.first, argument.second - argument.first));
  if (found == named_.end()) return;
  ProgramPoint& point = program_.points[static_cast<size_t>(found->second)];
  if (point.untouched.find("no motion") == 0) point.untouched = kOnlyStarts;
}

// get_inverse_kin(x=p[...], qnear=...) goes to its first argument.
void UrReader::ReadArgument(const std::string& motion, TextRange argument) {
  static const std::regex inverse = MakePattern("^get_inverse_kin\\s*\\(");
  argument = WithoutKeyword(argument);
  const std::string text = code_.substr(argument.first, argument.second - argument.first);
  std::smatch kinematics;
  if (!SearchPattern(text, &kinematics, inverse)) {
    ReadTarget(motion, argument);
    return;
  }
  const size_t inner = argument.first + static_cast<size_t>(kinematics.length(0)) - 1;
  const std::vector<TextRange> arguments = PartsOf(code_, inner + 1, EndOfBracket(code_, inner) - 1);
  for (size_t a = 0; a < arguments.size(); ++a) {
    const TextRange value = WithoutKeyword(arguments[a]);
    a == 0 ? ReadTarget(motion, value) : ReadStart(value);
  }
}

// "qnear=Waypoint_1_q" -> "Waypoint_1_q"
TextRange UrReader::WithoutKeyword(TextRange argument) const {
  size_t word = argument.first;
  while (word < argument.second && IsWordCharacter(code_[word])) ++word;
  const size_t equals = code_.find_first_not_of(" \t", word);
  if (equals >= argument.second || code_[equals] != '=' || code_[equals + 1] == '=') return argument;
  return {std::min(code_.find_first_not_of(" \t", equals + 1), argument.second), argument.second};
}

void UrReader::ReadCalls() {
  static const std::regex call = MakePattern(
      "\\b(movej|movel|movep|movec|servoj|servoc|set_tcp|set_payload|set_payload_mass|set_payload_cog|set_target_"
      "payload)"
      "\\s*(\\()");
  for (const std::smatch& match : AllMatches(code_.begin(), code_.end(), call)) {
    const size_t open = static_cast<size_t>(match.position(2));
    const size_t end = EndOfBracket(code_, open);
    const std::string motion = match[1];
    if (end == std::string::npos) {
      throw InputError({program_.path, LineAt(code_, open), motion}, "the bracket of this call is not closed");
    }
    if (motion == "set_tcp") {
      SetTool(open);
      continue;
    }
    if (motion.find("payload") != std::string::npos) {
      SetLoad(motion, open);
      continue;
    }
    const std::vector<TextRange> parts = PartsOf(code_, open + 1, end - 1);
    for (size_t i = 0; i < parts.size() && i < (motion == "movec" ? 2U : 1U); ++i) ReadArgument(motion, parts[i]);
  }
}

void UrReader::Read() {
  program_.notation = PoseNotation::kRotationVectorMetres;
  ReadAssignments();
  ReadCalls();
}

}  // namespace

void ReadUrScript(int joints, RobotProgram* program) { UrReader(joints, program).Read(); }

}  // namespace sagitta

// URScript: p[x, y, z, rx, ry, rz] in the base, m and rad, for the tool that set_tcp states; [j1, ..., j6] in rad. Only
// what a motion goes to is a target: other lists and poses are tools, frames. set_payload(m, [x, y, z]) states all that
// hangs on the flange, in m of the flange; without the list its centre of mass is the tool centre point. After
// set_payload_mass or set_payload_cog, which change a part of it, the user states it.
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
  void ReadCalls();
  void ReadTarget(const std::string& motion, TextRange argument, bool only_start);
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

// name = p[...]: a target once a motion uses it.
void UrReader::ReadAssignments() {
  static const std::regex assignment =
      MakePattern("(?:^|\\n)[ \\t]*(?:global[ \\t]+|local[ \\t]+)?([A-Za-z_]\\w*)[ \\t]*=[ \\t]*(p?\\[)");
  for (const std::smatch& match : AllMatches(code_.begin(), code_.end(), assignment)) {
    const int index = AddLiteral(match[1], static_cast<size_t>(match.position(2)));
    if (index < 0) continue;
    if (named_.count(match[1]) > 0) {
      for (const int again : {index, named_[match[1]]}) {
        program_.points[static_cast<size_t>(again)].untouched = "the variable is set more than once";
      }
      continue;
    }
    program_.points.back().untouched = "no motion in this file goes to it";
    named_[match[1]] = index;
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

void UrReader::ReadTarget(const std::string& motion, TextRange argument, bool only_start) {
  const std::string text = code_.substr(argument.first, argument.second - argument.first);
  const std::string name = motion + " of line " + std::to_string(LineAt(code_, argument.first));
  int index = -1;
  if (const auto found = named_.find(text); found != named_.end()) {
    index = found->second;
  } else if (!text.empty() && (text[0] == '[' || IsPoseAt(code_, argument.first))) {
    index = AddLiteral(name, argument.first);
  } else if (text.find("p[") != std::string::npos || text.find('(') != std::string::npos) {
    ProgramPoint computed;
    computed.name = name;
    computed.line = LineAt(code_, argument.first);
    computed.untouched = "it is computed: " + text.substr(0, 40);
    program_.points.push_back(computed);
  }
  if (index < 0) return;
  ProgramPoint& point = program_.points[static_cast<size_t>(index)];
  if (only_start) {
    if (!point.untouched.empty()) point.untouched = "it only starts an inverse kinematics";
    return;
  }
  if (!point.is_joints && point.untouched.empty() && !point.tool.empty() && point.tool != tool_) {
    point.untouched = "the program moves to it with more than one tool";
    return;
  }
  UseLoad(LoadHere(), used_.insert(index).second, &point);
  if (!point.untouched.empty()) point.used_at = argument.first;
  if (point.untouched.find("no motion") == 0 || point.untouched.find("it only starts") == 0) point.untouched.clear();
  if (!point.is_joints) point.tool = tool_;
}

void UrReader::ReadCalls() {
  static const std::regex call = MakePattern(
      "\\b(movej|movel|movep|movec|servoj|set_tcp|set_payload|set_payload_mass|set_payload_cog|set_target_payload)"
      "\\s*(\\()");
  static const std::regex inverse = MakePattern("^get_inverse_kin\\s*\\(");
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
    for (size_t i = 0; i < parts.size() && i < (motion == "movec" ? 2U : 1U); ++i) {
      const std::string text = code_.substr(parts[i].first, parts[i].second - parts[i].first);
      std::smatch kinematics;
      if (!SearchPattern(text, &kinematics, inverse)) {
        ReadTarget(motion, parts[i], false);
        continue;
      }
      const size_t inner = parts[i].first + static_cast<size_t>(kinematics.length(0)) - 1;
      const std::vector<TextRange> arguments = PartsOf(code_, inner + 1, EndOfBracket(code_, inner) - 1);
      for (size_t a = 0; a < arguments.size(); ++a) {
        TextRange argument = arguments[a];
        const size_t equals = code_.find('=', argument.first);
        if (equals < argument.second) argument.first = code_.find_first_not_of(" \t", equals + 1);
        ReadTarget(motion, argument, a > 0);
      }
    }
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

// URScript: p[x, y, z, rx, ry, rz] in the base, m and rad, for the tool that set_tcp states; [j1, ..., j6] in rad. Only
// what a motion goes to is a target: other lists and poses are tools, frames. set_payload(m, [x, y, z]) states all that
// hangs on the flange, in m of the flange; without the list its centre of mass is the tool centre point. After
// set_payload_mass or set_payload_cog, which change a part of it, the user states it.
//
// get_inverse_kin(x, qnear, maxPositionError, maxOrientationError, tcp): the joint solution nearest to qnear, for tcp;
// without them nearest to where the arm is, for the tool of set_tcp.
#include <algorithm>
#include <optional>
#include <set>

#include "problems/input_error.h"
#include "problems/io/pattern.h"
#include "problems/io/programs/calls_elsewhere.h"
#include "problems/io/programs/program_text.h"
#include "problems/io/programs/ur_flow.h"

namespace sagitta {
namespace {

class UrReader {
 public:
  UrReader(int joints, RobotProgram* program)
      : joints_(joints),
        program_(*program),
        source_(*program, "#", '"'),
        code_(source_.text()),
        flow_(FlowOfUrScript(code_)) {}

  void Read();

 private:
  // What a motion's inverse kinematics goes by.
  struct Start {
    std::vector<double> near;         // rad; empty: where the arm is
    std::optional<std::string> tool;  // nothing: that of set_tcp
    std::string unknown;              // what is no number; "": all is known
  };

  void ReadAssignments();
  void RefuseChanged();
  void ReadCalls();
  void ReadArgument(const std::string& motion, TextRange argument);
  void ReadTarget(const std::string& motion, TextRange argument, const Start& start);
  void ReadKinematics(const std::string& motion, size_t open);
  static void GoBy(const Start& start, bool is_first, ProgramPoint* point);
  void MarkStart(TextRange argument);
  std::vector<double> NearOf(TextRange argument, bool* is_known) const;
  std::string ToolOf(TextRange argument, const std::string& call);
  std::string KeywordOf(TextRange argument) const;
  TextRange WithoutKeyword(TextRange argument) const;
  // One before the first byte of the line.
  size_t LineBegin(size_t at) const { return at == 0 ? std::string::npos : code_.rfind('\n', at - 1); }
  std::string TextOf(TextRange range) const { return code_.substr(range.first, range.second - range.first); }
  int PointOf(const std::string& motion, TextRange argument);
  void SetTool(size_t open);
  void StateTool(const std::string& name);
  void SetLoad(const std::string& call, size_t open);
  FlowValues LoadsHere();
  int AddLiteral(const std::string& name, size_t at);
  void SayWhatMovesComputedPoints();

  const int joints_;
  RobotProgram& program_;
  const ProgramCode source_;
  const std::string& code_;
  ProgramFlow flow_;
  std::map<std::string, double> mass_at_tool_;  // of loads that are in the tool centre point, wherever that is
  std::map<std::string, int> assigned_;         // how often, in all or in part
  std::set<std::string> parameters_;            // of routines
  std::set<int> used_;                          // points that a motion goes to
  std::set<int> tools_;                         // points that a tool is set to
  std::map<std::string, int> named_;            // index of a point
  std::map<int, std::string> computed_;         // what a point that has no numbers is computed from
};

constexpr const char* kOnlyStarts = "it only starts an inverse kinematics";
constexpr const char* kSetAgain = "the variable is set more than once";

bool IsName(const std::string& text) { return std::all_of(text.begin(), text.end(), IsWordCharacter); }

std::vector<double> ValuesOf(const std::vector<TextNumber>& numbers) {
  std::vector<double> values;
  for (const TextNumber& number : numbers) values.push_back(number.value);
  return values;
}

bool IsPoseAt(const std::string& code, size_t at) { return code.compare(at, 2, "p[") == 0; }

// The literal at `at` as a point; -1: it is none.
int UrReader::AddLiteral(const std::string& name, size_t at) {
  const bool is_pose = IsPoseAt(code_, at);
  const size_t open = at + (is_pose ? 1 : 0);
  if (open >= code_.size() || code_[open] != '[') return -1;
  if (EndOfBracket(code_, open) == std::string::npos) {
    throw InputError({program_.path, source_.LineAt(at), name}, "the bracket of this list is not closed");
  }
  ProgramPoint point;
  point.name = name;
  point.line = source_.LineAt(at);
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
      MakeCodePattern("(?:^|\\n)[ \\t]*(?:global[ \\t]+|local[ \\t]+)?([A-Za-z_]\\w*)[ \\t]*=[ \\t]*(p?\\[)");
  for (const std::smatch& match : AllMatches(code_.begin(), code_.end(), assignment)) {
    const int index = AddLiteral(match[1], static_cast<size_t>(match.position(2)));
    if (index < 0) continue;
    program_.points.back().untouched = "no motion in this file goes to it";
    named_[match[1]] = index;
  }
  RefuseChanged();
}

void UrReader::RefuseChanged() {
  int depth = 0;  // in brackets "=" names an argument
  for (size_t i = 1; i + 1 < code_.size(); ++i) {
    depth += (code_[i] == '(') - (code_[i] == ')');
    const bool is_comparison =
        code_[i + 1] == '=' || std::string_view("=<>!").find(code_[i - 1]) != std::string_view::npos;
    if (code_[i] == '=' && depth == 0 && !is_comparison) ++assigned_[AssignedBefore(code_, i).name];
  }
  // def go(p1): the name is another one in there.
  static const std::regex routine = MakeCodePattern("\\bdef \\w+ ?(\\()");
  for (const std::smatch& match : AllMatches(code_.begin(), code_.end(), routine)) {
    const size_t open = static_cast<size_t>(match.position(1)), end = EndOfBracket(code_, open);
    if (end == std::string::npos) continue;
    for (const TextRange& part : PartsOf(code_, open + 1, end - 1)) {
      const size_t name_end = std::min(code_.find_first_of("= ", part.first), part.second);
      parameters_.insert(code_.substr(part.first, name_end - part.first));
    }
  }
  for (ProgramPoint& point : program_.points) {
    if (assigned_[point.name] > 1) point.untouched = kSetAgain;
    if (parameters_.count(point.name) > 0) point.untouched = "a routine is handed another one by this name";
  }
}

// A name that is set more than once, or what is computed, is one tool here and another one there.
void UrReader::SetTool(size_t open) {
  const TextRange argument = WithoutKeyword(PartsOf(code_, open + 1, EndOfBracket(code_, open) - 1)[0]);
  const std::string tool = ToolOf(argument, "set_tcp");
  const bool is_one =
      program_.tools.count(tool) > 0 || (IsName(tool) && assigned_[tool] <= 1 && parameters_.count(tool) == 0);
  is_one ? flow_.Set(kUrTool, tool) : flow_.SetUnknown(kUrTool);
}

// my_tcp = p[...] states it, where nothing else sets it.
void UrReader::StateTool(const std::string& name) {
  const auto found = named_.find(name);
  if (found == named_.end() || assigned_[name] != 1 || parameters_.count(name) > 0) return;
  const ProgramPoint& point = program_.points[static_cast<size_t>(found->second)];
  if (point.is_joints || point.numbers.size() != 6) return;
  program_.tools[name] = PoseFrom(PoseNotation::kRotationVectorMetres, ValuesOf(point.numbers));
  tools_.insert(found->second);
}

// The name of a tool: of a literal the call that has it, else as it is written.
std::string UrReader::ToolOf(TextRange argument, const std::string& call) {
  if (!IsPoseAt(code_, argument.first)) {
    StateTool(TextOf(argument));
    return TextOf(argument);
  }
  const std::vector<TextNumber> numbers = NumbersInBracket(code_, argument.first + 1);
  if (numbers.size() != 6) return TextOf(argument);
  const Pose<double> pose = PoseFrom(PoseNotation::kRotationVectorMetres, ValuesOf(numbers));
  std::string name = call + " of line " + std::to_string(source_.LineAt(argument.first));
  if (program_.tools.count(name) > 0) name += ", column " + std::to_string(argument.first - LineBegin(argument.first));
  program_.tools[name] = pose;
  return name;
}

void UrReader::SetLoad(const std::string& call, size_t open) {
  const std::vector<TextRange> parts = PartsOf(code_, open + 1, EndOfBracket(code_, open) - 1);
  const std::string load = call + " of line " + std::to_string(source_.LineAt(open));
  flow_.Set(kUrLoad, load);
  if (call == "set_payload_mass" || call == "set_payload_cog") return;
  TextNumber mass;
  if (!NumberAt(code_, WithoutKeyword(parts[0]), &mass) || mass.value < 0.0) return;
  if (parts.size() < 2) {
    mass_at_tool_[load] = mass.value;
    return;
  }
  const size_t bracket = code_.find('[', parts[1].first);  // "[0, 0, 0.05]", "cog=[0, 0, 0.05]"
  if (bracket >= parts[1].second) return;
  const std::vector<TextNumber> centre = NumbersInBracket(code_, bracket);
  if (centre.size() != 3) return;
  program_.loads[load] = {mass.value, {centre[0].value, centre[1].value, centre[2].value}};
}

FlowValues UrReader::LoadsHere() {
  FlowValues loads;
  for (const std::string& load : flow_.Of(kUrLoad)) {
    const auto mass = mass_at_tool_.find(load);
    if (mass == mass_at_tool_.end()) loads.insert(load);
    if (mass == mass_at_tool_.end()) continue;
    for (const std::string& tool : flow_.Of(kUrTool)) {
      const std::string name = load + (tool.empty() ? "" : " at " + tool);
      const auto known = program_.tools.find(tool);
      if (known != program_.tools.end()) program_.loads[name] = {mass->second, known->second.translation};
      loads.insert(name);
    }
  }
  return loads;
}

// The point of a target; what has no numbers here is one that stays as it is.
int UrReader::PointOf(const std::string& motion, TextRange argument) {
  const std::string text = code_.substr(argument.first, argument.second - argument.first);
  if (const auto found = named_.find(text); found != named_.end()) return found->second;
  const int line = source_.LineAt(argument.first);
  const std::string name = motion + " of line " + std::to_string(line);
  if (!text.empty() && (text[0] == '[' || IsPoseAt(code_, argument.first))) {
    const int index = AddLiteral(name, argument.first);
    if (index >= 0) return index;
  }
  if (IsName(text)) {
    return named_[text] = AddPointElsewhere(text, line, argument.first, &program_);
  }
  const int index =
      AddComputedPoint(name, line, argument.first, "it is computed: " + Quoted(code_, argument), &program_);
  computed_[index] = text;
  return index;
}

// pose_trans(p_1, p[...]) moves with p_1 where that is corrected.
void UrReader::SayWhatMovesComputedPoints() {
  static const std::regex word = MakeCodePattern("\\b[A-Za-z_]\\w*\\b");
  for (const auto& [index, text] : computed_) {
    for (const std::smatch& match : AllMatches(text.begin(), text.end(), word)) {
      const auto found = named_.find(match.str(0));
      if (found == named_.end()) continue;
      const ProgramPoint& from = program_.points[static_cast<size_t>(found->second)];
      if (from.is_joints || !from.untouched.empty()) continue;
      program_.points[static_cast<size_t>(index)].untouched += "; it moves with " + from.name + ", which is corrected";
      break;
    }
  }
}

void UrReader::ReadTarget(const std::string& motion, TextRange argument, const Start& start) {
  ProgramMotion to = MotionTo(motion, source_, argument);
  const int index = to.point = PointOf(motion, argument);
  program_.motions.push_back(to);
  ProgramPoint& point = program_.points[static_cast<size_t>(index)];
  const bool is_first = used_.insert(index).second;
  if (start.near.empty()) ComeFrom(flow_.Of(kUrArm), &point);
  flow_.Set(kUrArm, std::to_string(index));
  const FlowValues tools = start.tool ? FlowValues{*start.tool} : flow_.Of(kUrTool);
  const bool is_other = tools.size() > 1 || (!is_first && point.tool != *tools.begin());
  UseLoads(LoadsHere(), is_first, &point);
  if (!point.untouched.empty()) point.used_at = argument.first;
  if (point.untouched.find("no motion") == 0 || point.untouched.find(kOnlyStarts) == 0) point.untouched.clear();
  if (point.is_joints) return;
  if (is_other && point.untouched.empty()) {
    point.untouched = "the program moves to it with more than one tool";
    return;
  }
  point.tool = *tools.begin();
  GoBy(start, is_first, &point);
}

// The joint solution of one more motion to the point.
void UrReader::GoBy(const Start& start, bool is_first, ProgramPoint* point) {
  if (!point->untouched.empty()) return;
  StatedBranch& branch = point->branch;
  if (!start.unknown.empty()) {
    point->untouched = "where its inverse kinematics starts from, or for which tool, is no number: " + start.unknown;
  } else if (!branch.near.empty() && !start.near.empty() && branch.near != start.near) {
    point->untouched = "the program moves to it from more than one qnear";
  } else if (!start.near.empty()) {
    branch.also_from_before |= !is_first && branch.near.empty();
    branch.near = start.near;
  }
}

// Joints that only an inverse kinematics starts from are no target.
void UrReader::MarkStart(TextRange argument) {
  const auto found = named_.find(TextOf(argument));
  if (found == named_.end()) return;
  ProgramPoint& point = program_.points[static_cast<size_t>(found->second)];
  if (point.untouched.find("no motion") == 0) point.untouched = kOnlyStarts;
}

// The numbers of a list of joints, by its name or as it stands there. None, and known: where the arm is.
std::vector<double> UrReader::NearOf(TextRange argument, bool* is_known) const {
  static const std::regex here = MakeCodePattern("^get_(actual|target)_joint_positions\\s*\\(\\s*\\)$");
  const std::string text = TextOf(argument);
  std::smatch match;
  std::vector<double> values;
  if (SearchPattern(text, &match, here)) return values;
  if (code_[argument.first] == '[') values = ValuesOf(NumbersInBracket(code_, argument.first));
  const auto found = named_.find(text);
  if (found != named_.end()) {
    const ProgramPoint& point = program_.points[static_cast<size_t>(found->second)];
    if (point.is_joints && point.untouched != kSetAgain) values = ValuesOf(point.numbers);
  }
  *is_known = static_cast<int>(values.size()) == joints_;
  return values;
}

// get_inverse_kin(x=p[...], qnear=..., tcp=p[...]) goes to x.
void UrReader::ReadArgument(const std::string& motion, TextRange argument) {
  static const std::regex inverse = MakeCodePattern("^get_inverse_kin\\s*\\(");
  argument = WithoutKeyword(argument);
  const std::string text = TextOf(argument);
  std::smatch kinematics;
  if (SearchPattern(text, &kinematics, inverse)) {
    ReadKinematics(motion, argument.first + static_cast<size_t>(kinematics.length(0)) - 1);
  } else {
    ReadTarget(motion, argument, {});
  }
}

void UrReader::ReadKinematics(const std::string& motion, size_t open) {
  static const char* const kOrder[] = {"x", "qnear", "maxPositionError", "maxOrientationError", "tcp"};
  const std::vector<TextRange> arguments = PartsOf(code_, open + 1, EndOfBracket(code_, open) - 1);
  std::optional<TextRange> target;
  Start start;
  for (size_t a = 0; a < arguments.size(); ++a) {
    const TextRange value = WithoutKeyword(arguments[a]);
    std::string name = KeywordOf(arguments[a]);
    if (name.empty() && a < std::size(kOrder)) name = kOrder[a];
    if (value.first >= value.second) continue;  // a text, "active_tcp"
    bool is_known = true;
    if (name == "x") target = value;
    if (name == "qnear") start.near = NearOf(value, &is_known);
    if (name == "qnear") MarkStart(value);
    if (name == "tcp") start.tool = ToolOf(value, "tcp of get_inverse_kin");
    if (name == "tcp") is_known = IsName(*start.tool) || program_.tools.count(*start.tool) > 0;
    if (!is_known) start.unknown = Quoted(code_, value);
  }
  if (target) ReadTarget(motion, *target, start);
}

// "qnear=Waypoint_1_q" -> "Waypoint_1_q"
TextRange UrReader::WithoutKeyword(TextRange argument) const {
  const std::string keyword = KeywordOf(argument);
  if (keyword.empty()) return argument;
  const size_t equals = code_.find('=', argument.first + keyword.size());
  return {std::min(code_.find_first_not_of(" \t", equals + 1), argument.second), argument.second};
}

// "qnear=Waypoint_1_q" -> "qnear"; "" where there is none.
std::string UrReader::KeywordOf(TextRange argument) const {
  size_t word = argument.first;
  while (word < argument.second && IsWordCharacter(code_[word])) ++word;
  const size_t equals = code_.find_first_not_of(" \t", word);
  if (equals >= argument.second || code_[equals] != '=' || code_[equals + 1] == '=') return "";
  return code_.substr(argument.first, word - argument.first);
}

void UrReader::ReadCalls() {
  static const std::regex call = MakeCodePattern(
      "\\b(movej|movel|movep|movec|optimovej|optimovel|servoj|servoc|set_tcp|set_payload|set_payload_mass|set_payload_"
      "cog|set_target_"
      "payload)"
      "\\s*(\\()");
  for (const std::smatch& match : AllMatches(code_.begin(), code_.end(), call)) {
    const size_t open = static_cast<size_t>(match.position(2));
    const size_t end = EndOfBracket(code_, open);
    const std::string motion = match[1];
    flow_.MoveTo(open);
    if (end == std::string::npos) {
      throw InputError({program_.path, source_.LineAt(open), motion}, "the bracket of this call is not closed");
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
  ReadAssignments();
  ReadCalls();
  for (const int index : tools_) {
    ProgramPoint& point = program_.points[static_cast<size_t>(index)];
    if (point.untouched.empty()) point.untouched = "it is a tool, too";
  }
  SayWhatMovesComputedPoints();
  FindCallsElsewhere(source_, &program_);
  source_.PlaceInFile(&program_);
}

}  // namespace

void ReadUrScript(int joints, RobotProgram* program) { UrReader(joints, program).Read(); }

}  // namespace sagitta

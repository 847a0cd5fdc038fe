// ABB RAPID: robtarget [[x, y, z], [q1..q4], [cf1, cf4, cf6, cfx], [...]] and jointtarget [[...], [...]], declared or
// in the motion itself. The motion says tool and work object; without \WObj it is wobj0, the world. What hangs on the
// flange is the tool's load, its centre of mass in the flange, and that of the last GripLoad, its centre of mass in the
// tool.
#include <optional>
#include <set>

#include "models/constants.h"
#include "problems/input_error.h"
#include "problems/io/pattern.h"
#include "problems/io/programs/program_text.h"

namespace sagitta {
namespace {

class RapidReader {
 public:
  RapidReader(int joints, RobotProgram* program)
      : joints_(joints),
        program_(*program),
        code_(WithoutComments(program->text, "!", '"')),
        upper_(UpperCase(code_)) {}

  void Read();

 private:
  void ReadDeclarations();
  void ReadChanges();  // of tools, work objects, loads and targets as the program runs
  void ReadMotions();
  bool ReadStatement(size_t begin, size_t end);  // false: it is no motion
  void AddTarget(const std::string& name, size_t open, bool is_joints);
  void AddTool(const std::string& name, size_t open);
  void AddWorkObject(const std::string& name, size_t open);
  void ReadGripLoad(size_t begin, size_t end);
  std::string LoadWith(const std::string& tool, const std::string& total);
  void ReadTarget(const std::string& command, TextRange part, bool is_joints);
  void Use(int index_of_point, const std::string& tool, const std::string& frame, const std::string& load);

  const int joints_;
  RobotProgram& program_;
  const std::string code_, upper_;
  std::map<std::string, size_t> named_;
  std::map<std::string, std::string> refused_;  // tools and work objects that stand in the way of a correction
  std::map<std::string, ProgramLoad> tool_loads_, payloads_;  // in the flange, in the tool
  StatedOnce<ProgramLoad> stated_tool_loads_, stated_payloads_;
  StatedOnce<Pose<double>> stated_tools_, stated_frames_;
  std::string gripped_;  // by the last GripLoad; "": nothing
  std::vector<bool> used_;
};

void RapidReader::AddTarget(const std::string& name, size_t open, bool is_joints) {
  const std::vector<TextNumber> numbers = NumbersInBracket(code_, open);
  ProgramPoint point;
  point.name = name;
  point.line = LineAt(code_, open);
  point.is_joints = is_joints;
  const size_t expected = is_joints ? 12 : 17;
  if (numbers.size() != expected) {
    point.untouched = "it is not written in numbers alone";
  } else if (is_joints) {
    point.numbers.assign(numbers.begin(), numbers.begin() + std::min(joints_, 6));
    if (joints_ > 6) point.untouched = "the robot has more than six joints";
  } else {
    point.numbers.assign(numbers.begin(), numbers.begin() + 7);
    const int turns[] = {0, 3, 5};
    for (int i = 0; i < 3; ++i) {
      const double quadrant = numbers[7 + static_cast<size_t>(i)].value;
      point.branch.ranges.push_back({turns[i], {quadrant * kPi / 2, (quadrant + 1) * kPi / 2}});
    }
    const int shape = static_cast<int>(numbers[10].value);
    point.branch.wrist_negative = (shape & 1) != 0;
    point.branch.elbow_of_zero = (shape & 2) == 0;
    point.branch.wrist_behind = (shape & 4) != 0;
  }
  named_[UpperCase(name)] = program_.points.size();
  program_.points.push_back(point);
}

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

// [robhold, [[x, y, z], [q1..q4]], [mass, ...]]
void RapidReader::AddTool(const std::string& name, size_t open) {
  const std::vector<TextRange> parts = PartsOf(code_, open + 1, EndOfBracket(code_, open) - 1);
  const std::string key = UpperCase(name);
  if (parts.size() < 2) return;
  const std::vector<TextNumber> numbers = NumbersInBracket(code_, parts[1].first);
  if (upper_.compare(parts[0].first, 4, "TRUE") != 0)
    refused_[key] = "its tool stands in the room and the robot holds the workpiece";
  if (numbers.size() == 7) stated_tools_.State(key, PoseOf(numbers, 0), &program_.tools);
  if (parts.size() < 3 || code_[parts[2].first] != '[') return;
  if (const auto load = LoadOf(NumbersInBracket(code_, parts[2].first))) {
    stated_tool_loads_.State(key, *load, &tool_loads_);
  }
}

// "GUN and PIECE": tool and workpiece as one body. `total`: what \TLoad names in place of both, "": nothing.
std::string RapidReader::LoadWith(const std::string& tool, const std::string& total) {
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
  if (!gripped_.empty()) {
    name += (name.empty() ? "" : " and ") + gripped_;
    const auto found = payloads_.find(gripped_);
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

// GripLoad piece1;
void RapidReader::ReadGripLoad(size_t begin, size_t end) {
  static const std::regex grip = MakePattern("\\bGRIPLOAD\\s+(\\w+)");
  const std::string statement = upper_.substr(begin, end - begin);
  std::smatch match;
  if (SearchPattern(statement, &match, grip)) gripped_ = match[1] == "LOAD0" ? "" : match[1].str();
}

// [robhold, ufprog, ufmec, uframe, oframe]
void RapidReader::AddWorkObject(const std::string& name, size_t open) {
  const std::vector<TextRange> parts = PartsOf(code_, open + 1, EndOfBracket(code_, open) - 1);
  const std::string key = UpperCase(name);
  if (parts.size() != 5) return;
  if (upper_.compare(parts[0].first, 5, "FALSE") != 0) refused_[key] = "the robot holds its work object";
  if (upper_.compare(parts[1].first, 4, "TRUE") != 0) refused_[key] = "its work object is moved by another unit";
  const std::vector<TextNumber> user = NumbersInBracket(code_, parts[3].first),
                                object = NumbersInBracket(code_, parts[4].first);
  if (user.size() != 7 || object.size() != 7) return;
  const Pose<double> u = PoseOf(user, 0), o = PoseOf(object, 0);
  stated_frames_.State(key, {u.rotation * o.rotation, u * o.translation}, &program_.frames);
}

void RapidReader::ReadDeclarations() {
  static const std::regex declaration =
      MakePattern("\\b(ROBTARGET|JOINTTARGET|TOOLDATA|WOBJDATA|LOADDATA)\\s+(\\w+)\\s*(\\{[^}]*\\})?\\s*:=\\s*(\\[)");
  for (const std::smatch& match : AllMatches(upper_.begin(), upper_.end(), declaration)) {
    const size_t open = static_cast<size_t>(match.position(4));
    const std::string name = code_.substr(static_cast<size_t>(match.position(2)), static_cast<size_t>(match.length(2)));
    if (EndOfBracket(code_, open) == std::string::npos) {
      throw InputError({program_.path, LineAt(code_, open), name}, "the brackets of this value are not closed");
    }
    const std::string type = match[1];
    if (match[3].matched) {
      if (type[0] == 'T' || type[0] == 'W' || type[0] == 'L') continue;
      ProgramPoint array;
      array.name = name;
      array.line = LineAt(code_, open);
      array.untouched = "it is an array of targets";
      program_.points.push_back(array);
    } else if (type == "TOOLDATA") {
      AddTool(name, open);
    } else if (type == "WOBJDATA") {
      AddWorkObject(name, open);
    } else if (type == "LOADDATA") {
      if (const auto load = LoadOf(NumbersInBracket(code_, open))) {
        stated_payloads_.State(UpperCase(name), *load, &payloads_);
      }
    } else {
      AddTarget(name, open, type == "JOINTTARGET");
    }
  }
}

// gun.tload.mass := 7; piece := other;   a word before the name is a type only in a declaration.
void RapidReader::ReadChanges() {
  static const std::regex change = MakePattern("(?:\\b(\\w+)\\s+)?\\b(\\w+)((?:\\s*\\.\\s*\\w+)*)\\s*:=");
  static const std::set<std::string> types = {"TOOLDATA", "WOBJDATA", "LOADDATA", "ROBTARGET", "JOINTTARGET"};
  for (const std::smatch& match : AllMatches(upper_.begin(), upper_.end(), change)) {
    const size_t at = static_cast<size_t>(match.position(2));
    if (types.count(match[1]) > 0 || (at > 0 && upper_[at - 1] == '\\')) continue;
    const std::string name = match[2], part = match[3];
    if (payloads_.count(name) > 0) stated_payloads_.Change(name, &payloads_);
    if (tool_loads_.count(name) > 0 && part.find("TFRAME") == std::string::npos) {
      stated_tool_loads_.Change(name, &tool_loads_);
    }
    if (program_.tools.count(name) > 0 && part.find("TLOAD") == std::string::npos) {
      stated_tools_.Change(name, &program_.tools);
    }
    if (program_.frames.count(name) > 0) stated_frames_.Change(name, &program_.frames);
    if (named_.count(name) > 0) program_.points[named_[name]].untouched = "the program changes it as it runs";
  }
}

void RapidReader::Use(int index_of_point, const std::string& tool, const std::string& frame, const std::string& load) {
  const size_t index = static_cast<size_t>(index_of_point);
  used_.resize(program_.points.size(), false);
  ProgramPoint* point = &program_.points[index];
  if (used_[index] && (point->tool != tool || point->frame != frame) && point->untouched.empty()) {
    point->untouched = "the program moves to it with more than one tool or work object";
  }
  UseLoad(load, !used_[index], point);
  used_[index] = true;
  point->tool = tool;
  point->frame = frame;
  for (const std::string& name : {tool, frame}) {
    if (refused_.count(name) > 0 && point->untouched.empty()) point->untouched = refused_.at(name);
  }
}

// MoveL p10, v1000, z50, tool1 \WObj := wobj1
bool RapidReader::ReadStatement(size_t begin, size_t end) {
  static const std::regex motion = MakePattern(
      "^(?:[^;]*\\b(?:THEN|ELSE|DO)\\b)?\\s*((?:MOVE|TRIGG|(SEARCH)|ARC|SPOT|DISP)(ABSJ|[JLC])(?:[DAG]O|SYNC|IOS|START|"
      "END)?\\d?)(?=[\\s\\\\])\\s*");
  static const std::regex object = MakePattern("\\\\\\s*WOBJ\\s*:=\\s*(\\w+)");
  static const std::regex tool_at_end = MakePattern("^(\\w+)");
  static const std::regex total_load = MakePattern("\\\\\\s*TLOAD\\s*:=\\s*(\\w+)");
  const std::string statement = upper_.substr(begin, end - begin);
  std::smatch match;
  if (!SearchPattern(statement, &match, motion)) return false;
  std::smatch with_object;
  const std::string frame_name = SearchPattern(statement, &with_object, object) ? with_object[1].str() : "WOBJ0";
  const std::string frame = frame_name == "WOBJ0" ? kWorldName : frame_name;
  const std::vector<TextRange> parts = PartsOf(code_, begin + static_cast<size_t>(match.length(0)), end);
  const std::string last = upper_.substr(parts.back().first, parts.back().second - parts.back().first);
  std::smatch tool_match;
  std::string tool = SearchPattern(last, &tool_match, tool_at_end) ? tool_match[1].str() : "";
  if (tool == "TOOL0") tool = kFlangeName;
  std::smatch total;
  const std::string load =
      LoadWith(tool, SearchPattern(statement, &total, total_load) ? total[1].str() : std::string());
  size_t to_skip = match[2].matched ? 2 : 0, targets = match[3] == "C" ? 2 : 1;  // SearchL signal, place, target
  for (const TextRange& part : parts) {
    if (part.first >= part.second || code_[part.first] == '\\') continue;  // \Conc
    if (to_skip > 0) {
      --to_skip;
      continue;
    }
    if (targets-- == 0) break;
    ReadTarget(code_.substr(begin + static_cast<size_t>(match.position(1)), static_cast<size_t>(match.length(1))), part,
               match[3] == "ABSJ");
    Use(program_.motions.back().point, tool, frame, load);
  }
  return true;
}

// p10, [[...]], Offs(p10, ...), RelTool(p10, ...), and what is computed: p{3}, CRobT().
void RapidReader::ReadTarget(const std::string& command, TextRange part, bool is_joints) {
  static const std::regex offset = MakePattern("^(?:OFFS|RELTOOL)\\s*\\(\\s*(\\w+)\\s*,");
  static const std::regex name_alone = MakePattern("^(\\w+)\\s*(?=\\\\|$)");  // \NoEOffs, \ID may follow
  ProgramMotion motion = MotionTo(command, code_, part);
  const std::string text = upper_.substr(part.first, part.second - part.first);
  const std::string in_motion = UpperCase(command) + " of line " + std::to_string(motion.line);
  std::smatch word;
  motion.is_offset = SearchPattern(text, &word, offset);
  if (motion.is_offset || SearchPattern(text, &word, name_alone)) {
    const auto [named, is_new] = named_.try_emplace(word[1], 0);
    if (is_new) {
      const std::string name =
          code_.substr(part.first + static_cast<size_t>(word.position(1)), static_cast<size_t>(word.length(1)));
      named->second = static_cast<size_t>(AddPointElsewhere(name, motion.line, part.first, &program_));
    }
    motion.point = static_cast<int>(named->second);
  } else if (text[0] == '[') {
    AddTarget(in_motion, part.first, is_joints);
    motion.point = static_cast<int>(program_.points.size()) - 1;
  } else {
    const size_t bracket = text.find_first_of("{(");
    const bool is_element = bracket != std::string::npos && text[bracket] == '{';
    const std::string why = is_element ? "it is one of an array" : "it is computed: " + Quoted(code_, part);
    motion.point = AddComputedPoint(in_motion, motion.line, part.first, why, &program_);
  }
  program_.motions.push_back(motion);
}

void RapidReader::ReadMotions() {
  for (size_t begin = 0; begin < code_.size();) {
    const size_t end = std::min(code_.find(';', begin), code_.size());
    ReadGripLoad(begin, end);
    // PROC main() and IF ... THEN before it end without a semicolon: the motion begins on a line of its own.
    for (size_t line = begin; line < end; line = code_.find('\n', line) + 1) {
      if (ReadStatement(line, end) || code_.find('\n', line) >= end) break;
    }
    begin = end + 1;
  }
}

void RapidReader::Read() {
  program_.notation = PoseNotation::kQuaternion;
  ReadDeclarations();
  ReadChanges();
  ReadMotions();
}

}  // namespace

void ReadRapid(int joints, RobotProgram* program) { RapidReader(joints, program).Read(); }

}  // namespace sagitta

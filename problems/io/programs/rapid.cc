// ABB RAPID: robtarget [[x, y, z], [q1..q4], [cf1, cf4, cf6, cfx], [...]] and jointtarget [[...], [...]], declared or
// in the motion itself. The motion says tool and work object; without \WObj it is wobj0, the world. A name of a
// routine's own hides the module's.
#include <algorithm>
#include <set>

#include "models/constants.h"
#include "problems/input_error.h"
#include "problems/io/pattern.h"
#include "problems/io/programs/calls_elsewhere.h"
#include "problems/io/programs/rapid_calls.h"
#include "problems/io/programs/rapid_flow.h"
#include "problems/io/programs/rapid_tools.h"

namespace sagitta {
namespace {

constexpr double kUnused = 8.9e9;  // 9E9: there is no such axis

// "CONFL\OFF", "PDISPOFF"
bool IsOff(const std::string& value) { return value.size() >= 3 && value.compare(value.size() - 3, 3, "OFF") == 0; }

class RapidReader {
 public:
  RapidReader(int joints, RobotProgram* program)
      : joints_(joints),
        program_(*program),
        source_(*program, "!", '"'),
        code_(source_.text()),
        upper_(UpperCase(code_)),
        flow_(FlowOfRapid(source_.InCapitals())),
        tools_(upper_, program) {}

  void Read();

 private:
  // How a motion goes to its targets.
  struct Manner {
    std::string tool, frame, total_load;
    bool is_clear = true;  // tool and work object are names
    bool is_linear = false;
    size_t at = 0;
  };

  void ReadRoutines();
  void ReadDeclarations();
  void ReadChanges();  // of tools, work objects, loads and targets as the program runs
  void ReadChangesByName();
  void ReadInstructions();
  void ReadMotion(const std::smatch& match);
  Manner MannerOf(const std::smatch& match, TextRange arguments, const std::vector<TextRange>& positional);
  void ReadUnknownInstructions();
  void LeaveUnused();
  void ReadOtherUse(size_t point, size_t at, size_t name_end);
  void AddTarget(const std::string& name, size_t open, bool is_joints);
  void ReadConfiguration(const std::vector<TextNumber>& numbers, ProgramPoint* point) const;
  void ReadTarget(const std::string& command, TextRange part, bool is_joints);
  void Use(int index_of_point, const Manner& manner);
  std::string WhyNot(const Manner& manner, const ProgramPoint& point) const;
  bool UseConfiguration(const Manner& manner, bool is_first, ProgramPoint* point);
  // As `named_` has it: "3#P10" is P10 of the third routine.
  std::string KeyAt(size_t at, const std::string& name) const;
  bool IsParameter(size_t at, const std::string& name) const;

  const int joints_;
  RobotProgram& program_;
  const ProgramCode source_;
  const std::string& code_;
  const std::string upper_;
  ProgramFlow flow_;
  RapidTools tools_;
  std::vector<TextRange> routines_;
  std::vector<std::set<std::string>> parameters_, locals_;  // by routine
  std::map<std::string, size_t> named_;
  std::vector<bool> used_;
  std::vector<TextRange> motions_;  // the statements
};

void RapidReader::ReadRoutines() {
  static const std::regex head = MakeCodePattern("\\b(PROC|FUNC|TRAP)\\s+(?:\\w+\\s+)?(\\w+)\\s*(\\()?");
  static const std::regex parameter = MakeCodePattern("(\\w+)\\s*(?:\\{[^}]{0,20}\\})?\\s*(?:,|\\||$)");
  for (const std::smatch& match : AllMatches(upper_.begin(), upper_.end(), head)) {
    const size_t begin = static_cast<size_t>(match.position(0));
    const size_t end = std::min(upper_.find("END" + match[1].str(), begin), upper_.size());
    routines_.emplace_back(begin, end);
    parameters_.emplace_back();
    locals_.emplace_back();
    if (!match[3].matched) continue;
    const size_t open = static_cast<size_t>(match.position(3)), close = EndOfBracket(code_, open);
    if (close == std::string::npos) {
      throw InputError({program_.path, source_.LineAt(open), match[2]}, "the bracket of this routine is not closed");
    }
    const std::string list = upper_.substr(open + 1, close - open - 2);
    for (const std::smatch& one : AllMatches(list.begin(), list.end(), parameter)) parameters_.back().insert(one[1]);
  }
}

bool RapidReader::IsParameter(size_t at, const std::string& name) const {
  for (size_t r = 0; r < routines_.size(); ++r) {
    if (at >= routines_[r].first && at < routines_[r].second && parameters_[r].count(name) > 0) return true;
  }
  return false;
}

std::string RapidReader::KeyAt(size_t at, const std::string& name) const {
  for (size_t r = 0; r < routines_.size(); ++r) {
    if (at < routines_[r].first || at >= routines_[r].second) continue;
    if (locals_[r].count(name) + parameters_[r].count(name) > 0) return std::to_string(r) + "#" + name;
  }
  return name;
}

void RapidReader::ReadConfiguration(const std::vector<TextNumber>& numbers, ProgramPoint* point) const {
  const int turns[] = {0, 3, 5};
  for (int i = 0; i < 3; ++i) {
    const double quadrant = numbers[7 + static_cast<size_t>(i)].value;
    point->branch.ranges.push_back({turns[i], {quadrant * kPi / 2, (quadrant + 1) * kPi / 2}});
  }
  const int shape = static_cast<int>(numbers[10].value);
  point->branch.wrist_negative = (shape & 1) != 0;
  point->branch.elbow_of_zero = (shape & 2) == 0;
  point->branch.wrist_behind = (shape & 4) != 0;
  for (size_t i = 0; i < 6 && point->untouched.empty(); ++i) {
    const double value = numbers[11 + i].value;
    if (value >= kUnused || value == 0.0) continue;
    point->untouched = ExternalAxisInWords(std::string("eax_") + "abcdef"[i], code_, numbers[11 + i]);
  }
  if (joints_ > 6 && point->untouched.empty()) point->untouched = kMoreThanSixJoints;
}

void RapidReader::AddTarget(const std::string& name, size_t open, bool is_joints) {
  const std::vector<TextNumber> numbers = NumbersInBracket(code_, open);
  ProgramPoint point;
  point.name = name;
  point.line = source_.LineAt(open);
  point.is_joints = is_joints;
  point.used_at = std::string::npos;
  const size_t expected = is_joints ? 12 : 17;
  if (numbers.size() != expected) {
    point.untouched = "it is not written in numbers alone";
  } else if (is_joints) {
    point.numbers.assign(numbers.begin(), numbers.begin() + std::min(joints_, 6));
    if (joints_ > 6) point.untouched = "the robot has more than six joints";
    const auto is_unused = [](const TextNumber& number) { return number.value >= kUnused; };
    if (std::any_of(point.numbers.begin(), point.numbers.end(), is_unused))
      point.untouched = "it states only some of the joints";
  } else {
    point.numbers.assign(numbers.begin(), numbers.begin() + 7);
    ReadConfiguration(numbers, &point);
  }
  const std::string key = UpperCase(name);
  for (size_t r = 0; r < routines_.size(); ++r) {
    if (open >= routines_[r].first && open < routines_[r].second) locals_[r].insert(key);
  }
  named_[KeyAt(open, key)] = program_.points.size();
  program_.points.push_back(point);
}

void RapidReader::ReadDeclarations() {
  static const std::regex declaration = MakeCodePattern(
      "\\b(ROBTARGET|JOINTTARGET|TOOLDATA|WOBJDATA|LOADDATA)\\s+(\\w+)\\s*(\\{[^}]{0,99}\\})?\\s*:=\\s*(\\[)");
  for (const std::smatch& match : AllMatches(upper_.begin(), upper_.end(), declaration)) {
    const size_t open = static_cast<size_t>(match.position(4));
    const std::string name = code_.substr(static_cast<size_t>(match.position(2)), static_cast<size_t>(match.length(2)));
    if (EndOfBracket(code_, open) == std::string::npos) {
      throw InputError({program_.path, source_.LineAt(open), name}, "the brackets of this value are not closed");
    }
    const std::string type = match[1];
    if (match[3].matched) {
      if (type[0] == 'T' || type[0] == 'W' || type[0] == 'L') continue;
      ProgramPoint array;
      array.name = name;
      array.line = source_.LineAt(open);
      array.untouched = "it is an array of targets";
      program_.points.push_back(array);
    } else if (type == "TOOLDATA") {
      tools_.AddTool(UpperCase(name), open);
    } else if (type == "WOBJDATA") {
      tools_.AddWorkObject(UpperCase(name), open);
    } else if (type == "LOADDATA") {
      tools_.AddPayload(UpperCase(name), open);
    } else {
      AddTarget(name, open, type == "JOINTTARGET");
    }
  }
}

// gun.tload.mass := 7; piece := other;   a word before the name is a type only in a declaration.
void RapidReader::ReadChanges() {
  static const std::set<std::string> types = {"TOOLDATA", "WOBJDATA", "LOADDATA", "ROBTARGET", "JOINTTARGET"};
  for (size_t sign = upper_.find(":="); sign != std::string::npos; sign = upper_.find(":=", sign + 2)) {
    const auto [word, name, part, at] = AssignedBefore(upper_, sign);
    if (types.count(word) > 0 || name.empty() || (at > 0 && upper_[at - 1] == '\\')) continue;
    tools_.Change(name, part);
    const auto target = named_.find(KeyAt(at, name));
    if (target != named_.end()) program_.points[target->second].untouched = "the program changes it as it runs";
  }
}

// SetDataVal "piece", 5; SetAllDataVal "loaddata", other;
void RapidReader::ReadChangesByName() {
  static const std::regex change = MakeCodePattern("\\bSET(?:ALL)?DATAVAL\\b");
  for (const std::smatch& match : AllMatches(upper_.begin(), upper_.end(), change)) {
    const size_t at = static_cast<size_t>(match.position(0) + match.length(0));
    const std::string name = match[0] == "SETDATAVAL" ? RapidNameAt(source_, {at, upper_.find(',', at)}) : "";
    tools_.Change(name, "");
    for (const auto& [key, index] : named_) {
      if (!name.empty() && key.substr(key.find('#') + 1) != name) continue;
      program_.points[index].untouched = "the program changes it, or what a text names, as it runs";
    }
  }
}

std::string RapidReader::WhyNot(const Manner& manner, const ProgramPoint& point) const {
  for (const RapidVariable variable : {kDisplacement, kAxisOffset}) {
    for (const std::string& value : flow_.Of(variable)) {
      if (point.is_joints || value.empty() || IsOff(value)) continue;
      return "a displacement (PDispOn, PDispSet, EOffsOn, EOffsSet) may be active there";
    }
  }
  if (!manner.is_clear) return "its tool or work object is chosen as the program runs";
  return tools_.WhyNot(manner.tool, manner.frame, point.is_joints);
}

// After ConfJ\Off and ConfL\Off the solution is the one that is nearest to where the arm is. False: the text does not
// decide whether it is.
bool RapidReader::UseConfiguration(const Manner& manner, bool is_first, ProgramPoint* point) {
  const FlowValues& values = flow_.Of(manner.is_linear ? kConfL : kConfJ);
  const auto off = static_cast<size_t>(
      std::count_if(values.begin(), values.end(), [](const std::string& value) { return IsOff(value); }));
  const bool is_off = off == values.size();
  const bool is_clear = (is_off || off == 0) && (is_first || is_off == point->branch.from_before);
  point->branch.from_before = is_off;
  return is_clear;
}

void RapidReader::Use(int index_of_point, const Manner& manner) {
  const size_t index = static_cast<size_t>(index_of_point);
  used_.resize(program_.points.size(), false);
  ProgramPoint* point = &program_.points[index];
  const bool is_first = !used_[index], was_untouched = !point->untouched.empty();
  used_[index] = true;
  if (is_first) point->used_at = manner.at;
  FlowValues loads;
  for (const std::string& gripped : flow_.Of(kGripped)) {
    loads.insert(tools_.LoadWith(manner.tool, manner.total_load, gripped));
    if (tools_.IsLoadChanged(manner.tool, gripped)) loads.insert(kSetElsewhere);
  }
  ComeFrom(flow_.Of(kRapidArm), point);
  UseLoads(loads, is_first, point);
  if (!was_untouched) point->untouched = WhyNot(manner, *point);
  if (!point->is_joints && point->untouched.empty() && !UseConfiguration(manner, is_first, point)) {
    point->untouched = "the program moves to it with and without its configuration (ConfJ, ConfL)";
  }
  if (!is_first && (point->tool != manner.tool || point->frame != manner.frame) && point->untouched.empty()) {
    point->untouched = "the program moves to it with more than one tool or work object";
  }
  point->tool = manner.tool;
  point->frame = manner.frame;
}

// Speed, zone, tool, \WObj and \TLoad; behind the tool of MoveLDO stand a signal and its value, of MoveLSync a name.
RapidReader::Manner RapidReader::MannerOf(const std::smatch& match, TextRange arguments,
                                          const std::vector<TextRange>& positional) {
  static const std::regex object = MakeCodePattern("\\\\\\s*WOBJ\\b");
  static const std::regex object_name = MakeCodePattern("\\\\\\s*WOBJ\\s*:=\\s*(\\w+)\\s*(?=\\\\|,|$)");
  static const std::regex tool_name = MakeCodePattern("^(\\w+)\\s*(?=\\\\|$)");
  static const std::regex total = MakeCodePattern("\\\\\\s*TLOAD\\s*:=\\s*(\\w+)");
  const std::string text = upper_.substr(arguments.first, arguments.second - arguments.first);
  Manner manner;
  manner.at = arguments.first;
  manner.is_linear = match[3] != "J" && match[3] != "ABSJ";
  const size_t targets = match[3] == "C" ? 2 : 1, behind = match[4].matched ? 2 : match[5].matched ? 1 : 0;
  const bool is_move = match[1].str().compare(0, 4, "MOVE") == 0;
  const bool is_complete =
      positional.size() > targets + behind + 1 && (!is_move || positional.size() == targets + 3 + behind);
  std::smatch found;
  std::string frame = "WOBJ0";
  if (SearchPattern(text, &found, object_name)) {
    frame = found[1];
  } else if (SearchPattern(text, object)) {
    manner.is_clear = false;
  }
  if (SearchPattern(text, &found, total)) manner.total_load = found[1];
  if (!manner.total_load.empty()) {
    program_.unclear_loads[manner.total_load] =
        "of what \\TLoad names it is not known in which frame its centre of mass is given";
  }
  const TextRange place = is_complete ? positional[positional.size() - 1 - behind] : TextRange();
  const std::string tool_text = upper_.substr(place.first, place.second - place.first);
  const bool is_named = is_complete && SearchPattern(tool_text, &found, tool_name);
  const std::string tool = is_named ? found[1].str() : "";
  manner.is_clear &= is_named && !IsParameter(manner.at, tool) && !IsParameter(manner.at, frame);
  manner.tool = tool == "TOOL0" ? kFlangeName : tool;
  manner.frame = frame == "WOBJ0" ? kWorldName : frame;
  return manner;
}

// MoveL p10, v1000, z50, tool1 \WObj := wobj1, wherever it stands in a line: IF di1=1 MoveL ..., CASE 1: MoveL ...
void RapidReader::ReadMotion(const std::smatch& match) {
  const size_t begin = static_cast<size_t>(match.position(1));
  const size_t after = static_cast<size_t>(match.position(0) + match.length(0));
  const size_t end = std::min(code_.find(';', begin), code_.size());
  motions_.emplace_back(begin, end);
  std::vector<TextRange> positional;
  for (const TextRange& part : PartsOf(code_, after, end)) {
    if (part.first >= part.second || code_[part.first] != '\\') positional.push_back(part);  // \Conc
  }
  const Manner manner = MannerOf(match, {after, end}, positional);
  const std::string command = code_.substr(begin, static_cast<size_t>(match.length(1)));
  const size_t first = match[2].matched ? 2 : 0;  // SearchL signal, place, target
  const size_t last = std::min(first + (match[3] == "C" ? 2 : 1), positional.size());
  for (size_t i = first; i < last; ++i) {
    if (positional[i].first >= positional[i].second) continue;
    ReadTarget(command, positional[i], match[3] == "ABSJ");
    const ProgramMotion& motion = program_.motions.back();
    Use(motion.point, manner);
    motion.is_offset ? flow_.SetUnknown(kRapidArm) : flow_.Set(kRapidArm, std::to_string(motion.point));
  }
}

// Of an instruction that is not known, or a routine that is handed the point, nobody knows with which tool it moves.
void RapidReader::ReadUnknownInstructions() {
  const auto named = named_;
  for (const auto& [key, index] : named) {
    if (program_.points[index].numbers.empty() || program_.points[index].is_joints) continue;
    const std::string name = key.substr(key.find('#') + 1);
    for (const size_t at : PlacesOf(upper_, name)) {
      const auto behind = std::upper_bound(motions_.begin(), motions_.end(), TextRange{at, std::string::npos});
      const bool is_read = behind != motions_.begin() && at < std::prev(behind)->second;
      if (!is_read && KeyAt(at, name) == key) ReadOtherUse(index, at, at + name.size());
    }
  }
}

void RapidReader::ReadOtherUse(size_t index, size_t at, size_t name_end) {
  static const std::regex option = MakeCodePattern("\\\\\\s*\\w+\\s*:="), returned = MakeCodePattern("\\bRETURN\\s+$"),
                          offset = MakeCodePattern("\\b(?:OFFS|RELTOOL)\\s*\\(\\s*$");
  const size_t next = upper_.find_first_not_of(" \t\r\n", name_end);
  if (next == std::string::npos || std::string_view(",;\\").find(upper_[next]) == std::string_view::npos) return;
  const size_t begin = upper_.find_last_of(';', at) + 1;  // npos + 1 is 0
  const std::string before = upper_.substr(begin, at - begin);
  const auto count = [&](char c) { return std::count(before.begin(), before.end(), c); };
  if (ReplacePattern(before, option, "").find(":=") != std::string::npos || SearchPattern(before, returned)) return;
  if (count('(') > count(')') && !SearchPattern(before, offset)) return;  // a value is computed of it
  ProgramPoint& point = program_.points[index];
  if (before.find("PDISPON") != std::string::npos) {
    if (point.untouched.empty()) point.untouched = "PDispOn computes a displacement of it";
    return;
  }
  const size_t line = std::max(begin, upper_.find_last_of('\n', at) + 1);
  ProgramMotion motion = MotionTo("", source_, {line, std::min(code_.find(';', at), code_.size())});
  motion.name.erase(0, 1);
  motion.point = static_cast<int>(index);
  program_.motions.push_back(motion);
  if (point.untouched.empty()) {
    point.untouched = "an instruction that is not known as a motion, or a routine, is handed it (line " +
                      std::to_string(source_.LineAt(at)) + ")";
  }
}

// p10, [[...]], Offs(p10, ...), RelTool(p10, ...), and what is computed: p{3}, CRobT().
void RapidReader::ReadTarget(const std::string& command, TextRange part, bool is_joints) {
  static const std::regex offset = MakeCodePattern("^(?:OFFS|RELTOOL)\\s*\\(\\s*(\\w+)\\s*,");
  static const std::regex name_alone = MakeCodePattern("^(\\w+)\\s*(?=\\\\|$)");  // \NoEOffs, \ID may follow
  ProgramMotion motion = MotionTo(command, source_, part);
  const std::string text = upper_.substr(part.first, part.second - part.first);
  const std::string in_motion = UpperCase(command) + " of line " + std::to_string(motion.line);
  std::smatch word;
  motion.is_offset = SearchPattern(text, &word, offset);
  if (motion.is_offset || SearchPattern(text, &word, name_alone)) {
    const auto [named, is_new] = named_.try_emplace(KeyAt(part.first, word[1]), 0);
    if (is_new) {
      const std::string name =
          code_.substr(part.first + static_cast<size_t>(word.position(1)), static_cast<size_t>(word.length(1)));
      named->second = static_cast<size_t>(AddPointElsewhere(name, motion.line, part.first, &program_));
      if (IsParameter(part.first, word[1])) program_.points.back().untouched = "it is handed to the routine";
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

void RapidReader::ReadInstructions() {
  static const std::regex instruction = MakeCodePattern(
      "\\b(?:((?:MOVE|TRIGG|(SEARCH)|ARC|SPOT|DISP)(ABSJ|[JLC])(?:([DAG]O)|(SYNC)|IOS|START|END)?\\d?)(?=[\\s\\\\\\[])"
      "|(GRIPLOAD)\\b|(PDISP|EOFFS)(ON|SET|OFF)\\b|(CONF[JL])\\b\\s*(?:\\\\\\s*(ON|OFF)\\b)?|(SETSYSDATA) (\\w+))");
  static const std::regex declared = MakeCodePattern("\\b(?:PROC|TRAP|FUNC\\s+\\w+)\\s+$");
  for (const std::smatch& match : AllMatches(upper_.begin(), upper_.end(), instruction)) {
    const size_t at = static_cast<size_t>(match.position(0));
    flow_.MoveTo(at);
    if (match[6].matched) {
      static const std::regex name = MakeCodePattern("^\\s(\\w+)\\s?$");
      const size_t begin = at + static_cast<size_t>(match.length(0));
      const std::string load = upper_.substr(begin, std::min(upper_.find(';', begin), begin + 99) - begin);
      std::smatch word;
      const bool is_name = MatchPattern(load, &word, name);
      is_name ? flow_.Set(kGripped, word[1] == "LOAD0" ? "" : word[1].str()) : flow_.SetUnknown(kGripped);
    } else if (match[11].matched) {
      // Of a payload and of a total load alike; every motion names its own tool and work object.
      if (!tools_.IsToolOrWorkObject(match[12])) flow_.SetUnknown(kGripped);
    } else if (match[7].matched) {
      flow_.Set(match[7] == "PDISP" ? kDisplacement : kAxisOffset, match[8]);
    } else if (match[9].matched) {
      flow_.Set(match[9] == "CONFJ" ? kConfJ : kConfL, match[10]);
    } else if (const size_t line = at - std::min<size_t>(at, 60);
               !SearchPattern(upper_.substr(line, at - line), declared)) {
      ReadMotion(match);
    }
  }
}

// Nobody knows with which tool another file goes to it; a file of declarations alone is asked for one.
void RapidReader::LeaveUnused() {
  used_.resize(program_.points.size(), false);
  for (size_t i = 0; i < used_.size() && !program_.motions.empty(); ++i) {
    ProgramPoint& point = program_.points[i];
    if (!used_[i] && !point.is_joints && point.untouched.empty()) point.untouched = "no motion in this file goes to it";
  }
}

void RapidReader::Read() {
  ReadRoutines();
  ReadDeclarations();
  ReadChanges();
  ReadChangesByName();
  ReadInstructions();
  ReadUnknownInstructions();
  LeaveUnused();
  FindCallsElsewhere(source_.InCapitals(), &program_);
  FindRapidCallsElsewhere(source_.InCapitals(), &program_);
  source_.PlaceInFile(&program_);
}

}  // namespace

void ReadRapid(int joints, RobotProgram* program) { RapidReader(joints, program).Read(); }

}  // namespace sagitta

// KUKA KRL: .src and .dat. Points are aggregates, {X 1, Y 2, ..., A 0, S 2, T 35} and {A1 0, A2 -90, ...}; tool and
// base of taught points stand in their FDAT, of others in $TOOL and $BASE as the program goes. The load, {M 5, CM {X 0,
// ...}, J {...}} with the centre of mass in the flange and all that hangs there in it, is $LOAD; BAS sets it with
// $TOOL. What the program changes as it runs (LOAD_DATA[1].M = 5, a second LOAD_DATA[1] = {...}) is not stated.
#include <limits>
#include <optional>
#include <set>

#include "models/constants.h"
#include "problems/input_error.h"
#include "problems/io/pattern.h"
#include "problems/io/programs/krl_flow.h"
#include "problems/io/programs/program_text.h"

namespace sagitta {
namespace {

using Fields = std::map<std::string, TextRange>;
class KrlReader {
 public:
  KrlReader(int joints, RobotProgram* program)
      : joints_(joints),
        program_(*program),
        code_(UpperCase(WithoutComments(program->text, ";", '"'))),
        flow_(FlowOfKrl(code_)) {}

  void Read();

 private:
  Fields FieldsAt(size_t open) const;
  void ReadLine(size_t begin, size_t end);
  void ReadScene(const std::string& line, size_t begin);
  bool ReadLoad(const std::string& line, size_t begin);
  bool ReadChange(const std::string& line, size_t begin);
  void StateLoad(const std::string& name, size_t open);
  void ReadFrameData(const std::string& name, size_t open);
  void ReadMotion(const std::string& word, size_t begin, size_t end);
  void AddPoint(const std::string& name, size_t open);
  void FillJoints(const Fields& fields, ProgramPoint* point) const;
  void FillPose(const Fields& fields, ProgramPoint* point) const;
  int LiteralPoint(const std::string& word, TextRange place);
  int NamedPoint(const std::string& word, TextRange place);
  void UseHere(int index, size_t at);
  void UseScene(bool is_first, ProgramPoint* point);
  void ReadWith(const std::string& line, size_t begin);
  void SetScene(const std::string& what, const std::string& value, size_t at);
  void CheckFrames();
  void ReadPointDeclaration(const std::string& type, const std::string& name, size_t open);
  void CheckStatus(bool is_linear, ProgramPoint* point);
  void ReadAllFrameData();
  std::string NameOf(const std::string& text, size_t at, const char* null_name,
                     std::map<std::string, Pose<double>>* stated);

  const int joints_;
  RobotProgram& program_;
  const std::string code_;
  ProgramFlow flow_;  // "": tool, base or load is not set so far
  std::map<std::string, size_t> named_;
  std::vector<bool> used_;                      // by a motion
  std::set<size_t> loaded_;                     // points whose FDAT says the tool, and so the load
  std::set<size_t> frames_;                     // declared as FRAME: targets only where a motion goes to them
  std::map<std::string, size_t> frame_data_;    // FDAT: where its aggregate opens
  std::pair<int, int> status_before_ = {0, 0};  // bits that the motion before states, and what they are
  StatedOnce<ProgramLoad> loads_;
  StatedOnce<Pose<double>> tools_, bases_;
};

// "{E6POS: X 1, Y 2}" -> X, Y with the places of their values.
Fields KrlReader::FieldsAt(size_t open) const {
  const size_t end = EndOfBracket(code_, open);
  if (end == std::string::npos) {
    throw InputError({program_.path, LineAt(code_, open), ""}, "the brace of this aggregate is not closed");
  }
  size_t begin = open + 1;
  const size_t colon = code_.find(':', begin);
  if (colon < end) begin = colon + 1;
  Fields fields;
  for (const TextRange& part : PartsOf(code_, begin, end - 1)) {
    size_t name_end = part.first;
    while (name_end < part.second && (IsWordCharacter(code_[name_end]))) ++name_end;
    size_t value = name_end;
    while (value < part.second && (code_[value] == ' ' || code_[value] == '\t')) ++value;
    fields[code_.substr(part.first, name_end - part.first)] = {value, part.second};
  }
  return fields;
}

void KrlReader::FillJoints(const Fields& fields, ProgramPoint* point) const {
  point->is_joints = true;
  for (int j = 1; j <= joints_; ++j) {
    const auto field = fields.find("A" + std::to_string(j));
    TextNumber number;
    if (field == fields.end() || !NumberAt(code_, field->second, &number)) {
      point->untouched = "it states only some of the joints";
      return;
    }
    point->numbers.push_back(number);
  }
}

void KrlReader::FillPose(const Fields& fields, ProgramPoint* point) const {
  for (const char* name : {"X", "Y", "Z", "A", "B", "C"}) {
    const auto field = fields.find(name);
    TextNumber number;
    if (field == fields.end() || !NumberAt(code_, field->second, &number)) {
      point->untouched = "it states only a part of the pose";
      return;
    }
    point->numbers.push_back(number);
  }
  for (int e = 1; e <= 6 && point->untouched.empty(); ++e) {
    const std::string axis = "E" + std::to_string(e);
    const auto field = fields.find(axis);
    TextNumber number;
    if (field == fields.end()) continue;
    if (!NumberAt(code_, field->second, &number)) {
      point->untouched = "external axis " + axis + " is not written as a number";
    } else if (number.value != 0.0) {
      point->untouched = ExternalAxisInWords(axis, code_, number);
    }
  }
  if (joints_ > 6 && point->untouched.empty()) point->untouched = kMoreThanSixJoints;
  const auto s = fields.find("S"), t = fields.find("T");
  if (s == fields.end() || t == fields.end()) {
    point->branch.from_before = true;  // LIN and CIRC stay on the branch where the arm is
    return;
  }
  const std::optional<int> status = KrlBitsAt(code_, s->second), turn = KrlBitsAt(code_, t->second);
  if (!status || !turn) {
    if (point->untouched.empty()) point->untouched = "its status or turn is not written as a number";
    return;
  }
  const int bits = *status, turns = *turn;
  point->branch.wrist_behind = (bits & 1) != 0;
  point->branch.elbow_past_stretch = (bits & 2) != 0;
  point->branch.wrist_negative = (bits & 4) != 0;
  constexpr double kFar = std::numeric_limits<double>::infinity();
  for (int j = 0; j < joints_; ++j) {
    const bool negative = (turns & (1 << j)) != 0;
    point->branch.ranges.push_back({j, negative ? std::make_pair(-kFar, 0.0) : std::make_pair(0.0, kFar)});
  }
}

void KrlReader::AddPoint(const std::string& name, size_t open) {
  const Fields fields = FieldsAt(open);
  ProgramPoint point;
  point.name = name;
  point.line = LineAt(code_, open);
  const bool has_joints = fields.count("A1") + fields.count("A2") + fields.count("A3") > 0;
  const bool has_pose = fields.count("X") + fields.count("Y") + fields.count("Z") > 0;
  if (!has_joints && !has_pose) return;
  has_joints ? FillJoints(fields, &point) : FillPose(fields, &point);
  point.used_at = open;
  named_[name] = program_.points.size();
  program_.points.push_back(point);
}

// A motion to a declared point: with the tool and base that are set.
void KrlReader::UseHere(int index, size_t at) {
  const size_t i = static_cast<size_t>(index);
  used_.resize(program_.points.size(), false);
  ProgramPoint& point = program_.points[i];
  const bool is_first = !used_[i];
  if (is_first) point.used_at = at;
  if (loaded_.count(i) == 0) UseLoads(flow_.Of(kKrlLoad), is_first, &point);
  used_[i] = true;
  if (!point.is_joints && point.untouched.empty()) UseScene(is_first, &point);
}

void KrlReader::UseScene(bool is_first, ProgramPoint* point) {
  const FlowValues &tools = flow_.Of(kKrlTool), &bases = flow_.Of(kKrlBase);
  if (flow_.Of(kKrlMode) != FlowValues{""}) {
    point->untouched = "$IPO_MODE may be #TCP there: the tool stands in the room and the robot holds the workpiece";
    return;
  }
  const std::string &tool = *tools.begin(), &base = *bases.begin();
  const bool fits = (point->tool == tool || (is_first && point->tool.empty())) &&
                    (point->frame == base || (is_first && point->frame.empty()));
  if (!fits || tools.size() > 1 || bases.size() > 1) {
    point->untouched = "the program moves to it with more than one tool or base";
    return;
  }
  point->tool = tool;
  point->frame = base;
}

std::string KrlReader::NameOf(const std::string& text, size_t at, const char* null_name,
                              std::map<std::string, Pose<double>>* stated) {
  if (text == "$NULLFRAME") return null_name;
  if (text.empty() || text[0] != '{') return text;
  ProgramPoint point;
  FillPose(FieldsAt(at), &point);
  if (!point.untouched.empty()) return text;
  std::vector<double> numbers;
  for (const TextNumber& number : point.numbers) numbers.push_back(number.value);
  const std::string name = std::string(null_name == std::string(kFlangeName) ? "$TOOL" : "$BASE") + " of line " +
                           std::to_string(LineAt(code_, at));
  (*stated)[name] = PoseFrom(PoseNotation::kAbcDegrees, numbers);
  return name;
}

// A mass below 0 is the controller's word for one that nobody has stated.
void KrlReader::StateLoad(const std::string& name, size_t open) {
  const Fields fields = FieldsAt(open);
  const auto mass = fields.find("M"), centre = fields.find("CM");
  TextNumber number;
  if (mass == fields.end() || centre == fields.end() || code_[centre->second.first] != '{') return;
  if (!NumberAt(code_, mass->second, &number) || number.value < 0.0) return;
  ProgramLoad load;
  load.mass = number.value;
  const Fields of_centre = FieldsAt(centre->second.first);
  for (int a = 0; a < 3; ++a) {
    const auto at = of_centre.find(std::string(1, "XYZ"[a]));
    if (at == of_centre.end() || !NumberAt(code_, at->second, &number)) return;
    load.centre[a] = number.value / 1e3;
  }
  loads_.State(name, load, &program_.loads);
}

// $TOOL, $BASE or $LOAD = value, $IPO_MODE = #TCP
void KrlReader::SetScene(const std::string& what, const std::string& value, size_t at) {
  if (what == "IPO_MODE") {
    flow_.Set(kKrlMode, value == "#BASE" ? "" : value);
  } else if (what == "TOOL") {
    flow_.Set(kKrlTool, NameOf(value, at, kFlangeName, &program_.tools));
  } else if (what == "BASE") {
    flow_.Set(kKrlBase, NameOf(value, at, kWorldName, &program_.frames));
  } else if (value[0] != '{') {
    flow_.Set(kKrlLoad, value);
  } else {
    const std::string load = "$LOAD of line " + std::to_string(LineAt(code_, at));
    flow_.Set(kKrlLoad, load);
    StateLoad(load, at);
  }
}

// SLIN XP1 WITH $VEL.CP = 0.2, $BASE = BASE_DATA[2]: for this one motion.
void KrlReader::ReadWith(const std::string& line, size_t begin) {
  static const std::regex with = MakePattern("[\\s}\\])]WITH\\s+(?=\\$)"),
                          set = MakePattern("^\\$(TOOL|BASE|LOAD|IPO_MODE)\\s*=\\s*");
  std::smatch match;
  if (!SearchPattern(line, &match, with)) return;
  const size_t from = begin + static_cast<size_t>(match.position(0) + match.length(0));
  for (const TextRange& part : PartsOf(code_, from, begin + line.size())) {
    const std::string text = code_.substr(part.first, part.second - part.first);
    if (!SearchPattern(text, &match, set)) continue;
    const size_t length = static_cast<size_t>(match.length(0));
    SetScene(match[1], text.substr(length), part.first + length);
  }
}

// $LOAD = ..., LOAD_DATA[1] = {...}, DECL LOAD GRIPPER = {...}
bool KrlReader::ReadLoad(const std::string& line, size_t begin) {
  static const std::regex set = MakePattern("^\\s*\\$LOAD\\s*=\\s*(\\S.*?)\\s*$");
  static const std::regex data = MakePattern("^\\s*\\$?(LOAD_DATA)\\s*\\[\\s*(\\d+)\\s*\\]\\s*=\\s*(\\{)");
  static const std::regex named =
      MakePattern("^\\s*(?:DECL\\s+)?(?:GLOBAL\\s+)?(?:CONST\\s+)?LOAD\\s+(\\w+)()\\s*=\\s*(\\{)");
  std::smatch match;
  if (SearchPattern(line, &match, set)) {
    SetScene("LOAD", match[1], begin + static_cast<size_t>(match.position(1)));
    return true;
  }
  if (!SearchPattern(line, &match, data) && !SearchPattern(line, &match, named)) return false;
  const std::string number = match[2];
  StateLoad(match[1].str() + (number.empty() ? "" : "[" + number + "]"),
            begin + static_cast<size_t>(match.position(3)));
  return true;
}

// $TOOL = ..., $BASE = ..., BAS(#TOOL, 1), TOOL_DATA[1] = {...}
void KrlReader::ReadScene(const std::string& line, size_t begin) {
  static const std::regex set = MakePattern("^\\s*\\$(TOOL|BASE|IPO_MODE)\\s*=\\s*(\\S.*?)\\s*$");
  static const std::regex bas = MakePattern("BAS\\s*\\(\\s*#(TOOL|BASE)\\s*,\\s*(\\d+)\\s*\\)");
  static const std::regex data = MakePattern("^\\s*(TOOL_DATA|BASE_DATA)\\s*\\[\\s*(\\d+)\\s*\\]\\s*=\\s*(\\{)");
  std::smatch match;
  if (SearchPattern(line, &match, set)) {
    SetScene(match[1], match[2], begin + static_cast<size_t>(match.position(2)));
  } else if (SearchPattern(line, &match, bas)) {
    const bool is_tool = match[1] == "TOOL", is_null = match[2] == "0";
    const std::string place = "[" + match[2].str() + "]";
    const std::string null_name = is_tool ? kFlangeName : kWorldName;
    flow_.Set(is_tool ? kKrlTool : kKrlBase, is_null ? null_name : match[1].str() + "_DATA" + place);
    if (is_tool) flow_.Set(kKrlLoad, is_null ? "" : "LOAD_DATA" + place);
  } else if (SearchPattern(line, &match, data)) {
    std::map<std::string, Pose<double>> one;
    const std::string written = "{";
    const std::string name = NameOf(written, begin + static_cast<size_t>(match.position(3)), kFlangeName, &one);
    if (one.empty()) return;
    const std::string place = match[1].str() + "[" + match[2].str() + "]";
    const bool is_tool = match[1] == "TOOL_DATA";
    (is_tool ? tools_ : bases_).State(place, one.begin()->second, is_tool ? &program_.tools : &program_.frames);
  }
}

// Other values of what is stated: LOAD_DATA[1].M = 5, TOOL_DATA[2] = X, GRIPPER.CM.X = 10, $TOOL.Z = 3, XP1.Z = 4.
bool KrlReader::ReadChange(const std::string& line, size_t begin) {
  static const std::regex change = MakePattern(
      "^\\s*(?:\\$(TOOL|BASE|LOAD)|\\$?(TOOL|BASE|LOAD)_DATA\\s*\\[\\s*(\\w+)\\s*\\]|(\\w+))\\s*((?:\\.\\s*\\w+\\s*)*)"
      "=\\s*(?=\\S)");
  std::smatch match;
  if (!SearchPattern(line, &match, change)) return false;
  const bool is_part = match.length(5) > 0;
  const bool is_literal = !is_part && code_[begin + static_cast<size_t>(match.length(0))] == '{';
  if (match[1].matched) {
    if (!is_part) return false;
    const std::string here = "$" + match[1].str() + " of line " + std::to_string(LineAt(code_, begin));
    flow_.Set(match[1] == "TOOL" ? kKrlTool : match[1] == "BASE" ? kKrlBase : kKrlLoad, here);
    return true;
  }
  const auto changed = is_literal ? named_.end() : named_.find(match[4]);
  if (changed != named_.end()) {
    program_.points[changed->second].untouched = "the program changes it as it runs";
    return true;
  }
  if (match[4].matched) {
    if (program_.loads.count(match[4]) == 0) return false;
    loads_.Change(match[4], &program_.loads);
    return true;
  }
  if (is_literal) return false;
  const std::string place = match[2].str() + "_DATA[" + match[3].str() + "]";
  if (match[2] == "LOAD") loads_.Change(place, &program_.loads);
  if (match[2] == "TOOL") tools_.Change(place, &program_.tools);
  if (match[2] == "BASE") bases_.Change(place, &program_.frames);
  return true;
}

// FDAT of XP1 is FP1; it may stand above its point or below.
void KrlReader::ReadAllFrameData() {
  static const std::regex data = MakePattern("\\bFDAT\\s+(F[\\w$]*)\\s*=\\s*(\\{)");
  for (const std::smatch& match : AllMatches(code_.begin(), code_.end(), data)) {
    frame_data_[match[1]] = static_cast<size_t>(match.position(2));
  }
}

void KrlReader::ReadFrameData(const std::string& name, size_t open) {
  const auto found = named_.find("X" + name.substr(1));
  if (found == named_.end() || name[0] != 'F') return;
  const Fields fields = FieldsAt(open);
  ProgramPoint& point = program_.points[found->second];
  const auto number = [&](const char* field, const std::string& stem, const char* zero) -> std::string {
    TextNumber value;
    const auto at = fields.find(field);
    if (at == fields.end() || !NumberAt(code_, at->second, &value) || value.value < 0) return "";
    return value.value == 0 ? zero : stem + "[" + std::to_string(static_cast<int>(value.value)) + "]";
  };
  point.tool = number("TOOL_NO", "TOOL_DATA", kFlangeName);
  point.frame = number("BASE_NO", "BASE_DATA", kWorldName);
  point.load = number("TOOL_NO", "LOAD_DATA", "");
  loaded_.insert(found->second);
  const auto mode = fields.find("IPO_FRAME");
  if (mode != fields.end() && code_.compare(mode->second.first, 4, "#TCP") == 0) {
    point.untouched = "its tool stands in the room and the robot holds the workpiece";
  }
}

int KrlReader::LiteralPoint(const std::string& word, TextRange place) {
  const int line = LineAt(code_, place.first);
  const std::string name = word + " of line " + std::to_string(line);
  const size_t before = program_.points.size();
  AddPoint(name, place.first);
  if (program_.points.size() == before) {
    return AddComputedPoint(name, line, place.first, "it states only a part of the pose", &program_);
  }
  ProgramPoint& point = program_.points.back();
  UseLoads(flow_.Of(kKrlLoad), true, &point);
  if (!point.is_joints && point.untouched.empty()) UseScene(true, &point);
  return static_cast<int>(before);
}

// XP1, and what is computed of one: XP1:XOFF, XP[I], PLACE(3).
int KrlReader::NamedPoint(const std::string& word, TextRange place) {
  size_t stop = place.first;
  while (stop < place.second && IsWordCharacter(code_[stop])) ++stop;
  const size_t next = code_.find_first_not_of(' ', stop);
  const int line = LineAt(code_, place.first);
  if (next < place.second && std::string_view(":[(.").find(code_[next]) != std::string_view::npos) {
    const std::string why =
        code_[next] == '[' ? "it is one of an array" : "it is computed: " + Quoted(code_, {place.first, place.second});
    return AddComputedPoint(word + " of line " + std::to_string(line), line, place.first, why, &program_);
  }
  const std::string name = code_.substr(place.first, stop - place.first);
  const auto [named, is_new] = named_.try_emplace(name, 0);
  if (is_new) named->second = static_cast<size_t>(AddPointElsewhere(name, line, place.first, &program_));
  const int index = static_cast<int>(named->second);
  UseHere(index, place.first);
  return index;
}

// Controllers go by status and turn for PTP alone: LIN and CIRC stay on the branch where the arm is. Which that is the
// motion before says: by its status, or by the sign of A5.
void KrlReader::CheckStatus(bool is_linear, ProgramPoint* point) {
  if (point->is_joints && point->numbers.size() > 4) {
    const double a5 = point->numbers[4].value;
    status_before_ = {a5 == 0.0 ? 0 : 4, a5 < 0.0 ? 4 : 0};
    return;
  }
  const StatedBranch& branch = point->branch;
  if (!branch.wrist_behind || !branch.elbow_past_stretch || !branch.wrist_negative) {
    if (point->numbers.empty()) status_before_ = {0, 0};  // it stands in another file
    return;
  }
  const int bits =
      (*branch.wrist_behind ? 1 : 0) + (*branch.elbow_past_stretch ? 2 : 0) + (*branch.wrist_negative ? 4 : 0);
  if (is_linear && ((bits ^ status_before_.second) & status_before_.first) != 0) {
    if (point->untouched.empty()) {
      point->untouched = "its status is another than where the arm comes from, and LIN and CIRC do not change it";
    }
    return;
  }
  status_before_ = {7, bits};
}

// PTP and LIN go to the first part, CIRC over the first to the second; what follows says how.
void KrlReader::ReadMotion(const std::string& word, size_t begin, size_t end) {
  const bool is_relative = word.find("REL") != std::string::npos;
  const size_t targets = word.find("CIRC") != std::string::npos ? 2 : 1;
  const std::vector<TextRange> parts = PartsOf(code_, begin, end);
  const std::vector<FlowValues> as_set = flow_.All();
  ReadWith(code_.substr(begin, end - begin), begin);
  for (size_t i = 0; i < parts.size() && i < targets; ++i) {
    if (parts[i].first >= parts[i].second) continue;
    ProgramMotion motion = MotionTo(word, code_, parts[i]);
    motion.point = code_[parts[i].first] == '{' ? LiteralPoint(word, parts[i]) : NamedPoint(word, parts[i]);
    program_.motions.push_back(motion);
    ProgramPoint& point = program_.points[static_cast<size_t>(motion.point)];
    if (is_relative) point.untouched = "a relative motion: it goes on from where the arm is";
    CheckStatus(word.find("PTP") == std::string::npos, &point);
  }
  flow_.SetAll(as_set);
}

void KrlReader::ReadPointDeclaration(const std::string& type, const std::string& name, size_t open) {
  const size_t index = program_.points.size();
  AddPoint(name, open);
  if (program_.points.size() == index) return;
  if (type == "FRAME") frames_.insert(index);
  if (name.back() == ']') program_.points.back().untouched = "it is one of an array";
  const auto data = frame_data_.find("F" + name.substr(1));
  if (name[0] == 'X' && data != frame_data_.end()) ReadFrameData(data->first, data->second);
}

// A FRAME is a target only where a motion goes to it, and what a base, a tool or a geometric operator (:) is computed
// of is none.
void KrlReader::CheckFrames() {
  static const std::regex operand = MakePattern("(?:\\$(?:BASE|TOOL)\\s*=|:)\\s*$");
  used_.resize(program_.points.size(), false);
  for (const auto& [name, index] : named_) {
    ProgramPoint& point = program_.points[index];
    if (point.is_joints || !point.untouched.empty()) continue;
    const bool is_frame = frames_.count(index) > 0;
    if (is_frame && !used_[index]) point.untouched = "no motion in this file goes to it";
    for (const size_t at : PlacesOf(code_, name)) {
      const size_t line = code_.find_last_of('\n', at) + 1, next = code_.find_first_not_of(" \t", at + name.size());
      const bool is_left = is_frame && next < code_.size() && code_[next] == ':';
      if (is_left || SearchPattern(code_.substr(line, at - line), operand)) {
        point.untouched = "a base, a tool or another pose is computed of it";
      }
    }
  }
}

void KrlReader::ReadLine(size_t begin, size_t end) {
  const std::string line = code_.substr(begin, end - begin);
  static const std::regex declaration = MakePattern(
      "^\\s*(?:DECL\\s+)?(?:GLOBAL\\s+)?(?:CONST\\s+)?(?:(E6POS|POS|FRAME|E6AXIS|AXIS|FDAT)\\s+)?([A-Z_$][\\w$]*(?:\\[["
      "^"
      "\\]]*\\])?)\\s*=\\s*\\{");
  static const std::regex motion = MakePattern("^\\s*(S?(?:PTP|LIN|CIRC)(?:_REL)?|SPL)(?:\\s+(?=\\S)|(?=\\{))");
  std::smatch match;
  if (SearchPattern(line, &match, motion)) {
    ReadMotion(match[1], begin + static_cast<size_t>(match.position(0) + match.length(0)), end);
  } else if (ReadChange(line, begin)) {
    return;
  } else if (SearchPattern(line, &match, declaration) && match[2].str()[0] != '$' &&
             match[2].str().find("_DATA[") == std::string::npos) {
    const size_t open = begin + static_cast<size_t>(match.position(0) + match.length(0)) - 1;
    if (match[1] != "FDAT") ReadPointDeclaration(match[1], match[2], open);
  } else if (!ReadLoad(line, begin)) {
    ReadScene(line, begin);
  }
}

void KrlReader::Read() {
  program_.notation = PoseNotation::kAbcDegrees;
  ReadAllFrameData();
  for (size_t begin = 0; begin < code_.size();) {
    const size_t end = std::min(code_.find('\n', begin), code_.size());
    flow_.MoveTo(end);
    ReadLine(begin, end);
    begin = end + 1;
  }
  CheckFrames();
}

}  // namespace

void ReadKrl(int joints, RobotProgram* program) { KrlReader(joints, program).Read(); }

}  // namespace sagitta

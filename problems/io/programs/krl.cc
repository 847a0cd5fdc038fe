// KUKA KRL: .src and .dat. Points are aggregates, {X 1, Y 2, ..., A 0, S 2, T 35} and {A1 0, A2 -90, ...}; tool and
// base of taught points stand in their FDAT, of others in $TOOL and $BASE as the program goes. The load, {M 5, CM {X 0,
// ...}, J {...}} with the centre of mass in the flange and all that hangs there in it, is $LOAD; BAS sets it with
// $TOOL.
#include <limits>
#include <optional>
#include <set>

#include "models/constants.h"
#include "problems/io/pattern.h"
#include "problems/io/programs/calls_elsewhere.h"
#include "problems/io/programs/krl_calls.h"
#include "problems/io/programs/krl_scene.h"

namespace sagitta {
namespace {

constexpr size_t kLongestLine = 2000;  // bytes, as of a word (program_text.cc)

class KrlReader {
 public:
  KrlReader(int joints, RobotProgram* program)
      : joints_(joints),
        program_(*program),
        source_(ProgramCode(*program, ";", '"', kLongestLine).InCapitals()),
        code_(source_.text()),
        scene_(source_, program),
        flow_(scene_.flow()) {}

  void Read();

 private:
  void ReadLine(size_t begin, size_t end);
  bool ReadChange(const std::string& line, size_t begin);
  void ReadFrameData(const std::string& name);
  void ReadMotion(const std::string& word, size_t begin, size_t end);
  void AddPoint(const std::string& name, size_t open);
  void FillJoints(const KrlFields& fields, ProgramPoint* point) const;
  void FillPose(const KrlFields& fields, ProgramPoint* point) const;
  int LiteralPoint(const std::string& word, TextRange place);
  int NamedPoint(const std::string& word, TextRange place);
  void UseHere(int index, size_t at);
  void UseScene(bool is_first, ProgramPoint* point);
  void CheckFrames();
  void LeaveHandedOn();
  void ReadPointDeclaration(const std::string& type, const std::string& name, size_t open);
  bool CheckStatus(bool is_linear, ProgramPoint* point) const;
  void ReadSpline(const std::string& line, size_t begin);

  const int joints_;
  RobotProgram& program_;
  const ProgramCode source_;
  const std::string& code_;
  KrlScene scene_;
  ProgramFlow& flow_;
  std::map<std::string, size_t> named_;
  std::vector<bool> used_;       // by a motion
  std::set<size_t> loaded_;      // points whose FDAT says the tool, and so the load
  std::set<size_t> undeclared_;  // targets only where a motion goes to them: FRAMEs, what has no type
  std::vector<FlowValues> before_spline_;
};

void KrlReader::FillJoints(const KrlFields& fields, ProgramPoint* point) const {
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

void KrlReader::FillPose(const KrlFields& fields, ProgramPoint* point) const {
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
  if ((bits & 16) != 0 && point->untouched.empty()) {
    point->untouched = "its status says that it was taught with an absolutely accurate robot, which corrects itself";
  }
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
  const KrlFields fields = scene_.FieldsAt(open);
  ProgramPoint point;
  point.name = name;
  point.line = source_.LineAt(open);
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
  ComeFrom(flow_.Of(kKrlArm), &point);
  if (!point.is_joints && point.untouched.empty()) UseScene(is_first, &point);
}

void KrlReader::UseScene(bool is_first, ProgramPoint* point) {
  const FlowValues &tools = flow_.Of(kKrlTool), &bases = flow_.Of(kKrlBase);
  if (flow_.Of(kKrlMode) != FlowValues{""}) {
    point->untouched = "$IPO_MODE may be #TCP there: the tool stands in the room and the robot holds the workpiece";
    return;
  }
  if (tools.count(kSetElsewhere) + bases.count(kSetElsewhere) > 0) {
    point->untouched = "which tool and base are set there is decided as the program runs";
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

// XP1.Z = 4, XP1 = XP2
bool KrlReader::ReadChange(const std::string& line, size_t begin) {
  static const std::regex change = MakeCodePattern("^\\s*(\\w+)\\s*((?:\\.\\s*\\w+\\s*)*)=\\s*(?=\\S)");
  std::smatch match;
  if (!SearchPattern(line, &match, change)) return false;
  const bool is_literal = match.length(2) == 0 && code_[begin + static_cast<size_t>(match.length(0))] == '{';
  const auto changed = is_literal ? named_.end() : named_.find(match[1]);
  if (changed == named_.end()) return false;
  program_.points[changed->second].untouched = "the program changes it as it runs";
  return true;
}

void KrlReader::ReadFrameData(const std::string& name) {
  const auto found = named_.find("X" + name.substr(1));
  const KrlScene::FrameData* data = scene_.FindFrameData(name);
  if (found == named_.end() || data == nullptr) return;
  ProgramPoint& point = program_.points[found->second];
  point.tool = data->tool;
  point.frame = data->base;
  point.load = data->load;
  loaded_.insert(found->second);
  if (data->is_held) point.untouched = "its tool stands in the room and the robot holds the workpiece";
}

int KrlReader::LiteralPoint(const std::string& word, TextRange place) {
  const int line = source_.LineAt(place.first);
  const std::string name = word + " of line " + std::to_string(line);
  const size_t before = program_.points.size();
  AddPoint(name, place.first);
  if (program_.points.size() == before) {
    return AddComputedPoint(name, line, place.first, "it states only a part of the pose", &program_);
  }
  ProgramPoint& point = program_.points.back();
  UseLoads(flow_.Of(kKrlLoad), true, &point);
  ComeFrom(flow_.Of(kKrlArm), &point);
  if (!point.is_joints && point.untouched.empty()) UseScene(true, &point);
  return static_cast<int>(before);
}

// XP1, and what is computed of one: XP1:XOFF, XP[I], PLACE(3).
int KrlReader::NamedPoint(const std::string& word, TextRange place) {
  size_t stop = place.first;
  while (stop < place.second && IsWordCharacter(code_[stop])) ++stop;
  const size_t next = code_.find_first_not_of(' ', stop);
  const int line = source_.LineAt(place.first);
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

// Bits of the status that a point states, and what they are; a joint target states the sign of A5.
std::pair<int, int> StatusOf(const ProgramPoint& point) {
  if (point.is_joints && point.numbers.size() > 4) {
    const double a5 = point.numbers[4].value;
    return {a5 == 0.0 ? 0 : 4, a5 < 0.0 ? 4 : 0};
  }
  const StatedBranch& branch = point.branch;
  if (!branch.wrist_behind || !branch.elbow_past_stretch || !branch.wrist_negative) return {0, 0};
  return {7, (*branch.wrist_behind ? 1 : 0) + (*branch.elbow_past_stretch ? 2 : 0) + (*branch.wrist_negative ? 4 : 0)};
}

// Controllers go by status and turn for PTP alone: LIN and CIRC stay on the branch where the arm is. Which that is the
// points that the motion may come from say. False: the arm does not get where the point says.
bool KrlReader::CheckStatus(bool is_linear, ProgramPoint* point) const {
  const auto [mask, bits] = StatusOf(*point);
  if (!is_linear || point->is_joints || mask == 0) return true;
  ProgramPoint motion;
  ComeFrom(flow_.Of(kKrlArm), &motion);
  for (const int from : motion.before) {
    if (from < 0) continue;
    const auto [mask_before, bits_before] = StatusOf(program_.points[static_cast<size_t>(from)]);
    if (((bits ^ bits_before) & mask_before) == 0) continue;
    if (point->untouched.empty()) {
      point->untouched = "its status is another than where the arm comes from, and LIN and CIRC do not change it";
    }
    return false;
  }
  return true;
}

// PTP and LIN go to the first part, CIRC over the first to the second; what follows says how.
void KrlReader::ReadMotion(const std::string& word, size_t begin, size_t end) {
  const bool is_relative = word.find("REL") != std::string::npos;
  const size_t targets = word.find("CIRC") != std::string::npos ? 2 : 1;
  const std::vector<TextRange> parts = PartsOf(code_, begin, end);
  const std::vector<FlowValues> as_set = flow_.All();
  scene_.ReadWith(code_.substr(begin, end - begin), begin);
  for (size_t i = 0; i < parts.size() && i < targets; ++i) {
    if (parts[i].first >= parts[i].second) continue;
    ProgramMotion motion = MotionTo(word, source_, parts[i]);
    motion.point = code_[parts[i].first] == '{' ? LiteralPoint(word, parts[i]) : NamedPoint(word, parts[i]);
    program_.motions.push_back(motion);
    ProgramPoint& point = program_.points[static_cast<size_t>(motion.point)];
    if (is_relative) point.untouched = "a relative motion: it goes on from where the arm is";
    if (CheckStatus(word.find("PTP") == std::string::npos, &point)) flow_.Set(kKrlArm, std::to_string(motion.point));
  }
  flow_.SetAllBut(kKrlArm, as_set);
}

// SPLINE WITH $BASE = BASE_DATA[2] ... ENDSPLINE: for the motions in between.
void KrlReader::ReadSpline(const std::string& line, size_t begin) {
  if (line.find("ENDSPLINE") == std::string::npos) {
    before_spline_ = flow_.All();
    scene_.ReadWith(line, begin);
  } else if (!before_spline_.empty()) {
    flow_.SetAllBut(kKrlArm, before_spline_);
  }
}

void KrlReader::ReadPointDeclaration(const std::string& type, const std::string& name, size_t open) {
  const size_t index = program_.points.size();
  const auto known = named_.find(name);
  const std::optional<size_t> first = known == named_.end() ? std::nullopt : std::make_optional(known->second);
  AddPoint(name, open);
  if (program_.points.size() == index) return;
  if (type.empty() || type == "FRAME") undeclared_.insert(index);
  if (name.back() == ']') program_.points.back().untouched = "it is one of an array";
  ReadFrameData("F" + name.substr(1));
  if (!first) return;
  // Which of them a motion goes to is decided as the program runs.
  for (const size_t i : {*first, index}) {
    if (!program_.points[i].is_elsewhere) program_.points[i].untouched = "the program gives it numbers more than once";
  }
}

// A FRAME, or what has no type in its line, is a target only where a motion goes to it, and what a base, a tool or a
// geometric operator (:) is computed of is none.
void KrlReader::CheckFrames() {
  static const std::regex operand = MakeCodePattern("(?:\\$(?:BASE|TOOL)\\s*=|:)\\s*$");
  used_.resize(program_.points.size(), false);
  for (const auto& [name, index] : named_) {
    ProgramPoint& point = program_.points[index];
    if (point.is_joints || !point.untouched.empty()) continue;
    if (undeclared_.count(index) > 0 && !used_[index]) point.untouched = "no motion in this file goes to it";
    for (const size_t at : PlacesOf(code_, name)) {
      const size_t line = code_.find_last_of('\n', at) + 1, next = code_.find_first_not_of(" \t", at + name.size());
      const bool is_left = next < code_.size() && code_[next] == ':';
      if (is_left || SearchPattern(code_.substr(line, at - line), operand)) {
        point.untouched = "a base, a tool or another pose is computed of it";
      }
    }
  }
}

// What a routine is handed it may change, or move to with a tool of its own. A controller with $ABS_ACCUR has another
// model than the nominal one.
void KrlReader::LeaveHandedOn() {
  static const std::regex accurate = MakeCodePattern("\\$ABS_ACCUR ?=(?!=) ?(?!FALSE\\b)");
  const bool is_accurate = SearchPattern(code_, accurate);
  for (ProgramPoint& point : program_.points) {
    if (is_accurate && !point.is_joints && point.untouched.empty())
      point.untouched = "$ABS_ACCUR may be on: the controller then corrects the arm by a model of its own";
  }
  for (const auto& [name, index] : named_) {
    ProgramPoint& point = program_.points[index];
    if (!point.untouched.empty()) continue;
    const std::optional<size_t> at = HandedToRoutine(code_, name, true);
    if (at) point.untouched = "a routine is handed it (line " + std::to_string(source_.LineAt(*at)) + ")";
  }
}

void KrlReader::ReadLine(size_t begin, size_t end) {
  const std::string line = code_.substr(begin, end - begin);
  static const std::regex declaration = MakeCodePattern(
      "^\\s*(?:DECL\\s+)?(?:GLOBAL\\s+)?(?:CONST\\s+)?(?:(E6POS|POS|FRAME|E6AXIS|AXIS|FDAT)\\s+)?([A-Z_$][\\w$]*(?:\\["
      "[^\\]]*\\])?)\\s*=\\s*\\{");
  static const std::regex motion = MakeCodePattern("^\\s*(S?(?:PTP|LIN|CIRC)(?:_REL)?|SPL)(?:\\s+(?=\\S)|(?=\\{))"),
                          spline = MakeCodePattern("^\\s*(?:PTP_|END)?SPLINE\\b");
  std::smatch match;
  if (SearchPattern(line, &match, motion)) {
    ReadMotion(match[1], begin + static_cast<size_t>(match.position(0) + match.length(0)), end);
  } else if (SearchPattern(line, spline)) {
    ReadSpline(line, begin);
  } else if (ReadChange(line, begin) || scene_.ReadLine(line, begin)) {
    return;
  } else if (SearchPattern(line, &match, declaration) && match[1] != "FDAT" && match[2].str()[0] != '$') {
    const size_t open = begin + static_cast<size_t>(match.position(0) + match.length(0)) - 1;
    ReadPointDeclaration(match[1], match[2], open);
  }
}

void KrlReader::Read() {
  for (size_t begin = 0; begin < code_.size();) {
    const size_t end = std::min(code_.find('\n', begin), code_.size());
    flow_.MoveTo(end);
    ReadLine(begin, end);
    begin = end + 1;
  }
  CheckFrames();
  LeaveHandedOn();
  scene_.LeaveChanged();
  FindCallsElsewhere(source_, &program_);
  source_.PlaceInFile(&program_);
}

}  // namespace

void ReadKrl(int joints, RobotProgram* program) { KrlReader(joints, program).Read(); }

}  // namespace sagitta

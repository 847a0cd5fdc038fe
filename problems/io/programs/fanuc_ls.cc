// FANUC LS: section /POS, P[1]{ GP1: UF : 0, UT : 1, CONFIG : 'N U T, 0, 0, 0', X = 600.0 mm, ... W = 180.0 deg, ... };
// or J1 = 0.0 deg, .... Section /MN: which motion goes where, and PAYLOAD[n], which names what hangs on the flange; its
// numbers are in the controller.
#include <algorithm>
#include <set>

#include "models/constants.h"
#include "problems/input_error.h"
#include "problems/io/pattern.h"
#include "problems/io/programs/calls_elsewhere.h"
#include "problems/io/programs/program_flow.h"

namespace sagitta {
namespace {

class FanucReader {
 public:
  FanucReader(int joints, RobotProgram* program)
      : joints_(joints),
        program_(*program),
        source_(ProgramCode(*program, "//", '"').InCapitals()),
        code_(source_.text()) {}

  void Read();

 private:
  void ReadPosition(const std::string& name, size_t open, size_t end);
  // The number after "X =" in [begin, end). False: there is none, or it is "********".
  bool NumberOf(const std::string& name, size_t begin, size_t end, TextNumber* number) const;
  std::string FrameNumber(const std::string& name, const char* zero, size_t begin, size_t end) const;
  void ReadConfiguration(size_t begin, size_t end, ProgramPoint* point) const;
  void ReadExternalAxes(size_t begin, size_t end, ProgramPoint* point) const;
  void ReadMotions(size_t end);
  void ReadCommands(size_t end);
  void LeaveChanged(size_t end);
  void LeaveChanged(const std::string& kind, const std::string& number);
  bool IsRemark(size_t at) const;
  int PointOf(const std::string& name, TextRange place);

  const int joints_;
  RobotProgram& program_;
  const ProgramCode source_;
  const std::string& code_;
  std::map<std::string, size_t> named_;
};

bool FanucReader::NumberOf(const std::string& name, size_t begin, size_t end, TextNumber* number) const {
  const std::string_view code = std::string_view(code_).substr(0, end);
  for (size_t at = code.find(name, begin); at != std::string_view::npos; at = code.find(name, at + 1)) {
    size_t sign = at + name.size();
    if (at > begin && std::string_view(" \n,:").find(code[at - 1]) == std::string_view::npos) continue;
    while (sign < end && std::isspace(static_cast<unsigned char>(code[sign])) != 0) ++sign;
    if (sign >= end || code[sign] != '=') continue;
    const size_t from = code.find_first_not_of(" \n", sign + 1);
    const size_t to = std::min(code.find_first_not_of("-+0123456789.E", from), end);
    const size_t unit = code.find_first_not_of(" \n", to);
    if (from >= to || unit >= end || (code.compare(unit, 2, "MM") != 0 && code.compare(unit, 3, "DEG") != 0)) continue;
    return NumberAt(code, {from, to}, number);
  }
  return false;
}

std::string FanucReader::FrameNumber(const std::string& name, const char* zero, size_t begin, size_t end) const {
  const std::regex field = MakeCodePattern("\\b" + name + "\\s*:\\s*(\\d+)");
  std::smatch match;
  const std::string text = code_.substr(begin, end - begin);
  if (!SearchPattern(text, &match, field)) return "";
  return match[1] == "0" ? zero : name + match[1].str();
}

// F or N: wrist flipped (joint 5 above 0) or not; U or D: elbow up, as at the zero pose, or down; T or B: wrist in
// front of joint 1 or behind it; turns of joints.
void FanucReader::ReadConfiguration(size_t begin, size_t end, ProgramPoint* point) const {
  static const std::regex field = MakeCodePattern(
      "CONFIG\\s*:\\s*'\\s*([NF])?\\s*,?\\s*(?:[LR]\\s*,?\\s*)?([UD])?\\s*,?\\s*([TB])?\\s*,\\s*(-?\\d+)\\s*,\\s*(-?"
      "\\d+)\\s*,\\s*(-?\\d+)\\s*'");
  const std::string text = code_.substr(begin, end - begin);
  std::smatch match;
  if (!SearchPattern(text, &match, field)) {
    if (point->untouched.empty()) point->untouched = "its CONFIG is missing or not understood";
    return;
  }
  if (match[1].matched) point->branch.wrist_negative = match[1] == "N";
  if (match[2].matched) point->branch.elbow_of_zero = match[2] == "U";
  if (match[3].matched) point->branch.wrist_behind = match[3] == "B";
  // Which joints these count differs between arms; the controller's variable $SCR_GRP[1].$TURN_AXIS has it, no program.
  for (int i = 4; i <= 6; ++i) point->branch.turns.push_back(std::stoi(match[i].str().substr(0, 4)));
  const bool any = std::any_of(point->branch.turns.begin(), point->branch.turns.end(), [](int t) { return t != 0; });
  if (any) return;
  point->branch.turns.clear();
  for (int j = 0; j < joints_; ++j) point->branch.ranges.push_back({j, {-kPi, kPi}});
}

// E1 = 100.000 mm
void FanucReader::ReadExternalAxes(size_t begin, size_t end, ProgramPoint* point) const {
  for (int e = 1; e <= 3 && point->untouched.empty(); ++e) {
    const std::string axis = "E" + std::to_string(e);
    TextNumber number;
    if (!NumberOf(axis, begin, end, &number) || number.value == 0.0) continue;
    point->untouched = ExternalAxisInWords(axis, code_, number);
  }
  if (joints_ > 6 && point->untouched.empty()) point->untouched = kMoreThanSixJoints;
}

// Labels, IF in every form, FOR. The ELSE of a SELECT, "ELSE,JMP LBL[1]", is none.
ProgramFlow FlowOfFanuc(const std::string& code) {
  static const std::regex words =
      MakeCodePattern("\\b(LBL(?=\\[[^\\]]{1,40}\\] ?[;\\n])|IF|ELSE(?! ?,)|ENDIF|FOR|ENDFOR)\\b()");
  static const std::map<std::string, FlowKind> kinds = {{"LBL", FlowKind::kJoin},  {"IF", FlowKind::kBranch},
                                                        {"ELSE", FlowKind::kElse}, {"ENDIF", FlowKind::kBranchEnd},
                                                        {"FOR", FlowKind::kLoop},  {"ENDFOR", FlowKind::kLoopEnd}};
  return ProgramFlow(code, WithEndsOfShortBranches(code, FlowEventsOf(code, words, kinds)),
                     {{MakeCodePattern("\\bPAYLOAD\\s*\\["), false}});
}

// "PAYLOAD[2]", "PAYLOAD[R[3]]", "P[4]", "P[GP1:4]", "PR[5]", with what a comment adds
const char kPlace[] = "\\s*\\[\\s*(?:GP1\\s*:\\s*)?(\\d+|[A-Z]+\\s*\\[[^\\]]{0,99}\\])";

// "3:  !PAYLOAD[7]"
bool FanucReader::IsRemark(size_t at) const {
  const size_t line = code_.rfind('\n', at) + 1;
  const size_t begin = code_.find_first_not_of(" \t0123456789:", line);
  return begin < at && code_[begin] == '!';
}

// UFRAME[1]=PR[2], UTOOL[R[1]]=..., $MNUFRAME[1,3]=..., P[2]=LPOS: the points of the frame or tool then stand
// elsewhere.
void FanucReader::LeaveChanged(size_t end) {
  static const std::regex changed = MakeCodePattern("(?:(?:\\$MN|\\b)U(FRAME|TOOL)|\\bP) ?(\\[)");
  static const std::regex number = MakeCodePattern("^ ?(?:GP1 ?: ?|1 ?, ?)?(\\d+) ?(?:$|:)");
  const auto stop = code_.begin() + static_cast<std::ptrdiff_t>(end);
  for (const std::smatch& match : AllMatches(code_.begin(), stop, changed)) {
    const size_t open = static_cast<size_t>(match.position(2)), close = EndOfBracket(code_, open);
    if (close == std::string::npos || IsRemark(open)) continue;
    const size_t next = code_.find_first_not_of(' ', close);
    if (next == std::string::npos || code_[next] != '=') continue;
    const std::string index = code_.substr(open + 1, close - open - 2);
    std::smatch found;
    LeaveChanged(match[1], SearchPattern(index, &found, number) ? found[1].str() : "");
  }
}

// kind: FRAME, TOOL, or "" of the points themselves; number: "" is any.
void FanucReader::LeaveChanged(const std::string& kind, const std::string& number) {
  const std::string stem = kind.empty() ? "P[" : kind == "FRAME" ? "UF" : "UT";
  for (ProgramPoint& point : program_.points) {
    const std::string& name = kind.empty() ? point.name : kind == "FRAME" ? point.frame : point.tool;
    const std::string changed = stem + number + (kind.empty() ? "]" : "");
    const bool is_meant = name.empty() || (number.empty() ? name.compare(0, 2, stem) == 0 : name == changed);
    if ((point.is_joints && !kind.empty()) || !is_meant || !point.untouched.empty()) continue;
    point.untouched = "the program changes " + (name.empty() ? "a frame or tool" : name) + " as it runs";
  }
}

// The first motion to each point, and what hangs on the flange then.
void FanucReader::ReadMotions(size_t end) {
  static const std::regex step = MakeCodePattern(std::string("\\b(PAYLOAD|P)") + kPlace);
  const auto stop = code_.begin() + static_cast<std::ptrdiff_t>(end);
  ProgramFlow flow = FlowOfFanuc(code_.substr(0, end));
  std::set<size_t> used;
  for (const std::smatch& match : AllMatches(code_.begin(), stop, step)) {
    const size_t at = static_cast<size_t>(match.position(0));
    flow.MoveTo(at);
    if (IsRemark(at)) continue;
    if (match[1] == "PAYLOAD") {
      flow.Set(0, "PAYLOAD[" + match[2].str() + "]");
      continue;
    }
    const auto found = named_.find("P[" + match[2].str() + "]");
    if (found == named_.end()) continue;
    ProgramPoint& point = program_.points[found->second];
    const bool is_first = used.insert(found->second).second;
    if (is_first) point.used_at = at;
    UseLoads(flow.Of(0), is_first, &point);
  }
}

// "P[2]", "PR[3]", "P[R[1]]"
int FanucReader::PointOf(const std::string& name, TextRange place) {
  if (const auto found = named_.find(name); found != named_.end()) return static_cast<int>(found->second);
  const int line = source_.LineAt(place.first);
  const int index = AddPointElsewhere(name, line, place.first, &program_);
  ProgramPoint& point = program_.points.back();
  if (name.compare(0, 2, "PR") == 0) point.untouched = "its numbers are in the controller";
  if (name.find('[') != name.rfind('[')) point.untouched = "which point it is, is chosen as the program runs";
  named_[name] = static_cast<size_t>(index);
  return index;
}

// "3:L P[2] 100mm/sec FINE ;", "4:C P[3] : P[4] 100mm/sec FINE ;": J, L, A and S go to one point, C to two. INC says
// that the numbers of the point are an increment.
void FanucReader::ReadCommands(size_t end) {
  static const std::regex command =
      MakeCodePattern("(?:^|\\n)[ \\t]*\\d*[ \\t]*:[ \\t]*([JLCAS])[ \\t]+(?=PR?[ \\t]*\\[)");
  static const std::regex target = MakeCodePattern(std::string("\\b(PR?)") + kPlace + "[^\\]]{0,99}\\]");
  static const std::regex incremental = MakeCodePattern("\\bINC\\b");
  static const std::regex remote = MakeCodePattern("\\bRTCP\\b");
  static const std::regex displaced =
      MakeCodePattern("\\b(?:TOOL_OFFSET|OFFSET|VOFFSET|COORD)\\b|\\bOFFSET\\s*,|\\bVR\\s*\\[");
  const auto stop = code_.begin() + static_cast<std::ptrdiff_t>(end);
  for (const std::smatch& match : AllMatches(code_.begin(), stop, command)) {
    const size_t begin = static_cast<size_t>(match.position(0) + match.length(0));
    const size_t until = std::min(code_.find(';', begin), end);
    const std::string body = code_.substr(begin, until - begin);
    const auto targets = AllMatches(body.begin(), body.end(), target);
    std::smatch found;
    const bool is_increment = SearchPattern(body, &found, incremental);
    const bool is_displaced = SearchPattern(body, displaced);
    for (size_t i = 0; i < targets.size() && i < (match[1] == "C" ? 2U : 1U); ++i) {
      const size_t at = begin + static_cast<size_t>(targets[i].position(0));
      const TextRange place = {at, at + static_cast<size_t>(targets[i].length(0))};
      ProgramMotion motion = MotionTo(match[1], source_, place);
      motion.point = PointOf(targets[i][1].str() + "[" + targets[i][2].str() + "]", place);
      program_.motions.push_back(motion);
      ProgramPoint& point = program_.points[static_cast<size_t>(motion.point)];
      if (is_increment && point.untouched.empty())
        point.untouched = "an incremental motion goes on from where the arm is";
      if (SearchPattern(body, remote) && point.untouched.empty())
        point.untouched = "its tool stands in the room and the robot holds the workpiece";
      if (is_displaced && point.untouched.empty())
        point.untouched = "a motion to it is displaced (Offset, Tool_Offset, VOFFSET, COORD)";
    }
  }
}

void FanucReader::ReadPosition(const std::string& name, size_t open, size_t end) {
  ProgramPoint point;
  point.name = name;
  point.line = source_.LineAt(open);
  point.used_at = open;
  named_[name] = program_.points.size();
  const std::string_view position = std::string_view(code_).substr(0, end);
  const size_t group = position.find("GP1", open);
  if (group >= end) {
    point.untouched = "it has no motion group 1";
    program_.points.push_back(point);
    return;
  }
  const size_t next = std::min(position.find("GP2", group), end);
  TextNumber number;
  point.is_joints = NumberOf("J1", group, next, &number);
  const std::vector<std::string> pose = {"X", "Y", "Z", "W", "P", "R"};
  for (int i = 0; i < (point.is_joints ? joints_ : 6); ++i) {
    if (!NumberOf(point.is_joints ? "J" + std::to_string(i + 1) : pose[static_cast<size_t>(i)], group, next, &number)) {
      point.untouched = "it is not taught: a value is missing";
      break;
    }
    point.numbers.push_back(number);
  }
  if (!point.is_joints) {
    ReadExternalAxes(group, next, &point);
    point.frame = FrameNumber("UF", kWorldName, group, next);
    point.tool = FrameNumber("UT", kFlangeName, group, next);
    ReadConfiguration(group, next, &point);
  }
  program_.points.push_back(point);
}

void FanucReader::Read() {
  static const std::regex positions = MakeCodePattern("(?:^|\\n)[ \\t]*(/POS)\\b");  // not one in a remark
  std::smatch section_match;
  if (!SearchPattern(code_, &section_match, positions)) return;
  const size_t section = static_cast<size_t>(section_match.position(1));
  static const std::regex head = MakeCodePattern("\\bP\\s*\\[\\s*(\\d+)[^\\]]{0,99}\\]\\s*(\\{)");
  for (const std::smatch& match : AllMatches(code_.begin() + static_cast<std::ptrdiff_t>(section), code_.end(), head)) {
    const size_t open = section + static_cast<size_t>(match.position(2));
    const size_t end = code_.find('}', open);
    if (end == std::string::npos) {
      throw InputError({program_.path, source_.LineAt(open), "P[" + match[1].str() + "]"}, "the brace is not closed");
    }
    ReadPosition("P[" + match[1].str() + "]", open, end);
  }
  ReadMotions(section);
  ReadCommands(section);
  LeaveChanged(section);
  FindCallsElsewhere(source_, &program_);
  source_.PlaceInFile(&program_);
}

}  // namespace

void ReadFanuc(int joints, RobotProgram* program) { FanucReader(joints, program).Read(); }

}  // namespace sagitta

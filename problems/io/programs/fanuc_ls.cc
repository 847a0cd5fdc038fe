// FANUC LS: section /POS, P[1]{ GP1: UF : 0, UT : 1, CONFIG : 'N U T, 0, 0, 0', X = 600.0 mm, ... W = 180.0 deg, ... };
// or J1 = 0.0 deg, ....
#include <limits>
#include <regex>

#include "models/constants.h"
#include "problems/input_error.h"
#include "problems/io/programs/program_text.h"

namespace sagitta {
namespace {

class FanucReader {
 public:
  FanucReader(int joints, RobotProgram* program)
      : joints_(joints), program_(*program), code_(UpperCase(WithoutComments(program->text, "//", '"'))) {}

  void Read();

 private:
  void ReadPosition(const std::string& name, size_t open, size_t end);
  // The number after "X =" in [begin, end). False: there is none, or it is "********".
  bool NumberOf(const std::string& name, size_t begin, size_t end, TextNumber* number) const;
  std::string FrameNumber(const std::string& name, const char* zero, size_t begin, size_t end) const;
  void ReadConfiguration(size_t begin, size_t end, ProgramPoint* point) const;

  const int joints_;
  RobotProgram& program_;
  const std::string code_;
};

bool FanucReader::NumberOf(const std::string& name, size_t begin, size_t end, TextNumber* number) const {
  const std::regex field("(?:^|[\\s,:])" + name + "\\s*=\\s*([-+0-9.eE]+)\\s*(MM|DEG)");
  std::smatch match;
  const auto from = code_.begin() + static_cast<std::ptrdiff_t>(begin),
             to = code_.begin() + static_cast<std::ptrdiff_t>(end);
  if (!std::regex_search(from, to, match, field)) return false;
  const size_t at = begin + static_cast<size_t>(match.position(1));
  return NumberAt(code_, {at, at + static_cast<size_t>(match.length(1))}, number);
}

std::string FanucReader::FrameNumber(const std::string& name, const char* zero, size_t begin, size_t end) const {
  const std::regex field("\\b" + name + "\\s*:\\s*(\\d+)");
  std::smatch match;
  const std::string text = code_.substr(begin, end - begin);
  if (!std::regex_search(text, match, field)) return "";
  return match[1] == "0" ? zero : name + match[1].str();
}

// F or N: wrist flipped (joint 5 above 0) or not; U or D: elbow up, as at the zero pose, or down; T or B: wrist in
// front of joint 1 or behind it; turns of joints.
void FanucReader::ReadConfiguration(size_t begin, size_t end, ProgramPoint* point) const {
  static const std::regex field(
      "CONFIG\\s*:\\s*'\\s*([NF])?\\s*,?\\s*(?:[LR]\\s*,?\\s*)?([UD])?\\s*,?\\s*([TB])?\\s*,\\s*(-?\\d+)\\s*,\\s*(-?"
      "\\d+)\\s*,\\s*(-?\\d+)\\s*'");
  const std::string text = code_.substr(begin, end - begin);
  std::smatch match;
  if (!std::regex_search(text, match, field)) {
    point->branch.from_before = true;
    return;
  }
  if (match[1].matched) point->branch.wrist_negative = match[1] == "N";
  if (match[2].matched) point->branch.elbow_of_zero = match[2] == "U";
  if (match[3].matched) point->branch.wrist_behind = match[3] == "B";
  for (int i = 4; i <= 6; ++i) {
    // The manuals count joints whose range is more than a turn; which of J1, J4, J5, J6 that are differs between arms,
    // and public sources contradict each other. A wrong joint would be a wrong correction.
    if (match[i] != "0")
      point->untouched = "a joint of its configuration has made a whole turn, and which one the number does not say";
  }
  for (int j = 0; j < joints_; ++j) point->branch.ranges.push_back({j, {-kPi, kPi}});
}

void FanucReader::ReadPosition(const std::string& name, size_t open, size_t end) {
  ProgramPoint point;
  point.name = name;
  point.line = LineAt(code_, open);
  const size_t group = code_.find("GP1", open);
  if (group >= end) {
    point.untouched = "it has no motion group 1";
    program_.points.push_back(point);
    return;
  }
  const size_t next = std::min(code_.find("GP2", group), end);
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
    point.frame = FrameNumber("UF", kWorld, group, next);
    point.tool = FrameNumber("UT", kFlange, group, next);
    ReadConfiguration(group, next, &point);
  }
  program_.points.push_back(point);
}

void FanucReader::Read() {
  program_.notation = PoseNotation::kWprDegrees;
  const size_t section = code_.find("/POS");
  if (section == std::string::npos) return;
  static const std::regex head("\\bP\\s*\\[\\s*(\\d+)[^\\]]*\\]\\s*(\\{)");
  for (auto match = std::sregex_iterator(code_.begin() + static_cast<std::ptrdiff_t>(section), code_.end(), head);
       match != std::sregex_iterator(); ++match) {
    const size_t open = section + static_cast<size_t>(match->position(2));
    const size_t end = code_.find('}', open);
    if (end == std::string::npos) {
      throw InputError({program_.path, LineAt(code_, open), "P[" + (*match)[1].str() + "]"}, "the brace is not closed");
    }
    ReadPosition("P[" + (*match)[1].str() + "]", open, end);
  }
}

}  // namespace

void ReadFanuc(int joints, RobotProgram* program) { FanucReader(joints, program).Read(); }

}  // namespace sagitta

#include "problems/io/import/elementary_transforms.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "problems/input_error.h"
#include "problems/io/import/expressions.h"
#include "problems/io/import/header_words.h"
#include "problems/io/import/text_table.h"
#include "problems/io/pattern.h"
#include "problems/io/robot_units.h"
#include "problems/io/trimmed.h"
#include "problems/text.h"

namespace sagitta {
namespace {

const std::regex& TransformPattern() {
  static const std::regex kTransform = MakePattern(R"(([TR])([xyz])\s*\(\s*([^()]*)\s*\))", true);
  return kTransform;
}

// Blanked out, so that places and lines stay.
std::string WithBlankComments(std::string text) {
  bool is_comment = false;
  for (char& c : text) {
    is_comment = c != '\n' && (is_comment || c == '%' || c == '#');
    if (is_comment) c = ' ';
  }
  return text;
}

// Without blanks and the signs of a product at both ends.
std::string Bare(std::string text) {
  for (const char* sign : {"×", "·"}) {
    for (size_t at = 0; (at = text.find(sign)) != std::string::npos;) text.replace(at, 2, " ");
  }
  const char* separators = " \t\r\v*.,";
  const size_t first = text.find_first_not_of(separators), last = text.find_last_not_of(separators);
  return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

class TransformReader {
 public:
  TransformReader(const std::string& text, const std::string& path) : text_(WithBlankComments(text)), path_(path) {}

  RobotReading Read() {
    matches_ = AllMatches(text_.begin(), text_.end(), TransformPattern());
    CheckWhatIsBetween();
    FindUnit();
    for (const std::smatch& match : matches_) Append(match);
    reading_.format = "elementary transforms, lengths in m";
    reading_.robot.chain = chain_;
    const std::string defect = chain_.Defect();
    if (!defect.empty()) throw InputError({path_, 0, ""}, defect);
    if (chain_.joints.empty())
      throw InputError({path_, 0, ""}, "none of the transforms has a joint variable", "Rz(q1), Tz(q2) …");
    return std::move(reading_);
  }

 private:
  [[noreturn]] void Fail(size_t place, const std::string& what, const std::string& hint) const {
    const int line = 1 + static_cast<int>(std::count(text_.begin(), text_.begin() + static_cast<long>(place), '\n'));
    throw InputError({path_, line, ""}, what, hint);
  }

  static std::string NameOf(const std::smatch& match) { return match.str(1) + match.str(2) + "(" + match.str(3) + ")"; }
  static bool Turns(const std::smatch& match) { return LowerCaseOf(match.str(1)) == "r"; }

  void CheckWhatIsBetween() {
    size_t from = 0;
    for (const std::smatch& match : matches_) {
      const size_t to = static_cast<size_t>(match.position(0));
      CheckPieces(from, to, true);
      from = to + static_cast<size_t>(match.length(0));
    }
    CheckPieces(from, text_.size(), false);
  }

  // Statements end at a semicolon or a line's end; the last piece stands right before a transform.
  void CheckPieces(size_t from, size_t to, bool a_transform_follows) {
    while (from <= to) {
      const size_t end = std::min(text_.find_first_of(";\n", from), to);
      CheckPiece(text_.substr(from, end - from), from, a_transform_follows && end == to);
      from = end + 1;
    }
  }

  void CheckPiece(const std::string& piece, size_t place, bool a_transform_follows) {
    static const std::regex kOfNoRobot = MakePattern(
        R"((clear|clc|close|syms|format|startup_rvc|import|from)\b.*|[A-Za-z]\w*\s*=\s*DHFactor\s*\(\s*[A-Za-z]\w*\s*\))");
    static const std::regex kLeftSide = MakePattern(
        R"(\s*([A-Za-z]\w*)\s*(\*?)(?::=|=|:)\s*(?:([A-Za-z]\w*)\s*\*)?\s*(DHFactor\s*\(\s*)?(['"]?)\s*(?:ETS?[23]?\s*\.)?\s*)");
    static const std::regex kClass = MakePattern("ETS?[23]?");
    std::smatch match;
    if (a_transform_follows && MatchPattern(piece, &match, kLeftSide)) return BeginSequence(match, place);
    std::string rest = Bare(piece);
    if (!closing_.empty() && rest.compare(0, closing_.size(), closing_) == 0) {
      rest = Bare(rest.substr(closing_.size()));
      closing_.clear();
    }
    if (rest.empty() || MatchPattern(rest, a_transform_follows ? kClass : kOfNoRobot)) return;
    Fail(FirstLetter(place), "'" + rest + "' is not understood",
         "transforms along and about one axis, Tx(0.4) Rz(q1) …, with blanks or * between them; comments behind %");
  }

  size_t FirstLetter(size_t place) const { return std::min(text_.find_first_not_of(" \t\r\n", place), text_.size()); }

  // "E = ", "E = E * ", "E *= ", "s = '", "dh = DHFactor('".
  void BeginSequence(const std::smatch& left, size_t place) {
    const std::string name = left.str(1), continued = left.str(3);
    const bool goes_on = left.length(2) > 0 || continued == name;
    const bool is_first = sequence_.empty();
    if (is_first ? goes_on || !continued.empty() : !goes_on || sequence_ != name) {
      Fail(FirstLetter(place), "'" + name + " = …' is a second sequence of transforms, or a part of one",
           "one sequence in a file: the robot's, from the base to the flange");
    }
    sequence_ = name;
    closing_ = left.str(5) + (left.length(4) > 0 ? ")" : "");
  }

  void FindUnit() {
    for (const std::smatch& match : matches_) {
      if (!Turns(match)) continue;
      const auto joint = ParseJointExpression(match.str(3));
      if (const auto number = ParseTypedNumber(match.str(3))) angles_.Add(*number);
      if (joint) angles_.Add(joint->offset);
    }
    if (angles_.unit() == AnglesWithoutUnit::Unit::kEach)
      reading_.notes.push_back("angles with pi are in rad, the others in deg");
    if (!angles_.is_guess()) return;
    const bool degrees = angles_.unit() == AnglesWithoutUnit::Unit::kDeg;
    reading_.guesses.push_back(std::string("angles are in ") + (degrees ? "deg" : "rad") +
                               ": the text does not say, the largest is " + FormatNumber(angles_.largest()));
  }

  double ValueOf(const TypedNumber& number, const std::smatch& match) const {
    const size_t place = static_cast<size_t>(match.position(0));
    const std::string name = "'" + NameOf(match) + "'";
    if (!Turns(match)) {
      if (number.is_degrees || number.uses_pi) Fail(place, name + " is a length", "lengths in m are expected");
      if (std::abs(number.value) > kLongestLink)
        Fail(place, name + " is longer than 10 m", "lengths in m are expected");
      return number.value;
    }
    if (angles_.IsUndecided(number))
      Fail(place, name + " may be in deg or in rad, and other angles are in either",
           "one unit for all angles, or a degree sign");
    return angles_.ToRad(number);
  }

  void Append(const std::smatch& match) {
    const std::string axis = LowerCaseOf(match.str(2));
    ElementaryTransform transform;
    transform.motion = Turns(match) ? Motion::kRotation : Motion::kTranslation;
    transform.axis = static_cast<Axis>(axis[0] - 'x');
    if (const auto number = ParseTypedNumber(match.str(3))) {
      transform.nominal = ValueOf(*number, match);
    } else if (const auto joint = ParseJointExpression(match.str(3))) {
      transform.joint = chain_.num_joints();
      transform.sign = joint->sign;
      transform.nominal = ValueOf(joint->offset, match);
      AppendJoint(joint->index, match);
    } else {
      Fail(static_cast<size_t>(match.position(0)), "'" + NameOf(match) + "' has no value",
           "put numbers in place of symbols");
    }
    // A name for every error: the default free set chooses among them.
    transform.error = (Turns(match) ? "phi_" : "p_") + axis + std::to_string(chain_.num_transforms() + 1);
    chain_.transforms.push_back(transform);
  }

  void AppendJoint(int index, const std::smatch& match) {
    const auto [other, is_new] = joints_.emplace(index, NameOf(match));
    if (!is_new) {
      Fail(static_cast<size_t>(match.position(0)),
           "joint " + std::to_string(index) + " moves two transforms, '" + other->second + "' and '" + NameOf(match) +
               "'",
           "a joint stands in one transform; put numbers in place of symbols that are constants");
    }
    chain_.joints.push_back(
        {"q" + std::to_string(index), Turns(match) ? JointType::kRevolute : JointType::kPrismatic, {}, {}});
  }

  std::string text_, path_;
  std::vector<std::smatch> matches_;  // point into text_
  std::string sequence_, closing_;    // the name it is assigned to, the quotation mark that is open
  AnglesWithoutUnit angles_;
  std::map<int, std::string> joints_;
  Chain chain_;
  RobotReading reading_;
};

// Whether rows of numbers stand below what looks like transforms: those are headers then, as of Rx (tool), Ry (tool).
bool HoldsTable(const std::string& text) {
  try {
    return ParseTextTable(text, "").rows.size() > 1;
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace

bool HoldsElementaryTransforms(const std::string& text) {
  const std::string plain = WithBlankComments(text);
  // A header's Rx (deg), Ry (deg): a unit is no argument.
  const auto names_unit = [](const std::smatch& match) { return IsUnit(std::string(Trimmed(match.str(3)))); };
  const std::vector<std::smatch> matches = AllMatches(plain.begin(), plain.end(), TransformPattern());
  const auto units = std::count_if(matches.begin(), matches.end(), names_unit);
  return matches.size() > 1 + static_cast<size_t>(units) && !HoldsTable(text);
}

RobotReading ReadElementaryTransforms(const std::string& text, const std::string& path) {
  return TransformReader(text, path).Read();
}

}  // namespace sagitta

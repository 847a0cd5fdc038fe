// Robots as MATLAB people keep them, as text:
//
//   SerialLink([theta d a alpha sigma offset; …])   Robotics Toolbox (DHFactor prints it); standard, "modified" where
//   Link([theta d a alpha sigma offset])            the text says so; theta is the variable
//   dhparams = [a alpha d theta; …]                 Robotics System Toolbox, with 'dh' or 'mdh' in setFixedTransform
//   Tz(0.4) Rz(q1) Rx(-90) …                        elementary_transforms.h
//
// What changes the robot behind the table, offset, base, tool …, is read where it is simple, or refused.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <sstream>

#include "problems/input_error.h"
#include "problems/io/import/elementary_transforms.h"
#include "problems/io/import/expressions.h"
#include "problems/io/import/robot_reading.h"
#include "problems/io/pattern.h"
#include "problems/io/robot_units.h"
#include "problems/io/trimmed.h"

namespace sagitta {
namespace {

const std::regex kMatrix = MakePattern(R"((dhparams\s*=|SerialLink\s*\(|Link\s*\()\s*\[([^\]]*)\])");

// A line that goes on has a '\v' in place of its end, so that lines can be counted.
std::string WithoutMatlabComments(const std::string& text) {
  std::istringstream lines(text);
  std::string kept;
  for (std::string line; std::getline(lines, line);) kept += line.substr(0, line.find('%')) + "\n";
  return ReplacePattern(kept, MakePattern(R"(\.\.\.\s*\n)"), "\v");
}

// Rows at ';' and line ends, cells at commas and blanks.
std::vector<std::vector<std::string>> MatrixRows(const std::string& body) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(ReplacePattern(body, MakePattern(";"), "\n"));
  for (std::string line; std::getline(lines, line);) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream words(line);
    std::vector<std::string> cells;
    for (std::string word; words >> word;) cells.push_back(word);
    if (!cells.empty()) rows.push_back(cells);
  }
  return rows;
}

// What is assigned to a robot or to one of its links.
enum class Property { kOffset, kPlace, kLimits, kOfTheRow };

std::optional<Property> PropertyNamed(const std::string& name) {
  static const std::map<std::string, Property> kNames = {{"offset", Property::kOffset},
                                                         {"base", Property::kPlace},
                                                         {"tool", Property::kPlace},
                                                         {"qlim", Property::kLimits},
                                                         {"PositionLimits", Property::kLimits},
                                                         {"a", Property::kOfTheRow},
                                                         {"d", Property::kOfTheRow},
                                                         {"alpha", Property::kOfTheRow},
                                                         {"theta", Property::kOfTheRow},
                                                         {"sigma", Property::kOfTheRow},
                                                         {"mdh", Property::kOfTheRow},
                                                         {"flip", Property::kOfTheRow},
                                                         {"jointtype", Property::kOfTheRow},
                                                         {"convention", Property::kOfTheRow},
                                                         {"JointAxis", Property::kOfTheRow}};
  const auto found = kNames.find(name);
  return found == kNames.end() ? std::nullopt : std::optional<Property>(found->second);
}

// Base or tool that change nothing.
bool IsIdentity(const std::string& value) {
  static const std::regex kIdentity = MakePattern(
      R"(\s*(eye\s*\(\s*4\s*\)|SE3\s*(\(\s*\))?|\[\s*\]|(transl|SE3)\s*\(\s*\[?\s*0+(\.0*)?([\s,]+0+(\.0*)?){2}\s*\]?\s*\))\s*)");
  return MatchPattern(value, kIdentity);
}

// Where a row is: L(2), or L2.
struct RowLabel {
  std::string name;
  int index = 0;  // 0: none
};

class MatlabReader {
 public:
  MatlabReader(const std::string& text, std::string path, const RobotReadOptions& options)
      : text_(WithoutMatlabComments(text)), path_(std::move(path)), options_(options) {}

  // Lengths in m, angles in rad, as both toolboxes have them.
  RobotReading Read() {
    const std::vector<std::smatch> tables = AllMatches(text_.begin(), text_.end(), kMatrix);
    is_system_toolbox_ = tables.front().str(1).rfind("dhparams", 0) == 0;
    for (const std::smatch& table : tables) AddTable(table);
    if (table_.links.empty()) Fail(0, "the table has no rows", "");
    CheckWhatIsNotRead();
    if (is_system_toolbox_) ReadKindsOfJoints();
    ReadProperties();
    for (size_t r = 0; r < table_.links.size(); ++r) CheckRowUnits(table_.links[r], {path_, lines_[r], ""});
    SetConvention();
    SayWhatTheToolboxIgnores();
    reading_.robot = RobotOfTable(joints_, {}, table_);
    CheckReach(reading_.robot.chain, {path_, lines_.front(), ""});
    reading_.format = is_system_toolbox_ ? "MATLAB dhparams [a alpha d theta], m and rad"
                                         : "MATLAB links [theta d a alpha sigma offset], m and rad";
    return std::move(reading_);
  }

 private:
  int LineAt(size_t place) const {
    const auto ends = [](char c) { return c == '\n' || c == '\v'; };
    return 1 + static_cast<int>(std::count_if(text_.begin(), text_.begin() + static_cast<long>(place), ends));
  }

  [[noreturn]] void Fail(size_t place, const std::string& what, const std::string& hint) const {
    throw InputError({path_, LineAt(place), ""}, what, hint);
  }

  TypedNumber NumberOf(const std::string& cell, size_t place) const {
    if (const auto number = ParseTypedNumber(cell)) return *number;
    if (const auto joint = ParseJointExpression(cell)) return joint->offset;
    Fail(place, "'" + cell + "' has no value", "put numbers in place of symbols");
  }

  void AddTable(const std::smatch& match) {
    const size_t place = static_cast<size_t>(match.position(0)), end = place + static_cast<size_t>(match.length(0));
    const bool is_link = match.str(1).rfind("Link", 0) == 0;
    if (!table_.links.empty() && (!is_link || !of_links_)) Fail(place, "this is a second table", "one robot in a file");
    const size_t next = text_.find_first_not_of(" \t", end);
    if (next != std::string::npos && std::string(",);]\r\n\v").find(text_[next]) == std::string::npos)
      Fail(place,
           "what stands behind the table, '" + text_.substr(next, text_.find('\n', next) - next) + "', is not read",
           "put the numbers that come of it into the table, m and rad");
    of_links_ = is_link;
    const RowLabel label = LabelBefore(place);
    if (is_link) CheckOrder(label, place);
    for (const std::vector<std::string>& row : MatrixRows(match.str(2))) AddRow(row, label, place);
  }

  // The left side of the assignment.
  RowLabel LabelBefore(size_t place) const {
    static const std::regex kLeftSide = MakePattern(R"(([A-Za-z]\w*)\s*(?:[({]\s*([0-9]{1,6})\s*[)}])?\s*=\s*$)");
    const size_t line = place == 0 ? std::string::npos : text_.find_last_of("\n;", place - 1);
    const size_t first = line == std::string::npos ? 0 : line + 1;
    const std::string before = text_.substr(first, place - first);
    std::smatch match;
    if (!SearchPattern(before, &match, kLeftSide)) return {};
    return {match.str(1), match.length(2) > 0 ? std::stoi(match.str(2)) : 0};
  }

  // L(1), L(2) … or L1, L2 …, one after the other.
  void CheckOrder(const RowLabel& label, size_t place) const {
    static const std::regex kCounted = MakePattern(R"([A-Za-z_]+([0-9]{1,6}))");
    std::smatch match;
    int index = label.index;
    if (index == 0 && MatchPattern(label.name, &match, kCounted)) index = std::stoi(match.str(1));
    const int expected = static_cast<int>(table_.links.size()) + 1;
    if (index == 0 || index == expected) return;
    Fail(place, "link " + std::to_string(index) + " stands where link " + std::to_string(expected) + " is expected",
         "every link, from the base on");
  }

  void AddRow(const std::vector<std::string>& row, const RowLabel& label, size_t place) {
    if (row.size() < 4)
      Fail(place, "a row of the table has " + std::to_string(row.size()) + " numbers", "four are expected at least");
    std::vector<double> n;
    for (const std::string& cell : row) n.push_back(NumberOf(cell, place).value);
    DhLink link;
    link.joint = static_cast<int>(joints_.size());
    const bool slides = !is_system_toolbox_ && n.size() > 4 && n[4] != 0.0;
    if (is_system_toolbox_) {
      link.a = n[0], link.alpha = n[1], link.d = n[2], link.theta = n[3];
    } else {
      link.theta = n[0], link.d = n[1], link.a = n[2], link.alpha = n[3];
    }
    joints_.push_back(
        {"j" + std::to_string(joints_.size() + 1), slides ? JointType::kPrismatic : JointType::kRevolute, {}, {}});
    table_.links.push_back(link);
    typed_.push_back(slides ? link.d : link.theta);
    offsets_.push_back(0.0);
    labels_.push_back(label);
    lines_.push_back(LineAt(place));
    if (!is_system_toolbox_ && n.size() > 5) SetOffset(joints_.size() - 1, n[5]);
  }

  // A later one replaces it, as in the toolbox.
  void SetOffset(size_t row, double offset) {
    double& counted = joints_[row].type == JointType::kPrismatic ? table_.links[row].d : table_.links[row].theta;
    counted += offset - offsets_[row];
    offsets_[row] = offset;
  }

  // Parts of the robot that are stated otherwise than as a row of numbers.
  void CheckWhatIsNotRead() const {
    static const std::regex kByName =
        MakePattern(R"(\b(Link|Revolute|Prismatic|RevoluteMDH|PrismaticMDH)\s*\((?!\s*\[)[^\n]*)");
    static const std::regex kOption = MakePattern(R"(['"](base|tool|offset)['"]\s*,[^\n]*)");
    static const std::regex kChanged = MakePattern(R"(\bdhparams\s*(\([^()=\n]*\)\s*=(?!=)|=\s*(?!\s|\[))[^\n]*)");
    std::smatch match;
    if (is_system_toolbox_ && SearchPattern(text_, &match, kChanged))
      FailAt(match, "changes the table", "put the numbers that come of it into the table, m and rad");
    if (is_system_toolbox_) return;
    if (SearchPattern(text_, &match, kByName))
      FailAt(match, "is a link that is not read", "write it as Link([theta d a alpha sigma offset]), m and rad");
    if (SearchPattern(text_, &match, kOption))
      FailAt(match, "is not read", "offsets are the sixth number of a row; " + PlaceHint());
  }

  [[noreturn]] void FailAt(const std::smatch& match, const std::string& what, const std::string& hint) const {
    Fail(static_cast<size_t>(match.position(0)), "'" + std::string(Trimmed(match.str(0), " \t\r;")) + "' " + what,
         hint);
  }

  static std::string PlaceHint() {
    return "base and flange are those of the table: remove the line, and add the tool to d of the last row where it "
           "lies "
           "along the last axis";
  }

  // Of jnt3 = rigidBodyJoint('jnt3', 'prismatic'), with setFixedTransform(jnt3, dhparams(3, :), 'dh').
  void ReadKindsOfJoints() {
    static const std::regex kJoint = MakePattern(
        R"((?:([A-Za-z]\w*(?:\s*[({]\s*\w+\s*[)}])?)\s*=\s*)?\b(?:rigidBodyJoint|robotics\.Joint)\s*\(([^()\n]*(?:\([^()\n]*\)[^()\n]*)*)\))");
    static const std::regex kKind = MakePattern(R"(.*,\s*['"](revolute|prismatic|fixed)['"]\s*)");
    for (const std::smatch& joint : AllMatches(text_.begin(), text_.end(), kJoint)) {
      std::smatch kind;
      const std::string arguments = joint.str(2);
      if (!MatchPattern(arguments, &kind, kKind))
        FailAt(joint, "does not say whether the joint turns or slides", "'revolute' or 'prismatic' as second argument");
      if (kind[1] == "fixed")
        FailAt(joint, "does not move, and rows of the table are joints that do",
               "remove it and its row; what lies behind the last joint adds to d of the last row along its axis");
      if (kind[1] == "prismatic") SetPrismatic(RowOfJoint(joint));
    }
  }

  void SetPrismatic(size_t row) { joints_[row].type = JointType::kPrismatic; }

  // The one row that the joint is given by its number, between this assignment of its name and the next.
  size_t RowOfJoint(const std::smatch& joint) const {
    static const std::regex kRow = MakePattern(
        R"(setFixedTransform\s*\(\s*([A-Za-z]\w*(?:\s*[({]\s*\w+\s*[)}])?)\s*,\s*dhparams\s*\(\s*([0-9]{1,6})\s*,\s*:\s*\))");
    const auto plain = [](const std::string& text) { return ReplacePattern(text, MakePattern(R"(\s+)"), ""); };
    const std::string name = plain(joint.str(1));
    const size_t from = static_cast<size_t>(joint.position(0) + joint.length(0));
    std::vector<int> rows;
    for (const std::smatch& call : AllMatches(text_.begin(), text_.end(), kRow)) {
      const auto at = static_cast<size_t>(call.position(0));
      if (at < from || plain(call.str(1)) != name || IsAssigned(name, from, at)) continue;
      rows.push_back(std::stoi(call.str(2)));
    }
    if (rows.size() != 1 || rows[0] < 1 || rows[0] > static_cast<int>(joints_.size()))
      FailAt(joint, "slides, and which row of dhparams it has is not said by a number",
             "setFixedTransform(" + (name.empty() ? std::string("jnt3") : name) +
                 ", dhparams(3,:), 'dh') in the text says it");
    return static_cast<size_t>(rows[0]) - 1;
  }

  // Whether a name stands for another joint from here on: joint = rigidBodyJoint(…) again.
  bool IsAssigned(const std::string& name, size_t from, size_t to) const {
    const std::string between = ReplacePattern(text_.substr(from, to - from), MakePattern(R"([ \t]+)"), "");
    for (size_t at = between.find(name + "="); at != std::string::npos; at = between.find(name + "=", at + 1)) {
      const char before = at == 0 ? '\n' : between[at - 1];
      if (std::isalnum(static_cast<unsigned char>(before)) == 0 && before != '_') return true;
    }
    return false;
  }

  // setFixedTransform(…, 'dh') of a tree ignores theta of a joint that turns, and d of one that slides, and so does
  // Link, in whose place q stands (Corke, Robotics Toolbox, Link.A): here they are offsets of q, as in every other
  // table.
  void SayWhatTheToolboxIgnores() {
    const bool is_tree = is_system_toolbox_ && text_.find("setFixedTransform") != std::string::npos;
    if (is_system_toolbox_ && (!is_tree || table_.convention != DhConvention::kStandard)) return;
    for (size_t r = 0; r < joints_.size(); ++r) {
      if (typed_[r] == 0.0) continue;
      const bool slides = joints_[r].type == JointType::kPrismatic;
      reading_.guesses.push_back(
          std::string(slides ? "d" : "theta") + " of row " + std::to_string(r + 1) + " adds to its joint's value: " +
          (is_tree ? "setFixedTransform ignores it, so that joint values of a rigidBodyTree count without it"
                   : "the toolbox ignores it, so that joint values there count without it; what adds is the offset"));
    }
  }

  void ReadProperties() {
    static const std::regex kAssignment = MakePattern(
        R"(([A-Za-z]\w*)\s*(?:[({]\s*([0-9]{1,6}|:|end)\s*[)}])?\s*\.\s*([A-Za-z]\w*)([.({][^=\n;]*)?\s*=(?!=)\s*(\[[^\]]*\]|[^;\n]*))");
    for (const std::smatch& match : AllMatches(text_.begin(), text_.end(), kAssignment)) {
      const std::optional<Property> property = PropertyNamed(match.str(3));
      if (!property) continue;
      switch (*property) {
        case Property::kOffset:
          ReadOffset(match);
          break;
        case Property::kPlace:
          if (!is_system_toolbox_ && (match.length(4) > 0 || !IsIdentity(match.str(5))))
            FailAt(match, "is not read", PlaceHint());
          break;
        case Property::kLimits:
          reading_.notes.push_back("limits are not read: " + std::string(Trimmed(match.str(0), " \t\r")));
          break;
        case Property::kOfTheRow:
          FailAt(match, "changes the table", "put it into the row of numbers; --convention states which table it is");
      }
    }
  }

  // L(2).offset = -pi/2, R.offset = [0 -pi/2 0].
  void ReadOffset(const std::smatch& match) {
    const size_t place = static_cast<size_t>(match.position(0));
    const std::string value = match.str(5);
    const bool is_list = value[0] == '[';
    const auto rows = MatrixRows(is_list ? value.substr(1, value.size() - 2) : value);
    std::vector<std::string> cells;
    for (const auto& row : rows) cells.insert(cells.end(), row.begin(), row.end());
    const std::vector<size_t> meant = RowsOf(match.str(1), match.str(2));
    if (match.length(4) > 0 || meant.empty() || meant.size() != cells.size()) {
      FailAt(match,
             "is not understood: " + std::to_string(cells.size()) + " offsets for " + std::to_string(meant.size()) +
                 " links of the table",
             "put them into the rows as the sixth number");
    }
    for (size_t i = 0; i < meant.size(); ++i) SetOffset(meant[i], NumberOf(cells[i], place).value);
  }

  // Of L(2), of L2, or all of a robot.
  std::vector<size_t> RowsOf(const std::string& name, const std::string& index) const {
    std::vector<size_t> rows;
    const bool is_counted = !index.empty() && std::isdigit(static_cast<unsigned char>(index[0]));
    const auto is_named = [&](const RowLabel& label) { return label.name == name && label.index == 0; };
    // A matrix of several rows is a robot's: its name means all of them.
    const bool is_row = joints_.size() > 1 && std::count_if(labels_.begin(), labels_.end(), is_named) == 1;
    for (size_t r = 0; r < labels_.size(); ++r) {
      const bool is_meant = is_counted ? static_cast<int>(r) + 1 == std::stoi(index) : !is_row || is_named(labels_[r]);
      if (is_meant) rows.push_back(r);
    }
    return rows;
  }

  void SetConvention() {
    const bool modified = SearchPattern(text_, MakePattern(R"('mdh'|"mdh"|modified)"));
    const bool standard = SearchPattern(text_, MakePattern(R"('dh'|"dh"|standard)"));
    if (options_.convention) {
      table_.convention = *options_.convention;
    } else if (modified || standard) {
      if (modified && standard) throw InputError({path_, 0, ""}, "the text names both conventions", ConventionHint());
      table_.convention = modified ? DhConvention::kModified : DhConvention::kStandard;
    } else if (options_.leave_convention_open) {
      reading_.convention_is_open = true;
    } else {
      table_.convention = DhConvention::kStandard;
      reading_.guesses.push_back(std::string("convention: standard, the default of ") +
                                 (is_system_toolbox_ ? "dhparams" : "SerialLink"));
    }
  }

  std::string text_, path_;
  const RobotReadOptions& options_;
  bool is_system_toolbox_ = false, of_links_ = false;
  DhTable table_;
  std::vector<Joint> joints_;  // these five: one per row
  std::vector<double> typed_;  // theta of a row that turns, d of one that slides, as typed
  std::vector<double> offsets_;
  std::vector<RowLabel> labels_;
  std::vector<int> lines_;
  RobotReading reading_;
};

}  // namespace

bool LooksLikeMatlab(const std::string& text) {
  return SearchPattern(WithoutMatlabComments(text), kMatrix) || HoldsElementaryTransforms(text);
}

RobotReading ReadMatlabText(const std::string& text, const std::string& path, const RobotReadOptions& options) {
  if (!SearchPattern(WithoutMatlabComments(text), kMatrix)) return ReadElementaryTransforms(text, path);
  return MatlabReader(text, path, options).Read();
}

}  // namespace sagitta

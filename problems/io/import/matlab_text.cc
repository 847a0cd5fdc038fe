// Robots as MATLAB people keep them, as text:
//
//   SerialLink([theta d a alpha sigma offset; …])   Robotics Toolbox (DHFactor prints it); standard, "modified" where
//   Link([theta d a alpha sigma offset])            the text says so; theta is the variable
//   dhparams = [a alpha d theta; …]                 Robotics System Toolbox, with 'dh' or 'mdh' in setFixedTransform
//   Tz(0.4) Rz(q1) Rx(-90) …                        elementary transforms (DHFactor's input, ETS)
#include <algorithm>
#include <cmath>
#include <sstream>

#include "models/constants.h"
#include "problems/input_error.h"
#include "problems/io/files.h"
#include "problems/io/import/expressions.h"
#include "problems/io/import/header_words.h"
#include "problems/io/import/robot_reading.h"
#include "problems/io/pattern.h"

namespace sagitta {
namespace {

const std::regex kMatrix = MakePattern(R"((dhparams\s*=|SerialLink\s*\(|Link\s*\()\s*\[([^\]]*)\])");
const std::regex kTransform = MakePattern(R"(([TR])([xyz])\s*\(\s*([^()]*)\s*\))", true);

std::string WithoutMatlabComments(const std::string& text) {
  std::istringstream lines(text);
  std::string kept;
  for (std::string line; std::getline(lines, line);) kept += line.substr(0, line.find('%')) + "\n";
  return ReplacePattern(kept, MakePattern(R"(\.\.\.\s*\n)"), " ");
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

class MatlabReader {
 public:
  MatlabReader(const std::string& text, std::string path, const RobotReadOptions& options)
      : text_(WithoutMatlabComments(text)), path_(std::move(path)), options_(options) {}

  RobotReading Read() {
    std::smatch match;
    if (SearchPattern(text_, &match, kMatrix)) return ReadTables();
    return ReadTransforms();
  }

 private:
  [[noreturn]] void Fail(const std::string& what, const std::string& hint) const {
    throw InputError({path_, 0, ""}, what, hint);
  }

  TypedNumber NumberOf(const std::string& cell) const {
    if (const auto number = ParseTypedNumber(cell)) return *number;
    if (const auto joint = ParseJointExpression(cell)) return joint->offset;
    Fail("'" + cell + "' has no value", "put numbers in place of symbols");
  }

  // Lengths in m, angles in rad, as both toolboxes have them.
  RobotReading ReadTables() {
    RobotReading reading;
    DhTable table;
    std::vector<Joint> joints;
    bool system_toolbox = false;
    for (const std::smatch& match : AllMatches(text_.begin(), text_.end(), kMatrix)) {
      system_toolbox = match.str(1).rfind("dhparams", 0) == 0;
      for (const std::vector<std::string>& row : MatrixRows(match.str(2))) AddRow(row, system_toolbox, &table, &joints);
      if (system_toolbox) break;
    }
    if (table.links.empty()) Fail("the table has no rows", "");
    SetConvention(system_toolbox, &table, &reading);
    reading.robot = RobotOfTable(joints, {}, table);
    reading.format = system_toolbox ? "MATLAB dhparams [a alpha d theta], m and rad"
                                    : "MATLAB links [theta d a alpha sigma offset], m and rad";
    return reading;
  }

  void AddRow(const std::vector<std::string>& row, bool system_toolbox, DhTable* table,
              std::vector<Joint>* joints) const {
    if (row.size() < 4)
      Fail("a row of the table has " + std::to_string(row.size()) + " numbers", "four are expected at least");
    DhLink link;
    link.joint = static_cast<int>(joints->size());
    bool slides = false;
    if (system_toolbox) {
      link.a = NumberOf(row[0]).value;
      link.alpha = NumberOf(row[1]).value;
      link.d = NumberOf(row[2]).value;
      link.theta = NumberOf(row[3]).value;
    } else {
      link.theta = NumberOf(row[0]).value;
      link.d = NumberOf(row[1]).value;
      link.a = NumberOf(row[2]).value;
      link.alpha = NumberOf(row[3]).value;
      slides = row.size() > 4 && NumberOf(row[4]).value != 0.0;
      if (row.size() > 5) (slides ? link.d : link.theta) += NumberOf(row[5]).value;
    }
    joints->push_back(
        {"j" + std::to_string(joints->size() + 1), slides ? JointType::kPrismatic : JointType::kRevolute, {}, {}});
    table->links.push_back(link);
  }

  void SetConvention(bool system_toolbox, DhTable* table, RobotReading* reading) const {
    const bool modified = SearchPattern(text_, MakePattern(R"('mdh'|"mdh"|modified)"));
    const bool standard = SearchPattern(text_, MakePattern(R"('dh'|"dh"|standard)"));
    if (options_.convention) {
      table->convention = *options_.convention;
    } else if (modified || standard) {
      if (modified && standard)
        Fail("the text names both conventions", "--convention=standard or --convention=modified");
      table->convention = modified ? DhConvention::kModified : DhConvention::kStandard;
    } else if (options_.leave_convention_open) {
      reading->convention_is_open = true;
    } else {
      table->convention = DhConvention::kStandard;
      reading->guesses.push_back(std::string("convention: standard, the default of ") +
                                 (system_toolbox ? "dhparams" : "SerialLink"));
    }
  }

  // Degrees where a sign or a number beyond a full turn says so, rad where pi does.
  double DegreesPerUnit(RobotReading* reading) const {
    bool degrees = false, radians = false, any = false;
    for (const std::smatch& match : AllMatches(text_.begin(), text_.end(), kTransform)) {
      const std::string letter = LowerCaseOf(match.str(1));
      const auto number = letter == "r" ? ParseTypedNumber(match.str(3)) : std::nullopt;
      if (!number) continue;
      degrees |= number->is_degrees || std::abs(number->value) > 2.0 * M_PI + 1e-6;
      radians |= number->uses_pi;
      any |= number->value != 0.0;
    }
    if (degrees && radians) Fail("some angles are in degrees and some use pi", "one unit is expected");
    if (any && !degrees && !radians) reading->guesses.push_back("angles are in rad: none is beyond a full turn");
    return degrees ? kDegree : 1.0;
  }

  RobotReading ReadTransforms() {
    RobotReading reading;
    reading.format = "elementary transforms, lengths in m";
    const double rad_per_unit = DegreesPerUnit(&reading);
    Chain chain;
    for (const std::smatch& match : AllMatches(text_.begin(), text_.end(), kTransform)) {
      const bool turns = LowerCaseOf(match.str(1)) == "r";
      const std::string name = match.str(1) + match.str(2) + "(" + match.str(3) + ")";
      ElementaryTransform transform;
      transform.motion = turns ? Motion::kRotation : Motion::kTranslation;
      transform.axis = static_cast<Axis>(LowerCaseOf(match.str(2))[0] - 'x');
      const auto value = [&](const TypedNumber& n) { return turns && !n.uses_pi ? n.value * rad_per_unit : n.value; };
      if (const auto number = ParseTypedNumber(match.str(3))) {
        transform.nominal = value(*number);
      } else if (const auto joint = ParseJointExpression(match.str(3))) {
        transform.joint = chain.num_joints();
        transform.sign = joint->sign;
        transform.nominal = value(joint->offset);
        chain.joints.push_back(
            {"q" + std::to_string(joint->index), turns ? JointType::kRevolute : JointType::kPrismatic, {}, {}});
      } else {
        Fail("'" + name + "' has no value", "put numbers in place of symbols");
      }
      if (!turns && std::abs(transform.nominal) > 10.0)
        Fail("'" + name + "' is longer than 10 m", "lengths in m are expected");
      // A name for every error: the default free set chooses among them.
      transform.error =
          (turns ? "phi_" : "p_") + LowerCaseOf(match.str(2)) + std::to_string(chain.num_transforms() + 1);
      chain.transforms.push_back(transform);
    }
    reading.robot.chain = chain;
    const std::string defect = chain.Defect();
    if (!defect.empty()) Fail(defect, "");
    if (chain.joints.empty()) Fail("none of the transforms has a joint variable", "Rz(q1), Tz(q2) …");
    return reading;
  }

  std::string text_, path_;
  const RobotReadOptions& options_;
};

}  // namespace

bool LooksLikeMatlab(const std::string& text) {
  const std::string plain = WithoutMatlabComments(text);
  if (SearchPattern(plain, kMatrix)) return true;
  return AllMatches(plain.begin(), plain.end(), kTransform).size() > 1;
}

RobotReading ReadMatlabText(const std::string& text, const std::string& path, const RobotReadOptions& options) {
  return MatlabReader(text, path, options).Read();
}

}  // namespace sagitta

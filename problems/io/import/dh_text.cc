#include "problems/io/import/dh_text.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include "problems/input_error.h"
#include "problems/io/files.h"
#include "problems/io/import/expressions.h"
#include "problems/io/import/header_words.h"
#include "problems/io/import/mapped_columns.h"
#include "problems/io/import/robot_reading.h"
#include "problems/io/import/text_table.h"
#include "problems/io/pattern.h"
#include "problems/io/text_checks.h"
#include "problems/io/units.h"
#include "problems/limits.h"
#include "problems/text.h"

namespace sagitta {
namespace {

// What a column of a DH table can hold.
enum class DhColumn { kA, kAlpha, kD, kTheta, kOffset, kBeta, kName, kType, kMin, kMax, kOther };

bool IsLength(DhColumn column) { return column == DhColumn::kA || column == DhColumn::kD; }
bool IsAngle(DhColumn column) {
  return column == DhColumn::kAlpha || column == DhColumn::kTheta || column == DhColumn::kBeta ||
         column == DhColumn::kOffset;
}

// "alpha_{i-1} [deg]": the name without its index. Indices one behind the joint's are Craig's.
DhColumn ColumnOf(const std::string& header, bool* is_previous) {
  std::string name = NameWithoutUnit(header);
  const std::regex previous = MakePattern(R"([_ ]*[\{\(]?[ij_ n]*-+ *1[\}\)]?$)");
  const std::regex index = MakePattern(R"([_ ]*[\{\(]?(i|j|n)[\}\)]?$)");
  *is_previous = SearchPattern(name, previous) && ReplacePattern(name, previous, "") != name;
  name = ReplacePattern(name, previous, "");
  static const std::map<std::string, DhColumn> kNames = {{"a", DhColumn::kA},
                                                         {"r", DhColumn::kA},
                                                         {"length", DhColumn::kA},
                                                         {"link length", DhColumn::kA},
                                                         {"alpha", DhColumn::kAlpha},
                                                         {"α", DhColumn::kAlpha},
                                                         {"twist", DhColumn::kAlpha},
                                                         {"link twist", DhColumn::kAlpha},
                                                         {"d", DhColumn::kD},
                                                         {"link offset", DhColumn::kD},
                                                         {"theta", DhColumn::kTheta},
                                                         {"θ", DhColumn::kTheta},
                                                         {"joint angle", DhColumn::kTheta},
                                                         {"q", DhColumn::kTheta},
                                                         {"offset", DhColumn::kOffset},
                                                         {"theta offset", DhColumn::kOffset},
                                                         {"beta", DhColumn::kBeta},
                                                         {"β", DhColumn::kBeta},
                                                         {"joint", DhColumn::kName},
                                                         {"link", DhColumn::kName},
                                                         {"axis", DhColumn::kName},
                                                         {"name", DhColumn::kName},
                                                         {"j", DhColumn::kName},
                                                         {"i", DhColumn::kName},
                                                         {"nr", DhColumn::kName},
                                                         {"no", DhColumn::kName},
                                                         {"achse", DhColumn::kName},
                                                         {"kinematics", DhColumn::kName},
                                                         {"type", DhColumn::kType},
                                                         {"sigma", DhColumn::kType},
                                                         {"min", DhColumn::kMin},
                                                         {"lower", DhColumn::kMin},
                                                         {"qmin", DhColumn::kMin},
                                                         {"max", DhColumn::kMax},
                                                         {"upper", DhColumn::kMax},
                                                         {"qmax", DhColumn::kMax}};
  auto found = kNames.find(name);
  if (found == kNames.end()) found = kNames.find(ReplacePattern(name, index, ""));
  return found == kNames.end() ? DhColumn::kOther : found->second;
}

bool IsDhHeader(const std::vector<std::string>& header) {
  std::set<DhColumn> columns;
  bool ignored = false;
  for (const std::string& name : header) columns.insert(ColumnOf(name, &ignored));
  return columns.count(DhColumn::kA) && columns.count(DhColumn::kAlpha) && columns.count(DhColumn::kD);
}

class DhReader {
 public:
  DhReader(const TextTable& table, const RobotReadOptions& options) : table_(table), options_(options) {}

  RobotReading Read() {
    for (const std::string& name : table_.header) {
      bool previous = false;
      columns_.push_back(ColumnOf(name, &previous));
      has_previous_ |= previous;
    }
    reading_.format = "DH table (" + table_.separator + (table_.decimal_comma ? ", decimal comma)" : ")");
    reading_.guesses = table_.guesses;
    FindUnits();
    for (size_t r = 0; r < table_.rows.size(); ++r) ReadRow(table_.rows[r]);
    ReadComments();
    SetConvention();
    reading_.robot = RobotOfTable(joints_, couplings_, dh_);
    reading_.robot.name = name_;
    return std::move(reading_);
  }

 private:
  [[noreturn]] void Fail(const TextTable::Row& row, size_t c, const std::string& what, const std::string& hint) const {
    throw InputError({table_.path, row.line, table_.header[c]}, what, hint);
  }

  // The unit of each column: in its name, else by the size of the numbers.
  void FindUnits() {
    for (size_t c = 0; c < columns_.size(); ++c) {
      units_.push_back(nullptr);
      const bool limit = columns_[c] == DhColumn::kMin || columns_[c] == DhColumn::kMax;
      if (!IsLength(columns_[c]) && !IsAngle(columns_[c]) && !limit) continue;
      const std::string unit = UnitInHeader(table_.header[c]);
      if (unit.empty()) continue;
      const bool fits = IsLengthUnit(unit) ? !IsAngle(columns_[c]) : IsAngleUnit(unit) && !IsLength(columns_[c]);
      if (!fits) {
        throw InputError({table_.path, table_.header_line, table_.header[c]},
                         std::string(IsLength(columns_[c])  ? "a length"
                                     : IsAngle(columns_[c]) ? "an angle"
                                                            : "a limit") +
                             " in " + unit,
                         "lengths in mm, cm, m, um or in, angles in deg, rad, mrad or urad");
      }
      units_[c] = &UnitNamed(unit);
    }
    GuessUnit(true);
    GuessUnit(false);
  }

  void GuessUnit(bool lengths) {
    double largest = 0.0;
    bool uses_pi = false, is_degrees = false, any = false, whole = true;
    for (size_t c = 0; c < columns_.size(); ++c) {
      if (units_[c] || !(lengths ? IsLength(columns_[c]) : IsAngle(columns_[c]))) continue;
      any = true;
      for (const TextTable::Row& row : table_.rows) {
        std::optional<TypedNumber> number = ParseTypedNumber(row.cells[c], table_.decimal_comma);
        if (const auto joint = ParseJointExpression(row.cells[c], table_.decimal_comma)) number = joint->offset;
        if (!number) continue;
        largest = std::max(largest, std::abs(number->value));
        uses_pi |= number->uses_pi;
        is_degrees |= number->is_degrees;
        whole &= number->value == std::round(number->value);
      }
    }
    if (!any) return;
    std::string unit;
    if (lengths) {
      unit = largest < 10.0 ? "m" : "mm";  // no link is 10 m long, and no arm is made of links below 10 mm
    } else {
      unit = uses_pi                                                                                   ? "rad"
             : is_degrees || largest > 2.0 * M_PI + 1e-6 || largest == 0.0 || (whole && largest > 4.0) ? "deg"
                                                                                                       : "rad";
    }
    for (size_t c = 0; c < columns_.size(); ++c) {
      if (!units_[c] && (lengths ? IsLength(columns_[c]) : IsAngle(columns_[c]))) units_[c] = &UnitNamed(unit);
    }
    const bool certain = uses_pi || is_degrees || largest == 0.0;
    if (!certain) {
      reading_.guesses.push_back(std::string(lengths ? "lengths" : "angles") + " are in " + unit +
                                 ": the header does not say, the largest is " + FormatNumber(largest));
    }
  }

  // A column's number in SI; an expression with a joint variable gives its constant.
  double Quantity(const TextTable::Row& row, size_t c, bool* is_variable) const {
    const std::string& cell = row.cells[c];
    std::optional<TypedNumber> number = ParseTypedNumber(cell, table_.decimal_comma);
    if (const auto joint = number ? std::nullopt : ParseJointExpression(cell, table_.decimal_comma)) {
      if (joint->sign < 0.0)
        Fail(row, c, "'" + cell + "' turns the joint round",
             "a DH row has q with a plus; turn the axis by alpha, or write a chain");
      number = joint->offset;
      *is_variable = true;
    }
    if (!number && (cell.empty() || cell == "-")) number = TypedNumber();
    if (!number)
      Fail(row, c, "'" + cell + "' is no number",
           "numbers, multiples of pi and joint variables like q1 + 90 are expected");
    if (number->uses_pi && !IsLength(columns_[c])) return number->value;
    if (number->is_degrees) return UnitNamed("deg").ToSi(number->value);
    return units_[c]->ToSi(number->value);
  }

  void ReadRow(const TextTable::Row& row) {
    DhLink link;
    Joint joint;
    bool slides = false;
    for (size_t c = 0; c < columns_.size(); ++c) {
      const std::string& cell = row.cells[c];
      bool variable = false;
      switch (columns_[c]) {
        case DhColumn::kA:
          link.a = Quantity(row, c, &variable);
          break;
        case DhColumn::kAlpha:
          link.alpha = Quantity(row, c, &variable);
          break;
        case DhColumn::kBeta:
          link.beta = Quantity(row, c, &variable);
          break;
        case DhColumn::kD:
          link.d = Quantity(row, c, &variable);
          slides |= variable;
          break;
        case DhColumn::kTheta:
        case DhColumn::kOffset:
          link.theta += Quantity(row, c, &variable);
          break;
        case DhColumn::kName:
          joint.name = cell;
          break;
        case DhColumn::kType:
          slides |= IsPrismatic(row, c);
          break;
        default:
          break;
      }
      const bool is_joint_column =
          columns_[c] == DhColumn::kTheta || columns_[c] == DhColumn::kD || columns_[c] == DhColumn::kOffset;
      if (variable && !is_joint_column) Fail(row, c, "a joint variable stands where a constant is expected", "");
    }
    joint.type = slides ? JointType::kPrismatic : JointType::kRevolute;
    ReadLimits(row, &joint);
    joint.name = JointName(joint.name);
    link.joint = static_cast<int>(joints_.size());
    joints_.push_back(joint);
    dh_.links.push_back(link);
  }

  bool IsPrismatic(const TextTable::Row& row, size_t c) const {
    const std::string type = LowerCaseOf(row.cells[c]);
    if (type.empty() || type[0] == 'r' || type == "0") return false;
    if (type[0] == 'p' || type == "1" || type[0] == 't') return true;
    Fail(row, c, "'" + row.cells[c] + "' is no kind of joint", "revolute or prismatic, R or P, 0 or 1");
  }

  // Cells without number, or in the unit of the other kind of joint, state no limit.
  void ReadLimits(const TextTable::Row& row, Joint* joint) const {
    for (size_t c = 0; c < columns_.size(); ++c) {
      const bool is_min = columns_[c] == DhColumn::kMin;
      if ((!is_min && columns_[c] != DhColumn::kMax) || !units_[c]) continue;
      const bool of_length = IsLengthUnit(units_[c]->suffix);
      const std::optional<double> number = table_.Number(row.cells[c]);
      if (!number || of_length != (joint->type == JointType::kPrismatic)) continue;
      (is_min ? joint->min : joint->max) = units_[c]->ToSi(*number);
    }
  }

  // "Joint 1", "1", "" become j1; a name of one's own stays.
  std::string JointName(const std::string& cell) const {
    const std::string count = std::to_string(joints_.size() + 1);
    const bool plain = cell.empty() || cell.find_first_not_of("0123456789") == std::string::npos;
    std::string name = plain ? "j" + count : cell;
    std::replace(name.begin(), name.end(), ' ', '_');
    for (const Joint& joint : joints_) {
      if (joint.name == name) throw InputError({table_.path, 0, ""}, "two joints are called '" + name + "'");
    }
    return name;
  }

  void ReadComments() {
    static const std::regex kEntry = MakePattern(R"(^\s*(name|convention|coupling|flange)\s*:\s*(.*?)\s*$)");
    for (const std::string& line : table_.preamble) {
      std::smatch match;
      words_ += LowerCaseOf(line) + "\n";
      if (line.size() > limits::kWordBytes || !MatchPattern(line, &match, kEntry)) continue;
      if (match[1] == "name") name_ = match[2];
      if (match[1] == "coupling") ReadCoupling(match[2]);
      if (match[1] == "flange") ReadFlange(match[2]);
    }
    for (const std::string& name : table_.header) words_ += LowerCaseOf(name) + "\n";
  }

  void ReadCoupling(const std::string& text) {
    std::istringstream words(text);
    std::string joint, driver, ratio;
    words >> joint >> driver >> ratio;
    Coupling coupling;
    for (size_t j = 0; j < joints_.size(); ++j) {
      if (joints_[j].name == joint) coupling.joint = static_cast<int>(j);
      if (joints_[j].name == driver) coupling.driver = static_cast<int>(j);
    }
    const std::optional<double> number = ParseNumber(ratio);
    if (coupling.joint < 0 || coupling.driver < 0 || !number) {
      throw InputError({table_.path, 0, "coupling"}, "'" + text + "' is no coupling", "# coupling: JOINT DRIVER RATIO");
    }
    coupling.ratio = *number;
    couplings_.push_back(coupling);
  }

  // xyz_mm 0 0 100 rpy_deg 0 0 90
  void ReadFlange(const std::string& text) {
    std::istringstream words(text);
    std::string xyz, rpy, numbers[6];
    words >> xyz >> numbers[0] >> numbers[1] >> numbers[2] >> rpy >> numbers[3] >> numbers[4] >> numbers[5];
    for (int i = 0; i < 6; ++i) {
      const std::optional<double> number = ParseNumber(numbers[i]);
      if (!number || xyz != "xyz_mm" || rpy != "rpy_deg") {
        throw InputError({table_.path, 0, "flange"}, "'" + text + "' is no pose",
                         "# flange: xyz_mm X Y Z rpy_deg R P Y");
      }
      if (i < 3) dh_.flange_xyz[i] = UnitNamed("mm").ToSi(*number);
      if (i >= 3) dh_.flange_rpy[i - 3] = UnitNamed("deg").ToSi(*number);
    }
  }

  void SetConvention() {
    const bool modified = SearchPattern(words_, MakePattern(R"(modified|\bmdh\b|moddh|craig|khalil|proximal)"));
    const bool standard = SearchPattern(words_, MakePattern(R"(standard|\bsdh\b|stddh|classic|distal|paul)"));
    if (options_.convention) {
      dh_.convention = *options_.convention;
    } else if (modified != standard) {
      dh_.convention = modified ? DhConvention::kModified : DhConvention::kStandard;
      reading_.notes.push_back(std::string("convention: ") + (modified ? "modified" : "standard") +
                               ", as the file says");
    } else if (has_previous_) {
      dh_.convention = DhConvention::kModified;
      reading_.notes.push_back("convention: modified, as the indices i-1 in the header say");
    } else if (options_.leave_convention_open) {
      reading_.convention_is_open = true;
    } else if (const auto by_shape = ConventionByShape(dh_.links)) {
      dh_.convention = *by_shape;
      const bool is_modified = *by_shape == DhConvention::kModified;
      reading_.guesses.push_back(
          is_modified ? "convention: modified, since the first row has neither a nor alpha and the last row has"
                      : "convention: standard, since the last row has neither a nor alpha and the first row has");
    } else {
      throw InputError({table_.path, table_.header_line, ""},
                       "whether this is a standard or a modified DH table is not said and cannot be seen",
                       "--convention=standard or --convention=modified");
    }
  }

  const TextTable& table_;
  const RobotReadOptions& options_;
  RobotReading reading_;
  std::vector<DhColumn> columns_;
  std::vector<const Unit*> units_;
  bool has_previous_ = false;
  std::string words_, name_;
  std::vector<Joint> joints_;
  std::vector<Coupling> couplings_;
  DhTable dh_;
};

std::string InUnit(double si, const char* unit) { return FormatNumber(ToUnit(si, UnitNamed(unit))); }

}  // namespace

std::optional<DhConvention> ConventionByShape(const std::vector<DhLink>& links) {
  const auto is_plain = [](const DhLink& link) { return link.a == 0.0 && link.alpha == 0.0; };
  const bool first = is_plain(links.front()), last = is_plain(links.back());
  if (first == last) return std::nullopt;
  return first ? DhConvention::kModified : DhConvention::kStandard;
}

Robot RobotOfTable(const std::vector<Joint>& joints, const std::vector<Coupling>& couplings, const DhTable& table) {
  Robot robot;
  robot.dh = table;
  robot.chain = ChainFromDhTable(joints, couplings, table);
  return robot;
}

bool LooksLikeDhTable(const std::string& text, const std::string& path) {
  try {
    return IsDhHeader(ParseTextTable(text, path).header);
  } catch (const InputError&) {
    return false;
  }
}

RobotReading ReadDhText(const std::string& text, const std::string& path, const RobotReadOptions& options) {
  const TextTable table = ParseTextTable(text, path);
  return DhReader(table, options).Read();
}

std::string DhTableToCsv(const Robot& robot, const DhTable& table) {
  const Chain& chain = robot.chain;
  const bool has_beta =
      std::any_of(table.links.begin(), table.links.end(), [](const DhLink& l) { return l.beta != 0.0; });
  const bool modified = table.convention == DhConvention::kModified;
  std::string text;
  if (!robot.name.empty()) text += "# name: " + robot.name + "\n";
  text += std::string("# convention: ") + (modified ? "modified" : "standard") + "\n# one row: ";
  text += modified ? std::string("Rx(alpha) Tx(a) ") + (has_beta ? "Ry(beta) " : "") + "Rz(theta + q) Tz(d)\n"
                   : std::string("Rz(theta + q) Tz(d) Tx(a) Rx(alpha)") + (has_beta ? " Ry(beta)\n" : "\n");
  for (const Coupling& coupling : chain.couplings) {
    text += "# coupling: " + chain.joints[coupling.joint].name + " " + chain.joints[coupling.driver].name + " " +
            FormatNumber(coupling.ratio) + "\n";
  }
  if (!table.flange_xyz.isZero(0.0) || !table.flange_rpy.isZero(0.0)) {
    text += "# flange: xyz_mm";
    for (int i = 0; i < 3; ++i) text += " " + InUnit(table.flange_xyz[i], "mm");
    text += " rpy_deg";
    for (int i = 0; i < 3; ++i) text += " " + InUnit(table.flange_rpy[i], "deg");
    text += "\n";
  }
  text += std::string("joint,type,theta_deg,d_mm,a_mm,alpha_deg") + (has_beta ? ",beta_deg" : "") +
          ",min_deg,max_deg,min_mm,max_mm\n";
  for (const DhLink& link : table.links) {
    const Joint& joint = chain.joints[link.joint];
    const bool revolute = joint.type == JointType::kRevolute;
    text += CsvCell(joint.name) + (revolute ? ",revolute," : ",prismatic,") + InUnit(link.theta, "deg") + "," +
            InUnit(link.d, "mm") + "," + InUnit(link.a, "mm") + "," + InUnit(link.alpha, "deg") +
            (has_beta ? "," + InUnit(link.beta, "deg") : "");
    const std::string min = joint.min ? InUnit(*joint.min, revolute ? "deg" : "mm") : "";
    const std::string max = joint.max ? InUnit(*joint.max, revolute ? "deg" : "mm") : "";
    text += revolute ? "," + min + "," + max + ",,\n" : ",,," + min + "," + max + "\n";
  }
  return text;
}

}  // namespace sagitta

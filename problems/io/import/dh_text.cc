#include "problems/io/import/dh_text.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "problems/choices.h"
#include "problems/input_error.h"
#include "problems/io/import/dh_columns.h"
#include "problems/io/import/dh_units.h"
#include "problems/io/import/expressions.h"
#include "problems/io/import/robot_reading.h"
#include "problems/io/import/text_table.h"
#include "problems/io/pattern.h"
#include "problems/io/text_checks.h"
#include "problems/io/units.h"
#include "problems/limits.h"
#include "problems/text.h"

namespace sagitta {
namespace {

// Where a row says which joint it is, and that it is one.
struct RowName {
  int line = 0;
  std::string name;             // as typed
  std::optional<int> variable;  // 2 of q2
  bool states_type = false;
};

bool IsCount(const std::string& name) {
  return !name.empty() && name.size() <= 6 && name.find_first_not_of("0123456789") == std::string::npos;
}

// Rows behind the last joint, and sums.
bool IsNoJoint(const std::string& name) {
  static const std::set<std::string> kWords = {"tcp",   "tool", "flange",       "flansch",      "sum",   "summe",
                                               "total", "ee",   "end effector", "end-effector", "gesamt"};
  return kWords.count(LowerCaseOf(name)) > 0;
}

// A of A2, and 2.
std::optional<std::pair<std::string, int>> CountedName(const std::string& name) {
  const size_t last = name.find_last_not_of("0123456789");
  const std::string count = name.substr(last == std::string::npos ? 0 : last + 1);
  if (!IsCount(count)) return std::nullopt;
  return std::pair(name.substr(0, name.size() - count.size()), std::stoi(count));
}

// By which row ConventionByShape sees the convention.
const char* PlainRowOf(DhConvention convention) {
  switch (convention) {
    case DhConvention::kStandard:
      return "last row has neither a nor alpha and the first row has";
    case DhConvention::kModified:
      return "first row has neither a nor alpha and the last row has";
  }
  return "";
}

class DhReader {
 public:
  DhReader(const TextTable& table, const RobotReadOptions& options) : table_(table), options_(options) {}

  RobotReading Read() {
    columns_ = DhColumnsOf(table_, &has_previous_);
    ReadWords();
    const bool is_khalil = IsKhalils();
    const bool has_r = SetLengths(is_khalil, &columns_);
    reading_.format = "DH table (" + table_.separator + (table_.decimal_comma ? ", decimal comma)" : ")");
    reading_.guesses = table_.guesses;
    const DhUnits units(table_, columns_, &reading_);
    units_ = &units;
    for (const TextTable::Row& row : table_.rows) ReadRow(row);
    CheckEveryRowIsAJoint();
    CheckOrder();
    NameJoints();
    units.ReadLimits(&joints_, &reading_);
    NoteColumnsNotRead();
    ReadComments();
    SetConvention();
    if (has_r) CheckLengths(is_khalil);
    reading_.robot = RobotOfTable(joints_, couplings_, dh_);
    reading_.robot.name = name_;
    return std::move(reading_);
  }

 private:
  [[noreturn]] void Fail(const TextTable::Row& row, size_t c, const std::string& what, const std::string& hint) const {
    throw InputError({table_.path, row.line, table_.header[c]}, what, hint);
  }

  void NoteColumnsNotRead() {
    const std::string columns = ColumnsNotRead(table_, columns_);
    if (!columns.empty()) reading_.notes.push_back("columns not read: " + columns);
  }

  // A cell in SI; an expression with a joint variable gives its constant.
  double Quantity(const TextTable::Row& row, size_t c, RowName* name) const {
    const std::string& cell = row.cells[c];
    std::optional<TypedNumber> number = ParseTypedNumber(cell, table_.decimal_comma);
    if (const auto joint = number ? std::nullopt : ParseJointExpression(cell, table_.decimal_comma)) {
      if (joint->sign < 0.0) FailTurnedRound(row, c);
      number = joint->offset;
      AddVariable(row, c, joint->index, name);
    }
    if (!number && (cell.empty() || cell == "-")) number = TypedNumber();
    if (!number)
      Fail(row, c, "'" + cell + "' is no number",
           "numbers, multiples of pi and joint variables like q1 + 90 are expected");
    return units_->ToSi(row, c, *number);
  }

  [[noreturn]] void FailTurnedRound(const TextTable::Row& row, size_t c) const {
    Fail(row, c, "'" + row.cells[c] + "' turns the joint round",
         "a DH row has q with a plus; turn the axis by alpha, or write a chain");
  }

  void AddVariable(const TextTable::Row& row, size_t c, int index, RowName* name) const {
    const DhColumn column = columns_[c];
    if (column == DhColumn::kA || column == DhColumn::kAlpha || column == DhColumn::kBeta)
      Fail(row, c, "a joint variable stands where a constant is expected", "");
    if (name->variable) Fail(row, c, "a second joint variable stands in this row", "one row per joint is expected");
    name->variable = index;
  }

  void ReadRow(const TextTable::Row& row) {
    DhLink link;
    Joint joint;
    RowName name;
    name.line = row.line;
    bool slides = false;
    for (size_t c = 0; c < columns_.size(); ++c) {
      const bool had_variable = name.variable.has_value();
      switch (columns_[c]) {
        case DhColumn::kA:
          link.a = Quantity(row, c, &name);
          break;
        case DhColumn::kAlpha:
          link.alpha = Quantity(row, c, &name);
          break;
        case DhColumn::kBeta:
          link.beta = Quantity(row, c, &name);
          break;
        case DhColumn::kD:
          link.d = Quantity(row, c, &name);
          slides |= name.variable && !had_variable;
          break;
        case DhColumn::kTheta:
        case DhColumn::kOffset:
        case DhColumn::kThetaOffset:
          link.theta += Quantity(row, c, &name);
          break;
        case DhColumn::kName:
          name.name = row.cells[c];
          break;
        case DhColumn::kType:
          slides |= IsPrismatic(row, c);
          name.states_type = !row.cells[c].empty();
          break;
        case DhColumn::kSign:
          CheckSign(row, c);
          break;
        case DhColumn::kR:  // named by SetLengths
        case DhColumn::kMin:
        case DhColumn::kMax:
        case DhColumn::kOther:
          break;
      }
    }
    joint.type = slides ? JointType::kPrismatic : JointType::kRevolute;
    if (slides) CheckOffsetOfSlide(row);
    link.joint = static_cast<int>(joints_.size());
    joints_.push_back(joint);
    dh_.links.push_back(link);
    names_.push_back(name);
  }

  bool IsPrismatic(const TextTable::Row& row, size_t c) const {
    const std::string type = LowerCaseOf(row.cells[c]);
    if (type.empty() || type[0] == 'r' || type == "0") return false;
    if (type[0] == 'p' || type == "1" || type[0] == 't') return true;
    Fail(row, c, "'" + row.cells[c] + "' is no kind of joint", "revolute or prismatic, R or P, 0 or 1");
  }

  void CheckSign(const TextTable::Row& row, size_t c) const {
    const std::string& cell = row.cells[c];
    const std::optional<double> number = table_.Number(cell);
    if (cell == "-" || (number && *number == -1.0)) FailTurnedRound(row, c);
    if (cell.empty() || cell == "+" || cell == "+1" || (number && *number == 1.0)) return;
    Fail(row, c, "'" + cell + "' is no sign", "1 or -1 is expected");
  }

  // Of the joint's value: of a slide a length.
  void CheckOffsetOfSlide(const TextTable::Row& row) const {
    for (size_t c = 0; c < columns_.size(); ++c) {
      const std::optional<TypedNumber> number = ParseTypedNumber(row.cells[c], table_.decimal_comma);
      if (columns_[c] != DhColumn::kOffset || !number || number->value == 0.0) continue;
      Fail(row, c, "the joint slides, and its offset stands among angles", "add it to d");
    }
  }

  [[noreturn]] void FailRow(const RowName& row, const std::string& what, const std::string& hint) const {
    throw InputError({table_.path, row.line, row.name}, what, hint);
  }

  // A flange or a sum below the table would become a joint of its own.
  void CheckEveryRowIsAJoint() const {
    const auto has_variable = [](const RowName& row) { return row.variable.has_value(); };
    const auto is_counted = [](const RowName& row) { return IsCount(row.name); };
    const bool variables = std::any_of(names_.begin(), names_.end(), has_variable);
    const bool counts = std::any_of(names_.begin(), names_.end(), is_counted);
    for (const RowName& row : names_) {
      if (row.states_type) continue;
      const std::string hint = "one row per joint; what lies behind the last one: # flange: xyz_mm X Y Z rpy_deg R P Y";
      if (variables && !row.variable)
        FailRow(
            row, "the row has no joint variable, others have one",
            "q1, q2 … in every row that moves, or a column type; what lies behind the last joint: # flange: xyz_mm X "
            "Y Z rpy_deg R P Y");
      if (IsNoJoint(row.name) || (counts && !IsCount(row.name)))
        FailRow(row, "'" + row.name + "' is no joint" + (counts ? ": other rows have numbers" : ""), hint);
    }
  }

  // Rows are in the order of the chain; numbers that say otherwise belong to another order.
  void CheckOrder() {
    const RowName* first_variable = nullptr;
    size_t first = 0;
    for (size_t r = 0; r < names_.size(); ++r) {
      const RowName& row = names_[r];
      if (IsCount(row.name) && IsCount(names_[0].name))
        CheckCount(r, std::stoi(names_[0].name), std::stoi(row.name), row);
      if (row.variable && first_variable) CheckCount(r - first, *first_variable->variable, *row.variable, row);
      if (row.variable && !first_variable) first_variable = &row, first = r;
    }
    for (size_t r = 1; r < names_.size(); ++r) {
      const auto before = CountedName(names_[r - 1].name), here = CountedName(names_[r].name);
      if (!before || !here || before->first != here->first || before->second < here->second) continue;
      reading_.guesses.push_back("the rows are in the order of the chain: " + names_[r - 1].name + " lies before " +
                                 names_[r].name);
    }
  }

  void CheckCount(size_t rows_on, int first, int count, const RowName& row) const {
    const int expected = first + static_cast<int>(rows_on);
    if (count == expected) return;
    FailRow(row, "joint " + std::to_string(count) + " stands where joint " + std::to_string(expected) + " is expected",
            "one row per joint, from the base to the flange");
  }

  // 1, 2 … become j1, j2 …, as do 0, 1 …; a name of one's own stays.
  void NameJoints() {
    const int start = IsCount(names_[0].name) ? std::max(1, std::stoi(names_[0].name)) : 1;
    for (size_t j = 0; j < joints_.size(); ++j) {
      const std::string& cell = names_[j].name;
      const bool plain = cell.empty() || IsCount(cell);
      std::string name = plain ? "j" + std::to_string(start + static_cast<int>(j)) : cell;
      std::replace(name.begin(), name.end(), ' ', '_');
      for (size_t other = 0; other < j; ++other) {
        if (joints_[other].name == name) FailRow(names_[j], "two joints are called '" + name + "'", "");
      }
      joints_[j].name = name;
    }
  }

  // A line of comments that is an entry: its key and value.
  static std::optional<std::pair<std::string, std::string>> EntryOf(const std::string& line) {
    static const std::regex kEntry = MakePattern(R"(^\s*(name|convention|coupling|flange)\s*:\s*(.*?)\s*$)");
    std::smatch match;
    if (line.size() > limits::kWordBytes || !MatchPattern(line, &match, kEntry)) return std::nullopt;
    return std::pair(match[1].str(), match[2].str());
  }

  // What comments and header say of the convention; the name of a robot says nothing of it.
  void ReadWords() {
    static const std::regex kKhalil = MakePattern("khalil");
    static const std::regex kNotKhalil = MakePattern(R"(\b(not|no|nicht|kein|keine)\b.*khalil)");
    for (const std::string& line : table_.preamble) {
      const auto entry = EntryOf(line);
      if (entry && entry->first == "name") continue;
      const std::string words = LowerCaseOf(line);
      words_ += words + "\n";
      if (!SearchPattern(words, kKhalil)) continue;
      const bool is_denied = line.size() <= limits::kWordBytes && SearchPattern(words, kNotKhalil);
      (is_denied ? denies_khalil_ : says_khalil_) = true;
    }
    for (const std::string& name : table_.header) words_ += LowerCaseOf(name) + "\n";
    says_modified_ = SearchPattern(words_, MakePattern(R"(modified|\bmdh\b|moddh|craig|proximal)")) ||
                     (SearchPattern(words_, kKhalil) && !denies_khalil_);
    says_standard_ = SearchPattern(words_, MakePattern(R"(standard|\bsdh\b|stddh|classic|distal|paul)"));
  }

  // Lengths are Khalil's: his notation is a modified one. A table that is said to be both, here or by the flag, is
  // refused where it matters.
  bool IsKhalils() const {
    if (!says_khalil_) return false;
    const bool is_standard = says_standard_ || options_.convention == DhConvention::kStandard;
    const auto is_r = [](DhColumn column) { return column == DhColumn::kR; };
    if (is_standard && std::any_of(columns_.begin(), columns_.end(), is_r)) {
      throw InputError({table_.path, table_.header_line, "r"},
                       "the file speaks of Khalil, whose notation is a modified one, and " +
                           std::string(says_standard_ ? "the file" : "--convention") +
                           " says standard: whether r is along x or along z is open",
                       "call the length along x a and that along z d, or leave out one of the two words");
    }
    return !is_standard;
  }

  void ReadComments() {
    for (const std::string& line : table_.preamble) {
      const auto entry = EntryOf(line);
      if (!entry) continue;
      if (entry->first == "name") name_ = entry->second;
      if (entry->first == "coupling") ReadCoupling(entry->second);
      if (entry->first == "flange") ReadFlange(entry->second);
    }
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
    for (const Coupling& other : couplings_) {
      if (other.joint != coupling.joint || other.driver != coupling.driver) continue;
      throw InputError({table_.path, 0, "coupling"}, "'" + driver + "' drives '" + joint + "' twice",
                       "one ratio per pair of joints: the two would add up");
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

  // A modified table of d and r is Khalil's, or has a in its column r.
  void CheckLengths(bool is_khalil) {
    if (is_khalil) {
      reading_.notes.push_back("d is along x and r along z, as in Khalil's notation, which the file says");
    } else if (dh_.convention == DhConvention::kModified && !reading_.convention_is_open) {
      throw InputError({table_.path, table_.header_line, "r"},
                       "whether r is along x or, as in Khalil's notation, along z is not said",
                       "call the length along x a and that along z d, or say '# modified DH (Khalil)' above the table");
    }
  }

  void SetConvention() {
    if (options_.convention) {
      dh_.convention = *options_.convention;
      const bool is_other = dh_.convention == DhConvention::kModified ? says_standard_ : says_modified_;
      if (is_other && says_modified_ != says_standard_) {
        reading_.notes.push_back("convention: " + WordOf(dh_.convention) + ", as --convention says; the file says " +
                                 WordOf(says_modified_ ? DhConvention::kModified : DhConvention::kStandard));
      }
    } else if (says_modified_ != says_standard_) {
      dh_.convention = says_modified_ ? DhConvention::kModified : DhConvention::kStandard;
      reading_.notes.push_back("convention: " + WordOf(dh_.convention) + ", as the file says");
    } else if (has_previous_) {
      dh_.convention = DhConvention::kModified;
      reading_.notes.push_back("convention: modified, as the indices i-1 in the header say");
    } else if (options_.leave_convention_open) {
      reading_.convention_is_open = true;
    } else if (const auto by_shape = ConventionByShape(dh_.links)) {
      dh_.convention = *by_shape;
      reading_.guesses.push_back("convention: " + WordOf(*by_shape) + ", since the " + PlainRowOf(*by_shape));
    } else {
      throw InputError({table_.path, table_.header_line, ""},
                       "whether this is a standard or a modified DH table is not said and cannot be seen",
                       ConventionHint());
    }
  }

  const TextTable& table_;
  const RobotReadOptions& options_;
  RobotReading reading_;
  std::vector<DhColumn> columns_;
  const DhUnits* units_ = nullptr;
  bool has_previous_ = false;
  std::string words_, name_;
  bool says_khalil_ = false, denies_khalil_ = false, says_modified_ = false, says_standard_ = false;
  std::vector<Joint> joints_;
  std::vector<RowName> names_;  // of the rows, as joints_
  std::vector<Coupling> couplings_;
  DhTable dh_;
};

// What one row of such a table does, in its order.
std::string RowInWords(DhConvention convention, bool has_beta) {
  switch (convention) {
    case DhConvention::kStandard:
      return std::string("Rz(theta + q) Tz(d) Tx(a) Rx(alpha)") + (has_beta ? " Ry(beta)" : "");
    case DhConvention::kModified:
      return std::string("Rx(alpha) Tx(a) ") + (has_beta ? "Ry(beta) " : "") + "Rz(theta + q) Tz(d)";
  }
  return "";
}

std::string InUnit(double si, const char* unit) { return FormatNumber(ToUnit(si, UnitNamed(unit))); }

}  // namespace

std::optional<DhConvention> ConventionByShape(const std::vector<DhLink>& links) {
  const auto is_plain = [](const DhLink& link) { return link.a == 0.0 && link.alpha == 0.0; };
  const bool first = is_plain(links.front()), last = is_plain(links.back());
  if (first == last) return std::nullopt;
  return first ? DhConvention::kModified : DhConvention::kStandard;
}

std::string ConventionHint() {
  std::vector<std::string> flags;
  for (const std::string& word : WordsOf<DhConvention>()) flags.push_back("--convention=" + word);
  return Joined(flags, " or ");
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
  std::string text;
  if (!robot.name.empty()) text += "# name: " + robot.name + "\n";
  text += "# convention: " + WordOf(table.convention) + "\n";
  text += "# one row: " + RowInWords(table.convention, has_beta) + "\n";
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

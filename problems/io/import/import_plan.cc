#include "problems/io/import/import_plan.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include "problems/input_error.h"
#include "problems/io/import/column_meaning.h"
#include "problems/io/import/header_words.h"
#include "problems/io/import/mapped_columns.h"
#include "problems/io/import/marker_column.h"
#include "problems/io/import/open_units.h"
#include "problems/io/import/other_columns.h"
#include "problems/io/import/time_column.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr const char* kAxes[] = {"x", "y", "z"};
constexpr char kMapHint[] =
    "--map=x_mm=HEADER,y_mm=HEADER,z_mm=HEADER,q1_deg=HEADER,… (x_m, q1_rad where the numbers are in m and rad); a "
    "column's number does as well";

class Planner {
 public:
  Planner(const TextTable& table, const std::vector<Joint>& joints, const std::map<std::string, std::string>& columns)
      : table_(table), joints_(joints), mapped_(columns) {}

  std::vector<ImportPlan> Plans() {
    plan_.guesses = table_.guesses;
    AddColumnsNotJoined(table_, &plan_);
    TakeMapped();
    if (table_.has_header()) {
      meanings_ = MeaningsOf(HeadersOnce(), joints_);
      for (const int c : taken_) meanings_[static_cast<size_t>(c)] = ColumnMeaning();
      TakeJoints();
      TakePoints();
      TakeRotation();
      TakeTorques();
      AddOtherColumns(table_, meanings_, taken_, &plan_);
      return WithOpenUnits({plan_}, joints_);
    }
    if (IsComplete(plan_)) return WithOpenUnits({plan_}, joints_);
    return WithOpenUnits(LayoutsWithoutHeader(), joints_);
  }

 private:
  [[noreturn]] void Fail(const std::string& key, const std::string& what, const std::string& hint) const {
    throw InputError({table_.path, table_.header_line, key}, what, hint);
  }

  std::string HeaderOf(int c) const { return HeaderOfColumn(table_, c); }

  int ColumnNamed(const std::string& text) const {
    for (int c = 0; c < table_.columns(); ++c) {
      if (table_.header[c] == text) return c;
    }
    const bool number = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos && text.size() < 6;
    const int c = number ? std::stoi(text) - 1 : -1;
    return c >= 0 && c < table_.columns() ? c : -1;
  }

  // What --map says comes first and is no guess.
  void TakeMapped() {
    for (const auto& [column, text] : mapped_) {
      PlannedColumn planned;
      std::tie(planned.stem, planned.unit) = StemAndUnit(column);
      planned.header = text;
      planned.meaning = "as --map says";
      planned.is_mapped = true;
      planned.source = ColumnNamed(text);
      for (size_t at = 1; planned.source < 0 && at < text.size(); ++at) {
        if (text[at] != '+' && text[at] != '-') continue;
        const int first = ColumnNamed(text.substr(0, at)), second = ColumnNamed(text.substr(at + 1));
        if (first < 0 || second < 0) continue;
        planned.source = first;
        planned.second = second;
        planned.sign = text[at] == '+' ? 1.0 : -1.0;
      }
      if (planned.source < 0) Fail("--map", "there is no column '" + text + "'", SpellingHint(text, table_.header));
      CheckMappedColumn(table_, joints_, column, planned);
      taken_.insert(planned.source);
      if (planned.second >= 0) taken_.insert(planned.second);
      if (planned.stem.size() == 2 && planned.stem[0] == 'o') planned.unit = "1";
      (IsRotationStem(planned.stem) ? plan_.rotation_columns : plan_.columns).push_back(planned);
    }
    plan_.rotation_is_mapped = !plan_.rotation_columns.empty();
    if (plan_.rotation_is_mapped) SortMappedRotation(table_, &plan_.rotation_columns);
  }

  // The headers, "" in place of those of columns that stand a second time with the same cells, which are left out.
  std::vector<std::string> HeadersOnce() {
    std::vector<std::string> headers = table_.header;
    const auto are_equal = [this](size_t a, size_t b) {
      return std::all_of(table_.rows.begin(), table_.rows.end(),
                         [a, b](const TextTable::Row& row) { return row.cells[a] == row.cells[b]; });
    };
    for (size_t c = 0; c < headers.size(); ++c) {
      if (headers[c].empty() || taken_.count(static_cast<int>(c)) > 0) continue;
      for (size_t before = 0; before < c && !headers[c].empty(); ++before) {
        if (table_.header[before] == table_.header[c] && are_equal(before, c)) headers[c].clear();
      }
      if (!headers[c].empty()) continue;
      taken_.insert(static_cast<int>(c));
      plan_.unused.emplace_back(table_.header[c], "stands twice with the same cells");
    }
    return headers;
  }

  // Nothing is found for `what`, perhaps because of units.
  [[noreturn]] void FailMissing(const std::string& what, const std::string& hint = kMapHint) const {
    std::vector<std::string> columns;
    for (int c = 0; c < static_cast<int>(meanings_.size()); ++c) {
      if (!meanings_[c].unread_unit.empty()) columns.push_back("'" + HeaderOf(c) + "'");
    }
    if (columns.empty()) Fail("", what, hint);
    Fail("", what + "; of " + Joined(columns) + " the unit is not one that is read",
         "lengths in mm, cm, m, um or in, angles in deg, rad, mrad or urad (grad: degrees in German, gon elsewhere)");
  }

  bool IsMapped(const std::string& stem) const { return plan_.Find(stem) != nullptr; }

  void Add(const std::string& stem, const std::string& unit, int c, const std::string& meaning) {
    plan_.Add(stem, unit, c, HeaderOf(c), meaning);
    taken_.insert(c);
  }

  std::vector<int> ColumnsOf(Role role, int index) const {
    std::vector<int> columns;
    for (int c = 0; c < static_cast<int>(meanings_.size()); ++c) {
      if (meanings_[c].role == role && meanings_[c].index == index && !taken_.count(c)) columns.push_back(c);
    }
    return columns;
  }

  // Of commanded and actual joint values the commanded ones: what the controller is corrected by.
  int OneJointColumn(std::vector<int> columns, const std::string& stem) {
    const auto keep = [&columns](auto predicate) {
      std::vector<int> kept;
      std::copy_if(columns.begin(), columns.end(), std::back_inserter(kept), predicate);
      if (!kept.empty() && kept.size() < columns.size()) columns = kept;
    };
    if (columns.size() > 1) {
      keep([this](int c) { return meanings_[c].is_commanded; });
      keep([this](int c) { return !meanings_[c].is_actual; });
      if (columns.size() == 1) {
        both_joints_ = true;
        return columns[0];
      }
      Fail(stem,
           "the columns '" + HeaderOf(columns[0]) + "' and '" + HeaderOf(columns[1]) + "' may both be joint " +
               stem.substr(1),
           kMapHint);
    }
    return columns[0];
  }

  void TakeJoints() {
    // Counted from 0: a joint before the first, and none too many at the end.
    const bool from_zero = !ColumnsOf(Role::kJoint, -1).empty();
    if (!ColumnsOf(Role::kJoint, static_cast<int>(joints_.size()) - (from_zero ? 1 : 0)).empty()) {
      Fail("", "the table has more joints than the robot, which has " + std::to_string(joints_.size()),
           "give the robot that was measured");
    }
    std::vector<std::string> missing;
    std::vector<size_t> missing_joints;
    for (size_t j = 0; j < joints_.size(); ++j) {
      const std::string stem = "q" + std::to_string(j + 1);
      if (IsMapped(stem)) continue;
      const std::vector<int> columns = ColumnsOf(Role::kJoint, static_cast<int>(j) - (from_zero ? 1 : 0));
      if (columns.empty()) {
        missing.push_back(stem);
        missing_joints.push_back(j);
        continue;
      }
      const int c = OneJointColumn(columns, stem);
      const std::string unit = meanings_[c].unit;
      const bool slides = joints_[j].type == JointType::kPrismatic;
      if (!unit.empty() && !(slides ? IsLengthUnit(unit) : IsAngleUnit(unit))) {
        Fail(HeaderOf(c),
             "joint '" + joints_[j].name + "' " + (slides ? "slides" : "turns") + ", the column is in " + unit,
             HintOfJoints(joints_, {j}));
      }
      Add(stem, unit, c, "joint " + joints_[j].name);
    }
    if (!missing.empty()) {
      FailMissing(
          "no column is found for " + Joined(missing) + " of the robot's " + std::to_string(joints_.size()) + " joints",
          HintOfJoints(joints_, missing_joints));
    }
    RefusePulses(table_, plan_, joints_);
    if (both_joints_) plan_.guesses.push_back("of commanded and actual joint values the commanded ones are used");
    for (const int c : Remaining(Role::kJoint)) plan_.unused.emplace_back(HeaderOf(c), "the other joint values");
  }

  std::vector<int> Remaining(Role role) {
    std::vector<int> columns;
    for (int c = 0; c < static_cast<int>(meanings_.size()); ++c) {
      if (meanings_[c].role == role && !taken_.count(c)) columns.push_back(c);
    }
    taken_.insert(columns.begin(), columns.end());
    return columns;
  }

  // Names that say measured come first; two that may be meant are refused.
  bool TakeMeasured() {
    bool says_measured = false;
    for (int i = 0; i < 3; ++i) {
      for (const int c : ColumnsOf(Role::kPoint, i)) says_measured |= meanings_[c].says_measured;
    }
    std::vector<int> found;
    for (int i = 0; i < 3; ++i) {
      std::vector<int> columns;
      for (const int c : ColumnsOf(Role::kPoint, i)) {
        if (!says_measured || meanings_[c].says_measured) columns.push_back(c);
      }
      if (columns.size() > 1) {
        Fail(kAxes[i],
             "the columns '" + HeaderOf(columns[0]) + "' and '" + HeaderOf(columns[1]) + "' may both be the measured " +
                 kAxes[i],
             kMapHint);
      }
      if (!columns.empty()) found.push_back(columns[0]);
    }
    if (found.empty()) return false;
    if (found.size() < 3) FailMissing("only " + std::to_string(found.size()) + " of the measured x, y, z are found");
    CheckEqualUnits(found);
    for (int i = 0; i < 3; ++i) Add(kAxes[i], meanings_[found[i]].unit, found[i], std::string("measured ") + kAxes[i]);
    const std::string& name = table_.header[found[0]];
    if (!says_measured && name != "x_mm" && name != "x_m") {
      plan_.guesses.push_back("'" + name + "' and those like it are measured points: their names do not say so");
    }
    return true;
  }

  void CheckEqualUnits(const std::vector<int>& columns) const {
    for (const int c : columns) {
      const std::string& unit = meanings_[c].unit;
      if (!unit.empty() && !IsLengthUnit(unit)) Fail(HeaderOf(c), "a point in " + unit, kMapHint);
      if (unit != meanings_[columns[0]].unit) Fail(HeaderOf(c), "x, y and z are in different units", kMapHint);
    }
  }

  // Where targets and differences are stated and measured points are not. An error is measured minus nominal
  // (ISO 9283, "deviation"; VIM 2.16: measured value minus reference value).
  bool TakeTargetPlusDifference() {
    std::vector<int> targets, differences;
    for (int i = 0; i < 3; ++i) {
      const std::vector<int> target = ColumnsOf(Role::kTarget, i), difference = ColumnsOf(Role::kDifference, i);
      if (target.size() != 1 || difference.size() != 1) return false;
      targets.push_back(target[0]);
      differences.push_back(difference[0]);
    }
    CheckEqualUnits({targets[0], targets[1], targets[2], differences[0], differences[1], differences[2]});
    for (int i = 0; i < 3; ++i) {
      Add(kAxes[i], meanings_[targets[i]].unit, targets[i], std::string("measured ") + kAxes[i]);
      plan_.columns.back().second = differences[i];
      plan_.columns.back().header += " + " + HeaderOf(differences[i]);
      taken_.insert(differences[i]);
    }
    const std::string a = HeaderOf(targets[0]), b = HeaderOf(differences[0]);
    plan_.guesses.push_back("measured = '" + a + "' + '" + b +
                            "', the difference being measured minus target; --map=x_mm=" + a + "+" + b + " or " + a +
                            "-" + b + " says it");
    return true;
  }

  void TakePoints() {
    if (!(IsMapped("x") && IsMapped("y") && IsMapped("z")) && !TakeMeasured() && !TakeTargetPlusDifference()) {
      const std::string spherical = HintOfSphericalReadings(table_.header);
      FailMissing("no column says that it holds measured points (columns: " + Joined(table_.header) + ")",
                  spherical.empty() ? kMapHint : spherical);
    }
    std::vector<int> sigmas;
    for (int i = 0; i < 3; ++i) {
      const std::vector<int> columns = ColumnsOf(Role::kSigma, i);
      if (columns.size() == 1 && !IsMapped(std::string("sigma_") + kAxes[i])) sigmas.push_back(columns[0]);
    }
    if (sigmas.size() != 3) return;
    CheckEqualUnits(sigmas);
    if (meanings_[sigmas[0]].may_be_expanded)
      plan_.guesses.push_back("'" + HeaderOf(sigmas[0]) + "' is one standard deviation: the header does not say");
    for (int i = 0; i < 3; ++i)
      Add(std::string("sigma_") + kAxes[i], meanings_[sigmas[i]].unit, sigmas[i],
          std::string("standard deviation of ") + kAxes[i]);
  }

  // One column of each index, names that say measured first; empty where one is absent.
  std::vector<int> OneOfEach(Role role, int count) {
    bool says_measured = false;
    for (int i = 0; i < count; ++i) {
      for (const int c : ColumnsOf(role, i)) says_measured |= meanings_[c].says_measured;
    }
    std::vector<int> found;
    for (int i = 0; i < count; ++i) {
      std::vector<int> columns;
      for (const int c : ColumnsOf(role, i)) {
        if (!says_measured || meanings_[c].says_measured) columns.push_back(c);
      }
      if (columns.size() == 1) found.push_back(columns[0]);
    }
    if (static_cast<int>(found.size()) != count) found.clear();
    for (const int c : found) {
      if (meanings_[c].unit != meanings_[found[0]].unit) return {};
      if (!meanings_[c].unit.empty() && !IsAngleUnit(meanings_[c].unit)) return {};
    }
    return found;
  }

  void AddRotation(const std::string& stem, const std::string& unit, int c, const std::string& meaning) {
    Add(stem, unit, c, meaning);
    plan_.rotation_columns.push_back(plan_.columns.back());
    plan_.columns.pop_back();
  }

  // A quaternion says more than angles whose order is open. What stands alone, twice or in two units is left out.
  void TakeRotation() {
    if (plan_.rotation_is_mapped) return;
    const std::vector<int> parts = OneOfEach(Role::kQuaternion, 4);
    // "Rotation X, Y, Z, W": three of the four looked like angles.
    std::vector<int> angles = OneOfEach(Role::kRotation, 3);
    const std::vector<int> scalar = ColumnsOf(Role::kQuaternion, 0);
    if (parts.empty() && scalar.size() == 1 && angles.size() == 3 &&
        meanings_[angles[0]].says_measured == meanings_[scalar[0]].says_measured) {
      angles.insert(angles.begin(), scalar[0]);
    }
    const bool is_quaternion = !parts.empty() || angles.size() == 4;
    const std::vector<int>& columns = parts.empty() ? angles : parts;
    for (size_t i = 0; i < columns.size(); ++i) {
      const std::string axis(1, is_quaternion ? "wxyz"[i] : "xyz"[i]);
      AddRotation((is_quaternion ? "o" : "r") + axis, is_quaternion ? "1" : meanings_[columns[i]].unit, columns[i],
                  is_quaternion ? "quaternion " + axis : "rotation about " + axis);
    }
    if (columns.empty() || is_quaternion) return;
    const std::vector<int> sigmas = OneOfEach(Role::kAngleSigma, 3);
    for (size_t i = 0; i < sigmas.size(); ++i) {
      AddRotation(std::string("sigma_r") + kAxes[i], meanings_[sigmas[i]].unit, sigmas[i],
                  std::string("standard deviation of r") + kAxes[i]);
    }
  }

  // Of all joints or of none: the model's torque cannot stand in for one that is missing.
  void TakeTorques() {
    const int n = static_cast<int>(joints_.size());
    const int first = ColumnsOf(Role::kTorque, -1).empty() ? 0 : -1;
    std::vector<int> found;
    bool open = false, usable = true;
    for (int j = 0; j < n; ++j) {
      if (IsMapped("tau" + std::to_string(j + 1))) return;
      const std::vector<int> columns = ColumnsOf(Role::kTorque, j + first);
      if (columns.size() != 1) return;
      found.push_back(columns[0]);
      open |= meanings_[columns[0]].unit.empty();
      usable &= meanings_[columns[0]].unit.empty() ||
                meanings_[columns[0]].unit == TorqueUnit(joints_[static_cast<size_t>(j)]);
    }
    if (!usable) return;
    for (size_t j = 0; j < found.size(); ++j) {
      Add("tau" + std::to_string(j + 1), TorqueUnit(joints_[j]), found[j], "measured torque of " + joints_[j].name);
    }
    if (open) plan_.guesses.push_back("joint torques are in N m: the header does not say");
  }

  static bool IsComplete(const ImportPlan& plan) {
    return plan.Find("x") && plan.Find("y") && plan.Find("z") && plan.Find("q1");
  }

  bool CountsUp(int c) const {
    for (size_t r = 1; r < table_.rows.size(); ++r) {
      const auto a = table_.Number(table_.rows[r - 1].cells[c]), b = table_.Number(table_.rows[r].cells[c]);
      if (!a || !b || *b - *a != 1.0) return false;
    }
    return table_.rows.size() > 1;
  }

  // Joints before or after the point, with or without a running number in front; three angles or a quaternion may
  // follow the point.
  std::vector<ImportPlan> LayoutsWithoutHeader() {
    const int n = static_cast<int>(joints_.size()), points = n + 3, columns = table_.columns();
    const int first = columns > points && CountsUp(0) ? 1 : 0;
    const int turns = columns - points - first;
    if (turns != 0 && turns != 3 && turns != 4) {
      Fail("",
           "the table has no header and " + std::to_string(columns) +
               " columns; joints and x, y, z of this robot are " + std::to_string(points) +
               ", with three angles or a quaternion " + std::to_string(points + 3) + " or " +
               std::to_string(points + 4),
           kMapHint);
    }
    std::vector<ImportPlan> plans;
    for (const bool joints_first : {true, false}) {
      plan_ = ImportPlan();
      plan_.guesses = table_.guesses;
      taken_.clear();
      const int point = first + (joints_first ? n : 0);
      for (int j = 0; j < n; ++j)
        Add("q" + std::to_string(j + 1), "", first + (joints_first ? 0 : 3 + turns) + j, "joint " + joints_[j].name);
      for (int i = 0; i < 3; ++i) Add(kAxes[i], "", point + i, std::string("measured ") + kAxes[i]);
      for (int i = 0; i < turns; ++i) {
        const bool angles = turns == 3;
        AddRotation(std::string(angles ? "r" : "o") + (angles ? "xyz" : "wxyz")[i], angles ? "" : "1", point + 3 + i,
                    angles ? std::string("rotation about ") + kAxes[i] : "quaternion");
      }
      plan_.has_header = false;
      if (first == 1) plan_.unused.emplace_back("column 1", "a running number");
      const std::string measured = std::string("x, y, z") + (turns == 3   ? " and angles"
                                                             : turns == 4 ? " and a quaternion"
                                                                          : "");
      plan_.choice = joints_first ? "joints, then " + measured : measured + ", then joints";
      plan_.guesses.push_back("there is no header: the columns are " + plan_.choice);
      plans.push_back(plan_);
    }
    return plans;
  }

  const TextTable& table_;
  const std::vector<Joint>& joints_;
  const std::map<std::string, std::string>& mapped_;
  std::vector<ColumnMeaning> meanings_;
  std::set<int> taken_;
  bool both_joints_ = false;
  ImportPlan plan_;
};

}  // namespace

void ImportPlan::Add(const std::string& stem, const std::string& unit, int source, const std::string& header,
                     const std::string& meaning) {
  PlannedColumn planned;
  planned.stem = stem;
  planned.unit = unit;
  planned.source = source;
  planned.header = header;
  planned.meaning = meaning;
  columns.push_back(planned);
}

const PlannedColumn* ImportPlan::Find(const std::string& stem) const {
  for (const PlannedColumn& column : columns) {
    if (column.stem == stem) return &column;
  }
  return nullptr;
}

std::vector<ImportPlan> PossiblePlans(const TextTable& table, const std::vector<Joint>& joints,
                                      const std::map<std::string, std::string>& columns) {
  std::vector<ImportPlan> plans = Planner(table, joints, columns).Plans();
  NameMarkers(table, columns.count("marker") > 0, &plans);
  NamePoses(table, &plans);
  DecideTimes(table, &plans);
  return plans;
}

}  // namespace sagitta

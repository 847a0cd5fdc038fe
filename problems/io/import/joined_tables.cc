#include "problems/io/import/joined_tables.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "problems/input_error.h"
#include "problems/interruption.h"
#include "problems/io/files.h"
#include "problems/io/import/column_meaning.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr size_t kNamesInWords = 3;

bool SeparatesParts(unsigned char c) { return c < 0x80 && std::isalnum(c) == 0; }

// Of a name that holds more than that of the pose: what stands before one of its separators, behind one, or all.
enum class PoseNameAt { kWhole, kBefore, kBehind };

// The longest first, in small letters: of P_07_SMR2 {p_07, p}, {07_smr2, smr2}.
std::vector<std::string> NamesIn(const std::string& cell, PoseNameAt at) {
  const std::string name = LowerCaseOf(cell);
  if (at == PoseNameAt::kWhole) return {name};
  std::vector<std::string> parts;
  for (size_t i = 1; i + 1 < name.size(); ++i) {
    if (!SeparatesParts(static_cast<unsigned char>(name[i]))) continue;
    parts.push_back(at == PoseNameAt::kBefore ? name.substr(0, i) : name.substr(i + 1));
  }
  if (at == PoseNameAt::kBefore) std::reverse(parts.begin(), parts.end());
  return parts;
}

std::set<std::string> PartsOf(const std::string& cell) {
  std::set<std::string> parts;
  for (const PoseNameAt at : {PoseNameAt::kBefore, PoseNameAt::kBehind}) {
    for (const std::string& part : NamesIn(cell, at)) parts.insert(part);
  }
  return parts;
}

bool MayName(const ColumnMeaning& meaning) {
  return meaning.role == Role::kText || (meaning.role == Role::kOther && meaning.unit.empty());
}

struct MeantTable {
  TextTable table;
  std::vector<ColumnMeaning> meanings;

  bool Has(Role role) const {
    return std::any_of(meanings.begin(), meanings.end(), [role](const auto& each) { return each.role == role; });
  }
  // The same column of a table, by what it means.
  bool Has(const ColumnMeaning& other) const {
    return std::any_of(meanings.begin(), meanings.end(), [&](const ColumnMeaning& each) {
      return each.role == other.role && each.index == other.index && each.name == other.name;
    });
  }
  const std::string& Cell(size_t row, int column) const { return table.rows[row].cells[static_cast<size_t>(column)]; }
};

// A table of a name and three numbers without header.
void NameColumns(TextTable* table) {
  if (table->has_header() || table->columns() != 4 || table->rows.empty()) return;
  const std::vector<std::string>& cells = table->rows[0].cells;
  const bool are_points = !table->Number(cells[0]) && table->Number(cells[1]) && table->Number(cells[2]);
  if (!are_points || !table->Number(cells[3])) return;
  table->header = {"name", "x", "y", "z"};
  table->header_line = table->rows[0].line;
  table->guesses.push_back("there is no header: the columns are a name and x, y, z");
}

MeantTable Meant(TextTable table, const std::vector<Joint>& joints) {
  NameColumns(&table);
  MeantTable meant{std::move(table), {}};
  if (meant.table.has_header()) meant.meanings = MeaningsOf(meant.table.header, joints);
  return meant;
}

// A column of x, y, z to fill in is no point.
bool HoldsPoints(const MeantTable& meant) {
  for (int c = 0; c < static_cast<int>(meant.meanings.size()); ++c) {
    const Role role = meant.meanings[c].role;
    if (role != Role::kPoint && role != Role::kDifference) continue;
    for (size_t r = 0; r < meant.table.rows.size(); ++r) {
      if (!IsLostCell(meant.Cell(r, c))) return true;
    }
  }
  return false;
}

// Which rows of a list of poses have a name, where all of one name have the same joint values.
using RowsOfName = std::map<std::string, std::vector<size_t>>;

std::string JointsOf(const MeantTable& poses, size_t row) {
  std::string values;
  for (int c = 0; c < static_cast<int>(poses.meanings.size()); ++c) {
    if (poses.meanings[c].role == Role::kJoint) values += poses.Cell(row, c) + ";";
  }
  return values;
}

std::optional<RowsOfName> NamesIn(const MeantTable& poses, int column) {
  if (!MayName(poses.meanings[column])) return std::nullopt;
  RowsOfName rows;
  for (size_t r = 0; r < poses.table.rows.size(); ++r) {
    const std::string name = LowerCaseOf(poses.Cell(r, column));
    if (name.empty()) return std::nullopt;
    std::vector<size_t>& own = rows[name];
    if (!own.empty() && JointsOf(poses, own[0]) != JointsOf(poses, r)) return std::nullopt;
    own.push_back(r);
  }
  return rows;
}

// By which columns a table's rows find their poses.
struct Join {
  int column = -1;  // of the readings
  int pose_column = -1;
  PoseNameAt at = PoseNameAt::kWhole;
  RowsOfName rows;
  size_t found = 0;  // readings that have a pose
  size_t poses = 0;  // that have a reading: a marker's number may be a pose's, too, but is that of few

  bool IsBetterThan(const Join& other) const {
    return found != other.found ? found > other.found : poses > other.poses;
  }
  const std::vector<size_t>* Find(const std::string& cell) const {
    for (const std::string& name : NamesIn(cell, at)) {
      const auto known = rows.find(name);
      if (known != rows.end()) return &known->second;
    }
    return nullptr;
  }
};

Join BestJoin(const MeantTable& readings, const MeantTable& poses) {
  Join best;
  for (int p = 0; p < poses.table.columns(); ++p) {
    const std::optional<RowsOfName> rows = NamesIn(poses, p);
    if (!rows) continue;
    for (int c = 0; c < readings.table.columns(); ++c) {
      if (!MayName(readings.meanings[c])) continue;
      for (const PoseNameAt at : {PoseNameAt::kWhole, PoseNameAt::kBefore, PoseNameAt::kBehind}) {
        CheckInterruption();
        Join join{c, p, at, *rows};
        std::set<const std::vector<size_t>*> found;
        for (size_t r = 0; r < readings.table.rows.size(); ++r) {
          const std::vector<size_t>* pose = join.Find(readings.Cell(r, c));
          if (pose == nullptr) continue;
          ++join.found;
          found.insert(pose);
        }
        join.poses = found.size();
        if (join.IsBetterThan(best)) best = join;
      }
    }
  }
  return best;
}

// The readings with the columns of the list of poses that they do not have.
class Joiner {
 public:
  Joiner(const MeantTable& readings, const MeantTable& poses) : readings_(readings), poses_(poses) {}

  TextTable ByName(const Join& join) {
    TextTable joined = WithHeader(join.pose_column);
    std::vector<std::string> left_out;
    for (size_t r = 0; r < readings_.table.rows.size(); ++r) {
      const std::string& name = readings_.Cell(r, join.column);
      const std::vector<size_t>* rows = join.Find(name);
      if (rows) joined.rows.push_back(Joined(r, Rows(r, name, *rows)));
      if (!rows) left_out.push_back("'" + name + "'");
    }
    joined.joined_with = "'" + readings_.table.header[join.column] + "' names the poses of " + poses_.table.path +
                         ", where the joint values are";
    if (!left_out.empty()) {
      joined.guesses.push_back("no pose of " + poses_.table.path + " has the name of " +
                               std::to_string(left_out.size()) +
                               " readings, which are left out: " + Enumerate(left_out, kNamesInWords));
    }
    return joined;
  }

  TextTable ByOrder() {
    TextTable joined = WithHeader(-1);
    for (size_t r = 0; r < readings_.table.rows.size(); ++r) joined.rows.push_back(Joined(r, {r}));
    joined.joined_with = "joint values of " + poses_.table.path + ", row by row";
    joined.guesses.push_back("no name joins the readings with " + poses_.table.path +
                             ": its rows are in the same order, as many as there are readings");
    return joined;
  }

 private:
  // Columns of the poses that are added; the name of the pose is the configuration's.
  TextTable WithHeader(int pose_name) {
    TextTable joined = readings_.table;
    joined.rows.clear();
    ColumnMeaning config;
    config.role = Role::kText, config.name = "config";
    for (int c = 0; c < poses_.table.columns(); ++c) {
      const ColumnMeaning& meaning = poses_.meanings[c];
      const bool is_name = c == pose_name && meaning.role == Role::kOther && !readings_.Has(config);
      if (!is_name && (meaning.role == Role::kOther || meaning.role == Role::kPoint || readings_.Has(meaning)))
        continue;
      added_.push_back(c);
      joined.header.push_back(is_name ? config.name : poses_.table.header[c]);
    }
    return joined;
  }

  // Of the rows of one pose those that the reading can be of: what else it states, or what else its name holds.
  std::vector<size_t> Rows(size_t reading, const std::string& name, std::vector<size_t> rows) const {
    const std::set<std::string> parts = PartsOf(name);
    for (int c = 0; c < poses_.table.columns(); ++c) {
      const ColumnMeaning& meaning = poses_.meanings[c];
      if (meaning.role != Role::kText) continue;
      std::vector<size_t> kept;
      std::copy_if(rows.begin(), rows.end(), std::back_inserter(kept), [&](size_t row) {
        const std::string value = LowerCaseOf(poses_.Cell(row, c));
        return parts.count(value) > 0 || Stated(reading, meaning) == value;
      });
      if (!kept.empty()) rows = kept;
    }
    return rows;
  }

  std::string Stated(size_t reading, const ColumnMeaning& meaning) const {
    for (int c = 0; c < static_cast<int>(readings_.meanings.size()); ++c) {
      const ColumnMeaning& own = readings_.meanings[c];
      if (own.role == meaning.role && own.name == meaning.name) return LowerCaseOf(readings_.Cell(reading, c));
    }
    return "";
  }

  TextTable::Row Joined(size_t reading, const std::vector<size_t>& rows) const {
    TextTable::Row row = readings_.table.rows[reading];
    for (const int c : added_) {
      std::string cell = poses_.Cell(rows[0], c);
      for (const size_t other : rows) {
        if (poses_.Cell(other, c) == cell) continue;
        // What says it may be a column of the readings that the points decide.
        if (poses_.meanings[c].name == "marker") cell.clear();
        if (!cell.empty()) FailSeveral(row, c, cell, poses_.Cell(other, c));
        break;
      }
      row.cells.push_back(WithOwnDecimals(cell));
    }
    return row;
  }

  std::string WithOwnDecimals(const std::string& cell) const {
    if (poses_.table.decimal_comma == readings_.table.decimal_comma) return cell;
    const std::optional<double> number = poses_.table.Number(cell);
    if (!number) return cell;
    std::string text = FormatNumber(*number);
    if (readings_.table.decimal_comma) std::replace(text.begin(), text.end(), '.', ',');
    return text;
  }

  [[noreturn]] void FailSeveral(const TextTable::Row& row, int column, const std::string& one,
                                const std::string& other) const {
    throw InputError(
        {readings_.table.path, row.line, poses_.table.header[column]},
        "the pose of this reading stands in " + poses_.table.path + " with '" + one + "' and with '" + other + "'",
        "a column '" + poses_.table.header[column] + "' of the readings, or names that hold it, say which");
  }

  const MeantTable& readings_;
  const MeantTable& poses_;
  std::vector<int> added_;
};

[[noreturn]] void FailToJoin(const MeantTable& readings, const MeantTable& poses) {
  std::vector<std::string> names;
  for (int c = 0; c < poses.table.columns() && names.empty(); ++c) {
    if (!NamesIn(poses, c)) continue;
    for (const TextTable::Row& row : poses.table.rows) names.push_back("'" + row.cells[static_cast<size_t>(c)] + "'");
  }
  throw InputError({readings.table.path, readings.table.header_line, ""},
                   "there are no joint values, and no column names the poses of " + poses.table.path +
                       (names.empty() ? "" : " (" + Enumerate(names, kNamesInWords) + ")"),
                   "a column of the poses' names, as in plan7 or plan7_M1; or as many rows in the same order");
}

TextTable Joined(const MeantTable& readings, const std::vector<MeantTable>& lists) {
  Join best;
  const MeantTable* of = &lists[0];
  for (const MeantTable& poses : lists) {
    const Join join = BestJoin(readings, poses);
    if (join.IsBetterThan(best)) best = join, of = &poses;
  }
  const size_t rows = readings.table.rows.size();
  if (2 * best.found >= rows && rows > 0) return Joiner(readings, *of).ByName(best);
  if (lists.size() == 1 && rows == of->table.rows.size()) return Joiner(readings, *of).ByOrder();
  FailToJoin(readings, *of);
}

}  // namespace

std::vector<TextTable> JoinPosesByName(std::vector<TextTable> tables, const std::vector<Joint>& joints) {
  std::vector<MeantTable> all, lists;
  for (const TextTable& table : tables) all.push_back(Meant(table, joints));
  const auto has_points_alone = [](const MeantTable& each) { return HoldsPoints(each) && !each.Has(Role::kJoint); };
  for (const MeantTable& each : all) {
    if (each.Has(Role::kJoint) && !HoldsPoints(each)) lists.push_back(each);
  }
  if (lists.empty() || std::none_of(all.begin(), all.end(), has_points_alone)) return tables;
  std::vector<TextTable> joined;
  for (const MeantTable& each : all) {
    if (has_points_alone(each)) joined.push_back(Joined(each, lists));
    if (HoldsPoints(each) && each.Has(Role::kJoint)) joined.push_back(each.table);
  }
  return joined;
}

}  // namespace sagitta

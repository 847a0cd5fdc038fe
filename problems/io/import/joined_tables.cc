#include "problems/io/import/joined_tables.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <tuple>

#include "problems/input_error.h"
#include "problems/interruption.h"
#include "problems/io/import/column_meaning.h"
#include "problems/io/import/meant_table.h"
#include "problems/io/import/other_columns.h"
#include "problems/io/import/pose_names.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr size_t kNamesInWords = 3;
constexpr const char* kMarkerColumn = "marker";

// Which rows of a list of poses have a name, where all of one name have the same joint values.
using RowsOfName = std::map<std::string, std::vector<size_t>>;

std::string JointsOf(const MeantTable& poses, size_t row) {
  std::string values;
  for (int c = 0; c < static_cast<int>(poses.meanings.size()); ++c) {
    if (poses.meanings[c].role == Role::kJoint) values += poses.Cell(row, c) + ";";
  }
  return values;
}

std::optional<RowsOfName> RowsOfNames(const MeantTable& poses, int column, bool as_written = false) {
  if (!MayName(poses.meanings[column])) return std::nullopt;
  RowsOfName rows;
  for (size_t r = 0; r < poses.table.rows.size(); ++r) {
    const std::string name = Plain(poses.Cell(r, column), as_written);
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
  bool as_written = false;
  std::shared_ptr<const RowsOfName> rows;
  size_t found = 0;  // readings that have a pose
  size_t poses = 0;  // that have a reading: a marker's number may be a pose's, too, but is that of few

  bool is_same = false;  // both columns have one meaning or header
  bool is_text = false;  // a name says more than a number, which may only count rows

  auto Rank() const { return std::tie(found, poses, is_text, is_same); }
  bool IsBetterThan(const Join& other) const { return Rank() > other.Rank(); }
  const std::vector<size_t>* Find(const std::string& cell, std::string* rest = nullptr) const {
    for (const NameInCell& part : NamesIn(cell, at, as_written)) {
      const auto known = rows->find(part.name);
      if (known == rows->end()) continue;
      if (rest != nullptr) *rest = part.rest;
      return &known->second;
    }
    return nullptr;
  }
};

bool AreSame(const MeantTable& readings, int column, const MeantTable& poses, int pose_column) {
  const ColumnMeaning &a = readings.meanings[column], &b = poses.meanings[pose_column];
  if (a.role == Role::kText && b.role == Role::kText) return a.name == b.name;
  return Plain(readings.table.header[column]) == Plain(poses.table.header[pose_column]);
}

// Two columns that name poses as well, and not the same ones.
void RefuseContradiction(const MeantTable& readings, const MeantTable& poses, const Join& one, const Join& other) {
  for (size_t r = 0; r < readings.table.rows.size(); ++r) {
    const std::vector<size_t>* a = one.Find(readings.Cell(r, one.column));
    const std::vector<size_t>* b = other.Find(readings.Cell(r, other.column));
    if (a == nullptr || b == nullptr || JointsOf(poses, a->front()) == JointsOf(poses, b->front())) continue;
    throw InputError({readings.table.path, readings.table.rows[r].line, readings.table.header[other.column]},
                     "this column names another pose of " + poses.table.path + " than '" +
                         readings.table.header[one.column] + "' does",
                     "leave out the one that counts rows");
  }
}

Join BestJoin(const MeantTable& readings, const MeantTable& poses) {
  Join best;
  std::vector<Join> rivals;
  for (int p = 0; p < poses.table.columns(); ++p) {
    std::optional<RowsOfName> rows = RowsOfNames(poses, p);
    const bool as_written = !rows;  // a1 and A1 are two
    if (as_written) rows = RowsOfNames(poses, p, true);
    if (!rows) continue;
    const auto shared = std::make_shared<const RowsOfName>(std::move(*rows));
    for (int c = 0; c < readings.table.columns(); ++c) {
      if (!MayName(readings.meanings[c])) continue;
      for (const PoseNameAt at : {PoseNameAt::kWhole, PoseNameAt::kBefore, PoseNameAt::kBehind, PoseNameAt::kWithin}) {
        CheckInterruption();
        Join join{c, p, at, as_written, shared};
        std::set<const std::vector<size_t>*> found;
        for (size_t r = 0; r < readings.table.rows.size(); ++r) {
          const std::vector<size_t>* pose = join.Find(readings.Cell(r, c));
          if (pose == nullptr) continue;
          ++join.found;
          found.insert(pose);
        }
        join.poses = found.size();
        join.is_text = !readings.table.Number(readings.Cell(0, c));
        join.is_same = AreSame(readings, c, poses, p);
        if (join.IsBetterThan(best)) rivals.clear(), best = join;
        if (join.found > 0 && join.column != best.column && join.Rank() == best.Rank()) rivals.push_back(join);
      }
    }
  }
  for (const Join& rival : rivals) RefuseContradiction(readings, poses, best, rival);
  return best;
}

// A column of texts of the list: as they are compared, by row, and the first row of each.
struct Texts {
  int column;
  std::vector<std::string> plain;
  std::map<std::string, size_t> first;
};

// The readings with the columns of the list of poses that they do not have.
class Joiner {
 public:
  Joiner(const MeantTable& readings, const MeantTable& poses) : readings_(readings), poses_(poses) {
    for (int c = 0; c < poses_.table.columns(); ++c) {
      if (poses_.meanings[c].role != Role::kText) continue;
      Texts texts{c, {}, {}};
      for (size_t row = 0; row < poses_.table.rows.size(); ++row) {
        texts.plain.push_back(Plain(poses_.Cell(row, c)));
        texts.first.emplace(texts.plain.back(), row);
      }
      texts_.push_back(std::move(texts));
    }
  }

  TextTable ByName(const Join& join) {
    TextTable joined = WithHeader(join.pose_column);
    std::vector<std::string> left_out;
    const std::map<std::string, size_t> rests = RestsOfNames(join);
    const bool are_whole = rests.count("") > 0 && 2 * rests.at("") >= join.found;
    for (size_t r = 0; r < readings_.table.rows.size(); ++r) {
      const std::string& name = readings_.Cell(r, join.column);
      std::string rest;
      const std::vector<size_t>* rows = join.Find(name, &rest);
      if (rows && are_whole && 2 * rests.at(rest) < join.poses && !IsKnown(rest))
        rows = nullptr;  // REF_1 is not pose 1
      if (rows) joined.rows.push_back(Joined(r, Rows(r, rest, join.pose_column, *rows)));
      if (!rows) left_out.push_back("'" + name + "'");
    }
    DropOpenMarkers(&joined);
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
    joined.joined_in_order = true;
    joined.guesses.push_back("no name joins the readings with " + poses_.table.path +
                             ": its rows are in the same order, as many as there are readings");
    return joined;
  }

 private:
  // What the names of readings hold next to a pose's, and how often.
  std::map<std::string, size_t> RestsOfNames(const Join& join) const {
    std::map<std::string, size_t> rests;
    for (size_t r = 0; r < readings_.table.rows.size(); ++r) {
      std::string rest;
      if (join.Find(readings_.Cell(r, join.column), &rest) != nullptr) ++rests[rest];
    }
    return rests;
  }

  // What a name may hold next to the pose's: the number of a repeat, or what the list states of a pose.
  bool IsKnown(const std::string& rest) const {
    const auto is_letter = [](unsigned char c) { return c >= 0x80 || std::isalpha(c) != 0; };
    if (std::none_of(rest.begin(), rest.end(), is_letter)) return true;
    for (const std::string& piece : PiecesOf(rest)) {
      for (const Texts& texts : texts_) {
        if (texts.first.count(piece) > 0) return true;
      }
    }
    return false;
  }

  // A plan's times and temperatures are those that it was made for: the readings have their own.
  static bool IsAssumed(const ColumnMeaning& meaning) {
    return !meaning.is_mapped && (meaning.role == Role::kTime || meaning.role == Role::kTemperature);
  }

  // Columns of the poses that are added; the name of the pose is the configuration's.
  TextTable WithHeader(int pose_name) {
    TextTable joined = readings_.table;
    joined.rows.clear();
    ColumnMeaning config;
    config.role = Role::kText, config.name = "config";
    for (int c = 0; c < poses_.table.columns(); ++c) {
      const ColumnMeaning& meaning = poses_.meanings[c];
      const bool is_name = c == pose_name && meaning.role == Role::kOther && readings_.Find(config) < 0;
      const bool is_left_out = meaning.role == Role::kOther || IsOfPoint(meaning.role) || IsAssumed(meaning);
      if (!is_name && (is_left_out || readings_.Find(meaning) >= 0)) {
        if (c != pose_name) LeaveOut(c, &joined);
        continue;
      }
      added_.push_back(c);
      joined.header.push_back(is_name ? config.name : poses_.table.header[c]);
    }
    return joined;
  }

  void LeaveOut(int c, TextTable* joined) const {
    const ColumnMeaning& meaning = poses_.meanings[c];
    TextTable::NotJoined column;
    column.header = HeaderOfColumn(poses_.table, c);
    column.why = IsOfPoint(meaning.role) && meaning.why.empty() ? "not measured" : "the readings have such a column";
    if (IsAssumed(meaning) && readings_.Find(meaning) < 0) {
      const char* map = meaning.role == Role::kTime ? "time_s" : "temperature_degC";
      column.why = std::string("of the list and not of the readings, planned perhaps; --map=") + map + "=" +
                   column.header + " uses it";
    }
    if (meaning.role == Role::kOther || !meaning.why.empty()) {
      column.why = WhyNotUsed(poses_.table, c, meaning, &column.moved);
    }
    column.why += " (" + poses_.table.path + ")";
    joined->not_joined.push_back(column);
  }

  // A column of markers that neither names nor readings state: another column may, as the points decide.
  void DropOpenMarkers(TextTable* joined) const {
    for (size_t k = 0; k < added_.size(); ++k) {
      if (poses_.meanings[added_[k]].name != kMarkerColumn) continue;
      const auto at = static_cast<long>(readings_.table.header.size() + k);
      const auto open = [at](const TextTable::Row& row) { return row.cells[static_cast<size_t>(at)].empty(); };
      const auto first = std::find_if(joined->rows.begin(), joined->rows.end(), open);
      if (first == joined->rows.end()) return;
      if (!std::all_of(first, joined->rows.end(), open) || first != joined->rows.begin()) {
        throw InputError({readings_.table.path, first->line, kMarkerColumn},
                         "names say the marker of some readings, and not of this one",
                         "a column 'marker' of the readings, or names that hold it, say which");
      }
      joined->header.erase(joined->header.begin() + at);
      for (TextTable::Row& row : joined->rows) row.cells.erase(row.cells.begin() + at);
      return;
    }
  }

  // Of the rows of one pose those that the reading can be of: what else it states, or what else its name holds. What
  // that names and no row of the pose has is another pose, or a slip.
  std::vector<size_t> Rows(size_t reading, const std::string& rest, int pose_column, std::vector<size_t> rows) const {
    const std::set<std::string> pieces = PiecesOf(rest);
    for (const Texts& texts : texts_) {
      if (texts.column == pose_column) continue;
      const int own = readings_.Find(poses_.meanings[texts.column]);
      std::set<std::string> said = pieces;
      if (own >= 0) said.insert(Plain(readings_.Cell(reading, own)));
      std::vector<size_t> kept;
      std::copy_if(rows.begin(), rows.end(), std::back_inserter(kept),
                   [&](size_t row) { return said.count(texts.plain[row]) > 0; });
      if (kept.empty() && !rest.empty()) RefuseOther(reading, texts, said);
      if (!kept.empty()) rows = kept;
    }
    return rows;
  }

  TextTable::Row Joined(size_t reading, const std::vector<size_t>& rows) const {
    TextTable::Row row = readings_.table.rows[reading];
    Respell(rows[0], &row);
    for (const int c : added_) {
      std::string cell = poses_.Cell(rows[0], c);
      for (const size_t other : rows) {
        if (poses_.Cell(other, c) == cell) continue;
        // What says it may be a column of the readings that the points decide.
        if (poses_.meanings[c].name == kMarkerColumn) cell.clear();
        if (!cell.empty()) FailSeveral(row, c, cell, poses_.Cell(other, c));
        break;
      }
      row.cells.push_back(WithOwnDecimals(cell));
    }
    return row;
  }

  // Texts that both state are written as the list has them: PLAN7 is plan7, l50 L50.
  void Respell(size_t pose, TextTable::Row* row) const {
    for (const Texts& texts : texts_) {
      const int own = readings_.Find(poses_.meanings[texts.column]);
      if (own < 0) continue;
      std::string& cell = row->cells[static_cast<size_t>(own)];
      if (Plain(cell) == texts.plain[pose]) cell = poses_.Cell(pose, texts.column);
    }
  }

  std::string WithOwnDecimals(const std::string& cell) const {
    if (poses_.table.decimal_comma == readings_.table.decimal_comma) return cell;
    const std::optional<double> number = poses_.table.Number(cell);
    if (!number) return cell;
    std::string text = FormatNumber(*number);
    if (readings_.table.decimal_comma) std::replace(text.begin(), text.end(), '.', ',');
    return text;
  }

  // What is said of a pose and is a value of the column, but of other poses.
  void RefuseOther(size_t reading, const Texts& texts, const std::set<std::string>& said) const {
    const auto known =
        std::find_if(said.begin(), said.end(), [&](const auto& each) { return texts.first.count(each); });
    if (known == said.end()) return;
    throw InputError({readings_.table.path, readings_.table.rows[reading].line, poses_.table.header[texts.column]},
                     "the name of this reading says '" + poses_.Cell(texts.first.at(*known), texts.column) +
                         "', with which its pose does not stand in " + poses_.table.path,
                     "correct the name, or the list");
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
  std::vector<Texts> texts_;
  std::vector<int> added_;
};

[[noreturn]] void FailToJoin(const MeantTable& readings, const MeantTable& poses) {
  std::vector<std::string> names;
  for (int c = 0; c < poses.table.columns() && names.empty(); ++c) {
    if (!RowsOfNames(poses, c)) continue;
    for (const TextTable::Row& row : poses.table.rows) names.push_back("'" + row.cells[static_cast<size_t>(c)] + "'");
  }
  throw InputError({readings.table.path, readings.table.header_line, ""},
                   "there are no joint values, and no column names the poses of " + poses.table.path +
                       (names.empty() ? "" : " (" + Enumerate(names, kNamesInWords) + ")") + "; there are " +
                       std::to_string(readings.table.rows.size()) + " readings and " +
                       std::to_string(poses.table.rows.size()) + " poses",
                   "a column of the poses' names, as in plan7 or plan7_M1; or as many rows in the same order");
}

// Names that hold the number of something else where a pose's would stand, as in P2_7 of the second marker: all
// readings are of a few poses, and each of these has as many as if all were.
void RefuseFewPoses(const MeantTable& readings, const MeantTable& poses, const Join& join) {
  constexpr size_t kFewPoses = 3;  // a third of the list
  const size_t listed = join.rows == nullptr ? 0 : join.rows->size();
  if (kFewPoses * join.poses > listed || join.found < listed) return;
  std::set<std::string> rests;  // as many as there are poses; of repeats there are few
  for (size_t r = 0; r < readings.table.rows.size(); ++r) {
    std::string rest;
    if (join.Find(readings.Cell(r, join.column), &rest) != nullptr) rests.insert(rest);
  }
  if (2 * rests.size() < listed) return;
  std::vector<std::string> names;
  for (size_t r = 0; r < readings.table.rows.size() && names.size() < join.poses; ++r) {
    const std::vector<size_t>* rows = join.Find(readings.Cell(r, join.column));
    const std::string name = rows == nullptr ? "" : "'" + poses.Cell(rows->front(), join.pose_column) + "'";
    if (rows != nullptr && std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  throw InputError({readings.table.path, readings.table.header_line, readings.table.header[join.column]},
                   "of the " + std::to_string(listed) + " poses of " + poses.table.path + " these names, such as '" +
                       readings.Cell(0, join.column) + "', are of " + std::to_string(join.poses) +
                       " only: " + Enumerate(names, kNamesInWords),
                   "names that hold the pose's own name, as in plan7_M2, where a marker or station has another one");
}

TextTable Joined(const MeantTable& readings, const MeantTable& poses) {
  const Join join = BestJoin(readings, poses);
  const size_t rows = readings.table.rows.size();
  if (3 * join.found >= 2 * rows && rows > 0) {
    RefuseFewPoses(readings, poses, join);
    return Joiner(readings, poses).ByName(join);
  }
  if (rows == poses.table.rows.size()) return Joiner(readings, poses).ByOrder();
  FailToJoin(readings, poses);
}

// Lists of the same columns as one. A name that stands in both has the same joint values: else nothing says which are
// those that were driven to.
MeantTable OneList(const std::vector<MeantTable>& lists) {
  MeantTable all = lists[0];
  for (size_t i = 1; i < lists.size(); ++i) {
    const TextTable& next = lists[i].table;
    if (next.header != all.table.header || next.decimal_comma != all.table.decimal_comma) {
      throw InputError({next.path, next.header_line, ""},
                       "this is a second list of poses, with other columns than " + lists[0].table.path,
                       "give one list, or several with the same columns");
    }
    const MeantTable before = all;
    all.table.rows.insert(all.table.rows.end(), next.rows.begin(), next.rows.end());
    for (int c = 0; c < next.columns(); ++c) {
      if (!RowsOfNames(before, c) || !RowsOfNames(lists[i], c) || RowsOfNames(all, c)) continue;
      throw InputError({next.path, 0, next.header[c]},
                       "poses of one name have other joint values here than in " + lists[0].table.path,
                       "give the list of the commanded values or of the actual ones, not both");
    }
  }
  return all;
}

// Nothing to join the lists with: the table that should have the points, and why it has none.
[[noreturn]] void FailWithoutPoints(const MeantTable& other, const MeantTable& list) {
  const std::string spherical = HintOfSphericalReadings(other.table.header);
  throw InputError({other.table.path, other.table.header_line, ""},
                   "no column says that it holds measured points; the joint values are in " + list.table.path,
                   spherical.empty()
                       ? "a header with X, Y, Z above the numbers, or rows of one name and three numbers; "
                         "of other headers --map=x_mm=HEADER,y_mm=HEADER,z_mm=HEADER (x_m where the "
                         "numbers are in m)"
                       : spherical);
}

}  // namespace

std::vector<TextTable> JoinPosesByName(std::vector<TextTable> tables, const std::vector<Joint>& joints,
                                       const std::map<std::string, std::string>& columns) {
  std::vector<MeantTable> all, lists, points, others, both;
  for (const TextTable& table : tables) all.push_back(Meant(table, joints, columns));
  CheckMappedHeaders(all, columns);
  for (const MeantTable& meant : all) {
    const bool has_joints = meant.Has(Role::kJoint), has_points = HoldsPoints(meant);
    (has_joints ? (has_points ? both : lists) : has_points ? points : others).push_back(meant);
  }
  if (lists.empty() && !points.empty()) lists.swap(both);  // what they say of points is not measured
  if (lists.empty() || (points.empty() && others.empty())) return tables;
  if (points.empty()) FailWithoutPoints(others[0], lists[0]);
  const MeantTable poses = OneList(lists);
  std::vector<TextTable> joined;
  for (const MeantTable& each : points) {
    joined.push_back(Joined(each, poses));
    if (!HoldsPoints(poses)) continue;
    joined.back().guesses.push_back("x, y, z of " + poses.table.path + " are not measured: the points are in " +
                                    each.table.path);
  }
  for (const MeantTable& each : both) joined.push_back(each.table);
  return joined;
}

}  // namespace sagitta

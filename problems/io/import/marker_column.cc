#include "problems/io/import/marker_column.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string_view>

#include "models/quantiles.h"
#include "problems/interruption.h"
#include "problems/io/import/column_meaning.h"
#include "problems/io/import/header_words.h"
#include "problems/io/import/pose_names.h"

namespace sagitta {
namespace {

// Rows of one marker lie within noise, of several apart: by half a percent of the reach at least, beyond which no arm
// is calibrated (SuspiciousMisfit), and a cloud of points is at most two reaches across.
constexpr double kApart = 0.005 / 2;
constexpr double kNearer = 0.2;  // rows of one marker are so much nearer to each other than those of all

using Point = std::array<double, 3>;
using Label = std::function<std::string(size_t)>;  // of a row

// The box around points; its diagonal is between the largest distance of two and the square root of 3 times that.
class Box {
 public:
  void Add(const Point& p) {
    for (size_t i = 0; i < 3; ++i) {
      low_[i] = empty_ ? p[i] : std::min(low_[i], p[i]);
      high_[i] = empty_ ? p[i] : std::max(high_[i], p[i]);
    }
    empty_ = false;
  }
  double Diagonal() const {
    double squared = 0.0;
    for (size_t i = 0; i < 3; ++i) squared += (high_[i] - low_[i]) * (high_[i] - low_[i]);
    return std::sqrt(squared);
  }

 private:
  Point low_{}, high_{};
  bool empty_ = true;
};

// Joint values as the row states them.
std::string JointsOf(const ImportPlan& plan, const TextTable::Row& row) {
  std::string joints;
  for (const PlannedColumn& column : plan.columns) {
    if (column.stem[0] == 'q') joints += row.cells[static_cast<size_t>(column.source)] + ";";
  }
  return joints;
}

class Poses {
 public:
  Poses(const TextTable& table, const ImportPlan& plan)
      : table_(table), points_(table.rows.size()), arm_(table.rows.size()) {
    std::map<std::string, int> arms;
    for (size_t r = 0; r < table.rows.size(); ++r) {
      CheckInterruption();
      Point point{};
      std::string key;
      if (!Read(plan, table.rows[r], &point, &key)) continue;
      arm_[r] = arms.emplace(JointsOf(plan, table.rows[r]), static_cast<int>(arms.size())).first->second;
      points_[r] = point;
      read_.push_back(r);
      all_.Add(point);
      rows_of_[key].push_back(r);
    }
  }

  const std::map<std::string, std::vector<size_t>>& rows_of() const { return rows_of_; }
  double Extent() const { return all_.Diagonal(); }

  // The median over the poses of how far the rows lie apart that have one label.
  double Spread(const Label& label) const {
    std::vector<double> spreads;
    for (const auto& [key, rows] : rows_of_) {
      if (rows.size() > 1) spreads.push_back(SpreadOf(rows, label));
    }
    return Median(std::move(spreads));
  }

  double SpreadOf(const std::vector<size_t>& rows, const Label& label) const {
    std::map<std::string, Box> boxes;
    for (const size_t r : rows) boxes[label(r)].Add(points_[r]);
    double largest = 0.0;
    for (const auto& [name, box] : boxes) largest = std::max(largest, box.Diagonal());
    return largest;
  }

  // A marker is seen at more than one pose: a name that recurs with another load alone is that of a pose.
  bool Recurs(const Label& label) const {
    std::set<std::string> labels;
    std::set<std::pair<std::string, int>> seen;
    for (const size_t r : read_) {
      labels.insert(label(r));
      seen.emplace(label(r), arm_[r]);
    }
    return seen.size() >= 2 * labels.size();
  }

 private:
  // False: a reading that is lost.
  bool Read(const ImportPlan& plan, const TextTable::Row& row, Point* point, std::string* key) const {
    for (const PlannedColumn& column : plan.columns) {
      const std::string& cell = row.cells[static_cast<size_t>(column.source)];
      if (IsOfPose(column)) *key += column.stem + "=" + cell + ";";
      if (column.stem.size() != 1) continue;
      const std::optional<double> number = table_.Number(cell);
      const std::optional<double> second =
          column.second < 0 ? 0.0 : table_.Number(row.cells[static_cast<size_t>(column.second)]);
      if (IsLostCell(cell) || !number || !second) return false;
      (*point)[static_cast<size_t>(column.stem[0] - 'x')] = *number + column.sign * *second;
    }
    return std::any_of(point->begin(), point->end(), [](double x) { return x != 0.0; });
  }

  const TextTable& table_;
  std::vector<Point> points_;  // by row
  std::vector<int> arm_;       // the same where the joint values are
  std::vector<size_t> read_;   // rows that are no lost reading
  std::map<std::string, std::vector<size_t>> rows_of_;
  Box all_;
};

// Headers of columns that name points, of which a marker is one.
bool NamesPoints(const std::string& header) {
  static const std::set<std::string> kPoints = {"point",  "pointname", "punkt", "punktname", "messpunkt",
                                                "target", "ziel",      "marke", "zielmarke"};
  static const std::set<std::string> kAround = {"name", "id", "nr", "no", "number"};
  const std::vector<std::string> words = WordsOf(StemOf(header));
  const auto is_point = [](const std::string& word) { return kPoints.count(word) > 0; };
  return std::any_of(words.begin(), words.end(), is_point) &&
         std::all_of(words.begin(), words.end(),
                     [&](const std::string& word) { return is_point(word) || kAround.count(word) > 0; });
}

bool IsText(const TextTable& table, int column) {
  return std::any_of(table.rows.begin(), table.rows.end(), [&](const TextTable::Row& row) {
    const std::string& cell = row.cells[static_cast<size_t>(column)];
    return !IsLostCell(cell) && !table.Number(cell);
  });
}

// Names that recur need no other part.
bool HoldsFewNames(const TextTable& table, int column) {
  std::set<std::string_view> names;
  for (const TextTable::Row& row : table.rows) names.insert(row.cells[static_cast<size_t>(column)]);
  return table.rows.size() >= 2 * names.size();
}

// Columns that may name markers, those first whose headers name points.
std::vector<int> Candidates(const TextTable& table, const ImportPlan& plan) {
  std::set<int> used;
  for (const auto* columns : {&plan.columns, &plan.rotation_columns}) {
    for (const PlannedColumn& column : *columns) used.insert({column.source, column.second});
  }
  std::vector<int> candidates;
  for (int c = 0; c < table.columns(); ++c) {
    const std::string& header = table.header[static_cast<size_t>(c)];
    const ColumnMeaning meaning = MeaningOf(header, {});
    if (used.count(c) > 0 || meaning.role != Role::kOther || !meaning.unit.empty()) continue;
    if (IsText(table, c) || NamesPoints(header)) candidates.push_back(c);
  }
  std::stable_partition(candidates.begin(), candidates.end(),
                        [&](int c) { return NamesPoints(table.header[static_cast<size_t>(c)]); });
  return candidates;
}

struct Found {
  int column = -1;
  NamePart part = NamePart::kWhole;
};

// Of 7 and 7_2 the first has no part that could be a marker's name.
bool AllHavePart(const TextTable& table, int column, NamePart part) {
  return std::all_of(table.rows.begin(), table.rows.end(), [column, part](const TextTable::Row& row) {
    const std::string& cell = row.cells[static_cast<size_t>(column)];
    return PartOfName(cell, NamePart::kFirst) != cell && !PartOfName(cell, part).empty();
  });
}

std::optional<Found> Find(const TextTable& table, const Poses& poses, const std::vector<int>& columns) {
  const double apart = poses.Spread([](size_t) { return std::string(); });
  if (!(apart > kApart * poses.Extent())) return std::nullopt;
  for (const NamePart part :
       {NamePart::kWhole, NamePart::kLast, NamePart::kFirst, NamePart::kSecond, NamePart::kThird, NamePart::kFourth}) {
    for (const int c : columns) {
      if (part != NamePart::kWhole && !AllHavePart(table, c, part)) continue;
      const Label label = [&table, c, part](size_t r) {
        return PartOfName(table.rows[r].cells[static_cast<size_t>(c)], part);
      };
      if (poses.Recurs(label) && poses.Spread(label) <= kNearer * apart) return Found{c, part};
    }
  }
  return std::nullopt;
}

const char* NameOf(NamePart part) {
  switch (part) {
    case NamePart::kFirst:
      return "first";
    case NamePart::kSecond:
      return "second";
    case NamePart::kThird:
      return "third";
    case NamePart::kFourth:
      return "fourth";
    case NamePart::kWhole:
    case NamePart::kLast:
    case NamePart::kButLast:
      break;
  }
  return "last";
}

std::string GuessInWords(const TextTable& table, const Found& found) {
  const std::string header = table.header[static_cast<size_t>(found.column)];
  const std::string& name = table.rows.front().cells[static_cast<size_t>(found.column)];
  std::string what = "'" + header + "'";
  if (found.part != NamePart::kWhole) {
    what = std::string("the ") + NameOf(found.part) + " part of " + what + " (" + PartOfName(name, found.part) +
           " of " + name + ")";
  }
  return what + " is the marker: rows of equal joint values differ in it, and their points lie apart; " +
         "--map=marker=" + header + " says it";
}

void AddNames(const TextTable& table, const char* stem, const Found& found, ImportPlan* plan) {
  PlannedColumn names;
  names.stem = names.meaning = stem;
  names.source = found.column;
  names.part = found.part;
  names.header = table.header[static_cast<size_t>(found.column)];
  plan->columns.push_back(names);
  const auto is_same = [&](const auto& unused) { return unused.first == names.header; };
  plan->unused.erase(std::remove_if(plan->unused.begin(), plan->unused.end(), is_same), plan->unused.end());
}

// Whether each name has its own joint values and these no other name.
bool NamesPoses(const TextTable& table, const ImportPlan& plan, const Found& found) {
  std::map<std::string, std::string> joints_of, name_of;
  for (const TextTable::Row& row : table.rows) {
    CheckInterruption();
    const std::string joints = JointsOf(plan, row);
    const std::string name = PartOfName(row.cells[static_cast<size_t>(found.column)], found.part);
    if (name.empty() || joints_of.emplace(name, joints).first->second != joints) return false;
    if (name_of.emplace(joints, name).first->second != name) return false;
  }
  return joints_of.size() > 1;
}

}  // namespace

bool IsOfPose(const PlannedColumn& column) {
  static const std::set<std::string> kTexts = {"station", "visit", "load"};
  const std::string& stem = column.stem;
  const bool is_wrench = stem.size() == 2 && (stem[0] == 'f' || stem[0] == 'm');
  return stem[0] == 'q' || kTexts.count(stem) > 0 || is_wrench || stem.rfind("approach", 0) == 0;
}

namespace {

// Of A::SMR1::P001 A, SMR1, P001.
std::vector<std::string> PartsOfName(const std::string& name) {
  std::vector<std::string> parts(1);
  for (const char c : name) {
    if (!SeparatesParts(static_cast<unsigned char>(c))) {
      parts.back() += c;
    } else if (!parts.back().empty()) {
      parts.emplace_back();
    }
  }
  return parts;
}

}  // namespace

std::string PartOfName(const std::string& name, NamePart part) {
  const int inner = static_cast<int>(part) - static_cast<int>(NamePart::kSecond);
  if (inner >= 0) {
    const std::vector<std::string> parts = PartsOfName(name);
    return parts.size() > static_cast<size_t>(inner) + 1 ? parts[static_cast<size_t>(inner) + 1] : "";
  }
  if (part == NamePart::kWhole) return name;
  if (part == NamePart::kFirst) return {name.begin(), std::find_if(name.begin(), name.end(), SeparatesParts)};
  const auto last = std::find_if(name.rbegin(), name.rend(), SeparatesParts);
  if (part == NamePart::kLast) return {last.base(), name.end()};
  return last == name.rend() ? name : std::string(name.begin(), last.base() - 1);
}

void NameMarkers(const TextTable& table, bool is_mapped, std::vector<ImportPlan>* plans) {
  if (!table.has_header()) return;
  const ImportPlan& first = plans->front();
  const PlannedColumn* named = first.Find("marker");
  const std::vector<int> columns = named ? std::vector<int>{named->source} : Candidates(table, first);
  if (columns.empty() || (named && HoldsFewNames(table, named->source))) return;
  const Poses poses(table, first);
  const std::optional<Found> found = Find(table, poses, columns);
  if (!found || (named && found->part == NamePart::kWhole)) return;
  const bool is_said =
      found->part == NamePart::kWhole ? NamesPoints(table.header[static_cast<size_t>(found->column)]) : is_mapped;
  for (ImportPlan& plan : *plans) {
    const auto is_marker = [](const PlannedColumn& column) { return column.stem == "marker"; };
    plan.columns.erase(std::remove_if(plan.columns.begin(), plan.columns.end(), is_marker), plan.columns.end());
    AddNames(table, "marker", *found, &plan);
    if (!is_said) plan.guesses.push_back(GuessInWords(table, *found));
  }
}

void NamePoses(const TextTable& table, std::vector<ImportPlan>* plans) {
  const ImportPlan& first = plans->front();
  if (!table.has_header() || first.Find("config")) return;
  std::vector<int> columns = Candidates(table, first);
  const PlannedColumn* marker = first.Find("marker");
  if (marker && marker->part != NamePart::kWhole) columns.push_back(marker->source);
  for (const int c : columns) {
    for (const NamePart part : {NamePart::kWhole, NamePart::kButLast, NamePart::kFirst}) {
      if (!NamesPoses(table, first, {c, part})) continue;
      for (ImportPlan& plan : *plans) AddNames(table, "config", {c, part}, &plan);
      return;
    }
  }
}

size_t DifferentPoses(const TextTable& table, const ImportPlan& plan) { return Poses(table, plan).rows_of().size(); }

ApartRows RowsOfOneMarker(const TextTable& table, const ImportPlan& plan) {
  const Poses poses(table, plan);
  const PlannedColumn* named = plan.Find("marker");
  const Label label = [&](size_t r) {
    return named ? PartOfName(table.rows[r].cells[static_cast<size_t>(named->source)], named->part) : std::string();
  };
  ApartRows apart;
  apart.distance = poses.Spread(label);
  for (const auto& [key, rows] : poses.rows_of()) {
    if (rows.size() < 2 || poses.SpreadOf(rows, label) < apart.distance) continue;
    std::map<std::string, size_t> first_of;
    for (const size_t r : rows) {
      const auto [known, is_new] = first_of.emplace(label(r), r);
      if (is_new || apart.line > 0 || poses.SpreadOf({known->second, r}, label) < apart.distance / 2) continue;
      apart.line = table.rows[known->second].line;
      apart.other_line = table.rows[r].line;
    }
    if (apart.line > 0) break;
  }
  return apart;
}

}  // namespace sagitta

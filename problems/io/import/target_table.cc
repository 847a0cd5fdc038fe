#include "problems/io/import/target_table.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <string_view>
#include <utility>

#include "problems/io/files.h"
#include "problems/io/import/column_meaning.h"
#include "problems/io/import/header_words.h"
#include "problems/io/import/joint_columns.h"
#include "problems/io/import/text_table.h"
#include "problems/io/units.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr const char* kNameOfRow = "target";
const std::set<std::string> kTexts = {kNameOfRow, "load", "station"};
const std::set<std::string> kNamesOfRows = {kNameOfRow, "targets", "name", "point", "pose"};

// The angles of a controller by its letters, where all three are there.
struct Letters {
  std::array<const char*, 3> letters, ours;
};
const Letters kLetters[] = {{{"a", "b", "c"}, {"a", "b", "c"}}, {{"w", "p", "r"}, {"roll", "pitch", "yaw"}}};

bool IsUnitOf(const std::string& unit, Dimension dimension) {
  const auto& units = UnitsOf(dimension);
  return std::any_of(units.begin(), units.end(), [&](const Unit& known) { return known.suffix == unit; });
}

std::string InUnit(const std::string& stem, const std::string& unit, Dimension dimension) {
  return IsUnitOf(unit, dimension) ? stem + "_" + unit : "";
}

// "" where a target file has no such column, or the header does not say enough.
std::string OurNameOf(const ColumnMeaning& meaning, const std::string& header, const std::vector<Joint>& joints) {
  const auto axis = [&meaning] { return std::string(1, "xyz"[meaning.index % 3]); };
  switch (meaning.role) {
    case Role::kJoint: {
      if (meaning.is_commanded || meaning.is_actual || meaning.index >= static_cast<int>(joints.size())) return "";
      const bool turns = joints[meaning.index].type == JointType::kRevolute;
      return InUnit("q" + std::to_string(meaning.index + 1), meaning.unit,
                    turns ? Dimension::kAngle : Dimension::kLength);
    }
    case Role::kPoint:
      return meaning.says_measured ? "" : InUnit(axis(), meaning.unit, Dimension::kLength);
    case Role::kWrench:
      return meaning.unit == (meaning.index < 3 ? "N" : "Nm")
                 ? (meaning.index < 3 ? "f" : "m") + axis() + "_" + meaning.unit
                 : "";
    case Role::kTime:
      return meaning.unit == "s" ? "time_s" : "";
    case Role::kTemperature:
      return meaning.unit == "degC" ? "temperature_degC" : "";
    case Role::kText:
      return kTexts.count(LowerCaseOf(header)) > 0 ? LowerCaseOf(header) : "";  // not a payload, which may be kg
    case Role::kSigma:
    case Role::kTarget:
    case Role::kDifference:
    case Role::kRotation:
    case Role::kQuaternion:
    case Role::kAngleSigma:
    case Role::kTorque:
    case Role::kApproach:
    case Role::kOther:
      break;
  }
  return kNamesOfRows.count(LowerCaseOf(header)) > 0 ? kNameOfRow : "";
}

// "A [deg]", not A_deg, which the reader asks about.
bool HasUnitInBrackets(const std::string& header) { return header.find_first_of("[(") != std::string::npos; }

void NameAngles(const std::vector<std::string>& header, std::map<size_t, std::string>* names) {
  for (const Letters& angles : kLetters) {
    std::map<size_t, std::string> found;
    for (size_t c = 0; c < header.size(); ++c) {
      const auto letter = std::find(angles.letters.begin(), angles.letters.end(), NameWithoutUnit(header[c]));
      if (letter == angles.letters.end() || !HasUnitInBrackets(header[c])) continue;
      const std::string name =
          InUnit(angles.ours[letter - angles.letters.begin()], UnitInHeader(header[c]), Dimension::kAngle);
      if (!name.empty() && names->count(c) == 0) found[c] = name;
    }
    if (found.size() == angles.letters.size()) names->insert(found.begin(), found.end());
  }
}

bool IsCommaSeparated(const std::string& text) {
  std::string_view rest = text;
  while (!rest.empty()) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    if (!line.empty() && line.front() != '#' && line.find_first_not_of(" \t\r") != std::string_view::npos) {
      return line.find(',') != std::string_view::npos || line.find_first_of(";\t") == std::string_view::npos;
    }
    rest.remove_prefix(std::min(rest.size(), line.size() + 1));
  }
  return true;
}

// Joints that are called X, Y or Z: columns of these very names that are no point, because a coordinate is missing, or
// because no rotation is there and all three are joints.
void NameJointsOfAxes(const std::vector<std::string>& header, const std::vector<Joint>& joints,
                      const std::map<size_t, std::string>& angles, std::vector<ColumnMeaning>* meanings) {
  std::set<int> axes;
  std::map<size_t, int> joint_of;
  bool turns = false, all_are_joints = true;
  for (size_t c = 0; c < header.size(); ++c) {
    const ColumnMeaning& meaning = (*meanings)[c];
    turns |= meaning.role == Role::kRotation || meaning.role == Role::kQuaternion;
    turns |= meaning.role != Role::kJoint && angles.count(c) > 0;
    if (meaning.role != Role::kPoint) continue;
    axes.insert(meaning.index);
    const int joint = JointNamed(header[c], joints);
    const bool is_joint = joint >= 0 && !meaning.says_measured;
    all_are_joints &= is_joint;
    if (is_joint) joint_of[c] = joint;
  }
  if (axes.size() == 3 && (turns || !all_are_joints)) return;
  SetJoints(joint_of, meanings);
}

}  // namespace

TargetTable ReadTargetTable(const std::string& path, std::vector<std::string>* notes) {
  const std::shared_ptr<const std::string> bytes = SharedText(path);
  if (LineOfInvalidUtf8(*bytes) == 0 && IsCommaSeparated(*bytes)) return {ParseCsvTable(*bytes, path), false};
  const TextTable text = ParseTextTable(*bytes, path);
  std::vector<std::vector<std::string>> columns(text.header.size());
  std::vector<int> lines;
  for (const TextTable::Row& row : text.rows) {
    lines.push_back(row.line);
    for (size_t c = 0; c < columns.size(); ++c) columns[c].push_back(row.cells[c]);
  }
  notes->push_back(path + ": " + text.encoding + ", separated by " + text.separator +
                   (text.decimal_comma ? ", decimal comma" : ", decimal point"));
  notes->insert(notes->end(), text.guesses.begin(), text.guesses.end());
  CsvTable table = CsvTableOf(path, text.header, columns, lines);
  table.header_line = text.header_line;
  return {std::move(table), text.decimal_comma};
}

void WriteNumbersAsOurs(const std::vector<size_t>& columns, MeasurementFile* file) {
  for (size_t r = 0; r < file->rows.size(); ++r) {
    for (const size_t c : columns) {
      const std::string cell(file->rows[r].cells[c]);
      if (cell.find(',') == std::string::npos) continue;
      const std::optional<double> number = ParseLocalNumber(cell, /*decimal_comma=*/true);
      if (number) file->rows.SetCell(r, c, FormatNumber(*number));
    }
  }
}

void RenameTargetColumns(const std::vector<Joint>& joints, std::vector<std::string>* header,
                         std::vector<std::string>* notes) {
  std::vector<ColumnMeaning> meanings = MeaningsOf(*header, joints);
  std::map<size_t, std::string> names, angles;
  NameAngles(*header, &angles);
  NameJointsOfAxes(*header, joints, angles, &meanings);
  for (size_t c = 0; c < header->size(); ++c) {
    const std::string name = OurNameOf(meanings[c], (*header)[c], joints);
    if (!name.empty()) names[c] = name;
  }
  NameAngles(*header, &names);
  std::set<std::string> taken(header->begin(), header->end());
  std::vector<std::string> said;
  for (const auto& [c, name] : names) {
    if (!taken.insert(name).second) continue;  // it is that column, or another one is
    said.push_back("'" + (*header)[c] + "' as " + name);
    (*header)[c] = name;
  }
  if (!said.empty()) notes->push_back("read " + Joined(said));
}

}  // namespace sagitta

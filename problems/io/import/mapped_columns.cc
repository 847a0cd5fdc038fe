#include "problems/io/import/mapped_columns.h"

#include <algorithm>
#include <set>

#include "problems/input_error.h"
#include "problems/io/import/header_words.h"
#include "problems/io/import/time_column.h"

namespace sagitta {
namespace {

[[noreturn]] void RefuseTable(const TextTable& table, const std::string& what, const std::string& hint) {
  throw InputError({table.path, table.header_line, "--map"}, what, hint);
}

}  // namespace

bool IsLengthUnit(const std::string& unit) {
  return unit == "mm" || unit == "m" || unit == "um" || unit == "cm" || unit == "in";
}
bool IsAngleUnit(const std::string& unit) { return unit == "deg" || unit == "rad" || unit == "mrad" || unit == "urad"; }
std::string TorqueUnit(const Joint& joint) { return joint.type == JointType::kPrismatic ? "N" : "Nm"; }

std::pair<std::string, std::string> StemAndUnit(const std::string& column) {
  const size_t bar = column.rfind('_');
  if (bar == std::string::npos) return {column, ""};
  const std::string unit = column.substr(bar + 1);
  static const std::set<std::string> kUnits = {"mm",   "m",    "um", "cm",   "in", "deg", "rad",
                                               "mrad", "urad", "s",  "degC", "N",  "Nm"};
  return kUnits.count(unit) ? std::make_pair(column.substr(0, bar), unit) : std::make_pair(column, std::string());
}

bool IsRotationStem(const std::string& stem) {
  static const std::set<std::string> kStems = {"rx", "ry", "rz",       "ow",       "ox",
                                               "oy", "oz", "sigma_rx", "sigma_ry", "sigma_rz"};
  return kStems.count(stem) > 0;
}

void CheckMappedColumn(const TextTable& table, const std::vector<Joint>& joints, const std::string& column,
                       const PlannedColumn& planned) {
  std::vector<std::string> known = {"config", "marker", "station", "visit",           "repeat",
                                    "load",   "set",    "time_s",  "temperature_degC"};
  for (const char* axis : {"x", "y", "z"}) {
    for (const char* stem : {"", "sigma_"}) {
      for (const char* unit : {"_mm", "_m", "_um", "_cm", "_in"}) known.push_back(std::string(stem) + axis + unit);
    }
  }
  for (const char* name : {"fx_N", "fy_N", "fz_N", "mx_Nm", "my_Nm", "mz_Nm", "ow", "ox", "oy", "oz"})
    known.push_back(name);
  for (const char* stem : {"rx", "ry", "rz", "sigma_rx", "sigma_ry", "sigma_rz"}) {
    for (const char* unit : {"_deg", "_rad", "_mrad", "_urad"}) known.push_back(std::string(stem) + unit);
  }
  for (size_t j = 0; j < joints.size(); ++j) {
    const std::string q = "q" + std::to_string(j + 1);
    for (const char* unit : {"_deg", "_rad", "_mrad", "_mm", "_m"}) known.push_back(q + unit);
    known.push_back("approach" + std::to_string(j + 1));
    known.push_back("tau" + std::to_string(j + 1) + "_" + TorqueUnit(joints[j]));
  }
  if (std::find(known.begin(), known.end(), column) == known.end()) {
    RefuseTable(table, "'" + column + "' is no column of measurements.csv", SpellingHint(column, known));
  }
  const std::string& header = table.header[planned.source];
  const std::string unread = UnreadUnitIn(header).unit;
  const bool is_time = planned.stem == "time";
  const bool is_other_time = is_time && SecondsOfHeader(header).value_or(1.0) != 1.0;
  const std::string unit = is_other_time || IsUnit(unread) ? unread : UnitInHeader(header);
  if (!unit.empty() && !planned.unit.empty() && unit != planned.unit) {
    RefuseTable(table,
                "the column '" + table.header[planned.source] + "' says " + unit + ", the map says " + planned.unit,
                "--map states the unit that the numbers have");
  }
  PlannedColumn found = planned;
  found.is_mapped = false;
  if (!is_time || !LookAtTime(table, found, {}).since_1970) return;
  RefuseTable(table, "the numbers of '" + header + "' are too large for s, which the map says",
              "a header with the unit that they have, as in 'Time [ms]', is read without the map");
}

std::string HintOfJoints(const std::vector<Joint>& of_robot, const std::vector<size_t>& joints) {
  std::string columns;
  for (const size_t j : joints) {
    const bool slides = of_robot[j].type == JointType::kPrismatic;
    columns += (columns.empty() ? "q" : ",q") + std::to_string(j + 1) + (slides ? "_mm" : "_deg") + "=HEADER";
  }
  return "--map=" + columns + " (_rad where the numbers are radians); a column's number does as well";
}

void SortMappedRotation(const TextTable& table, std::vector<PlannedColumn>* rotation_columns) {
  std::vector<PlannedColumn>& columns = *rotation_columns;
  std::stable_sort(columns.begin(), columns.end(),
                   [](const PlannedColumn& a, const PlannedColumn& b) { return a.stem.size() < b.stem.size(); });
  const auto count = [&columns](char first) {
    return std::count_if(columns.begin(), columns.end(), [first](const PlannedColumn& column) {
      return column.stem.size() == 2 && column.stem[0] == first;
    });
  };
  const auto angles = count('r'), parts = count('o');
  if ((angles == 3 && parts == 0) || (angles == 0 && parts == 4)) return;
  RefuseTable(table, "a rotation is three angles or the four parts of a quaternion",
              "--map=rx_deg=…,ry_deg=…,rz_deg=… or --map=ow=…,ox=…,oy=…,oz=…");
}

}  // namespace sagitta

#include "estimator/calibration/unit_guess.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "estimator/report/calibration_words.h"
#include "models/constants.h"
#include "problems/input_error.h"
#include "problems/io/units.h"

namespace sagitta {
namespace {

// Of the reach, of an estimate: twice what a nominal robot may miss by (reading_lint.cc).
constexpr double kMisfit = 0.01;
// A correction of a link's length by more than both is no tolerance of a robot: those are tenths of a millimetre, and a
// few millimetres where a length was read from a drawing.
constexpr double kOfALink = 0.1, kLargeCorrection = 5e-3;  // m
constexpr double kUnitImprovement = 10.0;  // from the tenths of the reach that a wrong unit leaves to kNotThisRobot

struct UnitReading {
  bool is_joint = true;  // joint columns, else x, y, z
  const char* suffix;    // what the header says
  const char* better;    // what the numbers look like
  const char* better_words;
  double factor;       // SI value in the better reading over SI value as read
  double least, most;  // of the largest number in the columns, for the reading to be worth a try
};

const UnitReading kReadings[] = {
    {true, "_deg", "_rad", "radians", 1.0 / kDegree, 0.0, kMostRadians},
    {true, "_rad", "_deg", "degrees", kDegree, kMostRadians, 1e4},
    {false, "_mm", "_m", "metres", 1e3, 0.0, kMostMetres},
    {false, "_m", "_mm", "millimetres", 1e-3, kMostMetres, 1e9},
};

std::vector<std::string> ColumnsOfReading(const UnitReading& reading, const std::string& point_prefix,
                                          const Chain& chain, const MeasurementFile& file) {
  std::vector<std::string> columns;
  const auto add = [&](const std::string& name) {
    if (file.FindColumn(name) >= 0) columns.push_back(name);
  };
  if (reading.is_joint) {
    for (int j = 0; j < chain.num_joints(); ++j) {
      if (chain.joints[j].type == JointType::kRevolute) add("q" + std::to_string(j + 1) + reading.suffix);
    }
  } else {
    for (const char* axis : {"x", "y", "z"}) add(point_prefix + axis + reading.suffix);
  }
  return columns;
}

double LargestNumber(const MeasurementFile& file, const std::vector<std::string>& columns) {
  double largest = 0.0;
  for (const std::string& column : columns) {
    const int index = file.FindColumn(column);
    for (const MeasurementFile::Row& row : file.rows) {
      largest = std::max(largest, std::abs(ParseNumber(row.cells[index]).value_or(0.0)));
    }
  }
  return largest;
}

// Files whose columns may be meant in the other unit.
std::vector<bool> FilesConcerned(const UnitReading& reading, const std::string& point_prefix,
                                 const CalibrationProblem& problem) {
  std::vector<bool> concerned;
  for (const MeasurementFile& file : problem.data().files) {
    const std::vector<std::string> columns = ColumnsOfReading(reading, point_prefix, problem.robot().chain, file);
    const double largest = LargestNumber(file, columns);
    concerned.push_back(!columns.empty() && largest > reading.least && largest <= reading.most);
  }
  return concerned;
}

CalibrationProblem RereadInUnits(const CalibrationProblem& problem, const UnitReading& reading,
                                 const std::vector<bool>& concerned) {
  CalibrationProblem reread = problem;
  Measurements& data = *reread.mutable_data();
  std::vector<bool> done(data.configurations.size());
  for (Observation& observation : data.observations) {
    if (observation.file < 0 || !concerned[observation.file]) continue;
    if (!reading.is_joint) {
      observation.point_in_station *= reading.factor;
      continue;
    }
    const int index = data.shots[observation.shot].configuration;
    if (done[index]) continue;
    done[index] = true;
    const MeasurementFile& file = data.files[observation.file];
    for (int j = 0; j < reread.robot().num_joints(); ++j) {
      const bool meant = file.FindColumn("q" + std::to_string(j + 1) + reading.suffix) >= 0;
      const bool revolute = reread.robot().chain.joints[j].type == JointType::kRevolute;
      if (meant && revolute) data.configurations[index].q[j] *= reading.factor;
    }
  }
  reread.RenewJoints();
  return reread;
}

UnitFinding DescribeUnits(const CalibrationProblem& problem, const UnitReading& reading,
                          const std::string& point_prefix, int file_index, double before, double after) {
  const MeasurementFile& file = problem.data().files[file_index];
  UnitFinding finding;
  finding.file = file.path;
  finding.line = file.rows.empty() ? 0 : file.rows.front().line;
  finding.column = ColumnsOfReading(reading, point_prefix, problem.robot().chain, file).front();
  const std::string stem = finding.column.substr(0, finding.column.rfind('_'));
  finding.words = NumbersLookLike(reading.better_words, before, after);
  finding.hint = ConvertNumbers(point_prefix.empty() ? stem + reading.better : "");
  return finding;
}

}  // namespace

std::optional<UnitFinding> GuessWrongUnit(const CalibrationProblem& problem, const AlignedSample& aligned,
                                          const std::string& point_prefix) {
  const double before = aligned.misfit;
  const double tolerance = kNotThisRobot * Reach(problem.robot().chain);
  if (!(before > tolerance)) return std::nullopt;
  for (const UnitReading& reading : kReadings) {
    if (reading.is_joint && !point_prefix.empty()) continue;
    const std::vector<bool> concerned = FilesConcerned(reading, point_prefix, problem);
    const auto first = std::find(concerned.begin(), concerned.end(), true);
    if (first == concerned.end()) continue;
    const double after = AlignedMisfit(RereadInUnits(problem, reading, concerned), aligned.rows);
    if (after * kUnitImprovement > before || after > tolerance) continue;
    return DescribeUnits(problem, reading, point_prefix, static_cast<int>(first - concerned.begin()), before, after);
  }
  return std::nullopt;
}

std::optional<UnitFinding> GuessWrongUnit(const CalibrationProblem& problem, const std::string& point_prefix) {
  return GuessWrongUnit(problem, AlignedSample(problem), point_prefix);
}

void CheckUnits(const CalibrationProblem& problem, const AlignedSample& aligned) {
  if (const std::optional<UnitFinding> finding = GuessWrongUnit(problem, aligned)) {
    throw InputError({finding->file, finding->line, finding->column}, finding->words, finding->hint);
  }
}

std::string WarningOfLargeCorrections(const CalibrationProblem& problem, const std::vector<ParameterEstimate>& table) {
  std::vector<std::string> large;
  for (const ParameterEstimate& row : table) {
    if (CoordinateKindOf(row.name) != CoordinateKind::kGeometry) continue;
    const int at = problem.robot().chain.FindError(NameWithinKind(row.name));
    if (at < 0 || problem.robot().chain.transforms[at].motion != Motion::kTranslation) continue;
    const double length = problem.robot().chain.transforms[at].nominal, by = row.value;
    if (length == 0.0 || !(std::abs(by) > std::max(kOfALink * std::abs(length), kLargeCorrection))) continue;
    large.push_back(CorrectedLength(row.name, length, by));
  }
  if (large.empty()) return "";
  return LengthsAreCorrected(large);
}

std::string WarningOfMisfit(const CalibrationProblem& problem, double distance_rms) {
  if (!(distance_rms > kMisfit * Reach(problem.robot().chain))) return "";
  return CalibratedRobotMisses(distance_rms);
}

}  // namespace sagitta

#include "estimator/inspection/rotation_lint.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "estimator/alignment/aligned_misfit.h"
#include "estimator/alignment/starting_values.h"
#include "estimator/inspection/reading_lint.h"
#include "estimator/inspection/wild_rows.h"
#include "estimator/report/inspection_reading_words.h"
#include "models/constants.h"
#include "models/matrix_functions.h"
#include "problems/io/import/rotation_reading.h"
#include "problems/io/units.h"

namespace sagitta {
namespace {

// Where no reading fits it may be the arm: six joints, each off by the 4 deg that no arm exceeds (kLargestError in
// reading_lint.cc).
constexpr double kBeyondAnArm = 24.0 * kDegree;
// A reading that fits as well as the best is named with it. A choice, next to the 90 and 180 deg by which wrong ones
// miss.
constexpr double kBetterRotation = 3.0;
constexpr size_t kNamed = 3;

// Columns that state the rotation of one row.
struct RotationColumns {
  std::vector<std::string> names;
  std::string unit;  // of the angles; empty: a quaternion
  bool is_quaternion() const { return unit.empty(); }
};

std::optional<RotationColumns> ColumnsOf(const MeasurementFile& file) {
  for (const Unit& unit : UnitsOf(Dimension::kAngle)) {
    const std::string suffix = std::string("_") + unit.suffix;
    if (file.FindColumn("rx" + suffix) >= 0) return {{{"rx" + suffix, "ry" + suffix, "rz" + suffix}, unit.suffix}};
  }
  if (file.FindColumn("ow") >= 0) return {{{"ow", "ox", "oy", "oz"}, ""}};
  return std::nullopt;
}

// One rotation as it stands in its row.
struct StatedRotation {
  int marker = -1;
  Matrix3<double> station_from_frame;
  Matrix3<double> as_read;
  std::vector<double> numbers;
};

// As the columns say first, then all others that tables are known to mean.
std::vector<RotationReading> ReadingsOf(const RotationColumns& columns) {
  if (columns.is_quaternion()) return PossibleRotations(true, "", true);
  std::vector<RotationReading> readings = PossibleRotations(false, columns.unit, false);
  for (const char* unit : {"mrad", "deg", "rad"}) {
    if (unit == columns.unit) continue;
    const std::vector<RotationReading> others = PossibleRotations(false, unit, false);
    readings.insert(readings.end(), others.begin(), others.end());
  }
  return readings;
}

double MisfitAs(const RotationReading& reading, const std::vector<StatedRotation>& stated) {
  std::vector<TargetRotation> rotations;
  for (const StatedRotation& one : stated) {
    std::vector<double> numbers = one.numbers;
    for (double& number : numbers) number = reading.unit.empty() ? number : UnitNamed(reading.unit).ToSi(number);
    rotations.push_back({one.marker, one.station_from_frame, reading.StationFromTarget(numbers)});
  }
  return RotationMisfit(rotations);
}

double MisfitAsRead(const std::vector<StatedRotation>& stated) {
  std::vector<TargetRotation> rotations;
  for (const StatedRotation& one : stated) rotations.push_back({one.marker, one.station_from_frame, one.as_read});
  return RotationMisfit(rotations);
}

// Points that spread by s in their second direction and are missed by d turn their base by d / s at most.
bool DetermineTheirBase(const CalibrationProblem& problem, const std::vector<int>& points, double misfit) {
  const std::map<int, std::vector<int>> of_station = ByStation(problem.data(), points);
  return std::all_of(of_station.begin(), of_station.end(), [&](const auto& entry) {
    Vector3<double> mean = Vector3<double>::Zero();
    for (const int i : entry.second) mean += problem.data().observations[i].point_in_station / entry.second.size();
    Matrix3<double> scatter = Matrix3<double>::Zero();
    for (const int i : entry.second) {
      const Vector3<double> from_mean = problem.data().observations[i].point_in_station - mean;
      scatter += from_mean * from_mean.transpose() / entry.second.size();
    }
    return misfit < kRotationFits * std::sqrt(std::max(0.0, PrincipalAxesOf(scatter).values[1]));
  });
}

// Rotations of one file's columns among the listed observations, those of the first that has any.
std::vector<StatedRotation> StatedRotations(const CalibrationProblem& problem, const ParameterSet& aligned,
                                            const std::vector<int>& rows, RotationColumns* columns) {
  const Measurements& data = problem.data();
  std::vector<int> rotations;
  std::vector<std::vector<double>> numbers;
  for (const int i : rows) {
    const Observation& row = data.observations[i];
    if (row.is_point() || row.file < 0) continue;
    const std::optional<RotationColumns> own = ColumnsOf(data.files[row.file]);
    if (!own || (!rotations.empty() && own->names != columns->names)) continue;
    *columns = *own;
    std::vector<double> read;
    for (const std::string& name : own->names) {
      if (const std::optional<double> number = ParseNumber(data.Cell(row, name))) read.push_back(*number);
    }
    if (read.size() != own->names.size()) continue;
    rotations.push_back(i);
    numbers.push_back(read);
  }
  const std::vector<Matrix3<double>> frames = OrientationsAt(problem, aligned, rotations);
  std::vector<StatedRotation> stated;
  for (size_t k = 0; k < rotations.size(); ++k) {
    const Observation& row = data.observations[rotations[k]];
    stated.push_back({row.marker, frames[k], row.rotation().in_station, numbers[k]});
  }
  return stated;
}

std::optional<Finding> DescribeRotations(const RotationColumns& columns, RotationsAsStated as_stated,
                                         const std::vector<StatedRotation>& stated) {
  const std::vector<RotationReading> readings = ReadingsOf(columns);
  as_stated.columns = columns.names;
  as_stated.reading = readings.front().Words();
  std::vector<std::pair<double, size_t>> misfits;
  double best = std::numeric_limits<double>::infinity();
  for (size_t k = 1; k < readings.size(); ++k) {
    misfits.emplace_back(MisfitAs(readings[k], stated), k);
    best = std::min(best, misfits.back().first);
  }
  std::sort(misfits.begin(), misfits.end());
  std::vector<std::string> fitting;
  for (const auto& [misfit, k] : misfits) {
    const bool fits =
        misfit < kRotationFits && misfit * kBetterRotation < as_stated.misfit && misfit <= kBetterRotation * best;
    if (fits && fitting.size() < kNamed) fitting.push_back(readings[k].Words());
  }
  if (fitting.empty() && !(as_stated.misfit > kBeyondAnArm)) return std::nullopt;
  return Found(Severity::kSerious, "rotation_convention", RotationsMiss(as_stated, fitting, best));
}

}  // namespace

std::optional<Finding> LintRotations(const CalibrationProblem& problem) {
  const std::vector<int> rows = SampleOfRows(problem), points = problem.data().PointsAmong(rows);
  if (points.empty() || points.size() == rows.size()) return std::nullopt;
  RotationsAsStated as_stated;
  ParameterSet aligned = problem.parameters;
  as_stated.points = FindStartingValues(problem, points, &aligned);
  const bool points_fit = as_stated.points <= SuspiciousMisfit(problem);
  if (!points_fit || !DetermineTheirBase(problem, points, as_stated.points)) return std::nullopt;
  RotationColumns columns;
  const std::vector<StatedRotation> stated = StatedRotations(problem, aligned, rows, &columns);
  if (stated.empty()) return std::nullopt;
  as_stated.misfit = MisfitAsRead(stated);
  if (!(as_stated.misfit > kRotationFits)) return std::nullopt;
  return DescribeRotations(columns, as_stated, stated);
}

}  // namespace sagitta

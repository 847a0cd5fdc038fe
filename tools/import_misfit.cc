#include "tools/import_misfit.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>

#include "estimator/alignment/aligned_misfit.h"
#include "estimator/inspection/reading_lint.h"
#include "estimator/inspection/sampled_problem.h"
#include "estimator/inspection/wild_rows.h"
#include "models/constants.h"
#include "problems/input_error.h"
#include "problems/io/import/marker_column.h"
#include "problems/io/measurement_file.h"
#include "problems/io/units.h"
#include "problems/split.h"
#include "tools/command_line.h"
#include "tools/import_choice.h"
#include "tools/report/command_words.h"

DEFINE_string(on, "",
              "MARKER=PLACE,…: markers that are not on the flange: a joint, whose link they ride on, base or world");

namespace sagitta {
namespace {

constexpr size_t kSampleRows = 60;
constexpr size_t kSampleShots = 12;       // at least, where rows are repeats of few poses
constexpr size_t kRowsOfDigits = 1000;    // one in ten ends with a zero: of so many not all do
constexpr size_t kEquationsPerPlace = 2;  // to every coordinate of a base or marker
constexpr double kMostFarOff = 0.2;       // of all: more are no exceptions, as in reading_lint.cc
constexpr double kNothing = std::numeric_limits<double>::infinity();
constexpr char kWrittenRows[] = "measurements.csv";
constexpr int kFirstRowLine = 2;  // of its rows, behind the header
// rad and m: controllers show joint values to a hundredth of a degree or of a millimetre at least. Values of fewer
// digits are those of poses that somebody wrote down, and the arm was driven to just these.
constexpr double kCoarsestAngle = 0.01 * kDegree, kCoarsestLength = 1e-5;

// The plan's joint values and points, and what names them.
ImportPlan GeometryOf(const ImportPlan& plan) {
  ImportPlan geometry = plan;
  geometry.columns.clear();
  for (const PlannedColumn& column : plan.columns) {
    const bool is_geometry = column.stem.size() == 1 || column.stem[0] == 'q' || column.stem == "config" ||
                             column.stem == "marker" || column.stem == "station";
    if (is_geometry) geometry.columns.push_back(column);
  }
  return geometry;
}

// Of these rows the points, those of one marker at one station and pose once: repeats say nothing of the robot.
std::vector<int> WithoutRepeats(const CalibrationProblem& problem, const std::vector<int>& rows) {
  const Measurements& data = problem.data();
  const std::vector<int> group_of = GroupsOfConfigurations(data);
  std::set<std::tuple<int, int, int>> seen;
  std::vector<int> once;
  for (const int i : data.PointsAmong(rows)) {
    const Observation& row = data.observations[static_cast<size_t>(i)];
    const Shot& shot = data.shots[static_cast<size_t>(row.shot)];
    if (seen.emplace(group_of[static_cast<size_t>(shot.configuration)], shot.station, row.marker).second) {
      once.push_back(i);
    }
  }
  return once;
}

// Twice as many equations as unknowns.
bool AreEnough(const CalibrationProblem& problem, const std::vector<int>& rows) {
  return 3 * rows.size() >= kEquationsPerPlace * problem.parameters.EstimatedCoordinates().size();
}

// One pose, or fewer than twice as many equations as all base poses and markers have coordinates.
bool AreTooFew(const Measurements& data) {
  const std::vector<int> groups = GroupsOfConfigurations(data);
  const std::set<int> poses(groups.begin(), groups.end());
  std::set<std::tuple<int, int, int>> points;
  for (const Observation& row : data.observations) {
    if (!row.is_point()) continue;
    const Shot& shot = data.shots[static_cast<size_t>(row.shot)];
    points.emplace(groups[static_cast<size_t>(shot.configuration)], shot.station, row.marker);
  }
  return poses.size() < 2 ||
         3 * points.size() < kEquationsPerPlace * (6 * data.stations.size() + 3 * data.markers.size());
}

Robot WithoutEffects(Robot robot) {
  robot.effects.clear();
  return robot;
}

Experiment WithWeightlessLoads(const Measurements& data) {
  Experiment experiment;
  experiment.load_point = Vector3<double>::Zero();
  for (const std::string& load : LoadsOf(data)) experiment.loads[load].mass = 0.0;
  for (const auto& [name, marker] : MarkersFromFlags()) {  // those of this table
    if (std::count(data.markers.begin(), data.markers.end(), name) > 0) experiment.markers[name] = marker;
  }
  return experiment;
}

// Base poses and markers alone are unknown: the nominal robot is compared, and as many rows as they need will do.
// Nothing: there are fewer than twice as many equations as these unknowns, and any robot fits few rows. Throws
// InputError where they are enough and no measurements of this robot.
std::optional<CalibrationProblem> ProblemOf(const Robot& robot, const Measurements& data) {
  Experiment experiment = WithWeightlessLoads(data);
  for (Selection* each : {&experiment.estimate.geometry, &experiment.estimate.compliance,
                          &experiment.estimate.gravity_compensator, &experiment.estimate.effects})
    each->kind = Selection::Kind::kNone;
  try {
    CalibrationProblem problem = MakeCalibrationProblem(WithoutEffects(robot), data, experiment);
    if (!AreEnough(problem, WithoutRepeats(problem, problem.CalibrationObservations()))) return std::nullopt;
    return problem;
  } catch (const InputError&) {
    if (AreTooFew(data)) return std::nullopt;
    throw;
  }
}

// How far the aligned nominal robot misses.
double Misfit(const Robot& robot, const TextTable& table, const ImportPlan& plan) {
  try {
    const std::optional<CalibrationProblem> problem = ProblemOf(robot, SampleOfTable(robot, table, plan));
    if (!problem) return kNothing;
    const std::vector<int> sample = SampleOfRows(*problem);
    // Repeats that come in turns may leave a few poses in a sample of every so many-th row.
    if (AreEnough(*problem, WithoutRepeats(*problem, sample))) return AlignedMisfit(*problem, sample);
    return AlignedMisfit(*problem, WithoutRepeats(*problem, problem->CalibrationObservations()));
  } catch (const InputError&) {  // CheckComparable says which
    return kNothing;
  }
}

// What a message says of rows of the file that is to be written, of those that they were read from.
std::string WithSources(std::string words, const ImportedRows& rows) {
  const std::string name = std::string(kWrittenRows) + ":";
  for (size_t at = 0; (at = words.find(name, at)) != std::string::npos;) {
    const int row = std::atoi(words.c_str() + at + name.size()) - kFirstRowLine;
    const std::string source = row >= 0 ? rows.SourceOf(static_cast<size_t>(row)) : "";
    const size_t end = std::min(words.find_first_not_of("0123456789", at + name.size()), words.size());
    const std::string& instead = source.empty() ? words.substr(at, end - at) : source;
    words.replace(at, end - at, instead);
    at += instead.size();
  }
  return words;
}

bool AreFew(size_t far, size_t all) { return static_cast<double>(far) <= kMostFarOff * static_cast<double>(all); }

// Rows that stand clear of the others, where these are enough to say so and fit as a robot's do.
std::optional<FarRows> FewFarRows(const CalibrationProblem& problem) {
  std::optional<FarRows> rows = FindFarRows(problem);
  if (!rows) return std::nullopt;
  *rows = OnlyThoseApart(std::move(*rows));
  const size_t all = rows->near.size() + rows->far.size();
  if (rows->far.empty() || !AreFew(rows->far.size(), all) || !AreApart(*rows, problem)) return std::nullopt;
  return rows;
}

// Digits behind the decimal sign, zeros at the end left out: of twelve, as a program that writes 17 has 0.1 as
// 0.10000000000000001.
int DecimalsOf(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.11e", number);
  const std::string mantissa(text, std::strchr(text, 'e'));
  const size_t point = mantissa.find('.'), last = mantissa.find_last_not_of('0');
  return static_cast<int>(last - point) - std::atoi(std::strchr(text, 'e') + 1);
}

// m or rad: what the numbers of a column are rounded to.
double LastDigit(const TextTable& table, const PlannedColumn& column) {
  int decimals = 0;
  const size_t stride = 1 + table.rows.size() / kRowsOfDigits;
  for (size_t r = 0; r < table.rows.size(); r += stride) {
    const std::optional<double> number = table.Number(table.rows[r].cells[static_cast<size_t>(column.source)]);
    if (number && *number != 0.0) decimals = std::max(decimals, DecimalsOf(*number));
  }
  return UnitNamed(column.unit).ToSi(std::pow(10.0, -decimals));
}

// m: where the aligned robot has the points of these rows.
Eigen::Matrix3Xd PointsWithJointMoved(CalibrationProblem problem, const AlignedSample& aligned,
                                      const std::vector<int>& points, int joint, double by) {
  for (Configuration& configuration : problem.mutable_data()->configurations) configuration.q[joint] += by;
  problem.RenewJoints();
  return PredictPoints(problem, aligned.parameters, points);
}

// Of rows that were read by the name of the file that is to be written, at the row as it was given.
InputError AtSource(const InputError& error, const ImportedRows& rows) {
  const int row = error.where().line - kFirstRowLine;
  return InputError({row >= 0 ? rows.SourceOf(static_cast<size_t>(row)) : "", 0, ""},
                    RowsAreNoMeasurements(WithSources(error.what(), rows)));
}

}  // namespace

std::map<std::string, MarkerSpec> MarkersFromFlags() {
  std::map<std::string, MarkerSpec> markers;
  const PairWords words = {"a marker and what it is on", "stands there twice", "--on=L1=A3,B=base"};
  for (const auto& [name, place] : PairsOfFlag("on", FLAGS_on, words)) markers[name].on = MarkerPlace::Named(place);
  return markers;
}

CalibrationProblem ProblemOfGeometry(const Robot& robot, const Measurements& data) {
  return MakeCalibrationProblem(WithoutEffects(robot), data, WithWeightlessLoads(data));
}

Measurements CheckedMeasurements(const Robot& robot, const ImportedRows& rows, const std::string& csv) {
  try {
    return ReadMeasurementsText(robot, csv, kWrittenRows);
  } catch (const InputError& error) {
    throw AtSource(error, rows);
  }
}

Measurements SampleOfTable(const Robot& robot, const TextTable& table, const ImportPlan& plan) {
  ImportedRows rows;
  const size_t stride = std::min(table.rows.size() / kSampleRows, DifferentPoses(table, plan) / kSampleShots);
  rows.Add(table, plan, {}, std::max<size_t>(1, stride));
  return CheckedMeasurements(robot, rows, rows.ToCsv(robot.num_joints()));
}

double MisfitOf(const Robot& robot, const TextTable& table, const ImportPlan& plan) {
  // Nothing else that a table has may keep a robot from being compared with its points.
  const double misfit = Misfit(robot, table, plan);
  return std::isfinite(misfit) ? misfit : Misfit(robot, table, GeometryOf(plan));
}

void CheckComparable(const Robot& robot, const TextTable& table, const ImportPlan& plan) {
  ImportedRows rows;
  rows.Add(table, plan, {});
  const Measurements data = CheckedMeasurements(robot, rows, rows.ToCsv(robot.num_joints()));
  try {
    ProblemOf(robot, data);
  } catch (const InputError& error) {
    if (error.where().file != kWrittenRows) throw;
    throw AtSource(error, rows);
  }
}

std::optional<double> MisfitOfMost(const Robot& robot, const TextTable& table, const ImportPlan& plan) {
  try {
    const std::optional<CalibrationProblem> problem = ProblemOf(robot, SampleOfTable(robot, table, GeometryOf(plan)));
    const std::optional<FarRows> rows = problem ? FewFarRows(*problem) : std::nullopt;
    return rows ? std::optional<double>(rows->near_rms) : std::nullopt;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

namespace {

// Of all points those farther than `limit` from where the robot has them; the RMS distance of the others.
ReadingsFarOff FartherThan(double limit, const CalibrationProblem& problem, const std::vector<int>& points,
                           const std::vector<double>& distances) {
  ReadingsFarOff found;
  double squares = 0.0;
  found.all = points.size();
  for (size_t k = 0; k < points.size(); ++k) {
    if (distances[k] > limit) {
      found.rows.push_back(problem.data().observations[points[k]].row);
      found.distances.push_back(distances[k]);
    } else {
      squares += distances[k] * distances[k];
    }
  }
  found.others = std::sqrt(squares / static_cast<double>(std::max<size_t>(1, found.all - found.rows.size())));
  return found;
}

}  // namespace

std::optional<ReadingsFarOff> FindReadingsFarOff(const Robot& robot, const Measurements& data) {
  try {
    const std::optional<CalibrationProblem> made = ProblemOf(robot, data);
    if (!made) return std::nullopt;
    const CalibrationProblem& problem = *made;
    const AlignedSample aligned(problem);
    const std::vector<int> points = problem.data().PointsAmong(problem.CalibrationObservations());
    const double least = SuspiciousMisfit(problem);
    std::vector<double> distances = DistancesFromPoints(problem, points, aligned.parameters);
    const double most = distances.empty() ? 0.0 : *std::max_element(distances.begin(), distances.end());
    if (most <= least) return std::nullopt;
    // Rows that are far off may have drawn the robot to themselves: where some are in the sample, without them.
    double typical = aligned.misfit;
    if (const std::optional<FarRows> rows = FewFarRows(SampledProblem(problem))) {
      distances = DistancesFromPoints(problem, points, rows->parameters);
      typical = rows->near_rms;
    }
    ReadingsFarOff found = FartherThan(std::max(least, kFarApart * typical), problem, points, distances);
    if (found.rows.empty() || !AreFew(found.rows.size(), found.all)) return std::nullopt;
    return found;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

double SpreadOfPoints(const TextTable& table, const ImportPlan& plan) {
  double squares = 0.0;
  for (const char* axis : {"x", "y", "z"}) {
    const PlannedColumn& column = *plan.Find(axis);
    std::vector<double> values;
    double sum = 0.0;
    for (const TextTable::Row& row : table.rows) {
      const std::optional<double> first = table.Number(row.cells[static_cast<size_t>(column.source)]);
      const std::optional<double> second =
          column.second < 0 ? 0.0 : table.Number(row.cells[static_cast<size_t>(column.second)]);
      if (!first || !second || *first == kLostReading) continue;
      values.push_back(UnitNamed(column.unit).ToSi(*first + column.sign * *second));
      sum += values.back();
    }
    const auto n = static_cast<double>(std::max<size_t>(1, values.size()));
    for (const double value : values) squares += (value - sum / n) * (value - sum / n) / n;
  }
  return std::sqrt(squares);
}

// A number that is rounded to a step h is off by h / sqrt 12 (RMS): a point along each axis, a joint by that times how
// fast it moves the point.
double MisfitOfRounding(const Robot& robot, const TextTable& table, const ImportPlan& plan) {
  try {
    const std::optional<CalibrationProblem> made = ProblemOf(robot, SampleOfTable(robot, table, GeometryOf(plan)));
    if (!made) return kNothing;
    const CalibrationProblem& problem = *made;
    const AlignedSample aligned(problem);
    const std::vector<int> points = problem.data().PointsAmong(aligned.rows);
    const Eigen::Matrix3Xd at_rest = PointsWithJointMoved(problem, aligned, points, 0, 0.0);
    const double of_points = LastDigit(table, *plan.Find("x"));
    double squares = 3.0 * of_points * of_points;
    for (int j = 0; j < robot.num_joints(); ++j) {
      const bool turns = robot.chain.joints[static_cast<size_t>(j)].type == JointType::kRevolute;
      const double step = LastDigit(table, *plan.Find("q" + std::to_string(j + 1)));
      // Written as 0.01 degrees: a bit more or less.
      if (step > 1.001 * (turns ? kCoarsestAngle : kCoarsestLength)) continue;
      const Eigen::Matrix3Xd moved = PointsWithJointMoved(problem, aligned, points, j, step);
      squares += (moved - at_rest).squaredNorm() / static_cast<double>(points.size());
    }
    return std::sqrt(squares / 12.0);
  } catch (const InputError&) {
    return kNothing;
  }
}

}  // namespace sagitta

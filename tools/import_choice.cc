#include "tools/import_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "estimator/alignment/aligned_misfit.h"
#include "estimator/calibration/unit_guess.h"
#include "estimator/inspection/reading_lint.h"
#include "estimator/inspection/rotation_lint.h"
#include "models/constants.h"
#include "problems/calibration_problem.h"
#include "problems/choices.h"
#include "problems/input_error.h"
#include "problems/io/import/imported_rows.h"
#include "problems/io/import/marker_column.h"
#include "problems/io/measurement_file.h"
#include "problems/io/units.h"
#include "problems/text.h"
#include "tools/import_misfit.h"
#include "tools/report/command_words.h"

namespace sagitta {
namespace {

constexpr double kComputed = 2e-6;  // m: no instrument and no robot agree with a nominal table so well
const std::string kNotTheseReadings = "this robot cannot have made these readings: ";
constexpr double kMostOfSpread = 0.5;  // of the points: a robot that moves them misses by less, one at rest by all
constexpr double kRounded = 1.2;       // of what rounding makes on average, for what few rows may have more

}  // namespace

std::set<std::string> LoadsOf(const Measurements& data) {
  std::set<std::string> loads;
  for (const Shot& shot : data.shots) loads.insert(shot.load);
  loads.erase(Shot().load);
  return loads;
}

namespace {

// Several markers, loads or stations as one.
void RefuseRowsApart(const Robot& robot, const TextTable& table, const ImportPlan& plan) {
  const ApartRows apart = RowsOfOneMarker(table, plan);
  const double distance = UnitNamed(plan.Find("x")->unit).ToSi(apart.distance);
  if (distance <= SuspiciousMisfit(robot.chain)) return;
  throw InputError({table.path, apart.other_line, "marker"}, RowsLieApart(apart.line, InMillimetres(distance)),
                   "--map=marker=HEADER, or a column 'marker'; columns 'load' and 'station' distinguish the others");
}

// Why the robot cannot have made the readings, where that is found.
std::optional<Finding> WhyNot(const Robot& robot, const TextTable& table, const ImportPlan& plan) {
  try {
    ImportedRows rows;
    rows.Add(table, plan, {});
    const Measurements data = ReadMeasurementsText(robot, rows.ToCsv(robot.num_joints()), table.path);
    const ReadingLint lint = LintReadingsOfGoodRows(ProblemOfGeometry(robot, data));
    if (lint.is_suspicious && lint.is_explained) return lint.findings.front();
  } catch (const InputError&) {  // nothing more can be said
  }
  return std::nullopt;
}

[[noreturn]] void RefuseRobot(const Robot& robot, const TextTable& table, const ImportPlan& plan, double misfit,
                              bool says_why) {
  const std::string words = kNotTheseReadings;
  const std::optional<Finding> why = says_why ? WhyNot(robot, table, plan) : std::nullopt;
  const bool is_one = plan.moved_axes.size() == 1;
  const std::string moved =
      plan.moved_axes.empty()
          ? ""
          : "; " + Enumerate(plan.moved_axes) + (is_one ? ", an axis" : ", axes") + " that this robot has not, moved";
  if (why) throw InputError({table.path, table.header_line, ""}, words + why->words + moved, why->remedy);
  if (!moved.empty()) {
    throw InputError({table.path, table.header_line, ""},
                     words + "its nominal geometry misses them by " + InMillimetres(misfit) + " (RMS)" + moved,
                     is_one ? "a robot file that has this axis as a joint; or rows in which it stands still"
                            : "a robot file that has these axes as joints; or rows in which they stand still");
  }
  if (table.joined_in_order) {
    throw InputError({table.path, table.header_line, ""},
                     "no name joins the readings with the poses, and in the order of the rows " + words +
                         "its nominal geometry misses them by " + InMillimetres(misfit) + " (RMS)",
                     "call the readings as the poses are called: plan7, or plan7_M1");
  }
  throw InputError(
      {table.path, table.header_line, ""},
      words + "at best its nominal geometry misses them by " + InMillimetres(misfit) + " (RMS)",
      "check robot, units (x_m, q1_rad where the numbers are in m and rad) and which columns hold measured points; "
      "--map=… says it");
}

}  // namespace

namespace {

// Another reading of the numbers explains all rows, those that are far off too.
void RefuseOtherReading(const Robot& robot, const TextTable& table, const ImportPlan& plan) {
  std::optional<Finding> other;
  try {
    const Measurements data = SampleOfTable(robot, table, plan);
    const ReadingLint lint = LintReadings(ProblemOfGeometry(robot, data));
    if (lint.is_suspicious && lint.is_explained) other = lint.findings.front();
  } catch (const InputError&) {  // nothing can be said
  }
  if (other) throw InputError({table.path, table.header_line, ""}, kNotTheseReadings + other->words, other->remedy);
}

// What each plan misses most of the rows by, m, where it misses all of them by more than `tolerance`; whether one fits.
bool FitMost(const Robot& robot, const TextTable& table, const std::vector<ImportPlan>& plans, double tolerance,
             std::vector<double>* misfits) {
  for (size_t i = 0; i < plans.size(); ++i) {
    if (std::isfinite((*misfits)[i])) (*misfits)[i] = MisfitOfMost(robot, table, plans[i]).value_or((*misfits)[i]);
  }
  return *std::min_element(misfits->begin(), misfits->end()) <= tolerance;
}

}  // namespace

Choice ChoosePlan(const Robot& robot, const TextTable& table, const std::vector<ImportPlan>& plans, IfNoneFits policy) {
  std::vector<double> misfits;
  for (const ImportPlan& plan : plans) misfits.push_back(MisfitOf(robot, table, plan));
  const auto best_of = [&misfits] {
    return static_cast<size_t>(std::min_element(misfits.begin(), misfits.end()) - misfits.begin());
  };
  const bool fits_decide = std::isfinite(misfits[best_of()]);
  const double tolerance = kNotThisRobot * Reach(robot.chain);
  const bool is_of_most = fits_decide && misfits[best_of()] > tolerance && policy != IfNoneFits::kRefuse &&
                          FitMost(robot, table, plans, tolerance, &misfits);
  const size_t best = best_of();
  const ImportPlan& chosen = plans[fits_decide ? best : PlanBySize(table, plans)];
  RefuseRowsApart(robot, table, chosen);
  if (!fits_decide) {
    CheckComparable(robot, table, chosen);
    return {chosen};
  }
  if (misfits[best] > tolerance) RefuseRobot(robot, table, chosen, misfits[best], policy == IfNoneFits::kSayWhy);
  if (is_of_most) RefuseOtherReading(robot, table, chosen);
  // Metres read as millimetres lie so near to each other that any robot is within tolerance. (Of rows in their order
  // ConfirmOrder asks the same.)
  const bool is_chosen = plans.size() > 1 || !table.joined_in_order;
  if (is_chosen && misfits[best] > kMostOfSpread * SpreadOfPoints(table, chosen)) {
    const size_t likely = PlanBySize(table, plans);
    const double spread = SpreadOfPoints(table, plans[likely]);
    if (spread > tolerance) RefuseRobot(robot, table, plans[likely], misfits[likely], policy == IfNoneFits::kSayWhy);
    throw InputError(
        {table.path, table.header_line, ""},
        kNotTheseReadings + "the points lie within " + InMillimetres(spread) +
            " of each other (RMS), and the nominal robot misses them by " + InMillimetres(misfits[likely]),
        "the numbers are in another unit (--map=x_m=HEADER,… where they are in m), or one reading stands in "
        "all rows");
  }
  for (size_t i = 0; i < plans.size(); ++i) {
    if (i == best || misfits[i] > kBetter * std::max(misfits[best], kComputed) || misfits[i] > tolerance) continue;
    throw InputError(
        {table.path, table.header_line, ""},
        "the columns can be read in two ways, which fit equally well: " + plans[best].choice + "; " + plans[i].choice,
        "--map=… says which, as in --map=x_mm=1,q1_deg=4");
  }
  // Of several readings one fits: that is evidence, and stays a guess.
  return {plans[best], misfits[best], is_of_most};
}

namespace {

// Another order of the points: each row gets that of its marker and station at the pose half of them away, so that the
// joint values are others, however often the poses are repeated. Those of a marker that was seen at one pose stay.
TextTable WithPointsMoved(const TextTable& table, const ImportPlan& plan) {
  struct Seen {
    std::map<std::string, size_t> pose_of;   // by joint values, in their order
    std::vector<std::vector<size_t>> rows;   // of each pose
    std::vector<std::array<size_t, 3>> own;  // row, its pose, which of the pose's rows it is
  };
  std::map<std::string, Seen> seen;  // by marker and station
  for (size_t r = 0; r < table.rows.size(); ++r) {
    std::string whose, joints;
    for (const PlannedColumn& column : plan.columns) {
      const std::string& cell = table.rows[r].cells[static_cast<size_t>(column.source)];
      if (column.stem == "marker" || column.stem == "station") whose += PartOfName(cell, column.part) + ";";
      if (column.stem[0] == 'q') joints += cell + ";";
    }
    Seen& own = seen[whose];
    const size_t pose = own.pose_of.emplace(joints, own.rows.size()).first->second;
    if (pose == own.rows.size()) own.rows.emplace_back();
    own.own.push_back({r, pose, own.rows[pose].size()});
    own.rows[pose].push_back(r);
  }
  TextTable moved = table;
  for (const auto& [whose, own] : seen) {
    for (const auto& [r, pose, repeat] : own.own) {
      const std::vector<size_t>& others = own.rows[(pose + own.rows.size() / 2) % own.rows.size()];
      const TextTable::Row& other = table.rows[others[repeat % others.size()]];
      for (const char* axis : {"x", "y", "z"}) {
        const PlannedColumn& column = *plan.Find(axis);
        for (const int c : {column.source, column.second}) {
          if (c >= 0) moved.rows[r].cells[static_cast<size_t>(c)] = other.cells[static_cast<size_t>(c)];
        }
      }
    }
  }
  return moved;
}

}  // namespace

void ConfirmOrder(const Robot& robot, const TextTable& table, const Choice& choice) {
  if (!table.joined_in_order) return;
  const std::string hint = "the names of the poses next to the readings";
  if (!std::isfinite(choice.misfit)) {
    throw InputError({table.path, table.header_line, ""},
                     "nothing says that the readings are in the order of the poses, and so few rows (" +
                         std::to_string(table.rows.size()) + ") do not confirm it",
                     hint);
  }
  const TextTable moved = WithPointsMoved(table, choice.plan);
  double misfit = MisfitOf(robot, moved, choice.plan);
  if (choice.misfit_is_of_most) misfit = MisfitOfMost(robot, moved, choice.plan).value_or(misfit);
  if (misfit >= kBetter * choice.misfit) return;
  throw InputError({table.path, table.header_line, ""},
                   "nothing says that the readings are in the order of the poses: the nominal robot misses them by " +
                       InMillimetres(choice.misfit) + ", and in another order by " + InMillimetres(misfit) + " (RMS)",
                   hint);
}

// Positions that the nominal robot reproduces were computed from its joints.
void RefuseComputedPoints(const Robot& robot, const TextTable& table, const Choice& choice, bool is_mapped) {
  if (is_mapped || !std::isfinite(choice.misfit)) return;
  const std::string agree = "the points agree with the nominal robot to " + InMillimetres(choice.misfit);
  const std::string hint =
      "name the measured columns: --map=x_mm=HEADER,y_mm=HEADER,z_mm=HEADER; if these are, name them";
  const InputError::Where where = {table.path, table.header_line, ""};
  if (choice.misfit <= kComputed) throw InputError(where, agree + ": they were computed, not measured", hint);
  if (choice.misfit > SuspiciousMisfit(robot.chain)) return;  // far more than digits that are left out
  const double rounding = kRounded * MisfitOfRounding(robot, table, choice.plan);
  if (!std::isfinite(rounding) || choice.misfit > rounding) return;
  throw InputError(
      where, agree + ", as far as the digits of joint values and points go: they were computed, not measured", hint);
}

std::string InDegrees(double radians) { return Significant(radians / kDegree, 3) + " deg"; }

namespace {

// The plan with its rotation read in one way.
ImportPlan WithRotation(ImportPlan plan, const RotationReading& reading) {
  size_t part = 0;
  for (PlannedColumn column : plan.rotation_columns) {
    if (column.unit.empty()) column.unit = reading.unit;
    if (reading.scalar_is_last) column.stem = std::string("o") + "xyzw"[part++];
    plan.columns.push_back(column);
  }
  plan.rotation_columns.clear();
  plan.rotation = reading;
  return plan;
}

// A sample of the rows with the pose of each frame as the aligned nominal robot has it.
class RotationFit {
 public:
  RotationFit(const Robot& robot, const TextTable& table, const ImportPlan& points) : robot_(robot), table_(table) {
    try {
      const Measurements data = Sample(points);
      problem_.emplace(ProblemOfGeometry(robot, data));
      orientations_ = AlignedOrientations(*problem_);
    } catch (const InputError&) {  // too few rows
    }
  }

  bool HasOrientations() const { return !orientations_.empty(); }

  std::vector<TargetRotation> Read(const ImportPlan& plan) const {
    const Measurements data = Sample(plan);
    std::vector<TargetRotation> readings;
    size_t k = 0;
    for (const Observation& observation : data.observations) {
      if (!observation.is_point()) continue;
      const Matrix3<double>& frame = orientations_.at(k++);
      if (observation.partner < 0) continue;
      readings.push_back({observation.marker, frame,
                          data.observations[static_cast<size_t>(observation.partner)].rotation().in_station});
    }
    return readings;
  }

 private:
  Measurements Sample(const ImportPlan& plan) const { return SampleOfTable(robot_, table_, plan); }

  const Robot& robot_;
  const TextTable& table_;
  std::optional<CalibrationProblem> problem_;
  std::vector<Matrix3<double>> orientations_;
};

// The largest angle between two readings of the same rows.
double LargestAngle(const std::vector<TargetRotation>& a, const std::vector<TargetRotation>& b) {
  double largest = a.size() == b.size() ? 0.0 : std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    const Matrix3<double> turn = a[i].station_from_target * b[i].station_from_target.transpose();
    largest = std::max(largest, RotationVector(turn).norm());
  }
  return largest;
}

void LeaveRotationOut(const TextTable& table, const std::string& why, ImportPlan* plan) {
  if (!plan->has_header) {
    throw InputError({table.path, table.header_line, ""},
                     "the table has no header, and the columns other than joints and x, y, z are no rotation: " + why,
                     "--map=x_mm=1,q1_deg=4,… says which columns are what");
  }
  for (const PlannedColumn& column : plan->rotation_columns) plan->unused.emplace_back(column.header, why);
  plan->rotation_columns.clear();
}

// What the user or the columns leave open.
std::vector<RotationReading> RotationCandidates(const ImportPlan& plan, const std::string& stated) {
  std::vector<RotationReading> candidates =
      PossibleRotations(plan.HasQuaternion(), plan.rotation_columns[0].unit, !plan.has_header);
  if (plan.HasQuaternion()) return candidates;
  const bool is_named = !stated.empty() || plan.rotation_is_mapped;
  const RotationReading named = is_named ? RotationNamed(stated.empty() ? "vector" : stated) : RotationReading();
  const auto differs = [&named](const RotationReading& reading) {
    return reading.kind != named.kind || reading.order != named.order || reading.is_inverse;
  };
  if (is_named) candidates.erase(std::remove_if(candidates.begin(), candidates.end(), differs), candidates.end());
  return candidates;
}

// Our own names say what they mean (docs/FORMATS.md, section 2).
bool IsStatedByName(const ImportPlan& plan, const RotationReading& reading) {
  if (reading.is_inverse || reading.kind == RotationReading::Kind::kProduct) return false;
  if (reading.kind == RotationReading::Kind::kQuaternion) return plan.has_header;
  return plan.rotation_columns[0].header == "rx_" + reading.unit;
}

}  // namespace

void DecideRotation(const Robot& robot, const TextTable& table, const std::string& stated, Choice* choice) {
  ImportPlan& plan = choice->plan;
  const bool is_said = !stated.empty() || plan.rotation_is_mapped;
  if (plan.rotation_columns.empty()) {
    if (stated.empty()) return;
    throw InputError({table.path, table.header_line, "--rotation"}, "the table has no three angles of a rotation",
                     "--map=rx_deg=HEADER,ry_deg=HEADER,rz_deg=HEADER names them");
  }
  const RotationFit fit(robot, table, plan);
  const std::vector<RotationReading> candidates = RotationCandidates(plan, stated);
  if (!fit.HasOrientations()) {
    if (!is_said || candidates.size() != 1) return LeaveRotationOut(table, "too few rows to know what it means", &plan);
    plan = WithRotation(plan, candidates[0]);
    return;
  }
  std::vector<std::vector<TargetRotation>> read;
  std::vector<double> misfits;
  for (const RotationReading& candidate : candidates) {
    read.push_back(fit.Read(WithRotation(plan, candidate)));
    misfits.push_back(RotationMisfit(read.back()));
  }
  const size_t best = static_cast<size_t>(std::min_element(misfits.begin(), misfits.end()) - misfits.begin());
  const RotationReading& reading = candidates[best];
  if (!(misfits[best] < kRotationFits)) {
    const std::string why = "as " + reading.Words() + " it misses the nominal robot by " + InDegrees(misfits[best]);
    if (is_said) {
      throw InputError(
          {table.path, table.header_line, plan.rotation_columns[0].header}, why,
          stated.empty() && !plan.HasQuaternion()
              ? "--rotation=RzRyRx (roll, pitch, yaw), RxRyRz, … says what the angles mean; without it they "
                "are a rotation vector"
              : "");
    }
    return LeaveRotationOut(table, "as no kind of rotation does it fit the robot: " + why, &plan);
  }
  for (size_t i = 0; i < candidates.size(); ++i) {
    if (misfits[i] > kBetter * misfits[best] || LargestAngle(read[i], read[best]) < misfits[best]) continue;
    return LeaveRotationOut(
        table, "it can be " + reading.Words() + " or " + candidates[i].Words() + "; --rotation=… says it", &plan);
  }
  const auto open = std::find_if(plan.rotation_columns.begin(), plan.rotation_columns.end(),
                                 [](const PlannedColumn& column) { return column.unit.empty(); });
  const bool unit_is_open = open != plan.rotation_columns.end();
  if (!is_said && !IsStatedByName(plan, reading)) {
    plan.guesses.push_back("the rotation is " + reading.Words() + ", the only reading that fits the robot (" +
                           InDegrees(misfits[best]) + ")");
  } else if (unit_is_open) {
    plan.guesses.push_back("angles of the rotation are in " + reading.unit + ": the header does not say");
  }
  plan = WithRotation(plan, reading);
  choice->rotation_misfit = misfits[best];
}

RobotReading ReadRobotWithReadings(const std::string& path, const RobotReadOptions& options, const TextTable& table,
                                   const std::map<std::string, std::string>& columns) {
  RobotReadOptions open = options;
  open.leave_convention_open = true;
  RobotReading reading = ReadAnyRobot(path, open);
  if (!reading.convention_is_open) return reading;
  std::vector<std::pair<double, DhConvention>> fits;
  for (const DhConvention convention : ChoicesOf<DhConvention>()) {
    RobotReadOptions as = options;
    as.convention = convention;
    const Robot robot = ReadAnyRobot(path, as).robot;
    double misfit = std::numeric_limits<double>::infinity();
    try {
      misfit = ChoosePlan(robot, table, PossiblePlans(table, robot.chain.joints, columns), IfNoneFits::kTryMost).misfit;
    } catch (const InputError&) {  // with this convention the robot cannot have made the readings
    }
    fits.emplace_back(misfit, convention);
  }
  std::sort(fits.begin(), fits.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  // Where the readings do not decide, the table's shape has to.
  if (!(kBetter * fits[0].first < fits[1].first)) return ReadAnyRobot(path, options);
  RobotReadOptions as = options;
  as.convention = fits[0].second;
  reading = ReadAnyRobot(path, as);
  const std::string other =
      std::isinf(fits[1].first) ? "cannot have made the readings" : "misses them by " + InMillimetres(fits[1].first);
  reading.guesses.push_back(
      fmt::format("convention: {}, whose nominal geometry misses the readings by {}; the {} one {}",
                  WordOf(fits[0].second), InMillimetres(fits[0].first), WordOf(fits[1].second), other));
  return reading;
}

}  // namespace sagitta

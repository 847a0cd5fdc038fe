#include "estimator/results/compensation_csv.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "estimator/results/known_loads.h"
#include "estimator/results/remembering_effects.h"
#include "estimator/results/residuals_csv.h"
#include "models/constants.h"
#include "models/effects/catalogue.h"
#include "problems/input_error.h"
#include "problems/problem_checks.h"
#include "problems/structure_checks.h"
#include "problems/text.h"

namespace sagitta {
namespace {

class ColumnWriter {
 public:
  explicit ColumnWriter(size_t rows) : rows_(rows) {}
  std::string& Cell(const std::string& name, size_t row) {
    for (AddedColumn& column : columns_) {
      if (column.name == name) return column.cells[row];
    }
    columns_.push_back({name, std::vector<std::string>(rows_)});
    return columns_.back().cells[row];
  }
  void Number(const std::string& name, size_t row, double value, bool known) {
    Cell(name, row) = known && std::isfinite(value) ? FormatNumber(value) : "";
  }
  const std::vector<AddedColumn>& columns() const { return columns_; }

 private:
  size_t rows_;
  std::vector<AddedColumn> columns_;
};

}  // namespace

Chain NominalChain(const KnownRobot& known) {
  if (known.robot.controller) return known.robot.controller->chain;
  const ForwardModel model(known.robot);
  std::map<std::string, double> errors;
  for (const ModelParameter& parameter : model.parameters()) {
    const auto found = known.parameters.find(parameter.name);
    if (parameter.law != ParameterLaw::kGeometry || found == known.parameters.end()) continue;
    // The embedded robot carries geometric errors in its nominal values.
    errors[model.chain().transforms[parameter.index].error] = found->second.nominal - found->second.value;
  }
  return WithGeometricErrors(known.robot, errors).chain;
}

const std::string& StationOfTargets(const KnownRobot& known) {
  if (known.base_in_station.empty()) throw InputError({known.file, 0, "stations"}, "the estimate has no station");
  return known.base_in_station.begin()->first;
}

namespace {

Robot WithEffectsOfTheArm(const KnownRobot& known) {
  Robot robot = known.robot;
  const auto is_of_the_arm = [&](const EffectSpec& spec) { return MovesTheArm(*FindEffect(known.robot, spec.effect)); };
  const auto others = std::stable_partition(robot.effects.begin(), robot.effects.end(), is_of_the_arm);
  robot.effects.erase(others, robot.effects.end());
  return robot;
}

// Whether this effect lacks anything that a time would give it. untimed: conditions without a time.
bool NeedsTime(const CalibrationProblem& problem, const EffectSpec& spec, const ShotConditions& untimed) {
  ShotConditions timed = untimed;
  timed.has_time = true;
  const auto lacking = [&](const ShotConditions& shot) {
    const EffectContext context{&problem.robot(), &spec, &shot, &problem.data().markers, 0};
    return MissingColumn(*FindEffect(problem.robot(), spec.effect), context);
  };
  return lacking(untimed) != lacking(timed);
}

// Targets are gone to after all that was measured: where none states a time, what happened at a moment has happened. An
// effect that goes on with time still needs it.
void SetAfterMoments(CalibrationProblem* problem) {
  std::vector<ShotInput>& shots = *problem->mutable_shot_inputs();
  const auto has_time = [](const ShotInput& shot) { return shot.conditions.has_time; };
  if (shots.empty() || std::any_of(shots.begin(), shots.end(), has_time)) return;
  std::optional<double> last;
  for (const EffectSpec& spec : problem->robot().effects) {
    if (!NeedsTime(*problem, spec, shots[0].conditions)) continue;
    const std::string setting = MomentOf(problem->robot(), spec);
    if (setting.empty()) return;
    last = std::max(last.value_or(0.0), spec.NumberSetting(setting, 0.0));
  }
  if (!last) return;
  for (ShotInput& shot : shots) {
    shot.conditions.time = std::nextafter(*last, kInfinity);
    shot.conditions.has_time = true;
  }
  problem->model().Prepare(&shots);
}

void CheckColumnsOfTargets(const CalibrationProblem& problem, TargetsFrom from) {
  const std::string otherwise = "calibrate without the effect";
  if (from == TargetsFrom::kTable) return CheckEffectColumns(problem, otherwise);
  const std::optional<NeededColumn> needed = ColumnOfAnEffect(problem);
  if (!needed) return;
  const std::string program = problem.data().files.empty() ? "" : problem.data().files[0].path;
  throw InputError(
      {program, 0, ""}, needed->effect + " needs " + needed->column + ", which no robot program states",
      "correct a table of its points with this column (sagitta compensate ESTIMATE.json TARGETS.csv), or " + otherwise);
}

}  // namespace

CompensationInput MakeCompensationInput(const KnownRobot& known, const Targets& targets, TargetsFrom from) {
  if (targets.shots.shots.size() != targets.rows.size()) {
    throw InputError({},
                     "targets: " + std::to_string(targets.rows.size()) + " rows and " +
                         std::to_string(targets.shots.shots.size()) + " shots, each row needs its shot",
                     "read them by TargetsFromTable");
  }
  CheckStructure(known.robot, targets.shots, MarkerlessRows::kAllowed);
  for (const std::string& name : targets.shots.stations) {
    if (known.base_in_station.count(name) > 0) continue;
    std::vector<std::string> names;
    for (const auto& [station, pose] : known.base_in_station) names.push_back(station);
    const std::string file = targets.shots.files.empty() ? "" : targets.shots.files[0].path;
    throw InputError({file, 0, "station"}, "no pose of station '" + name + "' in " + known.file,
                     SpellingHint(name, names));
  }
  CheckLoadsAreKnown(known, targets.shots);
  CompensationInput input{
      MakeKnownProblem(WithEffectsOfTheArm(known), targets.shots, known.loading, {known.base_in_station, {}}),
      NominalChain(known),
      known.uncertainty,
      known.rest,
      known.noise.freedom,
      FlangeFromMarkers(known.markers, known.uncertainty.Names())};
  SetAfterMoments(&input.problem);
  CheckColumnsOfTargets(input.problem, from);
  return input;
}

namespace {

// The mirrored rotation in the form of the targets (RotationForm).
struct NamedNumbers {
  std::vector<std::string> names;
  Eigen::VectorXd values;
};

NamedNumbers RotationAs(RotationForm form, const Matrix3<double>& rotation) {
  const Vector3<double> rpy = RpyFromRotation(rotation) / kDegree;
  Eigen::Quaterniond q(rotation);
  if (q.w() < 0.0) q.coeffs() *= -1.0;
  switch (form) {
    case RotationForm::kVector:
      break;
    case RotationForm::kQuaternion:
      return {{"ow_cmd", "ox_cmd", "oy_cmd", "oz_cmd"}, Eigen::Vector4d(q.w(), q.x(), q.y(), q.z())};
    case RotationForm::kAbc:
      return {{"a_cmd_deg", "b_cmd_deg", "c_cmd_deg"}, rpy.reverse()};
    case RotationForm::kRollPitchYaw:
      return {{"roll_cmd_deg", "pitch_cmd_deg", "yaw_cmd_deg"}, rpy};
  }
  return {{"rx_cmd_mrad", "ry_cmd_mrad", "rz_cmd_mrad"}, 1e3 * RotationVector(Eigen::Quaterniond(rotation))};
}

}  // namespace

std::string CompensationToCsv(const Targets& targets, const std::vector<CompensatedTarget>& results) {
  ColumnWriter out(results.size());
  for (size_t i = 0; i < results.size(); ++i) {
    const CompensatedTarget& r = results[i];
    const bool solved = r.solution.status != TargetStatus::kEquilibriumDiverged;
    out.Cell("status", i) = StatusName(r.solution.status);
    for (int j = 0; j < r.solution.q.size(); ++j) {
      const bool turns = targets.joint_types[j] == JointType::kRevolute;
      const std::string name = "q" + std::to_string(j + 1) + (turns ? "_cmd_deg" : "_cmd_mm");
      out.Number(name, i, r.solution.q[j] / (turns ? kDegree : 1e-3), solved);
    }
    const NamedNumbers rotation = RotationAs(targets.rotation_form, r.commanded.rotation);
    for (int a = 0; a < 3; ++a) {
      out.Number(std::string(1, "xyz"[a]) + "_cmd_mm", i, 1e3 * r.commanded.translation[a], solved);
    }
    for (size_t a = 0; a < rotation.names.size(); ++a) {
      out.Number(rotation.names[a], i, rotation.values[static_cast<Eigen::Index>(a)], solved);
    }
    out.Number("u95_mm", i, 1e3 * r.u95_position, solved);
    out.Number("u95_mrad", i, 1e3 * r.u95_rotation, solved);
    out.Number("left_mm", i, 1e3 * r.solution.left_position, solved);
    out.Number("left_mrad", i, 1e3 * r.solution.left_rotation, solved);
    out.Number("before_mm", i, 1e3 * r.before_position, solved);
    out.Number("before_mrad", i, 1e3 * r.before_rotation, solved);
    out.Number("smallest_singular_value", i, r.solution.least_singular, solved);
    out.Cell("words", i) = r.words;
  }
  return RowsToCsv(targets.shots, out.columns());
}

}  // namespace sagitta

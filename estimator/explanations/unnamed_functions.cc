#include "estimator/explanations/unnamed_functions.h"

#include <cmath>

#include "estimator/explanations/driver_functions.h"
#include "estimator/explanations/unnamed_list.h"

namespace sagitta {
namespace {

constexpr double kAlike = 1e-3;  // of the largest: directions of functions that add less are dropped

// As the setting `by` names it; "" where none does.
const char* SettingOf(DriverKind kind) {
  switch (kind) {
    case DriverKind::kAngle:
    case DriverKind::kTravel:
      return "q";
    case DriverKind::kTorque:
      return "torque_Nm";
    case DriverKind::kTime:
      return "time_s";
    case DriverKind::kTemperature:
      return "temperature_K";
    case DriverKind::kOther:
      break;
  }
  return "";
}

}  // namespace

void GroupedFunctions::Append(const Eigen::MatrixXd& more, const std::string& kind, const Settings& settings,
                              const std::string& effect, double listed) {
  const long before = columns.cols();
  columns.conservativeResize(more.rows(), before + more.cols());
  columns.rightCols(more.cols()) = more;
  groups.push_back({kind, static_cast<int>(before), static_cast<int>(more.cols()), settings, effect, listed});
  few_ = nullptr;
}

const std::shared_ptr<const Compressed>& GroupedFunctions::Few() const {
  if (!few_) few_ = std::make_shared<const Compressed>(Compress(columns, kAlike));
  return few_;
}

Settings VectorSettings(const std::string& before, const Vector3<double>& vector, const std::string& after) {
  Settings settings;
  for (int axis = 0; axis < 3; ++axis) settings[before + "xyz"[axis] + after] = AsSetting(vector[axis]);
  return settings;
}

UnnamedList::UnnamedList(const CalibrationProblem& problem, EvidenceColumns* columns)
    : problem_(problem), columns_(columns), fitted_(FittedShots(problem)) {}

bool UnnamedList::Smooth(const Eigen::VectorXd& x, const std::string& kind, GroupedFunctions* functions) const {
  if (!RangeOf(x).Varies()) return false;
  for (const int count : kUnnamedBumps) AppendBumps(x, kind, count, functions);
  return true;
}

void UnnamedList::AppendBumps(const Eigen::VectorXd& x, const std::string& kind, int count,
                              GroupedFunctions* functions) const {
  const Range range = RangeOf(x);
  functions->Append(OverKnots(x, {range.low, range.high, count}), kind, {{"knots", std::to_string(count)}});
}

void UnnamedList::AppendRamps(const Eigen::VectorXd& time, int count, GroupedFunctions* functions) const {
  const Range range = RangeOf(time);
  functions->Append(OverKnots(time, {range.low, range.high, count, true}), "time",
                    {{"knots", std::to_string(count)}, {"shape", "ramps"}});
}

EffectSpec UnnamedList::Over(const Driver& driver, const std::string& effect, const std::string& target) const {
  const Range range = RangeOf(driver.of_shot);
  EffectSpec spec{effect, target, {{"by", SettingOf(driver.kind)}}, {}};
  spec.settings["from"] = AsSetting(range.low);
  spec.settings["to"] = AsSetting(range.high);
  if (driver.kind == DriverKind::kAngle || driver.kind == DriverKind::kTravel) spec.settings["driver"] = driver.name;
  return spec;
}

void UnnamedList::AddFunctions(const GroupedFunctions& functions, const UnnamedFunction& what,
                               const std::string& family) {
  if (functions.groups.empty()) return;
  functions.Few();  // once for all
  AddEach(std::vector<GroupedFunctions>(what.sources.size(), functions), what, family);
}

void UnnamedList::AddEach(const std::vector<GroupedFunctions>& of_source, const UnnamedFunction& what,
                          const std::string& family, bool together) {
  if (of_source.empty()) return;
  std::vector<int> own;
  for (size_t s = 0; s < of_source.size(); ++s) {
    const std::shared_ptr<const Compressed>& few = of_source[s].Few();
    for (const int column : columns_->Add({what.sources[s], {few, &few->basis}})) own.push_back(column);
  }
  const long lists = together ? 1 : of_source.size();  // of coefficients
  for (const GroupedFunctions::Group& group : of_source[0].groups) {
    ColumnGroup columns{own, Eigen::MatrixXd::Zero(own.size(), group.count * lists)};
    long top = 0, left = 0;
    for (const GroupedFunctions& functions : of_source) {
      const Eigen::MatrixXd mixing = functions.Few()->mixing.middleCols(group.first, group.count);
      columns.mixing.block(top, left, mixing.rows(), mixing.cols()) = mixing;
      top += mixing.rows();
      if (!together) left += mixing.cols();
    }
    UnnamedFunction function = what;
    function.kind = group.kind;
    for (EffectSpec& effect : function.effects) {
      if (!group.effect.empty()) effect = {group.effect, effect.target, {}, {}};
      effect.settings.insert(group.settings.begin(), group.settings.end());
    }
    list_.push_back({std::move(columns), std::move(function), family, group.listed});
  }
}

std::vector<UnnamedGroup> ListUnnamed(const CalibrationProblem& problem, const ParameterSet& parameters,
                                      EvidenceColumns* columns) {
  std::vector<UnnamedGroup> list = ListUnnamedJoints(problem, parameters, columns);
  for (UnnamedGroup& group : ListUnnamedPlaces(problem, parameters, columns)) list.push_back(std::move(group));
  for (UnnamedGroup& group : ListUnnamedReadings(problem, columns)) list.push_back(std::move(group));
  return list;
}

}  // namespace sagitta

#include "estimator/explanations/unnamed_functions.h"

#include <cmath>

#include "estimator/explanations/driver_functions.h"
#include "estimator/explanations/unnamed_list.h"
#include "problems/text.h"

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

UnnamedList::UnnamedList(const CalibrationProblem& problem, EvidenceColumns* columns)
    : problem_(problem), columns_(columns), fitted_(FittedShots(problem)) {}

bool UnnamedList::Smooth(const Eigen::VectorXd& x, const std::string& kind, GroupedFunctions* functions) const {
  const Eigen::VectorXd fitted = OnFitted(x);
  const double low = fitted.minCoeff(), high = fitted.maxCoeff();
  if (!(high - low > 1e-9 * (1.0 + std::abs(high)))) return false;
  for (const int count : kUnnamedBumps) AppendBumps(x, kind, count, functions);
  return true;
}

void UnnamedList::AppendBumps(const Eigen::VectorXd& x, const std::string& kind, int count,
                              GroupedFunctions* functions) const {
  const Eigen::VectorXd fitted = OnFitted(x);
  functions->Append(Bumps(x, fitted.minCoeff(), fitted.maxCoeff(), count), kind, {{"knots", std::to_string(count)}});
}

void UnnamedList::AppendRamps(const Eigen::VectorXd& order, const std::string& kind, int count,
                              GroupedFunctions* functions) const {
  const Eigen::VectorXd fitted = OnFitted(order);
  functions->Append(Ramps(order, fitted.minCoeff(), fitted.maxCoeff(), count), kind,
                    {{"knots", std::to_string(count)}, {"shape", "ramps"}});
}

EffectSpec UnnamedList::Over(const Driver& driver, const std::string& effect, const std::string& target) const {
  const Eigen::VectorXd seen = OnFitted(driver.of_shot);
  EffectSpec spec{effect, target, {{"by", SettingOf(driver.kind)}}, {}};
  spec.settings["from"] = Significant(seen.minCoeff(), kDigits);
  spec.settings["to"] = Significant(seen.maxCoeff(), kDigits);
  if (driver.kind == DriverKind::kAngle || driver.kind == DriverKind::kTravel) spec.settings["driver"] = driver.name;
  return spec;
}

Settings UnnamedList::DownSettings(const Vector3<double>& down_in_base) {
  return {{"down_x", Significant(down_in_base.x(), kDigits)},
          {"down_y", Significant(down_in_base.y(), kDigits)},
          {"down_z", Significant(down_in_base.z(), kDigits)}};
}

void UnnamedList::AddFunctions(const GroupedFunctions& functions, const UnnamedFunction& what,
                               const std::string& family) {
  if (functions.groups.empty()) return;
  functions.Few();  // once for all
  AddEach(std::vector<GroupedFunctions>(what.sources.size(), functions), what, family);
}

void UnnamedList::AddEach(const std::vector<GroupedFunctions>& of_source, const UnnamedFunction& what,
                          const std::string& family) {
  std::vector<int> own;
  for (size_t s = 0; s < of_source.size(); ++s) {
    const std::shared_ptr<const Compressed>& few = of_source[s].Few();
    for (const int column : columns_->Add({what.sources[s], {few, &few->basis}})) own.push_back(column);
  }
  for (size_t g = 0; !of_source.empty() && g < of_source[0].groups.size(); ++g) {
    const GroupedFunctions::Group& group = of_source[0].groups[g];
    ColumnGroup columns{
        own, Eigen::MatrixXd::Zero(static_cast<long>(own.size()), group.count * static_cast<long>(of_source.size()))};
    long top = 0, left = 0;
    for (const GroupedFunctions& functions : of_source) {
      const Eigen::MatrixXd mixing = functions.Few()->mixing.middleCols(group.first, group.count);
      columns.mixing.block(top, left, mixing.rows(), mixing.cols()) = mixing;
      top += mixing.rows();
      left += mixing.cols();
    }
    Append(std::move(columns), group, what, family);
  }
}

void UnnamedList::AddTogether(const std::vector<GroupedFunctions>& of_source, const UnnamedFunction& what,
                              const std::string& family) {
  std::vector<int> own;
  long height = 0;
  for (size_t s = 0; s < of_source.size(); ++s) {
    const std::shared_ptr<const Compressed>& few = of_source[s].Few();
    height += few->basis.cols();
    for (const int column : columns_->Add({what.sources[s], {few, &few->basis}})) own.push_back(column);
  }
  for (size_t g = 0; g < of_source[0].groups.size(); ++g) {
    const GroupedFunctions::Group& group = of_source[0].groups[g];
    ColumnGroup columns{own, Eigen::MatrixXd(height, group.count)};
    long top = 0;
    for (const GroupedFunctions& functions : of_source) {
      const Eigen::MatrixXd mixing = functions.Few()->mixing.middleCols(group.first, group.count);
      columns.mixing.middleRows(top, mixing.rows()) = mixing;
      top += mixing.rows();
    }
    Append(std::move(columns), group, what, family);
  }
}

void UnnamedList::Append(ColumnGroup columns, const GroupedFunctions::Group& group, const UnnamedFunction& what,
                         const std::string& family) {
  UnnamedFunction function = what;
  function.kind = group.kind;
  for (EffectSpec& effect : function.effects) {
    if (!group.effect.empty()) effect = {group.effect, effect.target, {}, {}};
    effect.settings.insert(group.settings.begin(), group.settings.end());
  }
  list_.push_back({std::move(columns), std::move(function), family, group.listed});
}

std::vector<UnnamedGroup> ListUnnamed(const CalibrationProblem& problem, const ParameterSet& parameters,
                                      EvidenceColumns* columns) {
  std::vector<UnnamedGroup> list = ListUnnamedJoints(problem, parameters, columns);
  for (UnnamedGroup& group : ListUnnamedPlaces(problem, parameters, columns)) list.push_back(std::move(group));
  for (UnnamedGroup& group : ListUnnamedReadings(problem, columns)) list.push_back(std::move(group));
  return list;
}

}  // namespace sagitta

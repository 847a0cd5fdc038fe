#include "estimator/explanations/unnamed_functions.h"

#include <algorithm>
#include <cmath>

#include "estimator/explanations/driver_functions.h"
#include "estimator/explanations/unnamed_list.h"
#include "models/effects/pose_functions.h"

namespace sagitta {
namespace {

// Jumps in time that go together; of all moments between visits.
constexpr size_t kJumpsInTime[] = {1, 2, 3, 4, 6, 8, 12};
constexpr int kMostMoments = 200;  // of an eight-hour day one in 2.4 minutes, as long as a visit lasts

// Of the largest: directions of functions that add less are dropped. Rows see such a direction only where they see the
// function with a chi-square of 10^6.
constexpr double kAlike = 1e-3;

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

// Of each effect one with each of these settings in place of its own.
std::vector<EffectSpec> EachWith(const std::vector<EffectSpec>& effects, const std::vector<Settings>& each) {
  std::vector<EffectSpec> all;
  for (const EffectSpec& effect : effects) {
    for (const Settings& settings : each) {
      all.push_back(effect);
      for (const auto& [name, value] : settings) all.back().settings[name] = value;
    }
  }
  return all;
}

// Ways to choose k of n.
double Ways(size_t n, size_t k) {
  double ways = 1.0;
  for (size_t i = 0; i < k; ++i) ways *= static_cast<double>(n - i) / static_cast<double>(i + 1);
  return ways;
}

}  // namespace

void GroupedFunctions::Append(const Eigen::MatrixXd& more, const std::string& kind, const Settings& settings,
                              const std::string& effect, double listed, const std::vector<Settings>& each) {
  const long before = columns.cols();
  columns.conservativeResize(more.rows(), before + more.cols());
  columns.rightCols(more.cols()) = more;
  groups.push_back({kind, static_cast<int>(before), static_cast<int>(more.cols()), settings, effect, listed, each});
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

UnnamedList::Field UnnamedList::FieldOf(const std::vector<bool>& is_in) const {
  Field field{Eigen::MatrixXd::Zero(is_in.size(), 3), {}};
  Eigen::RowVector3d middle = Eigen::RowVector3d::Zero();
  double count = 0.0, square = 0.0;
  for (size_t s = 0; s < is_in.size(); ++s) {
    field.places.row(s) = FlangePlace(problem_.robot().chain, problem_.shot_inputs()[s].conditions.q).transpose();
  }
  for (const int s : fitted_) {
    if (is_in[s]) middle += (field.places.row(s) - middle) / ++count;
  }
  for (const int s : fitted_) {
    if (is_in[s]) square += (field.places.row(s) - middle).squaredNorm() / (3.0 * count);
  }
  const double spread = std::max(1e-3, std::sqrt(square));  // m: a flange that stands has no field of places
  for (size_t s = 0; s < is_in.size(); ++s) {
    auto place = field.places.row(s);
    place = is_in[s] ? Eigen::RowVector3d((place - middle) / spread) : Eigen::RowVector3d::Zero();
  }
  field.settings = VectorSettings("", 1e3 * middle.transpose(), "_mm");
  field.settings["spread_mm"] = AsSetting(1e3 * spread);
  return field;
}

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

void UnnamedList::AppendJumpsInTime(const AlongSources& along, size_t fewest, GroupedFunctions* functions) const {
  const Eigen::VectorXd time = TimeOf(problem_).of_shot;
  const size_t places = Gaps(time(fitted_), kMostMoments).size(), most = kJumpsInTime[std::size(kJumpsInTime) - 1];
  const std::vector<std::vector<Gap>> best = BestJumps(along, fitted_, time, kMostMoments, most);
  for (const size_t count : kJumpsInTime) {
    if (count < fewest || count >= best.size()) continue;
    Eigen::MatrixXd jumps(time.size(), static_cast<long>(count));
    std::vector<Settings> settings;
    for (const Gap& gap : best[count]) {
      jumps.col(static_cast<long>(settings.size())) = OverKnots(time, {gap.first, gap.second, 1, true});
      settings.push_back({{"from", AsSetting(gap.first)}, {"to", AsSetting(gap.second)}});
    }
    functions->Append(jumps, "step", {{"knots", "1"}, {"shape", "ramps"}}, "", 1.0 / Ways(places, count), settings);
  }
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
                          const std::string& family, size_t together) {
  if (of_source.empty()) return;
  std::vector<int> own;
  for (size_t s = 0; s < of_source.size(); ++s) {
    const std::shared_ptr<const Compressed>& few = of_source[s].Few();
    for (const int column : columns_->Add({what.sources[s], {few, &few->basis}})) own.push_back(column);
  }
  const long lists = of_source.size() / together;  // of coefficients
  for (const GroupedFunctions::Group& group : of_source[0].groups) {
    ColumnGroup columns{own, Eigen::MatrixXd::Zero(own.size(), group.count * lists)};
    long top = 0;
    for (size_t s = 0; s < of_source.size(); ++s) {
      const Eigen::MatrixXd mixing = of_source[s].Few()->mixing.middleCols(group.first, group.count);
      columns.mixing.block(top, static_cast<long>(s / together) * group.count, mixing.rows(), group.count) = mixing;
      top += mixing.rows();
    }
    UnnamedFunction function = what;
    function.kind = group.kind;
    for (EffectSpec& effect : function.effects) {
      if (!group.effect.empty()) effect = {group.effect, effect.target, {}, {}};
      effect.settings.insert(group.settings.begin(), group.settings.end());
    }
    if (!group.each.empty()) function.effects = EachWith(function.effects, group.each);
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

#include "problems/io/import/open_units.h"

#include <algorithm>
#include <set>

namespace sagitta {
namespace {

void SetUnit(ImportPlan* plan, const std::set<std::string>& stems, const std::string& unit) {
  for (PlannedColumn& column : plan->columns) {
    if (column.unit.empty() && stems.count(column.stem)) column.unit = unit;
  }
}

bool IsOpen(const ImportPlan& plan, const std::set<std::string>& stems) {
  return std::any_of(plan.columns.begin(), plan.columns.end(),
                     [&stems](const PlannedColumn& column) { return column.unit.empty() && stems.count(column.stem); });
}

std::vector<ImportPlan> Opened(const std::vector<ImportPlan>& plans, const std::set<std::string>& stems,
                               const std::vector<std::string>& units, const std::string& what) {
  std::vector<ImportPlan> opened;
  for (const ImportPlan& plan : plans) {
    if (!IsOpen(plan, stems)) {
      opened.push_back(plan);
      continue;
    }
    for (const std::string& unit : units) {
      opened.push_back(plan);
      SetUnit(&opened.back(), stems, unit);
      opened.back().choice += (plan.choice.empty() ? "" : ", ") + what + " in " + unit;
      opened.back().guesses.push_back(what + " are in " + unit + ": the header does not say");
    }
  }
  return opened;
}

}  // namespace

std::vector<ImportPlan> WithOpenUnits(std::vector<ImportPlan> plans, const std::vector<Joint>& joints) {
  std::set<std::string> turning, sliding;
  for (size_t j = 0; j < joints.size(); ++j) {
    (joints[j].type == JointType::kRevolute ? turning : sliding).insert("q" + std::to_string(j + 1));
  }
  plans = Opened(plans, turning, {"deg", "rad"}, "joint angles");
  plans = Opened(plans, sliding, {"mm", "m"}, "sliding joints");
  plans = Opened(plans, {"x", "y", "z"}, {"mm", "m", "in"}, "points");
  for (ImportPlan& plan : plans) {
    const std::set<std::string> sigmas = {"sigma_x", "sigma_y", "sigma_z"};
    if (!IsOpen(plan, sigmas)) continue;
    SetUnit(&plan, sigmas, plan.Find("x")->unit);
    plan.guesses.push_back("standard deviations are in " + plan.Find("x")->unit +
                           " as the points are: the header does not say");
  }
  return plans;
}

}  // namespace sagitta

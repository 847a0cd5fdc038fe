// report.html of a plan: how good it will be, the parameters that are expected, and the arm drawn in each pose.
#pragma once

#include <string>

#include "estimator/planning/plan.h"
#include "estimator/results/estimate_json.h"
#include "models/robot.h"

namespace sagitta {

// cell: null: none is stated.
std::string PlanReportToHtml(const Robot& robot, const Cell* cell, const Plan& plan, const Provenance& provenance);

}  // namespace sagitta

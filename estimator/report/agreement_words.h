// What is said of the agreement between parts of the data.
#pragma once

#include "estimator/estimate/agreement_report.h"
#include "problems/calibration_problem.h"

namespace sagitta {

// Why there is model error.
std::string PartsContradict();

void DescribeAgreement(const CalibrationProblem& problem, AgreementReport* report);

}  // namespace sagitta

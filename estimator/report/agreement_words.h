// What is said of the agreement between parts of the data.
#pragma once

#include "estimator/estimate/agreement_report.h"
#include "problems/calibration_problem.h"

namespace sagitta {

void DescribeAgreement(const CalibrationProblem& problem, AgreementReport* report);

}  // namespace sagitta

#include <sagitta/sagitta.h>

#include <iostream>

int main(int, char** argv) {
  const sagitta::CalibrationProblem problem = sagitta::ReadExperiment({argv[1]});
  const sagitta::Calibration result = sagitta::Calibrate(problem);
  if (!sagitta::IsUsable(result.estimate.status)) return 3;
  std::cout << 1e3 * result.estimate.fit.rms << " mm RMS\n";
  sagitta::WriteCalibration(result, argv[2]);
}

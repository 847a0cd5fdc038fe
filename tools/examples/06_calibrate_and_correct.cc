// From files to corrected joint values in C++. usage: 06_calibrate_and_correct EXPERIMENT.yaml TARGETS.csv
#include <sagitta/sagitta.h>

#include <iostream>

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  try {
    const sagitta::Calibration result = sagitta::Calibrate(sagitta::ReadExperiment({argv[1]}));
    if (!sagitta::IsUsable(result.estimate.status)) return 3;
    std::cout << result.trust.verdict.words << "\n";
    const sagitta::KnownRobot robot = sagitta::KnownFrom(result);
    const sagitta::Targets targets = sagitta::ReadTargets(argv[2], robot.robot, robot.base_in_station.begin()->first);
    const std::vector<sagitta::CompensatedTarget> corrected =
        sagitta::Compensate(sagitta::MakeCompensationInput(robot, targets), targets.rows, 1);
    for (size_t i = 0; i < corrected.size(); ++i) {
      std::cout << targets.rows[i].name << ": " << sagitta::StatusName(corrected[i].solution.status) << ", "
                << 1e3 * corrected[i].before_position << " mm off without it\n";
    }
  } catch (const sagitta::InputError& error) {
    std::cerr << error.what() << "\n";
    return 2;
  }
}

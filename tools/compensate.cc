// sagitta compensate: corrected joint values for targets.
#include <iostream>
#include <map>

#include "estimator/results/compensation_csv.h"
#include "problems/input_error.h"
#include "problems/io/output_files.h"
#include "problems/io/target_file.h"
#include "tools/commands.h"
#include "tools/run_command.h"

namespace sagitta {
namespace {

void Summarise(const std::vector<CompensatedTarget>& results) {
  std::map<std::string, int> count;
  double before = 0.0, after = 0.0, u95 = 0.0;
  int solved = 0;
  for (const CompensatedTarget& result : results) {
    ++count[StatusName(result.solution.status)];
    if (result.solution.status != TargetStatus::kOk && result.solution.status != TargetStatus::kSingular) continue;
    ++solved;
    before = std::max(before, result.before_position);
    after = std::max(after, result.solution.left_position);
    u95 = std::isfinite(result.u95_position) ? std::max(u95, result.u95_position) : u95;
  }
  std::vector<std::string> parts;
  for (const auto& [status, number] : count) parts.push_back(std::to_string(number) + " " + status);
  std::cout << results.size() << " targets: " << Enumerate(parts) << ": " << FLAGS_out << "\n";
  if (solved == 0) return;
  std::cout << "Off target without compensation at most " << Significant(1e3 * before, 3)
            << " mm; with it, as far as the model is true, " << Significant(1e3 * after, 2)
            << " mm; 95 % uncertainty of the estimate at most " << Significant(1e3 * u95, 3) << " mm\n";
}

int RunCompensate(const CommandLine& line) {
  ExpectArguments(line, CompensateCommand(), 2, 2);
  if (FLAGS_out.empty()) throw InputError({"", 0, "--out"}, "where to write is missing", "--out=FILE.csv");
  const OutputFile out(FLAGS_out);
  const KnownRobot known = ReadEstimateFile(line.arguments[0]);
  if (known.base_in_station.empty()) throw InputError({known.file, 0, "stations"}, "the estimate has no station");
  const Targets targets = ReadTargets(line.arguments[1], known.robot, known.base_in_station.begin()->first);
  const CompensationInput input = MakeCompensationInput(known, targets);
  const std::vector<CompensatedTarget> results = Compensate(input, targets.rows, FLAGS_threads);
  const std::string csv = CompensationToCsv(targets, results);
  out.Write(csv);
  Summarise(results);
  const std::string model_error = ModelErrorInWords(known);
  if (!model_error.empty()) std::cout << model_error << " The uncertainties here are multiplied by it.\n";
  const bool any = std::any_of(results.begin(), results.end(), [](const CompensatedTarget& r) {
    return r.solution.status == TargetStatus::kOk || r.solution.status == TargetStatus::kSingular;
  });
  return any ? 0 : kNumericalFailure;
}

}  // namespace

Command CompensateCommand() {
  return {"compensate",
          "corrected joint values for targets",
          R"(sagitta compensate ESTIMATE.json TARGETS.csv --out=FILE.csv

TARGETS has the column target and

  q1_deg …                     joint values at which the nominal robot has the flange where it is wanted, or
  x_mm, y_mm, z_mm, rx_mrad, ry_mrad, rz_mrad   the flange in the base frame (rotation vector); q1_deg … beside
                               them choose the branch, otherwise the row before does, or the first solution found

and, where they matter, load, fx_N … mz_Nm, station, temperature_degC, time_s, approach1 … as in measurement files.
Every row comes back with

  status                       ok, singular (on target, close to a singularity), limit, unreachable,
                               equilibrium_diverged, not_converged
  q1_cmd_deg … (_mm)           corrected joint values: with them the estimated robot, loads included, is on target
  x_cmd_mm … rz_cmd_mrad       the pose to send where the controller keeps its nominal model
  u95_mm, u95_mrad             95 % uncertainty of where the flange then is, from the estimate; repeatability not in it
  left_mm, left_mrad           what is left by the estimated model (below 1e-6 where the status is ok)
  before_mm, before_mrad       how far off the uncompensated robot is
  smallest_singular_value      of the Jacobian, lengths in units of the reach
  words                        what there is to say

Exit status 3 where no target could be reached; the rows are written all the same.

Examples
  sagitta compensate results/estimate.json targets.csv --out=corrected.csv
)",
          {"out", "seed", "threads", "quiet"},
          RunCompensate};
}

}  // namespace sagitta

#include "tools/report/command_words.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <sstream>

#include "estimator/report/diagnosis_words.h"
#include "estimator/report/planning_words.h"
#include "estimator/statistics/distributions.h"
#include "problems/text.h"
#include "tools/report/summary.h"

namespace sagitta {
namespace {

std::string Micrometres(double metres) { return FormatNumber(std::round(metres * 1e6) / 1e3) + " mm"; }

}  // namespace

std::string NothingIsWritten() { return "\nNothing is written; --out=DIR keeps the results.\n"; }

std::string ResultsIn(const std::string& folder, const std::vector<std::string>& files) {
  return "Results in " + folder + (files.empty() ? ":" : ": ") + Joined(files) + "\n";
}

std::string ReplacedThoseOfTheEstimate(const std::vector<std::string>& files) {
  return "Warning: " + Joined(files, " and ") + " of the estimate stood there and are replaced by those of the " +
         "validation; another --out keeps both\n";
}

std::string OlderFilesIn(const std::string& folder, const std::vector<std::string>& files) {
  return "Of an earlier run are in " + folder + ": " + Joined(files) + "; this one has nothing to write there.\n";
}

std::string HowToGoOnWithEffects(const std::vector<std::string>& of_this_campaign) {
  const std::string words =
      "Go on with what was found: sagitta validate, predict and compensate read estimate.json, which has it; ";
  if (of_this_campaign.empty()) return words + "robot.extended.yaml is the robot file for the next measurements.\n";
  return words + kNextRobotFile + " is the robot file for the next measurements: robot.extended.yaml has " +
         Enumerate(of_this_campaign) + " at times that count from the first row of this campaign.\n";
}

std::string ComparisonInWords(const Changes& changes) {
  std::string words = "Predictions are " + Significant(1e3 * changes.before_rms, 3) + " mm apart (RMS)";
  if (!changes.changes.empty()) words += ", " + Significant(1e3 * changes.after_rms, 3) + " mm with that removed";
  words += "\n";
  for (const Change& other : changes.alternatives) {
    words +=
        "possible too: " + WordOf(other.kind) + " " + other.target + " (" + Significant(other.probability, 2) + ")\n";
  }
  return words;
}

std::vector<std::string> MethodsLegend() {
  return {
      "off by sigma: largest deviation of a parameter from the joint optimum, in its standard deviations.",
      "rate: error of one iteration over that of the one before; predicted: c1^2, the largest canonical correlation."};
}

std::vector<std::string> CoverageLegend(int outside, size_t rows) {
  return {
      "not 95 %: the Clopper-Pearson interval of the coverage leaves 95 % out; by chance that happens to one in twenty "
      "(" +
          std::to_string(outside) + " of " + std::to_string(rows) + " here).",
      "bound: Cramér-Rao. same draws: RMSE over that of the linear least squares at the truth on the same draws."};
}

// What is left below a nanometre is the rounding of the solver.
constexpr double kSolved = 1e-9;

std::string CompensationInWords(double before, double after, double u95) {
  return "Off target without compensation at most " + Significant(1e3 * before, 3) +
         " mm; with it, as far as the model is true, " +
         (after < kSolved ? std::string("less than 0.001 µm") : Significant(1e3 * after, 2) + " mm") +
         ", and with the uncertainty of the estimate (95 %) at most " + Significant(1e3 * u95, 3) + " mm\n";
}

std::string FlangeOfTheMarkers() {
  return "The flange is where the markers have it: these figures hold for tools that are measured through the same "
         "markers, its face and bore by drawing are not determined. The base is where the estimate has it, "
         "as the instrument of the target's station finds it: a target that is measured from the foot itself is off by "
         "the error of the base in estimate.json, too.\n";
}

std::string PlanInWords(const Plan& plan) {
  std::ostringstream words;
  words << Plural(static_cast<int>(plan.rows.configurations.size()), "pose");
  if (plan.measured > 0) {
    words << " in addition to the " << plan.measured << " that " << (plan.measured == 1 ? "is" : "are") << " measured";
  }
  words << ", chosen among " << Plural(static_cast<int>(plan.candidates), "candidate");
  if (plan.infeasible > 0)
    words << " (" << plan.infeasible << " more " << (plan.infeasible == 1 ? "is" : "are") << " not feasible)";
  words << ": " << InWords(plan.criterion.kind) << ".\n"
        << "Predicted position error at the " << plan.tests << " test points: RMS "
        << Significant(1e3 * plan.position_rms, 3) << " mm, worst point " << Significant(1e3 * plan.position_max, 3)
        << " mm" << (plan.HasModelError() ? " by noise alone" : ", as far as the model is true") << ".\n";
  if (plan.HasModelError()) {
    words << "With the model error of the former estimate: RMS " << Significant(1e3 * plan.rms_with_model_error, 3)
          << " mm.\n";
  }
  if (plan.criterion.kind == CriterionKind::kDiscriminate) {
    words << "The right one of the effects is expected to have a probability of " << Significant(plan.decides, 2)
          << " after these readings.\n";
  }
  words << CertificateInWords(plan) << "\n";
  return words.str();
}

// Where the normal distribution's factor is a few per cent too small.
std::string CoverageInWords(double noise_dof) {
  constexpr double kWorthSaying = 1.03;  // with fewer than 40 degrees of freedom
  const double factor = noise_dof > 0.0 ? StudentQuantile(0.975, noise_dof) : 0.0;
  if (!(factor > kWorthSaying * NormalQuantile(0.975))) return "";
  return "The noise was found from the residuals with " + Fixed(noise_dof, 0) +
         " degrees of freedom: 95 % are within " + Fixed(factor, 2) + " standard deviations.\n";
}

std::string PredictedInWords(int points, double largest, double noise_dof, const std::string& file) {
  const std::string deviation = std::isfinite(largest) ? "at most " + Fixed(largest, 4) + " mm per axis"
                                                       : "not known: there are no more rows than unknowns";
  return std::to_string(points) + (points == 1 ? " point predicted, its" : " points predicted, their") +
         " standard deviation " + deviation + ": " + file + "\n" + CoverageInWords(noise_dof);
}

std::string SimulatedInWords(int rows, std::uint64_t seed, bool is_exact, const std::string& file) {
  return std::to_string(rows) + " rows simulated with seed " + std::to_string(seed) +
         (is_exact ? ", exact: no standard deviation above 0 is stated" : "") + ": " + file + "\n";
}

std::string AgainstColumns(double reproduced) {
  return "The baseline is the simulation of the columns sim_x_mm, sim_y_mm, sim_z_mm; base and markers stay free. The "
         "robot file reproduces that simulation to " +
         Significant(1e3 * reproduced, 3) + " mm (RMS distance).";
}

std::string FarFromColumns() {
  return "That is far more than the gap: what the simulation knows and the file does not (joint compliances above all) "
         "is "
         "missing from the effects that act through it, such as link weights and springs. Give the simulation's values "
         "in "
         "the robot file.";
}

std::string CorrectionsToSimulation() {
  return "points are measured against another simulation: these are corrections to it";
}

std::string NotACalibratedRobot() {
  return "# The nominal robot with the effects that explain the gap to another simulation (--simulation=columns):\n"
         "# corrections to that simulation, no calibrated robot.\n";
}

std::string LearntFunctionsInFile() {
  return "# With smooth functions learnt from the rows where no effect of the catalogue explains the gap. They are "
         "empirical:\n"
         "# they name no cause, and say nothing beyond the measured ranges.\n";
}

std::string TrialsAreKept(int done, int trials, double covered, const std::string& folder) {
  return "  " + std::to_string(done) + " of " + std::to_string(trials) +
         " trials are done; their 95 % intervals held " + Fixed(100.0 * covered, 1) + " % of the true values. " +
         folder + "/coverage.state.jsonl keeps them: the same command goes on from there.\n";
}

std::string PlainAndExact() { return "the table has no beta: it is plain, and exact"; }

std::string WithoutBeta(double rms, double largest, double largest_length_change) {
  return "without beta the flange is off by " + Micrometres(rms) + " RMS, " + Micrometres(largest) +
         " at most, over the joints' range; the refit moved lengths by up to " + Micrometres(largest_length_change);
}

std::string HashIsMissing() {
  return "the file has no kinematics: hash, which ur_description reads and the driver compares with that of the arm: "
         "--template=calibration.yaml (of this arm) keeps it";
}

std::string KeepControllersLines() {
  return "the controller also wants the lines of its own calibration.conf that belong to the arm (joint_checksum, …): "
         "--template=calibration.conf keeps them";
}

std::string ListsAreReplaced(const std::string& file) {
  return "the four lists of " + file + " are replaced, its other lines kept";
}

std::string MovesAsBefore(double difference) {
  return "read again it moves as before, to " + FormatNumber(std::ceil(1e15 * difference) / 1e12) +
         " mm at 1 m from the flange";
}

std::string CountsFromTurnedAxes(const std::string& effect, double difference) {
  return "the values of " + effect +
         " count from the axes of the joint's own frame, which this description turns: the flange would move otherwise "
         "by up to " +
         Micrometres(difference) + "; nothing is written";
}

std::string KeepItsDescription() {
  return "keep the robot's description (--as=chain), or write it without the effect and estimate that anew";
}

std::string ChainRuns(const std::string& base, const std::string& tip, const std::vector<std::string>& others) {
  const std::string words = "the chain runs from " + base + " to " + tip;
  return others.empty() ? words : words + ", not to " + Enumerate(others, 6) + " (--tip_link says another)";
}

std::string RowsAreNoMeasurements(const std::string& what) {
  return "the rows as they are understood are no measurements: " + what;
}

std::string MimicIsACoupling(const std::string& joint, const std::string& driver) {
  return joint + " mimics " + driver +
         ": a coupling, and its own column is 0, what it moves by itself (ROS publishes what it moves in all)";
}

std::string LeftOutOfFormat(const std::string& what) { return "left out, the format has no place for them: " + what; }

std::string NoShippedTables(const std::vector<std::string>& tried) {
  return fmt::format("the tables of robots that this program ships are not found in {}", fmt::join(tried, " nor in "));
}

std::string WhereTablesAre() {
  return "SAGITTA_DATA_DIR names the folder that holds robots/*.csv; or give the robot as one of the files";
}

std::string OnlyTableThatFits(const std::string& table, const std::string& misfit) {
  return "no robot is given: of the tables that this program ships only '" + table +
         "' can have made the readings (its nominal geometry misses by " + misfit + ")";
}

std::string ColumnsFit(const std::string& misfit) {
  return "the nominal robot, base and marker fitted, misses by " + misfit + " (RMS): the columns fit the robot";
}

std::string ColumnsFitMostRows(const std::string& misfit) {
  return "the nominal robot, base and marker fitted, misses most rows by " + misfit +
         " (RMS): the columns fit the robot; the other rows are far off";
}

std::string ReadingsAreFarOff(size_t all, const std::string& others, size_t far, const std::string& rows) {
  return "of " + std::to_string(all) + " readings " + std::to_string(far) + (far == 1 ? " is" : " are") +
         " far from where the nominal robot has the marker, which misses the others by " + others + " (RMS): " + rows +
         ". They are imported as they are: correct them, or leave out rows that are no readings, such as means.";
}

std::string TorquesAreCarried() {
  return "torques are carried along; 'torques: measured' in experiment.yaml has them drive the compliances";
}

std::string LoadNeedsPoint(const std::string& load) {
  return "Load " + load +
         ": state in experiment.yaml where it hangs, load_point_mm: [x, y, z] on the flange, and, where "
         "no column has its force, loads: {" +
         load + ": {mass_kg: …}}";
}

std::string WeighedLoadNeedsPoint(const std::string& load, double mass) {
  return "Load " + load + ": " + Significant(mass, 6) +
         " kg, as its column says; state in experiment.yaml where it hangs, load_point_mm: [x, y, z] on the flange";
}

std::string RowsLieApart(int line, const std::string& distance) {
  return "of rows with equal joint values, such as this one and line " + std::to_string(line) + ", the points lie " +
         distance + " apart (median): no column says of which marker, load or station they are";
}

std::string TooFewPoses(size_t poses) {
  if (poses == 1) return "all rows have equal joint values: the columns cannot be checked against the robot";
  return "too few different configurations (" + std::to_string(poses) + ") to check the columns against the robot";
}

std::string StationPerFile() {
  return "each file is a station of its own: the instrument may have been moved between them";
}

std::string MarkerPerFile() { return "each file has a marker of its own: the reflector may have been mounted anew"; }

}  // namespace sagitta

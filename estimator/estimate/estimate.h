// What came out: the answer of every method, in SI; estimator/results states it in the units of FORMATS section 4.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "estimator/estimate/agreement_report.h"
#include "estimator/estimate/noise_report.h"
#include "estimator/least_squares/held_influence.h"
#include "estimator/least_squares/identifiability.h"
#include "models/robot.h"
#include "problems/measurements.h"
#include "problems/noise_model.h"
#include "problems/parameter_set.h"

namespace sagitta {

// kNotRun: a method that cannot be asked on these data, in a comparison.
enum class Status {
  kConverged,
  kConvergedWithHeldParameters,
  kNoConvergence,
  kSingular,
  kEquilibriumDiverged,
  kNotRun
};
// "converged", "converged_with_held_parameters", ...
const char* StatusName(Status status);
inline bool IsUsable(Status status) {
  return status == Status::kConverged || status == Status::kConvergedWithHeldParameters;
}

// Unweighted residual sizes, m. RMS and max over single coordinates (divisor
// N); distance_* over 3-D distances, as in the tables of papers 002 and 003.
struct ResidualSize {
  int observations = 0;
  double rms = 0.0;
  double max = 0.0;
  Vector3<double> rms_axis = Vector3<double>::Zero();
  double distance_rms = 0.0;
  double distance_max = 0.0;
  // Of the rotations of poses, rad: over single axes, divisor N; the largest angle.
  int rotations = 0;
  double rotation_rms = 0.0;
  double rotation_max = 0.0;
};
// residuals: 3 x N, m, of points.
ResidualSize MeasureResiduals(const Eigen::Matrix3Xd& residuals);
// Of the listed observations, points and rotations.
ResidualSize MeasureReadings(const Measurements& data, const std::vector<int>& observations,
                             const Eigen::Matrix3Xd& predicted);

// From low to high.
struct Interval {
  double low = 0.0;
  double high = 0.0;
};

// One line of the table: a coordinate with its value and intervals. Methods give all by the noise alone. Where an
// estimate is judged (Calibrate, ExtendedCalibration), model error widens ci95 and the unconditional two, and sigma
// stays as it was: Trust::sigma is the one with model error.
struct ParameterEstimate {
  std::string name;
  Quantity quantity = Quantity::kLength;
  double value = 0.0;    // SI
  double nominal = 0.0;  // SI; geometric errors 0, base and markers the aligned start
  double sigma = 0.0;    // SI, by the noise alone; 0 unless estimated
  Interval ci95;
  bool free = false;                                        // estimated
  bool identifiable = true;                                 // false: held, the data do not determine it
  bool at_bound = false;                                    // the value or its interval meets the physical bound
  double lower = -std::numeric_limits<double>::infinity();  // that bound, SI
  bool weak = false;                                        // known worse than 1 mm, 1 mrad or half its value

  // Student's t of the interval by the noise alone; infinity: normal.
  double dof = std::numeric_limits<double>::infinity();
  // Interval on the condition that held parameters are where they were put; the unconditional one counts what they may
  // do to it (held_influence.h). Of held ones themselves too; equal to sigma and ci95 where nothing is held.
  bool conditional = false;
  std::vector<int> conditional_on;  // held coordinates that widen it, which ci95 assumes to be exact
  double unconditional_sigma = 0.0;
  Interval unconditional_ci95;
  bool open_low = false, open_high = false;  // profile likelihood: no end on that side
};

// How the intervals came about (experiment key `covariance`).
struct IntervalReport {
  CovarianceKind method = CovarianceKind::kModel;
  std::optional<BootstrapKind> kind;  // bootstrap: parametric or configurations
  int clusters = 0;                   // sandwich and bootstrap of configurations
  int replicates = 0;                 // bootstrap: refits used
  int failed = 0;                     // refits that did not converge, ends that did not close
  unsigned long long seed = 0;        // bootstrap
  std::string words;

  // Seen in the residuals of whole configurations instead of scaled into the model's covariance.
  bool is_empirical() const { return method == CovarianceKind::kSandwich || kind == BootstrapKind::kConfigurations; }
};

// What stated priors add to chi-square beyond that of the rows alone, at the noise as it weighs the rows: its
// expectation is their number. Where that is more than chance and the noise of the rows explain, it is set aside: a
// prior that is wrong says nothing of the noise of the rows.
struct PriorPull {
  double squares = 0.0;
  int priors = 0;  // that the rows can contradict
  bool is_set_aside = false;
};

// The noise that the estimate goes by, against what was stated.
struct SigmaReport {
  bool stated = false;        // by rows, experiment or flag, or put in their place before the fit: `origin`
  double estimated = 0.0;     // m, the common sigma where none is stated
  double a_posteriori = 1.0;  // root of reduced chi-square, without what is set aside
  bool scaled = false;        // the noise is assumed to be a_posteriori times the stated sigmas
  double p_value = 1.0;       // of that chi-square at the stated sigmas
  PriorPull pull;
  NoiseOrigin origin = NoiseOrigin::kStated;
  double rotation = 0.0;  // rad, of every axis of rotations that state none, as it was found; 0: none was looked for

  // Residuals made it what it is, before the fit or by it: no residual can contradict it.
  bool IsOfResiduals() const { return !stated || origin == NoiseOrigin::kScaled || origin == NoiseOrigin::kFound; }
};

// m per coordinate: interferometric length measurement in a workshop is not better (1 um and more per metre), and no
// industrial arm returns to a point within it.
constexpr double kBelowAnyInstrument = 1e-6;

// What any method returns; pessimistic until it has converged.
struct Estimate {
  // Compiled once (estimate.cc), not in each file that holds one.
  Estimate();
  Estimate(const Estimate&);
  Estimate(Estimate&&) noexcept;
  Estimate& operator=(const Estimate&);
  Estimate& operator=(Estimate&&) noexcept;
  ~Estimate();

  Status status = Status::kNoConvergence;
  std::string message = "not run";
  int iterations = 0;
  double seconds = 0.0;
  double cost = 0.0;  // 1/2 sum of squared whitened residuals

  ParameterSet parameters;               // the optimum
  ParameterSet aligned;                  // nominal robot, base and markers fitted: "before"
  std::vector<ParameterEstimate> table;  // one per coordinate

  std::vector<int> estimated;        // coordinates behind the rows of `covariance`
  Eigen::MatrixXd covariance;        // SI, by the noise alone, by intervals.method; profile: that of the model
  Eigen::MatrixXd model_covariance;  // SI, (J'J)^-1, scaled where sigma.scaled or not stated
  Eigen::MatrixXd fit_covariance;    // SI, (J'J)^-1 by the weights of the fit, not scaled
  Eigen::VectorXd interval_dof;      // of each estimated one's interval by the noise alone; infinity: normal
  HeldInfluence held;                // what held parameters do to the estimated ones
  IntervalReport intervals;
  Identifiability identifiability;
  SigmaReport sigma;
  NoiseReport noise_report;
  AgreementReport agreement;  // between parts of the data; filled by CheckAgreement
  double chi2 = 0.0;
  int dof = 0;
  int rows = 0;  // residuals fitted

  int calibration_configurations = 0;
  ResidualSize fit, fit_before;
  ResidualSize validation, validation_before;
  // Loaded minus unloaded of equal (configuration, visit, marker): measured, and
  // measured minus predicted. `observations` counts the pairs.
  ResidualSize deflection_before, deflection_after;
  double validation_predicted_rms = 0.0;  // m, per coordinate: noise and parameters
  double noise_floor = 0.0;               // m: the same at the sigmas as stated

  // Per observation of the data, in row order.
  Eigen::Matrix3Xd predicted;          // m, station frame
  Eigen::Matrix3Xd predicted_aligned;  // the same by `aligned`; none where nothing was aligned
  NoiseRoots noise;                    // m, the instrument's, as used for whitening
  NoiseRoots scatter;                  // m, of a row by itself: the instrument's and what joint repeatability adds
  Eigen::VectorXd leverage;            // mean over the axes of the hat matrix's diagonal
  std::vector<std::string> warnings;
};

// Times that the stated noise is larger than the residuals show, where these are very much smaller than stated and an
// instrument's; 1: they are not.
double StatedTooLarge(const Estimate& estimate);

// Of the directions that are held those that noise of the residuals' size leaves open too. The others are held for a
// stated noise that is too large alone.
std::vector<Direction> LeftOpen(const Estimate& estimate);

}  // namespace sagitta

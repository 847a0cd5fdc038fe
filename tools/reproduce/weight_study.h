// What weights do to the linear elastostatic identification of paper 003, and
// whether the intervals that come with them are true.
//
//   y = B k + e      y: deflections (loaded - unloaded), 3 rows per marker and repeat
//   B                first order, eq. (3): columns J_j J_j' F at the unloaded arm
//   e ~ N(0, S^2)    S = diag(sigma), Table 1
//
//   k  = (B'W^2 B)^-1 B'W^2 y                                        eq. (10); W = I: eq. (6)
//   C  = (B'W^2 B)^-1 B'W^2 S^2 W^2 B (B'W^2 B)^-1                   eq. (11); W = I: eq. (8)
//   C  = (B'S^-2 B)^-1                       W = S^-1, eq. (13), misprinted there as B'S^2 B
//   w  = s0 / (s0 + lambda s)                                        eq. (14)
//
// An interval is a claim. Every method here states what it claims, and a seeded
// simulation says what it holds: the actual standard deviation and the share of
// intervals that contain the truth. Weights from each row's own residual, read as
// sigmas, claim intervals 20 to 40 times shorter than those of plain least squares;
// they hold the truth one time in fourteen.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "estimator/noise/residual_noise.h"
#include "models/forward_model.h"

namespace sagitta {

// Loaded configurations of one arm, all markers seen in each.
struct ElasticScene {
  std::vector<ShotInput> shots;  // one per configuration, wrenches set
  Pose<double> base_in_station;
  std::vector<MarkerInFrame> markers;
};

// Columns of B for the listed model parameters (compliances), one block of 3 rows
// per shot and marker, m per rad/(N m). Exact at zero deflection: the derivative of
// u = k tau(u) by k at k = 0 is tau(0).
Eigen::MatrixXd ElasticColumns(const ForwardModel& model, const ElasticScene& scene,
                               const std::vector<int>& parameters);

struct WeightDesign {
  Eigen::MatrixXd rows;     // B
  Eigen::VectorXd sigma;    // of each row, m
  std::vector<int> groups;  // configuration and axis of each row: 0, 1, 2 of the first configuration, ...
};
// Repeats `columns` and gives every row the sigma of its configuration and axis, m.
WeightDesign MakeWeightDesign(const Eigen::MatrixXd& columns, const std::vector<Vector3<double>>& sigma, int markers,
                              int repeats);

enum class StudyWeights {
  kEqual,       // OLS
  kKnownSigma,  // 1 / sigma
  kGroup,       // from the residuals of a group (configuration and axis)
  kResidual,    // from each row's own residual
};
enum class Claim {
  kSandwich,           // eq. (8), (11) with the true sigmas; W = 1/sigma: eq. (13)
  kIid,                // s^2 (B'W^2 B)^-1, s from the residuals
  kEstimatedSandwich,  // eq. (11) with the sigmas the weights came from
  kNormalised,         // s0^2 (B'W^2 B)^-1: eq. (14) read as W = s0 / sigma
  kEstimatedSigma,     // eq. (13) with the sigmas the weights came from
};

struct WeightMethod {
  std::string name;
  StudyWeights weights = StudyWeights::kEqual;
  Claim claim = Claim::kSandwich;
  double lambda = 1.0;
  double sigma0 = 1e-5;  // m; 0: w = 1 / s
  int iterations = 10;
  double floor = kResidualFloor;  // m, of a residual read as a sigma
};

struct WeightedFit {
  Eigen::VectorXd value;  // rad/(N m)
  Eigen::VectorXd sigma;  // claimed, rad/(N m)
};
// One entry per iteration; the first is OLS, its eq. (8) with known sigmas or, where
// the method has its sigmas from residuals, with |r|.
std::vector<WeightedFit> FitWeighted(const WeightDesign& design, const Eigen::VectorXd& deflections,
                                     const WeightMethod& method);

// Standard deviations before any measurement: eq. (8) and eq. (13).
Eigen::VectorXd PredictOlsSigma(const WeightDesign& design);
Eigen::VectorXd PredictWlsSigma(const WeightDesign& design);

// No design whatever lets known sigmas between s and ratio s gain more than
// (R + 1) / (2 sqrt R), R = ratio^2, over equal weights (Kantorovich).
double WlsGainBound(double ratio);

struct WeightStudyOptions {
  int trials = 500;
  unsigned long long seed = 1;
  Eigen::VectorXd bias;  // m per row, what the model lacks; empty: nothing
  std::function<void(const std::string&)> progress = {};
};
// Throws InputError that names the option (problems/range.h).
void CheckOptions(const WeightStudyOptions& options);

struct MethodStudy {
  std::string name;
  Eigen::VectorXd claimed;     // mean claimed standard deviation, rad/(N m)
  Eigen::VectorXd actual;      // root mean square error
  Eigen::VectorXd coverage95;  // share of 95 % intervals that hold the truth, per parameter
  Eigen::VectorXd coverage3s;  // of 3-sigma intervals, 99.73 % promised
  // Mean over trials of sigma(OLS) / claimed, OLS by eq. (8) with |r| of the same data:
  // the gain that somebody without known sigmas would print.
  Eigen::VectorXd claimed_factor;
  double Coverage95() const { return coverage95.mean(); }
  double Coverage3s() const { return coverage3s.mean(); }
  double ClaimedOverActual() const;  // geometric mean
};
// All methods on the same trials. `truth`: rad/(N m).
std::vector<MethodStudy> StudyWeights(const WeightDesign& design, const Eigen::VectorXd& truth,
                                      const std::vector<WeightMethod>& methods, const WeightStudyOptions& options = {});

// The methods that papers and practice know, plainest first.
std::vector<WeightMethod> KnownWeightMethods();

}  // namespace sagitta

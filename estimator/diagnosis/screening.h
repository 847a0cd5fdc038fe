// Screening: what each candidate would explain, from the one fit.
//
// At the believed optimum the whitened residual r is orthogonal to the believed
// columns J. A candidate's columns C at neutral, projected off J,
//
//   C_perp = C - Q Q' C,   score = r' C_perp (C_perp' C_perp)^+ C_perp' r
//
// is the chi-square reduction of a linear refit, chi-square distributed with
// rank(C_perp) degrees of freedom where nothing is missing (score test).
#pragma once

#include <vector>

#include "estimator/diagnosis/candidates.h"
#include "estimator/estimate/estimate.h"
#include "estimator/least_squares/linearization.h"

namespace sagitta {

constexpr double kOversized = 100.0;  // typical sizes

struct Score {
  double reduction = 0.0;  // chi-square
  int rank = 0;
  double penalised = 0.0;  // reduction - p ln(n) - 2 ln(settings)
};

// C_perp' C_perp and C_perp' r of some columns. Those that the believed ones contain are zero in it.
struct NormalEquations {
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
};

// P of a reduction by chance, the best of so many tests: chi-square in the noise at hand, F in units of the scatter
// that is left (chi-square per degree of freedom, dof of them) where that is more: a model that does not reach the
// stated sigma cannot use it as yardstick.
double CorrectedP(double reduction, int parameters, double scatter, int dof, int tests);

// From those of the columns as they are, and their coordinates along the believed basis.
NormalEquations ReduceOff(Eigen::MatrixXd information, const Eigen::Ref<const Eigen::MatrixXd>& on_believed,
                          Eigen::VectorXd gradient);

// The score test from normal equations of a residual with this many rows.
Score ScoreOf(const NormalEquations& normal, long rows, int settings);

// 2 ln of the marginal likelihood over that of no effect, for coefficients of one common prior variance tau^2, the best
// of a grid; minus ln(rows) for tau. With C_perp = U S V', z = U' r, t_i = (tau s_i)^2:
//   max over tau of sum z_i^2 t_i / (1 + t_i) - ln(1 + t_i)
double MarginalGainOf(const NormalEquations& normal, long rows);

// Leaves out, worst first, parameters that would stay unknown to more than a typical size: they would only fit noise.
// One that is significant all the same stays, unless its value would be oversized beside others: a column that hardly
// stands out of the believed ones. Returns the others. In a refit the left-out ones get a wide prior instead, so that
// the intervals of the others stay true. typical: size of each, in units of the columns.
std::vector<int> InformedColumns(const NormalEquations& normal, const Eigen::VectorXd& typical);

// Believed columns as an orthonormal basis, and the residual.
class ProjectedResidual {
 public:
  explicit ProjectedResidual(const Linearization& believed);
  ProjectedResidual(const Eigen::MatrixXd& believed, const Eigen::VectorXd& residual);

  Score Test(const Eigen::MatrixXd& columns, int settings = 1) const;
  double MarginalGain(const Eigen::MatrixXd& columns) const;
  NormalEquations Reduce(const Eigen::MatrixXd& columns) const;
  // The columns' coordinates along the believed basis, for ReduceBlock.
  Eigen::MatrixXd OnBelieved(const Eigen::MatrixXd& columns) const { return basis_.transpose() * columns; }
  // Reduce of some columns whose coordinates along the believed basis are known.
  NormalEquations ReduceBlock(const Eigen::Ref<const Eigen::MatrixXd>& columns,
                              const Eigen::Ref<const Eigen::MatrixXd>& on_believed) const;
  Eigen::MatrixXd ProjectOff(const Eigen::MatrixXd& columns) const;
  // What of `target` (rows, off the believed columns) the columns' part off the believed ones can do.
  Eigen::VectorXd Reproduce(const Eigen::MatrixXd& columns, const Eigen::VectorXd& target) const;
  const Eigen::VectorXd& residual() const { return residual_; }
  const Eigen::MatrixXd& basis() const { return basis_; }
  // That the residual is in units of; columns stay in those of the noise that is taken.
  double noise() const { return noise_; }
  // A copy that believes these columns too.
  ProjectedResidual With(const Eigen::MatrixXd& columns) const;
  // A copy in units of a noise that is this many times as large.
  ProjectedResidual InNoise(double factor) const;

 private:
  ProjectedResidual() = default;
  // Orthonormal, what the columns add to the basis. Of nearly dependent columns some directions are rounding, which the
  // basis contains as much as anything: they are projected a second time, and what that takes away is dropped.
  Eigen::MatrixXd NewDirections(const Eigen::MatrixXd& columns) const;

  Eigen::MatrixXd basis_;
  Eigen::VectorXd residual_;
  double noise_ = 1.0;
};

Linearization LinearizeEstimate(const CalibrationProblem& problem, const ParameterSet& parameters,
                                LatentTreatment treatment = LatentTreatment::kMarginalise);

// Whitened columns of several candidates at neutral, side by side, in units of results.
struct CandidateColumns {
  Eigen::MatrixXd columns;         // rows x parameters of all
  std::vector<std::string> names;  // of the parameters
  Eigen::VectorXd typical;         // sizes, in the same units
  std::vector<int> first;          // column of each candidate; one more at the end

  int count(int candidate) const { return first[candidate + 1] - first[candidate]; }
};

// From one linearization of the model with all of them. A candidate that the
// model already has gets no columns, and so does a gravity compensator (not
// linear: compensator_search.h).
CandidateColumns ColumnsOf(const CalibrationProblem& problem, const ParameterSet& parameters,
                           const std::vector<EffectSpec>& specs,
                           LatentTreatment treatment = LatentTreatment::kMarginalise);

// How a deviation of each joint on its encoder side moves the rows, whitened,
// per urad (um); one column per joint.
Eigen::MatrixXd JointDeviationColumns(const CalibrationProblem& problem, const ParameterSet& parameters,
                                      LatentTreatment treatment = LatentTreatment::kMarginalise);

}  // namespace sagitta

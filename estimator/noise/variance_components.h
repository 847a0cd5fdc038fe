// Variance components by restricted maximum likelihood (REML): how much of the
// scatter is the instrument, how much the joints.
//
//   r = J x + e,   e ~ N(0, V),   V = a I + sum_g v_g sum_{j in g} L_j L_j'   block diagonal by visit
//
// r, J whitened by the roots S at hand; a scales S S'; L_j is what one reference deviation of
// joint j does in the rows of a visit. Where points and rotations of poses have noise of their own, a I is a I of the
// points and b I of the rotations. The parameters x are projected out (hence
// restricted: plain maximum likelihood mistakes their degrees of freedom for
// precision):
//
//   D(a, v) = ln|V| + ln|J'V^-1 J| + r'P r,   P = V^-1 - V^-1 J (J'V^-1 J)^-1 J'V^-1
//
// minimised by Newton steps on average information, y'P V_i P V_k P y; variances stay
// at or above 0 (active set). Each visit is rotated once so that its deviations touch at most as
// many rows as there are joints: one evaluation costs visits x joints^2 x parameters.
#pragma once

#include <vector>

#include "estimator/estimate/noise_report.h"
#include "estimator/least_squares/linearization.h"

namespace sagitta {

// Joints that share one variance, and where it starts.
struct DeviationGroup {
  std::vector<int> joints;
  double variance = 0.0;  // rad^2 or m^2
  bool estimated = true;
};

struct RemlFit {
  bool converged = false;
  double deviance = 0.0;
  Eigen::VectorXd variances;   // a (and b), then one per group, SI
  Eigen::MatrixXd covariance;  // of them, from the information; 0 where stated or at 0
};

class RestrictedLikelihood {
 public:
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  // At `parameters`, over their estimated coordinates; calibration rows. rotations_apart: rotations have a variance of
  // their own, which is always estimated.
  RestrictedLikelihood(const CalibrationProblem& problem, const ParameterSet& parameters, bool rotations_apart = false);

  RemlFit Maximise(bool estimate_instrument, const std::vector<DeviationGroup>& groups) const;
  // 95 % interval of component i of RemlFit::variances as standard deviation, the others refitted.
  void ProfileInterval(const RemlFit& fit, bool estimate_instrument, const std::vector<DeviationGroup>& groups, int i,
                       double* low, double* high) const;
  // -2 ln of the restricted likelihood, but for a constant; SI variances.
  double Deviance(double instrument, const std::vector<DeviationGroup>& groups) const;
  // Degrees of freedom that carry information on variances: rows minus parameters.
  int dof() const { return dof_; }
  // Variances of readings, before those of the groups: one, or two where rotations are apart.
  int num_noises() const { return num_noises_; }
  // How much a deviation of each joint shows in the rows, whitened: root of the sum of squares.
  Eigen::VectorXd Levers() const;
  // Student degrees of freedom of each estimated coordinate's interval (Satterthwaite).
  Eigen::VectorXd Satterthwaite(const RemlFit& fit, const std::vector<DeviationGroup>& groups) const;

 private:
  struct Visit {
    int first;                  // of its rows
    int of_points;              // how many of them have the first variance; the others the second
    Eigen::MatrixXd deviation;  // rows that deviations touch; one column per joint, of a reference deviation
  };
  // Rows that no deviation touches, of one variance.
  struct Rest {
    Eigen::MatrixXd products;  // [J r]'[J r]
    int rows = 0;
  };
  struct Whitened;
  struct Evaluation {
    double deviance = 0.0;
    Eigen::VectorXd fitted;  // x
    Eigen::VectorXd gradient;
    Eigen::MatrixXd hessian;                  // average information
    Eigen::MatrixXd inverse;                  // (J'V^-1 J)^-1
    std::vector<Eigen::MatrixXd> derivative;  // J'V^-1 V_i V^-1 J
  };
  // Variances in units of the reference: a, then per group.
  Evaluation Evaluate(const Eigen::VectorXd& variances, const std::vector<DeviationGroup>& groups,
                      bool with_derivatives) const;
  Whitened Whiten(const Eigen::VectorXd& variances, const std::vector<DeviationGroup>& groups) const;
  void Differentiate(const Whitened& whitened, const Eigen::VectorXd& variances,
                     const std::vector<DeviationGroup>& groups, Evaluation* result) const;
  // Diagonal of V without deviations, in the touched rows of a visit.
  Eigen::VectorXd OwnVariances(const Visit& visit, const Eigen::VectorXd& variances) const;
  // F of V_i = F F' in them.
  Eigen::MatrixXd FactorOf(const Visit& visit, int i, const std::vector<DeviationGroup>& groups) const;
  void AddVisit(const Rows& rows, const Eigen::MatrixXd& deviation, const std::vector<int>& of_points,
                const std::vector<int>& of_rotations, int* touched);
  std::vector<bool> FreeOnes(bool estimate_instrument, const std::vector<DeviationGroup>& groups) const;
  // Of the residuals of one kind of readings: where its variance starts.
  double MeanSquare(int noise) const;
  Eigen::VectorXd BestStart(const std::vector<bool>& is_free, const std::vector<DeviationGroup>& groups) const;
  bool Minimise(const std::vector<bool>& is_free, const std::vector<DeviationGroup>& groups,
                Eigen::VectorXd* variances) const;
  Eigen::VectorXd StartVariances(const std::vector<DeviationGroup>& groups) const;

  std::vector<Visit> visits_;
  Rows rows_;               // [J r] of the rows that deviations touch; the columns of J have unit norm over all rows
  std::vector<Rest> rest_;  // of each variance of readings
  Eigen::MatrixXd prior_;   // [J r]'[J r] of priors, not scaled by a
  int num_noises_ = 1;
  int columns_ = 0;
  int dof_ = 0;
};

}  // namespace sagitta

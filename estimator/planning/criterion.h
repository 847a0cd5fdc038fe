// What a plan is judged by: a function of the covariance C = M^-1 that its readings will leave, smaller is better.
//
//   I   tr(W C)            W = mean J'J of test points: mean squared position error there after compensation, the
//                          industry-oriented measure of papers 000 and 002
//   D   ln det C_SS        S: the robot's parameters; base and markers stay unknown together with them (marginalised)
//   A   tr C_SS
//   E   largest eigenvalue of C_SS
//   O1..O5                 observability indices (Sun and Hollerbach, ICRA 2008) of the singular values s of the
//                          identification Jacobian that is left for S: s = eigenvalues of C_SS, to the power -1/2
//                          O1 = (s1 .. sL)^(1/L), O2 = s_min/s_max, O3 = s_min, O4 = s_min^2/s_max, O5 = 1/sum(1/s)
//   T   - mean_k I(D_k)    of rival effects k: the information (statistics/mutual_information.h), in nat, of readings
//                          on whether it is k or one of the others, D_k = tr(T_k C_kk^-1 T_k) for parameters of size
//                          T_k: the noncentrality by which data of k contradict the others, base, markers, robot and
//                          the others refitted (Atkinson and Fedorov, Biometrika 62, 1975). I is concave and grows, D_k
//                          is concave in M: so is T's information.
//
// Parameters are scaled to columns of unit root mean square over the candidates, so that D apart they have one unit.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace sagitta {

enum class CriterionKind { kI, kD, kA, kE, kO1, kO2, kO3, kO4, kO5, kDiscriminate };

// A cost of the covariance, the less the better.
struct Criterion {
  CriterionKind kind = CriterionKind::kI;
  Eigen::MatrixXd weight;     // W, of I
  std::vector<int> interest;  // S, columns; of T: those of all rivals, one after the other
  std::vector<int> rival_of;  // of T: which rival each of `interest` is a parameter of
  Eigen::VectorXd size;       // of T: T_k's diagonal, one per `interest`

  // Cost of a covariance.
  double Cost(const Eigen::MatrixXd& covariance) const;
  // The same from C_SS (of I: from the whole of C).
  double CostOfBlock(const Eigen::MatrixXd& block) const;
  // Convex in the information: the cost has a slope that bounds every other plan (equivalence theorem).
  bool HasCertificate() const;
  // -d cost / d M, positive semidefinite; only with a certificate.
  Eigen::MatrixXd Slope(const Eigen::MatrixXd& covariance) const;
  // Ratio of what `best` needs to what `cost` needs, 0 to 1: of variances (I, A), of the volume's side squared (D),
  // of standard deviations (O5), of information (T).
  double Efficiency(double cost, double best) const;
  // Of T: D_k of each rival.
  std::vector<double> Apart(const Eigen::MatrixXd& block) const;
  // Columns of C that the cost depends on.
  std::vector<int> Columns(int all) const;

 private:
  // Of T, from C_:S and C_SS.
  Eigen::MatrixXd SlopeOfRivals(const Eigen::MatrixXd& tall, const Eigen::MatrixXd& block) const;
};

// "I", "D", ... ; throws InputError at `key` for another name.
CriterionKind CriterionNamed(const std::string& name, const std::string& key = "--criterion");
std::string WordOf(CriterionKind kind);

// O1 .. O5 of C_SS.
Eigen::Matrix<double, 5, 1> ObservabilityIndices(const Eigen::MatrixXd& block);

}  // namespace sagitta

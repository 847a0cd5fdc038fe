#include "estimator/planning/criterion.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "estimator/statistics/mutual_information.h"
#include "models/constants.h"
#include "models/matrix_functions.h"
#include "problems/choices.h"
#include "problems/input_error.h"

namespace sagitta {
namespace {

Eigen::VectorXd EigenvaluesOf(const Eigen::MatrixXd& block) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(block, Eigen::EigenvaluesOnly);
  return solver.eigenvalues().cwiseMax(1e-300);
}

// Places in `rival_of` of each rival.
std::vector<std::vector<int>> PlacesOfRivals(const std::vector<int>& rival_of) {
  std::vector<std::vector<int>> places;
  for (size_t i = 0; i < rival_of.size(); ++i) {
    if (rival_of[i] >= static_cast<int>(places.size())) places.resize(rival_of[i] + 1);
    places[rival_of[i]].push_back(static_cast<int>(i));
  }
  return places;
}

}  // namespace

std::vector<int> Criterion::Columns(int all) const {
  if (kind != CriterionKind::kI) return interest;
  std::vector<int> columns(all);
  std::iota(columns.begin(), columns.end(), 0);
  return columns;
}

double Criterion::Cost(const Eigen::MatrixXd& covariance) const {
  if (kind == CriterionKind::kI) return weight.cwiseProduct(covariance).sum();
  return CostOfBlock(covariance(interest, interest));
}

double Criterion::CostOfBlock(const Eigen::MatrixXd& block) const {
  switch (kind) {
    case CriterionKind::kI:
      return weight.cwiseProduct(block).sum();
    case CriterionKind::kA:
      return block.trace();
    case CriterionKind::kD:
    case CriterionKind::kO1:
      // ln det C_SS = 2 sum ln diag chol(C_SS); least where the ellipsoid of what is of interest is smallest.
      return LogDeterminant(block.llt());
    case CriterionKind::kDiscriminate: {
      const std::vector<double> apart = Apart(block);
      double information = 0.0;
      for (const double d : apart) information += InformationOfTwo(d).information / static_cast<double>(apart.size());
      return -information;
    }
    case CriterionKind::kO2:
      return -ObservabilityIndices(block)[1];
    case CriterionKind::kO4:
      return -ObservabilityIndices(block)[3];
    case CriterionKind::kO5:
      return 1.0 / ObservabilityIndices(block)[4];
    case CriterionKind::kE:
    case CriterionKind::kO3: {  // these agree
      const double least = ObservabilityIndices(block)[2];
      return 1.0 / (least * least);
    }
  }
  return kNotKnown;
}

std::vector<double> Criterion::Apart(const Eigen::MatrixXd& block) const {
  std::vector<double> apart;
  for (const std::vector<int>& places : PlacesOfRivals(rival_of)) {
    const Eigen::MatrixXd own = block(places, places);
    const Eigen::VectorXd sizes = size(places);
    apart.push_back(sizes.cwiseAbs2().dot(InverseOfPositive(own).diagonal()));  // T is diagonal
  }
  return apart;
}

bool Criterion::HasCertificate() const {
  switch (kind) {
    case CriterionKind::kI:
    case CriterionKind::kA:
    case CriterionKind::kD:
    case CriterionKind::kO1:
    case CriterionKind::kO5:
    case CriterionKind::kDiscriminate:
      return true;
    case CriterionKind::kE:
    case CriterionKind::kO2:
    case CriterionKind::kO3:
    case CriterionKind::kO4:
      break;
  }
  return false;
}

Eigen::MatrixXd Criterion::SlopeOfRivals(const Eigen::MatrixXd& tall, const Eigen::MatrixXd& block) const {
  Eigen::MatrixXd slope = Eigen::MatrixXd::Zero(tall.rows(), tall.rows());
  const std::vector<std::vector<int>> rivals = PlacesOfRivals(rival_of);
  const std::vector<double> apart = Apart(block);
  for (size_t k = 0; k < rivals.size(); ++k) {
    const Eigen::MatrixXd own = block(rivals[k], rivals[k]);
    const Eigen::MatrixXd of_rival = tall(Eigen::all, rivals[k]);
    const double worth = InformationOfTwo(apart[k]).slope / static_cast<double>(rivals.size());
    const Eigen::MatrixXd sized = std::sqrt(worth) * (of_rival * InverseOfPositive(own)) * size(rivals[k]).asDiagonal();
    slope += sized * sized.transpose();
  }
  return slope;
}

// With S = C_SS^-1 (the Schur complement of M) dS = V' dM V, V = C_:S S; hence -d f(S) = tr(V (-f') V' dM).
Eigen::MatrixXd Criterion::Slope(const Eigen::MatrixXd& covariance) const {
  if (kind == CriterionKind::kI) {
    const Eigen::MatrixXd half = covariance * weight;
    return half * covariance;
  }
  const Eigen::MatrixXd tall = covariance(Eigen::all, interest);
  const Eigen::MatrixXd block = covariance(interest, interest);
  switch (kind) {
    case CriterionKind::kA:
      return tall * tall.transpose();
    case CriterionKind::kO5: {  // -f' = 1/2 S^-3/2
      const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(block);
      const Eigen::MatrixXd half = tall * solver.operatorInverseSqrt();
      return half * (0.5 * tall.transpose());
    }
    case CriterionKind::kD:
    case CriterionKind::kO1: {
      const Eigen::MatrixXd across = tall.transpose(), solved = block.llt().solve(across);
      return tall * solved;
    }
    case CriterionKind::kDiscriminate:
      return SlopeOfRivals(tall, block);
    case CriterionKind::kI:  // above, of the whole of C
    case CriterionKind::kE:  // the others have no certificate
    case CriterionKind::kO2:
    case CriterionKind::kO3:
    case CriterionKind::kO4:
      break;
  }
  return Eigen::MatrixXd::Constant(covariance.rows(), covariance.cols(), kNotKnown);
}

double Criterion::Efficiency(double cost, double best) const {
  switch (kind) {
    case CriterionKind::kD:
    case CriterionKind::kO1:
      return std::exp((best - cost) / static_cast<double>(interest.size()));
    case CriterionKind::kDiscriminate:
    case CriterionKind::kO2:
    case CriterionKind::kO4:
      return best < 0.0 ? std::max(0.0, cost / best) : 0.0;
    case CriterionKind::kI:
    case CriterionKind::kA:
    case CriterionKind::kE:
    case CriterionKind::kO3:
    case CriterionKind::kO5:
      return std::max(0.0, best / cost);
  }
  return 0.0;
}

Eigen::Matrix<double, 5, 1> ObservabilityIndices(const Eigen::MatrixXd& block) {
  // Singular values of the identification Jacobian: 1 / sqrt(eigenvalues of C_SS).
  const Eigen::ArrayXd s = EigenvaluesOf(block).array().rsqrt();
  const double least = s.minCoeff(), largest = s.maxCoeff();
  Eigen::Matrix<double, 5, 1> indices;
  indices << std::exp(s.log().mean()), least / largest, least, least * least / largest, 1.0 / s.inverse().sum();
  return indices;
}

CriterionKind CriterionNamed(const std::string& name, const std::string& key) {
  std::vector<std::string> known;
  for (const CriterionKind kind : ChoicesOf<CriterionKind>()) {
    if (kind == CriterionKind::kDiscriminate) continue;  // asked for with --discriminate
    if (WordOf(kind) == name) return kind;
    known.push_back(WordOf(kind));
  }
  throw InputError({"", 0, key}, "there is no criterion '" + name + "'", SpellingHint(name, known));
}

std::string WordOf(CriterionKind kind) {
  switch (kind) {
    case CriterionKind::kI:
      return "I";
    case CriterionKind::kD:
      return "D";
    case CriterionKind::kA:
      return "A";
    case CriterionKind::kE:
      return "E";
    case CriterionKind::kO1:
      return "O1";
    case CriterionKind::kO2:
      return "O2";
    case CriterionKind::kO3:
      return "O3";
    case CriterionKind::kO4:
      return "O4";
    case CriterionKind::kO5:
      return "O5";
    case CriterionKind::kDiscriminate:
      return "discriminate";
  }
  return "";
}

}  // namespace sagitta

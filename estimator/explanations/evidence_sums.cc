// What the rows of EvidenceColumns sum to: covariances of the rows, products of their columns, and what is left of them
// given what is believed.
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <numeric>
#include <set>

#include "estimator/explanations/evidence_columns.h"
#include "estimator/least_squares/normal_algebra.h"
#include "models/matrix_functions.h"

namespace sagitta {
namespace {

// Of J'J scaled to a unit diagonal: below, a direction is rounding.
constexpr double kRankOfSums = 1e-13;

}  // namespace

std::vector<EvidenceColumns::PoseRows> EvidenceColumns::PosesAmong(const std::vector<int>& observations) const {
  std::vector<PoseRows> poses;
  int latest = -1;
  for (size_t o = 0; o < observations.size(); ++o) {
    const int pose = pose_of_observation_[observations[o]];  // -1 of one that is not fitted
    if (o == 0 || pose != latest) poses.push_back({static_cast<long>(3 * o), 0});
    poses.back().height += 3;
    latest = pose;
  }
  return poses;
}

// Sum over joints of visit_j^2 l_j l_j' within visits + pose_j^2 l_j l_j' within poses; of_visit, of_pose: visit_j l_j
// and pose_j l_j, a column for each row of the block.
Eigen::MatrixXd EvidenceColumns::SharedBy(const PoseRows& pose, const std::vector<int>& observations,
                                          const Eigen::MatrixXd& of_visit, const Eigen::MatrixXd& of_pose) const {
  const auto visit = [&](long row) {
    return extended_.latent.visit_of_shot[extended_.data().observations[observations[row / 3]].shot];
  };
  Eigen::MatrixXd shared(pose.height, pose.height);
  for (long j = 0; j < pose.height; ++j) {
    for (long i = j; i < pose.height; ++i) {
      const long row = pose.top + i, other = pose.top + j;
      double sum = of_pose.col(row).dot(of_pose.col(other));
      if (i / 3 == j / 3 || visit(row) == visit(other)) sum += of_visit.col(row).dot(of_visit.col(other));
      shared(i, j) = shared(j, i) = sum;
    }
  }
  return shared;
}

// Adds M M' of each reading, I of one that is as the problem has it.
void EvidenceColumns::ScaleReadings(const PoseRows& pose, const std::vector<int>& observations,
                                    const std::vector<ScaledGroup>& readings, Eigen::MatrixXd* covariance) const {
  covariance->diagonal().array() += 1.0;
  if (readings.empty()) return;
  for (long row = 0; row < pose.height; row += 3) {
    const Matrix3<double> scaling = ScalingOf(ReadingOf(extended_, observations[(pose.top + row) / 3]), readings);
    covariance->block<3, 3>(row, row) += scaling * scaling.transpose() - Matrix3<double>::Identity();
  }
}

EvidenceColumns::BlockRoots EvidenceColumns::RootsOf(const std::vector<int>& observations,
                                                     const Eigen::MatrixXd& latent, const RowScatter& scatter) const {
  BlockRoots roots;
  if (scatter.IsUnit()) return roots;
  const Eigen::MatrixXd of_visit = scatter.visit.asDiagonal() * latent.transpose();
  const Eigen::MatrixXd of_pose = scatter.pose.asDiagonal() * latent.transpose();
  for (const PoseRows& pose : PosesAmong(observations)) {
    Eigen::MatrixXd covariance = SharedBy(pose, observations, of_visit, of_pose);
    ScaleReadings(pose, observations, scatter.readings, &covariance);
    roots.push_back({pose.top, Eigen::LLT<Eigen::MatrixXd>(covariance)});
  }
  return roots;
}

// L x = b of each pose and column, as they lie in memory: x_j = b_j / L_jj, b_i -= L_ij x_j below.
double EvidenceColumns::Whiten(const BlockRoots& roots, Eigen::MatrixXd* rows) {
  double log_det = 0.0;
  for (const PoseRoot& pose : roots) log_det += LogDeterminant(pose.root);
  const Eigen::VectorXd inverses = InversePivots(roots, rows->rows());
  for (long c = 0; c < rows->cols(); ++c) {
    for (const PoseRoot& pose : roots) {
      const Eigen::MatrixXd& root = pose.root.matrixLLT();
      double* const x = rows->col(c).data() + pose.top;
      for (long j = 0; j < root.rows(); ++j) {
        x[j] *= inverses[pose.top + j];
        for (long i = j + 1; i < root.rows(); ++i) x[i] -= root(i, j) * x[j];
      }
    }
  }
  return log_det;
}

// L'y = x:  y_j = (x_j - sum over i > j of L_ij y_i) / L_jj.
void EvidenceColumns::WhitenAgain(const BlockRoots& roots, Eigen::MatrixXd* rows) {
  const Eigen::VectorXd inverses = InversePivots(roots, rows->rows());
  for (long c = 0; c < rows->cols(); ++c) {
    for (const PoseRoot& pose : roots) {
      const Eigen::MatrixXd& root = pose.root.matrixLLT();
      double* const x = rows->col(c).data() + pose.top;
      for (long j = root.rows() - 1; j >= 0; --j) {
        for (long i = j + 1; i < root.rows(); ++i) x[j] -= root(i, j) * x[i];
        x[j] *= inverses[pose.top + j];
      }
    }
  }
}

Eigen::VectorXd EvidenceColumns::InversePivots(const BlockRoots& roots, long rows) {
  Eigen::VectorXd inverses = Eigen::VectorXd::Ones(rows);
  for (const PoseRoot& pose : roots) {
    inverses.segment(pose.top, pose.root.rows()) = pose.root.matrixLLT().diagonal().cwiseInverse();
  }
  return inverses;
}

std::vector<int> EvidenceColumns::AllColumns() const {
  std::vector<int> all(num_columns_);
  std::iota(all.begin(), all.end(), 0);
  return all;
}

RowSums EvidenceColumns::Sum(const RowScatter& scatter, const std::vector<int>& columns, int every) const {
  return SumEach(scatter, columns, std::vector<int>(poses_.size(), 0), every)[0];
}

void RowSums::AddUpper(const RowSums& others, int times) {
  for (long c = 0; c < products.cols(); ++c) products.col(c).head(c + 1) += times * others.products.col(c).head(c + 1);
  log_det += times * others.log_det;
  rows += times * others.rows;
}

std::vector<RowSums> EvidenceColumns::SumEach(const RowScatter& scatter, const std::vector<int>& columns,
                                              const std::vector<int>& group_of_pose, int every) const {
  const int groups = 1 + *std::max_element(group_of_pose.begin(), group_of_pose.end());
  const long width = believed_.size() + columns.size() + 1;
  std::vector<RowSums> sums(static_cast<size_t>(groups), RowSums::Zero(width));
  Block scratch;
  Eigen::MatrixXd rows;
  for (size_t b = 0; b < observations_of_block_.size(); b += static_cast<size_t>(every)) {
    const Block& block = BlockOf(b, &scratch);
    FillRows(block, columns, &rows);
    const BlockRoots roots = RootsOf(block.observations, block.here.latent, scatter);
    const double log_det = Whiten(roots, &rows);
    const auto add = [](const Eigen::MatrixXd& own, RowSums* to) {
      to->products += SelfProduct(own);
      to->rows += static_cast<int>(own.rows());
    };
    if (groups == 1) {
      add(rows, &sums[0]);
      sums[0].log_det += log_det;
      continue;
    }
    std::vector<std::vector<long>> of_group(sums.size());
    const std::vector<PoseRows> poses = PosesAmong(block.observations);
    for (size_t k = 0; k < poses.size(); ++k) {
      const int pose = pose_of_observation_[block.observations[poses[k].top / 3]];
      const auto group = static_cast<size_t>(group_of_pose[pose]);
      for (long row = 0; row < poses[k].height; ++row) of_group[group].push_back(poses[k].top + row);
      if (!roots.empty()) sums[group].log_det += LogDeterminant(roots[k].root);
    }
    for (size_t group = 0; group < sums.size(); ++group) add(rows(of_group[group], Eigen::all), &sums[group]);
  }
  return sums;
}

AlongSources EvidenceColumns::SumAlong(const std::vector<Source>& sources) const {
  const Measurements& data = extended_.data();
  const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(data.shots.size(), sources.size());
  const auto count = static_cast<long>(sources.size());
  AlongSources sums{none, none, Eigen::MatrixXd::Zero(none.rows(), count * count)};
  Block scratch;
  for (size_t b = 0; b < observations_of_block_.size(); ++b) {
    const Block& block = BlockOf(b, &scratch);
    Eigen::MatrixXd rows(block.here.num_rows(), count + 1);
    for (long s = 0; s < count; ++s) rows.col(s) = SourceRows(block, sources[static_cast<size_t>(s)]);
    rows.col(count) = block.here.residual;
    Whiten(RootsOf(block.observations, block.here.latent, stated_), &rows);
    for (size_t o = 0; o < block.observations.size(); ++o) {
      const long shot = data.observations[block.observations[o]].shot, top = static_cast<long>(3 * o);
      const Eigen::MatrixXd own = rows.block(top, 0, 3, count), products = own.transpose() * own;
      sums.square.row(shot) += products.diagonal().transpose();
      sums.products.row(shot) += products.reshaped().transpose();
      sums.residual.row(shot) += rows.col(count).segment<3>(top).transpose() * own;
    }
  }
  return sums;
}

// Those that the user stated, and markers on a spring.
int EvidenceColumns::AddPriors(Eigen::MatrixXd* own, Eigen::VectorXd* along, double* square) const {
  Linearization priors;
  priors.columns = believed_;
  priors.jacobian.resize(0, static_cast<long>(believed_.size()));
  AppendPriors(extended_.parameters, &priors);
  *own += priors.jacobian.transpose() * priors.jacobian;
  *along += priors.jacobian.transpose() * priors.residual;
  *square += priors.residual.squaredNorm();
  return static_cast<int>(priors.residual.size());
}

Eigen::MatrixXd EvidenceColumns::RowsAt(const std::vector<int>& observations, const RowScatter& scatter,
                                        const std::vector<int>& columns) const {
  const Block block = LinearizeBlock(observations);
  Eigen::MatrixXd rows;
  FillRows(block, columns, &rows);
  Whiten(RootsOf(block.observations, block.here.latent, scatter), &rows);
  return rows.leftCols(rows.cols() - 1);
}

Eigen::MatrixXd EvidenceColumns::WithPriors(Eigen::MatrixXd products) const {
  const long believed = num_believed(), last = products.cols() - 1;
  Eigen::MatrixXd own = products.topLeftCorner(believed, believed);
  Eigen::VectorXd along = products.col(last).head(believed);
  AddPriors(&own, &along, &products(last, last));
  products.topLeftCorner(believed, believed) = own;
  products.col(last).head(believed) = along;
  products.row(last).head(believed) = along.transpose();
  return products;
}

// With K = J'C^-1 J (priors added) = V diag(l) V' of scaled columns and B = V diag(l)^(-1/2) of its rank:
//   along = B'(J'C^-1 [A r]),   n = rows + priors - rank,   log constant = -1/2 (log |C| + log |K|).
EvidenceColumns::Eliminated EvidenceColumns::Eliminate(Eigen::MatrixXd own, Eigen::MatrixXd with_others, double square,
                                                       const RowSums& sums) const {
  Eigen::VectorXd along_residual = with_others.rightCols(1);
  const int priors = AddPriors(&own, &along_residual, &square);
  with_others.rightCols(1) = along_residual;
  const Eigen::VectorXd scale = own.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
      Eigen::MatrixXd(scale.asDiagonal() * own * scale.asDiagonal()));
  const double least = kRankOfSums * eigen.eigenvalues().maxCoeff();
  const int rank = static_cast<int>((eigen.eigenvalues().array() > least).count());
  const Eigen::MatrixXd basis =
      eigen.eigenvectors().rightCols(rank) * eigen.eigenvalues().tail(rank).cwiseSqrt().cwiseInverse().asDiagonal();
  const double log_det = eigen.eigenvalues().tail(rank).array().log().sum() - 2.0 * scale.array().log().sum();
  return {basis.transpose() * (scale.asDiagonal() * with_others), square,
          static_cast<double>(sums.rows + priors - rank), -0.5 * (sums.log_det + log_det)};
}

// [G g; g' R] = [A r]'C^-1 [A r] - along' along.
GivenBelieved EvidenceColumns::Project(const RowSums& sums) const {
  const long believed = num_believed(), count = sums.products.cols() - believed - 1;
  const Eigen::MatrixXd own = sums.products.topLeftCorner(believed, believed).selfadjointView<Eigen::Upper>();
  const Eliminated out = Eliminate(own, sums.products.topRightCorner(believed, count + 1),
                                   sums.products(count + believed, count + believed), sums);
  Eigen::MatrixXd left = sums.products.bottomRightCorner(count + 1, count + 1);
  left(count, count) = out.square;
  const Eigen::VectorXd before = left.diagonal();
  left.selfadjointView<Eigen::Upper>().rankUpdate(out.along.transpose(), -1.0);
  Eigen::MatrixXd information = left.topLeftCorner(count, count).selfadjointView<Eigen::Upper>();
  Eigen::VectorXd gradient = left.col(count).head(count);
  for (long c = 0; c < count; ++c) {
    if (information(c, c) > kContained * before[c]) continue;
    information.row(c).setZero();
    information.col(c).setZero();
    gradient[c] = 0.0;
  }
  return {{std::move(information), std::move(gradient), left(count, count), out.dof}, out.log_constant};
}

}  // namespace sagitta

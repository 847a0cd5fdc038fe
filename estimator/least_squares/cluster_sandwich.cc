#include "estimator/least_squares/cluster_sandwich.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <string>
#include <tuple>
#include <utility>

#include "estimator/least_squares/row_sums.h"
#include "estimator/least_squares/satterthwaite.h"
#include "models/batch/shot_program.h"

namespace sagitta {
namespace {

constexpr double kSampled = 2000.0;
constexpr int kHeldScores = 32;  // rows of lanes that are summed together
constexpr Eigen::Index kSampledRowsAtOnce = 512;

// In [0, 1), the same for a cluster wherever it is asked (SplitMix64: Steele, Lea and Flood 2014).
double Chance(int cluster) {
  std::uint64_t z = (static_cast<std::uint64_t>(cluster) + 1) * 0x9E3779B97F4A7C15ULL;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1.0p-53;
}

// As few rows with the same products: what a cluster is worth depends on those alone.
RowMajorMatrix Shortened(RowMajorMatrix rows) {
  const Eigen::Index numbers = rows.cols();
  if (rows.rows() <= numbers) return rows;
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr{Eigen::MatrixXd(rows)};
  return Eigen::MatrixXd(qr.matrixQR().topRows(numbers).triangularView<Eigen::Upper>());
}

}  // namespace

ClusterSandwich::ClusterSandwich(int columns, int clusters, const Eigen::MatrixXd& root, std::vector<ClusterFit> fits)
    : columns_(columns), padded_((columns + kGramBlock - 1) / kGramBlock * kGramBlock), clusters_(clusters) {
  const auto square = static_cast<size_t>(padded_) * padded_;
  root_.assign(square, 0.0);
  for (int c = 0; c < columns; ++c) {
    for (int a = 0; a < columns; ++a) root_[static_cast<size_t>(c) * padded_ + a] = root(c, a);
  }
  const auto count = padded_ / kGramBlock;
  for (ClusterFit& given : fits) {
    Fit& fit = fits_.emplace_back();
    fit.given = std::move(given);
    std::vector<int>& own = fit.given.columns;
    const bool all = own.empty();
    for (int c = 0; all && c < columns; ++c) own.push_back(c);
    fit.inverse_normal.assign(square, 0.0);
    fit.step.assign(padded_, 0.0);
    for (size_t i = 0; i < own.size(); ++i) {
      if (fit.given.step.size() > 0) fit.step[own[i]] = fit.given.step[static_cast<Eigen::Index>(i)];
      for (size_t k = 0; k < own.size(); ++k) {
        fit.inverse_normal[static_cast<size_t>(own[i]) * padded_ + own[k]] =
            fit.given.solution.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
      }
    }
    fit.products = GramSums(count, count, true);
    fit.held = fit.memory.Reserve(static_cast<size_t>(kHeldScores) * padded_ * kBatchLanes);
    fit.clusters =
        fit.given.has.empty() ? clusters : static_cast<int>(std::count(fit.given.has.begin(), fit.given.has.end(), 1));
  }
}

void ClusterSandwich::Add(const RowMajorMatrix& rows, const std::vector<int>& cluster_of) {
  // Clusters that the same fits have side by side, by their numbers of rows.
  std::vector<int> by_cluster(cluster_of.size());
  std::iota(by_cluster.begin(), by_cluster.end(), 0);
  std::stable_sort(by_cluster.begin(), by_cluster.end(), [&](int a, int b) { return cluster_of[a] < cluster_of[b]; });
  struct Own {
    std::string fits;  // 1 for each that has it
    std::vector<int> observations;
    int cluster = 0;
  };
  std::vector<Own> order;
  for (const int k : by_cluster) {
    if (order.empty() || order.back().cluster != cluster_of[k]) {
      order.push_back({{}, {}, cluster_of[k]});
      for (const Fit& fit : fits_) order.back().fits += Has(fit, cluster_of[k]) ? '1' : '0';
    }
    order.back().observations.push_back(k);
  }
  std::sort(order.begin(), order.end(), [](const Own& a, const Own& b) {
    const size_t size_a = a.observations.size(), size_b = b.observations.size();
    return std::tie(a.fits, size_a, a.cluster) < std::tie(b.fits, size_b, b.cluster);
  });
  std::vector<int> clusters;
  std::vector<RowMajorMatrix> own;
  for (size_t i = 0; i < order.size(); ++i) {
    const std::vector<int>& seen = order[i].observations;
    RowMajorMatrix& block = own.emplace_back(static_cast<Eigen::Index>(3 * seen.size()), columns_ + 1);
    for (size_t k = 0; k < seen.size(); ++k) {
      block.middleRows<3>(3 * static_cast<Eigen::Index>(k)) = rows.middleRows<3>(3 * seen[k]);
    }
    block = Shortened(std::move(block));
    clusters.push_back(order[i].cluster);
    if (clusters.size() < kBatchLanes && i + 1 < order.size()) continue;
    AddLanes(clusters, own);
    clusters.clear();
    own.clear();
  }
}

void ClusterSandwich::Add(const RowStream& stream, const ParameterSet& parameters, const std::vector<int>& columns,
                          const std::vector<int>& cluster_of) {
  std::vector<int> own;
  stream.ForEach(parameters, columns, [&](const RowPiece& piece) {
    own.clear();
    for (const int k : piece.positions) own.push_back(cluster_of[k]);
    Add(piece.rows, own);
  });
}

void ClusterSandwich::AddLanes(const std::vector<int>& clusters, const std::vector<RowMajorMatrix>& rows) {
  ClusterLanes lanes;
  for (const RowMajorMatrix& own : rows) lanes.rows = std::max(lanes.rows, static_cast<std::size_t>(own.rows()));
  lanes.columns = static_cast<std::size_t>(padded_);
  lanes.stride = lanes.columns + 1;
  double* const cells = cells_.Reserve(lanes.rows * lanes.stride * kBatchLanes);
  lanes.cells = cells;
  for (size_t i = 0; i < rows.size(); ++i) {
    for (Eigen::Index r = 0; r < rows[i].rows(); ++r) {
      double* const lane = cells + static_cast<size_t>(r) * lanes.stride * kBatchLanes + i;
      for (int c = 0; c < columns_; ++c) lane[c * kBatchLanes] = rows[i](r, c);
      lane[lanes.columns * kBatchLanes] = rows[i](r, columns_);
    }
  }
  double leverages[kBatchLanes];
  LeveragesOf(lanes, root_.data(), leverages);
  for (size_t i = 0; i < clusters.size(); ++i) Draw(clusters[i], leverages[i], rows[i]);
  for (Fit& fit : fits_) Score(lanes, clusters, rows, &fit);
}

void ClusterSandwich::Draw(int cluster, double leverage, const RowMajorMatrix& rows) {
  // sum_g h_g = tr H = p: about kSampled clusters are drawn. Each stands for 1 / probability of them, which leaves
  // every sum over clusters unbiased (Horvitz and Thompson 1952).
  const double expected = clusters_ <= kSampled ? 1.0 : kSampled * leverage / std::max(1, columns_);
  if (Chance(cluster) >= expected) return;
  sample_.push_back({cluster, 1.0 / std::min(1.0, expected), rows});
}

void ClusterSandwich::Score(const ClusterLanes& lanes, const std::vector<int>& clusters,
                            const std::vector<RowMajorMatrix>& rows, Fit* fit) {
  double counts[kBatchLanes] = {};
  bool any = false;
  for (size_t i = 0; i < clusters.size(); ++i) {
    if (Has(*fit, clusters[i])) counts[i] = 1.0, any = true;
  }
  if (!any) return;
  if (fit->num_held == kHeldScores) Flush(fit);
  double* const scores = fit->held + static_cast<size_t>(fit->num_held++) * padded_ * kBatchLanes;
  double* const work = work_.Reserve((2 * lanes.rows + 2 * lanes.columns) * kBatchLanes);
  const unsigned too_long = ScoreClusters(lanes, {fit->inverse_normal.data(), fit->step.data(), counts}, work, scores);
  for (size_t i = 0; i < clusters.size() && too_long != 0; ++i) {
    if ((too_long >> i & 1u) == 0) continue;
    const Eigen::MatrixXd j = Columns(rows[i], *fit);
    Eigen::VectorXd residual = rows[i].col(columns_);
    if (fit->given.step.size() > 0) residual += j * fit->given.step;
    const Eigen::MatrixXd b = j * fit->given.solution.covariance_root;
    residual += (Unshrinking(b * b.transpose()) * residual).eval();
    const Eigen::VectorXd score = j.transpose() * residual;
    for (size_t c = 0; c < fit->given.columns.size(); ++c) {
      scores[static_cast<size_t>(fit->given.columns[c]) * kBatchLanes + i] = score[static_cast<Eigen::Index>(c)];
    }
  }
}

void ClusterSandwich::Flush(Fit* fit) {
  std::vector<const double*> rows;
  for (int i = 0; i < fit->num_held; ++i) rows.push_back(fit->held + static_cast<size_t>(i) * padded_ * kBatchLanes);
  fit->products.Add(rows, 0, 0);
  fit->num_held = 0;
}

Eigen::MatrixXd ClusterSandwich::Columns(const RowMajorMatrix& rows, const Fit& fit) const {
  return rows(Eigen::all, fit.given.columns);
}

Eigen::VectorXd ClusterSandwich::DegreesOf(const Fit& fit) const {
  const Eigen::MatrixXd& root = fit.given.solution.covariance_root;
  Satterthwaite satterthwaite(static_cast<int>(root.cols()));
  for (size_t first = 0, next = 0; first < sample_.size(); first = next) {
    std::vector<const Sample*> own;
    Eigen::Index count = 0;
    for (; next < sample_.size() && count < kSampledRowsAtOnce; ++next) {
      if (!Has(fit, sample_[next].cluster)) continue;
      own.push_back(&sample_[next]);
      count += sample_[next].rows.rows();
    }
    Eigen::MatrixXd rows(count, root.rows());
    Eigen::Index at = 0;
    for (const Sample* sample : own) {
      rows.middleRows(at, sample->rows.rows()) = Columns(sample->rows, fit);
      at += sample->rows.rows();
    }
    const Eigen::MatrixXd b = TallProduct(rows, root);
    Eigen::MatrixXd unshrunk = b;
    std::vector<Eigen::MatrixXd> h;
    at = 0;
    for (const Sample* sample : own) {
      const auto of_sample = b.middleRows(at, sample->rows.rows());
      h.push_back(of_sample * of_sample.transpose());
      unshrunk.middleRows(at, sample->rows.rows()) += Unshrinking(h.back()) * of_sample;
      at += sample->rows.rows();
    }
    const Eigen::MatrixXd a = TallProduct(unshrunk, root.transpose());
    at = 0;
    for (size_t i = 0; i < own.size(); ++i) {
      const Eigen::Index n = own[i]->rows.rows();
      satterthwaite.Add(b.middleRows(at, n), h[i], a.middleRows(at, n), own[i]->weight);
      at += n;
    }
  }
  return satterthwaite.Degrees();
}

RobustCovariance ClusterSandwich::Result(int which, const Eigen::MatrixXd& priors) {
  Fit& fit = fits_[which];
  if (fit.num_held > 0) Flush(&fit);
  const std::vector<int>& columns = fit.given.columns;
  const auto n = static_cast<Eigen::Index>(columns.size());
  Eigen::MatrixXd scores(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index k = i; k < n; ++k) scores(i, k) = scores(k, i) = fit.products.At(columns[i], columns[k]);
  }
  const Eigen::MatrixXd& inverse_normal = fit.given.solution.covariance;
  // C = M (sum s_g s_g') M + (M P')(M P')', M = (J'J)^-1: rows of priors P keep the variance 1 that they are whitened
  // to.
  const Eigen::MatrixXd sampled = inverse_normal * scores * inverse_normal;
  RobustCovariance result;
  result.clusters = fit.clusters;
  result.covariance = sampled;
  if (priors.rows() > 0) {
    const Eigen::MatrixXd stated = inverse_normal * priors.transpose();
    result.covariance += stated * stated.transpose();
  }
  const Eigen::VectorXd dof = DegreesOf(fit);
  result.dof.resize(n);
  for (Eigen::Index c = 0; c < n; ++c) {
    // A prior is exact: only the sampled part scatters, nu = 2 C^2 / var(C) = nu_sampled / share^2.
    const double share = sampled(c, c) / std::max(1e-300, result.covariance(c, c));
    result.dof[c] = dof[c] / std::max(1e-12, share * share);
  }
  return result;
}

}  // namespace sagitta

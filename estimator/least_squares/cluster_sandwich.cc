#include "estimator/least_squares/cluster_sandwich.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <tuple>
#include <utility>

#include "estimator/least_squares/row_sums.h"
#include "estimator/least_squares/satterthwaite.h"
#include "models/batch/shot_program.h"
#include "models/random_bits.h"

namespace sagitta {
namespace {

// Clusters that degrees of freedom are made of: good to 1 / sqrt(n) of them, 2 and 4 %. Where there are more clusters
// these are hundreds, and a quantile of 95 % moves by 1e-4.
constexpr double kSampled = 2000.0, kSampledOfPart = 500.0;
constexpr int kHeldScores = 32;  // rows of lanes that are summed together
constexpr Eigen::Index kSampledRowsAtOnce = 512;

// In [0, 1), the same for a cluster wherever it is asked.
double Chance(int cluster) { return UnitNumber(MixedBits((static_cast<std::uint64_t>(cluster) + 1) * kGoldenBits)); }

// As few rows with the same products: what a cluster is worth depends on those alone.
RowMajorMatrix Shortened(RowMajorMatrix rows) {
  const Eigen::Index numbers = rows.cols();
  if (rows.rows() <= numbers) return rows;
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr{Eigen::MatrixXd(rows)};
  return Eigen::MatrixXd(qr.matrixQR().topRows(numbers).triangularView<Eigen::Upper>());
}

// Upper triangular W with W W' = C: the Cholesky factor from the last column on.
Eigen::MatrixXd UpperRoot(const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd scale = covariance.diagonal().cwiseMax(1e-300).cwiseSqrt();
  const Eigen::MatrixXd correlation =
      scale.cwiseInverse().asDiagonal() * covariance * scale.cwiseInverse().asDiagonal();
  const Eigen::MatrixXd lower = Eigen::MatrixXd(correlation.reverse()).llt().matrixL();
  return scale.asDiagonal() * Eigen::MatrixXd(lower.reverse());
}

void Pad(const Eigen::MatrixXd& matrix, int padded, std::vector<double>* numbers) {
  numbers->assign(static_cast<size_t>(padded) * padded, 0.0);
  for (Eigen::Index a = 0; a < matrix.rows(); ++a) {
    for (Eigen::Index b = 0; b < matrix.cols(); ++b) {
      (*numbers)[static_cast<size_t>(a) * padded + static_cast<size_t>(b)] = matrix(a, b);
    }
  }
}

}  // namespace

ClusterSandwich::ClusterSandwich(int columns, int clusters, const Eigen::MatrixXd& normal, std::vector<ClusterFit> fits,
                                 const Eigen::MatrixXd& turn, int shares)
    : columns_(columns),
      padded_((columns + kGramBlock - 1) / kGramBlock * kGramBlock),
      clusters_(clusters),
      in_fits_(static_cast<size_t>(clusters), 0),
      scratch_(static_cast<size_t>(shares)) {
  Pad(UpperRoot(normal), padded_, &root_);
  const Eigen::MatrixXd along = turn.size() > 0 ? turn : Eigen::MatrixXd::Identity(columns, columns);
  const auto count = padded_ / kGramBlock;
  int different = 1;  // sets of fits
  for (ClusterFit& given : fits) {
    Fit& fit = fits_.emplace_back();
    fit.given = std::move(given);
    std::vector<int>& own = fit.given.columns;
    const bool all = own.empty();
    for (int c = 0; all && c < columns; ++c) own.push_back(c);
    fit.basis = along(Eigen::all, own);
    Pad(fit.basis * fit.given.solution.covariance * fit.basis.transpose(), padded_, &fit.inverse_normal);
    fit.step.assign(static_cast<size_t>(padded_), 0.0);
    if (fit.given.step.size() > 0) Eigen::VectorXd::Map(fit.step.data(), columns) = fit.basis * fit.given.step;
    fit.products = GramSums(count, count, true);
    fit.held = fit.memory.Reserve(static_cast<size_t>(kHeldScores) * padded_ * kBatchLanes);
    fit.clusters = clusters;
    if (fit.given.has.empty()) continue;
    fit.clusters = static_cast<int>(std::count(fit.given.has.begin(), fit.given.has.end(), 1));
    std::vector<int> numbers(2 * static_cast<size_t>(different), -1);
    different = 0;
    for (int c = 0; c < clusters; ++c) {
      int& number = numbers[2 * static_cast<size_t>(in_fits_[c]) + (fit.given.has[c] != 0 ? 1 : 0)];
      if (number < 0) number = different++;
      in_fits_[c] = number;
    }
  }
}

void ClusterSandwich::Add(const RowMajorMatrix& rows, const std::vector<int>& cluster_of, const Share& share) {
  Scratch& scratch = scratch_[static_cast<size_t>(share.number)];
  std::vector<int>& by_cluster = scratch.by_cluster;
  std::vector<Member>& members = scratch.members;
  // Clusters that the same fits have side by side, by their numbers of rows.
  by_cluster.resize(cluster_of.size());
  std::iota(by_cluster.begin(), by_cluster.end(), 0);
  const auto is_before = [&](int a, int b) { return cluster_of[a] < cluster_of[b]; };
  if (!std::is_sorted(cluster_of.begin(), cluster_of.end())) {
    std::stable_sort(by_cluster.begin(), by_cluster.end(), is_before);
  }
  members.clear();
  for (size_t i = 0; i < by_cluster.size(); ++i) {
    const int cluster = cluster_of[by_cluster[i]];
    if (members.empty() || members.back().cluster != cluster) members.push_back({in_fits_[cluster], cluster, i, 0});
    ++members.back().count;
  }
  std::sort(members.begin(), members.end(), [](const Member& a, const Member& b) {
    return std::tie(a.fits, a.count, a.cluster) < std::tie(b.fits, b.count, b.cluster);
  });
  for (size_t first = 0; first < members.size(); first += kBatchLanes) {
    const size_t count = std::min<size_t>(kBatchLanes, members.size() - first);
    for (size_t i = 0; i < count; ++i) Fill(members[first + i], rows, by_cluster, &scratch.lanes[i]);
    AddLanes(count, share, &scratch);
  }
}

void ClusterSandwich::Fill(const Member& member, const RowMajorMatrix& rows, const std::vector<int>& by_cluster,
                           Lane* lane) const {
  lane->cluster = member.cluster;
  lane->rows.clear();
  for (size_t i = member.first; i < member.first + member.count; ++i) {
    for (int axis = 0; axis < 3; ++axis) lane->rows.push_back(&rows(3 * by_cluster[i] + axis, 0));
  }
  if (lane->rows.size() <= static_cast<size_t>(columns_) + 1) return;
  lane->shortened = Shortened(RowsOf(*lane));
  lane->rows.clear();
  for (Eigen::Index r = 0; r < lane->shortened.rows(); ++r) lane->rows.push_back(&lane->shortened(r, 0));
}

RowMajorMatrix ClusterSandwich::RowsOf(const Lane& lane) const {
  RowMajorMatrix rows(static_cast<Eigen::Index>(lane.rows.size()), columns_ + 1);
  for (size_t r = 0; r < lane.rows.size(); ++r)
    std::copy_n(lane.rows[r], columns_ + 1, &rows(static_cast<Eigen::Index>(r), 0));
  return rows;
}

void ClusterSandwich::Add(const RowPiece& piece, const std::vector<int>& cluster_of, const Share& share) {
  std::vector<int>& own = scratch_[static_cast<size_t>(share.number)].clusters_of_piece;
  own.clear();
  for (const int k : piece.positions) own.push_back(cluster_of[k]);
  Add(piece.rows, own, share);
}

void ClusterSandwich::AddLanes(std::size_t count, const Share& share, Scratch* scratch) {
  const std::vector<Lane>& lanes = scratch->lanes;
  ClusterLanes cells;
  for (size_t i = 0; i < count; ++i) cells.rows = std::max(cells.rows, lanes[i].rows.size());
  cells.columns = static_cast<std::size_t>(padded_);
  cells.stride = cells.columns + 1;
  double* const memory = scratch->cells.Reserve(cells.rows * cells.stride * kBatchLanes);
  cells.cells = memory;
  for (size_t i = 0; i < count; ++i) {
    for (size_t r = 0; r < lanes[i].rows.size(); ++r) {
      double* const cell = memory + r * cells.stride * kBatchLanes + i;
      const double* const row = lanes[i].rows[r];
      for (int c = 0; c < columns_; ++c) cell[c * kBatchLanes] = row[c];
      cell[cells.columns * kBatchLanes] = row[columns_];
    }
  }
  for (size_t f = 0; f < fits_.size(); ++f) {
    if (share.Has(f)) Score(cells, count, scratch, &fits_[f]);
  }
  if (!share.Has(static_cast<size_t>(share.count) - 1))
    return;  // the last draws the sample: the first has the fit of all
  double leverages[kBatchLanes];
  LeveragesOf(cells, root_.data(), leverages);
  for (size_t i = 0; i < count; ++i) Draw(lanes[i], leverages[i]);
}

// sum_g h_g = tr H = p: about kSampled clusters are drawn. Each stands for 1 / probability of them, which leaves every
// sum over clusters unbiased (Horvitz and Thompson 1952).
double ClusterSandwich::Expected(double leverage, bool of_part) const {
  if (clusters_ <= kSampled) return 1.0;
  return std::min(1.0, (of_part ? kSampledOfPart : kSampled) * leverage / std::max(1, columns_));
}

void ClusterSandwich::Draw(const Lane& lane, double leverage) {
  if (Chance(lane.cluster) < Expected(leverage, false)) sample_.push_back({lane.cluster, leverage, RowsOf(lane)});
}

void ClusterSandwich::Score(const ClusterLanes& lanes, std::size_t count, Scratch* scratch, Fit* fit) const {
  double counts[kBatchLanes] = {};
  bool any = false;
  for (size_t i = 0; i < count; ++i) {
    if (Has(*fit, scratch->lanes[i].cluster)) counts[i] = 1.0, any = true;
  }
  if (!any) return;
  if (fit->num_held == kHeldScores) Flush(fit);
  double* const scores = fit->held + static_cast<size_t>(fit->num_held++) * padded_ * kBatchLanes;
  double* const work = scratch->work.Reserve((2 * lanes.rows + 2 * lanes.columns) * kBatchLanes);
  const unsigned too_long = ScoreClusters(lanes, {fit->inverse_normal.data(), fit->step.data(), counts}, work, scores);
  for (size_t i = 0; i < count && too_long != 0; ++i) {
    if ((too_long >> i & 1u) == 0) continue;
    const RowMajorMatrix rows = RowsOf(scratch->lanes[i]);
    const Eigen::MatrixXd j = rows.leftCols(columns_);
    Eigen::VectorXd residual = rows.col(columns_);
    residual += j * Eigen::VectorXd::Map(fit->step.data(), columns_);
    const Eigen::MatrixXd b = j * (fit->basis * fit->given.solution.covariance_root);
    residual += (Unshrinking(b * b.transpose()) * residual).eval();
    const Eigen::VectorXd score = j.transpose() * residual;
    for (int c = 0; c < columns_; ++c) scores[static_cast<size_t>(c) * kBatchLanes + i] = score[c];
  }
}

void ClusterSandwich::Flush(Fit* fit) const {
  std::vector<const double*> rows;
  for (int i = 0; i < fit->num_held; ++i) rows.push_back(fit->held + static_cast<size_t>(i) * padded_ * kBatchLanes);
  fit->products.Add(rows, 0, 0);
  fit->num_held = 0;
}

Eigen::VectorXd ClusterSandwich::DegreesOf(int which, const std::vector<int>& listed) const {
  if (listed.empty()) return {};
  const Fit& fit = fits_[which];
  const Eigen::MatrixXd& root = fit.given.solution.covariance_root;
  const Eigen::MatrixXd root_of_listed = root(listed, Eigen::all).transpose();
  const Eigen::MatrixXd root_of_rows = fit.basis * root;
  const bool of_part = !fit.given.has.empty();
  Satterthwaite satterthwaite(static_cast<int>(listed.size()));
  for (size_t first = 0, next = 0; first < sample_.size(); first = next) {
    std::vector<const Sample*> own;
    Eigen::Index count = 0;
    for (; next < sample_.size() && count < kSampledRowsAtOnce; ++next) {
      const Sample& sample = sample_[next];
      if (!Has(fit, sample.cluster) || Chance(sample.cluster) >= Expected(sample.leverage, of_part)) continue;
      own.push_back(&sample);
      count += sample.rows.rows();
    }
    Eigen::MatrixXd rows(count, columns_);
    std::vector<Eigen::Index> begins = {0};
    std::vector<double> weights;
    for (const Sample* sample : own) {
      rows.middleRows(begins.back(), sample->rows.rows()) = sample->rows.leftCols(columns_);
      begins.push_back(begins.back() + sample->rows.rows());
      weights.push_back(1.0 / Expected(sample->leverage, of_part));
    }
    satterthwaite.AddClusters(TallProduct(rows, root_of_rows), begins, root_of_listed, weights);
  }
  return satterthwaite.Degrees();
}

RobustCovariance ClusterSandwich::Covariance(int which) {
  Fit& fit = fits_[which];
  if (fit.num_held > 0) Flush(&fit);
  const std::vector<double> totals = fit.products.Totals();
  Eigen::MatrixXd by_rows(columns_, columns_);
  for (int i = 0; i < columns_; ++i) {
    for (int k = i; k < columns_; ++k) by_rows(i, k) = by_rows(k, i) = totals[static_cast<size_t>(i) * padded_ + k];
  }
  const Eigen::MatrixXd scores = fit.basis.transpose() * Eigen::MatrixXd(by_rows * fit.basis);
  const Eigen::MatrixXd& inverse_normal = fit.given.solution.covariance;
  return {inverse_normal * scores * inverse_normal, {}, fit.clusters};
}

// C = M (sum s_g s_g') M + (M P')(M P')', M = (J'J)^-1: rows of priors P keep the variance 1 that they are whitened to.
RobustCovariance ClusterSandwich::Result(int which, const Eigen::MatrixXd& priors) {
  RobustCovariance result = Covariance(which);
  const Eigen::VectorXd sampled = result.covariance.diagonal();
  if (priors.rows() > 0) {
    const Eigen::MatrixXd stated = fits_[which].given.solution.covariance * priors.transpose();
    result.covariance += stated * stated.transpose();
  }
  std::vector<int> all(static_cast<size_t>(sampled.size()));
  std::iota(all.begin(), all.end(), 0);
  result.dof = DegreesOf(which, all);
  for (Eigen::Index c = 0; c < sampled.size(); ++c) {
    // A prior is exact: only the sampled part scatters, nu = 2 C^2 / var(C) = nu_sampled / share^2.
    const double share = sampled[c] / std::max(1e-300, result.covariance(c, c));
    result.dof[c] /= std::max(1e-12, share * share);
  }
  return result;
}

}  // namespace sagitta

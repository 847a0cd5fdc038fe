// Linear algebra on rows of which each number stands for kBatchLanes shots (models/batch/batch_rows.h): what the sums
// of normal equations are made of. Instructions are chosen at run time.
#pragma once

#include <cstddef>
#include <vector>

namespace sagitta {

constexpr int kGramBlock = 4;  // columns that are summed together; column ranges begin and end at multiples of it

// The first address from p on that the lanes of a batch may begin at.
double* Aligned(double* p);

// Sums of products of two ranges of columns, lane by lane. `symmetric`: both ranges are one, blocks below the diagonal
// are left out.
class GramSums {
 public:
  GramSums() = default;
  GramSums(int blocks_a, int blocks_b, bool symmetric);

  // rows: pointers to rows of lanes; columns first_a + .. and first_b + .. of each.
  void Add(const std::vector<const double*>& rows, int first_a, int first_b);
  // Over all lanes: row a, column b, both from 0, row by row; of a symmetric sum b >= a only, the rest is zero.
  std::vector<double> Totals() const;
  int columns_b() const { return blocks_b_ * kGramBlock; }

 private:
  int blocks_a_ = 0, blocks_b_ = 0;
  bool symmetric_ = false;
  std::vector<double> lanes_;  // unaligned; by block, then column of a, column of b, lane
};

// sums += rows' rows of `count` rows, one after the other, of `columns` numbers (a multiple of kBatchLanes); both
// aligned. sums: row by row, of each row those from its diagonal on.
void AddProducts(const double* rows, std::size_t count, std::size_t columns, double* sums);

// product = X W for matrices stored column by column: x has `rows` rows (of `stride` numbers from column to column) and
// n columns, w n x k; product as many rows from column to column as x.
void MultiplyColumns(const double* x, std::size_t stride, std::size_t rows, std::size_t n, const double* w,
                     std::size_t k, double* product);

// kBatchLanes clusters side by side, zeros where one has fewer rows than another: rows of `stride` numbers per lane, of
// which the first `columns` (a multiple of kGramBlock) are J_g and the next is the residual.
struct ClusterLanes {
  std::size_t rows = 0, stride = 0, columns = 0;
  const double* cells = nullptr;  // aligned
};

// What a cluster is worth in one fit: J_g' (I - J_g M J_g')^-1/2 (r_g + J_g step), by the binomial series. Both
// matrices have columns x columns numbers.
struct ScoreFit {
  const double* inverse_normal = nullptr;  // M
  const double* step = nullptr;            // one number per column
  const double* counts = nullptr;          // of each lane: 1, or 0 where it is no part of the fit
};
// scores: columns x kBatchLanes, aligned. work: (2 rows + 2 columns) x kBatchLanes numbers, aligned. Returns the lanes
// whose series is too long, one bit each; their scores are not to be used.
unsigned ScoreClusters(const ClusterLanes& clusters, const ScoreFit& fit, double* work, double* scores);

// tr(J_g W W' J_g') of each lane; W upper triangular, row by row.
void LeveragesOf(const ClusterLanes& clusters, const double* root, double* leverages);

// Whitens rows that share deviations L (columns latent .. latent + count of each row, times their sigmas):
// rows <- chol(I + L L')^-1 rows, the columns before L. num_rows rows of `columns` columns. factor: num_rows x num_rows
// x kBatchLanes numbers to work in; both aligned.
void MarginaliseLanes(int num_rows, int columns, int latent, int count, double* rows, double* factor);

}  // namespace sagitta

// Products of all columns, as they are asked for. Most columns are a source's rows times a function of the shots, and
// what is asked of them follows from products shot by shot: with s and t the rows of two sources, f and h the functions
//
//   A_f'C^-1 A_h = f'S h,  S(i, j) = s_i'C^-1 t_j of shots i and j,    A_f'C^-1 X = sum over shots of f(i) s_i'C^-1 X
//
// which needs one row per shot in place of three per reading. S is zero between shots of different poses.
#include <glog/logging.h>

#include <Eigen/Cholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <functional>
#include <map>
#include <numeric>
#include <set>

#include "estimator/explanations/evidence_columns.h"
#include "estimator/least_squares/row_sums.h"
#include "models/batch/shot_program.h"

namespace sagitta {
namespace {

constexpr long kRowsTogether = 24;  // of products: what the widest vectors have registers for

}  // namespace

class EvidenceColumns::ShotProducts {
 public:
  ShotProducts(const EvidenceColumns& columns, const std::vector<BlockRoots>& roots)
      : columns_(columns), roots_(roots) {}

  // A'C^-1 A of columns that are all of families.
  Eigen::MatrixXd Own(const std::vector<int>& listed) {
    const std::vector<Part> parts = PartsOf(listed);
    const auto size = static_cast<long>(listed.size());
    Eigen::MatrixXd own(size, size);
    for (const Part& one : parts) {
      for (const Part& other : parts) {
        if (other.source < one.source) continue;
        const Eigen::MatrixXd along = Of(one.source, other.source).Times(other.functions);
        const Eigen::MatrixXd block = TallProduct(one.functions.transpose(), along);
        own(one.places, other.places) = block;
        own(other.places, one.places) = block.transpose();
      }
    }
    return own;
  }

 private:
  // Columns of one source.
  struct Part {
    size_t source = 0;
    std::vector<long> places;   // in the list
    Eigen::MatrixXd functions;  // fitted shots x columns
  };

  std::vector<Part> PartsOf(const std::vector<int>& listed) const {
    std::map<size_t, std::vector<long>> places;
    for (size_t k = 0; k < listed.size(); ++k) places[columns_.SourceOf(listed[k])].push_back(static_cast<long>(k));
    std::vector<Part> parts;
    for (const auto& [source, own] : places) {
      std::vector<int> columns;
      for (const long k : own) columns.push_back(listed[k]);
      parts.push_back({source, own, columns_.FunctionOf(columns)(columns_.fitted_shots_, Eigen::all)});
    }
    return parts;
  }

  // S of two sources, fitted shots x fitted shots; what lies off the diagonal is of poses with several shots.
  struct ByShot {
    Eigen::VectorXd diagonal;
    Eigen::SparseMatrix<double> off_diagonal;

    Eigen::MatrixXd Times(const Eigen::MatrixXd& functions) const {
      Eigen::MatrixXd product = diagonal.asDiagonal() * functions;
      if (off_diagonal.nonZeros() > 0) product += off_diagonal * functions;
      return product;
    }
  };

  const ByShot& Of(size_t one, size_t other) {
    const auto [known, is_new] = known_.try_emplace({one, other});
    ByShot& products = known->second;
    if (!is_new) return products;
    const auto shots = static_cast<long>(columns_.fitted_shots_.size());
    products.diagonal.setZero(shots);
    products.off_diagonal.resize(shots, shots);
    std::vector<Eigen::Triplet<double>> off_diagonal;
    for (size_t b = 0; b < columns_.stored_.size(); ++b) {
      AddBlock(b, one, other, [&](int shot, int with, double product) {
        if (shot == with) {
          products.diagonal[shot] += product;
        } else {
          off_diagonal.emplace_back(shot, with, product);
        }
      });
    }
    products.off_diagonal.setFromTriplets(off_diagonal.begin(),
                                          off_diagonal.end());  // sums what is of one pair of shots
    return products;
  }

  // add(shot, shot, product): to the products of two shots.
  void AddBlock(size_t b, size_t one, size_t other, const std::function<void(int, int, double)>& add) const {
    const Block& block = columns_.stored_[b];
    const Eigen::VectorXd &s = block.sources[one], &t = block.sources[other];
    const auto shot_of = [&](size_t o) { return columns_.FittedShotOf(block.observations[o]); };
    if (roots_[b].empty()) {
      for (size_t o = 0; o < block.observations.size(); ++o) {
        const long top = static_cast<long>(3 * o);
        add(shot_of(o), shot_of(o), s.segment<3>(top).dot(t.segment<3>(top)));
      }
      return;
    }
    for (const PoseRoot& pose : roots_[b]) {
      const long height = pose.root.rows();
      const auto first = static_cast<size_t>(pose.top / 3), last = first + static_cast<size_t>(height / 3);
      std::map<int, long> place;  // of its shots
      for (size_t o = first; o < last; ++o) place.emplace(shot_of(o), static_cast<long>(place.size()));
      Eigen::MatrixXd by_shot = Eigen::MatrixXd::Zero(height, place.size());
      for (size_t o = first; o < last; ++o) {
        const long top = static_cast<long>(3 * (o - first));
        by_shot.col(place[shot_of(o)]).segment<3>(top) = t.segment<3>(pose.top + top);
      }
      const Eigen::MatrixXd solved = pose.root.solve(by_shot);
      for (size_t o = first; o < last; ++o) {
        const long top = static_cast<long>(3 * (o - first));
        for (const auto& [shot, column] : place) {
          add(shot_of(o), shot, s.segment<3>(pose.top + top).dot(solved.col(column).segment<3>(top)));
        }
      }
    }
  }

  const EvidenceColumns& columns_;
  const std::vector<BlockRoots>& roots_;
  std::map<std::pair<size_t, size_t>, ByShot> known_;
};

struct EvidenceColumns::AllSums {
  RowSums whitened;               // log det and rows alone
  Eigen::MatrixXd with_believed;  // [J A r]'C^-1 [J r]
  ColumnProducts::OwnBlocks own;
};

namespace {

// Columns of which rows are made: those of the linearization, and those that are asked for together with one.
std::vector<int> ColumnsByRows(int of_linearization, const std::set<std::vector<int>>& own) {
  std::set<int> columns;
  for (int c = 0; c < of_linearization; ++c) columns.insert(columns.end(), c);
  for (const std::vector<int>& list : own) {
    const bool any = std::any_of(list.begin(), list.end(), [&](int c) { return c < of_linearization; });
    if (any) columns.insert(list.begin(), list.end());
  }
  return {columns.begin(), columns.end()};
}

std::vector<long> PlacesOf(const std::vector<int>& list, const std::vector<int>& sorted) {
  std::vector<long> places;
  for (const int c : list) places.push_back(static_cast<long>(PlaceIn(sorted, c)));
  return places;
}

}  // namespace

EvidenceColumns::AllSums EvidenceColumns::SumAll(const RowScatter& scatter, const std::set<std::vector<int>>& own,
                                                 std::vector<BlockRoots>* roots) const {
  const long believed = num_believed(), of_linearization = static_cast<long>(catalogue_.size());
  const std::vector<int> by_rows = ColumnsByRows(static_cast<int>(of_linearization), own);
  const auto count = static_cast<long>(by_rows.size());
  std::map<std::vector<int>, std::vector<long>> places;  // of lists, among those
  AllSums all;
  for (const std::vector<int>& list : own) {
    if (list.empty() || *std::min_element(list.begin(), list.end()) >= of_linearization) continue;
    places[list] = PlacesOf(list, by_rows);
    all.own[list] = Eigen::MatrixXd::Zero(list.size(), list.size());
  }
  Eigen::MatrixXd of_rows = Eigen::MatrixXd::Zero(believed + count + 1, believed + 1);
  std::vector<Eigen::MatrixXd> along;  // [J r]'C^-1 of each block
  Eigen::MatrixXd rows;
  for (const Block& block : stored_) {
    FillRows(block, by_rows, &rows);
    roots->push_back(RootsOf(block.observations, block.here.latent, scatter));
    all.whitened.log_det += Whiten(roots->back(), &rows);
    all.whitened.rows += block.here.num_rows();
    Eigen::MatrixXd with(rows.rows(), believed + 1);
    with << rows.leftCols(believed), rows.rightCols(1);
    of_rows += TallProduct(rows.transpose(), with);
    const Eigen::MatrixXd explaining = rows.middleCols(believed, count);
    for (const auto& [list, own_places] : places) {
      const Eigen::MatrixXd of = explaining(Eigen::all, own_places);
      all.own[list] += TallProduct(of.transpose(), of);
    }
    WhitenAgain(roots->back(), &with);
    along.push_back(with.transpose());
  }
  all.with_believed.resize(believed + num_columns_ + 1, believed + 1);
  all.with_believed << of_rows.topRows(believed + of_linearization), AlongFamilies(along).transpose(),
      of_rows.bottomRows(1);
  ShotProducts by_shot(*this, *roots);
  for (const std::vector<int>& list : own) {
    const auto [place, is_new] = all.own.try_emplace(list);
    if (is_new) place->second = by_shot.Own(list);
  }
  return all;
}

GivenBelieved EvidenceColumns::ProjectAll(const RowScatter& scatter, const std::set<std::vector<int>>& own) const {
  VLOG(1) << "diagnosis: products of " << num_columns_ << " columns in " << own.size() << " groups";
  if (stored_.size() < observations_of_block_.size()) return Project(Sum(scatter, AllColumns()));
  const long believed = num_believed();
  std::vector<BlockRoots> roots;
  AllSums all = SumAll(scatter, own, &roots);
  const Eigen::MatrixXd& few = all.with_believed;
  Eigen::MatrixXd with_others(believed, num_columns_ + 1);
  with_others << few.middleRows(believed, num_columns_).leftCols(believed).transpose(), few.topRightCorner(believed, 1);
  const Eliminated out = Eliminate(few.topLeftCorner(believed, believed), std::move(with_others),
                                   few(few.rows() - 1, believed), all.whitened);
  const Eigen::MatrixXd along = out.along.leftCols(num_columns_);
  const Eigen::VectorXd of_residual = out.along.rightCols(1);
  Eigen::VectorXd seen = Eigen::VectorXd::Ones(num_columns_);  // 0: of a column that what is believed contains
  for (const auto& [columns, sum] : all.own) {
    for (size_t k = 0; k < columns.size(); ++k) {
      const double left = sum(k, k) - along.col(columns[k]).squaredNorm();
      if (!(left > kContained * sum(k, k))) seen[columns[k]] = 0.0;
    }
  }
  for (auto& [columns, sum] : all.own) {
    const Eigen::MatrixXd of = along(Eigen::all, columns);
    const Eigen::VectorXd kept = seen(columns);
    sum = kept.asDiagonal() * (sum - of.transpose() * of) * kept.asDiagonal();
  }
  const Eigen::VectorXd gradient =
      seen.cwiseProduct(few.rightCols(1).middleRows(believed, num_columns_) - along.transpose() * of_residual);
  const auto rows_of = [this, roots, along, seen](const std::vector<int>& columns) -> Eigen::MatrixXd {
    const Eigen::MatrixXd of = along(Eigen::all, columns);
    const Eigen::VectorXd kept = seen(columns);
    return kept.asDiagonal() * (ProductsOf(columns, roots) - of.transpose() * along) * seen.asDiagonal();
  };
  return {{ColumnProducts(std::move(all.own), rows_of), gradient, out.square - of_residual.squaredNorm(), out.dof},
          out.log_constant};
}

// (u's)(shot) of each source, a column for each shot that is fitted, or for each of the data: of some rows of u', zeros
// below. Most sources move the readings of some shots or markers only. sums: of each source, and where they are made.
void EvidenceColumns::SumOfShots(const std::vector<Eigen::MatrixXd>& along, long first, const std::vector<int>& places,
                                 std::vector<Eigen::MatrixXd>* sums) const {
  for (Eigen::MatrixXd& of_source : *sums) of_source.setZero();
  const long rows = sums->empty() ? 0 : sums->front().rows(), own = std::min(rows, along[0].rows() - first);
  for (size_t b = 0; b < stored_.size(); ++b) {
    const Block& block = stored_[b];
    Eigen::MatrixXd u = Eigen::MatrixXd::Zero(rows, along[b].cols());
    u.topRows(own) = along[b].middleRows(first, own);
    for (size_t s = 0; s < sources_.size(); ++s) {
      for (size_t o = 0; o < block.observations.size(); ++o) {
        const long top = static_cast<long>(3 * o);
        const Vector3<double> moved = block.sources[s].segment<3>(top);
        if (moved.isZero(0.0)) continue;
        (*sums)[s].col(places[extended_.data().observations[block.observations[o]].shot]) +=
            moved[0] * u.col(top) + moved[1] * u.col(top + 1) + moved[2] * u.col(top + 2);
      }
    }
  }
}

// With u of each block:  u'A = sum over shots of (u's)(shot) f(shot). So many rows of u' at a time as fill whole
// vectors, and what follows the same functions one after the other: sums and functions stay in the cache. To pick the
// fitted shots out of the functions costs more than a few rows times all shots.
Eigen::MatrixXd EvidenceColumns::AlongFamilies(const std::vector<Eigen::MatrixXd>& along) const {
  struct Followers {
    Eigen::MatrixXd fitted;                        // functions of the fitted shots, of many rows
    std::vector<std::pair<size_t, long>> sources;  // and columns of products
  };
  const bool are_few = along[0].rows() <= kRowsTogether;
  std::map<const Eigen::MatrixXd*, Followers> followers;
  long columns = 0;
  for (size_t f = 0; f < families_.size(); ++f) {
    const Eigen::MatrixXd& functions = *families_[f].functions;
    Followers& own = followers[&functions];
    if (own.sources.empty() && !are_few) own.fitted = functions(fitted_shots_, Eigen::all);
    own.sources.emplace_back(source_of_family_[f], columns);
    columns += functions.cols();
  }
  std::vector<int> all_shots(extended_.data().shots.size());
  std::iota(all_shots.begin(), all_shots.end(), 0);
  const auto shots = static_cast<long>(are_few ? all_shots.size() : fitted_shots_.size());
  Eigen::MatrixXd products(along[0].rows(), columns);
  std::vector<Eigen::MatrixXd> of_shots(sources_.size());
  for (long row = 0; row < products.rows(); row += kRowsTogether) {
    const long own = std::min(kRowsTogether, products.rows() - row);
    const long wide = (own + kBatchLanes - 1) / kBatchLanes * kBatchLanes;
    for (Eigen::MatrixXd& of_source : of_shots) of_source.resize(wide, shots);
    SumOfShots(along, row, are_few ? all_shots : place_of_shot_, &of_shots);
    for (const auto& [functions, all] : followers) {
      for (const auto& [source, first] : all.sources) {
        products.block(row, first, own, functions->cols()) =
            TallProduct(of_shots[source], are_few ? *functions : all.fitted).topRows(own);
      }
    }
  }
  return products;
}

Eigen::MatrixXd EvidenceColumns::ProductsOf(const std::vector<int>& columns,
                                            const std::vector<BlockRoots>& roots) const {
  const long believed = num_believed(), size = static_cast<long>(columns.size());
  const long of_linearization = static_cast<long>(catalogue_.size());
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(size, num_columns_);
  std::vector<Eigen::MatrixXd> along;  // A_k'C^-1 of each block
  Eigen::MatrixXd u;
  for (size_t b = 0; b < stored_.size(); ++b) {
    const Block& block = stored_[b];
    u.resize(block.here.num_rows(), size);
    FillColumns(block, columns, u);
    Whiten(roots[b], &u);
    WhitenAgain(roots[b], &u);
    along.push_back(u.transpose());
    products.leftCols(of_linearization) +=
        TallProduct(along.back(), block.here.jacobian.middleCols(believed, of_linearization));
  }
  for (long c = 0; c < of_linearization; ++c) products.col(c) *= units_[c];
  products.rightCols(num_columns_ - of_linearization) = AlongFamilies(along);
  return products;
}

}  // namespace sagitta

#include "estimator/least_squares/row_stream.h"

#include <unordered_map>
#include <utility>

namespace sagitta {
namespace {

constexpr size_t kObservationsAtOnce = 1024;

// One lane's unit of a batch into rows of the piece.
void Unpack(const BatchColumns& columns, const std::vector<int>& unit, const double* lane, RowPiece* piece) {
  const Eigen::Index residual = piece->rows.cols() - 1;
  for (int row = 0; row < 3 * static_cast<int>(unit.size()); ++row) {
    const Eigen::Index to = 3 * unit[row / 3] + row % 3;
    const double* const from = lane + static_cast<size_t>(row) * columns.columns * kBatchLanes;
    double* const cells = &piece->rows(to, 0);
    for (int c = 0; c < columns.columns; ++c) {
      const int column = columns.Of(row, c);
      if (column >= 0) cells[column] = from[c * kBatchLanes];
    }
    cells[residual] = from[columns.residual * kBatchLanes];
    for (int i = 0; i < columns.latents; ++i) piece->latent(to, i) = from[(columns.latent + i) * kBatchLanes];
  }
}

// The group of each observation where none is asked for.
std::vector<int> OwnGroups(const CalibrationProblem& problem, const std::vector<int>& observations,
                           LatentTreatment treatment) {
  const bool by_visit = treatment == LatentTreatment::kMarginalise && !problem.latent.empty();
  std::vector<int> groups;
  groups.reserve(observations.size());
  for (const int i : observations) {
    const int shot = problem.data.observations[i].shot;
    groups.push_back(by_visit ? problem.latent.visit_of_shot[shot] : shot);
  }
  return groups;
}

}  // namespace

RowStream::RowStream(const CalibrationProblem& problem, std::vector<int> observations, Noise noise,
                     LatentTreatment treatment, const std::vector<int>& together)
    : problem_(problem), observations_(std::move(observations)), noise_(std::move(noise)), treatment_(treatment) {
  const std::vector<int> own = together.empty() ? OwnGroups(problem, observations_, treatment) : std::vector<int>();
  const std::vector<int>& groups = together.empty() ? own : together;
  std::unordered_map<int, size_t> place;
  std::vector<size_t> first;  // of each group, counted first
  for (const int group : groups) {
    const auto [found, is_new] = place.emplace(group, first.size());
    if (is_new) first.push_back(0);
    ++first[found->second];
  }
  pieces_.push_back(0);
  size_t count = 0;
  for (size_t& size : first) {
    if (count > pieces_.back() && count + size - pieces_.back() > kObservationsAtOnce) pieces_.push_back(count);
    count += std::exchange(size, count);
  }
  if (count > 0) pieces_.push_back(count);
  order_.resize(groups.size());
  for (size_t k = 0; k < groups.size(); ++k) order_[first[place[groups[k]]]++] = static_cast<int>(k);
}

bool RowStream::ForEach(const ParameterSet& parameters, const std::vector<int>& columns,
                        const std::function<void(const RowPiece& piece)>& visit) const {
  BatchScratch scratch;
  BatchBuffer buffer;
  RowPiece piece;
  std::vector<int> own;
  for (size_t i = 0; i + 1 < pieces_.size(); ++i) {
    piece.positions.assign(order_.begin() + static_cast<long>(pieces_[i]),
                           order_.begin() + static_cast<long>(pieces_[i + 1]));
    own.clear();
    for (const int k : piece.positions) own.push_back(observations_[k]);
    const RowBatches batches(problem_, own, noise_(own), treatment_);
    const RowBatches::Request request(batches, parameters, columns);
    piece.rows.setZero(static_cast<Eigen::Index>(3 * own.size()), static_cast<Eigen::Index>(columns.size()) + 1);
    piece.latent.setZero(piece.rows.rows(), batches.num_latents());
    for (int g = 0; g < batches.num_groups(); ++g) {
      const BatchColumns& layout = request.columns(g);
      for (int b = 0; b < batches.num_batches(g); ++b) {
        double* const rows =
            buffer.Reserve(static_cast<size_t>(batches.rows_of_unit(g)) * layout.columns * kBatchLanes);
        if (!batches.Evaluate(request, g, b, &scratch, rows)) return false;
        for (int lane = 0; lane < kBatchLanes; ++lane) Unpack(layout, batches.UnitOf(g, b, lane), rows + lane, &piece);
      }
    }
    if (change_) change_(&piece.rows);
    visit(piece);
  }
  return true;
}

}  // namespace sagitta

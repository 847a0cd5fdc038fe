#include "estimator/least_squares/row_stream.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <numeric>
#include <utility>

#include "estimator/least_squares/parallel.h"
#include "estimator/least_squares/sandwich.h"

namespace sagitta {
namespace {

constexpr size_t kObservationsAtOnce = 1024;

// Where the numbers of a batch go in rows of the piece: one group's, column by column.
class Unpacker {
 public:
  Unpacker(const BatchColumns& columns, int rows_of_unit, RowPiece* piece)
      : columns_(columns), rows_(rows_of_unit), piece_(*piece) {
    for (int m = 0; m < rows_ / 3; ++m) {
      std::vector<Place>& own = places_.emplace_back();
      for (int c = 0; c < columns.columns; ++c) {
        if (columns.Of(3 * m, c) >= 0) own.push_back({c * kBatchLanes, columns.Of(3 * m, c)});
      }
      own.push_back({columns.residual * kBatchLanes, static_cast<int>(piece->rows.cols()) - 1});
    }
    unused_.resize(static_cast<size_t>(piece->rows.cols()));
  }

  // units: of each lane, places in the piece; empty: filled up.
  void Unpack(const std::array<RowBatches::Unit, kBatchLanes>& units, const double* rows) {
    std::array<double*, kBatchLanes> to;
    for (int row = 0; row < rows_; ++row, rows += static_cast<size_t>(columns_.columns) * kBatchLanes) {
      for (size_t lane = 0; lane < units.size(); ++lane) {
        if (units[lane].empty()) {
          to[lane] = unused_.data();
          continue;
        }
        const Eigen::Index place = 3 * units[lane][row / 3] + row % 3;
        to[lane] = &piece_.rows(place, 0);
        for (int i = 0; i < columns_.latents; ++i) {
          piece_.latent(place, i) = rows[static_cast<size_t>(columns_.latent + i) * kBatchLanes + lane];
        }
      }
      for (const Place& place : places_[static_cast<size_t>(row / 3)]) {
        for (size_t lane = 0; lane < to.size(); ++lane) to[lane][place.column] = rows[place.from + lane];
      }
    }
  }

 private:
  struct Place {
    int from = 0, column = 0;
  };
  const BatchColumns& columns_;
  const int rows_;
  RowPiece& piece_;
  std::vector<std::vector<Place>> places_;  // of each marker
  std::vector<double> unused_;
};

struct PieceMemory {
  BatchScratch scratch;
  BatchBuffer buffer;
};

// Rows of batches at one point, written into pieces.
class PieceWriter {
 public:
  PieceWriter(const RowBatches& batches, const ParameterSet& parameters, const std::vector<int>& columns)
      : batches_(batches), request_(batches, parameters, columns), numbers_(columns.size() + 1) {}

  // Zero rows for the piece's positions.
  void Clear(RowPiece* piece) const {
    piece->rows.setZero(static_cast<Eigen::Index>(3 * piece->positions.size()), static_cast<Eigen::Index>(numbers_));
    piece->latent.setZero(piece->rows.rows(), batches_.num_latents());
  }
  // Those of some batches of a group; unit_of(batch, lane): places in the piece. False: an equilibrium diverges.
  template <typename UnitOf>
  bool Write(int group, int first, int last, const UnitOf& unit_of, PieceMemory* memory, RowPiece* piece) const {
    const BatchColumns& layout = request_.columns(group);
    const int rows_of_unit = batches_.rows_of_unit(group);
    Unpacker unpacker(layout, rows_of_unit, piece);
    // Zeros where no number of these batches goes: each writes the same places.
    double* const rows = memory->buffer.Reserve(static_cast<size_t>(rows_of_unit) * layout.columns * kBatchLanes);
    for (int b = first; b < last; ++b) {
      if (!batches_.Evaluate(request_, group, b, &memory->scratch, rows)) return false;
      std::array<RowBatches::Unit, kBatchLanes> units;
      for (int lane = 0; lane < kBatchLanes; ++lane) units[lane] = unit_of(b, lane);
      unpacker.Unpack(units, rows);
    }
    return true;
  }

 private:
  const RowBatches& batches_;
  const RowBatches::Request request_;
  const size_t numbers_;
};

// A piece and what it is made in; of one thread at a time.
struct PieceSlot {
  RowPiece piece;
  int group = -1;           // of batches that the piece's numbers are from, or -1
  std::vector<int> places;  // one unit behind the other
  PieceMemory memory;
};

// Pieces of batches that are at hand.
class PiecesOfBatches {
 public:
  PiecesOfBatches(const RowBatches& batches, const ParameterSet& parameters, const std::vector<int>& columns)
      : batches_(batches), writer_(batches, parameters, columns) {
    for (int g = 0; g < batches.num_groups(); ++g) {
      const int at_once = std::max(1, static_cast<int>(kObservationsAtOnce / (kBatchLanes * PerUnit(g))));
      for (int first = 0; first < batches.num_batches(g); first += at_once) {
        runs_.push_back({g, first, std::min(first + at_once, batches.num_batches(g))});
      }
    }
  }
  int count() const { return static_cast<int>(runs_.size()); }

  bool Make(int i, PieceSlot* slot) const {
    const auto& [group, first, last] = runs_[static_cast<size_t>(i)];
    RowPiece& piece = slot->piece;
    piece.positions.clear();
    for (int k = 0; k < (last - first) * kBatchLanes; ++k) {
      const RowBatches::Unit unit = batches_.UnitOf(group, first + k / kBatchLanes, k % kBatchLanes);
      piece.positions.insert(piece.positions.end(), unit.begin(), unit.end());
    }
    std::vector<int>& places = slot->places;
    places.resize(piece.positions.size());
    std::iota(places.begin(), places.end(), 0);
    const auto unit_of = [&, begin = first, per_unit = PerUnit(group)](int batch, int lane) -> RowBatches::Unit {
      const size_t own = (static_cast<size_t>(batch - begin) * kBatchLanes + static_cast<size_t>(lane)) * per_unit;
      return own < places.size() ? RowBatches::Unit(places.data() + own, per_unit) : RowBatches::Unit();
    };
    // Pieces of one size and group have their numbers at the same places.
    const bool is_like_before =
        slot->group == group && piece.rows.rows() == static_cast<Eigen::Index>(3 * places.size());
    if (!is_like_before) writer_.Clear(&piece);
    slot->group = group;
    return writer_.Write(group, first, last, unit_of, &slot->memory, &piece);
  }

 private:
  struct Run {
    int group = 0, first = 0, last = 0;  // batches
  };
  size_t PerUnit(int group) const { return static_cast<size_t>(batches_.rows_of_unit(group) / 3); }

  const RowBatches& batches_;
  const PieceWriter writer_;
  std::vector<Run> runs_;
};

template <typename Pieces>
bool VisitEach(const Pieces& pieces, int num_threads, const PieceVisit& visit) {
  std::vector<PieceSlot> slots(static_cast<size_t>(std::max(1, std::min(num_threads, pieces.count()))));
  std::atomic<bool> valid{true};
  ParallelFor(pieces.count(), num_threads, [&](int i, int worker) {
    PieceSlot& slot = slots[static_cast<size_t>(worker)];
    if (pieces.Make(i, &slot)) {
      visit(slot.piece);
    } else {
      valid = false;
    }
  });
  return valid;
}

template <typename Pieces>
bool VisitShared(const Pieces& pieces, int num_threads, const SharedVisit& visit) {
  constexpr int kPiecesOfThread = 4;
  std::vector<PieceSlot> slots(static_cast<size_t>(num_threads == 1 ? 1 : kPiecesOfThread * num_threads));
  std::vector<char> are_made(slots.size());
  std::atomic<bool> valid{true};
  MakeAndUse(
      pieces.count(), num_threads, static_cast<int>(slots.size()),
      [&](int i, int slot) {
        are_made[slot] = pieces.Make(i, &slots[slot]) ? 1 : 0;
        if (are_made[slot] == 0) valid = false;
      },
      [&](int slot, int share) {
        if (are_made[slot] != 0) visit(slots[slot].piece, {share, num_threads});
      });
  return valid;
}

// Steps of a register's units, next to the columns of their rows: those that all rows share, and of each marker its
// own.
class StepLanes {
 public:
  StepLanes(const BatchColumns& columns, int rows_of_unit)
      : columns_(columns.columns), first_(columns.own.empty() ? 0 : columns.first), markers_(rows_of_unit / 3) {
    for (int c = first_; c < columns_; ++c) AddPlace(columns.of[c], c - first_);
    for (int m = 0; m < markers_; ++m) {
      for (int c = 0; c < first_; ++c) AddPlace(columns.Of(3 * m, c), columns_ - first_ + m * first_ + c);
    }
    steps_.assign(static_cast<size_t>(columns_ - first_ + markers_ * first_) * kBatchLanes, 0.0);
  }

  // steps: of each lane.
  void Set(const std::array<const double*, kBatchLanes>& steps) {
    for (const Place& place : places_) {
      for (size_t lane = 0; lane < kBatchLanes; ++lane) steps_[place.to + lane] = steps[lane][place.from];
    }
  }
  void Visit(const std::array<RowBatches::Unit, kBatchLanes>& units, const double* rows,
             const std::function<void(int position, const Vector3<double>& moved)>& visit) const {
    const size_t stride = static_cast<size_t>(columns_) * kBatchLanes;
    for (int m = 0; m < markers_; ++m, rows += 3 * stride) {
      Lanes moved[3] = {};
      AddMoved(rows + static_cast<size_t>(first_) * kBatchLanes, columns_ - first_, steps_.data(), moved);
      const size_t own = static_cast<size_t>(columns_ - first_ + m * first_) * kBatchLanes;
      AddMoved(rows, first_, steps_.data() + own, moved);
      for (size_t lane = 0; lane < units.size(); ++lane) {
        if (!units[lane].empty()) visit(units[lane][m], {moved[0][lane], moved[1][lane], moved[2][lane]});
      }
    }
  }

 private:
  using Lanes = std::array<double, kBatchLanes>;
  struct Place {
    size_t to;
    int from;
  };

  void AddPlace(int from, int column) {
    if (from >= 0) places_.push_back({static_cast<size_t>(column) * kBatchLanes, from});
  }

  // What some columns add to J d of the three rows of a marker, of each lane.
  void AddMoved(const double* numbers, int count, const double* step, Lanes (&moved)[3]) const {
    const size_t stride = static_cast<size_t>(columns_) * kBatchLanes;
    Lanes sums[3] = {moved[0], moved[1], moved[2]};
    for (int c = 0; c < count; ++c, numbers += kBatchLanes, step += kBatchLanes) {
      for (size_t axis = 0; axis < 3; ++axis) {
        for (size_t lane = 0; lane < kBatchLanes; ++lane) {
          sums[axis][lane] += numbers[axis * stride + lane] * step[lane];
        }
      }
    }
    std::copy_n(sums, 3, moved);
  }

  const int columns_, first_, markers_;
  std::vector<Place> places_;
  std::vector<double> steps_;
};

// The group of each observation where none is asked for.
std::vector<int> OwnGroups(const CalibrationProblem& problem, const std::vector<int>& observations,
                           LatentTreatment treatment) {
  const bool by_visit = treatment == LatentTreatment::kMarginalise && !problem.latent.empty();
  std::vector<int> groups;
  groups.reserve(observations.size());
  for (const int i : observations) {
    const int shot = problem.data().observations[i].shot;
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
  constexpr size_t kNone = static_cast<size_t>(-1);
  std::vector<size_t> place(groups.empty() ? 0 : 1 + *std::max_element(groups.begin(), groups.end()), kNone);
  std::vector<size_t> first;  // of each group, counted first
  for (const int group : groups) {
    if (place[group] == kNone) {
      place[group] = first.size();
      first.push_back(0);
    }
    ++first[place[group]];
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

std::unique_ptr<RowBatches> RowStream::BatchesOf(size_t piece) const {
  std::vector<int> own;
  for (size_t i = pieces_[piece]; i < pieces_[piece + 1]; ++i) own.push_back(observations_[order_[i]]);
  return std::make_unique<RowBatches>(problem_, own, noise_(own), treatment_);
}

struct RowStream::Maker {
  int count() const { return static_cast<int>(stream.pieces_.size()) - 1; }

  bool Make(int i, PieceSlot* slot) const {
    const auto own = static_cast<size_t>(i);
    slot->piece.positions.assign(stream.order_.begin() + static_cast<long>(stream.pieces_[own]),
                                 stream.order_.begin() + static_cast<long>(stream.pieces_[own + 1]));
    const std::unique_ptr<RowBatches> batches = stream.BatchesOf(own);
    const PieceWriter writer(*batches, parameters, columns);
    writer.Clear(&slot->piece);
    for (int g = 0; g < batches->num_groups(); ++g) {
      const auto unit_of = [&](int batch, int lane) { return batches->UnitOf(g, batch, lane); };
      if (!writer.Write(g, 0, batches->num_batches(g), unit_of, &slot->memory, &slot->piece)) return false;
    }
    return true;
  }

  const RowStream& stream;
  const ParameterSet& parameters;
  const std::vector<int>& columns;
};

bool RowStream::ForEach(const ParameterSet& parameters, const std::vector<int>& columns, const PieceVisit& visit,
                        int num_threads) const {
  return VisitEach(Maker{*this, parameters, columns}, num_threads, visit);
}

bool RowStream::ForEachShared(const ParameterSet& parameters, const std::vector<int>& columns, int num_threads,
                              const SharedVisit& visit) const {
  return VisitShared(Maker{*this, parameters, columns}, num_threads, visit);
}

bool ForEachPiece(const RowBatches& batches, const ParameterSet& parameters, const std::vector<int>& columns,
                  int num_threads, const PieceVisit& visit) {
  return VisitEach(PiecesOfBatches(batches, parameters, columns), num_threads, visit);
}

FittedStream::FittedStream(const CalibrationProblem& problem, RowStream::Noise noise,
                           std::shared_ptr<const RowBatches> at_hand, int num_threads)
    : problem_(problem),
      noise_(std::move(noise)),
      clusters_(ConfigurationClusters(problem.data(), problem.CalibrationObservations())),
      batches_(std::move(at_hand)),
      num_threads_(num_threads) {
  if (batches_ != nullptr) return;
  const std::vector<int> fitted = problem.CalibrationObservations();
  batches_ = std::make_shared<RowBatches>(problem, fitted, noise_(fitted), LatentTreatment::kMarginalise);
}

FittedStream::FittedStream(const CalibrationProblem& problem, std::shared_ptr<const RowBatches> at_hand,
                           int num_threads)
    : FittedStream(
          problem, [&problem](const std::vector<int>& listed) { return FitRoots(problem, listed, kFallbackSigma); },
          std::move(at_hand), num_threads) {}

bool FittedStream::ForEach(const ParameterSet& parameters, const std::vector<int>& columns,
                           const PieceVisit& visit) const {
  return ForEachPiece(*batches_, parameters, columns, num_threads_, visit);
}

bool FittedStream::ForEachShared(const ParameterSet& parameters, const std::vector<int>& columns,
                                 const SharedVisit& visit) const {
  return VisitShared(PiecesOfBatches(*batches_, parameters, columns), num_threads_, visit);
}

bool FittedStream::ForEachMoved(const ParameterSet& parameters, const std::vector<int>& columns,
                                const std::function<const Eigen::VectorXd&(int position)>& step_of,
                                const std::function<void(int position, const Vector3<double>& moved)>& visit) const {
  constexpr int kBatchesAtOnce = 64;
  const RowBatches::Request request(*batches_, parameters, columns);
  std::vector<PieceMemory> memories(static_cast<size_t>(num_threads_));
  std::atomic<bool> valid{true};
  for (int g = 0; g < batches_->num_groups(); ++g) {
    const BatchColumns& layout = request.columns(g);
    const int rows_of_unit = batches_->rows_of_unit(g), batches = batches_->num_batches(g);
    const size_t stride = static_cast<size_t>(layout.columns) * kBatchLanes;
    ParallelFor((batches + kBatchesAtOnce - 1) / kBatchesAtOnce, num_threads_, [&](int block, int worker) {
      PieceMemory& memory = memories[static_cast<size_t>(worker)];
      StepLanes steps(layout, rows_of_unit);
      double* const rows = memory.buffer.Reserve(static_cast<size_t>(rows_of_unit) * stride);
      for (int b = kBatchesAtOnce * block; b < std::min(batches, kBatchesAtOnce * (block + 1)); ++b) {
        if (!batches_->Evaluate(request, g, b, &memory.scratch, rows)) {
          valid = false;
          return;
        }
        std::array<RowBatches::Unit, kBatchLanes> units;
        std::array<const double*, kBatchLanes> own;
        for (int lane = 0; lane < kBatchLanes; ++lane) {
          units[lane] = batches_->UnitOf(g, b, lane);
          own[lane] = step_of(units[units[lane].empty() ? 0 : lane][0]).data();  // the first lane is always filled
        }
        steps.Set(own);
        steps.Visit(units, rows, visit);
      }
    });
  }
  return valid;
}

bool FittedStream::ForEachOfClusters(const ParameterSet& parameters, const std::vector<int>& columns,
                                     const SharedVisit& visit) const {
  const int clusters = clusters_.empty() ? 0 : 1 + *std::max_element(clusters_.begin(), clusters_.end());
  if (batches_->num_units() == clusters) return ForEachShared(parameters, columns, visit);  // each is one unit
  return RowStream(problem_, observations(), noise_, LatentTreatment::kMarginalise, clusters_)
      .ForEachShared(parameters, columns, num_threads_, visit);
}

Eigen::Matrix3Xd FittedStream::Predict(const CalibrationProblem& problem, const ParameterSet& parameters,
                                       const std::vector<int>& listed) const {
  const std::vector<int>& fitted = observations();
  if (!problem.latent.empty() || !std::includes(fitted.begin(), fitted.end(), listed.begin(), listed.end())) {
    return PredictPoints(problem, parameters, listed);
  }
  const bool are_all = listed.size() == fitted.size();  // then they are the same
  Eigen::Matrix3Xd points = Eigen::Matrix3Xd::Constant(3, static_cast<Eigen::Index>(listed.size()), std::nan(""));
  ForEach(parameters, {}, [&](const RowPiece& piece) {
    std::vector<int> own;
    for (const int position : piece.positions) own.push_back(fitted[position]);
    const NoiseRoots roots = FitRoots(problem, own, kFallbackSigma);
    for (int i = 0; i < piece.num_observations(); ++i) {
      const int k = own[i];
      const auto place =
          are_all ? piece.positions[i] : std::lower_bound(listed.begin(), listed.end(), k) - listed.begin();
      const Observation& observation = problem.data().observations[k];
      if (place == points.cols() || listed[place] != k || !observation.is_point()) continue;
      points.col(place) = piece.PredictedPoint(i, observation, roots[i]);
    }
  });
  return points.allFinite() ? points : PredictPoints(problem, parameters, listed);
}

}  // namespace sagitta

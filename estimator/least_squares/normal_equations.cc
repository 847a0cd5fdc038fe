#include "estimator/least_squares/normal_equations.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <optional>
#include <utility>

#include "estimator/least_squares/batch_algebra.h"
#include "estimator/least_squares/parallel.h"

namespace sagitta {
namespace {

constexpr int kBatchesOfBlock = 64;  // 512 units: large against what a piece of work costs by itself
constexpr int kRowsAtOnce = 48;      // of lanes that are summed together: they stay in the cache

// The sums of one group's rows, lane by lane, and where they go.
class GroupSums {
 public:
  explicit GroupSums(const BatchColumns& columns)
      : columns_(columns), shared_((columns.last - columns.first) / kGramBlock) {
    dense_ = GramSums(shared_, shared_, true);
    for (size_t m = 0; m < columns.own.size(); ++m) own_.emplace_back(1, 1 + shared_, false);
  }

  void Add(const std::vector<const double*>& rows, int rows_of_unit) {
    dense_.Add(rows, columns_.first, columns_.first);
    std::vector<const double*> seen;
    for (size_t m = 0; m < own_.size(); ++m) {
      seen.clear();
      for (size_t r = 0; r < rows.size(); ++r) {
        if (r % rows_of_unit / 3 == m) seen.push_back(rows[r]);
      }
      own_[m].Add(seen, 0, 0);
    }
  }

  // Adds the totals of all lanes to the upper triangle.
  void AddTo(Eigen::MatrixXd* matrix) const {
    const int residual = static_cast<int>(matrix->cols()) - 1, shared = shared_ * kGramBlock;
    std::vector<int> target(columns_.of.begin() + columns_.first, columns_.of.begin() + columns_.last);
    target[columns_.residual - columns_.first] = residual;
    const auto add = [matrix](int a, int b, double value) {
      if (a >= 0 && b >= 0) (*matrix)(std::min(a, b), std::max(a, b)) += value;
    };
    const std::vector<double> dense = dense_.Totals();
    for (int a = 0; a < shared; ++a) {
      for (int b = a; b < shared; ++b) add(target[a], target[b], dense[a * shared + b]);
    }
    for (size_t m = 0; m < own_.size(); ++m) {
      const std::vector<int>& own = columns_.own[m];
      const std::vector<double> totals = own_[m].Totals();
      for (int a = 0; a < 3; ++a) {
        const double* const row = totals.data() + a * own_[m].columns_b();
        for (int b = a; b < 3; ++b) add(own[a], own[b], row[b]);
        for (int b = 0; b < shared; ++b) add(own[a], target[b], row[kGramBlock + b]);
      }
    }
  }

 private:
  const BatchColumns& columns_;
  int shared_;
  GramSums dense_;
  std::vector<GramSums> own_;
};

void WeighLane(RowBatches::Unit unit, const std::vector<double>& weights, int columns, double* lane) {
  for (size_t row = 0; row < 3 * unit.size(); ++row) {
    const double root = std::sqrt(weights[unit[row / 3]]);
    for (int c = 0; c < columns; ++c) lane[(row * columns + c) * kBatchLanes] *= root;
  }
}

std::vector<double> AllValues(const ParameterSet& parameters) {
  std::vector<double> values;
  for (const ParameterBlock& block : parameters.blocks()) {
    values.insert(values.end(), block.values.begin(), block.values.end());
  }
  return values;
}

}  // namespace

// Of two points: a solver ends with a trial step that it does not go.
struct NormalEquations::Latest {
  struct Point {
    std::vector<double> values;
    NormalSums sums;

    bool Holds(const std::vector<double>& asked, const std::vector<int>& columns) const {
      return sums.valid && values == asked && sums.columns == columns;
    }
    // Where it has these columns and others: what it says of them.
    std::optional<NormalSums> Among(const std::vector<double>& asked, const std::vector<int>& columns) const {
      if (!sums.valid || values != asked) return std::nullopt;
      std::vector<int> places;
      for (const int c : columns) {
        const auto place = std::find(sums.columns.begin(), sums.columns.end(), c);
        if (place == sums.columns.end()) return std::nullopt;
        places.push_back(static_cast<int>(place - sums.columns.begin()));
      }
      return SelectColumns(sums, places);
    }
  };
  std::atomic<int> passes{0};
  std::mutex mutex;  // of those who ask at the same time
  Point latest, before;
};

NormalEquations::~NormalEquations() = default;

int NormalEquations::num_passes() const { return latest_->passes; }

NormalEquations::NormalEquations(const CalibrationProblem& problem, const std::vector<int>& observations,
                                 const NoiseRoots& noise, LatentTreatment treatment, int num_threads)
    : batches_(std::make_shared<RowBatches>(problem, observations, noise, treatment)),
      num_threads_(num_threads),
      latest_(std::make_unique<Latest>()) {
  for (int g = 0; g < batches_->num_groups(); ++g) {
    for (int first = 0; first < batches_->num_batches(g); first += kBatchesOfBlock) {
      blocks_.push_back({g, first, std::min(batches_->num_batches(g), first + kBatchesOfBlock)});
    }
  }
}

NormalSums NormalEquations::SumOfAll(const ParameterSet& parameters, const std::vector<int>& columns,
                                     const std::vector<double>& weights) const {
  const RowBatches::Request request(*batches_, parameters, columns);
  ++latest_->passes;
  const int n = static_cast<int>(columns.size());
  std::vector<Eigen::MatrixXd> parts(blocks_.size());
  std::vector<BatchScratch> scratches(std::max(1, num_threads_));
  std::vector<BatchBuffer> buffers(std::max(1, num_threads_));
  std::atomic<bool> valid{true};
  ParallelFor(static_cast<int>(blocks_.size()), num_threads_, [&](int i, int worker) {
    if (!valid) return;
    const Block& block = blocks_[i];
    const BatchColumns& own = request.columns(block.group);
    const int rows = batches_->rows_of_unit(block.group);
    const int at_once = std::max(1, kRowsAtOnce / rows);
    const size_t doubles = static_cast<size_t>(rows) * own.columns * kBatchLanes;
    double* const memory = buffers[worker].Reserve(at_once * doubles);
    GroupSums sums(own);
    std::vector<const double*> pointers;
    for (int first = block.first; first < block.last; first += at_once) {
      const int last = std::min(block.last, first + at_once);
      pointers.clear();
      for (int b = first; b < last; ++b) {
        double* const at = memory + (b - first) * doubles;
        if (!batches_->Evaluate(request, block.group, b, &scratches[worker], at)) {
          valid = false;
          return;
        }
        for (int lane = 0; lane < kBatchLanes && !weights.empty(); ++lane) {
          WeighLane(batches_->UnitOf(block.group, b, lane), weights, own.columns, at + lane);
        }
        for (int r = 0; r < rows; ++r) pointers.push_back(at + static_cast<size_t>(r) * own.columns * kBatchLanes);
      }
      sums.Add(pointers, rows);
    }
    parts[i].setZero(n + 1, n + 1);
    sums.AddTo(&parts[i]);
  });
  NormalSums result;
  result.columns = columns;
  result.valid = valid;
  result.matrix.setZero(n + 1, n + 1);
  result.rows = 3 * batches_->num_observations();
  if (!result.valid) return result;
  for (const Eigen::MatrixXd& part : parts) result.matrix += part;
  result.matrix.triangularView<Eigen::StrictlyLower>() = result.matrix.transpose();
  return result;
}

NormalSums NormalEquations::Sum(const ParameterSet& parameters, const std::vector<int>& columns,
                                const std::vector<double>& weights, bool with_priors) const {
  NormalSums result;
  if (weights.empty()) {
    const std::lock_guard<std::mutex> lock(latest_->mutex);
    const std::vector<double> values = AllValues(parameters);
    if (!latest_->latest.Holds(values, columns)) std::swap(latest_->latest, latest_->before);
    if (!latest_->latest.Holds(values, columns)) {
      std::optional<NormalSums> known = latest_->before.Among(values, columns);
      if (!known) known = latest_->latest.Among(values, columns);
      latest_->latest = {values, known ? std::move(*known) : SumOfAll(parameters, columns, weights)};
    }
    result = latest_->latest.sums;
  } else {
    result = SumOfAll(parameters, columns, weights);
  }
  if (!result.valid || !with_priors) return result;
  const Linearization priors = PriorsOf(parameters, columns);
  Eigen::MatrixXd both(priors.num_rows(), result.matrix.cols());
  both << priors.jacobian, priors.residual;
  result.matrix += both.transpose() * both;
  result.rows += priors.num_rows();
  return result;
}

void NormalEquations::KeepMoved(const ParameterSet& from, const std::vector<int>& columns, const Eigen::VectorXd& step,
                                const ParameterSet& to) const {
  const std::lock_guard<std::mutex> lock(latest_->mutex);
  if (!latest_->latest.Holds(AllValues(from), columns)) return;
  Latest::Point moved{AllValues(to), latest_->latest.sums};
  Eigen::MatrixXd& matrix = moved.sums.matrix;
  const Eigen::Index n = step.size();
  // J'(r + J d) = J'r + J'J d,  |r + J d|^2 = r'r + d'J'r + d'J'(r + J d)
  const Eigen::VectorXd gradient = matrix.col(n).head(n);
  matrix.col(n).head(n) += matrix.topLeftCorner(n, n) * step;
  matrix.row(n) = matrix.col(n).transpose();
  matrix(n, n) += step.dot(gradient + matrix.col(n).head(n));
  latest_->before = std::exchange(latest_->latest, std::move(moved));
}

FittedRows RowsOf(const NormalEquations& equations, const ParameterSet& parameters, const std::vector<int>& columns) {
  FittedRows result;
  if (AreMany(3.0 * equations.batches().num_observations(), static_cast<double>(columns.size()))) {
    const NormalSums sums = equations.Sum(parameters, columns);
    result.rows = Condense(sums);
    result.equations = sums.rows;
    return result;
  }
  result.rows = Linearize(equations.batches(), parameters, columns);
  if (result.rows.valid) AppendPriors(parameters, &result.rows);
  result.equations = result.rows.num_rows();
  return result;
}

FittedRows FittedOnce(const CalibrationProblem& problem, const ParameterSet& parameters,
                      const std::vector<int>& observations, const std::vector<int>& columns,
                      const RowStream::Noise& noise) {
  FittedRows result;
  if (AreHeld(3.0 * static_cast<double>(observations.size()), static_cast<double>(columns.size()))) {
    result.rows = Linearize(problem, parameters, observations, columns, noise(observations));
    if (result.rows.valid) AppendPriors(parameters, &result.rows);
    result.equations = result.rows.num_rows();
    return result;
  }
  NormalSums sums =
      SumRows(RowStream(problem, observations, noise, LatentTreatment::kMarginalise), parameters, columns);
  const NormalSums priors = SumRows(PriorsOf(parameters, columns));
  sums.matrix += priors.matrix;
  result.rows = Condense(sums);
  result.equations = sums.rows + priors.rows;
  return result;
}

NormalSums SumRows(const RowStream& stream, const ParameterSet& parameters, const std::vector<int>& columns) {
  SumOfRows sums(static_cast<int>(columns.size()) + 1);
  const bool valid = stream.ForEach(parameters, columns, [&](const RowPiece& piece) {
    for (Eigen::Index i = 0; i < piece.rows.rows(); ++i) sums.Add(&piece.rows(i, 0));
  });
  return {valid, columns, sums.Total(), 3 * static_cast<int>(stream.observations().size())};
}

Linearization PriorsOf(const ParameterSet& parameters, const std::vector<int>& columns) {
  Linearization priors;
  priors.columns = columns;
  priors.jacobian.resize(0, static_cast<Eigen::Index>(columns.size()));
  AppendPriors(parameters, &priors);
  return priors;
}

}  // namespace sagitta

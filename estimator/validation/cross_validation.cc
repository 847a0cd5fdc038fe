#include "estimator/validation/cross_validation.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cstdint>
#include <functional>
#include <iterator>
#include <map>
#include <optional>
#include <set>

#include "estimator/calibration/bounds.h"
#include "estimator/calibration/held_rest.h"
#include "estimator/calibration/joint_estimator.h"
#include "estimator/estimate/parameter_table.h"
#include "estimator/intervals/predicted_sums.h"
#include "estimator/least_squares/held_influence.h"
#include "estimator/least_squares/identifiability.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/least_squares/normal_equations.h"
#include "estimator/least_squares/parallel.h"
#include "estimator/noise/repeat_spread.h"
#include "problems/io/files.h"
#include "problems/split.h"

namespace sagitta {
namespace {

// What is summed of the observations of one fold.
struct Fold {
  Fold(int columns, Eigen::MatrixXd summed) : predicted(columns), total(std::move(summed)) {}
  PredictedSums predicted;  // of its points
  Eigen::MatrixXd total;    // [J r]'[J r] of its rows as fitted, without priors
  Eigen::VectorXd step;     // of the fit without it, SI
  Eigen::MatrixXd root;     // R of that fit: R R' = (J'J)^-1
  bool loses = false;       // the fit without it holds more than the whole
};

size_t FoldAt(const CalibrationProblem& problem, const FoldPlan& plan, int observation) {
  return static_cast<size_t>(
      plan.fold_of[problem.data().shots[problem.data().observations[observation].shot].configuration]);
}

// A fit that is divided: its values, what each fold's fit estimates anew, and where it has the points.
struct Division {
  const ParameterSet& parameters;
  std::vector<int> columns;
  const Eigen::Matrix3Xd& predicted;
};

struct DividedFit {
  std::vector<int> columns;
  Eigen::MatrixXd sums;  // [J r]'[J r] of all rows and the priors
  std::vector<Fold> folds;
};

// What the fit without a fold would hold rests where such a fit lets it rest (held_rest.h): the same weak prior about
// the same place. One step along a direction that is hardly measured any more would go anywhere. left: [J r]'[J r].
// False: nothing is lost.
bool AddRest(const CalibrationProblem& problem, const Estimate& estimate, const Division& whole,
             Eigen::MatrixXd* left) {
  constexpr double kLeastWeight = 1e-6;  // of a column's norm: normal equations do not lose it in rounding
  const ParameterSet& aligned = estimate.aligned.num_coordinates() > 0 ? estimate.aligned : problem.parameters;
  const double noise = AppliedNoise(estimate.sigma);
  const std::vector<int>& columns = whole.columns;
  NormalSums sums;
  sums.columns = columns;
  sums.matrix = *left;
  sums.valid = true;
  const auto n = static_cast<Eigen::Index>(columns.size());
  const std::vector<int> lost = FindUnidentifiable(Condense(sums), whole.parameters, noise).columns;
  for (const int c : lost) {
    const int i = columns[static_cast<size_t>(c)];
    const Coordinate& coordinate = whole.parameters.coordinates()[i];
    if (coordinate.has_prior()) continue;
    const double weight = std::max(noise / PhysicalRange(coordinate), kLeastWeight * std::sqrt((*left)(c, c)));
    (*left)(c, c) += weight * weight;
    // Single axes of a rotation have no value of their own: they stay where the whole has them.
    if (IsRotation(whole.parameters.blocks()[coordinate.block].kind)) continue;
    const double off = whole.parameters.Value(i) - ReferenceOf(problem, aligned, i);
    (*left)(c, n) += weight * weight * off;
    (*left)(n, c) = (*left)(c, n);
  }
  return !lost.empty();
}

// A calibration without the listed rows, where the others see every station and marker that is to be predicted.
// Nothing: it has no result.
std::optional<ParameterSet> CalibrateWithout(const CalibrationProblem& problem, const std::vector<int>& left_out,
                                             const std::vector<int>& predicted) {
  CalibrationProblem rest = problem;
  for (const int i : left_out) rest.mutable_data()->ExcludeRow(i);
  std::set<int> stations, markers;
  for (const int i : rest.CalibrationObservations()) {
    stations.insert(rest.data().shots[rest.data().observations[i].shot].station);
    markers.insert(rest.data().observations[i].marker);
  }
  for (const int i : predicted) {
    const Observation& row = problem.data().observations[i];
    if (stations.count(problem.data().shots[row.shot].station) + markers.count(row.marker) < 2) return std::nullopt;
  }
  const Estimate estimate = EstimateJointly(rest);
  if (!IsUsable(estimate.status)) return std::nullopt;
  return estimate.parameters;
}

// The fit without one fold, by one Gauss-Newton step: its step, and R with R R' = (J'J)^-1. What only this fold
// measures is left where the whole has it: the step that is least. left: [J r]'[J r] of the others, SI; scale: of a
// unit of each column.
Eigen::MatrixXd Leave(const Eigen::MatrixXd& left, const Eigen::VectorXd& scale, Fold* fold) {
  const auto n = scale.size();
  const Eigen::MatrixXd normal = scale.asDiagonal() * left.topLeftCorner(n, n) * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(normal);
  const double least = 1e-12 * eigen.eigenvalues().tail(1)[0];
  const Eigen::VectorXd inverse =
      eigen.eigenvalues().unaryExpr([least](double value) { return value > least ? 1.0 / value : 0.0; });
  const Eigen::MatrixXd root = scale.asDiagonal() * eigen.eigenvectors() * inverse.cwiseSqrt().asDiagonal();
  fold->step = -(root * (root.transpose() * left.col(n).head(n)));
  return root;
}

using PointRows = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>;  // m/SI
using RowsOfPoint = Eigen::Ref<const PointRows, 0, Eigen::OuterStride<>>;

// Of what was fitted, its place among the points that are quoted; their number: it is none of them.
size_t PlaceAmong(const std::vector<int>& quoted, const FittedStream& fitted, int position) {
  const int k = fitted.observations()[position];
  const bool are_all = quoted.size() == fitted.observations().size();  // then they are the same
  const auto place =
      static_cast<size_t>(are_all ? position : std::lower_bound(quoted.begin(), quoted.end(), k) - quoted.begin());
  return place < quoted.size() && quoted[place] == k ? place : quoted.size();
}

// Calls visit(place among `quoted`, S, rows) for every fitted point of these: S times its rows are in m; on the thread
// of the share that has it.
void ForEachPoint(
    const ParameterSet& parameters, const std::vector<int>& columns, const FittedStream& fitted,
    const std::vector<int>& quoted, const NoiseRoots& weighed,
    const std::function<bool(size_t place, const Share& share)>& has,
    const std::function<void(size_t place, const Matrix3<double>& root, const RowsOfPoint& rows)>& visit) {
  const auto n = static_cast<Eigen::Index>(columns.size());
  fitted.ForEachShared(parameters, columns, [&](const RowPiece& piece, const Share& share) {
    for (int i = 0; i < piece.num_observations(); ++i) {
      const size_t place = PlaceAmong(quoted, fitted, piece.positions[i]);
      if (place >= quoted.size() || !has(place, share)) continue;
      visit(place, weighed[place], piece.rows.block(3 * i, 0, 3, n));
    }
  });
}

// Where joints deviate: calls visit(places among `quoted`, J, L), m, for every arrival; on the thread of the share that
// has it. A step moves what is predicted, and no deviation.
void ForEachQuotedArrival(const CalibrationProblem& problem, const Division& whole, const FittedStream& fitted,
                          const std::vector<int>& quoted,
                          const std::function<bool(size_t place, const Share& share)>& has, const ArrivalVisit& visit) {
  StreamOfArrivals(problem, quoted)
      .ForEachShared(whole.parameters, whole.columns, fitted.num_threads(),
                     [&](const RowPiece& piece, const Share& share) {
                       const auto is_own = [&](int place) { return has(static_cast<size_t>(place), share); };
                       ForEachArrival(problem, piece, quoted, is_own, visit);
                     });
}

// m, where all of these are the same number on every axis; else 0.
double SigmaOfEveryAxis(const NoiseRoots& roots) {
  constexpr double kSame = 1e-12;  // relative
  const double sigma = roots.front()(0, 0);
  const bool all = std::all_of(roots.begin(), roots.end(), [&](const Matrix3<double>& root) {
    return (root - sigma * Matrix3<double>::Identity()).cwiseAbs().maxCoeff() <= kSame * sigma;
  });
  return all ? sigma : 0.0;
}

// What the points of each fold say of predictions, where that follows from what is summed of its rows: all of them
// points that are weighed by one sigma and err by one. False: it does not.
bool PredictFromTotals(const CalibrationProblem& problem, const NoiseRoots& weighed_by, const NoiseRoots& instrument,
                       const std::vector<int>& quoted, const std::vector<int>& points_of_fold,
                       std::vector<Fold>* folds) {
  const bool are_all = quoted.size() == problem.CalibrationObservations().size();
  if (quoted.empty() || !are_all) return false;
  const double weighed = SigmaOfEveryAxis(weighed_by);
  const double errs = SigmaOfEveryAxis(instrument);
  if (!(weighed > 0.0 && errs > 0.0)) return false;
  for (size_t f = 0; f < folds->size(); ++f) {
    Fold& fold = (*folds)[f];
    const Eigen::Index n = fold.total.rows() - 1;
    fold.predicted.Add(errs, points_of_fold[f], weighed * weighed * fold.total.topLeftCorner(n, n));
  }
  return true;
}

// Base poses and markers: what the alignment of the nominal robot estimates.
std::vector<int> AlignedColumns(const ParameterSet& aligned) {
  std::vector<int> columns;
  for (const int i : aligned.EstimatedCoordinates()) {
    const CoordinateKind kind = aligned.coordinates()[i].kind;
    if (kind == CoordinateKind::kBase || kind == CoordinateKind::kMarker) columns.push_back(i);
  }
  return columns;
}

// Nothing: an equilibrium diverges, or there is nothing to sum.
std::vector<NormalSums> SumFolds(const FittedStream& fitted, const Partition& folds, const Division& whole) {
  if (whole.columns.empty()) return {};
  PartSums sums(fitted.observations().size(), whole.columns);
  sums.Divide(folds);
  const bool valid = fitted.ForEachShared(whole.parameters, whole.columns,
                                          [&](const RowPiece& piece, const Share& share) { sums.Add(piece, share); });
  return valid ? std::move(sums.Totals().parts.front()) : std::vector<NormalSums>();
}

// Of sums that have all of the listed coordinates.
Eigen::MatrixXd SumsOfColumns(const NormalSums& sums, const std::vector<int>& columns) {
  if (sums.columns == columns) return sums.matrix;
  std::vector<int> places;
  for (const int i : columns) {
    places.push_back(static_cast<int>(std::find(sums.columns.begin(), sums.columns.end(), i) - sums.columns.begin()));
  }
  return SelectColumns(sums, places).matrix;
}

// Every fold's sums, and the step of the fit without it. summed: of the folds, with all columns and maybe more; empty
// where an equilibrium diverges, and nothing comes out.
std::optional<DividedFit> Divide(const CalibrationProblem& problem, const Estimate& estimate, const Division& whole,
                                 const std::vector<NormalSums>& summed) {
  DividedFit fit;
  fit.columns = whole.columns;
  if (whole.columns.empty()) return fit;
  if (summed.empty()) return std::nullopt;
  const auto n = static_cast<Eigen::Index>(whole.columns.size());
  Eigen::MatrixXd sums = SumRows(PriorsOf(whole.parameters, whole.columns)).matrix;
  for (const NormalSums& own : summed) {
    sums += fit.folds.emplace_back(static_cast<int>(n), SumsOfColumns(own, whole.columns)).total;
  }
  const Eigen::VectorXd scale = sums.diagonal().head(n).cwiseSqrt().cwiseMax(1e-300).cwiseInverse();
  for (Fold& fold : fit.folds) {
    Eigen::MatrixXd left = sums - fold.total;
    fold.loses = AddRest(problem, estimate, whole, &left);
    fold.root = Leave(left, scale, &fold);
  }
  fit.sums = std::move(sums);
  return fit;
}

// Which stations and markers the rows of the other folds determine, everything else given.
class WithoutFold {
 public:
  WithoutFold(const Estimate& estimate, const DividedFit& fit, const Fold& fold)
      : estimate_(estimate), sums_(fit.sums), fold_(fold), columns_(fit.columns) {}

  bool DeterminesStation(int station) {
    const ParameterSet& all = estimate_.parameters;
    return Remembered(&stations_, station, {&all.station_translation(station), &all.station_rotation(station)});
  }
  bool DeterminesMarker(int marker) { return Remembered(&markers_, marker, {&estimate_.parameters.marker(marker)}); }

 private:
  using Blocks = std::vector<const ParameterBlock*>;

  bool Remembered(std::map<int, bool>* known, int owner, const Blocks& blocks) {
    const auto found = known->find(owner);
    if (found != known->end()) return found->second;
    return (*known)[owner] = AreDetermined(blocks);
  }

  bool AreDetermined(const Blocks& blocks) const {
    // Of a column's square: a difference of sums that is less is round-off. Of the eigenvalues where columns have unit
    // norm: two points at a station leave 0, three that are 1 mm off one line at 10 m 1e-8.
    constexpr double kLeast = 1e-7, kRank = 1e-9;
    std::vector<int> places;
    for (size_t c = 0; c < columns_.size(); ++c) {
      const int block = estimate_.parameters.coordinates()[columns_[c]].block;
      const auto is_it = [&](const ParameterBlock* one) { return one == &estimate_.parameters.blocks()[block]; };
      if (std::any_of(blocks.begin(), blocks.end(), is_it)) places.push_back(static_cast<int>(c));
    }
    if (places.empty()) return true;
    const Eigen::MatrixXd all = sums_(places, places), left = all - fold_.total(places, places);
    if ((left.diagonal().array() <= kLeast * all.diagonal().array()).any()) return false;
    const Eigen::VectorXd scale = left.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scale.asDiagonal() * left * scale.asDiagonal(),
                                                               Eigen::EigenvaluesOnly);
    return eigen.eigenvalues()[0] > kRank;
  }

  const Estimate& estimate_;
  const Eigen::MatrixXd& sums_;
  const Fold& fold_;
  const std::vector<int>& columns_;
  std::map<int, bool> stations_, markers_;
};

// Points of the listed ones whose marker and station the other folds determine; the rest is listed in `unpredictable`.
std::vector<int> Predictable(const CalibrationProblem& problem, const Estimate& estimate, const FoldPlan& plan,
                             const DividedFit& fit, const std::vector<int>& points, Unpredictable* unpredictable) {
  const Measurements& data = problem.data();
  std::vector<WithoutFold> without;
  for (const Fold& fold : fit.folds) without.emplace_back(estimate, fit, fold);
  std::vector<int> predictable;
  std::set<int> stations, markers;
  for (const int i : points) {
    WithoutFold& rest = without[FoldAt(problem, plan, i)];
    const int station = data.shots[data.observations[i].shot].station, marker = data.observations[i].marker;
    const bool has_station = rest.DeterminesStation(station), has_marker = rest.DeterminesMarker(marker);
    if (has_station && has_marker) predictable.push_back(i);
    if (!has_station) stations.insert(station);
    if (!has_marker) markers.insert(marker);
  }
  unpredictable->points = static_cast<int>(points.size() - predictable.size());
  for (const int s : stations) unpredictable->stations.push_back(data.stations[s]);
  for (const int m : markers) unpredictable->markers.push_back(data.markers[m]);
  return predictable;
}

// Measured - predicted of the points, each by the fit without its fold. weighed: roots that the points are fitted by.
// is_compared: whether what such fits predict is summed as well.
Eigen::Matrix3Xd ErrorsOfFolds(const CalibrationProblem& problem, const FittedStream& fitted, const Estimate& estimate,
                               const FoldPlan& plan, const Division& whole, const std::vector<int>& quoted,
                               const NoiseRoots& weighed, bool is_compared, DividedFit* fit) {
  Eigen::Matrix3Xd errors = ResidualsOf(problem.data(), quoted, whole.predicted(Eigen::all, quoted));
  if (whole.columns.empty() || quoted.empty()) return errors;
  const NoiseRoots instrument = is_compared ? InstrumentOf(estimate, quoted) : NoiseRoots();
  const auto fold_of = [&](size_t place) { return FoldAt(problem, plan, quoted[place]); };
  const auto has = [&](size_t place, const Share& share) { return share.Has(fold_of(place)); };
  if (!problem.latent.empty()) {
    ForEachQuotedArrival(
        problem, whole, fitted, quoted, has,
        [&](const std::vector<int>& places, const RowMajorMatrix& jacobian, const Eigen::MatrixXd& latent) {
          Fold& fold = fit->folds[fold_of(static_cast<size_t>(places.front()))];
          errors(Eigen::all, places) -= (jacobian * fold.step).reshaped(3, static_cast<Eigen::Index>(places.size()));
          if (!is_compared) return;
          NoiseRoots own;
          for (const int place : places) own.push_back(instrument[static_cast<size_t>(place)]);
          fold.predicted.AddArrival(own, jacobian, TimesStated(estimate) * latent);
        });
    return errors;
  }
  std::vector<int> points_of_fold(fit->folds.size(), 0);
  for (const int i : quoted) ++points_of_fold[FoldAt(problem, plan, i)];
  const bool are_summed =
      is_compared && PredictFromTotals(problem, weighed, instrument, quoted, points_of_fold, &fit->folds);
  if (are_summed || !is_compared) {
    fitted.ForEachMoved(
        whole.parameters, whole.columns,
        [&](int position) -> const Eigen::VectorXd& { return fit->folds[plan.rows.partition.part_of[position]].step; },
        [&](int position, const Vector3<double>& moved) {
          const size_t place = PlaceAmong(quoted, fitted, position);
          if (place < quoted.size()) errors.col(static_cast<Eigen::Index>(place)) -= weighed[place] * moved;
        });
    return errors;
  }
  ForEachPoint(whole.parameters, whole.columns, fitted, quoted, weighed, has,
               [&](size_t place, const Matrix3<double>& root, const RowsOfPoint& rows) {
                 Fold& fold = fit->folds[fold_of(place)];
                 errors.col(static_cast<Eigen::Index>(place)) -= root * (rows * fold.step);
                 fold.predicted.Add(instrument[place], root * rows);
               });
  return errors;
}

// What is held in addition moves what was held before: no step from the whole finds that. A fold without which
// something is not measured is calibrated without.
void RecalibrateWhereLost(const CalibrationProblem& problem, const FittedStream& fitted, const FoldPlan& plan,
                          const DividedFit& fit, const std::vector<int>& quoted, Eigen::Matrix3Xd* errors) {
  for (size_t f = 0; f < fit.folds.size(); ++f) {
    if (!fit.folds[f].loses) continue;
    std::vector<int> left_out, own;
    const auto is_in = [&](int i) { return FoldAt(problem, plan, i) == f; };
    std::copy_if(quoted.begin(), quoted.end(), std::back_inserter(own), is_in);
    if (own.empty()) continue;
    std::copy_if(fitted.observations().begin(), fitted.observations().end(), std::back_inserter(left_out), is_in);
    const std::optional<ParameterSet> rest = CalibrateWithout(problem, left_out, own);
    if (!rest) continue;
    const Eigen::Matrix3Xd without = ResidualsOf(problem.data(), own, PredictPoints(problem, *rest, own));
    for (size_t k = 0; k < own.size(); ++k) {
      const auto place = std::lower_bound(quoted.begin(), quoted.end(), own[k]) - quoted.begin();
      errors->col(place) = without.col(static_cast<Eigen::Index>(k));
    }
  }
}

}  // namespace

std::vector<int> FoldsOf(const CalibrationProblem& problem, std::uint64_t seed, int num_threads) {
  const Measurements& data = problem.data();
  std::vector<bool> fitted(data.configurations.size(), false);
  for (const int i : problem.CalibrationObservations())
    fitted[data.shots[data.observations[i].shot].configuration] = true;
  const std::vector<int> group_of = GroupsOfConfigurations(data);
  // Of the groups that are fitted, in the order of the hashes of their first configurations; hardly any two share the
  // first sixteen letters.
  struct Hashed {
    std::uint64_t first;
    int group;
  };
  std::vector<int> first_of, count_of;  // of each group: its first configuration; how many are fitted
  for (size_t c = 0; c < group_of.size(); ++c) {
    const auto g = static_cast<size_t>(group_of[c]);
    if (g == first_of.size()) first_of.push_back(static_cast<int>(c)), count_of.push_back(0);
    count_of[g] += fitted[c] ? 1 : 0;
  }
  const std::string seed_text = std::to_string(seed) + ":";
  const auto text_of = [&](int g) { return seed_text + data.configurations[first_of[g]].id; };
  std::vector<Hashed> hashed;
  for (size_t g = 0; g < first_of.size(); ++g) {
    if (count_of[g] > 0) hashed.push_back({0, static_cast<int>(g)});
  }
  constexpr size_t kHashedAtOnce = 2048;
  ParallelFor(static_cast<int>((hashed.size() + kHashedAtOnce - 1) / kHashedAtOnce), num_threads, [&](int block, int) {
    const size_t begin = static_cast<size_t>(block) * kHashedAtOnce;
    for (size_t i = begin; i < std::min(hashed.size(), begin + kHashedAtOnce); ++i) {
      hashed[i].first = StartOfSha256(text_of(hashed[i].group));
    }
  });
  std::sort(hashed.begin(), hashed.end(), [&](const Hashed& one, const Hashed& other) {
    if (one.first != other.first || one.group == other.group) return one.first < other.first;
    const std::string hash = Sha256(text_of(one.group)), hash_of_other = Sha256(text_of(other.group));
    return hash != hash_of_other ? hash < hash_of_other : one.group < other.group;
  });
  const int count = std::min(kFolds, static_cast<int>(hashed.size()));
  std::vector<int> fold_of(first_of.size(), -1);
  for (size_t i = 0; i < hashed.size(); ++i) fold_of[hashed[i].group] = static_cast<int>(i) % count;
  std::vector<int> folds(data.configurations.size(), -1);
  for (size_t c = 0; c < folds.size(); ++c) {
    if (fitted[c]) folds[c] = fold_of[group_of[c]];
  }
  return folds;
}

FoldPlan PlanFolds(const CalibrationProblem& problem, const FittedStream& fitted, std::uint64_t seed) {
  FoldPlan plan;
  if (fitted.observations().empty()) return plan;
  plan.fold_of = FoldsOf(problem, seed, fitted.num_threads());
  Partition& partition = plan.rows.partition;
  partition.parts = 1 + *std::max_element(plan.fold_of.begin(), plan.fold_of.end());
  for (const int i : fitted.observations()) partition.part_of.push_back(static_cast<int>(FoldAt(problem, plan, i)));
  return plan;
}

CrossValidation CrossValidate(const CalibrationProblem& problem, const FittedStream& fitted, const Estimate& estimate,
                              const FoldPlan& plan) {
  CrossValidation result;
  result.not_run = !plan.is_of_joint_fit;
  if (result.not_run) return result;
  const Division calibrated{estimate.parameters, MovingColumns(estimate), estimate.predicted};
  if (calibrated.columns.empty() || plan.count() < 2) return result;
  const auto sums_of = [&](const Division& whole) { return SumFolds(fitted, plan.rows.partition, whole); };
  std::optional<DividedFit> fit =
      Divide(problem, estimate, calibrated, plan.rows.sums.empty() ? sums_of(calibrated) : plan.rows.sums);
  if (!fit) return result;
  const std::vector<int> points = problem.data().PointsAmong(fitted.observations());
  const std::vector<int> quoted = Predictable(problem, estimate, plan, *fit, points, &result.unpredictable);
  const NoiseRoots weighed = FitRoots(problem, quoted, kFallbackSigma);
  Eigen::Matrix3Xd errors = ErrorsOfFolds(problem, fitted, estimate, plan, calibrated, quoted, weighed, true, &*fit);
  RecalibrateWhereLost(problem, fitted, plan, *fit, quoted, &errors);
  const auto n = static_cast<Eigen::Index>(fit->columns.size());
  SquaresOfFolds squares(fit->sums.topLeftCorner(n, n), AppliedNoise(estimate.sigma));
  for (Fold& fold : fit->folds) squares.Add(fold.root, &fold.predicted);
  const PredictedSquares predicted = squares.Total();
  result.folds = plan.count();
  result.unseen = MeasureUnseen(problem, quoted, errors);
  ComparePrediction(predicted, estimate, &result.unseen, DofOfSizes(problem.repeat_scatter));
  if (estimate.predicted_aligned.cols() == 0) return result;
  const Division aligned{estimate.aligned, AlignedColumns(estimate.aligned), estimate.predicted_aligned};
  std::optional<DividedFit> alignment = Divide(problem, estimate, aligned, sums_of(aligned));
  if (!alignment) return result;
  errors = ErrorsOfFolds(problem, fitted, estimate, plan, aligned, quoted, weighed, false, &*alignment);
  result.nominal = MeasureUnseen(problem, quoted, errors);
  return result;
}

}  // namespace sagitta

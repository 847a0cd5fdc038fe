// ComputeStatistics: covariance, intervals, leverage and hold-out of an estimate,
// all from one Linearization at its parameters.
#include "estimator/calibration/judge.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>

#include "estimator/calibration/bounds.h"
#include "estimator/calibration/joint_estimator.h"
#include "estimator/calibration/load_centres.h"
#include "estimator/calibration/load_remedy.h"
#include "estimator/calibration/prior_pull.h"
#include "estimator/estimate/parameter_table.h"
#include "estimator/least_squares/batch_algebra.h"
#include "estimator/least_squares/cluster_sandwich.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/least_squares/normal_equations.h"
#include "estimator/least_squares/sandwich.h"
#include "estimator/least_squares/spring_tie_cost.h"
#include "estimator/noise/repeat_spread.h"
#include "estimator/noise/weighting.h"
#include "estimator/report/calibration_words.h"
#include "models/matrix_functions.h"
#include "models/row_block.h"
#include "problems/loads.h"

namespace sagitta {
namespace {

// predicted: of all observations.
ResidualSize SizeOf(const CalibrationProblem& problem, const Eigen::Matrix3Xd& predicted,
                    const std::vector<int>& observations) {
  return MeasureReadings(problem.data(), observations, predicted(Eigen::all, observations));
}

// Where the fit has weights of its own, chi-square is the least that the known noise allows near the estimate.
double SquaredMisfit(const CalibrationProblem& problem, const Linearization& linearization) {
  const bool is_known = problem.experiment().noise.from != NoiseSpec::From::kResiduals;
  if (problem.weight_roots.empty() || !is_known) return linearization.residual.squaredNorm();
  return SolveLinearization(linearization).residual_norm_squared;
}

void JudgeNoise(const CalibrationProblem& problem, const FittedRows& fitted, Estimate* estimate) {
  const Linearization& linearization = fitted.rows;
  SigmaReport& sigma = estimate->sigma;
  sigma.stated = problem.sigma_is_stated();
  sigma.origin = problem.noise_origin;
  double sum = SquaredMisfit(problem, linearization);
  estimate->rows = fitted.equations;
  estimate->dof = fitted.equations - linearization.num_columns();
  if (!sigma.stated) {
    // What is held was fitted first: rows that are no more than all unknowns show no noise.
    const auto held = static_cast<int>(HeldCoordinates(estimate->parameters).size());
    if (estimate->dof <= held) estimate->dof = std::min(estimate->dof, 0);
    double dof = estimate->dof;
    SetPriorsAside(problem, linearization, &sum, &dof, estimate);
    sigma.estimated = dof > 0 ? kFallbackSigma * std::sqrt(sum / dof) : 0.0;
    estimate->chi2 = estimate->dof;  // by construction: sigma is what makes it so
    return;
  }
  estimate->chi2 = sum;
  double dof = estimate->dof;
  if (dof <= 0) return;
  SetPriorsAside(problem, linearization, &sum, &dof, estimate);
  // chi-square / dof is F(dof, infinity), unless the noise was read off repeats.
  sigma.a_posteriori = std::sqrt(sum / dof);
  sigma.p_value = ChanceOfResiduals(problem, sum, dof);
  sigma.scaled = sigma.a_posteriori > 1.0 && sigma.p_value < problem.experiment().significance;
  const double times = sigma.scaled ? sigma.a_posteriori : 1.0;
  sigma.rotation = times * problem.rotation_noise;
  if (sigma.origin == NoiseOrigin::kFound) sigma.estimated = times * problem.experiment().noise.sigma.value_or(0.0);
}

// The mean over its axes of the diagonal of J C J' V^-1, where V = I + L L' has the joints' deviations that the rows of
// one visit share; C = (J' V^-1 J)^-1. half: J C.
void LeverageGivenDeviations(const CalibrationProblem& problem, const RowPiece& piece, const Eigen::MatrixXd& jacobian,
                             const Eigen::MatrixXd& half, Eigen::VectorXd* leverage) {
  std::map<std::pair<int, int>, std::vector<int>> rows_of;  // by visit; an outlier is alone
  for (int i = 0; i < piece.num_observations(); ++i) {
    const int k = piece.positions[i];
    const Observation& observation = problem.data().observations[k];
    std::vector<int>& rows =
        rows_of[{problem.latent.visit_of_shot[observation.shot], observation.excluded ? 1 + k : 0}];
    for (int axis = 0; axis < 3; ++axis) rows.push_back(3 * i + axis);
    (*leverage)[k] = 0.0;
  }
  for (const auto& [visit, rows] : rows_of) {
    const Eigen::MatrixXd own = jacobian(rows, Eigen::all), latent = piece.latent(rows, Eigen::all);
    const Eigen::MatrixXd v = Eigen::MatrixXd::Identity(latent.rows(), latent.rows()) + latent * latent.transpose();
    const Eigen::MatrixXd among = own * half(rows, Eigen::all).transpose();
    const Eigen::VectorXd diagonal = v.llt().solve(among).diagonal();
    for (size_t i = 0; i < rows.size(); ++i) {
      (*leverage)[piece.positions[rows[i] / 3]] += diagonal[static_cast<Eigen::Index>(i)] / 3.0;
    }
  }
}

// Leverage and prediction of every row and the parameters' share of the predicted hold-out error, some observations at
// a time.
class RowJudge {
 public:
  // normal_root: R of R R' = (J'W^2 J)^-1 of the fit.
  RowJudge(const CalibrationProblem& problem, const Eigen::MatrixXd& normal_root, double scale, Estimate* estimate)
      : problem_(problem), normal_root_(normal_root), scale_(scale), estimate_(estimate) {
    const size_t n = problem.data().observations.size();
    estimate->leverage.setZero(static_cast<Eigen::Index>(n));
    estimate->scatter.resize(n);
    if (problem.ValidationObservations().empty()) return;
    held_out_.resize(n);
    by_covariance_ = RootOf(estimate->covariance);
    by_model_ = RootOf(estimate->model_covariance);
    by_held_ = RootOf(estimate->held.second_moment);
  }

  // fitted: rows of all observations as the instrument's noise whitens them, or null.
  void Judge(const RowBatches* fitted, int num_threads) {
    std::vector<int> columns = estimate_->estimated;
    columns.insert(columns.end(), estimate_->held.coordinates.begin(), estimate_->held.coordinates.end());
    std::vector<int> all(problem_.data().observations.size()), visits;
    std::iota(all.begin(), all.end(), 0);
    for (const Observation& observation : problem_.data().observations) {  // rows of one visit go together
      if (!problem_.latent.empty()) visits.push_back(problem_.latent.visit_of_shot[observation.shot]);
    }
    transposed_root_.setZero(normal_root_.cols(), static_cast<Eigen::Index>(columns.size()) + 1);
    transposed_root_.leftCols(normal_root_.rows()) = normal_root_.transpose();
    const auto noise = [this](const std::vector<int>& listed) {
      NoiseRoots roots;
      for (const int k : listed) roots.push_back(estimate_->noise[k]);
      return roots;
    };
    const auto judge = [this](const RowPiece& piece) { Judge(piece); };
    estimate_->predicted.setConstant(3, static_cast<Eigen::Index>(all.size()), std::nan(""));
    if (fitted != nullptr) {
      ForEachPiece(*fitted, estimate_->parameters, columns, num_threads, judge);
    } else {
      RowStream(problem_, all, noise, LatentTreatment::kIgnore, visits)
          .ForEach(estimate_->parameters, columns, judge, num_threads);
    }
    std::vector<int> others;  // rotations, and what was not measured
    for (const int k : all) {
      if (!estimate_->predicted.col(k).allFinite()) others.push_back(k);
    }
    estimate_->predicted(Eigen::all, others) = PredictPoints(problem_, estimate_->parameters, others);
    HeldOut sum;  // in the order of the observations, whichever was looked at first
    for (const HeldOut& own : held_out_) {
      sum.predicted += own.predicted;
      sum.floor += own.floor;
      sum.coordinates += own.coordinates;
    }
    estimate_->noise_floor = sum.coordinates > 0 ? std::sqrt(sum.floor / sum.coordinates) : 0.0;
    estimate_->validation_predicted_rms = sum.coordinates > 0 ? std::sqrt(sum.predicted / sum.coordinates) : 0.0;
  }

 private:
  // Squares that are expected of an observation that is held out, m^2, summed over its axes.
  struct HeldOut {
    double predicted = 0.0, floor = 0.0;
    int coordinates = 0;
  };

  // R' J', a column per row of the piece: these lie one behind the other as they are. What follows J in a row (columns
  // of what is held, the residual) meets zeros.
  Eigen::MatrixXd TimesNormalRoot(const RowPiece& piece) const {
    const Eigen::Index numbers = piece.rows.cols(), estimated = normal_root_.rows();
    if (!piece.rows.rightCols(numbers - estimated).allFinite()) {  // what was not measured: zero times it is no number
      return TallProduct(piece.rows.leftCols(estimated), normal_root_).transpose();
    }
    Eigen::MatrixXd product(transposed_root_.rows(), piece.rows.rows());
    const auto size = [](Eigen::Index number) { return static_cast<std::size_t>(number); };
    MultiplyColumns(transposed_root_.data(), size(product.rows()), size(product.rows()), size(numbers),
                    piece.rows.data(), size(product.cols()), product.data());
    return product;
  }

  void Judge(const RowPiece& piece) {  // on several threads at once
    Estimate& estimate = *estimate_;
    const std::vector<int>& observations = piece.positions;
    const auto estimated = static_cast<Eigen::Index>(estimate.estimated.size());
    const auto held = static_cast<Eigen::Index>(estimate.held.coordinates.size());
    const bool any_held_out = by_covariance_.size() > 0;
    Eigen::MatrixXd jacobian, open;  // where they are asked for
    if (any_held_out || !problem_.latent.empty()) jacobian = piece.rows.leftCols(estimated);
    if (any_held_out) open = piece.rows.middleCols(estimated, held) + jacobian * estimate.held.slopes;
    const bool weighed_by_noise = problem_.weight_roots.empty(), exact_joints = problem_.latent.empty();
    const NoiseRoots weights = weighed_by_noise ? NoiseRoots() : FitRoots(problem_, observations, kFallbackSigma);
    const Eigen::MatrixXd by_normal = TimesNormalRoot(piece);
    const auto moved_by = [&](const Eigen::MatrixXd& rows, const Eigen::MatrixXd& root) {
      return any_held_out ? TallProduct(rows, root) : Eigen::MatrixXd();
    };
    const Eigen::MatrixXd by_covariance = moved_by(jacobian, by_covariance_);
    const Eigen::MatrixXd by_model = moved_by(jacobian, by_model_), by_held = moved_by(open, by_held_);
    for (size_t i = 0; i < observations.size(); ++i) {
      const int k = observations[i];
      const auto row = 3 * static_cast<Eigen::Index>(i);
      const Matrix3<double>& own = estimate.noise[k];
      // tr(W J C_n J' W) / 3, C_n = (J'W^2 J)^-1: the mean over the three axes of a reading's hat matrix.
      estimate.leverage[k] = by_normal.middleCols<3>(row).squaredNorm() / 3.0;
      if (!weighed_by_noise) {
        estimate.leverage[k] =
            (by_normal.middleCols<3>(row) * (weights[i].inverse() * own).transpose()).squaredNorm() / 3.0;
      }
      const Eigen::MatrixXd latent = RowBlock(piece.latent, row, 3);  // in units of the instrument's noise
      // A root of S (1 + L L') S', what one reading scatters by: instrument and joints.
      estimate.scatter[k] = own;
      if (!exact_joints) {
        estimate.scatter[k] = own * LowerRoot(Matrix3<double>::Identity() + latent * latent.transpose());
      }
      const Observation& observation = problem_.data().observations[k];
      if (observation.is_point()) {
        estimate.predicted.col(k) = piece.PredictedPoint(static_cast<int>(i), observation, own);
      }
      if (observation.excluded || !problem_.data().IsValidation(observation) || !observation.is_point()) continue;
      // In the station frame, m^2, summed over the axes: the instrument and the joints' deviations; the parameters.
      const double scatter = own.squaredNorm() + (own * latent).squaredNorm();
      const auto variance = [&](const Eigen::MatrixXd& by_root) {
        return (own * RowBlock(by_root, row, 3)).squaredNorm();
      };
      held_out_[static_cast<size_t>(k)] = {scale_ * scale_ * scatter + variance(by_covariance) + variance(by_held),
                                           scatter + variance(by_model) / (scale_ * scale_), 3};
    }
    if (!problem_.latent.empty() && problem_.weight_roots.empty()) {
      LeverageGivenDeviations(problem_, piece, jacobian, TallProduct(by_normal.transpose(), normal_root_.transpose()),
                              &estimate.leverage);
    }
  }

  const CalibrationProblem& problem_;
  const Eigen::MatrixXd& normal_root_;
  const double scale_;
  Estimate* estimate_;
  Eigen::MatrixXd transposed_root_;                     // R' and zeros
  Eigen::MatrixXd by_covariance_, by_model_, by_held_;  // roots; empty where nothing is held out
  std::vector<HeldOut> held_out_;                       // of each observation, where any is held out
};

// A linearization with the information that the estimate has at unit scale: what is weak is so under its own weights.
Linearization Known(const CalibrationProblem& problem, const Linearization& fit, const Eigen::MatrixXd& covariance) {
  if (problem.weight_roots.empty()) return fit;
  Linearization known = fit;
  const Eigen::MatrixXd root = covariance.llt().matrixL();
  known.jacobian = root.triangularView<Eigen::Lower>().solve(Eigen::MatrixXd::Identity(root.rows(), root.cols()));
  known.residual.setZero(root.rows());
  return known;
}

RowStream::Noise RootsOfFit(const CalibrationProblem& problem) {
  return [&problem](const std::vector<int>& listed) { return FitRoots(problem, listed, kFallbackSigma); };
}

// linearization: of the fit, or as few rows with the same sums where it is not kept.
RobustCovariance SandwichOfFit(const CalibrationProblem& problem, const Linearization& linearization,
                               const LinearSolution& solution, const Estimate& estimate) {
  const std::vector<int> observations = problem.CalibrationObservations();
  const std::vector<int> clusters = ConfigurationClusters(problem.data(), observations);
  if (!linearization.observations.empty()) return SandwichCovariance(linearization, clusters);
  const auto columns = static_cast<int>(estimate.estimated.size());
  ClusterFit fit;
  fit.solution = solution;
  ClusterSandwich sandwich(columns, 1 + *std::max_element(clusters.begin(), clusters.end()), solution.covariance,
                           {fit});
  const RowStream stream(problem, observations, RootsOfFit(problem), LatentTreatment::kMarginalise, clusters);
  stream.ForEach(estimate.parameters, estimate.estimated,
                 [&](const RowPiece& piece) { sandwich.Add(piece, clusters); });
  return sandwich.Result(0, PriorsOf(estimate.parameters, estimate.estimated).jacobian);
}

// Covariance of the estimated parameters, and what the held ones add. `linearization`
// is whitened by the weights of the fit. False
// where the Jacobian is singular.
bool JudgeCovariance(const CalibrationProblem& problem, const Linearization& linearization, double scale,
                     Eigen::MatrixXd* normal_root, Estimate* estimate) {
  const std::vector<int> observations = problem.CalibrationObservations();
  const LinearSolution solution = SolveLinearization(linearization);
  if (!solution.full_rank) return false;
  *normal_root = solution.covariance_root;
  estimate->fit_covariance = solution.covariance;
  estimate->model_covariance = scale * scale * solution.covariance;
  if (!problem.weight_roots.empty()) {
    estimate->model_covariance = scale * scale * CovarianceOfWeighted(problem, estimate->parameters, solution);
  }
  estimate->covariance = estimate->model_covariance;
  estimate->identifiability.rank = linearization.num_columns();
  estimate->identifiability.condition = solution.condition;
  estimate->identifiability.weak = FindWeak(Known(problem, linearization, estimate->model_covariance / (scale * scale)),
                                            estimate->parameters, scale);
  std::vector<int> columns = estimate->estimated;
  const std::vector<int> held = HeldCoordinates(estimate->parameters);
  columns.insert(columns.end(), held.begin(), held.end());
  const auto influence_in = [&](const Linearization& rows) {
    return FindHeldInfluence(rows, estimate->parameters, static_cast<int>(estimate->estimated.size()), scale);
  };
  if (held.empty()) {
    estimate->held = influence_in(linearization);
  } else {
    estimate->held =
        influence_in(FittedOnce(problem, estimate->parameters, observations, columns, RootsOfFit(problem)).rows);
  }
  estimate->interval_dof = Eigen::VectorXd::Constant(estimate->estimated.size(), ModelDof(*estimate));
  estimate->intervals = IntervalReport();
  if (estimate->sigma.origin == NoiseOrigin::kRepeats && !estimate->sigma.scaled) {
    estimate->interval_dof = DofByRepeats(problem, *estimate);
  }
  if (problem.experiment().method.covariance != CovarianceKind::kSandwich || scale == 0.0) return true;
  const RobustCovariance robust = SandwichOfFit(problem, linearization, solution, *estimate);
  estimate->covariance = robust.covariance;
  estimate->interval_dof = robust.dof;
  estimate->intervals.method = CovarianceKind::kSandwich;
  estimate->intervals.clusters = robust.clusters;
  estimate->intervals.words = SandwichInWords(robust.clusters);
  return true;
}

// Each loaded observation that was fitted against the mean of the unloaded ones of its configuration, visit and marker.
void JudgeDeflections(const CalibrationProblem& problem, Estimate* estimate) {
  struct Mean {
    Vector3<double> measured = Vector3<double>::Zero();
    Vector3<double> predicted = Vector3<double>::Zero();
    int count = 0;
  };
  const Measurements& data = problem.data();
  const auto key_of = [&](const Observation& observation) {
    const Shot& shot = data.shots[observation.shot];
    return std::make_tuple(shot.configuration, shot.visit, shot.station, observation.marker);
  };
  std::map<decltype(key_of(data.observations[0])), Mean> unloaded;
  const std::vector<int> fitted = data.PointsAmong(problem.CalibrationObservations());
  std::vector<bool> is_loaded(data.configurations.size(), false);  // in some shot: others are compared with nothing
  for (const int k : fitted) {
    const Shot& shot = data.shots[data.observations[k].shot];
    if (IsLoaded(shot)) is_loaded[shot.configuration] = true;
  }
  for (const int k : fitted) {
    const Observation& observation = data.observations[k];
    const Shot& shot = data.shots[observation.shot];
    if (IsLoaded(shot) || !is_loaded[shot.configuration]) continue;
    Mean& mean = unloaded[key_of(observation)];
    mean.measured += observation.point_in_station;
    mean.predicted += estimate->predicted.col(k);
    ++mean.count;
  }
  std::vector<Vector3<double>> measured, remaining;
  for (const int k : fitted) {
    const Observation& observation = data.observations[k];
    const auto mean = unloaded.find(key_of(observation));
    if (!IsLoaded(data.shots[observation.shot]) || mean == unloaded.end()) continue;
    measured.push_back(observation.point_in_station - mean->second.measured / mean->second.count);
    remaining.push_back(measured.back() - (estimate->predicted.col(k) - mean->second.predicted / mean->second.count));
  }
  const auto size_of = [](const std::vector<Vector3<double>>& points) {
    Eigen::Matrix3Xd columns(3, points.size());
    for (size_t i = 0; i < points.size(); ++i) columns.col(i) = points[i];
    return MeasureResiduals(columns);
  };
  estimate->deflection_before = size_of(measured);
  estimate->deflection_after = size_of(remaining);
}

}  // namespace

namespace {

// Where the fit's rows are those of all observations, whitened by the instrument's noise alone: its batches; else null.
const RowBatches* RowsOfAll(const CalibrationProblem& problem, const NormalEquations* equations) {
  if (equations == nullptr || !problem.latent.empty() || !problem.weight_roots.empty()) return nullptr;
  const RowBatches& fitted = equations->batches();
  return fitted.num_observations() == static_cast<int>(problem.data().observations.size()) ? &fitted : nullptr;
}

// All points at the aligned nominal robot; none where nothing was aligned. of_all: or null.
Eigen::Matrix3Xd PredictAligned(const CalibrationProblem& problem, const RowBatches* of_all, int num_threads,
                                const Estimate& estimate) {
  const std::vector<Observation>& observations = problem.data().observations;
  if (estimate.aligned.num_coordinates() == 0) return {};
  const auto is_point = [](const Observation& observation) { return observation.is_point(); };
  if (of_all != nullptr && std::all_of(observations.begin(), observations.end(), is_point)) {
    Eigen::Matrix3Xd points(3, static_cast<Eigen::Index>(observations.size()));
    const bool valid = ForEachPiece(*of_all, estimate.aligned, {}, num_threads, [&](const RowPiece& piece) {
      for (int i = 0; i < piece.num_observations(); ++i) {
        const int k = piece.positions[i];
        points.col(k) = piece.PredictedPoint(i, observations[k], estimate.noise[k]);
      }
    });
    if (valid && points.allFinite()) return points;
  }
  std::vector<int> all(observations.size());
  std::iota(all.begin(), all.end(), 0);
  return PredictPoints(problem, estimate.aligned, all);
}

// equations: of the fit, or null.
void JudgeFit(const CalibrationProblem& problem, const NormalEquations* equations, Estimate* estimate) {
  const std::vector<int> calibration = problem.CalibrationObservations();
  const std::vector<int> validation = problem.ValidationObservations();
  const ParameterSet& parameters = estimate->parameters;
  estimate->estimated = parameters.EstimatedCoordinates();
  const auto noise = [&problem](const std::vector<int>& listed) {
    return ObservationNoise(problem, listed, kFallbackSigma);
  };
  const auto fitted_by = [&](const RowStream::Noise& roots) {
    return FittedOnce(problem, parameters, calibration, estimate->estimated, roots);
  };
  const bool are_held =
      AreHeld(3.0 * static_cast<double>(calibration.size()), static_cast<double>(estimate->estimated.size()));
  FittedRows fitted = equations == nullptr || are_held ? fitted_by(RootsOfFit(problem))
                                                       : RowsOf(*equations, parameters, estimate->estimated);
  const Linearization& fit = fitted.rows;
  if (!fit.valid) {  // the last step to the optimum folded the arm
    estimate->status = Status::kEquilibriumDiverged;
    estimate->message = FoldedInWords(problem, parameters);
    return;
  }
  estimate->cost = 0.5 * fit.residual.squaredNorm();
  JudgeNoise(problem, problem.weight_roots.empty() ? fitted : fitted_by(noise), estimate);
  const double scale = AppliedNoise(estimate->sigma);
  Eigen::MatrixXd normal_root;
  if (!JudgeCovariance(problem, fit, scale, &normal_root, estimate)) {
    estimate->status = Status::kSingular;
    estimate->message = SingularAtEstimate();
    return;
  }
  FillTable(problem, estimate);
  for (const BelowBound& below : FindBelowBounds(fit, parameters, scale, estimate->sigma.stated ? 1.0 : 0.0))
    estimate->warnings.push_back(StandsOnBound(parameters.coordinates()[below.coordinate].name, below.sigmas,
                                               problem.experiment().torques_measured));
  fitted = FittedRows();  // its memory

  std::vector<int> all(problem.data().observations.size());
  for (size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
  estimate->noise = ObservationNoise(problem, all, kFallbackSigma);
  const RowBatches* const of_all = RowsOfAll(problem, equations);
  const int num_threads = equations != nullptr ? equations->num_threads() : 1;
  RowJudge(problem, normal_root, scale, estimate).Judge(of_all, num_threads);
  estimate->predicted_aligned = PredictAligned(problem, of_all, num_threads, *estimate);
  if (!estimate->sigma.stated) {
    for (NoiseRoots* roots : {&estimate->noise, &estimate->scatter}) {
      for (Matrix3<double>& root : *roots) root *= estimate->sigma.estimated / kFallbackSigma;
    }
  }

  std::vector<bool> is_fitted(problem.data().configurations.size(), false);
  for (const int i : calibration)
    is_fitted[problem.data().shots[problem.data().observations[i].shot].configuration] = true;
  estimate->calibration_configurations = static_cast<int>(std::count(is_fitted.begin(), is_fitted.end(), true));
  estimate->fit = SizeOf(problem, estimate->predicted, calibration);
  estimate->validation = SizeOf(problem, estimate->predicted, validation);
  JudgeDeflections(problem, estimate);
  const std::string tie = TieInWords(problem, parameters);
  if (!tie.empty()) estimate->warnings.push_back(tie);
  for (const std::string& words : LoadCentresInWords(problem, parameters)) estimate->warnings.push_back(words);
  if (estimate->aligned.num_coordinates() > 0) {
    estimate->fit_before = SizeOf(problem, estimate->predicted_aligned, calibration);
    estimate->validation_before = SizeOf(problem, estimate->predicted_aligned, validation);
  }
}

}  // namespace

void ComputeStatistics(const CalibrationProblem& problem, Estimate* estimate) { JudgeFit(problem, nullptr, estimate); }

void ComputeStatistics(const CalibrationProblem& problem, const NormalEquations& equations, Estimate* estimate) {
  JudgeFit(problem, &equations, estimate);
}

}  // namespace sagitta

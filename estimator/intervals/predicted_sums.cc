#include "estimator/intervals/predicted_sums.h"

#include <map>

#include "estimator/statistics/distributions.h"

namespace sagitta {

double ChanceOf(const PredictedSquares& predicted, double ratio, double noise_dof) {
  return FSurvival(ratio, predicted.Freedom(), noise_dof);
}

PredictedSums::PredictedSums(int columns)
    : columns_(columns),
      points_(columns),
      by_noise_(columns),
      alike_(Eigen::MatrixXd::Zero(columns, columns)),
      alike_by_noise_(alike_) {}

void PredictedSums::Add(double sigma, int points, const Eigen::MatrixXd& products) {
  const double variance = sigma * sigma;
  trace_ += 3.0 * points * variance;
  square_ += 3.0 * points * variance * variance;
  alike_ += products;
  alike_by_noise_ += variance * products;
}

void PredictedSums::Add(const Matrix3<double>& noise,
                        const Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>& jacobian) {
  const Matrix3<double> own = noise * noise.transpose();
  trace_ += own.trace();
  square_ += own.squaredNorm();
  const Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> scaled = noise.transpose() * jacobian;
  for (int axis = 0; axis < 3; ++axis) {
    points_.Add(jacobian.data() + axis * columns_);
    by_noise_.Add(scaled.data() + axis * columns_);
  }
}

// tr LL' = |L|^2, tr (SS' + LL')^2 = tr (SS')^2 + 2 |S'L|^2 + |L'L|^2, J'LL'J = (L'J)'(L'J).
void PredictedSums::AddArrival(const NoiseRoots& instrument, const RowMajorMatrix& jacobian,
                               const Eigen::MatrixXd& latent) {
  for (size_t i = 0; i < instrument.size(); ++i) {
    const auto row = 3 * static_cast<Eigen::Index>(i);
    Add(instrument[i], jacobian.middleRows<3>(row));
    if (latent.cols() > 0) square_ += 2.0 * (instrument[i].transpose() * latent.middleRows<3>(row)).squaredNorm();
  }
  if (latent.cols() == 0) return;  // joints are exact
  trace_ += latent.squaredNorm();
  square_ += (latent.transpose() * latent).squaredNorm();
  const RowMajorMatrix moved = latent.transpose() * jacobian;
  for (Eigen::Index i = 0; i < moved.rows(); ++i) by_noise_.Add(moved.row(i).data());
}

// tr V = tr N + tr R'SR, tr V^2 = tr N^2 + 2 tr R'QR + |R'SR|^2 with S = J'J, Q = J'NJ.
PredictedSquares PredictedSums::Squares(const Eigen::MatrixXd& root, Eigen::MatrixXd* products) {
  const Eigen::MatrixXd all = points_.Total() + alike_;
  if (products != nullptr) *products = all;
  const Eigen::MatrixXd moved = root.transpose() * all * root;
  const Eigen::MatrixXd mixed = root.transpose() * (by_noise_.Total() + alike_by_noise_) * root;
  return {trace_ + moved.trace(), trace_, square_ + 2.0 * mixed.trace() + moved.squaredNorm()};
}

SquaresOfFolds::SquaresOfFolds(const Eigen::MatrixXd& normal, double noise)
    : noise_(noise), root_(RootOf(normal)), together_(Eigen::MatrixXd::Zero(normal.rows(), normal.cols())) {}

void SquaresOfFolds::Add(const Eigen::MatrixXd& root, PredictedSums* points) {
  Eigen::MatrixXd products;
  const PredictedSquares own = points->Squares(noise_ * root, &products);
  const Eigen::MatrixXd along = noise_ * root.transpose() * root_;
  const Eigen::MatrixXd shared = along.transpose() * (root.transpose() * products * root) * along;
  together_ += shared;
  sum_.trace += own.trace;
  sum_.of_noise += own.of_noise;
  sum_.trace_of_square += own.trace_of_square - shared.squaredNorm();
}

PredictedSquares SquaresOfFolds::Total() const {
  PredictedSquares total = sum_;
  total.trace_of_square += together_.squaredNorm();
  return total;
}

std::vector<int> ArrivalsOf(const CalibrationProblem& problem, const std::vector<int>& observations) {
  std::vector<int> arrivals;
  arrivals.reserve(observations.size());
  for (const int i : observations) {
    const int shot = problem.data().observations[i].shot;
    arrivals.push_back(problem.latent.empty() ? shot : problem.latent.visit_of_shot[shot]);
  }
  return arrivals;
}

RowStream StreamOfArrivals(const CalibrationProblem& problem, const std::vector<int>& observations) {
  const auto metres = [](const std::vector<int>& listed) {
    return NoiseRoots(listed.size(), Matrix3<double>::Identity());
  };
  return RowStream(problem, observations, metres, LatentTreatment::kIgnore, ArrivalsOf(problem, observations));
}

void ForEachArrival(const CalibrationProblem& problem, const RowPiece& piece, const std::vector<int>& observations,
                    const std::function<bool(int position)>& has, const ArrivalVisit& visit) {
  std::vector<int> listed;
  for (const int k : piece.positions) listed.push_back(observations[k]);
  const std::vector<int> arrivals = ArrivalsOf(problem, listed);
  std::map<int, std::vector<int>> places_of;
  for (size_t i = 0; i < arrivals.size(); ++i) places_of[arrivals[i]].push_back(static_cast<int>(i));
  for (const auto& [arrival, places] : places_of) {
    if (!has(piece.positions[places.front()])) continue;
    std::vector<int> positions, rows;
    for (const int i : places) {
      positions.push_back(piece.positions[i]);
      rows.insert(rows.end(), {3 * i, 3 * i + 1, 3 * i + 2});
    }
    visit(positions, piece.rows(rows, Eigen::seq(0, piece.rows.cols() - 2)), piece.latent(rows, Eigen::all));
  }
}

}  // namespace sagitta

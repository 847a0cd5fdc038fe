#include "estimator/noise/rigid_bodies.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <map>
#include <utility>

#include "estimator/least_squares/linearization.h"

namespace sagitta {
namespace {

constexpr double kWidest = 64.0;          // factors are tried by octaves, then refined
constexpr double kNoShareOfShape = 1e-9;  // rounding
// log f to a quarter of 2^-8 near 0: n coordinates leave a standard deviation of 1 / sqrt(2 n) open, as much of half a
// million, and a factor that is off by that has lost a half of the gain.
constexpr int kBitsOfFactor = 8;

// What rigid bodies say of the factor f of a group. With N orthonormal over what no rigid motion does, y = N'r of a
// shot has the covariance v (I + (f^2 - 1) N'W W'N), of which these are the eigenvalues l and the squares z^2 along
// them:
//
//   -2 log L(f) = n log v + sum log (1 + (f^2 - 1) l),   n v = sum y'y + sum z^2 (1 / (1 + (f^2 - 1) l) - 1)
struct LeftOfGroup {
  std::vector<double> shares, squares;

  double LogLikelihood(double factor, double square, double dof) const {
    double log_det = 0.0;
    for (size_t i = 0; i < shares.size(); ++i) {
      const double variance = 1.0 + (factor * factor - 1.0) * shares[i];
      log_det += std::log(variance);
      square += squares[i] * (1.0 / variance - 1.0);
    }
    return -0.5 * (dof * std::log(square) + log_det);
  }

  // The most likely factor. kLeastGain is of the top: from n coordinates log L has lost n e^2 where log f is off by e,
  // so that an octave alone may lie below log L(1) where hundreds say that f is 1.4. Where all shares are alike there
  // is one top, within an octave of the best one.
  double BestFactor(double square, double dof) const {
    const auto cost = [&](double log_factor) { return -LogLikelihood(std::exp(log_factor), square, dof); };
    const double octave = std::log(2.0), widest = std::log(kWidest);
    double near = 0.0;
    for (double at = -widest; at < widest + 0.5 * octave; at += octave)
      if (cost(at) < cost(near)) near = at;
    // Counted from the octave: the precision is relative.
    const auto from_near = [&](double offset) { return cost(near + offset); };
    return std::exp(near + boost::math::tools::brent_find_minima(from_near, -octave, octave, kBitsOfFactor).first);
  }
};

}  // namespace

// A small motion (t, w) of the body moves a marker at arm a from the centre by t + w x a = t - [a]x w.
std::vector<ShotResidual> ResidualsByShot(const CalibrationProblem& problem, const ParameterSet& parameters,
                                          const std::vector<int>& all) {
  const Eigen::Matrix3Xd predicted = PredictPoints(problem, parameters, all);
  const NoiseRoots noise = ObservationNoise(problem, all, kFallbackSigma);
  std::map<std::pair<int, int>, std::vector<size_t>> members;  // of each shot and body
  for (size_t k = 0; k < all.size(); ++k) {
    const Observation& observation = problem.data().observations[all[k]];
    members[{observation.shot, problem.marker_frames()[observation.marker]}].push_back(k);
  }
  std::vector<ShotResidual> shots;
  for (const auto& [shot, ks] : members) {
    ShotResidual result;
    result.residual.resize(3 * ks.size());
    result.rigid.resize(3 * ks.size(), 6);
    Vector3<double> center = Vector3<double>::Zero();
    double points = 0.0;
    for (const size_t k : ks) points += problem.data().observations[all[k]].is_point() ? 1.0 : 0.0;
    for (const size_t k : ks) {
      if (problem.data().observations[all[k]].is_point()) center += predicted.col(k) / points;
    }
    double off = 0.0, reach = 0.0;
    const Vector3<double> base = parameters.BaseInStation(problem.data().shots[shot.first].station).translation;
    for (size_t i = 0; i < ks.size(); ++i) {
      const Observation& observation = problem.data().observations[all[ks[i]]];
      const Matrix3<double> whitener = noise[ks[i]].inverse();
      result.observations.push_back(all[ks[i]]);
      result.residual.segment<3>(3 * i) =
          whitener * MeasuredMinusPredicted(observation.reading(), predicted.col(ks[i]));
      result.places.push_back(observation.is_point() ? Eigen::Vector3d(predicted.col(ks[i])) : Eigen::Vector3d::Zero());
      if (!observation.is_point()) {  // turns with the body, wherever it is
        result.rigid.block<3, 6>(3 * i, 0) << Matrix3<double>::Zero(), whitener;
        continue;
      }
      off += MeasuredMinusPredicted(observation.reading(), predicted.col(ks[i])).squaredNorm();
      reach += (predicted.col(ks[i]) - base).squaredNorm();
      const Vector3<double> arm = predicted.col(ks[i]) - center;
      result.rigid.block<3, 3>(3 * i, 0) = whitener;
      result.rigid.block<3, 3>(3 * i, 3) = whitener * Matrix3<double>(-Skew(arm));
    }
    if (reach > 0.0) result.turn = std::sqrt(off / reach);
    shots.push_back(std::move(result));
  }
  return shots;
}

// By orthonormal bases: solving would divide by the pivots beyond the rank, which are rounding alone.
Eigen::MatrixXd NotRigid(const ShotResidual& shot) {
  Eigen::MatrixXd scaled = shot.rigid;
  for (int c = 0; c < 6; ++c) scaled.col(c) /= std::max(1e-300, scaled.col(c).norm());
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(scaled);
  qr.setThreshold(1e-9);
  const Eigen::MatrixXd all = qr.householderQ();
  return all.rightCols(scaled.rows() - qr.rank());
}

Eigen::VectorXd WithoutRigidMotion(const ShotResidual& shot, int* dof) {
  const Eigen::MatrixXd free = NotRigid(shot);
  *dof = static_cast<int>(free.cols());
  return free * (free.transpose() * shot.residual);
}

int ShapeCost(const CalibrationProblem& problem) {
  if (!problem.experiment().estimate.markers) return 0;
  std::map<int, int> markers;
  for (const int frame : problem.marker_frames()) ++markers[frame];
  int cost = 0;
  for (const auto& [frame, m] : markers) cost += m == 2 ? 1 : std::max(0, 3 * m - 6);
  return cost;
}

std::vector<GroupOfOwnNoise> GroupsOfOwnNoise(const CalibrationProblem& problem, const ParameterSet& parameters,
                                              const std::vector<ReadingGroup>& groups) {
  std::vector<LeftOfGroup> of_group(groups.size());
  double square = 0.0, dof = 0.0;
  for (const ShotResidual& shot : ResidualsByShot(problem, parameters, problem.CalibrationObservations())) {
    const Eigen::MatrixXd free = NotRigid(shot);
    if (free.cols() == 0) continue;
    const Eigen::VectorXd left = free.transpose() * shot.residual;
    square += left.squaredNorm();
    dof += static_cast<double>(left.size());
    std::vector<ReadingWithRoot> readings;
    for (const int i : shot.observations) readings.push_back(ReadingOf(problem, i));
    for (size_t g = 0; g < groups.size(); ++g) {
      Eigen::MatrixXd own = Eigen::MatrixXd::Zero(left.size(), left.size());  // N'W W'N
      for (size_t i = 0; i < readings.size(); ++i) {
        const Directions along = DirectionsOf(readings[i], groups[g]);
        const Eigen::MatrixXd seen = along.transpose() * free.middleRows<3>(static_cast<long>(3 * i));
        own += seen.transpose() * seen;
      }
      if (own.isZero(kNoShareOfShape)) continue;
      const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(own);
      for (long k = 0; k < left.size(); ++k) {
        if (eigen.eigenvalues()[k] < kNoShareOfShape) continue;
        of_group[g].shares.push_back(eigen.eigenvalues()[k]);
        of_group[g].squares.push_back(std::pow(eigen.eigenvectors().col(k).dot(left), 2));
      }
    }
  }
  std::vector<GroupOfOwnNoise> own_noise;
  for (size_t g = 0; g < groups.size() && square > 0.0; ++g) {
    const double factor = of_group[g].BestFactor(square, dof), alike = of_group[g].LogLikelihood(1.0, square, dof);
    const double gain = of_group[g].LogLikelihood(factor, square, dof) - alike;
    if (gain >= kLeastGain) own_noise.push_back({{groups[g], factor}, gain});
  }
  std::stable_sort(own_noise.begin(), own_noise.end(), [](const auto& a, const auto& b) { return a.gain > b.gain; });
  return own_noise;
}

}  // namespace sagitta

#include "tools/reproduce/weight_study.h"

#include <glog/logging.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "estimator/noise/residual_noise.h"
#include "problems/interruption.h"
#include "problems/range.h"
#include "problems/simulation.h"

namespace sagitta {
namespace {

constexpr double k95 = 1.959963984540054;  // quantile of the normal distribution at 0.975

// (B' diag(v) B)^-1 with columns scaled to unit norm first: units differ by 1e3.
Eigen::MatrixXd InverseNormal(const Eigen::MatrixXd& rows, const Eigen::VectorXd& v) {
  const Eigen::MatrixXd weighted = v.cwiseSqrt().asDiagonal() * rows;
  const Eigen::VectorXd scale = weighted.colwise().norm().cwiseInverse();
  const Eigen::MatrixXd scaled = weighted * scale.asDiagonal();
  const Eigen::MatrixXd normal = scaled.transpose() * scaled;
  const Eigen::MatrixXd inverse = normal.llt().solve(Eigen::MatrixXd::Identity(normal.rows(), normal.cols()));
  return scale.asDiagonal() * inverse * scale.asDiagonal();
}

// Diagonal of N^-1 B' diag(w2 s2 w2) B N^-1, as standard deviations.
Eigen::VectorXd SandwichSigma(const WeightDesign& design, const Eigen::MatrixXd& inverse, const Eigen::VectorXd& w2,
                              const Eigen::VectorXd& sigma) {
  const Eigen::MatrixXd half = w2.cwiseProduct(sigma).asDiagonal() * design.rows * inverse;
  return half.colwise().norm().transpose();
}

// The sigmas that residuals suggest, per row.
Eigen::VectorXd SigmaFromResiduals(const WeightDesign& design, const Eigen::VectorXd& residuals,
                                   const WeightMethod& method) {
  if (method.weights == StudyWeights::kResidual) return residuals.cwiseAbs().cwiseMax(method.floor);
  if (method.weights != StudyWeights::kGroup) return design.sigma;
  return GroupSigmas(design.groups, residuals, Eigen::VectorXd::Ones(residuals.size()), method.floor);
}

// w^2, eq. (14) or 1 / sigma^2.
Eigen::VectorXd SquaredWeights(const WeightMethod& method, const Eigen::VectorXd& sigma) {
  if (method.weights == StudyWeights::kEqual) return Eigen::VectorXd::Ones(sigma.size());
  const double sigma0 = method.weights == StudyWeights::kKnownSigma ? 0.0 : method.sigma0;
  return sigma.unaryExpr([&](double s) { return std::pow(Eq14Weight(sigma0, method.lambda, s), 2); });
}

Eigen::VectorXd ClaimedSigma(const WeightDesign& design, const WeightMethod& method, const Eigen::MatrixXd& inverse,
                             const Eigen::VectorXd& w2, const Eigen::VectorXd& residuals) {
  const Eigen::VectorXd sigma = SigmaFromResiduals(design, residuals, method);
  const Eigen::VectorXd normal = inverse.diagonal().cwiseSqrt();
  switch (method.claim) {
    case Claim::kSandwich:
      return SandwichSigma(design, inverse, w2, design.sigma);
    case Claim::kIid: {
      const double dof = static_cast<double>(design.rows.rows() - design.rows.cols());
      return std::sqrt(residuals.dot(w2.cwiseProduct(residuals)) / dof) * normal;
    }
    case Claim::kEstimatedSandwich:
      return SandwichSigma(design, inverse, w2, sigma);
    case Claim::kNormalised:
      return (method.sigma0 > 0.0 ? method.sigma0 : 1.0) * normal;
    case Claim::kEstimatedSigma:
      break;
  }
  return InverseNormal(design.rows, sigma.array().square().inverse()).diagonal().cwiseSqrt();
}

WeightedFit Solve(const WeightDesign& design, const Eigen::VectorXd& deflections, const WeightMethod& method,
                  const Eigen::VectorXd& w2, bool with_claim, Eigen::VectorXd* residuals) {
  const Eigen::MatrixXd inverse = InverseNormal(design.rows, w2);
  WeightedFit fit;
  fit.value = inverse * (design.rows.transpose() * w2.cwiseProduct(deflections));
  *residuals = deflections - design.rows * fit.value;
  if (with_claim) fit.sigma = ClaimedSigma(design, method, inverse, w2, *residuals);
  return fit;
}

// The last fit alone, without the claims on the way.
WeightedFit FitToTheEnd(const WeightDesign& design, const Eigen::VectorXd& deflections, const WeightMethod& method) {
  const bool weights_known = method.weights == StudyWeights::kEqual || method.weights == StudyWeights::kKnownSigma;
  Eigen::VectorXd residuals;
  if (weights_known) return Solve(design, deflections, method, SquaredWeights(method, design.sigma), true, &residuals);
  WeightedFit fit =
      Solve(design, deflections, method, Eigen::VectorXd::Ones(deflections.size()), method.iterations == 0, &residuals);
  for (int i = 1; i <= method.iterations; ++i) {
    const Eigen::VectorXd w2 = SquaredWeights(method, SigmaFromResiduals(design, residuals, method));
    fit = Solve(design, deflections, method, w2, i == method.iterations, &residuals);
  }
  return fit;
}

// OLS whose eq. (8) has its sigmas from the same residuals.
WeightMethod PlainFromResiduals() {
  WeightMethod method;
  method.weights = StudyWeights::kResidual;
  method.claim = Claim::kEstimatedSandwich;
  method.iterations = 0;
  return method;
}

// What one method did over the trials.
struct Tally {
  Eigen::VectorXd claimed, squares, held95, held3s, factor;

  explicit Tally(int n)
      : claimed(Eigen::VectorXd::Zero(n)), squares(claimed), held95(claimed), held3s(claimed), factor(claimed) {}

  void Add(const WeightedFit& fit, const Eigen::VectorXd& truth, const Eigen::VectorXd& ols) {
    const Eigen::ArrayXd error = (fit.value - truth).array();
    claimed += fit.sigma;
    squares += error.square().matrix();
    held95 += (error.abs() <= k95 * fit.sigma.array()).cast<double>().matrix();
    held3s += (error.abs() <= 3.0 * fit.sigma.array()).cast<double>().matrix();
    factor += ols.cwiseQuotient(fit.sigma);
  }

  MethodStudy Finish(const std::string& name, int trials) const {
    MethodStudy study;
    study.name = name;
    study.claimed = claimed / trials;
    study.actual = (squares / trials).cwiseSqrt();
    study.coverage95 = held95 / trials;
    study.coverage3s = held3s / trials;
    study.claimed_factor = factor / trials;
    return study;
  }
};

}  // namespace

Eigen::MatrixXd ElasticColumns(const ForwardModel& model, const ElasticScene& scene,
                               const std::vector<int>& parameters) {
  std::vector<double> theta = model.NominalValues();
  for (int i = 0; i < model.num_parameters(); ++i) {
    if (model.parameters()[i].law == ParameterLaw::kCompliance) theta[i] = 0.0;
  }
  const int block = 3 * static_cast<int>(scene.markers.size());
  Eigen::MatrixXd columns(block * scene.shots.size(), parameters.size());
  std::vector<PointPrediction> predictions;
  for (size_t s = 0; s < scene.shots.size(); ++s) {
    CHECK(model.Predict(scene.shots[s], theta.data(), parameters, scene.base_in_station, scene.markers, &predictions));
    for (size_t m = 0; m < scene.markers.size(); ++m) {
      columns.middleRows(block * s + 3 * m, 3) = predictions[m].d_theta;
    }
  }
  return columns;
}

WeightDesign MakeWeightDesign(const Eigen::MatrixXd& columns, const std::vector<Vector3<double>>& sigma, int markers,
                              int repeats) {
  const int block = 3 * markers;
  CHECK_EQ(columns.rows(), block * static_cast<int>(sigma.size()));
  WeightDesign design;
  design.rows.resize(columns.rows() * repeats, columns.cols());
  design.sigma.resize(design.rows.rows());
  for (int i = 0; i < design.rows.rows(); ++i) {
    const int row = i % static_cast<int>(columns.rows());
    design.rows.row(i) = columns.row(row);
    design.sigma[i] = sigma[row / block][row % 3];
    design.groups.push_back(3 * (row / block) + row % 3);
  }
  return design;
}

std::vector<WeightedFit> FitWeighted(const WeightDesign& design, const Eigen::VectorXd& deflections,
                                     const WeightMethod& method) {
  std::vector<WeightedFit> fits;
  Eigen::VectorXd residuals;
  const bool from_residuals = method.weights == StudyWeights::kGroup || method.weights == StudyWeights::kResidual;
  const WeightMethod ols = from_residuals ? PlainFromResiduals() : WeightMethod();
  fits.push_back(Solve(design, deflections, ols, Eigen::VectorXd::Ones(deflections.size()), true, &residuals));
  if (method.weights == StudyWeights::kEqual) return fits;
  const int iterations = method.weights == StudyWeights::kKnownSigma ? 1 : method.iterations;
  for (int i = 0; i < iterations; ++i) {
    const Eigen::VectorXd w2 = SquaredWeights(method, SigmaFromResiduals(design, residuals, method));
    fits.push_back(Solve(design, deflections, method, w2, true, &residuals));
  }
  return fits;
}

Eigen::VectorXd PredictOlsSigma(const WeightDesign& design) {
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(design.rows.rows());
  return SandwichSigma(design, InverseNormal(design.rows, ones), ones, design.sigma);
}

Eigen::VectorXd PredictWlsSigma(const WeightDesign& design) {
  return InverseNormal(design.rows, design.sigma.array().square().inverse()).diagonal().cwiseSqrt();
}

double WlsGainBound(double ratio) {
  const double r = ratio * ratio;
  return (r + 1.0) / (2.0 * std::sqrt(r));
}

double MethodStudy::ClaimedOverActual() const { return std::exp((claimed.array() / actual.array()).log().mean()); }

void CheckOptions(const WeightStudyOptions& options) {
  CheckIn(allowed::kTrials, options.trials, "WeightStudyOptions.trials");
  for (const double metres : options.bias) CheckIn(allowed::kCoordinate, metres, "WeightStudyOptions.bias");
}

std::vector<MethodStudy> StudyWeights(const WeightDesign& design, const Eigen::VectorXd& truth,
                                      const std::vector<WeightMethod>& methods, const WeightStudyOptions& options) {
  CheckOptions(options);
  Eigen::VectorXd exact = design.rows * truth;
  if (options.bias.size() > 0) exact += options.bias;
  std::vector<Tally> tallies(methods.size(), Tally(static_cast<int>(truth.size())));
  NormalNumbers normal(options.seed);
  for (int trial = 0; trial < options.trials; ++trial) {
    CheckInterruption();
    if (options.progress) options.progress(std::to_string(trial) + " of " + std::to_string(options.trials) + " trials");
    Eigen::VectorXd measured = exact;
    for (int i = 0; i < measured.size(); ++i) measured[i] += design.sigma[i] * normal();
    const Eigen::VectorXd ols = FitToTheEnd(design, measured, PlainFromResiduals()).sigma;
    for (size_t m = 0; m < methods.size(); ++m) tallies[m].Add(FitToTheEnd(design, measured, methods[m]), truth, ols);
  }
  std::vector<MethodStudy> studies;
  for (size_t m = 0; m < methods.size(); ++m) studies.push_back(tallies[m].Finish(methods[m].name, options.trials));
  return studies;
}

std::vector<WeightMethod> KnownWeightMethods() {
  return {
      {"OLS, eq. 8, known sigmas", StudyWeights::kEqual, Claim::kSandwich},
      {"OLS, one common sigma", StudyWeights::kEqual, Claim::kIid},
      {"WLS, known sigmas, eq. 13", StudyWeights::kKnownSigma, Claim::kSandwich},
      {"per group, w = 1/s, eq. 13", StudyWeights::kGroup, Claim::kEstimatedSigma, 1.0, 0.0},
      {"per group, eq. 14, eq. 11", StudyWeights::kGroup, Claim::kEstimatedSandwich},
      {"per group, eq. 14, s0^2 (B'W^2B)^-1", StudyWeights::kGroup, Claim::kNormalised},
      {"per residual, eq. 14, s0^2 (B'W^2B)^-1", StudyWeights::kResidual, Claim::kNormalised},
      {"per residual, eq. 14, eq. 11 with |r|", StudyWeights::kResidual, Claim::kEstimatedSandwich},
      {"per residual, eq. 14, eq. 13 with |r|", StudyWeights::kResidual, Claim::kEstimatedSigma},
  };
}

}  // namespace sagitta

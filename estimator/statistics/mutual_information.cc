#include "estimator/statistics/mutual_information.h"

#include <algorithm>
#include <cmath>

namespace sagitta {
namespace {

// E f(z), z ~ N(0, 1), by the trapezoidal rule: exact to rounding for functions as smooth as these.
template <typename Function>
double NormalMean(const Function& f) {
  constexpr int kNodes = 161;
  constexpr double kReach = 8.0;
  double sum = 0.0, weights = 0.0;
  for (int k = 0; k < kNodes; ++k) {
    const double z = kReach * (2.0 * k / (kNodes - 1) - 1.0);
    const double weight = std::exp(-0.5 * z * z);
    weights += weight;
    sum += weight * f(z);
  }
  return sum / weights;
}

// sum_i p_i E f(ln sum_j p_j exp(x_ij) - ln p_i): minus the logarithm of the right one's probability.
template <typename Function>
double MeanOver(const Eigen::VectorXd& p, const Eigen::MatrixXd& apart, const Function& f) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < p.size(); ++i) {
    if (!(p[i] > 0.0)) continue;
    const Eigen::ArrayXd d = apart.col(i).array().max(0.0);
    sum += p[i] * NormalMean([&](double z) {
             const double odds = (p.array() / p[i] * (-0.5 * d + d.sqrt() * z).exp()).sum();
             return f(std::log(odds));
           });
  }
  return sum;
}

}  // namespace

double MutualInformation(const Eigen::VectorXd& probabilities, const Eigen::MatrixXd& apart) {
  const double after = MeanOver(probabilities, apart, [](double minus_log) { return minus_log; });
  double before = 0.0;
  for (const double p : probabilities) before -= p > 0.0 ? p * std::log(p) : 0.0;
  return before - after;
}

double ExpectedProbability(const Eigen::VectorXd& probabilities, const Eigen::MatrixXd& apart) {
  return MeanOver(probabilities, apart, [](double minus_log) { return std::exp(-minus_log); });
}

int ReadingsNeeded(const Eigen::VectorXd& probabilities, const Eigen::MatrixXd& apart, int count, double wanted,
                   int most) {
  for (int n = 1; n <= most; ++n) {
    if (ExpectedProbability(probabilities, n * apart / count) >= wanted) return n;
  }
  return 0;
}

TwoApart InformationOfTwo(double apart) {
  // With equal priors: I = ln 2 - E ln(1 + odds), odds = exp(-D/2 + sqrt(D) z) of the wrong one over the right one.
  const double d = std::max(0.0, apart), root = std::sqrt(d);
  const auto wrong_to_right = [&](double z) { return std::exp(-0.5 * d + root * z); };
  TwoApart two;
  two.information = std::log(2.0) - NormalMean([&](double z) { return std::log1p(wrong_to_right(z)); });
  two.decides = NormalMean([&](double z) { return 1.0 / (1.0 + wrong_to_right(z)); });
  two.slope = 0.5 * NormalMean([&](double z) {
                const double odds = wrong_to_right(z), wrong = odds / (1.0 + odds);
                return wrong * wrong;
              });
  return two;
}

}  // namespace sagitta

#include "estimator/statistics/mutual_information.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace sagitta {
namespace {

// z = -8 to 8 by a tenth with the weights of N(0, 1). By them the trapezoidal rule is exact to rounding for functions
// as smooth as these.
constexpr int kNodes = 161;
constexpr int kMiddle = kNodes / 2;
constexpr double kReach = 8.0;
constexpr double kFarApart = 1e6;  // exp(-D / 2 + 8 sqrt(D)) is 0 from a tenth of that on
constexpr double kStep = 2.0 * kReach / (kNodes - 1);

Eigen::ArrayXd NormalWeights() {
  const Eigen::ArrayXd weights = (-0.5 * Eigen::ArrayXd::LinSpaced(kNodes, -kReach, kReach).square()).exp();
  return weights / weights.sum();
}

// E f(z), z ~ N(0, 1)
template <typename Function>
double NormalMean(const Function& f) {
  static const Eigen::ArrayXd weights = NormalWeights();
  double sum = 0.0;
  for (int k = 0; k < kNodes; ++k) sum += weights[k] * f(k);
  return sum;
}

// exp(-D / 2 + sqrt(D) z) at all nodes, each from its neighbour: exp(sqrt(D) h) times as large.
Eigen::ArrayXd OddsAt(double apart) {
  const double d = std::clamp(apart, 0.0, kFarApart), up = std::exp(std::sqrt(d) * kStep), down = 1.0 / up;
  Eigen::ArrayXd odds(kNodes);
  odds[kMiddle] = std::exp(-0.5 * d);
  for (int k = 1; k <= kMiddle; ++k) {
    odds[kMiddle + k] = odds[kMiddle + k - 1] * up;
    odds[kMiddle - k] = odds[kMiddle - k + 1] * down;
  }
  return odds;
}

// sum_i p_i E f(P_i); what two are apart serves both.
template <typename Function>
double MeanOver(const Eigen::VectorXd& p, const std::vector<int>& names, const Eigen::MatrixXd& apart,
                const Function& f) {
  Eigen::ArrayXXd alike = Eigen::VectorXd::Ones(kNodes) * p.transpose();  // with itself
  Eigen::ArrayXXd others = Eigen::ArrayXXd::Zero(kNodes, p.size());
  for (Eigen::Index i = 0; i < p.size(); ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      const Eigen::ArrayXd odds = OddsAt(apart(j, i));
      Eigen::ArrayXXd& sums = names[j] == names[i] ? alike : others;
      sums.col(i) += p[j] * odds;
      sums.col(j) += p[i] * odds;
    }
  }
  double sum = 0.0;
  for (Eigen::Index i = 0; i < p.size(); ++i) {
    if (!(p[i] > 0.0)) continue;
    const Eigen::ArrayXd right = alike.col(i) / (alike.col(i) + others.col(i));
    sum += p[i] * NormalMean([&](int k) { return f(right[k]); });
  }
  return sum;
}

// Of the names, in nat.
double Entropy(const Eigen::VectorXd& p, const std::vector<int>& names) {
  std::map<int, double> of_name;
  for (Eigen::Index i = 0; i < p.size(); ++i) of_name[names[i]] += p[i];
  double entropy = 0.0;
  for (const auto& [name, probability] : of_name) {
    if (probability > 0.0) entropy -= probability * std::log(probability);
  }
  return entropy;
}

}  // namespace

double MutualInformation(const Eigen::VectorXd& probabilities, const std::vector<int>& names,
                         const Eigen::MatrixXd& apart) {
  return Entropy(probabilities, names) + MeanOver(probabilities, names, apart, [](double p) { return std::log(p); });
}

double ExpectedProbability(const Eigen::VectorXd& probabilities, const std::vector<int>& names,
                           const Eigen::MatrixXd& apart) {
  return MeanOver(probabilities, names, apart, [](double p) { return p; });
}

TwoApart InformationOfTwo(double apart) {
  // With equal priors: I = ln 2 - E ln(1 + odds), odds = exp(-D/2 + sqrt(D) z) of the wrong one over the right one.
  const Eigen::ArrayXd odds = OddsAt(apart);
  TwoApart two;
  two.information = std::log(2.0) - NormalMean([&](int k) { return std::log1p(odds[k]); });
  two.decides = NormalMean([&](int k) { return 1.0 / (1.0 + odds[k]); });
  two.slope = 0.5 * NormalMean([&](int k) {
                const double wrong = odds[k] / (1.0 + odds[k]);
                return wrong * wrong;
              });
  return two;
}

}  // namespace sagitta

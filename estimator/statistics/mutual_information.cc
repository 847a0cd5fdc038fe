#include "estimator/statistics/mutual_information.h"

#include <algorithm>
#include <cmath>
#include <map>

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

// sum_i p_i E f(P_i)
template <typename Function>
double MeanOver(const Eigen::VectorXd& p, const std::vector<int>& names, const Eigen::MatrixXd& apart,
                const Function& f) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < p.size(); ++i) {
    if (!(p[i] > 0.0)) continue;
    const Eigen::ArrayXd d = apart.col(i).array().max(0.0);
    Eigen::ArrayXd alike(p.size());  // 1 where called like i
    for (Eigen::Index j = 0; j < p.size(); ++j) alike[j] = names[j] == names[i] ? 1.0 : 0.0;
    sum += p[i] * NormalMean([&](double z) {
             const Eigen::ArrayXd odds = p.array() * (-0.5 * d + d.sqrt() * z).exp();
             return f((alike * odds).sum() / odds.sum());
           });
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

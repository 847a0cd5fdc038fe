#include "estimator/statistics/distributions.h"

#include <Eigen/Core>
#include <cmath>
#include <unsupported/Eigen/SpecialFunctions>

namespace sagitta {
namespace {

// Root of an increasing function between bounds.
template <typename Function>
double Bisect(const Function& f, double low, double high) {
  for (int i = 0; i < 200 && high - low > 1e-15 * (1.0 + std::abs(low)); ++i) {
    const double middle = 0.5 * (low + high);
    (f(middle) < 0.0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

// P(T_dof > t), t >= 0 (Abramowitz, Stegun 26.7.1).
double StudentUpperTail(double t, double dof) {
  return 0.5 * Eigen::numext::betainc(0.5 * dof, 0.5, dof / (dof + t * t));
}

}  // namespace

double ChiSquareSurvival(double x, double dof) {
  if (x <= 0.0) return 1.0;
  return Eigen::numext::igammac(0.5 * dof, 0.5 * x);
}

double ChiSquareQuantile(double p, double dof) {
  const double spread = 40.0 * std::sqrt(2.0 * dof) + 100.0;
  return Bisect([&](double x) { return (1.0 - p) - ChiSquareSurvival(x, dof); }, 0.0, dof + spread);
}

double FSurvival(double f, double m, double n) {
  if (f <= 0.0) return 1.0;
  if (!std::isfinite(n)) return ChiSquareSurvival(m * f, m);
  return Eigen::numext::betainc(0.5 * n, 0.5 * m, n / (n + m * f));  // Abramowitz, Stegun 26.6.2
}

double NormalQuantile(double p) { return Eigen::numext::ndtri(p); }

double StudentQuantile(double p, double dof) {
  if (p < 0.5) return -StudentQuantile(1.0 - p, dof);
  if (!std::isfinite(dof) || dof > 1e7) return NormalQuantile(p);
  const double tail = 1.0 - p;
  double high = 10.0;
  while (StudentUpperTail(high, dof) > tail && high < 1e12) high *= 10.0;
  return Bisect([&](double t) { return tail - StudentUpperTail(t, dof); }, 0.0, high);
}

double KolmogorovSurvival(double d, double n) {
  const double root = std::sqrt(n);
  const double x = (root + 0.12 + 0.11 / root) * d;
  if (x < 0.2) return 1.0;  // the series needs more terms than it is worth
  double sum = 0.0;
  for (int k = 1; k <= 100; ++k) sum += (k % 2 == 1 ? 2.0 : -2.0) * std::exp(-2.0 * k * k * x * x);
  return std::min(1.0, std::max(0.0, sum));
}

double BetaQuantile(double p, double a, double b) {
  return Bisect([&](double x) { return Eigen::numext::betainc(a, b, x) - p; }, 0.0, 1.0);
}

double FQuantile(double p, double m, double n) {
  if (!std::isfinite(n)) return ChiSquareQuantile(p, m) / m;
  const double b = BetaQuantile(p, 0.5 * m, 0.5 * n);  // m F / (n + m F) is a beta variate
  return n * b / (m * (1.0 - b));
}

BinomialInterval ClopperPearson(int successes, int trials, double level) {
  const double tail = 0.5 * (1.0 - level);
  BinomialInterval interval;
  if (successes > 0) interval.low = BetaQuantile(tail, successes, trials - successes + 1.0);
  if (successes < trials) interval.high = BetaQuantile(1.0 - tail, successes + 1.0, trials - successes);
  return interval;
}

}  // namespace sagitta

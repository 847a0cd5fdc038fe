#include "estimator/statistics/distributions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace sagitta::distributions_test {
namespace {

// Table values: Abramowitz and Stegun, tables 26.7, 26.8, 26.10.
TEST(Distributions, TableValues) {
  EXPECT_NEAR(NormalQuantile(0.975), 1.959963985, 1e-8);
  EXPECT_NEAR(StudentQuantile(0.975, 1), 12.7062, 1e-3);
  EXPECT_NEAR(StudentQuantile(0.975, 10), 2.228139, 1e-5);
  EXPECT_NEAR(StudentQuantile(0.025, 10), -2.228139, 1e-5);
  EXPECT_NEAR(StudentQuantile(0.995, 30), 2.749996, 1e-5);
  EXPECT_NEAR(ChiSquareSurvival(18.307, 10), 0.05, 1e-5);
  EXPECT_NEAR(ChiSquareQuantile(0.95, 10), 18.3070, 1e-3);
  EXPECT_NEAR(ChiSquareQuantile(0.01, 3), 0.114832, 1e-5);
  EXPECT_NEAR(FSurvival(3.70826, 3, 10), 0.05, 1e-5);
  EXPECT_NEAR(FSurvival(5.84893, 2, 20), 0.01, 1e-5);
  EXPECT_NEAR(FSurvival(161.448, 1, 1), 0.05, 1e-5);
  EXPECT_NEAR(FQuantile(0.95, 3, 10), 3.70826, 1e-5);
  EXPECT_NEAR(FQuantile(0.99, 2, 20), 5.84893, 1e-5);
  const double exact = std::numeric_limits<double>::infinity();
  EXPECT_NEAR(FSurvival(1.8307, 10, exact), 0.05, 1e-5);
  EXPECT_NEAR(FQuantile(0.95, 10, exact), 1.83070, 1e-4);
}

// Where they have a closed form, out to tails that no table holds.
TEST(Distributions, ClosedForms) {
  for (const double p : {1e-9, 1e-4, 0.025, 0.3, 0.5, 0.7, 0.975, 1.0 - 1e-6}) {
    const auto expect_near = [&](double value, double exact) {
      EXPECT_NEAR(value, exact, 1e-9 * std::abs(exact) + 1e-14) << p;  // 1e-9: of 1 - p at p = 1 - 1e-6, round-off
    };
    expect_near(StudentQuantile(p, 1.0), p == 0.5 ? 0.0 : -1.0 / std::tan(M_PI * p));
    expect_near(StudentQuantile(p, 2.0), (2.0 * p - 1.0) / std::sqrt(2.0 * p * (1.0 - p)));
    expect_near(ChiSquareQuantile(p, 2.0), -2.0 * std::log1p(-p));
    expect_near(FQuantile(p, 2.0, 7.0), 3.5 * std::expm1(-std::log1p(-p) / 3.5));
    expect_near(0.5 * std::erfc(-NormalQuantile(p) / std::sqrt(2.0)), p);
  }
  for (const double x : {1e-8, 0.1, 3.0, 40.0, 1200.0}) {
    EXPECT_NEAR(ChiSquareSurvival(x, 2.0) / std::exp(-0.5 * x), 1.0, 1e-12) << x;
    EXPECT_NEAR(FSurvival(x, 2.0, 7.0) / std::pow(1.0 + x / 3.5, -3.5), 1.0, 1e-12) << x;
  }
}

// Of an even number of degrees of freedom the distribution is that of a Poisson process:
// P(chi2 > x) = e^-x/2 sum (x/2)^k / k!, k < dof/2, and the rest of the sum is P(chi2 <= x).
TEST(Distributions, LogarithmsOfTailsThatAreNoNumbers) {
  const auto log_of_terms = [](double x, int first, int last) {
    double largest = -1e300, sum = 0.0;
    const auto log_term = [&](int k) { return k * std::log(0.5 * x) - 0.5 * x - std::lgamma(k + 1.0); };
    for (int k = first; k < last; ++k) largest = std::max(largest, log_term(k));
    for (int k = first; k < last; ++k) sum += std::exp(log_term(k) - largest);
    return largest + std::log(sum);
  };
  for (const double dof : {2.0, 10.0, 400.0, 3000.0}) {
    const int half = static_cast<int>(0.5 * dof);
    for (const double factor : {1e-8, 1e-3, 0.1, 0.9, 0.999}) {
      const double below = log_of_terms(factor * dof, half, half + 4000);
      EXPECT_NEAR(LogChiSquareBetween(0.0, factor * dof, dof), below, 1e-10 * std::abs(below) + 1e-10) << dof;
    }
    for (const double factor : {1.001, 1.1, 3.0, 100.0}) {
      const double above = log_of_terms(factor * dof, 0, half);
      EXPECT_NEAR(LogChiSquareBetween(factor * dof, 1e300, dof), above, 1e-10 * std::abs(above) + 1e-10) << dof;
    }
  }
  EXPECT_NEAR(LogChiSquareBetween(3000.0, 3002.0, 2.0), -1500.0 + std::log1p(-std::exp(-1.0)), 1e-9);
  EXPECT_NEAR(LogChiSquareBetween(1e-9, 2e-9, 2.0), std::log(0.5e-9), 1e-6);
  EXPECT_NEAR(LogChiSquareBetween(1.0, 3.0, 2.0), std::log(std::exp(-0.5) - std::exp(-1.5)), 1e-12);
}

// What callers meet at the ends: nothing throws, and what is beyond everything has no probability left.
TEST(Distributions, EndsOfTheRange) {
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(ChiSquareSurvival(0.0, 3.0), 1.0);
  EXPECT_EQ(ChiSquareSurvival(-1.0, 3.0), 1.0);
  EXPECT_EQ(ChiSquareSurvival(infinity, 3.0), 0.0);
  EXPECT_EQ(FSurvival(0.0, 3.0, 10.0), 1.0);
  EXPECT_EQ(FSurvival(infinity, 3.0, 10.0), 0.0);
  EXPECT_EQ(FSurvival(infinity, 3.0, infinity), 0.0);
  EXPECT_TRUE(std::isnan(ChiSquareSurvival(std::nan(""), 3.0)));
  EXPECT_TRUE(std::isnan(StudentQuantile(0.975, 0.0)));
  EXPECT_EQ(StudentQuantile(0.975, infinity), NormalQuantile(0.975));
  EXPECT_EQ(StudentQuantile(1.0, 5.0), infinity);
  EXPECT_EQ(ChiSquareQuantile(1.0, 5.0), infinity);
}

// Of one number its own quantile; of n of them what (1 - a / n)^n says: none beyond it in 1 - a of the experiments.
TEST(Distributions, LimitOfMany) {
  EXPECT_NEAR(ChiSquareLimitOfMany(1.0, 0.05, 3.0), 7.814728, 1e-6);
  EXPECT_EQ(ChiSquareLimitOfMany(0.0, 0.05, 3.0), ChiSquareLimitOfMany(1.0, 0.05, 3.0));
  EXPECT_NEAR(ChiSquareLimitOfMany(50.0, 0.05, 1.0), 10.827566, 1e-6);  // 1e-3 of one
  EXPECT_NEAR(1e4 * ChiSquareSurvival(ChiSquareLimitOfMany(1e4, 0.01, 3.0), 3.0), 0.01, 1e-9);
}

// By adding up binomial terms; at its ends an interval has that much probability on the other side.
TEST(Distributions, Binomial) {
  const auto at_least = [](int k, int n, double p) {
    double term = std::pow(1.0 - p, n), sum = 0.0;
    for (int i = 0; i <= n; term *= (n - i) * p / ((i + 1.0) * (1.0 - p)), ++i) sum += i >= k ? term : 0.0;
    return sum;
  };
  for (int k = 0; k <= 12; ++k) EXPECT_NEAR(BinomialSurvival(k, 11, 0.3), k > 11 ? 0.0 : at_least(k, 11, 0.3), 1e-14);
  EXPECT_EQ(BinomialSurvival(2, 5, 0.0), 0.0);
  EXPECT_EQ(BinomialSurvival(5, 5, 1.0), 1.0);
  const BinomialInterval interval = ClopperPearson(3, 11);
  EXPECT_NEAR(at_least(3, 11, interval.low), 0.025, 1e-12);
  EXPECT_NEAR(1.0 - at_least(4, 11, interval.high), 0.025, 1e-12);
  EXPECT_EQ(ClopperPearson(0, 11).low, 0.0);
  EXPECT_NEAR(ClopperPearson(0, 11).high, 1.0 - std::pow(0.025, 1.0 / 11.0), 1e-14);
  EXPECT_EQ(ClopperPearson(11, 11).high, 1.0);
  EXPECT_EQ(ClopperPearson(0, 0).low, 0.0);
  EXPECT_EQ(ClopperPearson(0, 0).high, 1.0);
}

TEST(Distributions, StudentTendsToNormal) { EXPECT_NEAR(StudentQuantile(0.975, 1e5), NormalQuantile(0.975), 5e-5); }

}  // namespace
}  // namespace sagitta::distributions_test

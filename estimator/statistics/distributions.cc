#include "estimator/statistics/distributions.h"

#include <algorithm>
#include <boost/math/distributions/beta.hpp>
#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/hypergeometric.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/tools/fraction.hpp>
#include <cmath>
#include <limits>
#include <utility>

namespace sagitta {
namespace {

// What no distribution is asked for is a NaN and what overflows an infinity, as of <cmath>: nothing throws. Double
// precision is kept inside (16 digits of the result need no long double).
namespace policies = boost::math::policies;
using Quiet =
    policies::policy<policies::domain_error<policies::ignore_error>, policies::pole_error<policies::ignore_error>,
                     policies::overflow_error<policies::ignore_error>,
                     policies::evaluation_error<policies::ignore_error>, policies::promote_double<false>>;
using ChiSquare = boost::math::chi_squared_distribution<double, Quiet>;
using FisherF = boost::math::fisher_f_distribution<double, Quiet>;
using Student = boost::math::students_t_distribution<double, Quiet>;
using Normal = boost::math::normal_distribution<double, Quiet>;
using Beta = boost::math::beta_distribution<double, Quiet>;
using Binomial = boost::math::binomial_distribution<double, Quiet>;

constexpr double kLargest = std::numeric_limits<double>::max();  // an infinite statistic is beyond all of them

// log P(chi2 <= x) below the mean:  x^a e^-x / Gamma(a + 1) (1 + x / (a + 1) + x^2 / ((a + 1)(a + 2)) + ...), of half
// of both (Abramowitz and Stegun 6.5.29).
double LogOfLowerTail(double x, double dof) {
  const double a = 0.5 * dof, half = 0.5 * x;
  double term = 1.0, sum = 1.0;
  for (double k = 1.0; term > std::numeric_limits<double>::epsilon() * sum; ++k) sum += term *= half / (a + k);
  return a * std::log(half) - half - std::lgamma(a + 1.0) + std::log(sum);
}

// Numerator and denominator of each step of the continued fraction below.
struct UpperTailTerms {
  using result_type = std::pair<double, double>;
  result_type operator()() {
    const result_type terms{k == 0.0 ? 1.0 : k * (a - k), half + 2.0 * k + 1.0 - a};
    ++k;
    return terms;
  }
  double a, half, k;
};

// log P(chi2 > x) above the mean:  x^a e^-x / Gamma(a) times the continued fraction
// 1 / (x + 1 - a - 1 (1 - a) / (x + 3 - a - 2 (2 - a) / (x + 5 - a - ...))) (Abramowitz and Stegun 6.5.31, contracted).
double LogOfUpperTail(double x, double dof) {
  const double a = 0.5 * dof, half = 0.5 * x;
  UpperTailTerms next{a, half, 0.0};
  const double fraction = boost::math::tools::continued_fraction_a(next, std::numeric_limits<double>::epsilon());
  return a * std::log(half) - half - std::lgamma(a) + std::log(fraction);
}

// log(e^larger - e^smaller).
double LogOfDifference(double larger, double smaller) { return larger + std::log1p(-std::exp(smaller - larger)); }

}  // namespace

double ChiSquareSurvival(double x, double dof) {
  if (x <= 0.0) return 1.0;
  if (x > kLargest) return 0.0;
  return cdf(complement(ChiSquare(dof), x));
}

double LogChiSquareBetween(double low, double high, double dof) {
  if (high < dof) {
    const double below_high = LogOfLowerTail(high, dof);
    return low > 0.0 ? LogOfDifference(below_high, LogOfLowerTail(low, dof)) : below_high;
  }
  if (low <= dof) return std::log(ChiSquareSurvival(low, dof) - ChiSquareSurvival(high, dof));
  const double above_low = LogOfUpperTail(low, dof);
  return high < kLargest ? LogOfDifference(above_low, LogOfUpperTail(high, dof)) : above_low;
}

double ChiSquareQuantile(double p, double dof) { return quantile(ChiSquare(dof), p); }

double ChiSquareLimitOfMany(double n, double significance, double dof) {
  return ChiSquareQuantile(1.0 - significance / std::max(1.0, n), dof);
}

double FSurvival(double f, double m, double n) {
  if (f <= 0.0) return 1.0;
  if (!std::isfinite(n)) return ChiSquareSurvival(m * f, m);
  if (f > kLargest) return 0.0;
  return cdf(complement(FisherF(m, n), f));
}

double FQuantile(double p, double m, double n) {
  return std::isfinite(n) ? quantile(FisherF(m, n), p) : ChiSquareQuantile(p, m) / m;
}

double NormalQuantile(double p) { return quantile(Normal(), p); }

double LogNormalCdf(double x) { return std::log(0.5 * std::erfc(-std::max(x, -37.0) / std::sqrt(2.0))); }

double HypergeometricSurvival(int n, int some, int last, int there) {
  const int least = std::max(0, some + last - n), most = std::min(some, last);
  if (there <= least || there > most) return there <= least ? 1.0 : 0.0;
  const boost::math::hypergeometric_distribution<double, Quiet> among(some, last, n);
  return cdf(complement(among, there - 1));
}

double LogStudentCdf(double t, double dof) {
  const double p = cdf(Student(dof), t);
  return p > 0.0 ? std::log(p) : LogNormalCdf(t);
}

double StudentQuantile(double p, double dof) { return quantile(Student(dof), p); }

double WelchDof(double a, double dof_a, double b, double dof_b) {
  const double weight = a * a / dof_a + b * b / dof_b;
  return weight > 0.0 ? (a + b) * (a + b) / weight : std::numeric_limits<double>::infinity();
}

double KolmogorovSurvival(double d, double n) {
  // P(D > d) = 2 sum_k (-1)^(k-1) exp(-2 k^2 x^2), x = (sqrt n + 0.12 + 0.11 / sqrt n) d (Stephens 1970).
  const double root = std::sqrt(n);
  const double x = (root + 0.12 + 0.11 / root) * d;
  if (x < 0.2) return 1.0;  // the series needs more terms than it is worth
  double sum = 0.0;
  for (int k = 1; k <= 100; ++k) sum += (k % 2 == 1 ? 2.0 : -2.0) * std::exp(-2.0 * k * k * x * x);
  return std::min(1.0, std::max(0.0, sum));
}

double BinomialSurvival(int k, int n, double p) { return k <= 0 ? 1.0 : cdf(complement(Binomial(n, p), k - 1)); }

BinomialInterval ClopperPearson(int successes, int trials, double level) {
  const double tail = 0.5 * (1.0 - level);
  // Beta quantiles: no p outside gives these successes with more than the tail (Clopper and Pearson 1934).
  return {Binomial::find_lower_bound_on_p(trials, successes, tail),
          Binomial::find_upper_bound_on_p(trials, successes, tail)};
}

}  // namespace sagitta

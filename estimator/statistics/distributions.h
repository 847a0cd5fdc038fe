// Distribution functions by Boost.Math, in double precision. Outside their domain (degrees of freedom that are not
// positive, a probability that is none) they are NaN; a quantile that overflows is infinite; nothing throws.
#pragma once

namespace sagitta {

inline constexpr double kUpperOf95 = 0.975;  // P below the upper end of a two-sided interval of 95 %

// P(chi2_dof > x).
double ChiSquareSurvival(double x, double dof);
// log P(low < chi2_dof <= high), 0 <= low < high, also where it is too small for a number.
double LogChiSquareBetween(double low, double high, double dof);
// x with P(chi2_dof <= x) = p.
double ChiSquareQuantile(double p, double dof);
// What one of n numbers of that distribution exceeds by chance in no more than that share of the experiments
// (Bonferroni): x with P(chi2_dof > x) = significance / n; n below 1 is 1.
double ChiSquareLimitOfMany(double n, double significance, double dof);
// P(F_{m,n} > f); infinite n: of chi2_m / m.
double FSurvival(double f, double m, double n);
// f with P(F_{m,n} <= f) = p; infinite n as above.
double FQuantile(double p, double m, double n);
double NormalQuantile(double p);
// log P(N(0, 1) <= x), not below that at -37, the last where P is no denormal number.
double LogNormalCdf(double x);
// log P(T_dof <= t), that of the normal distribution where P is no number any more.
double LogStudentCdf(double t, double dof);
// t with P(T_dof <= t) = p; the normal quantile for infinite dof.
double StudentQuantile(double p, double dof);
// Degrees of freedom of the variance a + b, each known with its own: (a + b)^2 / (a^2 / dof_a + b^2 / dof_b) (Welch
// 1947, Satterthwaite 1946).
double WelchDof(double a, double dof_a, double b, double dof_b);
// P(largest distance between an empirical distribution of n numbers and the true one > d), Kolmogorov's series with
// Stephens' correction for finite n; two samples: n = n1 n2 / (n1 + n2).
double KolmogorovSurvival(double d, double n);
// P(Binomial(n, p) >= k), 0 <= k <= n + 1.
double BinomialSurvival(int k, int n, double p);
// P(`there` or more of `some` are among `last` of n), where which of n they are is chance.
double HypergeometricSurvival(int n, int some, int last, int there);

// Clopper and Pearson's interval of a probability from `successes` of `trials`:
// covers at least `level`, whatever the probability.
struct BinomialInterval {
  double low = 0.0;
  double high = 1.0;
};
BinomialInterval ClopperPearson(int successes, int trials, double level = 0.95);

}  // namespace sagitta

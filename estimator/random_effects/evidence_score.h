// How well a group of columns explains a residual: the log marginal likelihood over that of nothing.
//
// Whitened, predicted - measured at the optimum of what is believed:  r + J b + A a = e,  e ~ N(0, I),  a ~ N(0, s^2
// I), b flat, both times the factor f^2 of sigma where that is open; the posterior mean of a is -(G + I / s^2)^-1 g.
// With P the projection off J, G = A'PA, g = A'Pr, R = r'Pr and n = rows - rank(J), the marginal likelihood depends on
// the group through
//
//   log det = log |I + s^2 G|,   quad = g' (G + I / s^2)^-1 g,
//   log B(s) = log f(R - quad) - log f(R) - 1/2 log det
//
// f is the density of a residual of that square: exp(-R/2) where sigma is known, Student's where it is open. The
// columns are in units of their typical size; s is not known and has the values of kScales with equal probability,
// which contains the Occam factor: there is no other penalty. (MacKay 1992, "Bayesian interpolation"; Kass and Raftery
// 1995.)
#pragma once

#include <Eigen/Cholesky>
#include <limits>
#include <vector>

#include "estimator/random_effects/column_products.h"

namespace sagitta {

// Half decades around the typical size: wide enough that the exact size does not matter. The last is for gross causes,
// as a marker that was knocked: below it what is ten times as large as usual would be given to wrong noise, or shared
// out among two effects that do the same.
constexpr double kScales[] = {0.03, 0.1, 0.3, 1.0, 3.0, 10.0};
constexpr int kNumScales = 6;
constexpr double kWidestScale = kScales[kNumScales - 1];
// Without the last: of functions without a name, which would absorb a named cause of the usual size as gross bends.
constexpr int kNumUsualScales = 5;
constexpr double kLargestUsual = kScales[kNumUsualScales - 1];  // at which all that is looked for has to be visible

// Normal equations of a list of columns with what is believed eliminated.
struct ProjectedNormal {
  ColumnProducts information;  // G
  Eigen::VectorXd gradient;    // g
  double residual = 0.0;       // R
  double dof = 0.0;            // n
};

// What a group does to the evidence at one scale.
struct GroupGain {
  double quad = 0.0;
  double log_det = 0.0;
};

// Of a group with prior standard deviation `scale`, in typical sizes, from its information and gradient.
GroupGain GainOf(const Eigen::Ref<const Eigen::MatrixXd>& information,
                 const Eigen::Ref<const Eigen::VectorXd>& gradient, double scale);

// The most that columns with at least this information can explain: quad grows with s and falls with G, and what a
// scale costs, log det, is no gain. Of each column of gradients.
Eigen::VectorXd MostQuads(const Eigen::MatrixXd& least_information, const Eigen::MatrixXd& gradients);

// log of the sum, and of the mean, of exponentials, without overflow.
double LogSumExp(const std::vector<double>& logs);
double LogMean(const std::vector<double>& logs);

// A wrong unit's decades: mm for 10 um, or a sigma of the last digit. Where the true factor lay beyond, what no factor
// absorbs would be given to explanations with certainty.
constexpr double kWidestFactor = 100.0;
// An expanded uncertainty, k = 2, stated for a standard one (JCGM 100:2008, section 6.3), or the other way round: what
// goes wrong without anybody's noticing.
constexpr double kUsualFactor = 2.0;

// f: what is known of sigma. `sigma_dof`: degrees of freedom that state it (infinity: known; 0: nothing states it).
// A stated sigma is wrong with probability `wrong`: then its factor lies anywhere within kUsualFactor or, as probably,
// within kWidestFactor, evenly in the logarithm.
class ResidualLikelihood {
 public:
  ResidualLikelihood(double dof, double sigma_dof, double wrong);

  // Of a residual of this square; the constant is that of known sigma, exp(-R/2).
  double Log(double residual) const;
  // That the stated sigma is wrong, given the square; 0 where nothing states it.
  double ProbabilityWrong(double residual) const;
  // That as large a square comes about where sigma is as stated; 1 where nothing states it.
  double ChanceOf(double residual) const;
  // Factor on sigma that the square asks for: root of R / n where it is open.
  double Factor(double residual) const;
  // log P(a > 0 | r) of a coefficient that is z standard deviations, of sigma as stated, above 0, given that square:
  // over all factors that sigma may have, which makes a normal distribution Student's.
  double LogPositive(double z, double residual) const;

 private:
  double LogStated(double residual) const;
  double LogOpen(double residual) const;

  double dof_, sigma_dof_, wrong_;
  double open_constant_, stated_constant_;
};

// A group given others that are in the set: what GainOf needs, and R and log |Q| without it.
struct GivenOthers {
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
  double residual = 0.0, log_det = 0.0;
  int num_scales = kNumScales;         // the first of kScales
  std::vector<int> not_negative = {};  // coefficients
};

// Log likelihood with the group at each of its scales; and what their average has less than the best of them.
std::vector<double> LogsOfScales(const ResidualLikelihood& likelihood, const GivenOthers& given);
double LossOfScale(const ResidualLikelihood& likelihood, const GivenOthers& given);
// Of coefficients that are not negative the prior is the half of a normal one. Over that of the whole, which all else
// here is, the log evidence is
//
//   sum_c log (P(a_c > 0 | r) / P(a_c > 0)) = sum_c log 2 Phi(a_c / sigma_c),  a = -(G + I/s^2)^-1 g,
//   sigma_c^2 = (G + I/s^2)^-1_cc;  where sigma is open Student's in place of Phi,
//
// as if they were independent of each other given the rows.
double LogOfSigns(const ResidualLikelihood& likelihood, const GivenOthers& given, double scale);
// The most that can be.
double MostOfSigns(const std::vector<int>& not_negative);
// Log evidence that the group adds, averaged over its scales; log_det is left out. scale: the best of them, or null.
double AverageGain(const ResidualLikelihood& likelihood, const GivenOthers& given, double* scale = nullptr);

}  // namespace sagitta

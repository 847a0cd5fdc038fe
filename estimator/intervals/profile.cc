#include "estimator/intervals/profile.h"

#include <algorithm>
#include <cmath>

#include "estimator/estimate/parameter_table.h"
#include "estimator/least_squares/bounded_step.h"
#include "estimator/least_squares/parallel.h"
#include "estimator/least_squares/refit.h"
#include "estimator/report/intervals_words.h"
#include "estimator/statistics/distributions.h"
#include "problems/range.h"

namespace sagitta {
namespace {

constexpr int kMaxFits = 40;              // four triplings lead to 30 half-widths, 20 halvings from one to 1e-6
constexpr double kBetterOptimum = -1e-3;  // of t^2, as the tolerance: another optimum, better than the estimate

struct End {
  double distance = 0.0;  // from the estimate, SI, >= 0
  bool open = false;
  bool at_bound = false;
  bool better = false;  // the profile dips below the estimate's chi-square
};

// One side of one coordinate.
class ProfileSide {
 public:
  ProfileSide(const CalibrationProblem& problem, const Estimate& estimate, int column, double sign, double chi2,
              double scale)
      : problem_(problem),
        estimate_(estimate),
        coordinate_(estimate.estimated[column]),
        sign_(sign),
        chi2_(chi2),
        scale_(scale),
        last_(estimate.parameters) {
    slope_ = Eigen::VectorXd::Zero(estimate.parameters.num_coordinates());
    // d theta_i / d theta_c along the profile of a quadratic: C_ic / C_cc.
    const Eigen::VectorXd along = estimate.model_covariance.col(column) / estimate.model_covariance(column, column);
    for (int c = 0; c < along.size(); ++c) slope_[estimate.estimated[c]] = sign * along[c];
  }

  // Signed root of the chi-square gained, in units of the noise, at a distance;
  // NaN: no fit there.
  double At(double distance) {
    ParameterSet start = last_;
    start.Plus((distance - at_) * slope_);
    ClampOthers(&start);
    RefitOptions options;
    options.kept = coordinate_;
    const Refit refit = RefitFrom(problem_, start, options);
    if (!refit.converged) return std::nan("");
    if (distance != at_) slope_ = TangentDifference(refit.parameters, last_) / (distance - at_);
    last_ = refit.parameters;
    at_ = distance;
    // z = sign sqrt((chi2(theta) - chi2_min) / s^2): normal or Student, straight where the model is linear (Bates and
    // Watts 1988, chapter 6).
    const double gained = (refit.chi2 - chi2_) / (scale_ * scale_);
    return gained < 0.0 ? -std::sqrt(-gained) : std::sqrt(gained);
  }

  double Lower() const {
    return sign_ < 0.0 ? estimate_.parameters.Value(coordinate_) - estimate_.parameters.coordinates()[coordinate_].lower
                       : std::numeric_limits<double>::infinity();
  }

 private:
  // The extrapolation may leave the bounds of other coordinates.
  void ClampOthers(ParameterSet* start) const {
    Eigen::VectorXd back = Eigen::VectorXd::Zero(start->num_coordinates());
    for (const int i : estimate_.estimated) {
      const double lower = start->coordinates()[i].lower;
      if (std::isfinite(lower) && start->Value(i) < lower) back[i] = lower - start->Value(i);
    }
    start->Plus(back);
  }

  const CalibrationProblem& problem_;
  const Estimate& estimate_;
  int coordinate_;
  double sign_;
  double chi2_;
  double scale_;
  ParameterSet last_;
  double at_ = 0.0;
  Eigen::VectorXd slope_;  // of all coordinates along the profile
};

// Where z(distance) = t: secant steps inside a bracket that grows from the ellipse.
End FindEnd(ProfileSide side, double t, double half, const ProfileOptions& options) {
  End end;
  const double bound = side.Lower();
  double low = 0.0, z_low = 0.0, high = std::numeric_limits<double>::infinity(), z_high = 0.0;
  double next = std::min(half, bound);
  for (int i = 0; i < kMaxFits; ++i) {
    const double z = side.At(next);
    if (std::isfinite(z) && z * std::abs(z) < kBetterOptimum * t * t) end.better = true;
    if (std::isfinite(z) && std::abs(z - t) < options.tolerance * t) {
      end.distance = next;
      return end;
    }
    if (std::isfinite(z) && z < t) {
      low = next, z_low = z;
      if (next >= bound) {
        end.distance = bound;
        end.at_bound = true;
        return end;
      }
    } else {
      high = next, z_high = z;
    }
    if (low >= options.farthest * half) break;
    if (std::isinf(high)) {
      next = z_low > 0.1 * t ? std::clamp(low * t / z_low, 1.05 * low, 3.0 * low) : 3.0 * low;
      next = std::min(next, bound);
    } else if (std::isfinite(z_high)) {
      const double secant = low + (high - low) * (t - z_low) / (z_high - z_low);
      next = std::clamp(secant, low + 0.02 * (high - low), high - 0.02 * (high - low));
    } else {
      next = 0.5 * (low + high);
    }
    if (high - low < 1e-6 * half) break;
  }
  end.distance = std::isinf(high) ? low : 0.5 * (low + high);
  end.open = std::isinf(high) || !std::isfinite(z_high);  // never worse enough, or no fit beyond
  return end;
}

}  // namespace

void CheckOptions(const ProfileOptions& options) {
  CheckIn(allowed::kThreads, options.num_threads, "ProfileOptions.num_threads");
  CheckIn(allowed::kTolerance, options.tolerance, "ProfileOptions.tolerance");
  CheckIn(allowed::kWideningFactor, options.farthest, "ProfileOptions.farthest");
}

void ProfileIntervals(const CalibrationProblem& problem, const ProfileOptions& options, Estimate* estimate) {
  CheckOptions(options);
  const auto n = static_cast<int>(estimate->estimated.size());
  const Refit here = RefitFrom(problem, estimate->parameters);
  IntervalReport& report = estimate->intervals;
  report = IntervalReport();
  if (!here.converged) {
    report.words = ProfileRefused();
    estimate->warnings.push_back(report.words);
    return;
  }
  // A loss costs certainty; variances that were estimated make a Student's t of the normal quantile.
  const double inflation = estimate->noise_report.loss_inflation;
  const double noise = std::isfinite(ModelDof(*estimate)) ? std::pow(AppliedNoise(estimate->sigma), 2) : 1.0;
  const double scale = std::sqrt(inflation * noise);
  std::vector<End> ends(2 * n);
  ParallelFor(2 * n, options.num_threads, [&](int i, int) {
    const double sign = i % 2 == 0 ? -1.0 : 1.0;
    const double t = StudentQuantile(kUpperOf95, estimate->interval_dof[i / 2]);
    const double half = t * std::sqrt(inflation * estimate->model_covariance(i / 2, i / 2));
    ends[i] = FindEnd(ProfileSide(problem, *estimate, i / 2, sign, here.chi2, scale), t, half, options);
  });
  report.method = CovarianceKind::kProfile;
  bool better = false;
  for (int c = 0; c < n; ++c) {
    ParameterEstimate& row = estimate->table[estimate->estimated[c]];
    const End& low = ends[2 * c];
    const End& high = ends[2 * c + 1];
    row.ci95 = {row.value - low.distance, row.value + high.distance};
    row.open_low = low.open;
    row.open_high = high.open;
    row.at_bound = low.at_bound;
    report.failed += low.open + high.open;
    better |= low.better || high.better;
  }
  report.words = ProfileInWords(report.failed);
  if (better) {
    estimate->warnings.push_back(ProfileFindsBetterFit());
  }
}

}  // namespace sagitta

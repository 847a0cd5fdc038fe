#include "estimator/validation/noise_share.h"

#include <algorithm>
#include <cmath>

#include "estimator/noise/rotation_noise.h"
#include "estimator/statistics/distributions.h"

namespace sagitta {
namespace {

constexpr double kConsiderable = 0.5;  // of the RMS: a quarter of the mean square

// Nothing states it, or points and rotations are weighed by the spread of their residuals. Components of the joints are
// apart from the noise of the instrument.
bool IsNoiseOfResiduals(const Estimate& estimate) {
  const NoiseReport& report = estimate.noise_report;
  return HasTwoNoises(report) || (!estimate.sigma.stated && report.components.empty());
}

// Found by a diagnosis, together with what deviates: a share of the residuals that it chose.
bool IsNoiseOfDiagnosis(const SigmaReport& sigma) { return sigma.stated && sigma.IsOfResiduals(); }

// Mean square of the readings' noise, m^2.
double SquareOfReadings(const Estimate& estimate, const std::vector<int>& points) {
  double noise = 0.0;
  for (const int i : points) noise += estimate.noise[i].squaredNorm();
  return noise / static_cast<double>(points.size());
}

}  // namespace

NoiseShare ShareOfNoise(const Estimate& estimate, const std::vector<int>& points, const UnseenPoints& unseen) {
  NoiseShare share;
  if (points.empty() || unseen.points == 0 || !(unseen.freedom > 0.0)) return share;
  const double noise = SquareOfReadings(estimate, points);
  const double square = unseen.distance_rms * unseen.distance_rms;
  const double deviation = square * std::sqrt(2.0 / unseen.freedom);
  const double two_sided = NormalQuantile(kUpperOf95), one_sided = NormalQuantile(0.95);
  const bool is_chosen = IsNoiseOfDiagnosis(estimate.sigma);
  share.of_residuals = is_chosen || IsNoiseOfResiduals(estimate);
  const double lacking = square - noise / (1.0 - unseen.parameters_share);
  if ((is_chosen || !share.of_residuals) && lacking > two_sided * deviation) share.beyond_noise = std::sqrt(lacking);
  if (is_chosen) return share;
  // More noise than there are errors: it is stated too large, which is said elsewhere.
  if (!(noise >= kConsiderable * kConsiderable * square) || noise > square + two_sided * deviation) return share;
  share.noise = std::sqrt(noise);
  share.rms_known_to = 0.5 * two_sided * deviation / square;
  const double rest = square - noise;
  share.rest_is_bound = rest < two_sided * deviation;
  share.rest = std::sqrt(share.rest_is_bound ? std::max(0.0, rest) + one_sided * deviation : rest);
  return share;
}

double BeyondScatter(const UnseenPoints& unseen) {
  if (unseen.points == 0) return 0.0;
  const double scatter = 3.0 * (1.0 - unseen.parameters_share) * unseen.predicted_rms * unseen.predicted_rms;
  return scatter > 0.0 ? std::sqrt(std::max(0.0, unseen.distance_rms * unseen.distance_rms - scatter)) : 0.0;
}

double BeyondInstrument(const Estimate& estimate, const std::vector<int>& points, const UnseenPoints& unseen) {
  if (points.empty() || unseen.points == 0) return 0.0;
  const double noise = SquareOfReadings(estimate, points);
  return std::sqrt(std::max(0.0, unseen.distance_rms * unseen.distance_rms - noise));
}

}  // namespace sagitta

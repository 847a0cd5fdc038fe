#include "estimator/inspection/tried_readings.h"

#include <algorithm>
#include <cmath>

#include "estimator/alignment/aligned_misfit.h"
#include "models/constants.h"

namespace sagitta {
namespace {

// Readings that fit alike, the simplest of which is named: an RMS of fifty coordinates is known to a tenth.
constexpr double kAsGoodAReading = 1.1;
constexpr size_t kMostAlike = 2;

// Some readings leave rows out. Where those were what did not fit, the others fit as stated as well.
double MisfitUnder(const Reading& reading, const CalibrationProblem& problem, const std::vector<int>& all,
                   double as_stated) {
  const CalibrationProblem reread = Reread(problem, reading);
  std::vector<int> rows;
  for (const int i : all) {
    if (!reread.data().observations[i].excluded) rows.push_back(i);
  }
  if (rows.empty()) return as_stated;
  const double misfit = AlignedMisfit(reread, rows);
  const bool leaves_out = rows.size() < all.size();
  return leaves_out && misfit * kReadingImprovement >= AlignedMisfit(problem, rows) ? as_stated : misfit;
}

// Joint values that no turn brings within the limits of the robot file, by more than a degree or a millimetre.
int CountBeyondLimits(const CalibrationProblem& problem) {
  constexpr double kSlackAngle = 1.0 * kDegree, kSlackLength = 1e-3;
  int beyond = 0;
  for (const Configuration& configuration : problem.data().configurations) {
    for (int j = 0; j < problem.robot().num_joints(); ++j) {
      const Joint& joint = problem.robot().chain.joints[j];
      if (!joint.min || !joint.max) continue;
      const bool turns = joint.type == JointType::kRevolute;
      const double slack = turns ? kSlackAngle : kSlackLength, least = *joint.min - slack;
      double q = configuration.q[j];
      if (turns) q -= 2.0 * kPi * std::floor((q - least) / (2.0 * kPi));  // the least that is not below
      beyond += q < least || q > *joint.max + slack;
    }
  }
  return beyond;
}

}  // namespace

TriedReadings TryReadings(const CalibrationProblem& problem, const std::vector<int>& rows,
                          std::vector<Reading> readings) {
  TriedReadings tried;
  tried.all = std::move(readings);
  tried.as_stated = AlignedMisfit(problem, rows);
  double least = tried.as_stated;
  for (Reading& reading : tried.all) {
    reading.misfit = MisfitUnder(reading, problem, rows, tried.as_stated);
    least = std::min(least, reading.misfit);
  }
  tried.best = std::max(kPerfect * Reach(problem), kAsGoodAReading * least);
  for (size_t k = 0; k < tried.all.size(); ++k) {
    const Reading& reading = tried.all[k];
    const bool explains = reading.misfit <= tried.best && reading.misfit * kReadingImprovement < tried.as_stated;
    tried.beyond_limits.push_back(explains ? CountBeyondLimits(Reread(problem, reading)) : -1);
    if (!explains) continue;
    if (!tried.simplest || tried.beyond_limits[k] < tried.beyond_limits[*tried.simplest]) tried.simplest = k;
  }
  for (const int beyond : tried.beyond_limits)
    tried.limits_decide |= tried.simplest && beyond > tried.beyond_limits[*tried.simplest];
  return tried;
}

std::vector<std::string> TriedReadings::Alike() const {
  std::vector<std::string> alike;
  for (size_t k = *simplest + 1; k < all.size() && alike.size() < kMostAlike; ++k) {
    if (beyond_limits[k] == beyond_limits[*simplest]) alike.push_back(all[k].name);
  }
  return alike;
}

std::vector<Reading> TriedReadings::BestOf(size_t count) const {
  std::vector<Reading> sorted = all;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Reading& a, const Reading& b) { return a.misfit < b.misfit; });
  sorted.resize(std::min(count, sorted.size()));
  return sorted;
}

}  // namespace sagitta

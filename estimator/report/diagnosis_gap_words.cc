#include "estimator/report/diagnosis_gap_words.h"

#include <algorithm>
#include <cmath>

#include "estimator/report/diagnosis_words.h"
#include "problems/text.h"

namespace sagitta {
namespace {

// Wide is the interval of 95 % of a share that may be anything from 0 to 1, each as probable.
constexpr double kAnyShare = 0.95;

// p: not a number where it was not asked.
std::string ChanceInWords(double p) {
  if (std::isnan(p)) return "on too few configurations to say whether noise alone gives as much";
  return "noise alone gives as much in " + Percent(p) + " of such hold-outs";
}

// Where a cause without a name is all that is found (JudgeFinal): the noise as it was stated.
bool IsBelievedModel(const Diagnosis& d) { return d.effects.empty() && d.has_unexplained; }

}  // namespace

bool MayBeAnyShare(const GapReport& gap) { return gap.closed_ci95.high - gap.closed_ci95.low >= kAnyShare; }

std::string GapIsNotKnown(const GapReport& gap) {
  return std::isnan(gap.floor) ? "not known, for nothing states the noise" : "not known, for nothing is held out";
}

std::string ClosedInWords(const GapReport& gap) {
  if (gap.before == 0.0) return "there was no gap beyond the noise floor";
  if (std::isnan(gap.closed)) {
    return std::string("which share of the gap that is is not known without a ") +
           (std::isnan(gap.floor) ? "stated noise" : "hold-out");
  }
  const std::string share = Significant(100 * gap.closed, 3) + " %";
  if (std::isnan(gap.closed_ci95.low)) return "closed " + share + " of the squared gap";
  const std::string interval =
      Significant(100 * gap.closed_ci95.low, 3) + " to " + Significant(100 * gap.closed_ci95.high, 3);
  if (MayBeAnyShare(gap)) {
    return "which share of the squared gap is closed is not known: " + share + " on these configurations, " + interval +
           " % on others like them (95 %)";
  }
  return "closed " + share + " of the squared gap (95 %: " + interval + ")";
}

std::string FloorGoesByStatedNoise() {
  return "by the noise as stated: the joints' deviation and the noise that are found may be an error that follows the "
         "pose, and count as gap";
}

std::string NoiseOfFinalInWords(const Diagnosis& d) {
  const NoiseFinding& noise = d.noise;
  const bool differs = noise.scale_differs || noise.HasRepeatability() || !noise.groups.empty();
  if (!differs || !noise.is_stated || IsBelievedModel(d)) return "";
  return noise.is_of_final || !d.has_unexplained
             ? "with the noise that is found"
             : "with the noise that would be left if all that is missing were known, what has no name too";
}

std::string FitInWords(const Diagnosis& d, const Estimate& estimate) {
  if (!d.noise.is_stated) return "fit RMS " + Significant(1e3 * estimate.fit.rms, 3) + " mm";
  return "reduced chi-square " + Significant(estimate.chi2 / std::max(1, estimate.dof), 3);
}

std::string GapInWords(const Diagnosis& d) {
  if (std::isnan(d.gap.before)) return "Gap on untouched configurations: " + GapIsNotKnown(d.gap) + "\n";
  if (d.gap.before == 0.0) return "Gap on untouched configurations: none beyond the noise floor\n";
  const std::string words =
      "Gap on untouched configurations, beyond the noise floor: " + Significant(1e3 * d.gap.before, 3);
  if (d.verdict == DiagnosisVerdict::kConsistent) return words + " mm, " + ChanceInWords(d.gap.p) + "\n";
  if (d.effects.empty() && d.gap.after < d.gap.before)
    return words + " mm; given the noise that was found " + Significant(1e3 * d.gap.after, 3) + " mm\n";
  if (d.effects.empty()) return words + " mm\n";
  return words + " -> " + Significant(1e3 * d.gap.after, 3) + " mm, " + ClosedInWords(d.gap) + "\n";
}

}  // namespace sagitta

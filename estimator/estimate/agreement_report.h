// Do parts of the data say the same within their intervals? Part of an Estimate; found in agreement.h.
#pragma once

#include <string>
#include <vector>

#include "problems/choices.h"

namespace sagitta {

// What the data are divided by into two parts.
enum class SplitBy { kRandom, kRegion, kStation, kTime, kMarker, kLoad };
// "random", ...
std::string WordOf(SplitBy by);

// Differences of parameters between two parts of the configurations, each over its joint 95 % interval.
struct PartComparison {
  SplitBy by = SplitBy::kRandom;
  std::string key;   // "" or a joint, x, y, z (base frame), "S1 and S2", "M1 and the others"; "" of a kind: all its
                     // splits together
  int compared = 0;  // differences
  int inside = 0;    // of them within their joint 95 % interval
  double inflation = 0.0;  // factor on the intervals with which 95 % would be
  double p_value = 1.0;    // of all differences of the split at once; of a kind: the least, times their number
  double share() const { return compared > 0 ? inside / static_cast<double>(compared) : 0.0; }
};

// What repeated shots of one arrival scatter by, against what is left between the arrivals (F test of lack of fit).
struct RepeatFit {
  bool known = false;  // there are repeats
  double ratio = 1.0;  // F: mean squares between over within
  double p_value = 1.0;
  int between_dof = 0, within_dof = 0;
};

// What the comparison of parts of the data found.
struct AgreementReport {
  bool known = false;                                            // there was enough to divide
  CovarianceKind covariance = CovarianceKind::kModel;            // of the intervals that were compared
  unsigned long long seed = 1;                                   // of the random halves
  std::vector<PartComparison> splits;                            // each one
  std::vector<PartComparison> kinds;                             // pooled: random first
  double random_share_model = 0.0, random_share_sandwich = 0.0;  // of random halves, by either covariance
  double inflation = 1.0;       // of intervals that are to hold between parts that disagree: what model error adds
  bool disagrees = false;       // at the experiment's significance
  double sandwich_ratio = 1.0;  // median over the parameters of the sandwich's standard deviation over the model's
  bool sandwich_advised = false;
  double shared_errors = 0.0;  // by how many standard deviations points of one shot err more alike than by chance
  RepeatFit repeats;
  std::vector<std::string> words;
};

}  // namespace sagitta

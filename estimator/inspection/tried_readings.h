// Several ways to read the same rows, each tried on them: which explains what the nominal robot misses by, and which
// others do as well.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "estimator/inspection/readings.h"

namespace sagitta {

// Times less misfit than as stated: what was meant. Of squares 25, which three coordinates against three have by chance
// once in 80 draws, nine against nine once in 40 000 (F distribution).
constexpr double kReadingImprovement = 5.0;
constexpr double kPerfect = 1e-4;  // of the reach: no better fit means anything

struct TriedReadings {
  std::vector<Reading> all;        // simplest first, each with its misfit
  double as_stated = 0.0;          // m RMS
  double best = 0.0;               // what fits as well as the best does, m
  std::optional<size_t> simplest;  // of those that explain the rows, beyond the joints' limits as seldom as any
  bool limits_decide = false;      // others that fit as well go beyond them more often

  // Names of others that do as well as the simplest.
  std::vector<std::string> Alike() const;
  std::vector<Reading> BestOf(size_t count) const;

  std::vector<int> beyond_limits;  // of those that fit as well as the best: joint values beyond; of others -1
};

// rows: observations that are compared, of a problem whose places are found anew under every reading, but for those
// that are fixed. readings: simplest first.
TriedReadings TryReadings(const CalibrationProblem& problem, const std::vector<int>& rows,
                          std::vector<Reading> readings);

}  // namespace sagitta

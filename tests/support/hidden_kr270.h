// What diagnosis has to find: a KR 270 whose joints stand elsewhere than its rows say, part of them held out.
#pragma once

#include "tests/support/moved_kr270.h"

namespace sagitta::test {

// Configurations from one station, three in ten of them held out; `move` changes where the joints really are.
template <typename Move>
CalibrationProblem Moved(std::uint64_t seed, const Move& move, int configurations = 50) {
  const Measurements data = MeasuredAfter(CampaignOf(configurations, 1, 2e-5, seed), 100 + seed, move);
  Experiment experiment;
  experiment.validation.kind = ValidationSpec::Kind::kFraction;
  experiment.validation.fraction = 0.3;
  return MakeCalibrationProblem(Kr270Robot(), data, experiment);
}

// Joint 3 off by `deviation(q3)`.
template <typename Deviation>
CalibrationProblem Hidden(std::uint64_t seed, const Deviation& deviation) {
  return Moved(seed, [&](Eigen::VectorXd* q) { (*q)[2] += deviation((*q)[2]); });
}

}  // namespace sagitta::test

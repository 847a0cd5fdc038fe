// Which readings are outliers, and whether they are: readings that share a
// configuration, marker, load, station, joint range, region or time are more likely a systematic
// misfit of the model, and a misfit must not be thrown out.
#pragma once

#include <string>
#include <vector>

#include "estimator/noise/robust.h"

namespace sagitta {

// Points whose leave-one-out distance is less likely than `significance` over all points together, worst first;
// exchanged markers of one shot are recognised.
std::vector<Outlier> FlagOutliers(const CalibrationProblem& problem, const PointCheck& check,
                                  const ParameterSet& parameters, double significance);

// What the flagged readings share, in words; empty: they lie about at random. An exchange of two
// markers counts once.
std::vector<std::string> WhatTheyShare(const CalibrationProblem& problem, const ParameterSet& parameters,
                                       const std::vector<Outlier>& outliers, double significance);

}  // namespace sagitta

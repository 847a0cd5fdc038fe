// Find where simulation and measurement disagree, name what is missing, add it,
// and show the gap shrink on data it has not seen. FORMATS section 6.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "estimator/diagnosis/alternatives.h"
#include "estimator/diagnosis/confirmation.h"
#include "estimator/diagnosis/decoys.h"
#include "estimator/diagnosis/gap.h"
#include "estimator/diagnosis/gap_map.h"
#include "estimator/diagnosis/noise_book.h"
#include "estimator/diagnosis/selection.h"
#include "estimator/diagnosis/step_view.h"
#include "estimator/diagnosis/thermal_lag.h"
#include "estimator/diagnosis/unexplained.h"

namespace sagitta {

constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();

struct WhereShare {
  std::string by;  // config, marker, axis, joint, load, station, time
  std::string key;
  double share = 0.0;  // of the excess chi-square
};

struct DiagnosisStep {
  ChosenStep chosen;
  std::vector<ParameterEstimate> parameters;
  std::optional<ThermalLag> lag;  // that their intervals allow for
  // m; not a number without a hold-out, or where this prefix of the steps does not converge alone
  double holdout_before = kNotKnown, holdout_after = kNotKnown;
  double reduced_chi2_after = kNotKnown;
  std::vector<Alternative> alternatives;
  Confirmation confirmation;
  StepView view;
};

struct Diagnosis {
  std::string verdict;  // consistent, noise, explained, partly, unknown
  std::string words;
  Status status = Status::kNoConvergence;
  std::string message;
  DiagnosedModel baseline, final;
  std::vector<WhereShare> where;
  std::vector<JointGap> gap_map;
  NoiseFinding noise;
  std::vector<ScreenedCandidate> candidates;  // of the baseline, best first
  std::vector<NotTestable> not_testable;
  std::vector<DiagnosisStep> steps;
  double baseline_p = 1.0, final_p = 1.0;  // lack of fit
  GapReport gap;
  bool has_unexplained = false;
  Decoy unexplained;
  std::vector<std::string> cautions;  // what limits the verdict, in words
};

struct DiagnosisOptions {
  double significance = 0.01;
  JointOptions joint;
  bool points_are_measured = true;  // not shifted by a simulation: readings can be judged
  int num_threads = 1;              // of the search: candidates and steps side by side
  std::function<void(const std::string&)> progress;
};

Diagnosis Diagnose(const CalibrationProblem& problem, const DiagnosisOptions& options);

std::vector<WhereShare> FindWhere(const DiagnosedModel& model);

}  // namespace sagitta

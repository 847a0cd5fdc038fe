// Find where simulation and measurement disagree, say what is missing with its probability, add it, and show the gap
// shrink on data it has not seen. FORMATS section 6.
#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "estimator/agreement/between_parts.h"
#include "estimator/diagnosis/effect_checks.h"
#include "estimator/diagnosis/gap.h"
#include "estimator/diagnosis/gap_map.h"
#include "estimator/diagnosis/learnt_function.h"
#include "estimator/diagnosis/noise_finding.h"
#include "estimator/diagnosis/physical_bounds.h"
#include "estimator/diagnosis/reported_posterior.h"
#include "estimator/diagnosis/verdict.h"
#include "estimator/evidence/next_poses.h"
#include "models/constants.h"
#include "problems/significance.h"

namespace sagitta {

// A candidate alone with the believed model.
struct ScreenedCandidate {
  EffectSpec spec;
  int explanation = 0;     // the best of its name
  double reduction = 0.0;  // chi-square
  int parameters = 0;
  double corrected_p = 1.0;
  double log_evidence = 0.0;          // over nothing, prior not included
  std::optional<double> holdout_rms;  // m; of those with a share of the probability
};

// Numbers of a scanned setting that the data do not contradict at 95 %, in the unit of its name. Of what temperature
// drives it is how late the arm follows the thermometer (Newton's law of cooling, thermal_growth.cc).
struct PossibleNumbers {
  std::string setting;
  double best = 0.0, least = 0.0, most = 0.0;
  // All numbers down to the least that was looked at, or up to the greatest, are possible: it may lie beyond.
  bool is_open_below = false, is_open_above = false;
  bool is_thermal_lag = false;
  bool is_timed = true;  // of a lag: the shots state their time; else they are in their order, one a minute
};

// An effect that the diagnosis names, with what it explains and what speaks for it.
struct FoundEffect : CheckedEffect {
  Candidate candidate;
  double probability = 0.0;
  double reduction = 0.0;  // chi-square, the others given
  double corrected_p = 1.0;
  std::vector<ParameterEstimate> parameters;
  PhysicalBounds bounds;
  std::vector<EffectSpec> stated_instead;  // of the robot file, with other values: they explain as much
  std::optional<PossibleNumbers> numbers;  // of its scanned setting, that the parameters' intervals allow for
  // m; not a number without a hold-out, or where this prefix of the effects does not converge alone
  double holdout_before = kNotKnown, holdout_after = kNotKnown;
  double reduced_chi2_after = kNotKnown;
  EffectView view;
};

// Uses of one effect, on however many targets.
struct EffectGroup {
  std::string effect;
  std::vector<int> effects;  // of Diagnosis::effects
  // Of the squared gap beyond the noise floor on untouched rows; group after group, strongest first.
  double share_of_gap = kNotKnown;
  // That the arm has this effect on any target, with any settings; not known of several effects.
  double probability = kNotKnown;
};

struct LearntModel;  // learnt_model.h

// All that a diagnosis found; the verdict is pessimistic until it is done.
struct Diagnosis {
  DiagnosisVerdict verdict = DiagnosisVerdict::kUnknown;
  Status status = Status::kNoConvergence;
  std::string message;
  DiagnosedModel baseline, final;
  std::vector<WhereShare> where;
  std::vector<JointGap> gap_map;
  NoiseFinding noise;
  ReportedPosterior posterior;
  std::vector<ScreenedCandidate> candidates;  // of the baseline, best first
  int screened = 0;                           // effects with their settings: so many tests are behind each p-value
  std::vector<NotTestable> not_testable;
  std::vector<FoundEffect> effects;
  std::vector<EffectGroup> groups;
  double baseline_p = kNotKnown, final_p = kNotKnown;  // lack of fit
  GapReport gap;
  std::optional<NextPoses> next;  // that would decide between what shares the probability
  bool has_unexplained = false;
  LearntFunction unexplained;
  std::shared_ptr<const LearntModel> learnt;  // null: nothing was learnt that predicts untouched rows better
  std::vector<std::string> cautions;          // what limits the verdict, in words
  size_t read_first = 0;                      // of these, the first: to be read before the answer
  BetweenParts choice;                        // that the final model holds one of several sets; not known: it is alone
};

// Effects with their probability while the work goes on: refitted, not yet judged by the full estimator.
using FoundSoFar = std::vector<std::pair<EffectSpec, double>>;

// How Diagnose searches, and to whom it reports its progress.
struct DiagnosisOptions {
  double significance = kDefaultSignificance;
  PriorMasses prior;
  JointOptions joint;
  bool points_are_measured = true;  // not shifted by a simulation: readings can be judged
  std::function<void(const std::string&)> progress;
  std::function<void(const FoundSoFar&)> found;  // whenever the effects change; may be empty
};
// Throws InputError that names the option (problems/range.h).
void CheckOptions(const DiagnosisOptions& options);

// Which effects the model lacks. The problem needs held-out configurations for the gap (HoldOutForDiagnosis). Throws
// InputError for an option out of its range and for fitted readings that are not numbers, std::invalid_argument where
// members of the problem do not fit together; a model that does not fit is the status.
Diagnosis Diagnose(const CalibrationProblem& problem, const DiagnosisOptions& options);

}  // namespace sagitta

// Which poses to measure, how many, and how good the calibration will be.
//
// One problem holds what is measured, the candidates and the test points (scene.h). Its linearization at the robot's
// values, in the experiment's noise, with priors and joint repeatability (once per arrival), gives the information of
// each candidate: all shots of one configuration (numbers.h). Directions that no data could determine count with the
// hold limits of the estimate (FORMATS section 4). The predicted error at a test point is that of the point in its
// station's frame, sqrt(tr(J C J')), as far as the model is true: what a calibration with the plan's readings leaves.
// Stations and markers that only test poses see count as registered there. The search is search.h, the order in which
// poses are measured route.h.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "estimator/planning/design.h"
#include "models/effects/effect_spec.h"
#include "models/robot.h"
#include "problems/cell.h"
#include "problems/experiment.h"
#include "problems/measurements.h"
#include "problems/parameter_set.h"

namespace sagitta {

// Of poses where they were drawn or found, not moved one by one: a quick plan of that many.
struct PosesAndAccuracy {
  int poses = 0;
  double position_rms = 0.0;  // m
};

// How far the points that a former estimate had not fitted are off, next to what its noise explains.
//
//   e^2 = rms^2 - predicted^2,   predicted: the root of the noise and of what it leaves of the parameters
//
// Both parts of `predicted` are in proportion to the noise that it was made with. Where nothing stated that one it was
// found from residuals, which have e in them; the instrument is then assumed to be that of the plan:
//
//   predicted -> predicted min(1, sigma of the plan / sigma that was found)
//
// Half of all sound estimates are off by a little more than they predict. So e counts where it is more than chance, at
// the experiment's significance alpha: where p_value, which the former estimate states for its own `predicted`, is
// below, or where the lower bound of the variance by chi-square is above what is predicted,
//
//   rms^2 nu / chi2_nu(1 - alpha) > predicted^2,
//
// if it states none, or one for a `predicted` that is larger than this. nu: degrees of freedom of the former fit;
// residuals of points left out are linear in its residuals, so that no more of them are independent.
struct FormerMisfit {
  enum class Kind {
    kNone,            // no former estimate was given
    kMeasured,        // the figures below
    kWithinChance,    // the figures below; e is no more than chance
    kNotCompared,     // nothing was left out and predicted, no noise is known, or nothing to test e by
    kInRepeatability  // the joints' repeatability was found from what the model lacks too
  };
  Kind kind = Kind::kNone;
  double rms = 0.0, predicted = 0.0;  // m per coordinate
  double found_noise = 0.0;           // m: what `predicted` was made with; 0: it was stated
  std::optional<double> p_value;      // that noise alone puts points as far off; none: not stated
  double dof = 0.0;                   // of the former fit; 0: not stated

  // Whether rms is beyond `predicted_now`, m per coordinate, at that significance; none: nothing says.
  std::optional<bool> IsBeyondChance(double predicted_now, double significance) const;
};

// What a plan is asked for, what may be chosen, and what reports its progress.
struct PlanRequest {
  int poses = 0;          // 0: as many as `accuracy` needs
  double accuracy = 0.0;  // m, RMS distance at the test points
  bool augment = false;   // the experiment's calibration rows are measured already
  CriterionKind criterion = CriterionKind::kI;
  std::vector<EffectSpec> discriminate;      // rivals; more than one: in place of the criterion
  const Measurements* candidates = nullptr;  // null: drawn in the joint limits
  const Measurements* tests = nullptr;       // null: the validation rows of the experiment, else all rows
  bool random_tests = false;                 // drawn in the joint limits instead
  const Cell* cell = nullptr;                // what poses must keep to in addition to the joint limits
  double model_error = 1.0;                  // factor by which errors exceed those predicted (Estimate's model error)
  double field = 0.0;    // m per coordinate: by which the model is wrong at unseen points (model_field.h); 0: not known
  FormerMisfit former;   // in place of `field`, where one is given
  bool move = true;      // drawn poses may move to better places
  int pool = 500;        // poses drawn
  int most_poses = 500;  // of the search for an accuracy
  int starts = 3;
  std::uint64_t seed = 1;
  std::function<void(const std::string&)> progress = {};
  std::function<void(const PosesAndAccuracy&)> found = {};  // each plan as it is found, before its poses move
};
// Throws InputError that names the option (problems/range.h).
void CheckOptions(const PlanRequest& options);

// What a parameter is expected to be known to.
struct PlannedParameter {
  std::string name;
  Quantity quantity = Quantity::kLength;
  double sigma = 0.0;        // SI, expected
  bool identifiable = true;  // false: expected worse than its hold limit
};

// Poses to measure, with what they are expected to bring.
struct Plan {
  Measurements rows;  // the chosen configurations in the order of their measurement, with the points that are expected
  Criterion criterion;
  double cost = 0.0;
  double bound = 0.0;                 // cost of no plan of as many candidates is below; only with a certificate
  double efficiency = 0.0;            // of the bound over the cost; 0 without a certificate
  bool moved = false;                 // poses were moved from where they were drawn
  int found_given_measured = 0;       // candidates that were not drawn but found from those drawn
  double position_rms = 0.0;          // m, distance, at the test points
  double position_max = 0.0;          // m, of the worst test point
  double best_rms = 0.0;              // m: no plan of as many candidates is better; 0: not known
  double model_error = 1.0;           // factor, as stated
  double field = 0.0;                 // m per coordinate, as stated or found from the former estimate
  FormerMisfit former;                // as it was compared with the plan's noise
  double field_amplitude = 0.0;       // rad, of each of the field's coefficients
  double rms_with_model_error = 0.0;  // m, distance, at the test points: with the field, or the factor
  // Of rivals: mean of the noncentralities D, of their information in nat, of the right one's expected probability.
  double apart = 0.0, information = 0.0, decides = 0.0;
  Eigen::Matrix<double, 5, 1> indices;  // O1 .. O5
  std::vector<PlannedParameter> parameters;
  std::vector<PosesAndAccuracy> curve;
  int knee = 0;  // poses from which on more only average the noise; 0: not within the curve
  int candidates = 0, infeasible = 0, tests = 0, measured = 0;
  std::map<std::string, int> infeasible_because;               // how many of those tried, by reason
  bool goes_with_time = false, goes_with_temperature = false;  // effects of the robot: rows state those assumed
  std::vector<std::string> checked, not_checked;
  double travel = 0.0, travel_as_found = 0.0;  // ranges of the joint that moves farthest, summed; 0: order is random
  std::string order;                           // in words
  std::vector<std::string> words;              // what was assumed

  bool HasModelError() const { return model_error > 1.0 || field_amplitude > 0.0; }
};

// Throws InputError for what cannot be planned.
Plan MakePlan(const Robot& robot, const Measurements& data, const Experiment& experiment, const PlanRequest& asked);

}  // namespace sagitta

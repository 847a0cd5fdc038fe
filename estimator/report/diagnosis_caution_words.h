// What limits a verdict whatever the search finds, in sentences with a remedy each. Lengths come in m.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "estimator/inspection/finding.h"
#include "models/effects/effect_spec.h"

namespace sagitta {

struct Diagnosis;
struct FoundEffect;
struct PhysicalBounds;
struct Robot;

// Effects that arms have and that these data cannot show, with what they lack; "" where there are none.
std::string NotTestedInWords(const Diagnosis& d);
// Of a misfit that no model has.
std::string MostIsOf(const std::vector<std::string>& configurations);
// Whether machines have an effect of that sign and size.
std::string PhysicalInWords(const PhysicalBounds& bounds);

// A finding about the readings that no effect answers.
std::string LookAtThisFirst(const Finding& finding);
// suspects: how many rows, and the first.
std::string LookAtSuspectsFirst(const std::string& suspects);

// conflict: a prior that the rows contradict, with its cure.
std::string PriorsFirst(const std::string& conflict);

// rows_share_visits: rows of one arrival can share an error.
std::string NoNoiseIsStated(bool rows_share_visits);
std::string MethodKeysUnused(const std::vector<std::string>& keys);

// Configurations and coordinates that are fitted.
std::string FewAreFitted(int configurations, int coordinates, int unknowns);
// Joints that hardly move; all: none moves.
std::string JointsStandStill(const std::vector<std::string>& joints, bool all);

// Joints that moved one way over all rows, which state no time.
std::string JointsFollowTheOrder(const std::vector<std::string>& joints);

// "time_s (3 of 40 rows)".
std::string PartlyStated(const std::string& column, long empty, size_t rows);
std::string ColumnsArePartlyStated(const std::vector<std::string>& columns);
// shots: how many of all leave cells of the columns empty.
std::string RowsThatStateLessAreLeftOut(size_t shots, size_t all, const std::vector<std::string>& columns);
std::string ParametersAreHeld(const std::vector<std::string>& parameters);
std::string EffectsAreHeld(const std::vector<std::string>& effects);
// Of effects in whose place other values of stated ones would do, what their probabilities are given; "" where none is.
std::string GivenTheStated(const Robot& robot, const std::vector<FoundEffect>& effects);
// Another value of the stated effect explains what the found one does.
std::string StatedOneDoesAsWell(const EffectSpec& found, const EffectSpec& stated);

// Configurations that are fitted and held out; held out: none, or too few.
std::string FittedAndHeldOut(int configurations);
std::string NothingHeldOut();
std::string FewHeldOut(int configurations);
// Functions without a name were learnt, and nothing is held out.
std::string LearntUnchecked();

// Hold-out RMS against the noise floor, m.
std::string HoldoutFarAboveFloor(double rms, double floor);
std::string HoldoutBelowFloor(double rms, double floor);

// Effects given a rest without a name, each with its probability by the fitted rows.
std::string ToolMoved(const std::string& words);
// Why the intervals of an estimate with effects are wider.
std::string EffectsAreUndecided();
// instead: the effects of each other set that share the probability.
std::string IsOneOfSeveral(const std::vector<std::vector<EffectSpec>>& instead);
std::string ProbabilitiesAreRough();
std::string HalvesContradict(const std::vector<EffectSpec>& effects);
std::string LinksBendToo(const std::vector<EffectSpec>& effects);
// kelvin: by which the arm, of steel, was warmer if it was the arm.
std::string ScaleMayBeWarmth(const EffectSpec& scale, double kelvin);
std::string NotConfirmed(const Robot& robot, const std::vector<std::pair<EffectSpec, double>>& effects);
// Probable, and not in the most probable set; in it, and refused by the full model.
std::string NotInLeading(const Robot& robot, const std::vector<std::pair<EffectSpec, double>>& effects);
std::string NotInFullModel(const Robot& robot, const std::vector<std::pair<EffectSpec, double>>& effects);
// Of probabilities: averaged over so many resamples of the poses.
std::string AreBagged(int resamples);
// Of held-out configurations between the visits next to the moment of an effect.
std::string AreNextToAMoment(const std::vector<std::string>& configurations);

}  // namespace sagitta

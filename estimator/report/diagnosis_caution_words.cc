#include "estimator/report/diagnosis_caution_words.h"

#include <algorithm>
#include <cmath>

#include "estimator/diagnosis/diagnose.h"
#include "estimator/report/diagnosis_words.h"
#include "models/effects/catalogue.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr size_t kNamesListed = 6;

std::string Configurations(int count) {
  return count == 1 ? "1 configuration is" : std::to_string(count) + " configurations are";
}

std::string NameOnTarget(const EffectSpec& spec) {
  return spec.effect + (spec.target.empty() ? "" : " on " + spec.target);
}

std::string WithProbabilities(const Robot& robot, const std::vector<std::pair<EffectSpec, double>>& effects) {
  std::vector<std::string> names;
  for (const auto& [spec, probability] : effects) {
    names.push_back(Title(robot, spec) + " with " + Percent(probability));
  }
  return Enumerate(names, kNamesListed);
}

}  // namespace

std::string LookAtThisFirst(const Finding& finding) {
  return "Look at this first: " + finding.words + "; " + finding.remedy + ".";
}

std::string LookAtSuspectsFirst(const std::string& suspects) {
  return "Look at this first: " + suspects + "; correct these rows or leave them out, and diagnose again.";
}

std::string PriorsFirst(const std::string& conflict) {
  return "Look at this first: " + conflict + ", and diagnose again; what is found below may be its pull.";
}

std::string NoNoiseIsStated(bool rows_share_visits) {
  const std::string taken =
      rows_share_visits
          ? ": what the rows of one arrival share is assumed to be joint repeatability where that says more than any "
            "effect, and the rest of the scatter that the model leaves is assumed to be the instrument's noise"
          : " and nothing was measured twice: the scatter that the model leaves is assumed to be noise";
  return "No noise is stated" + taken +
         ". Structure in it is found, a gap without structure is not, and 'consistent' means no more than "
         "that. State sigma_mm, or measure some poses again.";
}

std::string MethodKeysUnused(const std::vector<std::string>& keys) {
  return "Not used by the diagnosis, which itself estimates the noise together with the effects: " +
         Enumerate(keys, kNamesListed) + ".";
}

std::string FewAreFitted(int configurations, int coordinates, int unknowns) {
  return "Only " + std::to_string(configurations) + " different configurations (" + std::to_string(coordinates) +
         " coordinates) are fitted, for " + std::to_string(unknowns) +
         " unknowns and the whole catalogue: most effects cannot be seen in them, and what is named may "
         "stand for something else. 40 configurations and more carry the search.";
}

std::string JointsStandStill(const std::vector<std::string>& joints, bool all) {
  return (all ? std::string("All configurations are alike: no joint moves")
              : Enumerate(joints, kNamesListed) + (joints.size() == 1 ? " hardly moves" : " hardly move")) +
         " (less than 5 deg or 50 mm): what depends on their position cannot be determined" +
         (all ? ", and the verdict holds for this one pose." : ".");
}

std::string JointsFollowTheOrder(const std::vector<std::string>& joints) {
  return Enumerate(joints, kNamesListed) + (joints.size() == 1 ? " follows" : " follow") +
         " the order of the rows, and no time is stated: if they were measured in this order, a drift looks like an "
         "error "
         "of a joint, also on the configurations held out. State time_s, or measure in random order.";
}

std::string PartlyStated(const std::string& column, long empty, size_t rows) {
  return column + " (" + std::to_string(empty) + " of " + std::to_string(rows) + " rows)";
}

std::string ColumnsArePartlyStated(const std::vector<std::string>& columns) {
  return "Columns that some rows do not state: " + Enumerate(columns, kNamesListed) +
         ". What they drive is looked for only where three shots of four, and half of those of each "
         "station, load and marker, state it: fill the cells, or leave those rows out.";
}

std::string RowsThatStateLessAreLeftOut(size_t shots, size_t all, const std::vector<std::string>& columns) {
  return "Left out for empty cells: " + std::to_string(shots) + " of " + std::to_string(all) + " shots (" +
         Enumerate(columns, kNamesListed) +
         "), so that what goes with these columns can be looked for. Fill the cells, or remove the rows before "
         "robot.extended.yaml is calibrated with them.";
}

std::string ParametersAreHeld(const std::vector<std::string>& parameters) {
  return "The believed model already has what these data do not determine (held: " +
         Enumerate(parameters, kNamesListed) +
         "): an effect that moves the markers like these cannot be distinguished from them.";
}

std::string EffectsAreHeld(const std::vector<std::string>& effects) {
  return "Held at the values of the robot file, and not looked for: " + Enumerate(effects, kNamesListed) +
         ". To ask for them, free them (estimate: {effects: all}) or remove them from the file.";
}

std::string GivenTheStated(const Robot& robot, const std::vector<FoundEffect>& effects) {
  std::string words;
  for (const FoundEffect& effect : effects) {
    std::vector<std::string> stated;
    for (const EffectSpec& spec : effect.stated_instead) stated.push_back(spec.target);
    if (stated.empty()) continue;
    const EffectSpec& found = effect.candidate.spec;
    words += " But the " + Percent(effect.probability) + " of " + ShortTitle(robot, found) +
             " hold if what the robot file states of " + found.effect + " on " + Enumerate(stated) +
             " is right: other values of that explain as much.";
  }
  return words;
}

std::string StatedOneDoesAsWell(const EffectSpec& found, const EffectSpec& stated) {
  return "What " + found.Path() + " explains, other values of " + stated.Path() +
         ", which the robot file states and which are believed, explain as well: are the stated ones right? To ask the "
         "rows, free them (estimate: {effects: all}); the probability of " +
         found.Path() + " holds where they are.";
}

std::string FittedAndHeldOut(int configurations) {
  return Configurations(configurations) +
         " fitted and held out at once (equal joint values under different names): the "
         "hold-out figures are too good by their share. Hold out whole configurations.";
}

std::string NothingHeldOut() {
  return "Nothing is held out: whether the gap shrinks on data that were not used in the fit is not known, and an "
         "effect that is named together with something without a name may be a description of it.";
}

std::string LearntUnchecked() {
  return "Functions were learnt by what the fitted configurations say of each other; none is held out that could "
         "refute them. Measure some configurations more and give the learnt robot to sagitta validate before it is "
         "used.";
}

std::string FewHeldOut(int configurations) {
  return "Only " + Configurations(configurations) + " held out: the gap figures are hardly more than an example.";
}

std::string HoldoutFarAboveFloor(double rms, double floor) {
  return "The hold-out RMS, " + InMillimetres(rms) + ", is " + Significant(rms / floor, 2) +
         " times what noise and parameters explain: the fitted configurations do not determine what the held-out ones "
         "need.";
}

std::string HoldoutBelowFloor(double rms, double floor) {
  return "The noise floor, " + InMillimetres(floor) + ", is above the hold-out RMS, " + InMillimetres(rms) +
         ": these rows scatter less than the noise that is assumed, and how much of the gap is closed is an upper "
         "limit.";
}

std::string ToolMoved(const std::string& words) { return "Look at this first: " + words + "."; }

std::string EffectsAreUndecided() { return "the data do not decide which effects the robot has"; }

std::string IsOneOfSeveral(const std::vector<std::vector<EffectSpec>>& instead) {
  std::vector<std::string> sets;
  for (const std::vector<EffectSpec>& set : instead) {
    std::vector<std::string> names;
    for (const EffectSpec& spec : set) names.push_back(NameOnTarget(spec));
    sets.push_back(names.empty() ? "none of some of them" : Enumerate(names, kNamesListed));
  }
  return "The results hold the effects that are found, and the data do not decide for them against others: with " +
         Enumerate(sets, kNamesListed) +
         " in place of them the rows fit nearly as well. The intervals of the estimate, and those of what it predicts, "
         "allow for "
         "that choice.";
}

std::string ProbabilitiesAreRough() {
  return "Effects are so large that the linear model by which everything was weighed is wrong for them, also about "
         "what was found: the probabilities are rough. Bring the robot nearer to its nominal model, or add to it what "
         "is known, and diagnose again.";
}

std::string HalvesContradict(const std::vector<EffectSpec>& effects) {
  std::vector<std::string> names;
  for (const EffectSpec& spec : effects) names.push_back(NameOnTarget(spec));
  return "Two disjoint halves of the poses contradict each other on the values of " + Enumerate(names, kNamesListed) +
         ": something else, or something more, is at work there. The intervals do not allow for that.";
}

std::string LinksBendToo(const std::vector<EffectSpec>& effects) {
  std::vector<std::string> names;
  for (const EffectSpec& spec : effects) names.push_back(NameOnTarget(spec));
  return "All fitted rows carry the same load, and the weights of the links, which bend the arm as well, are not in "
         "the "
         "model: the values of " +
         Enumerate(names, kNamesListed) +
         " hold for this load and may be too large for another. Measure some poses with another load or with none.";
}

std::string ScaleMayBeWarmth(const EffectSpec& scale, double kelvin) {
  return NameOnTarget(scale) + ": an arm of steel that was " + Significant(std::abs(kelvin), 2) + " K " +
         (kelvin > 0.0 ? "warmer" : "colder") +
         " while this station measured moves the points alike, and no row states a temperature. Whether "
         "corrected targets are right depends on which of the two it was: state temperature_degC.";
}

std::string NotConfirmed(const Robot& robot, const std::vector<std::pair<EffectSpec, double>>& effects) {
  return WithProbabilities(robot, effects) + (effects.size() == 1 ? " is" : " are") +
         " not named: where something without a name may be left, an effect is named only if it predicts rows "
         "that were not fitted better, beyond chance.";
}

std::string NotInLeading(const Robot& robot, const std::vector<std::pair<EffectSpec, double>>& effects) {
  const bool is_one = effects.size() == 1;
  return WithProbabilities(robot, effects) + (is_one ? " is" : " are") +
         " probable and not named: " + (is_one ? "it is" : "they are") +
         " in most of the answers that share the probability, and not in the one that is most probable as a whole.";
}

std::string NotInFullModel(const Robot& robot, const std::vector<std::pair<EffectSpec, double>>& effects) {
  return WithProbabilities(robot, effects) + (effects.size() == 1 ? " is" : " are") +
         " probable and not named: the full model with it found no optimum, values that may be chance, or rows that "
         "were not fitted predicted worse.";
}

std::string AreNextToAMoment(const std::vector<std::string>& configurations) {
  return "Held out, but in no figure: " + Enumerate(configurations, kNamesListed) +
         ", measured between the two fitted " +
         "visits next to the moment of an effect: nothing says whether before it or after.";
}

std::string AreBagged(int resamples) {
  return "Probabilities are averaged over the poses and " + std::to_string(resamples) +
         " resamples of them (bagged): something without a name is left, and then those of the poses as they "
         "are would be too sure.";
}

std::string MostIsOf(const std::vector<std::string>& configurations) {
  return "More than half of what is left is of " + Enumerate(configurations, kNamesListed) +
         ": check the joint values and the rows there before a cause is looked for.";
}

std::string NotTestedInWords(const Diagnosis& d) {
  const Robot& robot = d.final.problem->robot();
  std::vector<std::string> parts;
  const auto add = [&](Lack lack, bool with_targets, const std::string& why) {
    std::vector<std::string> titles, targets;
    const auto add_once = [](const std::string& name, std::vector<std::string>* names) {
      if (std::find(names->begin(), names->end(), name) == names->end()) names->push_back(name);
    };
    for (const NotTestable& entry : d.not_testable) {
      if (entry.lack != lack) continue;
      const EffectDefinition* definition = FindEffect(robot, entry.effect);
      add_once(definition == nullptr ? "gravity compensator" : definition->title, &titles);
      add_once(entry.target, &targets);
    }
    if (titles.empty()) return;
    parts.push_back(Enumerate(titles) + (with_targets ? " on " + Enumerate(targets, kNamesListed) : "") + ", " + why);
  };
  add(Lack::kCompliance, true,
      "for neither robot file nor loaded rows show the joint's compliance (state it, or measure with a load)");
  add(Lack::kTime, false, "for want of times");
  add(Lack::kTemperature, false, "for want of temperatures");
  add(Lack::kApproach, true, "for want of approach directions");
  return parts.empty() ? "" : "Not tested: " + Joined(parts, "; ") + ".";
}

std::string PhysicalInWords(const PhysicalBounds& bounds) {
  const auto compliance = [](double k) {
    const QuantityTraits& traits = TraitsOf(Quantity::kCompliance);
    return Significant(k / traits.si_per_unit, 3) + " " + traits.unit;
  };
  const std::string weighs = "it would weigh " + Significant(bounds.found, 3) + " kg, and " +
                             Significant(bounds.stated, 3) + " kg are stated: ";
  switch (bounds.kind) {
    case PhysicalBounds::Kind::kUsual:
      break;
    case PhysicalBounds::Kind::kCorrection:
      return "it corrects the robot file: " + compliance(bounds.stated) + " there, " + compliance(bounds.found) +
             " found";
    case PhysicalBounds::Kind::kNegative:
      return "the sign is not physical: read it as a description, not as a cause";
    case PhysicalBounds::Kind::kTooLarge:
      return "the size is not physical: read it as a description, not as a cause";
    case PhysicalBounds::Kind::kMoreThanLoad:
      return weighs + "no error of weighing. Check the stated loads and their units";
    case PhysicalBounds::Kind::kLoadsExchanged:
      return weighs + "with its mass and that of " + bounds.other + " exchanged the rows would fit";
    case PhysicalBounds::Kind::kAboutItsPoint:
      return "it cancels the stated load point: the moments may be stated about the flange, with the force's in them";
  }
  return "the size is one that machines show";
}

}  // namespace sagitta

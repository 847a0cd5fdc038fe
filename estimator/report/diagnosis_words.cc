#include "estimator/report/diagnosis_words.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "estimator/diagnosis/learnt_model.h"
#include "estimator/estimate/parameter_table.h"
#include "estimator/explanations/compensator_shapes.h"
#include "estimator/report/diagnosis_caution_words.h"
#include "estimator/report/diagnosis_gap_words.h"
#include "estimator/report/diagnosis_next_words.h"
#include "estimator/report/diagnosis_noise_words.h"
#include "estimator/report/explanations_words.h"
#include "estimator/report/inspection_words.h"
#include "models/effects/catalogue.h"
#include "models/gravity_compensator.h"
#include "problems/io/units.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr double kWorthSaying = 0.1;  // of the probability, where nothing is named
constexpr double kIsDecided = 0.95;   // all else has a twentieth
constexpr size_t kMostLikely = 3;
constexpr double kLeastSaid = 0.01;       // of the probability of a set
constexpr double kDoTheSame = 0.9999;     // overlap: of what the one moves, the other leaves a hundredth
constexpr size_t kMostNames = 3;          // of what another prior would name
constexpr size_t kMostCausesInWords = 4;  // of a verdict: with its first line five
constexpr size_t kMostTargets = 6;        // named of one cause
constexpr size_t kMostEffects = 5;        // listed one by one on a terminal

// definition: null for the compensator, which has no settings.
std::string SettingsInWords(const EffectDefinition* definition, const EffectSpec& spec) {
  std::string words;
  for (const auto& [name, text] : spec.settings) {
    const bool is_moment =
        definition != nullptr && std::any_of(definition->settings.begin(), definition->settings.end(),
                                             [&name = name](const SettingDefinition& setting) {
                                               return setting.kind == SettingDefinition::Kind::kMoment &&
                                                      setting.name == name;
                                             });
    words += is_moment ? ", " + std::to_string(std::lround(ParseNumber(text).value())) + " s after the first row"
                       : ", " + name + " " + text;
  }
  return words;
}

std::string HoldoutInWords(const Estimate& estimate) {
  if (estimate.validation.observations == 0) return "no hold-out";
  return "hold-out RMS " + Significant(1e3 * estimate.validation.rms, 3) + " mm";
}

// 210 ± 8 urad, or 7.55 (6.21 to 8.21) ppm/K where the arms of the interval differ.
std::string WithInterval(const ParameterEstimate& row) {
  const QuantityTraits& traits = TraitsOf(row.quantity);
  const double half = 0.5 * (row.ci95.high - row.ci95.low);  // the last digit is a tenth of it or less
  const double ratio = half > 0.0 ? std::abs(row.value) / half : 1.0;
  const int digits = std::max(3, 1 + static_cast<int>(std::ceil(std::log10(std::max(1.0, ratio)))));
  const auto shown = [&](double value) { return Significant(value / traits.si_per_unit, digits); };
  const auto width = [&](double value) { return Significant(value / traits.si_per_unit, 3); };
  const std::string interval = IsEven(row) ? " ± " + width(row.ci95.high - row.value)
                                           : " (" + shown(row.ci95.low) + " to " + shown(row.ci95.high) + ")";
  return shown(row.value) + interval + " " + traits.unit;
}

std::string LagInWords(const PossibleNumbers& lag) {
  const auto minutes = [](double seconds) { return Fixed(seconds / 60.0, 0); };
  return "Here the arm may follow the thermometer " + minutes(lag.least) + " to " + minutes(lag.most) +
         " min late, best " + minutes(lag.best) +
         (lag.is_timed ? "" : ", if the rows stand in the order of measuring, one shot a minute") +
         "; the interval allows for that, the value does not.";
}

// "These data allow width_deg 12 to 24.1"
std::string NumbersInWords(const PossibleNumbers& numbers) {
  if (numbers.is_thermal_lag) return LagInWords(numbers);
  const auto shown = [](double number) { return Significant(number, 3); };
  std::string words = "These data allow " + numbers.setting + " ";
  if (numbers.is_open_below && numbers.is_open_above) {
    words += "from " + shown(numbers.least) + " to " + shown(numbers.most) + " and beyond: they do not determine it";
  } else if (numbers.is_open_below) {
    words += "up to " + shown(numbers.most) + " only";
  } else if (numbers.is_open_above) {
    words += "from " + shown(numbers.least) + " on";
  } else {
    words += "from " + shown(numbers.least) + " to " + shown(numbers.most);
  }
  return words + " (95 %); the interval allows for that.";
}

// Of the squared gap on untouched rows: those of the groups add up to what is closed of it.
std::string ShareOfGap(const Diagnosis& d, double share) {
  const bool is_known = !std::isnan(d.gap.closed);
  if (d.gap.before == 0.0 || MayBeAnyShare(d.gap)) return "";
  const std::string whole = is_known ? " % of the gap" : " % of what is explained";
  if (!std::isfinite(share) || (is_known && !(d.gap.closed > 0.0))) return "";
  return share > 0.0 ? Significant(100.0 * share, 2) + whole : "no gain on untouched rows";
}

double LeastProbability(const Diagnosis& d, const EffectGroup& group) {
  double least = 1.0;
  for (const int k : group.effects) least = std::min(least, d.effects[static_cast<size_t>(k)].probability);
  return least;
}

// "gear ripple on j1, j2 and j3, each 98 % or more: 60 % of the gap"; one effect by its full name.
std::string CauseInWords(const Diagnosis& d, const EffectGroup& group) {
  const bool is_one = group.effects.size() == 1;
  const FoundEffect& first = d.effects[static_cast<size_t>(group.effects.front())];
  std::string words = is_one ? Title(d.final.problem->robot(), first.candidate.spec) : GroupInWords(d, group);
  const double least = LeastProbability(d, group);
  words += is_one ? ", " + Percent(least) : ", each " + Percent(least) + (IsNearlyCertain(least) ? "" : " or more");
  std::string share = ShareOfGap(d, group.share_of_gap);
  if (!share.empty() && group.share_of_gap <= 0.0) share = "no gain on untouched rows";
  return d.effects.size() > 1 && !share.empty() ? words + ": " + share : words;
}

std::vector<EffectGroup> EffectGroupsOf(const Diagnosis& d) {
  if (!d.groups.empty()) return d.groups;
  std::vector<EffectGroup> groups;  // not grouped yet: each effect by itself
  for (size_t k = 0; k < d.effects.size(); ++k)
    groups.push_back({d.effects[k].candidate.spec.effect, {static_cast<int>(k)}, kNotKnown});
  return groups;
}

// At most kMostCausesInWords; the last has what is left.
std::vector<std::string> CausesInWords(const Diagnosis& d) {
  std::vector<EffectGroup> groups = EffectGroupsOf(d);
  while (groups.size() > kMostCausesInWords) {
    const EffectGroup last = groups.back();
    groups.pop_back();
    EffectGroup& rest = groups.back();
    rest.effect = "others";
    rest.effects.insert(rest.effects.end(), last.effects.begin(), last.effects.end());
    rest.share_of_gap += last.share_of_gap;
  }
  std::vector<std::string> causes;
  for (const EffectGroup& group : groups) causes.push_back(CauseInWords(d, group));
  return causes;
}

// What explains the rows and can hardly be their cause.
std::string ImplausibleInWords(const Diagnosis& d) {
  std::string words;
  for (const FoundEffect& effect : d.effects) {
    if (effect.bounds.IsPlausible()) continue;
    words += " But " + ShortTitle(d.final.problem->robot(), effect.candidate.spec) + ": " +
             PhysicalInWords(effect.bounds) + ".";
  }
  return words;
}

// Of what is named together, that it is not all; "" where that is less than even odds.
std::string MoreInWords(const Diagnosis& d) {
  double more = 0.0;
  for (const NamedSet& set : d.posterior.sets) {
    if (set.specs.size() + set.unnamed.size() > d.effects.size()) more += set.probability;
  }
  if (more <= kEvenOdds) return "";
  const auto is_named = [&d](const EffectSpec& spec) {
    return std::any_of(d.effects.begin(), d.effects.end(),
                       [&](const FoundEffect& effect) { return effect.candidate.spec.Path() == spec.Path(); });
  };
  std::string words = "There is probably more (" + Percent(more) + ")";
  for (const auto& [spec, probability] : d.posterior.explanations) {
    if (is_named(spec)) continue;
    if (probability >= kWorthSaying)
      words += ", most likely " + Title(d.baseline.problem->robot(), spec) + " with " + Percent(probability);
    break;
  }
  return words + ", but these data do not show it surely enough to name it.";
}

std::string RestInWords(const Diagnosis& d) {
  const std::string given = GivenTheStated(d.final.problem->robot(), d.effects);
  if (d.verdict == DiagnosisVerdict::kExplained) {
    const std::string more = MoreInWords(d);
    return (more.empty() ? "Nothing significant is left." : more) + ImplausibleInWords(d) + given;
  }
  const std::string share = std::isnan(d.gap.closed) ? "" : ShareOfGap(d, 1.0 - d.gap.closed);
  return "A significant rest has no name in the catalogue" + (share.empty() ? "" : " (" + share + ")") + "." + given;
}

// That no effect of the catalogue explains a gap well; or not as probably.
std::string NoEffectInWords(const Diagnosis& d) {
  const auto& sets = d.posterior.sets;  // the most probable first
  const auto named = std::find_if(sets.begin(), sets.end(),
                                  [](const NamedSet& set) { return set.unnamed.empty() && !set.specs.empty(); });
  if (named != sets.end() && named->probability >= kLeastSaid) {
    return ", most probably of a cause without a name (" + Percent(d.posterior.unnamed) +
           "); effects of the catalogue would explain it as well: " +
           WithOneAnother(NamesOf(d.baseline.problem->robot(), *named)) + " (" + Percent(named->probability) + ").";
  }
  return d.gap.before == 0.0 ? ", and no effect of the catalogue explains it well."
                             : " that no effect of the catalogue explains well.";
}

// What was fitted needs no cause, and something is off all the same.
std::string NothingFitsInWords(const Diagnosis& d) {
  const std::string nothing = " (nothing missing " + Percent(d.posterior.nothing) + ")";
  return d.gap.before == 0.0
             ? "The rows scatter more than the noise that is assumed, and no cause that is weighed is probable" +
                   nothing + "."
             : "There is a significant gap on untouched configurations, and no cause that is weighed is probable by "
               "what was fitted" +
                   nothing + ". Look at the largest residuals of the rows held out (residuals.csv).";
}

// Nothing fits, or too much does.
std::string UnknownInWords(const Diagnosis& d) {
  const std::string there_is = d.gap.before == 0.0
                                   ? "The fitted rows say that something is missing, the untouched ones show no gap"
                                   : "There is a significant gap";
  const Robot& robot = d.baseline.problem->robot();
  std::vector<std::string> likely;
  std::vector<std::string> sure;
  for (const auto& [spec, probability] : d.posterior.explanations) {
    const std::string said = Title(robot, spec) + " " + Percent(probability);
    if (probability >= kWorthSaying && likely.size() < kMostLikely) likely.push_back(said);
    if (probability > kIsDecided) sure.push_back(said);
  }
  if (!sure.empty()) {
    return there_is + ". By the rows that were fitted it is " + Enumerate(sure) +
           "; that is not named, for the full model or untouched rows do not confirm it (see the cautions).";
  }
  if (likely.empty() && d.posterior.nothing > std::max(d.posterior.unnamed, d.posterior.noise)) {
    return NothingFitsInWords(d);
  }
  if (likely.empty() && d.posterior.noise > d.posterior.unnamed) {
    return there_is + ", most probably noise other than stated (" + Percent(d.posterior.noise) +
           "; see below), next a cause without a name (" + Percent(d.posterior.unnamed) + ").";
  }
  const bool is_said_alone = likely.empty() && d.posterior.noise < kWorthSaying;
  if (is_said_alone || d.posterior.unnamed > kEvenOdds) return there_is + NoEffectInWords(d);
  likely.push_back("what has no name " + Percent(d.posterior.unnamed));
  if (d.posterior.nothing >= kWorthSaying) likely.push_back("nothing missing " + Percent(d.posterior.nothing));
  if (d.posterior.noise >= kWorthSaying) likely.push_back("noise other than stated " + Percent(d.posterior.noise));
  return there_is + ", and these data do not decide what it is: " + Joined(likely, ", ") + ".";
}

// No pose, load or marker like these distinguishes them.
std::string SeparateByKnowledge() {
  return "what is known from elsewhere (a part that is weighed, a length or a rate that is measured): in these rows "
         "the "
         "two do the same, and at poses and loads like these they predict the same";
}

}  // namespace

bool IsNearlyCertain(double probability) { return probability > 0.9995; }

std::string Percent(double probability) {
  if (IsNearlyCertain(probability)) return "above 99.9 %";
  return Significant(100.0 * probability, probability > 0.9 ? 3 : 2) + " %";
}

std::string Title(const Robot& robot, const EffectSpec& spec) {
  const EffectDefinition* definition = FindEffect(robot, spec.effect);
  const char* spring = IsNewSpring(spec) ? "gravity compensator" : "gravity compensator not as stated";
  const std::string title = definition == nullptr ? spring : definition->title;
  return title + " (" + spec.effect + ", " + spec.target + SettingsInWords(definition, spec) + ")";
}

std::string ShortTitle(const Robot& robot, const EffectSpec& spec) {
  return spec.target + " " + spec.effect + SettingsInWords(FindEffect(robot, spec.effect), spec);
}

std::string VerdictInWords(const Diagnosis& d) {
  const double something = 1.0 - d.posterior.nothing - d.posterior.noise;
  if (d.verdict == DiagnosisVerdict::kConsistent && something > kEvenOdds) {
    return "Something is probably missing (" + Percent(something) +
           "), but these data do not show it surely enough to name it.";
  }
  if (d.verdict == DiagnosisVerdict::kConsistent) {
    return d.cautions.empty() ? "Nothing is missing at this significance."
                              : "Nothing is missing at this significance, as far as these data show: see the cautions.";
  }
  if (d.verdict == DiagnosisVerdict::kNoise) {
    const bool is_by_misfit = d.noise.scale_differs && d.posterior.noise < kEvenOdds;
    return (is_by_misfit
                ? "No effect is probable, and these readings scatter more than the noise as stated makes them: "
                : "No effect is missing; ") +
           WrongNoiseInWords(d.noise) + ".";
  }
  if (d.verdict != DiagnosisVerdict::kExplained && d.verdict != DiagnosisVerdict::kPartly) return UnknownInWords(d);
  return "Found: " + Joined(CausesInWords(d), "; ") + ". " + RestInWords(d);
}

std::vector<std::string> VerdictLines(const Diagnosis& d) {
  const std::vector<std::string> causes = d.effects.empty() ? std::vector<std::string>() : CausesInWords(d);
  if (causes.size() < 2) return {VerdictInWords(d)};
  std::vector<std::string> lines = {"Found " + std::to_string(d.effects.size()) + " effects. " + RestInWords(d)};
  for (const std::string& cause : causes) lines.push_back("- " + cause);
  return lines;
}

bool IsDetermined(const FoundEffect& effect, const ParameterEstimate& row) {
  const std::vector<std::string>& poorly_determined = effect.candidate.poorly_determined;
  return std::find(poorly_determined.begin(), poorly_determined.end(), row.name) == poorly_determined.end();
}

// Of a spring that the robot file does not state: only ratios of its lengths are determined.
std::string GaugeInWords(const EffectSpec& spec) {
  if (spec.effect != kGravityCompensator || spec.values.empty()) return "";
  return " All for L = " + Significant(1e3 * spec.values[0], 3) +
         " mm: c times as long in every length, with Kc / c^2, it has the same torque.";
}

std::string EffectInWords(const Robot& robot, const FoundEffect& effect) {
  std::string words = Title(robot, effect.candidate.spec) + ", " + Percent(effect.probability) + ":";
  const std::vector<std::string>& poorly_determined = effect.candidate.poorly_determined;
  size_t shown = 0;
  for (const ParameterEstimate& row : effect.parameters) {
    if (!IsDetermined(effect, row)) continue;
    ++shown;
    words += " " + row.name.substr(row.name.rfind('/') + 1) + " " + WithInterval(row) + ",";
  }
  words.back() = ';';
  if (!poorly_determined.empty()) {
    const std::string count = std::to_string(poorly_determined.size());
    words += shown > 0                       ? " " + count + " more that these data do not determine;"
             : poorly_determined.size() == 1 ? " these data do not determine its value;"
                                             : " these data determine none of its " + count + " values by itself;";
  }
  if (std::isfinite(effect.holdout_after)) {
    const bool is_change = std::isfinite(effect.holdout_before);
    words += " hold-out RMS " + (is_change ? Significant(1e3 * effect.holdout_before, 3) + " -> " : "") +
             Significant(1e3 * effect.holdout_after, 3) + " mm.";
  } else {
    words.back() = '.';
  }
  const EffectDefinition* definition = FindEffect(robot, effect.candidate.spec.effect);
  if (definition != nullptr && !definition->note.empty()) words += " " + definition->note;
  words += GaugeInWords(effect.candidate.spec);
  if (effect.numbers) words += " " + NumbersInWords(*effect.numbers);
  return words;
}

std::string AlternativeInWords(const Robot& robot, const Alternative& alternative) {
  return Title(robot, alternative.spec) + ", " + Percent(alternative.probability) + "; it would explain " +
         Significant(100 * alternative.overlap, 3) + " % of the same";
}

std::string SeparateBy(const Robot& robot, const Alternative& alternative) {
  if (alternative.overlap >= kDoTheSame) return SeparateByKnowledge();
  const EffectSpec& spec = alternative.spec;
  const EffectDefinition* definition = FindEffect(robot, spec.effect);
  // The compensator, whose home is the robot: as a weight.
  std::string words = definition == nullptr ? kSeparateByWeight : definition->separate_by;
  const std::string place = "{target}";
  const size_t at = words.find(place);
  return at == std::string::npos ? words : words.replace(at, place.size(), spec.target);
}

std::string HalvesInWords(const Confirmation& confirmation) {
  if (confirmation.halves.size() < 2) return "Too few poses to compare two halves.";
  std::string words =
      "On two disjoint halves of the poses, each by itself: " + Percent(confirmation.halves[0].probability) + " and " +
      Percent(confirmation.halves[1].probability);
  const double p = confirmation.compatible_p;
  if (std::isnan(p)) return words + ".";
  const std::string values = p < kHalvesContradict ? "contradict each other"
                             : p < kHalvesDiffer   ? "differ more than noise usually has it"
                                                   : "agree";
  return words + "; the values " + values + " (p " + Significant(p, 3) + ").";
}

// Without what is scanned or tuned: the list's value need not be the one that was found.
NamedSet WithoutNumbers(const Robot& robot, NamedSet set) {
  for (EffectSpec& spec : set.specs) {
    const EffectDefinition* definition = FindEffect(robot, spec.effect);
    if (definition == nullptr) continue;
    for (const SettingDefinition& setting : definition->settings) {
      const bool is_number =
          setting.kind == SettingDefinition::Kind::kNumber || setting.kind == SettingDefinition::Kind::kMoment;
      if (is_number) spec.settings.erase(setting.name);
    }
  }
  return set;
}

std::string FlipInWords(const Robot& robot, const ReportedFlip& flip) {
  const auto listed = [&](const NamedSet& set) {
    const std::vector<std::string> names = NamesOf(robot, WithoutNumbers(robot, set));
    return names.empty() ? "" : Enumerate(names, kMostNames);
  };
  const std::string more = listed(flip.more), fewer = listed(flip.fewer);
  const std::string prior =
      "With a prior of '" + flip.mass + "' three times as " + (flip.is_larger ? "large" : "small") + ": ";
  if (!flip.is_something) return prior + "nothing is missing.";
  if (more.empty() && fewer.empty()) return prior + "something without a name.";
  if (fewer.empty()) return prior + "also " + more + ".";
  return prior + (more.empty() ? "without " + fewer : more + " instead of " + fewer) + ".";
}

std::string GroupInWords(const Diagnosis& d, const EffectGroup& group) {
  std::vector<std::string> targets;
  for (const int k : group.effects) {
    const std::string& target = d.effects[static_cast<size_t>(k)].candidate.spec.target;
    if (std::find(targets.begin(), targets.end(), target) == targets.end()) targets.push_back(target);
  }
  const EffectDefinition* definition = FindEffect(d.final.problem->robot(), group.effect);
  const std::string title = definition != nullptr                 ? definition->title
                            : group.effect == kGravityCompensator ? "gravity compensator"
                                                                  : "other effects";
  return title + " on " + Enumerate(targets, kMostTargets);
}

std::string UnexplainedInWords(const Diagnosis& d) {
  const LearntFunction& learnt = d.unexplained;
  if (learnt.what.acts_on.empty() || learnt.probability < kWorthSaying) return "no driving variable stands out";
  std::string words = (learnt.probability > kEvenOdds ? "" : "perhaps ") + learnt.what.words;
  if (!IsNearlyCertain(learnt.probability)) words += " (" + Percent(learnt.probability) + ")";
  if (!learnt.words.empty()) words += ": " + learnt.words;
  for (const EffectSpec& piece : learnt.pieces) {  // settings of one effect read alike
    const std::string like = "; " + PartlyLike(piece.effect, piece.target);
    if ((words + ";").find(like + ";") == std::string::npos) words += like;
  }
  const bool is_seen = d.learnt || !d.has_unexplained;
  return is_seen ? words : words + "; it was not seen to predict rows that it was not learnt from";
}

std::string LearntInWords(const Diagnosis& d) {
  const Robot& robot = d.final.problem->robot();
  std::vector<std::string> names;  // of effects that are not sure enough to be named
  size_t count = 0;
  for (const EffectSpec& spec : d.learnt->functions) {
    const EffectDefinition* definition = FindEffect(robot, spec.effect);
    const bool is_function = definition != nullptr && definition->is_learnt;
    count += is_function ? 1 : 0;
    if (!is_function) names.push_back(ShortTitle(robot, spec));
  }
  const std::string functions = std::to_string(count) + (count == 1 ? " smooth function" : " smooth functions");
  const std::string effects = Enumerate(names, kMostNames) + ", not sure enough to be named,";
  return "With " +
         (names.empty() ? functions
          : count == 0  ? effects
                        : functions + " and " + effects) +
         " learnt from the rows (" + kLearntFile + "): " + HoldoutInWords(d.learnt->model.estimate) + "; " +
         ClosedInWords(d.learnt->gap) +
         ". They describe and name no cause, and say nothing beyond the measured ranges.";
}

std::string ShareInWords(const WhereShare& share) {
  return Significant(100 * share.share, 3) + " % of the excess is at " + share.by + " " + share.key;
}

std::string DiagnosisToText(const Diagnosis& d) {
  std::ostringstream text;
  const Robot& robot = d.final.problem->robot();
  const Estimate& before = d.baseline.estimate;
  const Estimate& after = d.final.estimate;
  for (const std::string& warning : d.baseline.problem->data().warnings) text << "Warning: " << warning << "\n";
  const auto others = d.cautions.begin() + static_cast<long>(d.read_first);
  for (auto caution = d.cautions.begin(); caution != others; ++caution) text << "Caution: " << *caution << "\n";
  if (text.tellp() > 0) text << "\n";
  text << "Verdict: " << WordOf(d.verdict) << ".";
  for (const std::string& line : VerdictLines(d)) text << " " << line << "\n";
  text << "\n";
  text << "Baseline: " << FitInWords(d, before) << ", " << HoldoutInWords(before) << "\n";
  for (size_t i = 0; i < std::min(kMostEffects, d.effects.size()); ++i) {
    text << "Effect " << i + 1 << ": " << EffectInWords(robot, d.effects[i]) << "\n";
    text << "    " << HalvesInWords(d.effects[i].confirmation) << "\n";
    const PhysicalBounds& bounds = d.effects[i].bounds;
    if (bounds.kind != PhysicalBounds::Kind::kUsual) text << "    " << PhysicalInWords(bounds) << "\n";
    for (const Alternative& alternative : d.effects[i].alternatives) {
      text << "    or " << Title(robot, alternative.spec) << " (overlap " << Significant(alternative.overlap, 3) << ", "
           << Percent(alternative.probability) << "); separate by " << SeparateBy(robot, alternative) << "\n";
    }
  }
  if (d.effects.size() > kMostEffects)
    text << d.effects.size() - kMostEffects << " more effects: in report.html and diagnosis.json\n";
  const std::string noise = NoiseOfFinalInWords(d);
  text << "Final: " << FitInWords(d, after) << (noise.empty() ? "" : " " + noise) << ", " << HoldoutInWords(after);
  const bool is_held_out = after.validation.observations > 0;
  if (is_held_out && !std::isnan(d.gap.floor)) {
    text << ", noise floor " << Significant(1e3 * d.gap.floor, 3) << " mm";
    if (d.gap.floor_is_as_stated) text << " (" << FloorGoesByStatedNoise() << ")";
  }
  text << "\n";
  if (is_held_out || !std::isnan(d.gap.before)) text << GapInWords(d);
  text << "Noise: " << NoiseInWords(d.noise) << "\n";
  if (d.has_unexplained) text << "Unexplained: " << UnexplainedInWords(d) << "\n";
  if (d.learnt) text << "Learnt: " << LearntInWords(d) << "\n";
  if (d.next)
    text << "Next: " << NextInWords(*d.final.problem, *d.next, d.verdict == DiagnosisVerdict::kConsistent) << "\n";
  const std::string not_tested = NotTestedInWords(d);
  if (!not_tested.empty()) text << not_tested << "\n";
  for (const ReportedFlip& flip : d.posterior.flips) text << "Prior: " << FlipInWords(robot, flip) << "\n";
  for (auto caution = others; caution != d.cautions.end(); ++caution) text << "Caution: " << *caution << "\n";
  const std::string unread = NotReadInWords(d.baseline.problem->data().unread_columns);
  if (!unread.empty()) text << unread << "\n";
  return text.str();
}

}  // namespace sagitta

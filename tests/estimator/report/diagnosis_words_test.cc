// What a diagnosis says first: five lines at most, causes by group with their share of the gap.
#include "estimator/report/diagnosis_words.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>

#include "estimator/diagnosis/cautions.h"
#include "estimator/diagnosis/learnt_model.h"
#include "estimator/report/diagnosis_caution_words.h"
#include "estimator/report/diagnosis_gap_words.h"
#include "estimator/report/diagnosis_next_words.h"
#include "estimator/report/diagnosis_noise_words.h"
#include "problems/loads.h"
#include "tests/support/kr270_experiment.h"
#include "tests/support/loaded_kr270.h"
#include "tests/support/moved_kr270.h"

namespace sagitta::diagnosis_words_test {
namespace {

using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

FoundEffect Found(const std::string& effect, const std::string& target, double probability) {
  FoundEffect found;
  found.candidate.spec = {effect, target, {}, {}};
  if (effect == "joint_harmonic") found.candidate.spec.settings["order"] = "1";
  found.probability = probability;
  return found;
}

// 41 uses of six effects on a robot whose gap is closed by 90 %.
Diagnosis Large() {
  Diagnosis d;
  d.verdict = DiagnosisVerdict::kPartly;
  d.status = Status::kConverged;
  const test::Kr270Design design;
  d.final.problem = std::make_shared<CalibrationProblem>(test::Kr270Problem(design, test::Kr270Truth(), 1));
  d.baseline.problem = d.final.problem;
  d.has_unexplained = true;
  const std::vector<std::string> effects = {"joint_harmonic", "encoder_gain",   "link_gravity",
                                            "axis_wobble",    "thermal_growth", "station_scale"};
  for (int k = 0; k < 41; ++k) {
    const size_t g = std::min<size_t>(k / 8, effects.size() - 1);
    if (g == d.groups.size()) d.groups.push_back({effects[g], {}, 0.45 / (1 << g)});  // they add up to what is closed
    d.groups[g].effects.push_back(k);
    d.effects.push_back(Found(effects[g], "A" + std::to_string(k % 6 + 1), 0.99 - 0.001 * k));
  }
  d.gap.before = 2e-4;
  d.gap.after = 6e-5;
  d.gap.closed = 0.9;
  return d;
}

// 0.004 of two effects is what one of a hundred diagnoses of two has by chance, 0.006 is not rare enough.
TEST(DiagnosisWords, HalvesThatContradictEachOtherAreACaution) {
  std::vector<FoundEffect> effects = {Found("warm_up", "S1", 0.99), Found("encoder_gain", "A4", 0.99)};
  effects[0].confirmation.compatible_p = 0.006;
  effects[1].confirmation.compatible_p = kNotKnown;
  std::vector<std::string> cautions;
  CautionOfHalves(effects, &cautions);
  EXPECT_TRUE(cautions.empty());
  effects[0].confirmation.compatible_p = 0.004;
  CautionOfHalves(effects, &cautions);
  ASSERT_EQ(cautions.size(), 1u);
  EXPECT_THAT(cautions[0], AllOf(HasSubstr("contradict"), HasSubstr("warm_up on S1"), Not(HasSubstr("A4"))));
}

// The rows of the KR 270 are unloaded and under 250 kg; under 250 kg alone its links bend it as its load does.
TEST(DiagnosisWords, ACompliancesOneLoadIsACaution) {
  const test::LoadedTruth truth;
  Measurements data = test::LoadedRows(test::LoadedDesign(), truth);
  test::Measure(test::ExactPoints(truth, data), 3e-5, 1, &data);
  const test::LoadedSetup setup = test::SetupFor(truth);
  CalibrationProblem problem = MakeCalibrationProblem(setup.robot, data, setup.experiment);
  const std::vector<FoundEffect> effects = {Found("encoder_gain", "A4", 0.99), Found("joint_compliance", "A2", 0.99)};
  std::vector<std::string> cautions;
  CautionOfLookAlikes(problem, effects, &cautions);
  EXPECT_TRUE(cautions.empty());
  for (Observation& row : problem.mutable_data()->observations) {
    row.excluded = !IsLoaded(problem.data().shots[row.shot]);
  }
  CautionOfLookAlikes(problem, {effects[0]}, &cautions);
  EXPECT_TRUE(cautions.empty());
  CautionOfLookAlikes(problem, effects, &cautions);
  ASSERT_EQ(cautions.size(), 1u);
  EXPECT_THAT(cautions[0], AllOf(HasSubstr("joint_compliance on A2"), Not(HasSubstr("A4"))));
}

// 34.5 ppm are 3 K of steel at 11.5 ppm/K; where a row states the temperature, the growth of the arm is a candidate.
TEST(DiagnosisWords, AScaleMayBeTheArmsTemperature) {
  CalibrationProblem problem = test::Kr270Problem(test::CampaignOf(20, 1, 3e-5, 1), test::Kr270Truth(), 2);
  std::vector<FoundEffect> effects = {Found("encoder_gain", "A4", 0.99), Found("station_scale", "S1", 0.99)};
  for (FoundEffect& effect : effects) {
    effect.parameters.emplace_back();
    effect.parameters[0].value = -34.5e-6;
  }
  std::vector<std::string> cautions;
  CautionOfLookAlikes(problem, effects, &cautions);
  ASSERT_EQ(cautions.size(), 1u);
  EXPECT_THAT(cautions[0], AllOf(HasSubstr("station_scale on S1"), HasSubstr("3 K colder"), Not(HasSubstr("A4"))));
  for (ShotInput& shot : *problem.mutable_shot_inputs()) shot.conditions.has_temperature = true;
  cautions.clear();
  CautionOfLookAlikes(problem, effects, &cautions);
  EXPECT_TRUE(cautions.empty());
}

TEST(DiagnosisWords, WhyAProbableEffectIsNotNamedIsACaution) {
  Diagnosis d = Large();
  d.effects.erase(d.effects.begin() + 1, d.effects.end());
  const EffectSpec named = d.effects[0].candidate.spec;
  const EffectSpec left{"link_gravity", "A2", {}, {}}, refused{"encoder_gain", "A3", {}, {}};
  const EffectSpec unconfirmed{"joint_coupling", "A5", {{"driver", "A4"}}, {}}, doubtful{"payload", "L1", {}, {}};
  d.posterior.explanations = {{named, 0.99}, {left, 0.95}, {refused, 0.93}, {unconfirmed, 0.97}, {doubtful, 0.45}};
  // Another width, or moment, is the same effect.
  d.effects.push_back(d.effects[0]);
  d.effects[1].candidate.spec = {"backlash", "A5", {{"by", "torque"}, {"width_Nm", "0.333"}}, {}};
  d.posterior.explanations.push_back({{"backlash", "A5", {{"by", "torque"}}, {}}, 0.96});
  d.posterior.sets = {{0.6, {named, refused}, {}}, {0.4, {left}, {}}};
  CautionOfNotNamed({{unconfirmed, 0.97}}, &d);
  ASSERT_EQ(d.cautions.size(), 2u);
  EXPECT_THAT(d.cautions[0], AllOf(HasSubstr("(encoder_gain, A3) with 93 % is probable"), HasSubstr("full model")));
  EXPECT_THAT(d.cautions[1], AllOf(HasSubstr("(link_gravity, A2) with 95 % is probable"), HasSubstr("as a whole")));
}

TEST(DiagnosisWords, AVerdictOfFortyOneEffectsHasFiveLines) {
  const Diagnosis d = Large();
  const std::vector<std::string> lines = VerdictLines(d);
  ASSERT_EQ(lines.size(), 5u);
  EXPECT_EQ(lines[0], "Found 41 effects. A significant rest has no name in the catalogue (10 % of the gap).");
  EXPECT_THAT(lines[1], AllOf(StartsWith("- "), HasSubstr("on A1, A2, A3, A4, A5 and A6"), HasSubstr("each 98.3 %"),
                              EndsWith(": 45 % of the gap")));
  // The fourth stands for three: 1/8 + 1/16 + 1/32 of 0.45.
  EXPECT_THAT(lines[4], AllOf(HasSubstr("other effects"), HasSubstr(": 9.8 % of the gap")));
  EXPECT_LT(VerdictInWords(d).size(), 700u);
  const std::string text = DiagnosisToText(d);
  EXPECT_THAT(text, HasSubstr("Verdict: partly. Found 41 effects."));
  EXPECT_THAT(text, HasSubstr("36 more effects: in report.html and diagnosis.json"));
}

// 51 % and 5 % of all: the share is of what the two have together.
NextPoses BetweenTwo(const std::string& other) {
  NextPoses next;
  next.poses.resize(6);
  next.rivals = {{0.51, {Found("joint_harmonic", "A2", 0.51).candidate.spec}, {}}, {0.05, {{other, "A2", {}, {}}}, {}}};
  next.of_probability = 0.56;
  next.decides = 0.98;
  next.decided = 0.85;
  next.needed = 6;
  return next;
}

TEST(DiagnosisWords, WhatIsExpectedIsAShareOfWhatTheNamedRivalsHave) {
  const Diagnosis d = Large();
  NextPoses next = BetweenTwo("encoder_gain");
  const std::string words = NextInWords(*d.final.problem, next, false);
  EXPECT_THAT(
      words,
      AllOf(StartsWith("Measure the 6 poses of next.csv: fill in that file and add it to the measurements. To "
                       "decide between periodic joint error (joint_harmonic, A2, order 1) alone (51 %) and "),
            EndsWith("(encoder_gain, A2) alone (5 %): whichever of these is right is expected to have 98 % of what "
                     "they have together (56 %) then; now 85 %.")));
  for (NamedSet& rival : next.rivals) rival.specs.push_back({"link_gravity", "A3", {}, {}});
  EXPECT_THAT(NextInWords(*d.final.problem, next, false),
              AllOf(Not(HasSubstr("link_gravity")), HasSubstr(", given what all of them hold: whichever")));
}

TEST(DiagnosisWords, WhereNothingIsMissingNothingHasToBeMeasured) {
  const Diagnosis d = Large();
  const NextPoses next = BetweenTwo("encoder_gain");
  EXPECT_THAT(NextInWords(*d.final.problem, next, true), StartsWith("Nothing has to be measured for this verdict. "));
}

TEST(DiagnosisWords, HalvesThatHardlyAgreeAreNotSaidToAgree) {
  Confirmation halves;
  halves.halves.resize(2);
  const auto said = [&halves](double p) {
    halves.compatible_p = p;
    return HalvesInWords(halves);
  };
  EXPECT_THAT(said(0.3), HasSubstr("the values agree (p 0.3)"));
  EXPECT_THAT(said(0.034), HasSubstr("the values differ more than noise usually has it (p 0.034)"));
  EXPECT_THAT(said(0.004), HasSubstr("the values contradict each other (p 0.004)"));
}

// The list's value is not the one that was found.
TEST(DiagnosisWords, WhatAnotherPriorNamesIsSaidWithoutScannedNumbers) {
  const Diagnosis d = Large();
  ReportedFlip flip;
  flip.mass = "catalogue";
  flip.is_something = true;
  flip.fewer.specs = {{"warm_up", "S1", {{"tau_s", "300"}}, {}}, {"joint_harmonic", "A2", {{"order", "2"}}, {}}};
  EXPECT_THAT(FlipInWords(d.final.problem->robot(), flip), AllOf(Not(HasSubstr("300")), HasSubstr("order 2")));
}

TEST(DiagnosisWords, AFunctionThatIsOneOfSeveralIsNoFact) {
  Diagnosis d = Large();
  d.unexplained.what.acts_on = "S1";
  d.unexplained.what.words = "station S1 moves with time";
  d.unexplained.probability = 0.9999;
  EXPECT_EQ(UnexplainedInWords(d),
            "station S1 moves with time; it was not seen to predict rows that it was not learnt from");
  d.learnt = std::make_shared<LearntModel>();
  EXPECT_EQ(UnexplainedInWords(d), "station S1 moves with time");
  d.unexplained.probability = 0.34;
  EXPECT_EQ(UnexplainedInWords(d), "perhaps station S1 moves with time (34 %)");
  d.unexplained.probability = 0.01;
  EXPECT_EQ(UnexplainedInWords(d), "no driving variable stands out");
}

TEST(DiagnosisWords, OfManyRivalsTwoAreSaid) {
  const Diagnosis d = Large();
  NextPoses next = BetweenTwo("encoder_gain");
  next.rivals.push_back({0.04, {{"joint_coupling", "A5", {}, {}}}, {}});
  EXPECT_THAT(NextInWords(*d.final.problem, next, false), HasSubstr("joint_coupling"));  // "1 other" says no less
  next.rivals.push_back({0.03, {{"station_scale", "S1", {}, {}}}, {}});
  EXPECT_THAT(NextInWords(*d.final.problem, next, false),
              AllOf(Not(HasSubstr("joint_coupling")),
                    HasSubstr("(encoder_gain, A2) alone (5 %) and 2 others (7 %): whichever")));
}

TEST(DiagnosisWords, AnotherDayIsProposedWhereTimeOrTemperatureDrives) {
  const Diagnosis d = Large();
  NextPoses next = BetweenTwo("encoder_gain");
  next.needed = 0;
  EXPECT_THAT(NextInWords(*d.final.problem, next, false), EndsWith("another station is more informative."));
  next.depends_on_when = true;
  EXPECT_THAT(
      NextInWords(*d.final.problem, next, false),
      EndsWith("would not reach 90 %: the same poses on another day, or with the arm some kelvin warmer, are more "
               "informative."));
}

TEST(DiagnosisWords, WithoutAGapNoneIsSaid) {
  Diagnosis d = Large();
  d.gap.before = d.gap.after = d.gap.closed = 0.0;
  EXPECT_THAT(DiagnosisToText(d), HasSubstr("Gap on untouched configurations: none beyond the noise floor\n"));
  d.effects.clear();
  d.groups.clear();
  d.verdict = DiagnosisVerdict::kUnknown;
  d.posterior.nothing = 0.0, d.posterior.unnamed = 0.9;
  EXPECT_THAT(VerdictInWords(d), HasSubstr("the untouched ones show no gap"));
}

TEST(DiagnosisWords, WhatCouldNotBeTestedIsSaid) {
  Diagnosis d = Large();
  EXPECT_EQ(DiagnosisToText(d).find("Not tested"), std::string::npos);
  d.not_testable = {
      {"gravity_compensator", "A2", "…", Lack::kCompliance}, {"joint_slip", "A1", "time_s", Lack::kTime},
      {"joint_slip", "A2", "time_s", Lack::kTime},           {"station_drift", "S1", "time_s", Lack::kTime},
      {"backlash", "A1", "approach1", Lack::kApproach},      {"backlash", "A3", "approach3", Lack::kApproach},
      {"payload", "L1", "loaded rows", Lack::kOther}};
  EXPECT_THAT(DiagnosisToText(d),
              HasSubstr("Not tested: gravity compensator on A2, for neither robot file nor loaded rows show the "
                        "joint's compliance (state it, or measure with a load); zero shift of a joint and drift of the "
                        "station, for want of times; "
                        "backlash (or friction wind-up) on A1 and A3, for want of approach directions.\n"));
}

TEST(DiagnosisWords, UndecidedIsNotUnexplained) {
  Diagnosis d = Large();
  d.effects.clear();
  d.groups.clear();
  d.verdict = DiagnosisVerdict::kUnknown;
  d.posterior.nothing = 0.0, d.posterior.unnamed = 0.9;
  d.posterior.explanations = {{{"encoder_gain", "A3", {}, {}}, 0.27}, {{"link_gravity", "A3", {}, {}}, 0.05}};
  EXPECT_THAT(VerdictInWords(d), HasSubstr("no effect of the catalogue explains well"));
  const EffectSpec gain{"encoder_gain", "A3", {}, {}}, gravity{"link_gravity", "A2", {}, {}};
  d.posterior.sets = {
      {0.7, {}, {"a deviation of A3"}}, {0.1, {gain}, {"a deviation of A2"}}, {0.06, {gain, gravity}, {}}};
  EXPECT_THAT(VerdictInWords(d),
              AllOf(HasSubstr("most probably of a cause without a name (90 %); effects of the catalogue would explain "
                              "it as well: encoder gain (encoder_gain, A3) with "),
                    EndsWith("(link_gravity, A2) (6 %).")));
  d.posterior.sets.clear();
  d.posterior.unnamed = 0.24;
  EXPECT_THAT(VerdictInWords(d), AllOf(HasSubstr("do not decide what it is"), HasSubstr("encoder_gain, A3) 27 %"),
                                       HasSubstr("no name 24 %"), ::testing::Not(HasSubstr("link_gravity"))));
  // What the fitted rows decide and nothing confirms is no open question.
  d.posterior.explanations = {{{"encoder_gain", "A3", {}, {}}, 0.97}};
  EXPECT_THAT(VerdictInWords(d), AllOf(HasSubstr("encoder_gain, A3) 97 %"), HasSubstr("do not confirm it"),
                                       Not(HasSubstr("do not decide"))));
  // Where it is the noise most probably, that stands first.
  d.posterior.explanations = {{{"encoder_gain", "A3", {}, {}}, 0.02}};
  d.posterior.unnamed = 0.1, d.posterior.noise = 0.52;
  EXPECT_THAT(VerdictInWords(d), HasSubstr("most probably noise other than stated (52 %; see below), next a cause "
                                           "without a name (10 %)"));
}

TEST(DiagnosisWords, WhatIsNotMissingIsNotSaidToBe) {
  Diagnosis d = Large();
  d.effects.clear();
  d.groups.clear();
  d.verdict = DiagnosisVerdict::kUnknown;
  d.posterior.nothing = 0.61, d.posterior.unnamed = 0.09;
  d.posterior.sets = {{0.026, {{"encoder_gain", "A3", {}, {}}}, {}}};
  EXPECT_THAT(VerdictInWords(d), AllOf(HasSubstr("nothing missing 61 %"), HasSubstr("residuals.csv"),
                                       Not(HasSubstr("most probably")), Not(HasSubstr("encoder_gain"))));
  d.gap.before = 0.0;
  EXPECT_THAT(VerdictInWords(d), AllOf(HasSubstr("scatter more"), HasSubstr("nothing missing 61 %")));
  d.verdict = DiagnosisVerdict::kConsistent;
  EXPECT_THAT(VerdictInWords(d), StartsWith("Nothing is missing at this significance."));
  d.posterior.nothing = 0.17, d.posterior.noise = 0.02;
  EXPECT_THAT(VerdictInWords(d), StartsWith("Something is probably missing (81 %)"));
}

// Where only what has no name is found, the final model is the believed one with the noise as stated.
TEST(DiagnosisWords, NoNoiseIsFoundInTheBelievedModel) {
  Diagnosis d = Large();
  d.noise.scale_differs = true;
  EXPECT_THAT(DiagnosisToText(d), HasSubstr("with the noise that "));
  d.effects.clear();
  d.groups.clear();
  EXPECT_THAT(DiagnosisToText(d), Not(HasSubstr("with the noise that ")));
}

TEST(DiagnosisWords, ValuesThatAreNotDeterminedAreCounted) {
  FoundEffect effect = Found("encoder_gain", "A4", 0.99);
  const Robot robot = test::Kr270Robot();
  effect.candidate.poorly_determined = {"a"};
  EXPECT_THAT(EffectInWords(robot, effect), HasSubstr("do not determine its value"));
  effect.candidate.poorly_determined = {"a", "b"};
  EXPECT_THAT(EffectInWords(robot, effect), HasSubstr("none of its 2 values by itself"));
  effect.parameters.emplace_back();
  effect.parameters[0].name = "c";
  EXPECT_THAT(EffectInWords(robot, effect), HasSubstr("2 more that these data do not determine"));
}

TEST(DiagnosisWords, ALearntEffectOfTheCatalogueIsNoSmoothFunction) {
  Diagnosis d = Large();
  LearntModel learnt;
  learnt.model = d.final;
  learnt.functions = {{"encoder_gain", "A4", {}, {}}};
  d.learnt = std::make_shared<LearntModel>(learnt);
  EXPECT_THAT(LearntInWords(d), StartsWith("With A4 encoder_gain, not sure enough to be named, learnt from the rows"));
  learnt.functions.push_back({"learnt_deviation", "A2", {}, {}});
  d.learnt = std::make_shared<LearntModel>(learnt);
  EXPECT_THAT(LearntInWords(d), StartsWith("With 1 smooth function and A4 encoder_gain, not sure"));
}

TEST(DiagnosisWords, AWrongPoseIsNamed) {
  NoiseFinding noise;
  noise.outliers = {"m.csv:7", "m.csv:8", "m.csv:20"};
  noise.arrivals = {{"c6", 5.3e-3}};
  noise.outliers_of_arrivals = 2;
  EXPECT_EQ(WrongNoiseInWords(noise), "all readings of a shot are off in configuration c6 and readings are outliers");
  EXPECT_THAT(NoiseInWords(noise), AllOf(HasSubstr("c6 (5.3 mm)"), HasSubstr("3 outliers left out, 2 of them there")));
}

TEST(DiagnosisWords, WhatIsWrongWithTheRowsIsSaidFirst) {
  Diagnosis d = Large();
  CalibrationProblem problem = *d.baseline.problem;
  problem.mutable_data()->warnings = {"copies"};
  d.baseline.problem = std::make_shared<CalibrationProblem>(problem);
  d.cautions = {"units", "few poses"};
  d.read_first = 1;
  const std::string text = DiagnosisToText(d);
  EXPECT_THAT(text, StartsWith("Warning: copies\nCaution: units\n\nVerdict: "));
  EXPECT_THAT(text, EndsWith("Caution: few poses\n"));
}

// A sign or a size that no machine shows is said in the first line: nothing is left, and yet the cause is another one.
TEST(DiagnosisWords, WhatNoMachineShowsIsNoCause) {
  Diagnosis d = Large();
  EXPECT_THAT(VerdictInWords(d), Not(HasSubstr("no machine shows")));
  d.verdict = DiagnosisVerdict::kExplained;
  d.effects[1].bounds.kind = PhysicalBounds::Kind::kNegative;
  EXPECT_THAT(VerdictInWords(d),
              EndsWith("Nothing significant is left. But A2 joint_harmonic, order 1: the sign is not "
                       "physical: read it as a description, not as a cause."));
}

// Effects that cost untouched rows more than they give, though not beyond chance, have no share of what is explained.
TEST(DiagnosisWords, ANegativeShareIsNoGain) {
  Diagnosis d = Large();
  d.groups[1].share_of_gap = -0.089;
  EXPECT_THAT(VerdictLines(d)[2], EndsWith(": no gain on untouched rows"));
}

// The axes of pictures cut long names off at their end.
// Of a reflector's radius and of an effect as large as its uncertainty.
TEST(DiagnosisWords, AValueHasTheDigitsOfItsInterval) {
  Diagnosis d = Large();
  d.effects = {Found("station_range_offset", "S1", 0.99)};
  d.groups.clear();
  ParameterEstimate row;
  row.name = "effect/station_range_offset/S1/offset";
  row.quantity = Quantity::kShift;
  const auto words_of = [&](double value, double half) {
    row.value = value;
    row.ci95 = {value - half, value + half};
    d.effects[0].parameters = {row};
    return DiagnosisToText(d);
  };
  EXPECT_THAT(words_of(-19.03919e-3, 69.84e-6), HasSubstr("-19040 ± 69.8 um"));
  EXPECT_THAT(words_of(123.45e-6, 61.234e-6), HasSubstr("123 ± 61.2 um"));
}

TEST(DiagnosisWords, AShortTitleBeginsWithTheTarget) {
  const Diagnosis d = Large();
  EXPECT_EQ(ShortTitle(d.final.problem->robot(), d.effects[0].candidate.spec), "A1 joint_harmonic, order 1");
}

TEST(DiagnosisWords, OneEffectIsOneSentence) {
  Diagnosis d = Large();
  d.verdict = DiagnosisVerdict::kExplained;
  d.effects.resize(1);
  d.groups = {{"joint_harmonic", {0}, 1.0}};
  EXPECT_EQ(VerdictLines(d).size(), 1u);
  EXPECT_THAT(VerdictInWords(d), AllOf(StartsWith("Found: "), HasSubstr("(joint_harmonic, A1, order 1), 99 %"),
                                       EndsWith(". Nothing significant is left.")));
}

// A verdict holds itself to the probability that is printed next to it.
TEST(DiagnosisWords, WhereMoreIsProbableNotNothingIsLeft) {
  Diagnosis d = Large();
  d.verdict = DiagnosisVerdict::kExplained;
  d.effects.resize(1);
  d.groups = {{"joint_harmonic", {0}, 1.0}};
  const EffectSpec named = d.effects[0].candidate.spec, other{"backlash", "A2", {}, {}};
  d.posterior.explanations = {{named, 0.99}, {other, 0.55}};
  d.posterior.sets = {{0.40, {named, other}, {}}, {0.26, {named}, {}}, {0.34, {named}, {"a deviation of A4"}}};
  EXPECT_THAT(VerdictInWords(d), AllOf(Not(HasSubstr("Nothing significant")),
                                       HasSubstr("There is probably more (74 %), most likely backlash"),
                                       HasSubstr("(backlash, A2) with 55 %")));
  d.posterior.sets[1].probability = 0.6;
  d.posterior.sets[2].probability = 0.0;
  EXPECT_THAT(VerdictInWords(d), EndsWith("Nothing significant is left."));
}

TEST(DiagnosisWords, WithoutAHoldOutNoShareIsSaid) {
  Diagnosis d = Large();
  d.gap = GapReport();
  d.gap.closed = kNotKnown;
  for (EffectGroup& group : d.groups) group.share_of_gap = kNotKnown;
  for (const std::string& line : VerdictLines(d)) EXPECT_EQ(line.find("of the gap"), std::string::npos) << line;
}

// 0 to 100 % says nothing, however precise the figure before it reads; -20 to 30 % says that it is not most of it.
TEST(DiagnosisWords, AShareThatMayBeAnythingIsNotKnown) {
  Diagnosis d = Large();
  const auto said = [&d](double low, double high) {
    d.gap.closed_ci95 = {low, high};
    return ClosedInWords(d.gap);
  };
  EXPECT_THAT(said(0.8, 0.95), HasSubstr("closed 90 % of the squared gap (95 %: 80 to 95)"));
  EXPECT_THAT(said(-0.2, 0.3), StartsWith("closed"));
  EXPECT_THAT(said(-7.87, 1.0), HasSubstr("which share of the squared gap is closed is not known: 90 % on these"));
  EXPECT_THAT(VerdictInWords(d), Not(HasSubstr("of the gap")));
}

// Where nothing states the noise, each model's chi-square is in units of its own scatter.
TEST(DiagnosisWords, WithoutAStatedNoiseNoChiSquareIsCompared) {
  Diagnosis d = Large();
  d.baseline.estimate.fit.rms = 6.45e-5, d.final.estimate.fit.rms = 6.25e-5;
  EXPECT_THAT(DiagnosisToText(d), HasSubstr("reduced chi-square"));
  d.noise.is_stated = false;
  EXPECT_THAT(DiagnosisToText(d), AllOf(Not(HasSubstr("chi-square")), HasSubstr("Baseline: fit RMS 0.0645 mm"),
                                        HasSubstr("Final: fit RMS 0.0625 mm")));
}

// A floor by the stated noise next to a noise that is found is said to be that, and a scatter that holds what has no
// name is a bound.
TEST(DiagnosisWords, WhichNoiseAFigureGoesByIsSaid) {
  Diagnosis d = Large();
  d.final.estimate.validation.observations = 10;
  d.noise.scale_differs = true;
  d.noise.scale = 3.48, d.noise.low = 3.3, d.noise.high = 3.7;
  EXPECT_THAT(NoiseInWords(d.noise), HasSubstr("The instrument's noise is 3.48 times"));
  d.noise.is_bound = true;
  EXPECT_THAT(NoiseInWords(d.noise), HasSubstr("noise is at most 3.48 times what is stated (95 %: 3.3 to 3.7): what"));
  EXPECT_THAT(DiagnosisToText(d), AllOf(Not(HasSubstr("by the noise as stated")), HasSubstr("that would be left if")));
  d.gap.floor_is_as_stated = d.noise.is_of_final = true;
  EXPECT_THAT(DiagnosisToText(d),
              AllOf(HasSubstr("by the noise as stated"), HasSubstr("with the noise that is found")));
}

TEST(DiagnosisWords, WhyRivalsAreNotTheSetsIsSaid) {
  const Diagnosis d = Large();
  NextPoses next = BetweenTwo("encoder_gain");
  EXPECT_THAT(NextInWords(*d.final.problem, next, false), Not(HasSubstr("piece")));
  next.counts_pieces = true;
  EXPECT_THAT(NextInWords(*d.final.problem, next, false), HasSubstr("has both readings."));
}

}  // namespace
}  // namespace sagitta::diagnosis_words_test

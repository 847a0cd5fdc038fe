#include "tools/report/diagnosis_report.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "estimator/report/diagnosis_caution_words.h"
#include "estimator/report/diagnosis_gap_words.h"
#include "estimator/report/diagnosis_noise_words.h"
#include "estimator/report/diagnosis_words.h"
#include "estimator/report/inspection_words.h"
#include "models/quantiles.h"
#include "tools/report/calibration_report.h"
#include "tools/report/charts.h"
#include "tools/report/report_html.h"
#include "tools/report/summary.h"

namespace sagitta {
namespace {

constexpr size_t kBarsPerMap = 8;
constexpr double kMeaningless = 5e-3;  // rad, m: more than any joint deviates; such a joint hardly moves a marker

std::string Probability(double p) {
  if (std::isnan(p)) return "not known";
  return p > 0.0 ? Significant(p, 2) : "below 1e-300";
}

std::string Labelled(const std::string& name, const std::string& unit) {
  return unit.empty() ? name : name + ", " + ShownUnit(unit);
}

Picture Waterfall(const Diagnosis& d) {
  std::vector<Stage> stages = {{"believed model", 1e3 * d.baseline.estimate.validation.rms}};
  int number = 0;
  for (const FoundEffect& effect : d.effects) {
    stages.push_back({std::to_string(++number) + ": " + ShortTitle(d.final.problem->robot(), effect.candidate.spec),
                      1e3 * effect.holdout_after});
  }
  return WaterfallPicture("The gap, effect by effect", "hold-out RMS per coordinate, mm", stages, 1e3 * d.gap.floor,
                          "noise floor");
}

// Before: what the measurements ask for with the effect removed from the model, and what the effect says. After: the
// rest.
std::vector<Picture> EffectPictures(const EffectView& view) {
  std::vector<double> rest;
  for (size_t k = 0; k < view.x.size(); ++k) rest.push_back(view.measured[k] - view.simulated[k]);
  const std::string driver = Labelled(view.driver, view.driver_unit), what = Labelled(view.quantity, view.unit);
  return {ScatterPicture("Before: one point per visit, what the measurements ask for and what the effect says", driver,
                         view.x, what, {{"measured", view.measured}, {"the effect", view.simulated}}),
          ScatterPicture("After: what is left", driver, view.x, Labelled("the rest", view.unit), {{"the rest", rest}})};
}

// Of each effect, that its name belongs to the set of causes; of what else might be there in its place.
Picture Probabilities(const Diagnosis& d) {
  const Robot& robot = d.final.problem->robot();
  std::vector<Bar> bars;
  for (size_t i = 0; i < d.effects.size(); ++i) {
    const std::string number = std::to_string(i + 1) + ": ";
    bars.push_back({"", number + ShortTitle(robot, d.effects[i].candidate.spec), 100.0 * d.effects[i].probability});
    for (const Alternative& alternative : d.effects[i].alternatives) {
      bars.push_back({"", number + "or " + ShortTitle(robot, alternative.spec), 100.0 * alternative.probability});
    }
  }
  return BarPicture("How probable each name is, and what else it may be", "probability, %", bars);
}

Section GapSection(const Diagnosis& d) {
  const Estimate& before = d.baseline.estimate;
  const Estimate& after = d.final.estimate;
  const auto reduced = [](const Estimate& e) { return Significant(e.chi2 / std::max(1, e.dof), 4); };
  Section section;
  section.title = "The gap, before and after";
  section.header = {"", "before", "after", "unit"};
  const std::string noise = NoiseOfFinalInWords(d);
  if (d.noise.is_stated) {
    section.rows = {{"reduced chi-square of the fit" + (noise.empty() ? "" : " (after: " + noise + ")"),
                     reduced(before), reduced(after), ""},
                    {"lack of fit, p", Probability(d.baseline_p), Probability(d.final_p), ""}};
  } else {
    section.rows = {{"RMS per coordinate of the fit", Millimetres(before.fit.rms), Millimetres(after.fit.rms), "mm"}};
  }
  if (before.validation.observations == 0) {
    section.paragraphs = {"Nothing is held out: what the effects do on other data is not known."};
    if (!d.effects.empty()) section.pictures = {Probabilities(d)};
    return section;
  }
  const auto add = [&section](const char* what, double was, double is) {
    section.rows.push_back({what, Millimetres(was), Millimetres(is), "mm"});
  };
  add("hold-out RMS per coordinate", before.validation.rms, after.validation.rms);
  add("hold-out RMS distance", before.validation.distance_rms, after.validation.distance_rms);
  std::string gap = "The gap beyond the noise is " + GapIsNotKnown(d.gap);
  if (!std::isnan(d.gap.floor)) {
    add("gap beyond the noise floor", d.gap.before, d.gap.after);
    gap = "Noise floor " + Millimetres(d.gap.floor) + " mm per coordinate" +
          (d.gap.floor_is_as_stated ? " (" + FloorGoesByStatedNoise() + ")" : "") +
          (d.effects.empty() ? "" : "; " + ClosedInWords(d.gap));
  }
  section.paragraphs = {"Hold-out: configurations on which nothing was chosen or fitted. " + gap + "."};
  section.pictures = {Waterfall(d)};
  if (!d.effects.empty()) section.pictures.push_back(Probabilities(d));
  return section;
}

Section EffectSection(const Robot& robot, const FoundEffect& effect, size_t number) {
  Section section;
  section.title = "Effect " + std::to_string(number) + ": " + Title(robot, effect.candidate.spec);
  section.header = {"parameter", "value", "95 % from", "to", "unit", ""};
  for (const ParameterEstimate& row : effect.parameters) {
    const QuantityTraits& traits = TraitsOf(row.quantity);
    section.rows.push_back({row.name.substr(row.name.rfind('/') + 1), Significant(row.value / traits.si_per_unit, 4),
                            Significant(row.ci95.low / traits.si_per_unit, 4),
                            Significant(row.ci95.high / traits.si_per_unit, 4), ShownUnit(traits.unit),
                            IsDetermined(effect, row) ? "" : "not determined by these data"});
  }
  section.paragraphs = {EffectInWords(robot, effect), HalvesInWords(effect.confirmation),
                        "Physical bounds: " + PhysicalInWords(effect.bounds) + "."};
  for (const Alternative& alternative : effect.alternatives) {
    section.paragraphs.push_back("Or: " + AlternativeInWords(robot, alternative) +
                                 ". To separate them: " + SeparateBy(robot, alternative) + ".");
  }
  section.pictures = EffectPictures(effect.view);
  return section;
}

Section CandidateSection(const Diagnosis& d) {
  Section section;
  section.title = "What was screened";
  section.header = {"effect", "chi-square explained", "parameters", "p, corrected", "log evidence"};
  for (size_t i = 0; i < d.candidates.size() && i < 12; ++i) {
    const ScreenedCandidate& entry = d.candidates[i];
    section.rows.push_back({Title(d.final.problem->robot(), entry.spec), Fixed(entry.reduction, 1),
                            std::to_string(entry.parameters), Probability(entry.corrected_p),
                            Fixed(entry.log_evidence, 1)});
  }
  section.paragraphs = {std::to_string(d.screened) +
                        " effects with their settings, each alone with the believed model; p counts the whole search."};
  std::map<std::string, int> missing;
  for (const NotTestable& entry : d.not_testable) ++missing[entry.effect + " needs " + entry.needs];
  for (const auto& [what, count] : missing) section.paragraphs.push_back("Cannot be tested: " + what + ".");
  return section;
}

bool IsMeaningless(const JointGap& gap) {
  std::vector<double> sizes;
  for (const double deviation : gap.before) sizes.push_back(std::abs(deviation));
  return Median(sizes) * 1e-6 > kMeaningless;  // urad or um
}

// The deviation of each joint, as columns over all shots; what may drive them, once each.
struct GapColumns {
  explicit GapColumns(size_t of_shots) : shots(of_shots) {}

  void Add(const std::string& name, const std::string& label, const std::string& signal, const std::vector<int>& rows,
           const std::function<double(size_t)>& value) {
    PictureMenu& menu = signal == "x" ? across : down;
    if (columns.count(name) == 0) menu.options.emplace_back(name, label);
    std::vector<double>& column = columns.emplace(name, std::vector<double>(shots, NAN)).first->second;
    labels[name] = label;
    for (size_t i = 0; i < rows.size(); ++i) column[rows[i]] = value(i);
  }

  size_t shots;
  PictureMenu across{"x", "over", {}}, down{"y", "of", {}};
  std::map<std::string, std::vector<double>> columns;
  nlohmann::ordered_json labels = nlohmann::ordered_json::object();
};

void AddGap(const JointGap& gap, const std::vector<double>& deviations, GapColumns* columns) {
  columns->Add("gap " + gap.joint, "deviation of " + Labelled(gap.joint, gap.unit), "y", gap.shots,
               [&](size_t i) { return deviations[i]; });
  for (const Driver& driver : gap.over) {
    columns->Add("over " + driver.name, Labelled(driver.name, driver.unit), "x", gap.shots,
                 [&](size_t i) { return driver.of_shot[gap.shots[i]]; });
  }
}

// Root mean squares, per joint: the table of the map.
void AddGapRow(const JointGap& gap, Picture* picture) {
  const auto rms = [](const std::vector<double>& values) {
    double squares = 0.0;
    for (const double value : values) squares += value * value;
    return values.empty() ? std::string("-") : Significant(std::sqrt(squares / values.size()), 3);
  };
  picture->rows.push_back({gap.joint, rms(gap.before), rms(gap.after), gap.unit, std::to_string(gap.shots.size())});
}

Picture GapMap(const Diagnosis& d, const std::vector<const JointGap*>& gaps) {
  Picture picture;
  picture.kind = "scatter";
  picture.title = "Deviation of one joint that would explain the gap";
  picture.header = {"joint", "RMS given the believed model", "given the extended one", "unit", "shots"};
  nlohmann::ordered_json& rows = picture.data["rows"];
  for (const JointGap* gap : gaps) AddGapRow(*gap, &picture);
  for (const bool is_after : {false, true}) {
    if (is_after && d.effects.empty()) continue;
    GapColumns columns(d.final.problem->data().shots.size());
    for (const JointGap* gap : gaps) AddGap(*gap, is_after ? gap->after : gap->before, &columns);
    for (const auto& [name, values] : columns.columns) {
      for (const double value : values) rows[name].push_back(Rounded(value));
    }
    for (size_t s = 0; s < columns.shots; ++s) rows["model"].push_back(is_after ? "extended" : "believed");
    picture.settings = {{"labels", columns.labels}, {"trend", false}};
    picture.menus = {columns.down, columns.across, {"colour", "colour", {{"model", "model"}}}};
  }
  return picture;
}

// The deviation of each joint that would explain the gap, over what may drive it.
Section GapMapSection(const Diagnosis& d) {
  Section section;
  section.title = "The gap in joint space";
  section.paragraphs = {
      "Per shot, the deviation of one joint alone that would explain best what is measured and not predicted, over "
      "the joints' angles, the torques of the known loads, the direction of approach and the time, where these vary; "
      "given the believed model" +
      std::string(d.effects.empty() ? "." : " and given the extended one.")};
  std::vector<std::string> not_drawn;
  std::vector<const JointGap*> drawn;
  for (const JointGap& gap : d.gap_map) {
    if (IsMeaningless(gap)) {
      not_drawn.push_back(gap.joint);
    } else if (!gap.over.empty()) {
      drawn.push_back(&gap);
    }
  }
  if (!drawn.empty()) section.pictures = {GapMap(d, drawn)};
  if (!not_drawn.empty()) {
    section.paragraphs.push_back("Not drawn: " + Enumerate(not_drawn) +
                                 ", which moves the markers too little for its deviation to mean anything.");
  }
  return section;
}

// Share of the excess chi-square by joint, marker, load and so on.
Section WhereSection(const Diagnosis& d) {
  std::map<std::string, int> of_family;
  std::vector<Bar> bars;
  for (const WhereShare& share : d.where) ++of_family[share.by];
  std::map<std::string, size_t> taken;
  for (const WhereShare& share : d.where) {
    if (of_family[share.by] > 1 && taken[share.by]++ < kBarsPerMap)
      bars.push_back({share.by, share.key, 100.0 * share.share});
  }
  Section section;
  section.title = "Where they disagree";
  section.paragraphs = {"Share of the excess chi-square of the believed model."};
  if (bars.empty()) {
    section.paragraphs = {
        "No joint, marker, load, station or time has more chi-square than the noise by which the believed "
        "model is judged: there is nothing to draw."};
  }
  if (!bars.empty()) section.pictures = {BarPicture("Where the gap sits", "share, %", bars)};
  return section;
}

// What stands on the first screen: at most five lines of what was found, the noise, what limits it.
Section VerdictSection(const Diagnosis& d) {
  Section section;
  section.title = "Diagnosis: " + WordOf(d.verdict);
  for (const std::string& warning : d.baseline.problem->data().warnings)
    section.paragraphs.push_back("Warning: " + warning);
  for (const std::string& line : VerdictLines(d)) section.paragraphs.push_back(line);
  section.paragraphs.push_back("Noise: " + NoiseInWords(d.noise));
  if (d.has_unexplained) {
    section.paragraphs.push_back("Without a name: " + UnexplainedInWords(d) + ".");
    if (d.learnt) section.paragraphs.push_back(LearntInWords(d));
  }
  for (const std::string& caution : d.cautions) section.paragraphs.push_back("Caution: " + caution);
  const std::string unread = NotReadInWords(d.baseline.problem->data().unread_columns);
  if (!unread.empty()) section.paragraphs.push_back(unread);
  return section;
}

Section EffectTable(const Diagnosis& d) {
  Section section;
  section.title = "All " + std::to_string(d.effects.size()) + " effects";
  section.header = {"effect", "named", "hold-out RMS, mm", "probability", "a machine shows that"};
  for (size_t i = 0; i < d.effects.size(); ++i) {
    const FoundEffect& effect = d.effects[i];
    section.rows.push_back({std::to_string(i + 1), Title(d.final.problem->robot(), effect.candidate.spec),
                            Millimetres(effect.holdout_after), Fixed(100.0 * effect.probability, 1) + " %",
                            effect.bounds.IsPlausible() ? "yes" : "no: a description"});
  }
  return section;
}

}  // namespace

std::string DiagnosisToHtml(const Diagnosis& d, const Calibration& extended, const Provenance& provenance) {
  std::vector<Section> sections = {VerdictSection(d), GapSection(d)};
  const auto appendix = [&sections](Section section) {
    section.folded = true;
    sections.push_back(std::move(section));
  };
  if (d.effects.size() > 1) appendix(EffectTable(d));
  if (d.verdict != DiagnosisVerdict::kConsistent) {
    appendix(WhereSection(d));
    appendix(GapMapSection(d));
  }
  for (size_t i = 0; i < d.effects.size(); ++i) appendix(EffectSection(d.final.problem->robot(), d.effects[i], i + 1));
  appendix(CandidateSection(d));
  for (Section& section : CalibrationPage(extended)) appendix(std::move(section));
  return SectionsToPage(sections, provenance);
}

}  // namespace sagitta

#include "tools/report/summary.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <sstream>

#include "estimator/noise/robot_scatter.h"
#include "estimator/noise/rotation_noise.h"
#include "estimator/report/inspection_words.h"
#include "estimator/report/noise_words.h"
#include "models/quantiles.h"
#include "tools/report/parameter_section.h"
#include "tools/report/remedies.h"

namespace sagitta {

std::string Plural(int n, const std::string& noun) { return std::to_string(n) + " " + noun + (n == 1 ? "" : "s"); }

namespace {

Section ResultSection(const CalibrationProblem& problem, const Estimate& estimate) {
  Section section;
  section.title = problem.robot().name.empty() ? "Calibration" : problem.robot().name;
  section.paragraphs = {std::string("Status: ") + StatusName(estimate.status) + " (" + estimate.message + ").",
                        Plural(estimate.fit.observations, "observation") + " of " +
                            Plural(estimate.calibration_configurations, "configuration") + ", " +
                            Plural(problem.data().stations.size(), "station") + ", " +
                            Plural(problem.data().markers.size(), "marker") + "; " +
                            Plural(estimate.estimated.size(), "unknown") + " estimated in " +
                            Plural(estimate.iterations, "iteration") + ", " + Fixed(estimate.seconds, 2) + " s."};
  const std::string unread = NotReadInWords(problem.data().unread_columns);
  if (!unread.empty()) section.paragraphs.push_back(unread);
  return section;
}

std::string Factor(double before, double after) {
  if (!(after > 0.0 && before > 0.0)) return "-";
  return before / after < 1e5 ? Fixed(before / after, 1) : "> 100000";
}

// Three digits of what is left, and a tenth of a micrometre at least.
int DecimalsOfResiduals(const ResidualSize& after) {
  constexpr int kLeast = 4, kMost = 7;
  return after.rms > 0.0 ? std::clamp(DecimalsFor(1e3 * after.rms) + 1, kLeast, kMost) : kLeast;
}

}  // namespace

Section ResidualSection(const std::string& title, const ResidualSize& before, const ResidualSize& after) {
  Section section;
  section.title = title;
  section.header = {"mm", "before", "after", "factor"};
  const int decimals = DecimalsOfResiduals(after);
  const auto add = [&section, decimals](const std::string& name, double b, double a) {
    section.rows.push_back({name, Millimetres(b, decimals), Millimetres(a, decimals), Factor(b, a)});
  };
  add("coordinate max", before.max, after.max);
  add("coordinate RMS", before.rms, after.rms);
  for (int axis = 0; axis < 3; ++axis) {
    add(std::string("  ") + "xyz"[axis] + " RMS", before.rms_axis[axis], after.rms_axis[axis]);
  }
  add("distance max", before.distance_max, after.distance_max);
  add("distance RMS", before.distance_rms, after.distance_rms);
  if (after.rotations > 0) {  // mrad of rad, as mm of m
    add("rotation max, mrad", before.rotation_max, after.rotation_max);
    add("rotation RMS per axis, mrad", before.rotation_rms, after.rotation_rms);
  }
  return section;
}

namespace {

Section ValidationSection(const Estimate& estimate) {
  Section section =
      ResidualSection("Residuals on " + Plural(estimate.validation.observations, "validation observation"),
                      estimate.validation_before, estimate.validation);
  section.paragraphs = {"Predicted coordinate RMS from noise and parameter uncertainty: " +
                        Millimetres(estimate.validation_predicted_rms, DecimalsOfResiduals(estimate.validation)) +
                        " mm."};
  return section;
}

// "": no prior is contradicted.
std::string PullInWords(const Estimate& estimate) {
  const PriorPull& pull = estimate.sigma.pull;
  if (!pull.is_set_aside) return "";
  const double dof = std::max(1, estimate.dof - pull.priors), rows = estimate.chi2 - pull.squares;
  return "Of it " + Significant(pull.squares, 4) + " is the pull of " + Plural(pull.priors, "stated prior") +
         ": more than chance, and no noise of the rows; what follows is of the rows alone, " + Significant(rows, 4) +
         " at " + Fixed(dof, 0) + ", reduced " + Significant(rows / dof, 4) + ". ";
}

// One factor scales what is assumed of both where there are too few readings to estimate two (noise/rotation_noise.h).
std::string OfRotationsToo(const Estimate& estimate) {
  if (estimate.fit.rotations == 0) return "";
  return ", and with it " + Millimetres(estimate.sigma.estimated) +
         " mrad of every axis of a rotation: 1 mrad to 1 mm is assumed, for so few readings do not determine two";
}

Section NoiseSection(const CalibrationProblem& problem, const Estimate& estimate) {
  Section section;
  section.title = "Noise";
  const std::string dof = Plural(estimate.dof, "degree") + " of freedom";
  if (estimate.dof <= 0) {
    section.paragraphs = {"As many equations as unknowns: the data fit by construction and cannot check themselves."};
  } else if (!estimate.sigma.stated) {
    section.paragraphs = {"No standard deviation is stated; one for all coordinates is estimated: " +
                          Millimetres(estimate.sigma.estimated) + " mm (" + dof + ")" + OfRotationsToo(estimate) + "."};
  } else if (HasTwoNoises(estimate.noise_report)) {
    section.paragraphs.clear();  // by construction chi-square is what it should be; the report's words say the rest
  } else {
    section.paragraphs = {"Chi-square " + Significant(estimate.chi2, 5) + " at " + dof + ", reduced " +
                              Significant(estimate.chi2 / estimate.dof, 4) + ".",
                          PullInWords(estimate) + SigmaInWords(estimate, problem.experiment().significance)};
    // Fitted by REML, chi-square is what it should be by construction.
    if (!estimate.noise_report.components.empty()) section.paragraphs.pop_back();
    const bool misfit = estimate.sigma.scaled && std::pow(estimate.sigma.a_posteriori, 2) > kInstrumentIsNotTheNoise;
    if (misfit && problem.latent.empty()) {
      section.paragraphs.push_back(
          "Where it is the arm that repeats no better ('sagitta diagnose' distinguishes that from a missing effect), "
          "repeatability_urad: estimate keeps the instrument's sigma as stated, and predictions as narrow as they "
          "are.");
    }
  }
  if (estimate.sigma.rotation > 0.0 && estimate.noise_report.words.empty()) {
    section.paragraphs.push_back("No rotation states a standard deviation: " + Millimetres(estimate.sigma.rotation) +
                                 " mrad of every axis is what their residuals scatter by.");
  }
  for (const std::string& words : estimate.noise_report.words) section.paragraphs.push_back(words);
  return section;
}

std::string KindName(const PartComparison& kind) {
  if (kind.by == SplitBy::kRandom) return "random halves";
  if (kind.by == SplitBy::kRegion) return "halves of the workspace";
  if (kind.by == SplitBy::kStation) return "stations";
  if (kind.by == SplitBy::kMarker) return "markers";
  return kind.by == SplitBy::kLoad ? "loads" : "halves of the time";
}

// How the intervals came about, and whether parts of the data agree within them.
Section IntervalSection(const Estimate& estimate) {
  Section section;
  section.title = "Intervals: " + WordOf(estimate.intervals.method);
  const AgreementReport& agreement = estimate.agreement;
  if (!agreement.kinds.empty()) {
    section.header = {"parts compared", "differences", "within 95 %", "inflation"};
    for (const PartComparison& kind : agreement.kinds) {
      section.rows.push_back({KindName(kind), std::to_string(kind.compared), Fixed(100.0 * kind.share(), 1) + " %",
                              Significant(kind.inflation, 3)});
    }
  }
  if (!estimate.intervals.words.empty()) section.paragraphs.push_back(estimate.intervals.words + ".");
  for (const std::string& words : agreement.words) section.paragraphs.push_back(words);
  return section;
}

std::string List(const std::vector<std::string>& names, const std::string& prefix) {
  std::string text;
  for (const std::string& name : names) {
    if (!text.empty()) text += ", ";
    text += prefix;
    text += name;
  }
  return text;
}

void AddIdentifiability(const CalibrationProblem& problem, const Estimate& estimate, std::vector<Section>* sections) {
  const Identifiability& found = estimate.identifiability;
  Section held, weak;
  held.title = "What the data do not determine (held)";
  const std::vector<Direction> open = LeftOpen(estimate);
  held.paragraphs = DirectionsInWords(open, open.size());
  if (!held.paragraphs.empty()) sections->push_back(held);
  weak.title = "What the data determine poorly (worse than 1 mm, 1 mrad or half its value)";
  for (const Direction& direction : found.weak) {
    if (direction.sigma < StatedTooLarge(estimate)) continue;  // for the stated noise alone
    weak.paragraphs.push_back("- " + direction.words + " (" + Significant(direction.sigma, 2) +
                              " of that limit). Remedy: " + direction.remedy + ".");
  }
  if (!weak.paragraphs.empty()) sections->push_back(weak);
  Section rank;
  rank.title = "Identifiability";
  rank.paragraphs = {"Rank " + std::to_string(found.rank) + ", condition " + Significant(found.condition, 3) +
                     " of the column-normalised Jacobian."};
  if (!problem.redundant_errors.empty()) {
    rank.paragraphs.push_back("Redundant, left at nominal (their effect is in the estimated ones): " +
                              List(problem.redundant_errors, "geometry/") + ".");
  }
  sections->push_back(rank);
}

size_t Width(const std::string& utf8) {
  return std::count_if(utf8.begin(), utf8.end(), [](char c) { return (c & 0xC0) != 0x80; });
}

// Column 0 and units flush left, numbers flush right.
std::string TableToText(const Section& section) {
  std::vector<std::vector<std::string>> rows = section.rows;
  rows.insert(rows.begin(), section.header);
  std::vector<size_t> widths(section.header.size());
  for (const auto& row : rows) {
    for (size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], Width(row[c]));
  }
  std::string text;
  for (const auto& row : rows) {
    std::string line = " ";
    for (size_t c = 0; c < row.size(); ++c) {
      const std::string padding(widths[c] - Width(row[c]), ' ');
      const bool left = c == 0 || section.header[c] == "unit" || section.header[c].empty();
      line += " " + (left ? row[c] + padding : padding + row[c]) + " ";
    }
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

constexpr size_t kTerminalWidth = 110;

std::string Wrapped(const std::string& paragraph) {
  const std::string indent = paragraph.rfind("- ", 0) == 0 ? "    " : "  ";
  std::string text, line = " ";
  std::istringstream words(paragraph);
  for (std::string word; words >> word;) {
    if (Width(line) + 1 + Width(word) > kTerminalWidth && line.size() > indent.size()) {
      text += line + "\n";
      line = indent.substr(1);
    }
    line += " " + word;
  }
  return text + line + "\n";
}

}  // namespace

int DecimalsFor(double size) {
  if (!(size > 0.0) || !std::isfinite(size)) return 4;
  return std::clamp(1 - static_cast<int>(std::floor(std::log10(size))), 0, 9);
}

std::string Millimetres(double metres, int decimals) { return Fixed(1e3 * metres, decimals); }

std::string ShownUnit(const std::string& unit) { return unit.rfind('u', 0) == 0 ? "µ" + unit.substr(1) : unit; }

std::vector<Section> Summarise(const CalibrationProblem& problem, const Estimate& estimate, double model_error) {
  std::vector<Section> sections = {ResultSection(problem, estimate)};
  sections.push_back(ResidualSection("Residuals on calibration observations", estimate.fit_before, estimate.fit));
  if (estimate.validation.observations > 0) sections.push_back(ValidationSection(estimate));
  if (estimate.deflection_before.observations > 0) {
    sections.push_back(ResidualSection("Deflections, loaded minus unloaded, " +
                                           Plural(estimate.deflection_before.observations, "pair") +
                                           ": measured, and measured minus predicted",
                                       estimate.deflection_before, estimate.deflection_after));
  }
  sections.push_back(NoiseSection(problem, estimate));
  const Section intervals = IntervalSection(estimate);
  if (!intervals.paragraphs.empty()) sections.push_back(intervals);
  sections.push_back(ParameterSection(problem, estimate, model_error));
  AddIdentifiability(problem, estimate, &sections);
  Section warnings;
  warnings.title = "Warnings";
  for (const std::string& warning : problem.data().warnings) warnings.paragraphs.push_back("- " + warning);
  for (const std::string& warning : estimate.warnings) warnings.paragraphs.push_back("- " + warning);
  if (!warnings.paragraphs.empty()) sections.push_back(warnings);
  return sections;
}

std::string SectionsToText(const std::vector<Section>& sections) {
  std::string text;
  for (const Section& section : sections) {
    text += (text.empty() ? "" : "\n") + section.title + "\n";
    if (!section.header.empty()) text += TableToText(section);
    for (const std::string& paragraph : section.paragraphs) text += Wrapped(paragraph);
  }
  return text;
}

}  // namespace sagitta

#include "tools/reproduce/table.h"

#include <algorithm>
#include <cmath>

#include "tools/report/html_text.h"
#include "tools/report/report_html.h"

namespace sagitta {
namespace {

// Of published figures: within a tenth they are reproduced, within half a decade in their order of magnitude. Choices.
constexpr double kNearPublished = 0.10;
constexpr double kFactor = 3.0;

// In addition to that of all pages.
constexpr const char* kStyle = R"(body{max-width:72em}th,td{text-align:left;vertical-align:top;white-space:normal}
.n{text-align:right}td+td{white-space:nowrap}td.n{white-space:pre}ol{margin:.5em 0;padding-left:1.8em}
figure td,figure th{text-align:right}.reproduced{color:#1a8b3f}.order{color:#a8701a}.not{color:#d2352b}.note,.input{opacity:.75}
)";

const char* StyleOf(Reproducibility verdict) {
  switch (verdict) {
    case Reproducibility::kReproduced:
      return "reproduced";
    case Reproducibility::kOrderOfMagnitude:
      return "order";
    case Reproducibility::kNotReproducible:
      return "not";
    case Reproducibility::kInput:
    case Reproducibility::kAddition:
      break;
  }
  return "input";
}

std::string Paragraph(const std::string& text) { return "<p>" + EscapeHtml(text) + "</p>\n"; }

// The reasons of a table, once each.
std::vector<std::string> ReasonsOf(const ReproducedTable& table) {
  std::vector<std::string> reasons;
  for (const ReproducedRow& row : table.rows) {
    const bool is_new = std::find(reasons.begin(), reasons.end(), row.why) == reasons.end();
    if (!row.why.empty() && is_new) reasons.push_back(row.why);
  }
  return reasons;
}

// " (2)": which of the reasons; "": none.
std::string ReasonNumber(const ReproducedRow& row, const std::vector<std::string>& reasons) {
  if (row.why.empty()) return "";
  const auto at = std::find(reasons.begin(), reasons.end(), row.why) - reasons.begin();
  return " (" + std::to_string(at + 1) + ")";
}

std::string RowToHtml(const ReproducedRow& row, const std::vector<std::string>& reasons) {
  return "<tr title=\"" + EscapeHtml(row.why) + "\"><td>" + EscapeHtml(row.quantity) + "</td><td class=\"n\">" +
         EscapeHtml(row.published) + "</td><td class=\"n\">" + EscapeHtml(row.computed) + "</td><td class=\"" +
         StyleOf(row.verdict) + "\">" + ReproducibilityName(row.verdict) + ReasonNumber(row, reasons) + "</td></tr>\n";
}

std::string ReproducedToHtml(const ReproducedTable& table) {
  const std::vector<std::string> reasons = ReasonsOf(table);
  std::string html = "<h2 id=\"" + EscapeHtml(table.id) + "\">" + EscapeHtml(table.id + "  " + table.title) +
                     "</h2>\n<p class=\"note\">" + EscapeHtml(SimulationNote()) +
                     "</p>\n<table><thead><tr><th>quantity</th><th class=\"n\">published</th><th "
                     "class=\"n\">computed</th><th>verdict</th></tr></thead><tbody>\n";
  for (const ReproducedRow& row : table.rows) html += RowToHtml(row, reasons);
  html += "</tbody></table>\n";
  if (!reasons.empty()) {
    html += "<ol class=\"note\">\n";
    for (const std::string& reason : reasons) html += "<li>" + EscapeHtml(reason) + "</li>\n";
    html += "</ol>\n";
  }
  for (const Picture& picture : table.pictures) html += PictureToHtml(picture);
  for (const std::string& note : table.notes) html += Paragraph(note);
  return html;
}

std::string OverviewToHtml(const std::vector<ReproducedTable>& tables) {
  const Section overview = OverviewSection(tables);
  std::string html = "<table><thead><tr>";
  for (const std::string& cell : overview.header) html += "<th>" + EscapeHtml(cell) + "</th>";
  html += "</tr></thead><tbody>\n";
  for (size_t t = 0; t < tables.size(); ++t) {
    html += "<tr><td><a href=\"#" + EscapeHtml(tables[t].id) + "\">" + EscapeHtml(overview.rows[t][0]) + "</a></td>";
    for (size_t c = 1; c < overview.rows[t].size(); ++c) {
      html += "<td class=\"n\">" + EscapeHtml(overview.rows[t][c]) + "</td>";
    }
    html += "</tr>\n";
  }
  return html + "</tbody></table>\n";
}

}  // namespace

const char* ReproducibilityName(Reproducibility verdict) {
  switch (verdict) {
    case Reproducibility::kReproduced:
      return "reproduced";
    case Reproducibility::kOrderOfMagnitude:
      return "order of magnitude";
    case Reproducibility::kNotReproducible:
      return "not reproducible";
    case Reproducibility::kAddition:
      return "not in the paper";
    case Reproducibility::kInput:
      break;
  }
  return "input";
}

int ReproducedTable::Count(Reproducibility verdict) const {
  int count = 0;
  for (const ReproducedRow& row : rows) count += row.verdict == verdict ? 1 : 0;
  return count;
}

Reproducibility JudgeRatio(double published, double computed, Reproducibility best) {
  const double ratio = computed / published;
  if (!(ratio > 1.0 / kFactor && ratio < kFactor)) return Reproducibility::kNotReproducible;
  if (std::abs(ratio - 1.0) <= kNearPublished) return best;
  return Reproducibility::kOrderOfMagnitude;
}

ReproducedRow& ReproducedTable::Compare(const std::string& quantity, double published_value, double computed_value,
                                        int decimals, const std::string& why, Reproducibility best) {
  State(quantity, Fixed(published_value, decimals), Fixed(computed_value, decimals),
        JudgeRatio(published_value, computed_value, best), why);
  rows.back().published_value = published_value;
  rows.back().computed_value = computed_value;
  return rows.back();
}

ReproducedRow& ReproducedTable::State(const std::string& quantity, const std::string& published_text,
                                      const std::string& computed_text, Reproducibility verdict,
                                      const std::string& why) {
  ReproducedRow row;
  row.quantity = quantity;
  row.published = published_text;
  row.computed = computed_text;
  row.verdict = verdict;
  row.why = why;
  rows.push_back(row);
  return rows.back();
}

const std::string& SimulationNote() {
  static const std::string note =
      "No raw measurements are published: the published parameters, configurations, loads and noise drive the "
      "simulation behind every computed number.";
  return note;
}

Section TableToSection(const ReproducedTable& table) {
  Section section;
  section.title = table.id + "  " + table.title;
  section.header = {"quantity", "published", "computed", "verdict"};
  const std::vector<std::string> reasons = ReasonsOf(table);
  for (const ReproducedRow& row : table.rows) {
    section.rows.push_back(
        {row.quantity, row.published, row.computed, ReproducibilityName(row.verdict) + ReasonNumber(row, reasons)});
  }
  for (size_t i = 0; i < reasons.size(); ++i) {
    section.paragraphs.push_back("(" + std::to_string(i + 1) + ") " + reasons[i]);
  }
  for (const std::string& note : table.notes) section.paragraphs.push_back(note);
  section.paragraphs.push_back(SimulationNote());
  return section;
}

Section OverviewSection(const std::vector<ReproducedTable>& tables) {
  Section section;
  section.title = "Published tables and figures: rows by verdict";
  section.header = {"table", "reproduced", "order of magnitude", "not reproducible", "input", "not in the paper"};
  for (const ReproducedTable& table : tables) {
    section.rows.push_back({table.id + "  " + table.title});
    for (const Reproducibility verdict :
         {Reproducibility::kReproduced, Reproducibility::kOrderOfMagnitude, Reproducibility::kNotReproducible,
          Reproducibility::kInput, Reproducibility::kAddition}) {
      section.rows.back().push_back(std::to_string(table.Count(verdict)));
    }
  }
  return section;
}

nlohmann::ordered_json TableToJson(const ReproducedTable& table) {
  nlohmann::ordered_json json = {{"id", table.id}, {"title", table.title}, {"note", SimulationNote()}};
  json["rows"] = nlohmann::ordered_json::array();
  for (const ReproducedRow& row : table.rows) {
    nlohmann::ordered_json entry = {{"quantity", row.quantity}};
    const bool numbers = std::isfinite(row.published_value) && std::isfinite(row.computed_value);
    if (numbers) {
      entry["published"] = row.published_value;
      entry["computed"] = row.computed_value;
    } else {
      entry["published"] = row.published;
      entry["computed"] = row.computed;
    }
    if (!row.numbers.empty()) entry["numbers"] = row.numbers;
    entry["verdict"] = ReproducibilityName(row.verdict);
    if (!row.why.empty()) entry["why"] = row.why;
    json["rows"].push_back(entry);
  }
  json["notes"] = table.notes;
  return json;
}

std::string ReproductionToHtml(const std::vector<ReproducedTable>& tables, const std::string& command) {
  std::string html = "<h1>Published tables side by side</h1>\n" + Paragraph(SimulationNote()) + OverviewToHtml(tables);
  std::vector<const Picture*> pictures;
  for (const ReproducedTable& table : tables) {
    html += ReproducedToHtml(table);
    for (const Picture& picture : table.pictures) pictures.push_back(&picture);
  }
  html += "<h2>Provenance</h2>\n<p>sagitta " SAGITTA_VERSION "</p>\n<p><code>" + EscapeHtml(command) + "</code></p>\n";
  return PageAround("Published tables side by side", kStyle, html, pictures);
}

}  // namespace sagitta

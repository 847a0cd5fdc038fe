#include "tools/report/report_html.h"

#include <algorithm>
#include <cmath>

#include "estimator/results/residuals_csv.h"
#include "tools/report/summary.h"
#include "tools/report/svg.h"

namespace sagitta {
namespace {

constexpr int kBins = 30;
constexpr double kRange = 4.0;     // standard deviations shown
constexpr size_t kMostBars = 400;  // configurations drawn one by one; more: groups of neighbours

constexpr const char* kStyle = R"(body{font:15px/1.5 sans-serif;max-width:60em;margin:2em auto;padding:0 1em;color:#222}
h1{font-size:1.5em}h2{font-size:1.15em;margin-top:1.8em;border-bottom:1px solid #ccc}
table{border-collapse:collapse}th,td{padding:.15em .9em .15em 0;text-align:right;font-variant-numeric:tabular-nums}
th:first-child,td:first-child,.unit{text-align:left}td:first-child{white-space:pre}tr:nth-child(even) td{background:#f5f5f5}
svg{margin:.5em 1em .5em 0;max-width:100%;height:auto}svg text{font:11px sans-serif;fill:#444}code{background:#f5f5f5;word-break:break-all}
summary{cursor:pointer}summary h2{display:inline-block;margin:.4em 0}
.bar{fill:#4a78b0}.held-out{fill:#d9822b}.line{stroke:#b33;fill:none;stroke-width:1.5}.axis{stroke:#888}
.dot,.model,.beyond{fill:none;stroke-width:4;stroke-linecap:round}.beyond{stroke:#d9822b}.dot{stroke:#4a78b0;stroke-opacity:.55}.model{stroke:#b33}.taken{fill:#4a78b0;fill-opacity:.2}
@media print{body{margin:0;max-width:none;font-size:11px}h2{break-after:avoid}tr,svg{break-inside:avoid}}
)";

// Counts in bins over +-kRange; what lies beyond is in the outermost bins.
std::vector<int> Histogram(const std::vector<double>& values) {
  std::vector<int> counts(kBins);
  for (const double value : values) {
    const double position = (value + kRange) / (2.0 * kRange) * kBins;
    ++counts[static_cast<int>(std::clamp(position, 0.0, kBins - 1.0))];
  }
  return counts;
}

std::string HistogramSvg(char axis, const std::vector<double>& values) {
  constexpr double kWidth = 260, kHeight = 160, kFloor = 135;
  const std::vector<int> counts = Histogram(values);
  const double expected_peak = values.size() * 2.0 * kRange / kBins * 0.3989422804;
  const double highest = std::max({1.0, expected_peak, 1.0 * *std::max_element(counts.begin(), counts.end())});
  const double scale = (kFloor - 20) / highest, step = kWidth / kBins;
  std::string body;
  for (int b = 0; b < kBins; ++b) {
    body += svg::Rectangle(b * step, kFloor - scale * counts[b], step - 1, scale * counts[b], "bar",
                           std::to_string(counts[b])) +
            "\n";
  }
  std::vector<std::pair<double, double>> normal;
  for (int i = 0; i <= 80; ++i) {
    const double u = kRange * (i / 40.0 - 1.0);
    normal.emplace_back(kWidth * i / 80.0, kFloor - scale * expected_peak * std::exp(-0.5 * u * u));
  }
  body += svg::Curve(normal) + "\n";
  body += "<line class=\"axis\" x1=\"0\" x2=\"260\" y1=\"135\" y2=\"135\"/>\n";
  for (const int tick : {-3, -2, -1, 0, 1, 2, 3}) {
    body += svg::Text(kWidth * (tick + kRange) / (2.0 * kRange), 150, "middle", std::to_string(tick)) + "\n";
  }
  body += svg::Text(4, 12, "start", std::string(1, axis)) + "\n";
  return svg::Picture(kWidth, kHeight, std::string("whitened residuals in ") + axis, "\n" + body);
}

std::string Histograms(const CalibrationProblem& problem, const Estimate& estimate) {
  const Eigen::Matrix3Xd whitened = WhitenedResiduals(problem, estimate);
  const double scale = estimate.sigma.scaled ? estimate.sigma.a_posteriori : 1.0;
  std::string html = "<h2>Whitened residuals</h2>\n<p>(measured − predicted) / sigma of calibration rows";
  if (estimate.sigma.scaled) html += ", divided by the a-posteriori sigma " + Significant(scale, 3);
  html += "; the line is the normal distribution.</p>\n";
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const int i : problem.CalibrationObservations()) {
      if (std::isfinite(whitened(axis, i))) values.push_back(whitened(axis, i) / scale);
    }
    html += HistogramSvg("xyz"[axis], values);
  }
  return html;
}

struct Bar {
  double squared = 0.0;  // m^2
  int observations = 0;
  bool is_validation = false;
  std::string name;
  double rms() const { return std::sqrt(squared / std::max(1, observations)); }
};

std::vector<Bar> BarPerConfiguration(const CalibrationProblem& problem, const Estimate& estimate) {
  const Measurements& data = problem.data;
  std::vector<Bar> bars(data.configurations.size());
  for (size_t i = 0; i < data.observations.size(); ++i) {
    const int configuration = data.shots[data.observations[i].shot].configuration;
    if (!data.observations[i].is_point()) continue;
    bars[configuration].squared += (data.observations[i].point_in_station - estimate.predicted.col(i)).squaredNorm();
    ++bars[configuration].observations;
  }
  for (size_t c = 0; c < bars.size(); ++c) {
    bars[c].name = data.configurations[c].id;
    bars[c].is_validation = data.configurations[c].is_validation;
  }
  return bars;
}

// In order of the rows; neighbours merge where there are too many, those held out apart from those fitted.
std::vector<Bar> BarsOf(const CalibrationProblem& problem, const Estimate& estimate) {
  const std::vector<Bar> bars = BarPerConfiguration(problem, estimate);
  if (bars.size() <= kMostBars) return bars;
  std::vector<Bar> merged;
  for (size_t group = 0; group < kMostBars; ++group) {
    const size_t first = group * bars.size() / kMostBars, last = (group + 1) * bars.size() / kMostBars;
    for (const bool is_validation : {false, true}) {
      Bar sum;
      sum.is_validation = is_validation;
      for (size_t c = first; c < last; ++c) {
        if (bars[c].is_validation != is_validation) continue;
        if (sum.name.empty()) sum.name = (is_validation ? "held out, from " : "from ") + bars[c].name;
        sum.squared += bars[c].squared;
        sum.observations += bars[c].observations;
      }
      if (sum.observations > 0) merged.push_back(sum);
    }
  }
  return merged;
}

std::string ConfigurationSvg(const std::vector<Bar>& bars) {
  constexpr double kWidth = 840, kHeight = 190, kFloor = 170;
  double highest = 1e-9;
  for (const Bar& bar : bars) highest = std::max(highest, bar.rms());
  const double step = kWidth / bars.size();
  std::string body;
  for (size_t i = 0; i < bars.size(); ++i) {
    const double height = (kFloor - 20) * bars[i].rms() / highest;
    body += svg::Rectangle(i * step, kFloor - height, std::max(0.5, 0.8 * step), height,
                           bars[i].is_validation ? "held-out" : "bar",
                           bars[i].name + ": " + Fixed(1e3 * bars[i].rms(), 4) + " mm") +
            "\n";
  }
  body += "<line class=\"axis\" x1=\"0\" x2=\"840\" y1=\"170\" y2=\"170\"/>\n";
  body += svg::Text(4, 12, "start", Fixed(1e3 * highest, 3) + " mm at most") + "\n";
  body += svg::Text(0, 185, "start", bars.front().name) + "\n";
  body += svg::Text(kWidth, 185, "end", bars.back().name) + "\n";
  return svg::Picture(kWidth, kHeight, "RMS distance per configuration", "\n" + body);
}

std::string SectionToHtml(const Section& section, const char* heading) {
  const std::string title = std::string("<") + heading + ">" + EscapeHtml(section.title) + "</" + heading + ">";
  std::string html = section.folded ? "<details><summary>" + title + "</summary>\n" : title + "\n";
  if (!section.header.empty()) {
    html += "<table><thead><tr>";
    for (const std::string& cell : section.header) html += "<th>" + EscapeHtml(cell) + "</th>";
    html += "</tr></thead><tbody>\n";
    for (const auto& row : section.rows) {
      html += "<tr>";
      for (size_t c = 0; c < row.size(); ++c) {
        html += std::string("<td") + (section.header[c] == "unit" ? " class=\"unit\"" : "") + ">" + EscapeHtml(row[c]) +
                "</td>";
      }
      html += "</tr>\n";
    }
    html += "</tbody></table>\n";
  }
  for (const std::string& paragraph : section.paragraphs) html += "<p>" + EscapeHtml(paragraph) + "</p>\n";
  return html + section.figure + (section.folded ? "</details>\n" : "");
}

std::string ProvenanceToHtml(const Provenance& provenance) {
  std::string html = "<h2>Provenance</h2>\n<p>sagitta " SAGITTA_VERSION ", method " + EscapeHtml(provenance.method) +
                     ", run " + RunId(provenance) + "</p>\n<p><code>" + EscapeHtml(provenance.command) +
                     "</code></p>\n<table><tbody>\n";
  for (const InputFile& input : provenance.inputs) {
    html +=
        "<tr><td>" + EscapeHtml(input.path) + "</td><td class=\"unit\"><code>" + input.sha256 + "</code></td></tr>\n";
  }
  return html + "</tbody></table>\n";
}

}  // namespace

std::string SectionsToPage(const std::vector<Section>& sections, const std::string& charts,
                           const Provenance& provenance) {
  std::string html = "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>" +
                     EscapeHtml(sections.front().title) + " - sagitta</title>\n<style>" + kStyle +
                     "</style></head><body>\n";
  for (size_t i = 0; i < sections.size(); ++i) html += SectionToHtml(sections[i], i == 0 ? "h1" : "h2");
  return html + charts + ProvenanceToHtml(provenance) + "</body></html>\n";
}

std::string ResidualCharts(const CalibrationProblem& problem, const Estimate& estimate) {
  return Histograms(problem, estimate) +
         "<h2>Residual per configuration</h2>\n<p>RMS distance; validation configurations in orange.</p>\n" +
         ConfigurationSvg(BarsOf(problem, estimate));
}

std::string ReportToHtml(const CalibrationProblem& problem, const Estimate& estimate, const Provenance& provenance) {
  return SectionsToPage(Summarise(problem, estimate), ResidualCharts(problem, estimate), provenance);
}

}  // namespace sagitta

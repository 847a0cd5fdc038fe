#include "tools/charts.h"

#include <algorithm>
#include <cmath>

#include "tools/report_html.h"
#include "tools/summary.h"

namespace sagitta {
namespace {

constexpr double kWidth = 300, kWide = 400, kTop = 24, kFloor = 130, kHeight = 150;
constexpr int kBins = 12;

std::string N(double value) { return Fixed(value, 1); }

std::string Text(double x, double y, const std::string& anchor, const std::string& text) {
  return "<text x=\"" + N(x) + "\" y=\"" + N(y) + "\" text-anchor=\"" + anchor + "\">" + EscapeHtml(text) + "</text>";
}

std::string Canvas(const std::string& title, const std::string& body, double width, double height) {
  return "<svg role=\"img\" width=\"" + N(width) + "\" height=\"" + N(height) + "\" viewBox=\"0 0 " + N(width) + " " +
         N(height) + "\"><title>" + EscapeHtml(title) + "</title>" + Text(0, 12, "start", title) + body + "</svg>\n";
}

// With a base line.
std::string Frame(const std::string& title, const std::string& body, double width = kWidth) {
  return Canvas(title,
                body + "<line class=\"axis\" x1=\"0\" x2=\"" + N(width) + "\" y1=\"" + N(kFloor) + "\" y2=\"" +
                    N(kFloor) + "\"/>",
                width, kHeight);
}

}  // namespace

std::string LineChart(const std::string& title, const std::vector<double>& values, int decimals) {
  const double low = *std::min_element(values.begin(), values.end());
  const double high = *std::max_element(values.begin(), values.end());
  const double scale = high > low ? (kFloor - kTop) / (high - low) : 0.0;
  std::string points;
  for (size_t i = 0; i < values.size(); ++i) {
    points +=
        N(kWidth * i / std::max<size_t>(1, values.size() - 1)) + "," + N(kFloor - scale * (values[i] - low)) + " ";
  }
  return Frame(title + ": " + Fixed(low, decimals) + " ... " + Fixed(high, decimals),
               "<polyline class=\"line\" points=\"" + points + "\"/>" + Text(0, kHeight - 6, "start", "0") +
                   Text(kWidth, kHeight - 6, "end", std::to_string(values.size() - 1)));
}

std::string HistogramChart(const std::string& title, const std::vector<double>& values, int decimals) {
  const double low = *std::min_element(values.begin(), values.end());
  const double high = *std::max_element(values.begin(), values.end());
  std::vector<int> counts(kBins);
  for (const double value : values) {
    const double position = high > low ? (value - low) / (high - low) * kBins : 0.0;
    ++counts[static_cast<int>(std::clamp(position, 0.0, kBins - 1.0))];
  }
  const double scale = (kFloor - kTop) / *std::max_element(counts.begin(), counts.end()), step = kWidth / kBins;
  std::string body;
  for (int b = 0; b < kBins; ++b) {
    body += "<rect class=\"bar\" x=\"" + N(b * step) + "\" y=\"" + N(kFloor - scale * counts[b]) + "\" width=\"" +
            N(step - 1) + "\" height=\"" + N(scale * counts[b]) + "\"><title>" + std::to_string(counts[b]) +
            "</title></rect>";
  }
  return Frame(title, body + Text(0, kHeight - 6, "start", Fixed(low, decimals)) +
                          Text(kWidth, kHeight - 6, "end", Fixed(high, decimals)));
}

std::string ScatterChart(const std::string& title, const std::string& x_label, const std::vector<double>& x,
                         const std::vector<double>& measured, const std::vector<double>& model) {
  if (x.empty()) return "";
  const auto [left, right] = std::minmax_element(x.begin(), x.end());
  double reach = 0.0;
  for (const std::vector<double>* values : {&measured, &model}) {
    for (const double value : *values) reach = std::max(reach, std::abs(value));
  }
  const double middle = 0.5 * (kTop + kFloor);
  const double across = *right > *left ? kWide / (*right - *left) : 0.0;
  const double up = reach > 0.0 ? 0.5 * (kFloor - kTop) / reach : 0.0;
  std::string body =
      "<line class=\"axis\" x1=\"0\" x2=\"" + N(kWide) + "\" y1=\"" + N(middle) + "\" y2=\"" + N(middle) + "\"/>";
  const auto dots = [&](const std::vector<double>& values, const char* style) {
    for (size_t i = 0; i < values.size(); ++i) {
      body += std::string("<circle class=\"") + style + "\" r=\"2\" cx=\"" + N(across * (x[i] - *left)) + "\" cy=\"" +
              N(middle - up * values[i]) + "\"/>";
    }
  };
  dots(measured, "dot");
  dots(model, "model");
  return Frame(title + ", within " + Significant(reach, 2),
               body + Text(0, kHeight - 6, "start", Significant(*left, 3)) +
                   Text(0.5 * kWide, kHeight - 6, "middle", x_label) +
                   Text(kWide, kHeight - 6, "end", Significant(*right, 3)),
               kWide);
}

std::string WaterfallChart(const std::string& title, const std::vector<Stage>& stages, double floor,
                           const std::string& floor_name) {
  double highest = floor;
  for (const Stage& stage : stages) highest = std::max(highest, stage.value);
  const double scale = highest > 0.0 ? (kFloor - kTop - 14) / highest : 0.0;
  const double step = std::max(60.0, kWide / static_cast<double>(stages.size()));
  const double width = step * static_cast<double>(stages.size());
  std::string body;
  for (size_t i = 0; i < stages.size(); ++i) {
    const double x = step * static_cast<double>(i), top = kFloor - scale * stages[i].value;
    const double before = i > 0 ? kFloor - scale * stages[i - 1].value : top;
    body += "<rect class=\"bar\" x=\"" + N(x) + "\" y=\"" + N(top) + "\" width=\"" + N(0.8 * step) + "\" height=\"" +
            N(kFloor - top) + "\"><title>" + EscapeHtml(stages[i].name) + "</title></rect>";
    if (top > before) {
      body += "<rect class=\"taken\" x=\"" + N(x) + "\" y=\"" + N(before) + "\" width=\"" + N(0.8 * step) +
              "\" height=\"" + N(top - before) + "\"/>";
    }
    body += Text(x + 0.4 * step, std::min(top, before) - 4, "middle", Significant(stages[i].value, 3)) +
            Text(x + 0.4 * step, kHeight - 6, "middle", i == 0 ? "before" : "step " + std::to_string(i));
  }
  body += "<line class=\"line\" x1=\"0\" x2=\"" + N(width) + "\" y1=\"" + N(kFloor - scale * floor) + "\" y2=\"" +
          N(kFloor - scale * floor) + "\"/>";
  return Frame(title + " (line: " + floor_name + ", " + Significant(floor, 3) + ")", body, width);
}

std::string BarChart(const std::string& title, const std::vector<Stage>& bars) {
  constexpr double kRow = 16, kNames = 110;
  double highest = 0.0;
  for (const Stage& bar : bars) highest = std::max(highest, bar.value);
  const double height = kTop + kRow * static_cast<double>(bars.size()) + 4;
  std::string body;
  for (size_t i = 0; i < bars.size(); ++i) {
    const double y = kTop + kRow * static_cast<double>(i);
    const double length = highest > 0.0 ? (kWidth - kNames - 50) * bars[i].value / highest : 0.0;
    body += Text(kNames - 6, y + 11, "end", bars[i].name) + "<rect class=\"bar\" x=\"" + N(kNames) + "\" y=\"" + N(y) +
            "\" width=\"" + N(length) + "\" height=\"" + N(kRow - 4) + "\"/>" +
            Text(kNames + length + 4, y + 11, "start", Significant(bars[i].value, 2));
  }
  return Canvas(title, body, kWidth, height);
}

}  // namespace sagitta

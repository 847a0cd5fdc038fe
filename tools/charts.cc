#include "tools/charts.h"

#include <algorithm>

#include "tools/report_html.h"
#include "tools/summary.h"

namespace sagitta {
namespace {

constexpr double kWidth = 300, kTop = 24, kFloor = 130, kHeight = 150;
constexpr int kBins = 12;

std::string N(double value) { return Fixed(value, 1); }

std::string Text(double x, double y, const std::string& anchor, const std::string& text) {
  return "<text x=\"" + N(x) + "\" y=\"" + N(y) + "\" text-anchor=\"" + anchor + "\">" + EscapeHtml(text) + "</text>";
}

std::string Frame(const std::string& title, const std::string& body) {
  return "<svg role=\"img\" width=\"" + N(kWidth) + "\" height=\"" + N(kHeight) + "\" viewBox=\"0 0 " + N(kWidth) +
         " " + N(kHeight) + "\"><title>" + EscapeHtml(title) + "</title>" + Text(0, 12, "start", title) + body +
         "<line class=\"axis\" x1=\"0\" x2=\"" + N(kWidth) + "\" y1=\"" + N(kFloor) + "\" y2=\"" + N(kFloor) +
         "\"/></svg>\n";
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

}  // namespace sagitta

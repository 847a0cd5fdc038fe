#include "tools/report/charts.h"

#include <algorithm>
#include <cmath>

#include "tools/report/summary.h"
#include "tools/report/svg.h"

namespace sagitta {
namespace {

constexpr double kWidth = 300, kWide = 400, kTop = 24, kFloor = 130, kHeight = 150;
constexpr double kTickRoom = 52, kDotRoom = 3;  // left of a scatter for its figures, around its dots
constexpr int kBins = 12;
constexpr double kMostOfThem = 0.95, kFarBeyond = 3.0;  // the axis ends at so many times what that share keeps within

std::string Canvas(const std::string& title, const std::string& body, double width, double height) {
  return svg::Picture(width, height, title, svg::Text(0, 12, "start", title) + body);
}

// With a base line.
std::string Frame(const std::string& title, const std::string& body, double width = kWidth) {
  return Canvas(title, body + svg::LevelLine(kFloor, width, "axis"), width, kHeight);
}

}  // namespace

std::string LineChart(const std::string& title, const std::vector<double>& values, int decimals) {
  const double low = *std::min_element(values.begin(), values.end());
  const double high = *std::max_element(values.begin(), values.end());
  const double scale = high > low ? (kFloor - kTop) / (high - low) : 0.0;
  std::vector<std::pair<double, double>> points;
  for (size_t i = 0; i < values.size(); ++i) {
    points.emplace_back(kWidth * i / std::max<size_t>(1, values.size() - 1), kFloor - scale * (values[i] - low));
  }
  return Frame(title + ": " + Fixed(low, decimals) + " ... " + Fixed(high, decimals),
               svg::Curve(points) + svg::Text(0, kHeight - 6, "start", "0") +
                   svg::Text(kWidth, kHeight - 6, "end", std::to_string(values.size() - 1)));
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
    body += svg::Rectangle(b * step, kFloor - scale * counts[b], step - 1, scale * counts[b], "bar",
                           std::to_string(counts[b]));
  }
  return Frame(title, body + svg::Text(0, kHeight - 6, "start", Fixed(low, decimals)) +
                          svg::Text(kWidth, kHeight - 6, "end", Fixed(high, decimals)));
}

namespace {

// Where the axis of a scatter ends: at the largest size, unless few values lie so far out that the others would be a
// line.
double ReachOf(const std::vector<double>& blue, const std::vector<double>& red) {
  std::vector<double> sizes;
  for (const std::vector<double>* values : {&blue, &red}) {
    for (const double value : *values) sizes.push_back(std::abs(value));
  }
  if (sizes.empty()) return 0.0;
  std::sort(sizes.begin(), sizes.end());
  const auto rank = static_cast<size_t>(std::ceil(kMostOfThem * sizes.size()));
  const double most = sizes[std::max<size_t>(rank, 1) - 1];
  return most > 0.0 ? std::min(sizes.back(), kFarBeyond * most) : sizes.back();
}

}  // namespace

std::string ScatterChart(const std::string& title, const std::string& x_label, const std::vector<double>& x,
                         const std::vector<double>& blue, const std::vector<double>& red) {
  if (x.empty()) return "";
  const auto ends = std::minmax_element(x.begin(), x.end());
  const double left = *ends.first, right = *ends.second;  // C++17 lambdas capture no structured bindings
  const double reach = ReachOf(blue, red);
  const double middle = 0.5 * (kTop + kFloor);
  const double origin = kTickRoom + kDotRoom, width = kWide - origin - kDotRoom;
  const double across = right > left ? width / (right - left) : 0.0;
  const double up = reach > 0.0 ? (0.5 * (kFloor - kTop) - kDotRoom) / reach : 0.0;
  std::string body = svg::LevelLine(middle, kWide, "axis");
  int beyond = 0;
  const auto dots = [&](const std::vector<double>& values, const char* style) {
    std::vector<std::pair<double, double>> points, far;
    for (size_t i = 0; i < values.size(); ++i) {
      const bool is_far = std::abs(values[i]) > reach;
      (is_far ? far : points)
          .emplace_back(origin + across * (x[i] - left), middle - up * std::clamp(values[i], -reach, reach));
    }
    body += svg::Dots(points, style);
    if (!far.empty()) body += svg::Dots(far, "beyond");
    beyond += static_cast<int>(far.size());
  };
  dots(blue, "dot");
  dots(red, "model");
  body += svg::Text(0, kTop + 8, "start", Significant(reach, 3)) + svg::Text(0, middle - 3, "start", "0") +
          svg::Text(0, kFloor - 3, "start", Significant(-reach, 3));
  const std::string left_out = beyond > 0 ? " (" + std::to_string(beyond) + " beyond the axis, in orange)" : "";
  return Frame(title + left_out,
               body + svg::Text(origin, kHeight - 6, "start", Significant(left, 3)) +
                   svg::Text(origin + 0.5 * width, kHeight - 6, "middle", x_label) +
                   svg::Text(kWide, kHeight - 6, "end", Significant(right, 3)),
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
  double before = kFloor;
  for (size_t i = 0; i < stages.size(); ++i) {
    if (!std::isfinite(stages[i].value)) continue;  // that stage did not converge
    const double x = step * static_cast<double>(i), top = kFloor - scale * stages[i].value;
    body += svg::Rectangle(x, top, 0.8 * step, kFloor - top, "bar", stages[i].name);
    if (top > before) body += svg::Rectangle(x, before, 0.8 * step, top - before, "taken");
    body += svg::Text(x + 0.4 * step, std::min(top, before) - 4, "middle", Significant(stages[i].value, 3)) +
            svg::Text(x + 0.4 * step, kHeight - 6, "middle", i == 0 ? "before" : "step " + std::to_string(i));
    before = top;
  }
  body += svg::LevelLine(kFloor - scale * floor, width, "line");
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
    body += svg::Text(kNames - 6, y + 11, "end", bars[i].name) + svg::Rectangle(kNames, y, length, kRow - 4, "bar") +
            svg::Text(kNames + length + 4, y + 11, "start", Significant(bars[i].value, 2));
  }
  return Canvas(title, body, kWidth, height);
}

}  // namespace sagitta

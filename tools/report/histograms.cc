#include "tools/report/histograms.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "estimator/results/residuals_csv.h"
#include "problems/text.h"

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kDistanceBins = 48, kWhitenedBins = 30, kPlainBins = 12;
constexpr double kRange = 4.0;           // standard deviations shown
constexpr double kLeastDistance = 1e-7;  // mm; shorter ones count as this on the logarithmic axis

struct Bins {
  double low = 0.0, high = 1.0;
  int number = 1;

  double Edge(int b) const { return low + (high - low) * b / number; }
  // What lies beyond is in the outermost bins.
  std::vector<int> Counts(const std::vector<double>& values) const {
    std::vector<int> counts(number);
    for (const double value : values) {
      const double position = (value - low) / (high - low) * number;
      ++counts[static_cast<int>(std::clamp(position, 0.0, number - 1.0))];
    }
    return counts;
  }
};

// Appends the bins of one series to the data; `shown`: an edge as the table says it.
template <typename Shown>
void AddSeries(const std::string& series, const Bins& bins, const std::vector<double>& values, const Shown& shown,
               Picture* picture) {
  Json& data = picture->data["bins"];
  const std::vector<int> counts = bins.Counts(values);
  for (int b = 0; b < bins.number; ++b) {
    data["series"].push_back(series);
    data["from"].push_back(Rounded(bins.Edge(b), 6));
    data["to"].push_back(Rounded(bins.Edge(b + 1), 6));
    data["count"].push_back(counts[b]);
    if (counts[b] == 0) continue;
    picture->rows.push_back({series, shown(bins.Edge(b)), shown(bins.Edge(b + 1)), std::to_string(counts[b])});
  }
}

// Over the range of all; of one value alone a tenth about it.
Bins BinsOver(const std::vector<NamedSeries>& series, int number) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const NamedSeries& one : series) {
    for (const double value : one.values) {
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  if (!(low <= high)) return {0.0, 1.0, number};
  if (low == high) return {low - 0.05, high + 0.05, number};
  return {low, high, number};
}

std::vector<double> DecimalLogarithms(const std::vector<double>& distances) {
  std::vector<double> logarithms;
  for (const double distance : distances) logarithms.push_back(std::log10(std::max(kLeastDistance, 1e3 * distance)));
  return logarithms;
}

}  // namespace

std::vector<Picture> BeforeAndAfter(const UnseenPoints& before, const UnseenPoints& after) {
  if (before.points == 0 || after.points == 0 || !(before.distance_max > 0.0) || !(after.distance_max > 0.0)) return {};
  Picture picture;
  picture.kind = "histogram";
  picture.title = "Distance between measured and predicted point, before and after; lines: median and 95th percentile";
  picture.settings = {{"xTitle", "distance, mm"}, {"ten", true}};
  picture.header = {"", "from, mm", "to, mm", "points"};
  const std::vector<double> was = DecimalLogarithms(before.distances), is = DecimalLogarithms(after.distances);
  const Bins bins = BinsOver({{"before", was}, {"after", is}}, kDistanceBins);
  const auto shown = [](double logarithm) { return Significant(std::pow(10.0, logarithm), 3); };
  for (const bool is_after : {false, true}) {
    const std::string series = is_after ? "after" : "before";
    const UnseenPoints& points = is_after ? after : before;
    AddSeries(series, bins, is_after ? is : was, shown, &picture);
    int line = 0;
    for (const auto& [name, distance] : {std::pair<const char*, double>{"P50", points.distance_p50},
                                         std::pair<const char*, double>{"P95", points.distance_p95}}) {
      Json& places = picture.data["places"];
      places["series"].push_back(series);
      places["x"].push_back(Rounded(std::log10(std::max(kLeastDistance, 1e3 * distance)), 6));
      places["label"].push_back(std::string(name) + " " + Significant(1e3 * distance, 3) + " mm");
      places["line"].push_back(line++);
    }
  }
  return {picture};
}

Picture HistogramPicture(const std::string& title, const std::string& x_label, const std::vector<NamedSeries>& series) {
  Picture picture;
  picture.kind = "histogram";
  picture.title = title;
  picture.settings = {{"xTitle", x_label}};
  picture.header = {"", x_label + ", from", x_label + ", to", "count"};
  const Bins bins = BinsOver(series, kPlainBins);
  for (const NamedSeries& one : series)
    AddSeries(
        one.name, bins, one.values, [](double edge) { return Significant(edge, 3); }, &picture);
  return picture;
}

Picture WhitenedHistogram(const CalibrationProblem& problem, const Estimate& estimate) {
  const Eigen::Matrix3Xd whitened = WhitenedResiduals(problem, estimate);
  const double scale = estimate.sigma.scaled ? estimate.sigma.a_posteriori : 1.0;
  Picture picture;
  picture.kind = "histogram";
  picture.title = "Whitened residuals: (measured − predicted) / sigma of calibration rows";
  if (estimate.sigma.scaled) picture.title += ", divided by the a-posteriori sigma " + Significant(scale, 3);
  picture.title += "; the curve is the normal distribution";
  picture.settings = {{"xTitle", "standard deviations; those beyond 4 are in the last bars"}};
  picture.header = {"axis", "from, standard deviations", "to, standard deviations", "rows"};
  const Bins bins{-kRange, kRange, kWhitenedBins};
  const std::vector<int> fitted = problem.CalibrationObservations();
  for (int axis = 0; axis < 3; ++axis) {
    const std::string series(1, "xyz"[axis]);
    std::vector<double> values;
    for (const int i : fitted) {
      if (std::isfinite(whitened(axis, i))) values.push_back(whitened(axis, i) / scale);
    }
    AddSeries(
        series, bins, values, [](double edge) { return Fixed(edge, 2); }, &picture);
    // The density times what a bar stands for.
    const double peak = values.size() * (2.0 * kRange / kWhitenedBins) / std::sqrt(2.0 * M_PI);
    for (int i = 0; i <= 80; ++i) {
      const double u = kRange * (i / 40.0 - 1.0);
      Json& curve = picture.data["curve"];
      curve["series"].push_back(series);
      curve["x"].push_back(Rounded(u));
      curve["count"].push_back(Rounded(peak * std::exp(-0.5 * u * u)));
    }
  }
  return picture;
}

}  // namespace sagitta

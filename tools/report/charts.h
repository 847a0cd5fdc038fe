// Inline SVG for reports.
#pragma once

#include <string>
#include <vector>

namespace sagitta {

// Values over 0, 1, 2 …; the range is written at the axis.
std::string LineChart(const std::string& title, const std::vector<double>& values, int decimals);

// Counts in equal bins between the extremes.
std::string HistogramChart(const std::string& title, const std::vector<double>& values, int decimals);

// Two values over each x, as what was measured and what the model says there; either may be empty.
std::string ScatterChart(const std::string& title, const std::string& x_label, const std::vector<double>& x,
                         const std::vector<double>& blue, const std::vector<double>& red);

// A value after each stage, what each stage took away, and the floor that none can go below.
struct Stage {
  std::string name;
  double value;
};
std::string WaterfallChart(const std::string& title, const std::vector<Stage>& stages, double floor,
                           const std::string& floor_name);

// One bar per name, longest first or as given.
std::string BarChart(const std::string& title, const std::vector<Stage>& bars);

}  // namespace sagitta

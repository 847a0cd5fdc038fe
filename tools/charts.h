// Inline SVG for reports.
#pragma once

#include <string>
#include <vector>

namespace sagitta {

// Values over 0, 1, 2 …; the range is written at the axis.
std::string LineChart(const std::string& title, const std::vector<double>& values, int decimals);

// Counts in equal bins between the extremes.
std::string HistogramChart(const std::string& title, const std::vector<double>& values, int decimals);

}  // namespace sagitta

// The drawn figures themselves: what a reader sees in them, taken from the SVG.
#include "tools/report/charts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <regex>
#include <set>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/results/provenance.h"
#include "tests/support/kr270_experiment.h"
#include "tools/report/report_html.h"

namespace sagitta {
namespace {

using ::testing::HasSubstr;

struct Dot {
  double x, y;
};

std::vector<Dot> DotsOf(const std::string& svg, const std::string& style) {
  std::smatch path;
  if (!std::regex_search(svg, path, std::regex("<path class=\"" + style + "\" d=\"([^\"]*)\""))) return {};
  std::vector<Dot> dots;
  const std::string d = path[1];
  const std::regex kMove("M([-0-9.]+) ([-0-9.]+)h0");
  for (std::sregex_iterator dot(d.begin(), d.end(), kMove), end; dot != end; ++dot)
    dots.push_back({std::stod((*dot)[1]), std::stod((*dot)[2])});
  return dots;
}

struct Bar {
  double height, rms_mm;
  std::string name;
};

std::vector<Bar> BarsOf(const std::string& html, const std::string& style) {
  const size_t start = html.find("<title>RMS distance per configuration</title>");
  const std::string svg = html.substr(start, html.find("</svg>", start) - start);
  std::vector<Bar> bars;
  const std::regex kBar("<rect class=\"" + style +
                        "\"[^>]*height=\"([-0-9.]+)\"[^>]*><title>([^<]*): ([0-9.]+) mm</title>");
  for (std::sregex_iterator bar(svg.begin(), svg.end(), kBar), end; bar != end; ++bar)
    bars.push_back({std::stod((*bar)[1]), std::stod((*bar)[3]), (*bar)[2]});
  return bars;
}

TEST(ScatterChart, OneValueFarOffDoesNotFlattenTheOthers) {
  std::vector<double> x, y;
  for (int i = 0; i < 100; ++i) {
    x.push_back(i);
    y.push_back(100.0 * std::sin(i));
  }
  y[40] = 1e6;
  y[41] = -3e5;
  const std::string svg = ScatterChart("deviation", "deg", x, y, {});
  const std::vector<Dot> dots = DotsOf(svg, "dot"), beyond = DotsOf(svg, "beyond");
  ASSERT_EQ(dots.size(), 98u);
  ASSERT_EQ(beyond.size(), 2u);
  double top = 1e9, bottom = 0.0;
  for (const Dot& dot : dots) {
    top = std::min(top, dot.y);
    bottom = std::max(bottom, dot.y);
  }
  EXPECT_GT(bottom - top, 30.0);  // px: a third of the height, three times 95 % of them being the axis
  EXPECT_LE(beyond[0].y, top);
  EXPECT_GE(beyond[1].y, bottom);
  EXPECT_THAT(svg, HasSubstr("2 beyond the axis"));
  EXPECT_EQ(svg.find("1e+06"), std::string::npos);
  EXPECT_EQ(svg.find(">1000000<"), std::string::npos);
}

TEST(ScatterChart, WithoutFarValuesTheAxisEndsAtTheLargest) {
  const std::string svg = ScatterChart("deviation", "deg", {0, 1, 2, 3}, {10, -40, 20, 5}, {});
  EXPECT_TRUE(DotsOf(svg, "beyond").empty());
  EXPECT_THAT(svg, HasSubstr(">40<"));
  EXPECT_THAT(svg, HasSubstr(">-40<"));
}

// Configurations of one marker, every seventh held out.
CalibrationProblem Many(int configurations) {
  test::Kr270Design design;
  design.configurations = configurations;
  design.stations = 1;
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(test::Kr270Truth(), design.sigma, 4, &data);
  for (size_t c = 0; c < data.configurations.size(); ++c) data.configurations[c].is_validation = c % 7 == 3;
  Robot robot;
  robot.chain = test::Kr270Chain();
  CalibrationProblem problem = test::Kr270ProblemOf(data, Experiment());
  problem.data.configurations = data.configurations;
  return problem;
}

TEST(ConfigurationChart, KeepsTheColourOfWhatIsHeldOutAboveFourHundred) {
  for (const int configurations : {350, 1000}) {
    const CalibrationProblem problem = Many(configurations);
    const Estimate estimate = EstimateJointly(problem);
    ASSERT_TRUE(IsUsable(estimate.status)) << estimate.message;
    const std::string html = ReportToHtml(problem, estimate, Provenance());
    const std::vector<Bar> fitted = BarsOf(html, "bar"), held_out = BarsOf(html, "held-out");
    // What each bar stands for, summed here: squared distances by group of neighbours.
    const int groups = std::min(400, configurations);
    std::map<int, std::pair<double, int>> expected;
    std::set<int> with_fitted;
    for (size_t i = 0; i < problem.data.observations.size(); ++i) {
      const Observation& row = problem.data.observations[i];
      const int c = problem.data.shots[row.shot].configuration;
      int group = 0;
      while ((group + 1) * configurations / groups <= c) ++group;
      if (!problem.data.IsValidation(row)) {
        with_fitted.insert(group);
        continue;
      }
      auto& [squares, count] = expected[group];
      squares += (row.point_in_station - estimate.predicted.col(static_cast<Eigen::Index>(i))).squaredNorm();
      ++count;
    }
    ASSERT_EQ(held_out.size(), expected.size()) << configurations;
    EXPECT_EQ(fitted.size(), with_fitted.size());
    size_t k = 0;
    for (const auto& [group, sum] : expected) {
      EXPECT_NEAR(held_out[k].rms_mm, 1e3 * std::sqrt(sum.first / sum.second), 1e-4) << held_out[k].name;
      EXPECT_GT(held_out[k].height, 0.0);
      ++k;
    }
  }
}

}  // namespace
}  // namespace sagitta

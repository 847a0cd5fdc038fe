// The pictures of report pages: the numbers that they are drawn from, and what of them a reader without scripts has.
#include "tools/report/charts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "models/constants.h"
#include "tests/support/kr270_experiment.h"
#include "tools/report/first_screen.h"
#include "tools/report/histograms.h"
#include "tools/report/html_text.h"
#include "tools/report/page_parts.h"
#include "tools/report/report_html.h"
#include "tools/report/residual_pictures.h"
#include "tools/report/residual_rows.h"

namespace sagitta::charts_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::ordered_json;

// Configurations of one marker, every seventh held out.
CalibrationProblem Many(int configurations) {
  test::Kr270Design design;
  design.configurations = configurations;
  design.stations = 1;
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(test::Kr270Truth(), design.sigma, 4, &data);
  for (size_t c = 0; c < data.configurations.size(); ++c) data.configurations[c].is_validation = c % 7 == 3;
  CalibrationProblem problem = test::Kr270ProblemOf(data, Experiment());
  problem.mutable_data()->configurations = data.configurations;
  return problem;
}

// An estimate that misses row i by (0.1, 0.2, -0.2) mm (1 + i % 5) in its station's frame.
Estimate Missing(const CalibrationProblem& problem) {
  Estimate estimate;
  estimate.parameters = problem.parameters;
  Pose<double> base;
  base.rotation = RotationFromRpy(Vector3<double>(0.3, -0.2, 1.1));
  base.translation = Vector3<double>(1.0, 2.0, 0.5);
  estimate.parameters.SetBaseInStation(0, base);
  estimate.predicted.resize(3, static_cast<Eigen::Index>(problem.data().observations.size()));
  for (size_t i = 0; i < problem.data().observations.size(); ++i) {
    estimate.predicted.col(static_cast<Eigen::Index>(i)) =
        problem.data().observations[i].point_in_station - Vector3<double>(1e-4, 2e-4, -2e-4) * (1.0 + i % 5);
  }
  return estimate;
}

TEST(ResidualsOverDrivers, RowsAreMeasuredMinusPredictedInTheBase) {
  const CalibrationProblem problem = Many(100);
  const Estimate estimate = Missing(problem);
  const Picture picture = ResidualsOverDrivers({problem, estimate});
  const Json& rows = picture.data["rows"];
  ASSERT_EQ(rows["distance"].size(), problem.data().observations.size());
  // Rz(1.1) Ry(-0.2) Rx(0.3) transposed, written out for x: its first column times the miss.
  const double x_axis[3] = {std::cos(1.1) * std::cos(-0.2), std::sin(1.1) * std::cos(-0.2), -std::sin(-0.2)};
  for (size_t i = 0; i < rows["distance"].size(); ++i) {
    const double factor = 1.0 + i % 5;
    EXPECT_NEAR(rows["distance"][i].get<double>(), 0.3 * factor, 1e-3);
    EXPECT_NEAR(rows["residual x"][i].get<double>(), factor * (0.1 * x_axis[0] + 0.2 * x_axis[1] - 0.2 * x_axis[2]),
                1e-3);
    const Observation& row = problem.data().observations[i];
    EXPECT_EQ(rows["set"][i], problem.data().IsValidation(row) ? "held out" : "fitted");
    EXPECT_EQ(rows["pose"][i], problem.data().shots[row.shot].configuration);
    const std::string first = "over " + problem.robot().chain.joints[0].name;
    EXPECT_NEAR(rows[first][i].get<double>(), problem.data().ConfigurationOf(row).q[0] / kDegree, 0.05);
  }
  // Every choice of a menu is a column, and has its words.
  for (const PictureMenu& menu : picture.menus) {
    EXPECT_FALSE(menu.options.empty());
    for (const auto& [value, label] : menu.options) EXPECT_TRUE(rows.contains(value)) << menu.signal << " " << value;
  }
  // The table counts every row once per driver.
  std::map<std::string, int> counted;
  for (const auto& cells : picture.rows) counted[cells[0]] += std::stoi(cells[3]);
  EXPECT_EQ(counted.size(), picture.menus[0].options.size());
  for (const auto& [driver, count] : counted) EXPECT_EQ(count, static_cast<int>(problem.data().observations.size()));
}

TEST(ResidualsOverDrivers, OfManyRowsTheFarthestStayAndThePageStaysSmall) {
  const CalibrationProblem problem = Many(12000);
  Estimate estimate = Missing(problem);
  ASSERT_GT(problem.data().observations.size(), kMostDrawn);
  for (const int far : {1, 7778, 11999}) estimate.predicted.col(far).array() += 0.05;
  const std::vector<ResidualRow> rows = DrawnReadings(problem, estimate).rows;
  EXPECT_LE(rows.size(), kDrawnOfMany);
  EXPECT_GT(rows.size(), kDrawnOfMany - 2 * kFarthestKept);
  for (const int far : {1, 7778, 11999}) {
    EXPECT_TRUE(std::any_of(rows.begin(), rows.end(), [&](const ResidualRow& row) { return row.observation == far; }));
  }
  Section section;
  section.title = "many";
  section.pictures = {ResidualsOverDrivers({problem, estimate}), ResidualsInWorkspace({problem, estimate})};
  EXPECT_THAT(section.pictures[0].title, HasSubstr("of 36000 points"));
  EXPECT_LT(SectionsToPage({section}, Provenance()).size(), 4u << 20);
}

TEST(ResidualsInWorkspace, ArrowsBeginAtThePointAndTheArmEndsAtItsFlange) {
  const CalibrationProblem problem = Many(30);
  const Estimate estimate = Missing(problem);
  const Picture picture = ResidualsInWorkspace({problem, estimate});
  const Json &rows = picture.data["rows"], &arms = picture.data["arms"];
  const Pose<double> base = estimate.parameters.BaseInStation(0);
  for (size_t i = 0; i < problem.data().observations.size(); ++i) {
    const Vector3<double> start(rows["x"][i], rows["y"][i], rows["z"][i]);
    const Vector3<double> arrow(rows["dx"][i], rows["dy"][i], rows["dz"][i]);
    const Vector3<double> tip_in_station = base * Vector3<double>(1e-3 * (start + arrow));
    EXPECT_LT((tip_in_station - problem.data().observations[i].point_in_station).norm(), 1e-3);  // drawn to 1 mm
  }
  ASSERT_EQ(arms["polylines"].size(), 30u);
  for (size_t c = 0; c < 30; ++c) {
    const Json& line = arms["polylines"][c];
    const std::vector<double> theta = estimate.parameters.ModelValues();
    const Pose<double> flange = problem.model().FrameInBase(ShotInput(problem.data().configurations[c].q), theta.data(),
                                                            problem.robot().chain.FlangeFrame());
    ASSERT_GE(line.size(), 6u);
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(line[line.size() - 3 + axis].get<double>(), 1e3 * flange.translation[axis], 0.51 + 0.5);
  }
}

// Pictures stand behind the first screen, whatever that has.
TEST(Page, SizeOfTheFirstScreenIsThatOfItsSections) {
  const CalibrationProblem problem = Many(10);
  for (int parts = 0; parts < 8; ++parts) {
    Calibration calibration{problem, Missing(problem), {}};
    if ((parts & 1) != 0) calibration.trust.cross_validation.unseen.points = 1;
    if ((parts & 2) != 0) calibration.trust.suspects.push_back({0, "m.csv:2", "is off"});
    if ((parts & 4) != 0) calibration.estimate.identifiability.unidentifiable.emplace_back();
    EXPECT_EQ(SizeOfFirstScreen(calibration), FirstScreen(calibration).size()) << parts;
  }
}

TEST(BeforeAndAfter, BinsHoldEveryPointOnce) {
  UnseenPoints before, after;
  for (int i = 1; i <= 40; ++i) {
    before.distances.push_back(1e-3 * i);
    after.distances.push_back(1e-5 * i);
  }
  before.points = after.points = 40;
  before.distance_max = 0.04;
  after.distance_max = 4e-4;
  const std::vector<Picture> pictures = BeforeAndAfter(before, after);
  ASSERT_EQ(pictures.size(), 1u);
  const Json& bins = pictures[0].data["bins"];
  std::map<std::string, int> points;
  for (size_t b = 0; b < bins["count"].size(); ++b) {
    points[bins["series"][b]] += bins["count"][b].get<int>();
    EXPECT_LT(bins["from"][b].get<double>(), bins["to"][b].get<double>());
  }
  EXPECT_EQ(points, (std::map<std::string, int>{{"before", 40}, {"after", 40}}));
  EXPECT_TRUE(BeforeAndAfter(UnseenPoints(), after).empty());
}

TEST(Charts, AStageWithoutAValueIsLeftOut) {
  const Picture picture = WaterfallPicture("gap", "mm", {{"before", 2.0}, {"one", NAN}, {"two", 0.5}}, 0.1, "floor");
  EXPECT_EQ(picture.data["stages"]["stage"], Json({"before", "two"}));
  ASSERT_EQ(picture.rows.size(), 3u);
  EXPECT_EQ(picture.rows.back(), (std::vector<std::string>{"floor", "0.1"}));
}

TEST(Picture, NumbersAreAsShortAsTheirDigits) {
  EXPECT_EQ(Rounded(0.123456789).dump(), "0.1235");
  EXPECT_EQ(Rounded(-123456.0, 3).dump(), "-123000");
  EXPECT_EQ(Rounded(2.5e-9, 4).dump(), "2.5e-09");
  EXPECT_EQ(Rounded(0.0).dump(), "0");
  EXPECT_TRUE(Rounded(NAN).is_null());
}

TEST(Picture, HostileNamesNeitherEndTheScriptNorBecomeMarkup) {
  const std::string hostile = "</script><script>alert(1)</script><!--<b>&amp;\xE2\x80\xA8\xE2\x80\xA9\xFF";
  const std::string json = JsonInScript({{"name", hostile}});
  for (const char* forbidden : {"<", ">", "&", "\xE2\x80\xA8", "\xE2\x80\xA9", "\xFF"})
    EXPECT_THAT(json, Not(HasSubstr(forbidden)));
  const std::string back = Json::parse(json)["name"];
  EXPECT_EQ(back.substr(0, 30), hostile.substr(0, 30));
  Picture picture = BarPicture(hostile, hostile, {{hostile, hostile, 1.0}, {"b", hostile, 2.0}});
  const std::string html = PictureToHtml(picture);
  EXPECT_THAT(html, Not(HasSubstr("<b>")));
  EXPECT_THAT(html, Not(HasSubstr("<script>")));
}

TEST(Page, ForbidsEverythingButItsOwnScripts) {
  Section section;
  section.title = "a page";
  const std::string plain = SectionsToPage({section}, Provenance());
  EXPECT_THAT(plain, HasSubstr("default-src 'none'"));
  EXPECT_THAT(plain, HasSubstr("script-src 'none'"));
  EXPECT_THAT(plain, Not(HasSubstr("<script")));
  if (!HasPictures()) GTEST_SKIP() << "built without libjs-vega and libjs-three: pages have no scripts";
  section.pictures = {BarPicture("bars", "x", {{"", "a", 1.0}})};
  const std::string drawn = SectionsToPage({section}, Provenance());
  EXPECT_THAT(drawn, HasSubstr("script-src 'sha256-"));
  for (const char* outside : {"unsafe-eval", "src=\"http", "href=\"http", "sourceMappingURL"})
    EXPECT_THAT(drawn, Not(HasSubstr(outside)));
}

}  // namespace
}  // namespace sagitta::charts_test

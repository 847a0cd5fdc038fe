// Which marker, load and time the rows of a foreign table are of.
#include "tests/tools/import_tables.h"

#ifdef SAGITTA_HAVE_KDL

namespace sagitta::import_markers_test {
namespace {

using test::Readings;
using test::Table;

// Three reflectors on the flange, each seen at every pose.
const Table& ThreeMarkers() {
  static const Table all = [] {
    const Table a(test::MakeReadings(false)), b(test::MakeReadings(false, KDL::Vector(-0.04, 0.02, 0.08))),
        c(test::MakeReadings(false, KDL::Vector(0.03, -0.05, 0.06)));
    Table table(Readings());
    table.rows.clear();
    for (size_t r = 0; r < a.rows.size(); ++r) {
      for (const Table* one : {&a, &b, &c}) table.rows.push_back(one->rows[r]);
    }
    return table;
  }();
  return all;
}

std::string Reflector(size_t row) { return "SMR" + std::to_string(1 + row % 3); }
std::string NameOfRow(size_t row) { return "P" + std::to_string(10 + row / 3) + "_" + Reflector(row); }

class ImportMarkers : public test::Import {
 protected:
  std::vector<std::string> ColumnOf(const std::string& name) const {
    const auto cells = test::Cells(Read("job/measurements.csv"));
    std::vector<std::string> column;
    for (size_t r = 1; r < cells.size(); ++r) column.push_back(cells[r][test::Column(cells, name)]);
    return column;
  }
  void ExpectReflectors(const test::Outcome& outcome) const {
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const std::vector<std::string> markers = ColumnOf("marker");
    ASSERT_EQ(markers.size(), 90U);
    for (size_t r = 0; r < markers.size(); ++r) EXPECT_EQ(markers[r], Reflector(r));
  }
};

TEST_F(ImportMarkers, HeadersThatSayIt) {
  for (const char* header : {"Reflektor", "SMR", "Prisma", "Nest", "Reflector Nr", "Punkt", "Point Name", "Target"}) {
    SCOPED_TRACE(header);
    Table table = ThreeMarkers();
    ExpectReflectors(ImportText(table.Insert(0, header, Reflector).ToText(), {"--strict"}));
  }
}

TEST_F(ImportMarkers, OtherwiseTheColumnThatPartsThePointsIsAGuess) {
  Table table = ThreeMarkers();
  const std::string named = table.Insert(0, "Name", Reflector).ToText();
  const test::Outcome outcome = ImportText(named);
  ExpectReflectors(outcome);
  EXPECT_NE(outcome.out.find("'Name' is the marker"), std::string::npos) << outcome.out;
  ExpectRefused(named, {"--strict", "'Name' is the marker", "--map=marker=Name"}, {"--strict"});
  ExpectReflectors(ImportText(named, {"--strict", "--map=marker=Name"}));
}

TEST_F(ImportMarkers, APartOfANameThatRecurs) {
  Table table = ThreeMarkers();
  const std::string named = table.Insert(0, "Point Name", NameOfRow).ToText();
  const test::Outcome outcome = ImportText(named);
  ExpectReflectors(outcome);
  EXPECT_NE(outcome.out.find("the last part of 'Point Name' (SMR1 of P10_SMR1)"), std::string::npos) << outcome.out;
  ExpectReflectors(ImportText(named, {"--strict", "--map=marker=Point Name"}));
}

// Collection::Group::Point of SpatialAnalyzer, and a part further in.
TEST_F(ImportMarkers, APartBetweenOthersThatRecurs) {
  const auto name = [](size_t row) { return "A::" + Reflector(row) + "::P" + std::to_string(10 + row / 3); };
  const auto deep = [](size_t row) { return "KR_job_" + Reflector(row) + "_P" + std::to_string(10 + row / 3); };
  Table table = ThreeMarkers(), other = ThreeMarkers();
  const std::string named = table.Insert(0, "Point Name", name).ToText();
  const test::Outcome outcome = ImportText(named);
  ExpectReflectors(outcome);
  EXPECT_NE(outcome.out.find("the second part of 'Point Name' (SMR1 of A::SMR1::P10)"), std::string::npos)
      << outcome.out;
  ExpectRefused(named, {"--strict", "the second part of"}, {"--strict"});
  ExpectReflectors(ImportText(named, {"--strict", "--map=marker=Point Name"}));
  ExpectReflectors(ImportText(other.Insert(0, "Punkt", deep).ToText()));
}

// P10_SMR1 without and with a load is one name at one pose: it is the pose's, and its last part the marker's.
TEST_F(ImportMarkers, ANameThatRecursWithAnotherLoadAloneIsOfAPose) {
  Table table = ThreeMarkers();
  const std::vector<std::vector<std::string>> unloaded = table.rows;
  table.rows.insert(table.rows.end(), unloaded.begin(), unloaded.end());
  table.Insert(0, "Load", [](size_t r) { return std::string(r < 90 ? "none" : "V80"); });
  const std::string text = table.Insert(0, "Punkt", [](size_t r) { return NameOfRow(r % 90); }).ToText();
  const test::Outcome outcome = ImportText(text);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const std::vector<std::string> markers = ColumnOf("marker");
  ASSERT_EQ(markers.size(), 180U);
  for (size_t r = 0; r < markers.size(); ++r) EXPECT_EQ(markers[r], Reflector(r % 90));
}

TEST_F(ImportMarkers, RowsApartThatNoColumnPartsAreRefused) {
  Table table = ThreeMarkers();
  table.Insert(0, "Operator", [](size_t r) { return std::string(r % 2 == 0 ? "Ada" : "Karl"); });
  ExpectRefused(table.ToText(), {"export.txt:", "equal joint values", "apart", "--map=marker=HEADER"});
}

// Names of single rows, and texts that part nothing, are no markers.
TEST_F(ImportMarkers, OneMarkerStaysOne) {
  Table table(Readings());
  table.Insert(0, "Punkt", [](size_t r) { return "P" + std::to_string(r); });
  table.Insert(1, "Bediener", [](size_t r) { return std::string(r % 2 == 0 ? "Ada" : "Karl"); });
  ASSERT_EQ(ImportText(table.ToText(), {"--strict"}).status, 0);
  for (const std::string& marker : ColumnOf("marker")) EXPECT_EQ(marker, "M1");
}

TEST_F(ImportMarkers, LoadsThatAreMasses) {
  const auto load = [](size_t r) { return std::string(r < 15 ? "0" : "5.0"); };
  Table in_header(Readings()), in_cells(Readings()), open(Readings());
  for (const std::string& text : {in_header.Insert(0, "Load [kg]", load).ToText(),
                                  in_cells.Insert(0, "Payload", [&](size_t r) { return load(r) + " kg"; }).ToText()}) {
    const test::Outcome outcome = ImportText(text, {"--strict"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(ColumnOf("load")[0], "none");
    EXPECT_EQ(ColumnOf("load")[20], "5kg");
    EXPECT_NE(Read("job/experiment.yaml").find("loads:\n  \"5kg\": {mass_kg: 5}\n"), std::string::npos);
    EXPECT_NE(outcome.out.find("Load 5kg: 5 kg, as its column says"), std::string::npos) << outcome.out;
    EXPECT_EQ(outcome.out.find("Load 0"), std::string::npos) << outcome.out;
  }
  const std::string text = open.Insert(0, "Load", load).ToText();
  ExpectRefused(text, {"'Load' is 0 where there is no load"}, {"--strict"});
  ASSERT_EQ(ImportText(text).status, 0);
  EXPECT_EQ(ColumnOf("load")[0], "none");
  EXPECT_EQ(ColumnOf("load")[20], "5.0");
}

TEST_F(ImportMarkers, StampsAndWhatIsNone) {
  const auto minutes = [](size_t r) { return (r < 10 ? "0" : "") + std::to_string(r) + ":11"; };
  Table stamps(Readings()), clock(Readings());
  stamps.Insert(0, "Date/Time", [&](size_t r) { return "2024-03-12 09:" + minutes(r); });
  ASSERT_EQ(ImportText(stamps.ToText(), {"--strict"}).status, 0);
  const std::vector<std::string> times = ColumnOf("time_s");
  EXPECT_EQ(std::stod(times[7]) - std::stod(times[0]), 420.0);
  const test::Outcome outcome =
      ImportText(clock.Insert(0, "Zeit", [&](size_t r) { return "09:" + minutes(r); }).ToText());
  ASSERT_EQ(outcome.status, 0);
  EXPECT_EQ(outcome.out.find("time (time)"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("not used: the times are no seconds"), std::string::npos) << outcome.out;
}

TEST_F(ImportMarkers, MinutesBecomeSecondsAndAGuessIsSaid) {
  const auto minutes = [](size_t row) { return std::to_string(row / 3); };
  Table table = ThreeMarkers(), open = ThreeMarkers();
  const std::string named = table.Insert(0, "SMR", Reflector).Insert(1, "Time [min]", minutes).ToText();
  const std::string text = open.Insert(0, "SMR", Reflector).Insert(1, "Time", minutes).ToText();
  ExpectRefused(text, {"--strict", "'Time' is in s: the header does not say"}, {"--strict"});
  ExpectRefused(named, {"says min, the map says s"}, {"--map=time_s=Time [min]"});
  ASSERT_EQ(ImportText(named, {"--strict"}).status, 0);
  const std::vector<std::string> seconds = ColumnOf("time_s");
  ASSERT_EQ(seconds.size(), 90U);
  for (size_t r = 0; r < seconds.size(); ++r) EXPECT_EQ(std::stod(seconds[r]), 60.0 * static_cast<double>(r / 3));
}

// Degrees that the header calls rad, next to a column that no measurement has: the robot is compared all the same.
TEST_F(ImportMarkers, OtherColumnsDoNotKeepTheRobotFromBeingCompared) {
  Table table(Readings());
  table.Named({"A1 [rad]", "A2 [rad]", "A3 [rad]", "A4 [rad]", "A5 [rad]", "A6 [rad]", "x_mm", "y_mm", "z_mm"});
  table.Insert(9, "approach5", [](size_t) { return std::string("5"); });
  ExpectRefused(table.ToText(), {"cannot have made these readings"});
}

TEST_F(ImportMarkers, EqualPosesAreNoFewRows) {
  Table table(Readings());
  for (size_t r = 0; r < table.rows.size(); ++r) {  // one pose, read again and again
    table.rows[r] = table.rows[0];
    table.rows[r].back() = test::Text(std::stod(table.rows[0].back()) + 1e-3 * static_cast<double>(r));
  }
  const test::Outcome outcome = ImportText(table.ToText());
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("all rows have equal joint values"), std::string::npos) << outcome.out;
}

TEST_F(ImportMarkers, JointsOfThePendant) {
  const auto& right = Readings();
  ExpectRight(Table(right)
                  .Named({"Base [deg]", "Shoulder [deg]", "Elbow [deg]", "Wrist 1 [deg]", "Wrist 2 [deg]",
                          "Wrist3 [deg]", "x_mm", "y_mm", "z_mm"})
                  .ToText(),
              right, {"--strict"});
}

// A reflector on the foot stands still: on the flange the robot would have moved it.
TEST_F(ImportMarkers, MarkersThatAreNotOnTheFlangeAreWhereTheUserHasThem) {
  Table table(Readings());
  const std::vector<std::vector<std::string>> poses = table.rows;
  for (std::vector<std::string> row : poses) {
    row[6] = "-812.5", row[7] = "1003.25", row[8] = "411.75";
    table.rows.push_back(row);
  }
  table.Insert(6, "marker", [&](size_t r) { return std::string(r < poses.size() ? "M" : "foot: left"); });
  const test::Outcome refused = ImportText(table.ToText());
  EXPECT_EQ(refused.status, 2);
  const test::Outcome outcome = ImportText(table.ToText(), {"--on=foot: left=base"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(Run({"calibrate", Path("job/experiment.yaml"), "--quiet", "--out=" + Path("out")}).status, 0);
  EXPECT_NE(Read("out/estimate.json").find("marker/foot: left/x"), std::string::npos);
  const test::Outcome unknown = ImportText(table.ToText(), {"--on=foot: left=base,Q=j2"});
  EXPECT_EQ(unknown.status, 2);
  EXPECT_NE(unknown.err.find("no row measures the marker 'Q'"), std::string::npos) << unknown.err;
}

}  // namespace
}  // namespace sagitta::import_markers_test

#endif

// What messages say of cells, headers and units that are not read.
#include "tests/tools/import_tables.h"

#ifdef SAGITTA_HAVE_KDL

namespace sagitta::import_hints_test {
namespace {

using test::Readings;
using test::Table;

class ImportHints : public test::Import {
 protected:
  std::vector<std::string> With(const std::string& poses, std::vector<std::string> flags = {}) const {
    flags.insert(flags.begin(), Write("poses.csv", poses));
    return flags;
  }
};

TEST_F(ImportHints, LostReadingsAsInstrumentsWriteThem) {
  for (const char* lost : {"---", "*", "****", "1.#QNAN", "-1.#IND", "1.#INF"}) {
    SCOPED_TRACE(lost);
    Table table(Readings());
    for (size_t c = 6; c < 9; ++c) table.rows[5][c] = lost;
    ExpectRight(table.ToText(), Readings(), {}, {5});
  }
}

TEST_F(ImportHints, CellsThatAreNoNumbersSayWhy) {
  const std::pair<const char*, const char*> cells[] = {{"2 813.6391", "thousands must not be grouped"},
                                                       {"2'813.6391", "thousands must not be grouped"},
                                                       {"2\u2019813.6391", "thousands must not be grouped"},
                                                       {"2\u00a0813.6391", "thousands must not be grouped"},
                                                       {"2.8136391D+03", "2.0E+03, not 2.0D+03"},
                                                       {"\u201325.5", "a dash is no minus"},
                                                       {"25.5 mm", "units stand in the header"},
                                                       {"about 12", "a lost reading is"}};
  for (const auto& [cell, hint] : cells) {
    SCOPED_TRACE(cell);
    Table table(Readings());
    table.rows[4][6] = cell;
    ExpectRefused(table.ToText(), {"export.txt:6", cell, "is no number", hint});
  }
}

// Headers of ROS state no unit, and the numbers are in m and rad.
TEST_F(ImportHints, MetresMappedAsMillimetresDoNotFit) {
  const std::vector<std::string> header = {"translation.x", "translation.y", "translation.z"};
  Table table(Readings(), kDegree, 1e-3);
  for (size_t c = 6; c < 9; ++c) table.header[c] = header[c - 6];
  for (size_t c = 0; c < 6; ++c) table.header[c] = "q" + std::to_string(c + 1);
  ExpectRefused(table.ToText(), {"x_m, q1_rad where the numbers are in m and rad"});
  const std::string mapped = "translation.x,y_mm=translation.y,z_mm=translation.z";
  ExpectRefused(table.ToText(), {"cannot have made these readings: the points lie within", "x_m=HEADER"},
                {"--map=x_mm=" + mapped});
  ExpectRight(table.ToText(), Readings(), {"--map=x_m=translation.x,y_m=translation.y,z_m=translation.z"});
}

TEST_F(ImportHints, PointsOfAnotherOrderAreNotReadInTwoUnits) {
  Table points = Table(Readings(), 1.0, 1e-3).Reordered({6, 7, 8});
  points.header = {"x", "y", "z"};
  Table poses = Table(Readings(), kDegree).Reordered({0, 1, 2, 3, 4, 5});
  poses.header = {"q1", "q2", "q3", "q4", "q5", "q6"};
  ExpectRight(points.ToText(), Readings(), With(poses.ToText()));
  std::reverse(poses.rows.begin() + 5, poses.rows.end());
  const test::Outcome outcome = ImportText(points.ToText(), With(poses.ToText()));
  EXPECT_EQ(outcome.status, 2);
  EXPECT_EQ(outcome.err.find("two ways"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("cannot have made these readings"), std::string::npos) << outcome.err;
}

TEST_F(ImportHints, SphericalReadingsSayHowToConvert) {
  Table points = Table(Readings()).Reordered({6, 7, 8});
  points.header = {"Az (deg)", "Ze (deg)", "Range (mm)"};
  points.Insert(0, "Name", [](size_t row) { return "P" + std::to_string(row); });
  Table poses = Table(Readings()).Reordered({0, 1, 2, 3, 4, 5});
  poses.Insert(0, "Name", [](size_t row) { return "P" + std::to_string(row); });
  ExpectRefused(points.ToText(), {"azimuth, zenith angle and distance are not read", "d sin(zenith) cos(azimuth)"},
                With(poses.ToText()));
}

TEST_F(ImportHints, OnePoseTooManyIsCounted) {
  Table points = Table(Readings()).Reordered({6, 7, 8}), poses = Table(Readings()).Reordered({0, 1, 2, 3, 4, 5});
  poses.rows.push_back(poses.rows[0]);
  ExpectRefused(points.ToText(), {"there are 30 readings and 31 poses"}, With(poses.ToText()));
}

TEST_F(ImportHints, AnglesThatAreNoRotationVectorNeedTheRotation) {
  Table table(Readings());
  for (const char* axis : {"C", "B", "A"}) {
    table.Insert(9, axis, [axis](size_t row) { return std::to_string((37 * row + 11 * size_t(axis[0])) % 170); });
  }
  ExpectRefused(table.ToText(), {"misses the nominal robot", "--rotation=RzRyRx"},
                {"--map=rz_deg=A,ry_deg=B,rx_deg=C"});
}

}  // namespace
}  // namespace sagitta::import_hints_test

#endif  // SAGITTA_HAVE_KDL

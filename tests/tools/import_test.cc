// sagitta import and convert as people use them: one file spoiled in many ways, each read right or refused with the
// reason, none read wrong; and two public sets as their authors published them.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>

#include "tests/support/kdl_chain.h"
#include "tests/support/paths.h"
#include "tests/tools/program.h"

#ifdef SAGITTA_HAVE_KDL

namespace sagitta::test {
namespace {

struct Reading {
  std::vector<double> q_deg;
  std::vector<double> xyz_mm;
};

// Points that a robot with small errors shows, from KDL; `nominal`: without errors.
std::vector<Reading> MakeReadings(bool nominal) {
  std::vector<DhRow> rows = Ur5Rows();
  RandomNumbers random(17);
  for (DhRow& row : rows) {
    if (nominal) break;
    row.a += random.Uniform(-1e-3, 1e-3);
    row.d += random.Uniform(-1e-3, 1e-3);
    row.alpha_deg += random.Uniform(-0.1, 0.1);
    row.theta_deg += random.Uniform(-0.1, 0.1);
  }
  const KDL::Chain chain = KdlChainOfDh(DhConvention::kStandard, rows);
  const KDL::Frame base(KDL::Rotation::RPY(0.1, -0.2, 1.0), KDL::Vector(2.1, -1.3, 0.4));
  std::vector<Reading> readings;
  RandomNumbers poses(18);
  for (int k = 0; k < 30; ++k) {
    Reading reading;
    Eigen::VectorXd q(6);
    for (int j = 0; j < 6; ++j) {
      reading.q_deg.push_back(std::round(poses.Uniform(-170, 170) * 1e3) / 1e3);
      q[j] = reading.q_deg[j] * kDegree;
    }
    const KDL::Vector p = base * KdlFlange(chain, q) * KDL::Vector(0.02, 0.05, 0.08);
    for (int i = 0; i < 3; ++i) reading.xyz_mm.push_back(nominal ? 1e3 * p[i] : std::round(1e7 * p[i]) / 1e4);
    readings.push_back(reading);
  }
  return readings;
}

std::string Text(double value, int digits = 12) {
  std::ostringstream text;
  text.precision(digits);
  text << value;
  return text.str();
}

// A table that can be spoiled: cells first, then the way they are written.
struct Table {
  std::vector<std::string> header = {"q1_deg", "q2_deg", "q3_deg", "q4_deg", "q5_deg",
                                     "q6_deg", "x_mm",   "y_mm",   "z_mm"};
  std::vector<std::vector<std::string>> rows;
  std::string separator = ",";
  std::string line_end = "\n";
  std::string preamble;

  explicit Table(const std::vector<Reading>& readings, double angle = 1.0, double length = 1.0) {
    for (const Reading& reading : readings) {
      rows.emplace_back();
      for (const double q : reading.q_deg) rows.back().push_back(Text(q * angle, 17));
      for (const double x : reading.xyz_mm) rows.back().push_back(Text(x * length, 17));
    }
  }

  std::string Join(const std::vector<std::string>& cells) const {
    std::string line;
    for (size_t c = 0; c < cells.size(); ++c) line += (c > 0 ? separator : "") + cells[c];
    return line + line_end;
  }
  std::string ToText() const {
    std::string text = preamble;
    if (!header.empty()) text += Join(header);
    for (const auto& row : rows) text += Join(row);
    return text;
  }

  Table& DecimalComma() {
    for (auto& row : rows) {
      for (std::string& cell : row) std::replace(cell.begin(), cell.end(), '.', ',');
    }
    return *this;
  }
  Table& Quoted() {
    for (auto& row : rows) {
      for (std::string& cell : row) cell = "\"" + cell + "\"";
    }
    return *this;
  }
  Table& With(const std::string& a_separator) {
    separator = a_separator;
    return *this;
  }
  Table& Named(const std::vector<std::string>& names) {
    header = names;
    return *this;
  }
  // A column of equal or counted cells at a place.
  Table& Insert(size_t at, const std::string& name, const std::function<std::string(size_t)>& cell) {
    if (!header.empty()) header.insert(header.begin() + at, name);
    for (size_t r = 0; r < rows.size(); ++r) rows[r].insert(rows[r].begin() + at, cell(r));
    return *this;
  }
  Table& Reordered(const std::vector<int>& order) {
    const auto pick = [&order](const std::vector<std::string>& cells) {
      std::vector<std::string> picked;
      for (const int c : order) picked.push_back(cells[c]);
      return picked;
    };
    if (!header.empty()) header = pick(header);
    for (auto& row : rows) row = pick(row);
    return *this;
  }
};

std::string Utf16(const std::string& text, bool little, bool bom) {
  std::string bytes = bom ? (little ? "\xFF\xFE" : "\xFE\xFF") : "";
  for (const char c : text) {
    if (little) bytes += c;
    bytes += '\0';
    if (!little) bytes += c;
  }
  return bytes;
}

constexpr char kRobot[] = R"(schema: sagitta/robot/1
joints:
  - {name: j1, type: revolute}
  - {name: j2, type: revolute}
  - {name: j3, type: revolute}
  - {name: j4, type: revolute}
  - {name: j5, type: revolute}
  - {name: j6, type: revolute}
kinematics:
  dh:
    convention: standard
    links:
      - {joint: j1, a_mm: 0, alpha_deg: 90, d_mm: 89.159, theta_deg: 0}
      - {joint: j2, a_mm: -425, alpha_deg: 0, d_mm: 0, theta_deg: 0}
      - {joint: j3, a_mm: -392.25, alpha_deg: 0, d_mm: 0, theta_deg: 0}
      - {joint: j4, a_mm: 0, alpha_deg: 90, d_mm: 109.15, theta_deg: 0}
      - {joint: j5, a_mm: 0, alpha_deg: -90, d_mm: 94.65, theta_deg: 0}
      - {joint: j6, a_mm: 0, alpha_deg: 0, d_mm: 82.3, theta_deg: 0}
)";

class Import : public ProgramTest {
 protected:
  Outcome ImportText(const std::string& bytes, std::vector<std::string> flags = {}) const {
    std::vector<std::string> arguments = {"import", Write("robot.yaml", kRobot), Write("export.txt", bytes),
                                          "--out=" + Path("job")};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    std::filesystem::remove_all(Path("job"));
    return Run(arguments);
  }

  // What was written equals the readings, `lost` ones (by index) left out.
  void ExpectRight(const std::string& bytes, const std::vector<Reading>& readings,
                   const std::vector<std::string>& flags = {}, const std::vector<size_t>& lost = {}) const {
    const Outcome outcome = ImportText(bytes, flags);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const auto cells = Cells(Read("job/measurements.csv"));
    ASSERT_EQ(cells.size(), 1 + readings.size() - lost.size()) << outcome.out;
    size_t row = 0;
    for (size_t r = 0; r < readings.size(); ++r) {
      if (std::count(lost.begin(), lost.end(), r)) continue;
      ++row;
      for (int j = 0; j < 6; ++j) Expect(cells, row, "q" + std::to_string(j + 1), readings[r].q_deg[j]);
      for (int i = 0; i < 3; ++i) Expect(cells, row, std::string(1, "xyz"[i]), readings[r].xyz_mm[i]);
    }
    const Outcome inspected = Run({"inspect", Path("job/experiment.yaml")});
    EXPECT_EQ(inspected.status, 0) << inspected.err;
  }

  void ExpectRefused(const std::string& bytes, const std::vector<std::string>& words,
                     const std::vector<std::string>& flags = {}) const {
    const Outcome outcome = ImportText(bytes, flags);
    EXPECT_EQ(outcome.status, 2) << outcome.out;
    for (const std::string& word : words)
      EXPECT_NE(outcome.err.find(word), std::string::npos) << "'" << word << "' is not in: " << outcome.err;
    EXPECT_FALSE(Exists("job")) << "nothing is written";
  }

 private:
  static void Expect(const std::vector<std::vector<std::string>>& cells, size_t row, const std::string& stem,
                     double expected) {
    const std::map<std::string, double> kFactors = {{"_deg", 1.0}, {"_rad", 1.0 / kDegree}, {"_mm", 1.0}, {"_m", 1e3}};
    for (size_t c = 0; c < cells[0].size(); ++c) {
      for (const auto& [suffix, factor] : kFactors) {
        if (cells[0][c] != stem + suffix) continue;
        EXPECT_NEAR(std::stod(cells[row][c]) * factor, expected, 1e-9 * std::max(1.0, std::abs(expected)))
            << stem << " row " << row;
        return;
      }
    }
    ADD_FAILURE() << "no column " << stem;
  }
};

const std::vector<Reading>& Readings() {
  static const std::vector<Reading> readings = MakeReadings(false);
  return readings;
}

std::function<std::string(size_t)> Counted(int from) {
  return [from](size_t r) { return std::to_string(r + from); };
}
std::function<std::string(size_t)> Always(const std::string& text) {
  return [text](size_t) { return text; };
}

TEST_F(Import, SeparatorsAndDecimalSigns) {
  const auto& right = Readings();
  ExpectRight(Table(right).ToText(), right, {"--strict"});
  ExpectRight(Table(right).With(";").DecimalComma().ToText(), right, {"--strict"});
  ExpectRight(Table(right).With("\t").ToText(), right, {"--strict"});
  ExpectRight(Table(right).With("\t").DecimalComma().ToText(), right, {"--strict"});
  ExpectRight(Table(right).With("   ").ToText(), right, {"--strict"});
  ExpectRight(Table(right).DecimalComma().Quoted().ToText(), right, {"--strict"});
  ExpectRight(Table(right).With(" | ").ToText(), right, {"--strict"});
  Table ended = Table(right).With(";");
  ended.line_end = ";\r\n";
  ExpectRight(ended.ToText(), right);
}

TEST_F(Import, Encodings) {
  const auto& right = Readings();
  const std::string text = Table(right).ToText();
  ExpectRight("\xEF\xBB\xBF" + text, right, {"--strict"});
  ExpectRight(Utf16(text, true, true), right, {"--strict"});
  ExpectRight(Utf16(text, false, true), right, {"--strict"});
  ExpectRight(Utf16(text, true, false), right, {"--strict"});
  const std::vector<std::string> degrees = {"q1 [\xB0]", "q2 [\xB0]", "q3 [\xB0]", "q4 [\xB0]", "q5 [\xB0]",
                                            "q6 [\xB0]", "x_mm",      "y_mm",      "z_mm"};
  ExpectRight(Table(right).Named(degrees).ToText(), right);
  for (const char* line_end : {"\r\n", "\r"}) {
    Table table(right);
    table.line_end = line_end;
    ExpectRight(table.ToText(), right, {"--strict"});
  }
}

TEST_F(Import, UnitsAndHeaderStyles) {
  const auto& right = Readings();
  ExpectRight(Table(right)
                  .Named({"J1 [deg]", "J2 [deg]", "J3 [deg]", "J4 [deg]", "J5 [deg]", "J6 [deg]", "measured x [mm]",
                          "measured y [mm]", "measured z [mm]"})
                  .ToText(),
              right, {"--strict"});
  ExpectRight(Table(right, kDegree, 1e-3)
                  .Named({"Axis 1 (rad)", "Axis 2 (rad)", "Axis 3 (rad)", "Axis 4 (rad)", "Axis 5 (rad)",
                          "Axis 6 (rad)", "Ist X (m)", "Ist Y (m)", "Ist Z (m)"})
                  .ToText(),
              right, {"--strict"});
  ExpectRight(Table(right)
                  .Named({"q[0] deg", "q[1] deg", "q[2] deg", "q[3] deg", "q[4] deg", "q[5] deg", "MeasuredX_mm",
                          "MeasuredY_mm", "MeasuredZ_mm"})
                  .ToText(),
              right, {"--strict"});
  const std::vector<std::string> bare = {"joint_1", "joint_2", "joint_3", "joint_4", "joint_5",
                                         "joint_6", "x",       "y",       "z"};
  ExpectRight(Table(right).Named(bare).ToText(), right);
  ExpectRight(Table(right, kDegree, 1e-3).Named(bare).ToText(), right);
  ExpectRight(Table(right, kDegree).Named(bare).ToText(), right);
  Table units = Table(right).Named(bare).With(";").DecimalComma();
  units.rows.insert(units.rows.begin(), {"deg", "deg", "deg", "deg", "deg", "deg", "mm", "mm", "mm"});
  ExpectRight(units.ToText(), right);
  Table commented = Table(right).With(" ");
  commented.preamble = "# made by a tracker\n# on a Monday\n";
  commented.header[0] = "% " + commented.header[0];
  ExpectRight(commented.ToText(), right, {"--strict"});
}

TEST_F(Import, ColumnsInAnyOrderAndOthersBesides) {
  const auto& right = Readings();
  ExpectRight(Table(right).Reordered({8, 0, 6, 5, 4, 7, 3, 2, 1}).ToText(), right, {"--strict"});
  Table target =
      Table(right).Named({"target_q1_deg", "target_q2_deg", "target_q3_deg", "target_q4_deg", "target_q5_deg",
                          "target_q6_deg", "actual x [mm]", "actual y [mm]", "actual z [mm]"});
  for (const char* axis : {"z", "y", "x"}) target.Insert(0, std::string("Goal ") + axis, Always("0.5"));
  for (const char* joint : {"6", "5", "4", "3", "2", "1"})
    target.Insert(3, std::string("actual_q") + joint + "_deg", Always("1.5"));
  target.Insert(0, "Timestamp", Always("2.02E+13")).Insert(3, "roll", Always("3.1"));
  ExpectRight(target.ToText(), right);
}

TEST_F(Import, TablesWithoutHeader) {
  const auto& right = Readings();
  ExpectRight(Table(right).Named({}).ToText(), right);
  ExpectRight(Table(right, kDegree).Named({}).With(" ").ToText(), right);
  Table points_first =
      Table(right, 1.0, 1e-3).Named({}).Reordered({6, 7, 8, 0, 1, 2, 3, 4, 5}).Insert(0, "", Counted(1));
  ExpectRight(points_first.With("\t").DecimalComma().ToText(), right);
  ExpectRefused(Table(right).Named({}).ToText(), {"--strict", "guess", "no header"}, {"--strict"});
  ExpectRefused(Table(right).Named({}).Insert(2, "", Always("0.25")).ToText(), {"no header", "10 columns"});
}

TEST_F(Import, LostReadingsAreLeftOutAndCounted) {
  const auto& right = Readings();
  Table table(right);
  table.rows[3][6] = table.rows[3][7] = table.rows[3][8] = "";
  table.rows[5][7] = "NaN";
  table.rows[9][6] = table.rows[9][7] = table.rows[9][8] = "-9999";
  table.rows[11][6] = table.rows[11][7] = table.rows[11][8] = "0.000";
  ExpectRight(table.ToText(), right, {}, {3, 5, 9, 11});
  const Outcome outcome = ImportText(table.ToText());
  EXPECT_NE(outcome.out.find("3 lost readings"), std::string::npos) << outcome.out;
  Table semicolons = Table(right).With(";").DecimalComma();
  semicolons.rows[0][6] = semicolons.rows[0][7] = semicolons.rows[0][8] = "-9999,0";
  ExpectRight(semicolons.ToText(), right, {}, {0});
  table.rows[4][6] = "about 12";
  ExpectRefused(table.ToText(), {"export.txt:6", "about 12", "no number"});
}

TEST_F(Import, WhatIsNotMeasuredIsRefused) {
  const auto& right = Readings();
  const std::vector<std::string> joints = {"q1_deg", "q2_deg", "q3_deg", "q4_deg", "q5_deg", "q6_deg"};
  const auto named = [&joints](const std::string& x, const std::string& y, const std::string& z) {
    std::vector<std::string> names = joints;
    for (const std::string& name : {x, y, z}) names.push_back(name);
    return names;
  };
  ExpectRefused(Table(right).Named(named("target_x_mm", "target_y_mm", "target_z_mm")).ToText(),
                {"measured points", "--map"});
  ExpectRefused(Table(right).Named(named("x_nom", "y_nom", "z_nom")).ToText(), {"measured points"});
  ExpectRefused(Table(right).Named(named("tcp_x", "tcp_y", "tcp_z")).ToText(), {"measured points"});
  ExpectRefused(Table(right).Named(named("dx", "dy", "dz")).ToText(), {"measured points"});
  ExpectRefused(Table(MakeReadings(true)).ToText(), {"computed, not measured"});
  Table twice = Table(right);
  twice.Insert(9, "X [mm]", Always("1.5"));
  ExpectRefused(twice.ToText(), {"x_mm", "X [mm]", "may both be"});
  ExpectRight(Table(right).Named(named("tcp_x", "tcp_y", "tcp_z")).ToText(), right,
              {"--map=x_mm=tcp_x,y_mm=tcp_y,z_mm=tcp_z", "--strict"});
  ExpectRefused(Table(right).ToText(), {"tcp_x", "no column"}, {"--map=x_mm=tcp_x"});
}

TEST_F(Import, WhatCannotBeToldIsRefused) {
  const auto& right = Readings();
  Table mixed = Table(right).With(";");
  mixed.rows[4][2] = "12,5";
  ExpectRefused(mixed.ToText(), {"comma", "point", "decimal sign"});
  ExpectRefused(Table(right).DecimalComma().ToText(), {"export.txt:1", "9 cells", "semicolons"});
  Table cut = Table(right);
  cut.rows[7].pop_back();
  ExpectRefused(cut.ToText(), {"export.txt:9", "8 cells"});
  Table header = Table(right);
  header.header.pop_back();
  ExpectRefused(header.ToText(), {"export.txt:1", "8 cells"});
  ExpectRefused(Table(right, kDegree).ToText(), {"cannot have made these readings"});
  ExpectRefused(Table(right).Reordered({1, 0, 2, 3, 4, 5, 6, 7, 8}).Named(Table(right).header).ToText(),
                {"cannot have made these readings"});
  ExpectRefused(Table(right, 1.0, 1e-3).ToText(), {"cannot have made these readings"});
  ExpectRefused("PK\x03\x04 something zipped", {"workbook", "CSV"});
  ExpectRefused("no numbers\nat all\n", {"no table"});
  Table grouped = Table(right).With(";").DecimalComma();
  // 2345,6 as 2.345,6: the same number.
  for (auto& row : grouped.rows) {
    for (std::string& cell : row) {
      const size_t comma = cell.find(',');
      if (comma != std::string::npos && comma >= 4 + (cell[0] == '-')) cell.insert(comma - 3, ".");
    }
  }
  ASSERT_NE(grouped.ToText().find('.'), std::string::npos);
  ExpectRight(grouped.ToText(), right);
}

TEST_F(Import, SeveralFilesAreStations) {
  const auto& right = Readings();
  const std::vector<Reading> first(right.begin(), right.begin() + 15), second(right.begin() + 15, right.end());
  const Outcome outcome =
      Run({"import", Write("robot.yaml", kRobot), Write("a.csv", Table(first).ToText()),
           Write("b.txt", Table(second, kDegree, 1e-3)
                              .With(";")
                              .Named({"q1_rad", "q2_rad", "q3_rad", "q4_rad", "q5_rad", "q6_rad", "x_m", "y_m", "z_m"})
                              .DecimalComma()
                              .ToText()),
           "--out=" + Path("job")});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto cells = Cells(Read("job/measurements.csv"));
  ASSERT_EQ(cells.size(), 31u);
  EXPECT_EQ(cells[1][Column(cells, "station")], "a");
  EXPECT_EQ(cells[30][Column(cells, "station")], "b");
  EXPECT_NE(cells[1][Column(cells, "marker")], cells[30][Column(cells, "marker")]);
  EXPECT_NEAR(std::stod(cells[30][Column(cells, "q3_deg")]), right[29].q_deg[2], 1e-9);
  EXPECT_NE(outcome.out.find("station of its own"), std::string::npos);
}

class AsPublished : public ProgramTest {
 protected:
  std::string Set(const std::string& name) const { return SharedFolder() + "/data/as_published/" + name; }
  void SetUp() override {
    ProgramTest::SetUp();
    if (!std::filesystem::exists(Set("README.md"))) GTEST_SKIP() << "the public data sets are not beside this tree";
  }
};

// Target and difference make the measured point; no file of the set names the robot, which the readings do.
TEST_F(AsPublished, Ur5) {
  const std::string grid = Set("serial_robots_datasets/UR5/3D_UR5_uncalibrated_grid_cleaned.csv");
  const Outcome imported = Run({"import", grid, "--out=" + Path("job")});
  ASSERT_EQ(imported.status, 0) << imported.err;
  EXPECT_NE(imported.out.find("ur5"), std::string::npos);
  EXPECT_EQ(Run({"import", grid, "--out=" + Path("strict"), "--strict"}).status, 2);
  const auto cells = Cells(Read("job/measurements.csv"));
  const auto known = Cells(ReadAll(SharedFolder() + "/data/ur5_gts3800/measurements.csv"));
  ASSERT_GT(cells.size(), 1000u);
  for (size_t r = 1; r <= 1000; r += 37) {
    for (const char* column : {"x_mm", "y_mm", "z_mm", "q1_deg", "q6_deg"}) {
      EXPECT_NEAR(std::stod(cells[r][Column(cells, column)]), std::stod(known[r][Column(known, column)]), 2e-6)
          << column << " row " << r;
    }
  }
  const Outcome calibrated = Run({"calibrate", Path("job/experiment.yaml"), "--out=" + Path("results")});
  ASSERT_EQ(calibrated.status, 0) << calibrated.err;
  // An independent fit of the same rows has 0.111 mm.
  EXPECT_NEAR(ReadJson("results/estimate.json")["fit"]["distance_rms_mm"].get<double>(), 0.111, 0.003);
}

// Semicolons, decimal commas, commanded poses beside the measured ones, damaged time stamps.
TEST_F(AsPublished, Ur10) {
  const std::string cubes = Set("ipa-robot-accuracy/Series_D/measurements_iso_cubes.csv");
  const Outcome imported = Run({"import", cubes, "--robot=ur10", "--out=" + Path("job")});
  ASSERT_EQ(imported.status, 0) << imported.err;
  EXPECT_NE(imported.out.find("Goal x"), std::string::npos);
  const auto cells = Cells(Read("job/measurements.csv"));
  const auto known = Cells(ReadAll(SharedFolder() + "/data/ur10_leica/series_D.csv"));
  ASSERT_EQ(cells.size(), known.size());
  for (size_t r = 1; r < known.size(); r += 13) {
    for (const char* column : {"x_mm", "y_mm", "z_mm", "sigma_x_mm", "temperature_degC"}) {
      EXPECT_NEAR(std::stod(cells[r][Column(cells, column)]), std::stod(known[r][Column(known, column)]), 1e-6)
          << column;
    }
    EXPECT_NEAR(std::stod(cells[r][Column(cells, "q2_rad")]) / kDegree, std::stod(known[r][Column(known, "q2_deg")]),
                1e-6);
  }
  const Outcome calibrated = Run({"calibrate", Path("job/experiment.yaml"), "--out=" + Path("results")});
  ASSERT_EQ(calibrated.status, 0) << calibrated.err;
  // An independent fit has 0.395 mm; ours weighs the rows by their stated sigmas.
  EXPECT_LT(ReadJson("results/estimate.json")["fit"]["distance_rms_mm"].get<double>(), 0.55);
}

class Convert : public ProgramTest {};

TEST_F(Convert, RoundTripAndWords) {
  const std::string robot = Write("robot.yaml", kRobot);
  for (const std::string& out : {"a.urdf", "a.csv", "b.yaml"})
    EXPECT_EQ(Run({"convert", robot, Path(out)}).status, 0) << out;
  const Outcome back = Run({"convert", Path("a.urdf"), Path("again.csv"), "--as=mdh"});
  EXPECT_EQ(back.status, 0) << back.err;
  EXPECT_NE(back.out.find("moves as before"), std::string::npos);
  EXPECT_NE(Read("again.csv").find("convention: modified"), std::string::npos);
  EXPECT_EQ(Run({"convert", robot, Path("c.yaml"), "--as=ur"}).status, 0);
  EXPECT_EQ(Run({"convert", Path("c.yaml"), Path("d.yaml")}).status, 0);
  const Outcome plain =
      Run({"convert",
           Write("beta.yaml",
                 [] {
                   std::string text = kRobot;
                   return text.replace(text.find("d_mm: 0, theta_deg: 0"), 21, "d_mm: 0, theta_deg: 0, beta_deg: 0.03");
                 }()),
           Path("plain.csv"), "--plain"});
  EXPECT_EQ(plain.status, 0) << plain.err;
  EXPECT_NE(plain.out.find("without beta the flange is off by"), std::string::npos) << plain.out;
  EXPECT_EQ(Read("plain.csv").find("beta_deg"), std::string::npos);
  const Outcome edited = Run({"convert", Path("a.urdf"), Path("e.urdf"), "--template=" + Path("a.urdf")});
  EXPECT_EQ(edited.status, 0) << edited.err;
  EXPECT_EQ(Read("e.urdf"), Read("a.urdf"));
  const Outcome unknown = Run({"convert", robot, Path("a.docx")});
  EXPECT_EQ(unknown.status, 2);
  EXPECT_NE(unknown.err.find(".urdf"), std::string::npos);
}

}  // namespace
}  // namespace sagitta::test

#else

TEST(Import, NeedsKdl) { GTEST_SKIP() << "liborocos-kdl-dev is not installed: no independent forward kinematics"; }

#endif

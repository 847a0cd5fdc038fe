// sagitta import and convert as people use them: one file spoiled in many ways, each read right or refused with the
// reason, none read wrong.
#include <gtest/gtest.h>

#ifdef SAGITTA_HAVE_KDL

#include "tests/tools/import_tables.h"

namespace sagitta::test::import_test {
namespace {

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
  ExpectRight(Table(right, 1.0, 1e3)
                  .Named({"A1[°]", "A2[°]", "A3[°]", "A4[°]", "A5[°]", "A6[°]", "Xact(µm)", "Yact(µm)", "Zact(µm)"})
                  .With(";")
                  .DecimalComma()
                  .ToText(),
              right, {"--strict"});
  ExpectRight(
      Table(right)
          .Named({"Articulation 1 (°)", "Articulation 2 (°)", "Articulation 3 (°)", "Articulation 4 (°)",
                  "Articulation 5 (°)", "Articulation 6 (°)", "X mesuré (mm)", "Y mesuré (mm)", "Z mesuré (mm)"})
          .ToText(),
      right, {"--strict"});
  ExpectRight(
      Table(right)
          .Named({"q_1/deg", "q_2/deg", "q_3/deg", "q_4/deg", "q_5/deg", "q_6/deg", "LT_X/mm", "LT_Y/mm", "LT_Z/mm"})
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

// An inch is 25.4 mm exactly; a unit that is not read is named, not passed over.
TEST_F(Import, ForeignUnits) {
  const auto& right = Readings();
  const std::vector<std::string> joints = {"J1 [deg]", "J2 [deg]", "J3 [deg]", "J4 [deg]", "J5 [deg]", "J6 [deg]"};
  const auto in_unit = [&](const std::string& unit, double length, double angle = 1.0) {
    std::vector<std::string> names = joints;
    for (const char* axis : {"x", "y", "z"}) names.push_back(std::string("measured ") + axis + " " + unit);
    return Table(right, angle, length).Named(names);
  };
  ExpectRight(in_unit("[in]", 1 / 25.4).ToText(), right, {"--strict"});
  ExpectRight(in_unit("(inches)", 1 / 25.4).ToText(), right, {"--strict"});
  ExpectRight(in_unit("[cm]", 0.1).ToText(), right, {"--strict"});
  ExpectRight(in_unit("", 1 / 25.4).ToText(), right);  // the robot decides
  Table units = in_unit("", 1 / 25.4).With(";");
  units.rows.insert(units.rows.begin(), {"deg", "deg", "deg", "deg", "deg", "deg", "in", "in", "in"});
  for (std::string& name : units.header) name = name.substr(0, name.find(" ["));
  ExpectRight(units.ToText(), right);
  ExpectRefused(in_unit("[ft]", 1 / 304.8).ToText(),
                {"'measured x [ft]'", "the unit is not one that is read", "mm, cm, m, um or in"});
  Table gons = in_unit("[mm]", 1.0, 10.0 / 9.0);
  for (int j = 0; j < 6; ++j) gons.header[static_cast<size_t>(j)] = "J" + std::to_string(j + 1) + " [gon]";
  ExpectRefused(gons.ToText(), {"'J1 [gon]'", "the unit is not one that is read", "deg, rad"});
  Table grads = in_unit("[mm]", 1.0, 1.0);  // a degree in German, a gon elsewhere
  for (int j = 0; j < 6; ++j) grads.header[static_cast<size_t>(j)] = "J" + std::to_string(j + 1) + " [Grad]";
  ExpectRefused(grads.ToText(), {"'J1 [Grad]'", "grad: degrees in German, gon elsewhere"});
}

TEST_F(Import, NumbersThatAreNone) {
  const auto& right = Readings();
  Table minus = Table(right).With(";");
  for (auto& row : minus.rows) {
    for (std::string& cell : row) {
      if (cell[0] == '-') cell = "\u2212" + cell.substr(1);
    }
  }
  ASSERT_NE(minus.ToText().find("\u2212"), std::string::npos);
  ExpectRight(minus.ToText(), right, {"--strict"});
  Table huge = Table(right);
  huge.rows[5][7] = "1e300";
  ExpectRefused(huge.ToText(), {"export.txt:7", "1e+300 mm is no reading"});
  Table words = Table(right);
  for (size_t c = 0; c < 6; ++c) words.rows[0][c] = "about";
  ExpectRefused(words.ToText(), {"export.txt:2", "'about' is no number"});
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
  // The cause and its remedy, as calibrate says them.
  const std::string not_made = "cannot have made these readings";
  ExpectRefused(Table(right, kDegree).ToText(), {not_made, "look like radians", "q1_rad"});
  ExpectRefused(Table(right).Reordered({1, 0, 2, 3, 4, 5, 6, 7, 8}).Named(Table(right).header).ToText(),
                {not_made, "joints j1 and j2 exchanged", "order of the columns"});
  ExpectRefused(Table(right, 1.0, 1e-3).ToText(), {not_made, "x_mm", "m"});
  Table turned = Table(right), mirrored = Table(right), shifted = Table(right);
  for (auto& row : turned.rows) row[2] = Text(-std::stod(row[2]));
  ExpectRefused(turned.ToText(), {not_made, "joint j3 counted the other way", "sign: -1"});
  for (auto& row : mirrored.rows) row[7] = Text(-std::stod(row[7]));
  ExpectRefused(mirrored.ToText(), {not_made, "mirror"});
  for (size_t r = 0; r + 1 < right.size(); ++r) {
    for (size_t i = 6; i < 9; ++i) shifted.rows[r][i] = Table(right).rows[r + 1][i];
  }
  shifted.rows.pop_back();
  ExpectRefused(shifted.ToText(), {not_made, "row"});
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

class Convert : public ProgramTest {};

TEST_F(Convert, UniversalRobotsConf) {
  const std::string robot = Write("robot.yaml", kRobot);
  std::string changed = kRobot;
  changed.replace(changed.find("a_mm: -425, alpha_deg: 0"), 24, "a_mm: -425.3, alpha_deg: 0.02, beta_deg: 0.01");
  const std::string calibrated = Write("calibrated.yaml", changed);
  EXPECT_EQ(Run({"convert", calibrated, Path("new.conf")}).status, 2) << "differences from what?";
  const Outcome written = Run({"convert", calibrated, Path("new.conf"), "--nominal=" + robot});
  ASSERT_EQ(written.status, 0) << written.err;
  EXPECT_NE(written.out.find("joint_checksum"), std::string::npos) << written.out;
  EXPECT_EQ(Run({"convert", Path("new.conf"), Path("back.yaml"), "--nominal=" + robot}).status, 0);
}

// An effect that belongs to a geometric error of the chain is the reason, not a line of a file that is not written.
TEST_F(Convert, AnEffectOfAnErrorKeepsItsDescription) {
  const std::string robot =
      Write("robot.yaml", std::string("schema: sagitta/robot/1\n") +
                              "joints: [{name: A1, type: revolute}, {name: A2, type: revolute}]\n"
                              "kinematics:\n  chain: [{Rz: A1}, {Tx_mm: 350}, "
                              "{Ry: A2, error: dq2}, {Tz_mm: 900}]\n"
                              "effects: [{effect: frozen_geometry, error: dq2, value_deg: 0.1}]\n");
  for (const std::string as : {"--as=dh", "--as=mdh", "--plain"}) {
    const Outcome refused = Run({"convert", robot, Path("table.yaml"), as});
    EXPECT_EQ(refused.status, 2) << as;
    for (const char* part : {"effect 'frozen_geometry'", "the error 'dq2'", "--as=chain"})
      EXPECT_NE(refused.err.find(part), std::string::npos) << refused.err;
    EXPECT_EQ(refused.err.find("table.yaml"), std::string::npos) << refused.err;
    EXPECT_FALSE(Exists("table.yaml"));
  }
  EXPECT_EQ(Run({"convert", robot, Path("same.yaml")}).status, 0);
  EXPECT_NE(Read("same.yaml").find("frozen_geometry"), std::string::npos);
}

// The first axis counts the other way: a standard table has no place for that, a modified one has.
TEST_F(Convert, AFirstAxisThatCountsTheOtherWay) {
  const std::string robot = Write("robot.yaml",
                                  "schema: sagitta/robot/1\n"
                                  "joints: [{name: A1, type: revolute}, {name: A2, type: revolute}]\n"
                                  "kinematics:\n  chain: [{Tz_mm: 750}, {Rz: A1, sign: -1}, {Tx_mm: 350}, {Ry: A2}, "
                                  "{Tz_mm: 900}]\n");
  const Outcome refused = Run({"convert", robot, Path("table.yaml"), "--as=dh"});
  EXPECT_EQ(refused.status, 2);
  for (const char* part : {"joint 'A1' moves about the z axis", "counts the other way", "--as=mdh"})
    EXPECT_NE(refused.err.find(part), std::string::npos) << refused.err;
  EXPECT_FALSE(Exists("table.yaml"));
  for (const std::string out : {"table.yaml", "table.csv"}) {
    const Outcome modified = Run({"convert", robot, Path(out), "--as=mdh"});
    EXPECT_EQ(modified.status, 0) << modified.err;
    EXPECT_NE(modified.out.find("moves as before"), std::string::npos) << modified.out;
  }
}

TEST_F(Convert, RoundTripAndWords) {
  const std::string robot = Write("robot.yaml", kRobot);
  for (const std::string out : {"a.urdf", "a.csv", "b.yaml"})
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

// Units in round brackets behind Rx, Ry, Rz make no robot of a table.
TEST_F(Import, RotationsWithUnitsInBracketsAreATable) {
  const char* const headers[][3] = {{"Rx (deg)", "Ry (deg)", "Rz (deg)"},
                                    {"Rx(deg)", "Ry(deg)", "Rz(deg)"},
                                    {"rx(rad)", "ry(rad)", "rz(rad)"},
                                    {"Rx (mrad)", "Ry (mrad)", "Rz (mrad)"},
                                    {"Rx (tool)", "Ry (tool)", "Rz (tool)"}};
  for (const auto& names : headers) {
    Table table{Readings()};
    for (const char* name : names)
      table.Insert(table.header.size(), name, [](size_t r) { return std::to_string(0.1 * double(r)); });
    ExpectRight(table.ToText(), Readings());
  }
}

// Ids that a file states are not given to poses of another that states none.
TEST_F(Import, MadeIdsOfConfigurationsAreNotThoseThatAFileStates) {
  const std::vector<Reading> all = Readings();
  Table stated(std::vector<Reading>(all.begin(), all.begin() + 15));
  stated.Insert(0, "config", [](size_t r) { return "c000" + std::to_string(r + 16); });
  Table none(std::vector<Reading>(all.begin() + 15, all.end()));
  for (Table* table : {&stated, &none}) table->Insert(0, "station", Always("S1")).Insert(0, "marker", Always("M1"));
  ExpectRight(stated.ToText(), all, {Write("b.csv", none.ToText())});
  ASSERT_FALSE(HasFailure());
  const auto cells = Cells(Read("job/measurements.csv"));
  const size_t config = Column(cells, "config");
  std::set<std::string> ids;
  for (size_t r = 1; r < cells.size(); ++r) ids.insert(cells[r][config]);
  EXPECT_EQ(ids.size(), 30u);
  EXPECT_EQ(cells[1][config], "c00016");
  EXPECT_EQ(cells[16][config], "c00031");
}

// Nor is a marker of a file without names one that another file names.
TEST_F(Import, MadeMarkersAreNotThoseThatAFileNames) {
  const std::vector<Reading> all = Readings();
  Table stated(std::vector<Reading>(all.begin(), all.begin() + 15));
  Table none(std::vector<Reading>(all.begin() + 15, all.end()));
  stated.Insert(0, "marker", Always("M2")).Insert(0, "station", Always("b"));
  ExpectRight(stated.ToText(), all, {Write("b.csv", none.ToText())});
  ASSERT_FALSE(HasFailure());
  const auto cells = Cells(Read("job/measurements.csv"));
  EXPECT_EQ(cells[1][Column(cells, "marker")], "M2");
  EXPECT_EQ(cells[30][Column(cells, "marker")], "M2_");
  EXPECT_EQ(cells[30][Column(cells, "station")], "b_");
}

// Dates in one file and seconds from a start in another would be half a century apart, in either order.
TEST_F(Import, TimesOfTwoClocksAreRefused) {
  const std::vector<Reading> all = Readings();
  Table seconds(std::vector<Reading>(all.begin(), all.begin() + 15));
  Table stamps(std::vector<Reading>(all.begin() + 15, all.end()));
  for (Table* table : {&seconds, &stamps}) table->Insert(0, "station", Always("S1")).Insert(0, "marker", Always("M1"));
  Table other = stamps;
  seconds.Insert(0, "time [s]", [](size_t r) { return std::to_string(60 * r); });
  stamps.Insert(0, "time", [](size_t r) { return "2024-03-05 10:" + std::to_string(20 + r) + ":00"; });
  ExpectRefused(seconds.ToText(), {"b.csv:1", "dates", "export.txt", "start of their own", "one clock"},
                {Write("b.csv", stamps.ToText())});
  ExpectRefused(stamps.ToText(), {"b.csv:1", "start of their own", "one clock"}, {Write("b.csv", seconds.ToText())});
  other.Insert(0, "time [s]", [](size_t r) { return std::to_string(900 + 60 * r); });
  ExpectRight(seconds.ToText(), all, {Write("b.csv", other.ToText())});
  ExpectRight(Table(all).ToText(), all, {});
}

TEST_F(Import, TheMapDecidesWhatATimeIs) {
  Table table{Readings()};
  table.Insert(0, "t", [](size_t r) { return Text(40000.0 + 0.05 * double(r)); });
  ExpectRight(table.ToText(), Readings(), {"--strict", "--map=time_s=t"});
  ASSERT_FALSE(HasFailure());
  const auto cells = Cells(Read("job/measurements.csv"));
  const size_t time = Column(cells, "time_s");
  EXPECT_NEAR(std::stod(cells[2][time]) - std::stod(cells[1][time]), 0.05, 1e-9);
  Table since_1970{Readings()};
  since_1970.Insert(0, "t", [](size_t r) { return std::to_string(1700000000000 + 60000 * r); });
  ExpectRefused(since_1970.ToText(), {"'t' are too large for s", "Time [ms]"}, {"--map=time_s=t"});
}

TEST_F(Import, ColumnsThatStandTwiceAlikeAreOne) {
  Table table{Readings()};
  for (const size_t c : {0u, 6u}) {
    const auto rows = table.rows;
    table.Insert(table.header.size(), table.header[c], [&rows, c](size_t r) { return rows[r][c]; });
  }
  ExpectRight(table.ToText(), Readings(), {"--strict"});
  table.rows[3].back() = "1";
  ExpectRefused(table.ToText(), {"may both be the measured x"});
}

// A gantry's joints are called as the axes of the points are.
TEST_F(Import, JointsNamedLikeAxes) {
  const std::string robot = Write("gantry.yaml",
                                  "schema: sagitta/robot/1\njoints:\n  - {name: X, type: prismatic}\n"
                                  "  - {name: Y, type: prismatic}\n  - {name: Z, type: prismatic}\n"
                                  "kinematics:\n  chain: [{Tx: X}, {Ty: Y}, {Tz: Z}]\n");
  for (const std::string points : {"Ist X [mm];Ist Y [mm];Ist Z [mm]", "x_mm;y_mm;z_mm"}) {
    std::string text = "X [mm];Y [mm];Z [mm];" + points + "\n";
    RandomNumbers random(3);
    for (int row = 0; row < 12; ++row) {
      const double q[3] = {random.Uniform(0, 2000), random.Uniform(0, 1500), random.Uniform(0, 900)};
      for (const double value : q) text += test::Text(value) + ";";
      for (int i = 0; i < 3; ++i) text += test::Text(q[i] + 100.0 + 0.3 * std::sin(row + i)) + (i < 2 ? ";" : "\n");
    }
    const test::Outcome outcome = Run({"import", robot, Write("export.txt", text), "--out=" + Path("job")});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const auto cells = test::Cells(Read("job/measurements.csv"));
    ASSERT_EQ(cells.size(), 13u);
    const double joint = std::stod(cells[1][test::Column(cells, "q1_mm")]);
    EXPECT_NEAR(std::stod(cells[1][test::Column(cells, "x_mm")]) - joint, 100.0, 0.4);
    std::filesystem::remove_all(Path("job"));
  }
}

}  // namespace
}  // namespace sagitta::test::import_test

#else

TEST(Import, NeedsKdl) { GTEST_SKIP() << "liborocos-kdl-dev is not installed: no independent forward kinematics"; }

#endif

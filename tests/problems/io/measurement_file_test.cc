#include "problems/io/measurement_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "models/effects/effect.h"
#include "problems/io/files.h"
#include "problems/text.h"
#include "tests/problems/file_test_support.h"
#include "tests/support/paths.h"

namespace sagitta::measurement_file_test {
namespace {

constexpr double kDeg = M_PI / 180.0;
const std::vector<std::string> kJoints = {"A1", "L2"};
const std::vector<bool> kPrismatic = {false, true};

constexpr char kSmall[] =
    "config,marker,q1_deg,q2_mm,x_mm,y_mm,z_mm\n"
    "C1,M1,10,200,1,2,3\n"
    "C1,M2,10,200,4,5,6\n"
    "C2,M1,-20,250,7,8,9.5\n";

constexpr char kFull[] =
    "# a comment\n"
    "config,marker,station,visit,repeat,load,q1_rad,q2_m,x_m,y_mm,z_mm,sigma_x_mm,sigma_y_mm,sigma_z_mm,"
    "fx_N,fy_N,fz_N,mx_Nm,my_Nm,mz_Nm,time_s,temperature_degC,approach1,approach2,set,sim_x_mm,sim_y_mm,sim_z_mm,note\n"
    "\n"
    "C1,M1,S2,v1,0,none,0.5,0.2,1,2,3,0.1,0.2,0.3,0,0,0,0,0,0,1.5,20,-1,+1,calibration,1,2,3,a\n"
    "C1,M2,S2,v1,0,none,0.5,0.2,1,2,4,0.1,0.2,0.3,0,0,0,0,0,0,1.7,21,-1,1,calibration,1,2,3,\"b, c\"\n"
    "C1,M1,S2,v1,0,V250,0.5,0.2,1,2,5,,,,0,0,-2451,1,2,3,,,,,calibration,,,,\n"
    "C1,M1,S2,v2,0,V250,0.5,0.2,1,2,6,0.1,0.2,0.3,0,0,-2451,0,0,0,1.9,20,0,0,validation,1,2,3,\n";

class MeasurementFileTest : public FileTest {
 protected:
  Measurements Read(const std::string& text, const MeasurementReadOptions& options = {}) {
    return ReadMeasurements({Write("m.csv", text)}, kJoints, kPrismatic, options);
  }
  std::string Error(const std::string& text) {
    return ErrorOf([&] { Read(text); });
  }
};

TEST_F(MeasurementFileTest, ReadsTheRequiredColumns) {
  const Measurements data = Read(kSmall);
  ASSERT_EQ(data.files.size(), 1u);
  EXPECT_EQ(data.files[0].path, Path("m.csv"));
  EXPECT_EQ(data.files[0].sha256, Sha256(kSmall));
  EXPECT_EQ(data.stations, std::vector<std::string>{"S1"});
  EXPECT_EQ(data.markers, (std::vector<std::string>{"M1", "M2"}));
  ASSERT_EQ(data.configurations.size(), 2u);
  EXPECT_EQ(data.configurations[1].id, "C2");
  EXPECT_NEAR(data.configurations[1].q[0], -20 * kDeg, 1e-15);
  EXPECT_EQ(data.configurations[1].q[1], 0.25);
  ASSERT_EQ(data.shots.size(), 2u);
  EXPECT_EQ(data.shots[0].observations, (std::vector<int>{0, 1}));
  EXPECT_EQ(data.shots[0].load, "none");
  EXPECT_TRUE(data.shots[0].wrench.IsZero());
  EXPECT_FALSE(data.shots[0].has_time);
  EXPECT_TRUE(data.shots[0].approach.empty());
  ASSERT_EQ(data.observations.size(), 3u);
  EXPECT_EQ(data.observations[2].point_in_station, Vector3<double>(0.007, 0.008, 0.0095));
  EXPECT_EQ(data.observations[2].sigma, Vector3<double>(0, 0, 0));
  EXPECT_EQ(data.SourceOf(data.observations[2]), Path("m.csv") + ":4");
  EXPECT_EQ(data.Cell(data.observations[2], "z_mm"), "9.5");
  EXPECT_EQ(data.Cell(data.observations[2], "absent"), "");
  EXPECT_TRUE(data.warnings.empty());
}

// Configurations that come back in any order are the same ones, however many there are.
TEST_F(MeasurementFileTest, RowsOfAConfigurationMayStandAnywhere) {
  std::mt19937_64 random(2);
  std::vector<int> rows;
  for (int i = 0; i < 6000; ++i) rows.push_back(i / 3);
  std::shuffle(rows.begin(), rows.end(), random);
  std::string text = "config,marker,q1_deg,q2_mm,x_mm,y_mm,z_mm\n";
  std::map<int, int> times, places;  // how often a configuration came; its place by first appearance
  std::vector<int> expected;
  for (const int c : rows) {
    const std::string own = std::to_string(c);
    text += "C" + own + ",M" + std::to_string(times[c]++) + ",0," + own + ",1,2,3\n";
    expected.push_back(places.emplace(c, static_cast<int>(places.size())).first->second);
  }
  const Measurements data = Read(text);
  ASSERT_EQ(data.configurations.size(), 2000u);
  EXPECT_EQ(data.shots.size(), 2000u);
  for (size_t i = 0; i < rows.size(); ++i) {
    const Observation& row = data.observations[i];
    EXPECT_EQ(data.shots[row.shot].configuration, expected[i]);
    EXPECT_EQ(data.ConfigurationOf(row).id, "C" + std::to_string(rows[i]));
  }
}

TEST_F(MeasurementFileTest, ALostReadingIsSkippedAndCounted) {
  const Measurements data = Read(std::string(kSmall) + "C3,M1,-30,300,,,\nC3,M2,-30,300,,,\n");
  EXPECT_EQ(data.observations.size(), 3u);
  ASSERT_EQ(data.warnings.size(), 1u);
  EXPECT_TRUE(SaysInOrder(data.warnings[0], {"2 readings are lost", "skipped", "m.csv:5"})) << data.warnings[0];
}

TEST_F(MeasurementFileTest, SigmasThatAreReplacedAreNotLookedAt) {
  std::string text = kFull;
  text.replace(text.find("0.1,0.2,0.3"), 11, "0.1,0,nan");
  MeasurementReadOptions options;
  options.row_sigmas_used = false;
  EXPECT_TRUE(Read(text, options).observations[0].sigma.isZero(0.0));
  EXPECT_TRUE(SaysInOrder(Error(text), {"m.csv:4: sigma_y_mm", "above 0"}));
}

TEST_F(MeasurementFileTest, ReadsEveryColumn) {
  const Measurements data = Read(kFull);
  ASSERT_EQ(data.observations.size(), 4u);
  ASSERT_EQ(data.shots.size(), 3u);
  ASSERT_EQ(data.configurations.size(), 1u);
  EXPECT_EQ(data.configurations[0].q, Eigen::Vector2d(0.5, 0.2));
  EXPECT_EQ(data.stations, std::vector<std::string>{"S2"});
  const Shot& first = data.shots[0];
  EXPECT_EQ(first.observations, (std::vector<int>{0, 1}));
  EXPECT_EQ(first.visit, "v1");
  EXPECT_EQ(first.repeat, "0");
  EXPECT_TRUE(first.has_time && first.has_temperature);
  EXPECT_EQ(first.time, 1.6);  // the mean of its two rows
  EXPECT_EQ(first.temperature, 20.5);
  EXPECT_EQ(first.approach, (std::vector<int>{-1, 1}));
  EXPECT_EQ(data.observations[0].point_in_station, Vector3<double>(1, 0.002, 0.003));
  EXPECT_TRUE(data.observations[0].sigma.isApprox(Vector3<double>(1e-4, 2e-4, 3e-4)));
  const Shot& loaded = data.shots[1];
  EXPECT_EQ(loaded.load, "V250");
  EXPECT_EQ(loaded.wrench.force, Vector3<double>(0, 0, -2451));
  EXPECT_EQ(loaded.wrench.moment, Vector3<double>(1, 2, 3));
  EXPECT_FALSE(loaded.has_time);
  EXPECT_TRUE(loaded.approach.empty());
  EXPECT_TRUE(data.observations[2].sigma.isZero());
  EXPECT_EQ(data.shots[2].visit, "v2");
  EXPECT_EQ(data.shots[2].approach, (std::vector<int>{0, 0}));
  EXPECT_EQ(data.Cell(data.observations[1], "note"), "b, c");
  EXPECT_EQ(data.SourceOf(data.observations[0]), Path("m.csv") + ":4");
}

TEST_F(MeasurementFileTest, AShotCountsAtTheMeanOfItsRows) {
  const Measurements data = Read(
      "config,marker,visit,q1_deg,q2_mm,x_mm,y_mm,z_mm,time_s,temperature_degC,approach2\n"
      "C1,M1,a,1,2,3,4,5,10,20,1\nC1,M2,a,1,2,3,4,6,16,,1\nC1,M3,a,1,2,3,4,7,,21,1\n"
      "C1,M1,b,1,2,3,4,8,100,20,-1\nC1,M2,b,1,2,3,4,9,1000,20,-1\n");
  ASSERT_EQ(data.shots.size(), 2u);
  EXPECT_EQ(data.shots[0].time, 13.0);
  EXPECT_EQ(data.shots[0].temperature, 20.5);
  EXPECT_EQ(data.shots[0].approach, (std::vector<int>{kApproachNotStated, 1}));
  ASSERT_EQ(data.warnings.size(), 1u);
  EXPECT_NE(data.warnings[0].find("900 s apart"), std::string::npos) << data.warnings[0];
}

TEST_F(MeasurementFileTest, TakesByteOrderMarkAndCarriageReturns) {
  std::string text = "\xEF\xBB\xBF";
  for (const char c : std::string(kSmall)) text += c == '\n' ? std::string("\r\n") : std::string(1, c);
  const Measurements data = Read(text);
  EXPECT_EQ(data.observations.size(), 3u);
  EXPECT_EQ(data.files[0].header.front(), "config");
  EXPECT_EQ(data.files[0].header.back(), "z_mm");
  EXPECT_EQ(Read(std::string(kSmall).substr(0, sizeof(kSmall) - 2)).observations.size(), 3u);  // no last newline
}

TEST_F(MeasurementFileTest, QuotedAndBlankPaddedCells) {
  const Measurements data = Read(Replaced(kSmall, "C1,M1,10,", "\"C1\" , \"M \"\"1\"\"\",\"10\", "));
  EXPECT_EQ(data.markers[0], "M \"1\"");
  EXPECT_EQ(data.configurations[0].id, "C1");
}

TEST_F(MeasurementFileTest, ExtraColumnsAreCarriedAlong) {
  for (const char* extra : {"group", "dx_mm", "rotation", "temperature2_degC", "pred_x_mm", "psig_x_mm", "res_x_mm",
                            "whitened_x", "leverage", "operator", "load_kg", "date"}) {
    const Measurements data =
        Read(std::string("config,marker,q1_deg,q2_mm,x_mm,y_mm,z_mm,") + extra + "\nC1,M1,10,200,1,2,3,some text\n");
    EXPECT_EQ(data.Cell(data.observations[0], extra), "some text");
  }
}

TEST_F(MeasurementFileTest, PointsMayBeAbsentWhereTheyAreNotRequired) {
  MeasurementReadOptions options;
  options.points_required = false;
  const Measurements data = Read("config,marker,q1_deg,q2_mm\nC1,M1,10,200\n", options);
  EXPECT_TRUE(data.observations[0].point_in_station.array().isNaN().all());
  const Measurements mixed =
      Read("config,marker,q1_deg,q2_mm,x_mm,y_mm,z_mm\nC1,M1,1,2,,,\nC1,M2,1,2,1,2,3\n", options);
  EXPECT_TRUE(mixed.observations[0].point_in_station.array().isNaN().all());
  EXPECT_EQ(mixed.observations[1].point_in_station.z(), 0.003);
}

TEST_F(MeasurementFileTest, IdsAreSharedAcrossFiles) {
  const std::string second =
      "q2_mm,q1_deg,marker,config,z_mm,y_mm,x_mm,station\n"
      "200,10,M2,C1,1,2,3,S1\n"
      "1,1,M3,C3,1,2,3,S9\n";
  const Measurements data = ReadMeasurements({Write("a.csv", kSmall), Write("b.csv", second)}, kJoints, kPrismatic, {});
  EXPECT_EQ(data.markers, (std::vector<std::string>{"M1", "M2", "M3"}));
  EXPECT_EQ(data.configurations.size(), 3u);
  EXPECT_EQ(data.stations, (std::vector<std::string>{"S1", "S9"}));
  ASSERT_EQ(data.warnings.size(), 1u);  // C1, M2 once more: a repeated shot
  EXPECT_TRUE(SaysInOrder(data.warnings[0], {"1 row", "b.csv:2"}));
  EXPECT_EQ(data.shots.size(), 4u);
  EXPECT_EQ(data.observations[3].file, 1);
}

TEST_F(MeasurementFileTest, EqualIdsAreRepeatedShots) {
  const Measurements data =
      Read(std::string(kSmall) + "C1,M1,10,200,1,2,3.1\nC1,M2,10,200,4,5,6.1\nC1,M1,10,200,1,2,3.2\n");
  ASSERT_EQ(data.warnings.size(), 1u);
  EXPECT_TRUE(SaysInOrder(data.warnings[0], {"3 rows", "m.csv:5", "repeated shots"}));
  ASSERT_EQ(data.shots.size(), 4u);
  EXPECT_EQ(data.shots[0].observations, (std::vector<int>{0, 1}));
  EXPECT_EQ(data.shots[2].observations, (std::vector<int>{3, 4}));
  EXPECT_EQ(data.shots[3].observations, (std::vector<int>{5}));
}

TEST_F(MeasurementFileTest, RowsOfAConfigurationAgreeAcrossUnits) {
  const Measurements data = ReadMeasurements(
      {Write("a.csv", kSmall),
       Write("b.csv", "config,marker,q1_rad,q2_m,x_mm,y_mm,z_mm\nC1,M7," + FormatNumber(10 * kDeg) + ",0.2,1,2,3\n")},
      kJoints, kPrismatic, {});
  EXPECT_EQ(data.configurations.size(), 2u);
}

TEST_F(MeasurementFileTest, WithoutALoadColumnTheWrenchNamesTheLoad) {
  const Measurements data = Read(
      "config,marker,q1_deg,q2_mm,x_mm,y_mm,z_mm,fz_N\n"
      "C1,M1,10,200,1,2,3,0\n"
      "C1,M1,10,200,1,2,2,-100\n");
  ASSERT_EQ(data.shots.size(), 2u);
  EXPECT_EQ(data.shots[0].load, "none");
  EXPECT_NE(data.shots[1].load, "none");
}

constexpr char kPoses[] =
    "config,marker,q1_deg,q2_mm,x_mm,y_mm,z_mm,rx_mrad,ry_mrad,rz_mrad,sigma_rot_urad\n"
    "C1,M1,10,200,1,2,3,100,-200,300,40\n"
    "C1,M2,10,200,4,5,6,,,,\n"
    "C2,M1,-20,250,7,8,9.5,3000,0,0,50\n";

TEST_F(MeasurementFileTest, PosesArePointsAndRotations) {
  const Measurements data = Read(kPoses);
  ASSERT_EQ(data.observations.size(), 5u);
  EXPECT_EQ(data.NumRows(), 3);
  EXPECT_EQ(data.OrientedMarkers(), (std::vector<bool>{true, false}));
  const Observation& point = data.observations[0];
  const Observation& rotation = data.observations[1];
  EXPECT_TRUE(point.is_point());
  EXPECT_FALSE(rotation.is_point());
  EXPECT_EQ(point.partner, 1);
  EXPECT_EQ(rotation.partner, 0);
  EXPECT_EQ(data.SourceOf(rotation), data.SourceOf(point));
  EXPECT_EQ(data.shots[0].observations, (std::vector<int>{0, 1, 2}));
  // Rodrigues: cos(a) I + sin(a) [n]x + (1 - cos(a)) n n'.
  const Vector3<double> v(0.1, -0.2, 0.3), n = v.normalized();
  const Matrix3<double> expected = std::cos(v.norm()) * Matrix3<double>::Identity() + std::sin(v.norm()) * Skew(n) +
                                   (1.0 - std::cos(v.norm())) * n * n.transpose();
  EXPECT_LT((rotation.rotation().in_station - expected).norm(), 1e-15);
  EXPECT_TRUE(rotation.rotation().sigma.isApprox(Vector3<double>::Constant(40e-6)));
  EXPECT_TRUE(data.observations[2].is_point());
  EXPECT_EQ(data.observations[2].partner, -1) << "no rotation in its row: a point";
}

TEST_F(MeasurementFileTest, QuaternionsSayTheSameAsRotationVectors) {
  const Measurements vectors = Read(kPoses);
  std::string text = "config,marker,q1_deg,q2_mm,x_mm,y_mm,z_mm,ow,ox,oy,oz,sigma_rx_mrad,sigma_ry_urad,sigma_rz_rad\n";
  const char* ids[3] = {"C1,M1,10,200,1,2,3", "C1,M2,10,200,4,5,6", "C2,M1,-20,250,7,8,9.5"};
  const Vector3<double> turns[3] = {{0.1, -0.2, 0.3}, {0, 0, 0}, {3.0, 0, 0}};
  for (int row = 0; row < 3; ++row) {
    const double half = 0.5 * turns[row].norm(), sign = row == 2 ? -1.0 : 1.0;  // q and -q are the same rotation
    char cells[200] = ",,,,";
    if (row != 1) {
      const Vector3<double> n = sign * std::sin(half) * turns[row].normalized();
      std::snprintf(cells, sizeof cells, ",%.17g,%.17g,%.17g,%.17g", sign * std::cos(half), n.x(), n.y(), n.z());
    }
    text += std::string(ids[row]) + cells + (row == 1 ? ",,,\n" : ",0.04,50,6e-5\n");
  }
  const Measurements quaternions = Read(text);
  ASSERT_EQ(quaternions.observations.size(), vectors.observations.size());
  for (size_t i = 0; i < vectors.observations.size(); ++i) {
    EXPECT_LT(
        (quaternions.observations[i].rotation().in_station - vectors.observations[i].rotation().in_station).norm(),
        1e-14);
  }
  EXPECT_TRUE(quaternions.observations[1].rotation().sigma.isApprox(Vector3<double>(40e-6, 50e-6, 60e-6)));
  text.replace(text.find("C2"), std::string::npos, "C2,M1,1,2,3,4,5,2,0,0,0,1,1,1\n");
  EXPECT_TRUE(SaysInOrder(Error(text), {"4: ow", "length 2", "unit quaternion"}));
}

TEST_F(MeasurementFileTest, ARotationIsGivenOnceAndWhole) {
  const std::string both =
      "config,marker,q1_deg,q2_mm,x_mm,y_mm,z_mm,rx_mrad,ry_mrad,rz_mrad,ow,ox,oy,oz\n"
      "C1,M1,10,200,1,2,3,0,0,0,1,0,0,0\n";
  EXPECT_TRUE(SaysInOrder(Error(both), {"1: ow", "twice"}));
  EXPECT_TRUE(SaysInOrder(Error(Replaced(kPoses, "100,-200,300", "100,,300")), {"2: ry_mrad", "empty"}));
  EXPECT_TRUE(SaysInOrder(Error(Replaced(kPoses, ",300,40", ",300,0")), {"2: sigma_rot_urad", "above 0"}));
}

TEST_F(MeasurementFileTest, JointTorquesAreTheMeanOfTheShotsRows) {
  const std::string text =
      "config,marker,q1_deg,q2_mm,x_mm,y_mm,z_mm,tau1_Nm,tau2_N\n"
      "C1,M1,10,200,1,2,3,100,-50\nC1,M2,10,200,4,5,6,102,-54\nC2,M1,-20,250,7,8,9.5,,\n";
  const Measurements data = Read(text);
  EXPECT_EQ(data.shots[0].joint_torques, Eigen::VectorXd(Eigen::Vector2d(101, -52)));
  EXPECT_EQ(data.shots[1].joint_torques.size(), 0);
  EXPECT_TRUE(SaysInOrder(Error(Replaced(text, "102,-54", "102,")), {"3: tau2_N", "empty"}));
}

struct BadFile {
  const char* name;
  const char* text;
  const char* from;
  const char* to;
  std::vector<std::string> says;
};

class BadMeasurementTest : public MeasurementFileTest, public ::testing::WithParamInterface<BadFile> {};

TEST_P(BadMeasurementTest, IsRefusedWithWords) {
  const BadFile& bad = GetParam();
  std::vector<std::string> says = {"m.csv:"};
  says.insert(says.end(), bad.says.begin(), bad.says.end());
  EXPECT_TRUE(SaysInOrder(Error(Replaced(bad.text, bad.from, bad.to)), says));
}

INSTANTIATE_TEST_SUITE_P(
    Header, BadMeasurementTest,
    ::testing::Values(
        BadFile{"missing_z", kSmall, ",z_mm", ",zz", {"1: z_mm", "missing"}},
        // A target is not measured: no hint leads from its name to that of a reading.
        BadFile{"target", kSmall, "x_mm", "x_t", {"1: x_mm", "missing", "'x_t' reads like a target"}},
        BadFile{
            "missing_config", kSmall, "config", "c", {"1: config", "missing", "'sagitta import ROBOT FILE --out=DIR'"}},
        BadFile{"no_joints", kSmall, "q1_deg,q2_mm", "a,b", {"1: q1_deg", "missing"}},
        BadFile{"misspelt", kSmall, "x_mm", "x_mmm", {"1: x_mmm", "unknown", "'x_mm'"}},
        BadFile{"centimetres", kSmall, "x_mm", "x_cm", {"1: x_cm", "'x_mm'"}},
        BadFile{"micrometres", kFull, "sigma_x_mm", "sigma_x_um", {"2: sigma_x_um", "'sigma_x_mm'"}},
        BadFile{"no_unit", kSmall, "x_mm", "x", {"1: x:", "'x_mm'"}},
        BadFile{"no_unit_joint", kSmall, "q1_deg", "q1", {"1: q1:", "'q1_deg'"}},
        BadFile{"case", kSmall, "x_mm", "X_mm", {"1: X_mm", "'x_mm'"}},
        BadFile{"config_case", kSmall, "config", "Config", {"1: Config", "'config'"}},
        BadFile{"markers", kSmall, "marker", "markers", {"1: markers", "'marker'"}},
        BadFile{"time", kFull, "time_s", "time_ms", {"2: time_ms", "'time_s'"}},
        BadFile{"force", kFull, "fz_N", "fz_kN", {"2: fz_kN", "'fz_N'"}},
        BadFile{"sigma_mm", kFull, "sigma_x_mm", "sigma_mm", {"2: sigma_mm", "'sigma_x_mm'"}},
        BadFile{"approach", kFull, "approach2", "aproach2", {"2: aproach2", "'approach2'"}},
        BadFile{"approach3", kFull, "approach2", "approach3", {"2: approach3", "2 joints"}},
        BadFile{"prismatic", kSmall, "q2_mm", "q2_deg", {"1: q2_deg", "'L2' is prismatic", "q2_mm, q2_m"}},
        BadFile{"revolute", kSmall, "q1_deg", "q1_mm", {"1: q1_mm", "'A1' is revolute", "q1_deg, q1_rad"}},
        BadFile{"two_units", kSmall, "z_mm", "x_m", {"1: x_m", "two units"}},
        BadFile{"stands_twice", kSmall, "z_mm", "x_mm", {"1: x_mm", "twice"}},
        BadFile{"no_name", kSmall, "marker", "", {"1: ", "column 2 has no name"}},
        BadFile{"joints_short", kSmall, "q2_mm", "other", {"1: q1", "the robot has 2 joints (A1 .. L2)", "q1 .. q1"}},
        BadFile{"joints_long", kSmall, "z_mm", "q3_deg", {"1: q3", "the robot has 2 joints", "q1 .. q3"}},
        BadFile{"joint_gap", kSmall, "q1_deg", "other", {"1: q1_deg", "missing"}},
        BadFile{"sigma_alone", kFull, "sigma_z_mm", "other", {"2: sigma_z_mm", "missing"}},
        BadFile{"kind", kFull, "note", "kind", {"2: kind", "reserved"}},
        BadFile{"session", kFull, "note", "session", {"2: session", "reserved"}},
        BadFile{"range", kFull, "note", "range_mm", {"2: range_mm", "reserved"}},
        BadFile{"sigma_rot", kFull, "note", "sigma_rot_urad", {"2: sigma_rot_urad", "no rotations"}},
        BadFile{"torque_of_no_joint", kFull, "note", "tau3_Nm", {"2: tau3_Nm", "2 joints"}},
        BadFile{"torque_of_one", kFull, "note", "tau1_Nm", {"2: tau2_N", "missing", "all joints, or of none"}},
        BadFile{"torque_of_a_slide", kFull, "note", "tau2_Nm", {"2: tau2_Nm", "'L2' is prismatic", "tau2_N"}},
        BadFile{"rotation_in_part", kFull, "note", "rx_mrad", {"2: ry_mrad", "missing"}},
        BadFile{"rotation_unit", kFull, "note", "rx_mm", {"2: rx_mm"}},
        BadFile{"quaternion_in_part", kFull, "note", "ow", {"2: ox", "missing", "scalar first"}},
        BadFile{"semicolons",
                kSmall,
                "config,marker,q1_deg,q2_mm,x_mm,y_mm,z_mm",
                "config;marker;q1_deg",
                {"1: ", "commas"}}),
    [](const auto& param) { return std::string(param.param.name); });

INSTANTIATE_TEST_SUITE_P(
    Rows, BadMeasurementTest,
    ::testing::Values(
        BadFile{"nan", kSmall, "7,8", "nan,8", {"4: x_mm", "'nan' is not a finite number", "lost reading"}},
        BadFile{"inf", kSmall, "7,8", "7,-inf", {"4: y_mm", "'-inf'"}},
        BadFile{"text", kSmall, "7,8", "12_5,8", {"4: x_mm", "'12_5'"}},
        BadFile{"trailing", kSmall, "7,8", "7mm,8", {"4: x_mm", "'7mm'"}},
        BadFile{"huge", kSmall, "7,8", "1e999,8", {"4: x_mm", "'1e999'"}},
        BadFile{"empty_cell", kSmall, "7,8", ",8", {"4: x_mm", "empty", "lost reading has x, y and z all empty"}},
        BadFile{"joint_text", kSmall, "-20", "-2O", {"4: q1_deg", "'-2O'"}},
        BadFile{"too_few", kSmall, ",9.5", "", {"4: ", "6 cells", "7"}},
        BadFile{"too_many", kSmall, "9.5", "9,5", {"4: ", "8 cells", "7", "decimal comma"}},
        BadFile{"open_quote", kSmall, "C2,M1", "C2,\"M1", {"4: ", "quotes"}},
        BadFile{"no_config", kSmall, "C2,M1", ",M1", {"4: config", "empty"}},
        BadFile{"no_marker", kSmall, "C2,M1", "C2,", {"4: marker", "empty"}},
        BadFile{"copy",
                kSmall,
                "C2,M1,-20,250,7,8,9.5",
                "C1,M2,10,200,4,5,6",
                {"4: ", "equals", "m.csv:3", "every column"}},
        BadFile{"joints_differ", kSmall, "C1,M2,10,", "C1,M2,10.001,", {"3: q1", "'C1'", "m.csv:2"}},
        BadFile{"joints_differ_across_visits", kFull, "v2,0,V250,0.5", "v2,0,V250,0.6", {"7: q1", "'C1'", "m.csv:4"}},
        BadFile{"sigma_zero", kFull, "0.1,0.2,0.3", "0.1,0,0.3", {"4: sigma_y_mm", "above 0"}},
        BadFile{"sigma_negative", kFull, "0.1,0.2,0.3", "0.1,0.2,-1", {"4: sigma_z_mm", "above 0"}},
        BadFile{"sigma_partly", kFull, "0.1,0.2,0.3", "0.1,0.2,", {"4: sigma_z_mm", "empty"}},
        BadFile{"approach", kFull, "-1,+1", "-1,2", {"4: approach2", "-1, 0 or 1"}},
        BadFile{"approach_differs", kFull, "-1,1,cal", "1,1,cal", {"5: approach", "m.csv:4"}},
        BadFile{"set", kFull, "0,0,validation", "0,0,validaton", {"7: set", "'validaton'", "'validation'"}},
        BadFile{"sim", kFull, "calibration,1,2,3,a", "calibration,1,2,x,a", {"4: sim_z_mm", "'x'"}},
        BadFile{"none_loaded", kFull, "0.3,0,0,0,0,0,0,1.5", "0.3,0,0,5,0,0,0,1.5", {"4: load", "none", "wrench"}},
        BadFile{"none_in_capitals",
                kFull,
                "0,none,0.5,0.2,1,2,4,0.1,0.2,0.3,0,0,0",
                "0,None,0.5,0.2,1,2,4,0.1,0.2,0.3,0,0,0",
                {"5: load", "'None'", "or no load?", "written none"}},
        BadFile{"wrench_differs",
                kFull,
                "C1,M2,S2,v1,0,none,0.5,0.2,1,2,4,0.1,0.2,0.3,0,0,0",
                "C1,M2,S2,v1,0,V250,0.5,0.2,1,2,4,0.1,0.2,0.3,0,0,-9",
                {"6: load", "m.csv:5", "some markers"}},
        BadFile{"time", kFull, "1.9,20", "noon,20", {"7: time_s", "'noon'"}}),
    [](const auto& param) { return std::string(param.param.name); });

TEST_F(MeasurementFileTest, RefusesWhatIsNoTable) {
  EXPECT_TRUE(SaysInOrder(Error(""), {"m.csv: ", "empty"}));
  EXPECT_TRUE(SaysInOrder(Error("\n"), {"m.csv: ", "empty"}));
  EXPECT_TRUE(SaysInOrder(Error("config,marker,q1_deg,q2_mm,x_mm,y_mm,z_mm\n"), {"m.csv:1", "no rows"}));
  EXPECT_TRUE(SaysInOrder(Error(std::string("c\0o,\0", 5)), {"m.csv:1", "not a text file"}));
  EXPECT_TRUE(SaysInOrder(Error(Replaced(kSmall, "C2,M1", "C\xE4,M1")), {"m.csv:4", "UTF-8"}));
  const auto read = [](const std::string& path) {
    return ErrorOf([&] { ReadMeasurements({path}, kJoints, kPrismatic); });
  };
  EXPECT_TRUE(SaysInOrder(read(folder_), {folder_, "folder"}));
  EXPECT_TRUE(SaysInOrder(read(Path("absent.csv")), {"absent.csv", "no such file"}));
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { ReadMeasurements({}, kJoints, kPrismatic); }), {"no measurement file"}));
}

TEST_F(MeasurementFileTest, AFileGivenTwiceIsRefused) {
  const std::string path = Write("m.csv", kSmall);
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] {
                            ReadMeasurements({path, path}, kJoints, kPrismatic);
                          }),
                          {"m.csv:2", "equals", "m.csv:2", "every column"}));
  const std::string turned = Write("t.csv", "marker,config,q1_deg,q2_mm,x_mm,y_mm,z_mm\nM1,C1,10,200,1,2,3\n");
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] {
                            ReadMeasurements({path, turned}, kJoints, kPrismatic);
                          }),
                          {"t.csv:2", "equals", "m.csv:2"}));
}

// How long they need is measured by tests/benchmarks.
TEST_F(MeasurementFileTest, RepeatsAmongManyRowsAreShotsOfTheirConfiguration) {
  std::string text = "config,marker,repeat,q1_deg,q2_mm,x_mm,y_mm,z_mm\n";
  constexpr int kRows = 20000;
  for (int i = 0; i < kRows; ++i) {
    const std::string config = i % 2 == 0 ? "C" : "C" + std::to_string(i);
    text += config + ",M1,0,12.5,100," + std::to_string(i) + ".5,2,3\n";
  }
  const Measurements data = Read(text);
  ASSERT_EQ(data.observations.size(), static_cast<size_t>(kRows));
  EXPECT_EQ(data.shots.size(), static_cast<size_t>(kRows));
  EXPECT_EQ(data.configurations.size(), static_cast<size_t>(kRows / 2 + 1));
  for (int i = 0; i < kRows; ++i) {
    const Observation& row = data.observations[i];
    ASSERT_EQ(data.ConfigurationOf(row).id, i % 2 == 0 ? "C" : "C" + std::to_string(i));
    ASSERT_NEAR(row.point_in_station.x(), 1e-3 * (i + 0.5), 1e-12);
  }
}

TEST_F(MeasurementFileTest, ReadsTheSharedData) {
  const std::string folder = test::SharedFolder() + "/data/";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "the shared data are not here: " << folder;
  const std::vector<std::string> joints = {"j1", "j2", "j3", "j4", "j5", "j6"};
  const auto read = [&](const std::vector<std::string>& names) {
    std::vector<std::string> paths;
    for (const std::string& name : names) paths.push_back(folder + name);
    return ReadMeasurements(paths, joints, std::vector<bool>(6, false));
  };
  const Measurements ur5 = read({"ur5_gts3800/measurements.csv"});
  EXPECT_EQ(ur5.observations.size(), 1020u);
  EXPECT_EQ(ur5.configurations.size(), 1020u);
  EXPECT_EQ(ur5.markers, std::vector<std::string>{"smr"});
  EXPECT_EQ(ur5.Cell(ur5.observations.back(), "group"), "random");
  const Measurements ur10 = read(
      {"ur10_leica/series_A.csv", "ur10_leica/series_B.csv", "ur10_leica/series_C.csv", "ur10_leica/series_D.csv"});
  EXPECT_EQ(ur10.observations.size(), 11911u + 1495u + 2773u + 632u);
  EXPECT_EQ(ur10.stations, (std::vector<std::string>{"A", "B", "C", "D"}));
  EXPECT_EQ(ur10.markers.size(), 2u);
  const Measurements practice = read({"practice/case010/measurements.csv"});
  EXPECT_EQ(practice.observations.size(), 405u);
  EXPECT_EQ(practice.markers.size(), 3u);
  EXPECT_TRUE(practice.warnings.empty());
  for (const Shot& shot : practice.shots) EXPECT_EQ(shot.observations.size(), 3u);
}

}  // namespace
}  // namespace sagitta::measurement_file_test

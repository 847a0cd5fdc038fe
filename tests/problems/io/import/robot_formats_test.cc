// Robots in other people's formats, against KDL chains built from the numbers themselves.
#include <gtest/gtest.h>

#include "models/dh_from_chain.h"
#include "problems/io/import/dh_text.h"
#include "problems/io/import/expressions.h"
#include "problems/io/import/robot_reading.h"
#include "problems/io/import/universal_robots.h"
#include "problems/io/urdf_robot.h"
#include "problems/io/urdf_writer.h"
#include "tests/problems/file_test_support.h"
#include "tests/support/paths.h"
#include "tests/support/urdf_arms.h"

#ifdef SAGITTA_HAVE_KDL

namespace sagitta::robot_formats_test {
namespace {

using test::DhRow;
using test::ExpectSameFlange;
using test::KdlChainOfDh;

class RobotFormats : public FileTest {
 protected:
  RobotReading Read(const std::string& text, const RobotReadOptions& options = {}) const {
    return ReadAnyRobot(Write("file.txt", text), options);
  }
};

// Columns in any order, separators, units, decimal comma, variables, multiples of pi: always the UR5.
TEST_F(RobotFormats, DhTablesOfEveryMake) {
  const KDL::Chain kdl = KdlChainOfDh(DhConvention::kStandard, test::Ur5Rows());
  const std::vector<std::string> tables = {
      "joint,type,theta_deg,d_mm,a_mm,alpha_deg\nA1,revolute,0,89.159,0,90\nA2,R,0,0,-425,0\nA3,R,0,0,-392.25,0\n"
      "A4,R,0,109.15,0,90\nA5,R,0,94.65,0,-90\nA6,R,0,82.3,0,0\n",
      "# standard DH\nalpha [rad];a [m];theta [rad];d "
      "[m]\n1,570796326794897;0;0;0,089159\n0;-0,425;0;0\n0;-0,39225;0;0\n"
      "1,570796326794897;0;0;0,10915\n-1,570796326794897;0;0;0,09465\n0;0;0;0,0823\n",
      "i\tθ (°)\td (mm)\ta (mm)\tα "
      "(°)\n1\tq1\t89.159\t0\t90\n2\tq2\t0\t-425\t0\n3\tq3\t0\t-392.25\t0\n4\tq4\t109.15\t0\t90\n"
      "5\tq5\t94.65\t0\t-90\n6\tq6\t82.3\t0\t0\n",
      " UR5 [Universal Robots]:: 6 axis, RRRRRR, stdDH\n+---+-----+-----+-----+-----+\n| j |   theta |     d |     a | "
      "  alpha |\n"
      "+---+-----+-----+-----+-----+\n|  1|       q1|  0.089159|      0|   pi/2|\n|  2|  q2|  0|  -0.425|  0|\n|  3|  "
      "q3|  0|  -0.39225|  0|\n"
      "|  4|  q4|  0.10915|  0|  pi/2|\n|  5|  q5|  0.09465|  0|  -pi/2|\n|  6|  q6|  0.0823|  0|  "
      "0|\n+---+-----+-----+-----+-----+\n",
      "a alpha d theta\n0 pi/2 0.089159 0\n-0.425 0 0 0\n-0.39225 0 0 0\n0 pi/2 0.10915 0\n0 -pi/2 0.09465 0\n0 0 "
      "0.0823 0\n",
      "L = [ Link([0 0.089159 0 pi/2]) ];\nrobot = SerialLink([0 0.089159 0 pi/2 0; 0 0 -0.425 0 0\n 0 0 -0.39225 0 0; "
      "0 0.10915 0 pi/2 0\n"
      "0, 0.09465, 0, -pi/2, 0; 0 0.0823 0 0 0], 'name', 'UR5');"};
  for (size_t i = 0; i + 1 < tables.size(); ++i) {
    SCOPED_TRACE(tables[i]);
    ExpectSameFlange(Read(tables[i]).robot.chain, kdl, 1e-9, 20);
  }
  const std::string serial_link = tables.back().substr(tables.back().find("robot"));
  ExpectSameFlange(Read(serial_link).robot.chain, kdl, 1e-9, 20);
  EXPECT_EQ(Read(serial_link).guesses.size(), 1u);
  ExpectSameFlange(
      Read("dhparams = [0 pi/2 0.089159 0; -0.425 0 0 0; ...\n -0.39225 0 0 0; 0 pi/2 0.10915 0; 0 -pi/2 0.09465 0; "
           "0 0 0.0823 0];\n setFixedTransform(jnt, dhparams(i,:), 'dh');\n")
          .robot.chain,
      kdl, 1e-9, 20);
}

TEST_F(RobotFormats, ModifiedTables) {
  const KDL::Chain kdl = KdlChainOfDh(DhConvention::kModified, test::PumaModifiedRows());
  const std::string rows = "1,0,0,0,0\n2,-90,0,0,0\n3,0,431.8,150.1,0\n4,-90,20.3,431.8,0\n5,90,0,0,0\n6,-90,0,0,0\n";
  ExpectSameFlange(Read("i,alpha_i-1 [deg],a_i-1 [mm],d_i [mm],theta_i [deg]\n" + rows).robot.chain, kdl, 1e-9, 20);
  ExpectSameFlange(Read("# Craig\ni,alpha_deg,a_mm,d_mm,theta_deg\n" + rows).robot.chain, kdl, 1e-9, 20);
  const RobotReading guessed = Read("i,alpha_deg,a_mm,d_mm,theta_deg\n" + rows);
  ExpectSameFlange(guessed.robot.chain, kdl, 1e-9, 20);
  EXPECT_EQ(guessed.guesses.size(), 1u);
}

TEST_F(RobotFormats, LengthsInInchesAndUnitsOfAnotherKind) {
  const std::string rows = "0;90;3.51;0\n-16.73;0;0;0\n";
  const Robot robot = Read("# standard DH\na [in];alpha [deg];d [in];theta [deg]\n" + rows).robot;
  ASSERT_TRUE(robot.dh);
  EXPECT_NEAR(robot.dh->links[0].d, 3.51 * 0.0254, 1e-15);
  EXPECT_NEAR(robot.dh->links[1].a, -16.73 * 0.0254, 1e-15);
  for (const char* header : {"a [deg];alpha [deg];d [mm];theta [deg]", "a [mm];alpha [mm];d [mm];theta [deg]",
                             "a [mm];alpha [deg];d [s];theta [deg]"}) {
    EXPECT_THROW(Read(std::string("# standard DH\n") + header + "\n" + rows), InputError) << header;
  }
}

TEST_F(RobotFormats, WhatCannotBeKnownIsRefused) {
  const std::string rows = "1,90,100,200,0\n2,90,100,0,0\n3,90,50,0,0\n";
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { Read("i,alpha_deg,a_mm,d_mm,theta_deg\n" + rows); }),
                          {"standard or a modified", "--convention"}));
  RobotReadOptions modified;
  modified.convention = DhConvention::kModified;
  EXPECT_EQ(Read("i,alpha_deg,a_mm,d_mm,theta_deg\n" + rows, modified).robot.num_joints(), 3);
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { Read("j,theta,d,a,alpha\n1,-q1,L1,0,90\n"); }), {"file.txt"}));
  EXPECT_TRUE(SaysInOrder(
      ErrorOf([&] { Read("Robot: (6 bodies)\n Idx    Body Name   Joint Name   Joint Type\n 1 b j revolute\n"); }),
      {"exportrobot"}));
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { Read("Rz(q1)Tz(L1)Rx(-90)"); }), {"Tz(L1)", "no value"}));
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { Read("hello\nworld\n"); }), {"no robot"}));
}

// The same Puma, written as a sequence of elementary transforms.
TEST_F(RobotFormats, ElementaryTransforms) {
  const RobotReading reading = Read(
      "Rz(q1) Rx(-90) Rz(q2) Tx(0.4318) Tz(0.1501) Rz(q3) Rx(-90) Tx(0.0203) Tz(0.4318) Rz(q4) Rx(90) Rz(q5) Rx(-90) "
      "Rz(q6)");
  ExpectSameFlange(reading.robot.chain, KdlChainOfDh(DhConvention::kModified, test::PumaModifiedRows()), 1e-9, 20);
}

TEST_F(RobotFormats, UniversalRobotsFiles) {
  const std::string dh =
      "[DH]\na = [0.00000, -0.42500, -0.39225, 0.00000, 0.00000, 0.0000]\nd = [0.089159, 0.00000, 0.00000, 0.10915, "
      "0.09465, 0.0823]\n"
      "alpha = [ 1.570796326794897, 0, 0, 1.570796326794897, -1.570796326794897, 0 ]\nq_home_offset = [0, -1.57, 0, "
      "-1.57, 0, 0]\n";
  ExpectSameFlange(Read(dh).robot.chain, KdlChainOfDh(DhConvention::kStandard, test::Ur5Rows()), 1e-9, 20);
  const std::string deltas =
      "[mounting]\n# by the factory\ndelta_theta = [ 1e-05, 0.02, -0.01, -0.01, 2e-05, 0]\ndelta_a = [ 1e-4, 0.0002, "
      "-3e-4, 0, 0, 0]\n"
      "delta_d = [ 0.0001, 20.5, -20.7, 0.2, -1e-4, 3e-5]\ndelta_alpha = [ 1e-4, -2e-4, 3e-4, 1e-4, 0, "
      "0]\ncalibration_status = 2\n";
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { Read(deltas); }), {"differences", "--nominal"}));
  RobotReadOptions options;
  options.nominal_file = Write("urcontrol.conf", dh);
  auto rows = test::Ur5Rows();
  const double dt[] = {1e-5, 0.02, -0.01, -0.01, 2e-5, 0}, da[] = {1e-4, 2e-4, -3e-4, 0, 0, 0},
               dd[] = {1e-4, 20.5, -20.7, 0.2, -1e-4, 3e-5}, dalpha[] = {1e-4, -2e-4, 3e-4, 1e-4, 0, 0};
  for (int i = 0; i < 6; ++i) {
    rows[i].theta_deg += dt[i] / kDegree;
    rows[i].a += da[i];
    rows[i].d += dd[i];
    rows[i].alpha_deg += dalpha[i] / kDegree;
  }
  const Robot calibrated = Read(deltas, options).robot;
  const KDL::Chain kdl = KdlChainOfDh(DhConvention::kStandard, rows);
  ExpectSameFlange(calibrated.chain, kdl, 1e-9, 20);
  // As the driver's file, and read again.
  ExpectSameFlange(Read(RobotToUrCalibration(calibrated)).robot.chain, kdl, 1e-9, 20);
  // As the controller's, alone and into a file whose other lines stay.
  const DhTable nominal = *Read(dh).robot.dh;
  ExpectSameFlange(Read(RobotToUrConf(calibrated, nominal, "", ""), options).robot.chain, kdl, 1e-9, 20);
  const std::string kept = RobotToUrConf(calibrated, nominal, deltas, "calibration.conf");
  ExpectSameFlange(Read(kept, options).robot.chain, kdl, 1e-9, 20);
  EXPECT_EQ(kept.rfind("[mounting]\n# by the factory\ndelta_theta = [ ", 0), 0u);
  EXPECT_NE(kept.find("]\ncalibration_status = 2\n"), std::string::npos);
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { RobotToUrConf(calibrated, nominal, "[mounting]\ndelta_a = [0]\n", "c.conf"); }),
                          {"c.conf", "delta_theta", "no such list"}));
}

// What a calibration leaves of parallel axes: nearly parallel ones with Hayati's beta, which the controller's file has
// not. The differences are metres along the axes, and hold the arm all the same.
TEST_F(RobotFormats, AxesOffParallelGoIntoAUrConfExactly) {
  auto rows = test::Ur5Rows();
  Robot robot =
      Read(
          "# standard DH\na alpha d theta\n0 pi/2 0.089159 0\n-0.425 0 0 0\n-0.39225 0 0 0\n0 pi/2 0.10915 0\n"
          "0 -pi/2 0.09465 0\n0 0 0.0823 0\n")
          .robot;
  DhTable table = *robot.dh;
  table.links[1].beta = 3e-4;
  table.links[2].beta = -2e-4;
  table.links[2].alpha = 5e-4;
  const Robot calibrated = RobotOfTable(robot.chain.joints, {}, table);
  // Ry(beta) behind each row, by KDL.
  KDL::Chain kdl;
  const double beta[] = {0, 3e-4, -2e-4, 0, 0, 0}, alpha[] = {0, 0, 5e-4, 0, 0, 0};
  for (size_t i = 0; i < 6; ++i) {
    const KDL::Frame row =
        KDL::Frame::DH(rows[i].a, rows[i].alpha_deg * kDegree + alpha[i], rows[i].d, rows[i].theta_deg * kDegree);
    kdl.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::RotZ), row * KDL::Frame(KDL::Rotation::RotY(beta[i]))));
  }
  RobotReadOptions options;
  options.nominal_file = Write("nominal.csv", DhTableToCsv(robot, *robot.dh));
  const std::string conf = RobotToUrConf(calibrated, *robot.dh, "", "");
  ExpectSameFlange(Read(conf, options).robot.chain, kdl, 1e-9, 20);
}

Eigen::VectorXd Degrees(const std::vector<double>& degrees) {
  return Eigen::Map<const Eigen::VectorXd>(degrees.data(), degrees.size()) * kDegree;
}

// Manufacturers' tables, in three separators and both conventions: where the flange is in poses that the dimension
// drawings show, by hand (mm).
TEST(ShippedTables, FlangeIsWhereTheDrawingHasIt) {
  struct Pose {
    const char* name;
    std::vector<double> q_deg;
    Vector3<double> flange_mm;
  };
  const double s = std::sin(30 * kDegree), c = std::cos(30 * kDegree);
  const std::vector<Pose> poses = {
      {"irb120", {0, 0, 0, 0, 0, 0}, {302 + 72, 0, 290 + 270 + 70}},
      {"irb120", {30, 0, 0, 0, 0, 0}, {374 * c, 374 * s, 630}},
      {"irb120", {0, 30, -30, 0, 0, 0}, {270 * s + 374, 0, 290 + 270 * c + 70}},
      {"kr6_r900", {0, 0, 0, 0, 0, 0}, {25 + 455 + 420 + 80, 0, 400 + 35}},
      {"kr6_r900", {0, -90, 90, 0, 0, 0}, {25 + 420 + 80, 0, 400 + 455 + 35}},
      {"kr6_r900", {30, -90, 90, 0, 0, 0}, {525 * c, -525 * s, 890}},
      {"lrmate200id", {0, 0, 0, 0, 0, 0}, {50 + 420 + 80, 0, 440 + 35}},
      {"lrmate200id", {0, 30, 0, 0, 0, 0}, {50 + 440 * s + 500, 0, 440 * c + 35}},
      {"lrmate200id", {0, 0, 30, 0, 0, 0}, {50 + 500 * c - 35 * s, 0, 440 + 500 * s + 35 * c}},
      {"tx60", {0, 0, 0, 0, 0, 0}, {0, 20, 375 + 290 + 310 + 70}},
      {"tx60", {0, 90, 0, 0, 0, 0}, {290 + 310 + 70, 20, 375}},
      {"ur5", {0, 0, 0, 0, 0, 0}, {-425 - 392.25, -109.15 - 82.3, 89.159 - 94.65}},
      {"ur10", {0, 0, 0, 0, 0, 0}, {-612 - 572.3, -163.941 - 92.2, 127.3 - 115.7}},
      {"ur3", {0, 0, 0, 0, 0, 0}, {-243.65 - 213.25, -112.35 - 81.9, 151.9 - 85.35}}};
  for (const Pose& pose : poses) {
    SCOPED_TRACE(pose.name);
    const Robot robot = ReadAnyRobot(test::SourceFolder() + "/problems/published/robots/" + pose.name + ".csv").robot;
    EXPECT_FALSE(robot.name.empty());
    const Vector3<double> flange = 1e3 * test::FlangeOf(robot.chain, Degrees(pose.q_deg)).translation;
    EXPECT_LT((flange - pose.flange_mm).norm(), 1e-9) << flange.transpose();
  }
}

// The makers' numbers typed once more, to KDL: at any joint values, not only where a drawing shows the arm. FANUC
// counts J3 from the horizontal: what turns there is q3 + q2.
TEST(ShippedTables, FlangeIsThatOfKdl) {
  struct Maker {
    const char* name;
    DhConvention convention;
    std::vector<DhRow> rows;
    double third_by_second;
  };
  const std::vector<Maker> makers = {
      {"ur10",
       DhConvention::kStandard,
       {{0, 90, 0.1273, 0},
        {-0.612, 0, 0, 0},
        {-0.5723, 0, 0, 0},
        {0, 90, 0.163941, 0},
        {0, -90, 0.1157, 0},
        {0, 0, 0.0922, 0}},
       0.0},
      {"kr6_r900",
       DhConvention::kModified,
       {{0, 180, -0.4, 0},
        {0.025, 90, 0, 0},
        {0.455, 0, 0, -90},
        {0.035, 90, -0.42, 0},
        {0, -90, 0, 0},
        {0, 90, -0.08, 180}},
       0.0},
      {"irb120",
       DhConvention::kStandard,
       {{0, -90, 0.29, 0}, {0.27, 0, 0, -90}, {0.07, -90, 0, 0}, {0, 90, 0.302, 0}, {0, -90, 0, 0}, {0, 0, 0.072, 180}},
       0.0},
      {"lrmate200id",
       DhConvention::kModified,
       {{0, 0, 0, 0},
        {0.05, -90, 0, -90},
        {0.44, 180, 0, 0},
        {0.035, -90, -0.42, 0},
        {0, 90, 0, 0},
        {0, -90, -0.08, 180}},
       1.0},
      {"tx60",
       DhConvention::kStandard,
       {{0, -90, 0.375, 0}, {0.29, 0, 0.02, -90}, {0, 90, 0, 90}, {0, -90, 0.31, 0}, {0, 90, 0, 0}, {0, 0, 0.07, 0}},
       0.0}};
  test::RandomNumbers random(23);
  for (const Maker& maker : makers) {
    SCOPED_TRACE(maker.name);
    const Robot robot = ReadAnyRobot(test::SourceFolder() + "/problems/published/robots/" + maker.name + ".csv").robot;
    const KDL::Chain kdl = KdlChainOfDh(maker.convention, maker.rows);
    for (int trial = 0; trial < 30; ++trial) {
      Eigen::VectorXd q(6);
      for (int j = 0; j < 6; ++j) q[j] = random.Uniform(-M_PI, M_PI);
      const Pose<double> flange = test::FlangeOf(robot.chain, q);
      q[2] += maker.third_by_second * q[1];
      const KDL::Frame expected = test::KdlFlange(kdl, q);
      for (int r = 0; r < 3; ++r) {
        ASSERT_NEAR(flange.translation[r], expected.p[r], 1e-9);
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(flange.rotation(r, c), expected.M(r, c), 1e-9);
      }
    }
  }
}

std::vector<DhRow> Perturbed(std::vector<DhRow> rows, bool with_beta) {
  test::RandomNumbers random(3);
  for (DhRow& row : rows) {
    row.a += random.Uniform(-1e-3, 1e-3);
    row.d += random.Uniform(-1e-3, 1e-3);
    row.alpha_deg += random.Uniform(-0.05, 0.05);
    row.theta_deg += random.Uniform(-0.05, 0.05);
    if (with_beta) row.beta_deg = random.Uniform(-0.05, 0.05);
  }
  return rows;
}

struct Arm {
  const char* name;
  DhConvention convention;
  std::vector<DhRow> rows;
};
void PrintTo(const Arm& arm, std::ostream* out) { *out << arm.name; }

class DhRoundTrip : public ::testing::TestWithParam<Arm> {};

INSTANTIATE_TEST_SUITE_P(
    Arms, DhRoundTrip,
    ::testing::Values(Arm{"Ur5", DhConvention::kStandard, test::Ur5Rows()},
                      Arm{"Ur5Calibrated", DhConvention::kStandard, Perturbed(test::Ur5Rows(), false)},
                      Arm{"Puma", DhConvention::kStandard, Perturbed(test::PumaStandardRows(), false)},
                      Arm{"PumaModified", DhConvention::kModified, test::PumaModifiedRows()},
                      Arm{"Iiwa", DhConvention::kStandard, test::IiwaRows()},
                      Arm{"IiwaCalibrated", DhConvention::kStandard, Perturbed(test::IiwaRows(), false)},
                      Arm{"Track", DhConvention::kStandard, test::TrackRows()},
                      Arm{"Scara", DhConvention::kStandard, test::ScaraRows()},
                      Arm{"ScaraCalibrated", DhConvention::kStandard, Perturbed(test::ScaraRows(), false)}),
    [](const auto& arm) { return std::string(arm.param.name); });

// DH -> chain without names -> standard and modified table -> CSV -> URDF and back: always KDL's flange.
TEST_P(DhRoundTrip, ThroughEveryFormat) {
  const KDL::Chain kdl = KdlChainOfDh(GetParam().convention, GetParam().rows);
  Robot robot;
  robot.chain = test::DhArm(GetParam().convention, GetParam().rows);
  for (const DhConvention convention : {DhConvention::kStandard, DhConvention::kModified}) {
    std::string why_not;
    const std::optional<DhTable> table = DhTableFromChain(robot.chain, convention, &why_not);
    ASSERT_TRUE(table) << why_not;
    ExpectSameFlange(ChainFromDhTable(robot.chain.joints, {}, *table), kdl, 1e-9, 30);
    for (const DhLink& link : table->links)
      EXPECT_LT(std::abs(link.d) + std::abs(link.a), 3.0) << "no parameter runs away";
    const Robot from_csv = ReadDhText(DhTableToCsv(robot, *table), "table.csv", {}).robot;
    ASSERT_TRUE(from_csv.dh);
    EXPECT_EQ(from_csv.dh->convention, convention);
    ExpectSameFlange(from_csv.chain, kdl, 1e-9, 30);
    ExpectSameFlange(ReadUrdfText(RobotToUrdf(from_csv), "robot.urdf").chain, kdl, 1e-9, 30);
    const std::optional<DhTable> other = InConvention(*table, DhConvention::kStandard, &why_not);
    ASSERT_TRUE(other) << why_not;
    ExpectSameFlange(ChainFromDhTable(robot.chain.joints, {}, *other), kdl, 1e-9, 30);
  }
}

// Manufacturers' tables come out as they are printed: the UR5's, signs and all.
TEST(DhFromChainTest, PrintedTableComesBack) {
  std::string why_not;
  const DhTable table =
      *DhTableFromChain(test::DhArm(DhConvention::kStandard, test::Ur5Rows()), DhConvention::kStandard, &why_not);
  const auto rows = test::Ur5Rows();
  for (int j = 0; j < 6; ++j) {
    EXPECT_NEAR(table.links[j].a, rows[j].a, 1e-12) << j;
    EXPECT_NEAR(table.links[j].alpha, rows[j].alpha_deg * kDegree, 1e-12) << j;
    EXPECT_NEAR(table.links[j].theta, 0.0, 1e-12) << j;
    EXPECT_EQ(table.links[j].beta, 0.0) << j;
  }
  EXPECT_NEAR(table.links[0].d, rows[0].d, 1e-12);
}

TEST(DhFromChainTest, BaseThatIsNotOnTheFirstAxisIsRefusedInWords) {
  std::string why_not;
  const Robot robot = ReadUrdfText(test::UrdfText(test::ObliqueStyle()), "arm.urdf");
  EXPECT_FALSE(DhTableFromChain(robot.chain, DhConvention::kStandard, &why_not));
  EXPECT_NE(why_not.find("'track'"), std::string::npos) << why_not;
}

// A first joint that counts against the base's z axis: alpha of a modified table's first row turns the base over.
TEST(DhFromChainTest, AFirstAxisThatCountsTheOtherWay) {
  for (const bool slides : {false, true}) {
    Robot robot;
    robot.chain = test::DhArm(DhConvention::kStandard, Perturbed(slides ? test::TrackRows() : test::Ur5Rows(), false));
    robot.chain.transforms[robot.chain.JointTransform(0)].sign = -1.0;
    std::string why_not;
    EXPECT_FALSE(DhTableFromChain(robot.chain, DhConvention::kStandard, &why_not));
    EXPECT_NE(why_not.find(slides ? "along the z axis of the base and counts the other way"
                                  : "about the z axis of the base and counts the other way"),
              std::string::npos)
        << why_not;
    const std::optional<DhTable> table = DhTableFromChain(robot.chain, DhConvention::kModified, &why_not);
    ASSERT_TRUE(table) << why_not;
    const Chain written = ReadDhText(DhTableToCsv(robot, *table), "table.csv", {}).robot.chain;
    test::RandomNumbers random(3);
    for (int trial = 0; trial < 30; ++trial) {
      const Eigen::VectorXd q = test::RandomJointValues(robot.chain, &random);
      const Pose<double> a = test::FlangeOf(robot.chain, q), b = test::FlangeOf(written, q);
      EXPECT_LT((a.translation - b.translation).norm(), 1e-9);
      EXPECT_LT((a.rotation - b.rotation).norm(), 1e-9);
    }
  }
}

// RMS over flange and tool points of a table's arm against the true one.
double RmsOf(const Chain& truth, const DhTable& table, double tool) {
  const Chain chain = ChainFromDhTable(truth.joints, {}, table);
  test::RandomNumbers random(9);
  double sum = 0.0;
  for (int trial = 0; trial < 300; ++trial) {
    const Eigen::VectorXd q = test::RandomJointValues(truth, &random);
    const Pose<double> a = test::FlangeOf(truth, q), b = test::FlangeOf(chain, q);
    for (const Vector3<double>& point :
         {Vector3<double>(0, 0, 0), Vector3<double>(tool, 0, 0), Vector3<double>(0, tool, 0)}) {
      sum += (a * point - b * point).squaredNorm() / 900;
    }
  }
  return std::sqrt(sum);
}

// Tilts between parallel axes have no place in a table without beta: the refit is the best there is near the printed
// values (no parameter can be moved with profit), and its cost is that of other poses.
TEST(PlainDhTest, IsTheBestTableWithoutBeta) {
  auto rows = test::Ur5Rows();
  rows[1].beta_deg = 0.5e-3 / kDegree;
  rows[2].beta_deg = -0.3e-3 / kDegree;
  const Chain chain = test::DhArm(DhConvention::kStandard, rows);
  std::string why_not;
  const DhTable exact = *DhTableFromChain(chain, DhConvention::kStandard, &why_not);
  const PlainDhFit fit = FitPlainDh(chain, exact);
  DhTable dropped = exact;
  for (DhLink& link : dropped.links) link.beta = 0.0;
  const double cost = RmsOf(chain, fit.table, 0.1);
  EXPECT_LT(cost, 0.99 * RmsOf(chain, dropped, 0.1));
  EXPECT_NEAR(RmsOf(chain, fit.table, 0.0), fit.rms, 0.1 * fit.rms);
  EXPECT_GT(fit.rms, 0.05e-3);
  EXPECT_GE(fit.max, fit.rms);
  EXPECT_LT(fit.largest_length_change, 20e-3);
  for (size_t i = 0; i < fit.table.links.size(); ++i) {
    EXPECT_EQ(fit.table.links[i].beta, 0.0);
    for (double DhLink::*field : {&DhLink::a, &DhLink::d, &DhLink::alpha, &DhLink::theta}) {
      for (const double step : {-3e-4, 3e-4}) {
        DhTable moved = fit.table;
        moved.links[i].*field += step;
        EXPECT_GT(RmsOf(chain, moved, 0.1), 0.98 * cost) << i;
      }
    }
  }
}

// The largest distance within the limits, by another search: random steps from the worst of many poses. A sample of 400
// has 0.9 of it.
TEST(PlainDhTest, NoPoseIsFartherOffThanTheLargest) {
  auto rows = test::Ur5Rows();
  rows[1].beta_deg = rows[2].beta_deg = 0.03;
  Chain chain = test::DhArm(DhConvention::kStandard, rows);
  for (Joint& joint : chain.joints) {
    joint.min = -2.0;
    joint.max = 1.5;
  }
  std::string why_not;
  const PlainDhFit fit = FitPlainDh(chain, *DhTableFromChain(chain, DhConvention::kStandard, &why_not));
  const Chain plain = ChainFromDhTable(chain.joints, {}, fit.table);
  const auto off = [&](const Eigen::VectorXd& q) {
    return (test::FlangeOf(chain, q).translation - test::FlangeOf(plain, q).translation).norm();
  };
  test::RandomNumbers random(11);
  double largest = 0.0;
  for (int start = 0; start < 20; ++start) {
    Eigen::VectorXd best;
    double here = 0.0;
    for (int trial = 0; trial < 4000; ++trial) {
      Eigen::VectorXd q(6);
      const double reach = trial < 1000 ? 3.5 : 1.0 * std::pow(1e-3, (trial - 1000) / 3000.0);
      for (int j = 0; j < 6; ++j) {
        const double centre = trial < 1000 ? -0.25 : best[j];
        q[j] = std::clamp(centre + reach * random.Uniform(-0.5, 0.5), -2.0, 1.5);
      }
      if (off(q) <= here) continue;
      here = off(q);
      best = q;
    }
    largest = std::max(largest, here);
  }
  EXPECT_NEAR(fit.max, largest, 0.01 * largest);
}

TEST(ExpressionTest, NumbersAsPeopleTypeThem) {
  EXPECT_NEAR(ParseTypedNumber("-pi/2")->value, -0.5 * kPi, 1e-15);
  EXPECT_NEAR(ParseTypedNumber("0.5*π")->value, 0.5 * kPi, 1e-15);
  EXPECT_TRUE(ParseTypedNumber("90°")->is_degrees);
  EXPECT_EQ(ParseTypedNumber("−90")->value, -90.0);
  EXPECT_FALSE(ParseTypedNumber("L1"));
  // Each factor is a number, their quotient is none.
  EXPECT_FALSE(ParseTypedNumber(std::string(250, '9') + "pi/0." + std::string(100, '0') + "1"));
  EXPECT_EQ(ParseJointExpression("θ2 - 90")->offset.value, -90.0);
  EXPECT_EQ(ParseJointExpression("θ2 - 90")->index, 2);
  EXPECT_EQ(ParseJointExpression("90+q3")->offset.value, 90.0);
  EXPECT_EQ(ParseJointExpression("-q3")->sign, -1.0);
  EXPECT_FALSE(ParseJointExpression("12"));
}

}  // namespace
}  // namespace sagitta::robot_formats_test

#else

TEST(RobotFormats, FlangeIsThatOfKdl) {
  GTEST_SKIP() << "liborocos-kdl-dev is not installed: no independent forward kinematics";
}

#endif

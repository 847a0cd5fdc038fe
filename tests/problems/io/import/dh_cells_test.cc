// Cells, columns and rows of DH tables as text: each counts, or the table is refused.
#include <gtest/gtest.h>

#include "models/constants.h"
#include "problems/io/import/robot_reading.h"
#include "tests/problems/file_test_support.h"

namespace sagitta::dh_cells_test {
namespace {

class DhCells : public FileTest {
 protected:
  RobotReading Read(const std::string& text) const { return ReadAnyRobot(Write("file.csv", "# standard DH\n" + text)); }
  std::string Error(const std::string& text) const {
    return ErrorOf([&] { Read(text); });
  }
  static bool Says(const std::vector<std::string>& lines, const std::string& words) {
    return std::any_of(lines.begin(), lines.end(),
                       [&](const std::string& line) { return line.find(words) != std::string::npos; });
  }
};

TEST_F(DhCells, WithPiIsRadAndBeyondAFullTurnIsDeg) {
  const RobotReading reading =
      Read("joint,theta,d [mm],a [mm],alpha\n1,q1,400,0,-pi/2\n2,q2-90,0,500,0\n3,q3,0,100,-pi/2\n");
  EXPECT_NEAR(reading.robot.dh->links[1].theta, -0.5 * kPi, 1e-15);
  EXPECT_NEAR(reading.robot.dh->links[0].alpha, -0.5 * kPi, 1e-15);
  EXPECT_TRUE(reading.guesses.empty());
  EXPECT_TRUE(Says(reading.notes, "angles with pi are in rad, the others in deg"));
  const auto marked = Read("joint,a,alpha,d,theta\n1,0,-π/2,400,0\n2,500,0°,0,-90°\n3,100,90,0,0\n").robot.dh->links;
  EXPECT_NEAR(marked[0].alpha, -0.5 * kPi, 1e-15);
  EXPECT_NEAR(marked[1].theta, -0.5 * kPi, 1e-15);
  EXPECT_NEAR(marked[2].alpha, 0.5 * kPi, 1e-15);
  // Without pi, 1.5 and 90 are in one unit; with pi, 1.5 may be in either.
  EXPECT_TRUE(SaysInOrder(Error("joint,theta,d [mm],a [mm],alpha\n1,q1,400,0,-pi/2\n2,q2-90,0,500,0\n3,q3,0,100,1.5\n"),
                          {"file.csv:5", "alpha", "'1.5' may be in deg or in rad"}));
  EXPECT_NEAR(Read("joint,theta,d [mm],a [mm],alpha\n1,q1,400,0,-pi/2\n2,q2-1.5,0,500,0\n").robot.dh->links[1].theta,
              -1.5, 1e-15);
}

TEST_F(DhCells, OffsetsOfThetaCount) {
  for (const char* name : {"theta_offset", "theta offset", "offset", "joint_offset", "theta_offset [deg]"}) {
    const auto links =
        Read(std::string("joint,a_mm,alpha,d_mm,") + name + "\n1,0,pi/2,400,0\n2,500,0,0,90\n3,100,-pi/2,0,0\n")
            .robot.dh->links;
    EXPECT_NEAR(links[1].theta, 0.5 * kPi, 1e-15) << name;
  }
  EXPECT_TRUE(SaysInOrder(Error("joint,type,a_mm,alpha_deg,d_mm,offset\n1,R,0,90,400,0\n2,P,500,0,0,90\n"),
                          {"file.csv:4", "offset", "slides"}));
}

TEST_F(DhCells, SignsAreReadOrRefused) {
  const std::string header = "joint,a_mm,alpha_deg,d_mm,theta_deg,sign\n";
  EXPECT_EQ(Error(header + "1,0,90,400,0,1\n2,500,0,0,0,+1\n"), "");
  EXPECT_TRUE(SaysInOrder(Error(header + "1,0,90,400,0,1\n2,500,0,0,0,-1\n"), {"file.csv:4", "sign", "joint round"}));
  EXPECT_TRUE(SaysInOrder(Error(header + "1,0,90,400,0,1\n2,500,0,0,0,2\n"), {"file.csv:4", "'2' is no sign"}));
}

TEST_F(DhCells, LimitsWithoutUnitAreReadWhereTheirSizeSaysIt) {
  const std::string header = "joint,type,a_mm,alpha_deg,d_mm,theta_deg,min,max\n";
  const RobotReading reading = Read(header + "A1,R,0,90,400,0,-180,180\nA2,P,500,0,0,90,-20,500\nA3,R,9,0,0,0,,\n");
  const std::vector<Joint>& joints = reading.robot.chain.joints;
  EXPECT_NEAR(*joints[0].min, -kPi, 1e-15);
  EXPECT_NEAR(*joints[0].max, kPi, 1e-15);
  EXPECT_NEAR(*joints[1].min, -0.02, 1e-15);
  EXPECT_NEAR(*joints[1].max, 0.5, 1e-15);
  EXPECT_FALSE(joints[2].min);
  EXPECT_TRUE(Says(reading.guesses, "limits of joints that turn are in deg"));
  EXPECT_TRUE(Says(reading.guesses, "limits of joints that slide are in mm"));
  EXPECT_TRUE(SaysInOrder(Error(header + "A1,R,0,90,400,0,-3.1,3.1\nA2,R,500,0,0,90,-1,1\n"),
                          {"file.csv:3", "min", "in deg or rad"}));
  EXPECT_NEAR(*Read("joint,a_m,alpha_rad,d_m,theta_rad,min,max\n1,0,1.57,0.4,0,-3.1,3.1\n2,1,0,0,0,-pi,pi\n")
                   .robot.chain.joints[0]
                   .max,
              3.1, 1e-15);
  EXPECT_TRUE(SaysInOrder(Error(header + "A1,R,0,90,400,0,180,-180\n"), {"file.csv:3", "swapped"}));
  EXPECT_TRUE(SaysInOrder(Error(header + "A1,R,0,90,400,0,±180,\n"), {"file.csv:3", "no limit"}));
}

// Of lengths without a unit zeros say none, and d's comes first.
TEST_F(DhCells, LimitsOfSlidesAreInTheUnitOfD) {
  const std::string rows = "\nX,0,90,200,90,P,0,1000\nY,0,90,150,90,P,0,800\n";
  const RobotReading gantry = Read("joint,a,alpha [deg],d [mm],theta [deg],type,min,max" + rows);
  EXPECT_NEAR(*gantry.robot.chain.joints[0].max, 1.0, 1e-15);
  EXPECT_TRUE(Says(gantry.guesses, "limits of joints that slide are in mm"));
  const std::string zeros = "\nX,0,90,0,90,P,0,15\nY,0,90,0,90,P,0,8\n";
  EXPECT_NEAR(*Read("joint,a [mm],alpha [deg],d,theta [deg],type,min,max" + zeros).robot.chain.joints[0].max, 0.015,
              1e-15);
  EXPECT_TRUE(SaysInOrder(Error("joint,a,alpha [deg],d,theta [deg],type,min,max" + zeros),
                          {"file.csv:3", "max", "limits of up to 15 are in m or mm cannot be seen", "max [mm]"}));
  EXPECT_TRUE(SaysInOrder(Error("joint,a [m],alpha [deg],d [m],theta [deg],type,min,max\nX,0,90,0.2,90,P,0,1000\n"),
                          {"file.csv:3", "max", "a limit of 1000 m, which no track is long"}));
}

TEST_F(DhCells, OtherColumnsAreSaidOrRefused) {
  const RobotReading reading =
      Read("joint,a_mm,alpha_deg,d_mm,theta_deg,gear,mass_kg\n1,0,90,400,0,100,3\n2,5,0,0,0,-9,2\n");
  EXPECT_TRUE(Says(reading.notes, "columns not read: 'gear', 'mass_kg'"));
  EXPECT_TRUE(SaysInOrder(Error("joint,a_mm,alpha_deg,d_mm,theta_deg,coupling\n1,0,90,400,0,0\n2,5,0,0,0,1\n"),
                          {"file.csv:4", "coupling", "no place for '1'"}));
  EXPECT_TRUE(SaysInOrder(Error("joint,a_mm,alpha_deg,d_mm,theta_deg,gamma [deg]\n1,0,90,400,0,0\n2,5,0,0,0,1\n"),
                          {"file.csv:4", "gamma", "no place for '1'"}));
  EXPECT_EQ(Error("joint,a_mm,alpha_deg,d_mm,theta_deg,home_deg\n1,0,90,400,0,0\n2,5,0,0,0,-90\n"), "");
  EXPECT_TRUE(SaysInOrder(Error("joint,a_mm,r_mm,alpha_deg,d_mm,theta_deg\n1,0,0,90,400,0\n2,5,6,0,0,0\n"),
                          {"file.csv:2", "mean the same"}));
}

TEST_F(DhCells, RowsAreInTheOrderOfTheirNumbers) {
  const std::string header = "joint,a_mm,alpha_deg,d_mm,theta_deg\n";
  EXPECT_TRUE(SaysInOrder(Error(header + "2,500,0,0,0\n1,0,90,400,0\n3,100,-90,0,0\n"),
                          {"file.csv:4", "joint 1 stands where joint 3 is expected"}));
  EXPECT_TRUE(SaysInOrder(Error("a_mm,alpha_deg,d_mm,theta\n500,0,0,q2\n0,90,400,q1\n100,-90,0,q3\n"),
                          {"file.csv:4", "joint 1 stands where joint 3 is expected"}));
  EXPECT_EQ(Read(header + "0,500,0,0,0\n1,0,90,400,0\n").robot.chain.joints[0].name, "j1");
  EXPECT_EQ(Read(header + "4,500,0,0,0\n5,0,90,400,0\n").robot.chain.joints[0].name, "j4");
  const RobotReading named = Read(header + "A2,500,0,0,0\nA1,0,90,400,0\n");
  EXPECT_EQ(named.robot.chain.joints[0].name, "A2");
  EXPECT_TRUE(Says(named.guesses, "A2 lies before A1"));
}

TEST_F(DhCells, ARowThatIsNoJointIsRefused) {
  const std::string header = "joint,a_mm,alpha_deg,d_mm,theta_deg\n", rows = "1,0,90,400,0\n2,500,0,0,0\n";
  EXPECT_TRUE(SaysInOrder(Error(header + rows + "TCP,0,0,120,0\n"), {"file.csv:5", "'TCP' is no joint", "# flange:"}));
  EXPECT_TRUE(SaysInOrder(Error(header + rows + "Sum,500,90,400,0\n"), {"file.csv:5", "'Sum' is no joint"}));
  EXPECT_TRUE(SaysInOrder(Error(header + "A1,0,90,400,0\nA2,5,0,0,0\nflange,0,0,120,0\n"), {"'flange' is no joint"}));
  EXPECT_TRUE(SaysInOrder(Error("a_mm,alpha_deg,d_mm,theta\n0,90,400,q1\n5,0,0,q2\n0,0,120,0\n"),
                          {"file.csv:5", "no joint variable"}));
  EXPECT_EQ(Error("joint,type,a_mm,alpha_deg,d_mm,theta_deg\ntool,R,0,90,400,0\n2,R,5,0,0,0\n"), "");
}

TEST_F(DhCells, CouplingsAreStatedOnce) {
  const std::string rows = "joint,a_mm,alpha_deg,d_mm,theta_deg\n1,0,90,400,0\n2,500,0,0,0\n";
  EXPECT_EQ(Error("# coupling: j2 j1 1\n" + rows), "");
  EXPECT_TRUE(SaysInOrder(Error("# coupling: j2 j1 1\n# coupling: j2 j1 0.5\n" + rows), {"'j1' drives 'j2' twice"}));
}

TEST_F(DhCells, AThousandIsNotReadAsOne) {
  const std::string header = "Achse;a [mm];alpha [°];d [mm];theta [°]\nA1;350;-90;750;0\n";
  EXPECT_TRUE(SaysInOrder(Error(header + "A2;1.250;0;0;0\n"), {"file.csv:4", "'1.250' may be 1.25 or 1250"}));
  EXPECT_TRUE(SaysInOrder(Error(header + "A2;1,250;0;0;0\n"), {"file.csv:4", "'1,250' may be 1.25 or 1250"}));
  EXPECT_NEAR(Read(header + "A2;1.25;0;0;0\n").robot.dh->links[1].a, 1.25e-3, 1e-15);
  // Another number says that the point is the decimal sign: as thousands it would be no link.
  EXPECT_NEAR(Read(header + "A2;1.250;0;163.941;0\n").robot.dh->links[1].a, 1.25e-3, 1e-15);
  EXPECT_NEAR(Read("# x\nj;a [m];alpha [°];d [m];theta [°]\nA1;0.35;-90;1.250;0\n").robot.dh->links[0].d, 1.25, 1e-15);
}

TEST_F(DhCells, MetresAndRadiansOfTheHeaderAre) {
  EXPECT_TRUE(SaysInOrder(Error("j,a_m,alpha_rad,d_m,theta_rad\n1,0,1.57,400,0\n2,500,0,0,0\n"),
                          {"file.csv:3", "d_m", "'400' is 400 m", "m here"}));
  EXPECT_TRUE(SaysInOrder(Error("j,a_m,alpha_rad,d_m,theta_rad\n1,0,90,0.4,0\n2,0.5,0,0,0\n"),
                          {"file.csv:3", "alpha_rad", "'90' is 90 rad", "rad here"}));
}

}  // namespace
}  // namespace sagitta::dh_cells_test

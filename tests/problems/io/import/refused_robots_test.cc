// Descriptions of robots of which a part cannot be read: they are refused, not read without it.
#include <gtest/gtest.h>

#include "models/dh_from_chain.h"
#include "problems/io/import/robot_reading.h"
#include "problems/io/import/universal_robots.h"
#include "tests/problems/file_test_support.h"

namespace sagitta::refused_robots_test {
namespace {

class RefusedRobots : public FileTest {
 protected:
  RobotReading Read(const std::string& text, const RobotReadOptions& options = {}) const {
    return ReadAnyRobot(Write("file.txt", text), options);
  }
};

// A list that is cut off or missing is no list of zeros.
TEST_F(RefusedRobots, ListsOfAUrConfAreThereOrRefused) {
  const std::string nominal =
      "[DH]\na = [0, -0.425, -0.39225, 0, 0, 0]\nd = [0.089159, 0, 0, 0.10915, 0.09465, 0.0823]\n";
  const std::string alpha = "alpha = [1.570796326794897, 0, 0, 1.570796326794897, -1.570796326794897, 0]\n";
  RobotReadOptions options;
  options.nominal_file = Write("urcontrol.conf", nominal + alpha);
  const std::string most = "delta_theta = [0, 0, 0, 0, 0, 0]\ndelta_d = [0, 0, 0, 0, 0, 0]\n";
  const std::string whole = most + "delta_alpha = [0, 0, 0, 0, 0, 0]\ndelta_a = [ # m\n 1e-3, 2e-3,\n 0, 0, 0, 0\n]\n";
  const Robot robot = Read(whole, options).robot;
  EXPECT_NEAR(robot.dh->links[0].a, 1e-3, 1e-15);
  EXPECT_NEAR(robot.dh->links[1].a, -0.423, 1e-15);
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { Read(most + "delta_a = [0, 0, 0, 0, 0, 0]\n", options); }),
                          {"delta_alpha", "missing"}));
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { Read(most + "delta_a = [0, 0, 0,\n", options); }), {"delta_a", "not closed"}));
  // ROS reads the hash; 1e-04 is a text to it.
  const std::string yaml = RobotToUrCalibration(robot, "calib_123");
  EXPECT_NE(yaml.find("\n  hash: calib_123\n"), std::string::npos) << yaml;
  EXPECT_EQ(HashOfUrCalibration(yaml, "c.yaml"), "calib_123");
  EXPECT_EQ(HashOfUrCalibration(RobotToUrCalibration(robot), "c.yaml"), "");
  DhTable table = *robot.dh;
  table.links[0].a = 1e-7;
  const std::string small = RobotToUrCalibration(RobotOfTable(robot.chain.joints, {}, table));
  EXPECT_NE(small.find("1.0e-07"), std::string::npos) << small;
  EXPECT_EQ(small.find("1e-07"), std::string::npos) << small;
  std::string tagged = yaml;
  tagged.replace(tagged.find("roll: "), 6, "roll: !degrees ");
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { Read(tagged); }), {"tag", "!degrees", "not known"}));
}

TEST_F(RefusedRobots, AnOriginByQuaternionIsRefused) {
  EXPECT_TRUE(SaysInOrder(
      ErrorOf([&] {
        Read(
            "<robot name='r'><link name='a'/><link name='b'/><joint name='j' type='revolute'><parent link='a'/>"
            "<child link='b'/><axis xyz='0 0 1'/><limit lower='-1' upper='1' effort='1' velocity='1'/>"
            "<origin xyz='0 0 1' quat_xyzw='0 0 0.6 0.8'/></joint></robot>");
      }),
      {"quat_xyzw", "not read"}));
}

}  // namespace
}  // namespace sagitta::refused_robots_test

// Bodies of the arm from a URDF: capsules against points on the shapes' surfaces, moved by kinematics of this file's
// own.
#include "problems/io/urdf_bodies.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "models/forward_model.h"
#include "models/kinematics.h"
#include "problems/input_error.h"
#include "problems/io/cell_file.h"
#include "problems/io/robot_file.h"
#include "problems/io/urdf_robot.h"
#include "tests/problems/file_test_support.h"

namespace sagitta::urdf_bodies_test {
namespace {

using Isometry = Eigen::Isometry3d;

Isometry Origin(double x, double y, double z, double roll, double pitch, double yaw) {
  using Eigen::AngleAxisd;
  return Eigen::Translation3d(x, y, z) * AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
         AngleAxisd(pitch, Eigen::Vector3d::UnitY()) * AngleAxisd(roll, Eigen::Vector3d::UnitX());
}

// Joint `first` turns about an oblique axis, `second` about -y; the hand is fixed to the forearm, a finger slides on
// it.
const char* const kArm = R"(<?xml version="1.0"?>
<robot name="arm">
  <link name="foot"><collision><origin xyz="0 0 0.1"/><geometry><cylinder radius="0.15" length="0.2"/></geometry></collision></link>
  <joint name="first" type="revolute"><parent link="foot"/><child link="upper"/>
    <origin xyz="0.1 0 0.4" rpy="0.2 -0.3 0.5"/><axis xyz="0.6 0 0.8"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
  <link name="upper">
    <collision><origin xyz="0.3 0.02 0.1" rpy="0.1 0.7 0"/><geometry><box size="0.2 0.7 0.1"/></geometry></collision>
    <collision><origin xyz="0 0 0.05"/><geometry><sphere radius="0.12"/></geometry></collision></link>
  <joint name="second" type="revolute"><parent link="upper"/><child link="forearm"/>
    <origin xyz="0.6 0 0" rpy="0 0 0.4"/><axis xyz="0 -1 0"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
  <link name="forearm"><collision><geometry><mesh filename="package://arm/forearm.stl"/></geometry></collision></link>
  <joint name="wrist" type="fixed"><parent link="forearm"/><child link="hand"/><origin xyz="0 0 0.5" rpy="0 0.5 0"/></joint>
  <link name="hand"><collision><origin xyz="0.01 0 0.05" rpy="1 0 0"/><geometry><cylinder radius="0.05" length="0.3"/></geometry></collision></link>
  <joint name="slide" type="prismatic"><parent link="hand"/><child link="finger"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="0.1" effort="1" velocity="1"/></joint>
  <link name="finger"/>
  <joint name="bracket" type="fixed"><parent link="upper"/><child link="valve"/><origin xyz="0.2 0.1 0"/></joint>
  <link name="valve"><collision><geometry><sphere radius="0.04"/></geometry></collision></link>
</robot>
)";

UrdfChain Arm(const std::string& base = "foot", const std::string& tip = "hand") {
  return ReadUrdfChain(kArm, "arm.urdf", {base, tip});
}

// base_from_link of the URDF, written from its definition.
std::map<std::string, Isometry> Links(double first, double second) {
  std::map<std::string, Isometry> links;
  links["foot"] = Isometry::Identity();
  links["upper"] = Origin(0.1, 0, 0.4, 0.2, -0.3, 0.5) * Eigen::AngleAxisd(first, Eigen::Vector3d(0.6, 0, 0.8));
  links["forearm"] =
      links["upper"] * Origin(0.6, 0, 0, 0, 0, 0.4) * Eigen::AngleAxisd(second, -Eigen::Vector3d::UnitY());
  links["hand"] = links["forearm"] * Origin(0, 0, 0.5, 0, 0.5, 0);
  return links;
}

double DistanceToLine(const Eigen::Vector3d& point, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const double length = (to - from).squaredNorm();
  const double t = length > 0 ? std::clamp((point - from).dot(to - from) / length, 0.0, 1.0) : 0.0;
  return (point - from - t * (to - from)).norm();
}

// The capsule's ends in the base frame, by the chain it rides on.
std::pair<Eigen::Vector3d, Eigen::Vector3d> EndsAt(const LinkCapsule& capsule, const Chain& chain,
                                                   const Eigen::VectorXd& q) {
  const ForwardModel model(chain);
  const std::vector<double> theta(model.num_parameters(), 0.0);
  const std::vector<double> values = model.TransformValues(ShotInput(q), theta.data());
  ChainState<double> state;
  EvaluateChain(model.chain(), values.data(), &state);
  const int frame =
      capsule.on == LinkCapsule::kBase ? model.chain().BaseFrame() : model.chain().FrameAfterJoint(capsule.on);
  return {state.frames[frame] * capsule.from, state.frames[frame] * capsule.to};
}

TEST(UrdfBodiesTest, CapsulesHoldTheShapesWhereverTheArmIs) {
  const Robot robot = ReadUrdfText(kArm, "arm.urdf", {"foot", "hand"});
  const UrdfBodies bodies = BodiesFromUrdf(Arm(), robot.chain, "arm.urdf");
  ASSERT_EQ(bodies.capsules.size(), 5u);
  const Eigen::Vector2d q(0.7, -0.9);
  const std::map<std::string, Isometry> links = Links(q[0], q[1]);
  struct Expected {
    std::string name;
    Isometry base_from_shape;
    Eigen::Vector3d half;  // of a box around the shape's extreme points
    bool is_box;
    double radius;
  };
  const double of_box = std::sqrt(0.1 * 0.1 + 0.05 * 0.05);
  const std::vector<Expected> expected = {
      {"foot", links.at("foot") * Origin(0, 0, 0.1, 0, 0, 0), {0.15, 0.15, 0.1}, false, 0.15},
      {"upper", links.at("upper") * Origin(0.3, 0.02, 0.1, 0.1, 0.7, 0), {0.1, 0.35, 0.05}, true, of_box},
      {"upper 2", links.at("upper") * Origin(0, 0, 0.05, 0, 0, 0), {0.12, 0.12, 0.12}, false, 0.12},
      {"upper 3", links.at("upper") * Origin(0.2, 0.1, 0, 0, 0, 0), {0.04, 0.04, 0.04}, false, 0.04},
      {"hand", links.at("hand") * Origin(0.01, 0, 0.05, 1, 0, 0), {0.05, 0.05, 0.15}, false, 0.05}};
  for (size_t i = 0; i < expected.size(); ++i) {
    const LinkCapsule& capsule = bodies.capsules[i];
    EXPECT_EQ(capsule.name, expected[i].name);
    EXPECT_NEAR(capsule.radius, expected[i].radius, 1e-12);
    const auto [from, to] = EndsAt(capsule, robot.chain, q);
    double farthest = 0.0;
    for (int corner = 0; corner < 8; ++corner) {  // of a box; of the others the middles of its faces
      Eigen::Vector3d point = expected[i].half;
      for (int axis = 0; axis < 3; ++axis) point[axis] *= (corner >> axis) & 1 ? 1.0 : -1.0;
      if (!expected[i].is_box) {
        const int axis = corner % 3;
        const double side = point[axis];
        point.setZero();
        point[axis] = side;
      }
      farthest = std::max(farthest, DistanceToLine(expected[i].base_from_shape * point, from, to));
    }
    EXPECT_LE(farthest, capsule.radius + 1e-9) << capsule.name;
    EXPECT_GE(farthest, capsule.radius - 1e-9) << capsule.name;  // and no larger than it must be
  }
  EXPECT_EQ(bodies.meshes, std::vector<std::string>{"forearm"});
  EXPECT_EQ(bodies.moving, std::vector<std::string>{"finger"});
}

TEST(UrdfBodiesTest, AChainUpTheTreeCarriesTheSameBodies) {
  const Robot robot = ReadUrdfText(kArm, "arm.urdf", {"hand", "foot"});
  const UrdfBodies bodies = BodiesFromUrdf(Arm("hand", "foot"), robot.chain, "arm.urdf");
  const Eigen::Vector2d q(-0.8, 0.5);  // second is the first of this chain
  const std::map<std::string, Isometry> links = Links(q[1], q[0]);
  const Isometry hand_from_foot = links.at("hand").inverse();
  for (const LinkCapsule& capsule : bodies.capsules) {
    if (capsule.name != "foot") continue;
    const auto [from, to] = EndsAt(capsule, robot.chain, q);
    EXPECT_LT((from - hand_from_foot * Eigen::Vector3d(0, 0, 0.0)).norm(), 1e-12);
    EXPECT_LT((to - hand_from_foot * Eigen::Vector3d(0, 0, 0.2)).norm(), 1e-12);
    return;
  }
  FAIL() << "no capsule of the foot";
}

class UrdfCellTest : public FileTest {};

// A joint may be called as a place is; a capsule there has two meanings.
TEST_F(UrdfCellTest, APlaceHasOneMeaning) {
  Robot robot = ReadUrdfText(kArm, "arm.urdf", {"foot", "hand"});
  const std::string path =
      Write("cell.yaml",
            "schema: sagitta/cell/1\n"
            "capsules: [{name: forearm, on: flange, from_mm: [0, 0, 0], to_mm: [0, 0, 500], radius_mm: 80}]\n");
  EXPECT_EQ(ErrorOf([&] { ReadCellFile(path, robot.chain); }), "");
  robot.chain.joints[0].name = "flange";
  EXPECT_TRUE(
      SaysInOrder(ErrorOf([&] { ReadCellFile(path, robot.chain); }), {"capsules[0].on", "joint of this robot"}));
}

TEST_F(UrdfCellTest, ACellNamesTheUrdfAndSaysWhatItLacks) {
  Write("arm.urdf", kArm);
  const Robot robot = ReadUrdfText(kArm, "arm.urdf", {"foot", "hand"});
  const std::string path =
      Write("cell.yaml",
            "schema: sagitta/cell/1\nurdf: {file: arm.urdf, base_link: foot, tip_link: hand}\n"
            "capsules: [{name: forearm, on: second, from_mm: [0, 0, 0], to_mm: [0, 0, 500], radius_mm: 80}]\n"
            "may_touch: [[upper, hand]]\n");
  const Cell cell = ReadCellFile(path, robot.chain);
  EXPECT_EQ(cell.capsules.size(), 6u);
  ASSERT_EQ(cell.without_body.size(), 2u);
  EXPECT_NE(cell.without_body[0].find("forearm"), std::string::npos);
  EXPECT_NE(cell.without_body[0].find("meshes"), std::string::npos);
  EXPECT_NE(cell.without_body[1].find("finger"), std::string::npos);
}

TEST_F(UrdfCellTest, AUrdfOfAnotherArmIsRefused) {
  Robot robot = ReadUrdfText(kArm, "arm.urdf", {"foot", "hand"});
  Chain shifted = robot.chain;  // as far as a calibration goes it may be off
  shifted.transforms[0].nominal += 0.005;
  EXPECT_NO_THROW(BodiesFromUrdf(Arm(), shifted, "arm.urdf"));
  Chain turned = robot.chain;
  turned.transforms[turned.JointTransform(1)].sign *= -1.0;
  EXPECT_THROW(BodiesFromUrdf(Arm(), turned, "arm.urdf"), InputError);
  Chain renamed = robot.chain;
  renamed.joints[1].name = "elbow";
  EXPECT_THROW(BodiesFromUrdf(Arm(), renamed, "arm.urdf"), InputError);
}

}  // namespace
}  // namespace sagitta::urdf_bodies_test

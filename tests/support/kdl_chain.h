// Orocos KDL as the second forward kinematics: chains are built from plain numbers, never from our readers.
#pragma once

#ifdef SAGITTA_HAVE_KDL

#include <gtest/gtest.h>

#include <cmath>
#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <string>
#include <vector>

#include "models/forward_model.h"
#include "tests/support/arms.h"

namespace sagitta::test {

// A joint as a URDF states it.
struct UrdfRow {
  std::string name;
  std::string type;  // revolute, continuous, prismatic, fixed
  double x, y, z, roll, pitch, yaw;
  double ax = 0, ay = 0, az = 1;
};

// As ROS' kdl_parser does it: the joint stands at its origin, its axis turned into the parent's frame.
inline KDL::Chain KdlChainOfUrdf(const std::vector<UrdfRow>& rows) {
  KDL::Chain chain;
  for (const UrdfRow& row : rows) {
    const KDL::Frame origin(KDL::Rotation::RPY(row.roll, row.pitch, row.yaw), KDL::Vector(row.x, row.y, row.z));
    KDL::Joint joint(row.name, KDL::Joint::None);
    const KDL::Vector axis = origin.M * KDL::Vector(row.ax, row.ay, row.az);
    if (row.type == "revolute" || row.type == "continuous") {
      joint = KDL::Joint(row.name, origin.p, axis, KDL::Joint::RotAxis);
    } else if (row.type == "prismatic") {
      joint = KDL::Joint(row.name, origin.p, axis, KDL::Joint::TransAxis);
    }
    chain.addSegment(KDL::Segment(row.name, joint, origin));
  }
  return chain;
}

// KDL puts the joint before a segment's fixed frame: standard DH as it stands;
// in the modified convention the fixed part of a link comes before its joint.
inline KDL::Chain KdlChainOfDh(DhConvention convention, const std::vector<DhRow>& rows) {
  KDL::Chain chain;
  const bool standard = convention == DhConvention::kStandard;
  for (const DhRow& row : rows) {
    const KDL::Joint joint(row.type == JointType::kRevolute ? KDL::Joint::RotZ : KDL::Joint::TransZ);
    const KDL::Frame link =
        standard ? KDL::Frame::DH(row.a, row.alpha_deg * kDegree, row.d, row.theta_deg * kDegree)
                 : KDL::Frame::DH_Craig1989(row.a, row.alpha_deg * kDegree, row.d, row.theta_deg * kDegree);
    if (standard) {
      chain.addSegment(KDL::Segment(joint, link));
    } else {
      chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), link));
      chain.addSegment(KDL::Segment(joint));
    }
  }
  return chain;
}

inline KDL::Frame KdlFlange(const KDL::Chain& chain, const Eigen::VectorXd& q) {
  KDL::ChainFkSolverPos_recursive solver(chain);
  KDL::JntArray joints(chain.getNrOfJoints());
  joints.data = q;
  KDL::Frame flange;
  EXPECT_EQ(solver.JntToCart(joints, flange), 0);
  return flange;
}

inline Pose<double> FlangeOf(const Chain& chain, const Eigen::VectorXd& q) {
  const ForwardModel model(chain);
  const std::vector<double> no_errors(model.num_parameters(), 0.0);
  ChainState<double> state;
  EvaluateChain(chain, model.TransformValues(q, no_errors.data()).data(), &state);
  return state.frames[chain.FlangeFrame()];
}

// Our chain against KDL's at random joint values; tolerance in m and for the entries of the rotation.
inline void ExpectSameFlange(const Chain& chain, const KDL::Chain& kdl, double tolerance, int trials = 100) {
  ASSERT_EQ(static_cast<int>(kdl.getNrOfJoints()), chain.num_joints());
  RandomNumbers random(4711);
  for (int trial = 0; trial < trials; ++trial) {
    const Eigen::VectorXd q = RandomJointValues(chain, &random);
    const KDL::Frame expected = KdlFlange(kdl, q);
    const Pose<double> flange = FlangeOf(chain, q);
    for (int r = 0; r < 3; ++r) {
      ASSERT_NEAR(flange.translation[r], expected.p[r], tolerance) << "trial " << trial;
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(flange.rotation(r, c), expected.M(r, c), tolerance) << "trial " << trial;
    }
  }
}

}  // namespace sagitta::test

#endif

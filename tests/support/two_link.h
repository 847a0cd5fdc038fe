// An arm that one can compute by hand: a column, a turn, a boom that tilts.
//
//   Tz 0.5   Rz J1   Tx 1.0 (error a1)   Ry J2 (sign -1)   Tx 0.4
//
// At q = 0 the flange is at (1.4, 0, 0.5), J2's axis passes through (1, 0, 0.5) along y, and a positive J2 lifts the
// boom: the flange is at (1 + 0.4 cos q2, 0, 0.5 + 0.4 sin q2).
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "models/forward_model.h"
#include "tests/support/arms.h"

namespace sagitta::test {

inline Robot TwoLink() {
  Robot robot;
  robot.name = "two links";
  robot.chain.joints = Revolutes(2, "J");
  robot.chain.joints[0].min = -1.0;
  robot.chain.joints[0].max = 3.0;
  robot.chain.transforms = {Translate(Axis::kZ, 0.5), OnJoint(Motion::kRotation, Axis::kZ, 0),
                            Translate(Axis::kX, 1.0, "a1"), OnJoint(Motion::kRotation, Axis::kY, 1, "", -1.0),
                            Translate(Axis::kX, 0.4)};
  return robot;
}

// A shot of it and what it may state.
struct TwoLinkScene {
  Robot robot = TwoLink();
  std::vector<ShotInput> campaign = {ShotInput(Eigen::VectorXd::Zero(2))};
  Pose<double> base_in_station;
  Vector3<double> marker = Vector3<double>::Zero();  // M1, on the flange

  ShotConditions& shot() { return campaign.back().conditions; }
  void Add(const EffectSpec& effect) { robot.effects.push_back(effect); }
  void GiveWay(int joint, double k) { robot.compliances.push_back({joint, {{0.0, k}}, false}); }
  // A force at a point of the flange frame, as the load "V".
  void Load(const Vector3<double>& force, const Vector3<double>& at = Vector3<double>::Zero(),
            WrenchFrame frame = WrenchFrame::kMeasurement) {
    shot().load = "V";
    shot().load_wrenches = {{0, at, force, Vector3<double>::Zero(), frame}};
  }
  void Moment(const Vector3<double>& moment) { shot().load_wrenches.at(0).moment = moment; }

  // M1 in the last shot of the campaign.
  Vector3<double> Seen() const {
    const ForwardModel model(robot, {"M1"});
    std::vector<ShotInput> shots = campaign;
    for (ShotInput& input : shots) {
      for (AppliedWrench& wrench : input.conditions.load_wrenches) {
        wrench.frame = model.chain().FlangeFrame();
        input.wrenches.push_back(wrench);
      }
    }
    model.Prepare(&shots);
    const std::vector<double> theta = model.NominalValues();
    std::vector<PointPrediction> seen;
    EXPECT_TRUE(model.Predict(shots.back(), theta.data(), {}, base_in_station,
                              {{model.chain().FlangeFrame(), marker, 0}}, &seen));
    return seen[0].point;
  }
};

inline void ExpectPoint(const Vector3<double>& point, double x, double y, double z, double within = 1e-9) {
  EXPECT_NEAR(point.x(), x, within);
  EXPECT_NEAR(point.y(), y, within);
  EXPECT_NEAR(point.z(), z, within);
}

}  // namespace sagitta::test

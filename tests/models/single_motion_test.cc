// Effects that move one thing: the arm with the effect against the arm whose joint, or marker, stands elsewhere.
#include "models/single_motion.h"

#include <gtest/gtest.h>

#include <set>

#include "models/effects/catalogue.h"
#include "tests/support/effect_contract.h"

namespace sagitta::single_motion_test {
namespace {

constexpr double kSize = 1e-4;  // rad or m per unit

// Joint 3 counts against its axis.
Robot Arm() {
  Robot robot = test::ContractArm();
  robot.compliances.clear();
  robot.chain.transforms[robot.chain.JointTransform(2)].sign = -1;
  return robot;
}

std::vector<ShotInput> Campaign(const Robot& robot) {
  test::RandomNumbers random(5);
  std::vector<ShotInput> shots;
  for (int k = 0; k < 8; ++k) {
    shots.push_back(test::ContractShot(robot.chain.FlangeFrame(), &random));
    shots.back().wrenches.clear();
    shots.back().conditions.time = 7200.0 - 100.0 * k;  // not as they are listed
    shots.back().conditions.approach = {1, -1, k % 2 == 0 ? 1 : -1, -1, 1, -1};
  }
  return shots;
}

Vector3<double> PointOf(const ForwardModel& model, const ShotInput& shot, const std::vector<double>& theta,
                        const Vector3<double>& marker) {
  const MarkerInFrame in_frame{model.chain().FlangeFrame(), marker, 1};
  return model.PointInStation<double>(shot, theta.data(), in_frame, marker, Matrix3<double>::Identity(),
                                      Vector3<double>::Zero());
}

void ExpectTheSame(const EffectSpec& use, const std::vector<SingleMotion>& motions) {
  Robot robot = Arm();
  const std::vector<ShotInput> plain_shots = Campaign(robot);
  const ForwardModel plain(robot, test::ContractMarkers());
  robot.effects = {use};
  const ForwardModel model(robot, test::ContractMarkers());
  std::vector<ShotInput> shots = plain_shots;
  model.Prepare(&shots);
  const std::vector<double> none(plain.num_parameters(), 0.0);
  const Vector3<double> marker(0.1, -0.2, 0.3);
  for (size_t k = 0; k < motions.size(); ++k) {
    std::vector<double> theta = none;
    theta.resize(model.num_parameters(), 0.0);
    theta[none.size() + k] = kSize;
    for (size_t s = 0; s < shots.size(); ++s) {
      ShotInput elsewhere(plain_shots[s].conditions.q);
      Vector3<double> moved = marker;
      const double by = kSize * motions[k].per_unit[static_cast<long>(s)];
      (motions[k].of == SingleMotion::Of::kJoint ? elsewhere.conditions.q[motions[k].owner] : moved[motions[k].axis]) +=
          by;
      plain.Prepare(&elsewhere);
      const Vector3<double> difference =
          PointOf(model, shots[s], theta, marker) - PointOf(plain, elsewhere, none, moved);
      EXPECT_LT(difference.norm(), 1e-12) << use.Path() << " parameter " << k << " shot " << s;
    }
  }
}

TEST(SingleMotions, DoWhatTheirEffectsDo) {
  const Robot robot = Arm();
  const std::vector<ShotInput> shots = Campaign(robot);
  std::set<std::string> of_one, of_more;
  for (const EffectSpec& use : test::ContractUses(EffectCatalogue())) {
    const auto motions = SingleMotionsOf(robot, test::ContractMarkers(), use, shots);
    (motions ? of_one : of_more).insert(use.effect);
    if (motions) ExpectTheSame(use, *motions);
  }
  for (const char* name : {"joint_harmonic", "encoder_gain", "joint_coupling", "backlash", "joint_slip", "hysteresis",
                           "marker_shift", "learnt_wave_deviation"}) {
    EXPECT_EQ(of_one.count(name), 1u) << name;
  }
  for (const char* name : {"axis_wobble", "backlash", "frozen_geometry", "joint_compliance", "link_gravity",
                           "station_scale", "thermal_growth"}) {
    EXPECT_EQ(of_more.count(name), 1u) << name;  // of play that what is pressed by torque
  }
}

// The same shots again at the same times, as another campaign: each remembers its own.
TEST(Memories, OtherCampaignsAreNotRemembered) {
  const Robot robot = Arm();
  const std::vector<ShotInput> alone = Campaign(robot);
  std::vector<ShotInput> twice = alone;
  for (ShotInput shot : alone) {
    shot.conditions.campaign = 1;
    twice.push_back(shot);
  }
  int remembering = 0;
  for (const EffectSpec& use : test::ContractUses(EffectCatalogue())) {
    const EffectDefinition& definition = *FindEffect(robot, use.effect);
    const std::vector<double> own = MemoriesOf(robot, definition, use, alone);
    std::vector<double> both = own;
    both.insert(both.end(), own.begin(), own.end());
    EXPECT_EQ(MemoriesOf(robot, definition, use, twice), both) << use.Path();
    remembering += own != std::vector<double>(own.size(), 0.0) ? 1 : 0;
  }
  EXPECT_GE(remembering, 3);
}

}  // namespace
}  // namespace sagitta::single_motion_test

// The batched pass against the model itself (which the derivative tests hold against automatic differentiation): every
// effect, loads in the base frame, springs, prismatic joints, markers on links and foot, deviations of joints.
#include "models/batch/batch_rows.h"

#include <gtest/gtest.h>

#include <numeric>

#include "tests/support/arms.h"
#include "tests/support/effect_contract.h"
#include "tests/support/instruction_sets.h"

namespace sagitta::batch_rows_test {
namespace {

constexpr int kShots = 5;  // of 8 lanes

struct BatchCase {
  Robot robot;
  std::vector<int> frames;  // of M1, M2
  bool base_wrench = false;
  bool is_loaded = true;
};

ShotInput RandomShot(const ForwardModel& model, const BatchCase& setup, test::RandomNumbers* random) {
  ShotInput shot = test::ContractShot(model.chain().FlangeFrame(), random);
  const int joints = model.chain().num_joints();
  shot.conditions.q.resize(joints);
  shot.conditions.approach.assign(joints, 1);
  for (int j = 0; j < joints; ++j) shot.conditions.q[j] = random->Uniform(-1.2, 1.2);
  if (!setup.is_loaded) {
    shot.conditions.load = kNoLoad;
    shot.conditions.load_wrenches.clear();
    shot.wrenches.clear();
  }
  if (setup.base_wrench) {
    AppliedWrench wrench = shot.wrenches[0];
    wrench.frame = model.chain().FrameAfterJoint(2);
    wrench.expressed_in = WrenchFrame::kBase;
    shot.wrenches.push_back(wrench);
  }
  model.Prepare(&shot);
  return shot;
}

// Torques of each lane's wrenches, relative to the largest; an arm that nothing bends is left to the model.
void ExpectTorquesOfTheModel(const ForwardModel& model, const std::vector<ShotInput>& shots,
                             const std::vector<double>& theta, const BatchPoint& at, const ShotProgram& program,
                             const double* data) {
  const Chain& chain = model.chain();
  std::vector<int> transforms;
  for (int j = 0; j < chain.num_joints(); ++j) transforms.push_back(chain.JointTransform(j));
  std::vector<double> torques(transforms.size() * kBatchLanes);
  BatchScratch scratch;
  const unsigned left = WrenchTorques(program, at, data, &scratch, torques.data());
  EXPECT_EQ(left, program.is_elastic() ? 0u : (1u << kBatchLanes) - 1);
  for (size_t lane = 0; left == 0 && lane < shots.size(); ++lane) {
    const ShotInput& shot = shots[lane];
    const Equilibrium there = model.Equilibrate(shot, theta.data(), at.base_in_station.rotation);
    const ElasticQuery query{&chain, &transforms, nullptr, &shot.conditions.q, &shot.wrenches, &shot.terms};
    const Eigen::VectorXd expected = TorquesOf(query, there.state, shot.wrenches, at.base_in_station.rotation);
    for (size_t j = 0; j < transforms.size(); ++j) {
      EXPECT_NEAR(torques[j * kBatchLanes + lane], expected[static_cast<long>(j)],
                  1e-12 * expected.cwiseAbs().maxCoeff());
    }
  }
}

// Amplitudes of effects: this share of the hold limit of their parameters, at most.
constexpr double kEffectSize = 0.1;

// 1/m: how far a reading's derivative moves with the point, of a wave over the range. Others are smooth over metres.
double BendOfReadings(const Robot& robot) {
  double bend = 0.0;
  for (const EffectSpec& effect : robot.effects) {
    const double period = 1e-3 * effect.NumberSetting("period_mm", 1e6);
    const double amplitude = std::sqrt(2.0) * kEffectSize * TraitsOf(Quantity::kShift).hold_limit;
    bend = std::max(bend, amplitude * std::pow(2.0 * M_PI / period, 2));
  }
  return bend;
}

// A batch with every derivative asked for, against ForwardModel::Predict lane by lane. Sizes: of the arm, 1 m.
// softness: factor of all compliances and effects.
void ExpectBatchIsTheModel(const BatchCase& setup, int seed, double softness, double tolerance) {
  const ForwardModel model(setup.robot, test::ContractMarkers());
  test::RandomNumbers random(seed);
  std::vector<double> theta = model.NominalValues();
  for (int i = 0; i < model.num_parameters(); ++i) {
    const ModelParameter& parameter = model.parameters()[i];
    if (parameter.law == ParameterLaw::kGeometry) theta[i] = random.Uniform(-1e-3, 1e-3);
    if (parameter.law == ParameterLaw::kCompliance) theta[i] *= softness;
    if (parameter.law == ParameterLaw::kEffect) {
      theta[i] = softness * random.Uniform(0.5, 1.0) * kEffectSize * TraitsOf(parameter.quantity).hold_limit;
    }
  }
  Pose<double> base;
  base.rotation = RotationFromVector<double>(random.Vector(1.0));
  base.translation = random.Vector(2.0);
  std::vector<BatchReading> readings;
  std::vector<MarkerInFrame> markers;
  std::vector<Vector3<double>> points;
  for (int m = 0; m < 2; ++m) {
    const int frame = setup.frames.empty() ? model.chain().FlangeFrame() : setup.frames[m];
    Matrix3<double> whitener;
    for (int i = 0; i < 9; ++i) whitener(i / 3, i % 3) = random.Uniform(-1.0, 1.0);
    if (m == seed % 2) whitener = whitener(0, 0) * Matrix3<double>::Identity();  // one sees equally in all directions
    readings.push_back({m, frame, random.Vector(2.0), whitener});
    points.push_back(random.Vector(0.3));
    markers.push_back({frame, points.back(), m});
  }
  std::vector<ShotInput> shots;
  for (int i = 0; i < kShots; ++i) shots.push_back(RandomShot(model, setup, &random));
  const ShotProgram program = MakeShotProgram(model, shots[0], readings);
  for (const ShotInput& shot : shots) {
    ASSERT_EQ(StructureOf(model, shot, readings), StructureOf(model, shots[0], readings));
  }

  const int joints = model.chain().num_joints(), n = model.num_parameters();
  BatchLayout layout;
  layout.markers = {0, 3};
  layout.station = 6;
  for (int i = 0; i < n; ++i) layout.theta.push_back(12 + i);
  layout.latent = 12 + n;
  layout.residual = 12 + n + joints;
  layout.columns = layout.residual + 1;
  for (int j = 0; j < joints; ++j) layout.latent_joints.push_back(j), layout.latent_sigmas.push_back(0.5 + j);
  BatchScratch numbers, scratch, results;
  double* const data = numbers.Reserve(static_cast<std::size_t>(program.num_data) * kBatchLanes);
  double* const rows = results.Reserve(static_cast<std::size_t>(6) * layout.columns * kBatchLanes);
  std::fill(rows, rows + 6 * layout.columns * kBatchLanes, 0.0);
  for (int lane = 0; lane < kBatchLanes; ++lane) {
    PackShot(model, program, shots[std::min(lane, kShots - 1)], readings, lane, data);
  }
  for (int m = 0; m < 2; ++m) {
    EXPECT_EQ(program.markers[m].sees_equally, m == seed % 2);
    EXPECT_EQ(PackedWhitener(program.markers[m], kShots - 1, data), readings[m].whitener);
  }
  const BatchPoint at(program, theta.data(), base, points);
  // m; three coordinates of the point, three of the whitener's rows, none above 1.
  constexpr double kPoint = 1e-13;
  const double turned = kPoint * std::max(1.0, softness * 3.0 * BendOfReadings(setup.robot));
  const auto check = [&] {
    ASSERT_EQ(EvaluateBatch(program, at, BatchPlan(program, layout), data, &scratch, rows), 0u);

    std::vector<int> all(n);
    std::iota(all.begin(), all.end(), 0);
    const std::vector<double> exact(joints, 0.0);
    for (int lane = 0; lane < kShots; ++lane) {
      std::vector<PointPrediction> expected;
      ASSERT_TRUE(model.Predict(shots[lane], theta.data(), all, base, markers, &expected, exact.data()));
      for (int m = 0; m < 2; ++m) {
        const auto cell = [&](int i, int column) {
          return rows[((3 * m + i) * layout.columns + column) * kBatchLanes + lane];
        };
        const auto expect = [&](int column, const Vector3<double>& derivative, double bound) {
          const Vector3<double> whitened = readings[m].whitener * derivative;
          for (int i = 0; i < 3; ++i) EXPECT_NEAR(cell(i, column), whitened[i], bound) << column << " " << lane;
        };
        expect(layout.residual, expected[m].point - readings[m].point_in_station, kPoint);
        for (int i = 0; i < 3; ++i) {
          expect(layout.station + i, expected[m].d_translation.col(i), turned);
          expect(layout.station + 3 + i, expected[m].d_rotation.col(i), tolerance);
          expect(layout.markers[m] + i, expected[m].d_marker.col(i), tolerance);
          EXPECT_EQ(cell(0, layout.markers[1 - m] + i), 0.0);
        }
        for (int i = 0; i < n; ++i) {
          expect(layout.theta[i], expected[m].d_theta.col(i),
                 tolerance * std::max(1.0, expected[m].d_theta.col(i).norm()));
        }
        for (int j = 0; j < joints; ++j) {
          expect(layout.latent + j, layout.latent_sigmas[j] * expected[m].d_latent.col(j), tolerance);
        }
      }
    }
  };
  test::OnEveryInstructionSet(check);
  test::OnEveryInstructionSet([&] { ExpectTorquesOfTheModel(model, shots, theta, at, program, data); });
}

// Points are exact to the square of the Newton step that is left, 1e-8 at most, derivatives to that step. Of a stiff
// arm the first step leaves nothing.
void ExpectBatchIsTheModel(const BatchCase& setup, int seed) {
  ExpectBatchIsTheModel(setup, seed, 1.0, 1e-8);
  ExpectBatchIsTheModel(setup, seed, 1e-4, 3e-12);
}

bool HasProgram(const BatchCase& setup) {
  const ForwardModel model(setup.robot, test::ContractMarkers());
  test::RandomNumbers random(1);
  return !StructureOf(model, RandomShot(model, setup, &random), {}).empty();
}

TEST(BatchRows, EveryEffectIsAsInTheModel) {
  int seed = 100;
  for (const EffectSpec& use : test::ContractUses(EffectCatalogue())) {
    SCOPED_TRACE(use.Path());
    BatchCase setup{test::ContractArm(), {}, false};
    setup.robot.effects = {use};
    ++seed;
    ASSERT_TRUE(HasProgram(setup));
    ExpectBatchIsTheModel(setup, seed);
  }
}

// Play that friction holds between both sides, and a deviation that is a smooth function of the torque.
TEST(BatchRows, SmoothLawsOfTheTorque) {
  for (const EffectSpec& use :
       {EffectSpec{"backlash", "A2", {{"by", "torque"}, {"width_Nm", "30"}}, {}},
        EffectSpec{
            "learnt_deviation", "A2", {{"by", "torque_Nm"}, {"from", "-400"}, {"to", "300"}, {"knots", "4"}}, {}}}) {
    SCOPED_TRACE(use.Path());
    BatchCase setup{test::ContractArm(), {}, false};
    setup.robot.effects = {use};
    ASSERT_TRUE(HasProgram(setup));
    ExpectBatchIsTheModel(setup, 4);
  }
}

// A bump is not zero where nothing pulls: alone, with a spring on another joint, with weights that sag.
TEST(BatchRows, SmoothLawsOfNoTorque) {
  const EffectSpec bumps{
      "learnt_deviation", "A3", {{"by", "torque_Nm"}, {"from", "-40"}, {"to", "30"}, {"knots", "4"}}, {}};
  for (const bool has_spring : {false, true}) {
    for (const bool sags : {false, true}) {
      BatchCase setup{test::ContractArm(), {}, false, false};
      setup.robot.effects = {bumps};
      if (sags) setup.robot.effects.push_back({"self_weight_sag", "A2", {}, {}});
      if (has_spring) setup.robot.gravity_compensator = {1, 0.18472, 0.68593, 0.12330, 0.458, 2e5, true};
      ASSERT_TRUE(HasProgram(setup));
      ExpectBatchIsTheModel(setup, 10);
    }
  }
}

TEST(BatchRows, LoadsInTheBaseFrameAndMarkersOnLinksAndFoot) {
  BatchCase setup{test::ContractArm(), {}, true};
  const Chain& chain = setup.robot.chain;
  setup.frames = {chain.FrameAfterJoint(1), chain.FlangeFrame()};
  ExpectBatchIsTheModel(setup, 1);
  setup.frames = {chain.FrameAfterJoint(2), chain.BaseFrame()};
  ExpectBatchIsTheModel(setup, 2);
}

TEST(BatchRows, SpringOnAJoint) {
  for (const bool preload : {true, false}) {
    BatchCase setup{test::ContractArm(), {}, false};
    setup.robot.gravity_compensator = GravityCompensator{1, 0.18472, 0.68593, 0.12330, 0.458, 2e5, preload};
    ExpectBatchIsTheModel(setup, 3);
  }
}

TEST(BatchRows, JointsThatSlide) {
  BatchCase setup{test::ContractArm(), {}, true};
  for (Joint& joint : setup.robot.chain.joints) {
    if (joint.name == "A2" || joint.name == "A4") joint.type = JointType::kPrismatic;
  }
  for (ElementaryTransform& transform : setup.robot.chain.transforms) {
    if (transform.has_joint() && setup.robot.chain.joints[transform.joint].type == JointType::kPrismatic) {
      transform.motion = Motion::kTranslation;
    }
  }
  ExpectBatchIsTheModel(setup, 4);
}

// Axes that turn against the joint's count; and one marker stands on the foot, which does not grow with the arm.
TEST(BatchRows, JointsThatCountBackwardsAndWhatDoesNotGrow) {
  BatchCase setup{test::ContractArm(), {}, false};
  for (const int joint : {1, 3}) {
    setup.robot.chain.transforms[setup.robot.chain.JointTransform(joint)].sign = -1.0;
  }
  setup.robot.effects = {{"thermal_growth", "robot", {}, {1e-5}}};
  setup.frames = {setup.robot.chain.BaseFrame(), setup.robot.chain.FlangeFrame()};
  ExpectBatchIsTheModel(setup, 8);
}

// Nothing bends a rigid arm; without markers on the flange nothing beyond them moves.
TEST(BatchRows, RigidArm) {
  BatchCase setup{test::ContractArm(), {}, false};
  setup.robot.compliances.clear();
  ExpectBatchIsTheModel(setup, 5);
}

// Where an arm deflects by half a radian the model has to say whether it folds.
TEST(BatchRows, LargeDeflectionsAreLeftToTheModel) {
  Robot robot = test::ContractArm();
  robot.compliances[1].nodes[0].k = 1e-3;
  const ForwardModel model(robot, test::ContractMarkers());
  test::RandomNumbers random(6);
  ShotInput shot = test::ContractShot(model.chain().FlangeFrame(), &random);
  shot.wrenches[0].force = {0.0, 0.0, -2500.0};
  model.Prepare(&shot);
  const std::vector<BatchReading> readings = {
      {0, model.chain().FlangeFrame(), Vector3<double>::Zero(), Matrix3<double>::Identity()}};
  const ShotProgram program = MakeShotProgram(model, shot, readings);
  const std::vector<double> theta = model.NominalValues();
  BatchLayout layout;
  layout.columns = 1;
  layout.theta.assign(theta.size(), -1);
  layout.markers = {-1};
  BatchScratch numbers, scratch, results;
  double* const data = numbers.Reserve(static_cast<std::size_t>(program.num_data) * kBatchLanes);
  for (int lane = 0; lane < kBatchLanes; ++lane) PackShot(model, program, shot, readings, lane, data);
  const BatchPoint at(program, theta.data(), {}, {Vector3<double>::Zero()});
  EXPECT_EQ(EvaluateBatch(program, at, BatchPlan(program, layout), data, &scratch, results.Reserve(3 * kBatchLanes)),
            (1u << kBatchLanes) - 1);
  const Equilibrium there = model.Equilibrate(shot, theta.data(), Matrix3<double>::Identity());
  const int slot = model.chain().JointTransform(1);
  const double commanded = model.TransformValues(shot, theta.data())[slot];
  EXPECT_TRUE(!there.converged || std::abs(there.values[slot] - commanded) > 0.5);
}

// A shot among shots that bend two thousand times as far says what it says among its like: rows in another order
// share a register with others.
TEST(BatchRows, AShotTakesNoNoticeOfItsNeighbours) {
  const ForwardModel model(test::ContractArm(), test::ContractMarkers());
  test::RandomNumbers random(9);
  const BatchCase setup{test::ContractArm(), {}, false};
  ShotInput shot = RandomShot(model, setup, &random), heavy = RandomShot(model, setup, &random);
  shot.wrenches[0].force *= 0.02;
  heavy.wrenches[0].force *= 40.0;
  model.Prepare(&shot);
  model.Prepare(&heavy);
  const std::vector<BatchReading> readings = {
      {0, model.chain().FlangeFrame(), random.Vector(2.0), Matrix3<double>::Identity()}};
  const ShotProgram program = MakeShotProgram(model, shot, readings);
  const std::vector<double> theta = model.NominalValues();
  const int n = model.num_parameters();
  BatchLayout layout;
  layout.columns = n + 1;
  layout.residual = n;
  layout.markers = {-1};
  for (int i = 0; i < n; ++i) layout.theta.push_back(i);
  const BatchPoint at(program, theta.data(), {}, {random.Vector(0.3)});
  BatchScratch numbers, scratch, results;
  const auto first_lane = [&](const ShotInput& beside) {
    double* const data = numbers.Reserve(static_cast<std::size_t>(program.num_data) * kBatchLanes);
    double* const rows = results.Reserve(static_cast<std::size_t>(3) * layout.columns * kBatchLanes);
    std::fill(rows, rows + 3 * layout.columns * kBatchLanes, 0.0);
    for (int lane = 0; lane < kBatchLanes; ++lane) {
      PackShot(model, program, lane == 0 ? shot : beside, readings, lane, data);
    }
    EXPECT_EQ(EvaluateBatch(program, at, BatchPlan(program, layout), data, &scratch, rows) & 1u, 0u);
    std::vector<double> own;
    for (int i = 0; i < 3 * layout.columns; ++i) own.push_back(rows[i * kBatchLanes]);
    return own;
  };
  test::OnEveryInstructionSet([&] { EXPECT_EQ(first_lane(shot), first_lane(heavy)); });
}

// Wrenches that turn with the flange have no program.
TEST(BatchRows, WrenchesOfTheFlangeHaveNoStructure) {
  const ForwardModel model(test::ContractArm(), test::ContractMarkers());
  test::RandomNumbers random(7);
  ShotInput shot = test::ContractShot(model.chain().FlangeFrame(), &random);
  model.Prepare(&shot);
  EXPECT_FALSE(StructureOf(model, shot, {}).empty());
  shot.wrenches[0].expressed_in = WrenchFrame::kFlange;
  EXPECT_TRUE(StructureOf(model, shot, {}).empty());
}

}  // namespace
}  // namespace sagitta::batch_rows_test

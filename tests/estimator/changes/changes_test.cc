// What changed between two estimates, on pairs measured by a generator of its own (tests/support/kr270_experiment.h).
#include "estimator/changes/changes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "estimator/changes/comparison.h"
#include "estimator/changes/sparse_search.h"
#include "estimator/sagitta.h"
#include "problems/failure.h"
#include "problems/input_error.h"
#include "tests/support/loaded_kr270.h"
#include "tests/support/moved_kr270.h"

namespace sagitta::changes_test {
namespace {

using test::Kr270Truth;
using ::testing::HasSubstr;

KnownRobot Estimated(const Kr270Truth& truth, std::uint64_t seed, const std::vector<std::string>& fixed = {},
                     const std::string& robot_name = "KR 270") {
  const test::Kr270Design design = test::CampaignOf(24, 2, 3e-5, seed);  // other poses every time
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(truth, design.sigma, 1000 + seed, &data);
  Experiment experiment;
  experiment.estimate.fixed = fixed;
  Robot robot = test::Kr270Robot();
  robot.name = robot_name;
  const CalibrationProblem problem = MakeCalibrationProblem(robot, data, experiment);
  const Calibration calibration{problem, EstimateJointly(problem), {}};
  EXPECT_TRUE(IsUsable(calibration.estimate.status)) << calibration.estimate.message;
  return KnownFrom(calibration);
}

std::string NamesOf(const Changes& changes) {
  std::string names;
  for (const Change& change : changes.changes) names += WordOf(change.kind) + "/" + change.target + " ";
  return names;
}

TEST(ChangesTest, ASlippedJointIsNamed) {
  const Kr270Truth before;
  Kr270Truth after = before;
  after.errors[7] += 0.4e-3;  // dq3
  const Changes changes = FindChanges(Estimated(before, 1), Estimated(after, 2));
  ASSERT_EQ(NamesOf(changes), "joint_zero/A3 ") << changes.words;
  const Change& slip = changes.changes[0];
  EXPECT_EQ(slip.unit, "mrad");
  EXPECT_GT(slip.probability, 0.9);
  // Four standard deviations to either side hold it but once in 16 000.
  const double sigma = (slip.ci95[1] - slip.ci95[0]) / (2 * 1.959964);
  EXPECT_NEAR(slip.value, 0.4, 4 * sigma);
  EXPECT_LT(sigma, 0.1);
  EXPECT_LT(changes.after_rms, changes.before_rms);
}

// Their sandwich cannot have the inverse that a comparison needs: 24 clusters, more parameters.
TEST(ChangesTest, ACovarianceOfFewConfigurationsIsRefused) {
  const Kr270Truth truth;
  KnownRobot old_estimate = Estimated(truth, 20);
  const KnownRobot new_estimate = Estimated(truth, 21);
  old_estimate.clusters = 24;
  try {
    FindChanges(old_estimate, new_estimate);
    FAIL() << "compared";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("found from 24 configurations, too few"));
  }
  // Of very many nothing is to be allowed for.
  const double before = FindChanges(Estimated(truth, 20), new_estimate).before_rms;
  old_estimate.clusters = 1e9;
  EXPECT_DOUBLE_EQ(FindChanges(old_estimate, new_estimate).before_rms, before);
}

TEST(ChangesTest, AKnockedToolIsOneRigidMotion) {
  const Kr270Truth before;
  Kr270Truth after = before;
  const Vector3<double> turn(0, 2e-3, 1e-3);
  for (Vector3<double>& tool : after.tools) tool = RotationFromVector(turn) * tool + Vector3<double>(3e-4, 0, -5e-4);
  const Changes changes = FindChanges(Estimated(before, 3), Estimated(after, 4));
  ASSERT_EQ(NamesOf(changes), "tool/flange ") << changes.words;
  ASSERT_EQ(changes.changes[0].parts.size(), 6u);
  const double truth[6] = {0.3, 0.0, -0.5, 0.0, 2.0, 1.0};
  for (int i = 0; i < 6; ++i) {
    const Change::Part& part = changes.changes[0].parts[i];
    EXPECT_NEAR(part.value, truth[i], 2.0 * (part.ci95[1] - part.ci95[0])) << part.name;
  }
}

// Nine numbers of three markers are those of a tool and of one marker, too.
TEST(ChangesTest, MarkersThatWereMountedAnewAreNoKnockedTool) {
  const Kr270Truth before;
  Kr270Truth after = before;
  ASSERT_EQ(after.tools.size(), 3u);
  const Vector3<double> shifts[3] = {{2.1e-3, -0.4e-3, 3.3e-3}, {-1.2e-3, 2.8e-3, 0.6e-3}, {0.3e-3, 1.7e-3, -2.4e-3}};
  for (int m = 0; m < 3; ++m) after.tools[m] += shifts[m];
  const Changes changes = FindChanges(Estimated(before, 31), Estimated(after, 32));
  ASSERT_EQ(NamesOf(changes), "markers/flange ") << changes.words;
  const Change& anew = changes.changes[0];
  ASSERT_EQ(anew.parts.size(), 9u);
  EXPECT_EQ(anew.parts[3].name, "P2/x");
  for (int i = 0; i < 9; ++i) {
    EXPECT_NEAR(anew.parts[i].value, 1e3 * shifts[i / 3][i % 3], anew.parts[i].ci95[1] - anew.parts[i].ci95[0]);
  }
  EXPECT_NEAR(anew.value, 1e3 * shifts[0].norm(), anew.ci95[1] - anew.ci95[0]);
  // What is a part of it is no further cause.
  for (const Change& other : changes.alternatives) EXPECT_LT(other.probability, 1.0 - anew.probability + 1e-9);
}

// A small knock and a marker that fell out: a tool and one marker are likelier than three by chance alike.
TEST(ChangesTest, AKnockedToolWithOneMarkerReseatedIsBoth) {
  const Kr270Truth before;
  Kr270Truth after = before;
  const Vector3<double> turn(0, 1e-3, 0.5e-3);
  for (Vector3<double>& tool : after.tools) tool = RotationFromVector(turn) * tool + Vector3<double>(2e-4, 0, -3e-4);
  after.tools[1] += Vector3<double>(4e-3, -5e-3, 3e-3);
  const Changes changes = FindChanges(Estimated(before, 33), Estimated(after, 34));
  EXPECT_THAT(NamesOf(changes), ::testing::AnyOf("marker/P2 tool/flange ", "tool/flange marker/P2 ")) << changes.words;
}

TEST(ChangesTest, AMovedBaseIsFound) {
  const Kr270Truth before;
  Kr270Truth after = before;
  after.base_xyz[0] += Vector3<double>(0.8e-3, -0.5e-3, 0.3e-3);
  after.base_rotvec[0] += Vector3<double>(1e-3, -2e-3, 1e-3);
  const Changes changes = FindChanges(Estimated(before, 5), Estimated(after, 6));
  ASSERT_EQ(NamesOf(changes), "base/S1 ") << changes.words;
  EXPECT_NEAR(changes.changes[0].value, std::sqrt(0.98), 0.15);
}

// P(something) > 1/2 where nothing changed: at most 2 of 12. With a rate of 3 % more are 1 in 200.
TEST(ChangesTest, NothingIsSaidToHaveChangedWhereNothingDid) {
  const Kr270Truth truth;
  int alarms = 0;
  for (std::uint64_t pair = 0; pair < 12; ++pair) {
    const Changes changes = FindChanges(Estimated(truth, 20 + 2 * pair), Estimated(truth, 21 + 2 * pair));
    alarms += changes.nothing < 0.5;
    EXPECT_THAT(changes.notes, ::testing::Not(::testing::Contains(HasSubstr("more is left"))));
  }
  EXPECT_LE(alarms, 2);
}

// What a campaign leaves open, not what its noise does, is what another is compared with.
TEST(ChangesTest, WhatCampaignsLeaveOpenIsNoChange) {
  const Kr270Truth before;
  Kr270Truth after = before;
  after.errors[7] += 0.1e-3;  // dq3
  KnownRobot old_estimate = Estimated(before, 1), new_estimate = Estimated(after, 2);
  EXPECT_EQ(NamesOf(FindChanges(old_estimate, new_estimate)), "joint_zero/A3 ");
  for (KnownRobot* known : {&old_estimate, &new_estimate}) known->campaign_covariance *= 400.0;
  EXPECT_EQ(NamesOf(FindChanges(old_estimate, new_estimate)), "");
}

// The same robot with the same gear waves, first over all its ranges, then in a third of them, where another phase of
// the waves is in every joint's zero. Without an allowance for the regions 7 of these 12 pairs are named; at a rate of
// 3 % 3 and more are 1 in 200. What is larger than the waves is named.
TEST(ChangesTest, TheSameWavesInAnotherRegionAreNoChange) {
  const auto estimated = [](double share, double slip, std::uint64_t seed) {
    test::Kr270Design design = test::CampaignOf(25, 1, 3e-5, seed);
    Measurements data = test::DesignMeasurements(design);
    const Eigen::VectorXd middle = data.configurations[0].q;
    for (Configuration& configuration : data.configurations) {
      if (share < 1.0) configuration.q = middle + share * (configuration.q - middle);
    }
    return KnownFrom(Calibrate(test::Kr270ProblemOf(test::MeasuredAfter(data, design.sigma, 1000 + seed,
                                                                        [&](Eigen::VectorXd* q) {
                                                                          for (const int joint : {1, 2})
                                                                            (*q)[joint] +=
                                                                                4e-5 *
                                                                                std::cos(3.0 * (*q)[joint] + joint);
                                                                          (*q)[2] += slip;
                                                                        }),
                                                    Experiment())));
  };
  int alarms = 0;
  for (std::uint64_t pair = 0; pair < 12; ++pair) {
    const Changes changes = FindChanges(estimated(1.0, 0.0, 100 + 2 * pair), estimated(0.35, 0.0, 101 + 2 * pair));
    alarms += !changes.changes.empty();
    if (pair == 0) {
      EXPECT_THAT(changes.notes, ::testing::Contains(HasSubstr("of the wider range of")));
    }
  }
  EXPECT_LE(alarms, 2);
  const Changes slipped = FindChanges(estimated(1.0, 0.0, 100), estimated(0.35, 3e-3, 101));
  EXPECT_THAT(NamesOf(slipped), HasSubstr("joint_zero/A3")) << slipped.words;
}

// Joints that stop 30 urad off their readings are in no estimate's covariance, and another campaign draws them anew. At
// a rate of 3 % of 12 pairs, 3 and more are 1 in 200. A slip of 0.5 mrad is named.
TEST(ChangesTest, JointsThatScatterAreNoChange) {
  const auto estimated = [](double slip, std::uint64_t seed) {
    NormalNumbers normal(500 + seed);
    const Measurements data =
        test::MeasuredAfter(test::CampaignOf(24, 2, 3e-5, seed), 1000 + seed, [&](Eigen::VectorXd* q) {
          for (double& joint : *q) joint += 3e-5 * normal();
          (*q)[2] += slip;
        });
    return KnownFrom(Calibrate(test::Kr270ProblemOf(data, Experiment())));
  };
  int alarms = 0;
  for (std::uint64_t pair = 0; pair < 12; ++pair) {
    const KnownRobot before = estimated(0.0, 60 + 2 * pair);
    alarms += !FindChanges(before, estimated(0.0, 61 + 2 * pair)).changes.empty();
    if (pair > 0) continue;
    const Changes changes = FindChanges(before, estimated(5e-4, 61));
    EXPECT_EQ(NamesOf(changes), "joint_zero/A3 ") << changes.words;
    EXPECT_THAT(changes.notes, ::testing::Contains(HasSubstr("err by more than noise")));
  }
  EXPECT_LE(alarms, 2);
}

// Fits of twelve configurations follow what the joints scatter by, and halves of six show nothing of it: by these alone
// 4 of 10 pairs are named. At a rate of 3 % of 20 pairs, 4 and more are 1 in 400. A slip of 0.02 deg is named.
TEST(ChangesTest, JointsThatScatterAtFewPosesAreNoChange) {
  const auto estimated = [](double slip, std::uint64_t seed) {
    NormalNumbers normal(700 + seed);
    const Measurements rows = test::SeenFromBothStations(test::CampaignOf(12, 2, 3e-5, seed));
    const Measurements data = test::MeasuredAfter(rows, 3e-5, 2000 + seed, [&](Eigen::VectorXd* q) {
      for (double& joint : *q) joint += 3e-5 * normal();
      (*q)[2] += slip;
    });
    return KnownFrom(Calibrate(test::Kr270ProblemOf(data, Experiment())));
  };
  int alarms = 0;
  for (std::uint64_t pair = 0; pair < 20; ++pair) {
    alarms += !FindChanges(estimated(0.0, 100 + 2 * pair), estimated(0.0, 101 + 2 * pair)).changes.empty();
  }
  EXPECT_LE(alarms, 3);
  const Changes slipped = FindChanges(estimated(0.0, 100), estimated(0.02 * kDegree, 101));
  EXPECT_THAT(NamesOf(slipped), HasSubstr("joint_zero/A3 ")) << slipped.words;
  // Where nothing shows by how much they err.
  KnownRobot hidden = estimated(0.0, 100);
  hidden.halves = kInfinity;
  EXPECT_THROW(FindChanges(hidden, estimated(0.0, 101)), InputError);
}

// Where every instrument was set up anew a slip of the first joint is a part of how all bases turned, and of no one.
TEST(ChangesTest, ASlipThatAllBasesHideIsSaid) {
  for (const bool both : {true, false}) {
    Kr270Truth after;
    for (size_t s = 0; s < (both ? 2 : 1); ++s) {
      after.base_xyz[s] += Vector3<double>(1.5, -0.8, 0.4);
      after.base_rotvec[s] += Vector3<double>(0.02, -0.01, 0.9);
    }
    const Changes changes = FindChanges(Estimated({}, 31), Estimated(after, 32));
    ASSERT_EQ(changes.changes.size(), both ? 2u : 1u) << changes.words;
    const auto said = ::testing::Contains("a slip of A1 would be a part of what the bases moved");
    if (both) {
      EXPECT_THAT(changes.notes, said);
    } else {
      EXPECT_THAT(changes.notes, ::testing::IsEmpty());
    }
  }
}

TEST(ChangesTest, WhatOnlyOneEstimatedIsNoChange) {
  Kr270Truth truth;
  truth.errors[4] = truth.errors[10] = 0.0;  // what was assumed is true
  const Changes changes = FindChanges(Estimated(truth, 7, {"geometry/p_x2", "geometry/phi_z3"}), Estimated(truth, 8));
  EXPECT_EQ(NamesOf(changes), "") << changes.words;
  ASSERT_EQ(changes.notes.size(), 1u);
  EXPECT_THAT(changes.notes[0], HasSubstr("geometry/p_x2"));
}

KnownRobot EstimatedUnderLoads(const test::LoadedTruth& truth, std::uint64_t seed) {
  test::LoadedDesign design;
  design.seed = seed, design.configurations = 60, design.stations = 1;
  Measurements data = test::LoadedRows(design, truth);
  test::Measure(test::ExactPoints(truth, data), 2e-5, 200 + seed, &data);
  const test::LoadedSetup setup = test::SetupFor(truth);
  const CalibrationProblem problem = MakeCalibrationProblem(setup.robot, data, setup.experiment);
  return KnownFrom(Calibration{problem, EstimateJointly(problem), {}});
}

// A gear that gives way by a fifth less: what it was is said with it.
TEST(ChangesTest, AStifferGearIsComparedWithWhatItWas) {
  test::LoadedTruth truth;
  const double before = truth.k[2];
  const KnownRobot old_estimate = EstimatedUnderLoads(truth, 11);
  truth.k[2] *= 0.8;
  const Changes changes = FindChanges(old_estimate, EstimatedUnderLoads(truth, 12));
  EXPECT_THAT(changes.notes, ::testing::Not(::testing::Contains(HasSubstr("a load that is"))));
  ASSERT_EQ(NamesOf(changes), "compliance/A3 ") << changes.words;
  EXPECT_NEAR(changes.changes[0].before, 1e6 * before, 0.03 * 1e6 * before);
  EXPECT_THAT(changes.changes[0].words,
              ::testing::ContainsRegex(", from 0\\.4[0-9]* \\(-(1[7-9]|2[0-3])(\\.[0-9])? %\\)"));
}

// A weight that is a tenth heavier than its plate says bends all joints by a tenth more.
TEST(ChangesTest, AHeavierLoadIsSaidToBePossible) {
  test::LoadedTruth truth;
  const KnownRobot old_estimate = EstimatedUnderLoads(truth, 11);
  for (double& k : truth.k) k *= 1.1;
  const Changes changes = FindChanges(old_estimate, EstimatedUnderLoads(truth, 12));
  EXPECT_THAT(NamesOf(changes), HasSubstr("compliance/A2 "));
  EXPECT_THAT(changes.notes, ::testing::Contains(HasSubstr("a load that is heavier"))) << changes.words;
}

// One campaign with weights, one without: nothing changed, and what no weight excited there is left open.
TEST(ChangesTest, StiffnessesOfALoadedCampaignAreOpenInAnUnloadedOne) {
  for (const double slip : {0.0, 0.3e-3}) {
    test::LoadedTruth truth;
    const auto estimated = [&](bool loaded, std::uint64_t seed) {
      test::LoadedDesign design;
      design.seed = seed, design.configurations = 40, design.stations = 1;
      if (!loaded) design.loads.clear();
      Measurements data = test::LoadedRows(design, truth);
      test::Measure(test::ExactPoints(truth, data), design.sigma, 100 + seed, &data);
      const test::LoadedSetup setup = test::SetupFor(truth);
      const CalibrationProblem problem = MakeCalibrationProblem(setup.robot, data, setup.experiment);
      return KnownFrom(Calibration{problem, EstimateJointly(problem), {}});
    };
    const KnownRobot loaded = estimated(true, 1);
    truth.errors[7] += slip;  // dq3
    const KnownRobot unloaded = estimated(false, 2);
    for (const Changes& changes : {FindChanges(loaded, unloaded), FindChanges(unloaded, loaded)}) {
      EXPECT_EQ(NamesOf(changes), slip == 0.0 ? "" : "joint_zero/A3 ") << changes.words;
      EXPECT_THAT(changes.notes, ::testing::Contains(HasSubstr("compliance/A2")));
    }
  }
}

// Two estimates that claim to be surer than they are: no few changes explain how they differ, and that is said.
TEST(ChangesTest, WhatNoChangeExplainsIsSaid) {
  KnownRobot old_estimate = Estimated(Kr270Truth(), 12), new_estimate = Estimated(Kr270Truth(), 13);
  for (KnownRobot* known : {&old_estimate, &new_estimate}) known->campaign_covariance *= 0.1;
  const Changes changes = FindChanges(old_estimate, new_estimate);
  ASSERT_FALSE(changes.notes.empty()) << changes.words;
  EXPECT_THAT(changes.notes[0], HasSubstr("more is left"));
  for (KnownRobot* known : {&old_estimate, &new_estimate}) known->campaign_covariance *= 0.1;
  try {
    FindChanges(old_estimate, new_estimate);
    FAIL() << "six changes are listed";
  } catch (const Failure& failure) {
    EXPECT_THAT(failure.what(), HasSubstr("less certain than it says"));
  }
}

// All lengths and zeros of another arm of the type differ: the six largest of them explain the points no better than
// any six do.
TEST(ChangesTest, AnotherArmOfTheTypeIsNoListOfSixChanges) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal(0.0, 3e-4);
  Kr270Truth other;
  for (double& error : other.errors) error += normal(random);
  EXPECT_THROW(FindChanges(Estimated({}, 1), Estimated(other, 2)), Failure);
}

// The same points at 15 and at 25 degC are those of two arms, of which the one measured warmer is the smaller one: in a
// model with its growth that is what changed, and without temperatures nothing is.
TEST(ChangesTest, EstimatesWithTemperaturesAreComparedAtOne) {
  KnownRobot old_estimate = Estimated({}, 1), new_estimate = Estimated({}, 2);
  for (KnownRobot* known : {&old_estimate, &new_estimate}) {
    known->robot.effects.push_back({"thermal_growth", "robot", {}, {11.5e-6}});
    known->parameters["effect/thermal_growth/robot/growth"] = {11.5e-6, 11.5e-6};
    known->loading.origins.emplace();
  }
  EXPECT_EQ(NamesOf(FindChanges(old_estimate, new_estimate)), "");
  old_estimate.loading.origins->mean_temperature = 15.0;
  EXPECT_EQ(NamesOf(FindChanges(old_estimate, new_estimate)), "");
  new_estimate.loading.origins->mean_temperature = 25.0;
  const Changes changes = FindChanges(old_estimate, new_estimate);
  ASSERT_EQ(NamesOf(changes), "scale/lengths ") << changes.words;
  EXPECT_NEAR(changes.changes[0].value, -115.0, changes.changes[0].ci95[1] - changes.changes[0].ci95[0]);
}

// A column is the derivative of the exact move, to the second order. Joint 3
// moves with joint 2 here, as on arms with a parallelogram: its own part of the column of joint 2 is as large as the
// rest. The instrument stands metres away, so that its distance grows as well.
TEST(ChangesTest, ColumnsAreTheDerivativesOfExactMoves) {
  Kr270Truth far;
  far.base_xyz = {{2.0, -1.5, 0.3}, {1.0, 2.5, -0.4}};
  KnownRobot old_estimate = Estimated(far, 10), new_estimate = Estimated(far, 11);
  for (KnownRobot* known : {&old_estimate, &new_estimate}) known->robot.chain.couplings.push_back({2, 1, 1.0});
  EstimateComparison comparison(old_estimate, new_estimate);
  const EstimateComparison::Linear here = comparison.Linearise();
  std::vector<Eigen::VectorXd> none;
  for (const ChangeGroup& group : comparison.groups()) none.push_back(Eigen::VectorXd::Zero(group.size()));
  ASSERT_GT(none.size(), 10u);
  for (size_t g = 0; g < none.size(); ++g) {
    std::vector<Eigen::VectorXd> applied = none;
    applied[g].setConstant(1e-2);  // of 0.2 mm or 0.2 mrad: second orders are some 1e-6 of it
    comparison.MoveTo(applied);
    const Eigen::VectorXd moved = comparison.Linearise().left - here.left;
    comparison.MoveTo(none);
    const Eigen::VectorXd column = 1e-2 * here.columns(Eigen::all, here.of_group[g]).rowwise().sum();
    EXPECT_GT(column.norm(), 0.0) << comparison.groups()[g].target;
    EXPECT_LT((moved + column).norm(), 1e-3 * column.norm()) << comparison.groups()[g].target;
  }
}

// A gear that is off once per turn is no length that changed, and may be called one: said where an estimate's parts
// disagree.
TEST(ChangesTest, ModelErrorOfOneEstimateIsSaid) {
  Kr270Truth after;
  after.errors[7] += 0.4e-3;  // dq3
  const KnownRobot old_estimate = Estimated({}, 1);
  KnownRobot new_estimate = Estimated(after, 2);
  const auto said = ::testing::Contains(HasSubstr("has model error (1.9 times on its intervals)"));
  EXPECT_THAT(FindChanges(old_estimate, new_estimate).notes, ::testing::Not(said));
  new_estimate.model_error = 1.9;
  EXPECT_THAT(FindChanges(old_estimate, new_estimate).notes, said);
}

TEST(ChangesTest, OtherRobotsAreRefused) {
  const KnownRobot known = Estimated(Kr270Truth(), 9);
  EXPECT_THROW(FindChanges(known, Estimated(Kr270Truth(), 9, {}, "KR 210")), InputError);
  KnownRobot other = known;
  other.robot.chain.joints.pop_back();
  EXPECT_THROW(FindChanges(known, other), InputError);
  other = known;
  other.markers.clear();
  EXPECT_THROW(FindChanges(known, other), InputError);
}

// One column of length c against a residual r: log B(s) = 1/2 s^2 (c.r)^2 / (1 + s^2 c.c) - 1/2 log(1 + s^2 c.c), by
// hand for c = (3, 4), r = (1, 2): c.c = 25, c.r = 11.
TEST(SparseSearchTest, OneColumnAgainstTheClosedForm) {
  const Eigen::Vector2d c(3, 4), r(1, 2);
  double evidence = 0.0;
  for (const double s : kChangeScales) {
    const double v = s * s;
    evidence += std::exp(0.5 * v * 121 / (1 + 25 * v)) / std::sqrt(1 + 25 * v) / kNumChangeScales;
  }
  const SparsePosterior posterior = SearchSparse(c, r, {{{0}}});
  EXPECT_NEAR(posterior.probability[0], evidence / (1 + evidence), 1e-12);
  EXPECT_NEAR(posterior.nothing, 1 / (1 + evidence), 1e-12);
}

// The value is that of least squares, c.r / c.c = 110 / 25 +- 1 / 5, and not drawn towards 0 by the scale that won: the
// prior of 30 leaves 1 / (1 + 900 * 25) of it away.
TEST(SparseSearchTest, ValuesAreNotDrawnTowardsZero) {
  const Eigen::Vector2d c(3, 4), r(10, 20);
  const SparsePosterior posterior = SearchSparse(c, r, {{{0}}});
  ASSERT_EQ(posterior.best.size(), 1u);
  EXPECT_NEAR(posterior.best[0].mean[0], 4.4 * (1 - 1.0 / 22501), 1e-12);
  EXPECT_NEAR(posterior.best[0].covariance(0, 0), 900.0 / 22501, 1e-12);
}

// What has been applied is a part of the whole, r = left + c b, whether the set names it or not: as if nothing had
// been. What can be anywhere leaves its own way out.
TEST(SparseSearchTest, WhatWasAppliedCounts) {
  const Eigen::Vector2d c(3, 4), r(10, 20);
  const Eigen::VectorXd applied = Eigen::VectorXd::Constant(1, 4.0);
  const SparsePosterior whole = SearchSparse(c, r, {{{0}}});
  const SparsePosterior rest = SearchSparse(c, r - 4.0 * c, {{{0}}}, applied);
  EXPECT_NEAR(rest.best[0].mean[0], whole.best[0].mean[0], 1e-9);
  EXPECT_NEAR(rest.log_best, whole.log_best, 1e-9);
  EXPECT_NEAR(rest.nothing, whole.nothing, 1e-12);
  // ln p of the set: P(set) = 1/2 / 6, |r|^2 and (c.r)^2 of what is left, s = 5000.
  const SparsePosterior anywhere = SearchSparse(c, r, {{{0}, BeyondTypical::kAnywhere}}, applied * 1e4);
  const double s2 = kAnySize * kAnySize;
  EXPECT_TRUE(anywhere.best[0].anywhere);
  EXPECT_NEAR(anywhere.best[0].mean[0], 110.0 / (25 + 1 / s2), 1e-9);
  EXPECT_NEAR(anywhere.log_best,
              std::log(0.5 / 6) - 0.5 * 500 + 0.5 * s2 * 110 * 110 / (1 + 25 * s2) - 0.5 * std::log(1 + 25 * s2), 1e-6);
}

// What moves all of two and each of the two, of very different sizes: a whole and a part of it are no two causes.
TEST(SparseSearchTest, AWholeAndAPartOfItAreOneCause) {
  Eigen::MatrixXd columns(2, 4);
  columns << 100, 0, 100, 0, 0, 100, 0, 100;
  const std::vector<SparseGroup> groups = {
      {{0}, BeyondTypical::kNone, 2}, {{1}, BeyondTypical::kNone, 2}, {{2, 3}, BeyondTypical::kNone, -1}};
  double largest = 0.0;
  for (const double small : {0.05, 0.1, 0.3, 1.0}) {
    const SparsePosterior found = SearchSparse(columns, Eigen::Vector2d(3000.0, 100.0 * small), groups);
    largest = std::max(largest, found.probability[0] + found.probability[2]);
    EXPECT_LE(found.best.size(), 2u);
  }
  EXPECT_LE(largest, 1.0 + 1e-9);
  EXPECT_GT(largest, 0.9);
}

TEST(SparseSearchTest, APairIsFoundThatALikenessHides) {
  // Columns 0 and 1 made the residual; column 2 is near their sum and wins alone.
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(4, 3);
  columns.col(0) << 20, 0, 0, 0;
  columns.col(1) << 0, 20, 0, 0;
  columns.col(2) << 15, 14, 6, 0;
  const Eigen::Vector4d residual(20, 20, 0, 0);
  const SparsePosterior posterior = SearchSparse(columns, residual, {{{0}}, {{1}}, {{2}}});
  ASSERT_EQ(posterior.best.size(), 2u);
  EXPECT_EQ(posterior.best[0].group, 0);
  EXPECT_EQ(posterior.best[1].group, 1);
}

}  // namespace
}  // namespace sagitta::changes_test

// What an unnamed deviation moves, against differences of the model's own predictions, and its functions against the
// kernels that they stand for.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <map>
#include <numeric>
#include <set>

#include "estimator/explanations/driver_functions.h"
#include "estimator/explanations/evidence_columns.h"
#include "estimator/explanations/unnamed_functions.h"
#include "models/constants.h"
#include "models/effects/learnt_deviation.h"
#include "models/effects/pose_functions.h"
#include "tests/support/kr270_experiment.h"

namespace sagitta::unnamed_sources_test {
namespace {

constexpr double kSigma = 2e-5;  // m

CalibrationProblem Problem() {
  test::Kr270Design design;
  design.configurations = 12;
  design.stations = 1;
  design.sigma = kSigma;
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(test::Kr270Truth(), kSigma, 300, &data);
  Robot robot;
  robot.chain = test::Kr270Chain();
  return MakeCalibrationProblem(robot, data, Experiment());
}

// The same arm with loads, over an hour in which it warms up.
CalibrationProblem Campaign() {
  test::Kr270Design design;
  design.configurations = 40;
  design.stations = 1;
  design.sigma = kSigma;
  Measurements data = test::DesignMeasurements(design);
  for (size_t s = 0; s < data.shots.size(); ++s) {
    Shot& shot = data.shots[s];
    shot.has_time = shot.has_temperature = true;
    shot.time = 100.0 * static_cast<double>(s);
    shot.temperature = 20.0 + 5.0 * std::sin(0.05 * static_cast<double>(s));
    if (s % 2 == 0) continue;
    shot.load = "heavy";
    shot.wrench.force = {0.0, 0.0, -2000.0};
  }
  test::MeasureKr270(test::Kr270Truth(), kSigma, 300, &data);
  Robot robot;
  robot.chain = test::Kr270Chain();
  for (int j = 0; j < 6; ++j) robot.compliances.push_back({j, {{0.0, 1e-9}}, false});  // a load moves what gives way
  Experiment experiment;
  experiment.load_point = Vector3<double>(0.2, 0.1, -0.1);
  return MakeCalibrationProblem(robot, data, experiment);
}

// Parameters near the truth, where lever arms are those of a robot.
ParameterSet Placed(const CalibrationProblem& problem) {
  ParameterSet parameters = problem.parameters;
  parameters.SetBaseInStation(0, {RotationFromVector(Vector3<double>(0.1, -0.2, 0.7)), {3.0, -1.0, 0.5}});
  for (int m = 0; m < parameters.num_markers(); ++m) parameters.SetMarkerPoint(m, {0.1 * m, 0.05 - 0.1 * m, 0.2});
  return parameters;
}

// Of a source times one, m per unit: rows of all observations.
Eigen::VectorXd Moves(const CalibrationProblem& problem, const ParameterSet& parameters, const Source& source) {
  EvidenceColumns columns(problem, parameters, {});
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(static_cast<long>(problem.data().shots.size()));
  const std::vector<int> column = columns.Add({source, std::make_shared<const Eigen::MatrixXd>(ones)});
  const std::vector<int> all = problem.CalibrationObservations();
  return kSigma * columns.RowsAt(all, StatedScatter(problem), column).rightCols(1);
}

Eigen::VectorXd Predicted(const CalibrationProblem& problem, const ParameterSet& parameters) {
  return PredictPoints(problem, parameters, problem.CalibrationObservations()).reshaped();
}

TEST(UnnamedSources, APlateTurnsAllMarkersAboutTheFlange) {
  const CalibrationProblem problem = Problem();
  const ParameterSet parameters = Placed(problem);
  ParameterSet turned = parameters;
  for (int m = 0; m < parameters.num_markers(); ++m) {
    const Eigen::AngleAxisd turn(kTypicalPlateTurn, Eigen::Vector3d::UnitY());
    turned.SetMarkerPoint(m, turn * parameters.MarkerPoint(m));
  }
  const Eigen::VectorXd difference = Predicted(problem, turned) - Predicted(problem, parameters);
  EXPECT_GT(difference.norm(), 1e-4);
  const Source source{Source::Kind::kPlate, 0, 4};
  EXPECT_LT((Moves(problem, parameters, source) - difference).norm(), 1e-3 * difference.norm());
}

TEST(UnnamedSources, ALinkGrowsByItsLengths) {
  const CalibrationProblem problem = Problem();
  const ParameterSet parameters = Placed(problem);
  Robot grown = problem.robot();
  int before = -1, lengths = 0;
  for (ElementaryTransform& transform : grown.chain.transforms) {
    if (transform.has_joint()) before = transform.joint;
    if (before != 1 || transform.is_rotation() || transform.nominal == 0.0) continue;
    transform.nominal *= 1.0 + kTypicalGrowth;
    ++lengths;
  }
  ASSERT_GT(lengths, 0);
  const CalibrationProblem longer = MakeCalibrationProblem(grown, problem.data(), Experiment());
  const Eigen::VectorXd difference = Predicted(longer, parameters) - Predicted(problem, parameters);
  EXPECT_GT(difference.norm(), 1e-4);
  const Source source{Source::Kind::kLink, 1, 0};
  EXPECT_LT((Moves(problem, parameters, source) - difference).norm(), 1e-3 * difference.norm());
}

TEST(UnnamedSources, TheBaseTurnsInItsStation) {
  const CalibrationProblem problem = Problem();
  const ParameterSet parameters = Placed(problem);
  ParameterSet turned = parameters;
  Pose<double> pose = parameters.BaseInStation(0);
  pose.rotation = RotationFromVector(Vector3<double>(kTypicalStationTurn, 0.0, 0.0)) * pose.rotation;
  turned.SetBaseInStation(0, pose);
  const Eigen::VectorXd difference = Predicted(problem, turned) - Predicted(problem, parameters);
  const Source source{Source::Kind::kStationTurn, 0, 0};
  EXPECT_LT((Moves(problem, parameters, source) - difference).norm(), 1e-3 * difference.norm());
}

// A station that reads an azimuth, an elevation or a range of one marker too large sees it turned about the upright
// axis, in the plane of its ray, or further off; the other markers stay.
TEST(UnnamedSources, AReadingIsOfOneMarker) {
  const CalibrationProblem problem = Problem();
  const ParameterSet parameters = Placed(problem);
  for (int reading = 0; reading < 3; ++reading) {
    const Eigen::VectorXd moves = Moves(problem, parameters, {Source::Kind::kReading, 0, reading, 1});
    Eigen::VectorXd turned = Eigen::VectorXd::Zero(moves.size());
    long row = 0;
    for (const int i : problem.CalibrationObservations()) {
      const Observation& one = problem.data().observations[i];
      const Eigen::Vector3d& p = one.point_in_station;
      const Eigen::Vector3d across = p.cross(Eigen::Vector3d::UnitZ()).normalized();
      Eigen::Vector3d then = p * (1.0 + kTypicalMovement / p.norm());
      if (reading == 0) then = Eigen::AngleAxisd(kTypicalStationTurn, Eigen::Vector3d::UnitZ()) * p;
      if (reading == 1) then = Eigen::AngleAxisd(kTypicalStationTurn, across) * p;
      if (one.marker == 1) turned.segment<3>(row) = then - p;
      row += 3;
    }
    ASSERT_GT(turned.norm(), 1e-5);
    EXPECT_LT((moves - turned).norm(), 1e-4 * turned.norm()) << reading;
  }
}

// Random functions of a direction: covariance (c + c^2 + c^3) / 3 between two of cosine c.
TEST(PoseFunctions, OfADirectionDependOnTheAngleAlone) {
  const Eigen::VectorXd one = DirectionFunctions({0.6, 0.0, 0.8}, 3), other = DirectionFunctions({0.0, -0.6, 0.8}, 3);
  const double c = 0.64;
  EXPECT_EQ(one.size(), 3 + 6 + 10);
  EXPECT_EQ(NumDirectionFunctions(3), 3 + 6 + 10);
  EXPECT_NEAR(one.dot(other), (c + c * c + c * c * c) / 3.0, 1e-12);
  EXPECT_NEAR(one.squaredNorm(), 1.0, 1e-12);
}

// The share of the square of `functions` that no combination of `columns` makes.
double LeftBy(const Eigen::MatrixXd& columns, const Eigen::MatrixXd& functions) {
  const Eigen::MatrixXd fitted = columns * columns.completeOrthogonalDecomposition().solve(functions);
  return (functions - fitted).squaredNorm() / functions.squaredNorm();
}

// Whatever without a name may win can be added to the model: its effects make the same rows, but for a seat between
// visits, whose edges the bumps follow in part.
TEST(UnnamedFunctions, AreEffectsOfTheModel) {
  const CalibrationProblem problem = Campaign();
  ParameterSet parameters = problem.parameters;  // as measured: a scale is of measured points there, of predicted here
  parameters.SetBaseInStation(0, Pose<double>());
  for (int m = 0; m < parameters.num_markers(); ++m) parameters.SetMarkerPoint(m, test::Kr270Truth().tools[m]);
  const std::vector<int> all = problem.CalibrationObservations();
  const RowScatter scatter = StatedScatter(problem);
  EvidenceColumns columns(problem, parameters, {{{"load_com", "heavy", {}, {}}}});
  const std::vector<UnnamedGroup> groups = ListUnnamed(problem, parameters, &columns);
  std::vector<Candidate> candidates;
  std::map<std::string, int> number;
  for (const UnnamedGroup& group : groups) {
    EXPECT_FALSE(group.function.effects.empty()) << group.function.words;
    for (const EffectSpec& effect : group.function.effects) {
      if (number.emplace(effect.Path(), static_cast<int>(candidates.size())).second) candidates.push_back({effect});
    }
  }
  const EvidenceColumns effects(problem, parameters, candidates);
  const auto rows = [&](const EvidenceColumns& of) -> Eigen::MatrixXd {
    std::vector<int> every(static_cast<size_t>(of.num_columns()));
    std::iota(every.begin(), every.end(), 0);
    return of.RowsAt(all, scatter, every).rightCols(of.num_columns());
  };
  const Eigen::MatrixXd found = rows(columns), learnt = rows(effects);
  std::set<std::string> families;
  for (const UnnamedGroup& group : groups) {
    families.insert(group.family);
    std::vector<int> own;
    for (const EffectSpec& effect : group.function.effects) {
      const std::vector<int>& of = effects.ColumnsOf(number.at(effect.Path()));
      own.insert(own.end(), of.begin(), of.end());
    }
    const double left = LeftBy(learnt(Eigen::all, own), found(Eigen::all, group.group.columns) * group.group.mixing);
    const bool is_sharp = group.function.depends_on == std::vector<std::string>{"visits"};
    EXPECT_LT(left, is_sharp ? 0.3 : 2e-3) << group.function.words;
  }
  EXPECT_GE(families.size(), 20u);
  for (const char* family : {"tool in time", "reading", "range wave", "load shift", "lag", "pull", "base by place"}) {
    EXPECT_EQ(families.count(family), 1u) << family;
  }
}

// A centre of gravity that is off along one axis is load_com's: a slide of one axis that holds it, too, would say the
// same by fewer directions, and a tool whose length is misstated would have no name.
TEST(UnnamedFunctions, SlidesOfALoadHaveNoMean) {
  const CalibrationProblem problem = Campaign();
  EvidenceColumns columns(problem, problem.parameters, {{{"load_com", "heavy", {}, {}}}});
  const std::vector<int> fitted = FittedShots(problem);
  int slides = 0;
  for (const UnnamedGroup& group : ListUnnamed(problem, problem.parameters, &columns)) {
    if (group.function.effects.empty() || group.function.effects[0].effect != "learnt_load_slide") continue;
    const Eigen::MatrixXd functions = columns.FunctionOf(group.group.columns)(fitted, Eigen::all) * group.group.mixing;
    EXPECT_LT(functions.colwise().mean().norm(), 1e-6 * functions.norm()) << group.function.words;
    ++slides;
  }
  EXPECT_GE(slides, 3);
}

// On a lattice of 15 degrees waves of 23, 25, 47, ... per turn are those of 1 per turn: ten orders up to 130, which one
// stands for with the mass of all. On other angles none is.
TEST(UnnamedFunctions, OrdersThatALatticeDoesNotTellShareTheProbability) {
  const auto masses = [](double step) {
    test::Kr270Design design;
    design.configurations = 60;
    design.stations = 1;
    design.sigma = kSigma;
    Measurements data = test::DesignMeasurements(design);
    for (Configuration& configuration : data.configurations) {
      if (step > 0.0) configuration.q[1] = step * std::round(configuration.q[1] / step);
    }
    test::MeasureKr270(test::Kr270Truth(), kSigma, 301, &data);
    Robot robot;
    robot.chain = test::Kr270Chain();
    const CalibrationProblem problem = MakeCalibrationProblem(robot, data, Experiment());
    EvidenceColumns columns(problem, problem.parameters, {});
    std::map<std::string, double> of_order;
    for (const UnnamedGroup& group : ListUnnamed(problem, problem.parameters, &columns)) {
      if (group.family != "ripple" || group.function.acts_on != "A2") continue;
      of_order[group.function.effects[0].settings.at("order")] = group.listed;
    }
    return of_order;
  };
  std::map<std::string, double> lattice = masses(kPi / 12.0), scattered = masses(0.0);
  ASSERT_EQ(scattered.size(), 6u);
  for (const auto& [order, listed] : scattered) EXPECT_NEAR(listed, 6.0 / 124.0, 1e-12) << order;
  ASSERT_EQ(lattice.size(), 12u);  // 1 to 6 have aliases
  ASSERT_EQ(lattice.count("23"), 1u);
  EXPECT_NEAR(lattice["23"], 10.0 * 12.0 / 124.0, 1e-12);
}

TEST(DriverFunctions, StretchesShareTheVisitsEvenly) {
  const Eigen::VectorXd visits = Eigen::VectorXd::LinSpaced(60, 1.0, 60.0);
  const Eigen::MatrixXd stretches = Stretches(visits, 25);
  EXPECT_EQ(stretches.cols(), 25);
  EXPECT_TRUE((stretches.rowwise().sum().array() == 1.0).all());
  EXPECT_GE(stretches.colwise().sum().minCoeff(), 2.0);
  EXPECT_LE(stretches.colwise().sum().maxCoeff(), 3.0);
  EXPECT_EQ(Stretches(visits.head(10), 25).cols(), 10);
}

// A row of bumps with weights of unit variance has unit variance between the knots.
TEST(DriverFunctions, BumpsHaveUnitVariance) {
  const Eigen::VectorXd inside = Eigen::VectorXd::LinSpaced(50, 30.0, 70.0);
  EXPECT_LT((OverKnots(inside, {0.0, 100.0, 10}).rowwise().squaredNorm().array() - 1.0).abs().maxCoeff(), 2e-3);
}

// Of n ramps with independent weights of variance v the walk has the variance (t - u (1 - u) / n) n v at t, u the place
// within a ramp: n v (1/2 - 1 / 6 n) in the mean; the square of its mean is n v (1/3 - 1 / 12 n^2). With n v = 6 the
// difference is 1 - 1 / n + 1 / 2 n^2.
TEST(DriverFunctions, RampsHaveUnitVarianceAboutTheirMean) {
  const Eigen::VectorXd at = Eigen::VectorXd::LinSpaced(20001, 30.0, 70.0);
  for (const int n : {4, 50}) {
    const Eigen::MatrixXd ramps = OverKnots(at, {30.0, 70.0, n, true});
    const double square = ramps.rowwise().squaredNorm().mean(), of_mean = ramps.colwise().mean().squaredNorm();
    EXPECT_NEAR(square - of_mean, 1.0 - 1.0 / n + 0.5 / (n * n), 1e-3) << n;
    EXPECT_EQ(OverKnots(at.array() - 40.0, {30.0, 70.0, n, true}).row(0).norm(), 0.0);
  }
}

}  // namespace
}  // namespace sagitta::unnamed_sources_test

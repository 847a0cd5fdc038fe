// What results, baselines and comparisons state, recomputed from what they are made of.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "estimator/agreement/agreement.h"
#include "estimator/baselines/differencing.h"
#include "estimator/baselines/full_pose.h"
#include "estimator/baselines/paper_stages.h"
#include "estimator/calibration/joint_estimator.h"
#include "estimator/calibration/noise_loop.h"
#include "estimator/changes/changes.h"
#include "estimator/diagnosis/gap.h"
#include "estimator/least_squares/sandwich.h"
#include "estimator/noise/robot_scatter.h"
#include "estimator/results/intervals_json.h"
#include "estimator/results/prediction_noise.h"
#include "estimator/results/residuals_csv.h"
#include "estimator/sagitta.h"
#include "estimator/statistics/distributions.h"
#include "estimator/validation/unseen.h"
#include "tests/support/constant_orientation.h"
#include "tests/support/loaded_kr270.h"
#include "tests/support/random_vector.h"

namespace sagitta::recomputed_results_test {
namespace {

std::vector<int> AllOf(const CalibrationProblem& problem) {
  std::vector<int> all(problem.data().observations.size());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

// Sigmas stated three times too small: what predicts goes by the noise that the residuals showed.
TEST(RecomputedResults, APredictionGoesByTheNoiseOfTheResiduals) {
  Measurements data = test::DesignMeasurements(test::Kr270Design());
  test::MeasureKr270(test::Kr270Truth(), 3e-4, 4, &data);
  const CalibrationProblem problem = test::Kr270ProblemOf(data, Experiment());
  const Estimate estimate = EstimateJointly(problem);
  ASSERT_TRUE(estimate.sigma.scaled);
  double squares = 0.0;
  for (size_t k = 0; k < problem.data().observations.size(); ++k) {
    squares +=
        (problem.data().observations[k].point_in_station - estimate.predicted.col(static_cast<long>(k))).squaredNorm();
  }
  const double scale = std::sqrt(squares / 1e-8 / (162 - 39));
  EXPECT_NEAR(PredictionNoiseToJson(problem, estimate)["scale"].get<double>(), scale, 1e-9);
}

// Sigmas of an instrument, between 2 and 40 um, and a robot that scatters by 0.3 mm wherever it is: so does the next
// measurement, however well its row was seen.
TEST(RecomputedResults, APredictionAddsTheRobotsScatterToTheStatedNoise) {
  test::Kr270Design design;
  design.configurations = 60;
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(test::Kr270Truth(), 3e-4, 4, &data);
  for (size_t i = 0; i < data.observations.size(); ++i) data.observations[i].sigma.setConstant(i % 2 ? 2e-6 : 40e-6);
  const CalibrationProblem problem = test::Kr270ProblemOf(data, Experiment());
  const ResolvedEstimate found = EstimateWithNoise(problem);
  PredictionNoise noise;
  const double scatter = ScatterBeyondStated(found.problem, found.estimate);
  // Standard error of a standard deviation from 501 degrees of freedom: 3.2 %.
  EXPECT_NEAR(scatter, 3e-4, 4 * 0.032 * 3e-4);
  const nlohmann::ordered_json json = PredictionNoiseToJson(found.problem, found.estimate);
  EXPECT_DOUBLE_EQ(json["scatter_mm"].get<double>(), 1e3 * scatter);
  EXPECT_EQ(json["scale"].get<double>(), 1.0);
  noise.scatter = scatter;
  const NoiseRoots roots = PredictionRoots(problem, noise, found.estimate.predicted);
  for (size_t i = 0; i < 4; ++i) {
    const double stated = i % 2 ? 2e-6 : 40e-6;
    const Matrix3<double> covariance = roots[i] * roots[i].transpose();
    EXPECT_LT((covariance - (stated * stated + scatter * scatter) * Matrix3<double>::Identity()).norm(),
              1e-12 * scatter);
  }
}

// 100 points that miss by 1, 2, .. 100 mm.
TEST(RecomputedResults, SizesOfUnseenPoints) {
  test::Kr270Design design;
  design.configurations = 34;
  const CalibrationProblem problem = test::Kr270Problem(design, test::Kr270Truth(), 1);
  std::vector<int> rows = AllOf(problem);
  rows.resize(100);
  Eigen::Matrix3Xd errors = Eigen::Matrix3Xd::Zero(3, 100);
  for (int k = 0; k < 100; ++k) errors(k % 3, k) = 1e-3 * ((37 * k) % 100 + 1);
  const UnseenPoints unseen = MeasureUnseen(problem, rows, errors);
  EXPECT_NEAR(unseen.distance_p50, 50e-3, 1e-15);
  EXPECT_NEAR(unseen.distance_p95, 95e-3, 1e-15);
  EXPECT_NEAR(unseen.distance_max, 100e-3, 1e-15);
  EXPECT_NEAR(unseen.distance_rms, 1e-3 * std::sqrt(100 * 101 * 201 / 6 / 100.0), 1e-12);
}

// F with 2 and n degrees of freedom exceeds f with (1 + 2 f / n)^(-n/2); with n infinite, exp(-f).
TEST(RecomputedResults, ErrorsAgainstTheirPrediction) {
  PredictedSquares predicted;
  predicted.trace = 2e-8;
  predicted.trace_of_square = 2e-16;  // (tr V)^2 / tr V^2 = 2
  UnseenPoints unseen;
  unseen.points = 5;
  unseen.rms = 1e-4;  // 15 of them squared: 15e-8, 7.5 times the trace
  Estimate estimate;
  estimate.dof = 6;
  estimate.sigma.stated = false;
  ComparePrediction(predicted, estimate, &unseen);
  EXPECT_NEAR(unseen.p_value, std::pow(1.0 + 2.0 * 7.5 / 6.0, -3.0), 1e-9);
  estimate.sigma.stated = true;
  ComparePrediction(predicted, estimate, &unseen);
  EXPECT_NEAR(unseen.p_value, std::exp(-7.5), 1e-9);
  EXPECT_NEAR(unseen.predicted_rms, std::sqrt(2e-8 / 15.0), 1e-15);
}

// Held-out points off by 2 mm before and by 1 mm after, a floor of 0.5 mm: gaps of sqrt(4/3 - 1/4) and sqrt(1/3 - 1/4)
// mm per coordinate; closed is 1 - (1/12) / (13/12).
TEST(RecomputedResults, TheGapIsOneOfSquares) {
  Measurements data = test::DesignMeasurements(test::Kr270Design());
  test::MeasureKr270(test::Kr270Truth(), 1e-4, 4, &data);
  Experiment experiment;
  experiment.validation.kind = ValidationSpec::Kind::kFraction;
  experiment.validation.fraction = 0.3;
  const auto problem = std::make_shared<CalibrationProblem>(test::Kr270ProblemOf(data, experiment));
  const auto off_by = [&](double distance) {
    DiagnosedModel model{problem, {}};
    model.estimate.predicted.resize(3, static_cast<long>(problem->data().observations.size()));
    for (size_t k = 0; k < problem->data().observations.size(); ++k) {
      model.estimate.predicted.col(static_cast<long>(k)) =
          problem->data().observations[k].point_in_station + distance * Vector3<double>::Unit(static_cast<int>(k % 3));
    }
    return model;
  };
  const GapReport gap = JudgeGap(off_by(2e-3), off_by(1e-3), 0.5e-3, true);
  EXPECT_NEAR(gap.before, 1e-3 * std::sqrt(4.0 / 3 - 0.25), 1e-12);
  EXPECT_NEAR(gap.after, 1e-3 * std::sqrt(1.0 / 3 - 0.25), 1e-12);
  EXPECT_NEAR(gap.closed, 12.0 / 13.0, 1e-12);
}

// Whitened by the instrument and what joints of 60 urad move, by levers of another generator.
TEST(RecomputedResults, WhitenedResiduals) {
  const test::Kr270Truth truth;
  Measurements data = test::DesignMeasurements(test::Kr270Design());
  test::MeasureKr270(truth, 1e-4, 4, &data);
  Experiment experiment;
  experiment.repeatability.angle.common = 60e-6;
  const CalibrationProblem problem = test::Kr270ProblemOf(data, experiment);
  const Estimate estimate = EstimateJointly(problem);
  ASSERT_TRUE(IsUsable(estimate.status)) << estimate.message;
  const Eigen::Matrix3Xd whitened = WhitenedResiduals(problem, estimate);
  for (const int k : AllOf(problem)) {
    const Observation& row = problem.data().observations[k];
    const Eigen::VectorXd& q = problem.data().ConfigurationOf(row).q;
    const int station = problem.data().shots[row.shot].station;
    Matrix3<double> covariance = 1e-8 * Matrix3<double>::Identity();
    for (int j = 0; j < 6; ++j) {
      const Eigen::VectorXd step = 1e-6 * Eigen::VectorXd::Unit(6, j);
      const Vector3<double> lever = 60e-6 *
                                    (test::ExactPoint(truth, q + step, row.marker, station) -
                                     test::ExactPoint(truth, q - step, row.marker, station)) /
                                    2e-6;
      covariance += lever * lever.transpose();
    }
    const Vector3<double> r = row.point_in_station - estimate.predicted.col(k);
    EXPECT_NEAR(whitened.col(k).squaredNorm() / r.dot(covariance.ldlt().solve(r)), 1.0, 5e-3) << k;
  }
}

// mm per degree, deg per mm: SI times the unit of what is held over that of what moves.
TEST(RecomputedResults, SlopesOfWhatIsHeld) {
  const Eigen::Matrix3d one = test::Turn(Eigen::Vector3d::UnitY(), 0.3);
  Measurements data = test::ConstantOrientationGrid(one, 40, 3, 5e-5);
  test::MeasureKr270(test::Kr270Truth(), 5e-5, 4, &data);
  const CalibrationProblem problem = test::Kr270ProblemOf(data, Experiment());
  const Estimate estimate = EstimateJointly(problem);
  ASSERT_GT(estimate.held.coordinates.size(), 0u);
  const auto json = HeldToJson(estimate);
  const std::map<std::string, double> si = {{"mm", 1e-3}, {"mrad", 1e-3}, {"deg", 3.14159265358979323846 / 180}};
  int unlike = 0;
  for (size_t c = 0; c < estimate.estimated.size(); ++c) {
    for (size_t h = 0; h < estimate.held.coordinates.size(); ++h) {
      const std::string of = json["estimated_unit"][c], by = json["unit"][h];
      const double slope = json["slopes"][c][h].get<double>() * si.at(of) / si.at(by);
      const double expected = estimate.held.slopes(static_cast<long>(c), static_cast<long>(h));
      EXPECT_NEAR(slope, expected, 1e-9 * std::abs(expected) + 1e-300);
      unlike += of != by && std::abs(expected) > 1e-6;
    }
  }
  EXPECT_GT(unlike, 0);
}

// Two halves of thirteen configurations, six unknowns: Hotelling's T^2 of their difference by cluster-robust
// covariances, F = T^2 (n - m + 1) / (n m) with m and n - m + 1 degrees of freedom, n the clusters of both beyond their
// unknowns.
TEST(RecomputedResults, HalvesAreComparedByHotelling) {
  test::Kr270Design design;
  design.configurations = 26;
  design.stations = 1;
  const test::Kr270Truth truth;
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(truth, design.sigma, 7, &data);
  Experiment experiment;
  experiment.method.covariance = CovarianceKind::kSandwich;
  experiment.estimate.geometry.kind = Selection::Kind::kNone;
  experiment.estimate.markers = false;
  std::map<std::string, double> errors;
  for (size_t i = 0; i < 18; ++i) errors[test::Kr270Errors()[i]] = truth.errors[i];
  Robot robot;
  robot.chain = test::Kr270Chain();
  robot = WithGeometricErrors(robot, errors);
  for (int m = 0; m < 3; ++m) experiment.markers["P" + std::to_string(m + 1)].point = truth.tools[m];
  const CalibrationProblem problem = MakeCalibrationProblem(robot, data, experiment);
  Estimate estimate = EstimateJointly(problem);
  ASSERT_EQ(estimate.estimated.size(), 6u);
  CheckAgreement(problem, {1, 0}, &estimate);
  std::vector<double> q1;
  for (const Configuration& configuration : problem.data().configurations) q1.push_back(configuration.q[0]);
  std::nth_element(q1.begin(), q1.begin() + 13, q1.end());
  Eigen::VectorXd step[2];
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(6, 6);
  for (const int half : {0, 1}) {
    std::vector<int> rows;
    for (const int k : problem.CalibrationObservations()) {
      const bool is_below = problem.data().ConfigurationOf(problem.data().observations[k]).q[0] < q1[13];
      if (is_below == (half == 0)) rows.push_back(k);
    }
    ASSERT_EQ(rows.size(), 39u);
    Linearization fit = Linearize(problem, estimate.parameters, rows, estimate.estimated,
                                  NoiseRoots(rows.size(), 1e-4 * Matrix3<double>::Identity()));
    step[half] = -fit.jacobian.colPivHouseholderQr().solve(fit.residual);
    fit.residual += fit.jacobian * step[half];
    covariance += SandwichCovariance(fit, ConfigurationClusters(problem.data(), rows)).covariance;
  }
  const Eigen::VectorXd scale = covariance.diagonal().cwiseSqrt();
  const Eigen::VectorXd z = (step[0] - step[1]).cwiseQuotient(scale);
  const Eigen::MatrixXd correlation =
      scale.cwiseInverse().asDiagonal() * covariance * scale.cwiseInverse().asDiagonal();
  const double squares = z.dot(correlation.ldlt().solve(z)), n = 26 - 12, m = 6;
  int found = 0;
  for (const PartComparison& split : estimate.agreement.splits) {
    if (split.key != "A1") continue;
    EXPECT_NEAR(split.p_value, FSurvival(squares * (n - m + 1) / (n * m), m, n - m + 1), 1e-6);
    ++found;
  }
  EXPECT_EQ(found, 1);
}

// The published stage 1 (paper 000, eq. 9) sets I + [r]x for the base's rotation, which is none; the marker by its
// transpose.
TEST(RecomputedResults, TheLiteralStageIsLinearInTheRotation) {
  test::Kr270Truth truth;
  truth.base_rotvec = {{0.2, -0.1, 0.3}, {-0.1, 0.25, -0.2}};
  const CalibrationProblem problem = test::Kr270Problem(test::Kr270Design(), truth, 3);
  StageContext context{problem, problem.CalibrationObservations(), {}, {}, {}};
  context.noise = NoiseRoots(context.observations.size(), Matrix3<double>::Identity());
  StageState state{problem.parameters, {}};
  for (int s = 0; s < 2; ++s) state.bases.push_back(state.parameters.BaseInStation(s));
  ASSERT_TRUE(LiteralStageOne(context, &state));
  for (int s = 0; s < 2; ++s) {
    const Vector3<double> r = RotationVector(state.parameters.BaseInStation(s).rotation);
    ASSERT_GT(r.norm(), 0.2);
    Matrix3<double> linear;
    linear << 1, -r.z(), r.y(), r.z(), 1, -r.x(), -r.y(), r.x(), 1;
    EXPECT_LT((state.bases[s].rotation - linear).norm(), 1e-12);
  }
}

// An arm so soft that loads turn its levers by a tenth: the joints' deviations, 0.5 mrad against a reading of 1 um, no
// longer cancel in differences.
TEST(RecomputedResults, DeviationsOfASoftArmDoNotCancelInDifferences) {
  test::LoadedTruth truth;
  for (double& k : truth.k) k = 1.5e-5;
  test::LoadedDesign design;
  Measurements data = test::LoadedRows(design, truth);
  test::Measure(test::ExactPoints(truth, data), 1e-6, 3, &data);
  for (Observation& row : data.observations) row.sigma.setConstant(1e-6);
  test::LoadedSetup setup = test::SetupFor(truth);
  const Estimate without = EstimateByDifferencing(MakeCalibrationProblem(setup.robot, data, setup.experiment));
  setup.experiment.repeatability.angle.common = 5e-4;
  const Estimate with = EstimateByDifferencing(MakeCalibrationProblem(setup.robot, data, setup.experiment));
  ASSERT_TRUE(IsUsable(with.status)) << with.message;
  ASSERT_TRUE(IsUsable(without.status)) << without.message;
  for (const char* name : {"compliance/A2", "compliance/A3", "compliance/A5"}) {
    const int i = with.parameters.FindCoordinate(name);
    EXPECT_GT(with.table[i].sigma / without.table[i].sigma, 3.0) << name;
  }
}

// With hardly any weight on rotations it does not matter how the tool is turned about the point whose position counts.
TEST(RecomputedResults, FullPosesWithoutWeightOnRotationsGoByPositions) {
  const test::Kr270Truth truth;
  test::Kr270Design design;
  design.stations = 1;
  design.configurations = 40;
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(truth, 2e-5, 5, &data);
  Experiment experiment;
  experiment.estimate.markers = false;
  experiment.estimate.geometry = {Selection::Kind::kList, {"p_x1", "dq2", "dq3", "p_x2"}};
  Vector3<double> reference = Vector3<double>::Zero();
  for (int m = 0; m < 3; ++m) {
    experiment.markers["P" + std::to_string(m + 1)].point = truth.tools[m];
    reference += truth.tools[m] / 3.0;
  }
  FullPoseOptions options;
  options.weight = 1e-6;
  options.reference_in_flange = reference;
  const auto estimate = [&] {
    const Estimate found = EstimateFromFullPoses(test::Kr270ProblemOf(data, experiment), options);
    EXPECT_TRUE(IsUsable(found.status)) << found.message;
    return found;
  };
  const Estimate before = estimate();
  test::RandomNumbers random(8);
  for (const Shot& shot : data.shots) {  // every tool turned by a milliradian about its markers' centre
    Vector3<double> centre = Vector3<double>::Zero();
    for (const int k : shot.observations) centre += data.observations[k].point_in_station / 3.0;
    const Matrix3<double> turn = RotationFromVector(random.Vector(1e-3));
    for (const int k : shot.observations) {
      Vector3<double>& point = data.observations[k].point_in_station;
      point = centre + turn * (point - centre);
    }
  }
  const Estimate after = estimate();
  for (const int i : before.estimated) {
    EXPECT_NEAR(after.table[i].value, before.table[i].value, 0.05 * before.table[i].sigma) << before.table[i].name;
  }
}

// A parallelogram: A3 moves with A2. A slipped zero of A2 moves both, and is one change.
TEST(RecomputedResults, ASlippedDriverMovesWhatIsCoupledToIt) {
  constexpr double kRatio = -0.8;
  const auto estimated = [&](double slip, std::uint64_t seed) {
    test::Kr270Truth truth;
    test::Kr270Design design;
    design.seed = seed;
    design.configurations = 24;
    design.sigma = 3e-5;
    Measurements data = test::DesignMeasurements(design);
    NormalNumbers normal(1000 + seed);
    for (Observation& row : data.observations) {
      Eigen::VectorXd q = data.ConfigurationOf(row).q;
      q[1] += slip;
      q[2] += kRatio * q[1];
      const Vector3<double> noise = test::RandomVector(normal);
      row.point_in_station =
          test::ExactPoint(truth, q, row.marker, data.shots[row.shot].station) + design.sigma * noise;
    }
    Robot robot;
    robot.name = "KR 270";
    robot.chain = test::Kr270Chain();
    robot.chain.couplings.push_back({2, 1, kRatio});
    const CalibrationProblem problem = MakeCalibrationProblem(robot, data, Experiment());
    const Calibration calibration{problem, EstimateJointly(problem), {}};
    EXPECT_TRUE(IsUsable(calibration.estimate.status)) << calibration.estimate.message;
    return KnownFrom(calibration);
  };
  const Changes changes = FindChanges(estimated(0.0, 1), estimated(5e-4, 2));
  ASSERT_EQ(changes.changes.size(), 1u) << changes.words;
  EXPECT_EQ(WordOf(changes.changes[0].kind) + "/" + changes.changes[0].target, "joint_zero/A2");
  EXPECT_NEAR(changes.changes[0].value, 0.5, 0.1);  // mrad
}

}  // namespace
}  // namespace sagitta::recomputed_results_test

// Products that are made as they are asked for, against those of all rows at once.
#include "estimator/explanations/evidence_columns.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <tuple>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/explanations/driver_functions.h"
#include "estimator/explanations/explanations.h"
#include "estimator/least_squares/linearization.h"
#include "tests/support/kr270_experiment.h"
#include "tests/support/moved_kr270.h"

namespace sagitta::evidence_columns_test {
namespace {

// Two stations see each pose, so that rows of one visit and of one pose are not the same.
CalibrationProblem Campaign() {
  const test::Kr270Design design = test::CampaignOf(25, 2, 2e-5, 1);
  Measurements data = test::DesignMeasurements(design);
  for (size_t s = 0; s < data.shots.size(); ++s) {
    data.shots[s].has_time = true;
    data.shots[s].time = 100.0 * static_cast<double>(s);
  }
  test::MeasureKr270(test::Kr270Truth(), design.sigma, 302, &data);
  return MakeCalibrationProblem(test::Kr270Robot(), data, Experiment());
}

RowScatter Scatter(int joints, double visit, double pose) {
  return {Eigen::VectorXd::Constant(joints, visit), Eigen::VectorXd::Constant(joints, pose)};
}

TEST(EvidenceColumns, ProductsThatAreAskedForAreThoseOfAllRows) {
  CalibrationProblem problem = Campaign();
  for (size_t c = 0; c < problem.data().configurations.size(); ++c) {
    problem.mutable_data()->configurations[c].is_validation = c % 5 == 0;  // shots that are not fitted among the others
  }
  const ParameterSet parameters = EstimateJointly(problem).parameters;  // residuals of noise, not of decimetres
  const CandidateList candidates = ListCandidates(problem, parameters);
  EvidenceColumns columns(problem, parameters, candidates.candidates);
  const ExplanationList list = ListExplanations(problem, parameters, candidates, PriorMasses(), &columns);
  std::set<std::vector<int>> own;
  for (const Explanation& explanation : list.math) own.insert(explanation.group.columns);
  const int joints = problem.robot().num_joints();
  RowScatter grouped = StatedScatter(problem), with_joints = Scatter(joints, 2e-5, 4e-5);
  grouped.readings =
      with_joints.readings = {{{ReadingGroup::Kind::kStation, 1}, 3.0}, {{ReadingGroup::Kind::kSight, 0}, 0.5}};
  for (const RowScatter& scatter :
       {StatedScatter(problem), Scatter(joints, 3e-5, 0.0), Scatter(joints, 2e-5, 4e-5), grouped, with_joints}) {
    const GivenBelieved whole = columns.Project(columns.Sum(scatter, columns.AllColumns()));
    const GivenBelieved asked = columns.ProjectAll(scatter, own);
    EXPECT_NEAR(asked.log_constant, whole.log_constant, 1e-9 * std::abs(whole.log_constant));
    EXPECT_EQ(asked.normal.dof, whole.normal.dof);
    EXPECT_NEAR(asked.normal.residual, whole.normal.residual, 1e-9 * whole.normal.residual);
    EXPECT_LT((asked.normal.gradient - whole.normal.gradient).norm(), 1e-9 * whole.normal.gradient.norm());
    for (const std::vector<int>& group : own) {
      const Eigen::MatrixXd block = whole.normal.information.Own(group);
      EXPECT_LE((asked.normal.information.Own(group) - block).norm(), 1e-8 * block.norm());
    }
    for (int c = 0; c < columns.num_columns(); c += 97) {
      const Eigen::MatrixXd row = whole.normal.information.Rows({c});
      EXPECT_LE((asked.normal.information.Rows({c}) - row).norm(), 1e-8 * row.norm()) << c;
      EXPECT_LE(
          (asked.normal.information.Between({c - c % 2}, {c}) - whole.normal.information.Between({c - c % 2}, {c}))
              .norm(),
          1e-8 * row.norm());
    }
  }
}

// A factor on the noise of readings is other rows of the same problem: sums are those of the problem with that noise,
// given that the joints deviate.
TEST(EvidenceColumns, ScaledReadingsAreThoseOfAProblemWithThatNoise) {
  const CalibrationProblem problem = Campaign();
  const ParameterSet parameters = EstimateJointly(problem).parameters;
  const EvidenceColumns columns(problem, parameters, {});
  RowScatter scatter = Scatter(problem.robot().num_joints(), 2e-5, 4e-5);
  scatter.readings = {{{ReadingGroup::Kind::kMarker, 2}, 0.4}, {{ReadingGroup::Kind::kAxis, 1}, 2.5}};
  CalibrationProblem other = problem;
  double log_det = 0.0;  // of the roots: rows are whitened by them beforehand
  for (size_t i = 0; i < problem.data().observations.size(); ++i) {
    const Observation& row = problem.data().observations[i];
    const Vector3<double> factors = row.marker == 2 ? Vector3<double>(0.4, 1.0, 0.4) : Vector3<double>(1.0, 2.5, 1.0);
    const Matrix3<double> root = problem.SqrtCovariance(static_cast<int>(i));
    ASSERT_TRUE(root.isDiagonal());
    other.resolved_noise.push_back(root * factors.asDiagonal());
    log_det += 2.0 * factors.array().log().sum();
  }
  const EvidenceColumns of_other(other, parameters, {});
  const RowSums sums = columns.Sum(scatter, {});
  const RowSums expected = of_other.Sum(Scatter(problem.robot().num_joints(), 2e-5, 4e-5), {});
  EXPECT_LT((sums.products - expected.products).norm(), 1e-9 * expected.products.norm());
  EXPECT_NEAR(sums.log_det, expected.log_det + log_det, 1e-12 * std::abs(expected.log_det));
}

// A function that is 1 everywhere, with the repeatability that the experiment states: its column over all rows.
TEST(EvidenceColumns, SumsAlongSourcesAreThoseOfAConstantColumn) {
  Experiment experiment;
  for (const Joint& joint : test::Kr270Robot().chain.joints)
    experiment.repeatability.angle.per_joint[joint.name] = 3e-5;
  const CalibrationProblem plain = Campaign();
  const CalibrationProblem problem = MakeCalibrationProblem(plain.robot(), plain.data(), experiment);
  const ParameterSet parameters = EstimateJointly(problem).parameters;
  EvidenceColumns columns(problem, parameters, ListCandidates(problem, parameters).candidates);
  const Source joint{Source::Kind::kJoint, 2, 0};
  const auto ones = std::make_shared<const Eigen::MatrixXd>(Eigen::MatrixXd::Ones(problem.data().shots.size(), 1));
  const std::vector<int> column = columns.Add({joint, ones});
  const RowSums sums = columns.Sum(StatedScatter(problem), column);
  const AlongSources along = columns.SumAlong({joint});
  const long own = columns.num_believed();
  EXPECT_NEAR(along.square.sum(), sums.products(own, own), 1e-9 * sums.products(own, own));
  EXPECT_NEAR(along.residual.sum(), sums.products(own, own + 1), 1e-9 * std::sqrt(sums.products(own, own)));
  EXPECT_LT(along.square.sum(), 0.9 * columns.Sum(StatedScatter(plain), column).products(own, own));
}

// Residual r - A e, and what is believed without the effects, at an estimate that holds a weight (columns of its own),
// a harmonic (one of a family) and a spring, by differences of predicted points. The spring's torque is linear in its
// rate alone. holds_weight: what is believed is with the weight.
void CheckAboutAnEstimate(bool holds_weight) {
  const CalibrationProblem problem = Campaign();
  const ParameterSet parameters = EstimateJointly(problem).parameters;
  const std::vector<EffectSpec> effects = {{"link_gravity", "A3", {}, {}},
                                           {"joint_harmonic", "A2", {{"order", "2"}}, {}},
                                           {"gravity_compensator", "A2", {}, {0.2, 0.1, 0.7, 0.5, 3e4}}};
  const CalibrationProblem extended = problem.WithEffects(effects);
  ParameterSet about = extended.parameters;
  about.CopyByName(parameters);
  std::vector<int> linear = {about.FindCoordinate(CompensatorPart::kKc)};
  Eigen::VectorXd values = Eigen::VectorXd::Zero(about.num_coordinates());
  for (int i = 0; i < about.num_coordinates(); ++i) {
    const std::string& name = about.coordinates()[i].name;
    const bool is_weight = name.rfind("effect/link_gravity/A3/", 0) == 0;
    if (!is_weight && name.rfind("effect/joint_harmonic", 0) != 0) continue;
    values[i] = is_weight ? 20.0 : 4e-4;  // kg, kg m; rad
    linear.push_back(i);
  }
  ASSERT_EQ(linear.size(), 7u);
  about.Plus(values);

  const std::vector<int> fitted = problem.CalibrationObservations();
  const auto rows_at = [&](const ParameterSet& here) {
    const Eigen::Matrix3Xd points = PredictPoints(extended, here, fitted);
    Eigen::VectorXd rows(3 * points.cols());
    for (long i = 0; i < points.cols(); ++i)
      rows.segment<3>(3 * i) = (points.col(i) - problem.data().observations[fitted[i]].point_in_station) / 2e-5;
    return rows;
  };
  const auto by_step = [&](const ParameterSet& here, int i, double step) {
    Eigen::VectorXd delta = Eigen::VectorXd::Zero(here.num_coordinates());
    delta[i] = step;
    ParameterSet up = here, down = here;
    up.Plus(delta);
    down.Plus(-delta);
    return Eigen::VectorXd((rows_at(up) - rows_at(down)) / (2.0 * step));
  };
  const Eigen::VectorXd there = rows_at(about);
  Eigen::VectorXd residual = there;
  for (const int i : linear) residual -= about.Value(i) * by_step(about, i, 1e-3 * about.Value(i));
  ASSERT_GT((residual - there).norm(), 10.0 * there.norm() / std::sqrt(there.size()));

  const EvidenceColumns columns(problem, parameters, ListCandidates(problem, parameters).candidates,
                                {effects, about, holds_weight});
  const RowSums sums = columns.Sum(StatedScatter(problem), {});
  const long last = columns.num_believed();
  EXPECT_NEAR(sums.products(last, last), residual.squaredNorm(), 1e-6 * residual.squaredNorm());
  const std::vector<int> believed = parameters.EstimatedCoordinates();
  ASSERT_EQ(last, static_cast<long>(believed.size()));
  ParameterSet without = about;
  Eigen::VectorXd back = Eigen::VectorXd::Zero(about.num_coordinates());
  for (const int i : linear) {
    const bool is_weight = about.coordinates()[i].name.rfind("effect/link_gravity", 0) == 0;
    if (!is_weight || !holds_weight) back[i] = -about.Value(i);
  }
  without.Plus(back);
  for (long c = 0; c < last; ++c) {
    const std::string& name = parameters.coordinates()[believed[c]].name;
    const double step = name.find("compliance") != std::string::npos ? 1e-9 : 1e-6;
    const Eigen::VectorXd column = by_step(without, about.FindCoordinate(name), step);
    EXPECT_NEAR(sums.products(c, last), column.dot(residual), 1e-5 * column.norm() * residual.norm()) << name;
    EXPECT_NEAR(sums.products(c, c), column.squaredNorm(), 1e-5 * column.squaredNorm()) << name;
  }
}

TEST(EvidenceColumns, AboutAnEstimateWithEffectsTheResidualIsThatWithoutThem) { CheckAboutAnEstimate(false); }

TEST(EvidenceColumns, AboutAWeightThatAllHoldWhatIsBelievedIsWithIt) { CheckAboutAnEstimate(true); }

// Each group's sums are those over its poses alone, and all together they are those over all rows.
TEST(EvidenceColumns, SumsOfGroupsOfPosesAddUp) {
  const CalibrationProblem problem = Campaign();
  const ParameterSet parameters = EstimateJointly(problem).parameters;  // residuals of noise, not of decimetres
  const EvidenceColumns columns(problem, parameters, ListCandidates(problem, parameters).candidates);
  const RowScatter scatter = Scatter(problem.robot().num_joints(), 2e-5, 4e-5);
  const std::vector<int> some = {0, 3, columns.num_columns() - 1};
  std::vector<int> group_of_pose;
  std::vector<std::vector<int>> observations(3);
  std::map<int, int> pose_of;  // by configuration
  for (const int i : problem.CalibrationObservations()) {
    const int configuration = problem.data().shots[problem.data().observations[i].shot].configuration;
    const int pose = pose_of.emplace(configuration, static_cast<int>(pose_of.size())).first->second;
    observations[pose % 7 % 3].push_back(i);
  }
  ASSERT_EQ(static_cast<int>(pose_of.size()), columns.num_poses());
  for (int pose = 0; pose < columns.num_poses(); ++pose) group_of_pose.push_back(pose % 7 % 3);
  const std::vector<RowSums> each = columns.SumEach(scatter, some, group_of_pose);
  ASSERT_EQ(each.size(), 3u);
  RowSums all = RowSums::Zero(each[0].products.rows());
  for (size_t g = 0; g < each.size(); ++g) {
    all.AddUpper(each[g], 1);
    const Eigen::MatrixXd rows = columns.RowsAt(observations[g], scatter, some), alone = rows.transpose() * rows;
    EXPECT_EQ(each[g].rows, rows.rows());
    EXPECT_LT((each[g].products.topLeftCorner(rows.cols(), rows.cols()) - alone).norm(), 1e-9 * alone.norm()) << g;
  }
  const RowSums whole = columns.Sum(scatter, some);
  EXPECT_EQ(all.rows, whole.rows);
  EXPECT_NEAR(all.log_det, whole.log_det, 1e-9 * std::abs(whole.log_det));
  const Eigen::MatrixXd upper = whole.products.triangularView<Eigen::Upper>();
  EXPECT_LT((all.products - upper).norm(), 1e-9 * upper.norm());
  all.AddUpper(each[0], 2);
  EXPECT_EQ(all.rows, whole.rows + 2 * each[0].rows);
  const Eigen::MatrixXd thrice = upper + 2.0 * Eigen::MatrixXd(each[0].products.triangularView<Eigen::Upper>());
  EXPECT_LT((all.products - thrice).norm(), 1e-9 * thrice.norm());
}

// [J r]'C^-1 [J r] and log |C| with C = I + sum of sigma^2 l l' within visits and within poses, C as one dense matrix
// and l by differences of predicted points. Each pose is visited twice.
TEST(EvidenceColumns, RowsOfVisitsAndOfPosesScatterTogether) {
  test::Kr270Design design;
  design.configurations = 12;
  design.stations = 1;
  design.sigma = 2e-5;
  Measurements data = test::DesignMeasurements(design);
  test::VisitAgain(design, &data);
  test::MeasureKr270(test::Kr270Truth(), design.sigma, 303, &data);
  const CalibrationProblem problem = test::Kr270ProblemOf(data, Experiment());
  const ParameterSet parameters = EstimateJointly(problem).parameters;  // residuals of noise, not of decimetres
  const EvidenceColumns columns(problem, parameters, {});
  ASSERT_EQ(columns.num_poses(), design.configurations);

  const std::vector<int> fitted = problem.CalibrationObservations(), believed = parameters.EstimatedCoordinates();
  const auto count = static_cast<long>(fitted.size());
  const Linearization rows = Linearize(problem, parameters, fitted, believed,
                                       ObservationNoise(problem, fitted, kFallbackSigma), LatentTreatment::kIgnore);
  const double sigma[2] = {2e-5, 4e-5}, step = 1e-6;  // rad
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(3 * count, 3 * count);
  for (int j = 0; j < 6; ++j) {
    Eigen::VectorXd along(3 * count);
    Eigen::Matrix3Xd shifted[2];
    for (const int side : {0, 1}) {
      Measurements turned = data;
      for (Configuration& configuration : turned.configurations) configuration.q[j] += side == 0 ? step : -step;
      shifted[side] = PredictPoints(test::Kr270ProblemOf(turned, Experiment()), parameters, fitted);
    }
    const Eigen::Matrix3Xd by_step = (shifted[0] - shifted[1]) / (2.0 * step * design.sigma);
    for (long i = 0; i < count; ++i) along.segment<3>(3 * i) = by_step.col(i);
    const auto visit_of = [&](long row) { return data.observations[fitted[row / 3]].shot; };
    const auto pose_of = [&](long row) { return data.shots[visit_of(row)].configuration % design.configurations; };
    for (long a = 0; a < 3 * count; ++a) {
      for (long b = 0; b < 3 * count; ++b) {
        const double product = along[a] * along[b];
        if (visit_of(a) == visit_of(b)) covariance(a, b) += sigma[0] * sigma[0] * product;
        if (pose_of(a) == pose_of(b)) covariance(a, b) += sigma[1] * sigma[1] * product;
      }
    }
  }
  const long known = columns.num_believed();
  ASSERT_EQ(known, static_cast<long>(believed.size()));
  Eigen::MatrixXd all(3 * count, known + 1);
  all << rows.jacobian, rows.residual;
  const Eigen::LLT<Eigen::MatrixXd> root(covariance);
  const Eigen::MatrixXd products = all.transpose() * root.solve(all);
  const RowSums sums = columns.Sum(Scatter(6, sigma[0], sigma[1]), columns.AllColumns());
  EXPECT_EQ(sums.rows, 3 * count);
  const double log_det = 2.0 * root.matrixLLT().diagonal().array().log().sum();
  ASSERT_GT(log_det, 1.0);
  EXPECT_NEAR(sums.log_det, log_det, 1e-5 * log_det);
  const Eigen::VectorXd size = products.diagonal().cwiseSqrt();
  for (long i = 0; i <= known; ++i) {
    for (long k = i; k <= known; ++k)
      EXPECT_NEAR(sums.products(i, k), products(i, k), 1e-8 * size[i] * size[k]) << i << " " << k;
  }
  // Given what is believed: rows less what these determine of unknowns, and what no value of these explains.
  const GivenBelieved given_believed = columns.Project(sums);
  const Eigen::MatrixXd white = root.matrixL().solve(all);
  const Eigen::VectorXd scale = white.colwise().norm().cwiseInverse();
  const Eigen::MatrixXd scaled = white.leftCols(known) * scale.head(known).asDiagonal();
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(scaled);
  qr.setThreshold(1e-9);
  EXPECT_EQ(given_believed.normal.dof, static_cast<double>(3 * count - qr.rank()));
  EXPECT_GT(qr.rank(), 20);
  const double left = (white.col(known) - scaled * qr.solve(white.col(known))).squaredNorm();
  EXPECT_NEAR(given_believed.normal.residual, left, 1e-4 * left);
}

// Whatever is asked for first, and in whatever order, is a part of the same symmetric matrix.
TEST(ColumnProducts, AreThoseOfTheWholeInAnyOrder) {
  Eigen::MatrixXd whole(7, 7);
  for (int a = 0; a < 7; ++a) {
    for (int b = 0; b < 7; ++b) whole(a, b) = std::cos(1.0 + a * b) + 0.1 * (a + b);
  }
  int asked = 0;
  const auto rows_of = [&](const std::vector<int>& columns) -> Eigen::MatrixXd {
    asked += static_cast<int>(columns.size());
    return whole(columns, Eigen::all);
  };
  const ColumnProducts products({{{5, 6}, whole({5, 6}, {5, 6})}}, rows_of);
  EXPECT_EQ(products.Own({5, 6}), Eigen::MatrixXd(whole({5, 6}, {5, 6})));
  EXPECT_EQ(asked, 0);
  EXPECT_EQ(products.Rows({3, 1}), Eigen::MatrixXd(whole({3, 1}, Eigen::all)));
  EXPECT_EQ(products.Between({1}, {0, 2, 4}), Eigen::MatrixXd(whole({1}, {0, 2, 4})));
  EXPECT_EQ(products.Between({0, 2, 4}, {3, 1}), Eigen::MatrixXd(whole({0, 2, 4}, {3, 1})));
  EXPECT_EQ(asked, 2);  // the rows of 3 and 1 hold all of these
  EXPECT_EQ(products.Own({4, 0}), Eigen::MatrixXd(whole({4, 0}, {4, 0})));
  EXPECT_EQ(asked, 4);
  const std::vector<int> known = {4}, one = {2}, other = {6, 2};
  products.AskTogether({&known, &one});  // one alone
  EXPECT_EQ(asked, 4);
  products.AskTogether({&known, &one, &other});
  EXPECT_EQ(asked, 6);
  EXPECT_EQ(products.Between(other, one), Eigen::MatrixXd(whole({6, 2}, {2})));
  EXPECT_EQ(asked, 6);
}

// F is made again from few directions, however many columns it has: sines of 200 phases are two functions.
TEST(DriverFunctions, FewDirectionsAreKept) {
  for (const long shots : {40L, 500L}) {
    Eigen::MatrixXd functions(shots, 200);
    for (long c = 0; c < 200; ++c) {
      for (long s = 0; s < shots; ++s) {
        functions(s, c) = std::sin(0.1 * static_cast<double>(s) + 0.7 * static_cast<double>(c));
      }
    }
    const Compressed compressed = Compress(functions, 1e-5);
    EXPECT_EQ(compressed.basis.cols(), 2);
    EXPECT_LT((compressed.basis * compressed.mixing - functions).norm(), 1e-9 * functions.norm());
  }
}

}  // namespace
}  // namespace sagitta::evidence_columns_test

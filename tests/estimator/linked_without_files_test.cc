// What a program that links the library does without files, from rows in memory to results: everything works or is
// refused with words, nothing ends the program.
#include <ceres/ceres.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "estimator/least_squares/linearization.h"
#include "estimator/least_squares/minimize.h"
#include "estimator/results/next_csv.h"
#include "estimator/results/residuals_csv.h"
#include "estimator/sagitta.h"
#include "problems/io/csv_table.h"
#include "problems/io/files.h"
#include "problems/io/measurement_writer.h"
#include "tests/support/in_memory.h"
#include "tests/support/paths.h"

namespace sagitta::linked_without_files_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

const Measurements& Rows() {
  static const Measurements rows = test::ReadingsInMemory(test::ArmInMemory());
  return rows;
}

Measurements RowsWithoutSigmas() {
  Measurements rows = Rows();
  for (Observation& row : rows.observations) row.sigma.setZero();
  return rows;
}

CalibrationProblem ProblemOf(const Measurements& rows, const Experiment& experiment = {}) {
  return MakeCalibrationProblem(test::ArmInMemory(), rows, experiment);
}

const Calibration& Calibrated() {
  static const Calibration calibration = Calibrate(ProblemOf(Rows()));
  return calibration;
}

const KnownRobot& Known() {
  static const KnownRobot known = KnownFrom(Calibrated());
  return known;
}

std::string WordsOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const InputError& error) {
    return std::string("InputError ") + error.what();
  } catch (const std::invalid_argument& error) {
    return std::string("invalid_argument ") + error.what();
  }
  return "";
}

TEST(RowsInMemory, CalibrationIsWritten) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "linked_without_files";
  std::filesystem::remove_all(folder);
  WriteCalibration(Calibrated(), folder.string());
  for (const char* name : {"estimate.json", "residuals.csv", "robot.calibrated.yaml"}) {
    EXPECT_TRUE(std::filesystem::exists(folder / name)) << name;
  }
  const KnownRobot known = ReadEstimateFile((folder / "estimate.json").string());
  EXPECT_LT((Predict(known, Rows()).points - Calibrated().estimate.predicted).cwiseAbs().maxCoeff(), 1e-9);
}

// Which row it is, and what came out.
TEST(RowsInMemory, TablesNameTheRows) {
  const Prediction prediction = Predict(Known(), Rows());
  const CsvTable predicted = ParseCsvTable(PredictionToCsv(Rows(), prediction), "predicted");
  const CsvTable residuals = ParseCsvTable(ResidualsToCsv(Calibrated().problem, Calibrated().estimate), "residuals");
  const CsvTable validated = ParseCsvTable(ValidationToCsv(Rows(), Validate(Known(), Rows())), "validated");
  for (const CsvTable* table : {&predicted, &residuals, &validated}) {
    ASSERT_EQ(table->file.rows.size(), Rows().observations.size());
    const auto cell = [table](const char* column) {
      return std::string(table->file.rows[4].cells.at(static_cast<size_t>(table->file.FindColumn(column))));
    };
    EXPECT_EQ(cell("config"), "c1");
    EXPECT_EQ(cell("station"), "S1");
    EXPECT_EQ(cell("marker"), "M2");
    EXPECT_NEAR(std::stod(cell("x_mm")), 1e3 * Rows().observations[4].point_in_station.x(), 1e-9);
    EXPECT_NEAR(std::stod(cell("pred_x_mm")), 1e3 * prediction.points(0, 4), 1e-9);
  }
}

TEST(RowsInMemory, PosesToMeasureNextHaveTheirJointValues) {
  Diagnosis diagnosis;
  diagnosis.baseline.problem = std::make_shared<CalibrationProblem>(ProblemOf(Rows()));
  diagnosis.next = NextPoses();
  diagnosis.next->poses = {{Eigen::VectorXd::Constant(6, 0.5), 2}};
  const std::string csv = NextToCsv(diagnosis);
  EXPECT_THAT(csv, HasSubstr("config,visit,repeat,load,station,marker,x_mm,y_mm,z_mm,q1_deg,"));
  EXPECT_THAT(csv, HasSubstr("\nnext1,,,none,S1,M1,,,,28.648,28.648,"));
}

TEST(RowsInMemory, ErrorsOfPredictionNameThem) {
  Measurements rows = Rows();
  rows.markers[1] = "M9";
  EXPECT_THAT(WordsOf([&] { Predict(Known(), rows); }),
              AllOf(StartsWith("InputError configuration c0, marker M9"), HasSubstr("no point of marker")));
  rows = Rows();
  rows.shots[2].load = "W";
  EXPECT_THAT(WordsOf([&] { Predict(Known(), rows); }), HasSubstr("configuration c2, load W, marker M1"));
  // Joint values have a unit that rows do not state.
  EXPECT_THAT(WordsOf([] { MeasurementsToCsv(Rows()); }), HasSubstr("configuration c0, marker M1"));
}

TEST(RowsInMemory, PredictionChecksThemToo) {
  Measurements rows = Rows();
  rows.configurations[3].q.conservativeResize(5);
  const auto each = {+[](const Measurements& bad) { Predict(Known(), bad); },
                     +[](const Measurements& bad) { Validate(Known(), bad); },
                     +[](const Measurements& bad) { Simulate(Known(), bad, {}); }};
  for (const auto call : each) EXPECT_THAT(WordsOf([&] { call(rows); }), HasSubstr("configuration c3"));
  rows = Rows();
  rows.observations[4].marker = 7;
  for (const auto call : each) EXPECT_THAT(WordsOf([&] { call(rows); }), HasSubstr("observation 4"));
  EXPECT_THAT(WordsOf([] { Predict(KnownRobot(), Rows()); }), HasSubstr("no joint"));
}

TEST(RowsInMemory, ReadingsThatContradictAPredictionAreSaidWithIt) {
  const auto warnings = [](const Measurements& rows) { return WarningsOf(Known(), rows, Predict(Known(), rows)); };
  const auto contradict = testing::Contains(HasSubstr("times what noise and parameters let expect"));
  EXPECT_THAT(warnings(Rows()), testing::Not(contradict));
  Measurements off = Rows();
  for (Observation& row : off.observations) row.point_in_station.z() += 20 * test::kSigmaInMemory;
  EXPECT_THAT(warnings(off), contradict);
}

TEST(RowsInMemory, WhatIsFittedWasRead) {
  Measurements rows = Rows();
  rows.observations[4].point_in_station.x() = kNan;
  EXPECT_THAT(WordsOf([&] { Calibrate(ProblemOf(rows)); }),
              AllOf(StartsWith("InputError configuration c1, marker M2"), HasSubstr("no number")));
  EXPECT_THAT(WordsOf([&] { Diagnose(ProblemOf(rows), {}); }), HasSubstr("configuration c1, marker M2"));
  EXPECT_THAT(WordsOf([&] { CheckReadings(ProblemOf(rows), "go on"); }), HasSubstr("configuration c1, marker M2"));
  EXPECT_THAT(WordsOf([&] { RunMethod(ProblemOf(rows), Method::kTwoStep, Calibrated().estimate, {}); }),
              HasSubstr("configuration c1, marker M2"));
  Experiment held_out;
  held_out.validation.kind = ValidationSpec::Kind::kFraction;
  held_out.validation.fraction = 0.5;
  EXPECT_THAT(WordsOf([&] { Calibrate(ProblemOf(rows, held_out)); }), HasSubstr("configuration c1, marker M2"));
  EXPECT_TRUE(Predict(Known(), rows).points.allFinite());
  rows.ExcludeRow(4);
  EXPECT_TRUE(IsUsable(Calibrate(ProblemOf(rows)).estimate.status));
}

// As Calibrate counts them.
TEST(RowsInMemory, ExcludedAndLostReadingsDoNotJudge) {
  const Validation all = Validate(Known(), Rows());
  EXPECT_EQ(all.after.observations, static_cast<int>(Rows().observations.size()));
  Measurements rows = Rows();
  rows.observations[4].point_in_station.x() += 0.005;
  const Validation with = Validate(Known(), rows);
  EXPECT_FALSE(with.refutation.empty());
  rows.ExcludeRow(4);
  const Validation without = Validate(Known(), rows);
  EXPECT_EQ(without.after.observations, all.after.observations - 1);
  EXPECT_TRUE(without.refutation.empty());
  EXPECT_EQ(without.predicted.cols(), all.predicted.cols());
  rows.ExcludeRow(4, false);
  rows.observations[4].point_in_station.x() = kNan;
  const Validation lost = Validate(Known(), rows);
  EXPECT_EQ(lost.after.rms, without.after.rms);
  EXPECT_EQ(lost.predicted_rms, without.predicted_rms);
  EXPECT_EQ(lost.p_value, without.p_value);
  for (Observation& row : rows.observations) row.excluded = true;
  EXPECT_THAT(WordsOf([&] { Validate(Known(), rows); }), HasSubstr("nothing judges the estimate"));
}

TEST(RowsInMemory, ResultsBelongToTheirRows) {
  Measurements fewer = test::ReadingsInMemory(test::ArmInMemory(), 20);
  const Prediction prediction = Predict(Known(), Rows());
  const Validation validation = Validate(Known(), Rows());
  const auto refused = StartsWith("invalid_argument ");
  EXPECT_THAT(WordsOf([&] { PredictionToCsv(fewer, prediction); }), refused);
  EXPECT_THAT(WordsOf([&] { LargestDeviation(prediction, fewer); }), refused);
  EXPECT_THAT(WordsOf([&] { LeftOpenInWords(Known(), fewer, prediction); }), refused);
  EXPECT_THAT(WordsOf([&] { WarningsOf(Known(), fewer, prediction); }), refused);
  EXPECT_THAT(WordsOf([&] { Contradiction(Known(), fewer, prediction.points); }), refused);
  EXPECT_THAT(WordsOf([&] { CheckReadings(Known(), fewer, prediction.points, "go on"); }), refused);
  EXPECT_THAT(WordsOf([&] { ValidationToCsv(fewer, validation); }), refused);
}

TEST(RowsInMemory, AnInputIsNotOverwritten) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "input_is_kept";
  std::filesystem::remove_all(folder);
  WriteCalibration(Calibrated(), folder.string());
  Experiment experiment;
  experiment.robot_file = (folder / "robot.calibrated.yaml").string();
  const std::string before = ReadTextFile(experiment.robot_file);
  const Calibration again = Calibrate(ProblemOf(Rows(), experiment));
  EXPECT_THAT(WordsOf([&] { WriteCalibration(again, folder.string()); }), HasSubstr("would be overwritten"));
  EXPECT_EQ(ReadTextFile(experiment.robot_file), before);
  WriteCalibration(again, (folder / "other").string());
}

TEST(RowsInMemory, APlanKnowsItsEffects) {
  PlanRequest request;
  request.poses = 6;
  request.discriminate = {{"nonsense", "A1", {}, {}}, {"joint_harmonic", "A1", {{"order", "1"}}, {}}};
  EXPECT_THAT(WordsOf([&] { MakePlan(test::ArmInMemory(), Rows(), {}, request); }), HasSubstr("'nonsense'"));
}

// m or rad, of a parameter, from Ceres' covariance of the residuals of a calibrated problem; as a share of what the
// calibration says.
double ShareOfCalibrated(const Calibration& calibration, const std::string& name) {
  ParameterSet parameters = calibration.estimate.parameters;
  ceres::Problem ceres_problem;
  LatentBlocks deviations;
  AddToProblem(calibration.problem, CalibrationResiduals(calibration.problem), &parameters, &ceres_problem,
               &deviations);
  const int i = parameters.FindCoordinate(name);
  const double* block = parameters.blocks()[parameters.coordinates()[i].block].values.data();
  ceres::Covariance covariance({});
  EXPECT_TRUE(covariance.Compute(std::vector<const double*>{block}, &ceres_problem));
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> of_block;
  covariance.GetCovarianceBlockInTangentSpace(block, block, of_block.data());
  const int k = parameters.coordinates()[i].index_in_block;
  return std::sqrt(of_block(k, k)) / calibration.estimate.table[i].sigma;
}

TEST(ResidualsOfACalibration, WeighByTheNoiseThatWasFound) {
  const Calibration unstated = Calibrate(ProblemOf(RowsWithoutSigmas()));
  ASSERT_FALSE(unstated.estimate.sigma.stated);
  EXPECT_NEAR(ShareOfCalibrated(unstated, "marker/M1/z"), 1.0, 1e-3);
  EXPECT_NEAR(ShareOfCalibrated(unstated, "base/S1/rx"), 1.0, 1e-3);
  Measurements too_small = Rows();
  for (Observation& row : too_small.observations) row.sigma.setConstant(0.3 * test::kSigmaInMemory);
  const Calibration scaled = Calibrate(ProblemOf(too_small));
  ASSERT_TRUE(scaled.estimate.sigma.scaled);
  EXPECT_NEAR(ShareOfCalibrated(scaled, "marker/M1/z"), 1.0, 1e-3);
  EXPECT_NEAR(ShareOfCalibrated(Calibrated(), "marker/M1/z"), 1.0, 1e-3);
  Experiment with_deviations;
  with_deviations.repeatability.angle.common = 5e-6;
  const Calibration both = Calibrate(ProblemOf(too_small, with_deviations));
  ASSERT_TRUE(both.estimate.sigma.scaled);
  EXPECT_NEAR(ShareOfCalibrated(both, "marker/M1/z"), 1.0, 1e-3);
}

// 1/2 sum rho(|u|), by its definition (noise/robust.h).
double CostByDefinition(const CalibrationProblem& problem, LossKind loss) {
  const std::vector<int> rows = problem.CalibrationObservations();
  const Linearization at = Linearize(problem, problem.parameters, rows, {}, ObservationNoise(problem, rows, 1e-3));
  double cost = 0.0;
  for (int k = 0; k < static_cast<int>(rows.size()); ++k) {
    const double r = at.residual.segment<3>(3 * k).norm();
    if (loss == LossKind::kHuber) cost += r <= 2.1 ? 0.5 * r * r : 2.1 * r - 0.5 * 2.1 * 2.1;
    if (loss == LossKind::kCauchy) cost += 0.5 * 2.67 * 2.67 * std::log1p(r * r / (2.67 * 2.67));
    if (loss == LossKind::kNone) cost += 0.5 * r * r;
  }
  return cost;
}

TEST(ResidualsOfACalibration, BelongToTheirProblem) {
  const CalibrationProblem problem = ProblemOf(Rows());
  const auto words = [&](const ResidualSelection& selection, ParameterSet parameters) {
    return WordsOf([&] {
      ceres::Problem ceres_problem;
      AddToProblem(problem, selection, &parameters, &ceres_problem);
    });
  };
  const ResidualSelection whole = CalibrationResiduals(problem);
  EXPECT_EQ(words(whole, problem.parameters), "");
  ResidualSelection selection = whole;
  selection.observations.back() = static_cast<int>(problem.data().observations.size());
  EXPECT_THAT(words(selection, problem.parameters), HasSubstr("there is no observation"));
  selection = whole;
  selection.noise.pop_back();
  EXPECT_THAT(words(selection, problem.parameters), HasSubstr("a noise for each"));
  selection = whole;
  selection.noise[3].setZero();
  EXPECT_THAT(words(selection, problem.parameters), HasSubstr("has no noise"));
  selection = whole;
  selection.deviation_factor = -1.0;
  EXPECT_THAT(words(selection, problem.parameters), HasSubstr("not above 0"));
  const CalibrationProblem other = problem.WithEffects({{"joint_harmonic", "A2", {{"order", "1"}}, {}}});
  EXPECT_THAT(words(whole, other.parameters), HasSubstr("another problem"));
}

TEST(ResidualsOfACalibration, CarryTheLoss) {
  for (const LossKind loss : {LossKind::kNone, LossKind::kHuber, LossKind::kCauchy}) {
    Experiment experiment;
    experiment.method.loss = loss;
    CalibrationProblem problem = ProblemOf(Rows(), experiment);
    problem.parameters = Calibrated().estimate.parameters;
    problem.parameters.SetMarkerPoint(1, problem.parameters.MarkerPoint(1) + Vector3<double>(1e-4, 0.0, 0.0));
    ceres::Problem ceres_problem;
    AddToProblem(problem, CalibrationResiduals(problem), &problem.parameters, &ceres_problem);
    double cost = 0.0;
    ASSERT_TRUE(ceres_problem.Evaluate({}, &cost, nullptr, nullptr, nullptr));
    const double expected = CostByDefinition(problem, loss);
    EXPECT_NEAR(cost, expected, 1e-9 * expected);
    EXPECT_GT(std::abs(CostByDefinition(problem, LossKind::kNone) / expected - 1.0),
              loss == LossKind::kNone ? -1.0 : 0.1);
  }
}

TEST(NothingIsPrinted, WhereALoadFoldsTheArm) {
  Measurements rows = Rows();
  for (Shot& shot : rows.shots) {
    shot.load = "W";
    shot.wrench.force = {0.0, 0.0, -3000.0};
  }
  Robot soft = test::ArmInMemory();
  soft.compliances = {{1, {{0.0, 5e-3}}, false}};
  Experiment experiment;
  experiment.load_point = Vector3<double>::Zero();
  const CalibrationProblem problem = MakeCalibrationProblem(soft, rows, experiment);
  ParameterSet parameters = problem.parameters;
  testing::internal::CaptureStderr();
  const MinimizeSummary summary = MinimizeJointly(problem, CalibrationResiduals(problem), {}, &parameters);
  const Calibration calibration = Calibrate(problem);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_FALSE(summary.usable);
  EXPECT_EQ(calibration.estimate.status, Status::kEquilibriumDiverged);
}

TEST(NothingToWorkOn, IsRefusedWithWords) {
  EXPECT_THAT(WordsOf([] { ReadExperiment({}); }), HasSubstr("InputError no file is given"));
  EXPECT_THAT(WordsOf([] { ExtendedCalibration(Diagnosis()); }), HasSubstr("the diagnosis has no model"));
  EXPECT_THAT(WordsOf([] { LearntEstimateToJson(Diagnosis(), {}); }), HasSubstr("learnt nothing"));
  Calibration empty = Calibrated();
  empty.estimate = Estimate();
  const std::string folder = (std::filesystem::path(testing::TempDir()) / "nothing_to_write").string();
  EXPECT_THAT(WordsOf([&] { WriteCalibration(empty, folder); }), HasSubstr("the estimate is not usable"));
  EXPECT_FALSE(std::filesystem::exists(folder));
  EXPECT_THAT(WordsOf([&] { KnownFrom(empty); }), HasSubstr("the estimate is not usable"));
}

TEST(NothingToWorkOn, ATargetHasAShotAndAPose) {
  Targets targets;
  targets.rows.resize(1);
  targets.rows[0].q = Eigen::VectorXd::Zero(6);
  EXPECT_THAT(WordsOf([&] { MakeCompensationInput(Known(), targets); }), HasSubstr("1 rows and 0 shots"));
  targets = TargetsFromTable(ParseCsvTable("target,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg\na,1,2,3,4,5,6\n", "mem"),
                             Known().robot, StationOfTargets(Known()));
  const CompensationInput input = MakeCompensationInput(Known(), targets);
  EXPECT_EQ(Compensate(input, targets.rows, 1).size(), 1u);
  std::vector<Target> more(2, targets.rows[0]);
  EXPECT_THAT(WordsOf([&] { Compensate(input, more, 1); }), HasSubstr("2 targets and 1 shots"));
  Target short_one = targets.rows[0];
  short_one.q = Eigen::VectorXd::Zero(5);
  EXPECT_THAT(WordsOf([&] { Compensate(input, {short_one}, 1); }), HasSubstr("target a: 5 joint values"));
  EXPECT_THAT(WordsOf([&] { Compensate(input, {Target()}, 1); }), HasSubstr("neither a pose nor joint values"));
}

TEST(ForwardModelOfACaller, RefusesAnotherNumberOfJointValues) {
  const ForwardModel model(test::ArmInMemory());
  const std::vector<double> theta = model.NominalValues();
  for (const int count : {0, 5, 7}) {
    const ShotInput shot(Eigen::VectorXd(Eigen::VectorXd::Zero(count)));
    EXPECT_THAT(WordsOf([&] { model.FrameInBase<double>(shot, theta.data(), model.chain().FlangeFrame()); }),
                HasSubstr(std::to_string(count) + " joint values, the robot has 6 joints"));
    std::vector<PointPrediction> seen;
    EXPECT_THAT(WordsOf([&] { model.Predict(shot, theta.data(), {}, {}, {}, &seen); }), HasSubstr("the robot has 6"));
  }
}

}  // namespace
}  // namespace sagitta::linked_without_files_test

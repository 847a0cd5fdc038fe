// Options are checked once, where the library accepts them: what is out of range is an InputError that names the option
// and says what is expected, and nothing else happens.
#include <gtest/gtest.h>

#include <limits>

#include "estimator/baselines/full_pose.h"
#include "estimator/baselines/two_step.h"
#include "estimator/calibration/noise_loop.h"
#include "estimator/intervals/bootstrap.h"
#include "estimator/intervals/intervals.h"
#include "estimator/intervals/profile.h"
#include "estimator/least_squares/refit.h"
#include "estimator/sagitta.h"
#include "problems/experiment_checks.h"
#include "problems/range.h"
#include "tests/support/kr270_experiment.h"

namespace sagitta::options_test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

void ExpectRefused(const std::string& name, const std::function<void()>& call) {
  SCOPED_TRACE(name);
  try {
    call();
    ADD_FAILURE() << "nothing was refused";
  } catch (const InputError& error) {
    EXPECT_EQ(error.where().key, name);
    EXPECT_NE(std::string(error.what()).find(" is expected"), std::string::npos) << error.what();
  }
}

// Each value, put where `field` leads, is refused by the struct's check under `name`.
template <typename Options, typename Field>
void ExpectEachRefused(const std::string& name, Options good, Field Options::*field, const std::vector<double>& bad) {
  CheckOptions(good);
  ASSERT_FALSE(bad.empty());
  for (const double value : bad) {
    Options options = good;
    options.*field = static_cast<Field>(value);
    ExpectRefused(name, [&] { CheckOptions(options); });
  }
}

const std::vector<double> kNoCounts = {0, -1, std::numeric_limits<int>::min(), std::numeric_limits<int>::max()};
const std::vector<double> kNoShares = {0.0, 1.0, -0.1, 1.5, kNan, kInfinity};

PlanRequest Asked() {
  PlanRequest request;
  request.poses = 12;
  return request;
}

TEST(Range, HasItsEndsUnlessItIsOpen) {
  const Range closed{"a length", 1.0, 2.0, " m"}, open{"a share", 0.0, 1.0, "", true};
  const Range or_zero{"a sigma", 1.0, 2.0, "", false, true};
  for (const double value : {1.0, 1.5, 2.0}) EXPECT_TRUE(closed.Has(value)) << value;
  for (const double value : {0.0, 0.999, 2.001, -1.5, kNan, kInfinity, -kInfinity}) EXPECT_FALSE(closed.Has(value));
  EXPECT_TRUE(open.Has(0.5));
  for (const double value : {0.0, 1.0, kNan}) EXPECT_FALSE(open.Has(value)) << value;
  EXPECT_TRUE(or_zero.Has(0.0));
  EXPECT_FALSE(or_zero.Has(0.5));
}

TEST(Range, SaysWhatIsExpectedAndWhatIs) {
  EXPECT_EQ(allowed::kThreads.Refusal(0), "a number of threads from 1 to 1024 is expected, this is 0");
  EXPECT_EQ(allowed::kFraction.Refusal(1.5), "a fraction between 0 and 1 is expected, this is 1.5");
  EXPECT_EQ(allowed::kSigmaOrZero.Refusal(-1.0),
            "0 or a standard deviation from 1e-09 to 10 m is expected, this is below 0: -1 m");
}

TEST(Options, OutOfRangeAreRefusedByName) {
  ExpectEachRefused("CalibrateOptions.num_threads", CalibrateOptions(), &CalibrateOptions::num_threads, kNoCounts);
  ExpectEachRefused("JointOptions.num_threads", JointOptions(), &JointOptions::num_threads, kNoCounts);
  ExpectEachRefused("JointOptions.max_iterations", JointOptions(), &JointOptions::max_iterations, kNoCounts);
  ExpectEachRefused("MinimizeOptions.num_threads", MinimizeOptions(), &MinimizeOptions::num_threads, kNoCounts);
  ExpectEachRefused("MinimizeOptions.max_iterations", MinimizeOptions(), &MinimizeOptions::max_iterations, kNoCounts);
  ExpectEachRefused("SimulateOptions.sigma", SimulateOptions(), &SimulateOptions::sigma,
                    {-1e-3, 1e-300, 1e3, kNan, kInfinity});
  ExpectEachRefused("IntervalOptions.num_threads", IntervalOptions(), &IntervalOptions::num_threads, kNoCounts);
  ExpectEachRefused("BootstrapOptions.num_threads", BootstrapOptions(), &BootstrapOptions::num_threads, kNoCounts);
  ExpectEachRefused("BootstrapOptions.replicates", BootstrapOptions(), &BootstrapOptions::replicates, kNoCounts);
  ExpectEachRefused("ProfileOptions.num_threads", ProfileOptions(), &ProfileOptions::num_threads, kNoCounts);
  ExpectEachRefused("ProfileOptions.tolerance", ProfileOptions(), &ProfileOptions::tolerance, kNoShares);
  ExpectEachRefused("ProfileOptions.farthest", ProfileOptions(), &ProfileOptions::farthest, {0.0, -1.0, kNan});
  ExpectEachRefused("FullPoseOptions.weight", FullPoseOptions(), &FullPoseOptions::weight,
                    {0.0, -1.0, kNan, kInfinity});
  ExpectEachRefused("FullPoseOptions.max_iterations", FullPoseOptions(), &FullPoseOptions::max_iterations, kNoCounts);
  ExpectEachRefused("TwoStepOptions.max_iterations", TwoStepOptions(), &TwoStepOptions::max_iterations, kNoCounts);
  ExpectEachRefused("TwoStepOptions.tolerance", TwoStepOptions(), &TwoStepOptions::tolerance, kNoShares);
  RefitOptions refit;
  refit.weights = {1.0, 0.0, kNan};
  ExpectRefused("RefitOptions.weights", [&] { CheckOptions(refit); });
  ExpectEachRefused("RefitOptions.kept", RefitOptions(), &RefitOptions::kept, {-2, std::numeric_limits<int>::max()});
  FullPoseOptions poses;
  poses.reference_in_flange.y() = kNan;
  ExpectRefused("FullPoseOptions.reference_in_flange", [&] { CheckOptions(poses); });
}

TEST(Options, OfAPlanAreRefusedByName) {
  ExpectEachRefused("PlanRequest.poses", Asked(), &PlanRequest::poses, {-1, 1e9});
  ExpectEachRefused("PlanRequest.accuracy", Asked(), &PlanRequest::accuracy, {-1e-3, kNan, kInfinity});
  ExpectEachRefused("PlanRequest.model_error", Asked(), &PlanRequest::model_error, {0.0, 0.99, kNan, kInfinity});
  ExpectEachRefused("PlanRequest.field", Asked(), &PlanRequest::field, {-1e-4, kNan, kInfinity});
  ExpectEachRefused("PlanRequest.pool", Asked(), &PlanRequest::pool, kNoCounts);
  ExpectEachRefused("PlanRequest.most_poses", Asked(), &PlanRequest::most_poses, kNoCounts);
  ExpectEachRefused("PlanRequest.starts", Asked(), &PlanRequest::starts, kNoCounts);
  ExpectEachRefused("ExactOptions.starts", ExactOptions(), &ExactOptions::starts, kNoCounts);
  ExpectEachRefused("ExactOptions.rounds", ExactOptions(), &ExactOptions::rounds, kNoCounts);
  ExpectEachRefused("ExactOptions.max_trials", ExactOptions(), &ExactOptions::max_trials, kNoCounts);
  PlanRequest both = Asked();
  both.accuracy = 1e-4;
  ExpectRefused("PlanRequest.poses", [&] { CheckOptions(both); });
  ExpectRefused("PlanRequest.poses", [&] { CheckOptions(PlanRequest()); });
}

TEST(Options, OfADiagnosisAreRefusedByName) {
  const DiagnosisOptions good;
  ExpectEachRefused("DiagnosisOptions.significance", good, &DiagnosisOptions::significance, kNoShares);
  for (double PriorMasses::*mass :
       {&PriorMasses::nothing, &PriorMasses::catalogue, &PriorMasses::unnamed, &PriorMasses::further}) {
    for (const double value : kNoShares) {
      DiagnosisOptions options;
      options.prior.*mass = value;
      EXPECT_THROW(CheckOptions(options), InputError) << value;
    }
  }
  DiagnosisOptions options;
  options.prior.nothing = 0.6;  // 1.1 together
  EXPECT_THROW(CheckOptions(options), InputError);
  options = good;
  options.joint.max_iterations = 0;
  ExpectRefused("JointOptions.max_iterations", [&] { CheckOptions(options); });
}

// What each key of an experiment that was made in memory can be made wrong by.
TEST(Options, OfAnExperimentAreRefusedAtTheirKey) {
  CheckExperiment(Experiment());
  using Spoil = std::function<void(Experiment*)>;
  const std::vector<std::pair<std::string, Spoil>> cases = {
      {"noise.sigma", [](Experiment* e) { e->noise.sigma = 0.0; }},
      {"noise.sigma", [](Experiment* e) { e->noise.sigma = kNan; }},
      {"noise.sigma0", [](Experiment* e) { e->noise.sigma0 = -1e-5; }},
      {"noise.lambda", [](Experiment* e) { e->noise.lambda = 0.0; }},
      {"noise.iterations", [](Experiment* e) { e->noise.iterations = 0; }},
      {"noise.instrument.range", [](Experiment* e) { e->noise.range = -1e-6; }},
      {"noise.instrument.range_per_m", [](Experiment* e) { e->noise.range_per_m = kNan; }},
      {"noise.instrument.angle", [](Experiment* e) { e->noise.angle = 100.0; }},
      {"noise.instrument.angle_per_m", [](Experiment* e) { e->noise.angle_per_m = -1e-6; }},
      {"repeatability", [](Experiment* e) { e->repeatability.angle.common = -1e-6; }},
      {"repeatability.Z", [](Experiment* e) { e->repeatability.length.per_joint["Z"] = kInfinity; }},
      {"bootstrap.replicates", [](Experiment* e) { e->method.bootstrap.replicates = 0; }},
      {"priors.geometry/a.value",
       [](Experiment* e) {
         e->priors["geometry/a"] = {kNan, 1.0};
       }},
      {"priors.geometry/a.sigma",
       [](Experiment* e) {
         e->priors["geometry/a"] = {0.0, 0.0};
       }},
      {"validation.fraction",
       [](Experiment* e) {
         e->validation.kind = ValidationSpec::Kind::kFraction;
         e->validation.fraction = 1.0;
       }},
      {"significance", [](Experiment* e) { e->significance = 0.0; }},
      {"load_point", [](Experiment* e) { e->load_point = Vector3<double>(0.0, kNan, 0.0); }},
      {"loads.L1.mass_kg", [](Experiment* e) { e->loads["L1"].mass = -1.0; }},
      {"loads.L1.point", [](Experiment* e) { e->loads["L1"].point = Vector3<double>(1e9, 0.0, 0.0); }},
      {"tool.mass_kg", [](Experiment* e) { e->tool_mass = kNan; }},
      {"tool.com", [](Experiment* e) { e->tool_com.x() = kInfinity; }},
      {"gravity.m_per_s2", [](Experiment* e) { e->gravity = -9.8; }},
      {"gravity.direction", [](Experiment* e) { e->gravity_direction *= 2.0; }},
      {"gravity.direction", [](Experiment* e) { e->gravity_direction.x() = kNan; }},
      {"markers.P1.xyz", [](Experiment* e) { e->markers["P1"].point = Vector3<double>(kNan, 0.0, 0.0); }},
      {"markers.P1.rotvec", [](Experiment* e) { e->markers["P1"].rotvec = Vector3<double>(0.0, 0.0, kNan); }},
      {"markers.P1.spring_sigma", [](Experiment* e) { e->markers["P1"].spring_sigma = 0.0; }},
      {"stations.S1.xyz", [](Experiment* e) { e->stations["S1"].base_xyz = Vector3<double>(kNan, 0.0, 0.0); }},
      {"stations.S1.rotvec", [](Experiment* e) { e->stations["S1"].base_rotvec = Vector3<double>(kNan, 0.0, 0.0); }},
      {"stations.S1.instrument",
       [](Experiment* e) { e->stations["S1"].instrument_xyz = Vector3<double>(0.0, kInfinity, 0.0); }},
  };
  for (const auto& [key, spoil] : cases) {
    Experiment experiment;
    spoil(&experiment);
    ExpectRefused(key, [&] { CheckExperiment(experiment); });
  }
}

// The functions that accept options ask before they do anything else: of the progress nothing is heard.
TEST(Options, AreAskedAtTheDoor) {
  const test::Kr270Truth truth;
  test::Kr270Design design;
  design.stations = 1;
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(truth, design.sigma, 3, &data);
  const CalibrationProblem problem = test::Kr270ProblemOf(data, Experiment());
  const auto silent = [](const std::string& what) { ADD_FAILURE() << "already at work: " << what; };
  Estimate estimate;
  ParameterSet parameters = problem.parameters;
  const std::vector<int> rows = problem.CalibrationObservations();

  ExpectRefused("CalibrateOptions.num_threads", [&] { Calibrate(problem, {Method::kJoint, 0, 1, silent}); });
  DiagnosisOptions diagnosis;
  diagnosis.significance = 0.0;
  diagnosis.progress = silent;
  ExpectRefused("DiagnosisOptions.significance", [&] { Diagnose(problem, diagnosis); });
  PlanRequest plan = Asked();
  plan.pool = 0;
  plan.progress = silent;
  ExpectRefused("PlanRequest.pool", [&] { MakePlan(problem.robot(), data, Experiment(), plan); });
  JointOptions joint;
  joint.max_iterations = 0;
  joint.progress = silent;
  ExpectRefused("JointOptions.max_iterations", [&] { EstimateJointly(problem, joint); });
  ExpectRefused("JointOptions.max_iterations", [&] { EstimateFrom(problem, parameters, joint); });
  ExpectRefused("JointOptions.max_iterations", [&] { EstimateWithNoise(problem, joint); });
  MinimizeOptions minimize;
  minimize.num_threads = 0;
  ExpectRefused("MinimizeOptions.num_threads",
                [&] { MinimizeJointly(problem, CalibrationResiduals(problem), minimize, &parameters); });
  RefitOptions refit;
  refit.weights.assign(rows.size(), -1.0);
  ExpectRefused("RefitOptions.weights", [&] { RefitFrom(problem, parameters, refit); });
  FullPoseOptions poses;
  poses.weight = 0.0;
  ExpectRefused("FullPoseOptions.weight", [&] { EstimateFromFullPoses(problem, poses); });
  TwoStepOptions two;
  two.tolerance = 0.0;
  two.progress = silent;
  ExpectRefused("TwoStepOptions.tolerance", [&] { EstimateInTwoSteps(problem, two); });
  ExpectRefused("IntervalOptions.num_threads", [&] { AddIntervals(problem, {0, silent}, &estimate); });
  BootstrapOptions bootstrap;
  bootstrap.replicates = 1;
  bootstrap.progress = silent;
  ExpectRefused("BootstrapOptions.replicates", [&] { BootstrapIntervals(problem, bootstrap, &estimate); });
  ProfileOptions profile;
  profile.tolerance = 0.0;
  ExpectRefused("ProfileOptions.tolerance", [&] { ProfileIntervals(problem, profile, &estimate); });
  ExactOptions exact;
  exact.starts = 0;
  ExpectRefused("ExactOptions.starts", [&] { SolveExact({}, {}, {}, 3, {}, exact); });
  ExpectRefused("SimulateOptions.sigma", [&] { Simulate(KnownRobot(), data, Experiment(), {-1.0, 1}); });
}

TEST(Options, OfTheExperimentAreAskedAtEachDoor) {
  test::Kr270Design design;
  design.stations = 1;
  const Measurements data = test::DesignMeasurements(design);
  Experiment experiment;
  experiment.significance = 2.0;
  Robot robot;
  robot.chain = test::Kr270Chain();
  ExpectRefused("significance", [&] { MakeCalibrationProblem(robot, data, experiment); });
  ExpectRefused("significance", [&] { MakePlan(robot, data, experiment, Asked()); });
  ExpectRefused("significance", [&] { Simulate(KnownRobot(), data, experiment); });
}

TEST(Options, ThreadsOfCompensationAreAskedAtTheDoor) {
  const CalibrationProblem problem = test::Kr270Problem(test::Kr270Design(), test::Kr270Truth(), 3);
  const CompensationInput input{problem, problem.robot().chain, {}};
  for (const int threads : {0, -1, 1 << 20}) {
    ExpectRefused("threads", [&] { Compensate(input, {}, threads); });
  }
}

}  // namespace
}  // namespace sagitta::options_test

// What the estimator costs, as ratios to the forward kinematics of the same arm in the same run: Google Benchmark's
// rows, and with --benchmark_format=json what tests/benchmarks/run turns into BENCHMARKS.md.
#include <benchmark/benchmark.h>
#include <ceres/solver.h>
#include <hwy/targets.h>
#include <malloc.h>

#include <array>
#include <random>

#include "estimator/baselines/two_step.h"
#include "estimator/calibration/joint_estimator.h"
#include "estimator/least_squares/batch_algebra.h"
#include "estimator/least_squares/bounded_step.h"
#include "estimator/least_squares/condensed_cost.h"
#include "estimator/least_squares/parallel.h"
#include "estimator/least_squares/refit.h"
#include "estimator/least_squares/sandwich.h"
#include "problems/io/measurement_file.h"
#include "problems/text.h"
#include "tests/benchmarks/loaded_arm.h"
#include "tools/heap.h"

namespace sagitta::benchmarks {
namespace {

struct Setup {
  explicit Setup(int configurations, double repeatability = 0.0)
      : problem(LoadedArm(configurations, repeatability)),
        rows(CalibrationResiduals(problem)),
        start(problem.parameters) {
    AlignNominal(problem, &start);
    for (const int i : HeldAtStart()) start.coordinate(i).held = true;
    columns = start.EstimatedCoordinates();
  }
  // What an estimate of these data holds; the comparisons solve for the same unknowns.
  std::vector<int> HeldAtStart() const {
    const Estimate estimate = EstimateFrom(problem, start);
    std::vector<int> held;
    for (int i = 0; i < start.num_coordinates(); ++i) {
      if (estimate.parameters.coordinates()[i].held) held.push_back(i);
    }
    return held;
  }

  CalibrationProblem problem;
  ResidualSelection rows;
  ParameterSet start;
  std::vector<int> columns;
};

const Setup& SetupOf(int configurations, bool deviate = false) {
  static std::map<std::pair<int, bool>, std::unique_ptr<Setup>> known;
  std::unique_ptr<Setup>& setup = known[{configurations, deviate}];
  if (!setup) setup = std::make_unique<Setup>(configurations, deviate ? 40e-6 : 0.0);
  return *setup;
}

// By malloc, of the heap and of mapped pages.
size_t BytesAllocated() {
  const struct mallinfo2 all = mallinfo2();
  return all.uordblks + all.hblkhd;
}

void PerConfiguration(benchmark::State& state, const Setup& setup) {
  state.counters["configurations"] = static_cast<double>(setup.problem.data().configurations.size());
  state.counters["unknowns"] = static_cast<double>(setup.columns.size());
}

// T_FK: kinematics, deflection to first order and three points, scalar code.
void ForwardKinematics(benchmark::State& state) {
  const Setup& setup = SetupOf(1000);
  const Chain& chain = setup.problem.model().chain();
  const std::vector<double> theta = setup.start.ModelValues();
  const Pose<double> base = setup.start.BaseInStation(0);
  ChainState<double> pose;
  size_t s = 0;
  std::vector<std::vector<double>> values;
  for (const ShotInput& shot : setup.problem.shot_inputs()) {
    values.push_back(setup.problem.model().TransformValues(shot, theta.data()));
  }
  for (auto _ : state) {
    s = (s + 1) % values.size();
    const ShotInput& shot = setup.problem.shot_inputs()[s];
    EvaluateChain(chain, values[s].data(), &pose);
    for (const ElasticTerm& term : shot.terms.elastic) {
      double torque = 0.0;
      for (const AppliedWrench& w : shot.wrenches) {
        torque += GeneralisedForce(chain, pose, term.transform, ToBase(w, pose, base.rotation));
      }
      benchmark::DoNotOptimize(torque);
    }
    for (int m = 0; m < 3; ++m) {
      const Vector3<double> point = base * (pose.frames.back() * setup.start.MarkerPoint(m));
      benchmark::DoNotOptimize(point.data());
    }
  }
}
BENCHMARK(ForwardKinematics);

extern "C" void dgemm_(const char*, const char*, const int*, const int*, const int*, const double*, const double*,
                       const int*, const double*, const int*, const double*, double*, const int*);

// The rate of the machine's BLAS on the product that sums of rows are: J'J of 57 columns, 1152 rows at a time.
void MachineDgemm(benchmark::State& state) {
  const int columns = 57, rows = 1152;
  const Eigen::MatrixXd j = Eigen::MatrixXd::Random(rows, columns);
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(columns, columns);
  const double one = 1.0;
  for (auto _ : state) {
    dgemm_("T", "N", &columns, &columns, &rows, &one, j.data(), &rows, j.data(), &rows, &one, product.data(), &columns);
    benchmark::DoNotOptimize(product.data());
  }
  state.counters["flops"] =
      benchmark::Counter(2.0 * rows * columns * columns, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(MachineDgemm);

// The same sums by ours, the upper half only; flops counted as dgemm's.
void SumsOfRows(benchmark::State& state) {
  Linearization rows;
  rows.jacobian = Eigen::MatrixXd::Random(1152, 56);
  rows.residual = Eigen::VectorXd::Random(1152);
  for (auto _ : state) benchmark::DoNotOptimize(SumRows(rows).matrix.data());
  state.counters["flops"] = benchmark::Counter(2.0 * 1152 * 57 * 57, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(SumsOfRows);

void RowsByModel(benchmark::State& state) {
  const Setup& setup = SetupOf(1000);
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        LinearizeByModel(setup.problem, setup.start, setup.rows.observations, setup.columns, setup.rows.noise));
  }
  PerConfiguration(state, setup);
}
BENCHMARK(RowsByModel)->Unit(benchmark::kMillisecond);

// With the instructions that every machine of this kind has, or with the best of this one.
void BatchedRows(benchmark::State& state) {
  if (state.range(0) != 0) hwy::SetSupportedTargetsForTest(HWY_STATIC_TARGET);
  hwy::GetChosenTarget().DeInit();
  const Setup& setup = SetupOf(1000);
  const RowBatches batches(setup.problem, setup.rows.observations, setup.rows.noise, LatentTreatment::kIgnore);
  const RowBatches::Request request(batches, setup.start, setup.columns);
  BatchScratch scratch;
  BatchBuffer buffer;
  for (auto _ : state) {
    for (int g = 0; g < batches.num_groups(); ++g) {
      double* const rows =
          buffer.Reserve(static_cast<size_t>(batches.rows_of_unit(g)) * request.columns(g).columns * kBatchLanes);
      for (int b = 0; b < batches.num_batches(g); ++b) {
        benchmark::DoNotOptimize(batches.Evaluate(request, g, b, &scratch, rows));
      }
    }
  }
  state.SetLabel(BatchInstructions());
  PerConfiguration(state, setup);
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().DeInit();
}
BENCHMARK(BatchedRows)->ArgNames({"plain_instructions"})->Args({0})->Args({1})->Unit(benchmark::kMicrosecond);

// Rows and sums.
void NormalEquationsPass(benchmark::State& state) {
  const Setup& setup = SetupOf(static_cast<int>(state.range(0)), state.range(2) != 0);
  const size_t held_before = BytesAllocated();
  const NormalEquations equations(setup.problem, setup.rows.observations, setup.rows.noise,
                                  LatentTreatment::kMarginalise, static_cast<int>(state.range(1)));
  std::array<ParameterSet, 3> in_turn = {setup.start, setup.start, setup.start};  // the sums of two values are kept
  for (size_t k = 1; k < in_turn.size(); ++k) {
    in_turn[k].SetMarkerPoint(0, setup.start.MarkerPoint(0) + Vector3<double>::Constant(1e-9 * static_cast<double>(k)));
  }
  size_t pass = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(equations.Sum(in_turn[pass++ % in_turn.size()], setup.columns).matrix.data());
  }
  PerConfiguration(state, setup);
  state.counters["bytes_held"] = static_cast<double>(BytesAllocated() - held_before);
}
BENCHMARK(NormalEquationsPass)
    ->ArgNames({"configurations", "threads", "joints_deviate"})
    ->Args({18, 1, 0})
    ->Args({1000, 1, 0})
    ->Args({10000, 1, 0})
    ->Args({10000, 2, 0})
    ->Args({10000, 1, 1})
    ->Args({100000, 1, 1})
    ->Args({100000, 1, 0})
    ->Args({100000, 2, 0})
    ->UseRealTime()
    ->Unit(benchmark::kMicrosecond);

// The deviations of the visits.
std::shared_ptr<ceres::ParameterBlockOrdering> EliminateFirst(LatentBlocks& latents, const ceres::Problem& problem) {
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (std::vector<double>& block : latents) ordering->AddElementToGroup(block.data(), 0);
  std::vector<double*> blocks;
  problem.GetParameterBlocks(&blocks);
  for (double* block : blocks) {
    if (!ordering->IsMember(block)) ordering->AddElementToGroup(block, 1);
  }
  return ordering;
}

enum Way { kJets, kAnalytic, kCondensedWay, kSchur, kWholeEstimate, kTwoSteps, kEliminated };

// Condensed for exact joints, then Gauss-Newton on rows from which the joints' deviations are eliminated, as
// EstimateFrom does it: from the same start as a bundle adjustment by Ceres' Schur complement, and as near to the
// optimum.
int SolveEliminated(const Setup& setup, ParameterSet* parameters) {
  constexpr double kThere = 3e-3;  // standard deviations: what function_tolerance leaves of a thousand configurations
  const NormalEquations exact(setup.problem, setup.rows.observations, setup.rows.noise, LatentTreatment::kIgnore, 1);
  int iterations = MinimizeSums(exact, MinimizeOptions(), parameters).iterations;
  const NormalEquations equations(setup.problem, setup.rows.observations, setup.rows.noise,
                                  LatentTreatment::kMarginalise, 1);
  for (double left = 1.0; left > kThere && iterations < 50; ++iterations) {
    const LinearSolution solution = SolveLinearization(Condense(equations.Sum(*parameters, setup.columns)));
    left = solution.step.cwiseQuotient(solution.covariance.diagonal().cwiseSqrt()).cwiseAbs().maxCoeff();
    Move(setup.columns, solution.step, 1.0, parameters);
  }
  return iterations;
}

void Solve(benchmark::State& state) {
  const auto way = static_cast<Way>(state.range(1));
  const bool deviate = state.range(2) != 0;
  const Setup& setup = SetupOf(static_cast<int>(state.range(0)), deviate);
  int iterations = 0;
  for (auto _ : state) {
    ParameterSet parameters = setup.start;
    if (way == kWholeEstimate) {
      JointOptions options;
      options.judge = false;
      iterations = EstimateFrom(setup.problem, parameters, options).iterations;
      continue;
    }
    if (way == kEliminated) {
      iterations = SolveEliminated(setup, &parameters);
      continue;
    }
    if (way == kTwoSteps) {
      CalibrationProblem problem = setup.problem;
      problem.parameters = setup.start;
      iterations = static_cast<int>(EstimateInTwoSteps(problem).steps.size());
      continue;
    }
    ceres::Problem::Options problem_options;
    problem_options.disable_all_safety_checks = true;
    ceres::Problem problem(problem_options);
    ceres::Solver::Options options;
    options.logging_type = ceres::SILENT;
    options.initial_trust_region_radius = 1e12;
    options.function_tolerance = 1e-9;
    options.linear_solver_type = ceres::DENSE_QR;
    std::unique_ptr<NormalEquations> equations;
    LatentBlocks latents;
    if (way == kCondensedWay) {
      equations = std::make_unique<NormalEquations>(setup.problem, setup.rows.observations, setup.rows.noise,
                                                    LatentTreatment::kIgnore, 1);
      AddCondensed(*equations, &parameters, &problem);
    } else if (way == kJets) {
      AddJets(setup.problem, setup.rows, &parameters, &problem);
      options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    } else {
      AddToProblem(setup.problem, setup.rows, &parameters, &problem, way == kSchur ? &latents : nullptr);
      options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
    }
    if (way == kSchur) {
      options.linear_solver_type = ceres::DENSE_SCHUR;
      options.linear_solver_ordering = EliminateFirst(latents, problem);
    }
    RemoveBounds(parameters, &problem);  // as the estimator does where none is met: Ceres would search along every step
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    iterations = static_cast<int>(summary.iterations.size()) - 1;
  }
  state.counters["iterations"] = iterations;
  PerConfiguration(state, setup);
}
BENCHMARK(Solve)
    ->ArgNames({"configurations", "way", "joints_deviate"})
    ->Args({18, kJets, 0})
    ->Args({18, kAnalytic, 0})
    ->Args({18, kCondensedWay, 0})
    ->Args({18, kWholeEstimate, 0})
    ->Args({18, kTwoSteps, 0})
    ->Args({1000, kJets, 0})
    ->Args({1000, kAnalytic, 0})
    ->Args({1000, kCondensedWay, 0})
    ->Args({1000, kWholeEstimate, 0})
    ->Args({1000, kTwoSteps, 0})
    ->Args({10000, kJets, 0})
    ->Args({10000, kAnalytic, 0})
    ->Args({10000, kCondensedWay, 0})
    ->Args({10000, kWholeEstimate, 0})
    ->Args({33333, kCondensedWay, 0})
    ->Args({100000, kJets, 0})
    ->Args({100000, kAnalytic, 0})
    ->Args({100000, kCondensedWay, 0})
    ->Args({1000, kSchur, 1})
    ->Args({1000, kEliminated, 1})
    ->Args({1000, kWholeEstimate, 1})
    ->Args({10000, kSchur, 1})
    ->Args({10000, kEliminated, 1})
    ->Args({10000, kWholeEstimate, 1})
    ->Args({100000, kSchur, 1})
    ->Args({100000, kEliminated, 1})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

enum Factors { kSums, kDenseQr, kDenseNormal, kSparseNormal, kDenseSchur, kSparseSchur };

// Four iterations of the joint solve where many stations hardly meet; the last two estimate the joints' deviations
// along.
void ManyStations(benchmark::State& state) {
  const auto factors = static_cast<Factors>(state.range(1));
  const bool deviate = factors >= kDenseSchur;
  const CalibrationProblem problem = LoadedArm(400, deviate ? 40e-6 : 0.0, static_cast<int>(state.range(0)));
  const ResidualSelection rows = CalibrationResiduals(problem);
  const NormalEquations equations(problem, rows.observations, rows.noise, LatentTreatment::kIgnore, 1);
  constexpr ceres::LinearSolverType kTypes[] = {
      ceres::DENSE_QR,    ceres::DENSE_QR,    ceres::DENSE_NORMAL_CHOLESKY, ceres::SPARSE_NORMAL_CHOLESKY,
      ceres::DENSE_SCHUR, ceres::SPARSE_SCHUR};
  for (auto _ : state) {
    ParameterSet parameters = problem.parameters;
    ceres::Problem::Options problem_options;
    problem_options.disable_all_safety_checks = true;
    ceres::Problem ceres_problem(problem_options);
    LatentBlocks latents;
    if (factors == kSums) AddCondensed(equations, &parameters, &ceres_problem);
    if (factors != kSums) AddToProblem(problem, rows, &parameters, &ceres_problem, deviate ? &latents : nullptr);
    ceres::Solver::Options options;
    options.logging_type = ceres::SILENT;
    options.max_num_iterations = 4;
    options.linear_solver_type = kTypes[factors];
    if (deviate) options.linear_solver_ordering = EliminateFirst(latents, ceres_problem);
    ceres::Solver::Summary summary;
    ceres::Solve(options, &ceres_problem, &summary);
  }
  state.counters["unknowns"] = static_cast<double>(problem.parameters.EstimatedCoordinates().size());
}
BENCHMARK(ManyStations)
    ->ArgNames({"stations", "factors"})
    ->ArgsProduct({{2, 10, 20, 30, 100}, {kSums, kDenseQr, kDenseNormal, kSparseNormal, kDenseSchur, kSparseSchur}})
    ->Unit(benchmark::kMillisecond);

void CovarianceFromSums(benchmark::State& state) {
  const Setup& setup = SetupOf(1000);
  const NormalEquations equations(setup.problem, setup.rows.observations, setup.rows.noise,
                                  LatentTreatment::kMarginalise, 1);
  const NormalSums sums = equations.Sum(setup.start, setup.columns);
  for (auto _ : state) benchmark::DoNotOptimize(SolveLinearization(Condense(sums)).covariance.data());
}
BENCHMARK(CovarianceFromSums)->Unit(benchmark::kMicrosecond);

// Full nonlinear refits of 18 configurations, each of other noise.
void MonteCarlo(benchmark::State& state) {
  constexpr int kDraws = 999;  // as a bootstrap has them: of few, the start of a thread and the last draw show
  const Setup& setup = SetupOf(18);
  ParameterSet optimum = setup.start;
  SolveEliminated(setup, &optimum);
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise(0.0, 5e-5);
  std::vector<CalibrationProblem> draws(kDraws, setup.problem);
  for (CalibrationProblem& draw : draws) {
    for (Observation& row : draw.mutable_data()->observations) {
      for (double& number : row.point_in_station) number += noise(random);
    }
  }
  for (auto _ : state) {
    ParallelFor(kDraws, static_cast<int>(state.range(0)),
                [&](int i, int) { benchmark::DoNotOptimize(RefitFrom(draws[i], optimum).chi2); });
  }
  state.counters["solves"] = kDraws;
  state.counters["configurations"] = 18.0 * kDraws;
}
BENCHMARK(MonteCarlo)->ArgNames({"threads"})->Args({1})->Args({2})->UseRealTime()->Unit(benchmark::kMillisecond);

// A measurement file of 30,000 rows and 16 columns from text to configurations, shots and observations.
void Reading(benchmark::State& state) {
  const CalibrationProblem& problem = SetupOf(10000).problem;
  std::string text =
      "config,marker,station,load,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,fx_N,fy_N,fz_N,x_mm,y_mm,z_mm\n";
  for (const Observation& row : problem.data().observations) {
    const Shot& shot = problem.data().shots[row.shot];
    const Configuration& configuration = problem.data().configurations[shot.configuration];
    text += configuration.id + "," + problem.data().markers[row.marker] + "," + problem.data().stations[shot.station] +
            "," + shot.load;
    for (const double q : configuration.q) text += "," + FormatNumber(1e-4 * std::round(1e4 * q * 180.0 / M_PI));
    for (const double f : shot.wrench.force) text += "," + FormatNumber(f);
    for (const double x : row.point_in_station) text += "," + FormatNumber(1e-4 * std::round(1e7 * x));
    text += "\n";
  }
  for (auto _ : state) {
    benchmark::DoNotOptimize(ReadMeasurementsText(problem.robot(), text, "rows").observations.data());
  }
  state.counters["bytes"] =
      benchmark::Counter(static_cast<double>(text.size()), benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(Reading)->Unit(benchmark::kMillisecond);

void Sandwich(benchmark::State& state) {
  const Setup& setup = SetupOf(1000);
  const Linearization fit =
      Linearize(setup.problem, setup.start, setup.rows.observations, setup.columns, setup.rows.noise);
  const std::vector<int> clusters = ConfigurationClusters(setup.problem.data(), setup.rows.observations);
  for (auto _ : state) benchmark::DoNotOptimize(SandwichCovariance(fit, clusters).covariance.data());
  PerConfiguration(state, setup);
}
BENCHMARK(Sandwich)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace sagitta::benchmarks

int main(int argc, char** argv) {
  sagitta::PrepareHeap();  // as the program has its memory
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}

// The number of threads does not show in any digit of a calibration, and what is made on several threads is used in its
// order.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <nlohmann/json.hpp>
#include <numeric>
#include <thread>

#include "estimator/least_squares/parallel.h"
#include "estimator/least_squares/row_sums.h"
#include "estimator/results/residuals_csv.h"
#include "estimator/sagitta.h"
#include "problems/interruption.h"
#include "tests/support/kr270_experiment.h"
#include "tests/support/kr270_poses.h"
#include "tests/support/loaded_kr270.h"

namespace sagitta::threads_test {
namespace {

CalibrationProblem Rigid(int configurations) {
  test::Kr270Design design;
  design.configurations = configurations;
  return test::Kr270Problem(design, test::Kr270Truth(), 11);
}

// Several shots of each configuration. change: of the experiment.
CalibrationProblem Loaded(int configurations, const std::function<void(Experiment*)>& change) {
  const test::LoadedTruth truth = test::Everything();
  test::LoadedDesign design = test::WithPulls();
  design.configurations = configurations;
  Measurements data = test::LoadedRows(design, truth);
  test::Measure(test::ExactPoints(truth, data), design.sigma, 5, &data);
  test::LoadedSetup setup = test::SetupFor(truth);
  change(&setup.experiment);
  return MakeCalibrationProblem(setup.robot, data, setup.experiment);
}

void HoldSomeOut(Experiment* experiment) {
  experiment->validation.kind = ValidationSpec::Kind::kFraction;
  experiment->validation.fraction = 0.2;
}

struct NamedProblem {
  const char* name;
  bool are_held;  // its rows: they are few
  CalibrationProblem (*make)();
};

const NamedProblem kProblems[] = {
    {"Few", true, [] { return Rigid(18); }},
    {"ManyConfigurations", false, [] { return Rigid(7500); }},
    {"ManyShots", false, [] { return Loaded(2500, [](Experiment*) {}); }},
    {"ManyHeldOut", false, [] { return Loaded(3000, HoldSomeOut); }},
    {"ManyThatDeviate", false,
     [] { return Loaded(2500, [](Experiment* experiment) { experiment->repeatability.angle.common = 40e-6; }); }}};

class ThreadsOf : public testing::TestWithParam<NamedProblem> {};

INSTANTIATE_TEST_SUITE_P(Every, ThreadsOf, testing::ValuesIn(kProblems),
                         [](const auto& which) { return std::string(which.param.name); });

TEST_P(ThreadsOf, DoNotShowInACalibration) {
  const CalibrationProblem problem = GetParam().make();
  const auto texts = [&](int threads) {
    CalibrateOptions options;
    options.num_threads = threads;
    Calibration found = Calibrate(problem, options);
    EXPECT_TRUE(IsUsable(found.estimate.status));
    const auto rows = 3.0 * static_cast<double>(problem.CalibrationObservations().size());
    EXPECT_EQ(AreHeld(rows, static_cast<double>(found.estimate.estimated.size())), GetParam().are_held);
    found.estimate.seconds = 0.0;
    std::string residuals;
    ResidualsToCsv(
        found.problem, found.estimate, [&](const std::string& piece) { residuals += piece; }, threads);
    return std::pair(CalibrationToJson(found, {}).dump(), residuals);
  };
  const auto [json, residuals] = texts(1);
  for (const int threads : {2, 3}) {
    const auto [other_json, other_residuals] = texts(threads);
    EXPECT_EQ(json, other_json) << threads;
    EXPECT_TRUE(residuals == other_residuals) << threads;
  }
}

// How many of n have been worked on, by as many threads at most; each waits until all of them have begun.
int WorkedOn(int n, int threads) {
  std::atomic<int> begun{0}, done{0};
  std::vector<int> of_worker(static_cast<size_t>(threads), 0);
  ParallelFor(n, threads, [&](int, int worker) {
    if (of_worker[worker]++ == 0) ++begun;
    while (begun < std::min(n, threads)) std::this_thread::yield();
    ++done;
  });
  return done;
}

// Helpers are those of earlier calls, with work of their own each time, also inside the work of one of them.
TEST(ParallelFor, HasItsThreadsCallAfterCall) {
  for (int i = 0; i < 200; ++i) EXPECT_EQ(WorkedOn(1 + i % 7, 1 + i % 5), 1 + i % 7);
  std::atomic<int> sum{0};
  ParallelFor(3, 3, [&](int, int) { sum += WorkedOn(4, 3); });
  EXPECT_EQ(sum, 12);
  std::thread other([&sum] { sum += WorkedOn(100, 2); });
  sum += WorkedOn(100, 2);
  other.join();
  EXPECT_EQ(sum, 212);
}

// A process that is forked has no threads but its own.
TEST(ParallelFor, WorksInAForkedProcess) {
  EXPECT_EQ(WorkedOn(3, 3), 3);
  const pid_t child = fork();
  if (child == 0) {
    alarm(60);
    _exit(WorkedOn(3, 3));
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 3) << status;
}

TEST(MakeAndUse, EveryUserHasAllInTheirOrder) {
  for (const int threads : {1, 2, 5}) {
    constexpr int kCount = 500, kSlots = 7;
    std::vector<int> made(kSlots, -1), times(kCount, 0);
    std::vector<std::vector<int>> used(static_cast<size_t>(threads));
    MakeAndUse(
        kCount, threads, kSlots,
        [&](int i, int slot) {
          ++times[i];
          made[slot] = i;
        },
        [&](int slot, int user) { used[user].push_back(made[slot]); });
    std::vector<int> all(kCount);
    std::iota(all.begin(), all.end(), 0);
    EXPECT_EQ(times, std::vector<int>(kCount, 1));
    for (const std::vector<int>& own : used) EXPECT_EQ(own, all);
  }
  MakeAndUse(
      0, 2, 3, [](int, int) { FAIL(); }, [](int, int) { FAIL(); });
}

// Nobody waits for who has thrown, whether it made or used.
TEST(MakeAndUse, HandsOnWhatIsThrown) {
  const auto run = [](int bad_to_make, int bad_to_use) {
    std::vector<int> made(4);
    MakeAndUse(
        50, 3, 4,
        [&](int i, int slot) {
          if (i == bad_to_make) throw std::runtime_error("made");
          made[slot] = i;
        },
        [&](int slot, int user) {
          if (user == 1 && made[slot] == bad_to_use) throw std::runtime_error("used");
        });
  };
  EXPECT_THROW(run(20, -1), std::runtime_error);
  EXPECT_THROW(run(-1, 20), std::runtime_error);
}

TEST(MakeAndUse, EndsWhereItIsInterrupted) {
  for (const int threads : {1, 3}) {
    std::atomic<bool> stop{false};
    const Interruptible scope(&stop);
    std::atomic<int> made{0};
    const auto make = [&](int, int) {
      if (++made == 20) stop = true;
    };
    EXPECT_THROW(MakeAndUse(1000, threads, 4, make, [](int, int) {}), Interruption);
    EXPECT_LT(made, 30);
  }
}

}  // namespace
}  // namespace sagitta::threads_test

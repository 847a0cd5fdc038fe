// Robots that only need calibration and are refused all the same: none is wanted.
//
//   sagitta_plausibility_study [robots=200] [first seed=0]
//
// Each error of an arm drawn up to 5 mm and 1 deg (UR5, UR10, Puma 560, iiwa in turn), 30 configurations of one marker,
// of every fourth robot one row half a metre off; then the measured robots next to the tree (../shared/data).
#include <cstdio>
#include <cstdlib>

#include "estimator/inspection/reading_lint.h"
#include "tests/support/judged.h"
#include "tests/support/measured_arms.h"
#include "tests/support/real_data.h"

int main(int argc, char** argv) {
  using namespace sagitta;  // NOLINT: a program of one page
  const int robots = argc > 1 ? std::atoi(argv[1]) : 200;
  const int first = argc > 2 ? std::atoi(argv[2]) : 0;
  int refused = 0;
  for (int seed = first; seed < first + robots; ++seed) {
    const Plausibility found = test::CheckPlausible(test::ArmWithLargeErrors(seed));
    if (found.plausible) continue;
    ++refused;
    std::printf("seed %d: %s\n", seed, found.finding.words.c_str());
  }
  std::printf("simulated robots refused: %d of %d\n", refused, robots);
  if (!test::HasRealData()) return refused > 0;
  int real = 0;
  for (const auto& [folder, file] : {std::pair<const char*, const char*>{"ur5_gts3800", "measurements.csv"},
                                     {"ur10_leica", "series_A.csv"},
                                     {"ur10_leica", "series_B.csv"},
                                     {"ur10_leica", "series_C.csv"},
                                     {"ur10_leica", "series_D.csv"}}) {
    real += !test::CheckPlausible(test::RealProblem(folder, {file}, Experiment())).plausible;
  }
  std::printf("measured series refused: %d of 5\n", real);
  return refused + real > 0;
}

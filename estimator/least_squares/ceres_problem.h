// Our residuals and parameter blocks in a ceres::Problem, ours or somebody
// else's: estimators of other kinds mix laser-tracker markers with their own
// costs this way.
#pragma once

#include <ceres/problem.h>

#include <vector>

#include "estimator/least_squares/rotation_manifold.h"
#include "problems/calibration_problem.h"

namespace sagitta {

enum class CostGranularity {
  kShot,    // one cost per shot, kinematics shared by its markers (default)
  kMarker,  // one cost per marker: the reference and public building block
};

// Which readings become residuals, and how they are whitened.
struct ResidualSelection {
  std::vector<int> observations;  // indices into Measurements::observations
  NoiseRoots noise;               // one per observation, m
  CostGranularity granularity = CostGranularity::kShot;
  // Of the whitened distance of each marker (noise/robust.h): with one every reading is a cost of its own, whatever the
  // granularity.
  LossKind loss = LossKind::kNone;
  double deviation_factor = 1.0;  // of the standard deviations of the joints' deviations
};

// All calibration observations as the problem weighs them, with its loss, for a solve of one's own:
//
//   a noise is stated, or was found per row   that, and where Calibrate found it to be larger, that factor too, of the
//                                             joints' deviations as well
//   none is stated                            the common standard deviation that Calibrate found; of a problem that was
//                                             not calibrated `fallback` (m)
//   weights other than the noise's            these: ceres::Covariance then is no covariance of the estimate
ResidualSelection CalibrationResiduals(const CalibrationProblem& problem, double fallback = 1e-3);

// The same as the fits of this library begin with: they find noise and loss again.
ResidualSelection FittedResiduals(const CalibrationProblem& problem, double fallback = 1e-3);

// Latent joint deviations: one block of latent.size() values per visit.
using LatentBlocks = std::vector<std::vector<double>>;

// Adds residuals and parameter blocks. The blocks are the memory of
// `parameters` (ParameterBlock::values), which must outlive the solve; station
// rotations are quaternions x y z w on a RotationManifold. Coordinates that
// are not estimated (fixed or held) are held constant: their blocks are in the problem whether or not a selected row
// reads them, so that costs of one's own may read them all. A block that is estimated and that no selected row reads is
// added by the first cost that does; if it is a rotation, that cost's owner gives it a RotationManifold. Where the
// problem states
// a repeatability, `latents` receives one block per visit, each with its prior;
// eliminate these first (bundle adjustment). Null: joints are assumed to be exact.
// `problem` and `latents` must outlive `ceres_problem`.
//
// Several selections of one set, such as one per station with a loss each, are added by several calls: no observation
// twice, and `latents` the same each time. Priors, and the tie of markers to a spring, belong to the set and not to the
// selection: each is in the problem once.
//
// Throws std::invalid_argument where a selected observation is not there, has no noise, the blocks are not those of
// `problem`, or `latents` is another than that of the calls before.
void AddToProblem(const CalibrationProblem& problem, const ResidualSelection& selection, ParameterSet* parameters,
                  ceres::Problem* ceres_problem, LatentBlocks* latents = nullptr);

}  // namespace sagitta

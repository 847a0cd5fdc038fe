// Corrected joint values for targets: the whole estimated model (geometry, loads, compensator, compliances, effects,
// coupling; deflections at equilibrium) put on the pose at which the controller's nominal, rigid model believes the
// flange to be. Paper 002 corrects joints by one linear step; here the step is repeated until the flange is there.
//
//   q_cmd:  FK_estimated(q_cmd, load) = target           from the nominal solution, on its branch
//   x_cmd = FK_nominal(q_cmd)                            what to type in where the controller keeps its nominal model
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "estimator/compensation/flange_of_markers.h"
#include "estimator/compensation/flange_solver.h"
#include "estimator/intervals/prediction.h"
#include "problems/calibration_problem.h"
#include "problems/io/target_file.h"

namespace sagitta {

struct CompensationInput {
  CalibrationProblem problem;        // the estimated robot; one shot per target
  Chain nominal;                     // what the controller computes with: rigid, without errors
  ParameterUncertainty uncertainty;  // of the estimate, with its model error
  double rest = 0.0;                 // m, RMS distance: what is left on points that were not fitted (AddedByRest)
  double noise_dof = 0.0;            // where the residuals gave the noise, or scaled it; 0: it is stated
  FlangeOfMarkers flange = {};       // by the names of `uncertainty`
};

// A target with the joint values that reach it, and what is left.
struct CompensatedTarget {
  FlangeSolution solution;       // by the estimated model
  Pose<double> commanded;        // flange_in_base of the nominal model at solution.q
  double before_position = 0.0;  // m: off target where the nominal model has it, without compensation
  double before_rotation = 0.0;  // rad
  // The flange's distance from the target in 95 % of cases: what is left, and the covariance of the estimate; NaN: not
  // known.
  double u95_position = 0.0;  // m
  double u95_rotation = 0.0;  // rad
  std::string words;          // what there is to say of it; "" where all is well
};

// One per target, in their order. What comes out does not depend on `threads`. progress hears now and then how many
// targets are done, from one thread at a time. Throws InputError for a number of threads out of its range, for more
// targets than the input has shots, and for a target without pose and joint values, with another number of these, or
// with a pose that is none. An arm that its load folds is the target's status.
std::vector<CompensatedTarget> Compensate(const CompensationInput& input, const std::vector<Target>& targets,
                                          int threads, const std::function<void(size_t done)>& progress = {});

// 95 % of a normal vector of this mean and covariance are no longer than that: |x|^2 is approximated by g chi^2_h with
// its mean and variance, g h = tr C + m'm, 2 g^2 h = 2 tr C^2 + 4 m'C m (Satterthwaite 1946; Box 1954). Where C was
// found from residuals with n = noise_dof degrees of freedom, C is multiplied by F_{k,n} / F_{k,inf} with
// k = (tr C)^2 / tr C^2: without a mean that is tr C F_{k,n}. 0: it is known.
double Radius95(const Matrix3<double>& covariance, const Vector3<double>& mean = Vector3<double>::Zero(),
                double noise_dof = 0.0);

}  // namespace sagitta

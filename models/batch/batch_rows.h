// Residuals and derivatives of kBatchLanes shots of one structure, side by side in vector registers.
//
// The same mathematics as ForwardModel::Predict, arranged for many shots at once:
//
//   equilibrium   Newton on u = f(u), each lane until its own step is below 1e-8; where the first step is wide, a
//   second
//                 one by the same factors, of torques alone, comes before derivatives are looked at again. The step
//                 that is left moves the points to first order, so that they are exact to its square
//   columns       everything that moves a slot by d f bends the arm by the twist H d f,  H = Xi (I - F_u)^-1, Xi the
//                 slots' twists; a column is the twist of the flange per unit of its parameter,
//   rows          J = P [w; v],  P = W B [-[p]x | I] of each marker; W whitener, B = d seen / d point, axes of the
//                 station; W = s I, the same noise in all directions, needs half of the products
//
// Instructions are chosen at run time (AVX-512, AVX2, or plain ones). Lanes where Newton does not settle are left to
// the caller (the reference decides whether the arm folds).
#pragma once

#include <memory>
#include <vector>

#include "models/batch/shot_program.h"

namespace sagitta {

// Where the shots are evaluated: the same in all lanes.
struct BatchPoint {
  BatchPoint(const ShotProgram& program, const double* theta_in, const Pose<double>& base_in_station_in,
             std::vector<Vector3<double>> marker_points_in);

  const double* theta;  // one per model parameter
  Pose<double> base_in_station;
  std::vector<Vector3<double>> marker_points;  // of the program's markers, m
  // Of each transform: sin and cos, or the value, where all lanes share it; else what is added to the lane's own.
  std::vector<double> fixed;
};

// Where each derivative goes: columns of row-major rows of `columns` numbers per lane, three rows per marker.
struct BatchLayout {
  int columns = 0;
  int first_row = 0;
  int station = -1;          // translation, then rotation (left perturbation): 6 columns; -1: not asked for
  std::vector<int> markers;  // 3 columns each, one entry per marker of the program; -1: not asked for
  std::vector<int> theta;    // one entry per model parameter; -1: not asked for
  int latent = -1;           // one column per entry of latent_joints, times its sigma
  std::vector<int> latent_joints;
  std::vector<double> latent_sigmas;
  int residual = 0;
};

// What a layout asks of a program, sorted by where it is found: the same for all batches of a structure.
struct BatchPlan {
  BatchPlan(const ShotProgram& program, BatchLayout layout_in);

  struct ByTransform {  // the derivative by the value of a transform
    int twist = 0;
    int column = 0;
  };
  struct Sum {  // of parts of the program
    int first_part = 0, last_part = 0;
    int column = 0;
  };
  BatchLayout layout;
  std::vector<int> twists;  // of all transforms that any derivative needs
  std::vector<ByTransform> by_transform;
  std::vector<Sum> sums;

  std::size_t num_columns() const { return 3 + by_transform.size() + sums.size() + layout.latent_joints.size(); }
};

// Memory that calls use again; one per thread.
class BatchScratch {
 public:
  BatchScratch();
  ~BatchScratch();
  double* Reserve(std::size_t doubles);  // aligned for the widest registers

 private:
  struct Memory;
  std::unique_ptr<Memory> memory_;
};

// data: program.num_data x kBatchLanes, aligned. rows: at least (first_row + 3 markers) x columns x kBatchLanes,
// aligned; cells that no derivative belongs to are left as they are. Returns the lanes that did not settle, one bit
// each.
unsigned EvaluateBatch(const ShotProgram& program, const BatchPoint& at, const BatchPlan& plan, const double* data,
                       BatchScratch* scratch, double* rows);

// MotionPerUnit (models/excitation.h) of each parameter but geometric errors, the largest over all lanes: raises
// motions, one number per model parameter. Shots are as in EvaluateBatch, whiteners and measured points count for
// nothing; lanes that are left over must repeat a shot. Returns the lanes that were left to the caller.
unsigned RaiseMotions(const ShotProgram& program, const BatchPoint& at, const double* data, BatchScratch* scratch,
                      double* motions);

// Torques (forces) of the shots' own wrenches about each joint's axis, N m (N), at the equilibrium: joints x
// kBatchLanes numbers. Shots are as in EvaluateBatch. Returns the lanes that are left to the caller.
unsigned WrenchTorques(const ShotProgram& program, const BatchPoint& at, const double* data, BatchScratch* scratch,
                       double* torques);

// Which instructions run: "AVX3", "AVX2", ...
const char* BatchInstructions();

}  // namespace sagitta

// A problem's observations in batches of equal structure, kBatchLanes units side by side: the one pass over rows
// behind linearizations, normal equations and whatever judges them.
//
// A unit is what shares residuals: a shot, or, where joints have deviations that are marginalised, all shots of one
// visit. Rows are those of linearization.h: S^-1 (predicted - measured), three per observation. Units whose structure
// only the model itself evaluates, and those whose equilibrium a batch does not find, go through
// ForwardModel::Predict.
#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "estimator/least_squares/linearization.h"
#include "models/batch/batch_rows.h"

namespace sagitta {

// The columns of one group of units and what they are of.
struct BatchColumns {
  std::vector<BatchPlan> shots;  // one per shot of a unit
  std::vector<int> of;           // per local column: index into the columns asked for, or -1
  // Units of one shot: rows of a marker share the columns 0 .. 2 with those of the others; per marker what they are.
  // Empty: every marker has columns of its own.
  std::vector<std::vector<int>> own;
  int columns = 0;  // a multiple of kGramBlock; unused ones are zero
  int first = 0;    // of those that all rows share
  int last = 0;     // where they end; deviations and unused ones follow
  int sparse = 0;   // of stations and markers among them, which come first: a row has cells in some
  int residual = 0;
  int latent = -1, latents = 0;  // deviations of joints, times their sigmas, as they were before they are marginalised

  // What the local column of a row says: index into the columns asked for, or -1.
  int Of(int row, int column) const {
    return column < first && !own.empty() ? (column < 3 ? own[row / 3][column] : -1) : of[column];
  }
};

// What the residuals are against: the points as measured, or the origin (then they are the whitened predictions).
enum class RowsAgainst { kMeasured, kOrigin };

// Listed observations, grouped by structure and packed lane by lane.
class RowBatches {
 public:
  // noise: one root per observation, m. What the problem was given (model, data, shots) must outlive this, as it does
  // where the problem is moved or copied; its observations stay as they are.
  RowBatches(const CalibrationProblem& problem, const std::vector<int>& observations, const NoiseRoots& noise,
             LatentTreatment treatment, RowsAgainst against = RowsAgainst::kMeasured);
  ~RowBatches();

  const std::vector<int>& observations() const { return observations_; }
  int num_latents() const { return static_cast<int>(latent_joints_.size()); }
  int num_observations() const { return static_cast<int>(observations_.size()); }
  int num_groups() const { return static_cast<int>(groups_.size()); }
  int num_units() const;
  int num_batches(int group) const;
  int rows_of_unit(int group) const;
  // Positions in the list of observations, by row / 3, of one lane's unit; empty: the lane is filled up and counts for
  // nothing.
  class Unit {
   public:
    Unit() = default;
    Unit(const int* first, std::size_t count) : first_(first), count_(count) {}
    bool empty() const { return count_ == 0; }
    std::size_t size() const { return count_; }
    int operator[](std::size_t i) const { return first_[i]; }
    const int* begin() const { return first_; }
    const int* end() const { return first_ + count_; }

   private:
    const int* first_ = nullptr;
    std::size_t count_ = 0;
  };
  Unit UnitOf(int group, int batch, int lane) const;

  // The coordinates asked for, at one point; shared by all batches and threads.
  class Request {
   public:
    Request(const RowBatches& batches, const ParameterSet& parameters, const std::vector<int>& columns);

    const BatchColumns& columns(int group) const { return columns_[group]; }

   private:
    friend class RowBatches;
    std::vector<double> theta_;
    std::vector<Pose<double>> bases_;
    std::vector<Vector3<double>> markers_;
    std::vector<Matrix3<double>> turns_;           // of markers whose rotation is read
    std::vector<int> active_;                      // model parameters among the columns
    std::vector<BatchColumns> columns_;            // by group
    std::vector<std::vector<BatchPoint>> points_;  // by group, by shot of a unit
  };

  // Rows of one batch into rows_of_unit x columns x kBatchLanes numbers, aligned, and zero before the first batch of
  // the group; deviations of joints are marginalised here. False: an equilibrium diverges.
  bool Evaluate(const Request& request, int group, int batch, BatchScratch* scratch, double* rows) const;

  // MotionPerUnit (models/excitation.h), the largest over all units, at each of the given values: one number per model
  // parameter; those of geometric errors are 0. most: batches of each group that are looked at, spread over all.
  std::vector<std::vector<double>> LargestMotions(const std::vector<ParameterSet>& at,
                                                  int most = std::numeric_limits<int>::max()) const;

  // Torques of the known wrenches about each joint's axis at the equilibrium, N m (N), into a shot's row of torques.
  // Returns the shots that are left to the model.
  std::vector<int> FindWrenchTorques(const ParameterSet& at, Eigen::MatrixXd* torques) const;

 private:
  struct Group;

  int ShotOf(const Group& group, size_t shot, int unit) const;  // among those of the problem
  void RaiseByModel(const Group& group, size_t shot, int unit, const ParameterSet& at,
                    std::vector<double>* largest) const;
  bool EvaluateByModel(const Request& request, const Group& group, const BatchColumns& columns, int unit, int lane,
                       double* rows) const;
  BatchColumns ColumnsOf(const Group& group, const ParameterSet& parameters, const std::vector<int>& column_of) const;

  const ForwardModel& model_;
  const Measurements& data_;
  const std::vector<int>& marker_frames_;
  const std::vector<ShotInput>& shot_inputs_;
  const std::vector<int> latent_joints_;  // none: joints are exact
  const Eigen::VectorXd latent_sigmas_;
  const std::vector<int> observations_;
  const bool marginalises_;
  const RowsAgainst against_;
  std::vector<std::unique_ptr<Group>> groups_;
};

// The rows of all batches, in the order of their observations.
Linearization Linearize(const RowBatches& batches, const ParameterSet& parameters, const std::vector<int>& columns);

// The same observation by observation through ForwardModel::Predict: the reference of the batched pass, and what is
// left where an equilibrium diverges.
Linearization LinearizeByModel(const CalibrationProblem& problem, const ParameterSet& parameters,
                               const std::vector<int>& observations, const std::vector<int>& columns,
                               const NoiseRoots& noise, LatentTreatment treatment = LatentTreatment::kMarginalise);

// Aligned memory for the rows of a batch.
class BatchBuffer {
 public:
  double* Reserve(std::size_t doubles);  // zero

 private:
  std::vector<double> memory_;
};

}  // namespace sagitta

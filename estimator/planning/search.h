// The search for a plan: the certificate's design, exact plans by exchange, and poses that move to better places.
#pragma once

#include <vector>

#include "estimator/planning/numbers.h"

namespace sagitta {

struct FoundPlan {
  std::vector<PlannedPose> poses;
  std::vector<int> picks;      // candidates
  Eigen::MatrixXd covariance;  // scaled
  double cost = 0.0;
  ApproximateDesign approximate;
};

class PlanSearch {
 public:
  // All must outlive this; candidates that are found join `numbers`.
  PlanSearch(PlanScene* scene, PlanNumbers* numbers, const Criterion& criterion, const PlanRequest& request);

  // Throws InputError where there are fewer candidates.
  FoundPlan At(int poses);
  // The smallest number of poses whose RMS at the test points, without model error, is at most this, m. Throws
  // InputError where none is.
  FoundPlan Reaching(double accuracy);
  // Adds numbers of poses around this one to the curve.
  void Extend(int poses);

  // RMS distance at the test points, m; with the model error's field where there is one.
  double Rms(const Eigen::MatrixXd& covariance) const;
  // By which it grows where the model error is known as a factor alone.
  double Widening() const { return numbers_->has_field() ? 1.0 : request_.model_error; }
  std::vector<PosesAndAccuracy> Curve() const;
  // The first number of poses from which on the error falls no faster than N^-0.6: readings that only average it fall
  // as N^-1/2. 0: none.
  int Knee() const;
  int found_given_measured() const { return found_given_measured_; }
  // The rows of a plan, put where its poses are, with the readings that are expected.
  PoseRows& rows() { return rows_; }

 private:
  void CheckSupply(int poses) const;
  ApproximateDesign Approximate(int poses, double tolerance);
  // Candidates that gain more than those drawn, found from the best of them; twice, for what they change.
  void FindGivenMeasured(int poses);
  ExactDesign Exact(int poses, const ApproximateDesign& approximate, int starts, int rounds) const;
  // The best of the candidates.
  FoundPlan ChosenOf(int poses, const ApproximateDesign& approximate) const;
  bool IsNextToBest(const FoundPlan& found) const;
  void MovePoses(FoundPlan* found);
  // Exact plans of a few starts and rounds, for the curve; its RMS.
  double Quick(int poses);
  bool may_move() const { return request_.candidates == nullptr && request_.move; }

  PlanScene* scene_;
  PlanNumbers* numbers_;
  const Criterion& criterion_;
  const PlanRequest& request_;
  PoseRows rows_;
  std::vector<PlannedPose> candidates_;
  Eigen::VectorXd weights_;  // of the last approximate design
  Eigen::VectorXd quick_weights_;
  CandidateSet short_list_;  // for the curve, where there are very many
  std::vector<PosesAndAccuracy> curve_;
  int found_given_measured_ = 0;
};

}  // namespace sagitta

// A plan's scene as numbers: what each candidate says of the scaled unknowns, what is known before, what test points
// depend on.
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "estimator/planning/design.h"
#include "estimator/planning/scene.h"

namespace sagitta {

// What registering stations and markers of their own on the test poses leaves of these.
struct TestRegistration {
  int unknowns = 0;     // of those stations and markers
  int coordinates = 0;  // of the test points that see them
  int left = 0;         // of these; 0: they say nothing of the robot, and do not count
  bool has_any() const { return unknowns > 0; }
};

struct PlanNumbers {
  std::vector<int> columns;  // coordinates
  Eigen::VectorXd scale;     // SI value of one unit of each column
  CandidateSet set;
  Eigen::MatrixXd known;      // priors, hold limits, measured rows
  Eigen::MatrixXd test_rows;  // m per unit, three per test point that counts
  int equations_known = 0;    // measured rows and priors
  // Of `columns`: base and markers that only test poses see. They are registered there, so test_rows do not depend on
  // them, and what else registering absorbs is no error either: of n coordinates m are left, and the rows of these
  // points are larger by sqrt(n / m), so that a mean over them is one over what is left.
  std::vector<bool> registered;
  TestRegistration registration;
  // Of `columns`: those of the model error (model_field.h), which have a prior and are nobody's parameters.
  std::vector<bool> of_field;
  double field_amplitude = 0.0;  // rad

  bool has_field() const { return std::count(of_field.begin(), of_field.end(), true) > 0; }
  // Those that the plan has to determine.
  int unknowns() const;
  // C of everything else where the field is known to be 0: what noise alone leaves, C_rr - G C_fr.
  Eigen::MatrixXd ByNoiseAlone(const Eigen::MatrixXd& covariance) const;
  // C of a calibration that knows nothing of the field, as people make it: the field f stays in what it predicts, and
  // what it moves the others r by, G f with G = C_rf C_ff^-1. With the field's prior a^2 that is
  //   C_noise + [G; 1] a^2 [G; 1]'.
  Eigen::MatrixXd OfPlainFit(const Eigen::MatrixXd& covariance) const;
  // The least number of poses that has as many equations as unknowns.
  int LeastPoses() const;

 private:
  // Columns that are the field's and the others, and by how much these move with it: G.
  struct FieldSplit {
    std::vector<int> rest, field;
    Eigen::MatrixXd moved;
  };
  FieldSplit SplitByField(const Eigen::MatrixXd& covariance) const;
  static Eigen::MatrixXd ByNoiseAlone(const FieldSplit& split, const Eigen::MatrixXd& covariance);
};

// What is left of rows after the marked columns were fitted to them; those become 0. Returns how many rows they could
// follow: the rank of these columns.
int Absorb(const std::vector<bool>& columns, Eigen::MatrixXd* rows);

// model_error: m per coordinate, of PlanRequest::field. amplitude: of its field, rad, where that is known from other
// candidates. Throws InputError where nothing states the noise, or where test poses say nothing.
PlanNumbers MakePlanNumbers(const PlanScene& scene, double model_error = 0.0,
                            std::optional<double> amplitude = std::nullopt);

// Throws InputError where no parameter of the robot is free and the criterion asks for one.
Criterion CriterionFor(const CalibrationProblem& problem, const PlanNumbers& numbers, const PlanRequest& request);

// A pose that may be anywhere: one way to measure, joint values, sides of approach where they matter.
struct PlannedPose {
  int candidate = -1;  // of the list, where it stays there
  int way = -1;
  Eigen::VectorXd q;
  std::vector<int> approach;
  int like = -1;  // configuration whose time and temperature it has; -1: where it is listed, or those of its way
};

// Rows of poses that are no candidates.
class PoseRows {
 public:
  // Moves the movable configurations of the scene's problem; both must outlive this.
  PoseRows(PlanScene* scene, const PlanNumbers& numbers);

  // As in PlanNumbers::set; no rows where the load folds the arm.
  Eigen::MatrixXd At(const PlannedPose& pose);
  bool IsFeasible(const PlannedPose& pose) const;
  // The configuration that stands at the pose now, with the readings that are expected there.
  int MoveTo(const PlannedPose& pose);

 private:
  void Move(const PlannedPose& pose);
  bool Expect(int way);  // false: the load folds the arm

  PlanScene* scene_;
  const PlanNumbers& numbers_;
  std::vector<std::vector<int>> all_shots_;             // of each configuration
  std::vector<std::vector<int>> shots_, observations_;  // of each way
  std::vector<std::vector<Sight>> sights_;
};

}  // namespace sagitta

// What every candidate does at one model, to first order. One linearization serves every question asked there: beside
// other believed columns, on all configurations or on a part of them.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "estimator/diagnosis/candidates.h"
#include "estimator/diagnosis/compensator_search.h"
#include "estimator/diagnosis/screening.h"

namespace sagitta {

class CandidateBench {
 public:
  CandidateBench(const CalibrationProblem& problem, const ParameterSet& parameters, std::vector<Candidate> candidates);
  // The same on some of the rows.
  CandidateBench OnRows(const std::vector<int>& rows) const;

  const std::vector<Candidate>& candidates() const { return candidates_; }
  const CandidateColumns& columns() const { return columns_; }
  // The seat of a spring on this joint: what a compensator is searched with.
  const SpringSeat& seat(const std::string& joint) const { return seats_.at(joint); }

 private:
  std::vector<Candidate> candidates_;
  CandidateColumns columns_;
  std::map<std::string, SpringSeat> seats_;  // of the joints that have a compensator as candidate
};

// A candidate's score beside what is believed.
struct CandidateScore {
  Score score;
  std::vector<int> informed;             // columns of the bench that the data can tell
  std::vector<std::string> vague;        // names of the others
  bool oversized = false;                // Candidate::oversized
  std::vector<CompensatorShape> shapes;  // of a compensator, best first; its shape counts as parameters
};

// The candidates of a bench beside what one residual believes. has_spring: a compensator is among that, and a robot
// has but one.
class Screening {
 public:
  Screening(const CandidateBench& bench, const ProjectedResidual& residual, bool has_spring);
  CandidateScore Of(int candidate) const;
  // How much of the squared norm of `target` (rows, off what is believed) the scored candidate can do; a compensator
  // with its best shape for it.
  double Reproduced(const CandidateScore& scored, const Eigen::VectorXd& target) const;

 private:
  const CandidateBench& bench_;
  const ProjectedResidual& residual_;
  Eigen::MatrixXd on_believed_;
  bool has_spring_;
};

}  // namespace sagitta

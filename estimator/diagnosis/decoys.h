// Decoys: generic regressors outside the catalogue. Where one of them explains
// the gap better than catalogue effects do, the cause is not in the catalogue.
//
//   smooth    joint j deviates by a smooth function of joint k or of time
//   bump      by one bump in its own angle                 (one column, scanned)
//   step      by one step in its own angle                 (one column, scanned)
//   periodic  by a harmonic of another joint's angle       (two columns, scanned)
//   product   by products and sums of two joints' angles
//   wave      a station moves as a wave in time
//
// Families of many columns are scored by marginal likelihood
// (MarginalGainOf), few columns like a catalogue effect,
// reduction - p ln(n); both lose 2 ln(settings scanned): comparable to the
// penalised chi-square reduction of FORMATS section 6.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "estimator/diagnosis/selection.h"

namespace sagitta {

struct Decoy {
  std::string kind;                     // smooth, periodic, step, time, other
  std::vector<std::string> depends_on;  // joints, or a station
  std::string acts_on;
  std::string words;
  double penalised = -1e300;
  Eigen::MatrixXd columns;  // whitened, at the model it was scored on
  bool moves_station = false;
};

// What decoys are scored with at one model: how its joints and stations move the rows.
class DecoyBench {
 public:
  explicit DecoyBench(const DiagnosedModel& model);

  // The model's residual, projected off what it believes.
  const ProjectedResidual& residual() const { return residual_; }
  // The best decoy on the model's residual, or on what is left of it beside columns that are believed too.
  Decoy Best() const { return Best(residual_); }
  Decoy Best(const ProjectedResidual& residual) const;
  // The best decoy in units of the scatter that it leaves, as effects are judged, where that is more than the noise.
  Decoy BestInScatter() const;
  // All that a decoy's kind can do: any smooth function of what it depends on, on what it acts on, and its own columns.
  Eigen::MatrixXd ColumnsOfKind(const Decoy& decoy) const;

 private:
  bool Moves(int joint) const;
  bool Turns(int joint) const;
  // Joint values in words, deg or mm.
  std::string Place(int joint, double value) const;
  std::string PlaceUnit(int joint) const { return Turns(joint) ? " deg" : " mm"; }
  std::string Range(int joint, double low, double high) const;
  // One scalar per shot.
  Eigen::VectorXd PerShot(const std::function<double(const ShotConditions&)>& value) const;
  // Rows of functions of the shot.
  Eigen::MatrixXd OnRows(const Eigen::MatrixXd& of_shot) const { return of_shot(shot_of_row_, Eigen::all); }
  Eigen::MatrixXd StationShift(const std::string& station) const;

  const CalibrationProblem& problem_;
  const ParameterSet& parameters_;
  ProjectedResidual residual_;
  int dof_;
  Eigen::MatrixXd deviations_;                     // JointDeviationColumns
  std::map<std::string, Eigen::MatrixXd> shifts_;  // of stations: whitened rows per um in x, y, z
  std::vector<int> shots_, shot_of_row_;           // the fitted ones; index into them
  Eigen::VectorXd weight_;                         // rows of each shot over all
  std::vector<Eigen::VectorXd> angles_;            // of each joint, per shot
  Eigen::VectorXd time_;                           // per shot
  bool timed_ = false;

  friend class DecoySearch;
};

}  // namespace sagitta

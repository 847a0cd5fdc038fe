// The rows of a plan's problem as they are put together: those of the experiment, candidates, test poses.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "problems/experiment.h"
#include "problems/measurements.h"

namespace sagitta {

// Standard deviations that fitted rows state, m: root mean square per axis, of each marker from each station, and of
// all where no row has both. They stand for those of poses that are measured like these and state none.
class RowSigmas {
 public:
  explicit RowSigmas(const Measurements& data);
  bool AnyStated() const { return !all_.squares.isZero(0.0); }
  Vector3<double> Of(const std::string& station, const std::string& marker) const;

 private:
  struct Sum {
    Vector3<double> squares = Vector3<double>::Zero();
    int rows = 0;
    void Add(const Vector3<double>& sigma);
    Vector3<double> Rms() const;
  };
  std::map<std::pair<std::string, std::string>, Sum> of_sight_;
  Sum all_;
};

// Grows the rows of a plan's problem.
class SceneRows {
 public:
  SceneRows(const Measurements& data, const NoiseSpec& noise);

  // A configuration of `from` with these shots, as AppendConfiguration; approach: of its shots where not empty.
  int Add(const Measurements& from, int configuration, const std::vector<int>& shots, const Eigen::VectorXd& q,
          const std::string& id, const std::vector<int>& approach);

  // The listed configurations, with the files of their rows. Rows without a standard deviation have that of the
  // experiment's, where these state one and the experiment none for all.
  std::vector<int> AddCandidates(const Measurements& from, const std::vector<int>& configurations);
  // All configurations: nothing of them is weighed, so that their noise is whatever lets the others have theirs.
  std::vector<int> AddTests(const Measurements& from);
  // Stations and markers of test poses that no other row has; call it before rows are added. False: there are none.
  bool AddNamesOf(const Measurements& tests);

  // Rows of candidates that were given the experiment's standard deviations.
  int without_sigma() const { return without_sigma_; }

  Measurements rows;

 private:
  std::vector<int> AddAll(const Measurements& from, const std::vector<int>& configurations);
  int FillSigmas(size_t first);

  RowSigmas sigmas_;
  bool one_for_all_;  // the experiment states a standard deviation for rows that state none
  int without_sigma_ = 0;
};

}  // namespace sagitta

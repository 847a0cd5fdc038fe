// The rows of a plan's problem as they are put together: those of the experiment, candidates, test poses.
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <tuple>
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

// Configurations that are measured alike in what they differ by: how exactly, when and how warm it was. A pose that is
// planned like them has readings of their mean variance, which is what a reading of any of them has on average, and the
// time and temperature of one of them.
class MeasuredAlike {
 public:
  // configurations: all with as many shots of each station and load. otherwise: m, of rows that state no standard
  // deviation.
  MeasuredAlike(const Measurements& data, const std::vector<int>& configurations, std::optional<double> otherwise);

  // Standard deviations that differ, m, the least and the largest of any axis; none where all are alike.
  std::optional<std::pair<double, double>> SigmasThatDiffer() const;
  // How many configurations there are.
  size_t size() const { return conditions_.size(); }
  // Of rows whose last shots, from `first` on, were made of the first configuration's: their standard deviations where
  // these differ, and time and temperature of the number-th configuration, from 0.
  void Complete(size_t number, size_t first, Measurements* rows) const;

 private:
  struct Spread {
    Vector3<double> squares = Vector3<double>::Zero();
    double least = std::numeric_limits<double>::infinity(), largest = 0.0;
    int rows = 0;
  };
  using Key = std::tuple<std::string, std::string, std::string, bool>;  // station, load, marker, is a point
  static Key KeyOf(const Measurements& data, const Observation& row);
  static bool Differs(const Spread& spread);

  std::map<Key, Spread> spreads_;
  // Of each configuration: its shots' conditions by station and load, in their order.
  std::vector<std::map<std::pair<std::string, std::string>, std::vector<Shot>>> conditions_;
};

// Numbers below a count in random order, again and again in another one: each as often as the others, and none goes
// with the place of a pose in its sequence, whose first joint alternates (Halton's base 2).
class RandomTurns {
 public:
  RandomTurns(size_t count, std::uint64_t seed);
  size_t Next();

 private:
  std::vector<size_t> turns_;
  size_t next_;  // of turns_
  std::mt19937_64 random_;
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

// What lists of unnamed functions are made of: functions over drivers, their columns, and the effects that are the
// same.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "estimator/explanations/driver_functions.h"
#include "estimator/explanations/unnamed_functions.h"
#include "problems/text.h"

namespace sagitta {

// Random smooth functions bend over a third or a ninth of the driver's range: a sag and a ripple.
constexpr int kUnnamedBumps[] = {4, 10};
constexpr int kFineBumps = 25;  // of a joint's own angle: a bump of 10 degrees
constexpr int kRamps = 50;      // in time: where something changed at once is known to within visits, some tens

using Settings = std::map<std::string, std::string>;

// A range, a place or a direction, in the settings of an effect.
inline std::string AsSetting(double value) { return Significant(value, 7); }
// The same of x, y and z.
Settings VectorSettings(const std::string& before, const Vector3<double>& vector, const std::string& after = "");

// What functions one driver has, and which of them go together.
struct GroupedFunctions {
  struct Group {
    std::string kind;
    int first, count;
    Settings settings;           // of the effect that is the same function
    std::string effect;          // its name; empty: that of the whole list, over the driver's range
    double listed;               // UnnamedGroup::listed
    std::vector<Settings> each;  // the effect is several, each with these too; empty: it is one
  };
  Eigen::MatrixXd columns;
  std::vector<Group> groups;

  void Append(const Eigen::MatrixXd& more, const std::string& kind, const Settings& settings,
              const std::string& effect = "", double listed = 1.0, const std::vector<Settings>& each = {});
  // Fewer columns that these are made of; kept for the next source that has the same functions.
  const std::shared_ptr<const Compressed>& Few() const;

 private:
  mutable std::shared_ptr<const Compressed> few_;
};

// A list while it grows.
class UnnamedList {
 public:
  UnnamedList(const CalibrationProblem& problem, EvidenceColumns* columns);

 protected:
  std::vector<UnnamedGroup> Take() { return std::move(list_); }

  // Of a driver over the fitted shots.
  struct Range {
    double low, high;

    bool Varies() const { return high - low > 1e-9 * (1.0 + std::abs(high)); }
  };

  Eigen::MatrixXd OnFitted(const Eigen::MatrixXd& functions) const { return functions(fitted_, Eigen::all); }
  Range RangeOf(const Eigen::VectorXd& x) const { return {x(fitted_).minCoeff(), x(fitted_).maxCoeff()}; }
  std::string JointName(int j) const { return problem_.robot().chain.joints[j].name; }
  int joints() const { return problem_.robot().num_joints(); }

  // Where the nominal flange is, from the middle of the fitted ones of some shots and in units of their spread; zero of
  // the others.
  struct Field {
    Eigen::MatrixXd places;  // shots x 3
    Settings settings;
  };
  Field FieldOf(const std::vector<bool>& is_in) const;

  // Smooth functions of x over the range of the fitted shots. False: it does not vary.
  bool Smooth(const Eigen::VectorXd& x, const std::string& kind, GroupedFunctions* functions) const;
  void AppendBumps(const Eigen::VectorXd& x, const std::string& kind, int count, GroupedFunctions* functions) const;
  // Of time: a random walk.
  void AppendRamps(const Eigen::VectorXd& time, int count, GroupedFunctions* functions) const;
  // An effect over the range of a driver; its knots go by the group of functions.
  EffectSpec Over(const Driver& driver, const std::string& effect, const std::string& target) const;
  // Every group of functions on one source or on several, each with coefficients of its own.
  void AddFunctions(const GroupedFunctions& functions, const UnnamedFunction& what, const std::string& family);
  // The same where each source has functions of its own, in groups that are alike. together: so many sources after each
  // other have the same coefficients.
  void AddEach(const std::vector<GroupedFunctions>& of_source, const UnnamedFunction& what, const std::string& family,
               size_t together = 1);
  // What stays as it is but for a few jumps in time, which lie where the rows say, `fewest` at least. The prior counts
  // all places that they may have.
  void AppendJumpsInTime(const AlongSources& along, size_t fewest, GroupedFunctions* functions) const;

  const CalibrationProblem& problem_;
  EvidenceColumns* columns_;
  std::vector<int> fitted_;  // shots

 private:
  std::vector<UnnamedGroup> list_;
};

// Joints that deviate; all else that moves: stations, links, markers; instruments that read wrong.
std::vector<UnnamedGroup> ListUnnamedJoints(const CalibrationProblem& problem, const ParameterSet& parameters,
                                            EvidenceColumns* columns);
std::vector<UnnamedGroup> ListUnnamedPlaces(const CalibrationProblem& problem, const ParameterSet& parameters,
                                            EvidenceColumns* columns);
std::vector<UnnamedGroup> ListUnnamedReadings(const CalibrationProblem& problem, EvidenceColumns* columns);

}  // namespace sagitta

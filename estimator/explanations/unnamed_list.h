// What lists of unnamed functions are made of: functions over drivers, their columns, and the effects that are the
// same.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "estimator/explanations/driver_functions.h"
#include "estimator/explanations/unnamed_functions.h"

namespace sagitta {

// Random smooth functions bend over a third or a ninth of the driver's range: a sag and a ripple.
constexpr int kUnnamedBumps[] = {4, 10};
constexpr int kFineBumps = 25;  // of a joint's own angle: a bump of 10 degrees
constexpr int kRamps = 50;      // in time: where something changed at once is known to within visits, some tens
constexpr int kDigits = 7;      // of a range, a place or a direction, in the settings of an effect

using Settings = std::map<std::string, std::string>;

// What follows jumps and waves as well as so many knots do.
inline Settings Fine() { return {{"knots", std::to_string(kFineBumps)}}; }

// What functions one driver has, and which of them go together.
struct GroupedFunctions {
  struct Group {
    std::string kind;
    int first, count;
    Settings settings;   // of the effect that is the same function
    std::string effect;  // its name; empty: that of the whole list, over the driver's range
    double listed;       // UnnamedGroup::listed
  };
  Eigen::MatrixXd columns;
  std::vector<Group> groups;

  void Append(const Eigen::MatrixXd& more, const std::string& kind, const Settings& settings,
              const std::string& effect = "", double listed = 1.0);
  // Fewer columns that these are made of; kept for the next source that has the same functions.
  const std::shared_ptr<const Compressed>& Few() const;

 private:
  mutable std::shared_ptr<const Compressed> few_;
};

// A list while it grows.
class UnnamedList {
 public:
  UnnamedList(const CalibrationProblem& problem, EvidenceColumns* columns);

  std::vector<UnnamedGroup> Take() { return std::move(list_); }

 protected:
  Eigen::MatrixXd OnFitted(const Eigen::MatrixXd& functions) const { return functions(fitted_, Eigen::all); }
  std::string JointName(int j) const { return problem_.robot().chain.joints[static_cast<size_t>(j)].name; }
  int joints() const { return problem_.robot().num_joints(); }

  // Smooth functions of x over the range of the fitted shots. False: it does not vary.
  bool Smooth(const Eigen::VectorXd& x, const std::string& kind, GroupedFunctions* functions) const;
  void AppendBumps(const Eigen::VectorXd& x, const std::string& kind, int count, GroupedFunctions* functions) const;
  // Of what puts the visits in order: a random walk.
  void AppendRamps(const Eigen::VectorXd& order, const std::string& kind, int count, GroupedFunctions* functions) const;
  // An effect over the range of a driver; its knots go by the group of functions.
  EffectSpec Over(const Driver& driver, const std::string& effect, const std::string& target) const;
  // Of an effect that asks which way is down.
  static Settings DownSettings(const Vector3<double>& down_in_base);
  // Every group of functions on one source or on several, each with coefficients of its own.
  void AddFunctions(const GroupedFunctions& functions, const UnnamedFunction& what, const std::string& family);

  // The same where each source has functions of its own, in groups that are alike.
  void AddEach(const std::vector<GroupedFunctions>& of_source, const UnnamedFunction& what, const std::string& family);

  // Every group of functions on several sources that have the same coefficients, each with its own values of these
  // functions.
  void AddTogether(const std::vector<GroupedFunctions>& of_source, const UnnamedFunction& what,
                   const std::string& family);

  const CalibrationProblem& problem_;
  EvidenceColumns* columns_;
  std::vector<int> fitted_;  // shots

 private:
  void Append(ColumnGroup columns, const GroupedFunctions::Group& group, const UnnamedFunction& what,
              const std::string& family);

  std::vector<UnnamedGroup> list_;
};

// Joints that deviate; all else that moves: stations, links, markers; instruments that read wrong.
std::vector<UnnamedGroup> ListUnnamedJoints(const CalibrationProblem& problem, const ParameterSet& parameters,
                                            EvidenceColumns* columns);
std::vector<UnnamedGroup> ListUnnamedPlaces(const CalibrationProblem& problem, const ParameterSet& parameters,
                                            EvidenceColumns* columns);
std::vector<UnnamedGroup> ListUnnamedReadings(const CalibrationProblem& problem, EvidenceColumns* columns);

}  // namespace sagitta

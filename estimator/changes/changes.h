// What changed between two estimates of one robot, beyond what both leave open.
//
// Parameters trade off against each other, points do not: both estimates predict the markers that they share, in many
// configurations, unloaded and loaded, and what is compared is
//
//   d = p_new - p_old,   C = J_o C_o J_o' + J_n C_n J_n' + e^2 I     (held directions included)
//
// A parameter that one of them estimated and the other assumed adds its column, with those of what moves along with it
// (c = J C_p / C_pp), as wide as such a parameter can be. Explanations (a joint's zero slipped, tool knocked, marker
// reseated, base moved, length, angle, stiffness) are columns per typical size; which of them changed is a posterior
// over sets (sparse_search.h).
//
// An instrument that is set up anew stands metres away: the old estimate is first moved next to the new one, exactly,
// by all that can be of any size (align.cc), columns and C are those of that place, and a set is searched and moved to
// in turn until it stays.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "estimator/changes/change_groups.h"

namespace sagitta {

struct Change {
  ChangeKind kind = ChangeKind::kJointZero;
  std::string target;  // A3, flange, M1, S1, p_x1, ...
  double value = 0.0;  // in `unit`; a motion: of the base's or the flange's origin
  std::string unit;    // mm, mrad, ...
  double ci95[2] = {0.0, 0.0};
  double before = 0.0;  // of a compliance, in `unit`; 0: the old estimate has none
  double probability = 0.0;
  struct Part {
    std::string name;  // x, y, z, rx, ry, rz
    double value = 0.0;
    std::string unit;
    double ci95[2] = {0.0, 0.0};
  };
  std::vector<Part> parts;        // of a motion
  std::vector<std::string> same;  // parameters whose change would move the points alike
  std::string words;
};

struct Changes {
  std::vector<Change> changes;       // the most probable set, strongest first
  std::vector<Change> alternatives;  // others with a probability of 0.05 or more; values are not given
  double nothing = 1.0;              // probability that nothing changed
  double before_rms = 0.0;           // m, over points: how far the estimates are apart
  double after_rms = 0.0;            // m, with the changes removed
  std::vector<std::string> notes;    // what is not compared, and why
  std::string words;
};

// Throws InputError where the estimates are of different robots or nothing can be compared, Failure where no set of
// changes is reached from one to the other.
Changes FindChanges(const KnownRobot& old_estimate, const KnownRobot& new_estimate);

// changed.json, sagitta/changed/1.
nlohmann::ordered_json ChangesToJson(const Changes& changes);

}  // namespace sagitta

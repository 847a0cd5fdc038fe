// What has no name: random functions of what a pose, a load, a time or a place may drive, of everything that may
// deviate.
#pragma once

#include <string>
#include <vector>

#include "estimator/explanations/drivers.h"
#include "estimator/explanations/evidence_columns.h"
#include "estimator/random_effects/sweep.h"

namespace sagitta {

// A deviation outside the catalogue.
struct UnnamedFunction {
  UnnamedFunction() = default;
  UnnamedFunction(std::string part, std::vector<std::string> drivers, std::string sentence, std::vector<Source> moved,
                  std::vector<EffectSpec> same, Driver over = {})
      : acts_on(std::move(part)),
        depends_on(std::move(drivers)),
        words(std::move(sentence)),
        sources(std::move(moved)),
        effects(std::move(same)),
        driver(std::move(over)) {}

  std::string acts_on;                  // joint, station or marker
  std::vector<std::string> depends_on;  // joints, time, temperature, a station or a marker
  std::string words;
  std::vector<Source> sources;  // each with the same functions
  // The same function as effects of the model, without values (seats between visits as ramps over time); empty where
  // time is not stated and it goes by visits.
  std::vector<EffectSpec> effects;
  Driver driver;     // of one driver; else empty
  std::string kind;  // smooth, periodic, step (a jump), time, other: FORMATS section 6
};

// One of them with its columns.
struct UnnamedGroup {
  ColumnGroup group;
  UnnamedFunction function;
  std::string family;   // that shares a part of the prior
  double listed = 1.0;  // of the family: the others say less of these rows and are left out
};

// Adds their columns.
std::vector<UnnamedGroup> ListUnnamed(const CalibrationProblem& problem, const ParameterSet& parameters,
                                      EvidenceColumns* columns);

}  // namespace sagitta

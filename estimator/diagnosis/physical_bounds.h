// Whether a machine could show what was found: sign and size of an effect's values.
#pragma once

#include <string>
#include <vector>

#include "estimator/diagnosis/diagnosed_model.h"

namespace sagitta {

// What sign and size of an effect say.
struct PhysicalBounds {
  enum class Kind {
    kUsual,
    kCorrection,      // of a compliance of the robot file: what it adds up to
    kNegative,        // less than nothing of a mass, a gap, what a part gives way by
    kTooLarge,        // it moves the arm by more than machines show
    kMoreThanLoad,    // a load is off by more than its stated mass: no weighing error
    kLoadsExchanged,  // the same, and two loads weigh as if their masses were exchanged
    kAboutItsPoint    // a load's point is off by the whole stated offset: its moments may be about that point already
  };
  Kind kind = Kind::kUsual;
  // kCorrection, rad/(N m); kMoreThanLoad and kLoadsExchanged, kg: of the robot or the experiment file, and now.
  double stated = 0.0, found = 0.0;
  std::string other = {};  // kLoadsExchanged: the other load

  bool IsPlausible() const { return kind == Kind::kUsual || kind == Kind::kCorrection || kind == Kind::kAboutItsPoint; }
};

// final: the model that holds the effect with these values; parameters: the effect's own.
PhysicalBounds PhysicalBoundsOf(const DiagnosedModel& final, const EffectSpec& spec,
                                const std::vector<ParameterEstimate>& parameters);

}  // namespace sagitta

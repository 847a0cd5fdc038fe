// Terms of an effect that somebody wrote outside the catalogue: whether they lead somewhere.
#pragma once

#include <string>

#include "models/effects/effect.h"

namespace sagitta {

// Throws std::invalid_argument, with the effect's name, where a term names a parameter, transform, frame or marker that
// there is not, or has a factor that is no number.
void CheckTerms(const ShotTerms& terms, int parameters, int transforms, int markers, const std::string& effect);

}  // namespace sagitta

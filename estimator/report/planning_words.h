// What a plan says of itself: what was assumed and checked, its order, how near to the best it is. Numbers come in SI.
#pragma once

#include <string>
#include <vector>

#include "estimator/planning/plan.h"

namespace sagitta {

// What a plan by this criterion makes small or large.
std::string InWords(CriterionKind kind);

// share: of the way in the order in which poses were found.
std::string OrderIsMixed();
std::string OrderIsShort(double share);

// What the plan assumed, after what its scene already says.
std::vector<std::string> AssumptionsInWords(const Plan& plan, bool candidates_are_drawn);
std::string RegisteredOnTests();
std::string PlacesFitReadings();
std::string PlacesAreStated();
std::string PatternsLeftOut(int left_out, int offered);

// What is not checked of each pose: `what` follows.
std::string BodiesAreNotStated();
std::string BoxesAreNotStated();

// How near the plan is to the best one; of a criterion without a certificate, why that is not known.
std::string CertificateInWords(const Plan& plan);
// What the numbers of a plan that tells effects apart mean.
std::string SeparationInWords();

}  // namespace sagitta

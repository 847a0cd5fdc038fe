// Which geometric errors are free by default: the largest set that is complete,
// minimal and continuous.
//
// The rule.
//  1. Snap: every fixed rotation within 3 degrees of a multiple of 90 degrees is
//     read as that multiple, so that nearly parallel axes count as parallel
//     (plain DH is singular there and its parameters would jump: Hayati).
//  2. Form the identification Jacobian of three generic marker points over
//     generic joint values, the snapped chain, base pose and marker points free.
//  3. Walk the errors in order, three times: offsets of joints first (a controller
//     can correct them), then all others, Hayati's beta last; keep an error if its
//     column is independent of all columns kept so far.
// Complete: every generic motion of the flange is spanned. Minimal: no kept
// column is redundant. Continuous: the choice does not change as axes pass
// through parallel. Of 4R + 2P + 6 parameters of base, arm and tool (Everett, Driels,
// Mooring 1987) exactly 4R + 2P - 6 remain in addition to base and tool.
#pragma once

#include <string>
#include <vector>

#include "models/chain.h"

namespace sagitta {

struct FreeSetContext {
  bool base_free = true;
  bool markers_free = true;
};

struct FreeSet {
  std::vector<std::string> free;       // error names, chain order
  std::vector<std::string> redundant;  // the rest: combinations of the free ones, base and markers
};

FreeSet DefaultFreeSet(const Chain& chain, const FreeSetContext& context = {});

}  // namespace sagitta

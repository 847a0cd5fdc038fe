// What a diagnosis expects before it has seen the data, as probabilities (FORMATS section 6).
#pragma once

namespace sagitta {

// That nothing is missing, an effect of the catalogue, something outside it; further: each cause beside the first.
struct PriorMasses {
  double nothing = 0.5, catalogue = 0.38, unnamed = 0.12, further = 0.3;
};

}  // namespace sagitta

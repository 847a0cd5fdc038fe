// What a diagnosis expects before it has seen the data, as probabilities (FORMATS section 6).
#pragma once

#include <cmath>

namespace sagitta {

// That nothing is missing, an effect of the catalogue, something outside it; further: each cause in addition to the
// first. Choices, for nobody counted arms: something is missing as likely as not, and a quarter of causes (0.12 / 0.5)
// is not in the catalogue. `prior` of the experiment file replaces them, and prior.flips says where they decide.
struct PriorMasses {
  double nothing = 0.5, catalogue = 0.38, unnamed = 0.12, further = 0.3;

  // To the decimals that people write.
  bool SumToOne() const { return std::abs(nothing + catalogue + unnamed - 1.0) <= 1e-3; }
};

// Of masses that do not, in words.
inline constexpr const char* kMassesDoNotSum = "nothing, catalogue and unnamed do not sum to 1";

}  // namespace sagitta

// What a deviation without a name looks like: its posterior mean over the driver with its band, and the nearest
// formula.
#pragma once

#include <string>
#include <vector>

#include "estimator/evidence/posterior.h"
#include "estimator/explanations/unnamed_functions.h"

namespace sagitta {

// Log evidence that an unnamed function needs in addition to a set that has none of its own: odds of 20.
constexpr double kStandsOut = 3.0;

struct FunctionPoint {
  double at = 0.0;     // of the driver, in its unit
  double value = 0.0;  // urad or um
  double sigma = 0.0;
};

// A function of the data that no effect of the catalogue is.
struct LearntFunction {
  UnnamedFunction what;      // acts on nothing: no cause stands out
  double probability = 0.0;  // of what is called so
  std::string unit;          // of the table, which is empty where there is more than one driver
  std::vector<FunctionPoint> table;
  std::string driver;  // q3: the joint by its number; else the driver's name
  // That the table is nearest to, of the driver in its unit: 75.8·cos(10·q3) + 8.93·sin(10·q3) + 1.2
  std::string formula;
  std::string words;               // the same
  std::vector<EffectSpec> pieces;  // of the same cause, each like an effect of the catalogue
};

// The strongest unnamed function of a model, the others of its set given, and what it moves by all of them that follow
// the same driver; none where it has none. posterior: of the
// evidence's models.
LearntFunction LearnFunction(const Evidence& evidence, const Posterior& posterior, const WeightedModel& model,
                             const CalibrationProblem& problem);

}  // namespace sagitta

// What may be missing: every effect of the catalogue on every target with every
// setting that the data can speak about.
#pragma once

#include <string>
#include <vector>

#include "models/effects/effect.h"
#include "problems/calibration_problem.h"

namespace sagitta {

struct Candidate {
  EffectSpec spec;                                  // values empty: neutral
  std::vector<std::string> poorly_determined = {};  // parameters
  // Those, and what the data determine poorly: refitted with a prior.
  std::vector<std::string> loose = {};
  double prior_scale = 3.0;  // typical sizes, of that prior
  bool keeps_shape = false;  // of a spring: the data hardly determine its shape, it stays near the start's
  bool rate_alone = false;   // of a spring that the robot states: what else it states is believed
};

// What another measurement, or another robot file, would have.
enum class Lack { kOther, kTime, kTemperature, kApproach, kCompliance };

// An effect that these data cannot show, and what is missing.
struct NotTestable {
  std::string effect;
  std::string target;
  std::string needs;  // a column, or words
  Lack lack = Lack::kOther;
};

// The catalogue on this robot and these data.
struct CandidateList {
  std::vector<Candidate> candidates;
  std::vector<NotTestable> not_testable;
};

// Names of the loads that shots carry, in their order.
std::vector<std::string> LoadsCarried(const Measurements& data);

// Their specs, in their order.
std::vector<EffectSpec> SpecsOf(const std::vector<Candidate>& candidates);

// Orders of a harmonic that are scanned: as many as the configurations can resolve; a gear has more.
constexpr int kHarmonicOrders = 6;        // scanned with few configurations
constexpr int kMostHarmonicOrders = 130;  // a strain wave gear has about 100
int ResolvedOrders(const CalibrationProblem& problem);

// `estimated`: values of the believed model; what acts through a compliance of zero there cannot be tested.
CandidateList ListCandidates(const CalibrationProblem& problem, const ParameterSet& estimated);

}  // namespace sagitta

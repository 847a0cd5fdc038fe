// What the numbers that people choose may be: options of the library, flags of the program, arguments of Python, keys
// of an experiment. A range is stated once, here; whoever reads a number says what it was called where it was chosen:
//
//   CheckIn(allowed::kThreads, options.num_threads, "CalibrateOptions.num_threads");
//   CheckIn(allowed::kThreads, FLAGS_threads, "--threads");
//
// A struct of options has one CheckOptions, called first by the functions that accept the struct: behind it no value
// has to be doubted (tests/options_test.py).
#pragma once

#include <string>

#include "problems/limits.h"

namespace sagitta {

// What a number may be, SI: from low to high, or between the two where neither is possible itself.
struct Range {
  const char* what;  // "a number of threads"
  double low, high;
  const char* unit = "";     // of both, with the blank before it: " m"
  bool is_open = false;      // neither end is possible
  bool may_be_zero = false;  // in addition

  bool Has(double value) const;  // false of NaN
  // "a number of threads from 1 to 1024 is expected, this is 0"
  std::string Refusal(double value) const;
};

// Throws InputError at `name`, which says to the caller what to change, where the range does not have the value.
void CheckIn(const Range& range, double value, const std::string& name);

// The ranges. Reasons of the ends: problems/limits.h.
namespace allowed {

inline constexpr Range kThreads{"a number of threads", 1, limits::kThreads};
inline constexpr Range kTrials{"a number of trials", 1, limits::kTrials};
inline constexpr Range kIterations{"a number of iterations", 1, 1e6};
inline constexpr Range kStarts{"a number of starts", 1, 1e4};
// Below 99 the ends of a 95 % interval are the largest draws themselves.
inline constexpr Range kReplicates{"a number of replicates", 99, 1e6};
inline constexpr Range kNoiseIterations{"a number of iterations", 1, 1e4};
inline constexpr Range kPoses{"a number of poses", 1, limits::kPlanPoses};
inline constexpr Range kPool{"a number of candidates", 1, limits::kPlanPool};

inline constexpr Range kLevel{"a level", 0.0, 1.0, "", true};
inline constexpr Range kFraction{"a fraction", 0.0, 1.0, "", true};
inline constexpr Range kProbability{"a probability", 0.0, 1.0, "", true};
inline constexpr Range kTolerance{"a tolerance", 0.0, 1.0, "", true};
inline constexpr Range kFactor{"a factor", 0.0, limits::kYamlNumber, "", true};
inline constexpr Range kWideningFactor{"a factor", 1.0, 1e6};
inline constexpr Range kWeight{"a weight", 0.0, limits::kYamlNumber};

inline constexpr Range kSigma{"a standard deviation", limits::kLeastSigma, limits::kLargestSigma, " m"};
inline constexpr Range kSigmaOrZero{
    "a standard deviation", limits::kLeastSigma, limits::kLargestSigma, " m", false, true};
inline constexpr Range kAngleSigmaOrZero{
    "a standard deviation", limits::kLeastRotationSigma, limits::kLargestRotationSigma, " rad", false, true};
inline constexpr Range kPriorSigma{"a standard deviation of what is known", limits::kLeastPriorSigma,
                                   limits::kLargestPriorSigma};
inline constexpr Range kPriorValue{"a value", -limits::kYamlNumber, limits::kYamlNumber};
inline constexpr Range kAccuracy{"an accuracy", 0.0, limits::kCoordinate, " m", true};
inline constexpr Range kLength{"a length", 0.0, limits::kCoordinate, " m", true};
inline constexpr Range kMisfit{"a length", 0.0, limits::kCoordinate, " m"};
inline constexpr Range kCoordinate{"a coordinate", -limits::kCoordinate, limits::kCoordinate, " m"};
inline constexpr Range kAngle{"an angle", -limits::kJointValue, limits::kJointValue, " rad"};
inline constexpr Range kMass{"a mass", 0.0, limits::kMass, " kg"};
inline constexpr Range kGravity{"a gravity", 1e-3, 1e3, " m/s^2"};

}  // namespace allowed
}  // namespace sagitta

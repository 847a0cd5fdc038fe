// What the readers accept at most, and why. Whatever lies beyond is a slip or an attack: it is refused with words at
// the reader (InputError), so that nothing behind the readers meets sizes or numbers that it was not made for.
#pragma once

#include <cstddef>

namespace sagitta::limits {

// --- sizes -----------------------------------------------------------------------------------------------------------

// Bytes of one file. Ten million rows of twenty columns are 2 GB; a campaign of a hundred thousand rows is 20 MB.
inline constexpr std::size_t kFileBytes = 256u << 20;
// Bytes of a file in YAML or XML: their parsers make some hundred bytes of every byte. A robot of 64 joints is 20 kB.
inline constexpr std::size_t kMarkupBytes = 8u << 20;
// A controller's configuration or a MATLAB script that describes a robot: they are searched by std::regex, whose stack
// grows with what matches (32 kB ended it). Names of columns, lines of comment and expressions: the same, per piece.
inline constexpr std::size_t kScriptBytes = 12'000;
inline constexpr std::size_t kWordBytes = 500;
// Nesting of lists and maps. Our own files nest 8 deep; a parser's or writer's stack ends at some ten thousand.
inline constexpr int kDepth = 64;
// Values of a YAML file with every alias written out: a kilobyte of aliases stands for 10^9 of them.
inline constexpr std::size_t kYamlValues = 1'000'000;
// Columns of a table, and cells: a cell needs 32 bytes at least, so this is 1 GB.
inline constexpr std::size_t kColumns = 4096;
inline constexpr std::size_t kCells = 32'000'000;
// Joints of one chain: the longest arms that are calibrated have 9, with tracks and turntables 12. A few tables and
// error messages are quadratic in them.
inline constexpr int kJoints = 64;
// Elementary transforms of one chain, fixed ones included.
inline constexpr int kTransforms = 4096;
// Elements of a URDF, and of them links: a humanoid has 100 links of 10 elements. Finding the tip looks at every branch
// from every leaf.
inline constexpr std::size_t kXmlElements = 50'000;
inline constexpr std::size_t kLinks = 2000;

// --- counts that are asked for ---------------------------------------------------------------------------------------

inline constexpr int kTrials = 1'000'000;    // 5 decimals of a coverage; a state file of some GB
inline constexpr int kPlanPoses = 100'000;   // a plan is measured pose by pose
inline constexpr int kPlanPool = 1'000'000;  // candidates are kept in memory
inline constexpr int kThreads = 1024;

// --- quantities, SI --------------------------------------------------------------------------------------------------

// Any number in a file of YAML, in its own unit: beyond, squares of it leave no digit to a metre that is added.
inline constexpr double kYamlNumber = 1e15;
// Standard deviation of a length, m: interferometers resolve 1 nm; 10 m is not knowing where a robot is. A ratio of
// 10^10 of two sigmas still leaves six digits in their weighted sum.
inline constexpr double kLeastSigma = 1e-6 / 1e3, kLargestSigma = 10.0;  // as 1e-6 mm is read
// The same of a rotation, rad.
inline constexpr double kLeastRotationSigma = 1e-9, kLargestRotationSigma = 10.0;
// A prior's standard deviation, in the unit of results: 10 km or 10^4 turns say nothing of a robot, and a column that
// is scaled by more loses the digits of the others.
inline constexpr double kLeastPriorSigma = 1e-12, kLargestPriorSigma = 1e7;
// A coordinate, m: at 1000 km the last digit of a double is 0.1 nm.
inline constexpr double kCoordinate = 1e6;
// A joint's value, rad or m: a thousand turns, with room.
inline constexpr double kJointValue = 1e5;
// Force, N, and moment, N m: a thousand tonnes.
inline constexpr double kForce = 1e7, kMoment = 1e7;
inline constexpr double kMass = 1e6;  // kg
// Compliance, rad/(N m) or m/N: 1 N m turns the joint by ten turns. Below the least one nothing moves at kMoment.
inline constexpr double kCompliance = 100.0, kLeastCompliance = 1e-18;
// Time, s: a clock in milliseconds since 1970 is 1.8e12, which is a slip; in seconds 1.8e9.
inline constexpr double kTime = 1e11;
inline constexpr double kTemperature = 5000.0;  // degC, either sign

}  // namespace sagitta::limits

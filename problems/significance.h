// The level of every test where the experiment states none (FORMATS section 3).
#pragma once

namespace sagitta {

// Of a hundred sound experiments one fails a test.
inline constexpr double kDefaultSignificance = 0.01;

}  // namespace sagitta

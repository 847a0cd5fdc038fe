#include <cstdlib>

#include "estimator/results/estimate_json.h"
#include "tests/fuzz/readers.h"

namespace sagitta {

// Of the estimators, which are not linked; reading an estimate predicts nothing.
Eigen::Matrix3Xd PredictPoints(const CalibrationProblem&, const ParameterSet&, const std::vector<int>&) {
  std::abort();
}

}  // namespace sagitta

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, size_t size) {
  return sagitta::fuzz::Feed([](const std::string& text) { sagitta::ReadEstimateText(text, "estimate.json"); }, data,
                             size);
}

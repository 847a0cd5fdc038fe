#include "estimator/results/estimate_json.h"
#include "tests/fuzz/readers.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, size_t size) {
  return sagitta::fuzz::Feed([](const std::string& text) { sagitta::ReadEstimateText(text, "estimate.json"); }, data,
                             size);
}

#include "estimator/estimate/agreement_report.h"

namespace sagitta {

std::string WordOf(SplitBy by) {
  switch (by) {
    case SplitBy::kRandom:
      return "random";
    case SplitBy::kRegion:
      return "region";
    case SplitBy::kStation:
      return "station";
    case SplitBy::kTime:
      return "time";
    case SplitBy::kMarker:
      return "marker";
    case SplitBy::kLoad:
      return "load";
  }
  return "";
}

}  // namespace sagitta

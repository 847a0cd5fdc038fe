#include "estimator/report/results_words.h"

#include "estimator/results/estimate_json.h"
#include "problems/text.h"

namespace sagitta {

std::string ModelErrorInWords(const KnownRobot& known) {
  if (!(known.model_error > 1.0)) return "";
  return "Standard deviations carry the model error that the calibration found: those of the parameters are about " +
         Significant(known.model_error, 2) + " times as large as noise alone makes them (model_error in " + known.file +
         ").";
}

std::string InputOfTheEstimate(const std::string& file) {
  return file +
         " is an input of the estimate: unless its rows were held out, these are residuals of the fit, not a "
         "validation";
}

std::string PointsAreCorrected(const std::string& dialect, int corrected, size_t points, double before, double u95) {
  std::string words =
      dialect + ": " + std::to_string(corrected) + " of " + std::to_string(points) + " points corrected";
  if (corrected == 0) return words;
  return words + "; off target before by at most " + InMillimetres(before) +
         "; 95 % uncertainty of the estimate at most " + InMillimetres(u95);
}

}  // namespace sagitta

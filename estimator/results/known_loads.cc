#include "estimator/results/known_loads.h"

#include "estimator/results/estimate_json.h"
#include "problems/input_error.h"
#include "problems/loads.h"

namespace sagitta {

void CheckLoadsAreKnown(const KnownRobot& known, const Measurements& data) {
  std::vector<std::string> loads;
  for (const auto& [name, spec] : known.loading.loads) loads.push_back(name);
  for (const Shot& shot : data.shots) {
    if (!IsLoaded(shot) || known.loading.loads.count(shot.load) > 0) continue;
    if (known.loading.load_point && !shot.wrench.IsZero()) continue;
    if (known.loading.load_point) {
      throw InputError(
          data.WhereOf(shot, "load"),
          "load '" + shot.load + "' has no weight here: the row states no wrench, and " + known.file + " no mass of it",
          "add its force and moment: fx_N, fy_N, fz_N, mx_Nm, my_Nm, mz_Nm" +
              (loads.empty() ? "" : "; or " + SpellingHint(shot.load, loads)));
    }
    throw InputError(data.WhereOf(shot, "load"), "load '" + shot.load + "' is none of those in " + known.file,
                     loads.empty() ? "it knows no load: calibrate with this one" : SpellingHint(shot.load, loads));
  }
}

}  // namespace sagitta

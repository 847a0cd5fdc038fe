#include "models/effects/typical_sizes.h"

#include <map>

namespace sagitta {

double TypicalSize(const std::string& effect, const std::string& parameter) {
  static const std::map<std::string, double> sizes = {
      // rad: transmission errors of cycloidal and strain wave gears are 0.5 to 1 arcmin (150 to 290 urad) peak to peak
      // in their data sheets.
      {"joint_harmonic", 75e-6},
      // rad: a run-out of 10 um over the 0.2 m of a main bearing (data sheets of crossed roller bearings: 5 to 20 um).
      {"axis_wobble", 50e-6},
      // 1: 75 urad, as a periodic error, over half a turn and less.
      {"encoder_gain", 100e-6},
      {"joint_coupling", 100e-6},
      // rad, half the gap: lost motion of cycloidal gears is 1 arcmin (290 urad) at most in their data sheets.
      {"backlash", 75e-6},
      {"hysteresis", 75e-6},
      // rad: mastering repeats to about 0.01 deg (handbooks of the makers).
      {"joint_slip", 150e-6},
      // 1/K: cast iron 10e-6, aluminium 23e-6.
      {"thermal_growth", 12e-6},
      // 1: 1 K of air temperature that is not compensated is 1 ppm of range; a length standard or target constant that
      // is off is tens of ppm.
      {"station_scale", 30e-6},
      // m: magnetic nests repeat to 5 to 10 um when clean (data sheets); dirt under the ball is 50 um.
      {"marker_shift", 50e-6}};
  // m, rad: what calibrations of industrial arms find (Nubiola and Bonev 2013: 0.1 to 0.7 mm, 0.1 to 0.9 mrad).
  constexpr double kGeometry = 3e-4;
  // m/s, rad/s: 20 um and 10 urad per hour, a tripod on a shop floor.
  constexpr double kDrift = 20e-6 / 3600.0, kTurn = 10e-6 / 3600.0;
  if (effect == "frozen_geometry") return kGeometry;
  if (effect == "station_drift") return parameter[0] == 'r' ? kTurn : kDrift;
  const auto found = sizes.find(effect);
  return found == sizes.end() ? 0.0 : found->second;
}

}  // namespace sagitta

// Where an effect would move the points of an arm that was really measured: the
// difference of two computed worlds, to be added to real rows.
#pragma once

#include <cstdint>
#include <string>

namespace hidden {

struct DisplacementOptions {
  std::uint64_t study = 1, number = 0;
  std::string kind;
  double scale = 1.0;
  std::string input, output;  // JSON files
};

// Input: {"joints": [{name, low_rad, high_rad}], "dh": [{theta, d, a, alpha, beta}] (rad, m),
// "stations": {S: {origin_m, rotvec_rad}}, "markers": {M: point_m},
// "rows": [{q_rad, station, marker, time_s, since_start_s, temperature_degC, approach}]}.
// Output: {"hidden": {kind, target, settings, parameters}, "displacement_mm": [[x, y, z]]}.
void WriteDisplacements(const DisplacementOptions& options);

}  // namespace hidden

// What the data do not determine, decided relative to the noise and said in words.
//
// Columns are scaled so that one unit is the largest standard deviation that
// still means anything: 5 mm, 5 mrad, and of compliances and effects what moves
// their slot by that (Coordinate::hold_limit, problems/excitation.h). With the
// singular values S of the scaled, whitened Jacobian, a direction v_i has the
// standard deviation sigma / S_i; beyond 1 it is unidentifiable.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "estimator/least_squares/linearization.h"

namespace sagitta {

struct Direction {
  std::vector<std::pair<std::string, double>> components;  // unit norm where 1 mm = 1 mrad; largest first
  double sigma = 0.0;  // standard deviation in units of the hold limit; infinity: not measured at all
  std::string words;
  std::string remedy;
};

// What the data can determine, in numbers and directions.
struct Identifiability {
  int rank = 0;
  double condition = 0.0;  // of the column-normalised Jacobian of what is estimated
  std::vector<Direction> unidentifiable;
  std::vector<Direction> weak;
};

// Columns (indices into linearization.columns) to hold so that the rest is
// identifiable, each with the direction in which it moves with the others.
struct Unidentifiable {
  std::vector<int> columns;
  std::vector<Direction> directions;
};

// sigma: scale of the whitened noise (1: as stated).
Unidentifiable FindUnidentifiable(const Linearization& linearization, const ParameterSet& parameters, double sigma);

// Directions known worse than 1 mm, 1 mrad (moved by compliances and effects) or half their value, but not held.
std::vector<Direction> FindWeak(const Linearization& linearization, const ParameterSet& parameters, double sigma);

// "a and b move together: only their sum is measured".
std::string DirectionInWords(const std::vector<std::pair<std::string, double>>& components);

}  // namespace sagitta

// Writes measurements back as a measurement file (FORMATS section 2).
#pragma once

#include <string>

#include "problems/measurements.h"

namespace sagitta {

// Every observation with its point in x_mm, y_mm, z_mm at full double precision;
// all other columns as their source file has them. Point columns stand where the
// source has them, else at the end. Several source files give one table with
// every column of any of them, empty where a row's own file lacks it; a quantity
// that the files state in different units is written in the unit seen first.
// A missing point (NaN) is an empty cell. Throws InputError for a row that is of no file: the columns of its joint
// values are not known.
std::string MeasurementsToCsv(const Measurements& data);

// The points have this standard deviation on every axis, m, whatever the rows said; 0: they are exact, and their
// columns of standard deviations are empty.
void StateSigma(double sigma, Measurements* data);

}  // namespace sagitta

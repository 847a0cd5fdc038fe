// Rows that are of no file, because a caller made them, with the cells that a file would have: what carries columns
// along then has some that say which row it is.
#pragma once

#include <optional>

#include "problems/measurements.h"

namespace sagitta {

// `data` itself where every row is of a file. Else `made` from it: rows of no file get one without a name, with the
// columns config, visit, repeat, load, station, marker, x_mm, y_mm, z_mm. No joint values: rows do not say whether a
// joint turns or slides.
const Measurements& WithCells(const Measurements& data, std::optional<Measurements>* made);

}  // namespace sagitta

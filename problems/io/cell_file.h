// cell.yaml (sagitta/cell/1, docs/FORMATS.md): what poses that are to be measured must keep to.
#pragma once

#include <string>

#include "models/chain.h"
#include "problems/cell.h"

namespace sagitta {

// Throws InputError: a joint, body or pair that the robot or the file does not have, a box without extent.
Cell ReadCellFile(const std::string& path, const Chain& chain);
Cell ReadCellText(const std::string& text, const std::string& file, const Chain& chain);

}  // namespace sagitta

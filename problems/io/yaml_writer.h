// YAML that this program's readers, and others, read as what was meant.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace sagitta {

// Maps and lists of plain values on one line; texts in quotes where they could be mistaken for a number, a truth value
// or syntax; numbers with the digits that they have.
std::string JsonToYaml(const nlohmann::ordered_json& json);

}  // namespace sagitta

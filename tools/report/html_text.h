// Texts, tables and JSON as they stand safely in a page.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace sagitta {

// For text and attributes.
std::string EscapeHtml(const std::string& text);

// For the inside of a <script type="application/json">: no character that ends the element, opens a comment in it or
// ends a line of JavaScript stands as itself.
std::string JsonInScript(const nlohmann::ordered_json& json);

// The first cell of a row is text, the others are numbers, but for columns headed "unit" and those without a heading.
std::string TableToHtml(const std::vector<std::string>& header, const std::vector<std::vector<std::string>>& rows);

}  // namespace sagitta

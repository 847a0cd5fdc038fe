#include "tools/report/html_text.h"

#include <nlohmann/json.hpp>

#include "problems/io/text_checks.h"

namespace sagitta {

std::string EscapeHtml(const std::string& text) {
  std::string escaped;
  for (const char c : ValidUtf8(Printable(text))) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string JsonInScript(const nlohmann::ordered_json& json) {
  // U+2028 and U+2029 are ASCII here already, and bytes that are no UTF-8 became U+FFFD.
  const std::string text = json.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace);
  const auto holds = [&](char c) { return text.find(c) != std::string::npos; };
  if (!holds('<') && !holds('>') && !holds('&')) return text;  // columns of numbers
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text) {
    switch (c) {
      case '<':
        safe += "\\u003c";
        break;
      case '>':
        safe += "\\u003e";
        break;
      case '&':
        safe += "\\u0026";
        break;
      default:
        safe += c;
    }
  }
  return safe;
}

std::string TableToHtml(const std::vector<std::string>& header, const std::vector<std::vector<std::string>>& rows) {
  std::string html = "<div class=\"table\"><table><thead><tr>";
  for (const std::string& cell : header) html += "<th scope=\"col\">" + EscapeHtml(cell) + "</th>";
  html += "</tr></thead><tbody>\n";
  for (const auto& row : rows) {
    html += "<tr>";
    for (size_t c = 0; c < row.size(); ++c) {
      const bool is_text = header[c] == "unit" || header[c].empty();
      html += std::string("<td") + (is_text ? " class=\"unit\"" : "") + ">" + EscapeHtml(row[c]) + "</td>";
    }
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

}  // namespace sagitta

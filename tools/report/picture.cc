#include "tools/report/picture.h"

#include <cmath>

#include "problems/interruption.h"
#include "tools/report/html_text.h"
#include "tools/report/page_parts.h"

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

Json MenusToJson(const std::vector<PictureMenu>& menus) {
  Json json = Json::object();
  for (const PictureMenu& menu : menus) {
    Json options = Json::array(), labels = Json::array();
    for (const auto& [value, label] : menu.options) {
      options.push_back(value);
      labels.push_back(label);
    }
    json[menu.signal] = {{"name", menu.name}, {"options", options}, {"labels", labels}};
  }
  return json;
}

}  // namespace

Json Rounded(double value, int digits) {
  if (!std::isfinite(value)) return nullptr;
  if (value == 0.0) return 0;
  const int decimals = digits - 1 - static_cast<int>(std::floor(std::log10(std::abs(value))));
  const double scale = std::pow(10.0, std::abs(decimals));
  if (!std::isfinite(scale)) return value;
  const double rounded = decimals > 0 ? std::round(value * scale) / scale : std::round(value / scale) * scale;
  // A whole number is shorter without its ".0".
  if (rounded == std::floor(rounded) && std::abs(rounded) < 1e15) return static_cast<long long>(rounded);
  return rounded;
}

Json RoundedColumn(const std::vector<double>& values) {
  Json column = Json::array();
  column.get_ref<Json::array_t&>().reserve(values.size());
  for (const double value : values) {
    CheckInterruption();
    column.push_back(Rounded(value));
  }
  return column;
}

std::string PictureToHtml(const Picture& picture) {
  const std::string title = EscapeHtml(picture.title);
  std::string html = "<figure class=\"picture\"><figcaption>" + title + "</figcaption>\n";
  if (HasPictures()) {
    html += "<div class=\"menus\"></div><div class=\"place\" role=\"group\" aria-label=\"" + title + "\"></div>\n";
  }
  if (!picture.rows.empty()) {
    html += "<details open><summary>Table</summary>\n" + TableToHtml(picture.header, picture.rows) + "</details>\n";
  }
  if (HasPictures()) {
    // Key by key: the data are not copied.
    html += "<script type=\"application/json\">{\"kind\":" + JsonInScript(picture.kind) +
            ",\"menus\":" + JsonInScript(MenusToJson(picture.menus)) +
            ",\"settings\":" + JsonInScript(picture.settings) + ",\"data\":";
    html += JsonInScript(picture.data);
    html += "}</script>\n";
  }
  return html + "</figure>\n";
}

}  // namespace sagitta

#include "tools/report/charts.h"

#include <algorithm>
#include <cmath>

#include "problems/text.h"

namespace sagitta {
namespace {

constexpr size_t kTableRows = 40;  // of a scatter's table: every so many of its points

Picture PictureOf(const std::string& kind, const std::string& title) {
  Picture picture;
  picture.kind = kind;
  picture.title = title;
  return picture;
}

}  // namespace

Picture ScatterPicture(const std::string& title, const std::string& x_label, const std::vector<double>& x,
                       const std::string& y_label, const std::vector<NamedSeries>& series) {
  Picture picture = PictureOf("scatter", title);
  nlohmann::ordered_json& rows = picture.data["rows"];
  picture.header = {x_label};
  for (const NamedSeries& one : series) {
    picture.header.push_back(one.name + ": " + y_label);
    for (size_t i = 0; i < x.size(); ++i) {
      if (!std::isfinite(one.values[i])) continue;
      rows["x"].push_back(Rounded(x[i]));
      rows["y"].push_back(Rounded(one.values[i]));
      rows["series"].push_back(one.name);
    }
  }
  const size_t stride = std::max<size_t>(1, (x.size() + kTableRows - 1) / kTableRows);
  for (size_t i = 0; i < x.size(); i += stride) {
    std::vector<std::string> cells = {Significant(x[i], 4)};
    for (const NamedSeries& one : series) cells.push_back(Significant(one.values[i], 4));
    picture.rows.push_back(cells);
  }
  picture.settings = {{"labels", {{"x", x_label}, {"y", y_label}}}, {"trend", false}};
  picture.menus = {
      {"x", "over", {{"x", x_label}}}, {"y", "what", {{"y", y_label}}}, {"colour", "colour", {{"series", ""}}}};
  return picture;
}

Picture CurvePicture(const std::string& title, const std::string& x_label, const std::vector<double>& x,
                     const std::string& y_label, const std::vector<double>& y) {
  Picture picture = ScatterPicture(title, x_label, x, y_label, {{"", y}});
  picture.settings["joined"] = true;
  picture.header.back() = y_label;
  return picture;
}

Picture BarPicture(const std::string& title, const std::string& x_label, const std::vector<Bar>& bars) {
  Picture picture = PictureOf("bars", title);
  picture.settings = {{"xTitle", x_label}};
  PictureMenu menu{"group", "by", {}};
  nlohmann::ordered_json& rows = picture.data["rows"];
  for (const Bar& bar : bars) {
    rows["group"].push_back(bar.group);
    rows["name"].push_back(bar.name);
    rows["value"].push_back(Rounded(bar.value));
    const std::pair<std::string, std::string> option{bar.group, bar.group};
    if (std::find(menu.options.begin(), menu.options.end(), option) == menu.options.end())
      menu.options.push_back(option);
  }
  picture.menus = {menu};
  const bool grouped = menu.options.size() > 1;
  picture.header = grouped ? std::vector<std::string>{"by", "", x_label} : std::vector<std::string>{"", x_label};
  for (const Bar& bar : bars) {
    picture.rows.push_back(grouped ? std::vector<std::string>{bar.group, bar.name, Significant(bar.value, 3)}
                                   : std::vector<std::string>{bar.name, Significant(bar.value, 3)});
  }
  return picture;
}

Picture WaterfallPicture(const std::string& title, const std::string& x_label, const std::vector<Stage>& stages,
                         double floor, const std::string& floor_name) {
  Picture picture = PictureOf("waterfall", title);
  picture.settings = {{"xTitle", x_label}};
  if (std::isfinite(floor)) {
    picture.settings["floor"] = Rounded(floor);
    picture.settings["floorName"] = floor_name + " " + Significant(floor, 3);
  }
  picture.header = {"after", x_label};
  nlohmann::ordered_json& data = picture.data["stages"];
  for (const Stage& stage : stages) {
    if (!std::isfinite(stage.value)) continue;
    data["stage"].push_back(stage.name);
    data["value"].push_back(Rounded(stage.value));
    picture.rows.push_back({stage.name, Significant(stage.value, 3)});
  }
  if (std::isfinite(floor)) picture.rows.push_back({floor_name, Significant(floor, 3)});
  return picture;
}

}  // namespace sagitta

// A picture of a page: numbers for a template (page/pictures/KIND.json, a Vega specification; "workspace": the arm in
// 3-D), menus that choose among them, and the same for readers as a table.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace sagitta {

// Chooses the value of a signal of the template.
struct PictureMenu {
  std::string signal, name;
  std::vector<std::pair<std::string, std::string>> options;  // value and how it reads; the first one is shown
};

struct Picture {
  std::string kind, title;
  nlohmann::ordered_json data = nlohmann::ordered_json::object();      // data set of the template: column: values
  nlohmann::ordered_json settings = nlohmann::ordered_json::object();  // signal of the template: value
  std::vector<PictureMenu> menus;
  std::vector<std::string> header;  // of the table
  std::vector<std::vector<std::string>> rows;
};

// To so many significant digits, as short as it is written; null: not a number.
nlohmann::ordered_json Rounded(double value, int digits = 4);
nlohmann::ordered_json RoundedColumn(const std::vector<double>& values);

std::string PictureToHtml(const Picture& picture);

}  // namespace sagitta

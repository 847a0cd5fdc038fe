// Pieces of inline SVG, in pixels with one decimal. A style is a class of the page's style sheet; texts are escaped.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace sagitta {

// For text and attributes, of HTML and SVG alike.
std::string EscapeHtml(const std::string& text);

namespace svg {

// anchor: start, middle or end of the text stands at x.
std::string Text(double x, double y, const std::string& anchor, const std::string& text);

// The title shows under the pointer; "": none.
std::string Rectangle(double x, double y, double width, double height, const std::string& style,
                      const std::string& title = "");

// Dots of one style as one path: large charts stay small.
std::string Dots(const std::vector<std::pair<double, double>>& points, const std::string& style);

// From the left edge.
std::string LevelLine(double y, double width, const std::string& style);

std::string Curve(const std::vector<std::pair<double, double>>& points);

// The whole, with a title for those who hear the page.
std::string Picture(double width, double height, const std::string& title, const std::string& body);

}  // namespace svg
}  // namespace sagitta

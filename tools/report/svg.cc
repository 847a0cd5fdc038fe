#include "tools/report/svg.h"

#include "problems/io/text_checks.h"
#include "tools/report/summary.h"

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

namespace svg {
namespace {

std::string N(double value) { return Fixed(value, 1); }

}  // namespace

std::string Text(double x, double y, const std::string& anchor, const std::string& text) {
  return "<text x=\"" + N(x) + "\" y=\"" + N(y) + "\" text-anchor=\"" + anchor + "\">" + EscapeHtml(text) + "</text>";
}

std::string Rectangle(double x, double y, double width, double height, const std::string& style,
                      const std::string& title) {
  return "<rect class=\"" + style + "\" x=\"" + N(x) + "\" y=\"" + N(y) + "\" width=\"" + N(width) + "\" height=\"" +
         N(height) + "\"" + (title.empty() ? "/>" : "><title>" + EscapeHtml(title) + "</title></rect>");
}

std::string Dots(const std::vector<std::pair<double, double>>& points, const std::string& style) {
  std::string path;
  for (const auto& [x, y] : points) path += "M" + N(x) + " " + N(y) + "h0";
  return "<path class=\"" + style + "\" d=\"" + path + "\"/>";
}

std::string LevelLine(double y, double width, const std::string& style) {
  return "<line class=\"" + style + "\" x1=\"0\" x2=\"" + N(width) + "\" y1=\"" + N(y) + "\" y2=\"" + N(y) + "\"/>";
}

std::string Curve(const std::vector<std::pair<double, double>>& points) {
  std::string list;
  for (const auto& [x, y] : points) list += N(x) + "," + N(y) + " ";
  return "<polyline class=\"line\" points=\"" + list + "\"/>";
}

std::string Picture(double width, double height, const std::string& title, const std::string& body) {
  return "<svg role=\"img\" width=\"" + N(width) + "\" height=\"" + N(height) + "\" viewBox=\"0 0 " + N(width) + " " +
         N(height) + "\"><title>" + EscapeHtml(title) + "</title>" + body + "</svg>\n";
}

}  // namespace svg
}  // namespace sagitta

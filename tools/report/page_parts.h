// What a page carries in addition to its text: style, the libraries that draw, templates of pictures. Made of page/ and
// of the packages libjs-vega and libjs-three when the program is built (page/embed.cmake).
#pragma once

#include <string_view>

namespace sagitta::page {

extern const std::string_view kStyle;      // page.css
extern const std::string_view kTemplates;  // JSON, kind of picture: Vega specification
extern const std::string_view kVega;       // JavaScript; empty: the package was missing
extern const std::string_view kThree;      // three.js with OrbitControls; empty: the package was missing
extern const std::string_view kDrawing;    // page.js

}  // namespace sagitta::page

namespace sagitta {

// Whether pages can draw; else they have the tables of their pictures alone.
inline bool HasPictures() { return !page::kVega.empty() && !page::kThree.empty(); }

}  // namespace sagitta

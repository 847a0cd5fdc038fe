// Small pictures that several reports share, and their tables.
#pragma once

#include <string>
#include <vector>

#include "tools/report/picture.h"

namespace sagitta {

// A curve through points.
Picture CurvePicture(const std::string& title, const std::string& x_label, const std::vector<double>& x,
                     const std::string& y_label, const std::vector<double>& y);

// Named values over each x, each in its colour (a point where it is a number), as what was measured and what the model
// says there.
struct NamedSeries {
  std::string name;
  std::vector<double> values;
};
Picture ScatterPicture(const std::string& title, const std::string& x_label, const std::vector<double>& x,
                       const std::string& y_label, const std::vector<NamedSeries>& series);

struct Bar {
  std::string group, name;
  double value;
};
// Where there are several groups, a menu chooses one.
Picture BarPicture(const std::string& title, const std::string& x_label, const std::vector<Bar>& bars);

// A value after each stage, what each stage removed, and the floor that none can go below. A stage whose value is no
// number is left out.
struct Stage {
  std::string name;
  double value;
};
Picture WaterfallPicture(const std::string& title, const std::string& x_label, const std::vector<Stage>& stages,
                         double floor, const std::string& floor_name);

}  // namespace sagitta

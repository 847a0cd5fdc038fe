// Names of columns as people write them: "Joint_1 [deg]", "measurement_x", "θ (°)", "x_mm".
#pragma once

#include <set>
#include <string>
#include <vector>

namespace sagitta {

// The unit that a header states, in this project's spelling (mm, cm, m, um, in, deg, rad, mrad, urad,
// s, degC, N, Nm), "" when there is none: in brackets or parentheses, as a suffix after
// an underscore or a blank.
std::string UnitInHeader(const std::string& header);

// A unit of a table, read or not: mm, inches, gon.
bool IsUnit(const std::string& word);

// Of "J1 [gon]" the name and the unit that is not read; both empty where nothing looks like one.
struct NameWithUnreadUnit {
  std::string name, unit;
};
NameWithUnreadUnit UnreadUnitIn(const std::string& header);

// The header without its unit, blanks trimmed: as written, and in lower case.
std::string StemOf(const std::string& header);
std::string NameWithoutUnit(const std::string& header);

// Words of a name: "measurement_std_x" -> {measurement, std, x}; "TargetQ1" -> {target, q, 1};
// digits are words of their own.
std::vector<std::string> WordsOf(const std::string& name);

// Whether one of the words is one of these.
bool Has(const std::vector<std::string>& words, const std::set<std::string>& set);

// fx, fy, fz, mx, my, mz: columns of a wrench, in their order.
const std::vector<std::string>& WrenchNames();

// 0, 1, 2 of "x", "y", "z"; -1 of any other word.
int AxisNamed(const std::string& word);

}  // namespace sagitta

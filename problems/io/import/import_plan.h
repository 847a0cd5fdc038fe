// How the columns of a foreign table become those of measurements.csv.
//
// Names decide where they say something. Where they leave a choice (units, a table
// without header) every reading is a plan of its own, and the robot decides: the one
// that its nominal geometry can have made.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "models/chain.h"
#include "problems/io/import/rotation_reading.h"
#include "problems/io/import/text_table.h"

namespace sagitta {

// Of P_07_SMR2 the whole, P, SMR2, P_07, 07, SMR2, nothing: parts end at signs that are no letters or digits, and of
// A::SMR1::P001 the second is SMR1.
enum class NamePart { kWhole, kFirst, kLast, kButLast, kSecond, kThird, kFourth };
std::string PartOfName(const std::string& name, NamePart part);

struct PlannedColumn {
  std::string stem;  // q1, x, sigma_x, rx, ow, tau1, temperature, time, config …
  std::string unit;  // of the source: mm, m, um, deg …; "1" of a quaternion; "" for texts
  int source = -1;   // column of the table
  int second = -1;   // another one, added with `sign`
  double sign = 1.0;
  NamePart part = NamePart::kWhole;  // of a text: which part of its cells
  std::string text_unit;             // of a text: what the header says, as kg of a load
  std::string header;                // as the table has it, for people
  std::string meaning;               // in words
  bool is_mapped = false;            // --map says it
};

struct ImportPlan {
  std::vector<PlannedColumn> columns;
  std::vector<std::pair<std::string, std::string>> unused;  // header, why
  std::vector<std::string> moved_axes;  // headers of those that are axes outside the arm and did not stand still
  std::vector<std::string> guesses;
  std::vector<PlannedColumn> other_times;  // columns that may be the time where the one in `columns` is not
  std::string choice;                      // what distinguishes this plan from the others, in words

  // Columns of a rotation and its standard deviations, used once it is known what they mean.
  std::vector<PlannedColumn> rotation_columns;
  bool rotation_is_mapped = false;  // --map says rx, ry, rz: a rotation vector unless --rotation says otherwise
  bool has_header = true;           // else nothing says that these columns are a rotation, nor which number is which
  std::optional<RotationReading> rotation;

  bool HasQuaternion() const { return !rotation_columns.empty() && rotation_columns[0].stem[0] == 'o'; }
  const PlannedColumn* Find(const std::string& stem) const;
  // A column of the table by its place and header.
  void Add(const std::string& stem, const std::string& unit, int source, const std::string& header,
           const std::string& meaning);
};

// `columns`: what the user says, as in {"x_mm", "measurement_x"}; a header, the
// number of a column from 1, or the sum or difference of two (a+b, a-b). At least
// one plan; throws InputError where the table cannot be measurements of these joints.
std::vector<ImportPlan> PossiblePlans(const TextTable& table, const std::vector<Joint>& joints,
                                      const std::map<std::string, std::string>& columns);

// The plan by the size of the numbers alone, where no fit can decide.
size_t PlanBySize(const TextTable& table, const std::vector<ImportPlan>& plans);

}  // namespace sagitta

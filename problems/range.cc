#include "problems/range.h"

#include <fmt/format.h>

#include "problems/input_error.h"
#include "problems/text.h"

namespace sagitta {

bool Range::Has(double value) const {
  if (may_be_zero && value == 0.0) return true;
  return is_open ? low < value && value < high : low <= value && value <= high;
}

std::string Range::Refusal(double value) const {
  const char* format = is_open ? "{}{} between {} and {}{} is expected, this is {}{}{}"
                               : "{}{} from {} to {}{} is expected, this is {}{}{}";
  const char* below = value < 0.0 && low >= 0.0 ? "below 0: " : "";
  return fmt::format(fmt::runtime(format), may_be_zero ? "0 or " : "", what, Significant(low, 7), Significant(high, 7),
                     unit, below, value, unit);
}

void CheckIn(const Range& range, double value, const std::string& name) {
  if (!range.Has(value)) throw InputError({"", 0, name}, range.Refusal(value));
}

}  // namespace sagitta

// Other ways to read a part of the rows (inspection/part_readings.h, wrong_part.h), in words that complete "with … they
// fit", and what is said of such a part.
#pragma once

#include <string>
#include <vector>

#include "estimator/report/inspection_reading_words.h"

namespace sagitta {

// The points of shots that stand in the reverse order, of two shots only where they are two.
Advice PointsReversed(bool are_two);
// The points in the order that the names of the configurations have as text, else as numbers.
Advice PointsInOrderOfNames(bool as_text);
Advice MarkersExchanged(const std::vector<std::string>& markers);
Advice PointsTimes(bool thousand);  // or a thousandth

// A part of the rows that was read in another way than the others.
struct WrongPartInWords {
  std::string which;               // "of station S2", "from m.csv:60 on"
  size_t rows = 0, all = 0;        // of the part, and of all
  double misfit = 0.0;             // m RMS, as stated
  double others = 0.0;             // m RMS, of the others
  double as_read = 0.0;            // m RMS, with the other reading
  std::vector<std::string> alike;  // other readings that fit as well
};
Advice PartIsReadOtherwise(const WrongPartInWords& part, const Advice& reading);

// Points of a station that rise or fall along an axis from shot to shot, and that the robot fits (m RMS) in another
// order.
Advice PointsAreSorted(size_t shots, int axis, bool falls, const std::string& station, const std::string& marker,
                       double as_read);

std::string RowsOfStations(const std::vector<std::string>& stations);
std::string RowsOfMarkers(const std::vector<std::string>& markers);
// Rows from `first` to `last`; "" where no other row follows.
std::string RowsBetween(const std::string& first, const std::string& last);
std::string RowsOfShots(size_t shots, const std::string& first, const std::string& last);

}  // namespace sagitta

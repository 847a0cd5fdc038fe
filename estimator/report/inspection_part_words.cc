#include "estimator/report/inspection_part_words.h"

#include "problems/text.h"

namespace sagitta {

Advice PointsReversed(bool are_two) {
  if (are_two) return {"the points of these two shots exchanged", "exchange the points of the two shots"};
  return {"the points in reverse order", "joint values and points run in opposite orders: reverse one of them"};
}

Advice PointsInOrderOfNames(bool as_text) {
  return {std::string("the points in the order of the configurations' names ") +
              (as_text ? "as text (1, 10, 2)" : "as numbers (1, 2, 10)"),
          "joint values and points were sorted differently: bring both into one order"};
}

Advice MarkersExchanged(const std::vector<std::string>& markers) {
  return {"markers " + Enumerate(markers) + (markers.size() == 2 ? " exchanged" : " exchanged in turn"),
          "exchange the marker names"};
}

Advice PointsTimes(bool thousand) {
  return {std::string("the measured points 1000 times ") +
              (thousand ? "as large (metres in place of millimetres)" : "as small (millimetres in place of metres)"),
          "convert x, y, z to the unit of the others"};
}

Advice PartIsReadOtherwise(const WrongPartInWords& part, const Advice& reading) {
  std::string words = std::to_string(part.rows) + " of " + std::to_string(part.all) + " rows, those " + part.which +
                      ", miss by " + InMillimetres(part.misfit) +
                      " (RMS), while the others fit the nominal robot within " + InMillimetres(part.others) +
                      "; they fit within " + InMillimetres(part.as_read) + " with " + reading.words;
  if (!part.alike.empty()) words += ", and just as well with " + Enumerate(part.alike);
  return {words, "for these rows alone: " + reading.remedy};
}

Advice PointsAreSorted(size_t shots, int axis, bool falls, const std::string& station, const std::string& marker,
                       double as_read) {
  const std::string name(1, kAxisLetters[axis]);
  return {"the points of station " + station + " were sorted by " + name + " and the joint values were not: " + name +
              " of marker " + marker + (falls ? " falls" : " rises") + " from shot to shot in all " +
              std::to_string(shots) +
              ", and each point with other joint values of the file fits the nominal robot within " +
              InMillimetres(as_read) + " (RMS)",
          "export points and joint values again, in the order of measurement"};
}

std::string RowsOfStations(const std::vector<std::string>& stations) {
  return (stations.size() == 1 ? "of station " : "of stations ") + Enumerate(stations);
}

std::string RowsOfMarkers(const std::vector<std::string>& markers) {
  return (markers.size() == 1 ? "of marker " : "of markers ") + Enumerate(markers);
}

std::string RowsBetween(const std::string& first, const std::string& last) {
  return "from " + first + (last.empty() ? " on" : " to " + last);
}

std::string RowsOfShots(size_t shots, const std::string& first, const std::string& last) {
  return "of " + std::to_string(shots) + " shots (the first: " + first + ", the last: " + last + ")";
}

}  // namespace sagitta

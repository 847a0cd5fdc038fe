#include "estimator/inspection/part_readings.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "estimator/report/inspection_part_words.h"

namespace sagitta {
namespace {

// The same row in the whole problem and in one that is made of some of its configurations.
using RowKey = std::pair<int, int>;

RowKey KeyOf(const Measurements& data, const Observation& row) {
  if (row.file < 0) return {-1, static_cast<int>(&row - data.observations.data())};
  return {row.file, data.files[row.file].rows.LineOf(static_cast<size_t>(row.row))};
}

// Row rows[k] gets the point of `from[k]`; -1: none, it is left out.
Reading Reordered(const Measurements& data, const std::vector<int>& rows, const std::vector<int>& from,
                  const Advice& advice) {
  std::map<RowKey, int> points_of;
  for (size_t k = 0; k < rows.size(); ++k) points_of[KeyOf(data, data.observations[rows[k]])] = from[k];
  std::map<int, Vector3<double>> points;
  for (const int i : from) {
    if (i >= 0) points[i] = data.observations[i].point_in_station;
  }
  const auto change = [points_of, points](Measurements* changed) {
    for (Observation& row : changed->observations) {
      const auto found = row.is_point() ? points_of.find(KeyOf(*changed, row)) : points_of.end();
      if (found == points_of.end()) continue;
      row.excluded |= found->second < 0;
      if (found->second >= 0) row.point_in_station = points.at(found->second);
    }
  };
  return {"row_order", advice.words, advice.remedy, change, false, {}};
}

// Rows of one station, shot by shot in the order of the files.
using Shots = std::vector<std::vector<int>>;

std::map<int, Shots> ShotsByStation(const Measurements& data, const std::vector<int>& rows) {
  std::map<int, Shots> shots;
  int latest = -1;
  for (const int i : rows) {
    const int shot = data.observations[i].shot;
    Shots& own = shots[data.shots[shot].station];
    if (shot != latest || own.empty()) own.emplace_back();
    own.back().push_back(i);
    latest = shot;
  }
  return shots;
}

// Places of n shots: the k-th is to have the points of the shot at place order[k]; -1: of none.
using Order = std::vector<int>;

Order ShiftedBy(int by, int n) {
  Order order(n);
  for (int k = 0; k < n; ++k) order[k] = k + by >= 0 && k + by < n ? k + by : -1;
  return order;
}

// Points that stand in the order that `less` sorts the configurations' names by.
template <typename Less>
Order SortedBy(const std::vector<std::string>& names, const Less& less) {
  const int n = static_cast<int>(names.size());
  std::vector<int> sorted(n);
  std::iota(sorted.begin(), sorted.end(), 0);
  std::stable_sort(sorted.begin(), sorted.end(), [&](int a, int b) { return less(names[a], names[b]); });
  Order order(n);
  for (int k = 0; k < n; ++k) order[sorted[k]] = k;
  return order;
}

bool IsShorterOrLess(const std::string& a, const std::string& b) {
  return std::make_pair(a.size(), a) < std::make_pair(b.size(), b);
}

class Orders {
 public:
  Orders(const Measurements& data, const std::vector<int>& rows) : data_(data), shots_(ShotsByStation(data, rows)) {}

  // order: of the shots of a station, from their names.
  template <typename OrderOf>
  void Add(const OrderOf& order_of, const char* code, const Advice& advice, std::vector<Reading>* readings) const {
    std::vector<int> rows, from;
    bool changes = false;
    for (const auto& [station, shots] : shots_) {
      const Order order = order_of(NamesOf(shots));
      for (size_t k = 0; k < shots.size(); ++k) {
        changes |= order[k] != static_cast<int>(k);
        for (const int i : shots[k]) {
          rows.push_back(i);
          from.push_back(order[k] < 0 ? -1 : SameMarker(shots[order[k]], i));
        }
      }
    }
    if (!changes) return;
    readings->push_back(Reordered(data_, rows, from, advice));
    readings->back().code = code;
  }

  size_t Most() const {
    size_t most = 0;
    for (const auto& [station, shots] : shots_) most = std::max(most, shots.size());
    return most;
  }

 private:
  std::vector<std::string> NamesOf(const Shots& shots) const {
    std::vector<std::string> names;
    for (const std::vector<int>& shot : shots)
      names.push_back(data_.ConfigurationOf(data_.observations[shot.front()]).id);
    return names;
  }

  int SameMarker(const std::vector<int>& shot, int row) const {
    const auto is_same = [&](int i) { return data_.observations[i].marker == data_.observations[row].marker; };
    const auto found = std::find_if(shot.begin(), shot.end(), is_same);
    return found == shot.end() ? -1 : *found;
  }

  const Measurements& data_;
  std::map<int, Shots> shots_;
};

void AddOrders(const Measurements& data, const std::vector<int>& rows, std::vector<Reading>* readings) {
  constexpr size_t kFewestShifted = 3;  // shots: of two a shift would leave one
  using Names = std::vector<std::string>;
  const Orders orders(data, rows);
  const auto reversed = [](const Names& names) {
    Order order(names.size());
    for (size_t k = 0; k < order.size(); ++k) order[k] = static_cast<int>(order.size() - 1 - k);
    return order;
  };
  orders.Add(reversed, "row_order", PointsReversed(orders.Most() == 2), readings);
  for (const int by : {-1, 1}) {
    if (orders.Most() < kFewestShifted) break;
    const auto shifted = [by](const Names& names) { return ShiftedBy(by, static_cast<int>(names.size())); };
    orders.Add(shifted, "row_shift", RowsShifted(by < 0), readings);
  }
  orders.Add([](const Names& names) { return SortedBy(names, std::less<>()); }, "row_order", PointsInOrderOfNames(true),
             readings);
  orders.Add([](const Names& names) { return SortedBy(names, IsShorterOrLess); }, "row_order",
             PointsInOrderOfNames(false), readings);
}

// now[m]: the marker that rows of marker m are of.
Reading Relabelled(const std::vector<int>& now, const Advice& advice) {
  const auto change = [now](Measurements* data) {
    for (Observation& row : data->observations) row.marker = now[row.marker];
  };
  return {"marker_swap", advice.words, advice.remedy, change, false, {}};
}

void AddExchanges(const CalibrationProblem& problem, const std::vector<int>& rows, std::vector<Reading>* readings) {
  const Measurements& data = problem.data();
  std::set<int> seen;
  for (const int i : rows) seen.insert(data.observations[i].marker);
  const std::vector<int> markers(seen.begin(), seen.end());
  std::vector<int> straight(data.markers.size());
  std::iota(straight.begin(), straight.end(), 0);
  // Those of `cycle` each in place of the one before.
  const auto add = [&](const std::vector<int>& cycle) {
    std::vector<int> now = straight;
    std::vector<std::string> names;
    for (size_t k = 0; k < cycle.size(); ++k) {
      if (problem.marker_frames()[cycle[k]] != problem.marker_frames()[cycle[0]]) return;
      now[cycle[k]] = cycle[(k + 1) % cycle.size()];
      names.push_back(data.markers[cycle[k]]);
    }
    readings->push_back(Relabelled(now, MarkersExchanged(names)));
  };
  const int n = static_cast<int>(markers.size());
  for (int a = 0; a < n; ++a) {
    for (int b = a + 1; b < n; ++b) add({markers[a], markers[b]});
  }
  for (int a = 0; a < n; ++a) {
    for (int b = a + 1; b < n; ++b) {
      for (int c = b + 1; c < n; ++c) {
        add({markers[a], markers[b], markers[c]});
        add({markers[a], markers[c], markers[b]});
      }
    }
  }
}

void AddUnitsOfPoints(std::vector<Reading>* readings) {
  for (const double factor : {1e3, 1e-3}) {
    const Advice advice = PointsTimes(factor > 1.0);
    const auto scale = [factor](Measurements* data) {
      for (Observation& row : data->observations) row.point_in_station *= factor;
    };
    readings->push_back({"unit", advice.words, advice.remedy, scale, false, {}});
  }
}

// Whether the joint values of the part can be others than those of all other rows: of one or two configurations some
// reading fits by chance.
bool MayHaveOtherJoints(const Measurements& data, const PartOfRows& part) {
  constexpr size_t kFewestConfigurations = 3;
  const auto configurations = [&](const std::vector<int>& rows) {
    std::set<int> seen;
    for (const int i : rows) seen.insert(data.shots[data.observations[i].shot].configuration);
    return seen;
  };
  const std::set<int> own = configurations(part.rows), others = configurations(part.others);
  return own.size() >= kFewestConfigurations &&
         std::none_of(own.begin(), own.end(), [&](int configuration) { return others.count(configuration) > 0; });
}

}  // namespace

std::vector<Reading> ReadingsOfPart(const CalibrationProblem& problem, const PartOfRows& part) {
  std::vector<Reading> readings;
  AddExchanges(problem, part.rows, &readings);
  AddOrders(problem.data(), part.with_held_out, &readings);
  AddUnitsOfPoints(&readings);
  const bool joints_may_differ = MayHaveOtherJoints(problem.data(), part);
  std::vector<Reading> of_file = AllReadings(problem);
  std::stable_partition(of_file.begin(), of_file.end(), [](const Reading& reading) { return !reading.changes_joints; });
  for (Reading& reading : of_file) {
    if (reading.robot || reading.is_of_order || (reading.changes_joints && !joints_may_differ)) continue;
    readings.push_back(std::move(reading));
  }
  return readings;
}

}  // namespace sagitta

#include "estimator/inspection/wrong_part.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <set>

#include "estimator/alignment/aligned_misfit.h"
#include "estimator/alignment/starting_values.h"
#include "estimator/inspection/part_readings.h"
#include "estimator/inspection/reading_lint.h"
#include "estimator/inspection/sampled_problem.h"
#include "estimator/inspection/tried_readings.h"
#include "estimator/report/inspection_part_words.h"

namespace sagitta {
namespace {

constexpr size_t kEquationsPerPlace = 2;  // of places: from here on a fit of them alone says something
constexpr size_t kMostRowsOfPart = 1000;
constexpr double kMostExceptions = 0.2;  // of the far shots: one block holds the others
constexpr size_t kFewestOfWrong = 4;  // rows: of fewer each is named by itself, and a robust loss goes on without them

std::set<int> StationsOf(const Measurements& data, const std::vector<int>& rows) {
  std::set<int> stations;
  for (const int i : rows) stations.insert(data.shots[data.observations[i].shot].station);
  return stations;
}

// Base poses and points of the markers that the rows see.
bool DeterminePlaces(const Measurements& data, const std::vector<int>& rows) {
  const size_t unknowns = 6 * StationsOf(data, rows).size() + 3 * MarkersOfRows(data, rows).size();
  return 3 * rows.size() >= kEquationsPerPlace * unknowns;
}

// Holds the places of the stations and markers that the rows see, or of all others.
void HoldPlaces(const Measurements& data, const std::vector<int>& rows, bool seen, ParameterSet* parameters) {
  const std::set<int> stations = StationsOf(data, rows), markers = MarkersOfRows(data, rows);
  for (int i = 0; i < parameters->num_coordinates(); ++i) {
    const ParameterBlock& block = parameters->blocks()[parameters->coordinates()[i].block];
    if (block.kind == BlockKind::kModelParameter) continue;
    const bool is_station = block.kind == BlockKind::kStationTranslation || block.kind == BlockKind::kStationRotation;
    const bool is_seen = (is_station ? stations : markers).count(block.owner) > 0;
    if (is_seen == seen) parameters->coordinate(i).free = false;
  }
}

// The problem of these rows alone, with nothing held out.
CalibrationProblem OnlyRows(const CalibrationProblem& problem, const std::vector<int>& rows) {
  CalibrationProblem only = problem;
  Measurements& data = *only.mutable_data();
  for (Observation& row : data.observations) row.excluded = true;
  for (const int i : rows) data.ExcludeRow(i, false);
  return only;
}

// Places fitted to the rows; m RMS of distances.
double FitPlaces(const CalibrationProblem& problem, const std::vector<int>& rows, ParameterSet* parameters) {
  CalibrationProblem only = OnlyRows(problem, rows);
  HoldPlaces(problem.data(), rows, false, &only.parameters);
  const std::vector<int> some = SampleOfRows(only);
  ParameterSet fitted = only.parameters;
  const double rms = FindStartingValues(only, some, &fitted);
  *parameters = problem.parameters;
  for (const int s : StationsOf(problem.data(), rows)) parameters->SetBaseInStation(s, fitted.BaseInStation(s));
  for (const int m : MarkersOfRows(problem.data(), rows)) {
    parameters->SetMarkerPoint(m, fitted.MarkerPoint(m));
    if (parameters->is_oriented(m)) parameters->SetMarkerRotation(m, fitted.MarkerRotation(m));
  }
  return rms;
}

std::vector<int> FittedPoints(const CalibrationProblem& problem) {
  return problem.data().PointsAmong(problem.CalibrationObservations());
}

// Rows of the labels that the nominal robot misses, each label alone, where it fits those of the others.
std::optional<PartOfRows> PartOfLabels(const CalibrationProblem& problem, PartOfRows::Kind kind) {
  const Measurements& data = problem.data();
  const bool of_stations = kind == PartOfRows::Kind::kStations;
  const auto label_of = [&](const Observation& row) { return of_stations ? data.shots[row.shot].station : row.marker; };
  const std::vector<int> points = FittedPoints(problem);
  std::map<int, std::vector<int>> by_label;
  for (const int i : points) by_label[label_of(data.observations[i])].push_back(i);
  std::set<int> wrong;
  ParameterSet places;
  for (const auto& [label, rows] : by_label) {
    if (by_label.size() < 2) return std::nullopt;
    if (!DeterminePlaces(data, rows)) continue;
    if (FitPlaces(problem, rows, &places) > SuspiciousMisfit(problem)) wrong.insert(label);
  }
  if (wrong.empty() || wrong.size() == by_label.size()) return std::nullopt;
  PartOfRows part;
  part.kind = kind;
  for (const int label : wrong) part.labels.push_back((of_stations ? data.stations : data.markers)[label]);
  for (const int i : points) (wrong.count(label_of(data.observations[i])) > 0 ? part.rows : part.others).push_back(i);
  for (size_t i = 0; i < data.observations.size(); ++i) {
    const Observation& row = data.observations[i];
    if (row.is_point() && !row.excluded && wrong.count(label_of(row)) > 0)
      part.with_held_out.push_back(static_cast<int>(i));
  }
  if (!DeterminePlaces(data, part.others)) return std::nullopt;
  part.others_rms = FitPlaces(problem, part.others, &part.parameters);
  if (!(part.others_rms <= SuspiciousMisfit(problem))) return std::nullopt;
  return part;
}

// The shots that follow one another and among which more of those with a far row are than of the others, by most:
// the places of the first and the one past the last.
std::pair<size_t, size_t> FarBlock(const std::vector<bool>& is_far) {
  std::pair<size_t, size_t> best = {0, 0};
  int most = 0, sum = 0;
  for (size_t k = 0, first = 0; k < is_far.size(); ++k) {
    sum += is_far[k] ? 1 : -1;
    if (sum <= 0) {
      sum = 0;
      first = k + 1;
    } else if (sum > most) {
      most = sum;
      best = {first, k + 1};
    }
  }
  return best;
}

// Rows that are far off, and the others of their stations and markers, by shot.
class FarShots {
 public:
  FarShots(const CalibrationProblem& problem, const FarRows& far)
      : problem_(problem),
        far_(far),
        stations_(StationsOf(problem.data(), far.far)),
        markers_(MarkersOfRows(problem.data(), far.far)),
        points_(far.near) {
    points_.insert(points_.end(), far.far.begin(), far.far.end());
    std::sort(points_.begin(), points_.end());
    const std::set<int> off(far.far.begin(), far.far.end());
    for (const int i : points_) {
      if (!IsConcerned(i)) continue;
      if (shots_.empty() || shots_.back() != ShotOf(i)) {
        shots_.push_back(ShotOf(i));
        first_.push_back(i);
        is_far_.push_back(false);
      }
      if (off.count(i) > 0) is_far_.back() = true;
    }
  }

  // Those among which the far rows are, where these follow one another but for exceptions; all shots that have some.
  std::vector<PartOfRows> Parts() const {
    const auto [from, past] = FarBlock(is_far_);
    const auto inside = std::count(is_far_.begin() + static_cast<std::ptrdiff_t>(from),
                                   is_far_.begin() + static_cast<std::ptrdiff_t>(past), true);
    const auto all = std::count(is_far_.begin(), is_far_.end(), true);
    const int begin = first_[from];
    const int end = past < first_.size() ? first_[past] : static_cast<int>(problem_.data().observations.size());
    const std::set<int> off = ShotsThatAreFar();
    std::vector<PartOfRows> parts;
    if (inside < all) {
      parts.push_back(Part(PartOfRows::Kind::kShots, [&](int i) { return off.count(ShotOf(i)) > 0; }));
    }
    if (static_cast<double>(all - inside) <= kMostExceptions * static_cast<double>(all)) {
      parts.push_back(Part(PartOfRows::Kind::kBlock, [&](int i) { return i >= begin && i < end; }));
    }
    return parts;
  }

 private:
  int ShotOf(int i) const { return problem_.data().observations[i].shot; }

  bool IsConcerned(int i) const {
    const Observation& row = problem_.data().observations[i];
    return row.is_point() && markers_.count(row.marker) > 0 &&
           stations_.count(problem_.data().shots[row.shot].station) > 0;
  }

  std::set<int> ShotsThatAreFar() const {
    std::set<int> off;
    for (size_t k = 0; k < shots_.size(); ++k) {
      if (is_far_[k]) off.insert(shots_[k]);
    }
    return off;
  }

  template <typename Contains>
  PartOfRows Part(PartOfRows::Kind kind, const Contains& contains) const {
    const Measurements& data = problem_.data();
    const std::set<int> off(far_.far.begin(), far_.far.end());
    PartOfRows part;
    part.kind = kind;
    part.parameters = far_.parameters;
    part.others_rms = far_.near_rms;
    if (markers_.size() < data.markers.size()) {
      for (const int m : markers_) part.labels.push_back(data.markers[m]);
    }
    for (const int i : points_) {
      if (contains(i) && IsConcerned(i)) {
        part.rows.push_back(i);
      } else if (off.count(i) == 0) {
        part.others.push_back(i);
      }
    }
    for (int i = part.rows.front(); i <= part.rows.back(); ++i) {
      if (contains(i) && IsConcerned(i) && !data.observations[i].excluded) part.with_held_out.push_back(i);
    }
    return part;
  }

  const CalibrationProblem& problem_;
  const FarRows& far_;
  std::set<int> stations_, markers_;
  std::vector<int> points_;         // observations
  std::vector<int> shots_, first_;  // the shots concerned, and a row of each
  std::vector<bool> is_far_;        // of each
};

// Rows of one station that are far from places that its first shots fit, or its last ones: a half, a quarter, an
// eighth.
std::optional<FarRows> FarFromOneEnd(const CalibrationProblem& problem, const std::vector<int>& rows,
                                     std::vector<int> end) {
  constexpr int kSteps = 3;  // the places of the end, and twice of all that fits
  const Measurements& data = problem.data();
  if (!DeterminePlaces(data, end) || MarkersOfRows(data, end) != MarkersOfRows(data, rows)) return std::nullopt;
  FarRows found;
  for (int step = 0; step < kSteps; ++step) {
    const double rms = FitPlaces(problem, end, &found.parameters);
    if (!(rms <= SuspiciousMisfit(problem))) return std::nullopt;
    const std::vector<double> distances = DistancesFromPoints(problem, rows, found.parameters);
    found = SplitByDistance(rows, distances, kNearHalf * rms, found.parameters);
    if (found.far.empty() || found.near.size() < end.size()) return std::nullopt;
    end = found.near;
  }
  return AreApart(found, problem) ? std::optional(found) : std::nullopt;
}

std::optional<FarRows> FarFromAnyEnd(const CalibrationProblem& problem) {
  const Measurements& data = problem.data();
  const std::map<int, std::vector<int>> of_station = ByStation(data, FittedPoints(problem));
  for (const size_t share : {2, 4, 8}) {
    for (const auto& [station, rows] : of_station) {
      const auto shot = [&, &own = rows](size_t k) { return data.observations[own[k]].shot; };
      size_t size = rows.size() / share;
      while (size > 0 && shot(size) == shot(size - 1)) --size;  // whole shots
      const auto count = static_cast<std::ptrdiff_t>(size);
      for (const bool is_first : {true, false}) {
        const std::vector<int> end(is_first ? rows.begin() : rows.end() - count,
                                   is_first ? rows.begin() + count : rows.end());
        if (std::optional<FarRows> found = FarFromOneEnd(problem, rows, end)) return found;
      }
    }
  }
  return std::nullopt;
}

std::string WhichRows(const CalibrationProblem& problem, const PartOfRows& part) {
  const Measurements& data = problem.data();
  if (part.kind == PartOfRows::Kind::kStations) return RowsOfStations(part.labels);
  if (part.kind == PartOfRows::Kind::kMarkers) return RowsOfMarkers(part.labels);
  const std::string first = data.SourceOf(data.observations[part.rows.front()]);
  const std::string last = data.SourceOf(data.observations[part.rows.back()]);
  const std::string of_markers = part.labels.empty() ? "" : RowsOfMarkers(part.labels) + " ";
  if (part.kind == PartOfRows::Kind::kShots) {
    std::set<int> shots;
    for (const int i : part.rows) shots.insert(data.observations[i].shot);
    return of_markers + RowsOfShots(shots.size(), first, last);
  }
  const std::set<int> markers = MarkersOfRows(data, part.rows);
  const auto is_alike = [&](int i) { return markers.count(data.observations[i].marker) > 0; };
  const bool others_follow =
      std::any_of(part.others.begin(), part.others.end(), [&](int i) { return is_alike(i) && i > part.rows.back(); });
  return of_markers + RowsBetween(first, others_follow ? last : "");
}

std::optional<WrongPart> TryPart(const CalibrationProblem& problem, const PartOfRows& part) {
  if (part.rows.size() < kFewestOfWrong) return std::nullopt;
  CalibrationProblem alone = OnlyRows(problem, part.rows);
  alone.parameters = part.parameters;
  HoldPlaces(problem.data(), part.others, true, &alone.parameters);
  const CalibrationProblem sampled = SampledProblem(alone);
  const TriedReadings tried = TryReadings(sampled, SampleOfRows(sampled), ReadingsOfPart(problem, part));
  if (!tried.simplest) return std::nullopt;
  const Reading& reading = tried.all[*tried.simplest];
  const double as_others = std::max(kPerfect * Reach(problem), kNearHalf * part.others_rms);
  if (reading.misfit > std::min(SuspiciousMisfit(problem), as_others)) return std::nullopt;
  const WrongPartInWords words = {
      WhichRows(problem, part), part.rows.size(), FittedPoints(problem).size(), tried.as_stated, part.others_rms,
      reading.misfit,           tried.Alike()};
  WrongPart wrong{
      Found(Severity::kSerious, reading.code.c_str(), PartIsReadOtherwise(words, {reading.name, reading.remedy})), {}};
  for (size_t k = 0; k < std::min(kMostRowsOfPart, part.rows.size()); ++k)
    wrong.finding.rows.push_back(problem.data().SourceOf(problem.data().observations[part.rows[k]]));
  const bool of_labels = part.kind == PartOfRows::Kind::kStations || part.kind == PartOfRows::Kind::kMarkers;
  if (!of_labels) wrong.rows = part.rows;
  return wrong;
}

}  // namespace

std::optional<WrongPart> FindWrongPart(const CalibrationProblem& problem, const std::optional<FarRows>& far) {
  for (const PartOfRows::Kind kind : {PartOfRows::Kind::kStations, PartOfRows::Kind::kMarkers}) {
    const std::optional<PartOfRows> part = PartOfLabels(problem, kind);
    std::optional<WrongPart> found = part ? TryPart(problem, *part) : std::nullopt;
    if (found) return found;
  }
  const std::optional<FarRows> rows = far && AreApart(*far, problem) ? far : FarFromAnyEnd(problem);
  return rows ? FindWrongRows(problem, *rows) : std::nullopt;
}

std::optional<WrongPart> FindWrongRows(const CalibrationProblem& problem, const FarRows& far) {
  const FarRows apart = OnlyThoseApart(far);
  if (apart.far.empty() || !AreApart(apart, problem)) return std::nullopt;
  for (const PartOfRows& part : FarShots(problem, apart).Parts()) {
    std::optional<WrongPart> found = TryPart(problem, part);
    if (found) return found;
  }
  return std::nullopt;
}

}  // namespace sagitta

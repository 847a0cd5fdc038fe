#include "problems/io/measurement_file.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <string_view>
#include <unordered_map>

#include "models/effects/effect.h"
#include "problems/input_error.h"
#include "problems/interruption.h"
#include "problems/io/ids_by_text.h"
#include "problems/io/measurement_row.h"
#include "problems/io/measurement_warnings.h"
#include "problems/io/units.h"
#include "problems/text.h"

namespace sagitta {
namespace {

// Two files may state the same angle in two units.
constexpr double kSameJointValue = 1e-9;  // rad or m
constexpr double kLongShot = 600.0;       // s: markers are read one after the other within minutes

int IndexOf(std::string_view name, IdsByText* words, std::vector<std::string>* names) {
  const int index = words->IndexOf(name);
  if (index == static_cast<int>(names->size())) names->emplace_back(name);
  return index;
}

// Numbers of ids that go together: configuration, visit, repeat, station, load.
using Ids = std::array<int, 5>;

size_t HashOf(const Ids& ids) {
  size_t sum = 0;
  for (const int id : ids) sum = (sum ^ static_cast<size_t>(id)) * kSpread + (sum >> 29);
  return sum * kSpread;
}

std::vector<size_t> HashesOf(const std::vector<std::string>& names) {
  std::vector<size_t> hashes;
  for (const std::string& name : names) hashes.push_back(std::hash<std::string>()(name) * kSpread);
  return hashes;
}

// The same for rows that say the same in another order of columns. header: hashes of its names.
size_t RowHash(const MeasurementFile::Row& row, const std::vector<size_t>& header) {
  const std::hash<std::string_view> hash;
  size_t sum = 0;
  for (size_t c = 0; c < header.size(); ++c) {
    size_t h = hash(row.cells[c]) ^ header[c];
    h ^= h >> 29;
    sum += h * 0xBF58476D1CE4E5B9ULL;  // of SplitMix64 (models/random_bits.h)
  }
  return sum;
}

bool SameCells(const MeasurementFile& file, const MeasurementFile::Row& row, const MeasurementFile& other_file,
               const MeasurementFile::Row& other_row) {
  if (file.header.size() != other_file.header.size()) return false;
  for (size_t c = 0; c < file.header.size(); ++c) {
    const int other = other_file.FindColumn(file.header[c]);
    if (other < 0 || row.cells[c] != other_row.cells[other]) return false;
  }
  return true;
}

// A shot has the mean of the times, temperatures and joint torques that its rows state.
struct Moment {
  int times = 0, temperatures = 0, torques = 0;
  double earliest = 0.0, latest = 0.0;

  void Take(const MeasurementRow& row, Shot* shot) {
    if (row.has_time) {
      earliest = times == 0 ? row.time : std::min(earliest, row.time);
      latest = times == 0 ? row.time : std::max(latest, row.time);
      shot->has_time = true;
      shot->time += (row.time - shot->time) / ++times;
    }
    if (row.has_temperature) {
      shot->has_temperature = true;
      shot->temperature += (row.temperature - shot->temperature) / ++temperatures;
    }
    if (row.joint_torques.size() > 0) {
      if (torques == 0) shot->joint_torques.setZero(row.joint_torques.size());
      shot->joint_torques += (row.joint_torques - shot->joint_torques) / ++torques;
    }
  }
};

class MeasurementsBuilder {
 public:
  void Reserve(size_t rows);
  void Add(CsvTable table, const MeasurementColumns& columns, const MeasurementReadOptions& options);
  Measurements Take();

 private:
  const MeasurementFile& FileOf(int observation) const { return data_.files[data_.observations[observation].file]; }
  MeasurementFile::Row RowOf(int observation) const {
    return FileOf(observation).rows[data_.observations[observation].row];
  }
  std::string SourceOf(int observation) const { return data_.SourceOf(data_.observations[observation]); }
  [[noreturn]] void Fail(const std::string& key, const std::string& what, const std::string& hint) const;

  // Shots of equal ids, once one of them has a row that repeats a marker: that begins another.
  struct Repeated {
    std::vector<int> shots;
    std::vector<std::pair<int, size_t>> rows;  // marker, and how many rows it has; ascending
    std::unordered_map<size_t, int> seen;      // observations by hash

    // One more row of a marker; returns how many it had.
    size_t Count(int marker) {
      auto own = std::lower_bound(rows.begin(), rows.end(), std::make_pair(marker, size_t{0}));
      if (own == rows.end() || own->first != marker) own = rows.insert(own, {marker, 0});
      return own->second++;
    }
  };

  void RefuseCopy(Repeated* shots);
  bool StatesAnotherTime(const Observation& one, const Observation& other) const;
  void CountCopiedPoint(const MeasurementRow& row, int first_shot, int marker);
  void WarnOfRepeated();
  int FirstShot(const Ids& ids);
  bool HasMarker(int shot, int marker) const;
  Repeated RepeatedFrom(int shot) const;
  int ConfigurationIndex(const MeasurementRow& row);
  int ShotIndex(const MeasurementRow& row, int configuration, int station, int marker);
  int BeginShot(const MeasurementRow& row, int configuration, int station);
  void CheckShot(const MeasurementRow& row, const Shot& shot) const;
  void CheckApproach(const MeasurementRow& row, const Shot& shot) const;

  Measurements data_;
  int current_ = 0;  // the observation that is being added
  IdsByText stations_, markers_, configurations_, visits_, repeat_ids_, loads_;
  PlacesByHash first_shots_;                   // of the shots of equal ids
  std::vector<Ids> ids_;                       // of the shots
  std::pair<Ids, int> latest_ = {Ids(), -1};   // of the row before, and the first shot of these
  std::unordered_map<int, Repeated> repeats_;  // by the first shot
  std::vector<std::vector<size_t>> headers_;   // hashes of each file's names
  std::vector<int> first_of_configuration_;
  std::vector<Moment> moments_;    // of the shots
  int repeated_ = 0, copied_ = 0;  // rows of equal ids, those among them that have the point of an earlier row
  std::string first_repeated_;
  InputError::Where first_copied_;
  std::string original_;
  int lost_ = 0;  // readings
  std::string first_lost_;
};

void MeasurementsBuilder::Fail(const std::string& key, const std::string& what, const std::string& hint) const {
  throw InputError({FileOf(current_).path, RowOf(current_).line, key}, what, hint);
}

// Rows that are equal have equal ids.
void MeasurementsBuilder::RefuseCopy(Repeated* shots) {
  const auto remember = [&](int observation) {
    return shots->seen.try_emplace(RowHash(RowOf(observation), headers_[data_.observations[observation].file]),
                                   observation);
  };
  if (shots->seen.empty()) {
    for (const int shot : shots->shots) {
      for (const int i : data_.shots[shot].observations) {
        if (data_.observations[i].is_point()) remember(i);
      }
    }
  }
  const auto [entry, is_new] = remember(current_);
  if (is_new) return;
  const int first = entry->second;
  if (!SameCells(FileOf(current_), RowOf(current_), FileOf(first), RowOf(first))) return;
  Fail("", "this row equals " + SourceOf(first) + " in every column",
       "a file given twice? repeated shots differ in repeat or in their values");
}

bool MeasurementsBuilder::StatesAnotherTime(const Observation& one, const Observation& other) const {
  const std::optional<double> first = ParseNumber(data_.Cell(one, "time_s")),
                              second = ParseNumber(data_.Cell(other, "time_s"));
  return first && second && *first != *second;
}

// Two readings of one place differ in their last digits, in one of three coordinates at least.
void MeasurementsBuilder::CountCopiedPoint(const MeasurementRow& row, int first_shot, int marker) {
  if (row.point.isZero(0.0)) return;  // a table of poses to come
  for (const int i : data_.shots[first_shot].observations) {
    const Observation& first = data_.observations[i];
    const bool is_copied = first.marker == marker && first.is_point() && first.point_in_station == row.point &&
                           !StatesAnotherTime(first, data_.observations[current_]);
    if (!is_copied || copied_++ > 0) continue;
    first_copied_ = {FileOf(current_).path, RowOf(current_).line, "x_mm"};
    original_ = SourceOf(i);
  }
}

int MeasurementsBuilder::ConfigurationIndex(const MeasurementRow& row) {
  const int index = configurations_.IndexOf(row.config);
  if (index == static_cast<int>(data_.configurations.size())) {
    data_.configurations.push_back({std::string(row.config), row.q, false});
    first_of_configuration_.push_back(current_);
    return index;
  }
  const Eigen::VectorXd& q = data_.configurations[index].q;
  for (int j = 0; j < q.size(); ++j) {
    if (std::abs(row.q[j] - q[j]) <= kSameJointValue) continue;
    Fail("q" + std::to_string(j + 1),
         "configuration '" + std::string(row.config) + "' has another joint value at " +
             SourceOf(first_of_configuration_[index]),
         "rows of one config share one commanded joint configuration");
  }
  return index;
}

// The first shot of these ids; the next one that begins, where there is none.
int MeasurementsBuilder::FirstShot(const Ids& ids) {
  if (latest_.second < 0 || latest_.first != ids) {
    const auto next = static_cast<int>(data_.shots.size());
    latest_ = {ids, first_shots_.FindOrPut(HashOf(ids), next, [&](int shot) { return ids_[shot] == ids; })};
  }
  return latest_.second;
}

bool MeasurementsBuilder::HasMarker(int shot, int marker) const {
  const std::vector<int>& own = data_.shots[shot].observations;
  return std::any_of(own.begin(), own.end(), [&](int i) { return data_.observations[i].marker == marker; });
}

MeasurementsBuilder::Repeated MeasurementsBuilder::RepeatedFrom(int shot) const {
  Repeated repeated;
  repeated.shots.push_back(shot);
  for (const int i : data_.shots[shot].observations) {
    if (data_.observations[i].is_point()) repeated.Count(data_.observations[i].marker);
  }
  return repeated;
}

// A row goes into the first shot of its ids that has no row of its marker yet.
int MeasurementsBuilder::ShotIndex(const MeasurementRow& row, int configuration, int station, int marker) {
  const int first = FirstShot(
      {configuration, visits_.IndexOf(row.visit), repeat_ids_.IndexOf(row.repeat), station, loads_.IndexOf(row.load)});
  if (first == static_cast<int>(data_.shots.size())) return BeginShot(row, configuration, station);
  auto repeated = repeats_.find(first);
  if (repeated == repeats_.end()) {
    if (!HasMarker(first, marker)) {
      CheckShot(row, data_.shots[first]);
      return first;
    }
    repeated = repeats_.emplace(first, RepeatedFrom(first)).first;
  }
  Repeated& own = repeated->second;
  const size_t occurrence = own.Count(marker);
  RefuseCopy(&own);
  if (occurrence > 0) {
    if (repeated_++ == 0) first_repeated_ = SourceOf(current_);
    CountCopiedPoint(row, first, marker);
  }
  if (occurrence == own.shots.size()) own.shots.push_back(BeginShot(row, configuration, station));
  const int shot = own.shots[occurrence];
  if (!data_.shots[shot].observations.empty()) CheckShot(row, data_.shots[shot]);
  return shot;
}

int MeasurementsBuilder::BeginShot(const MeasurementRow& row, int configuration, int station) {
  Shot& shot = data_.shots.emplace_back();
  moments_.emplace_back();
  ids_.push_back(latest_.first);
  shot.configuration = configuration;
  shot.station = station;
  shot.visit = row.visit;
  shot.repeat = row.repeat;
  shot.load = row.load;
  shot.wrench = row.wrench;
  shot.approach = row.approach;
  shot.observations.reserve(std::min<size_t>(data_.markers.size(), 8));
  return static_cast<int>(data_.shots.size()) - 1;
}

void MeasurementsBuilder::CheckShot(const MeasurementRow& row, const Shot& shot) const {
  if (row.wrench.force != shot.wrench.force || row.wrench.moment != shot.wrench.moment) {
    Fail("load", "the wrench differs from that of the same shot at " + SourceOf(shot.observations.front()),
         "loads on some markers of a shot only; another load state has another load id");
  }
  CheckApproach(row, shot);
}

// No direction at all is none of any joint.
void MeasurementsBuilder::CheckApproach(const MeasurementRow& row, const Shot& shot) const {
  const auto at = [](const std::vector<int>& approach, size_t joint) {
    return approach.empty() ? kApproachNotStated : approach[joint];
  };
  for (size_t j = 0; j < std::max(row.approach.size(), shot.approach.size()); ++j) {
    const int here = at(row.approach, j), there = at(shot.approach, j);
    if (here == there) continue;
    const std::string column = "approach" + std::to_string(j + 1), first = SourceOf(shot.observations.front());
    if (here == kApproachNotStated || there == kApproachNotStated) {
      const bool is_here = here == kApproachNotStated;
      Fail(column,
           std::string("the cell is ") + (is_here ? "" : "not ") + "empty, that of the same shot at " + first +
               (is_here ? " is not" : " is"),
           "state the direction of the last motion in both, or in neither");
    }
    Fail(column, "the direction of the last motion differs from that of the same shot at " + first,
         "another arrival is another visit");
  }
}

// Room for what so many rows may be. What is not used is never touched: it costs addresses and no memory; the tables of
// hashes, which are cleared, are for rows of three markers.
void MeasurementsBuilder::Reserve(size_t rows) {
  constexpr size_t kRowsOfShot = 3;  // a guess: memory that is reserved, and grows where it is not enough
  data_.observations.reserve(rows);
  data_.shots.reserve(rows);
  data_.configurations.reserve(rows);
  moments_.reserve(rows);
  first_of_configuration_.reserve(rows);
  ids_.reserve(rows);
  configurations_.Reserve(rows / kRowsOfShot);
  first_shots_.Reserve(rows / kRowsOfShot);
}

void MeasurementsBuilder::Add(CsvTable table, const MeasurementColumns& columns,
                              const MeasurementReadOptions& options) {
  data_.files.push_back(std::move(table.file));
  const MeasurementFile& file = data_.files.back();
  headers_.push_back(HashesOf(file.header));
  for (const std::string& name : columns.unread) {
    std::vector<std::string>& unread = data_.unread_columns;
    if (std::find(unread.begin(), unread.end(), name) == unread.end()) unread.push_back(name);
  }
  MeasurementRowReader reader(file, columns, options);
  MeasurementRow row;
  for (size_t r = 0; r < file.rows.size(); ++r) {
    CheckInterruption();
    reader.Read(file.rows[r], &row);
    if (row.lost) {
      if (lost_++ == 0) first_lost_ = file.path + ":" + std::to_string(file.rows.LineOf(r));
      continue;
    }
    current_ = static_cast<int>(data_.observations.size());
    Observation& observation = data_.observations.emplace_back();
    observation.file = static_cast<int>(data_.files.size()) - 1;
    observation.row = static_cast<int>(r);
    observation.point_in_station = row.point;
    observation.sigma = row.sigma;
    if (!row.rotation_sigma.isZero(0.0)) observation.mutable_rotation()->sigma = row.rotation_sigma;
    observation.marker = IndexOf(row.marker, &markers_, &data_.markers);
    const int configuration = ConfigurationIndex(row);
    const int station = IndexOf(row.station, &stations_, &data_.stations);
    observation.shot = ShotIndex(row, configuration, station, observation.marker);
    Shot& shot = data_.shots[observation.shot];
    shot.observations.push_back(current_);
    moments_[observation.shot].Take(row, &shot);
    if (!row.is_pose) continue;
    data_.AddRotation(current_).mutable_rotation()->in_station = row.rotation;
  }
}

// Files that are given twice in another dress (results of a calibration next to its rows) would halve the variance of
// everything, and repeats that agree to the last digit say that there is no noise.
void MeasurementsBuilder::WarnOfRepeated() {
  if (repeated_ == 0) return;
  if (copied_ >= kFewestCopies && copied_ == repeated_) {
    throw InputError(first_copied_,
                     std::to_string(copied_) + " rows have the point of an earlier row of the same ids to the last " +
                         "digit (the first that of " + original_ + "): these are the same readings given twice",
                     "leave one of them out; repeated shots that do read alike differ in the column repeat");
  }
  data_.warnings.push_back(
      std::to_string(repeated_) +
      " rows equal an earlier one in config, visit, marker, load, station and repeat (the first: " + first_repeated_ +
      (copied_ > 0 ? "; " + std::to_string(copied_) + " of them have its point to the last digit" : "") +
      "); they count as repeated shots of one arrival: if the arm came anew for them, name the arrivals in a column "
      "visit, or noise and repeatability that are estimated are wrong");
}

Measurements MeasurementsBuilder::Take() {
  WarnOfRows(&data_);
  if (lost_ > 0) {
    data_.warnings.push_back(std::to_string(lost_) + (lost_ == 1 ? " reading is" : " readings are") +
                             " lost (x, y and z are empty): skipped (the first: " + first_lost_ + ")");
  }
  WarnOfRepeated();
  const auto longest = std::max_element(moments_.begin(), moments_.end(), [](const Moment& a, const Moment& b) {
    return a.latest - a.earliest < b.latest - b.earliest;
  });
  if (longest != moments_.end() && longest->latest - longest->earliest > kLongShot) {
    const Shot& shot = data_.shots[longest - moments_.begin()];
    data_.warnings.push_back("the rows of one shot are up to " + FormatNumber(longest->latest - longest->earliest) +
                             " s apart (" + SourceOf(shot.observations.front()) +
                             "); a shot counts at the mean of its times: give other visits or repeats other ids");
  }
  return std::move(data_);
}

}  // namespace

Measurements MeasurementsFromTables(std::vector<CsvTable> tables, const Robot& robot,
                                    const MeasurementReadOptions& options) {
  std::vector<std::string> joints;
  std::vector<bool> prismatic;
  for (const Joint& joint : robot.chain.joints) {
    joints.push_back(joint.name);
    prismatic.push_back(joint.type == JointType::kPrismatic);
  }
  MeasurementsBuilder builder;
  size_t rows = 0;
  for (const CsvTable& table : tables) rows += table.file.rows.size();
  builder.Reserve(rows);
  for (CsvTable& table : tables) {
    const MeasurementColumns columns = FindMeasurementColumns(table, joints, prismatic, options.points_required);
    builder.Add(std::move(table), columns, options);
  }
  return builder.Take();
}

Measurements ReadMeasurementsFor(const Robot& robot, const std::vector<std::string>& paths,
                                 const MeasurementReadOptions& options) {
  if (paths.empty()) throw InputError({"", 0, "measurements"}, "no measurement file is given");
  std::vector<CsvTable> tables;
  for (const std::string& path : paths) tables.push_back(ReadCsvTable(path));
  return MeasurementsFromTables(std::move(tables), robot, options);
}

Measurements ReadMeasurementsText(const Robot& robot, const std::string& text, const std::string& file_in_messages,
                                  const MeasurementReadOptions& options) {
  std::vector<CsvTable> tables;
  tables.push_back(ParseCsvTable(text, file_in_messages));
  return MeasurementsFromTables(std::move(tables), robot, options);
}

}  // namespace sagitta

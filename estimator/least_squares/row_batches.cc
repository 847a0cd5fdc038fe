#include "estimator/least_squares/row_batches.h"

#include <hwy/cache_control.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <unordered_map>

#include "estimator/least_squares/batch_algebra.h"
#include "models/excitation.h"

namespace sagitta {
namespace {

// Groups grow by pieces of memory, and nothing is copied: some 100 kB, or an eighth of all units where these are few.
constexpr int kMostBatchesTogether = 32, kPiecesOfMemory = 8;

int InWholeBlocks(int count) { return (count + kGramBlock - 1) / kGramBlock * kGramBlock; }

// Observations of one shot that follow each other: positions in the list.
struct ShotRun {
  int first = 0, last = 0;
  int size() const { return last - first; }
};

// Runs, by visit or one by one.
struct Units {
  std::vector<ShotRun> runs;  // unit by unit
  std::vector<int> first;     // run of each unit, and the end
  int size() const { return static_cast<int>(first.size()) - 1; }
};

Units UnitsOf(const CalibrationProblem& problem, const std::vector<int>& observations, bool by_visit) {
  std::vector<ShotRun> runs;
  std::vector<int> unit_of;  // of each run
  std::unordered_map<int, int> unit_of_visit;
  int previous = -1;
  for (int k = 0; k < static_cast<int>(observations.size()); ++k) {
    const int shot = problem.data().observations[observations[k]].shot;
    if (shot != previous) {
      runs.push_back({k, k});
      const int next = static_cast<int>(unit_of_visit.size());
      if (by_visit) unit_of.push_back(unit_of_visit.emplace(problem.latent.visit_of_shot[shot], next).first->second);
    }
    runs.back().last = k + 1;
    previous = shot;
  }
  Units units;
  if (!by_visit) {
    units.first.resize(runs.size() + 1);
    std::iota(units.first.begin(), units.first.end(), 0);
    units.runs = std::move(runs);
    return units;
  }
  units.first.assign(unit_of_visit.size() + 1, 0);
  for (const int unit : unit_of) ++units.first[unit + 1];
  std::partial_sum(units.first.begin(), units.first.end(), units.first.begin());
  std::vector<int> place = units.first;
  units.runs.resize(runs.size());
  for (size_t r = 0; r < runs.size(); ++r) units.runs[place[unit_of[r]]++] = runs[r];
  return units;
}

}  // namespace

struct RowBatches::Group {
  struct ShotPart {
    int station = 0;
    std::vector<int> markers;
    std::vector<ReadingKind> kinds;  // what is read of each
    ShotProgram program;
  };
  std::vector<ShotPart> shots;
  bool by_model = false;
  int rows = 0;
  int num_units = 0;
  std::vector<int> observations;           // unit by unit, positions in the list
  std::vector<Matrix3<double>> whiteners;  // of these, where only the model itself evaluates them
  int batch_doubles = 0;
  int batches_together = 1;                 // whose numbers lie in one piece of memory
  std::vector<std::vector<double>> memory;  // per batch the shots' blocks one after the other

  int per_unit() const { return rows / 3; }
  int num_batches() const { return (num_units + kBatchLanes - 1) / kBatchLanes; }
  const double* Data(int batch, int shot) const {
    const double* data = Aligned(const_cast<double*>(memory[batch / batches_together].data())) +
                         static_cast<std::size_t>(batch % batches_together) * batch_doubles;
    for (int s = 0; s < shot; ++s) data += shots[s].program.num_data * kBatchLanes;
    return data;
  }
  double* MutableData(int batch, int shot) { return const_cast<double*>(Data(batch, shot)); }

  // What is evaluated next comes while its predecessor is: of 10^5 configurations nothing is in the cache any more.
  void Prefetch(int batch) const {
    constexpr int kDoublesOfLine = 8;
    const double* const data = Data(batch, 0);
    for (int i = 0; i < batch_doubles; i += kDoublesOfLine) hwy::Prefetch(data + i);
  }

  // Memory for one more unit.
  void Grow() {
    const int batch = num_units++ / kBatchLanes;
    if (batch / batches_together < static_cast<int>(memory.size())) return;
    memory.emplace_back(static_cast<std::size_t>(batches_together) * batch_doubles + kBatchLanes, 0.0);
  }
  // Lanes that are left over repeat the last unit; nobody reads them.
  void FillUp() {
    const int last = num_units - 1;
    double* const data = MutableData(last / kBatchLanes, 0);
    for (int lane = last % kBatchLanes + 1; lane < kBatchLanes; ++lane) {
      for (int i = 0; i < batch_doubles; i += kBatchLanes) data[i + lane] = data[i + last % kBatchLanes];
    }
  }
};

RowBatches::~RowBatches() = default;

RowBatches::RowBatches(const CalibrationProblem& problem, const std::vector<int>& observations, const NoiseRoots& noise,
                       LatentTreatment treatment, RowsAgainst against)
    : model_(problem.model()),
      data_(problem.data()),
      marker_frames_(problem.marker_frames()),
      shot_inputs_(problem.shot_inputs()),
      latent_joints_(problem.latent.joints),
      latent_sigmas_(problem.latent.sigmas),
      observations_(observations),
      marginalises_(treatment == LatentTreatment::kMarginalise && !problem.latent.empty()),
      against_(against) {
  // Most readings are as noisy as the one before.
  Matrix3<double> latest = Matrix3<double>::Identity(), whitener = latest;
  const auto whitener_of = [&](const Matrix3<double>& root) -> const Matrix3<double>& {
    if (root != latest) latest = root, whitener = root.inverse();
    return whitener;
  };
  const auto read = [&](const ShotRun& run, std::vector<BatchReading>* readings) {
    readings->clear();
    for (int k = run.first; k < run.last; ++k) {
      const Observation& row = problem.data().observations[observations[k]];
      const Vector3<double> target =
          against_ == RowsAgainst::kMeasured ? row.point_in_station : Vector3<double>::Zero().eval();
      readings->push_back({row.marker, problem.marker_frames()[row.marker], target, whitener_of(noise[k])});
    }
  };
  const Units units = UnitsOf(problem, observations, marginalises_);
  const int batches_together = std::clamp(units.size() / (kPiecesOfMemory * kBatchLanes), 1, kMostBatchesTogether);
  std::map<std::vector<std::int64_t>, int> group_of;
  std::vector<std::vector<BatchReading>> readings;  // of each run of the unit that is looked at
  std::vector<std::int64_t> key;
  for (int u = 0; u < units.size(); ++u) {
    const ShotRun* const runs = &units.runs[units.first[u]];
    const auto num_runs = static_cast<size_t>(units.first[u + 1] - units.first[u]);
    if (readings.size() < num_runs) readings.resize(num_runs);
    const auto shot_of = [&](size_t r) { return problem.data().observations[observations[runs[r].first]].shot; };
    key.clear();
    bool by_model = false;
    for (size_t r = 0; r < num_runs; ++r) {
      read(runs[r], &readings[r]);
      for (int k = runs[r].first; k < runs[r].last; ++k) {
        const ReadingKind kind = problem.data().observations[observations[k]].kind;
        by_model |= kind != ReadingKind::kPoint;
        key.push_back(static_cast<int>(kind));
      }
      key.push_back(problem.data().shots[shot_of(r)].station);
      key.push_back(runs[r].size());
      for (const BatchReading& reading : readings[r]) key.push_back(reading.id);
      by_model |= !AppendStructure(problem.model(), problem.shot_inputs()[shot_of(r)], readings[r], &key);
    }
    const auto [found, is_new] = group_of.try_emplace(key, num_groups());
    if (is_new) {
      groups_.push_back(std::make_unique<Group>());
      groups_.back()->by_model = by_model;
      groups_.back()->batches_together = batches_together;
    }
    Group& group = *groups_[found->second];
    for (size_t r = 0; r < num_runs && is_new; ++r) {
      Group::ShotPart part;
      part.station = problem.data().shots[shot_of(r)].station;
      for (const BatchReading& reading : readings[r]) part.markers.push_back(reading.id);
      for (int k = runs[r].first; k < runs[r].last; ++k) {
        part.kinds.push_back(problem.data().observations[observations[k]].kind);
      }
      const ShotInput& input = problem.shot_inputs()[shot_of(r)];
      if (!group.by_model) part.program = MakeShotProgram(problem.model(), input, readings[r]);
      group.rows += 3 * runs[r].size();
      group.batch_doubles += part.program.num_data * kBatchLanes;
      group.shots.push_back(std::move(part));
    }
    group.Grow();
    const int batch = (group.num_units - 1) / kBatchLanes, lane = (group.num_units - 1) % kBatchLanes;
    for (size_t r = 0; r < num_runs; ++r) {
      for (int k = runs[r].first; k < runs[r].last; ++k) {
        group.observations.push_back(k);
        if (group.by_model) group.whiteners.push_back(whitener_of(noise[k]));
      }
      if (group.by_model) continue;
      PackShot(problem.model(), group.shots[r].program, problem.shot_inputs()[shot_of(r)], readings[r], lane,
               group.MutableData(batch, static_cast<int>(r)));
    }
  }
  for (const std::unique_ptr<Group>& group : groups_) group->FillUp();
}

int RowBatches::num_batches(int group) const { return groups_[group]->num_batches(); }
int RowBatches::num_units() const {
  return std::accumulate(groups_.begin(), groups_.end(), 0,
                         [](int sum, const std::unique_ptr<Group>& group) { return sum + group->num_units; });
}
int RowBatches::rows_of_unit(int group) const { return groups_[group]->rows; }

RowBatches::Unit RowBatches::UnitOf(int group, int batch, int lane) const {
  const Group& own = *groups_[group];
  const int unit = batch * kBatchLanes + lane;
  if (unit >= own.num_units) return {};
  const auto size = static_cast<std::size_t>(own.per_unit());
  return {own.observations.data() + static_cast<std::size_t>(unit) * size, size};
}

BatchColumns RowBatches::ColumnsOf(const Group& group, const ParameterSet& parameters,
                                   const std::vector<int>& column_of) const {
  BatchColumns result;
  const auto three = [&](const ParameterBlock& block) {
    std::vector<int> columns(3);
    for (int i = 0; i < 3; ++i) columns[i] = column_of[block.first_coordinate + i];
    return columns;
  };
  const auto is_asked = [](const std::vector<int>& columns) {
    return std::any_of(columns.begin(), columns.end(), [](int c) { return c >= 0; });
  };
  const auto append = [&](const std::vector<int>& columns) {
    const int first = static_cast<int>(result.of.size());
    result.of.insert(result.of.end(), columns.begin(), columns.end());
    return first;
  };
  const bool alone = !marginalises_;
  bool any_own = false;
  const auto read_block = [&](const Group::ShotPart& shot, size_t m) -> const ParameterBlock& {
    return parameters.read_block(shot.markers[m], shot.kinds[m]);
  };
  for (size_t m = 0; alone && m < group.shots[0].markers.size(); ++m) {
    result.own.push_back(three(read_block(group.shots[0], m)));
    any_own |= is_asked(result.own.back());
  }
  if (any_own) result.of.assign(kGramBlock, -1), result.first = kGramBlock;
  if (!any_own) result.own.clear();
  std::map<int, int> station_at, marker_at;  // the latter by the block's first coordinate
  for (const Group::ShotPart& shot : group.shots) {
    std::vector<int> station = three(parameters.station_translation(shot.station));
    const std::vector<int> rotation = three(parameters.station_rotation(shot.station));
    station.insert(station.end(), rotation.begin(), rotation.end());
    if (is_asked(station) && station_at.count(shot.station) == 0) station_at[shot.station] = append(station);
    for (size_t m = 0; !alone && m < shot.markers.size(); ++m) {
      const ParameterBlock& block = read_block(shot, m);
      const bool is_new = marker_at.count(block.first_coordinate) == 0;
      if (is_new && is_asked(three(block))) marker_at[block.first_coordinate] = append(three(block));
    }
  }
  result.sparse = static_cast<int>(result.of.size());
  std::vector<int> theta(parameters.num_model_parameters(), -1);
  for (int i = 0; i < parameters.num_model_parameters(); ++i) {
    const int column = column_of[parameters.model_parameter(i).first_coordinate];
    if (column >= 0) theta[i] = append({column});
  }
  result.residual = append({-1});
  result.last = InWholeBlocks(static_cast<int>(result.of.size()));
  result.of.resize(result.last, -1);
  const bool deviate = num_latents() > 0;
  if (deviate) {
    result.latents = num_latents();
    result.latent = append(std::vector<int>(result.latents, -1));
    result.of.resize(InWholeBlocks(static_cast<int>(result.of.size())), -1);
  }
  // An odd number of blocks: rows that are summed together would else fall into few sets of the cache.
  if (result.of.size() / kGramBlock % 2 == 0) result.of.resize(result.of.size() + kGramBlock, -1);
  result.columns = static_cast<int>(result.of.size());
  int row = 0;
  for (const Group::ShotPart& shot : group.shots) {
    BatchLayout layout;
    layout.columns = result.columns;
    layout.first_row = row;
    layout.residual = result.residual;
    layout.theta = theta;
    if (station_at.count(shot.station) > 0) layout.station = station_at[shot.station];
    for (size_t m = 0; m < shot.markers.size(); ++m) {
      const auto at = marker_at.find(read_block(shot, m).first_coordinate);
      layout.markers.push_back(any_own ? 0 : at != marker_at.end() ? at->second : -1);
    }
    if (deviate) {
      layout.latent = result.latent;
      layout.latent_joints = latent_joints_;
      layout.latent_sigmas.assign(latent_sigmas_.begin(), latent_sigmas_.end());
    }
    row += 3 * static_cast<int>(shot.markers.size());
    result.shots.emplace_back(shot.program, std::move(layout));
  }
  return result;
}

RowBatches::Request::Request(const RowBatches& batches, const ParameterSet& parameters, const std::vector<int>& columns)
    : theta_(parameters.ModelValues()) {
  std::vector<int> column_of(parameters.num_coordinates(), -1);
  for (size_t c = 0; c < columns.size(); ++c) column_of[columns[c]] = static_cast<int>(c);
  for (int s = 0; s < parameters.num_stations(); ++s) bases_.push_back(parameters.BaseInStation(s));
  for (int m = 0; m < parameters.num_markers(); ++m) {
    markers_.push_back(parameters.MarkerPoint(m));
    turns_.push_back(parameters.MarkerRotation(m));
  }
  for (int i = 0; i < parameters.num_model_parameters(); ++i) {
    if (column_of[parameters.model_parameter(i).first_coordinate] >= 0) active_.push_back(i);
  }
  for (const std::unique_ptr<Group>& group : batches.groups_) {
    columns_.push_back(batches.ColumnsOf(*group, parameters, column_of));
    points_.emplace_back();
    for (const Group::ShotPart& shot : group->shots) {
      std::vector<Vector3<double>> points;
      for (const int m : shot.markers) points.push_back(markers_[m]);
      points_.back().emplace_back(shot.program, theta_.data(), bases_[shot.station], std::move(points));
    }
  }
}

bool RowBatches::Evaluate(const Request& request, int group, int batch, BatchScratch* scratch, double* rows) const {
  const Group& own = *groups_[group];
  const BatchColumns& columns = request.columns_[group];
  if (batch + 1 < own.num_batches()) own.Prefetch(batch + 1);
  // Marginalising fills cells that no derivative belongs to.
  for (int r = 0; r < own.rows && marginalises_; ++r) {
    double* const row = rows + static_cast<std::size_t>(r) * columns.columns * kBatchLanes;
    std::fill(row, row + columns.sparse * kBatchLanes, 0.0);
  }
  unsigned by_model = own.by_model ? (1u << kBatchLanes) - 1 : 0;
  for (size_t s = 0; s < own.shots.size() && !own.by_model; ++s) {
    by_model |= EvaluateBatch(own.shots[s].program, request.points_[group][s], columns.shots[s],
                              own.Data(batch, static_cast<int>(s)), scratch, rows);
  }
  for (int lane = 0; lane < kBatchLanes; ++lane) {
    const int unit = batch * kBatchLanes + lane;
    if (unit >= own.num_units) {
      for (int i = 0; i < own.rows * columns.columns; ++i) rows[i * kBatchLanes + lane] = 0.0;
    } else if ((by_model >> lane & 1u) != 0 && !EvaluateByModel(request, own, columns, unit, lane, rows)) {
      return false;
    }
  }
  if (marginalises_) {
    double* const factor = scratch->Reserve(static_cast<std::size_t>(own.rows) * own.rows * kBatchLanes);
    MarginaliseLanes(own.rows, columns.columns, columns.latent, columns.latents, rows, factor);
  }
  return true;
}

bool RowBatches::EvaluateByModel(const Request& request, const Group& group, const BatchColumns& columns, int unit,
                                 int lane, double* rows) const {
  const std::vector<double> exact(model_.robot().num_joints(), 0.0);
  const int* position = group.observations.data() + static_cast<std::size_t>(unit) * group.per_unit();
  for (size_t s = 0; s < group.shots.size(); ++s) {
    const BatchLayout& layout = columns.shots[s].layout;
    const int shot = data_.observations[observations_[*position]].shot;
    std::vector<MarkerInFrame> markers;
    for (size_t i = 0; i < group.shots[s].markers.size(); ++i) {
      const int m = group.shots[s].markers[i];
      markers.push_back({marker_frames_[m], request.markers_[m], m, group.shots[s].kinds[i], request.turns_[m]});
    }
    std::vector<PointPrediction> predictions;
    if (!model_.Predict(shot_inputs_[shot], request.theta_.data(), request.active_,
                        request.bases_[group.shots[s].station], markers, &predictions,
                        num_latents() == 0 ? nullptr : exact.data())) {
      return false;
    }
    for (size_t m = 0; m < markers.size(); ++m, ++position) {
      const PointPrediction& point = predictions[m];
      const Observation& observation = data_.observations[observations_[*position]];
      const bool is_measured = against_ == RowsAgainst::kMeasured;
      const Vector3<double> misfit =
          is_measured ? Vector3<double>(-MeasuredMinusPredicted(observation.reading(), point.point)) : point.point;
      const Matrix3<double> root = group.by_model ? group.whiteners[position - group.observations.data()]
                                                  : PackedWhitener(group.shots[s].program.markers[m], lane,
                                                                   group.Data(unit / kBatchLanes, static_cast<int>(s)));
      Matrix3<double> whitener = root;  // of what was not measured: the prediction's own derivative
      if (misfit.allFinite()) whitener *= MisfitByPrediction(observation.kind, misfit);
      const int row = layout.first_row + 3 * static_cast<int>(m);
      const auto write = [&](int column, const Vector3<double>& derivative) {
        const Vector3<double> whitened = whitener * derivative;
        for (int i = 0; i < 3; ++i) {
          rows[(static_cast<std::size_t>(row + i) * columns.columns + column) * kBatchLanes + lane] = whitened[i];
        }
      };
      for (int i = 0; i < 3 && layout.station >= 0; ++i) {
        write(layout.station + i, point.d_translation.col(i));
        write(layout.station + 3 + i, point.d_rotation.col(i));
      }
      for (int i = 0; i < 3 && layout.markers[m] >= 0; ++i) write(layout.markers[m] + i, point.d_marker.col(i));
      for (size_t i = 0; i < request.active_.size(); ++i) write(layout.theta[request.active_[i]], point.d_theta.col(i));
      for (size_t i = 0; i < layout.latent_joints.size(); ++i) {
        write(layout.latent + static_cast<int>(i),
              layout.latent_sigmas[i] * point.d_latent.col(layout.latent_joints[i]));
      }
      const Vector3<double> residual = root * misfit;
      for (int i = 0; i < 3; ++i) {
        rows[(static_cast<std::size_t>(row + i) * columns.columns + layout.residual) * kBatchLanes + lane] =
            residual[i];
      }
    }
  }
  return true;
}

std::vector<std::vector<double>> RowBatches::LargestMotions(const std::vector<ParameterSet>& at, int most) const {
  std::vector<std::vector<double>> all;
  BatchScratch scratch;
  for (const ParameterSet& values : at) {
    const Request request(*this, values, {});
    std::vector<double>& largest = all.emplace_back(model_.num_parameters(), 0.0);
    for (int g = 0; g < num_groups(); ++g) {
      const Group& group = *groups_[g];
      const auto shots = static_cast<int>(group.shots.size()), looked_at = std::min(group.num_batches(), most);
      for (int i = 0; i < looked_at * shots; ++i) {
        const auto batch = static_cast<int>(static_cast<long>(i / shots) * group.num_batches() / looked_at);
        const auto s = static_cast<size_t>(i % shots);
        const unsigned left = group.by_model
                                  ? (1u << kBatchLanes) - 1
                                  : RaiseMotions(group.shots[s].program, request.points_[g][s],
                                                 group.Data(batch, static_cast<int>(s)), &scratch, largest.data());
        for (int lane = 0; lane < kBatchLanes; ++lane) {
          const int unit = batch * kBatchLanes + lane;
          if ((left >> lane & 1u) != 0 && unit < group.num_units) RaiseByModel(group, s, unit, values, &largest);
        }
      }
    }
  }
  return all;
}

std::vector<int> RowBatches::FindWrenchTorques(const ParameterSet& at, Eigen::MatrixXd* torques) const {
  using Lane = Eigen::Map<const Eigen::RowVectorXd, 0, Eigen::InnerStride<kBatchLanes>>;
  const Request request(*this, at, {});
  BatchScratch scratch;
  std::vector<int> left_out;
  std::vector<double> found(static_cast<size_t>(torques->cols()) * kBatchLanes);
  for (int g = 0; g < num_groups(); ++g) {
    const Group& group = *groups_[g];
    for (int batch = 0; batch < group.num_batches(); ++batch) {
      for (size_t s = 0; s < group.shots.size(); ++s) {
        const unsigned left = group.by_model
                                  ? (1u << kBatchLanes) - 1
                                  : WrenchTorques(group.shots[s].program, request.points_[g][s],
                                                  group.Data(batch, static_cast<int>(s)), &scratch, found.data());
        for (int lane = 0; lane < kBatchLanes && batch * kBatchLanes + lane < group.num_units; ++lane) {
          const int shot = ShotOf(group, s, batch * kBatchLanes + lane);
          if ((left >> lane & 1u) != 0) left_out.push_back(shot);
          if ((left >> lane & 1u) == 0) torques->row(shot) = Lane(found.data() + lane, torques->cols());
        }
      }
    }
  }
  return left_out;
}

int RowBatches::ShotOf(const Group& group, size_t shot, int unit) const {
  const int* position = group.observations.data() + static_cast<std::size_t>(unit) * group.per_unit();
  for (size_t s = 0; s < shot; ++s) position += group.shots[s].markers.size();
  return data_.observations[observations_[*position]].shot;
}

void RowBatches::RaiseByModel(const Group& group, size_t shot, int unit, const ParameterSet& at,
                              std::vector<double>* largest) const {
  const int index = ShotOf(group, shot, unit);
  std::vector<MarkerInFrame> markers;
  for (const int m : group.shots[shot].markers) markers.push_back({marker_frames_[m], at.MarkerPoint(m), m});
  const std::vector<double> motion = MotionPerUnit(model_, shot_inputs_[index], at.ModelValues().data(),
                                                   at.BaseInStation(group.shots[shot].station), markers);
  for (size_t i = 0; i < largest->size(); ++i) {
    if (model_.parameters()[i].law != ParameterLaw::kGeometry) {
      (*largest)[i] = std::max((*largest)[i], motion[i]);
    }
  }
}

double* BatchBuffer::Reserve(std::size_t doubles) {
  if (memory_.size() < doubles + kBatchLanes) memory_.resize(doubles + kBatchLanes);
  double* const first = Aligned(memory_.data());
  std::fill(first, first + doubles, 0.0);
  return first;
}

}  // namespace sagitta

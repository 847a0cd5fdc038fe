#include "estimator/explanations/evidence_columns.h"

#include <glog/logging.h>

#include <algorithm>
#include <map>
#include <set>

#include "estimator/explanations/compensator_shapes.h"
#include "estimator/explanations/drivers.h"
#include "estimator/explanations/typical_units.h"
#include "estimator/least_squares/all_joints.h"
#include "models/effects/catalogue.h"
#include "models/effects/learnt_deviation.h"
#include "models/sight.h"
#include "problems/split.h"

namespace sagitta {
namespace {

constexpr int kRowsPerBlock = 384;  // enough for the products to run at full speed
// Bytes of linearized blocks that are kept; of more the rows are linearized again in each pass, and all products made.
constexpr size_t kMostStored = size_t{2} << 30;

// A force that is the same everywhere; it acts where joints give way.
EffectSpec UnitPull() { return {LearntPull().name, "robot", {{"degree", "0"}}, {}}; }
// Those of which no other is there already.

std::vector<EffectSpec> Missing(const std::vector<EffectSpec>& among, const std::vector<EffectSpec>& specs) {
  std::vector<EffectSpec> missing;
  for (const EffectSpec& spec : specs) {
    const bool is_there =
        std::any_of(among.begin(), among.end(), [&](const EffectSpec& own) { return own.Path() == spec.Path(); });
    if (!is_there) missing.push_back(spec);
  }
  return missing;
}

}  // namespace

SourceUnit UnitOf(const Source& source, const Chain& chain) {
  switch (source.kind) {
    case Source::Kind::kJoint:
      if (chain.joints[source.owner].type == JointType::kRevolute) return {kTypicalTurn, "urad"};
      return {kTypicalTravel, "um"};
    case Source::Kind::kStation:
    case Source::Kind::kMarker:
      break;
    case Source::Kind::kStationTurn:
      return {kTypicalStationTurn, "urad"};
    case Source::Kind::kStationScale:
      return {kTypicalScale, "ppm"};
    case Source::Kind::kReading:
      if (source.axis != static_cast<int>(Sensed::kRange)) return {kTypicalStationTurn, "urad"};
      break;
    case Source::Kind::kPlate:
      if (source.axis >= 3) return {kTypicalPlateTurn, "urad"};
      break;
    case Source::Kind::kLink:
      return {kTypicalGrowth, "ppm"};
    case Source::Kind::kLoad:
      return {kTypicalLoadShift, "um"};
    case Source::Kind::kPull:
      return {kTypicalPull, "um"};
  }
  return {kTypicalMovement, "um"};
}

RowScatter StatedScatter(const CalibrationProblem& problem) {
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(problem.robot().num_joints());
  RowScatter scatter{none, none};
  for (int i = 0; i < problem.latent.size(); ++i) scatter.visit[problem.latent.joints[i]] = problem.latent.sigmas[i];
  return scatter;
}

EvidenceColumns::SplitCandidates EvidenceColumns::Split(const CalibrationProblem& problem,
                                                        const std::vector<Candidate>& candidates) {
  const Robot& robot = problem.model().robot();
  SplitCandidates split;
  std::set<std::string> known;
  for (const EffectSpec& own : robot.effects) known.insert(own.Path());
  for (size_t c = 0; c < candidates.size(); ++c) {
    const EffectSpec& spec = candidates[c].spec;
    if (IsGravityCompensator(spec) || !known.insert(spec.Path()).second) continue;
    auto motions = SingleMotionsOf(robot, problem.data().markers, spec, problem.shot_inputs());
    if (motions) {
      split.motions.emplace_back(c, std::move(*motions));
    } else {
      split.others.push_back(spec);
    }
  }
  return split;
}

EvidenceColumns::EvidenceColumns(const CalibrationProblem& problem, const ParameterSet& parameters,
                                 const std::vector<Candidate>& candidates, const LinearizedAbout& about)
    : extended_(problem), stated_(StatedScatter(problem)), of_candidate_(candidates.size()) {
  const SplitCandidates split = Split(problem, candidates);
  const std::vector<EffectSpec> further = Missing(split.others, about.effects);  // their columns are elsewhere
  std::vector<EffectSpec> added = further;
  added.insert(added.end(), split.others.begin(), split.others.end());
  if (!problem.robot().compliances.empty()) added.push_back(UnitPull());
  extended_ = problem.WithEffects(added);
  extended_.parameters.CopyByName(parameters);
  extended_.parameters.CopyByName(about.parameters);
  SetSubtracted(parameters, about);
  extended_.latent = WithAllJoints(problem.latent, problem.robot().num_joints());
  const ParameterSet& all = extended_.parameters;
  std::map<std::string, std::vector<int>> coordinates_of;  // by path
  for (int i = 0; i < all.num_coordinates(); ++i) {
    const std::string& name = all.coordinates()[i].name;
    const int own = parameters.FindCoordinate(name);
    if (own < 0) coordinates_of[name.substr(0, name.rfind('/'))].push_back(i);
    if (own >= 0 && parameters.coordinates()[own].estimated()) believed_.push_back(i);
  }
  for (const EffectSpec& spec : further) coordinates_of.erase(spec.Path());
  for (size_t c = 0; c < candidates.size(); ++c) {
    const auto own = coordinates_of.find(candidates[c].spec.Path());
    if (own == coordinates_of.end()) continue;
    for (const int coordinate : own->second) {
      names_[catalogue_.size()] = all.coordinates()[coordinate].name;
      of_candidate_[c].push_back(static_cast<int>(catalogue_.size()));
      catalogue_.push_back(coordinate);
    }
    coordinates_of.erase(own);
  }
  AddStatedSpring(candidates, parameters);
  num_columns_ = static_cast<int>(catalogue_.size());
  const std::vector<double> sizes = TypicalSizes(extended_, all, split.others);
  for (const int coordinate : catalogue_) {
    const bool is_spring = all.coordinates()[coordinate].kind == CoordinateKind::kCompensator;
    units_.push_back(is_spring
                         ? TypicalSpringError(parameters, parameters.FindCoordinate(all.coordinates()[coordinate].name))
                         : AsFound(sizes[coordinate], all.coordinates()[coordinate].name));
  }
  SetLinearized();
  SetBlocks();
  AddMotions(candidates, split);
}

double EvidenceColumns::AsFound(double size, const std::string& name) const {
  const int coordinate = extended_.parameters.FindCoordinate(name);
  return coordinate < 0 ? size : std::max(size, std::abs(extended_.parameters.Value(coordinate)) / kWidestScale);
}

void EvidenceColumns::AddStatedSpring(const std::vector<Candidate>& candidates, const ParameterSet& believed) {
  if (!extended_.robot().gravity_compensator) return;
  for (size_t c = 0; c < candidates.size(); ++c) {
    if (!IsGravityCompensator(candidates[c].spec)) continue;
    for (const int held : HeldSpring(believed)) {
      const std::string& name = believed.coordinates()[held].name;
      names_[catalogue_.size()] = name;
      of_candidate_[c].push_back(static_cast<int>(catalogue_.size()));
      catalogue_.push_back(extended_.parameters.FindCoordinate(name));
    }
  }
}

void EvidenceColumns::SetSubtracted(const ParameterSet& believed, const LinearizedAbout& about) {
  const ParameterSet& all = extended_.parameters;
  const auto is_assumed = [this, &about](const std::string& name) {
    return about.holds_weight && std::any_of(about.effects.begin(), about.effects.end(), [&](const EffectSpec& spec) {
             return IsWeight(extended_.robot(), spec) && IsParameterOf(spec, name);
           });
  };
  for (int i = 0; i < all.num_coordinates(); ++i) {
    const Coordinate& coordinate = all.coordinates()[i];
    const int own = believed.FindCoordinate(coordinate.name), there = about.parameters.FindCoordinate(coordinate.name);
    if (there < 0) continue;
    if (own >= 0 && !believed.coordinates()[own].estimated() && about.parameters.coordinates()[there].estimated()) {
      subtracted_.push_back({i, all.Value(i) - believed.Value(own), false});
    }
    if (own < 0 && !IsSpringShape(coordinate)) subtracted_.push_back({i, all.Value(i), is_assumed(coordinate.name)});
  }
}

void EvidenceColumns::AddMotions(const std::vector<Candidate>& candidates, const SplitCandidates& split) {
  const Robot& robot = extended_.robot();
  const std::vector<int> fitted = FittedShots(extended_);
  struct Column {
    size_t candidate, parameter;
    std::string name;
    const Eigen::VectorXd* per_unit;
    double size;
  };
  std::map<Source, std::vector<Column>> of_source;
  for (const auto& [c, motions] : split.motions) {
    const EffectSpec& spec = candidates[c].spec;
    const auto own = FindEffect(robot, spec.effect)->parameters(robot, spec);
    std::vector<double> largest;
    for (const SingleMotion& motion : motions) largest.push_back(motion.per_unit(fitted).cwiseAbs().maxCoeff());
    const std::vector<double> sizes = TypicalSizes(own, largest);
    for (size_t k = 0; k < own.size(); ++k) {
      const std::string name = spec.Path() + "/" + own[k].name;
      const bool is_joint = motions[k].of == SingleMotion::Of::kJoint;
      const Source source{is_joint ? Source::Kind::kJoint : Source::Kind::kMarker, motions[k].owner, motions[k].axis};
      of_source[source].push_back({c, k, name, &motions[k].per_unit, AsFound(sizes[k], name) / TypicalSizeOf(source)});
    }
    of_candidate_[c].resize(own.size());
  }
  for (const auto& [source, columns] : of_source) {
    auto functions = std::make_shared<Eigen::MatrixXd>(static_cast<long>(extended_.data().shots.size()),
                                                       static_cast<long>(columns.size()));
    for (size_t i = 0; i < columns.size(); ++i) {
      functions->col(static_cast<long>(i)) = columns[i].size * *columns[i].per_unit;
    }
    const std::vector<int> added = Add({source, functions});
    for (size_t i = 0; i < columns.size(); ++i) {
      of_candidate_[columns[i].candidate][columns[i].parameter] = added[i];
      names_[added[i]] = columns[i].name;
    }
  }
}

void EvidenceColumns::SetLinearized() {
  loads_ = LoadsCarried(extended_.data());
  const ParameterSet& all = extended_.parameters;
  linearized_ = believed_;
  linearized_.insert(linearized_.end(), catalogue_.begin(), catalogue_.end());
  for (const Subtracted& each : subtracted_) {
    const bool is_there = std::find(catalogue_.begin(), catalogue_.end(), each.coordinate) != catalogue_.end();
    if (!is_there) linearized_.push_back(each.coordinate);
  }
  const std::set<int> there(linearized_.begin(), linearized_.end());
  const auto append = [&](const ParameterBlock& block) {
    for (int i = 0; i < block.tangent_size; ++i) {
      if (there.count(block.first_coordinate + i) == 0) linearized_.push_back(block.first_coordinate + i);
    }
  };
  for (int s = 0; s < all.num_stations(); ++s) {
    append(all.station_translation(s));
    append(all.station_rotation(s));
  }
  for (int m = 0; m < all.num_markers(); ++m) append(all.marker(m));
  for (int axis = 0; axis < 3; ++axis) {
    if (PullAlong(axis) >= 0) linearized_.push_back(PullAlong(axis));
  }
  for (int joint = -1; joint < extended_.robot().num_joints(); ++joint) {
    for (const auto& [coordinate, nominal] : LengthsOf(joint)) {
      if (there.count(coordinate) == 0) linearized_.push_back(coordinate);
    }
  }
}

void EvidenceColumns::SetBlocks() {
  const Measurements& data = extended_.data();
  std::vector<int> pose_of_configuration(data.configurations.size(), -1);
  int next = 0;
  for (const std::vector<int>& group : GroupsOfEqualJointValues(data)) {
    for (const int c : group) pose_of_configuration[c] = next;
    ++next;
  }
  std::map<int, int> place;
  pose_of_observation_.assign(data.observations.size(), -1);
  std::vector<std::set<int>> visits;
  for (const int i : extended_.CalibrationObservations()) {
    const int shot = data.observations[i].shot;
    const auto entry =
        place.emplace(pose_of_configuration[data.shots[shot].configuration], static_cast<int>(poses_.size()));
    if (entry.second) {
      poses_.emplace_back();
      visits.emplace_back();
    }
    poses_[entry.first->second].push_back(i);
    visits[entry.first->second].insert(extended_.latent.visit_of_shot[shot]);
    pose_of_observation_[i] = entry.first->second;
  }
  for (const std::set<int>& own : visits) has_revisits_ |= own.size() > 1;
  fitted_shots_ = FittedShots(extended_);
  place_of_shot_.assign(data.shots.size(), -1);
  for (size_t k = 0; k < fitted_shots_.size(); ++k) place_of_shot_[fitted_shots_[k]] = static_cast<int>(k);
  for (const std::vector<int>& pose : poses_) {
    if (observations_of_block_.empty() || 3 * observations_of_block_.back().size() > kRowsPerBlock) {
      observations_of_block_.emplace_back();
    }
    std::vector<int>& block = observations_of_block_.back();
    block.insert(block.end(), pose.begin(), pose.end());
  }
  size_t bytes = 0;
  for (const std::vector<int>& observations : observations_of_block_) {
    bytes += 3 * observations.size() * linearized_.size() * sizeof(double);
    if (!stored_.empty() && bytes > kMostStored) break;
    stored_.push_back(LinearizeBlock(observations));
  }
  VLOG(1) << "diagnosis: " << linearized_.size() << " linearized columns of " << num_rows() << " rows, "
          << stored_.size() << " of " << observations_of_block_.size() << " blocks are kept";
}

std::vector<int> EvidenceColumns::Add(const FunctionFamily& family) {
  const auto known = std::find(sources_.begin(), sources_.end(), family.source);
  source_of_family_.push_back(static_cast<size_t>(known - sources_.begin()));
  if (known == sources_.end()) {
    sources_.push_back(family.source);
    for (Block& block : stored_) block.sources.push_back(SourceRows(block, family.source));
  }
  std::vector<int> own;
  for (int f = 0; f < family.functions->cols(); ++f) {
    family_of_column_.push_back(static_cast<int>(families_.size()));
    function_of_column_.push_back(f);
    own.push_back(num_columns_++);
  }
  families_.push_back(family);
  return own;
}

std::vector<std::pair<int, double>> EvidenceColumns::LengthsOf(int joint) const {
  std::vector<std::pair<int, double>> lengths;
  const std::vector<std::vector<int>> links = LengthsByLink(extended_.robot().chain);
  for (const int transform : links[static_cast<size_t>(joint) + 1]) {
    const ElementaryTransform& length = extended_.robot().chain.transforms[transform];
    const int coordinate = length.error.empty() ? -1 : extended_.parameters.FindCoordinate(GeometryName(length.error));
    if (coordinate >= 0) lengths.emplace_back(coordinate, length.nominal);
  }
  return lengths;
}

int EvidenceColumns::LoadPointOf(int load, int axis) const {
  const EffectSpec spec{LoadCom().name, loads_[load], {}, {}};
  const std::string name = FindEffect(spec.effect)->parameters(extended_.robot(), spec)[axis].name;
  const int coordinate = extended_.parameters.FindCoordinate(spec.Path() + "/" + name);
  const bool is_there = std::find(linearized_.begin(), linearized_.end(), coordinate) != linearized_.end();
  return is_there ? coordinate : -1;
}

int EvidenceColumns::PullAlong(int axis) const {
  return extended_.parameters.FindCoordinate(UnitPull().Path() + "/" + "xyz"[axis] + "1");
}

std::optional<Source> EvidenceColumns::MotionOf(int column) const {
  if (static_cast<size_t>(column) < catalogue_.size()) return std::nullopt;
  return sources_[SourceOf(column)];
}

Eigen::MatrixXd EvidenceColumns::FunctionOf(const std::vector<int>& columns) const {
  Eigen::MatrixXd functions(static_cast<long>(extended_.data().shots.size()), columns.size());
  for (size_t c = 0; c < columns.size(); ++c) {
    const size_t beyond = static_cast<size_t>(columns[c]) - catalogue_.size();
    functions.col(c) = families_[family_of_column_[beyond]].functions->col(function_of_column_[beyond]);
  }
  return functions;
}

EvidenceColumns::Block EvidenceColumns::LinearizeBlock(const std::vector<int>& observations) const {
  const NoiseRoots noise = ObservationNoise(extended_, observations, kFallbackSigma);
  Block block{observations,
              Linearize(extended_, extended_.parameters, observations, linearized_, noise, LatentTreatment::kIgnore),
              {}};
  if (subtracted_.empty()) return block;
  ParameterSet without = extended_.parameters;
  Eigen::VectorXd step = Eigen::VectorXd::Zero(without.num_coordinates());
  for (const Subtracted& each : subtracted_) {
    const auto at = std::find(linearized_.begin(), linearized_.end(), each.coordinate) - linearized_.begin();
    block.here.residual -= each.value * block.here.jacobian.col(at);
    if (!each.is_assumed) step[each.coordinate] = -each.value;
  }
  without.Plus(step);
  block.here.jacobian.leftCols(num_believed()) =
      Linearize(extended_, without, observations, believed_, noise, LatentTreatment::kIgnore).jacobian;
  return block;
}

const EvidenceColumns::Block& EvidenceColumns::BlockOf(int index, Block* scratch) const {
  if (index < static_cast<int>(stored_.size())) return stored_[index];
  *scratch = LinearizeBlock(observations_of_block_[index]);
  return *scratch;
}

std::vector<std::pair<int, double>> EvidenceColumns::MovedBy(const Source& source) const {
  const ParameterSet& all = extended_.parameters;
  const double size = TypicalSizeOf(source);
  const Vector3<double> axis = Vector3<double>::Unit(source.axis % 3);
  std::vector<std::pair<int, double>> moved;
  switch (source.kind) {
    case Source::Kind::kJoint:
    case Source::Kind::kStationScale:
    case Source::Kind::kReading:
      break;
    case Source::Kind::kPull:
      moved.emplace_back(PullAlong(source.axis), size);
      break;
    case Source::Kind::kStation:
      moved.emplace_back(all.station_translation(source.owner).first_coordinate + source.axis, size);
      break;
    case Source::Kind::kStationTurn:
      moved.emplace_back(all.station_rotation(source.owner).first_coordinate + source.axis, size);
      break;
    case Source::Kind::kMarker:
      moved.emplace_back(all.marker(source.owner).first_coordinate + source.axis, size);
      break;
    case Source::Kind::kPlate:
      for (const int m : extended_.MarkersOnFlange()) {
        const Vector3<double> motion = source.axis < 3 ? axis : Vector3<double>(axis.cross(all.MarkerPoint(m)));
        for (int k = 0; k < 3; ++k) moved.emplace_back(all.marker(m).first_coordinate + k, size * motion[k]);
      }
      break;
    case Source::Kind::kLoad:
      moved.emplace_back(LoadPointOf(source.owner, source.axis), size);
      break;
    case Source::Kind::kLink:
      for (const auto& [coordinate, nominal] : LengthsOf(source.owner)) moved.emplace_back(coordinate, size * nominal);
      break;
  }
  return moved;
}

// What a unit of the source does to the rows of a block; a station's and a marker's are other coordinates for other
// rows.
Eigen::VectorXd EvidenceColumns::SourceRows(const Block& block, const Source& source) const {
  if (source.kind == Source::Kind::kJoint) {
    return TypicalSizeOf(source) * block.here.latent.col(source.owner);
  }
  if (source.kind == Source::Kind::kStationScale || source.kind == Source::Kind::kReading) {
    return ReadingRows(block, source);
  }
  Eigen::VectorXd rows = Eigen::VectorXd::Zero(block.here.num_rows());
  for (const auto& [coordinate, size] : MovedBy(source)) {
    const auto at = std::find(linearized_.begin(), linearized_.end(), coordinate);
    rows += size * block.here.jacobian.col(at - linearized_.begin());
  }
  return rows;
}

// What moves each measured point by a function of itself: with it the station's axes move as far.
Eigen::VectorXd EvidenceColumns::ReadingRows(const Block& block, const Source& source) const {
  const bool is_scale = source.kind == Source::Kind::kStationScale;
  const SightTerm term{0, static_cast<Sensed>(source.axis), SightLaw::kOne, {}};
  Eigen::MatrixXd motions = Eigen::MatrixXd::Zero(3, block.observations.size());
  for (size_t o = 0; o < block.observations.size(); ++o) {
    const Observation& reading = extended_.data().observations[block.observations[o]];
    const Vector3<double>& point = reading.point_in_station;
    if (!point.allFinite() || (!is_scale && reading.marker != source.marker)) continue;
    const Vector3<double>& instrument = extended_.shot_inputs()[reading.shot].conditions.instrument;
    motions.col(o) = is_scale ? point : SightDisplacement<double>(term, point - instrument, Vector3<double>::Zero());
  }
  motions *= TypicalSizeOf(source);
  Eigen::VectorXd rows = Eigen::VectorXd::Zero(block.here.num_rows());
  for (int axis = 0; axis < 3; ++axis) {
    const Source along{Source::Kind::kStation, source.owner, axis};
    Eigen::VectorXd moved = SourceRows(block, along) / TypicalSizeOf(along);
    for (long o = 0; o < motions.cols(); ++o) moved.segment<3>(3 * o) *= motions(axis, o);
    rows += moved;
  }
  return rows;
}

void EvidenceColumns::FillRows(const Block& block, const std::vector<int>& columns, Eigen::MatrixXd* rows) const {
  const long believed = num_believed(), count = columns.size();
  rows->resize(block.here.num_rows(), believed + count + 1);
  rows->leftCols(believed) = block.here.jacobian.leftCols(believed);
  rows->col(believed + count) = block.here.residual;
  FillColumns(block, columns, rows->middleCols(believed, count));
}

void EvidenceColumns::FillColumns(const Block& block, const std::vector<int>& columns,
                                  Eigen::Ref<Eigen::MatrixXd> rows) const {
  const long believed = num_believed();
  int family = -1;
  Eigen::VectorXd source;
  for (size_t k = 0; k < columns.size(); ++k) {
    const int column = columns[k];
    auto own = rows.col(k);
    if (column < static_cast<int>(catalogue_.size())) {
      own = units_[column] * block.here.jacobian.col(believed + column);
      continue;
    }
    const int beyond = column - static_cast<int>(catalogue_.size());
    if (family_of_column_[beyond] != family) {
      family = family_of_column_[beyond];
      const size_t known = source_of_family_[family];
      source = known < block.sources.size() ? block.sources[known] : SourceRows(block, families_[family].source);
    }
    const auto function = families_[family].functions->col(function_of_column_[beyond]);
    for (size_t o = 0; o < block.observations.size(); ++o) {
      const double value = function[extended_.data().observations[block.observations[o]].shot];
      own.segment<3>(3 * o) = value * source.segment<3>(3 * o);
    }
  }
}

}  // namespace sagitta

#include "estimator/diagnosis/evidence_columns.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "estimator/diagnosis/typical_units.h"
#include "estimator/least_squares/all_joints.h"
#include "estimator/least_squares/batch_algebra.h"
#include "models/effects/learnt_deviation.h"
#include "problems/split.h"

namespace sagitta {
namespace {

constexpr int kRowsPerBlock = 384;                 // enough for the products to run at full speed
constexpr Eigen::Index kColumnsAtOnce = 256;       // of a product, upper blocks alone: a tenth more than half of it
constexpr size_t kMostStored = 128 * 1024 * 1024;  // bytes of linearized blocks
// Of J'J scaled to a unit diagonal: below, a direction is rounding.
constexpr double kRank = 1e-13;
// Share of a column's square that is left off the believed ones: below, it is rounding of the elimination.
constexpr double kContained = 1e-9;

// R' R is added to the upper triangle, some columns at a time with the instructions that the machine has.
void AddProducts(const Eigen::MatrixXd& rows, Eigen::MatrixXd* upper) {
  const Eigen::MatrixXd turned = rows.transpose();
  const Eigen::Index width = turned.rows();
  Eigen::MatrixXd product(width, kColumnsAtOnce);
  for (Eigen::Index first = 0; first < width; first += kColumnsAtOnce) {
    const Eigen::Index columns = std::min<Eigen::Index>(kColumnsAtOnce, width - first), height = first + columns;
    const auto done = static_cast<Eigen::Index>(
        MultiplyColumns(turned.data(), width, height, turned.cols(), rows.col(first).data(), columns, product.data()));
    upper->block(0, first, done, columns) += product.topLeftCorner(done, columns);
    const Eigen::Index rest = height - done;
    if (rest > 0) {
      upper->block(done, first, rest, columns).noalias() +=
          turned.middleRows(done, rest) * rows.middleCols(first, columns);
    }
  }
}

std::vector<EffectSpec> FreshSpecs(const CalibrationProblem& problem, const std::vector<Candidate>& candidates) {
  std::set<std::string> known;
  for (const EffectSpec& own : problem.robot().effects) known.insert(own.Path());
  std::vector<EffectSpec> fresh;
  for (const Candidate& candidate : candidates) {
    const bool has_columns = !IsGravityCompensator(candidate.spec);
    if (has_columns && known.insert(candidate.spec.Path()).second) fresh.push_back(candidate.spec);
  }
  return fresh;
}

}  // namespace

double TypicalSizeOf(const Source& source, const Chain& chain) {
  switch (source.kind) {
    case Source::Kind::kJoint:
      return chain.joints[source.owner].type == JointType::kRevolute ? kTypicalTurn : kTypicalTravel;
    case Source::Kind::kStation:
    case Source::Kind::kMarker:
      return kTypicalMovement;
    case Source::Kind::kStationTurn:
      return kTypicalStationTurn;
    case Source::Kind::kStationScale:
      return kTypicalScale;
    case Source::Kind::kPlate:
      return source.axis < 3 ? kTypicalMovement : kTypicalPlateTurn;
    case Source::Kind::kLink:
      return kTypicalGrowth;
  }
  return 0.0;
}

const char* UnitOf(const Source& source, const Chain& chain) {
  const bool is_turn = source.kind == Source::Kind::kStationTurn ||
                       (source.kind == Source::Kind::kPlate && source.axis >= 3) ||
                       (source.kind == Source::Kind::kJoint && chain.joints[source.owner].type == JointType::kRevolute);
  const bool is_share = source.kind == Source::Kind::kLink || source.kind == Source::Kind::kStationScale;
  return is_turn ? "urad" : is_share ? "ppm" : "um";
}

std::vector<int> MarkersOnFlange(const CalibrationProblem& problem) {
  std::vector<int> markers;
  for (size_t m = 0; m < problem.data().markers.size(); ++m) {
    if (problem.marker_frames()[m] == problem.model().chain().FlangeFrame()) markers.push_back(static_cast<int>(m));
  }
  return markers;
}

JointScatter StatedScatter(const CalibrationProblem& problem) {
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(problem.robot().num_joints());
  JointScatter scatter{none, none};
  for (int i = 0; i < problem.latent.size(); ++i) scatter.visit[problem.latent.joints[i]] = problem.latent.sigmas[i];
  return scatter;
}

EvidenceColumns::EvidenceColumns(const CalibrationProblem& problem, const ParameterSet& parameters,
                                 const std::vector<Candidate>& candidates)
    : extended_(problem.WithEffects(FreshSpecs(problem, candidates))) {
  extended_.parameters.CopyByName(parameters);
  extended_.latent = WithAllJoints(problem.latent, problem.robot().num_joints());
  const ParameterSet& all = extended_.parameters;
  std::map<std::string, std::vector<int>> coordinates_of;  // by path
  for (int i = 0; i < all.num_coordinates(); ++i) {
    const std::string& name = all.coordinates()[i].name;
    const int own = parameters.FindCoordinate(name);
    if (own < 0) coordinates_of[name.substr(0, name.rfind('/'))].push_back(i);
    if (own >= 0 && parameters.coordinates()[own].estimated()) believed_.push_back(i);
  }
  for (const Candidate& candidate : candidates) {
    std::vector<int> columns;
    const auto own = coordinates_of.find(candidate.spec.Path());
    if (own != coordinates_of.end()) {
      for (const int coordinate : own->second) {
        columns.push_back(static_cast<int>(catalogue_.size()));
        catalogue_.push_back(coordinate);
        names_.push_back(all.coordinates()[coordinate].name);
      }
      coordinates_of.erase(own);
    }
    of_candidate_.push_back(std::move(columns));
  }
  num_columns_ = static_cast<int>(catalogue_.size());
  const std::vector<double> sizes = TypicalSizes(extended_, all);
  for (const int coordinate : catalogue_) units_.push_back(sizes[coordinate]);
  linearized_ = believed_;
  linearized_.insert(linearized_.end(), catalogue_.begin(), catalogue_.end());
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
  for (int joint = -1; joint < extended_.robot().num_joints(); ++joint) {
    for (const auto& [coordinate, nominal] : LengthsOf(joint)) {
      if (there.count(coordinate) == 0) linearized_.push_back(coordinate);
    }
  }

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
  int rows = 0;
  for (int pose = 0; pose < num_poses(); ++pose) {
    if (rows == 0 || rows > kRowsPerBlock) {
      poses_of_block_.emplace_back();
      rows = 0;
    }
    poses_of_block_.back().push_back(pose);
    rows += 3 * static_cast<int>(poses_[pose].size());
  }
  size_t bytes = 0;
  for (const std::vector<int>& own : poses_of_block_) {
    std::vector<int> observations;
    for (const int pose : own) observations.insert(observations.end(), poses_[pose].begin(), poses_[pose].end());
    bytes += 3 * observations.size() * linearized_.size() * sizeof(double);
    if (!stored_.empty() && bytes > kMostStored) break;
    stored_.push_back(LinearizeBlock(observations));
  }
}

std::vector<int> EvidenceColumns::Add(const FunctionFamily& family) {
  std::vector<int> own;
  for (int f = 0; f < family.functions.cols(); ++f) {
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
  for (const int transform : links[static_cast<size_t>(joint + 1)]) {
    const ElementaryTransform& length = extended_.robot().chain.transforms[transform];
    const int coordinate = length.error.empty() ? -1 : extended_.parameters.FindCoordinate("geometry/" + length.error);
    if (coordinate >= 0) lengths.emplace_back(coordinate, length.nominal);
  }
  return lengths;
}

Eigen::MatrixXd EvidenceColumns::FunctionOf(const std::vector<int>& columns) const {
  Eigen::MatrixXd functions(static_cast<long>(extended_.data().shots.size()), static_cast<long>(columns.size()));
  for (size_t c = 0; c < columns.size(); ++c) {
    const size_t beyond = static_cast<size_t>(columns[c]) - catalogue_.size();
    functions.col(static_cast<long>(c)) =
        families_[family_of_column_[beyond]].functions.col(function_of_column_[beyond]);
  }
  return functions;
}

EvidenceColumns::Block EvidenceColumns::LinearizeBlock(const std::vector<int>& observations) const {
  return {observations, Linearize(extended_, extended_.parameters, observations, linearized_,
                                  ObservationNoise(extended_, observations, kFallbackSigma), LatentTreatment::kIgnore)};
}

const EvidenceColumns::Block& EvidenceColumns::BlockOf(int index, Block* scratch) const {
  if (index < static_cast<int>(stored_.size())) return stored_[index];
  std::vector<int> observations;
  for (const int pose : poses_of_block_[index]) {
    observations.insert(observations.end(), poses_[pose].begin(), poses_[pose].end());
  }
  *scratch = LinearizeBlock(observations);
  return *scratch;
}

std::vector<std::pair<int, double>> EvidenceColumns::MovedBy(const Source& source) const {
  const ParameterSet& all = extended_.parameters;
  const double size = TypicalSizeOf(source, extended_.robot().chain);
  const Vector3<double> axis = Vector3<double>::Unit(source.axis % 3);
  std::vector<std::pair<int, double>> moved;
  switch (source.kind) {
    case Source::Kind::kJoint:
    case Source::Kind::kStationScale:
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
      for (const int m : MarkersOnFlange(extended_)) {
        const Vector3<double> motion = source.axis < 3 ? axis : Vector3<double>(axis.cross(all.MarkerPoint(m)));
        for (int k = 0; k < 3; ++k) moved.emplace_back(all.marker(m).first_coordinate + k, size * motion[k]);
      }
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
    return TypicalSizeOf(source, extended_.robot().chain) * block.here.latent.col(source.owner);
  }
  Eigen::VectorXd rows = Eigen::VectorXd::Zero(block.here.num_rows());
  if (source.kind == Source::Kind::kStationScale) {
    for (int axis = 0; axis < 3; ++axis) {
      const Source along{Source::Kind::kStation, source.owner, axis};
      Eigen::VectorXd moved = SourceRows(block, along) / TypicalSizeOf(along, extended_.robot().chain);
      for (size_t o = 0; o < block.observations.size(); ++o) {
        const Vector3<double>& point = extended_.data().observations[block.observations[o]].point_in_station;
        moved.segment<3>(static_cast<long>(3 * o)) *= kTypicalScale * (point.allFinite() ? point[axis] : 0.0);
      }
      rows += moved;
    }
    return rows;
  }
  for (const auto& [coordinate, size] : MovedBy(source)) {
    const auto at = std::find(linearized_.begin(), linearized_.end(), coordinate);
    rows += size * block.here.jacobian.col(at - linearized_.begin());
  }
  return rows;
}

void EvidenceColumns::FillRows(const Block& block, const std::vector<int>* of, Eigen::MatrixXd* rows) const {
  const long believed = static_cast<long>(believed_.size()), height = block.here.num_rows();
  const long count = of == nullptr ? num_columns_ : static_cast<long>(of->size());
  rows->resize(height, believed + count + 1);
  rows->leftCols(believed) = block.here.jacobian.leftCols(believed);
  rows->col(believed + count) = block.here.residual;
  int family = -1;
  Eigen::VectorXd source;
  Eigen::MatrixXd functions;
  for (long k = 0; k < count; ++k) {
    const int column = of == nullptr ? static_cast<int>(k) : (*of)[static_cast<size_t>(k)];
    auto own = rows->col(believed + k);
    if (column < static_cast<int>(catalogue_.size())) {
      own = units_[column] * block.here.jacobian.col(believed + column);
      continue;
    }
    const int beyond = column - static_cast<int>(catalogue_.size());
    if (family_of_column_[beyond] != family) {
      family = family_of_column_[beyond];
      source = SourceRows(block, families_[family].source);
    }
    const auto function = families_[family].functions.col(function_of_column_[beyond]);
    for (size_t o = 0; o < block.observations.size(); ++o) {
      const double value = function[extended_.data().observations[block.observations[o]].shot];
      own.segment<3>(static_cast<long>(3 * o)) = value * source.segment<3>(static_cast<long>(3 * o));
    }
  }
}

// C = I + sum over joints of visit_j^2 l_j l_j' within visits + pose_j^2 l_j l_j' within poses; rows <- chol(C)^-1
// rows.
double EvidenceColumns::Whiten(const std::vector<int>& observations, const Eigen::MatrixXd& latent,
                               const JointScatter& scatter, Eigen::MatrixXd* rows) const {
  if (scatter.visit.isZero(0.0) && scatter.pose.isZero(0.0)) return 0.0;
  double log_det = 0.0;
  size_t first = 0;
  while (first < observations.size()) {
    const int pose = pose_of_observation_[observations[first]];
    size_t last = first;
    while (last < observations.size() && pose_of_observation_[observations[last]] == pose) ++last;
    const long top = static_cast<long>(3 * first), height = static_cast<long>(3 * (last - first));
    const Eigen::MatrixXd l = latent.middleRows(top, height);
    const Eigen::MatrixXd of_visit = l * scatter.visit.asDiagonal(), of_pose = l * scatter.pose.asDiagonal();
    Eigen::MatrixXd covariance = of_pose * of_pose.transpose();
    const Eigen::MatrixXd within = of_visit * of_visit.transpose();
    for (long i = 0; i < height; ++i) {
      for (long j = 0; j <= i; ++j) {
        const auto visit = [&](long row) {
          const int observation = observations[first + static_cast<size_t>(row / 3)];
          return extended_.latent.visit_of_shot[extended_.data().observations[observation].shot];
        };
        if (visit(i) == visit(j)) covariance(i, j) += within(i, j);
      }
      covariance(i, i) += 1.0;
    }
    const Eigen::LLT<Eigen::MatrixXd> root(covariance);
    auto own = rows->middleRows(top, height);
    own = root.matrixL().solve(Eigen::MatrixXd(own));
    log_det += 2.0 * root.matrixLLT().diagonal().array().log().sum();
    first = last;
  }
  return log_det;
}

RowSums EvidenceColumns::Sum(const JointScatter& scatter, const std::vector<int>* columns,
                             const std::vector<int>& poses) const {
  const std::set<int> wanted(poses.begin(), poses.end());
  const long count = columns == nullptr ? num_columns_ : static_cast<long>(columns->size());
  const long width = static_cast<long>(believed_.size()) + count + 1;
  RowSums sums{Eigen::MatrixXd::Zero(width, width), 0.0, 0};
  Block scratch;
  Eigen::MatrixXd rows;
  for (size_t b = 0; b < poses_of_block_.size(); ++b) {
    const Block& block = BlockOf(static_cast<int>(b), &scratch);
    FillRows(block, columns, &rows);
    if (!poses.empty()) {
      for (size_t o = 0; o < block.observations.size(); ++o) {
        if (wanted.count(pose_of_observation_[block.observations[o]]) > 0) continue;
        rows.middleRows(static_cast<long>(3 * o), 3).setZero();
        sums.rows -= 3;
      }
    }
    sums.log_det += Whiten(block.observations, block.here.latent, scatter, &rows);
    AddProducts(rows, &sums.products);
    sums.rows += block.here.num_rows();
  }
  return sums;
}

EvidenceColumns::AlongJoints EvidenceColumns::SumAlongJoints() const {
  const Measurements& data = extended_.data();
  const Eigen::MatrixXd none =
      Eigen::MatrixXd::Zero(static_cast<long>(data.shots.size()), extended_.robot().num_joints());
  AlongJoints sums{none, none};
  Block scratch;
  for (size_t b = 0; b < poses_of_block_.size(); ++b) {
    const Block& block = BlockOf(static_cast<int>(b), &scratch);
    for (size_t o = 0; o < block.observations.size(); ++o) {
      const long shot = data.observations[block.observations[o]].shot, top = static_cast<long>(3 * o);
      const auto moved = block.here.latent.middleRows(top, 3);
      sums.square.row(shot) += moved.colwise().squaredNorm();
      sums.residual.row(shot) += block.here.residual.segment<3>(top).transpose() * moved;
    }
  }
  return sums;
}

std::vector<FilledBlock> EvidenceColumns::Fill(const std::vector<int>& columns, int every) const {
  std::vector<FilledBlock> filled;
  Block scratch;
  for (size_t b = 0; b < poses_of_block_.size(); b += static_cast<size_t>(every)) {
    const Block& block = BlockOf(static_cast<int>(b), &scratch);
    filled.push_back({block.observations, block.here.latent, {}});
    FillRows(block, &columns, &filled.back().rows);
  }
  return filled;
}

RowSums EvidenceColumns::Sum(const JointScatter& scatter, const std::vector<FilledBlock>& filled) const {
  const long width = filled.empty() ? 0 : filled[0].rows.cols();
  RowSums sums{Eigen::MatrixXd::Zero(width, width), 0.0, 0};
  for (FilledBlock block : filled) {
    sums.log_det += Whiten(block.observations, block.latent, scatter, &block.rows);
    AddProducts(block.rows, &sums.products);
    sums.rows += static_cast<int>(block.rows.rows());
  }
  return sums;
}

// Those that the user stated, and markers on a spring.
int EvidenceColumns::AddPriors(Eigen::MatrixXd* own, Eigen::VectorXd* along, double* square) const {
  Linearization priors;
  priors.columns = believed_;
  priors.jacobian.resize(0, static_cast<long>(believed_.size()));
  AppendPriors(extended_.parameters, &priors);
  *own += priors.jacobian.transpose() * priors.jacobian;
  *along += priors.jacobian.transpose() * priors.residual;
  *square += priors.residual.squaredNorm();
  return static_cast<int>(priors.residual.size());
}

Eigen::MatrixXd EvidenceColumns::RowsAt(const std::vector<int>& observations, const JointScatter& scatter,
                                        const std::vector<int>& columns) const {
  const Block block = LinearizeBlock(observations);
  Eigen::MatrixXd rows;
  FillRows(block, &columns, &rows);
  Whiten(block.observations, block.here.latent, scatter, &rows);
  return rows.leftCols(rows.cols() - 1);
}

Eigen::MatrixXd EvidenceColumns::FittedProducts(const JointScatter& scatter, const std::vector<int>& columns) const {
  Eigen::MatrixXd products = Sum(scatter, &columns).products.selfadjointView<Eigen::Upper>();
  const long believed = num_believed(), last = products.cols() - 1;
  Eigen::MatrixXd own = products.topLeftCorner(believed, believed);
  Eigen::VectorXd along = products.col(last).head(believed);
  AddPriors(&own, &along, &products(last, last));
  products.topLeftCorner(believed, believed) = own;
  products.col(last).head(believed) = along;
  products.row(last).head(believed) = along.transpose();
  return products;
}

BesideBelieved EvidenceColumns::Project(const RowSums& sums) const {
  const long believed = static_cast<long>(believed_.size()), width = sums.products.cols(), count = width - believed - 1;
  Eigen::MatrixXd own = sums.products.topLeftCorner(believed, believed).selfadjointView<Eigen::Upper>();
  Eigen::MatrixXd beside = sums.products.topRightCorner(believed, count + 1);
  Eigen::VectorXd along_residual = beside.col(count);
  double square = sums.products(count + believed, count + believed);
  const int priors = AddPriors(&own, &along_residual, &square);
  beside.col(count) = along_residual;
  const Eigen::VectorXd scale = own.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
      Eigen::MatrixXd(scale.asDiagonal() * own * scale.asDiagonal()));
  const double least = kRank * eigen.eigenvalues().maxCoeff();
  const int rank = static_cast<int>((eigen.eigenvalues().array() > least).count());
  const Eigen::MatrixXd basis =
      eigen.eigenvectors().rightCols(rank) * eigen.eigenvalues().tail(rank).cwiseSqrt().cwiseInverse().asDiagonal();
  const Eigen::MatrixXd along = basis.transpose() * (scale.asDiagonal() * beside);
  Eigen::MatrixXd left = sums.products.bottomRightCorner(count + 1, count + 1);
  left(count, count) = square;
  const Eigen::VectorXd before = left.diagonal();
  left.selfadjointView<Eigen::Upper>().rankUpdate(along.transpose(), -1.0);
  BesideBelieved result;
  ProjectedNormal& normal = result.normal;
  normal.information = left.topLeftCorner(count, count).selfadjointView<Eigen::Upper>();
  normal.gradient = left.col(count).head(count);
  normal.residual = left(count, count);
  normal.dof = sums.rows + priors - rank;
  for (long c = 0; c < count; ++c) {
    if (normal.information(c, c) > kContained * before[c]) continue;
    normal.information.row(c).setZero();
    normal.information.col(c).setZero();
    normal.gradient[c] = 0.0;
  }
  result.log_constant =
      -0.5 * (sums.log_det + eigen.eigenvalues().tail(rank).array().log().sum() - 2.0 * scale.array().log().sum());
  return result;
}

}  // namespace sagitta

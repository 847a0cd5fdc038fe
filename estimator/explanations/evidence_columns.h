// Normal equations of everything that may be missing, from one linearization of the believed model with all candidates
// at neutral. Rows come in blocks of whole poses and are added to the normal equations at once. What is kept grows with
// the shots by their functions alone, some thousand numbers each, beyond a store of 2 GB at most that saves linearizing
// twice.
//
// Columns are in units of their typical size. Most are "source times function": a source is one way in which a pose may
// be off (a joint deviates, a station or a marker moves along an axis), a function is one number per shot. So are the
// effects of the catalogue that do nothing but make a joint deviate or move a marker; the others have columns of the
// linearization.
#pragma once

#include <Eigen/Cholesky>
#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "estimator/explanations/candidates.h"
#include "estimator/explanations/scan.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/random_effects/evidence_score.h"
#include "models/single_motion.h"
#include "problems/reading_group.h"

namespace sagitta {

// Share of a column's square that is left off the believed ones: below, it is rounding of the elimination.
constexpr double kContained = 1e-9;

struct Source {
  enum class Kind {
    kJoint,         // a joint deviates
    kStation,       // the readings of a station move along an axis
    kStationTurn,   // the base turns in a station about an axis
    kStationScale,  // the readings of a station grow
    kReading,       // a station reads a marker's azimuth (axis 0), elevation (1) or range (2) too large
    kMarker,        // a marker moves along an axis of its frame
    kPlate,         // all markers on the flange move along an axis (0 to 2), turn about an axis of the flange (3 to 5)
    kLink,          // the lengths between a joint and the next grow
    kLoad,          // a load's centre of gravity moves along an axis of the flange, where load_com is a candidate
    kPull           // a force at the flange along an axis of the base, where joints give way
  };
  Kind kind = Kind::kJoint;
  int owner = 0;   // index of the joint, station, marker or load; of a link that of the joint before it, -1: the base
  int axis = 0;    // of all but joints, links and scales
  int marker = 0;  // of readings

  bool operator==(const Source& other) const { return Parts() == other.Parts(); }
  bool operator<(const Source& other) const { return Parts() < other.Parts(); }

 private:
  std::tuple<Kind, int, int, int> Parts() const { return {kind, owner, axis, marker}; }
};

// Its typical size, SI, and what millionths of that unit are called.
struct SourceUnit {
  double typical;
  const char* micro;
};
// Of a source's motion.
SourceUnit UnitOf(const Source& source, const Chain& chain);

// Functions of the shots that one source may follow, each a column.
struct FunctionFamily {
  Source source;
  std::shared_ptr<const Eigen::MatrixXd> functions;  // one row per shot of the data; those of other sources too
};

// How rows scatter: joint deviations that rows of one visit, or of one pose (equal joint values), share, standard
// deviations, rad or m, one per joint; and readings that scatter otherwise than the problem has it.
struct RowScatter {
  Eigen::VectorXd visit, pose;
  std::vector<ScaledGroup> readings = {};

  // Whether whitened rows are independent, of unit variance.
  bool IsUnit() const { return visit.isZero(0.0) && pose.isZero(0.0) && readings.empty(); }
};

// As the experiment states it: repeatability at each visit.
RowScatter StatedScatter(const CalibrationProblem& problem);

// Sums over rows, whitened: rows of [believed, explaining, residual] times themselves.
struct RowSums {
  Eigen::MatrixXd products;
  double log_det = 0.0;  // of the covariance that whitened them
  int rows = 0;

  static RowSums Zero(long width) { return {Eigen::MatrixXd::Zero(width, width), 0.0, 0}; }
  // The others so many times; of products the upper triangle, which is all that Project reads.
  void AddUpper(const RowSums& others, int times);
};

// Given what is believed, which is eliminated with a flat prior (or its stated one).
struct GivenBelieved {
  ProjectedNormal normal;
  double log_constant = 0.0;  // -1/2 (log |C| + log |J' C^-1 J|): compares ways to whiten
};

// Effects estimated in addition to what is believed, and the estimate of all: the point about which the model is
// linearized. With the effects' columns A and values e there, residual r - A e is that of the believed model by the
// same linear model. A spring's torque is linear in its rate alone: e holds no shape. Believed columns are those
// without the effects: the compliance's column at e holds the torque of a weight that is one of them, and would promise
// that another compliance does what the weight does. A set that holds the effects needs hardly any step of what is
// believed. But a set with another compliance in an effect's place does: what a tilt before a joint does, one behind it
// and the compliances about both axes do too, given all columns are of one torque. holds_weight: that there is a weight
// is not in question, sets without one are none, and believed columns are with the weights among the effects.
struct LinearizedAbout {
  std::vector<EffectSpec> effects;
  ParameterSet parameters;
  bool holds_weight = false;
};

// The columns of everything that is believed or may explain, and their sums over the rows.
class EvidenceColumns {
 public:
  // Candidates without columns of their own (the gravity compensator) are left out. about: none, with no effects, and
  // the model is linearized about what is believed.
  EvidenceColumns(const CalibrationProblem& problem, const ParameterSet& parameters,
                  const std::vector<Candidate>& candidates, const LinearizedAbout& about = {});

  // Adds a family; returns its columns.
  std::vector<int> Add(const FunctionFamily& family);
  int num_columns() const { return num_columns_; }
  // Columns of each candidate, empty for one that the model already has.
  const std::vector<int>& ColumnsOf(int candidate) const { return of_candidate_[candidate]; }
  // Name of the coordinate of a candidate's column.
  const std::string& Name(int column) const { return names_.at(column); }
  // Its typical size, SI.
  double TypicalOf(int column) const { return units_.at(column); }
  // Whether it is a candidate's.
  bool Has(int column) const { return names_.count(column) > 0; }

  // What a column moves as a function of the shots; none: it is the linearization's.
  std::optional<Source> MotionOf(int column) const;
  // Functions behind columns that are not the linearization's, one row per shot of the data.
  Eigen::MatrixXd FunctionOf(const std::vector<int>& columns) const;

  // Lengths of the arm between a joint (-1: the base) and the next: coordinate and nominal value, m, of each that has
  // an error.
  std::vector<std::pair<int, double>> LengthsOf(int joint) const;

  // Coordinate of a load's centre of gravity along an axis of the flange; -1: of a load that is none of load_com's
  // candidates. Loads are counted in the order of their names.
  int LoadPointOf(int load, int axis) const;
  const std::vector<std::string>& loads() const { return loads_; }
  // Coordinate of a pull at the flange along an axis of the base; -1: no joint gives way.
  int PullAlong(int axis) const;

  // Groups of configurations with equal joint values, in the order of the data.
  int num_poses() const { return static_cast<int>(poses_.size()); }
  // Whether any pose has more than one visit.
  bool HasRevisits() const { return has_revisits_; }

  std::vector<int> AllColumns() const;
  // Of some columns over all rows, or one block of rows in `every`; over the poses of each group by themselves.
  RowSums Sum(const RowScatter& scatter, const std::vector<int>& columns, int every = 1) const;
  std::vector<RowSums> SumEach(const RowScatter& scatter, const std::vector<int>& columns,
                               const std::vector<int>& group_of_pose, int every = 1) const;
  int num_rows() const { return 3 * static_cast<int>(extended_.CalibrationObservations().size()); }
  GivenBelieved Project(const RowSums& sums) const;
  // Of all columns over all rows. own: lists of columns of which the block with themselves is asked for often. Where
  // the linearized blocks are kept the other products are made as they are asked for: this must outlive what is
  // returned.
  GivenBelieved ProjectAll(const RowScatter& scatter, const std::set<std::vector<int>>& own) const;

  AlongSources SumAlong(const std::vector<Source>& sources) const;

  int num_believed() const { return static_cast<int>(believed_.size()); }
  // Rows [believed, columns] of one pose that need not be fitted, whitened.
  Eigen::MatrixXd RowsAt(const std::vector<int>& observations, const RowScatter& scatter,
                         const std::vector<int>& columns) const;
  // Products of RowSums, the priors of the believed included.
  Eigen::MatrixXd WithPriors(Eigen::MatrixXd products) const;

 private:
  struct Block {
    std::vector<int> observations;
    Linearization here;                    // believed, catalogue and source columns; joints that deviate: `latent`
    std::vector<Eigen::VectorXd> sources;  // rows of each of sources_
  };
  // Rows of one pose in a block, and what they share: C - I.
  struct PoseRows {
    long top = 0, height = 0;
  };
  std::vector<PoseRows> PosesAmong(const std::vector<int>& observations) const;
  void ScaleReadings(const PoseRows& pose, const std::vector<int>& observations,
                     const std::vector<ScaledGroup>& readings, Eigen::MatrixXd* covariance) const;
  Eigen::MatrixXd SharedBy(const PoseRows& pose, const std::vector<int>& observations, const Eigen::MatrixXd& of_visit,
                           const Eigen::MatrixXd& of_pose) const;
  // Of the covariance of one pose's rows, which begin at `top` in their block.
  struct PoseRoot {
    long top = 0;
    Eigen::LLT<Eigen::MatrixXd> root;
  };
  using BlockRoots = std::vector<PoseRoot>;  // empty: rows are independent, of unit variance

  // Candidates that the model has not: those whose parameters each move one thing, by their index, and the others.
  struct SplitCandidates {
    std::vector<std::pair<size_t, std::vector<SingleMotion>>> motions;
    std::vector<EffectSpec> others;
  };
  static SplitCandidates Split(const CalibrationProblem& problem, const std::vector<Candidate>& candidates);
  // What the effects come to about which the model is linearized.
  void SetSubtracted(const ParameterSet& believed, const LinearizedAbout& about);
  // A typical size, or what the effect is by the full model about which all is linearized: no usual size is held
  // against one that is larger than the widest scale of it.
  double AsFound(double size, const std::string& name) const;
  // Columns of the candidate that the spring the robot states is another.
  void AddStatedSpring(const std::vector<Candidate>& candidates, const ParameterSet& believed);
  // Coordinates of a block's columns.
  void SetLinearized();
  // Poses and blocks of them; the first blocks are linearized.
  void SetBlocks();
  // One family of each source.
  void AddMotions(const std::vector<Candidate>& candidates, const SplitCandidates& split);
  Block LinearizeBlock(const std::vector<int>& observations) const;
  const Block& BlockOf(int index, Block* scratch) const;
  // Of a family's column.
  size_t SourceOf(int column) const {
    return source_of_family_[family_of_column_[static_cast<size_t>(column) - catalogue_.size()]];
  }
  double TypicalSizeOf(const Source& source) const { return UnitOf(source, extended_.robot().chain).typical; }
  // Place of a fitted observation's shot among those that are fitted.
  int FittedShotOf(int observation) const { return place_of_shot_[extended_.data().observations[observation].shot]; }
  // What a unit of the source moves: coordinates, and by how much, SI.
  std::vector<std::pair<int, double>> MovedBy(const Source& source) const;
  Eigen::VectorXd SourceRows(const Block& block, const Source& source) const;
  Eigen::VectorXd ReadingRows(const Block& block, const Source& source) const;
  // [believed, columns, residual].
  void FillRows(const Block& block, const std::vector<int>& columns, Eigen::MatrixXd* rows) const;
  void FillColumns(const Block& block, const std::vector<int>& columns, Eigen::Ref<Eigen::MatrixXd> rows) const;
  // Their number.
  int AddPriors(Eigen::MatrixXd* own, Eigen::VectorXd* along, double* square) const;
  BlockRoots RootsOf(const std::vector<int>& observations, const Eigen::MatrixXd& latent,
                     const RowScatter& scatter) const;
  // rows <- root^-1 rows of each pose; log of the determinant of the covariance.
  static double Whiten(const BlockRoots& roots, Eigen::MatrixXd* rows);
  // rows <- root^-T rows: of whitened rows what C^-1 makes of them.
  static void WhitenAgain(const BlockRoots& roots, Eigen::MatrixXd* rows);
  static Eigen::VectorXd InversePivots(const BlockRoots& roots, long rows);  // 1 / L_jj of each row
  // Believed columns, with their priors, eliminated from sums with others and the residual.
  struct Eliminated {
    Eigen::MatrixXd along;  // Q'[A r], Q orthonormal over what is believed
    double square = 0.0;    // r'r, with priors
    double dof = 0.0;
    double log_constant = 0.0;  // as of GivenBelieved
  };
  Eliminated Eliminate(Eigen::MatrixXd own, Eigen::MatrixXd with_others, double square, const RowSums& sums) const;
  class ShotProducts;
  struct AllSums;
  AllSums SumAll(const RowScatter& scatter, const std::set<std::vector<int>>& own,
                 std::vector<BlockRoots>* roots) const;
  void SumOfShots(const std::vector<Eigen::MatrixXd>& along, long first, const std::vector<int>& places,
                  std::vector<Eigen::MatrixXd>* sums) const;
  // u'A of all columns of families; along: u' of each block.
  Eigen::MatrixXd AlongFamilies(const std::vector<Eigen::MatrixXd>& along) const;
  // A_k' C^-1 A of some columns with all; roots: of every block.
  Eigen::MatrixXd ProductsOf(const std::vector<int>& columns, const std::vector<BlockRoots>& roots) const;

  CalibrationProblem extended_;
  RowScatter stated_;
  std::vector<int> believed_;    // coordinates of extended_
  std::vector<int> catalogue_;   // coordinates of effects that have no families
  std::vector<int> linearized_;  // coordinates behind the columns of a block
  // Values at which the model is linearized and that move its residual back to what is believed (LinearizedAbout).
  struct Subtracted {
    int coordinate;
    double value;
    bool is_assumed;  // it stays in the believed columns
  };
  std::vector<Subtracted> subtracted_;
  std::vector<std::vector<int>> of_candidate_;
  std::vector<double> units_;         // of the columns of catalogue_
  std::map<int, std::string> names_;  // of all candidates' columns
  std::vector<FunctionFamily> families_;
  std::vector<Source> sources_;  // of the families, each once
  std::vector<size_t> source_of_family_;
  std::vector<int> family_of_column_, function_of_column_;  // of columns beyond the catalogue
  std::vector<std::string> loads_;
  int num_columns_ = 0;
  std::vector<std::vector<int>> poses_;  // observations of each
  std::vector<std::vector<int>> observations_of_block_;
  std::vector<int> pose_of_observation_;
  std::vector<int> fitted_shots_, place_of_shot_;  // ascending; of each shot of the data among those
  bool has_revisits_ = false;
  std::vector<Block> stored_;  // of the first blocks
};

}  // namespace sagitta

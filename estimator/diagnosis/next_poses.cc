#include "estimator/diagnosis/next_poses.h"

#include <glog/logging.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <set>

#include "estimator/diagnosis/pose_choice.h"
#include "estimator/least_squares/linearization.h"
#include "models/effects/catalogue.h"
#include "problems/loads.h"

namespace sagitta {
namespace {

constexpr int kPosesDrawn = 400;
constexpr double kLeastPivot = 1e-300;
constexpr double kDecided = 0.95;        // of the leading answer: nothing is left to decide
constexpr double kWorthDeciding = 0.02;  // of an answer
constexpr size_t kMostAnswers = 5;
constexpr size_t kMostShapes = 3;  // of an answer, such as those of a compensator

// The least and the largest value of each joint: its limits, or the range of the data where none are stated.
Eigen::Matrix2Xd LimitsOf(const CalibrationProblem& problem) {
  Eigen::Matrix2Xd limits(2, problem.robot().num_joints());
  for (int j = 0; j < problem.robot().num_joints(); ++j) {
    const Joint& joint = problem.robot().chain.joints[static_cast<size_t>(j)];
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Configuration& each : problem.data().configurations) {
      low = std::min(low, each.q[j]);
      high = std::max(high, each.q[j]);
    }
    const bool is_stated = joint.min && joint.max && high > low;
    limits.col(j) = is_stated ? Eigen::Vector2d(*joint.min, *joint.max) : Eigen::Vector2d(low, high);
  }
  return limits;
}

// Poses within these limits; each like a measured one.
std::vector<ProposedPose> DrawPoses(const CalibrationProblem& problem, unsigned long long seed) {
  std::mt19937_64 random(seed);
  const auto uniform = [&random](double low, double high) {
    return low + (high - low) * (static_cast<double>(random() >> 11) * 0x1p-53);
  };
  const std::vector<Configuration>& configurations = problem.data().configurations;
  const Eigen::Matrix2Xd limits = LimitsOf(problem);
  std::vector<ProposedPose> poses;
  for (int k = 0; k < kPosesDrawn; ++k) {
    ProposedPose pose;
    do {
      pose.like = static_cast<int>(random() % configurations.size());
    } while (configurations[static_cast<size_t>(pose.like)].is_validation);
    pose.q.resize(problem.robot().num_joints());
    for (int j = 0; j < problem.robot().num_joints(); ++j) pose.q[j] = uniform(limits(0, j), limits(1, j));
    poses.push_back(std::move(pose));
  }
  return poses;
}

// The problem with the poses as configurations that are not fitted, shot like those they are like.
CalibrationProblem WithPoses(const CalibrationProblem& problem, const std::vector<ProposedPose>& poses) {
  Measurements data = problem.data();
  NoiseRoots roots = problem.resolved_noise;
  for (const ProposedPose& pose : poses) {
    const int configuration = static_cast<int>(data.configurations.size());
    data.configurations.push_back({"next" + std::to_string(configuration), pose.q, true});
    const size_t shots = problem.data().shots.size();
    for (size_t s = 0; s < shots; ++s) {
      if (problem.data().shots[s].configuration != pose.like) continue;
      Shot shot = problem.data().shots[s];
      shot.configuration = configuration;
      shot.observations.clear();
      const int first = static_cast<int>(data.observations.size());
      const std::vector<int>& own = problem.data().shots[s].observations;
      for (const int o : problem.data().shots[s].observations) {
        Observation observation = problem.data().observations[static_cast<size_t>(o)];
        observation.shot = static_cast<int>(data.shots.size());
        if (observation.partner >= 0) {  // the other reading of a pose comes along
          observation.partner =
              first + static_cast<int>(std::find(own.begin(), own.end(), observation.partner) - own.begin());
        }
        shot.observations.push_back(static_cast<int>(data.observations.size()));
        data.observations.push_back(observation);
        if (!problem.resolved_noise.empty()) roots.push_back(problem.resolved_noise[static_cast<size_t>(o)]);
      }
      data.shots.push_back(std::move(shot));
    }
  }
  CalibrationProblem extended = problem;
  extended.set_data(std::move(data));
  extended.resolved_noise = std::move(roots);
  extended.weight_roots.clear();
  extended.RenewShots();
  extended.latent = MakeLatentModel(extended.robot().chain, extended.data(), extended.experiment());
  return extended;
}

// Points of the poses, the last observations, are where the model predicts them: a station reads them there.
CalibrationProblem AsPredicted(CalibrationProblem extended, const ParameterSet& parameters, size_t measured) {
  std::vector<int> added(extended.data().observations.size() - measured);
  std::iota(added.begin(), added.end(), static_cast<int>(measured));
  const Eigen::Matrix3Xd points = PredictPoints(extended, parameters, added);
  for (size_t i = 0; i < added.size(); ++i) {
    Observation& observation = extended.mutable_data()->observations[measured + i];
    if (observation.is_point()) observation.point_in_station = points.col(static_cast<long>(i));
  }
  return extended;
}

// The explanations that some sets have, in columns of their own over the rows of a problem with more poses.
class FewColumns {
 public:
  FewColumns(const Evidence& evidence, const std::vector<const WeightedSet*>& sets, const CalibrationProblem& extended,
             const ParameterSet& parameters)
      : given_(evidence.list()),
        candidates_(CandidatesOf(sets)),
        columns_(extended, parameters, candidates_.candidates),
        list_(ListExplanations(extended, parameters, candidates_, evidence.masses(), &columns_, AnyUnnamed(sets))) {}

  const EvidenceColumns& columns() const { return columns_; }
  const ExplanationList& list() const { return list_; }

  // Whether both list the same functions without a name. They are listed by the fitted rows, which are the same; only
  // where two say equally much of these, rounding may list another.
  bool AreListed() const { return list_.functions.empty() || list_.functions.size() == given_.functions.size(); }

  // The same set by the numbers of this list.
  WeightedSet Here(WeightedSet set) const {
    for (int& member : set.members) member = NumberOf(member);
    return set;
  }

 private:
  CandidateList CandidatesOf(const std::vector<const WeightedSet*>& sets) const {
    std::set<int> used;
    for (const WeightedSet* set : sets) {
      for (const int m : set->members) used.insert(given_.candidate[m]);
    }
    const int all = AnyUnnamed(sets) ? static_cast<int>(given_.candidates.size()) : 0;
    for (int c = 0; c < all; ++c) {  // functions without a name move load points too
      if (given_.candidates[c].spec.effect == LoadCom().name) used.insert(c);
    }
    CandidateList few;
    for (const int candidate : used) {
      if (candidate >= 0) few.candidates.push_back(given_.candidates[candidate]);
    }
    return few;
  }

  bool AnyUnnamed(const std::vector<const WeightedSet*>& sets) const {
    return std::any_of(sets.begin(), sets.end(), [&](const WeightedSet* set) {
      return std::any_of(set->members.begin(), set->members.end(), [&](int m) { return given_.IsUnnamed(m); });
    });
  }

  // What has no name comes last in both lists, all of it in the same order; of the catalogue one start has one place.
  int NumberOf(int member) const {
    const int here = static_cast<int>(list_.math.size());
    if (given_.IsUnnamed(member)) return here - static_cast<int>(given_.functions.size()) + given_.unnamed[member];
    const EffectSpec& start = given_.start[member];
    int k = 0;
    while (k < here && (list_.start[k].Path() != start.Path() || list_.start[k].values != start.values)) ++k;
    CHECK_LT(k, here);
    return k;
  }

  const ExplanationList& given_;
  const CandidateList candidates_;
  EvidenceColumns columns_;
  const ExplanationList list_;
};

// A set that could be the right answer.
struct Rival {
  int model = 0;  // of the evidence
  double probability = 0.0;
  int name = 0;  // of the answer
};

// Columns of the members of some sets, each once.
std::vector<int> ColumnsOf(const ExplanationList& list, const std::vector<WeightedSet>& sets) {
  std::set<int> columns;
  for (const WeightedSet& set : sets) {
    for (const int m : set.members) {
      const std::vector<int>& own = list.math[static_cast<size_t>(m)].group.columns;
      columns.insert(own.begin(), own.end());
    }
  }
  return {columns.begin(), columns.end()};
}

// A set's unit prior coefficients behind the believed parameters.
class Coefficients {
 public:
  // columns: of several sets.
  Coefficients(const ExplanationList& list, const WeightedSet& set, const std::vector<int>& columns, long believed)
      : list_(list), set_(set), believed_(believed) {
    for (const int m : set.members) {
      std::vector<long>& own = places_.emplace_back();
      for (const int c : GroupOf(m).columns) {
        own.push_back(believed + (std::lower_bound(columns.begin(), columns.end(), c) - columns.begin()));
      }
      size_ += GroupOf(m).size();
    }
  }

  // Of rows that are for [believed, columns].
  Eigen::MatrixXd Of(const Eigen::MatrixXd& rows) const {
    Eigen::MatrixXd mixed(believed_ + size_, rows.cols());
    mixed.topRows(believed_) = rows.topRows(believed_);
    long first = believed_;
    for (size_t k = 0; k < set_.members.size(); ++k) {
      const ColumnGroup& group = GroupOf(set_.members[k]);
      auto own = mixed.middleRows(first, group.size());
      const Eigen::MatrixXd raw = set_.scales[k] * rows(places_[k], Eigen::all);
      if (group.mixing.size() > 0) {
        own.noalias() = group.mixing.transpose() * raw;
      } else {
        own = raw;
      }
      first += group.size();
    }
    return mixed;
  }
  long size() const { return size_; }

 private:
  const ColumnGroup& GroupOf(int member) const { return list_.math[static_cast<size_t>(member)].group; }

  const ExplanationList& list_;
  const WeightedSet& set_;
  const long believed_;
  long size_ = 0;
  std::vector<std::vector<long>> places_;  // of each member
};

// What is known of a set's coefficients, and of all poses by it. sums: of the fitted rows with [believed, columns,
// residual]; turned: the poses' rows in [believed, columns], transposed. With N = P' L D L' P of the coefficients and
// the poses' rows R in them:  m = R x,  Y = D^-1/2 L^-1 P R'.
void Predict(const Coefficients& coefficients, const Eigen::MatrixXd& sums, const Eigen::MatrixXd& turned,
             RivalRows* rows) {
  const Eigen::MatrixXd half = coefficients.Of(sums);
  Eigen::MatrixXd precision = coefficients.Of(half.leftCols(turned.rows()).transpose());
  precision.diagonal().tail(coefficients.size()).array() += 1.0;
  // What hardly anything tells must not decide: a flat prior is one of a thousand times what the data say.
  precision.diagonal() *= 1.0 + 1e-9;
  const Eigen::LDLT<Eigen::MatrixXd> factor(precision);
  rows->spread = coefficients.Of(turned);
  rows->means = -rows->spread.transpose() * factor.solve(half.col(turned.rows()));
  rows->spread = factor.transpositionsP() * rows->spread;
  factor.matrixL().solveInPlace(rows->spread);
  rows->spread.array().colwise() *= factor.vectorD().array().max(kLeastPivot).rsqrt();
}

// The sets that are worth deciding between. What is called alike, or predicts the same at new poses, is one answer: a
// deviation that follows the pose has its own value at each, and whether an effect is a piece of a nameless cause no
// pose shows.
std::vector<Rival> RivalsOf(const Evidence& evidence) {
  struct Answer {
    double probability = 0.0;
    std::vector<int> models;
  };
  std::map<std::set<std::string>, Answer> answers;
  for (size_t m = 0; m < evidence.models().size(); ++m) {
    const WeightedModel& model = evidence.models()[m];
    std::set<std::string> names;
    for (const int member : model.set.members) names.insert(evidence.list().name[member]);
    Answer& answer = answers[names];
    answer.probability += model.probability;
    const bool is_met = std::any_of(answer.models.begin(), answer.models.end(), [&](int other) {
      return evidence.models()[other].set.members == model.set.members;
    });
    if (!is_met && answer.models.size() < kMostShapes) answer.models.push_back(static_cast<int>(m));
  }
  std::vector<Answer> sorted;
  for (const auto& [names, answer] : answers) {
    if (answer.probability >= kWorthDeciding) sorted.push_back(answer);
  }
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Answer& a, const Answer& b) { return a.probability > b.probability; });
  sorted.resize(std::min(sorted.size(), kMostAnswers));
  double all = 0.0;
  for (const Answer& answer : sorted) all += answer.probability;
  std::vector<Rival> rivals;
  for (size_t k = 0; k < sorted.size(); ++k) {
    double kept = 0.0;
    for (const int m : sorted[k].models) kept += evidence.models()[m].probability;
    for (const int m : sorted[k].models) {
      const double share = evidence.models()[m].probability / kept;
      rivals.push_back({m, share * sorted[k].probability / all, static_cast<int>(k)});
    }
  }
  return rivals;
}

// Of the answers.
std::vector<double> ProbabilitiesOf(const std::vector<Rival>& rivals) {
  std::vector<double> probabilities;
  for (const Rival& rival : rivals) {
    probabilities.resize(std::max(probabilities.size(), static_cast<size_t>(rival.name) + 1), 0.0);
    probabilities[static_cast<size_t>(rival.name)] += rival.probability;
  }
  return probabilities;
}

// Observations of each of the poses, the last configurations of the extended problem.
std::vector<std::vector<int>> ObservationsOf(const CalibrationProblem& extended, size_t poses) {
  const size_t first = extended.data().configurations.size() - poses;
  std::vector<std::vector<int>> observations(poses);
  for (size_t o = 0; o < extended.data().observations.size(); ++o) {
    const size_t c = static_cast<size_t>(extended.data().shots[extended.data().observations[o].shot].configuration);
    if (c >= first) observations[c - first].push_back(static_cast<int>(o));
  }
  return observations;
}

std::optional<PoseChoice> ChoiceOf(const Evidence& evidence, const std::vector<Rival>& rivals,
                                   const CalibrationProblem& extended, const ParameterSet& parameters, size_t poses) {
  std::vector<const WeightedSet*> sets;
  for (const Rival& rival : rivals) sets.push_back(&evidence.models()[rival.model].set);
  const FewColumns few(evidence, sets, extended, parameters);
  if (!few.AreListed()) return std::nullopt;
  const JointScatter& scatter = evidence.views()[evidence.models()[rivals[0].model].view].scatter;
  std::vector<WeightedSet> here;
  for (const WeightedSet* set : sets) here.push_back(few.Here(*set));
  const std::vector<int> columns = ColumnsOf(few.list(), here);
  const std::vector<std::vector<int>> observations = ObservationsOf(extended, poses);
  std::vector<long> first_row = {0};
  for (const std::vector<int>& own : observations) {
    first_row.push_back(first_row.back() + 3 * static_cast<long>(own.size()));
  }
  const long believed = few.columns().num_believed();
  Eigen::MatrixXd turned(believed + static_cast<long>(columns.size()), first_row.back());
  for (size_t c = 0; c < poses; ++c) {
    turned.middleCols(first_row[c], first_row[c + 1] - first_row[c]) =
        few.columns().RowsAt(observations[c], scatter, columns).transpose();
  }
  const Eigen::MatrixXd sums = few.columns().FittedProducts(scatter, columns);
  std::vector<RivalRows> rows(rivals.size());
  for (size_t i = 0; i < rivals.size(); ++i) {
    rows[i].probability = rivals[i].probability;
    rows[i].name = rivals[i].name;
    Predict(Coefficients(few.list(), here[i], columns, believed), sums, turned, &rows[i]);
  }
  return PoseChoice(std::move(rows), std::move(first_row));
}

}  // namespace

std::optional<NextPoses> ProposeNext(const Evidence& evidence, const CalibrationProblem& problem,
                                     const ParameterSet& parameters, unsigned long long seed) {
  const std::vector<Rival> rivals = RivalsOf(evidence);
  const std::vector<double> now = ProbabilitiesOf(rivals);
  if (now.size() < 2 || now[0] > kDecided) return std::nullopt;
  const std::vector<ProposedPose> drawn = DrawPoses(problem, seed);
  const CalibrationProblem extended =
      AsPredicted(WithPoses(problem, drawn), parameters, problem.data().observations.size());
  std::optional<PoseChoice> choice = ChoiceOf(evidence, rivals, extended, parameters, drawn.size());
  if (!choice) return std::nullopt;
  NextPoses next;
  for (const double probability : now) next.decided += probability * probability;
  for (int k = 0; k < kPosesProposed; ++k) next.poses.push_back(drawn[choice->Take()]);
  next.decides = choice->Decides();
  next.needed = choice->Needed(kWanted, kMostNeeded);
  if (next.decides < next.decided + kWorthDeciding) return std::nullopt;  // no pose decides
  return next;
}

}  // namespace sagitta

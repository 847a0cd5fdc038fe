#include "estimator/diagnosis/next_poses.h"

#include <glog/logging.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <set>

#include "estimator/least_squares/row_sums.h"
#include "estimator/statistics/mutual_information.h"
#include "problems/loads.h"

namespace sagitta {
namespace {

constexpr int kPosesDrawn = 400;
constexpr size_t kPosesTogether = 64;  // solved at once
constexpr double kLeastPivot = 1e-300;
constexpr size_t kPosesKept = 80;        // of these, asked again after each choice
constexpr double kDecided = 0.95;        // of the leading explanation: nothing is left to decide
constexpr double kWorthDeciding = 0.02;  // of an explanation
constexpr size_t kMostRivals = 5;

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

struct Rival {
  double probability = 0.0;
  std::vector<int> columns;
  Eigen::MatrixXd mixing;  // believed and own columns to unit prior coefficients
  Eigen::MatrixXd precision;
  Eigen::LDLT<Eigen::MatrixXd> factor;  // of the precision
  Eigen::VectorXd values;
};

Rival MakeRival(const EvidenceColumns& columns, const ExplanationList& list, const JointScatter& scatter,
                const WeightedSet& set, double probability) {
  Rival rival;
  rival.probability = probability;
  int size = 0;
  for (const int m : set.members) {
    const ColumnGroup& group = list.math[static_cast<size_t>(m)].group;
    rival.columns.insert(rival.columns.end(), group.columns.begin(), group.columns.end());
    size += group.size();
  }
  const long believed = columns.num_believed(), raw = static_cast<long>(rival.columns.size());
  rival.mixing.setZero(believed + raw, believed + size);
  rival.mixing.topLeftCorner(believed, believed).setIdentity();
  long row = believed, column = believed;
  for (size_t k = 0; k < set.members.size(); ++k) {
    const ColumnGroup& group = list.math[static_cast<size_t>(set.members[k])].group;
    const long height = static_cast<long>(group.columns.size());
    auto block = rival.mixing.block(row, column, height, group.size());
    if (group.mixing.size() > 0) {
      block = set.scales[k] * group.mixing;
    } else {
      block.setIdentity();
      block *= set.scales[k];
    }
    row += height;
    column += group.size();
  }
  const Eigen::MatrixXd rows = columns.FittedProducts(scatter, rival.columns);
  rival.precision = rival.mixing.transpose() * rows.topLeftCorner(believed + raw, believed + raw) * rival.mixing;
  rival.precision.diagonal().tail(size).array() += 1.0;
  // What hardly anything tells must not decide: a flat prior is one of a thousand times what the data say.
  rival.precision.diagonal() *= 1.0 + 1e-9;
  rival.factor.compute(rival.precision);
  rival.values = -rival.factor.solve(rival.mixing.transpose() * rows.col(believed + raw).head(believed + raw));
  return rival;
}

// What a pose would show under each rival.
struct Shown {
  std::vector<Eigen::MatrixXd> rows;  // of each rival, in its coefficients
};

// Rows of one rival from its columns to its coefficients, those of all poses at once.
void Mix(const Eigen::MatrixXd& mixing, size_t rival, std::vector<Shown>* shown) {
  long count = 0;
  for (const Shown& each : *shown) count += each.rows[rival].rows();
  Eigen::MatrixXd all(count, mixing.rows());
  long at = 0;
  for (const Shown& each : *shown) {
    all.middleRows(at, each.rows[rival].rows()) = each.rows[rival];
    at += each.rows[rival].rows();
  }
  all = TallProduct(all, mixing);
  at = 0;
  for (Shown& each : *shown) {
    each.rows[rival] = Eigen::MatrixXd(all.middleRows(at, each.rows[rival].rows()));
    at += each.rows[rival].rows();
  }
}

class Choice {
 public:
  Choice(std::vector<Rival> rivals, std::vector<Shown> shown) : rivals_(std::move(rivals)), shown_(std::move(shown)) {
    apart_ = Eigen::MatrixXd::Zero(static_cast<long>(rivals_.size()), static_cast<long>(rivals_.size()));
    asked_.resize(shown_.size());
    std::iota(asked_.begin(), asked_.end(), size_t{0});
  }

  // Takes the best pose that is left; its number. What is worth little at first stays so: after the first choice the
  // best kPosesKept are asked again.
  size_t Take(std::vector<bool>* taken) {
    size_t best = 0;
    double most = -1.0;
    Eigen::MatrixXd gained;
    std::vector<std::pair<double, size_t>> worths;
    std::vector<size_t> left;
    std::copy_if(asked_.begin(), asked_.end(), std::back_inserter(left), [&](size_t c) { return !(*taken)[c]; });
    for (size_t first = 0; first < left.size(); first += kPosesTogether) {
      const size_t end = std::min(left.size(), first + kPosesTogether);
      const std::vector<size_t> some(left.begin() + static_cast<long>(first), left.begin() + static_cast<long>(end));
      const std::vector<Eigen::MatrixXd> aparts = Apart(some);
      for (size_t k = 0; k < some.size(); ++k) {
        const double worth = MutualInformation(Probabilities(), apart_ + aparts[k]);
        worths.emplace_back(-worth, some[k]);
        if (worth <= most) continue;
        most = worth;
        best = some[k];
        gained = aparts[k];
      }
    }
    std::sort(worths.begin(), worths.end());
    worths.resize(std::min(worths.size(), kPosesKept));
    asked_.clear();
    for (const auto& [worth, c] : worths) asked_.push_back(c);
    (*taken)[best] = true;
    apart_ += gained;
    for (size_t i = 0; i < rivals_.size(); ++i) {
      rivals_[i].precision += shown_[best].rows[i].transpose() * shown_[best].rows[i];
      rivals_[i].factor.compute(rivals_[i].precision);
    }
    return best;
  }

  // The right one's probability afterwards, expected.
  double Decides() const { return ExpectedProbability(Probabilities(), apart_); }
  // Of poses like those that are taken.
  int Needed(int taken) const { return ReadingsNeeded(Probabilities(), apart_, taken, kWanted, kMostNeeded); }

 private:
  Eigen::VectorXd Probabilities() const {
    Eigen::VectorXd probabilities(static_cast<long>(rivals_.size()));
    for (size_t i = 0; i < rivals_.size(); ++i) probabilities[static_cast<long>(i)] = rivals_[i].probability;
    return probabilities;
  }

  // D_ij of each of these poses by itself. C_i = I + X_i P_i^-1 X_i' of the rows X_i that the pose shows and the
  // precision P_i = L_i D_i L_i': one solution with L_i for all poses.
  std::vector<Eigen::MatrixXd> Apart(const std::vector<size_t>& poses) const {
    const long n = static_cast<long>(rivals_.size());
    std::vector<std::vector<Eigen::VectorXd>> means(poses.size());
    std::vector<std::vector<Eigen::MatrixXd>> covariances(poses.size());
    for (size_t i = 0; i < rivals_.size(); ++i) {
      const Rival& rival = rivals_[i];
      long count = 0;
      for (const size_t c : poses) count += shown_[c].rows[i].rows();
      Eigen::MatrixXd columns(rival.values.size(), count);  // of all poses
      long at = 0;
      for (size_t k = 0; k < poses.size(); ++k) {
        const Eigen::MatrixXd& rows = shown_[poses[k]].rows[i];
        columns.middleCols(at, rows.rows()) = rows.transpose();
        means[k].push_back(rows * rival.values);
        at += rows.rows();
      }
      columns = rival.factor.transpositionsP() * columns;
      rival.factor.matrixL().solveInPlace(columns);
      columns = rival.factor.vectorD().cwiseMax(kLeastPivot).cwiseSqrt().cwiseInverse().asDiagonal() * columns;
      at = 0;
      for (size_t k = 0; k < poses.size(); ++k) {
        const auto own = columns.middleCols(at, means[k].back().size());
        covariances[k].push_back(Eigen::MatrixXd::Identity(own.cols(), own.cols()) + own.transpose() * own);
        at += own.cols();
      }
    }
    std::vector<Eigen::MatrixXd> aparts;
    for (size_t k = 0; k < poses.size(); ++k) aparts.push_back(Distances(means[k], covariances[k], n));
    return aparts;
  }

  static Eigen::MatrixXd Distances(const std::vector<Eigen::VectorXd>& means,
                                   const std::vector<Eigen::MatrixXd>& covariances, long n) {
    Eigen::MatrixXd apart = Eigen::MatrixXd::Zero(n, n);
    for (long i = 0; i < n; ++i) {
      for (long j = 0; j < i; ++j) {
        const Eigen::VectorXd difference = means[static_cast<size_t>(i)] - means[static_cast<size_t>(j)];
        const Eigen::MatrixXd mean = 0.5 * (covariances[static_cast<size_t>(i)] + covariances[static_cast<size_t>(j)]);
        apart(i, j) = apart(j, i) = difference.dot(mean.llt().solve(difference));
      }
    }
    return apart;
  }

  std::vector<Rival> rivals_;
  std::vector<Shown> shown_;
  Eigen::MatrixXd apart_;  // D_ij of the poses that are taken
  std::vector<size_t> asked_;
};

}  // namespace

std::optional<NextPoses> ProposeNext(const Evidence& evidence, const Posterior& posterior,
                                     const CalibrationProblem& problem, const ParameterSet& parameters,
                                     unsigned long long seed) {
  if (posterior.sets.empty()) return std::nullopt;
  struct Held {
    int model;
    double probability;
  };
  std::vector<Held> held;
  double sum = 0.0;
  const double nothing = posterior.nothing + posterior.noise;
  for (size_t m = 0; m < evidence.models().size() && nothing >= kWorthDeciding; ++m) {
    if (!evidence.models()[m].set.members.empty()) continue;
    held.push_back({static_cast<int>(m), nothing});
    break;
  }
  for (const NameSet& set : posterior.sets) {
    const std::vector<int>& members = evidence.models()[set.best].set.members;
    // A deviation that follows the pose predicts no new pose: its sets are those of their members.
    const auto same = std::find_if(held.begin(), held.end(), [&](const Held& each) {
      return evidence.models()[each.model].set.members == members;
    });
    if (same != held.end()) {
      same->probability += set.probability;
    } else if (held.size() < kMostRivals && set.probability >= kWorthDeciding && !members.empty()) {
      held.push_back({set.best, set.probability});
    }
  }
  double most = 0.0;
  for (const Held& each : held) {
    sum += each.probability;
    most = std::max(most, each.probability);
  }
  if (held.size() < 2 || most > kDecided * sum) return std::nullopt;

  const std::vector<ProposedPose> drawn = DrawPoses(problem, seed);
  const CalibrationProblem extended = WithPoses(problem, drawn);
  std::vector<const WeightedSet*> sets;
  for (const Held& each : held) sets.push_back(&evidence.models()[each.model].set);
  const FewColumns few(evidence, sets, extended, parameters);
  const EvidenceColumns& columns = few.columns();
  const JointScatter& scatter = evidence.views()[evidence.models()[held[0].model].view].scatter;
  std::vector<Rival> rivals;
  for (const Held& each : held) {
    const WeightedSet set = few.Here(evidence.models()[each.model].set);
    rivals.push_back(MakeRival(columns, few.list(), scatter, set, each.probability / sum));
  }
  std::vector<Shown> shown(drawn.size());
  const int first = static_cast<int>(problem.data().configurations.size());
  std::vector<std::vector<int>> observations(drawn.size());
  for (size_t o = problem.data().observations.size(); o < extended.data().observations.size(); ++o) {
    const int configuration = extended.data().shots[extended.data().observations[o].shot].configuration;
    observations[static_cast<size_t>(configuration - first)].push_back(static_cast<int>(o));
  }
  std::vector<std::vector<int>> of_rivals;
  for (const Rival& rival : rivals) of_rivals.push_back(rival.columns);
  for (size_t c = 0; c < drawn.size(); ++c) shown[c].rows = columns.RowsAt(observations[c], scatter, of_rivals);
  for (size_t i = 0; i < rivals.size(); ++i) Mix(rivals[i].mixing, i, &shown);
  Choice choice(std::move(rivals), std::move(shown));
  NextPoses next;
  for (const Held& each : held) next.decided += each.probability * each.probability / (sum * sum);
  std::vector<bool> taken(drawn.size(), false);
  for (int k = 0; k < kPosesProposed; ++k) next.poses.push_back(drawn[choice.Take(&taken)]);
  next.decides = choice.Decides();
  next.needed = choice.Needed(kPosesProposed);
  if (next.decides < next.decided + kWorthDeciding) return std::nullopt;  // no pose decides
  return next;
}

}  // namespace sagitta

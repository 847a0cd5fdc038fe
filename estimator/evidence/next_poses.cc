#include "estimator/evidence/next_poses.h"

#include <glog/logging.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <map>
#include <numeric>
#include <random>
#include <set>

#include "estimator/evidence/pose_choice.h"
#include "estimator/evidence/pose_groups.h"
#include "estimator/explanations/drivers.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/planning/pose_space.h"
#include "models/effects/catalogue.h"
#include "models/random_bits.h"

namespace sagitta {
namespace {

constexpr int kPosesDrawn = 800;       // six joints have 64 corners: a dozen near each
constexpr size_t kPosesWeighed = 400;  // of those drawn, at most: half of them are out of sight or reach
constexpr unsigned long long kSeedOfPoses = 1;
constexpr double kLeastPivot = 1e-300;
constexpr double kDecided = 0.95;          // of the leading answer: nothing is left to decide
constexpr double kWorthDeciding = 0.02;    // of an answer
constexpr double kSeenInPercent = 0.0005;  // of a model: of what is said in percent, the third digit
constexpr size_t kMostAnswers = 5;         // beyond kDecided and these little is left
constexpr size_t kFirstAnswers = 2;        // the most probable ones, which are named to people
constexpr size_t kMostShapes = 3;          // of an answer, such as those of a compensator

// The least and the largest value of each joint: its limits, or the range of the data where none are stated.
Eigen::Matrix2Xd LimitsOf(const CalibrationProblem& problem) {
  Eigen::Matrix2Xd limits(2, problem.robot().num_joints());
  for (int j = 0; j < problem.robot().num_joints(); ++j) {
    const Joint& joint = problem.robot().chain.joints[j];
    const Eigen::VectorXd q = JointValues(problem, j);
    const double low = q.minCoeff(), high = q.maxCoeff();
    const bool is_stated = joint.min && joint.max && high > low;
    limits.col(j) = is_stated ? Eigen::Vector2d(*joint.min, *joint.max) : Eigen::Vector2d(low, high);
  }
  return limits;
}

// Poses within these limits; each like a measured one.
std::vector<ProposedPose> DrawPoses(const CalibrationProblem& problem) {
  std::mt19937_64 random(kSeedOfPoses);
  const auto uniform = [&random](double low, double high) { return low + (high - low) * UnitNumber(random()); };
  const std::vector<Configuration>& configurations = problem.data().configurations;
  const Eigen::Matrix2Xd limits = LimitsOf(problem);
  std::vector<ProposedPose> poses;
  for (int k = 0; k < kPosesDrawn; ++k) {
    ProposedPose pose;
    do {
      pose.like = static_cast<int>(random() % configurations.size());
    } while (configurations[pose.like].is_validation);
    pose.q.resize(problem.robot().num_joints());
    for (int j = 0; j < problem.robot().num_joints(); ++j) pose.q[j] = uniform(limits(0, j), limits(1, j));
    poses.push_back(std::move(pose));
  }
  return poses;
}

// The problem with the poses as configurations that are not fitted, shot like those they are like, at their times: in
// a campaign of their own, so that what was measured remembers none of them.
CalibrationProblem WithPoses(const CalibrationProblem& problem, const std::vector<ProposedPose>& poses) {
  Measurements data = problem.data();
  NoiseRoots roots = problem.resolved_noise;
  for (const ProposedPose& pose : poses) {
    const std::vector<int> own = ShotsOfProposal(problem.data(), pose.like);
    const std::string id = "next" + std::to_string(data.configurations.size());
    AppendConfiguration(problem.data(), pose.like, own, pose.q, id, &data);
    data.configurations.back().is_validation = true;
    for (size_t k = data.shots.size() - own.size(); k < data.shots.size(); ++k) data.shots[k].campaign = 1;
    if (roots.empty()) continue;
    for (const int shot : own) {
      for (const int o : problem.data().shots[shot].observations) roots.push_back(problem.resolved_noise[o]);
    }
  }
  CalibrationProblem extended = problem;
  extended.set_data(std::move(data));
  extended.resolved_noise = std::move(roots);
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
    if (observation.is_point()) observation.point_in_station = points.col(i);
  }
  return extended;
}

// m, against the load-free pull of gravity: of a point in its station.
double HeightOf(const CalibrationProblem& problem, const ParameterSet& parameters, const Observation& observation) {
  const Shot& shot = problem.data().shots[observation.shot];
  const ShotConditions& conditions = problem.shot_inputs()[observation.shot].conditions;
  Vector3<double> up = -conditions.gravity.normalized();
  if (conditions.gravity_frame == WrenchFrame::kBase) up = parameters.BaseInStation(shot.station).rotation * up;
  return up.dot(observation.point_in_station);
}

// Poses none of whose points is lower than all that were measured from their station: there the floor may be.
std::vector<ProposedPose> NotBelowWhatWasMeasured(const CalibrationProblem& problem, const ParameterSet& parameters,
                                                  const std::vector<ProposedPose>& drawn) {
  const size_t measured = problem.data().observations.size();
  const CalibrationProblem extended = AsPredicted(WithPoses(problem, drawn), parameters, measured);
  const std::vector<Observation>& rows = extended.data().observations;
  std::vector<double> lowest(extended.data().stations.size(), kInfinity);
  std::vector<bool> is_below(drawn.size(), false);
  for (size_t i = 0; i < rows.size(); ++i) {
    if (!rows[i].is_point() || (i < measured && rows[i].excluded)) continue;
    const Shot& shot = extended.data().shots[rows[i].shot];
    const double height = HeightOf(extended, parameters, rows[i]);
    double& least = lowest[shot.station];
    if (i < measured) least = std::min(least, height);
    if (i >= measured && height < least)
      is_below[shot.configuration - static_cast<int>(problem.data().configurations.size())] = true;
  }
  std::vector<ProposedPose> kept;
  for (size_t k = 0; k < drawn.size() && kept.size() < kPosesWeighed; ++k) {
    if (!is_below[k]) kept.push_back(drawn[k]);
  }
  return kept;
}

// The explanations that some sets have, in columns of their own over the rows of a problem with more poses.
class FewColumns {
 public:
  FewColumns(const Evidence& evidence, const std::vector<const WeightedSet*>& sets, const CalibrationProblem& extended,
             const ParameterSet& parameters)
      : given_(evidence.list()),
        candidates_(CandidatesOf(sets)),
        columns_(extended, parameters, candidates_.candidates, evidence.about()),
        list_(ListExplanations(extended, evidence.parameters(), candidates_, evidence.masses(), &columns_,
                               AnyUnnamed(sets))) {}

  const EvidenceColumns& columns() const { return columns_; }
  const ExplanationList& list() const { return list_; }

  // Whether both list the same functions without a name. They are listed by the fitted rows, which are the same; only
  // where two say equally much of these, rounding may list another.
  bool AreListed() const {
    const auto is_same = [](const UnnamedFunction& a, const UnnamedFunction& b) {
      return a.acts_on == b.acts_on && a.words == b.words;
    };
    return list_.functions.empty() || std::equal(list_.functions.begin(), list_.functions.end(),
                                                 given_.functions.begin(), given_.functions.end(), is_same);
  }

  // Of a member in this list. What has no name comes last in both lists, all of it in the same order; of the catalogue
  // one start with so many columns has one place.
  int NumberOf(int member) const {
    const int here = static_cast<int>(list_.math.size());
    if (given_.IsUnnamed(member)) return here - static_cast<int>(given_.functions.size()) + given_.unnamed[member];
    const EffectSpec& start = given_.start[member];
    int k = 0;
    const int size = given_.math[member].group.size();
    const auto is_it = [&](int other) {
      return list_.start[other].Path() == start.Path() && list_.start[other].values == start.values &&
             list_.math[other].group.size() == size;
    };
    while (k < here && !is_it(k)) ++k;
    CHECK_LT(k, here);
    return k;
  }

 private:
  CandidateList CandidatesOf(const std::vector<const WeightedSet*>& sets) const {
    std::set<int> used;
    for (const WeightedSet* set : sets) {
      for (const int m : set->members) used.insert(given_.candidate[m]);
    }
    const int all = AnyUnnamed(sets) ? static_cast<int>(given_.candidates.size()) : 0;
    for (int c = 0; c < all; ++c) {  // functions without a name move load points too
      if (IsUseOf(LoadCom(), given_.candidates[c].spec)) used.insert(c);
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

// What is known of a set's coefficients, and of all poses by it. sums: of the fitted rows with [believed, columns,
// residual]; turned: the poses' rows in [believed, columns], transposed. With N = P' L D L' P of the coefficients and
// the poses' rows R in them:  m = R x,  Y = D^-1/2 L^-1 P R'.
void Predict(const SetCoefficients& coefficients, const Eigen::MatrixXd& sums, const Eigen::MatrixXd& turned,
             RivalRows* rows) {
  const Eigen::MatrixXd normal = coefficients.NormalOf(sums);
  Eigen::MatrixXd precision = normal.leftCols(coefficients.size());
  coefficients.AddPrior(&precision);
  // What hardly anything determines must not decide: a flat prior is one of thirty thousand times what the data
  // say.
  precision.diagonal() *= 1.0 + 1e-9;
  const Eigen::LDLT<Eigen::MatrixXd> factor(precision);
  rows->spread = coefficients.Of(turned);
  rows->means = -rows->spread.transpose() * factor.solve(normal.col(coefficients.size()));
  rows->spread = factor.transpositionsP() * rows->spread;
  factor.matrixL().solveInPlace(rows->spread);
  rows->spread.array().colwise() *= factor.vectorD().array().max(kLeastPivot).rsqrt();
}

// Time or temperature drives it.
bool DependsOnWhen(const Evidence& evidence, int member) {
  const ExplanationList& list = evidence.list();
  if (list.IsUnnamed(member)) {
    const DriverKind kind = list.functions[list.unnamed[member]].driver.kind;
    return kind == DriverKind::kTime || kind == DriverKind::kTemperature;
  }
  const EffectSpec& spec = list.start[member];
  const EffectDefinition* effect = FindEffect(evidence.robot(), spec.effect);
  return effect != nullptr && effect->DrivenBy(spec) != EffectDriver::kJoint;
}

// What a member is called at new poses. After a way longer than its width a play operator stands where a backlash does:
// on one joint both have one name.
std::string NameAtNewPoses(const Evidence& evidence, int member) {
  const ExplanationList& list = evidence.list();
  if (list.IsUnnamed(member)) return list.name[member];
  const EffectSpec& spec = list.start[member];
  const EffectDefinition* effect = FindEffect(evidence.robot(), spec.effect);
  const bool is_play =
      effect == &Hysteresis() || (effect == &Backlash() && effect->PressedByOf(spec) == PressedBy::kApproach);
  return is_play ? "play of " + spec.target : list.name[member];
}

// The sets that are worth deciding between, with their names in `next`. What is called alike, or predicts the same at
// new poses, is one answer: a deviation that follows the pose has its own value at each, and whether an effect is a
// piece of a nameless cause no pose shows.
std::vector<Rival> RivalsOf(const Evidence& evidence, NextPoses* next) {
  struct Answer {
    double probability = 0.0;
    std::vector<int> models;
  };
  std::map<std::set<std::string>, Answer> answers;
  for (size_t m = 0; m < evidence.models().size(); ++m) {
    const WeightedModel& model = evidence.models()[m];
    std::set<std::string> names;
    for (const int member : model.set.members) names.insert(NameAtNewPoses(evidence, member));
    Answer& answer = answers[names];
    answer.probability += model.probability;
    next->counts_pieces |= !model.pieces.empty() && model.probability >= kSeenInPercent;
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
  for (const Answer& answer : sorted) {
    const std::vector<int>& members = evidence.models()[answer.models.front()].set.members;
    next->rivals.push_back(evidence.list().ByName(members, answer.probability));
    next->of_probability += answer.probability;
    next->depends_on_when |=
        next->rivals.size() <= kFirstAnswers &&
        std::any_of(members.begin(), members.end(), [&](int m) { return DependsOnWhen(evidence, m); });
  }
  std::vector<Rival> rivals;
  for (size_t k = 0; k < sorted.size(); ++k) {
    const double of_all = sorted[k].probability / next->of_probability;
    double kept = 0.0;
    for (const int m : sorted[k].models) kept += evidence.models()[m].probability;
    for (const int m : sorted[k].models) {
      const double share = evidence.models()[m].probability / kept;
      rivals.push_back({m, share * of_all, static_cast<int>(k)});
    }
  }
  return rivals;
}

std::optional<PoseChoice> ChoiceOf(const Evidence& evidence, const std::vector<Rival>& rivals,
                                   const CalibrationProblem& extended, const ParameterSet& parameters, size_t poses) {
  std::vector<const WeightedSet*> sets;
  for (const Rival& rival : rivals) sets.push_back(&evidence.models()[rival.model].set);
  const FewColumns few(evidence, sets, extended, parameters);
  if (!few.AreListed()) return std::nullopt;
  const RowScatter& scatter = evidence.views()[evidence.models()[rivals[0].model].view].scatter;
  std::vector<int> chosen;  // members of all sets, each once
  for (const WeightedSet* set : sets) {
    for (const int m : set->members) chosen.push_back(few.NumberOf(m));
  }
  chosen = EachOnce(chosen);
  const FewExplanations explanations = WithTheirColumns(few.list().math, chosen);
  const std::vector<int>& columns = explanations.columns;
  const std::vector<std::vector<int>> all = ObservationsByConfiguration(extended.data());
  const std::vector<std::vector<int>> observations(all.end() - static_cast<long>(poses), all.end());
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
  const Eigen::MatrixXd sums = few.columns().WithPriors(few.columns().Sum(scatter, columns).products);
  std::vector<RivalRows> rows;
  for (size_t i = 0; i < rivals.size(); ++i) {
    rows.push_back({rivals[i].probability, rivals[i].name, {}, {}});
    SetCoefficients coefficients{{}, sets[i]->scales, believed};
    for (const int m : sets[i]->members) {
      coefficients.groups.push_back(&explanations.explanations[PlaceIn(chosen, few.NumberOf(m))].group);
    }
    Predict(coefficients, sums, turned, &rows.back());
  }
  return PoseChoice(std::move(rows), std::move(first_row));
}

}  // namespace

std::vector<int> ShotsOfProposal(const Measurements& data, int configuration) {
  std::vector<int> picked;
  for (size_t s = 0; s < data.shots.size(); ++s) {
    const Shot& shot = data.shots[s];
    if (shot.configuration != configuration) continue;
    const bool is_elsewhen = std::any_of(picked.begin(), picked.end(), [&](int p) {
      const Shot& other = data.shots[p];
      return other.station == shot.station && other.load == shot.load && other.wrench.force == shot.wrench.force &&
             other.wrench.moment == shot.wrench.moment && other.visit != shot.visit;
    });
    if (!is_elsewhen) picked.push_back(static_cast<int>(s));
  }
  return picked;
}

std::optional<NextPoses> ProposeNext(const Evidence& evidence, const CalibrationProblem& problem,
                                     const ParameterSet& parameters) {
  NextPoses next;
  const std::vector<Rival> rivals = RivalsOf(evidence, &next);
  if (next.rivals.size() < 2 || next.rivals[0].probability > kDecided * next.of_probability) return std::nullopt;
  const std::vector<ProposedPose> drawn = NotBelowWhatWasMeasured(problem, parameters, DrawPoses(problem));
  if (drawn.size() < kPosesProposed) return std::nullopt;
  const CalibrationProblem extended =
      AsPredicted(WithPoses(problem, drawn), parameters, problem.data().observations.size());
  std::optional<PoseChoice> choice = ChoiceOf(evidence, rivals, extended, parameters, drawn.size());
  if (!choice) return std::nullopt;
  for (const NamedSet& rival : next.rivals) {
    const double share = rival.probability / next.of_probability;
    next.decided += share * share;
  }
  for (int k = 0; k < kPosesProposed; ++k) next.poses.push_back(drawn[choice->Take()]);
  next.decides = choice->Decides();
  next.needed = choice->Needed(kWanted, kMostNeeded);
  if (next.decides < next.decided + kWorthDeciding) return std::nullopt;  // no pose decides
  return next;
}

}  // namespace sagitta

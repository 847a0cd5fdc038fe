#include "estimator/changes/changes.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "estimator/changes/comparison.h"
#include "estimator/changes/sparse_search.h"
#include "estimator/report/changes_words.h"
#include "estimator/statistics/distributions.h"
#include "models/dense_algebra.h"
#include "models/matrix_functions.h"
#include "problems/failure.h"

namespace sagitta {
namespace {

// A millimetre or a milliradian leaves a nanometre after the second round; a wrong set is left within a few.
constexpr int kRounds = 12;
constexpr double kArrived = 0.1;      // standard deviations of the whole difference, of the last step
constexpr double kWorthAWord = 0.05;  // of the probability, of what is not named: one in twenty
// Of what is left: less probable means that something is not explained.
constexpr double kUnexplained = 1e-3;

// value: of one parameter as it is; of a shift its length, of several the largest one's.
Change DescribeChange(const ChangeGroup& group, const Eigen::VectorXd& size, const Eigen::MatrixXd& covariance,
                      double probability) {
  const double k = NormalQuantile(kUpperOf95);
  Change change;
  change.kind = group.kind;
  change.target = group.target;
  change.probability = probability;
  change.same = group.same;
  Eigen::VectorXd factor(group.size());
  for (int i = 0; i < group.size(); ++i) factor[i] = group.typical[i] / group.unit[i];
  const Eigen::VectorXd value = factor.cwiseProduct(size);
  const Eigen::MatrixXd spread = factor.asDiagonal() * covariance * factor.asDiagonal();
  change.unit = group.units[0];
  for (int i = 0; i < group.size() && group.size() > 1; ++i) {
    const double sigma = std::sqrt(spread(i, i));
    change.parts.push_back({group.names[i], value[i], group.units[i], {value[i] - k * sigma, value[i] + k * sigma}});
  }
  if (group.size() < 3) {
    const double sigma = std::sqrt(spread(0, 0));
    change.value = value[0];
    change.ci95[0] = value[0] - k * sigma, change.ci95[1] = value[0] + k * sigma;
    change.words = ChangeInWords(change);
    return change;
  }
  long largest = 0;
  for (long i = 3; i < value.size() && !group.is_motion(); i += 3) {
    if (value.segment(i, 3).norm() > value.segment(largest, 3).norm()) largest = i;
  }
  change.value = value.segment(largest, 3).norm();
  const Eigen::VectorXd along = value.segment(largest, 3) / std::max(change.value, 1e-300);
  const double sigma = std::sqrt(along.dot(spread.block(largest, largest, 3, 3) * along));
  change.ci95[0] = std::max(0.0, change.value - k * sigma), change.ci95[1] = change.value + k * sigma;
  change.words = ChangeInWords(change);
  if (group.is_motion()) change.words += TurnedInWords(value.tail(3).norm());
  return change;
}

nlohmann::ordered_json ToJson(const Change& change) {
  nlohmann::ordered_json json = {{"what", WordOf(change.kind)},
                                 {"target", change.target},
                                 {"value", change.value},
                                 {"unit", change.unit},
                                 {"ci95", {change.ci95[0], change.ci95[1]}},
                                 {"probability", change.probability},
                                 {"words", change.words}};
  if (!change.same.empty()) json["same"] = change.same;
  if (change.parts.empty()) return json;
  json["parts"] = nlohmann::ordered_json::array();
  for (const Change::Part& part : change.parts) {
    json["parts"].push_back(
        {{"name", part.name}, {"value", part.value}, {"unit", part.unit}, {"ci95", {part.ci95[0], part.ci95[1]}}});
  }
  return json;
}

// What search sees of a comparison: whitened once more, for what each campaign has of its own is anywhere,
// K = I + P P' with P its columns of kAnySize.
struct SearchInput {
  Eigen::VectorXd left, applied;
  Eigen::MatrixXd columns;
  std::vector<SparseGroup> groups;
  std::vector<size_t> of;  // the comparison's group of each
  std::vector<size_t> own_groups;
  Eigen::MatrixXd own;                 // P
  Eigen::LLT<Eigen::MatrixXd> factor;  // of K, where there are such columns
};

// An instrument or a tool can be anywhere; joints and markers keep to the arm and are moved exactly at any size.
BeyondTypical BeyondTypicalOf(const ChangeGroup& group) {
  if (!group.is_plain()) return BeyondTypical::kNone;
  return group.is_motion() ? BeyondTypical::kAnywhere : BeyondTypical::kLarge;
}

SearchInput InputOf(const EstimateComparison::Linear& linear, const std::vector<ChangeGroup>& groups) {
  SearchInput input;
  input.left = linear.left, input.applied = linear.applied, input.columns = linear.columns;
  std::vector<int> own;
  for (size_t g = 0; g < groups.size(); ++g) {
    if (groups[g].of_campaign) {
      own.insert(own.end(), linear.of_group[g].begin(), linear.of_group[g].end());
      input.own_groups.push_back(g);
      for (const int column : linear.of_group[g]) input.applied[column] = 0.0;  // in no set
      continue;
    }
    input.groups.push_back({linear.of_group[g], BeyondTypicalOf(groups[g])});
    input.of.push_back(g);
  }
  for (size_t i = 0; i < input.of.size(); ++i) {
    const auto all = std::find_if(input.of.begin(), input.of.end(),
                                  [&](size_t g) { return IsPartOf(groups[input.of[i]], groups[g]); });
    if (all != input.of.end()) input.groups[i].part_of = static_cast<int>(all - input.of.begin());
  }
  if (own.empty()) return input;
  input.own = kAnySize * linear.columns(Eigen::all, own);
  input.factor.compute(Eigen::MatrixXd::Identity(input.left.size(), input.left.size()) +
                       input.own * input.own.transpose());
  input.factor.matrixL().solveInPlace(input.left);
  input.factor.matrixL().solveInPlace(input.columns);
  return input;
}

// Where the old estimate goes: by the best set, by nothing else, and by what each campaign has of its own.
std::vector<Eigen::VectorXd> MovedBy(const EstimateComparison& comparison, const EstimateComparison::Linear& linear,
                                     const SearchInput& input, const SparsePosterior& posterior,
                                     Eigen::VectorXd* step) {
  const std::vector<ChangeGroup>& groups = comparison.groups();
  std::vector<Eigen::VectorXd> target;
  for (const ChangeGroup& group : groups) target.push_back(Eigen::VectorXd::Zero(group.size()));
  *step = -linear.applied;
  const auto go = [&](size_t g, const Eigen::VectorXd& way) {
    target[g] = Further(groups[g], comparison.applied()[g], way);
    (*step)(linear.of_group[g]) = way;
  };
  for (const SparsePosterior::Member& member : posterior.best) {
    const size_t g = input.of[member.group];
    go(g, member.anywhere ? member.mean : Eigen::VectorXd(member.mean - comparison.applied()[g]));
  }
  if (input.own_groups.empty()) return target;
  for (const size_t g : input.own_groups) (*step)(linear.of_group[g]).setZero();
  // The mean of what is anywhere, given the rest: size P' K^-1 r.
  const Eigen::VectorXd rest = linear.left - linear.columns * *step;
  const Eigen::VectorXd own = kAnySize * (input.own.transpose() * input.factor.solve(rest));
  long first = 0;
  for (const size_t g : input.own_groups) {
    go(g, own.segment(first, groups[g].size()));
    first += groups[g].size();
  }
  return target;
}

struct SearchOutcome {
  SparsePosterior posterior;
  std::vector<Eigen::VectorXd> applied;
  std::vector<size_t> of;
  double log_evidence = 0.0;
  bool arrived = false;
  double left_p = 1.0;
};

// How probable it is that what is left is no more than both estimates leave open.
double ProbabilityOfTheRest(const EstimateComparison& comparison, const SearchOutcome& outcome) {
  const EstimateComparison::Linear linear = comparison.Linearise();
  double fitted = 0.0;
  for (const SparsePosterior::Member& member : outcome.posterior.best)
    fitted += static_cast<double>(member.mean.size());
  for (const ChangeGroup& group : comparison.groups()) fitted += group.of_campaign ? group.size() : 0;
  return ChiSquareSurvival(linear.left.squaredNorm(), std::max(1.0, comparison.NumRandom() - fitted));
}

// Sets and linearisations in turn, until the set stays and the step is none. The comparison has been aligned.
SearchOutcome SearchFrom(EstimateComparison* comparison) {
  SearchOutcome outcome;
  std::vector<int> before = {-1};
  for (int round = 0; round < kRounds && !outcome.arrived; ++round) {
    const EstimateComparison::Linear linear = comparison->Linearise();
    const SearchInput input = InputOf(linear, comparison->groups());
    outcome.of = input.of;
    outcome.posterior = SearchSparse(input.columns, input.left, input.groups, input.applied);
    outcome.log_evidence = outcome.posterior.log_best - 0.5 * comparison->LogDeterminant();
    if (!input.own_groups.empty()) outcome.log_evidence -= 0.5 * LogDeterminant(input.factor);
    Eigen::VectorXd step;
    comparison->MoveTo(MovedBy(*comparison, linear, input, outcome.posterior, &step));
    std::vector<int> set;
    for (const SparsePosterior::Member& member : outcome.posterior.best) set.push_back(member.group);
    outcome.arrived = set == before && (linear.columns * step).norm() < kArrived;
    before = set;
  }
  outcome.applied = comparison->applied();
  outcome.left_p = ProbabilityOfTheRest(*comparison, outcome);
  return outcome;
}

void SetBefore(const KnownRobot& old_estimate, Change* change) {
  const auto known = old_estimate.parameters.find(WordOf(change->kind) + ("/" + change->target));
  if (change->kind != ChangeKind::kCompliance || known == old_estimate.parameters.end()) return;
  change->before = known->second.value / TraitsOf(Quantity::kCompliance).si_per_unit;
  change->words = ChangeInWords(*change);
}

// A load bends every joint by its share more; gears do not soften by one share together. Alike: within a factor of two.
void NoteOneLoad(Changes* result) {
  std::vector<double> shares;
  for (const Change& change : result->changes) {
    if (change.kind == ChangeKind::kCompliance && change.before > 0.0) shares.push_back(change.value / change.before);
  }
  if (shares.size() < 2) return;
  const auto [least, most] = std::minmax_element(shares.begin(), shares.end());
  const bool is_alike = *least > 0.0 ? *most < 2.0 * *least : *least > 2.0 * *most;
  if (is_alike) result->notes.push_back(OneLoadDoesThatToo(*least, *most));
}

// A slip that moves the points as named motions do is a part of these: of one, of all bases together (a slip of the
// first joint turns every base), or of bases and tool. What fewer motions hide is said of these.
void NoteHiddenZeros(const EstimateComparison& comparison, const SearchOutcome& outcome, Changes* result) {
  std::vector<std::vector<size_t>> sets(2);  // all bases, all motions
  for (const SparsePosterior::Member& member : outcome.posterior.best) {
    const size_t g = outcome.of[member.group];
    if (!comparison.groups()[g].is_motion()) continue;
    sets.insert(sets.end() - 2, {g});
    if (comparison.groups()[g].kind == ChangeKind::kBase) sets[sets.size() - 2].push_back(g);
    sets.back().push_back(g);
  }
  const EstimateComparison::Linear linear = comparison.Linearise();
  std::vector<std::string> said;
  for (const std::vector<size_t>& set : sets) {
    std::vector<ChangeKind> kinds;
    for (const size_t g : set) kinds.push_back(comparison.groups()[g].kind);
    std::vector<std::string> zeros;
    for (const std::string& zero : comparison.ZerosWithin(linear, set)) {
      if (std::find(said.begin(), said.end(), zero) == said.end()) zeros.push_back(zero);
    }
    if (!zeros.empty()) result->notes.push_back(ZerosAreHidden(zeros, kinds));
    said.insert(said.end(), zeros.begin(), zeros.end());
  }
}

void AddAlternatives(const std::vector<ChangeGroup>& groups, const SearchOutcome& outcome, Changes* result) {
  std::vector<bool> named(outcome.of.size(), false);
  for (const SparsePosterior::Member& member : outcome.posterior.best) named[member.group] = true;
  for (size_t i = 0; i < outcome.of.size(); ++i) {
    const double p = outcome.posterior.probability[static_cast<long>(i)];
    if (p < kWorthAWord || named[i]) continue;
    Change other;
    other.kind = groups[outcome.of[i]].kind, other.target = groups[outcome.of[i]].target, other.probability = p;
    result->alternatives.push_back(other);
  }
}

}  // namespace

Changes FindChanges(const KnownRobot& old_estimate, const KnownRobot& new_estimate) {
  EstimateComparison comparison(old_estimate, new_estimate);
  comparison.Align(MarkerStart::kEach);
  comparison.LeaveOutIndistinguishable();
  const std::vector<ChangeGroup>& groups = comparison.groups();
  std::optional<SearchOutcome> best;
  for (const MarkerStart start : {MarkerStart::kEach, MarkerStart::kBody}) {
    comparison.Align(start);
    const SearchOutcome outcome = SearchFrom(&comparison);
    if (!outcome.arrived || (best && best->log_evidence >= outcome.log_evidence)) continue;
    best = outcome;
  }
  const bool is_settled = best && !(best->posterior.IsFull() && best->left_p < kUnexplained);
  if (!is_settled) throw Failure(TooFarApart(old_estimate.file, new_estimate.file));
  comparison.MoveTo(best->applied);
  Changes result;
  result.notes = comparison.notes();
  result.after_rms = comparison.Rms();
  result.nothing = best->posterior.nothing;
  for (const SparsePosterior::Member& member : best->posterior.best) {
    const size_t g = best->of[member.group];
    result.changes.push_back(
        DescribeChange(groups[g], best->applied[g], member.covariance, best->posterior.probability[member.group]));
    SetBefore(old_estimate, &result.changes.back());
  }
  NoteHiddenZeros(comparison, *best, &result);
  NoteOneLoad(&result);
  AddAlternatives(groups, *best, &result);
  const auto likelier = [](const Change& a, const Change& b) { return a.probability > b.probability; };
  std::stable_sort(result.changes.begin(), result.changes.end(), likelier);
  std::stable_sort(result.alternatives.begin(), result.alternatives.end(), likelier);
  // How far the two are apart but for what is each campaign's own.
  std::vector<Eigen::VectorXd> own = best->applied;
  for (size_t g = 0; g < groups.size(); ++g) {
    if (!groups[g].of_campaign) own[g].setZero();
  }
  comparison.MoveTo(own);
  result.before_rms = comparison.Rms();
  for (const KnownRobot* known : {&new_estimate, &old_estimate}) {
    if (known->model_error > 1.0 && !result.changes.empty()) {
      result.notes.push_back(LacksSomething(known->file, known->model_error));
    }
  }
  if (best->left_p < kUnexplained) result.notes.insert(result.notes.begin(), MoreIsLeft(result.after_rms));
  result.words = ChangesInWords(result);
  return result;
}

nlohmann::ordered_json ChangesToJson(const Changes& changes) {
  nlohmann::ordered_json json = {{"schema", "sagitta/changed/1"}, {"words", changes.words}};
  json["changes"] = nlohmann::ordered_json::array();
  for (const Change& change : changes.changes) json["changes"].push_back(ToJson(change));
  json["nothing"] = changes.nothing;
  json["alternatives"] = nlohmann::ordered_json::array();
  for (const Change& other : changes.alternatives) {
    json["alternatives"].push_back(
        {{"what", WordOf(other.kind)}, {"target", other.target}, {"probability", other.probability}});
  }
  json["apart_rms_mm"] = {{"before", 1e3 * changes.before_rms}, {"after", 1e3 * changes.after_rms}};
  json["notes"] = changes.notes;
  return json;
}

}  // namespace sagitta

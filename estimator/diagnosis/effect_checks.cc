#include "estimator/diagnosis/effect_checks.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "estimator/statistics/distributions.h"
#include "models/constants.h"

namespace sagitta {
namespace {

// Of the largest eigenvalue, which is a square: a direction that moves the rows a thousandth as much is left out.
constexpr double kRank = 1e-6;
// Of the prior variance, what is left of a parameter that the data hardly determine. A direction that they do not
// determine at all may lie along all four parameters of an effect: each keeps a quarter.
constexpr double kPoorlyDetermined = 0.2;
// Of the same: above, the prior stays in the refit. Below, a tenth of its width, it would move a value of three typical
// sizes by less than a third of its standard deviation, and is left out.
constexpr double kPriorMatters = 0.01;
constexpr double kReplacesIt = 0.5;  // of what the effect explains: more than what it leaves
// Names that are asked on a half, the most probable ones: the next has 1 / 41 at most.
constexpr size_t kRivalsOnHalves = 40;
// Of the probability: two thousand explanations with less have 2e-9 together, of which nothing is said.
constexpr double kNoProbability = 1e-12;

std::vector<NamedProbability> ByName(const Evidence& evidence, const std::vector<double>& weights) {
  const double sum = LogSumExp(weights);
  std::map<std::string, NamedProbability> names;
  std::map<std::string, double> most;
  for (size_t k = 0; k < weights.size(); ++k) {
    const double p = std::exp(weights[k] - sum);
    if (!(p > kNoProbability)) continue;
    const std::string& name = evidence.list().name[k];
    NamedProbability& entry = names.emplace(name, NamedProbability{name, static_cast<int>(k), 0.0}).first->second;
    entry.probability += p;
    if (p > most[name]) {
      most[name] = p;
      entry.explanation = static_cast<int>(k);
    }
  }
  std::vector<NamedProbability> list;
  for (const auto& [name, entry] : names) list.push_back(entry);
  std::stable_sort(list.begin(), list.end(),
                   [](const auto& a, const auto& b) { return a.probability > b.probability; });
  return list;
}

// Of what a group can determine.
Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> Determined(const Eigen::MatrixXd& information) {
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> determined;
  determined.setThreshold(kRank);
  determined.compute(information);
  return determined;
}

// With c = A a the effect's contribution, a its values given the others:  |P_rival c|^2 / |c|^2.
std::vector<Alternative> FindAlternatives(const Evidence& evidence, const Posterior& posterior,
                                          const WeightedModel& model, size_t place,
                                          const std::vector<NamedProbability>& in_place) {
  const int member = model.set.members[place];
  const ColumnGroup& own = evidence.list().math[member].group;
  Members others = evidence.MembersOf(model);
  const GivenOthers given = others.Of(place);
  others.Remove(place);
  const Eigen::VectorXd values = Determined(given.information).solve(given.gradient);
  const double size = std::max(1e-300, values.dot(given.information * values));
  std::vector<Alternative> alternatives;
  for (const NamedProbability& rival : in_place) {
    if (posterior.Of(rival.name) < kWorthListing) continue;
    if (rival.name == evidence.list().name[member]) continue;
    if (evidence.list().IsUnnamed(rival.explanation)) continue;
    const ColumnGroup joined = Joined(own, evidence.list().math[rival.explanation].group);
    Members with = others;
    with.Insert(0, joined, 1.0);
    const Eigen::MatrixXd both = with.Of(0).information;
    const long n = own.size(), m = both.cols() - n;
    const Eigen::VectorXd across = both.bottomLeftCorner(m, n) * values;
    const double overlap = across.dot(Determined(both.bottomRightCorner(m, m)).solve(across)) / size;
    if (overlap < kReplacesIt) continue;  // it would be added, not put in its place
    alternatives.push_back(
        {evidence.list().start[rival.explanation], posterior.Of(rival.name), std::min(1.0, overlap)});
  }
  return alternatives;
}

// What is asked on the halves: the set, then the rivals in each place; positions in `all` of what is asked there, the
// member first.
struct Asked {
  std::vector<int> all;  // explanations
  std::vector<std::vector<int>> of;
};

Asked AskedOf(const Evidence& evidence, const WeightedModel& model, const std::vector<size_t>& places,
              const std::vector<std::vector<NamedProbability>>& in_places) {
  Asked asked{model.set.members, {}};
  std::map<int, int> at;
  for (size_t k = 0; k < asked.all.size(); ++k) at[asked.all[k]] = static_cast<int>(k);
  const auto place_of = [&](int explanation) {
    const auto entry = at.emplace(explanation, static_cast<int>(asked.all.size()));
    if (entry.second) asked.all.push_back(explanation);
    return entry.first->second;
  };
  for (size_t k = 0; k < places.size(); ++k) {
    std::vector<int> own = {static_cast<int>(places[k])};
    for (const NamedProbability& rival : in_places[places[k]]) {
      if (own.size() > kRivalsOnHalves) break;
      if (rival.name == evidence.list().name[model.set.members[places[k]]]) continue;
      const int needed = evidence.list().math[rival.explanation].needs;
      if (needed != kNoExplanation) place_of(needed);
      own.push_back(place_of(rival.explanation));
    }
    asked.of.push_back(std::move(own));
  }
  return asked;
}

// in_place: of all that is asked there, in the k-th place.
HalfResult OnHalf(const Evidence& evidence, const Asked& asked, size_t k, const std::vector<double>& in_place) {
  std::vector<double> weights;
  for (const int i : asked.of[k]) weights.push_back(in_place[i]);
  HalfResult result;
  const auto best = std::max_element(weights.begin(), weights.end()) - weights.begin();
  const auto name = [&](size_t i) -> const std::string& { return evidence.list().name[asked.all[asked.of[k][i]]]; };
  result.best = name(static_cast<size_t>(best));
  const double sum = LogSumExp(weights);
  for (size_t i = 0; i < weights.size(); ++i) {
    if (name(i) == name(0)) result.probability += std::exp(weights[i] - sum);
  }
  return result;
}

// Of the halves' values being one:  d = a_1 - a_2,  d'(C_1 + C_2)^-1 d ~ chi^2 of as many degrees of freedom as there
// are values.
double CompatibleP(const std::vector<HalfResult>& halves) {
  if (halves.size() < 2) return kNotKnown;
  const Eigen::VectorXd apart = halves[0].values - halves[1].values;
  const Eigen::LLT<Eigen::MatrixXd> joint(Eigen::MatrixXd(halves[0].covariance + halves[1].covariance));
  if (joint.info() != Eigen::Success) return kNotKnown;
  return ChiSquareSurvival(apart.dot(joint.solve(apart)), static_cast<double>(apart.size()));
}

// Of the members at these places. Both halves are summed once for all.
std::vector<Confirmation> ConfirmEach(const Evidence& evidence, const WeightedModel& model,
                                      const std::vector<size_t>& places,
                                      const std::vector<std::vector<NamedProbability>>& in_places) {
  const EvidenceColumns& columns = evidence.columns();
  std::vector<Confirmation> confirmations(places.size());
  const Asked asked = AskedOf(evidence, model, places, in_places);
  const FewExplanations few = WithTheirColumns(evidence.list().math, asked.all);
  WeightedSet set{std::vector<int>(model.set.members.size()), model.set.scales, 0.0, 0.0};
  std::iota(set.members.begin(), set.members.end(), 0);
  const std::vector<const ColumnGroup*> groups = GroupsOf(few.explanations, set.members);
  const std::vector<double> widest(set.members.size(), kWidestScale);
  std::vector<int> half(columns.num_poses(), 1);
  std::fill_n(half.begin(), half.size() / 2, 0);
  for (const RowSums& sums : columns.SumEach(evidence.views()[model.view].scatter, few.columns, half)) {
    if (sums.rows == 0) continue;
    const ProjectedNormal normal = columns.Project(sums).normal;
    const SetSearch search = evidence.SearchAmong(few.explanations, normal);
    const GroupValues values = ValuesOf(normal, groups, widest);
    for (size_t k = 0; k < places.size(); ++k) {
      HalfResult result = OnHalf(evidence, asked, k, search.Additions(Without(set, places[k])));
      const GroupValues own = values.Of(places[k], groups);
      result.values = own.values;
      result.covariance = own.covariance;
      confirmations[k].halves.push_back(std::move(result));
    }
  }
  for (Confirmation& confirmation : confirmations) confirmation.compatible_p = CompatibleP(confirmation.halves);
  return confirmations;
}

}  // namespace

std::vector<std::vector<NamedProbability>> InPlaces(const Evidence& evidence, const WeightedModel& model) {
  std::vector<std::vector<NamedProbability>> in_places;
  const SetSearch search = evidence.SearchIn(model.view);
  for (size_t place = 0; place < model.set.members.size(); ++place) {
    in_places.push_back(ByName(evidence, search.Additions(Without(model.set, place))));
  }
  return in_places;
}

std::vector<CheckedEffect> CheckEffects(const Evidence& evidence, const Posterior& posterior,
                                        const WeightedModel& model,
                                        const std::vector<std::vector<NamedProbability>>& in_places,
                                        const std::vector<int>& members) {
  std::vector<CheckedEffect> checked(members.size());
  if (members.empty()) return checked;
  std::vector<size_t> own;
  for (const int member : members) own.push_back(model.PlaceOf(member));
  const std::vector<Confirmation> confirmations = ConfirmEach(evidence, model, own, in_places);
  for (size_t k = 0; k < members.size(); ++k) {
    checked[k] = {FindAlternatives(evidence, posterior, model, own[k], in_places[own[k]]), confirmations[k]};
  }
  return checked;
}

std::vector<int> OthersOfItsName(const Evidence& evidence, const WeightedModel& model, int member) {
  const std::vector<std::string>& name = evidence.list().name;
  std::vector<int> others;
  for (size_t k = 0; k < name.size(); ++k) {
    if (name[k] == name[member] && static_cast<int>(k) != member) others.push_back(static_cast<int>(k));
  }
  const WeightedSet set = Without(model.set, model.PlaceOf(member));
  const std::vector<double> weights = evidence.SearchIn(model.view).Additions(set);
  std::stable_sort(others.begin(), others.end(), [&](int a, int b) { return weights[a] > weights[b]; });
  return others;
}

// With values a = (G + S)^-1 g, S = diag(1 / s^2):  |r - A a|^2 = R - 2 a'g + a'G a = R - a'g - a'S a.
double ResidualAtBest(const Evidence& evidence, const WeightedModel& model) {
  std::vector<double> scales = model.set.scales;
  for (size_t k = 0; k < scales.size(); ++k) {
    const bool is_spring = IsNewSpring(evidence.list().start[model.set.members[k]]);
    if (!is_spring) scales[k] = kWidestScale;
  }
  const Members members = evidence.MembersOf(model, &scales);
  return members.residual() - members.Standardised().squaredNorm();
}

// reduction = g'G^+ g.
MemberFit FitOf(const GivenOthers& given) {
  const auto determined = Determined(given.information);
  return {given.gradient.dot(determined.solve(given.gradient)), static_cast<int>(determined.rank())};
}

// Of the prior variance s^2 there is left  diag (G + I / s^2)^-1.
void MarkUndetermined(const Evidence& evidence, int member, const GivenOthers& given, Candidate* candidate) {
  const ColumnGroup& own = evidence.list().math[member].group;
  if (own.mixing.size() > 0) return;
  const double variance = kLargestUsual * kLargestUsual;
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(own.size(), own.size());
  const Eigen::MatrixXd precision = given.information + identity / variance;
  const Eigen::VectorXd left = precision.llt().solve(identity).diagonal();
  for (long c = 0; c < left.size(); ++c) {
    const std::string& name = evidence.columns().Name(own.columns[c]);
    if (left[c] > kPoorlyDetermined * variance) candidate->poorly_determined.push_back(name);
    if (left[c] > kPriorMatters * variance) candidate->loose.push_back(name);
  }
}

}  // namespace sagitta

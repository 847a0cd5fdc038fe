#include "estimator/evidence/nameless_cause.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "models/effects/catalogue.h"

namespace sagitta {
namespace {

bool Holds(const std::vector<std::string>& list, const std::string& name) {
  return std::find(list.begin(), list.end(), name) != list.end();
}

// What needs loads or compliances bends the arm by torques, which turn with gravity.
bool HasSameDriver(const EffectDefinition& effect, const EffectSpec& spec, const UnnamedFunction& function) {
  switch (effect.DrivenBy(spec)) {
    case EffectDriver::kTime:
      return Holds(function.depends_on, "time");
    case EffectDriver::kTemperature:
      return Holds(function.depends_on, "temperature");
    case EffectDriver::kJoint:
      break;
  }
  const bool pulls = !function.sources.empty() && function.sources[0].kind == Source::Kind::kPull;
  const bool is_by_weight =
      pulls || function.driver.kind == DriverKind::kTorque || Holds(function.depends_on, "gravity");
  return is_by_weight && effect.needs != EffectNeeds::kNothing;
}

bool IsLike(const Robot& robot, const UnnamedFunction& function, const EffectSpec& spec) {
  if (function.acts_on == spec.target || Holds(function.depends_on, spec.target)) return true;
  const EffectDefinition* effect = FindEffect(robot, spec.effect);
  return effect != nullptr && HasSameDriver(*effect, spec, function);
}

}  // namespace

const NamelessCauses::Pieces& NamelessCauses::PiecesOf(const std::vector<int>& functions) {
  const auto [known, is_new] = pieces_.try_emplace(functions);
  Pieces& pieces = known->second;
  for (size_t k = 0; k < list_.math.size() && is_new; ++k) {
    const int named = static_cast<int>(k);
    const bool may_be = !list_.IsUnnamed(named) && std::any_of(functions.begin(), functions.end(), [&](int function) {
      return IsLike(robot_, list_.functions[list_.unnamed[function]], list_.SpecOf(named));
    });
    pieces.may_be.push_back(may_be);
  }
  for (size_t k = 0; k < list_.math.size() && is_new; ++k) {
    const int needed = list_.math[k].needs;
    if (needed != kNoExplanation && pieces.may_be[needed]) pieces.may_be[k] = true;
    if (pieces.may_be[k]) pieces.share += list_.math[k].share;
  }
  return pieces;
}

NamelessCauses::Cause NamelessCauses::OneOf(const std::vector<int>& members) {
  Cause cause;
  std::copy_if(members.begin(), members.end(), std::back_inserter(cause.functions),
               [&](int m) { return list_.IsUnnamed(m); });
  const Pieces& all = PiecesOf(cause.functions);
  std::copy_if(members.begin(), members.end(), std::back_inserter(cause.pieces), [&](int m) { return all.may_be[m]; });
  return cause;
}

// Of m causes one more, k, has the prior  rho m share(k)  (SetPrior: m draws in any order; rho: that there is one
// more). rho is `further` before anything is known. A machine of which m - 2 further ones were found has more of them:
// the mean of a beta distribution that began with the weight of one,  rho = (further + m - 2) / (m - 1). As a piece of
// the nameless cause k has the prior  further share(k) / (shares of all that may be pieces): that a cause has another
// piece is as likely as that there is another cause.
double NamelessCauses::OneMore(double further, size_t members) {
  const double m = static_cast<double>(members);
  return (further + m - 2.0) / (m - 1.0);
}

double NamelessCauses::LogPriorOdds(const std::vector<int>& members, const Cause& cause) {
  if (cause.pieces.empty()) return 0.0;
  const double m = static_cast<double>(members.size());
  return static_cast<double>(cause.pieces.size()) *
         std::log(further_ / (OneMore(further_, members.size()) * m * PiecesOf(cause.functions).share));
}

std::optional<NamelessCauses::AsOne> NamelessCauses::ReadAsOne(const std::vector<int>& members, const WeightedSet& set,
                                                               const std::vector<Explanation>& explanations,
                                                               const ProjectedNormal& normal,
                                                               const ResidualLikelihood& likelihood) {
  const Cause cause = OneOf(members);
  const double odds = LogPriorOdds(members, cause);
  if (odds <= 0.0) return std::nullopt;
  const auto counted = [&](std::vector<int> own) {
    for (int& m : own) m = set.members[PlaceIn(members, m)];
    return own;
  };
  AsOne one{cause.pieces, {}, 0.0};
  one.set = WithOneSize(set, {counted(cause.functions), counted(cause.pieces)}, explanations, normal, likelihood);
  one.gain = one.set.log_weight + odds - set.log_weight;
  return one;
}

// log L = log mean_s L(pieces at s, functions at s w; the others at their best)
//         + sum over the others of what averaging over their scales costs and their signs say,
//   w^2 = mean over the pieces of tr G_k / tr G_f:  at one s each moves the rows by as much. No part is larger than
// causes are.
WeightedSet NamelessCauses::WithOneSize(const WeightedSet& set, const Cause& cause,
                                        const std::vector<Explanation>& explanations, const ProjectedNormal& normal,
                                        const ResidualLikelihood& likelihood) {
  const auto shown = [&](int m) { return OwnInformation(normal, explanations[m].group).trace(); };
  double shown_by_pieces = 0.0;
  for (const int m : cause.pieces) shown_by_pieces += shown(m) / static_cast<double>(cause.pieces.size());
  Members members(normal, GroupsOf(explanations, set.members), set.scales);
  std::vector<double> units;  // of the scales; 0: of another cause
  double lost = 0.0;
  for (size_t k = 0; k < members.size(); ++k) {
    const int m = set.members[k];
    const bool is_piece = std::binary_search(cause.pieces.begin(), cause.pieces.end(), m);
    const bool is_function = std::binary_search(cause.functions.begin(), cause.functions.end(), m);
    units.push_back(is_piece ? 1.0 : is_function ? std::sqrt(shown_by_pieces / shown(m)) : 0.0);
    if (!is_piece && !is_function)
      lost += LossOfScale(likelihood, members.Of(k)) + LogOfSigns(likelihood, members.Of(k), set.scales[k]);
  }
  WeightedSet one = set;
  std::vector<double> logs;
  for (int s = 0; s < kNumUsualScales; ++s) {
    for (size_t k = 0; k < units.size(); ++k) {
      if (units[k] > 0.0) members.Rescale(k, std::min(kScales[s] * units[k], kLargestUsual));
    }
    const double log = likelihood.Log(members.residual()) - 0.5 * members.log_det();
    if (logs.empty() || log > *std::max_element(logs.begin(), logs.end())) one.scales = members.scales();
    logs.push_back(log);
  }
  one.log_likelihood = LogMean(logs) + lost;
  one.log_weight += one.log_likelihood - set.log_likelihood;
  return one;
}

}  // namespace sagitta

#include "estimator/explanations/explanations.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>

#include "estimator/explanations/compensator_shapes.h"
#include "estimator/explanations/driver_functions.h"
#include "estimator/explanations/unnamed_functions.h"
#include "estimator/report/explanations_words.h"
#include "models/effects/catalogue.h"
#include "models/effects/learnt_deviation.h"

namespace sagitta {
namespace {

constexpr double kAlikeShapes = 1e-5;  // of the largest: directions of springs that add less are dropped
constexpr long kPerShape = 4;          // columns of a compensator's shape: torque, and its three derivatives
constexpr double kElsewhere = 0.05;    // of the compensators: not against the arm's own weight

// What explanations that exclude each other have in common.
std::string WithoutOthers(const Robot& robot, EffectSpec spec) {
  const EffectDefinition* definition = FindEffect(robot, spec.effect);
  if (definition == nullptr) return spec.effect;  // a robot has one compensator
  for (const SettingDefinition& setting : definition->settings) {
    if (setting.one_each) spec.settings.erase(setting.name);
  }
  return NameOfExplanation(robot, spec);
}

// The orders that few configurations scan are equally likely, those beyond evenly over the logarithm: how many the data
// resolve says little of an eccentric scale's. 0: effects without orders are equally likely.
double WeightOf(const Robot& robot, const EffectSpec& spec) {
  const EffectDefinition* definition = FindEffect(robot, spec.effect);
  if (definition == nullptr) return 0.0;
  for (const SettingDefinition& setting : definition->settings) {
    if (setting.kind != SettingDefinition::Kind::kInteger) continue;
    return std::min(1.0, kHarmonicOrders / static_cast<double>(spec.IntegerSetting(setting.name, 1)));
  }
  return 0.0;
}

// Of the catalogue or of what is unnamed, each with its mass: equal over families, then over targets, then over what
// excludes nothing else (a harmonic's orders, play by approach or by torque), then over scanned settings (moments,
// widths); in a family that states weights, by these.
void SetShares(const PriorMasses& prior, ExplanationList* list) {
  struct Family {
    std::map<std::string, std::map<int, int>> settings;  // of each target, of each that excludes nothing else
    double weights = 0.0;
  };
  const double something = prior.catalogue + prior.unnamed;
  for (const bool unnamed : {false, true}) {
    std::map<std::string, Family> families;
    std::vector<size_t> own;
    for (size_t k = 0; k < list->math.size(); ++k) {
      if (list->IsUnnamed(static_cast<int>(k)) != unnamed) continue;
      own.push_back(k);
      Family& family = families[list->place[k].family];
      ++family.settings[list->place[k].target][list->math[k].excludes];
      family.weights += list->place[k].weight;
    }
    const double mass =
        (unnamed ? prior.unnamed : prior.catalogue) / something / std::max(1.0, static_cast<double>(families.size()));
    for (const size_t k : own) {
      const PlaceInPrior& place = list->place[k];
      const Family& family = families[place.family];
      const std::map<int, int>& settings = family.settings.at(place.target);
      const double among =
          static_cast<double>(family.settings.size() * settings.size()) * settings.at(list->math[k].excludes);
      list->math[k].share = mass * place.listed * (family.weights > 0.0 ? place.weight / family.weights : 1.0 / among);
    }
  }
}

class ListBuilder {
 public:
  ListBuilder(const CalibrationProblem& problem, const ParameterSet& parameters, const CandidateList& candidates,
              EvidenceColumns* columns)
      : problem_(problem), parameters_(parameters), columns_(columns), fitted_(FittedShots(problem)) {
    list_.candidates = candidates.candidates;
    list_.not_testable = candidates.not_testable;
  }

  ExplanationList Build(const PriorMasses& prior, bool with_unnamed) {
    AddCatalogue();
    if (with_unnamed) AddUnnamed();
    SetShares(prior, &list_);
    return std::move(list_);
  }

 private:
  int Number(const std::string& name) {
    return numbers_.emplace(name, static_cast<int>(numbers_.size())).first->second;
  }

  void Append(ColumnGroup group, int candidate, int unnamed, const EffectSpec& start, const PlaceInPrior& place,
              const std::string& name, const std::string& excludes) {
    list_.name.push_back(name);
    if (unnamed >= 0) group.num_scales = kNumUsualScales;
    list_.math.push_back({std::move(group), 0.0, Number(excludes), unnamed >= 0, NeedOf(start),
                          unnamed < 0 && IsWeight(problem_.robot(), start)});
    list_.candidate.push_back(candidate);
    list_.unnamed.push_back(unnamed);
    list_.start.push_back(start);
    list_.place.push_back(place);
  }

  // A spring acts through its joint's compliance. Where the model has none, a spring by itself would be free to do what
  // the weights do to a joint whose compliance is missing.
  int NeedOf(const EffectSpec& start) const {
    const bool is_through = IsNewSpring(start) && !(ComplianceOf(parameters_, start.target) > 0.0);
    if (!is_through) return kNoExplanation;
    const auto needed = std::find(list_.name.begin(), list_.name.end(), ComplianceEffectOf(start.target).Path());
    CHECK(needed != list_.name.end()) << start.target;
    return static_cast<int>(needed - list_.name.begin());
  }

  void AddCatalogue() {
    for (size_t c = 0; c < list_.candidates.size(); ++c) {
      const EffectSpec& spec = list_.candidates[c].spec;
      const int candidate = static_cast<int>(c);
      if (IsGravityCompensator(spec) && !problem_.robot().gravity_compensator) {
        AddCompensator(candidate);
      } else if (!columns_->ColumnsOf(candidate).empty()) {
        AddAsItIs(candidate, columns_->ColumnsOf(candidate));
        if (IsGravityCompensator(spec)) AddRateAlone(candidate);
      }
    }
  }

  void AddAsItIs(int candidate, const std::vector<int>& columns) {
    const EffectSpec& spec = list_.candidates[candidate].spec;
    ColumnGroup group{columns, {}};
    group.not_negative = NotNegativeOf(spec, columns);
    Append(std::move(group), candidate, -1, spec, {spec.effect, spec.target, WeightOf(problem_.robot(), spec)},
           NameOfExplanation(problem_.robot(), spec), WithoutOthers(problem_.robot(), spec));
  }

  // Which of an effect's columns are of parameters that no machine has less than nothing of.
  std::vector<int> NotNegativeOf(const EffectSpec& spec, const std::vector<int>& columns) const {
    std::vector<int> places;
    const EffectDefinition* definition = FindEffect(problem_.robot(), spec.effect);
    if (definition == nullptr) return places;
    for (const EffectParameter& parameter : definition->parameters(problem_.robot(), spec)) {
      const auto is_it = [&](int column) { return columns_->Name(column) == spec.Path() + "/" + parameter.name; };
      const auto column = std::find_if(columns.begin(), columns.end(), is_it);
      if (parameter.not_negative && column != columns.end())
        places.push_back(static_cast<int>(column - columns.begin()));
    }
    return places;
  }

  // A stated spring that has lost force, or was never as stiff, is where it is stated to be.
  void AddRateAlone(int candidate) {
    const std::vector<int>& all = columns_->ColumnsOf(candidate);
    for (const int column : all) {
      if (all.size() > 1 && columns_->Name(column) == NameOf(CompensatorPart::kKc)) AddAsItIs(candidate, {column});
    }
  }

  // Four columns for each shape: a spring of the usual rest length that turns the joint by kTypicalSpringTurn (root
  // mean square over the shots), and what another rest length, direction and ratio within the grid's cell add,
  //   Kc (T1 + s0 T2),  s0 = m + d eta,  eta ~ N(0, 1):  columns T1 + m T2, d T2, and the first one's derivatives times
  // the standard deviations of an even distribution over the cell.
  void AddCompensator(int candidate) {
    const EffectSpec& spec = list_.candidates[candidate].spec;
    const int joint = problem_.robot().chain.FindJoint(spec.target);
    const Source source{Source::Kind::kJoint, joint, 0};
    const std::vector<EffectSpec> shapes = CompensatorShapes(spec.target);
    const Eigen::MatrixX2d wave = Wave(JointValues(problem_, joint));
    Eigen::MatrixXd torques(wave.rows(), kPerShape * static_cast<long>(shapes.size()));
    const double turn = kTypicalSpringTurn / kTypicalTurn * std::sqrt(static_cast<double>(fitted_.size()));
    for (size_t s = 0; s < shapes.size(); ++s) {
      const Eigen::MatrixXd own = SpringColumns(shapes[s], wave);
      torques.middleCols(kPerShape * static_cast<long>(s), kPerShape) = turn / OnFitted(own.col(0)).norm() * own;
    }
    const Eigen::VectorXd weights = SpringWeights(joint, OnFitted(torques));
    const Compressed functions = Compress(torques, kAlikeShapes);
    const std::vector<int> own = columns_->Add({source, std::make_shared<const Eigen::MatrixXd>(functions.basis)});
    for (size_t s = 0; s < shapes.size(); ++s) {
      Append({own, functions.mixing.middleCols(kPerShape * static_cast<long>(s), kPerShape)}, candidate, -1, shapes[s],
             {spec.effect, spec.target, weights[s]}, NameOfExplanation(problem_.robot(), spec),
             WithoutOthers(problem_.robot(), spec));
    }
  }

  // A compensator is built where weight is carried and against it. Of the prior a joint has the share of the squared
  // torque that a weight at the flange puts on it (mean over the shots, of all joints'), and of that a shape the share
  // that it can remove, cos^2 of the angle between the two torques, nothing where it pulls along.
  // kElsewhere of the prior is equal over joints and shapes: springs that balance something else.
  Eigen::VectorXd SpringWeights(int joint, const Eigen::MatrixXd& torques) {
    if (of_weight_.size() == 0) of_weight_ = OnFitted(TorquesPerWeight(problem_, parameters_));
    const Chain& chain = problem_.robot().chain;
    const double sign = chain.transforms[chain.JointTransform(joint)].sign;  // a spring's torque is along the joint
    SpringShares& shares = list_.springs[chain.joints[joint].name];
    shares = {sign * of_weight_.col(joint), 1.0, 0.0};
    const long shapes = torques.cols() / kPerShape;
    const auto of_shapes = [&]() -> Eigen::VectorXd {
      return Eigen::VectorXd::NullaryExpr(shapes, [&](long s) { return shares.Of(torques.col(kPerShape * s)); });
    };
    double all = 0.0;
    for (int j = 0; j < joints(); ++j) all += IsRevolute(problem_, j) ? of_weight_.col(j).squaredNorm() : 0.0;
    const double sum = of_shapes().sum(), of_joint = all > 0.0 ? of_weight_.col(joint).squaredNorm() / all : 0.0;
    shares.per_cosine = sum > 0.0 ? (1.0 - kElsewhere) * of_joint / sum : 0.0;
    shares.elsewhere = kElsewhere / static_cast<double>(joints() * shapes);
    return of_shapes();
  }

  Eigen::MatrixXd OnFitted(const Eigen::MatrixXd& functions) const { return functions(fitted_, Eigen::all); }

  int joints() const { return problem_.robot().num_joints(); }

  void AddUnnamed() {
    for (UnnamedGroup& unnamed : ListUnnamed(problem_, parameters_, columns_)) {
      const std::string name = unnamed.family + "/" + unnamed.function.acts_on + "/" + unnamed.function.words;
      list_.functions.push_back(std::move(unnamed.function));
      const int function = static_cast<int>(list_.functions.size()) - 1;
      Append(std::move(unnamed.group), -1, function, {}, {unnamed.family, name, 0.0, unnamed.listed}, name, name);
    }
  }

  const CalibrationProblem& problem_;
  const ParameterSet& parameters_;
  EvidenceColumns* columns_;
  std::vector<int> fitted_;  // shots
  ExplanationList list_;
  std::map<std::string, int> numbers_;
  Eigen::MatrixXd of_weight_;  // fitted shots x joints: torque per weight at the flange, m
};

}  // namespace

std::string NameOfExplanation(const Robot& robot, EffectSpec spec) {
  const EffectDefinition* definition = FindEffect(robot, spec.effect);
  if (definition == nullptr) return spec.effect + "/" + spec.target;
  for (const SettingDefinition& setting : definition->settings) {
    const bool is_scanned =
        setting.kind == SettingDefinition::Kind::kMoment || setting.kind == SettingDefinition::Kind::kNumber;
    if (is_scanned) spec.settings.erase(setting.name);
  }
  return spec.Path();
}

NamedSet ExplanationList::ByName(const std::vector<int>& members, double probability,
                                 const std::vector<int>& pieces) const {
  NamedSet named{probability, {}, {}};
  for (const int m : members) {
    if (IsUnnamed(m)) {
      named.unnamed.push_back(functions[unnamed[m]].words);
    } else if (std::binary_search(pieces.begin(), pieces.end(), m)) {
      named.unnamed.push_back(PartlyLike(SpecOf(m).effect, SpecOf(m).target));
    } else {
      named.specs.push_back(start[m]);
    }
  }
  return named;
}

ExplanationList ListExplanations(const CalibrationProblem& problem, const ParameterSet& parameters,
                                 const CandidateList& candidates, const PriorMasses& prior, EvidenceColumns* columns,
                                 bool with_unnamed) {
  return ListBuilder(problem, parameters, candidates, columns).Build(prior, with_unnamed);
}

void DropInvisible(const ProjectedNormal& normal, const PriorMasses& prior, ExplanationList* list) {
  const double variance = kLargestUsual * kLargestUsual;
  std::vector<size_t> kept;
  std::vector<int> place(list->math.size(), kNoExplanation);  // among those
  std::map<std::pair<std::string, std::string>, bool> seen;   // of the catalogue, by effect and target
  const auto shows = [&](size_t k) { return variance * OwnInformation(normal, list->math[k].group).trace() >= 1.0; };
  for (size_t k = 0; k < list->math.size(); ++k) {
    int& needs = list->math[k].needs;  // what is listed before
    const bool lacks_need = needs != kNoExplanation && place[needs] == kNoExplanation;
    const bool is_visible = !lacks_need && shows(k);
    if (is_visible) {
      place[k] = static_cast<int>(kept.size());
      kept.push_back(k);
      if (needs != kNoExplanation) needs = place[needs];
    }
    if (list->IsUnnamed(static_cast<int>(k))) continue;
    const EffectSpec& spec = list->SpecOf(static_cast<int>(k));
    seen[{spec.effect, spec.target}] |= is_visible;
  }
  for (const auto& [what, is_visible] : seen) {
    if (is_visible) continue;
    list->not_testable.push_back({what.first, what.second, RowsAboveTheNoise()});
  }
  const auto keep = [&kept](auto* values) {
    std::remove_reference_t<decltype(*values)> few;
    for (const size_t k : kept) few.push_back(std::move((*values)[k]));
    *values = std::move(few);
  };
  keep(&list->math);
  keep(&list->candidate);
  keep(&list->unnamed);
  keep(&list->start);
  keep(&list->name);
  keep(&list->place);
  SetShares(prior, list);
}

}  // namespace sagitta

#include "estimator/explanations/candidates.h"

#include <algorithm>
#include <set>

#include "estimator/explanations/compensator_shapes.h"
#include "estimator/explanations/moments.h"
#include "estimator/report/explanations_words.h"
#include "models/effects/catalogue.h"
#include "problems/loads.h"
#include "problems/problem_checks.h"

namespace sagitta {
namespace {

constexpr int kConfigurationsPerOrder = 20;  // ten for each of its two values

bool AnyLoad(const CalibrationProblem& problem) {
  return std::any_of(problem.shot_inputs().begin(), problem.shot_inputs().end(),
                     [](const ShotInput& shot) { return !shot.wrenches.empty() || !shot.terms.torques.empty(); });
}

std::vector<std::string> JointsBut(const CalibrationProblem& problem, const std::string& one, bool turn) {
  std::vector<std::string> names;
  for (const Joint& joint : problem.robot().chain.joints) {
    if (joint.name != one && (!turn || joint.type == JointType::kRevolute)) names.push_back(joint.name);
  }
  return names;
}

std::vector<std::string> HeldErrors(const CalibrationProblem& problem) {
  std::vector<std::string> errors;
  for (const Coordinate& coordinate : problem.parameters.coordinates()) {
    if (coordinate.kind == CoordinateKind::kGeometry && !coordinate.estimated())
      errors.push_back(coordinate.name.substr(coordinate.name.find('/') + 1));
  }
  return errors;
}

std::vector<std::string> TargetsOf(const EffectDefinition& definition, const CalibrationProblem& problem) {
  switch (definition.target) {
    case EffectTarget::kJoint:
      return JointNames(problem.robot().chain.joints);
    case EffectTarget::kError:
      return HeldErrors(problem);
    case EffectTarget::kBase:
      return {"base"};
    case EffectTarget::kRobot:
      return {"robot"};
    case EffectTarget::kStation:
      return problem.data().stations;
    case EffectTarget::kLoad:
      return LoadsCarried(problem.data());
    case EffectTarget::kMarker:
      return problem.data().markers;
  }
  return {};
}

std::vector<std::string> Choices(const SettingDefinition& setting, const std::string& target,
                                 const CalibrationProblem& problem) {
  if (setting.kind == SettingDefinition::Kind::kMoment) return ChangePoints(problem);
  if (setting.kind == SettingDefinition::Kind::kJoint) return JointsBut(problem, target, setting.turns);
  if (setting.kind != SettingDefinition::Kind::kInteger) return setting.choices;
  std::vector<std::string> orders;
  const int most = setting.most_scanned > 0 ? setting.most_scanned : ResolvedOrders(problem);
  for (int n = 1; n <= most; ++n) orders.push_back(std::to_string(n));
  return orders;
}

bool Stands(const CalibrationProblem& problem, const EffectSpec& spec) {
  for (const EffectSpec& own : problem.robot().effects) {
    if (own.Path() == spec.Path()) return true;
  }
  if (!IsUseOf(JointComplianceEffect(), spec)) return false;
  for (const int i : ComplianceCoordinates(problem.parameters, spec.target)) {
    if (problem.parameters.coordinates()[i].estimated()) return true;
  }
  return false;
}

// Whether what drives the effect is more than one value.
template <typename Value>
bool Varies(const CalibrationProblem& problem, const Value& value) {
  return std::any_of(problem.shot_inputs().begin(), problem.shot_inputs().end(), [&](const ShotInput& shot) {
    return value(shot.conditions) != value(problem.shot_inputs()[0].conditions);
  });
}

// "" or the column that states one and the same in every row; that nothing was approached from anywhere (0) is no
// statement at all.
std::string StandingColumn(const CalibrationProblem& problem, const EffectDefinition& definition,
                           const EffectSpec& spec) {
  const EffectDriver by = definition.DrivenBy(spec);
  if (by == EffectDriver::kTime) {
    const bool varies = Varies(problem, [](const ShotConditions& shot) { return shot.time; });
    return varies ? "" : "time_s that varies";
  }
  if (by == EffectDriver::kTemperature) {
    const bool varies = Varies(problem, [](const ShotConditions& shot) { return shot.temperature; });
    return varies ? "" : "temperature_degC that varies";
  }
  if (definition.PressedByOf(spec) != PressedBy::kApproach) return "";
  const int joint = problem.robot().chain.FindJoint(spec.target);
  if (joint < 0 || !problem.shot_inputs()[0].conditions.StatesApproachOf(joint)) return "";
  if (Varies(problem, [joint](const ShotConditions& shot) { return shot.approach[joint]; })) return "";
  const bool is_zero = problem.shot_inputs()[0].conditions.approach[joint] == 0;
  return "approach" + std::to_string(joint + 1) + (is_zero ? "" : " that varies");
}

std::string MissingFor(const CalibrationProblem& problem, const EffectDefinition& definition, const EffectSpec& spec) {
  const bool asks_any = definition.missing != nullptr || definition.DrivenBy(spec) != EffectDriver::kJoint;
  for (const ShotInput& shot : problem.shot_inputs()) {
    if (!asks_any) break;
    const EffectContext context{&problem.robot(), &spec, &shot.conditions, &problem.data().markers, 0};
    const std::string column = MissingColumn(definition, context);
    if (!column.empty()) return column;
  }
  return StandingColumn(problem, definition, spec);
}

bool IsLevelled(const Experiment& experiment) {
  return std::all_of(experiment.stations.begin(), experiment.stations.end(),
                     [](const auto& station) { return station.second.levelled.value_or(true); });
}

// "" or what is not known where the effect is of weights. Whether it is, its terms say.
std::string UnknownGravity(const CalibrationProblem& problem, const EffectSpec& spec) {
  const std::string station = UnlevelledStationWithWeights(problem.WithEffects({spec}));
  return station.empty() ? "" : GravityIsUnknown(station);
}

// Joints that give way: what acts through a compliance of zero does nothing.
std::set<std::string> CompliantJoints(const CalibrationProblem& problem, const ParameterSet& estimated) {
  std::set<std::string> joints;
  for (const JointCompliance& compliance : problem.robot().compliances) {
    const std::string& joint = problem.robot().chain.joints[compliance.joint].name;
    if (ComplianceOf(estimated, joint) > 0.0) joints.insert(joint);
  }
  return joints;
}

bool IsListed(const CandidateList& list, const EffectSpec& spec) {
  return std::any_of(list.candidates.begin(), list.candidates.end(),
                     [&spec](const Candidate& listed) { return listed.spec.Path() == spec.Path(); });
}

// The compensator's home is the robot; its place in the list of effects is after
// the transverse compliance. One that the robot has may be other than stated, where its parameters are held. One that
// it has not acts through the joint's compliance: that of the model, or one that may be missing as well.
void AppendCompensators(const CalibrationProblem& problem, const std::set<std::string>& compliant,
                        CandidateList* list) {
  if (problem.robot().gravity_compensator) {
    const std::string& joint = problem.robot().chain.joints[problem.robot().gravity_compensator->joint].name;
    if (HeldSpring(problem.parameters).empty()) return;
    if (compliant.count(joint) == 0) {
      list->not_testable.push_back({kGravityCompensator, joint, ComplianceAboveZero(), Lack::kCompliance});
    } else {
      list->candidates.push_back({{kGravityCompensator, joint, {}, {}}});
    }
    return;
  }
  for (const Joint& joint : problem.robot().chain.joints) {
    if (joint.type != JointType::kRevolute) continue;
    if (compliant.count(joint.name) == 0 && !IsListed(*list, ComplianceEffectOf(joint.name))) {
      list->not_testable.push_back({kGravityCompensator, joint.name, ComplianceAboveZero(), Lack::kCompliance});
    } else {
      list->candidates.push_back({{kGravityCompensator, joint.name, {}, {}}});
    }
  }
}

// What elastic effects answer to.
struct Knowledge {
  bool loads, compliances, levelled;
};

// Whether it is a joint that slides, for which the effect says nothing.
bool SlidesInstead(const CalibrationProblem& problem, const EffectDefinition& definition, const std::string& target) {
  if (definition.target != EffectTarget::kJoint || definition.on_slide == OnSlide::kDiagnosed) return false;
  return problem.robot().chain.joints[problem.robot().chain.FindJoint(target)].type != JointType::kRevolute;
}

// "" or what the data or the model lack. Sag with unknown compliance (kNoCompliances) stands for link weights where no
// load determines them.
std::string UnmetNeed(EffectNeeds needs, const Knowledge& known) {
  if (needs == EffectNeeds::kLoads && !known.loads) return "loaded rows";
  if (needs == EffectNeeds::kCompliances && !known.compliances) return "joint compliances above 0 (loaded rows)";
  if (needs == EffectNeeds::kNoCompliances && known.compliances) return CompliancesOfZero();
  return "";
}

// One effect on one target with every combination of its settings.
std::vector<EffectSpec> Variants(const CalibrationProblem& problem, const EffectDefinition& definition,
                                 const std::string& target) {
  std::vector<EffectSpec> variants = {{definition.name, target, {}, {}}};
  for (const SettingDefinition& setting : definition.settings) {
    std::vector<EffectSpec> grown;
    const std::vector<std::string> choices = Choices(setting, target, problem);
    for (const EffectSpec& variant : variants) {
      const bool means_something = setting.MeansSomethingFor(variant);
      if (setting.silent || !means_something) grown.push_back(variant);
      if (!means_something) continue;
      for (const std::string& choice : choices) {
        if (setting.silent && choice == setting.FallbackFor(problem.robot())) continue;
        grown.push_back(variant);
        grown.back().settings[setting.name] = choice;
      }
    }
    variants = std::move(grown);
  }
  return variants;
}

// What a column is of that an effect lacks.
Lack LackOf(const EffectDefinition& definition, const EffectSpec& spec) {
  const EffectDriver by = definition.DrivenBy(spec);
  if (by == EffectDriver::kTime) return Lack::kTime;
  if (by == EffectDriver::kTemperature) return Lack::kTemperature;
  return definition.PressedByOf(spec) == PressedBy::kApproach ? Lack::kApproach : Lack::kOther;
}

// Whether a setting of it that acts by what is remembered makes no difference on these shots.
bool IsAsWithoutSetting(const CalibrationProblem& problem, const EffectDefinition& definition,
                        const EffectSpec& variant) {
  const auto memories = [&](const EffectSpec& spec) {
    return MemoriesOf(problem.robot(), definition, spec, problem.shot_inputs());
  };
  for (const SettingDefinition& setting : definition.settings) {
    EffectSpec without = variant;
    if (!setting.is_of_memory || without.settings.erase(setting.name) == 0) continue;
    if (memories(variant) == memories(without)) return true;
  }
  return false;
}

void AppendVariants(const CalibrationProblem& problem, const EffectDefinition& definition, const std::string& target,
                    const Knowledge& known, CandidateList* list) {
  const std::vector<EffectSpec> variants = Variants(problem, definition, target);
  std::string missing = variants.empty() ? MissingFor(problem, definition, {definition.name, target, {}, {}}) : "";
  Lack lack = missing.empty() ? Lack::kOther : LackOf(definition, {definition.name, target, {}, {}});
  std::vector<EffectSpec> testable;
  for (const EffectSpec& variant : variants) {
    const std::string column = MissingFor(problem, definition, variant);
    if (!column.empty()) {
      missing = column;
      lack = LackOf(definition, variant);
    }
    const bool needs_torque = definition.PressedByOf(variant) == PressedBy::kTorque && !known.loads;
    if (!column.empty() || needs_torque || Stands(problem, variant)) continue;
    if (!IsAsWithoutSetting(problem, definition, variant)) testable.push_back(variant);
  }
  const std::string unknown = testable.empty() || known.levelled ? "" : UnknownGravity(problem, testable[0]);
  if (!unknown.empty()) {
    missing = unknown;
    lack = Lack::kOther;
    testable.clear();
  }
  if (!missing.empty()) list->not_testable.push_back({definition.name, target, missing, lack});
  for (EffectSpec& variant : testable) list->candidates.push_back({std::move(variant)});
}

}  // namespace

int ResolvedOrders(const CalibrationProblem& problem) {
  const auto& configurations = problem.data().configurations;
  const auto fitted = std::count_if(configurations.begin(), configurations.end(),
                                    [](const Configuration& c) { return !c.is_validation; });
  return std::min(kMostHarmonicOrders, std::max(kHarmonicOrders, static_cast<int>(fitted) / kConfigurationsPerOrder));
}

std::vector<std::string> LoadsCarried(const Measurements& data) {
  std::set<std::string> loads;
  for (const Shot& shot : data.shots) {
    if (IsLoaded(shot)) loads.insert(shot.load);
  }
  return {loads.begin(), loads.end()};
}

std::vector<EffectSpec> SpecsOf(const std::vector<Candidate>& candidates) {
  std::vector<EffectSpec> specs;
  for (const Candidate& candidate : candidates) specs.push_back(candidate.spec);
  return specs;
}

CandidateList ListCandidates(const CalibrationProblem& problem, const ParameterSet& estimated) {
  CandidateList list;
  const std::set<std::string> compliant = CompliantJoints(problem, estimated);
  const Knowledge known{AnyLoad(problem), !compliant.empty(), IsLevelled(problem.experiment())};
  for (const EffectDefinition* definition : EffectsOf(problem.robot())) {
    if (definition->is_learnt) continue;
    if (definition == &LinkGravity()) AppendCompensators(problem, compliant, &list);
    const std::string unmet = UnmetNeed(definition->needs, known);
    for (const std::string& target : TargetsOf(*definition, problem)) {
      const std::string need = SlidesInstead(problem, *definition, target) ? "a revolute joint" : unmet;
      if (need.empty()) {
        AppendVariants(problem, *definition, target, known, &list);
      } else {
        list.not_testable.push_back({definition->name, target, need});
      }
    }
  }
  return list;
}

}  // namespace sagitta

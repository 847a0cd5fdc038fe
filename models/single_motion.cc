#include "models/single_motion.h"

#include "models/effects/catalogue.h"

namespace sagitta {
namespace {

bool MovesJointsOrMarkers(const ShotTerms& terms) {
  return terms.elastic.empty() && terms.sags.empty() && terms.wrenches.empty() && terms.base.empty() &&
         terms.station.empty() && terms.sights.empty();
}

// False where the parameter moves something else already.
bool Add(SingleMotion::Of of, int owner, int axis, int shot, double value, SingleMotion* motion) {
  const bool is_first = motion->of == SingleMotion::Of::kNothing;
  if (!is_first && (motion->of != of || motion->owner != owner || motion->axis != axis)) return false;
  motion->of = of;
  motion->owner = owner;
  motion->axis = axis;
  motion->per_unit[shot] += value;
  return true;
}

// A slot of a joint holds sign (q + deviation): the deviation is sign times what the slot moves.
bool AddSlot(const Chain& chain, const SlotTerm& term, int shot, SingleMotion* motion) {
  const ElementaryTransform& transform = chain.transforms[term.transform];
  return transform.has_joint() &&
         Add(SingleMotion::Of::kJoint, transform.joint, 0, shot, transform.sign * term.factor, motion);
}

bool AddMarker(const MarkerTerm& term, int shot, SingleMotion* motion) {
  for (int axis = 0; axis < 3; ++axis) {
    const bool along = term.direction[axis] != 0.0;
    if (along && !Add(SingleMotion::Of::kMarker, term.marker, axis, shot, term.direction[axis], motion)) return false;
  }
  return true;
}

}  // namespace

std::optional<std::vector<SingleMotion>> SingleMotionsOf(const Robot& robot, const std::vector<std::string>& markers,
                                                         const EffectSpec& spec, const std::vector<ShotInput>& shots) {
  const EffectDefinition* definition = FindEffect(robot, spec.effect);
  const bool may_be = definition != nullptr && !definition->tilts &&
                      (definition->target == EffectTarget::kJoint || definition->target == EffectTarget::kMarker);
  if (!may_be) return std::nullopt;
  const std::vector<double> memories = MemoriesOf(robot, *definition, spec, shots);
  std::vector<SingleMotion> motions(definition->parameters(robot, spec).size());
  for (SingleMotion& motion : motions) motion.per_unit.setZero(static_cast<long>(shots.size()));
  ShotTerms terms;
  for (size_t s = 0; s < shots.size(); ++s) {
    terms.slots.clear();
    terms.markers.clear();
    definition->apply({&robot, &spec, &shots[s].conditions, &markers, 0, memories[s]}, &terms);
    if (!MovesJointsOrMarkers(terms)) return std::nullopt;
    for (const SlotTerm& term : terms.slots) {
      if (!AddSlot(robot.chain, term, static_cast<int>(s), &motions[term.parameter])) return std::nullopt;
    }
    for (const MarkerTerm& term : terms.markers) {
      if (!AddMarker(term, static_cast<int>(s), &motions[term.parameter])) return std::nullopt;
    }
  }
  for (const SingleMotion& motion : motions) {
    if (motion.of == SingleMotion::Of::kNothing) return std::nullopt;
  }
  return motions;
}

}  // namespace sagitta

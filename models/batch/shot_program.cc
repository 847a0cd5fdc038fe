#include "models/batch/shot_program.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <set>

namespace sagitta {
namespace {

// Frames that bear wrenches, ascending.
std::vector<int> WrenchFrames(const ShotInput& shot) {
  std::set<int> frames;
  const auto add = [&](const std::vector<AppliedWrench>& wrenches) {
    for (const AppliedWrench& wrench : wrenches) frames.insert(wrench.frame);
  };
  add(shot.wrenches);
  for (const WrenchTerm& term : shot.terms.wrenches) add(term.wrenches);
  for (const SagTerm& term : shot.terms.sags) add(term.wrenches);
  return {frames.begin(), frames.end()};
}

// Slots that do not answer in this shot bend nothing and are left out: those without a term, and where nothing pulls
// but the spring, which acts on its own joint alone, those of the other joints: their torques are zero in every state.
// A bump is not zero there.
std::vector<int> ElasticSlots(const ForwardModel& model, const ShotInput& shot) {
  const bool is_pulled = !shot.wrenches.empty() || !shot.terms.wrenches.empty();
  std::set<int> slots;
  for (const ElasticTerm& term : shot.terms.elastic) {
    if (is_pulled || term.law == ElasticLaw::kBump) slots.insert(term.transform);
  }
  for (const SagTerm& term : shot.terms.sags) slots.insert(term.transform);
  const std::optional<GravityCompensator>& spring = model.robot().gravity_compensator;
  const bool may_bend = !shot.terms.elastic.empty() || !shot.terms.sags.empty();
  if (spring && may_bend) slots.insert(model.chain().JointTransform(spring->joint));
  return {slots.begin(), slots.end()};
}

bool SeesEqually(const BatchReading& reading) {
  return reading.whitener == reading.whitener(0, 0) * Matrix3<double>::Identity();
}

bool BelongsTo(const SightTerm& term, const BatchReading& reading) {
  return term.marker < 0 || term.marker == reading.id;
}

class Builder {
 public:
  Builder(const ForwardModel& model, const ShotInput& shot, const std::vector<BatchReading>& readings)
      : chain_(model.chain()), model_(model), shot_(shot), levels_(WrenchFrames(shot)) {
    program_.num_parameters = model.num_parameters();
    program_.num_levels = static_cast<int>(levels_.size());
    AddTransforms();
    AddElastic(ElasticSlots(model, shot));
    AddMarkers(readings);
    for (const BaseTerm& term : shot.terms.base) program_.growth.push_back({term.parameter, Take(1)});
    for (const StationTerm& term : shot.terms.station) program_.station.push_back({term.parameter, Take(12)});
    for (int j = 0; j < chain_.num_joints(); ++j) {
      program_.joint_twists.push_back(TwistOf(chain_.JointTransform(j)));
      program_.joint_signs.push_back(chain_.transforms[chain_.JointTransform(j)].sign);
    }
  }

  ShotProgram Take() {
    for (ShotProgram::Twist& twist : program_.twists) {
      twist.is_rotation = program_.transforms[twist.transform].is_rotation;
      for (const ShotProgram::Slot& slot : program_.slots) twist.slots += slot.transform <= twist.transform ? 1 : 0;
    }
    AddParts();
    return std::move(program_);
  }

 private:
  void AddParts() {
    using Part = ShotProgram::Part;
    using PartOf = ShotProgram::PartOf;
    std::vector<std::vector<Part>> of(static_cast<size_t>(program_.num_parameters));
    const auto add = [&](int parameter, PartOf kind, int index, int data = -1) {
      if (parameter >= 0) of[static_cast<size_t>(parameter)].push_back({kind, index, data});
    };
    for (const ShotProgram::Transform& transform : program_.transforms) {
      add(transform.geometry, PartOf::kTransform, transform.twist);
      for (const ShotProgram::Scaled& term : transform.terms) {
        add(term.parameter, PartOf::kTransform, transform.twist, term.data);
      }
    }
    for (size_t i = 0; i < program_.elastic.size(); ++i) {
      if (program_.elastic[i].slot >= 0) add(program_.elastic[i].parameter, PartOf::kElastic, static_cast<int>(i));
    }
    for (size_t i = 0; i < program_.loads.size(); ++i) {
      add(program_.loads[i].parameter, PartOf::kLoads, static_cast<int>(i));
    }
    for (size_t i = 0; i < program_.sags.size(); ++i) {
      add(program_.sags[i].parameter, PartOf::kSag, static_cast<int>(i));
    }
    for (int i = 0; i < 5 && program_.has_spring; ++i) {
      add(program_.spring.first_parameter + i, PartOf::kSpring, i);
    }
    for (const std::vector<Part>& parts : of) {
      program_.first_part.push_back(static_cast<int>(program_.parts.size()));
      program_.parts.insert(program_.parts.end(), parts.begin(), parts.end());
    }
    program_.first_part.push_back(static_cast<int>(program_.parts.size()));
  }
  int Take(int numbers) {
    const int first = program_.num_data;
    program_.num_data += numbers;
    return first;
  }
  // The first level whose frame lies beyond transform e.
  int LevelOf(int e) const {
    return static_cast<int>(std::upper_bound(levels_.begin(), levels_.end(), e) - levels_.begin());
  }
  int TwistOf(int e) {
    ShotProgram::Transform& transform = program_.transforms[e];
    if (transform.twist < 0) {
      transform.twist = static_cast<int>(program_.twists.size());
      program_.twists.push_back({e, LevelOf(e), 0, false});
    }
    return transform.twist;
  }
  int KeptFrame(int frame) {
    int& kept = frame == 0 ? program_.world_frame : program_.transforms[frame - 1].kept_frame;
    if (kept < 0) kept = program_.num_kept_frames++;
    return kept;
  }

  void AddTransforms() {
    for (const ElementaryTransform& given : chain_.transforms) {
      ShotProgram::Transform transform;
      transform.is_rotation = given.is_rotation();
      transform.axis = static_cast<int>(given.axis);
      transform.nominal = given.nominal;
      if (given.has_joint()) transform.lane_value = Take(transform.is_rotation ? 2 : 1);
      program_.transforms.push_back(transform);
    }
    for (int i = 0; i < model_.num_parameters(); ++i) {
      if (model_.parameters()[i].law != ParameterLaw::kGeometry) continue;
      program_.transforms[model_.parameters()[i].index].geometry = i;
      TwistOf(model_.parameters()[i].index);
    }
    for (const SlotTerm& term : shot_.terms.slots) {
      program_.slot_data.push_back(Take(1));
      program_.transforms[term.transform].terms.push_back({term.parameter, program_.slot_data.back()});
      TwistOf(term.transform);
    }
  }

  ShotProgram::Loads MakeLoads(int parameter, const std::vector<AppliedWrench>& wrenches) {
    ShotProgram::Loads loads;
    loads.parameter = parameter;
    for (const AppliedWrench& wrench : wrenches) {
      const auto level = std::lower_bound(levels_.begin(), levels_.end(), wrench.frame) - levels_.begin();
      const bool in_base = wrench.expressed_in == WrenchFrame::kBase;
      program_.has_base_loads |= in_base;
      loads.wrenches.push_back({KeptFrame(wrench.frame), static_cast<int>(level), in_base, Take(9)});
    }
    return loads;
  }

  void AddElastic(const std::vector<int>& slots) {
    if (slots.empty()) return;
    for (size_t s = 0; s < slots.size(); ++s) {
      program_.slots.push_back({slots[s], TwistOf(slots[s]), LevelOf(slots[s])});
      program_.transforms[slots[s]].slot = static_cast<int>(s);
    }
    const auto slot_of = [&](int transform) { return program_.transforms[transform].slot; };
    program_.loads.push_back(MakeLoads(-1, shot_.wrenches));
    for (const WrenchTerm& term : shot_.terms.wrenches)
      program_.loads.push_back(MakeLoads(term.parameter, term.wrenches));
    for (const SagTerm& term : shot_.terms.sags) {
      program_.sags.push_back(MakeLoads(term.parameter, term.wrenches));
      program_.sags.back().slot = slot_of(term.transform);
    }
    for (const ElasticTerm& term : shot_.terms.elastic) {
      program_.elastic.push_back({slot_of(term.transform), term.parameter, Take(1), term.law, term.width, term.centre});
    }
    if (model_.robot().gravity_compensator) AddSpring(*model_.robot().gravity_compensator);
  }

  void AddSpring(const GravityCompensator& spring) {
    const int e = chain_.JointTransform(spring.joint);
    const double zero = spring.zero.value_or(chain_.transforms[e].nominal);
    program_.has_spring = true;
    program_.spring = {program_.transforms[e].slot,
                       e,
                       FirstOf(ParameterLaw::kCompensator),
                       std::sin(zero),
                       std::cos(zero),
                       chain_.transforms[e].sign,
                       spring.preload ? -1 : Take(2)};
  }
  int FirstOf(ParameterLaw law) const {
    int i = 0;
    while (model_.parameters()[i].law != law) ++i;
    return i;
  }

  void AddMarkers(const std::vector<BatchReading>& readings) {
    std::map<int, int> class_of;
    for (const BatchReading& reading : readings) {
      const auto [found, is_new] = class_of.emplace(reading.frame, static_cast<int>(program_.classes.size()));
      if (is_new) program_.classes.push_back({reading.frame, {}});
      program_.classes[found->second].markers.push_back(static_cast<int>(program_.markers.size()));
      ShotProgram::Marker marker;
      marker.id = reading.id;
      marker.kept_frame = KeptFrame(reading.frame);
      marker.sees_equally = SeesEqually(reading);
      marker.whitener = Take(marker.sees_equally ? 1 : 9);
      marker.point = Take(3);
      marker.grows = reading.frame > chain_.BaseFrame();
      for (const MarkerTerm& term : shot_.terms.markers) {
        if (term.marker == reading.id) marker.terms.push_back({term.parameter, Take(3)});
      }
      for (const SightTerm& term : shot_.terms.sights) {
        if (BelongsTo(term, reading)) marker.sights.push_back({term, Take(9)});
      }
      program_.markers.push_back(std::move(marker));
    }
  }

  const Chain& chain_;
  const ForwardModel& model_;
  const ShotInput& shot_;
  const std::vector<int> levels_;
  ShotProgram program_;
};

std::int64_t BitsOf(double value) {
  std::int64_t bits = 0;
  std::memcpy(&bits, &value, sizeof(bits));
  return bits;
}

bool TurnsWithFlange(const std::vector<AppliedWrench>& wrenches) {
  return std::any_of(wrenches.begin(), wrenches.end(),
                     [](const AppliedWrench& w) { return w.expressed_in == WrenchFrame::kFlange; });
}

}  // namespace

std::vector<std::int64_t> StructureOf(const ForwardModel& model, const ShotInput& shot,
                                      const std::vector<BatchReading>& readings) {
  std::vector<std::int64_t> key;
  AppendStructure(model, shot, readings, &key);
  return key;
}

bool AppendStructure(const ForwardModel& model, const ShotInput& shot, const std::vector<BatchReading>& readings,
                     std::vector<std::int64_t>* given) {
  if (!shot.prepared || !shot.terms.torques.empty()) return false;
  std::vector<std::int64_t>& key = *given;
  const size_t before = key.size();
  key.push_back(model.chain().num_transforms());
  bool known = true;
  const auto add = [&](auto... numbers) { (key.push_back(numbers), ...); };
  const auto add_wrenches = [&](const std::vector<AppliedWrench>& wrenches) {
    key.push_back(static_cast<std::int64_t>(wrenches.size()));
    for (const AppliedWrench& wrench : wrenches) {
      key.push_back(2 * wrench.frame + (wrench.expressed_in == WrenchFrame::kBase ? 1 : 0));
    }
    known = known && !TurnsWithFlange(wrenches);
  };
  const auto begin_list = [&](size_t size) { key.push_back(-1 - static_cast<std::int64_t>(size)); };
  begin_list(readings.size());
  for (const BatchReading& reading : readings) {
    add(reading.id, reading.frame, SeesEqually(reading) ? 1 : 0);
  }
  add_wrenches(shot.wrenches);
  begin_list(shot.terms.slots.size());
  for (const SlotTerm& term : shot.terms.slots) add(term.transform, term.parameter);
  begin_list(shot.terms.elastic.size());
  for (const ElasticTerm& term : shot.terms.elastic) {
    add(term.transform, term.parameter, static_cast<int>(term.law), BitsOf(term.width), BitsOf(term.centre));
  }
  begin_list(shot.terms.wrenches.size());
  for (const WrenchTerm& term : shot.terms.wrenches) key.push_back(term.parameter), add_wrenches(term.wrenches);
  begin_list(shot.terms.sags.size());
  for (const SagTerm& term : shot.terms.sags) {
    add(term.transform, term.parameter);
    add_wrenches(term.wrenches);
  }
  begin_list(shot.terms.markers.size());
  for (const MarkerTerm& term : shot.terms.markers) add(term.marker, term.parameter);
  begin_list(shot.terms.base.size());
  for (const BaseTerm& term : shot.terms.base) key.push_back(term.parameter);
  begin_list(shot.terms.station.size());
  for (const StationTerm& term : shot.terms.station) key.push_back(term.parameter);
  begin_list(shot.terms.sights.size());
  for (const SightTerm& term : shot.terms.sights) {
    add(term.parameter, term.marker, static_cast<int>(term.sensed), static_cast<int>(term.law),
        static_cast<int>(term.over));
  }
  if (!known) key.resize(before);
  return known;
}

ShotProgram MakeShotProgram(const ForwardModel& model, const ShotInput& shot,
                            const std::vector<BatchReading>& readings) {
  return Builder(model, shot, readings).Take();
}

Matrix3<double> PackedWhitener(const ShotProgram::Marker& marker, int lane, const double* data) {
  const auto at = [&](int i) { return data[(marker.whitener + i) * kBatchLanes + lane]; };
  if (marker.sees_equally) return at(0) * Matrix3<double>::Identity();
  Matrix3<double> whitener;
  for (int i = 0; i < 9; ++i) whitener(i / 3, i % 3) = at(i);
  return whitener;
}

void PackShot(const ForwardModel& model, const ShotProgram& program, const ShotInput& shot,
              const std::vector<BatchReading>& readings, int lane, double* data) {
  const auto set = [&](int index, double value) { data[index * kBatchLanes + lane] = value; };
  const auto set_vector = [&](int index, const Vector3<double>& value) {
    for (int i = 0; i < 3; ++i) set(index + i, value[i]);
  };
  const auto set_matrix = [&](int index, const Matrix3<double>& value) {
    for (int i = 0; i < 9; ++i) set(index + i, value(i / 3, i % 3));
  };
  const auto set_wrenches = [&](const ShotProgram::Loads& loads, const std::vector<AppliedWrench>& wrenches) {
    for (size_t w = 0; w < wrenches.size(); ++w) {
      set_vector(loads.wrenches[w].data, wrenches[w].point);
      set_vector(loads.wrenches[w].data + 3, wrenches[w].force);
      set_vector(loads.wrenches[w].data + 6, wrenches[w].moment);
    }
  };
  const Chain& chain = model.chain();
  const Eigen::VectorXd coupled =
      chain.couplings.empty() ? Eigen::VectorXd() : chain.CoupledJointValues(shot.conditions.q);
  const Eigen::VectorXd& q = chain.couplings.empty() ? shot.conditions.q : coupled;
  for (int e = 0; e < chain.num_transforms(); ++e) {
    const ShotProgram::Transform& transform = program.transforms[e];
    if (transform.lane_value < 0) continue;
    const double value = transform.nominal + chain.transforms[e].sign * q[chain.transforms[e].joint];
    set(transform.lane_value, transform.is_rotation ? std::sin(value) : value);
    if (transform.is_rotation) set(transform.lane_value + 1, std::cos(value));
  }
  for (size_t i = 0; i < program.slot_data.size(); ++i) set(program.slot_data[i], shot.terms.slots[i].factor);
  if (program.is_elastic()) {
    set_wrenches(program.loads[0], shot.wrenches);
    for (size_t i = 0; i < shot.terms.wrenches.size(); ++i) {
      set_wrenches(program.loads[1 + i], shot.terms.wrenches[i].wrenches);
    }
    for (size_t i = 0; i < shot.terms.sags.size(); ++i) set_wrenches(program.sags[i], shot.terms.sags[i].wrenches);
    for (size_t i = 0; i < program.elastic.size(); ++i) set(program.elastic[i].data, shot.terms.elastic[i].factor);
    if (program.has_spring && program.spring.commanded >= 0) {
      const double commanded = q[model.robot().gravity_compensator->joint];
      set(program.spring.commanded, std::sin(commanded));
      set(program.spring.commanded + 1, std::cos(commanded));
    }
  }
  for (size_t m = 0; m < readings.size(); ++m) {
    const ShotProgram::Marker& marker = program.markers[m];
    for (int i = 0; i < (marker.sees_equally ? 1 : 9); ++i) {
      set(marker.whitener + i, readings[m].whitener(i / 3, i % 3));
    }
    set_vector(marker.point, readings[m].point_in_station);
    size_t own = 0;
    for (const MarkerTerm& term : shot.terms.markers) {
      if (term.marker == readings[m].id) set_vector(marker.terms[own++].data, term.direction);
    }
    own = 0;
    for (const SightTerm& term : shot.terms.sights) {
      if (!BelongsTo(term, readings[m])) continue;
      const int first = marker.sights[own++].data;
      set(first, term.factor);
      set_vector(first + 1, term.instrument);
      set_vector(first + 4, term.axis);
      set(first + 7, term.centre);
      set(first + 8, term.width);
    }
  }
  for (size_t i = 0; i < program.growth.size(); ++i) set(program.growth[i].data, shot.terms.base[i].factor);
  for (size_t i = 0; i < program.station.size(); ++i) {
    set_matrix(program.station[i].data, shot.terms.station[i].gradient);
    set_vector(program.station[i].data + 9, shot.terms.station[i].offset);
  }
}

}  // namespace sagitta

#include "models/effects/effect.h"

#include <algorithm>
#include <charconv>
#include <system_error>

template class std::vector<sagitta::EffectSpec>;

namespace sagitta {

ShotTerms::ShotTerms() = default;
ShotTerms::ShotTerms(const ShotTerms&) = default;
ShotTerms::ShotTerms(ShotTerms&&) noexcept = default;
ShotTerms& ShotTerms::operator=(const ShotTerms&) = default;
ShotTerms& ShotTerms::operator=(ShotTerms&&) noexcept = default;
ShotTerms::~ShotTerms() = default;

std::string EffectSpec::Path() const {
  std::string path = "effect/" + effect;
  if (!settings.empty()) {
    path += "[";
    for (auto it = settings.begin(); it != settings.end(); ++it) {
      path += (it == settings.begin() ? "" : ",") + it->first + "=" + it->second;
    }
    path += "]";
  }
  return path + "/" + target;
}

template <typename Number>
std::optional<Number> SettingAs(const std::string& text) {
  Number number = 0;
  const char* end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, number);
  if (read.ec != std::errc() || read.ptr != end) return std::nullopt;
  return number;
}
template std::optional<int> SettingAs(const std::string& text);
template std::optional<double> SettingAs(const std::string& text);

// What is no number is 0: readers refuse it.
int EffectSpec::IntegerSetting(const std::string& name, int otherwise) const {
  const auto found = settings.find(name);
  return found == settings.end() ? otherwise : SettingAs<int>(found->second).value_or(0);
}

double EffectSpec::NumberSetting(const std::string& name, double otherwise) const {
  const auto found = settings.find(name);
  return found == settings.end() ? otherwise : SettingAs<double>(found->second).value_or(0.0);
}

std::string EffectSpec::TextSetting(const std::string& name, const std::string& otherwise) const {
  const auto found = settings.find(name);
  return found == settings.end() ? otherwise : found->second;
}

EffectDriver EffectDefinition::DrivenBy(const EffectSpec& spec) const {
  const std::string by = spec.TextSetting("by", "");
  if (by == "time_s") return EffectDriver::kTime;
  if (by == "temperature_K") return EffectDriver::kTemperature;
  return driven_by.driver_;
}

bool EffectDefinition::IsOfAMoment() const {
  return std::any_of(settings.begin(), settings.end(),
                     [](const SettingDefinition& setting) { return setting.kind == SettingDefinition::Kind::kMoment; });
}

std::string JointThatSlides(const Chain& chain, const EffectDefinition& definition, const EffectSpec& spec) {
  const auto slides = [&](const std::string& joint) {
    return chain.joints[chain.FindJoint(joint)].type == JointType::kPrismatic;
  };
  const bool turns = definition.target == EffectTarget::kJoint && definition.on_slide == OnSlide::kUndefined;
  if (turns && slides(spec.target)) return spec.target;
  for (const SettingDefinition& setting : definition.settings) {
    const auto stated = spec.settings.find(setting.name);
    if (setting.turns && stated != spec.settings.end() && slides(stated->second)) return stated->second;
  }
  return "";
}

bool SettingDefinition::MeansSomethingFor(const EffectSpec& spec) const {
  const size_t equals = only_with.find('=');
  if (equals == std::string::npos) return true;
  const auto found = spec.settings.find(only_with.substr(0, equals));
  if (found == spec.settings.end()) return false;
  const std::string values = "|" + only_with.substr(equals + 1) + "|";
  return values.find("|" + found->second + "|") != std::string::npos;
}

// A joint's slots stand right after its transform, the foot's at the very start.
void AddTiltSlots(int joint, Chain* chain) {
  const int first = joint < 0 ? 0 : chain->JointTransform(joint) + 1;
  if (first < chain->num_transforms() && chain->transforms[first].tilt_slot) return;
  for (int axis = 0; axis < 3; ++axis) {
    ElementaryTransform slot;
    slot.motion = Motion::kRotation;
    slot.axis = static_cast<Axis>(axis);
    slot.tilt_slot = true;
    chain->transforms.insert(chain->transforms.begin() + first + axis, slot);
  }
}

int TiltSlot(const Chain& chain, int joint, Axis axis) {
  return (joint < 0 ? 0 : chain.JointTransform(joint) + 1) + static_cast<int>(axis);
}

Axis AxisOf(const Chain& chain, int joint) { return chain.transforms[chain.JointTransform(joint)].axis; }

Axis OtherAxis(Axis axis, int which) { return static_cast<Axis>((static_cast<int>(axis) + 1 + which) % 3); }

}  // namespace sagitta

#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace sagitta {

// All of the text as a number, int or double, with a decimal point in every locale; nothing if it is none.
template <typename Number>
std::optional<Number> SettingAs(const std::string& text);
extern template std::optional<int> SettingAs(const std::string& text);
extern template std::optional<double> SettingAs(const std::string& text);

// One use of an effect, as a robot file states it.
struct EffectSpec {
  std::string effect;
  std::string target;                           // "base", "robot" where there is only one
  std::map<std::string, std::string> settings;  // order: 2, driver: A2, by: torque, after_s: 120
  std::vector<double> values;                   // SI, one per parameter
  // SI, one per parameter, of priors about 0, no effect; 0: none. Empty: none at all. What data determine poorly of an
  // effect stays of the size that such an effect has.
  std::vector<double> prior_sigmas = {};

  // effect/joint_harmonic[order=1]/A3
  std::string Path() const;
  int IntegerSetting(const std::string& name, int otherwise) const;
  double NumberSetting(const std::string& name, double otherwise) const;
  std::string TextSetting(const std::string& name, const std::string& otherwise) const;
};

}  // namespace sagitta

// Compiled once (effect.cc), not in each file that has a list of them.
extern template class std::vector<sagitta::EffectSpec>;

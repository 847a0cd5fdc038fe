// A hidden effect as the sealed answer says it.
#pragma once

#include <nlohmann/json.hpp>

#include "tests/hidden_effects/generator/hidden_effect.h"

namespace hidden {

inline nlohmann::json AnswerOf(const HiddenEffect& effect) {
  nlohmann::json entry = {{"kind", effect.kind}, {"in_catalogue", effect.in_catalogue}, {"target", effect.target}};
  entry["settings"] = effect.settings;
  entry["parameters"] = nlohmann::json::object();
  for (const auto& [name, value] : effect.parameters) entry["parameters"][name] = value;
  if (!effect.words.empty()) entry["words"] = effect.words;
  if (!effect.further_orders.empty()) entry["further_orders"] = effect.further_orders;
  return entry;
}

}  // namespace hidden

// What an experiment can choose between, each with the words that files, flags and results use for it. Readers check
// the word once (FindChoice); everything behind them asks the enum.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace sagitta {

// What the fit weighs rows by. Others than kSigma: estimator/noise/weighting.h.
enum class Weights { kSigma, kEqual, kEq14 };

// What the intervals are made of.
enum class CovarianceKind { kModel, kSandwich, kBootstrap, kProfile };

// What a bootstrap draws: errors from the noise, or whole configurations; kAutomatic: these where there are enough.
enum class BootstrapKind { kAutomatic, kParametric, kConfigurations };

// What a row's whitened distance costs (estimator/noise/robust.h).
enum class LossKind { kNone, kHuber, kCauchy };

// Which residuals share one standard deviation.
enum class ResidualGroup { kAxis, kConfigAxis, kMarkerAxis, kStationAxis, kResidual };

// Which end of the compensator's spring a marker sits on.
enum class SpringEnd { kLever, kAnchor, kNone };

// The word of each, "" of no enumerator. A switch over all of them: where one is forgotten the build fails. Choices
// that stand elsewhere have a WordOf next to them, and what is below.
std::string WordOf(Weights weights);
std::string WordOf(CovarianceKind kind);
std::string WordOf(BootstrapKind kind);
std::string WordOf(LossKind kind);
std::string WordOf(ResidualGroup group);
std::string WordOf(SpringEnd end);

// All that can be chosen, in the order of the enum, which counts from 0.
template <typename Choice>
std::vector<Choice> ChoicesOf() {
  std::vector<Choice> choices;
  for (int i = 0; !WordOf(static_cast<Choice>(i)).empty(); ++i) choices.push_back(static_cast<Choice>(i));
  return choices;
}

// All words of a choice, for messages.
template <typename Choice>
std::vector<std::string> WordsOf() {
  std::vector<std::string> words;
  for (const Choice choice : ChoicesOf<Choice>()) words.push_back(WordOf(choice));
  return words;
}

// The choice that a word names; empty where it names none.
template <typename Choice>
std::optional<Choice> FindChoice(const std::string& word) {
  for (const Choice choice : ChoicesOf<Choice>()) {
    if (WordOf(choice) == word) return choice;
  }
  return std::nullopt;
}

}  // namespace sagitta

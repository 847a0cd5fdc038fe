// What an experiment can choose between, each with the words that files, flags and results use for it. Readers check
// the word once (FindChoice); everything behind them asks the enum.
#pragma once

#include <iterator>
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

// The words of a choice, in the order of its enum.
template <typename Choice>
struct ChoiceWords;
template <>
struct ChoiceWords<Weights> {
  static constexpr const char* kWords[] = {"sigma", "equal", "eq14"};
};
template <>
struct ChoiceWords<CovarianceKind> {
  static constexpr const char* kWords[] = {"model", "sandwich", "bootstrap", "profile"};
};
template <>
struct ChoiceWords<BootstrapKind> {
  static constexpr const char* kWords[] = {"automatic", "parametric", "configurations"};
};
template <>
struct ChoiceWords<LossKind> {
  static constexpr const char* kWords[] = {"none", "huber", "cauchy"};
};
template <>
struct ChoiceWords<ResidualGroup> {
  static constexpr const char* kWords[] = {"axis", "config-axis", "marker-axis", "station-axis", "residual"};
};
template <>
struct ChoiceWords<SpringEnd> {
  static constexpr const char* kWords[] = {"lever", "anchor", "none"};
};

// All words of a choice, for messages.
template <typename Choice>
std::vector<std::string> WordsOf() {
  return {std::begin(ChoiceWords<Choice>::kWords), std::end(ChoiceWords<Choice>::kWords)};
}

// The word of one choice.
template <typename Choice>
std::string WordOf(Choice choice) {
  return ChoiceWords<Choice>::kWords[static_cast<size_t>(choice)];
}

// The choice that a word names; empty where it names none.
template <typename Choice>
std::optional<Choice> FindChoice(const std::string& word) {
  const std::vector<std::string> words = WordsOf<Choice>();
  for (size_t i = 0; i < words.size(); ++i) {
    if (words[i] == word) return static_cast<Choice>(i);
  }
  return std::nullopt;
}

}  // namespace sagitta

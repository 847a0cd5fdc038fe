#include "problems/experiment.h"

namespace sagitta {

Experiment::Experiment() = default;
Experiment::Experiment(const Experiment&) = default;
Experiment::Experiment(Experiment&&) noexcept = default;
Experiment& Experiment::operator=(const Experiment&) = default;
Experiment& Experiment::operator=(Experiment&&) noexcept = default;
Experiment::~Experiment() = default;

std::string WordOf(MarkerPlace::Kind kind) {
  switch (kind) {
    case MarkerPlace::Kind::kFlange:
      return "flange";
    case MarkerPlace::Kind::kBase:
      return "base";
    case MarkerPlace::Kind::kWorld:
      return "world";
    case MarkerPlace::Kind::kJoint:
      break;
  }
  return "";
}

MarkerPlace MarkerPlace::Named(const std::string& word) {
  const std::optional<Kind> place = FindChoice<Kind>(word);
  return place ? MarkerPlace{*place, ""} : MarkerPlace{Kind::kJoint, word};
}

std::string MarkerPlace::Word() const { return kind == Kind::kJoint ? joint : WordOf(kind); }

std::vector<std::string> MarkerPlace::Words() { return WordsOf<Kind>(); }

}  // namespace sagitta

#include "problems/experiment.h"

#include <algorithm>
#include <iterator>

namespace sagitta {

Experiment::Experiment() = default;
Experiment::Experiment(const Experiment&) = default;
Experiment::Experiment(Experiment&&) noexcept = default;
Experiment& Experiment::operator=(const Experiment&) = default;
Experiment& Experiment::operator=(Experiment&&) noexcept = default;
Experiment::~Experiment() = default;

namespace {

constexpr const char* kPlaces[] = {"flange", "base", "world"};  // in the order of MarkerPlace::Kind

}  // namespace

MarkerPlace MarkerPlace::Named(const std::string& word) {
  const auto found = std::find(std::begin(kPlaces), std::end(kPlaces), word);
  if (found == std::end(kPlaces)) return {Kind::kJoint, word};
  return {static_cast<Kind>(found - std::begin(kPlaces)), ""};
}

std::string MarkerPlace::Word() const { return kind == Kind::kJoint ? joint : kPlaces[static_cast<int>(kind)]; }

std::vector<std::string> MarkerPlace::Words() { return {std::begin(kPlaces), std::end(kPlaces)}; }

}  // namespace sagitta

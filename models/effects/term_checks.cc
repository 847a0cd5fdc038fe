#include "models/effects/term_checks.h"

#include <cmath>
#include <stdexcept>

namespace sagitta {
namespace {

class TermChecker {
 public:
  TermChecker(int parameters, int transforms, int markers, const std::string& effect)
      : parameters_(parameters), transforms_(transforms), markers_(markers), effect_(effect) {}

  void Check(const SlotTerm& term) const { CheckMotion(term.transform, term.parameter, term.factor); }
  void Check(const ElasticTerm& term) const {
    CheckMotion(term.transform, term.parameter, term.factor);
    CheckNumber(term.width);
    CheckNumber(term.centre);
  }
  void Check(const SagTerm& term) const {
    CheckMotion(term.transform, term.parameter, 1.0);
    for (const AppliedWrench& wrench : term.wrenches) Check(wrench);
  }
  void Check(const WrenchTerm& term) const {
    CheckParameter(term.parameter);
    for (const AppliedWrench& wrench : term.wrenches) Check(wrench);
  }
  void Check(const MarkerTerm& term) const {
    CheckParameter(term.parameter);
    CheckPlace("marker", term.marker, markers_);
    CheckNumber(term.direction.sum());
  }
  void Check(const BaseTerm& term) const {
    CheckParameter(term.parameter);
    CheckNumber(term.factor);
  }
  void Check(const StationTerm& term) const {
    CheckParameter(term.parameter);
    CheckNumber(term.gradient.sum() + term.offset.sum());
  }
  void Check(const SightTerm& term) const {
    CheckParameter(term.parameter);
    if (term.marker >= 0) CheckPlace("marker", term.marker, markers_);
    CheckNumber(term.factor + term.instrument.sum() + term.axis.sum() + term.centre + term.width);
  }
  void Check(const StatedTorque& stated) const {
    CheckPlace("transform", stated.transform, transforms_);
    CheckNumber(stated.torque);
  }

 private:
  void Check(const AppliedWrench& wrench) const {
    CheckPlace("frame", wrench.frame, transforms_ + 1);
    CheckNumber(wrench.point.sum() + wrench.force.sum() + wrench.moment.sum());
  }
  void CheckMotion(int transform, int parameter, double factor) const {
    CheckPlace("transform", transform, transforms_);
    CheckParameter(parameter);
    CheckNumber(factor);
  }
  void CheckParameter(int parameter) const { CheckPlace("parameter", parameter, parameters_); }
  void CheckPlace(const char* what, int place, int count) const {
    if (place >= 0 && place < count) return;
    Fail(std::string("names ") + what + " " + std::to_string(place) + ", there are " + std::to_string(count) +
         " (numbers begin at 0)");
  }
  void CheckNumber(double value) const {
    if (!std::isfinite(value)) Fail("has a number that is none");
  }
  [[noreturn]] void Fail(const std::string& what) const {
    throw std::invalid_argument("effect '" + effect_ + "': a term that apply adds " + what);
  }

  int parameters_, transforms_, markers_;
  const std::string& effect_;
};

template <typename Term>
void CheckAll(const std::vector<Term>& terms, const TermChecker& checker) {
  for (const Term& term : terms) checker.Check(term);
}

}  // namespace

void CheckTerms(const ShotTerms& terms, int parameters, int transforms, int markers, const std::string& effect) {
  const TermChecker checker(parameters, transforms, markers, effect);
  CheckAll(terms.slots, checker);
  CheckAll(terms.elastic, checker);
  CheckAll(terms.sags, checker);
  CheckAll(terms.wrenches, checker);
  CheckAll(terms.markers, checker);
  CheckAll(terms.base, checker);
  CheckAll(terms.station, checker);
  CheckAll(terms.sights, checker);
  CheckAll(terms.torques, checker);
}

}  // namespace sagitta

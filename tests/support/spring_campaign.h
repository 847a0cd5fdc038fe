// A KR 270 that carries a spring which its robot file does not state.
#pragma once

#include <string>
#include <vector>

#include "tests/support/loaded_kr270.h"

namespace sagitta::test {

inline LoadedTruth WithSpring() {
  LoadedTruth truth;
  truth.base_rotvec = {{0.0, 0.0, 0.3}};
  truth.spring = SpringTruth();
  truth.spring->Kc = 1.5e5;
  return truth;
}

// Each configuration without and with a load, or without one only; the compliances of these joints are estimated, of
// the others nothing is stated.
inline CalibrationProblem SpringCampaign(const LoadedTruth& truth, bool loaded,
                                         const std::vector<std::string>& compliant) {
  LoadedDesign design;
  design.configurations = 60;
  design.stations = 1;
  if (!loaded) design.loads.clear();
  Measurements data = LoadedRows(design, truth);
  Measure(ExactPoints(truth, data), design.sigma, 5, &data);
  LoadedTruth believed = truth;
  believed.spring.reset();
  LoadedSetup setup = SetupFor(believed);
  setup.experiment.estimate.compliance = {compliant.empty() ? Selection::Kind::kNone : Selection::Kind::kList,
                                          compliant};
  setup.experiment.validation.kind = ValidationSpec::Kind::kFraction;
  setup.experiment.validation.fraction = 0.2;
  return MakeCalibrationProblem(setup.robot, data, setup.experiment);
}

}  // namespace sagitta::test

#include "estimator/calibration/load_centres.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/loaded_kr270.h"

namespace sagitta::load_centres_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// 250 kg at p, weighed 50 kg short, hang 200 mm off: 60 000 kg mm in the stated mass's moment are 240 mm of it.
TEST(LoadCentres, AreThoseOfTheWholeMass) {
  const test::LoadedTruth truth;
  Measurements data = test::LoadedRows(test::LoadedDesign(), truth);
  test::Measure(test::ExactPoints(truth, data), 0.0, 1, &data);
  const test::LoadedSetup setup = test::SetupFor(truth);
  const CalibrationProblem problem = MakeCalibrationProblem(setup.robot, data, setup.experiment);
  const auto words = [&problem](const std::vector<EffectSpec>& effects) {
    const CalibrationProblem extended = problem.WithEffects(effects);
    return LoadCentresInWords(extended, extended.parameters);
  };
  const double added = 50.0 * test::kWeightOf250Kg / 9.80665 / 250.0;  // in the stated mass's share
  const EffectSpec heavier{"payload", "V250", {}, {added}}, off{"load_com", "V250", {}, {0.24, 0.0, -0.12}};
  EXPECT_THAT(words({heavier, off}), ElementsAre(HasSubstr("(200, 0, -100) mm off the stated point")));
  EXPECT_THAT(words({off}), IsEmpty());
  EXPECT_THAT(words({heavier}), IsEmpty());
}

}  // namespace
}  // namespace sagitta::load_centres_test

// What flagged rows share: a region of the workspace, a range of a joint, a marker; or nothing.
#include "estimator/noise/outliers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/noise_experiment.h"

namespace sagitta::outliers_test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

struct Scene {
  CalibrationProblem problem;
  ParameterSet parameters;

  Scene() : problem(Make()), parameters(problem.parameters) {
    for (int s = 0; s < 2; ++s) {
      const test::Kr270Truth truth;
      parameters.SetBaseInStation(s, {test::BaseRotation(truth, s), truth.base_xyz[s]});
    }
  }
  static CalibrationProblem Make() {
    test::Kr270Design design;
    design.configurations = 100;
    Measurements data = test::DesignMeasurements(design);
    test::MeasureKr270(test::Kr270Truth(), design.sigma, 3, &data);
    return test::Kr270ProblemOf(data, Experiment());
  }
  // At most 24 rows for which `is_in` holds, every third row looked at.
  template <typename IsIn>
  std::vector<std::string> Shared(const IsIn& is_in) const {
    std::vector<Outlier> outliers;
    for (size_t i = 0; i < problem.data().observations.size() && outliers.size() < 24; i += 3) {
      const int k = static_cast<int>(i + (i / 3) % 3);  // all markers
      if (is_in(k)) outliers.push_back({k, 1e-3, 10.0, -1});
    }
    EXPECT_GE(outliers.size(), 15u);
    return WhatTheyShare(problem, parameters, outliers, 0.01);
  }
};

TEST(WhatOutliersShare, NothingWhereTheyLieAtRandom) {
  const Scene scene;
  EXPECT_THAT(scene.Shared([](int k) { return k % 4 != 0; }), IsEmpty());
}

TEST(WhatOutliersShare, ARegionOfTheWorkspace) {
  const Scene scene;
  const auto words =
      scene.Shared([&](int k) { return scene.problem.data().observations[k].point_in_station.z() > 2.4; });
  EXPECT_THAT(words, Contains(HasSubstr("base z from 2")));
  EXPECT_THAT(words, Not(Contains(HasSubstr("marker"))));
}

TEST(WhatOutliersShare, ARangeOfAJointAndAMarker) {
  const Scene scene;
  const Measurements& data = scene.problem.data();
  const auto joint = scene.Shared([&](int k) { return data.ConfigurationOf(data.observations[k]).q[3] > 1.4; });
  EXPECT_THAT(joint, Contains(HasSubstr("joint A4 from ")));
  const auto marker = scene.Shared([&](int k) { return data.observations[k].marker == 1; });
  EXPECT_THAT(marker, Contains(HasSubstr("marker P2")));
}

}  // namespace
}  // namespace sagitta::outliers_test

// A base plate that moves and turns with the air's temperature over three days, which time effects would be named for.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "estimator/diagnosis/diagnose.h"
#include "estimator/diagnosis/learnt_model.h"
#include "estimator/report/diagnosis_words.h"
#include "tests/support/moved_kr270.h"

namespace sagitta::warming_base_test {
namespace {

using ::testing::HasSubstr;

constexpr double kSigma = 2e-5, kDay = 86400.0;           // m, s
const Vector3<double> kPerKelvin(20e-6, -15e-6, 8e-6);    // m
const Vector3<double> kTurnPerKelvin(6e-6, 4e-6, -5e-6);  // rad
constexpr int kConfigurations = 60;

// Degrees above the mean: days that differ, and their hours.
double Air(double time) { return 4.0 * std::sin(2.0 * M_PI * time / kDay) + 2.0 * std::sin(2.3 * time / kDay); }

TEST(WarmingBase, IsSaidToGoWithTemperature) {
  const Measurements data = [] {
    Measurements rows = test::DesignMeasurements(test::CampaignOf(kConfigurations, 1, kSigma, 31));
    test::MeasureKr270(test::Kr270Truth(), kSigma, 32, &rows);
    for (Shot& shot : rows.shots) {
      shot.has_time = shot.has_temperature = true;
      // Twenty poses a day, eight hours long.
      shot.time = kDay * (shot.configuration / 20) + 1440.0 * (shot.configuration % 20);
      shot.temperature = 22.0 + Air(shot.time);
    }
    for (Observation& row : rows.observations) {
      const double warmer = Air(rows.shots[row.shot].time);
      const Eigen::Vector3d moved = row.point_in_station + warmer * kTurnPerKelvin.cross(row.point_in_station);
      row.point_in_station = moved + warmer * kPerKelvin;
    }
    return rows;
  }();
  Experiment experiment;
  experiment.validation.kind = ValidationSpec::Kind::kFraction;
  experiment.validation.fraction = 0.3;
  const Diagnosis d = Diagnose(MakeCalibrationProblem(test::Kr270Robot(), data, experiment), DiagnosisOptions());
  EXPECT_EQ(d.verdict, DiagnosisVerdict::kUnknown) << VerdictInWords(d);
  EXPECT_THAT(d.unexplained.what.words, HasSubstr("with temperature"));
  ASSERT_TRUE(d.learnt);
  EXPECT_LT(d.learnt->model.estimate.validation.rms, 0.5 * d.baseline.estimate.validation.rms);
}

}  // namespace
}  // namespace sagitta::warming_base_test

// What is said of the noise that is found.
#include "estimator/report/diagnosis_noise_words.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estimator/diagnosis/noise_finding.h"

namespace sagitta::diagnosis_noise_words_test {
namespace {

using testing::HasSubstr;

TEST(DiagnosisNoiseWords, JointsThatDeviateMoreThanStatedAreNotCalledUndeclared) {
  NoiseFinding noise;
  noise.turn.sigma = 13.8e-6;
  noise.is_finding = true;
  EXPECT_THAT(NoiseInWords(noise), HasSubstr("was not declared"));
  noise.turn.stated = 3e-6;
  EXPECT_THAT(NoiseInWords(noise), HasSubstr("is found; 3 urad are stated."));
  EXPECT_EQ(WrongNoiseInWords(noise), "the joints deviate more than is stated");
  noise.is_distinguished_from_pose = false;
  EXPECT_THAT(NoiseInWords(noise), HasSubstr("and so would any error that follows the pose"));
  noise.turn.stated = 0.0, noise.is_distinguished_from_pose = true, noise.is_bound = true;
  EXPECT_THAT(NoiseInWords(noise), HasSubstr("would explain what is left"));
  noise.travel = {25e-6, 20e-6, 31e-6, 0.0};
  EXPECT_THAT(NoiseInWords(noise), HasSubstr("of the joints that turn and 25 um (95 %: 20 to 31) of those that slide"));
}

}  // namespace
}  // namespace sagitta::diagnosis_noise_words_test

// What progress lines say: which phase, and how long the rest will need.
#include "tools/progress.h"

#include <gtest/gtest.h>

namespace sagitta::progress_test {
namespace {

TEST(ProgressMeter, SaysThePhaseAndTheTimeLeft) {
  ProgressMeter meter({{"aligning", 1.0}, {"solving", 3.0}, {"comparing", 4.0}});
  EXPECT_EQ(meter.Line(0.0), "");
  meter.Say("aligning the robot", 0.0);
  EXPECT_EQ(meter.Line(0.5), "phase 1 of 3: aligning the robot ...");
  meter.Say("solving for 30 unknowns", 5.0);  // an eighth of all needed 5 s: 40 s together
  EXPECT_EQ(meter.Line(5.0), "phase 2 of 3: solving for 30 unknowns (about 35 s left)");
  EXPECT_EQ(meter.Line(18.0), "phase 2 of 3: solving for 30 unknowns (about 22 s left)");
  // Longer than its share: half of all needed 60 s or more.
  EXPECT_EQ(meter.Line(60.0), "phase 2 of 3: solving for 30 unknowns (about 60 s left)");
  meter.Say("comparing parts", 100.0);  // half
  EXPECT_EQ(meter.Line(100.0), "phase 3 of 3: comparing parts (about 2 min left)");
}

TEST(ProgressMeter, CountsWithinAPhase) {
  ProgressMeter meter({{"aligning", 1.0}, {"bootstrap", 9.0}});
  meter.Say("aligning", 0.0);
  meter.Say("bootstrap: 400 of 900", 20.0);  // 1 + 4 of 10
  EXPECT_EQ(meter.Line(20.0), "phase 2 of 2: bootstrap: 400 of 900 (about 20 s left)");
}

TEST(ProgressMeter, WhatIsCountedIsExpectedFromItsFirstSeconds) {
  ProgressMeter meter({{"aligning", 1.0}, {"trials", 99.0}});
  meter.Say("aligning", 0.0);
  meter.Say("trials: 10 of 990", 4.0);  // 1 + 1 of 100
  EXPECT_EQ(meter.Line(4.0), "phase 2 of 2: trials: 10 of 990 (about 3 min left)");
}

TEST(ProgressMeter, APhaseThatIsSaidAgainDoesNotTakeLonger) {
  ProgressMeter meter({{"best", 1.0}, {"accuracy", 1.0}});
  meter.Say("best 40 poses", 0.0);
  meter.Say("accuracy of 20 poses", 10.0);
  meter.Say("accuracy of 28 poses", 15.0);
  EXPECT_EQ(meter.Line(15.0), "phase 2 of 2: accuracy of 28 poses (about 5 s left)");
}

TEST(ProgressMeter, WhatBelongsToNoPhaseBelongsToThePresentOne) {
  ProgressMeter meter({{"weighing", 1.0}, {"fitting", 1.0}});
  meter.Say("weighing 20 explanations", 0.0);
  meter.Say("once more with joints that deviate", 3.0);
  EXPECT_EQ(meter.Line(3.0), "phase 1 of 2: once more with joints that deviate (3 s so far)");
  meter.Say("fitting", 4.0);
  meter.Say("weighing 20 explanations", 5.0);  // the phase never goes back
  EXPECT_EQ(meter.Line(6.0), "phase 2 of 2: weighing 20 explanations (about 2 s left)");
}

TEST(ProgressMeter, WithoutPhasesTheWordsStandAlone) {
  ProgressMeter meter({});
  meter.Say("[##..] 100 of 400 trials", 10.0);
  EXPECT_EQ(meter.Line(10.0), "[##..] 100 of 400 trials (about 30 s left)");
}

}  // namespace
}  // namespace sagitta::progress_test

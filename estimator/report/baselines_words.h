// Why the papers' methods stop, or cannot run, and what their intervals leave out.
#pragma once

#include <string>

#include "estimator/least_squares/gauss_newton.h"

namespace sagitta {

// "a step's linear system is singular", …
const char* StepOutcomeInWords(StepOutcome outcome);

// Why a method has not run.
std::string NotRunBecause(const std::string& why);
std::string NoDifferences();
std::string KnowsAxesOnly(const std::string& method);
std::string NothingElastic();
std::string MarkersOnSeveralLinks();
std::string SomeMarkersHeld();
std::string NoFullPose();
std::string FewFullPoses(size_t poses, int unknowns);
std::string MarkerOffFlange(const std::string& marker);
std::string HeldInFirstStage(const std::string& parameter);

// A method that knows no bounds put a parameter below its own.
std::string NoRobotHasThis(const std::string& method, const std::string& parameter);

std::string PoseEquationsSingular();
std::string IdentificationSingular();
std::string PosesStandStill();

// What the intervals of a method leave out.
std::string DifferencesAssumeTheRestExact();
std::string PreloadWentIntoGeometry();
std::string BiasIsIgnored();

}  // namespace sagitta

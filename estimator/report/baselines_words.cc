#include "estimator/report/baselines_words.h"

namespace sagitta {

const char* StepOutcomeInWords(StepOutcome outcome) {
  switch (outcome) {
    case StepOutcome::kTaken:
      return "a step was made";
    case StepOutcome::kSingular:
      return "a step's linear system is singular";
    case StepOutcome::kNoDescent:
      return "no step lowers the cost, however short: the start is too far off";
    case StepOutcome::kEquilibriumDiverged:
      return "the equilibrium of a loaded shot diverges";
  }
  return "";
}

std::string NotRunBecause(const std::string& why) { return "not run: " + why; }

std::string NoDifferences() {
  return "no marker is measured loaded and unloaded at one visit, so there is no difference";
}

std::string NothingElastic() { return "no compliance and no compensator is estimated"; }

std::string MarkersOnSeveralLinks() { return "the markers ride on different links, they are no rigid body"; }

std::string SomeMarkersHeld() {
  return "some marker coordinates are fixed or held and others free; full-pose wants all or none";
}

std::string NoFullPose() { return "no shot sees three markers that are not on one line; there is no full pose"; }

std::string FewFullPoses(size_t poses, int unknowns) {
  return std::to_string(poses) + " full poses are fewer equations than " + std::to_string(unknowns) + " unknowns";
}

std::string MarkerOffFlange(const std::string& marker) {
  return "marker '" + marker + "' is not on the flange, and paper 000 eq. (8) knows no other";
}

std::string HeldInFirstStage(const std::string& parameter) {
  return parameter +
         " is held, but stage 1 of the two-step method as printed (paper 000, eq. 15) solves for every base pose and "
         "marker; use two-step";
}

std::string NoRobotHasThis(const std::string& method, const std::string& parameter) {
  return method + " puts " + parameter + " below 0, where no robot is, and no file that says so could be read again; " +
         "use --method=joint, which keeps to the bound, or hold it (--fixed=" + parameter + ")";
}

std::string PoseEquationsSingular() {
  return "the pose equations are singular, or the equilibrium of a loaded shot diverges";
}

std::string DifferencesAssumeTheRestExact() {
  return "its intervals of compliances and compensator assume geometry, base poses and markers of the unloaded rows to "
         "be exact";
}

std::string PreloadWentIntoGeometry() {
  return "what bends the unloaded arm (the spring's preload, the tool) went into the geometry of its first stage";
}

std::string BiasIsIgnored() { return "the intervals ignore the bias of this variant of the two-step method"; }

std::string IdentificationSingular() { return "the identification Jacobian is singular at the start"; }

std::string PosesStandStill() { return "the pose least squares stands still"; }

std::string KnowsAxesOnly(const std::string& method) {
  return method + " knows standard deviations per axis, not an instrument's covariances";
}

}  // namespace sagitta

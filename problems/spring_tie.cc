#include "problems/spring_tie.h"

#include <optional>

#include "problems/calibration_problem.h"
#include "problems/problem_checks.h"

namespace sagitta {
namespace {

std::optional<SpringEnd> StatedEnd(const CalibrationProblem& problem, int marker) {
  const auto spec = problem.experiment().markers.find(problem.data().markers[marker]);
  return spec == problem.experiment().markers.end() ? std::nullopt : spec->second.spring;
}

// The marker that is this end of the spring; -1: none, or no single one.
int FindEnd(const CalibrationProblem& problem, SpringEnd end, int frame) {
  int stated = -1, candidate = -1, candidates = 0;
  for (size_t m = 0; m < problem.data().markers.size(); ++m) {
    const std::optional<SpringEnd> says = StatedEnd(problem, static_cast<int>(m));
    const std::string key = "markers." + problem.data().markers[m] + ".spring";
    if (says == end) {
      const std::string word = WordOf(end);
      if (stated >= 0)
        FailProblem(problem, key, "the spring has one " + word + " only", "leave one marker its " + word);
      stated = static_cast<int>(m);
    }
    if (says || problem.marker_frames()[m] != frame) continue;
    candidate = static_cast<int>(m);
    ++candidates;
  }
  if (stated >= 0) return stated;
  return candidates == 1 ? candidate : -1;
}

// How well a marker sits on its end, m; nothing where not stated.
std::optional<double> SigmaOfEnd(const CalibrationProblem& problem, int marker) {
  const auto spec = problem.experiment().markers.find(problem.data().markers[marker]);
  return spec == problem.experiment().markers.end() ? std::nullopt : spec->second.spring_sigma;
}

// The frame before the compensator's joint on which an unnamed anchor is looked for: of the joint before, or the base.
int FrameBefore(const Chain& chain, int joint_transform) {
  int frame = chain.BaseFrame();
  for (int j = 0; j < chain.num_joints(); ++j) {
    if (chain.JointTransform(j) < joint_transform) frame = std::max(frame, chain.FrameAfterJoint(j));
  }
  return frame;
}

// A spring end that is named although there is no spring.
void CheckNoEnds(const CalibrationProblem& problem) {
  for (const auto& [name, spec] : problem.experiment().markers) {
    if (!spec.spring || *spec.spring == SpringEnd::kNone) continue;
    FailProblem(problem, "markers." + name + ".spring", "the robot has no gravity_compensator",
                "describe it in the robot file");
  }
}

void CheckFrames(const CalibrationProblem& problem, const SpringTie& tie, int joint) {
  const Chain& chain = problem.robot().chain;
  const auto fail = [&](int marker, const std::string& what, const std::string& hint) {
    FailProblem(problem, "markers." + problem.data().markers[marker] + ".on", what, hint);
  };
  const int spring_joint = problem.robot().gravity_compensator->joint;
  if (problem.marker_frames()[tie.lever_marker] != chain.FrameAfterJoint(spring_joint)) {
    fail(tie.lever_marker, "the lever end turns with the compensator's joint",
         "state on: " + chain.joints[spring_joint].name);
  }
  const int from = problem.marker_frames()[tie.anchor_marker];
  if (from > joint) fail(tie.anchor_marker, "the anchor lies before the compensator's joint", "state the joint before");
  for (int e = from; e < joint; ++e) {
    if (!chain.transforms[e].has_joint()) continue;
    fail(tie.anchor_marker, "a joint moves between the anchor and the compensator's joint",
         "tie a marker on the link before it");
  }
}

// The chain from the anchor's frame to the joint, and which parameters are on it.
void FillChain(const CalibrationProblem& problem, int joint, SpringTie* tie) {
  const Chain& chain = problem.robot().chain;
  const int from = problem.marker_frames()[tie->anchor_marker];
  tie->anchors.between.transforms.assign(chain.transforms.begin() + from, chain.transforms.begin() + joint);
  tie->anchors.axis = chain.transforms[joint];
  tie->anchors.axis.nominal = problem.robot().gravity_compensator->zero.value_or(tie->anchors.axis.nominal);
  tie->errors.assign(joint - from, -1);
  const std::vector<ModelParameter>& parameters = problem.model().parameters();
  for (int i = 0; i < static_cast<int>(parameters.size()); ++i) {
    const ModelParameter& p = parameters[i];
    if (p.law == ParameterLaw::kGeometry && p.index >= from && p.index < joint) tie->errors[p.index - from] = i;
    if (p.law == ParameterLaw::kCompensator && p.index < 3) tie->geometry[p.index] = i;
  }
}

}  // namespace

Eigen::Matrix3d CovarianceOfEnds(const Eigen::Vector3d& geometry, const SpringTie& tie) {
  const double lever = tie.lever_sigma, anchor = tie.anchor_sigma;
  const Eigen::Matrix3d along = Eigen::Vector3d(lever * lever, anchor * anchor, anchor * anchor).asDiagonal();
  const Eigen::Vector3d turn = lever / geometry[0] * Eigen::Vector3d(0.0, -geometry[2], geometry[1]);
  return along + turn * turn.transpose();
}

void TieSpringMarkers(CalibrationProblem* problem) {
  if (!problem->robot().gravity_compensator) return CheckNoEnds(*problem);
  const Chain& chain = problem->robot().chain;
  const GravityCompensator& spring = *problem->robot().gravity_compensator;
  const int joint = chain.JointTransform(spring.joint);
  SpringTie tie;
  tie.lever_marker = FindEnd(*problem, SpringEnd::kLever, chain.FrameAfterJoint(spring.joint));
  tie.anchor_marker = FindEnd(*problem, SpringEnd::kAnchor, FrameBefore(chain, joint));
  if (tie.lever_marker < 0 || tie.anchor_marker < 0) return;
  CheckFrames(*problem, tie, joint);
  FillChain(*problem, joint, &tie);
  const std::optional<double> lever = SigmaOfEnd(*problem, tie.lever_marker);
  const std::optional<double> anchor = SigmaOfEnd(*problem, tie.anchor_marker);
  tie.lever_sigma = lever.value_or(kMarkerIsTheEnd), tie.anchor_sigma = anchor.value_or(kMarkerIsTheEnd);
  tie.stated = {spring.L, spring.a_x, spring.a_y};
  tie.is_assumed = !StatedEnd(*problem, tie.lever_marker) || !StatedEnd(*problem, tie.anchor_marker);
  tie.sigma_is_stated = lever && anchor;
  tie.covariance = CovarianceOfEnds(tie.stated, tie);
  problem->parameters.SetSpringTie(tie);
}

}  // namespace sagitta

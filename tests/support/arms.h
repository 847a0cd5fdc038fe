// Arms for tests, written by hand or drawn at random; none comes from a file.
#pragma once

#include <string>
#include <vector>

#include "models/chain.h"
#include "models/constants.h"
#include "models/denavit_hartenberg.h"
#include "tests/support/random_numbers.h"

namespace sagitta::test {

inline ElementaryTransform Translate(Axis axis, double nominal_m, const std::string& error = "") {
  return {Motion::kTranslation, axis, nominal_m, -1, 1.0, error};
}
inline ElementaryTransform Rotate(Axis axis, double nominal_rad, const std::string& error = "") {
  return {Motion::kRotation, axis, nominal_rad, -1, 1.0, error};
}
inline ElementaryTransform OnJoint(Motion motion, Axis axis, int joint, const std::string& error = "",
                                   double sign = 1.0, double offset = 0.0) {
  return {motion, axis, offset, joint, sign, error};
}

inline std::vector<Joint> Revolutes(int n, const std::string& prefix = "j") {
  std::vector<Joint> joints;
  for (int j = 0; j < n; ++j) joints.push_back({prefix + std::to_string(j + 1), JointType::kRevolute, {}, {}});
  return joints;
}

// One row of a DH table in m and degrees.
struct DhRow {
  double a, alpha_deg, d, theta_deg;
  JointType type = JointType::kRevolute;
  double beta_deg = 0.0;
};

inline Chain DhArm(DhConvention convention, const std::vector<DhRow>& rows) {
  Chain chain;
  chain.joints = Revolutes(static_cast<int>(rows.size()));
  for (size_t j = 0; j < rows.size(); ++j) {
    chain.joints[j].type = rows[j].type;
    DhLink link;
    link.joint = static_cast<int>(j);
    link.a = rows[j].a;
    link.alpha = rows[j].alpha_deg * kDegree;
    link.d = rows[j].d;
    link.theta = rows[j].theta_deg * kDegree;
    link.beta = rows[j].beta_deg * kDegree;
    AppendDhLink(convention, link, &chain);
  }
  return chain;
}

inline std::vector<DhRow> Ur5Rows() {
  return {{0, 90, 0.089159, 0}, {-0.425, 0, 0, 0},    {-0.39225, 0, 0, 0},
          {0, 90, 0.10915, 0},  {0, -90, 0.09465, 0}, {0, 0, 0.0823, 0}};
}

// Craig's modified table of the Puma 560.
inline std::vector<DhRow> PumaModifiedRows() {
  return {{0, 0, 0, 0},  {0, -90, 0, 0}, {0.4318, 0, 0.1501, 0}, {0.0203, -90, 0.4318, 0},
          {0, 90, 0, 0}, {0, -90, 0, 0}};
}

inline std::vector<DhRow> PumaStandardRows() {
  return {{0, 90, 0.6604, 0}, {0.4318, 0, 0.2, 0}, {0.0203, -90, -0.0505, 0},
          {0, 90, 0.4318, 0}, {0, -90, 0, 0},      {0, 0, 0.05625, 0}};
}

inline std::vector<DhRow> IiwaRows() {
  return {{0, -90, 0.36, 0}, {0, 90, 0, 0}, {0, 90, 0.42, 0}, {0, -90, 0, 0},
          {0, -90, 0.4, 0},  {0, 90, 0, 0}, {0, 0, 0.126, 0}};
}

// A 6R arm on a linear track: the first axis slides.
inline std::vector<DhRow> TrackRows() {
  return {{0.1, -90, 0, 20, JointType::kPrismatic},
          {0.35, -90, 0.75, 0},
          {1.25, 0, 0, 0},
          {0.055, -90, 0, 0},
          {0, 90, 1.1, 0},
          {0, -90, 0, 0},
          {0, 0, 0.23, 0}};
}

// The iiwa and the arm on a track in Craig's convention.
inline std::vector<DhRow> IiwaModifiedRows() {
  return {{0, 0, 0.36, 0},  {0, -90, 0, 0}, {0, 90, 0.42, 0}, {0, 90, 0, 0},
          {0, -90, 0.4, 0}, {0, -90, 0, 0}, {0, 90, 0.126, 0}};
}
inline std::vector<DhRow> TrackModifiedRows() {
  return {{0, 0, 0, 20, JointType::kPrismatic},
          {0.1, -90, 0.75, 0},
          {0.35, -90, 0, 0},
          {1.25, 0, 0, 0},
          {0.055, -90, 1.1, 0},
          {0, 90, 0, 0},
          {0, -90, 0.23, 0}};
}

// Two parallel revolutes, a parallel slide, a parallel wrist.
inline std::vector<DhRow> ScaraRows() {
  return {{0.35, 0, 0.4, 0}, {0.3, 180, 0, 0}, {0, 0, 0.1, 0, JointType::kPrismatic}, {0, 0, 0.05, 0}};
}
inline std::vector<DhRow> ScaraModifiedRows() {
  return {{0, 0, 0.4, 0}, {0.35, 0, 0, 0}, {0.3, 180, 0.1, 0, JointType::kPrismatic}, {0, 0, 0.05, 0}};
}

// Any arm at all: joints on any axis and either sign, offsets, named errors on
// nearly every transform, prismatic joints with the given probability.
inline Chain RandomArm(int joints, bool prismatic_first, RandomNumbers* random) {
  Chain chain;
  int errors = 0;
  const auto error = [&] { return random->Index(5) == 0 ? std::string() : "e" + std::to_string(errors++); };
  const auto axis = [&] { return static_cast<Axis>(random->Index(3)); };
  for (int j = 0; j < joints; ++j) {
    const bool slides = j == 0 ? prismatic_first : random->Index(6) == 0;
    chain.joints.push_back(
        {"a" + std::to_string(j + 1), slides ? JointType::kPrismatic : JointType::kRevolute, {}, {}});
    chain.transforms.push_back(Translate(axis(), random->Uniform(-0.8, 0.8), error()));
    chain.transforms.push_back(Rotate(axis(), random->Uniform(-kPi, kPi), error()));
    chain.transforms.push_back(OnJoint(slides ? Motion::kTranslation : Motion::kRotation, axis(), j, error(),
                                       random->Sign(), random->Uniform(-1.0, 1.0)));
    chain.transforms.push_back(Translate(axis(), random->Uniform(-0.8, 0.8), error()));
  }
  chain.transforms.push_back(Rotate(axis(), random->Uniform(-kPi, kPi), error()));
  if (joints >= 3) chain.couplings.push_back({2, 1, random->Uniform(-1.0, 1.0)});
  return chain;
}

inline Eigen::VectorXd RandomJointValues(const Chain& chain, RandomNumbers* random) {
  Eigen::VectorXd q(chain.num_joints());
  for (int j = 0; j < q.size(); ++j) {
    q[j] = random->Uniform(-1.0, 1.0) * (chain.joints[j].type == JointType::kRevolute ? kPi : 1.0);
  }
  return q;
}

}  // namespace sagitta::test

#include "tools/reproduce/pose_study.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "models/constants.h"
#include "problems/io/robot_file.h"
#include "tests/support/paths.h"

namespace sagitta::pose_study_test {
namespace {

// The arm of paper 000. The paper does not state the range its configurations were
// drawn from; +-90 degrees of q2 and +-150 of q3 give the medians of the reference.
Robot ThreeLinkArm() {
  Robot robot = ReadRobotFile(test::SourceFolder() + "/problems/published/three_link/robot.yaml");
  robot.chain.joints[1].min = -90 * kDegree;
  robot.chain.joints[1].max = 90 * kDegree;
  robot.chain.joints[2].min = -150 * kDegree;
  robot.chain.joints[2].max = 150 * kDegree;
  return robot;
}

struct PublishedRow {
  int layout;
  double weight;
  double factors[6];  // l1 l2 l3 q1 q2 q3
};

std::vector<MarkerLayout> PublishedLayouts() {
  return {DiscLayout("disc r=100, TCP at centroid", 0.1, 0.0),
          DiscLayout("disc r=50, TCP at centroid", 0.05, 0.0),
          DiscLayout("disc r=200, TCP at centroid", 0.2, 0.0),
          DiscLayout("disc r=100, 100 mm ahead of TCP", 0.1, 0.1),
          {"paper-000 tool", {{0.2792, -0.0164, -0.0919}, {0.2792, -0.0252, 0.0961}, {0.2818, 0.1305, 0.0056}}}};
}

// PUBLISHED section 1, rows that print all six.
std::vector<PublishedRow> PublishedMedians() {
  return {{0, 0.001, {1.00, 1.00, 1.00, 1.01, 1.00, 1.01}}, {0, 0.1, {1.00, 1.00, 1.00, 1.08, 1.00, 1.01}},
          {0, 0.3, {1.31, 1.24, 1.04, 3.34, 1.27, 1.69}},   {0, 1.0, {2.17, 1.97, 1.22, 13.6, 2.10, 3.28}},
          {1, 0.001, {1.0, 1.0, 1.0, 1.0, 1.0, 1.0}},       {1, 0.1, {1.04, 1.03, 1.01, 1.32, 1.04, 1.10}},
          {1, 0.3, {2.05, 1.87, 1.19, 6.46, 1.96, 3.04}},   {1, 1.0, {4.0, 3.6, 1.8, 27, 3.9, 6.4}},
          {2, 0.1, {1.00, 1.00, 1.00, 1.04, 1.00, 1.01}},   {2, 0.3, {1.05, 1.04, 1.01, 1.88, 1.05, 1.14}},
          {2, 1.0, {1.36, 1.28, 1.05, 7.1, 1.33, 1.82}},    {3, 0.001, {1.46, 1.46, 1.28, 1.86, 1.44, 1.57}},
          {3, 0.1, {1.40, 1.43, 1.25, 1.74, 1.39, 1.40}},   {3, 0.3, {1.75, 1.72, 1.40, 3.25, 1.72, 1.74}},
          {3, 1.0, {2.6, 2.4, 1.6, 14, 2.5, 3.6}},          {4, 0.001, {2.90, 2.91, 2.30, 4.85, 2.81, 3.35}},
          {4, 0.1, {2.69, 2.82, 2.18, 4.67, 2.65, 3.00}},   {4, 0.3, {2.88, 2.96, 2.27, 4.16, 2.82, 2.58}},
          {4, 1.0, {3.7, 3.6, 2.6, 15, 3.6, 4.0}}};
}

const char* const kNames[6] = {"dl1", "dl2", "dl3", "dq1", "dq2", "dq3"};

const PoseStudyRow& FindRow(const PoseStudy& study, const std::string& layout, double weight) {
  for (const PoseStudyRow& row : study.rows) {
    if (row.layout == layout && row.weight == weight) return row;
  }
  static const PoseStudyRow kNone;
  return kNone;
}

double MedianOf(const PoseStudy& study, const PoseStudyRow& row, const std::string& parameter) {
  for (size_t p = 0; p < study.parameters.size(); ++p) {
    if (study.parameters[p] == parameter) return row.median[p];
  }
  return std::nan("");
}

// 10 %: what random sets and the unknown range leave open (a few rows 14 %).
TEST(PoseStudy, ReproducesTheMediansOfTheReference) {
  const std::vector<MarkerLayout> layouts = PublishedLayouts();
  const PoseStudy study = StudyPoses(ThreeLinkArm(), layouts);
  double sum_of_logs = 0.0;
  int count = 0;
  for (const PublishedRow& published : PublishedMedians()) {
    const PoseStudyRow& row = FindRow(study, layouts[published.layout].name, published.weight);
    for (int p = 0; p < 6; ++p) {
      const double factor = MedianOf(study, row, kNames[p]) / published.factors[p];
      EXPECT_NEAR(factor, 1.0, 0.10) << row.layout << " w " << row.weight << " " << kNames[p];
      sum_of_logs += std::abs(std::log(factor));
      ++count;
    }
  }
  EXPECT_LT(sum_of_logs / count, 0.03);
}

TEST(PoseStudy, MarkersAreNeverWorseAndPropagatedPosesAreTheSame) {
  for (const OrientationRows orientation : {OrientationRows::kRotationVector, OrientationRows::kEulerAngles}) {
    PoseStudyOptions options;
    options.orientation = orientation;
    const PoseStudy study = StudyPoses(ThreeLinkArm(), PublishedLayouts(), options);
    EXPECT_GT(study.sets, options.sets * 9 / 10);
    ASSERT_EQ(study.rows.size(), 20u);
    for (const PoseStudyRow& row : study.rows) {
      EXPECT_GT(row.smallest, 1.0 - 1e-9) << row.layout << " " << row.weight;
      EXPECT_LT(row.largest_gap, 1e-6) << row.layout << " " << row.weight;
    }
  }
}

// What separates the two readings of "orientation": the angles alone make q1 the
// worst by far, 13.6 against 5.8 with rotation vectors.
TEST(PoseStudy, OnlyEulerAnglesGiveTheFactorOfQ1) {
  PoseStudyOptions options;
  options.weights = {1.0};
  options.orientation = OrientationRows::kRotationVector;
  const PoseStudy study = StudyPoses(ThreeLinkArm(), {PublishedLayouts()[0]}, options);
  EXPECT_NEAR(MedianOf(study, study.rows[0], "dq1"), 5.8, 0.6);
  EXPECT_NEAR(MedianOf(study, study.rows[0], "dl1"), 2.17, 0.22);
}

TEST(PoseStudy, IsReproducible) {
  PoseStudyOptions options;
  options.sets = 50;
  const PoseStudy a = StudyPoses(ThreeLinkArm(), PublishedLayouts(), options);
  const PoseStudy b = StudyPoses(ThreeLinkArm(), PublishedLayouts(), options);
  options.seed = 2;
  const PoseStudy other = StudyPoses(ThreeLinkArm(), PublishedLayouts(), options);
  ASSERT_EQ(a.rows.size(), 20U);
  for (size_t i = 0; i < a.rows.size(); ++i) {
    EXPECT_EQ(a.rows[i].layout, b.rows[i].layout);
    EXPECT_EQ(a.rows[i].median, b.rows[i].median);
    EXPECT_NE(a.rows[i].median, other.rows[i].median);
  }
}

}  // namespace
}  // namespace sagitta::pose_study_test

// next.csv: what a cell of a proposed row says, and what is left to be filled in.
#include <gtest/gtest.h>

#include <memory>

#include "estimator/evidence/next_poses.h"
#include "estimator/results/next_csv.h"
#include "models/constants.h"
#include "tests/support/kr270_experiment.h"

namespace sagitta::next_file_test {
namespace {

constexpr char kHeader[] =
    "config,marker,station,load,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,x_mm,y_mm,z_mm,sigma_x_mm,time_s,"
    "temperature_degC,approach2,group,remark,q2_comment,q99999999999999999999_note";

std::vector<std::string> HeaderCells() {
  std::vector<std::string> cells(1);
  for (const char* c = kHeader; *c != '\0'; ++c) {
    if (*c == ',') {
      cells.emplace_back();
    } else {
      cells.back() += *c;
    }
  }
  return cells;
}

// One proposed pose, to be measured like the first configuration; or that one again.
std::string Proposed(bool again = false) {
  test::Kr270Design design;
  design.configurations = 12;
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(test::Kr270Truth(), design.sigma, 1, &data);
  data.files[0].header = HeaderCells();
  for (size_t i = 0; i < data.observations.size(); ++i) {
    data.files[0].rows.push_back(
        {static_cast<int>(i) + 2, {"C", "P1", "S,1", "none", "1",    "2", "3",    "4",          "5",     "6",   "7",
                                   "8", "9",  "0.1", "60",   "21.5", "1", "grid", "second try", "loose", "late"}});
    data.observations[i].file = 0;
    data.observations[i].row = static_cast<int>(i);
  }
  Experiment experiment;
  experiment.validation.kind = ValidationSpec::Kind::kNone;
  Diagnosis diagnosis;
  diagnosis.baseline.problem = std::make_shared<CalibrationProblem>(test::Kr270ProblemOf(data, experiment));
  diagnosis.next = NextPoses();
  diagnosis.next->poses = {{Eigen::VectorXd::Constant(6, 10.0 * kDegree), 0}};
  diagnosis.next->again = again;
  return NextToCsv(diagnosis);
}

// Time, temperature and the direction of a joint's last motion are those of the earlier row, and so is a remark, also
// one whose column begins as that of a joint; a comma in a station's name divides nothing.
TEST(NextFile, WhatIsReadWhenMeasuringIsEmpty) {
  const std::string row = "next1,P1,\"S,1\",none,10.000,10.000,10.000,10.000,10.000,10.000,,,,0.1,,,,,,,\n";
  EXPECT_EQ(Proposed(), std::string(kHeader) + "\n" + row + row + row);
}

// Its joint values as they are written, in a visit of its own: a file without that column gets one.
TEST(NextFile, APoseThatIsVisitedAgainIsThatPose) {
  const std::string row = "C,P1,\"S,1\",none,1,2,3,4,5,6,,,,0.1,,,,,,,,2\n";
  EXPECT_EQ(Proposed(true), std::string(kHeader) + ",visit\n" + row + row + row);
}

// A load that was hung at a later visit is hung at a proposed pose, too; what was visited once more alike is not.
TEST(NextFile, APoseIsMeasuredUnderEveryLoadOnce) {
  Measurements data = test::DesignMeasurements(test::Kr270Design());
  data.shots.resize(4);
  const char* const visits[] = {"1", "2", "3", "2"};
  const char* const loads[] = {"none", "V1", "none", "V1"};
  for (size_t s = 0; s < data.shots.size(); ++s) {
    data.shots[s].configuration = data.shots[s].station = 0;
    data.shots[s].visit = visits[s];
    data.shots[s].load = loads[s];
  }
  EXPECT_EQ(ShotsOfProposal(data, 0), (std::vector<int>{0, 1, 3}));
  data.shots[2].wrench.force.z() = -10.0;  // not the same pull
  EXPECT_EQ(ShotsOfProposal(data, 0), (std::vector<int>{0, 1, 2, 3}));
  data.shots[3].configuration = 1;
  EXPECT_EQ(ShotsOfProposal(data, 1), (std::vector<int>{3}));
}

}  // namespace
}  // namespace sagitta::next_file_test

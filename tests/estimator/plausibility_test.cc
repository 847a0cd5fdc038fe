// Wrong robot files and rows are refused with their cure, robots that only need calibration never: on points of a
// generator that knows nothing of the model's kinematics.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estimator/inspection/reading_lint.h"
#include "tests/support/arms.h"
#include "tests/support/real_data.h"

namespace sagitta {
namespace {

using test::DhRow;
using ::testing::HasSubstr;

std::vector<DhRow> Ur10Rows() {
  return {{0, 90, 0.1273, 0},   {-0.612, 0, 0, 0},   {-0.5723, 0, 0, 0},
          {0, 90, 0.163941, 0}, {0, -90, 0.1157, 0}, {0, 0, 0.0922, 0}};
}

// Rz(theta + q) Tz(d) Tx(a) Rx(alpha), written out (Denavit and Hartenberg 1955).
Eigen::Matrix4d Link(const DhRow& row, double q) {
  const double t = row.theta_deg * kDegree + q, al = row.alpha_deg * kDegree;
  Eigen::Matrix4d link;
  link << std::cos(t), -std::sin(t) * std::cos(al), std::sin(t) * std::sin(al), row.a * std::cos(t),  //
      std::sin(t), std::cos(t) * std::cos(al), -std::cos(t) * std::sin(al), row.a * std::sin(t),      //
      0, std::sin(al), std::cos(al), row.d, 0, 0, 0, 1;
  return link;
}

// One marker at 30 configurations of the arm `rows`.
Measurements Measure(const std::vector<DhRow>& rows, std::uint64_t seed) {
  test::RandomNumbers random(seed);
  Measurements data;
  data.files.resize(1);
  data.files[0].path = "arm.csv";
  data.stations = {"S1"};
  data.markers = {"P1"};
  for (int c = 0; c < 30; ++c) {
    Eigen::VectorXd q(rows.size());
    Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
    for (size_t j = 0; j < rows.size(); ++j) {
      q[j] = random.Uniform(-120, 120) * kDegree;
      pose = pose * Link(rows[j], q[j]);
    }
    data.configurations.push_back({"C" + std::to_string(c), q, false});
    Shot shot;
    shot.configuration = c;
    shot.station = 0;
    shot.observations = {c};
    data.shots.push_back(shot);
    Observation observation;
    observation.shot = c;
    observation.marker = 0;
    observation.file = 0;
    observation.row = c;
    observation.point_in_station = (pose * Eigen::Vector4d(0.03, -0.02, 0.06, 1)).head<3>();
    for (int axis = 0; axis < 3; ++axis) observation.point_in_station[axis] += random.Uniform(-1e-4, 1e-4);
    data.files[0].rows.push_back({c + 2, {}});
    data.observations.push_back(observation);
  }
  return data;
}

CalibrationProblem ProblemOf(const std::vector<DhRow>& rows, Measurements data,
                             DhConvention convention = DhConvention::kStandard) {
  Robot robot;
  DhTable table;
  table.convention = convention;
  for (size_t j = 0; j < rows.size(); ++j) {
    const DhRow& row = rows[j];
    table.links.push_back({static_cast<int>(j), row.a, row.alpha_deg * kDegree, row.d, row.theta_deg * kDegree, 0.0});
  }
  robot.chain = ChainFromDhTable(test::Revolutes(static_cast<int>(rows.size())), {}, table);
  robot.dh = table;
  return MakeCalibrationProblem(robot, std::move(data), Experiment());
}

struct Arm {
  const char* name;
  std::vector<DhRow> rows;
};
std::vector<Arm> Arms() { return {{"UR5", test::Ur5Rows()}, {"UR10", Ur10Rows()}}; }

struct WrongInput {
  const char* code;
  const char* cure;  // in words or remedy
  std::function<void(Eigen::VectorXd*)> joints;
  std::function<void(Vector3<double>*)> point;
};

TEST(Plausibility, WrongRowsAreRefusedWithTheirCure) {
  const std::vector<WrongInput> wrong = {
      {"sign_flip", "joint j2 counted the other way", [](auto* q) { (*q)[1] *= -1; }, {}},
      {"joint_offset", "joint j3 with its zero -90 deg away", [](auto* q) { (*q)[2] += kPi / 2; }, {}},
      {"joint_order", "joints j2 and j3 exchanged", [](auto* q) { std::swap((*q)[1], (*q)[2]); }, {}},
      {"joint_order", "reverse order", [](auto* q) { *q = q->reverse().eval(); }, {}},
      {"mirrored", "mirrored", {}, [](auto* p) { p->y() *= -1; }},
      {"mirrored", "mirrored", {}, [](auto* p) { std::swap(p->x(), p->z()); }},
      {"unit", "inches", {}, [](auto* p) { *p /= 25.4; }},
      {"coupling", "joint j3 coupled to j2 by 1", [](auto* q) { (*q)[2] -= (*q)[1]; }, {}},
  };
  for (const Arm& arm : Arms()) {
    for (const WrongInput& input : wrong) {
      Measurements data = Measure(arm.rows, 3);
      for (Configuration& configuration : data.configurations) {
        if (input.joints) input.joints(&configuration.q);
      }
      for (Observation& row : data.observations) {
        if (input.point) input.point(&row.point_in_station);
      }
      const Plausibility found = CheckPlausible(ProblemOf(arm.rows, data));
      ASSERT_FALSE(found.plausible) << arm.name << " " << input.cure;
      EXPECT_EQ(found.finding.code, input.code) << arm.name << ": " << found.finding.words;
      EXPECT_THAT(found.finding.words + found.finding.remedy, HasSubstr(input.cure)) << arm.name;
    }
  }
}

TEST(Plausibility, WrongTablesAreRefusedWithTheirCure) {
  for (const Arm& arm : Arms()) {
    const Measurements data = Measure(arm.rows, 4);
    Plausibility found = CheckPlausible(ProblemOf(arm.rows, data, DhConvention::kModified));
    ASSERT_FALSE(found.plausible);
    EXPECT_THAT(found.finding.words, HasSubstr("the table as standard DH"));
    std::vector<DhRow> turned = arm.rows;
    turned[0].alpha_deg *= -1;
    found = CheckPlausible(ProblemOf(turned, data));
    ASSERT_FALSE(found.plausible);
    EXPECT_THAT(found.finding.remedy, HasSubstr("alpha_deg in the row of j1"));
  }
  // The other arm: no reading explains it, and it would have to be off by centimetres.
  for (const bool first : {true, false}) {
    const std::vector<Arm> arms = Arms();
    const Plausibility found =
        CheckPlausible(ProblemOf(arms[first ? 0 : 1].rows, Measure(arms[first ? 1 : 0].rows, 5)));
    ASSERT_FALSE(found.plausible);
    EXPECT_EQ(found.finding.code, "misfit");
    EXPECT_THAT(found.finding.remedy, HasSubstr("is it this robot?"));
  }
}

// Each error of an arm drawn up to 5 mm and 1 deg; alone, and with rows that are far off beside.
TEST(Plausibility, RobotsWithLargeErrorsAreNotRefused) {
  const std::vector<std::vector<DhRow>> arms = {test::Ur5Rows(), Ur10Rows(), test::PumaStandardRows(),
                                                test::IiwaRows()};
  for (int seed = 0; seed < 40; ++seed) {
    const std::vector<DhRow>& nominal = arms[seed % arms.size()];
    test::RandomNumbers random(1000 + seed);
    std::vector<DhRow> real = nominal;
    const bool extreme = seed % 3 == 0;
    const auto error = [&](double most) {
      const double drawn = random.Uniform(-most, most);
      return extreme ? std::copysign(most, drawn) : drawn;
    };
    for (DhRow& row : real) {
      row.a += error(5e-3);
      row.d += error(5e-3);
      row.alpha_deg += error(1);
      row.theta_deg += error(1);
    }
    Measurements data = Measure(real, seed);
    if (seed % 4 == 1) data.observations[7].point_in_station.x() += 0.5;
    const Plausibility found = CheckPlausible(ProblemOf(nominal, data));
    EXPECT_TRUE(found.plausible) << seed << ": " << found.finding.words;
  }
}

TEST(Plausibility, RealRobotsAreNotRefused) {
  if (!test::HasRealData()) GTEST_SKIP() << "no measured robots at " << test::RealData("");
  EXPECT_TRUE(CheckPlausible(test::RealProblem("ur5_gts3800", {"measurements.csv"}, Experiment())).plausible);
  for (const char* series : {"series_A.csv", "series_B.csv", "series_C.csv", "series_D.csv"})
    EXPECT_TRUE(CheckPlausible(test::RealProblem("ur10_leica", {series}, Experiment())).plausible) << series;
}

}  // namespace
}  // namespace sagitta

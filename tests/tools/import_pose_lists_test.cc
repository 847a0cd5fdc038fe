// Lists of poses as controllers write them: headers that --map has to explain, axes outside the arm, names that are
// those of something else.
#include "tests/tools/import_tables.h"

#ifdef SAGITTA_HAVE_KDL

#include <chrono>

namespace sagitta::import_pose_lists_test {
namespace {

using test::Always;
using test::Readings;
using test::Table;

std::string PoseName(size_t row) { return "P" + std::to_string(row + 1); }

Table Points(const std::vector<std::string>& header = {"X [mm]", "Y [mm]", "Z [mm]"}) {
  Table table = Table(Readings()).Reordered({6, 7, 8});
  table.header = header;
  return table.Insert(0, "Name", PoseName);
}

// In the order from the last to the first.
Table Poses(const std::vector<std::string>& header) {
  Table table = Table(Readings()).Reordered({0, 1, 2, 3, 4, 5});
  table.header = header;
  table.Insert(0, "Name", PoseName);
  std::reverse(table.rows.begin(), table.rows.end());
  return table;
}

Table PosesByNumber() { return Poses({"A1 [deg]", "A2 [deg]", "A3 [deg]", "A4 [deg]", "A5 [deg]", "A6 [deg]"}); }

class ImportPoseLists : public test::Import {
 protected:
  std::vector<std::string> With(const std::string& poses, std::vector<std::string> flags = {}) const {
    flags.insert(flags.begin(), Write("poses.csv", poses));
    return flags;
  }
};

TEST_F(ImportPoseLists, TheMapNamesHeadersOfEitherFile) {
  const std::string poses = Poses({"Fuss", "Schulter", "Arm", "Hand 1", "Hand 2", "Hand 3"}).ToText();
  const std::string joints = "q1_deg=Fuss,q2_deg=Schulter,q3_deg=Arm,q4_deg=Hand 1,q5_deg=Hand 2,q6_deg=Hand 3";
  ExpectRight(Points().ToText(), Readings(), With(poses, {"--map=" + joints}));
  ExpectRight(Points({"East", "North", "Up"}).ToText(), Readings(),
              With(PosesByNumber().ToText(), {"--map=x_mm=East,y_mm=North,z_mm=Up"}));
  ExpectRight(Points({"East", "North", "Up"}).ToText(), Readings(),
              With(poses, {"--map=x_mm=East,y_mm=North,z_mm=Up," + joints}));
  ExpectRefused(Points({"East", "North", "Up"}).ToText(), {"--map", "'Norht'", "in any of the files", "North"},
                With(poses, {"--map=x_mm=East,y_mm=Norht,z_mm=Up," + joints}));
}

TEST_F(ImportPoseLists, JointsOfYaskawa) {
  ExpectRight(Points().ToText(), Readings(),
              With(Poses({"S [deg]", "L [deg]", "U [deg]", "R [deg]", "B [deg]", "T [deg]"}).ToText()));
  ExpectRight(Points().ToText(), Readings(), With(Poses({"S", "L", "U", "R", "B", "T"}).ToText()));
  Table pulses = Poses({"S", "L", "U", "R", "B", "T"});
  for (auto& row : pulses.rows) {
    for (size_t c = 1; c < row.size(); ++c) row[c] = test::Text(std::round(std::stod(row[c]) * 1341.4), 17);
  }
  ExpectRefused(Points().ToText(), {"joint values are whole numbers up to", "pulses of encoders, no angles", "degrees"},
                With(pulses.ToText()));
}

TEST_F(ImportPoseLists, ColumnsOfTheListThatAreNotUsedAreListed) {
  Table poses = PosesByNumber();
  poses.Insert(7, "E1 [mm]", Always("1500.0")).Insert(8, "Speed", Always("100")).Insert(9, "X [mm]", Always("1.5"));
  poses.Insert(10, "Comment", Always("c"));
  const test::Outcome outcome = ImportText(Points().ToText(), With(poses.ToText()));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  for (const char* words :
       {"an axis that this robot has not, always at 1500 (", "Speed ", "Comment ", "not measured ("})
    EXPECT_NE(outcome.out.find(words), std::string::npos) << words << " is not in\n" << outcome.out;
}

// The arm rides on a rail that the robot file has not.
TEST_F(ImportPoseLists, AnAxisThatMovedIsNamed) {
  std::vector<test::Reading> moved = Readings();
  for (size_t r = 0; r < moved.size(); ++r) moved[r].xyz_mm[1] += 100.0 * static_cast<double>(r);
  Table points = Table(moved).Reordered({6, 7, 8});
  points.Insert(0, "Name", PoseName);
  const auto rail = [](size_t row) { return std::to_string(100 * row); };
  Table poses = Table(moved).Reordered({0, 1, 2, 3, 4, 5});
  poses.Insert(0, "Name", PoseName).Insert(7, "E1 [mm]", rail);
  ExpectRefused(points.ToText(), {"cannot have made these readings", "E1 [mm], an axis that this robot has not, moved"},
                With(poses.ToText()));
  Table together = Table(moved);
  ExpectRefused(together.Insert(6, "E1 [mm]", rail).ToText(), {"E1 [mm], an axis that this robot has not, moved"});
}

// P2_7 is the seventh pose's second marker, and P2 a pose's name as well.
TEST_F(ImportPoseLists, NamesThatBeginWithAMarkersNumberAreRefusedAtOnce) {
  Table poses = PosesByNumber(), points = Points();
  const std::vector<std::vector<std::string>> once = points.rows;
  points.rows.clear();
  for (const auto& row : once) {
    for (const char* marker : {"1", "2", "3"}) {
      points.rows.push_back(row);
      points.rows.back()[0] = std::string("P") + marker + "_" + row[0].substr(1);
    }
  }
  const auto start = std::chrono::steady_clock::now();
  ExpectRefused(points.ToText(), {"export.txt", "of the 30 poses of", "'P1_1'", "of 3 only: 'P1', 'P2' and 'P3'"},
                With(poses.ToText()));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(15));
  // Few poses that are measured again and again are poses all the same.
  Table again = Points();
  for (size_t r = 0; r < again.rows.size(); ++r)
    again.rows[r][0] = "P" + std::to_string(1 + r % 10) + "_rep" + std::to_string(1 + r / 10);
  const test::Outcome outcome = ImportText(again.ToText(), With(poses.ToText()));
  EXPECT_EQ(outcome.err.find("only: 'P1'"), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace sagitta::import_pose_lists_test

#endif  // SAGITTA_HAVE_KDL

// Expected sets: an independent Python script (hashlib), FORMATS section 3.
#include "problems/split.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <vector>

#include "problems/io/files.h"
#include "problems/io/measurement_file.h"
#include "tests/problems/file_test_support.h"
#include "tests/support/paths.h"

namespace sagitta::split_test {
namespace {

// One shot per configuration C00, C01, ..., joint value 0, 1, ...
Measurements Configurations(int n) {
  Measurements data;
  data.files.push_back({"m.csv", "", {"config", "set", "group"}, {}});
  for (int i = 0; i < n; ++i) {
    const std::string id = std::string(i < 10 ? "C0" : "C") + std::to_string(i);
    data.configurations.push_back({id, Eigen::VectorXd::Constant(2, i), false});
    Shot& shot = data.shots.emplace_back();
    shot.configuration = i;
    shot.station = 0;
    shot.observations = {i};
    Observation& observation = data.observations.emplace_back();
    observation.shot = i;
    observation.marker = 0;
    observation.file = 0;
    observation.row = i;
    data.files[0].rows.push_back({i + 2, {id, "calibration", i < 3 ? "random" : "grid"}});
  }
  return data;
}

std::set<std::string> HeldOut(const Measurements& data) {
  std::set<std::string> ids;
  for (const Configuration& configuration : data.configurations) {
    if (configuration.is_validation) ids.insert(configuration.id);
  }
  return ids;
}

ValidationSpec Fraction(double fraction, unsigned long long seed) {
  ValidationSpec spec;
  spec.kind = ValidationSpec::Kind::kFraction;
  spec.fraction = fraction;
  spec.seed = seed;
  return spec;
}

ValidationSpec Column(const std::string& column, const std::vector<std::string>& values) {
  ValidationSpec spec;
  spec.kind = ValidationSpec::Kind::kColumn;
  spec.column = column;
  spec.values = values;
  return spec;
}

using Ids = std::set<std::string>;

TEST(SplitTest, FractionFollowsTheHashes) {
  Measurements data = Configurations(10);
  SplitConfigurations(Fraction(0.3, 1), &data);
  EXPECT_EQ(HeldOut(data), (Ids{"C00", "C04", "C07"}));
  SplitConfigurations(Fraction(0.5, 7), &data);  // replaces the split before
  EXPECT_EQ(HeldOut(data), (Ids{"C03", "C04", "C06", "C07", "C08"}));
  SplitConfigurations(Fraction(0.25, 2), &data);
  EXPECT_EQ(HeldOut(data), (Ids{"C01", "C05", "C06"}));
}

TEST(SplitTest, EqualJointValuesGoTogether) {
  Measurements data = Configurations(10);
  for (const int i : {3, 7, 9}) data.configurations[i].q = data.configurations[2].q;
  // -0 and 0 are one joint value: nothing changes.
  data.configurations[0].q[0] = -0.0;
  SplitConfigurations(Fraction(0.4, 3), &data);
  EXPECT_EQ(HeldOut(data), (Ids{"C00", "C06", "C08"}));
  SplitConfigurations(Fraction(0.4, 0), &data);
  EXPECT_EQ(HeldOut(data), (Ids{"C02", "C03", "C06", "C07", "C08", "C09"}));
}

// Against a map of the values: joint values of a grid, each met several times.
TEST(SplitTest, GroupsOfConfigurationsAreThoseOfEqualValues) {
  Measurements data = Configurations(3000);
  std::map<std::vector<double>, int> expected;
  std::vector<std::vector<int>> members;
  for (int c = 0; c < 3000; ++c) data.configurations[c].q << 0.25 * (c * 7 % 41 - 20), 1e-3 * (c * 11 % 53 - 26);
  const std::vector<int> group_of = GroupsOfConfigurations(data);
  for (int c = 0; c < 3000; ++c) {
    const Eigen::VectorXd& q = data.configurations[c].q;
    const int next = static_cast<int>(expected.size());
    const int group = expected.try_emplace({q[0], q[1]}, next).first->second;
    EXPECT_EQ(group_of[c], group) << c;
    if (group == static_cast<int>(members.size())) members.emplace_back();
    members[group].push_back(c);
  }
  EXPECT_EQ(expected.size(), 41u * 53u);
  EXPECT_EQ(GroupsOfEqualJointValues(data), members);
}

TEST(SplitTest, ByTimeHoldsOutTheLast) {
  Measurements data = Configurations(5);
  const double times[] = {50, 10, 40, 20, 30};
  for (int i = 0; i < 5; ++i) {
    data.shots[i].has_time = true;
    data.shots[i].time = times[i];
  }
  ValidationSpec spec = Fraction(0.3, 1);
  spec.by_time = true;
  SplitConfigurations(spec, &data);
  EXPECT_EQ(HeldOut(data), (Ids{"C00", "C02"}));
  data.shots[1].has_time = false;
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { SplitConfigurations(spec, &data); }), {"m.csv", "time", "time_s"}));
}

TEST(SplitTest, ByColumn) {
  Measurements data = Configurations(5);
  SplitConfigurations(Column("group", {"random"}), &data);
  EXPECT_EQ(HeldOut(data), (Ids{"C00", "C01", "C02"}));
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { SplitConfigurations(Column("gruop", {"random"}), &data); }),
                          {"m.csv", "gruop", "'group'"}));
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { SplitConfigurations(Column("group", {"x"}), &data); }),
                          {"m.csv", "no configuration is held out", "'group'"}));
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] {
                            SplitConfigurations(Column("group", {"random", "grid"}), &data);
                          }),
                          {"m.csv", "every configuration"}));
  // One of two that no row has: its rows would be fitted.
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] {
                            SplitConfigurations(Column("group", {"random", "gird"}), &data);
                          }),
                          {"m.csv", "'gird'", "'group'"}));
}

TEST(SplitTest, TheSetColumnIsTheDefault) {
  Measurements data = Configurations(5);
  SplitConfigurations({}, &data);
  EXPECT_TRUE(HeldOut(data).empty());
  data.files[0].rows.SetCell(4, 1, "validation");
  SplitConfigurations({}, &data);
  EXPECT_EQ(HeldOut(data), (Ids{"C04"}));
  data.files[0].header[1] = "other";  // no such column: nothing is held out
  SplitConfigurations({}, &data);
  EXPECT_TRUE(HeldOut(data).empty());
}

TEST(SplitTest, AConfigurationIsOneOrTheOther) {
  Measurements data = Configurations(5);
  data.files[0].rows.SetCell(4, 1, "validation");
  data.observations[4].shot = 1;
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { SplitConfigurations({}, &data); }), {"m.csv:6: set", "'C01'", "m.csv:3"}));
}

TEST(SplitTest, NoneHoldsOutNothing) {
  Measurements data = Configurations(3);
  data.files[0].rows.SetCell(1, 1, "validation");
  ValidationSpec spec;
  spec.kind = ValidationSpec::Kind::kNone;
  SplitConfigurations(spec, &data);
  EXPECT_TRUE(HeldOut(data).empty());
}

TEST(SplitTest, RefusesImpossibleFractions) {
  Measurements data = Configurations(3);
  for (const double fraction : {0.0, 1.0, -0.1, 1.5, std::nan("")}) {
    EXPECT_NE(ErrorOf([&] { SplitConfigurations(Fraction(fraction, 1), &data); }), "") << fraction;
  }
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { SplitConfigurations(Fraction(0.9, 1), &data); }), {"every configuration"}));
}

// All of them measured, or the first ones only.
TEST(SplitTest, ProposedNamesAreFittedWhateverTheSeedAndTheFraction) {
  constexpr int kCount = 6;
  for (const double fraction : {0.05, 0.2, 0.3, 0.5, 0.75}) {
    for (unsigned long long seed = 1; seed <= 20; ++seed) {
      const Measurements data = Configurations(24);
      const std::vector<std::string> names = NamesThatAreFitted(Fraction(fraction, seed), data, "next", kCount);
      ASSERT_EQ(names.size(), static_cast<size_t>(kCount));
      for (int measured = 1; measured <= kCount; ++measured) {
        Measurements more = data;
        for (int k = 0; k < measured; ++k) {
          more.configurations.push_back({names[k], Eigen::VectorXd::Constant(2, 100 + k), false});
        }
        SplitConfigurations(Fraction(fraction, seed), &more);
        for (int k = 0; k < measured; ++k) {
          EXPECT_FALSE(more.configurations[24 + k].is_validation) << names[k] << " seed " << seed << " of " << fraction;
        }
      }
    }
  }
}

TEST(SplitTest, ProposedNamesGoOnAfterThoseOfTheData) {
  Measurements data = Configurations(4);
  data.configurations[1].id = "next2";
  data.configurations[2].id = "next7";
  data.configurations[3].id = "next9_again";
  ValidationSpec none;
  none.kind = ValidationSpec::Kind::kNone;
  EXPECT_EQ(NamesThatAreFitted(none, data, "next", 2), (std::vector<std::string>{"next8", "next9"}));
  for (const std::string& name : NamesThatAreFitted(Fraction(0.3, 1), data, "next", 6)) {
    EXPECT_GT(std::stol(name.substr(4)), 7) << name;
  }
}

// No name keeps a pose fitted where the fraction leaves nothing to fit of the others.
TEST(SplitTest, ProposedNamesEndWhereTheFractionLeavesNoRoom) {
  EXPECT_EQ(NamesThatAreFitted(Fraction(0.95, 1), Configurations(4), "next", 6).size(), 6u);
}

TEST(SplitTest, SharedUr5SplitIsThePublishedOne) {
  const std::string path = test::SharedFolder() + "/data/ur5_gts3800/measurements.csv";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "the shared data are not here: " << path;
  Measurements data = ReadMeasurements({path}, {"j1", "j2", "j3", "j4", "j5", "j6"}, std::vector<bool>(6, false));
  SplitConfigurations(Fraction(0.3, 1), &data);
  const Ids ids = HeldOut(data);
  EXPECT_EQ(ids.size(), 306u);
  std::string joined;
  for (const std::string& id : ids) joined += (joined.empty() ? "" : "\n") + id;
  EXPECT_EQ(Sha256(joined), "42eeb447eca084e3895219cc5f0d87b960472905580d36050719b1d17dcb4eae");
}

}  // namespace
}  // namespace sagitta::split_test

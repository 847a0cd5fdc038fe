// Whether the robot can have made the readings of a table, has made them, and which rows alone it did not make.
#include "tests/tools/import_tables.h"

#ifdef SAGITTA_HAVE_KDL

namespace sagitta::import_misfit_test {
namespace {

using test::MakeReadings;
using test::Reading;
using test::Readings;
using test::Table;

class ImportMisfit : public test::Import {};

double Rounded(double value, double step) { return step * std::round(value / step); }

// The points of a controller, and its joint values with the digits that it shows.
std::vector<Reading> ControllersPoints(double angle_step, double length_step) {
  std::vector<Reading> readings = MakeReadings(true);
  for (Reading& reading : readings) {
    for (double& q : reading.q_deg) q = Rounded(q, angle_step);
    for (double& x : reading.xyz_mm) x = Rounded(x, length_step);
  }
  return readings;
}

TEST_F(ImportMisfit, PointsOfJointValuesThatAreRoundedAreComputed) {
  ExpectRefused(Table(ControllersPoints(0.01, 0.01)).ToText(), {"they were computed, not measured", "digits"});
  ExpectRefused(Table(ControllersPoints(0.01, 1e-4)).ToText(), {"they were computed, not measured"});
  // Who says that they are measured is believed.
  EXPECT_EQ(ImportText(Table(ControllersPoints(0.01, 0.01)).ToText(), {"--map=x_mm=x_mm,y_mm=y_mm,z_mm=z_mm"}).status,
            0);
}

// Poses of whole degrees were driven to as written: their digits are no rounding.
TEST_F(ImportMisfit, MeasuredPointsAtPosesOfFewDigitsAreMeasured) {
  ExpectRight(Table(Readings()).ToText(), Readings());
  std::vector<Reading> coarse = ControllersPoints(1.0, 0.001);
  const Table table(coarse);
  const test::Outcome outcome = ImportText(table.ToText());
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.err.find("computed"), std::string::npos) << outcome.err;
}

// One reading off by metres: all rows are imported, and that one is named.
TEST_F(ImportMisfit, ReadingsThatAreFarOffAreNamed) {
  for (const size_t bad : {0u, 11u, 29u}) {
    std::vector<Reading> readings = Readings();
    readings[bad].xyz_mm = {-999.0, -999.0, -999.0};
    ExpectRight(Table(readings).ToText(), readings);
    const test::Outcome outcome = ImportText(Table(readings).ToText());
    const std::string named = "of 30 readings 1 is far from where the nominal robot has the marker";
    EXPECT_NE(outcome.out.find("Warning: " + named), std::string::npos) << outcome.out;
    EXPECT_NE(outcome.out.find("export.txt:" + std::to_string(bad + 2) + " ("), std::string::npos) << outcome.out;
  }
  EXPECT_EQ(ImportText(Table(Readings()).ToText()).out.find("Warning"), std::string::npos);
}

// Whether a sample of the rows has it or not.
TEST_F(ImportMisfit, ReadingsThatAreFarOffAreNamedWhereverTheyStand) {
  std::vector<Reading> five_times;
  for (int repeat = 0; repeat < 5; ++repeat) five_times.insert(five_times.end(), Readings().begin(), Readings().end());
  for (const size_t bad : {34u, 35u, 36u}) {
    std::vector<Reading> readings = five_times;
    for (double& x : readings[bad].xyz_mm) x += 1500.0;
    const test::Outcome outcome = ImportText(Table(readings).ToText());
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("export.txt:" + std::to_string(bad + 2) + " ("), std::string::npos) << outcome.out;
    EXPECT_NE(outcome.out.find("of 150 readings 1 is far"), std::string::npos) << outcome.out;
  }
}

// What an effect of the robot file needs (sides of approach, times, a load) a table need not have: the arm is compared
// without it.
TEST_F(ImportMisfit, ARobotWithEffectsIsCompared) {
  std::vector<Reading> scrambled = Readings();
  for (size_t r = 0; r < scrambled.size(); ++r) scrambled[r].xyz_mm = Readings()[(r * 7 + 3) % scrambled.size()].xyz_mm;
  for (const char* effect :
       {"{effect: backlash, joint: j2, by: approach, half_gap_urad: 30}",
        "{effect: thermal_growth, growth_ppm_per_K: 11}", "{effect: station_drift, station: S1, x_um_per_h: 10}",
        "{effect: payload, load: L1, dmass_kg: 1}"}) {
    const std::string robot = Write("effects.yaml", std::string(test::kRobot) + "effects:\n  - " + effect + "\n");
    const auto import = [&](const std::vector<Reading>& readings) {
      std::filesystem::remove_all(Path("job"));
      return Run({"import", robot, Write("export.txt", Table(readings).ToText()), "--out=" + Path("job")});
    };
    const test::Outcome right = import(Readings());
    EXPECT_EQ(right.status, 0) << effect << right.err;
    EXPECT_NE(right.out.find("the columns fit the robot"), std::string::npos) << effect << right.out;
    EXPECT_NE(Read("job/robot.yaml").find("effects:"), std::string::npos) << "the robot is written as it is";
    const test::Outcome wrong = import(scrambled);
    EXPECT_EQ(wrong.status, 2) << effect;
    EXPECT_NE(wrong.err.find("cannot have made these readings"), std::string::npos) << effect << wrong.err;
    const test::Outcome computed = import(MakeReadings(true));
    EXPECT_NE(computed.err.find("they were computed"), std::string::npos) << effect << computed.err;
  }
}

// Enough rows that are no measurements of the robot are not called too few: the row is named that says why.
TEST_F(ImportMisfit, WhatKeepsTheRobotFromBeingComparedIsSaid) {
  std::string locked = test::kRobot;
  const std::string joint = "{name: j6, type: revolute}";
  locked.replace(locked.find(joint), joint.size(), "{name: j6, type: revolute, min_deg: 5, max_deg: 5}");
  const test::Outcome outcome = Run({"import", Write("locked.yaml", locked),
                                     Write("export.txt", Table(Readings()).ToText()), "--out=" + Path("job")});
  EXPECT_EQ(outcome.status, 2) << outcome.out;
  EXPECT_NE(outcome.err.find("joint 'j6' does not move by itself"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("export.txt:2"), std::string::npos) << outcome.err;
}

// Many repeats of each pose: a sample of the rows has to have several poses all the same, or any robot fits it.
TEST_F(ImportMisfit, RepeatsOfFewPosesAreComparedAtSeveralOfThem) {
  std::vector<Reading> repeats;
  for (int repeat = 0; repeat < 40; ++repeat) {
    for (Reading reading : Readings()) {
      reading.xyz_mm[2] += 0.001 * repeat;
      repeats.push_back(reading);
    }
  }
  const test::Outcome outcome = ImportText(Table(repeats).ToText());
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("the columns fit the robot"), std::string::npos) << outcome.out;
  std::vector<Reading> mirrored = repeats;
  for (Reading& reading : mirrored) reading.xyz_mm[1] *= -1.0;
  ExpectRefused(Table(mirrored).ToText(), {"cannot have made these readings"});
}

TEST_F(ImportMisfit, RowsOfMeansAndDeviationsAreNamed) {
  std::vector<Reading> readings = Readings();
  Reading mean = readings[0], deviation = readings[0];
  const auto n = static_cast<double>(readings.size());
  const auto fill = [&](const auto& member, std::vector<double>* means, std::vector<double>* deviations) {
    for (size_t i = 0; i < means->size(); ++i) {
      double sum = 0.0, squares = 0.0;
      for (const Reading& reading : Readings()) sum += member(reading)[i];
      for (const Reading& reading : Readings()) squares += std::pow(member(reading)[i] - sum / n, 2);
      (*means)[i] = sum / n, (*deviations)[i] = std::sqrt(squares / n);
    }
  };
  fill([](const Reading& reading) { return reading.q_deg; }, &mean.q_deg, &deviation.q_deg);
  fill([](const Reading& reading) { return reading.xyz_mm; }, &mean.xyz_mm, &deviation.xyz_mm);
  readings.push_back(mean);
  readings.push_back(deviation);
  const test::Outcome outcome = ImportText(Table(readings).ToText());
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("of 32 readings 2 are far"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("export.txt:32 ("), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("export.txt:33 ("), std::string::npos) << outcome.out;
}

// What is another robot, unit, sign or frame stays refused with such a reading, and many of them are no exceptions.
TEST_F(ImportMisfit, AnotherRobotWithAReadingFarOffStaysRefused) {
  std::vector<Reading> off = Readings();
  off[7].xyz_mm[0] += 2600.0;
  const auto spoiled = [&](const std::function<void(Reading*)>& spoil) {
    std::vector<Reading> readings = off;
    for (Reading& reading : readings) spoil(&reading);
    return Table(readings).ToText();
  };
  const std::string not_made = "this robot cannot have made these readings";
  ExpectRefused(spoiled([](Reading* r) { r->xyz_mm[1] *= -1.0; }), {not_made});
  ExpectRefused(spoiled([](Reading* r) { std::swap(r->xyz_mm[0], r->xyz_mm[1]); }), {not_made});
  ExpectRefused(spoiled([](Reading* r) { std::swap(r->q_deg[1], r->q_deg[2]); }), {not_made});
  ExpectRefused(spoiled([](Reading* r) { r->q_deg[0] *= -1.0; }), {not_made});
  ExpectRefused(spoiled([](Reading* r) {
                  for (double& x : r->xyz_mm) x *= 25.4;
                }),
                {not_made});
  ExpectRefused(spoiled([](Reading* r) {
                  for (double& q : r->q_deg) q *= kDegree;
                }),
                {not_made});
  std::vector<Reading> many = Readings();
  for (size_t r = 0; r < many.size(); r += 3) many[r].xyz_mm = {-999.0 - double(r), 50.0 * double(r), 300.0};
  ExpectRefused(Table(many).ToText(), {not_made});
}

}  // namespace
}  // namespace sagitta::import_misfit_test

#endif  // SAGITTA_HAVE_KDL

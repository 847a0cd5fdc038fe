#include "problems/io/experiment_file.h"

#include <gtest/gtest.h>

#include "problems/io/files.h"
#include "tests/problems/file_test_support.h"
#include "tests/support/paths.h"

namespace sagitta::experiment_file_test {
namespace {

constexpr char kMinimal[] = "schema: sagitta/experiment/1\nrobot: robot.yaml\nmeasurements: [a.csv, sub/b.csv]\n";

constexpr char kFull[] = R"(schema: sagitta/experiment/1
robot: robot.yaml
measurements: [geometric.csv, /data/loaded.csv]
load_point_mm: [280, 0, 0]
loads: {V250: {mass_kg: 250, point_m: [0.28, 0, 0.1], frame: base}, V100: {}}
tool: {mass_kg: 12, com_mm: [1, 2, 3]}
gravity: {direction: [0, 0, -2], frame: base, m_per_s2: 9.81}
markers: {M1: {xyz_mm: [279, -16, -92], on: flange}, P1: {on: A2}}
stations: {S1: {xyz_mm: [1, 2, 3], rotvec_mrad: [0, 0, 5], instrument_mm: [4, 5, 6], levelled: false}}
noise: {sigma_mm: 0.05}
repeatability_urad: 8
weights: equal
covariance: sandwich
loss: huber
estimate:
  base: true
  markers: false
  geometry: [p_x1, dq2]
  compliance: all
  gravity_compensator: [a_x, Kc]
  effects: none
  fixed: [base/S1]
priors: {compensator/Kc: {value: 15, sigma: 5}}
validation: {fraction: 0.3, seed: 12, by: time}
significance: 0.05
)";

class ExperimentFileTest : public FileTest {
 protected:
  Experiment Read(const std::string& text) { return ReadExperimentFile(Write("e.yaml", text)); }
  std::string Error(const std::string& text) {
    return ErrorOf([&] { Read(text); });
  }
};

TEST_F(ExperimentFileTest, OnlyRobotAndMeasurementsAreRequired) {
  const Experiment experiment = Read(kMinimal);
  EXPECT_EQ(experiment.file, Path("e.yaml"));
  EXPECT_EQ(experiment.sha256, Sha256(kMinimal));
  EXPECT_EQ(experiment.robot_file, Path("robot.yaml"));
  EXPECT_EQ(experiment.measurement_files, (std::vector<std::string>{Path("a.csv"), Path("sub/b.csv")}));
  EXPECT_EQ(experiment.noise.from, NoiseSpec::From::kDefault);
  EXPECT_TRUE(experiment.repeatability.IsZero());
  EXPECT_EQ(experiment.validation.kind, ValidationSpec::Kind::kSetColumn);
  EXPECT_EQ(experiment.estimate.geometry.kind, Selection::Kind::kDefault);
  EXPECT_EQ(experiment.gravity, 9.80665);
  EXPECT_FALSE(experiment.load_point.has_value());
}

TEST_F(ExperimentFileTest, ReadsTheScene) {
  const Experiment experiment = Read(kFull);
  EXPECT_EQ(experiment.measurement_files[1], "/data/loaded.csv");
  EXPECT_EQ(*experiment.load_point, Vector3<double>(0.28, 0, 0));
  EXPECT_EQ(*experiment.loads.at("V250").mass, 250);
  EXPECT_EQ(*experiment.loads.at("V250").point, Vector3<double>(0.28, 0, 0.1));
  EXPECT_EQ(experiment.loads.at("V250").frame, WrenchFrame::kBase);
  EXPECT_FALSE(experiment.loads.at("V100").mass.has_value());
  EXPECT_EQ(experiment.tool_mass, 12);
  EXPECT_EQ(experiment.tool_com, Vector3<double>(1e-3, 2e-3, 3e-3));
  EXPECT_EQ(experiment.gravity_direction, Vector3<double>(0, 0, -1));
  EXPECT_TRUE(experiment.gravity_in_base);
  EXPECT_EQ(experiment.gravity, 9.81);
  EXPECT_EQ(*experiment.markers.at("M1").point, Vector3<double>(0.279, -0.016, -0.092));
  EXPECT_EQ(experiment.markers.at("P1").on.joint, "A2");
  EXPECT_FALSE(experiment.markers.at("P1").point.has_value());
  const StationSpec& station = experiment.stations.at("S1");
  EXPECT_EQ(*station.base_xyz, Vector3<double>(1e-3, 2e-3, 3e-3));
  EXPECT_EQ(*station.base_rotvec, Vector3<double>(0, 0, 5e-3));
  EXPECT_EQ(*station.instrument_xyz, Vector3<double>(4e-3, 5e-3, 6e-3));
  EXPECT_FALSE(*station.levelled);
}

TEST_F(ExperimentFileTest, ReadsTheMethod) {
  const Experiment experiment = Read(kFull);
  EXPECT_EQ(experiment.noise.from, NoiseSpec::From::kSigma);
  EXPECT_EQ(*experiment.noise.sigma, 5e-5);
  EXPECT_EQ(*experiment.repeatability.angle.common, 8e-6);
  EXPECT_EQ(experiment.method.weights, Weights::kEqual);
  EXPECT_EQ(experiment.method.covariance, CovarianceKind::kSandwich);
  EXPECT_EQ(experiment.method.loss, LossKind::kHuber);
  EXPECT_FALSE(experiment.estimate.markers);
  EXPECT_EQ(experiment.estimate.geometry.names, (std::vector<std::string>{"p_x1", "dq2"}));
  EXPECT_EQ(experiment.estimate.compliance.kind, Selection::Kind::kAll);
  EXPECT_EQ(experiment.estimate.gravity_compensator.kind, Selection::Kind::kList);
  EXPECT_EQ(experiment.estimate.effects.kind, Selection::Kind::kNone);
  EXPECT_EQ(experiment.estimate.fixed, std::vector<std::string>{"base/S1"});
  EXPECT_EQ(experiment.priors.at("compensator/Kc").sigma, 5);
  EXPECT_EQ(experiment.validation.kind, ValidationSpec::Kind::kFraction);
  EXPECT_EQ(experiment.validation.seed, 12u);
  EXPECT_TRUE(experiment.validation.by_time);
  EXPECT_EQ(experiment.significance, 0.05);
}

TEST_F(ExperimentFileTest, ReadsEveryKindOfNoise) {
  const auto noise = [&](const std::string& text) { return Read(kMinimal + ("noise: " + text + "\n")).noise; };
  EXPECT_EQ(noise("{from: rows}").from, NoiseSpec::From::kRows);
  EXPECT_EQ(*noise("{from: rows, sigma_mm: 0.1}").sigma, 1e-4);
  EXPECT_EQ(noise("{from: repeats}").from, NoiseSpec::From::kRepeats);
  EXPECT_EQ(noise("{from: variance-components}").from, NoiseSpec::From::kVarianceComponents);
  const NoiseSpec residuals = noise("{from: residuals, lambda: 2, sigma0_mm: 0.02, group: marker-axis, iterations: 3}");
  EXPECT_EQ(residuals.from, NoiseSpec::From::kResiduals);
  EXPECT_EQ(residuals.lambda, 2);
  EXPECT_EQ(residuals.sigma0, 2e-5);
  EXPECT_EQ(residuals.group, ResidualGroup::kMarkerAxis);
  EXPECT_EQ(residuals.iterations, 3);
  const NoiseSpec tracker = noise("{instrument: {range_um: 10, range_um_per_m: 0.5, angle_um: 15, angle_um_per_m: 6}}");
  EXPECT_EQ(tracker.from, NoiseSpec::From::kInstrument);
  EXPECT_EQ(tracker.range, 1e-5);
  EXPECT_EQ(tracker.range_per_m, 0.5e-6);
  EXPECT_EQ(tracker.angle, 1.5e-5);
  EXPECT_EQ(tracker.angle_per_m, 6e-6);
}

TEST_F(ExperimentFileTest, ReadsEveryKindOfRepeatability) {
  const auto repeatability = [&](const std::string& text) { return Read(kMinimal + (text + "\n")).repeatability; };
  EXPECT_TRUE(repeatability("repeatability_urad: estimate").angle.estimate);
  EXPECT_FALSE(repeatability("repeatability_urad: estimate").length.estimate);
  EXPECT_TRUE(repeatability("repeatability: estimate").length.estimate);
  EXPECT_EQ(repeatability("repeatability_um: 5").length.common, 5e-6);
  const RepeatabilitySpec mixed = repeatability("repeatability_urad: {A1: 8}\nrepeatability_um: {L2: 4}");
  EXPECT_EQ(mixed.angle.per_joint.at("A1"), 8e-6);
  EXPECT_EQ(mixed.length.per_joint.at("L2"), 4e-6);
  const RepeatabilitySpec rest = repeatability("repeatability_um: 5\nrepeatability: estimate");
  EXPECT_TRUE(rest.angle.estimate);
  EXPECT_FALSE(rest.length.estimate);
  EXPECT_EQ(rest.length.StatedFor("L2"), 5e-6);
  EXPECT_THROW(repeatability("repeatability_mrad: estimate\nrepeatability_urad: 8"), InputError);
}

TEST_F(ExperimentFileTest, ReadsEveryKindOfValidation) {
  const auto validation = [&](const std::string& text) {
    return Read(kMinimal + ("validation: " + text + "\n")).validation;
  };
  EXPECT_EQ(validation("none").kind, ValidationSpec::Kind::kNone);
  EXPECT_EQ(validation("{column: set}").kind, ValidationSpec::Kind::kSetColumn);
  const ValidationSpec column = validation("{column: group, values: [random, 2]}");
  EXPECT_EQ(column.kind, ValidationSpec::Kind::kColumn);
  EXPECT_EQ(column.column, "group");
  EXPECT_EQ(column.values, (std::vector<std::string>{"random", "2"}));
  EXPECT_EQ(validation("{fraction: 0.3}").seed, 1u);
}

TEST_F(ExperimentFileTest, PathsFollowTheFile) {
  const std::string here = std::filesystem::current_path().string();
  std::filesystem::current_path(folder_);
  std::filesystem::create_directories("d");
  Write("d/e.yaml", Replaced(kMinimal, "[a.csv, sub/b.csv]", "../a.csv"));
  const Experiment experiment = ReadExperimentFile("d/e.yaml");
  std::filesystem::current_path(here);
  EXPECT_EQ(experiment.robot_file, "d/robot.yaml");
  EXPECT_EQ(experiment.measurement_files, std::vector<std::string>{"a.csv"});
}

TEST_F(ExperimentFileTest, ReadsThePracticeCases) {
  const std::string folder = test::SharedFolder() + "/data/practice/";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "the shared data are not here: " << folder;
  for (const char* name : {"case000", "case007", "case010", "case014", "case021"}) {
    const Experiment experiment = ReadExperimentFile(folder + name + "/experiment.yaml");
    EXPECT_EQ(experiment.estimate.geometry.names.size(), 18u);
    EXPECT_EQ(experiment.estimate.compliance.names.size(), 6u);
    EXPECT_EQ(experiment.validation.fraction, 0.3);
    EXPECT_TRUE(std::filesystem::exists(experiment.robot_file));
    EXPECT_TRUE(std::filesystem::exists(experiment.measurement_files.at(0)));
  }
}

struct BadExperiment {
  const char* name;
  const char* from;
  const char* to;
  std::vector<std::string> says;
};

class BadExperimentTest : public ExperimentFileTest, public ::testing::WithParamInterface<BadExperiment> {};

TEST_P(BadExperimentTest, IsRefusedWithWords) {
  const BadExperiment& bad = GetParam();
  std::vector<std::string> says = {"e.yaml:"};
  says.insert(says.end(), bad.says.begin(), bad.says.end());
  EXPECT_TRUE(SaysInOrder(Error(Replaced(kFull, bad.from, bad.to)), says));
}

INSTANTIATE_TEST_SUITE_P(
    Scene, BadExperimentTest,
    ::testing::Values(
        BadExperiment{"schema", "experiment/1", "robot/1", {"1: schema", "sagitta/experiment/1"}},
        BadExperiment{"no_robot", "robot: robot.yaml\n", "", {"robot", "missing"}},
        BadExperiment{"robot_misspelt", "robot: robot", "robto: robot", {"2: robto", "'robot'"}},
        BadExperiment{"robot_list", "robot.yaml", "[a]", {"2: robot", "a text"}},
        BadExperiment{"no_measurements", "[geometric.csv, /data/loaded.csv]", "[]", {"3: measurements", "empty"}},
        BadExperiment{"unknown_key", "priors:", "prior:", {"23: prior", "'priors'"}},
        BadExperiment{
            "load_point", "load_point_mm", "load_point_cm", {"4: load_point_cm", "load_point_mm, load_point_m"}},
        BadExperiment{"load_key", "mass_kg: 250", "mass_g: 250", {"5: loads.V250.mass_g", "'mass_kg'"}},
        BadExperiment{"load_mass", "mass_kg: 250", "mass_kg: -1", {"5: loads.V250.mass_kg", "below 0"}},
        BadExperiment{"load_frame", "0.1], frame: base", "0.1], frame: bse", {"5: loads.V250.frame", "'base'"}},
        BadExperiment{"load_none", "V100: {}", "none: {}", {"5: loads.none"}},
        BadExperiment{
            "load_none_in_capitals", "V100: {}", "NONE: {}", {"5: loads.NONE", "or no load?", "written none"}},
        BadExperiment{"load_twice", "V100: {}", "V250: {}", {"5: loads.V250", "twice"}},
        BadExperiment{"tool", "com_mm", "com", {"6: tool.com", "unit", "com_mm, com_m"}},
        BadExperiment{"gravity_zero", "[0, 0, -2]", "[0, 0, 0]", {"7: gravity.direction", "no length"}},
        BadExperiment{
            "gravity_frame", "frame: base, m_per", "frame: flange, m_per", {"7: gravity.frame", "measurement, base"}},
        BadExperiment{"gravity_size", "9.81", "-9.81", {"7: gravity.m_per_s2", "above 0"}},
        BadExperiment{"marker", "279, -16", "x, -16", {"8: markers.M1.xyz_mm[0]", "'x'"}},
        BadExperiment{"station", "rotvec_mrad", "rotvec_mard", {"9: stations.S1.rotvec_mard", "rotvec_mrad"}},
        BadExperiment{"levelled", "levelled: false", "levelled: 0", {"9: stations.S1.levelled", "true or false"}}),
    [](const auto& param) { return std::string(param.param.name); });

INSTANTIATE_TEST_SUITE_P(
    Method, BadExperimentTest,
    ::testing::Values(
        BadExperiment{"sigma_zero", "sigma_mm: 0.05", "sigma_mm: 0", {"10: noise.sigma_mm", "above 0"}},
        BadExperiment{"sigma_unit", "sigma_mm: 0.05", "sigma_um: 50", {"10: noise.sigma_um", "sigma_mm, sigma_m"}},
        BadExperiment{"noise_from", "sigma_mm: 0.05", "from: row", {"10: noise.from", "'rows'"}},
        BadExperiment{"noise_empty", "{sigma_mm: 0.05}", "{}", {"10: noise", "not stated"}},
        BadExperiment{
            "noise_two", "{sigma_mm: 0.05}", "{from: rows, instrument: {range_um: 1}}", {"10: noise", "two sources"}},
        BadExperiment{
            "noise_both", "{sigma_mm: 0.05}", "{sigma_mm: 1, instrument: {range_um: 1}}", {"10: noise", "two sources"}},
        BadExperiment{
            "noise_repeats", "{sigma_mm: 0.05}", "{sigma_mm: 1, from: repeats}", {"10: noise", "two sources"}},
        BadExperiment{
            "noise_residuals", "{sigma_mm: 0.05}", "{sigma_mm: 1, from: residuals}", {"10: noise", "two sources"}},
        BadExperiment{"noise_lambda", "{sigma_mm: 0.05}", "{from: rows, lambda: 1}", {"10: noise.lambda", "unknown"}},
        BadExperiment{
            "noise_iterations", "{sigma_mm: 0.05}", "{from: residuals, iterations: 0}", {"10: noise.iterations"}},
        BadExperiment{"instrument",
                      "{sigma_mm: 0.05}",
                      "{instrument: {range_nm: 1}}",
                      {"10: noise.instrument.range_nm", "range_um, range_mm, range_m"}},
        BadExperiment{
            "instrument_sign", "{sigma_mm: 0.05}", "{instrument: {range_um: -1}}", {"10: noise.instrument", "below 0"}},
        BadExperiment{
            "repeatability", "repeatability_urad: 8", "repeatability: 8", {"11: repeatability", "repeatability_urad"}},
        BadExperiment{"repeatability_sign",
                      "repeatability_urad: 8",
                      "repeatability_urad: -8",
                      {"11: repeatability_urad", "below 0"}},
        BadExperiment{"residual_group",
                      "{sigma_mm: 0.05}",
                      "{from: residuals, group: config-axes}",
                      {"10: noise.group", "'config-axis'"}},
        BadExperiment{"weights", "weights: equal", "weights: eqaul", {"12: weights", "'equal'"}},
        BadExperiment{"covariance", "sandwich", "sandwhich", {"13: covariance", "'sandwich'"}},
        BadExperiment{"loss", "huber", "tukey", {"14: loss", "'tukey'", "none, huber, cauchy"}},
        BadExperiment{"estimate_key", "  markers: false", "  makers: false", {"17: estimate.makers", "'markers'"}},
        BadExperiment{"estimate_word", "compliance: all", "compliance: al", {"19: estimate.compliance", "'al'", "all"}},
        BadExperiment{"estimate_twice", "[p_x1, dq2]", "[p_x1, p_x1]", {"18: estimate.geometry[1]", "twice"}},
        BadExperiment{"effects", "effects: none", "effects: [joint_harmonic]", {"21: estimate.effects", "all or none"}},
        BadExperiment{"compensator", "[a_x, Kc]", "[a_x, KC]", {"20: estimate.gravity_compensator[1]", "'Kc'"}},
        BadExperiment{"prior_sigma", "sigma: 5", "sigma: 0", {"23: priors.compensator/Kc.sigma", "above 0"}},
        BadExperiment{"prior_missing", ", sigma: 5", "", {"23: priors.compensator/Kc.sigma", "missing"}},
        BadExperiment{"fraction", "fraction: 0.3", "fraction: 1", {"24: validation.fraction", "between 0 and 1"}},
        BadExperiment{"seed", "seed: 12", "seed: -1", {"24: validation.seed", "whole number"}},
        BadExperiment{"by", "by: time", "by: tmie", {"24: validation.by", "'time'"}},
        BadExperiment{
            "two_splits", "fraction: 0.3", "fraction: 0.3, column: set", {"24: validation", "column, fraction"}},
        BadExperiment{
            "no_values", "{fraction: 0.3, seed: 12, by: time}", "{column: group}", {"24: validation", "values"}},
        BadExperiment{"validation_word", "{fraction: 0.3, seed: 12, by: time}", "some", {"24: validation", "none"}},
        BadExperiment{"significance", "0.05\n", "0\n", {"significance"}}),
    [](const auto& param) { return std::string(param.param.name); });

TEST_F(ExperimentFileTest, NamesTheFile) {
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { ReadExperimentFile(Path("absent.yaml")); }), {"absent.yaml", "no such file"}));
  EXPECT_TRUE(SaysInOrder(Error(""), {"e.yaml: ", "empty"}));
}

}  // namespace
}  // namespace sagitta::experiment_file_test

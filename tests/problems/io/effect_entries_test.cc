#include "problems/io/effect_entries.h"

#include <gtest/gtest.h>

#include "models/effects/catalogue.h"
#include "problems/compliance_home.h"
#include "problems/input_error.h"
#include "problems/io/robot_file.h"
#include "problems/robot_structure.h"

namespace sagitta::effect_entries_test {
namespace {

const char* kRobot = R"(schema: sagitta/robot/1
joints:
  - {name: A1, type: revolute}
  - {name: A2, type: revolute}
kinematics:
  chain:
    - {Rz: A1}
    - {Tx_mm: 400, error: p_x1}
    - {Ry: A2, error: dq2}
effects:
)";

Robot WithEntry(const std::string& entry) { return ReadRobotText(kRobot + ("  - " + entry + "\n"), "robot.yaml"); }

std::string Refusal(const std::string& entry) {
  try {
    WithEntry(entry);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(EffectEntries, AnAngleAmongTheSettingsIsReadInItsUnit) {
  const std::string amplitude = ", amplitude_urad: 60}", start = "{effect: hysteresis, joint: A2, ";
  const std::string path = WithEntry(start + "width_deg: 2.5" + amplitude).effects[0].Path();
  EXPECT_EQ(WithEntry(start + "width_mrad: 43.63323129985824" + amplitude).effects[0].Path(), path);
  EXPECT_NE(Refusal(start + "width_deg: 2.5, width_rad: 0.1" + amplitude).find("in two units"), std::string::npos);
}

TEST(EffectEntries, ACompensatorIsSentToItsHome) {
  const std::string words = Refusal("{effect: gravity_compensator, joint: A2}");
  EXPECT_NE(words.find("gravity_compensator: {joint"), std::string::npos) << words;
}

// A joint gives way by one number, which is estimated under one name.
TEST(EffectEntries, AJointsComplianceHasOneHome) {
  const Robot robot = WithEntry("{effect: joint_compliance, joint: A2, k_urad_per_Nm: 0.3}");
  EXPECT_TRUE(robot.effects.empty());
  ASSERT_EQ(robot.compliances.size(), 1u);
  EXPECT_EQ(robot.compliances[0].joint, 1);
  EXPECT_NEAR(robot.compliances[0].nodes[0].k, 0.3e-6, 1e-18);
  const std::string both = std::string("compliance: {A2: {k_urad_per_Nm: 0.2}}\n");
  const std::string entry = "  - {effect: joint_compliance, joint: A2, k_urad_per_Nm: 0.3}\n";
  const Robot sum = ReadRobotText(kRobot + entry + both, "robot.yaml");
  EXPECT_TRUE(sum.effects.empty());
  EXPECT_NEAR(sum.compliances[0].nodes[0].k, 0.5e-6, 1e-18);
  // One with a prior of its own, and one that is less than nothing, have none there.
  for (const std::string own : {"k_urad_per_Nm: 0.3, prior_sigma: {k_urad_per_Nm: 0.1}", "k_urad_per_Nm: -0.3"}) {
    EXPECT_EQ(WithEntry("{effect: joint_compliance, joint: A2, " + own + "}").effects.size(), 1u) << own;
  }
  // Of one that a diagnosis found the prior was the diagnosis's own.
  Robot found = WithEntry("{effect: joint_compliance, joint: A2, k_urad_per_Nm: 0.3, prior_sigma: {k_urad_per_Nm: 1}}");
  MoveCompliancesHome(PriorOfCompliance::kIsDropped, &found);
  EXPECT_TRUE(found.effects.empty());
  ASSERT_EQ(found.compliances.size(), 1u);
  EXPECT_NEAR(found.compliances[0].nodes[0].k, 0.3e-6, 1e-18);
}

TEST(EffectEntries, EveryEffectOfTheCatalogueReadsBackAsWritten) {
  for (const std::string entry :
       {"{effect: frozen_geometry, error: dq2, value_deg: 0.01}",
        "{effect: joint_compliance, joint: A2, k_urad_per_Nm: -0.3}",
        "{effect: compliance_hardening, joint: A2, k3_urad_per_kNm3: 2}",
        "{effect: transverse_compliance, joint: A1, ku_urad_per_Nm: 0.1, kv_urad_per_Nm: 0.2}",
        "{effect: link_gravity, joint: A2, mass_kg: 80, mx_kgm: 20, my_kgm: 0, mz_kgm: -3}",
        "{effect: self_weight_sag, joint: A2, about: u, s2x_urad: 5, s2y_urad: 6, s2z_urad: 7}",
        "{effect: base_compliance, kx_urad_per_Nm: 0.01, ky_urad_per_Nm: 0.02}",
        "{effect: payload, load: heavy, dmass_kg: 3}",
        "{effect: joint_harmonic, joint: A2, order: 3, cos_urad: 210, sin_urad: -4}",
        "{effect: axis_wobble, joint: A1, order: 1, u_cos_urad: 1, u_sin_urad: 2, v_cos_urad: 3, v_sin_urad: 4}",
        "{effect: encoder_gain, joint: A1, gain_ppm: 120}",
        "{effect: joint_coupling, joint: A2, driver: A1, ratio_ppm: 30}",
        "{effect: backlash, joint: A2, by: torque, half_gap_urad: 40}",
        "{effect: joint_slip, joint: A2, after_s: 120.5, jump_urad: 80}",
        "{effect: thermal_growth, growth_ppm_per_K: 11}",
        "{effect: station_drift, station: S1, x_um_per_h: 1, y_um_per_h: 2, z_um_per_h: 3, rx_urad_per_h: 4, "
        "ry_urad_per_h: 5, rz_urad_per_h: 6}",
        "{effect: station_scale, station: S1, scale_ppm: 9}",
        "{effect: marker_shift, marker: M1, after_s: 60, x_mm: 0.1, y_mm: 0.2, z_mm: 0.3}",
        "{effect: warm_up, station: S1, tau_s: 1800, x_um: 1, y_um: 2, z_um: 3, rx_urad: 4, ry_urad: 5, rz_urad: 6}",
        "{effect: station_eccentricity, station: S1, az_cos_urad: 1, az_sin_urad: 2, el_cos_urad: 3, el_sin_urad: 4}",
        "{effect: station_range_offset, station: S1, offset_um: 12}",
        "{effect: load_com, load: heavy, dx_mm: 10, dy_mm: -20, dz_mm: 30}",
        "{effect: hysteresis, joint: A2, width_deg: 2.5, amplitude_urad: 60}",
        "{effect: marker_acceptance, marker: M1, offset_um: 40}",
        "{effect: marker_acceptance, marker: M1, axis: -x, offset_um: 40}",
        "{effect: station_refraction, station: S1, curvature_urad_per_m: 0.8}",
        "{effect: backlash, joint: A2, by: torque, width_Nm: 35, half_gap_urad: 40}",
        "{effect: thermal_growth, lag_s: 600, growth_ppm_per_K: 11}"}) {
    const Robot robot = WithEntry(entry);
    ASSERT_EQ(robot.effects.size(), 1u) << entry;
    const Robot again = ReadRobotText(RobotToYaml(robot), "again.yaml");
    ASSERT_EQ(again.effects.size(), 1u);
    EXPECT_EQ(again.effects[0].Path(), robot.effects[0].Path());
    ASSERT_EQ(again.effects[0].values.size(), robot.effects[0].values.size());
    for (size_t i = 0; i < robot.effects[0].values.size(); ++i) {
      EXPECT_NEAR(again.effects[0].values[i], robot.effects[0].values[i], 1e-12 * std::abs(robot.effects[0].values[i]));
    }
  }
}

// How large a parameter may be, in its unit: of those that have such a prior.
TEST(EffectEntries, PriorsReadBackAsWritten) {
  const Robot robot =
      WithEntry("{effect: joint_harmonic, joint: A2, order: 2, cos_urad: 210, prior_sigma: {sin_mrad: 0.3}}");
  ASSERT_EQ(robot.effects[0].prior_sigmas.size(), 2u);
  EXPECT_EQ(robot.effects[0].prior_sigmas[0], 0.0);
  EXPECT_NEAR(robot.effects[0].prior_sigmas[1], 3e-4, 1e-15);
  const Robot again = ReadRobotText(RobotToYaml(robot), "again.yaml");
  EXPECT_EQ(again.effects[0].prior_sigmas, robot.effects[0].prior_sigmas);
  EXPECT_TRUE(WithEntry("{effect: joint_harmonic, joint: A2, order: 2}").effects[0].prior_sigmas.empty());
  const std::string start = "{effect: joint_harmonic, joint: A2, order: 2, prior_sigma: ";
  EXPECT_NE(Refusal(start + "{sin_urad: -3}}").find("positive"), std::string::npos);
  EXPECT_NE(Refusal(start + "{tan_urad: 3}}").find("tan_urad"), std::string::npos);
  EXPECT_NE(Refusal(start + "3}").find("robot.yaml"), std::string::npos);
}

TEST(EffectEntries, UnitsAreThoseOfTheFormat) {
  const Robot robot = WithEntry("{effect: joint_harmonic, joint: A2, order: 2, cos_urad: 210, sin_urad: 0}");
  EXPECT_EQ(robot.effects[0].Path(), "effect/joint_harmonic[order=2]/A2");
  EXPECT_NEAR(robot.effects[0].values[0], 210e-6, 1e-15);
  EXPECT_NEAR(WithEntry("{effect: joint_harmonic, joint: A2, order: 2, cos_mrad: 0.2}").effects[0].values[0], 2e-4,
              1e-15);
  EXPECT_NEAR(WithEntry("{effect: marker_shift, marker: M1, after_s: 6, y_m: 0.002}").effects[0].values[1], 2e-3,
              1e-15);
  EXPECT_NEAR(WithEntry("{effect: station_drift, station: S1, x_um_per_h: 36}").effects[0].values[0], 1e-8, 1e-18);
  EXPECT_NEAR(WithEntry("{effect: station_range_offset, station: S1, offset_um: 25}").effects[0].values[0], 25e-6,
              1e-18);
  EXPECT_NEAR(WithEntry("{effect: station_range_offset, station: S1, offset_mm: 0.025}").effects[0].values[0], 25e-6,
              1e-18);
  EXPECT_NEAR(WithEntry("{effect: load_com, load: V, dy_mm: -20}").effects[0].values[1], -0.02, 1e-15);
}

// A setting at its default is not part of the name: files and results from before it existed keep theirs.
TEST(EffectEntries, SettingsAtTheirDefaultAreSilent) {
  EXPECT_EQ(WithEntry("{effect: thermal_growth, growth_ppm_per_K: 11}").effects[0].Path(),
            "effect/thermal_growth/robot");
  EXPECT_EQ(WithEntry("{effect: thermal_growth, lag_s: 0}").effects[0].Path(), "effect/thermal_growth/robot");
  EXPECT_EQ(WithEntry("{effect: thermal_growth, lag_s: 600}").effects[0].Path(),
            "effect/thermal_growth[lag_s=600]/robot");
  EXPECT_EQ(WithEntry("{effect: backlash, joint: A2, by: torque}").effects[0].Path(), "effect/backlash[by=torque]/A2");
  EXPECT_EQ(WithEntry("{effect: backlash, joint: A2, by: torque, width_Nm: 35}").effects[0].Path(),
            "effect/backlash[by=torque,width_Nm=35]/A2");
  EXPECT_EQ(WithEntry("{effect: backlash, joint: A2}").effects[0].Path(), "effect/backlash[by=approach]/A2");
  // The last joint of this arm turns about y.
  EXPECT_EQ(WithEntry("{effect: marker_acceptance, marker: M1, axis: y}").effects[0].Path(),
            "effect/marker_acceptance/M1");
  EXPECT_EQ(WithEntry("{effect: marker_acceptance, marker: M1, axis: z}").effects[0].Path(),
            "effect/marker_acceptance[axis=z]/M1");
}

// What a number of functions can mean is said where it is read.
TEST(EffectEntries, WholeNumbersHaveARange) {
  const std::string place = ", x_mm: 0, y_mm: 0, z_mm: 0, spread_mm: 100";
  const std::string down = ", down_x: 0, down_y: 0, down_z: -1";
  const auto entry = [](const std::string& start, int number) { return start + std::to_string(number) + "}"; };
  const struct {
    std::string start;
    int least, most;
  } cases[] = {
      {"{effect: learnt_pull" + place + ", degree: ", 0, 1},
      {"{effect: learnt_station_motion, station: S1, by: place" + place + ", reach: 3, degree: ", 1, 2},
      {"{effect: learnt_load_shift, load: V" + down + ", degree: ", 1, 10},
      {"{effect: learnt_marker_motion, marker: M1, by: gravity" + down + ", degree: ", 1, 10},
      {"{effect: learnt_surface_deviation, joint: A1, driver: A1, with: A2, from: 0, to: 1, from_with: 0, to_with: 1, "
       "knots: ",
       2, 30},
      {"{effect: joint_harmonic, joint: A1, order: ", 1, 1000}};
  for (const auto& one : cases) {
    EXPECT_EQ(Refusal(entry(one.start, one.least)), "");
    EXPECT_EQ(Refusal(entry(one.start, one.most)), "");
    const std::string range = "from " + std::to_string(one.least) + " to " + std::to_string(one.most) + " is needed";
    EXPECT_NE(Refusal(entry(one.start, one.least - 1)).find(range), std::string::npos) << one.start;
    EXPECT_NE(Refusal(entry(one.start, one.most + 1)).find(range), std::string::npos) << one.start;
  }
}

// The zero of an axis that slides jumps by a length.
TEST(EffectEntries, ErrorsOfAJointThatSlidesAreLengths) {
  std::string rail = kRobot;
  rail.replace(rail.find("{name: A2, type: revolute}"), 26, "{name: A2, type: prismatic}");
  rail.replace(rail.find("{Ry: A2, error: dq2}"), 20, "{Ty: A2, error: dq2}");
  const auto value = [&rail](const std::string& entry) {
    return ReadRobotText(rail + ("  - " + entry + "\n"), "robot.yaml").effects[0].values[0];
  };
  EXPECT_NEAR(value("{effect: joint_slip, joint: A2, after_s: 10, jump_um: 80}"), 80e-6, 1e-18);
  EXPECT_NEAR(value("{effect: backlash, joint: A2, half_gap_um: 25}"), 25e-6, 1e-18);
  EXPECT_NEAR(value("{effect: joint_slip, joint: A1, after_s: 10, jump_urad: 80}"), 80e-6, 1e-18);
  EXPECT_THROW(value("{effect: joint_slip, joint: A2, after_s: 10, jump_urad: 80}"), InputError);
}

// A wave in urad over an angle, a loop over degrees, a ratio of angles.
TEST(EffectEntries, EffectsOfTurningJointsAreRefusedOnASlide) {
  std::string rail = kRobot;
  rail.replace(rail.find("{name: A2, type: revolute}"), 26, "{name: A2, type: prismatic}");
  rail.replace(rail.find("{Ry: A2, error: dq2}"), 20, "{Ty: A2, error: dq2}");
  for (const char* entry :
       {"{effect: joint_harmonic, joint: A2, order: 1}", "{effect: hysteresis, joint: A2, width_deg: 20}",
        "{effect: axis_wobble, joint: A2, order: 1}", "{effect: compliance_hardening, joint: A2}",
        "{effect: self_weight_sag, joint: A2}", "{effect: joint_coupling, joint: A1, driver: A2}"}) {
    try {
      ReadRobotText(rail + ("  - " + std::string(entry) + "\n"), "robot.yaml");
      ADD_FAILURE() << entry;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("'A2' slides"), std::string::npos) << error.what();
    }
  }
  EXPECT_NO_THROW(ReadRobotText(rail + "  - {effect: transverse_compliance, joint: A2}\n", "robot.yaml"));
  Robot robot = ReadRobotText(rail + "  - {effect: joint_harmonic, joint: A1, order: 1}\n", "robot.yaml");
  robot.effects[0].target = "A2";
  EXPECT_THROW(CheckEffectSpecs(robot), InputError);
}

TEST(EffectEntries, SettingsHaveTheirRanges) {
  EXPECT_NE(Refusal("{effect: hysteresis, joint: A2, width_deg: 0}").find("above 0"), std::string::npos);
  EXPECT_NE(Refusal("{effect: hysteresis, joint: A2}").find("width_deg"), std::string::npos);
  EXPECT_NE(Refusal("{effect: warm_up, station: S1, tau_s: -5}").find("above 0"), std::string::npos);
  EXPECT_NE(Refusal("{effect: thermal_growth, lag_s: -5}").find("above 0"), std::string::npos);
  EXPECT_NE(Refusal("{effect: backlash, joint: A2, width_Nm: 5}").find("by=torque"), std::string::npos);
}

TEST(EffectEntries, RefusalsNameKeyAndSpelling) {
  EXPECT_NE(Refusal("{effect: joint_harmonic, joint: A9}").find("A9"), std::string::npos);
  EXPECT_NE(Refusal("{effect: joint_harmonic, target: A2, order: 1}").find("joint: A2"), std::string::npos);
  EXPECT_NE(Refusal("{effect: joint_harmonic, joint: A2, order: 1, cos_m: 1}").find("cos_urad"), std::string::npos);
  EXPECT_NE(Refusal("{effect: joint_slip, joint: A2, jump_urad: 1}").find("after_s"), std::string::npos);
  EXPECT_NE(Refusal("{effect: backlash, joint: A2, by: aproach}").find("approach"), std::string::npos);
  EXPECT_NE(Refusal("{effect: joint_harmonic, joint: A2, order: 1.5}").find("whole number"), std::string::npos);
}

}  // namespace
}  // namespace sagitta::effect_entries_test

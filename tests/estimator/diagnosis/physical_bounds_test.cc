// What sign and size of an effect say: a load off by more than itself, loads exchanged, moments counted twice.
#include "estimator/diagnosis/physical_bounds.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estimator/report/diagnosis_caution_words.h"
#include "estimator/report/diagnosis_words.h"
#include "problems/excitation.h"
#include "tests/support/loaded_kr270.h"

namespace sagitta::physical_bounds_test {
namespace {

using ::testing::HasSubstr;
using Kind = PhysicalBounds::Kind;

// A KR 270 that was measured under 250 kg and under 100 kg, and an effect that its model holds.
DiagnosedModel Measured(const EffectSpec& spec, const Vector3<double>& moment = Vector3<double>::Zero(),
                        const std::vector<JointCompliance>& compliances = {{1, {{0.0, 3e-7}}, false}}) {
  test::LoadedTruth truth;
  truth.loads["V250"].moment = moment;
  truth.loads["V100"] = truth.loads["V250"];
  truth.loads["V100"].force *= 100.0 / 250.0;
  test::LoadedDesign design;
  design.loads = {"V250", "V100"};
  Measurements data = test::LoadedRows(design, truth);
  test::Measure(test::ExactPoints(truth, data), 3e-5, 1, &data);
  test::LoadedSetup setup = test::SetupFor(truth);
  setup.robot.compliances = compliances;
  setup.robot.effects = {spec};
  DiagnosedModel model;
  model.problem = std::make_shared<CalibrationProblem>(MakeCalibrationProblem(setup.robot, data, setup.experiment));
  model.estimate.parameters = model.problem->parameters;
  SetHoldLimits(*model.problem, &model.estimate.parameters);
  return model;
}

ParameterEstimate Row(const EffectSpec& spec, const std::string& name, Quantity quantity, double value, double half) {
  ParameterEstimate row;
  row.name = spec.Path() + "/" + name;
  row.quantity = quantity;
  row.value = value;
  row.ci95 = {value - half, value + half};
  return row;
}

PhysicalBounds OfPayload(const std::string& load, double more, double half) {
  const EffectSpec spec{"payload", load, {}, {}};
  return PhysicalBoundsOf(Measured(spec), spec, {Row(spec, "dmass", Quantity::kMass, more, half)});
}

TEST(PhysicalBounds, ALoadIsOffByLessThanItself) {
  EXPECT_EQ(OfPayload("V250", 20.0, 5.0).kind, Kind::kUsual);
  EXPECT_EQ(OfPayload("V100", 90.0, 5.0).kind, Kind::kUsual);
  const PhysicalBounds heavy = OfPayload("V100", 300.0, 5.0);
  EXPECT_EQ(heavy.kind, Kind::kMoreThanLoad);
  EXPECT_FALSE(heavy.IsPlausible());
  EXPECT_THAT(PhysicalInWords(heavy), HasSubstr("it would weigh 400 kg, and 100 kg are stated"));
  EXPECT_EQ(OfPayload("V250", -300.0, 5.0).kind, Kind::kMoreThanLoad);
}

// 250 kg in its place; or, where the compliances are estimated, too, as much more than the other as that is stated to
// be more than it: 250^2 / 100 = 625 kg.
TEST(PhysicalBounds, ExchangedLoadsAreSaid) {
  for (const double weighs : {250.0, 625.0}) {
    const PhysicalBounds bounds = OfPayload("V100", weighs - 100.0 + 3.0, 5.0);
    EXPECT_EQ(bounds.kind, Kind::kLoadsExchanged) << weighs;
    EXPECT_FALSE(bounds.IsPlausible());
    EXPECT_THAT(PhysicalInWords(bounds), HasSubstr("that of V250 exchanged"));
  }
}

PhysicalBounds OfPoint(const Vector3<double>& moment, const Vector3<double>& shift) {
  const EffectSpec spec{"load_com", "V250", {}, {}};
  std::vector<ParameterEstimate> rows;
  for (int axis = 0; axis < 3; ++axis) {
    rows.push_back(Row(spec, std::string("d") + "xyz"[axis], Quantity::kLength, shift[axis], 2e-3));
  }
  return PhysicalBoundsOf(Measured(spec, moment), spec, rows);
}

// Centres of gravity off by centimetres are what machines show, and so are 20 cm: of a load that is a metre long.
TEST(PhysicalBounds, APointOffByItsWholeOffsetMayBeMomentsCountedTwice) {
  const Vector3<double> point = test::LoadedTruth().loads.at("V250").point;
  ASSERT_GT(point.norm(), 0.05);
  const Vector3<double> moment(0.0, 300.0, 0.0), none = Vector3<double>::Zero();
  const PhysicalBounds twice = OfPoint(moment, -point + Vector3<double>(1e-3, 0.0, -1e-3));
  EXPECT_EQ(twice.kind, Kind::kAboutItsPoint);
  EXPECT_THAT(PhysicalInWords(twice), HasSubstr("about the flange"));
  EXPECT_EQ(OfPoint(none, -point).kind, Kind::kUsual);  // nothing states a moment
  EXPECT_EQ(OfPoint(moment, -0.5 * point).kind, Kind::kUsual);
  EXPECT_EQ(OfPoint(moment, {0.2, -0.2, 0.2}).kind, Kind::kUsual);
}

// Stated 2.1 urad/Nm, found 0.6 less: as much as machines show.
TEST(PhysicalBounds, ACorrectionOfAStatedComplianceIsJudgedByTheSum) {
  const EffectSpec spec{"joint_compliance", "A2", {}, {}};
  const auto with = [&](const std::vector<JointCompliance>& compliances) {
    return PhysicalBoundsOf(Measured(spec, Vector3<double>::Zero(), compliances), spec,
                            {Row(spec, "k", Quantity::kCompliance, -0.6e-6, 0.02e-6)});
  };
  EXPECT_EQ(with({}).kind, Kind::kNegative);
  const PhysicalBounds correction = with({{1, {{0.0, 2.1e-6}}, false}});
  EXPECT_TRUE(correction.IsPlausible());
  EXPECT_EQ(PhysicalInWords(correction), "it corrects the robot file: 2.1 urad/Nm there, 1.5 urad/Nm found");
}

TEST(PhysicalBounds, AGapIsNotLessThanNothing) {
  const EffectSpec spec{"backlash", "A3", {{"by", "torque"}}, {}};
  const auto of = [&](double value) {
    return PhysicalBoundsOf(Measured(spec), spec, {Row(spec, "half_gap", Quantity::kSmallAngle, value, 20e-6)}).kind;
  };
  EXPECT_EQ(of(60e-6), Kind::kUsual);
  EXPECT_EQ(of(-15e-6), Kind::kUsual);  // it may be none
  EXPECT_EQ(of(-60e-6), Kind::kNegative);
  EXPECT_EQ(of(3e-3), Kind::kTooLarge);
}

}  // namespace
}  // namespace sagitta::physical_bounds_test

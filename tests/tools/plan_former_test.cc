// What a former estimate says of its own errors: a plan counts what is more than chance.
#include "tests/tools/program.h"

namespace sagitta::test::plan_former_test {
namespace {

class PlanFormerTest : public ProgramTest {
 protected:
  // Of an estimate that is off by `rms` at points that it predicted to `predicted`, mm; more: further members of the
  // file, figures: of its cross-validation.
  nlohmann::json PlanAfter(double rms, double predicted, const std::string& figures, const std::string& more,
                           const std::vector<std::string>& flags = {"--poses=16"}) const {
    const std::string former =
        Write("estimate.json", R"({"model_error": {"factor": )" + factor_ + R"(}, "cross_validation": {"rms_mm": )" +
                                   std::to_string(rms) + R"(, "predicted_rms_mm": )" + std::to_string(predicted) +
                                   figures + "}" + more + "}");
    std::vector<std::string> arguments = {"plan",
                                          Published("kr270/experiment.yaml"),
                                          "--nomove",
                                          "--pool=60",
                                          "--quiet",
                                          "--out=" + Path("plan"),
                                          "--sigma_mm=0.05",
                                          "--model_error=" + former};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return ReadJson("plan/plan.json");
  }
  std::string factor_ = "1.5";
  static bool HasField(const nlohmann::json& plan) { return plan.at("predicted").contains("model_field"); }
  static bool Says(const nlohmann::json& plan, const std::string& words) {
    return plan.at("words").dump().find(words) != std::string::npos;
  }
};

// 15 poses of a model that is true, 18 degrees of freedom: rms^2 18 / chi2_18(0.99), 18/34.8 = 0.517, is below
// predicted^2 for up to 1.39 times what was predicted.
TEST_F(PlanFormerTest, ChanceIsNoModelError) {
  const nlohmann::json plan = PlanAfter(0.040, 0.0372, R"(, "prediction_p_value": 0.18)", R"(, "fit": {"dof": 18})");
  EXPECT_FALSE(HasField(plan));
  EXPECT_DOUBLE_EQ(plan.at("predicted").at("position_rms_with_model_error_mm"),
                   1.5 * plan.at("predicted").at("position_rms_mm").get<double>());
  EXPECT_TRUE(Says(plan, "no more than noise and chance explain (p = 0.18)")) << plan.at("words");
  // As far, and its own test says that it is more.
  EXPECT_TRUE(HasField(PlanAfter(0.040, 0.0372, R"(, "prediction_p_value": 0.009)", "")));
  // Without one, by chi-square.
  for (const char* none : {"", R"(, "prediction_p_value": null)"}) {
    EXPECT_FALSE(HasField(PlanAfter(1.37 * 0.04, 0.04, none, R"(, "fit": {"dof": 18})")));
    EXPECT_TRUE(HasField(PlanAfter(1.42 * 0.04, 0.04, none, R"(, "fit": {"dof": 18})")));
    const nlohmann::json untested = PlanAfter(0.08, 0.04, none, "");
    EXPECT_FALSE(HasField(untested));
    EXPECT_TRUE(Says(untested, "or no p-value and degrees of freedom to test it by")) << untested.at("words");
  }
}

// Noise that was found from residuals, beyond the plan's own: the p-value is of another prediction.
TEST_F(PlanFormerTest, ALittleMoreNoiseIsNoModelError) {
  const std::string p = R"(, "prediction_p_value": 0.4)";
  const auto found = [](const std::string& sigma_mm) {
    return R"(, "fit": {"dof": 327}, "sigma": {"stated": false, "scaled": false, "a_posteriori": 1.0, "estimated_mm": )" +
           sigma_mm + "}";
  };
  EXPECT_FALSE(HasField(PlanAfter(0.0534, 0.0540, p, found("0.0508"))));
  const nlohmann::json real = PlanAfter(0.25, 0.25, p, found("0.2"));
  ASSERT_TRUE(HasField(real));
  EXPECT_NEAR(real.at("predicted").at("model_field").at("rms_mm"), std::sqrt(0.25 * 0.25 - 0.0625 * 0.0625), 1e-9);
}

// What is no error costs no pose.
TEST_F(PlanFormerTest, AccuracyCountsWithNoChance) {
  factor_ = "1.0";
  const auto poses = [&](const std::string& p) {
    const nlohmann::json plan = PlanAfter(0.060, 0.052, R"(, "prediction_p_value": )" + p, "", {"--accuracy_mm=0.085"});
    EXPECT_LE(plan.at("predicted").at("position_rms_with_model_error_mm"), 0.085);
    return plan.at("poses").get<int>();
  };
  EXPECT_LT(poses("0.18"), poses("0.0001"));
}

}  // namespace
}  // namespace sagitta::test::plan_former_test

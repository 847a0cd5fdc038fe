#include "estimator/results/torques_json.h"

#include <nlohmann/json.hpp>

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

}  // namespace

nlohmann::ordered_json TorquesToJson(const CalibrationProblem& problem, const TorqueComparison& comparison) {
  Json json = Json::object();
  if (comparison.joints.empty()) return json;
  json["used"] = comparison.measured_count ? "measured" : "model";
  json["joints"] = Json::array();
  for (const JointTorqueComparison& line : comparison.joints) {
    const Joint& joint = problem.robot().chain.joints[line.joint];
    const std::string unit = joint.type == JointType::kRevolute ? "_Nm" : "_N";
    json["joints"].push_back({{"joint", joint.name},
                              {"shots", line.shots},
                              {"measured_rms" + unit, line.measured_rms},
                              {"modelled_rms" + unit, line.modelled_rms},
                              {"difference_rms" + unit, line.difference_rms},
                              {"slope", line.slope},
                              {"offset" + unit, line.offset},
                              {"correlation", line.correlation}});
  }
  json["words"] = comparison.words;
  return json;
}

}  // namespace sagitta

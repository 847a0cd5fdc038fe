#include "estimator/results/measured_conditions.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "estimator/report/diagnosis_words.h"
#include "estimator/report/results_words.h"
#include "estimator/results/measured_joints.h"
#include "models/constants.h"
#include "models/effects/catalogue.h"

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kBeyond = 0.1;         // of the largest load: as of ranges (OutsideBy)
constexpr double kLeastKelvin = 0.1;    // a thermometer of a workshop says no less
constexpr double kLeastSeconds = 60.0;  // nothing that drifts or cools changes within a minute

void Widen(double value, std::optional<MeasuredInterval>* range) {
  if (!*range) *range = MeasuredInterval{value, value};
  (*range)->least = std::min((*range)->least, value);
  (*range)->most = std::max((*range)->most, value);
}

double ForceOf(const ShotInput& shot) {
  Vector3<double> force = Vector3<double>::Zero();
  for (const AppliedWrench& wrench : shot.conditions.load_wrenches) force += wrench.force;
  return force.norm();
}

// Effects that go with it; what happened at a moment stays as it is.
std::vector<std::string> DrivenBy(EffectDriver driver, const Robot& robot) {
  std::vector<std::string> names;
  for (const EffectSpec& spec : robot.effects) {
    const EffectDefinition& effect = *FindEffect(robot, spec.effect);
    if (!effect.IsOfAMoment() && effect.DrivenBy(spec) == driver) names.push_back(Title(robot, spec));
  }
  return names;
}

struct Beyond {
  size_t shots = 0;
  double most = 0.0;  // by which one is beyond; of loads, the largest

  void Count(double by, double size) {
    if (!(by > 0.0)) return;
    ++shots;
    most = std::max(most, size);
  }
};

Json RangeToJson(const std::optional<MeasuredInterval>& range) {
  return range ? Json::array({range->least, range->most}) : Json(nullptr);
}

// What an effect of a moment states, s of the campaign's clock.
std::optional<double> MomentStated(const Robot& robot, const EffectSpec& spec) {
  const std::string setting = MomentOf(robot, spec);
  if (setting.empty()) return std::nullopt;
  return spec.NumberSetting(setting, 0.0);
}

// The last fitted shot before a moment and the first one after it.
MeasuredInterval ReadingsAround(const CalibrationProblem& problem, double moment) {
  MeasuredInterval around{-kInfinity, kInfinity};
  for (const int k : problem.CalibrationObservations()) {
    const ShotConditions& shot = problem.shot_inputs()[problem.data().observations[k].shot].conditions;
    if (!shot.has_time) continue;
    if (shot.time <= moment) around.least = std::max(around.least, shot.time);
    if (shot.time > moment) around.most = std::min(around.most, shot.time);
  }
  return around;
}

Json MomentsToJson(const CalibrationProblem& problem) {
  Json list = Json::array();
  for (const EffectSpec& spec : problem.robot().effects) {
    const std::optional<double> moment = MomentStated(problem.robot(), spec);
    if (!moment) continue;
    const MeasuredInterval around = ReadingsAround(problem, *moment);
    if (std::isfinite(around.least) && std::isfinite(around.most))
      list.push_back({{"after_s", *moment}, {"between_s", RangeToJson(around)}});
  }
  return list;
}

// A sentence on each effect whose moment lies between the same two readings as shots that are asked for.
void AddAroundMoments(const KnownRobot& known, const CalibrationProblem& problem, std::vector<std::string>* words) {
  for (const EffectSpec& spec : known.robot.effects) {
    const std::optional<double> moment = MomentStated(known.robot, spec);
    const auto found =
        moment ? known.measured_conditions.moments.find(*moment) : known.measured_conditions.moments.end();
    if (found == known.measured_conditions.moments.end()) continue;
    const auto is_between = [&](const ShotInput& shot) {
      const ShotConditions& at = shot.conditions;
      return at.has_time && at.time > found->second.least && at.time < found->second.most;
    };
    const auto count = std::count_if(problem.shot_inputs().begin(), problem.shot_inputs().end(), is_between);
    if (count > 0)
      words->push_back(
          ShotsAroundMoment(static_cast<size_t>(count), problem.shot_inputs().size(), Title(known.robot, spec)));
  }
}

std::optional<MeasuredInterval> RangeFrom(const JsonValue& json) {
  if (json.IsNull()) return std::nullopt;
  const std::vector<JsonValue> ends = json.Items();
  if (ends.size() != 2 || ends[1].Number() < ends[0].Number()) json.Fail("[least, most] is expected");
  return MeasuredInterval{ends[0].Number(), ends[1].Number()};
}

}  // namespace

Json MeasuredConditionsToJson(const CalibrationProblem& problem) {
  MeasuredConditions measured;
  for (const int k : problem.CalibrationObservations()) {
    const int s = problem.data().observations[k].shot;
    const Shot& shot = problem.data().shots[s];
    if (shot.has_time) Widen(shot.time, &measured.time);
    if (shot.has_temperature) Widen(shot.temperature, &measured.temperature);
    measured.load_force = std::max(measured.load_force, ForceOf(problem.shot_inputs()[s]));
  }
  return {{"time_s", RangeToJson(measured.time)},
          {"temperature_degC", RangeToJson(measured.temperature)},
          {"load_force_N", measured.load_force > 0.0 ? Json(measured.load_force) : Json(nullptr)},
          {"moments", MomentsToJson(problem)}};
}

MeasuredConditions MeasuredConditionsFrom(const JsonValue& json) {
  MeasuredConditions measured;
  measured.are_stated = true;
  measured.time = RangeFrom(json.Get("time_s"));
  measured.temperature = RangeFrom(json.Get("temperature_degC"));
  const JsonValue force = json.Get("load_force_N");
  if (!force.IsNull()) measured.load_force = force.PositiveNumber();
  const auto moments = json.Find("moments");
  for (const JsonValue& moment : moments ? moments->Items() : std::vector<JsonValue>()) {
    if (const auto between = RangeFrom(moment.Get("between_s")))
      measured.moments[moment.Get("after_s").Number()] = *between;
  }
  return measured;
}

std::vector<std::string> BeyondMeasuredInWords(const KnownRobot& known, const CalibrationProblem& problem) {
  const MeasuredConditions& measured = known.measured_conditions;
  if (!measured.are_stated) return {};
  Beyond late, warm, heavy;
  for (size_t s = 0; s < problem.data().shots.size(); ++s) {
    const Shot& shot = problem.data().shots[s];
    const ShotInput& input = problem.shot_inputs()[s];
    const double by_time = shot.has_time && measured.time ? OutsideBy(*measured.time, shot.time, kLeastSeconds) : 0.0;
    const double by_heat = shot.has_temperature && measured.temperature
                               ? OutsideBy(*measured.temperature, shot.temperature, kLeastKelvin)
                               : 0.0;
    const double force = input.terms.elastic.empty() ? 0.0 : ForceOf(input);
    late.Count(by_time, by_time);
    warm.Count(by_heat, by_heat);
    heavy.Count(force - (1.0 + kBeyond) * measured.load_force, force);
  }
  const size_t all = problem.data().shots.size();
  std::vector<std::string> words;
  const std::vector<std::string> by_time = DrivenBy(EffectDriver::kTime, known.robot);
  if (late.shots > 0 && !by_time.empty()) words.push_back(ShotsBeyondTime(late.shots, all, late.most, by_time));
  const std::vector<std::string> by_heat = DrivenBy(EffectDriver::kTemperature, known.robot);
  if (warm.shots > 0 && !by_heat.empty()) words.push_back(ShotsBeyondTemperature(warm.shots, all, warm.most, by_heat));
  if (heavy.shots > 0) words.push_back(ShotsBeyondLoads(heavy.shots, all, heavy.most, measured.load_force));
  AddAroundMoments(known, problem, &words);
  return words;
}

}  // namespace sagitta

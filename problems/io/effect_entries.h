// The `effects` list of a robot file, for robot_reader.cc and robot_writer.cc.
//
//   {effect: joint_harmonic, joint: A3, order: 1, cos_urad: 210, sin_urad: 0}
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "models/effects/effect.h"
#include "models/robot.h"
#include "problems/io/yaml_reader.h"

namespace sagitta {

std::vector<EffectSpec> ReadEffects(const YamlValue& value, const Robot& robot);
// Of this use, which is named in the end as if the settings that it leaves out had been stated.
void ReadSettings(const EffectDefinition& definition, const Robot& robot, YamlMap* entry, EffectSpec* use);
nlohmann::ordered_json EffectToJson(const Robot& robot, const EffectSpec& spec);
// {order: 1}: numbers are numbers; empty where an effect is none of the list.
nlohmann::ordered_json SettingsToJson(const Robot& robot, const EffectSpec& spec);

// The entry `prior_sigma: {cos_urad: 50}` of what has these parameters; empty where there is none.
std::vector<double> ReadPriors(const std::vector<EffectParameter>& parameters, YamlMap* entry);
void PutPriors(const std::vector<EffectParameter>& parameters, const std::vector<double>& sigmas,
               nlohmann::ordered_json* entry);
// Of a spring, L to Kc.
std::vector<EffectParameter> SpringParameters();

// cos_urad, k_urad_per_Nm: a parameter with its unit, as files write it.
std::string ParameterKey(const std::string& name, Quantity quantity);

// The key under which an entry names its target: joint, error, station ...; ""
// for effects on the base or the whole robot.
std::string TargetKey(EffectTarget target);

}  // namespace sagitta

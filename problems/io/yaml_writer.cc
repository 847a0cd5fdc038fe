#include "problems/io/yaml_writer.h"

#include <yaml-cpp/yaml.h>

#include <cctype>
#include <nlohmann/json.hpp>

#include "problems/text.h"

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

bool HasContainers(const Json& json) {
  for (const auto& item : json) {
    if (item.is_structured() && !item.empty()) return true;
  }
  return false;
}

// Plain where no reader could mistake it for a number, null or syntax.
bool IsPlainText(const std::string& text) {
  if (text.empty() || (!std::isalpha(static_cast<unsigned char>(text[0])) && text[0] != '_') || text.back() == ' ') {
    return false;
  }
  for (const char* word :
       {"null", "Null", "NULL", "true", "True", "TRUE", "false", "False", "FALSE", "yes", "Yes", "YES",
        "no",   "No",   "NO",   "on",   "On",   "ON",   "off",   "Off",   "OFF",   "y",   "n"}) {
    if (text == word) return false;
  }
  return text.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-. /()") ==
         std::string::npos;
}

void EmitText(const std::string& text, YAML::Emitter* emitter) {
  if (!IsPlainText(text)) *emitter << YAML::DoubleQuoted;
  *emitter << text;
}

void Emit(const Json& json, bool is_root, YAML::Emitter* emitter) {
  if (json.is_object()) {
    *emitter << (is_root || HasContainers(json) ? YAML::Block : YAML::Flow) << YAML::BeginMap;
    for (const auto& [key, value] : json.items()) {
      *emitter << YAML::Key;
      EmitText(key, emitter);
      *emitter << YAML::Value;
      Emit(value, false, emitter);
    }
    *emitter << YAML::EndMap;
  } else if (json.is_array()) {
    *emitter << (HasContainers(json) ? YAML::Block : YAML::Flow) << YAML::BeginSeq;
    for (const Json& item : json) Emit(item, false, emitter);
    *emitter << YAML::EndSeq;
  } else if (json.is_string()) {
    EmitText(json.get<std::string>(), emitter);
  } else {
    *emitter << (json.is_number_float() ? FormatNumber(json.get<double>()) : json.dump());
  }
}

}  // namespace

std::string JsonToYaml(const Json& json) {
  YAML::Emitter emitter;
  Emit(json, true, &emitter);
  return std::string(emitter.c_str()) + "\n";
}

}  // namespace sagitta

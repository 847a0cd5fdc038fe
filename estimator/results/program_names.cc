#include "estimator/results/program_names.h"

#include <algorithm>
#include <set>

#include "estimator/results/program_loads.h"
#include "problems/input_error.h"
#include "problems/io/programs/program_text.h"
#include "problems/text.h"

namespace sagitta {
namespace {

// As the controller compares names.
std::string Folded(const std::string& name, const RobotProgram& program) {
  return program.traits().names_have_case ? name : UpperCase(name);
}

template <typename Value>
void AddNames(const std::map<std::string, Value>& from, std::set<std::string>* names) {
  for (const auto& [name, value] : from) names->insert(name);
}

InputError NameOfNothing(const RobotProgram& program, const std::string& key, const std::string& kind,
                         const std::string& name, const std::set<std::string>& known) {
  std::vector<std::string> names;
  for (const std::string& one : known) {
    if (!one.empty()) names.push_back(one);
  }
  std::string hint = "the program has " + Enumerate(names);
  // A misspelt name in small letters is as near to one in capitals.
  for (const std::string& one : names) {
    const std::string folded = Folded(name, program);
    if (NearestName(folded, {Folded(one, program)}).empty()) continue;
    hint = "did you mean " + one + "?";
    break;
  }
  return InputError({program.path, 0, key}, "the program has no " + kind + " '" + name + "'", hint);
}

template <typename Value>
std::map<std::string, Value> ByNames(const RobotProgram& program, const std::map<std::string, Value>& stated,
                                     const std::set<std::string>& known, const std::string& key,
                                     const std::string& kind) {
  std::map<std::string, Value> named;
  for (const auto& [name, value] : stated) {
    const auto own = std::find_if(known.begin(), known.end(), [&, &said = name](const std::string& one) {
      return Folded(one, program) == Folded(said, program);
    });
    if (own == known.end() && NameStandsIn(program, name)) continue;
    if (own == known.end()) throw NameOfNothing(program, key, kind, name, known);
    if (!named.emplace(*own, value).second)
      throw InputError({program.path, 0, key}, "'" + *own + "' is given twice", "the program ignores case");
  }
  return named;
}

}  // namespace

ProgramScene SceneByNames(const RobotProgram& program, const ProgramScene& stated) {
  std::set<std::string> tools = {kFlangeName, kDefaultName}, frames = {kWorldName, kDefaultName};
  std::set<std::string> loads = {kDefaultName};
  AddNames(program.tools, &tools);
  AddNames(program.frames, &frames);
  AddNames(program.loads, &loads);
  for (const ProgramPoint& point : program.points) {
    tools.insert(point.tool);
    frames.insert(point.frame);
    loads.insert({point.load, point.other_load});
  }
  ProgramScene scene = stated;
  scene.tools = ByNames(program, stated.tools, tools, "--tools_mm_deg", "tool");
  scene.frames = ByNames(program, stated.frames, frames, "--frames_mm_deg", "frame");
  scene.loads = ByNames(program, stated.loads, loads, "--loads_kg_mm", "load");
  return scene;
}

}  // namespace sagitta

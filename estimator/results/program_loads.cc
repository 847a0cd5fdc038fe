#include "estimator/results/program_loads.h"

#include <set>

#include "estimator/report/results_words.h"
#include "models/constants.h"
#include "problems/input_error.h"
#include "problems/io/trimmed.h"
#include "problems/io/units.h"
#include "problems/range.h"
#include "problems/text.h"

namespace sagitta {
namespace {

// Whether any load can move the flange: of a rigid arm it makes no difference.
bool Bends(const Robot& robot) { return !robot.compliances.empty() || !robot.effects.empty(); }

class LoadsReader {
 public:
  LoadsReader(const KnownRobot& known, const RobotProgram& program, const ProgramScene& scene)
      : program_(program), scene_(scene) {
    loads_.loading = known.loading;
    const auto flange = scene.tools.find(kFlangeName);
    if (flange != scene.tools.end()) flange_ = flange->second;
  }

  ProgramLoads Read() {
    for (const ProgramPoint& point : program_.points) ReadPoint(point);
    if (loads_.needs_flange) MakeToolALoad();
    for (const auto& [name, points] : used_) loads_.notes.push_back(LoadUsedInWords(name, *Stated(name), points));
    for (const auto& [name, points] : unknown_) loads_.notes.push_back(LoadUnknownInWords(name, points));
    return std::move(loads_);
  }

 private:
  // By the user, else by the file.
  const ProgramLoad* Stated(const std::string& name) const {
    const auto own = scene_.loads.find(name.empty() ? kDefaultName : name);
    if (own != scene_.loads.end()) return &own->second;
    const auto in_file = program_.loads.find(name);
    return in_file == program_.loads.end() ? nullptr : &in_file->second;
  }

  void ReadPoint(const ProgramPoint& point) {
    loads_.of_point.push_back(Shot().load);
    loads_.unclear.emplace_back();
    if (!point.untouched.empty()) return;
    if (!point.other_load.empty()) {
      loads_.unclear.back() = LoadOfTwoInWords(point.load, point.other_load);
      return;
    }
    const ProgramLoad* load = Stated(point.load);
    if (load == nullptr) {
      if (point.load.empty()) return;
      ++unknown_[point.load];
      const auto why = program_.unclear_loads.find(point.load);
      loads_.unclear.back() = LoadNotStatedInWords(point.load, why == program_.unclear_loads.end() ? "" : why->second);
      return;
    }
    const std::string name = point.load.empty() ? kDefaultName : point.load;
    ++used_[name];
    if (load->mass == 0.0 && loads_.loading.tool_mass == 0.0) return;
    loads_.needs_flange = true;
    const std::string in_estimate = name + " of the program";
    LoadSpec& spec = loads_.loading.loads[in_estimate];
    spec.mass = load->mass;
    spec.point = Vector3<double>(flange_ * load->centre);
    loads_.of_point.back() = in_estimate;
  }

  // The tool of the estimate would hang on the arm at every point; it does where the program states no load.
  void MakeToolALoad() {
    Experiment& loading = loads_.loading;
    if (loading.tool_mass == 0.0) return;
    loads_.notes.push_back(ToolReplacedInWords(loading.tool_mass));
    const std::string name = "tool of the estimate";
    loading.loads[name].mass = loading.tool_mass;
    loading.loads[name].point = loading.tool_com;
    loading.tool_mass = 0.0;
    for (std::string& load : loads_.of_point) {
      if (load == Shot().load) load = name;
    }
  }

  const RobotProgram& program_;
  const ProgramScene& scene_;
  Pose<double> flange_;
  ProgramLoads loads_;
  std::map<std::string, int> used_, unknown_;
};

}  // namespace

ProgramLoads LoadsOfProgram(const KnownRobot& known, const RobotProgram& program, const ProgramScene& scene) {
  if (scene.load.empty() && Bends(known.robot)) return LoadsReader(known, program, scene).Read();
  ProgramLoads loads;
  loads.loading = known.loading;
  loads.of_point.assign(program.points.size(), scene.load.empty() ? Shot().load : scene.load);
  loads.unclear.resize(program.points.size());
  return loads;
}

namespace {

// A: "NAME=1,2; OTHER=3,4".
std::vector<std::pair<std::string, std::vector<double>>> NamedNumbers(const std::string& text, const std::string& key,
                                                                      size_t count, const std::string& hint) {
  std::vector<std::pair<std::string, std::vector<double>>> named;
  if (text.empty()) return named;
  const auto trimmed = [](const std::string& part) { return std::string(Trimmed(part)); };
  for (const std::string& entry : SplitText(text, ';')) {
    const size_t equals = entry.rfind('=');
    const std::string name = trimmed(entry.substr(0, equals));
    if (equals == std::string::npos || name.empty())
      throw InputError({"", 0, key}, "'" + trimmed(entry) + "' names nothing", hint);
    std::vector<double> numbers;
    for (const std::string& part : SplitText(entry.substr(equals + 1), ',')) {
      const std::optional<double> number = ParseNumber(trimmed(part));
      if (!number) throw InputError({"", 0, key}, "'" + trimmed(part) + "' of '" + name + "' is no number", hint);
      numbers.push_back(*number);
    }
    if (numbers.size() != count) {
      throw InputError({"", 0, key}, std::to_string(count) + " numbers are expected for '" + name + "'", hint);
    }
    named.emplace_back(name, numbers);
  }
  return named;
}

}  // namespace

std::map<std::string, ProgramLoad> LoadsFromText(const std::string& text, const std::string& key) {
  std::map<std::string, ProgramLoad> loads;
  const std::string hint = "NAME=mass,x,y,z in kg and mm of the controller's flange; several with ';' between";
  for (const auto& [name, numbers] : NamedNumbers(text, key, 4, hint)) {
    if (numbers[0] < 0.0) throw InputError({"", 0, key}, "the mass of '" + name + "' is below 0", hint);
    const ProgramLoad load = {numbers[0], Vector3<double>(numbers[1], numbers[2], numbers[3]) / 1e3};
    if (!loads.emplace(name, load).second) throw InputError({"", 0, key}, "'" + name + "' is given twice");
  }
  return loads;
}

Eigen::VectorXd StartFrom(const std::vector<double>& numbers, const Chain& chain, const std::string& key) {
  if (!numbers.empty() && static_cast<int>(numbers.size()) != chain.num_joints()) {
    throw InputError({"", 0, key}, std::to_string(chain.num_joints()) + " joint values are expected");
  }
  Eigen::VectorXd start(static_cast<Eigen::Index>(numbers.size()));
  for (size_t j = 0; j < numbers.size(); ++j) {
    const bool turns = chain.joints[j].type == JointType::kRevolute;
    const double value = numbers[j] * (turns ? kDegree : kMillimetre);
    CheckIn(turns ? allowed::kAngle : allowed::kCoordinate, value, key);
    start[static_cast<Eigen::Index>(j)] = value;
  }
  return start;
}

std::vector<int> TurnJointsFrom(const std::vector<double>& numbers, int joints, const std::string& key) {
  std::vector<int> turns;
  for (const double number : numbers) {
    const bool is_joint = number == static_cast<int>(number) && number >= 1 && number <= joints;
    if (is_joint) turns.push_back(static_cast<int>(number) - 1);
  }
  const size_t distinct = std::set<int>(turns.begin(), turns.end()).size();
  if (!numbers.empty() && (numbers.size() != 3 || distinct != 3)) {
    throw InputError({"", 0, key}, "three joints are expected, each once, counted from 1", key + "=1,4,6");
  }
  return turns;
}

}  // namespace sagitta

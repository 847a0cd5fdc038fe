#include "estimator/results/program_compensation.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <set>

#include "estimator/compensation/joint_solutions.h"
#include "estimator/report/compensation_words.h"
#include "estimator/report/results_words.h"
#include "estimator/results/flange_side.h"
#include "estimator/results/measured_conditions.h"
#include "estimator/results/measured_joints.h"
#include "estimator/results/program_loads.h"
#include "estimator/results/program_names.h"
#include "models/constants.h"
#include "problems/input_error.h"
#include "problems/io/trimmed.h"
#include "problems/io/units.h"
#include "problems/text.h"

namespace sagitta {
namespace {

std::string WithoutBlanks(const std::string& text) { return std::string(Trimmed(text)); }

// A frame or tool by its name in the file.
class Scene {
 public:
  Scene(const RobotProgram& program, const ProgramScene& scene) : program_(program), scene_(scene) {}

  // Nothing: it is stated nowhere; its name is then among those asked for.
  std::optional<Pose<double>> ToolInFlange(const std::string& name) {
    return Find(name, kFlangeName, scene_.tools, program_.tools, &tools_asked_);
  }
  std::optional<Pose<double>> FrameInBase(const std::string& name) {
    return Find(name, kWorldName, scene_.frames, program_.frames, &frames_asked_);
  }
  void ThrowWhatIsAsked() const;

 private:
  static std::optional<Pose<double>> Find(const std::string& name, const char* root,
                                          const std::map<std::string, Pose<double>>& stated,
                                          const std::map<std::string, Pose<double>>& in_file,
                                          std::set<std::string>* asked) {
    const auto at_root = stated.find(root);
    if (at_root == stated.end()) asked->insert(root);
    const Pose<double> from_root = at_root == stated.end() ? Pose<double>() : at_root->second;
    if (name == root) return at_root == stated.end() ? std::nullopt : std::make_optional(from_root);
    const std::string key = name.empty() ? kDefaultName : name;
    if (const auto own = stated.find(key); own != stated.end()) return Product(from_root, own->second);
    if (const auto own = in_file.find(key); own != in_file.end()) return Product(from_root, own->second);
    asked->insert(key);
    return std::nullopt;
  }

  const RobotProgram& program_;
  const ProgramScene& scene_;
  std::set<std::string> tools_asked_, frames_asked_;
};

void Scene::ThrowWhatIsAsked() const {
  const auto list = [](const std::set<std::string>& names) {
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : "; ") + name + "=x,y,z,roll,pitch,yaw";
    return text;
  };
  const bool tools = !tools_asked_.empty(), frames = !frames_asked_.empty();
  if (!tools && !frames) return;
  std::vector<std::string> names;
  for (const std::string& name : tools_asked_) names.push_back("tool '" + name + "'");
  for (const std::string& name : frames_asked_) names.push_back("frame '" + name + "'");
  std::string hint = tools ? "--tools_mm_deg='" + list(tools_asked_) + "'" : "";
  if (frames) hint += (tools ? " " : "") + std::string("--frames_mm_deg='") + list(frames_asked_) + "'";
  hint +=
      ", fixed axes; 'same' for one that stands where that of the robot file does: flange is the controller's flange "
      "in that of the robot file, world its world (base) frame in the base of the robot file, default what holds for "
      "points that name none";
  throw InputError({program_.path, 0, tools ? "--tools_mm_deg" : "--frames_mm_deg"},
                   "the program has poses, but does not state the " + Enumerate(names), hint);
}

// The points as rows of a target file.
class TargetTable {
 public:
  TargetTable(const std::string& name, const Chain& chain) {
    table_.file.path = name;
    table_.file.header = {"target"};
    for (int j = 0; j < chain.num_joints(); ++j) {
      const bool turns = chain.joints[static_cast<size_t>(j)].type == JointType::kRevolute;
      table_.file.header.push_back("q" + std::to_string(j + 1) + (turns ? "_rad" : "_m"));
    }
    for (const char* column : {"x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad", "load"})
      table_.file.header.push_back(column);
  }
  void Add(const ProgramPoint& point, const Eigen::VectorXd& q, const std::optional<Pose<double>>& flange,
           const std::string& load) {
    std::vector<std::string> cells = {point.name};
    for (const double value : q) cells.push_back(FormatNumber(value));
    const Vector3<double> turn = flange ? RotationVector(flange->rotation) : Vector3<double>::Zero();
    for (int a = 0; a < 3; ++a) cells.push_back(flange ? FormatNumber(flange->translation[a]) : "");
    for (int a = 0; a < 3; ++a) cells.push_back(flange ? FormatNumber(turn[a]) : "");
    cells.push_back(load);
    table_.file.rows.push_back({point.line, cells});
  }
  bool empty() const { return table_.file.rows.empty(); }
  CsvTable Take() { return std::move(table_); }

 private:
  CsvTable table_;
};

// What is solved of a program: rows of targets and the points they are of.
struct Prepared {
  std::vector<ProgramPointResult> results;
  std::vector<int> points;                     // of each row
  std::vector<Pose<double>> frame, from_tool;  // of each row: frame in base, flange from tool
  std::vector<Eigen::VectorXd> meant;          // of each row: joints by the nominal robot
};

Eigen::VectorXd VectorOf(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

StatedBranch BranchOf(const ProgramPoint& point, const ProgramScene& stated) {
  StatedBranch branch = point.branch;
  branch.turn_joints = stated.turn_joints;
  return branch;
}

// Whether the solution is the one nearest to where the arm is.
bool GoesByBefore(const StatedBranch& branch) {
  return branch.near.empty() ? branch.from_before || !branch.states_anything() : branch.also_from_before;
}

// The one solution of all motions to the pose, which come from these places. Empty: one that is not known.
BranchFound FindOnlyBranch(const Chain& nominal, const Pose<double>& flange, StatedBranch branch,
                           const std::vector<Eigen::VectorXd>& places, const Eigen::VectorXd& last) {
  constexpr double kSame = 1e-3;  // rad
  if (!GoesByBefore(branch)) return FindBranch(nominal, flange, branch, last);
  std::optional<BranchFound> found;
  if (!branch.near.empty()) found = FindBranch(nominal, flange, branch, last);
  branch.near.clear();
  for (const Eigen::VectorXd& place : places) {
    if (found && !found->why_not.empty()) break;
    const BranchFound other = FindBranch(nominal, flange, branch, place);
    bool is_same = !found || other.why_not.empty();
    for (int j = 0; found && is_same && j < found->q.size(); ++j)
      is_same = std::abs(std::remainder(other.q[j] - found->q[j], 2 * kPi)) < kSame;
    if (!found || !other.why_not.empty()) found = other;
    if (!is_same && found->why_not.empty()) found->why_not = TwoSolutionsMeant();
  }
  return found ? *found : FindBranch(nominal, flange, branch, {});
}

// Where the motions to point i come from; `solved`: joints at the points that are known so far.
std::vector<Eigen::VectorXd> PlacesBefore(const ProgramPoint& point, size_t i, const Eigen::VectorXd& start,
                                          const std::vector<Eigen::VectorXd>& solved) {
  std::vector<Eigen::VectorXd> places;
  for (const int before : point.before) {
    if (before == static_cast<int>(i)) continue;
    places.push_back(before >= 0               ? solved[static_cast<size_t>(before)]
                     : before == kPlaceOfStart ? start
                                               : Eigen::VectorXd());
  }
  return places;
}

void Prepare(const RobotProgram& program, const ProgramScene& stated, const ProgramLoads& loads, const Chain& nominal,
             TargetTable* table, Prepared* prepared) {
  Scene scene(program, stated);
  for (const ProgramPoint& point : program.points) {
    if (point.is_joints || !point.untouched.empty()) continue;
    scene.ToolInFlange(point.tool);
    scene.FrameInBase(point.frame);
  }
  if (loads.needs_flange) scene.ToolInFlange(kFlangeName);
  scene.ThrowWhatIsAsked();
  std::vector<size_t> way(program.points.size());
  std::iota(way.begin(), way.end(), size_t{0});
  std::stable_sort(way.begin(), way.end(),
                   [&](size_t a, size_t b) { return program.points[a].used_at < program.points[b].used_at; });
  prepared->results.resize(way.size());
  std::vector<Eigen::VectorXd> solved(way.size());
  Eigen::VectorXd last = stated.start;
  for (const size_t i : way) {
    const ProgramPoint& point = program.points[i];
    ProgramPointResult& result = prepared->results[i];
    result.point = static_cast<int>(i);
    result.untouched = point.untouched.empty() ? loads.unclear[i] : point.untouched;
    if (point.is_joints && point.untouched.empty()) solved[i] = VectorOf(program.JointValues(point));
    if (!result.untouched.empty()) continue;
    Pose<double> frame, from_tool;
    std::optional<Pose<double>> flange;
    Eigen::VectorXd q;
    if (point.is_joints) {
      q = solved[i];
    } else {
      std::vector<double> numbers;
      for (const TextNumber& number : point.numbers) numbers.push_back(number.value);
      frame = *scene.FrameInBase(point.frame);
      from_tool = Inverse(*scene.ToolInFlange(point.tool));
      flange = Product(Product(frame, PoseFrom(program.traits().notation, numbers)), from_tool);
      const BranchFound found =
          FindOnlyBranch(nominal, *flange, BranchOf(point, stated), PlacesBefore(point, i, stated.start, solved), last);
      result.untouched = found.why_not;
      if (!found.why_not.empty()) continue;
      q = found.q;
    }
    last = solved[i] = q;
    prepared->points.push_back(static_cast<int>(i));
    prepared->frame.push_back(frame);
    prepared->from_tool.push_back(from_tool);
    prepared->meant.push_back(q);
    table->Add(point, q, flange, loads.of_point[i]);
  }
}

bool IsCorrected(const CompensatedTarget& target) {
  return target.solution.status == TargetStatus::kOk || target.solution.status == TargetStatus::kSingular;
}

// A correction moves joints by what the robot's errors are, tenths of a degree, unless the pose is close to a
// singularity: with the wrist at angle a out of line an orientation that is off by e turns joints 4 and 6 by e / sin a.
constexpr double kLargestMove = 2.0 * kDegree;

// The revolute joint that the correction moves most, and by what, rad. -1: none.
int MostMoved(const Chain& chain, const Eigen::VectorXd& moves) {
  int most = -1;
  for (int j = 0; j < chain.num_joints(); ++j) {
    if (chain.joints[static_cast<size_t>(j)].type != JointType::kRevolute) continue;
    if (most < 0 || std::abs(moves[j]) > std::abs(moves[most])) most = j;
  }
  return most;
}

std::vector<std::string> JointsAt(const Chain& chain, const std::vector<int>& joints, const Eigen::VectorXd& q) {
  std::vector<std::string> words;
  for (const int j : joints) words.push_back(JointStandsInWords(chain.joints[static_cast<size_t>(j)].name, q[j]));
  return words;
}

// Judges the correction of a point: why the point stays as it is, or what there is to say of it.
void Judge(const Chain& nominal, const ProgramPoint& point, const StatedBranch& branch, const Eigen::VectorXd& meant,
           ProgramPointResult* result) {
  const CompensatedTarget& target = *result->solution;
  const Eigen::VectorXd& q = target.solution.q;
  if (!IsCorrected(target)) {
    result->untouched = std::string(StatusName(target.solution.status)) + ": " + target.words;
    return;
  }
  const int most = MostMoved(nominal, q - meant);
  const double move = most < 0 ? 0.0 : std::abs(q[most] - meant[most]);
  const std::string joint = most < 0 ? "" : nominal.joints[static_cast<size_t>(most)].name;
  const bool is_singular = target.solution.status == TargetStatus::kSingular;
  if (point.is_joints && (is_singular || move > kLargestMove)) {
    result->untouched = JointTargetStaysInWords(joint, move, is_singular);
    return;
  }
  if (move > kLargestMove) result->moves = JointMovesInWords(joint, move);
  if (point.is_joints) return;
  const BranchKept kept = KeepsBranch(nominal, branch, meant, q);
  const std::vector<std::string> out = JointsAt(nominal, kept.out, q);
  if (!kept.is_near) {
    result->untouched = OtherConfigurationInWords(out);
  } else if (!kept.is_exact()) {
    result->leaves = Enumerate(out);
  }
}

}  // namespace

std::map<std::string, Pose<double>> FramesFromText(const std::string& text, const std::string& key) {
  std::map<std::string, Pose<double>> frames;
  if (text.empty()) return frames;
  const char* kHint = "NAME=x,y,z,roll,pitch,yaw in mm and deg; NAME=same; several with ';' between";
  for (const std::string& entry : SplitText(text, ';')) {
    const size_t equals = entry.rfind('=');
    const std::string name = WithoutBlanks(entry.substr(0, equals));
    if (equals == std::string::npos || name.empty()) {
      throw InputError({"", 0, key}, "'" + WithoutBlanks(entry) + "' is no frame", kHint);
    }
    Pose<double> pose;
    const std::string value = WithoutBlanks(entry.substr(equals + 1));
    if (value != "same") {
      std::vector<double> numbers;
      for (const std::string& part : SplitText(value, ',')) {
        const std::optional<double> number = ParseNumber(WithoutBlanks(part));
        if (!number)
          throw InputError({"", 0, key}, "'" + WithoutBlanks(part) + "' of '" + name + "' is no number", kHint);
        numbers.push_back(*number);
      }
      if (numbers.size() != 6) throw InputError({"", 0, key}, "six numbers are expected for '" + name + "'", kHint);
      pose = PoseFrom(PoseNotation::kWprDegrees, numbers);
    }
    if (!frames.emplace(name, pose).second) throw InputError({"", 0, key}, "'" + name + "' is given twice");
  }
  return frames;
}

void CheckProgramLoad(const KnownRobot& known, const std::string& load, const std::string& key) {
  if (load.empty() || load == Shot().load) return;
  std::vector<std::string> weighed;
  for (const auto& [name, stated] : known.loading.loads) {
    if (stated.mass) weighed.push_back(name);
  }
  if (std::find(weighed.begin(), weighed.end(), load) != weighed.end()) return;
  throw InputError({known.file, 0, key}, "the estimate does not say what load '" + load + "' weighs",
                   (weighed.empty() ? "" : "it says so of " + Enumerate(weighed) + "; ") + "state loads: {" + load +
                       ": {mass_kg: …}} in the experiment and calibrate again, or correct a table of targets with "
                       "columns fx_N, fy_N, fz_N");
}

void CheckProgramIsKept(const std::string& program, const std::string& out, const std::string& key) {
  std::error_code ignored;
  if (!std::filesystem::equivalent(program, out, ignored)) return;
  throw InputError({out, 0, key}, "this would replace the program itself",
                   "a corrected program that is corrected again is wrong: keep the original");
}

CompensatedProgram CompensateProgram(const KnownRobot& known, RobotProgram program, const ProgramScene& stated,
                                     int threads, const std::function<void(size_t done)>& progress) {
  if (!stated.turn_joints.empty() && !program.traits().turns_of_three_joints) {
    throw InputError({program.path, 0, "--turn_joints"}, "only FANUC positions count turns of three joints");
  }
  const std::string& station = StationOfTargets(known);
  const Chain nominal = NominalChain(known);
  CompensatedProgram result;
  result.program = std::move(program);
  const RobotProgram& read = result.program;
  const ProgramScene scene = SceneByNames(read, stated);
  const ProgramLoads loads = LoadsOfProgram(known, read, scene);
  TargetTable table(read.path, nominal);
  Prepared prepared;
  Prepare(read, scene, loads, nominal, &table, &prepared);
  result.program.notes.insert(result.program.notes.end(), loads.notes.begin(), loads.notes.end());
  result.results = std::move(prepared.results);
  result.text = read.text;
  if (table.empty()) return result;
  result.targets = TargetsFromTable(table.Take(), known.robot, station);
  KnownRobot loaded = known;
  loaded.loading = loads.loading;
  const CompensationInput input = MakeCompensationInput(loaded, result.targets, TargetsFrom::kProgram);
  result.beyond = BeyondMeasuredInWords(loaded, input.problem);
  result.solved = Compensate(input, result.targets.rows, threads, progress);
  AddOutsideMeasured(known, &result.solved);
  std::vector<CorrectedPoint> corrected;
  std::vector<Configuration> arrived;
  for (size_t row = 0; row < result.solved.size(); ++row) {
    const CompensatedTarget& target = result.solved[row];
    ProgramPointResult& of_point = result.results[static_cast<size_t>(prepared.points[row])];
    of_point.solution = target;
    const ProgramPoint& asked = read.points[static_cast<size_t>(prepared.points[row])];
    Judge(nominal, asked, BranchOf(asked, scene), prepared.meant[row], &of_point);
    if (!of_point.untouched.empty()) continue;
    of_point.outside = Enumerate(OutsideMeasured(known, target.solution.q));
    arrived.push_back({asked.name, target.solution.q});
    CorrectedPoint point;
    point.point = prepared.points[row];
    for (const double value : target.solution.q) point.joints.push_back(value);
    const Pose<double> tool_in_base = Product(target.commanded, Inverse(prepared.from_tool[row]));
    point.tool_in_frame = Product(Inverse(prepared.frame[row]), tool_in_base);
    corrected.push_back(point);
  }
  const auto flange = scene.tools.find(kFlangeName);
  if (flange != scene.tools.end() && FacesTheArm(nominal, flange->second)) {
    result.beyond.push_back(ControllersFlangeFacesTheArm());
  }
  const std::string outside = OutsideMeasuredInWords(known, arrived);
  if (!outside.empty()) result.beyond.push_back(outside);
  result.text = WithCorrectedPoints(read, corrected);
  return result;
}

namespace {

// What is said of a line of the program.
using LineWords = std::pair<int, std::string>;

// Motions to named points. What stands in the motion itself is listed as the point that it is.
std::string MotionsToUntouched(const CompensatedProgram& result, std::vector<LineWords>* untouched) {
  const std::vector<ProgramMotion>& motions = result.program.motions;
  if (motions.empty()) return "";
  int corrected = 0;
  std::string notes;
  for (const ProgramMotion& motion : motions) {
    const size_t index = static_cast<size_t>(motion.point);
    const ProgramPoint& point = result.program.points[index];
    const bool is_corrected = result.results[index].untouched.empty();
    corrected += is_corrected;
    if (is_corrected && motion.is_offset) {
      notes += "Note: " + OffsetAdoptsInWords(motion.line, motion.name, point.name) + "\n";
    }
    if (is_corrected || point.line == motion.line) continue;
    untouched->emplace_back(motion.line, motion.name + ": " + PointStaysInWords(point.name, point.line));
  }
  return MotionsAreCorrected(corrected, motions.size()) + "\n" + notes;
}

std::string ListOf(std::vector<LineWords> lines) {
  std::stable_sort(lines.begin(), lines.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::string text;
  for (const auto& [line, words] : lines) text += "  line " + std::to_string(line) + ", " + words + "\n";
  return text;
}

}  // namespace

std::string SummaryOf(const CompensatedProgram& result) {
  int corrected = 0;
  double before = 0.0, u95 = 0.0, u95_rotation = 0.0;
  std::vector<LineWords> untouched, moves, leaves, outside;
  for (const ProgramPointResult& point : result.results) {
    const ProgramPoint& read = result.program.points[static_cast<size_t>(point.point)];
    if (!point.untouched.empty()) {
      untouched.emplace_back(read.line, read.name + ": " + point.untouched);
      continue;
    }
    ++corrected;
    if (!point.moves.empty()) moves.emplace_back(read.line, read.name + ": " + point.moves);
    if (!point.leaves.empty()) leaves.emplace_back(read.line, read.name + ": " + point.leaves);
    if (!point.outside.empty()) outside.emplace_back(read.line, read.name + ": " + point.outside);
    before = std::max(before, point.solution->before_position);
    if (std::isfinite(point.solution->u95_position)) u95 = std::max(u95, point.solution->u95_position);
    if (std::isfinite(point.solution->u95_rotation))
      u95_rotation = std::max(u95_rotation, point.solution->u95_rotation);
  }
  std::string text =
      PointsAreCorrected(result.program.traits().name, corrected, result.results.size(), before, u95, u95_rotation) +
      "\n";
  text += MotionsToUntouched(result, &untouched);
  if (!untouched.empty()) text += "Left as they are\n" + ListOf(untouched);
  if (!moves.empty()) text += PosesWithLargeMoves(kLargestMove) + "\n" + ListOf(moves);
  if (!leaves.empty()) text += PosesWithOtherTurns() + "\n" + ListOf(leaves);
  if (!outside.empty()) text += "Outside the measured joint ranges\n" + ListOf(outside);
  for (const std::string& note : result.program.notes) text += "Note: " + note + "\n";
  const auto& calls = result.program.calls_elsewhere;
  if (!calls.empty()) text += "Note: " + CallsElsewhereInWords(calls) + "\n";
  return text;
}

}  // namespace sagitta

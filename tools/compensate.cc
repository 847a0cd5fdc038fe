// sagitta compensate: corrected joint values for targets.
#include <gflags/gflags.h>

#include <algorithm>
#include <iostream>
#include <map>
#include <optional>

#include "estimator/report/compensation_words.h"
#include "estimator/report/inspection_words.h"
#include "estimator/results/compensation_csv.h"
#include "estimator/results/measured_conditions.h"
#include "estimator/results/measured_joints.h"
#include "estimator/results/program_compensation.h"
#include "problems/input_error.h"
#include "problems/interruption.h"
#include "problems/io/output_files.h"
#include "problems/io/target_file.h"
#include "tools/commands.h"
#include "tools/progress.h"
#include "tools/report/command_words.h"
#include "tools/report/summary.h"
#include "tools/run_command.h"

DEFINE_string(program, "", "FILE: a robot program (KRL, RAPID, URScript, FANUC LS) whose points are the targets");
DEFINE_string(program_out, "", "FILE: where the corrected program goes");
DEFINE_string(tools_mm_deg, "", "NAME=x,y,z,roll,pitch,yaw;…: tools of the program in the flange, or NAME=same");
DEFINE_string(frames_mm_deg, "", "NAME=x,y,z,roll,pitch,yaw;…: frames of the program in the world, or NAME=same");
DEFINE_string(start_deg, "", "q1,q2,…: where the arm is when the program starts (prismatic joints in mm)");
DEFINE_string(load, "", "load of the estimate that the arm carries at every point, or none [what the program states]");
DEFINE_string(loads_kg_mm, "", "NAME=mass,x,y,z;…: loads that the program names, centre of mass in the flange");
DEFINE_string(turn_joints, "", "j1,j2,j3: the joints whose turns FANUC positions count ($SCR_GRP[1].$TURN_AXIS)");

namespace sagitta {
namespace {

void Summarise(const std::vector<CompensatedTarget>& results, const std::string& out) {
  std::map<std::string, int> count;
  double before = 0.0, after = 0.0, u95 = 0.0;
  int solved = 0;
  for (const CompensatedTarget& result : results) {
    ++count[StatusName(result.solution.status)];
    if (result.solution.status != TargetStatus::kOk && result.solution.status != TargetStatus::kSingular) continue;
    ++solved;
    before = std::max(before, result.before_position);
    after = std::max(after, result.solution.left_position);
    u95 = std::isfinite(result.u95_position) ? std::max(u95, result.u95_position) : u95;
  }
  std::vector<std::string> parts;
  for (const auto& [status, number] : count) parts.push_back(std::to_string(number) + " " + status);
  std::cout << Plural(static_cast<int>(results.size()), "target") << ": " << Enumerate(parts) << ": " << out << "\n";
  if (solved == 0) return;
  std::cout << CompensationInWords(before, after, u95) << FlangeOfTheMarkers();
}

ProgramScene SceneFromFlags(const KnownRobot& known) {
  CheckProgramLoad(known, FLAGS_load, "--load");
  ProgramScene scene;
  scene.tools = FramesFromText(FLAGS_tools_mm_deg, "--tools_mm_deg");
  scene.frames = FramesFromText(FLAGS_frames_mm_deg, "--frames_mm_deg");
  if (!FLAGS_start_deg.empty()) {
    scene.start = StartFrom(NumbersOfFlag("start_deg", FLAGS_start_deg), known.robot.chain, "--start_deg");
  }
  scene.load = FLAGS_load;
  scene.loads = LoadsFromText(FLAGS_loads_kg_mm, "--loads_kg_mm");
  if (!FLAGS_turn_joints.empty()) {
    scene.turn_joints =
        TurnJointsFrom(NumbersOfFlag("turn_joints", FLAGS_turn_joints), known.robot.num_joints(), "--turn_joints");
  }
  return scene;
}

void SayWhatTheWayDoes(const KnownRobot& known) {
  const std::string words = WhatTheWayDoes(known);
  if (!words.empty()) std::cout << "Warning: " << words << "\n";
}

void SayWarnings(const std::vector<std::string>& warnings) {
  for (const std::string& words : warnings) std::cout << "Warning: " << words << "\n";
}

int RunProgram(const CommandLine& line) {
  ExpectArguments(line, CompensateCommand(), 1, 1);
  if (FLAGS_program_out.empty()) {
    throw InputError({"", 0, "--program_out"}, "where to write the corrected program is missing", "--program_out=FILE");
  }
  CheckProgramIsKept(FLAGS_program, FLAGS_program_out, "--program_out");
  const OutputFile program_out(FLAGS_program_out);
  std::optional<OutputFile> table_out;
  if (!FLAGS_out.empty()) table_out.emplace(FLAGS_out);
  const KnownRobot known = ReadEstimateFile(line.arguments[0]);
  const ProgramScene scene = SceneFromFlags(known);
  const RobotProgram program = ReadRobotProgram(FLAGS_program, known.robot.num_joints());
  Progress progress(FLAGS_quiet, {{"correcting", 1.0}});
  const std::string all = " of " + std::to_string(program.points.size());
  progress.Say("correcting points: 0" + all);
  const CompensatedProgram result = CompensateProgram(known, program, scene, FLAGS_threads, [&](size_t done) {
    if (done % 256 == 0) progress.Say("correcting points: " + std::to_string(done) + all);
  });
  const bool any = std::any_of(result.results.begin(), result.results.end(),
                               [](const ProgramPointResult& point) { return point.untouched.empty(); });
  std::vector<std::pair<const OutputFile*, std::string>> outputs = {{&program_out, result.text}};
  if (table_out && !result.solved.empty()) {
    outputs.emplace_back(&*table_out, CompensationToCsv(result.targets, result.solved));
  }
  OutputFile::WriteTogether(outputs);
  std::cout << SummaryOf(result) << "Program: " << FLAGS_program_out << "\n";
  if (any) std::cout << FlangeOfTheMarkers();
  SayWhatTheWayDoes(known);
  SayWarnings(result.beyond);
  const std::string carried = WhatFiguresCarry(known);
  if (!carried.empty()) std::cout << carried << "\n";
  return any ? 0 : kNumericalFailure;
}

void RefuseProgramFlags() {
  for (const char* flag :
       {"program_out", "tools_mm_deg", "frames_mm_deg", "start_deg", "load", "loads_kg_mm", "turn_joints"}) {
    if (!IsGiven(flag)) continue;
    throw InputError({"", 0, std::string("--") + flag}, "this is of a robot program", "--program=FILE names one");
  }
}

int RunCompensate(const CommandLine& line) {
  if (!FLAGS_program.empty()) return RunProgram(line);
  RefuseProgramFlags();
  ExpectArguments(line, CompensateCommand(), 2, 2);
  if (FLAGS_out.empty()) throw InputError({"", 0, "--out"}, "where to write is missing", "--out=FILE.csv");
  const OutputFile out(FLAGS_out);
  const KnownRobot known = ReadEstimateFile(line.arguments[0]);
  const Targets targets = ReadTargets(line.arguments[1], known.robot, StationOfTargets(known));
  // Shares as measured on 20000 targets of a UR5.
  std::string csv;
  std::vector<CompensatedTarget> results;
  std::vector<std::string> beyond;
  size_t outside = 0;
  {
    Progress progress(FLAGS_quiet, {{"correcting", 9.0}, {"writing", 1.0}});
    const std::string all = " of " + std::to_string(targets.rows.size());
    progress.Say("correcting targets: 0" + all);
    const CompensationInput input = MakeCompensationInput(known, targets);
    results = Compensate(input, targets.rows, FLAGS_threads, [&](size_t done) {
      if (done % 256 == 0) progress.Say("correcting targets: " + std::to_string(done) + all);
    });
    outside = AddOutsideMeasured(known, &results);
    beyond = BeyondMeasuredInWords(known, input.problem);
    progress.Say("writing the rows");
    csv = CompensationToCsv(targets, results);
    CheckInterruption();
  }
  out.Write(csv);
  Summarise(results, FLAGS_out);
  for (const std::string& note : targets.notes) std::cout << "Targets: " << note << "\n";
  const std::string unread = NotReadInWords(targets.shots.unread_columns);
  if (!unread.empty()) std::cout << unread << "\n";
  SayWhatTheWayDoes(known);
  if (targets.may_be_no_vector) SayWarnings({TargetsHaveRotationVectors()});
  SayWarnings(beyond);
  if (outside > 0) std::cout << TargetsOutsideMeasured(outside) << "\n";
  const std::string carried = WhatFiguresCarry(known);
  if (!carried.empty()) std::cout << carried << "\n";
  const bool any = std::any_of(results.begin(), results.end(), [](const CompensatedTarget& r) {
    return r.solution.status == TargetStatus::kOk || r.solution.status == TargetStatus::kSingular;
  });
  return any ? 0 : kNumericalFailure;
}

}  // namespace

Command CompensateCommand() {
  return {"compensate",
          "corrected joint values for targets, corrected robot programs",
          R"(sagitta compensate ESTIMATE.json TARGETS.csv --out=FILE.csv

TARGETS has the column target and

  q1_deg …                     joint values at which the nominal robot has the flange where it is wanted, or
  x_mm, y_mm, z_mm, rx_mrad, ry_mrad, rz_mrad   the flange in the base frame (rotation vector); q1_deg … next to
                               them choose the branch, otherwise the row before does, or the first solution found.
                               In place of the vector: ow, ox, oy, oz (unit quaternion, scalar first; or qw …),
                               a_deg, b_deg, c_deg (KUKA: Rz(a) Ry(b) Rx(c)), or
                               roll_deg, pitch_deg, yaw_deg (fixed axes: Rz(yaw) Ry(pitch) Rx(roll))

and, where they matter, load, fx_N … mz_Nm, station, temperature_degC, time_s, approach1 … as in measurement files.
Lists of spreadsheets and controllers are read as well: semicolons or tabs, decimal commas, names such as A1 [deg],
X [mm], A [deg] and FANUC's W [deg]; what was read as what is said.
Every row comes back with

  status                       ok, singular (on target, close to a singularity), limit, unreachable,
                               equilibrium_diverged, not_converged
  q1_cmd_deg … (_mm)           corrected joint values: with them the estimated robot, loads included, is on target
  x_cmd_mm … rz_cmd_mrad       the pose to send where the controller keeps its nominal model: a rotation vector in mrad,
                               or, where the targets state these, ow_cmd …, a_cmd_deg …, roll_cmd_deg …
  u95_mm, u95_mrad             95 % of where the flange then is lie within this of the target: what is left and the
                               uncertainty of the estimate; repeatability not in it.
                               The flange is where the markers have it: for tools measured through the same markers
  left_mm, left_mrad           what is left by the estimated model (below 1e-6 where the status is ok)
  before_mm, before_mrad       how far off the uncompensated robot is
  smallest_singular_value      of the Jacobian, lengths in units of the reach
  words                        what there is to say

Exit status 3 where no target could be reached; the rows are written all the same.

With --program=FILE --program_out=FILE the targets are the points of a robot program: KUKA KRL (.src, .dat), ABB RAPID
(.mod), URScript (.script), FANUC LS (.ls). Their numbers are corrected in place, joint values as joint values, poses as
mirrored poses in their frame and for their tool; every other byte stays. What stays as it is, is listed with the
reason. Frames and tools are those of the file; where it does not state them they are asked for, by their names:

  --frames_mm_deg='world=same; BASE_DATA[1]=800,0,500,0,0,90'    in the controller's world, fixed axes
  --tools_mm_deg='flange=same; TOOL_DATA[2]=0,0,180,0,0,0'       in the controller's flange
  --start_deg=0,-90,90,0,0,0    where the arm starts, for poses whose joint solution the file does not state

  --loads_kg_mm='PAYLOAD[1]=12.5,0,0,90'    mass, centre of mass in the controller's flange: loads that it only names

Loads are those of the program where it states them (tooldata and GripLoad, $LOAD and LOAD_DATA, set_payload); --load
uses one of the estimate for all points. --turn_joints=1,4,6: what the turn numbers of FANUC positions count.

--out=FILE.csv then lists every point that was solved as a row.

Examples
  sagitta compensate results/estimate.json targets.csv --out=corrected.csv
  sagitta compensate results/estimate.json --program=weld.mod --program_out=corrected/weld.mod --tools_mm_deg=flange=same --frames_mm_deg=world=same
)",
          {"program", "program_out", "tools_mm_deg", "frames_mm_deg", "start_deg", "load", "loads_kg_mm", "turn_joints",
           "out", "seed", "threads", "quiet"},
          RunCompensate};
}

}  // namespace sagitta

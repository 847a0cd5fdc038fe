// sagitta convert: robot files between formats.
#include <gflags/gflags.h>

#include <cstdint>
#include <filesystem>
#include <iostream>

#include "models/dh_from_chain.h"
#include "models/effects/catalogue.h"
#include "models/effects/effect.h"
#include "problems/choices.h"
#include "problems/failure.h"
#include "problems/input_error.h"
#include "problems/io/files.h"
#include "problems/io/import/dh_text.h"
#include "problems/io/import/robot_reading.h"
#include "problems/io/import/universal_robots.h"
#include "problems/io/output_files.h"
#include "problems/io/robot_file.h"
#include "problems/io/urdf_chain.h"
#include "problems/io/urdf_robot.h"
#include "problems/io/urdf_writer.h"
#include "problems/text.h"
#include "tools/commands.h"
#include "tools/convert_options.h"
#include "tools/report/command_words.h"
#include "tools/same_motion.h"

DEFINE_string(
    as, "",
    "how OUT describes the robot: chain, dh (standard), mdh (modified), ur (calibration.yaml); default: as IN does");
DEFINE_string(
    template, "",
    "URDF whose origins, or .conf whose lists, receive the robot; everything else of it is kept byte for byte. With "
    "--as=ur a calibration.yaml whose hash is kept");
DEFINE_bool(plain, false, "DH without Hayati's beta: the best such table, refitted, with what it costs");
DEFINE_string(convention, "", "standard or modified: of a DH table, whatever it says itself");
DEFINE_string(base_link, "", "link of a URDF where the chain begins; default: the root");
DEFINE_string(tip_link, "", "link of a URDF where the chain ends; default: the only end there is");
DEFINE_string(nominal, "", "robot that the differences of a calibration.conf are from");

namespace sagitta {

RobotReadOptions RobotOptionsFromFlags() {
  RobotReadOptions options;
  if (!FLAGS_convention.empty()) {
    options.convention = FindChoice<DhConvention>(FLAGS_convention);
    if (!options.convention) {
      throw InputError({"", 0, "--convention"}, "'" + FLAGS_convention + "' is no convention",
                       Joined(WordsOf<DhConvention>(), " or "));
    }
  }
  options.ends = {FLAGS_base_link, FLAGS_tip_link};
  options.nominal_file = FLAGS_nominal;
  return options;
}

namespace {

// How OUT is to describe the robot.
struct WriteOptions {
  std::string as;             // chain, dh, mdh, ur; empty: as the robot does
  std::string template_file;  // URDF or .conf that is edited, calibration.yaml of the arm; may be empty
  bool plain = false;         // without Hayati's beta
  RobotReadOptions read;      // links of the template, nominal robot
  std::string in;
};

WriteOptions WriteOptionsFromFlags() { return {FLAGS_as, FLAGS_template, FLAGS_plain, RobotOptionsFromFlags(), ""}; }

struct Written {
  std::string text;
  std::vector<std::string> notes;
  bool is_exact = true;
};

// The word of --as for such a table.
std::string TableDescription(DhConvention convention) {
  switch (convention) {
    case DhConvention::kStandard:
      return "dh";
    case DhConvention::kModified:
      return "mdh";
  }
  return "";
}

// The convention of the table that `as` says; nothing where it says no table.
std::optional<DhConvention> ConventionOf(const std::string& as) {
  for (const DhConvention convention : ChoicesOf<DhConvention>()) {
    if (as == TableDescription(convention)) return convention;
  }
  return std::nullopt;
}

std::string OwnDescription(const Robot& robot) { return robot.dh ? TableDescription(robot.dh->convention) : "chain"; }

DhTable TableOf(const Robot& robot, DhConvention convention) {
  std::string why_not;
  const std::optional<DhTable> table =
      robot.dh ? InConvention(*robot.dh, convention, &why_not) : DhTableFromChain(robot.chain, convention, &why_not);
  if (table) return *table;
  std::string not_modified_either;
  const bool is_modified = robot.dh || DhTableFromChain(robot.chain, DhConvention::kModified, &not_modified_either);
  throw InputError({"", 0, "--as"}, "this robot has no such DH table: " + why_not,
                   robot.dh      ? "--as=mdh keeps the modified table"
                   : is_modified ? "--as=mdh: the first row of a modified table turns the base over (alpha: 180 deg)"
                                 : "write a chain (--as=chain), or, of a URDF, state other links: --base_link");
}

// What is named after the errors of one description has no place in another.
void CheckErrorsAreKept(const Robot& robot) {
  for (const EffectSpec& spec : robot.effects) {
    const EffectDefinition* definition = FindEffect(robot, spec.effect);
    if (!definition || definition->target != EffectTarget::kError) continue;
    throw InputError({"", 0, "--as"},
                     "effect '" + spec.effect + "' belongs to the error '" + spec.target +
                         "', which the table written does not have",
                     "add its value to the transform that has this error and remove the effect, or keep the "
                     "description: --as=" +
                         OwnDescription(robot));
  }
}

bool HasBeta(const DhTable& table) {
  for (const DhLink& link : table.links) {
    if (link.beta != 0.0) return true;
  }
  return false;
}

DhTable PlainTable(const Robot& robot, const DhTable& table, Written* written) {
  if (!HasBeta(table)) {
    written->notes.push_back(PlainAndExact());
    return table;
  }
  const PlainDhFit fit = FitPlainDh(robot.chain, table);
  written->is_exact = false;
  written->notes.push_back(WithoutBeta(fit.rms, fit.max, fit.largest_length_change));
  return fit.table;
}

Robot WithTable(const Robot& robot, const DhTable& table) {
  Robot result = robot;
  result.dh = table;
  result.chain = ChainFromDhTable(robot.chain.joints, robot.chain.couplings, table);
  return result;
}

std::string Wanted(const WriteOptions& options, const std::string& fallback) {
  if (options.as.empty()) return fallback;
  if (options.as == "chain" || options.as == "ur" || ConventionOf(options.as)) return options.as;
  throw InputError({"", 0, "--as"}, "'" + options.as + "' is no description", "chain, dh, mdh or ur");
}

Written ToUrCalibration(const Robot& robot, const WriteOptions& options) {
  const std::string& own = options.template_file.empty() ? options.in : options.template_file;
  const std::string hash = HashOfUrCalibration(ReadTextFile(own), own);
  Written written{RobotToUrCalibration(robot, hash), {}, true};
  if (hash.empty()) written.notes.push_back(HashIsMissing());
  return written;
}

Written ToYaml(const Robot& robot, const WriteOptions& options) {
  Written written;
  const std::string as = Wanted(options, options.plain && !robot.dh ? "dh" : OwnDescription(robot));
  if (as == "ur") return ToUrCalibration(robot, options);
  Robot result = robot;
  if (const std::optional<DhConvention> convention = ConventionOf(as)) {
    if (as != OwnDescription(robot)) CheckErrorsAreKept(robot);
    DhTable table = TableOf(robot, *convention);
    if (options.plain) table = PlainTable(robot, table, &written);
    result = WithTable(robot, table);
  } else {  // a chain
    result.dh.reset();
  }
  written.text = RobotToYaml(result);
  return written;
}

Written ToCsv(const Robot& robot, const WriteOptions& options) {
  Written written;
  const std::string as = Wanted(options, robot.dh ? OwnDescription(robot) : "dh");
  const std::optional<DhConvention> convention = ConventionOf(as);
  if (!convention) throw InputError({"", 0, "--as"}, "a CSV holds a DH table", "--as=dh or --as=mdh");
  DhTable table = TableOf(robot, *convention);
  if (options.plain) table = PlainTable(robot, table, &written);
  written.text = DhTableToCsv(robot, table);
  return written;
}

Written ToUrdf(const Robot& robot, const WriteOptions& options) {
  const std::string& edits = options.template_file;
  if (edits.empty()) return {RobotToUrdf(robot), {}, true};
  const EditedUrdf edited = EditUrdf(ReadTextFile(edits), edits, options.read.ends, robot);
  return {
      edited.text, {edited.joints.empty() ? "no origin changes" : "origins edited: " + Joined(edited.joints)}, true};
}

Written ToUrConf(const Robot& robot, const WriteOptions& options) {
  const std::string& nominal_file = options.read.nominal_file;
  if (nominal_file.empty()) {
    throw InputError({"", 0, "--nominal"}, "a .conf holds differences, and from which table is not said",
                     "--nominal=urcontrol.conf (or any file with the nominal standard DH table)");
  }
  const Robot nominal = ReadAnyRobot(nominal_file).robot;
  if (!nominal.dh || nominal.dh->convention != DhConvention::kStandard)
    throw InputError({nominal_file, 0, ""}, "the nominal robot has no standard DH table, which the differences are of");
  const std::string& edits = options.template_file;
  const std::string kept = edits.empty() ? "" : ReadTextFile(edits);
  Written written{RobotToUrConf(robot, *nominal.dh, kept, edits), {}, true};
  written.notes.push_back(kept.empty() ? KeepControllersLines() : ListsAreReplaced(edits));
  return written;
}

Written WrittenAs(const Robot& robot, const std::string& out, const WriteOptions& options) {
  const std::string ending = std::filesystem::path(out).extension().string();
  if (!options.template_file.empty() && ending != ".urdf" && ending != ".conf" && options.as != "ur") {
    throw InputError({"", 0, "--template"}, "only a URDF, a .conf or a calibration.yaml (--as=ur) is edited",
                     "OUT has to end in .urdf or .conf, or --as=ur");
  }
  if (ending == ".conf") return ToUrConf(robot, options);
  if (ending == ".urdf") return ToUrdf(robot, options);
  if (ending == ".csv") return ToCsv(robot, options);
  if (ending == ".yaml" || ending == ".yml" || ending == ".json") return ToYaml(robot, options);
  throw InputError({out, 0, ""}, "the ending does not say which format is meant",
                   ".yaml (robot, or calibration.yaml with --as=ur), .urdf, .csv (DH table) or .conf (Universal "
                   "Robots)");
}

// What the other format has no place for.
std::string LeftOut(const Robot& robot) {
  std::vector<std::string> parts;
  if (!robot.compliances.empty()) parts.emplace_back("joint compliances");
  if (robot.gravity_compensator) parts.emplace_back("the gravity compensator");
  if (!robot.effects.empty()) parts.emplace_back("effects");
  return Joined(parts);
}

// Reads what is about to be written as any reader of it would.
Robot ReadBack(const std::string& text, const WriteOptions& written_by) {
  RobotReadOptions options;
  if (!written_by.template_file.empty()) options.ends = written_by.read.ends;
  options.nominal_file = written_by.read.nominal_file;
  try {
    return ReadAnyRobotText(text, "", options).robot;
  } catch (const InputError& error) {  // whose place is in a file that is never written
    throw InputError({written_by.in, 0, ""}, "OUT could not be read again: " + std::string(error.what()));
  }
}

// Where the chain of a URDF ends, and where it could.
std::string EndsOf(const std::string& in, const UrdfEnds& asked) {
  const std::string text = ReadTextFile(in);
  if (!IsUrdf(in, text)) return "";
  const UrdfChain chain = ReadUrdfChain(text, in, asked);
  return ChainRuns(chain.ends.base_link, chain.ends.tip_link, chain.other_tips);
}

// What a URDF says by <mimic>, a line each.
std::string MimicsOf(const Chain& chain) {
  std::string lines;
  for (const Coupling& coupling : chain.couplings) {
    lines += "  " + MimicIsACoupling(chain.joints[coupling.joint].name, chain.joints[coupling.driver].name) + "\n";
  }
  return lines;
}

// Values of effects stay as they are, so what they count from has to.
void CheckEffects(const std::string& in, const Robot& read, const Robot& back, std::uint64_t seed) {
  const std::vector<EffectInOtherFrame> other = EffectsInOtherFrames(read, back, seed);
  if (other.empty()) return;
  throw InputError({in, 0, "effects"}, CountsFromTurnedAxes(other.front().path, other.front().distance),
                   KeepItsDescription());
}

int RunConvert(const CommandLine& line) {
  ExpectArguments(line, ConvertCommand(), FLAGS_out.empty() ? 2 : 1, 2);
  if (line.arguments.size() == 2 && !FLAGS_out.empty()) {
    throw InputError({"", 0, "--out"}, "the file to write is given twice", "give OUT or --out=OUT");
  }
  const std::string& in = line.arguments[0];
  const std::string& out = FLAGS_out.empty() ? line.arguments[1] : FLAGS_out;
  const OutputFile file(out);
  WriteOptions options = WriteOptionsFromFlags();
  options.in = in;
  const RobotReading reading = ReadAnyRobot(in, options.read);
  const Written written = WrittenAs(reading.robot, out, options);
  constexpr double kSame = 1e-9;  // m
  const Robot back = ReadBack(written.text, options);
  const double difference = LargestDifference(reading.robot.chain, back.chain, FLAGS_seed);
  if (written.is_exact && difference > kSame) {
    throw Failure("the file written would differ from the robot read by " + FormatNumber(1e3 * difference) +
                  " mm; nothing is written");
  }
  if (back.effects.size() == reading.robot.effects.size()) CheckEffects(in, reading.robot, back, FLAGS_seed);
  file.Write(written.text);
  std::cout << in << ": " << reading.format << ", " << reading.robot.num_joints() << " joints\n";
  const std::string ends = EndsOf(in, options.read.ends);
  if (!ends.empty()) std::cout << "  " << ends << "\n" << MimicsOf(reading.robot.chain);
  for (const std::string& note : reading.notes) std::cout << "  " << note << "\n";
  for (const std::string& guess : reading.guesses) std::cout << "  guessed: " << guess << "\n";
  std::cout << out << ": written\n";
  for (const std::string& note : written.notes) std::cout << "  " << note << "\n";
  if (written.is_exact) std::cout << "  " << MovesAsBefore(difference) << "\n";
  const std::string left_out = LeftOut(reading.robot);
  const std::string ending = std::filesystem::path(out).extension().string();
  if (!left_out.empty() && (options.as == "ur" || ending == ".urdf" || ending == ".csv" || ending == ".conf")) {
    std::cout << "  " << LeftOutOfFormat(left_out) << "\n";
  }
  return 0;
}

}  // namespace

Command ConvertCommand() {
  return {
      "convert",
      "robot files between formats",
      R"(sagitta convert IN OUT [--as=chain|dh|mdh|ur] [--template=FILE] [--plain]

Reads a robot from IN, by its content: robot.yaml, URDF, a DH table as text (any column order, separator and unit),
calibration.yaml or .conf of Universal Robots, MATLAB text (SerialLink, dhparams, elementary transforms). Writes it to
OUT (or --out=OUT), by its ending: .yaml (--as=chain, dh, mdh; --as=ur: calibration.yaml), .urdf, .csv (DH table), .conf (the
differences from --nominal as a controller of Universal Robots has them). What is written is read again and has to move
alike to 1e-9 m.

--template edits the origins of an existing URDF, or the four lists of an existing .conf, and nothing else; with --as=ur the
hash of an existing calibration.yaml is kept. --plain gives a DH table without Hayati's beta, for controllers that have
none, and says what that costs. Details: docs/CONVERT.md.

Examples
  sagitta convert robot.urdf robot.yaml
  sagitta convert results/robot.calibrated.yaml calibrated.urdf --template=robot.urdf
  sagitta convert results/robot.calibrated.yaml table.csv --as=dh --plain
  sagitta convert calibration.conf robot.yaml --nominal=urcontrol.conf
  sagitta convert results/robot.calibrated.yaml new.conf --nominal=urcontrol.conf --template=calibration.conf
)",
      {"as", "template", "plain", "convention", "base_link", "tip_link", "nominal", "out", "seed", "threads", "quiet"},
      RunConvert};
}

}  // namespace sagitta

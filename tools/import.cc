// sagitta import: robot.yaml, measurements.csv and experiment.yaml from what people have.
#include <fmt/format.h>
#include <gflags/gflags.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "models/constants.h"
#include "problems/input_error.h"
#include "problems/io/import/import_plan.h"
#include "problems/io/import/imported_rows.h"
#include "problems/io/import/joined_tables.h"
#include "problems/io/import/marker_column.h"
#include "problems/io/import/robot_reading.h"
#include "problems/io/measurement_file.h"
#include "problems/io/output_files.h"
#include "problems/io/robot_file.h"
#include "problems/io/yaml_writer.h"
#include "problems/text.h"
#include "tools/commands.h"
#include "tools/convert_options.h"
#include "tools/import_choice.h"
#include "tools/import_misfit.h"
#include "tools/progress.h"
#include "tools/report/command_words.h"

DEFINE_string(
    map, "",
    "COLUMN=HEADER,…: columns of measurements.csv and where they come from (a header, a column's number, a+b or a-b)");
DEFINE_bool(strict, false, "refuse whatever would have to be guessed");
DEFINE_string(rotation, "",
              "what three angles mean: vector, or the product RxRyRz, RzRyRx, … of rotations about the axes");
DEFINE_string(robot, "", "robot whose table this program ships, by its name (ur5, irb120, …)");

namespace sagitta {
namespace {

namespace fs = std::filesystem;

std::map<std::string, std::string> MapFromFlags() {
  return PairsOfFlag(
      "map", FLAGS_map,
      {"a column and where it comes from", "is mapped twice", "--map=x_mm=measurement_x,q1_rad=shoulder_pan_joint"});
}

struct FoundRobot {
  RobotReading reading;
  std::string words;
};

// Sorted, empty where there is no such folder.
std::vector<std::string> TablesIn(const fs::path& folder) {
  std::vector<std::string> tables;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    if (entry.path().extension() == ".csv") tables.push_back(entry.path().string());
  }
  std::sort(tables.begin(), tables.end());
  return tables;
}

// Tables that ship with the program. A variable that is set is what the user means: nothing else is tried then. bin/
// lies next to share/ in the build folder as where it is installed.
std::vector<std::string> ShippedTables() {
  std::vector<std::string> tried;
  const char* set = std::getenv("SAGITTA_DATA_DIR");
  if (set != nullptr && *set != '\0') {
    tried = {(fs::path(set) / "robots").string()};
  } else {
    std::error_code ignored;
    const fs::path bin = fs::read_symlink("/proc/self/exe", ignored).parent_path();
    tried = {(bin.parent_path() / "share/sagitta/published/robots").string(), SAGITTA_ROBOTS_DIR};
  }
  for (const std::string& folder : tried) {
    const std::vector<std::string> tables = TablesIn(folder);
    if (!tables.empty()) return tables;
  }
  throw InputError({"", 0, ""}, NoShippedTables(tried), WhereTablesAre());
}

FoundRobot ShippedRobot(const std::string& name) {
  std::vector<std::string> names;
  for (const std::string& path : ShippedTables()) {
    names.push_back(fs::path(path).stem().string());
    if (names.back() == name) return {ReadAnyRobot(path), "the table '" + name + "' that this program ships"};
  }
  throw InputError({"", 0, "--robot"}, "there is no table '" + name + "'", SpellingHint(name, names));
}

struct CandidateTable {
  std::string path;
  double misfit;  // m
};

// Those of the shipped tables that can have made the readings.
std::vector<CandidateTable> TablesThatFit(const TextTable& table, const std::map<std::string, std::string>& columns,
                                          IfNoneFits policy) {
  std::vector<CandidateTable> fitting;
  for (const std::string& path : ShippedTables()) {
    const RobotReading reading = ReadAnyRobot(path);
    try {
      const auto plans = PossiblePlans(table, reading.robot.chain.joints, columns);
      const Choice choice = ChoosePlan(reading.robot, table, plans, policy);
      if (choice.misfit < std::numeric_limits<double>::infinity()) fitting.push_back({path, choice.misfit});
    } catch (const InputError&) {  // other joints, or it misses by far
    }
  }
  return fitting;
}

// Of the shipped tables the one that can have made the readings, if there is exactly one.
FoundRobot RobotByFit(const TextTable& table, const std::map<std::string, std::string>& columns) {
  std::vector<CandidateTable> fitting = TablesThatFit(table, columns, IfNoneFits::kRefuse);
  if (fitting.empty()) fitting = TablesThatFit(table, columns, IfNoneFits::kTryMost);
  std::sort(fitting.begin(), fitting.end(),
            [](const CandidateTable& a, const CandidateTable& b) { return a.misfit < b.misfit; });
  if (fitting.empty() || (fitting.size() > 1 && fitting[1].misfit < kBetter * fitting[0].misfit)) {
    throw InputError({table.path, 0, ""},
                     fitting.empty()
                         ? "no robot is given, and none of the tables that this program ships made these readings"
                         : "no robot is given, and several of the tables that this program ships fit",
                     "give the robot as one of the files: robot.yaml, URDF, a DH table, calibration.yaml …");
  }
  FoundRobot found{ReadAnyRobot(fitting[0].path), ""};
  found.reading.guesses.push_back(
      OnlyTableThatFits(fs::path(fitting[0].path).stem().string(), InMillimetres(fitting[0].misfit)));
  found.words = "the table '" + fs::path(fitting[0].path).stem().string() + "' that this program ships";
  return found;
}

// shipped: name of a table that this program ships; may be empty.
FoundRobot RobotOf(const std::vector<std::string>& robot_files, const std::string& shipped,
                   const RobotReadOptions& options, const std::vector<TextTable>& tables,
                   const std::map<std::string, std::string>& columns) {
  if (robot_files.size() > 1 || (!robot_files.empty() && !shipped.empty())) {
    throw InputError({robot_files.back(), 0, ""}, "this is a second robot",
                     "one robot and any number of measurement files are expected");
  }
  if (!robot_files.empty()) {
    return {ReadRobotWithReadings(robot_files[0], options, tables.front(), columns), robot_files[0]};
  }
  if (!shipped.empty()) return ShippedRobot(shipped);
  return RobotByFit(tables.front(), columns);
}

std::string FirstValue(const TextTable& table, const PlannedColumn& column) {
  const auto& cells = table.rows.front().cells;
  std::string value = PartOfName(cells[column.source], column.part);
  if (column.second >= 0) value += (column.sign > 0 ? " + " : " - ") + cells[column.second];
  return value;
}

void PrintPlan(const TextTable& table, const Choice& choice) {
  std::cout << "\n"
            << table.path << ": " << table.rows.size() << " rows, " << table.columns() << " columns, " << table.encoding
            << ", separator " << table.separator << ", decimal " << (table.decimal_comma ? "comma" : "point")
            << (table.has_header() ? "" : ", no header") << "\n";
  if (!table.joined_with.empty()) std::cout << "  " << table.joined_with << "\n";
  std::cout << fmt::format("  {:<30} {:<28} {:<6} {}\n", "column", "meaning", "unit", "first value");
  for (const PlannedColumn& column : choice.plan.columns) {
    std::cout << fmt::format("  {:<30} {:<28} {:<6} {}\n", column.header, column.stem + " (" + column.meaning + ")",
                             column.unit.empty() ? "-" : column.unit, FirstValue(table, column));
  }
  for (const auto& [header, why] : choice.plan.unused) std::cout << fmt::format("  {:<30} not used: {}\n", header, why);
  if (choice.misfit < std::numeric_limits<double>::infinity()) {
    std::cout << "  " << (choice.misfit_is_of_most ? ColumnsFitMostRows : ColumnsFit)(InMillimetres(choice.misfit))
              << "\n";
  } else {
    std::cout << "  " << TooFewPoses(DifferentPoses(table, choice.plan)) << "\n";
  }
  if (choice.plan.rotation) {
    std::cout << "  rotation: " << choice.plan.rotation->Words();
    if (std::isfinite(choice.rotation_misfit))
      std::cout << "; the nominal robot misses it by " << InDegrees(choice.rotation_misfit) << " (RMS)";
    std::cout << "\n";
  }
  if (choice.plan.Find("tau1")) {
    std::cout << "  " << TorquesAreCarried() << "\n";
  }
}

void PrintWhatLoadsNeed(const std::set<std::string>& loads, const std::map<std::string, double>& masses) {
  for (const std::string& load : loads) {
    const auto stated = masses.find(load);
    std::cout << (stated == masses.end() ? LoadNeedsPoint(load) : WeighedLoadNeedsPoint(load, stated->second)) << "\n";
  }
}

// Where they stand, the first of them with how far off they are.
std::string FarOffInWords(const ReadingsFarOff& far_off, const ImportedRows& rows) {
  constexpr size_t kNamed = 10;
  std::vector<std::string> names;
  for (size_t k = 0; k < far_off.rows.size(); ++k) {
    const std::string source = rows.SourceOf(static_cast<size_t>(far_off.rows[k]));
    names.push_back(source + " (" + InMillimetres(far_off.distances[k]) + ")");
  }
  return ReadingsAreFarOff(far_off.all, InMillimetres(far_off.others), names.size(), Enumerate(names, kNamed));
}

void PrintGuesses(const std::vector<std::string>& guesses) {
  if (guesses.empty()) {
    std::cout << "\nNothing had to be guessed.\n";
    return;
  }
  std::cout << "\nGuessed (--strict refuses):\n";
  for (const std::string& guess : guesses) std::cout << "  - " << guess << "\n";
}

// A file's name as an id.
std::string LabelOf(const std::string& path) {
  std::string label = fs::path(path).stem().string();
  for (char& c : label) c = std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-' ? c : '_';
  return label;
}

// Files from different folders may share a name.
std::vector<std::string> Labels(const std::vector<TextTable>& tables) {
  std::vector<std::string> labels;
  for (const TextTable& table : tables) {
    std::string label = LabelOf(table.path);
    while (std::count(labels.begin(), labels.end(), label)) label += "_";
    labels.push_back(label);
  }
  return labels;
}

std::string ExperimentText(const std::map<std::string, double>& masses) {
  nlohmann::ordered_json experiment = {
      {"schema", "sagitta/experiment/1"}, {"robot", "robot.yaml"}, {"measurements", {"measurements.csv"}}};
  for (const auto& [load, mass] : masses) experiment["loads"][load] = {{"mass_kg", mass}};
  for (const auto& [name, marker] : MarkersFromFlags()) experiment["markers"][name] = {{"on", marker.on.Word()}};
  return JsonToYaml(experiment);
}

// What --on names is there.
void CheckMarkersOfFlags(const Robot& robot, const Measurements& data) {
  for (const auto& [name, marker] : MarkersFromFlags()) {
    if (std::count(data.markers.begin(), data.markers.end(), name) == 0)
      throw InputError({"", 0, "--on"}, "no row measures the marker '" + name + "'", SpellingHint(name, data.markers));
    if (marker.on.kind == MarkerPlace::Kind::kJoint && robot.chain.FindJoint(marker.on.joint) < 0) {
      throw InputError({"", 0, "--on"}, "'" + marker.on.joint + "' is no place on this robot",
                       SpellingHint(marker.on.joint, JointNames(robot.chain.joints)));
    }
  }
}

// What is given: one robot or none, and tables.
struct Files {
  std::vector<std::string> robots;
  std::vector<TextTable> tables;
};

// Empty: the robot is not given, or its file is for a later message.
std::vector<Joint> JointsOf(const std::vector<std::string>& robots) {
  RobotReadOptions options = RobotOptionsFromFlags();
  options.leave_convention_open = true;
  return robots.size() == 1 ? ReadAnyRobot(robots[0], options).robot.chain.joints : std::vector<Joint>();
}

// A table given under two names would count every reading twice.
void RefuseCopies(const std::vector<TextTable>& tables) {
  const auto are_equal = [](const TextTable::Row& a, const TextTable::Row& b) { return a.cells == b.cells; };
  for (size_t t = 1; t < tables.size(); ++t) {
    for (size_t before = 0; before < t; ++before) {
      const auto &own = tables[t].rows, &other = tables[before].rows;
      if (!std::equal(own.begin(), own.end(), other.begin(), other.end(), are_equal)) continue;
      throw InputError({tables[t].path, 0, ""}, "the rows are those of " + tables[before].path,
                       "leave one of them out");
    }
  }
}

Files ReadFiles(const std::vector<std::string>& paths, const std::map<std::string, std::string>& columns) {
  Files files;
  for (const std::string& path : paths) {
    if (LooksLikeRobot(path)) {
      files.robots.push_back(path);
    } else {
      files.tables.push_back(ReadTextTable(path));
    }
  }
  RefuseCopies(files.tables);
  if (files.tables.size() > 1) files.tables = JoinPosesByName(std::move(files.tables), JointsOf(files.robots), columns);
  if (!files.tables.empty()) return files;
  throw InputError({paths[0], 0, ""}, "there are no measurements among the files",
                   "a robot alone is for 'sagitta convert'");
}

// The tables as one file of measurements.
struct Interpretation {
  std::vector<Choice> choices;  // of each table
  ImportedRows rows;
  std::vector<std::string> guesses;  // each once

  void Guess(const std::string& words) {
    if (std::find(guesses.begin(), guesses.end(), words) == guesses.end()) guesses.push_back(words);
  }
};

// What the files state in a column.
std::set<std::string> StatedNames(const std::vector<TextTable>& tables, const std::vector<Choice>& choices,
                                  const std::string& stem) {
  std::set<std::string> names;
  for (size_t t = 0; t < tables.size(); ++t) {
    const PlannedColumn* column = choices[t].plan.Find(stem);
    if (column == nullptr) continue;
    for (const TextTable::Row& row : tables[t].rows) {
      names.insert(PartOfName(row.cells[static_cast<size_t>(column->source)], column->part));
    }
  }
  return names;
}

// A made name that no file states.
std::string OtherThan(const std::set<std::string>& stated, std::string name) {
  while (stated.count(name) > 0) name += "_";
  return name;
}

// Several files are several stations and markers where no column says so.
RowDefaults DefaultsOf(size_t table, const std::vector<TextTable>& tables, const std::vector<std::string>& labels,
                       Interpretation* read) {
  RowDefaults defaults;
  if (labels.size() == 1) return defaults;
  const ImportPlan& plan = read->choices[table].plan;
  defaults.station = OtherThan(StatedNames(tables, read->choices, "station"), labels[table]);
  defaults.marker = OtherThan(StatedNames(tables, read->choices, "marker"), "M" + std::to_string(table + 1));
  if (!plan.Find("station")) read->Guess(StationPerFile());
  if (!plan.Find("marker")) read->Guess(MarkerPerFile());
  return defaults;
}

Interpretation Interpret(const std::vector<TextTable>& tables, const RobotReading& reading,
                         const std::map<std::string, std::string>& columns, const std::string& rotation,
                         Progress* progress) {
  Interpretation read;
  read.guesses = reading.guesses;
  const bool is_point_stated = columns.count("x_mm") + columns.count("x_m") + columns.count("x_um") > 0;
  const std::vector<std::string> labels = Labels(tables);
  for (size_t t = 0; t < tables.size(); ++t) {
    progress->Say("interpreting the readings of " + labels[t]);
    const auto plans = PossiblePlans(tables[t], reading.robot.chain.joints, columns);
    Choice choice = ChoosePlan(reading.robot, tables[t], plans, IfNoneFits::kSayWhy);
    ConfirmOrder(reading.robot, tables[t], choice);
    RefuseComputedPoints(reading.robot, tables[t], choice, is_point_stated);
    DecideRotation(reading.robot, tables[t], rotation, &choice);
    for (const std::string& words : choice.plan.guesses) read.Guess(words);
    read.choices.push_back(std::move(choice));
  }
  for (size_t t = 0; t < tables.size(); ++t) {
    read.rows.Add(tables[t], read.choices[t].plan, DefaultsOf(t, tables, labels, &read));
  }
  return read;
}

void RefuseGuesses(const std::vector<std::string>& guesses) {
  if (guesses.empty()) return;
  std::string all;
  for (const std::string& words : guesses) all += "\n  - " + words;
  throw InputError({"", 0, "--strict"}, std::to_string(guesses.size()) + " things would have to be guessed:" + all,
                   "say them: --map=COLUMN=HEADER,…, units in headers, columns station and marker");
}

void PrintWhatWasRead(const FoundRobot& found, const std::vector<TextTable>& tables, const Interpretation& read) {
  const Robot& robot = found.reading.robot;
  std::cout << "Robot: " << found.words << ", " << found.reading.format << ", " << robot.num_joints() << " joints"
            << (robot.name.empty() ? "" : ", " + robot.name) << "\n";
  for (const std::string& note : found.reading.notes) std::cout << "  " << note << "\n";
  for (size_t t = 0; t < tables.size(); ++t) PrintPlan(tables[t], read.choices[t]);
  if (!read.rows.notes().empty()) std::cout << "\n";
  for (const std::string& note : read.rows.notes()) std::cout << note << "\n";
  PrintGuesses(read.guesses);
}

int RunImport(const CommandLine& line) {
  ExpectArguments(line, ImportCommand(), 1, 1000);
  if (FLAGS_out.empty()) throw InputError({"", 0, "--out"}, "the folder for the files is missing", "--out=DIR");
  const std::map<std::string, std::string> columns = MapFromFlags();
  const OutputFolder out(FLAGS_out, {"robot.yaml", "measurements.csv", "experiment.yaml"});
  std::optional<Progress> progress;  // shares as measured on 390000 rows of the KR 270
  progress.emplace(FLAGS_quiet,
                   std::vector<ProgressPhase>{
                       {"reading the files", 4.0}, {"interpreting", 3.0}, {"writing", 1.0}, {"checking", 1.0}});
  progress->Say("reading the files");
  const Files files = ReadFiles(line.arguments, columns);
  const FoundRobot found = RobotOf(files.robots, FLAGS_robot, RobotOptionsFromFlags(), files.tables, columns);
  const Robot& robot = found.reading.robot;
  const Interpretation read = Interpret(files.tables, found.reading, columns, FLAGS_rotation, &*progress);
  if (FLAGS_strict) RefuseGuesses(read.guesses);
  progress->Say("writing the rows");
  const std::string csv = read.rows.ToCsv(robot.num_joints());
  progress->Say("checking what was written");
  // Before anything is written: it may be interrupted.
  const Measurements data = CheckedMeasurements(robot, read.rows, csv);
  CheckMarkersOfFlags(robot, data);
  const std::optional<ReadingsFarOff> far_off = FindReadingsFarOff(robot, data);
  out.Write({{"robot.yaml", RobotToYaml(robot)},
             {"measurements.csv", csv},
             {"experiment.yaml", ExperimentText(read.rows.masses())}});
  progress.reset();
  PrintWhatWasRead(found, files.tables, read);
  std::cout << "\n"
            << read.rows.size() << " readings in " << FLAGS_out << ": robot.yaml, measurements.csv, experiment.yaml\n";
  if (far_off) std::cout << "Warning: " << FarOffInWords(*far_off, read.rows) << "\n";
  PrintWhatLoadsNeed(LoadsOf(data), read.rows.masses());
  std::cout << "Next: sagitta calibrate " << FLAGS_out << "/experiment.yaml --out=results\n";
  return 0;
}

}  // namespace

Command ImportCommand() {
  return {"import",
          "robot, measurements and experiment from what people have",
          R"(sagitta import FILES… --out=DIR [--map=COLUMN=HEADER,…] [--on=MARKER=PLACE,…] [--rotation=…] [--strict]

Reads one robot (anything 'sagitta convert' reads) and any number of measurement tables as text, and writes
robot.yaml, measurements.csv and experiment.yaml to DIR. Separator, decimal sign, encoding, header and units are
found out; where a header does not say, the robot decides: the reading that its nominal geometry can have made, also of
angles (rotation vector or one of the products of three rotations) and of the convention of a DH table. What was
understood is printed, column by column, and every guess. --strict refuses guesses. Positions that were commanded,
nominal or computed are never read as measured ones. Several files are several stations. Markers
are on the flange, those on a link, the base or the floor where --on has them. Points whose joint values stand
in another file (plan.csv) are joined with it by the names of the poses.

Without a robot the tables that this program ships are tried; --robot=NAME uses one of them. They are found
in $SAGITTA_DATA_DIR/robots if that is set, else next to the program or where it was built. Details: docs/IMPORT.md.

Examples
  sagitta import robot.urdf tracker.csv --out=job
  sagitta import dh.csv series1.csv series2.csv --out=job --strict
  sagitta import robot.yaml plan.csv points.txt --out=job
  sagitta import robot.yaml export.txt --out=job --map=x_mm=measurement_x,y_mm=measurement_y,z_mm=measurement_z
  sagitta import robot.yaml links.csv --out=job --on=L1=A2,L2=A3
)",
          {"out", "map", "on", "rotation", "strict", "robot", "convention", "base_link", "tip_link", "nominal", "seed",
           "threads", "quiet"},
          RunImport};
}

}  // namespace sagitta

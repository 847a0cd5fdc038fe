// sagitta-reproduce (also: sagitta reproduce): the published tables side by side.
#include <gflags/gflags.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <optional>

#include "estimator/results/estimate_json.h"
#include "problems/input_error.h"
#include "problems/io/output_files.h"
#include "tools/progress.h"
#include "tools/reproduce/data.h"
#include "tools/run_command.h"

DEFINE_int32(trials, 2000, "of the Monte-Carlo study");
DEFINE_string(data, "", "folder with the published tables (else $SAGITTA_DATA, else as installed)");

namespace sagitta {
namespace {

std::string DataFolderFromFlags() {
  if (!FLAGS_data.empty()) return FLAGS_data;
  const char* set = std::getenv("SAGITTA_DATA");
  if (set != nullptr && *set != '\0') return set;
  std::error_code error;  // where it is installed: bin/ next to share/
  const std::filesystem::path bin = std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
  const std::filesystem::path installed = bin.parent_path() / "share/sagitta/published";
  return std::filesystem::exists(installed, error) ? installed.string() : SAGITTA_DATA_DIR;
}

std::vector<ReproducibleTable> AllTables() {
  std::vector<ReproducibleTable> all;
  for (const auto& tables : {PoseTables(), GeometryTables(), CompensatorTables(), ElastostaticTables(),
                             ValidationTables(), WeightTables()}) {
    all.insert(all.end(), tables.begin(), tables.end());
  }
  // Papers in order; within one the tables as numbered, then the figures.
  const std::vector<std::string> order = {"000-I",    "000-II",   "000-III",  "000-IV",   "002-I",    "002-II",
                                          "002-III",  "002-IV",   "002-V",    "002-VI",   "002-VII",  "002-VIII",
                                          "002-IX",   "002-X",    "002-XI",   "002-XII",  "002-XIII", "002-fig4",
                                          "002-fig5", "002-fig8", "002-fig9", "002-fig10"};
  const auto rank = [&order](const ReproducibleTable& table) {
    return std::find(order.begin(), order.end(), table.id) - order.begin();  // 003 stands behind, as listed
  };
  std::stable_sort(all.begin(), all.end(), [&rank](const auto& a, const auto& b) { return rank(a) < rank(b); });
  return all;
}

// all | 002 | 002-VI, in any number; nothing: all.
std::vector<ReproducibleTable> TablesAsked(const std::vector<std::string>& arguments) {
  const std::vector<ReproducibleTable> all = AllTables();
  std::vector<std::string> names = {"all", "000", "002", "003"};
  for (const ReproducibleTable& table : all) names.push_back(table.id);
  for (const std::string& argument : arguments) {
    if (std::find(names.begin(), names.end(), argument) != names.end()) continue;
    throw InputError({"", 0, "sagitta reproduce"}, "there is no table '" + argument + "'",
                     SpellingHint(argument, names));
  }
  std::vector<ReproducibleTable> asked;
  for (const ReproducibleTable& table : all) {
    const bool wanted = arguments.empty() || std::any_of(arguments.begin(), arguments.end(), [&](const std::string& a) {
                          return a == "all" || a == table.id || table.id.rfind(a + "-", 0) == 0;
                        });
    if (wanted) asked.push_back(table);
  }
  return asked;
}

// Seconds with 2000 trials: the trials need the time, and run where they are first asked for.
double ShareOf(const std::string& table) { return table == "002-VI" ? 7.0 : table == "003-3" ? 1.5 : 0.05; }

// A file of another version or a mutilated one: an input error, not a crash.
ReproducedTable Made(const ReproducibleTable& table, const std::string& folder, Reproduction* reproduction) {
  try {
    return table.make(reproduction);
  } catch (const nlohmann::json::exception&) {
    throw InputError({folder, 0, table.id}, "the published data lack something that this table needs");
  }
}

std::vector<ReproducedTable> Compute(const std::vector<ReproducibleTable>& asked, const std::string& folder, bool quiet,
                                     Reproduction* reproduction) {
  std::vector<ReproducedTable> tables;
  std::vector<ProgressPhase> phases;
  for (const ReproducibleTable& table : asked) phases.push_back({"computing " + table.id + ":", ShareOf(table.id)});
  Progress progress(quiet, phases);
  std::string now;
  reproduction->Listen([&](const std::string& words) { progress.Say(now + words); });
  const auto compute = [&] {
    for (const ReproducibleTable& table : asked) {
      now = "computing " + table.id + ": ";
      progress.Say(now + "published values");
      tables.push_back(Made(table, folder, reproduction));
    }
  };
  SayingWhatWasFound(compute, [&] {
    std::string found;
    if (!tables.empty()) found = SectionsToText({OverviewSection(tables)});
    return found;
  });
  reproduction->Listen({});
  return tables;
}

nlohmann::ordered_json ToJson(const std::vector<ReproducedTable>& tables, const std::string& command,
                              const ReproduceOptions& options) {
  nlohmann::ordered_json json = {
      {"schema", "sagitta/reproduction/1"}, {"version", SAGITTA_VERSION}, {"command", command},
      {"note", SimulationNote()},           {"trials", options.trials},   {"seed", options.seed}};
  json["tables"] = nlohmann::ordered_json::array();
  for (const ReproducedTable& table : tables) json["tables"].push_back(TableToJson(table));
  return json;
}

std::string ToText(const std::vector<ReproducedTable>& tables) {
  std::vector<Section> sections;
  for (const ReproducedTable& table : tables) sections.push_back(TableToSection(table));
  if (tables.size() > 1) sections.push_back(OverviewSection(tables));
  return SectionsToText(sections);
}

int RunReproduce(const CommandLine& line) {
  CheckIn(kReproducedTrials, FLAGS_trials, "--trials");
  const std::vector<ReproducibleTable> asked = TablesAsked(line.arguments);
  std::optional<OutputFolder> out;
  if (!FLAGS_out.empty()) out.emplace(FLAGS_out, std::vector<std::string>{"report.html", "reproduce.json"});
  const std::string folder = DataFolderFromFlags();
  Reproduction reproduction(ReadPublishedData(folder), {FLAGS_trials, FLAGS_seed});
  const std::vector<ReproducedTable> tables = Compute(asked, folder, FLAGS_quiet, &reproduction);
  const std::string report = ReproductionToHtml(tables, line.text),
                    json = DumpJson(ToJson(tables, line.text, reproduction.options()));
  std::cout << ToText(tables);
  if (FLAGS_out.empty()) {
    std::cout << "\nNothing is written; --out=DIR keeps the results.\n";
    return 0;
  }
  out->Write({{"report.html", report}, {"reproduce.json", json}});
  std::cout << "\nResults in " << FLAGS_out << ": report.html, reproduce.json\n";
  return 0;
}

Command ReproduceCommand() {
  return {"reproduce",
          "the published tables side by side",
          R"(sagitta reproduce [all | PAPER | TABLE…] --out=DIR

Every numbered table of papers 000, 002 and 003, and the figures that can be computed: published, computed, and a
verdict on each row with its reason. No raw measurements are published; the published parameters, configurations,
loads and noise drive the simulation. Tables: 000-I … 000-IV, 002-I … 002-XIII, 002-fig4, -fig5, -fig8, -fig9,
-fig10, 003-1 … 003-4, 003-fig3. Writes report.html and reproduce.json to DIR.

Examples
  sagitta reproduce --out=results
  sagitta reproduce 003-4 --trials=20000
  sagitta reproduce 002-VIII 002-XIII 003 --seed=7 --out=results
)",
          {"trials", "data", "out", "seed", "threads", "quiet"},
          RunReproduce};
}

}  // namespace
}  // namespace sagitta

int main(int argc, char** argv) {
  return sagitta::RunGuarded(argv[0], [&] {
    return sagitta::RunCommand(sagitta::ReproduceCommand(), {argv + 1, argv + argc});
  });
}

// Writes one case with a hidden effect: files without any hint, and a sealed
// answer. Independent of what it tests: nothing of models/, problems/ or estimator/.
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>

#include "tests/hidden_effects/generator/case_files.h"
#include "tests/hidden_effects/generator/displacements.h"

namespace {

const char* const kHelp = R"(sagitta_hidden_generator --out=DIR --answer=DIR [flags]

  --study=N --case=N          seed: every case of every study has streams of its own [1, 0]
  --robot=NAME                kr270, kr270_compensator, ur10, seven, track [kr270]
  --kinds=A,B                 hidden effects; none: nothing is hidden
  --scales=A,B                their sizes, in typical sizes [1]
  --configurations=N          [60]
  --stations=N                [1]
  --markers=N                 of three [3]
  --unloaded                  no loads, rigid arm believed
  --without=time,temperature,approach   columns that the file lacks
  --repeatability_urad=X      declared, per joint [0]
  --stated_factor=X           of that, what the experiment declares [1]
  --undeclared_urad=X         not declared, per joint [0]
  --sigma_factor=X            true over stated sigma [1]
  --group=NAME                readings with other noise: station (the last), marker (M2), axis (z), sight
  --group_factor=X            their true over their stated sigma [1]
  --outliers=X                share of the rows [0]
  --noise=rows|repeats|none   what states the noise; the latter two: one sigma for all rows [rows]
  --repeated=N                configurations that are shot twice [0]
  --list                      prints the kinds

sagitta_hidden_generator --displacements=IN.json --out=OUT.json --kinds=A [--scales=A] [--study=N] [--case=N]

  where an effect would move the points of an arm that was really measured
)";

std::vector<std::string> Split(const std::string& text) {
  std::vector<std::string> items;
  std::istringstream stream(text);
  for (std::string item; std::getline(stream, item, ',');) items.push_back(item);
  return items;
}

class Flags {
 public:
  Flags(int argc, char** argv) {
    for (int i = 1; i < argc; ++i) {
      const std::string text = argv[i];
      const size_t equals = text.find('=');
      if (text.rfind("--", 0) != 0) throw std::invalid_argument("not a flag: " + text);
      values_[text.substr(2, equals - 2)] = equals == std::string::npos ? "" : text.substr(equals + 1);
    }
  }
  bool Has(const std::string& name) const { return values_.count(name) > 0; }
  std::string Take(const std::string& name, const std::string& fallback) {
    const auto found = values_.find(name);
    if (found == values_.end()) return fallback;
    const std::string value = found->second;
    values_.erase(found);
    return value;
  }
  double Number(const std::string& name, double fallback) {
    const std::string text = Take(name, "");
    return text.empty() ? fallback : std::stod(text);
  }
  void RefuseRest() const {
    if (!values_.empty()) throw std::invalid_argument("unknown flag --" + values_.begin()->first);
  }

 private:
  std::map<std::string, std::string> values_;
};

hidden::CaseOptions Options(Flags* flags) {
  hidden::CaseOptions options;
  options.study = std::stoull(flags->Take("study", "1"));
  options.number = std::stoull(flags->Take("case", "0"));
  options.robot = flags->Take("robot", "kr270");
  options.kinds = Split(flags->Take("kinds", ""));
  if (options.kinds == std::vector<std::string>{"none"}) options.kinds.clear();
  for (const std::string& scale : Split(flags->Take("scales", ""))) options.scales.push_back(std::stod(scale));
  options.scales.resize(options.kinds.size(), 1.0);
  options.design.configurations = static_cast<int>(flags->Number("configurations", 60));
  options.design.stations = static_cast<int>(flags->Number("stations", 1));
  options.markers = static_cast<int>(flags->Number("markers", 3));
  if (options.markers < 1 || options.markers > 3) throw std::invalid_argument("--markers is 1, 2 or 3");
  options.design.loaded = !flags->Has("unloaded");
  flags->Take("unloaded", "");
  for (const std::string& column : Split(flags->Take("without", ""))) {
    if (column == "time") options.design.time = false;
    if (column == "temperature") options.design.temperature = false;
    if (column == "approach") options.design.approach = false;
  }
  options.repeatability = hidden::kMicro * flags->Number("repeatability_urad", 0.0);
  options.stated_factor = flags->Number("stated_factor", 1.0);
  options.undeclared_repeatability = hidden::kMicro * flags->Number("undeclared_urad", 0.0);
  options.sigma_factor = flags->Number("sigma_factor", 1.0);
  options.group = flags->Take("group", "");
  const std::set<std::string> groups = {"", "station", "marker", "axis", "sight"};
  if (groups.count(options.group) == 0) throw std::invalid_argument("--group is station, marker, axis or sight");
  options.group_factor = flags->Number("group_factor", 1.0);
  options.outliers = flags->Number("outliers", 0.0);
  options.noise = flags->Take("noise", "rows");
  if (options.noise != "rows" && options.noise != "repeats" && options.noise != "none") {
    throw std::invalid_argument("--noise is rows, repeats or none");
  }
  options.repeated = static_cast<int>(flags->Number("repeated", 0));
  options.folder = flags->Take("out", "");
  options.answer_folder = flags->Take("answer", "");
  flags->RefuseRest();
  if (options.folder.empty() || options.answer_folder.empty()) throw std::invalid_argument("--out and --answer");
  return options;
}

hidden::DisplacementOptions Displacements(Flags* flags) {
  hidden::DisplacementOptions options;
  options.study = std::stoull(flags->Take("study", "1"));
  options.number = std::stoull(flags->Take("case", "0"));
  options.kind = flags->Take("kinds", "");
  options.scale = flags->Number("scales", 1.0);
  options.input = flags->Take("displacements", "");
  options.output = flags->Take("out", "");
  flags->RefuseRest();
  return options;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    Flags flags(argc, argv);
    if (argc == 1 || flags.Has("help")) {
      std::fputs(kHelp, stdout);
      return 0;
    }
    if (flags.Has("list")) {
      for (const std::string& kind : hidden::CatalogueKinds()) std::printf("%s catalogue\n", kind.c_str());
      for (const std::string& kind : hidden::OutsideKinds()) std::printf("%s outside\n", kind.c_str());
      for (const std::string& kind : hidden::ForeignKinds()) std::printf("%s foreign\n", kind.c_str());
      for (const std::string& kind : hidden::StrangerKinds()) std::printf("%s strangers\n", kind.c_str());
      for (const std::string& kind : hidden::NewcomerKinds()) std::printf("%s newcomers\n", kind.c_str());
      for (const std::string& kind : hidden::LatecomerKinds()) std::printf("%s latecomers\n", kind.c_str());
      return 0;
    }
    if (flags.Has("displacements")) {
      hidden::WriteDisplacements(Displacements(&flags));
      return 0;
    }
    hidden::WriteCase(hidden::MakeCase(Options(&flags)));
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
    return 2;
  }
}

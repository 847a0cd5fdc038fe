// sagitta changed: what changed between two estimates of one robot.
#include <iostream>
#include <nlohmann/json.hpp>

#include "estimator/changes/changes.h"
#include "problems/input_error.h"
#include "problems/io/output_files.h"
#include "tools/commands.h"
#include "tools/report/command_words.h"

namespace sagitta {
namespace {

int RunChanged(const CommandLine& line) {
  ExpectArguments(line, ChangedCommand(), 2, 2);
  if (FLAGS_out.empty()) throw InputError({"", 0, "--out"}, "where to write is missing", "--out=DIR");
  const OutputFolder out(FLAGS_out, {"changed.json"});
  const KnownRobot old_estimate = ReadEstimateFile(line.arguments[0]);
  const KnownRobot new_estimate = ReadEstimateFile(line.arguments[1]);
  const Changes changes = FindChanges(old_estimate, new_estimate);
  out.Write({{"changed.json", DumpJson(ChangesToJson(changes))}});
  std::cout << changes.words << "\n" << ComparisonInWords(changes);
  for (const std::string& note : changes.notes) std::cout << note << "\n";
  return 0;
}

}  // namespace

Command ChangedCommand() {
  return {"changed",
          "what changed between two estimates of one robot",
          R"(sagitta changed OLD.json NEW.json --out=DIR

Compares what two estimates of one robot predict for the markers that they share, and says what changed beyond both
uncertainties: the zero of a joint that slipped, a tool that was knocked, a marker that was reseated, a base (or an
instrument) that moved, a length, an angle or a stiffness. DIR/changed.json has every change with its value, 95 %
interval and probability, and "nothing", the probability that none is needed.

Instruments and tools may stand and hang anywhere the second time. A station that both name may have moved by metres;
where no name is shared, nothing is said of where the instrument stands, and likewise of the tool.
A covariance that was found from few configurations (covariance: sandwich) is refused: calibrate with that of the
model for this, and with repeatability_urad: estimate where the joints scatter.

Examples
  sagitta changed before/estimate.json after/estimate.json --out=changed
)",
          {"out", "seed", "threads", "quiet"},
          RunChanged};
}

}  // namespace sagitta

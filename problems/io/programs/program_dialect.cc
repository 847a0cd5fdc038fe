#include "problems/io/programs/program_dialect.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "problems/input_error.h"
#include "problems/io/programs/calls_elsewhere.h"
#include "problems/io/programs/language_words.h"
#include "problems/io/programs/robot_program.h"
#include "problems/text.h"

namespace sagitta {
namespace {

std::vector<ProgramDialect> AllDialects() {
  std::vector<ProgramDialect> all;
  for (int i = 0; i < static_cast<int>(ProgramDialect::kCount); ++i) all.push_back(static_cast<ProgramDialect>(i));
  return all;
}

// ".src .dat .sub (KUKA), ..."
std::string KnownEndings() {
  std::vector<std::string> known;
  for (const ProgramDialect dialect : AllDialects()) {
    const DialectTraits& traits = TraitsOf(dialect);
    known.push_back(Joined({traits.endings.begin(), traits.endings.end()}, " ") + " (" + traits.maker + ")");
  }
  return Joined(known);
}

}  // namespace

const DialectTraits& TraitsOf(ProgramDialect dialect) {
  static const DialectTraits kKrl = {"KUKA KRL",
                                     "KUKA",
                                     {".src", ".dat", ".sub"},
                                     PoseNotation::kAbcDegrees,
                                     /*joints_in_rad=*/false,
                                     /*names_have_case=*/false,
                                     /*turns_of_three_joints=*/false,
                                     ReadKrl,
                                     KrlCalls,
                                     KrlWords};
  static const DialectTraits kRapid = {"ABB RAPID",
                                       "ABB",
                                       {".mod", ".modx", ".prg", ".sys"},
                                       PoseNotation::kQuaternion,
                                       /*joints_in_rad=*/false,
                                       /*names_have_case=*/false,
                                       /*turns_of_three_joints=*/false,
                                       ReadRapid,
                                       RapidCalls,
                                       RapidWords};
  static const DialectTraits kUrScript = {"URScript",
                                          "UR",
                                          {".script", ".urscript"},
                                          PoseNotation::kRotationVectorMetres,
                                          /*joints_in_rad=*/true,
                                          /*names_have_case=*/true,
                                          /*turns_of_three_joints=*/false,
                                          ReadUrScript,
                                          UrScriptCalls,
                                          UrScriptWords};
  static const DialectTraits kFanuc = {"FANUC LS",
                                       "FANUC",
                                       {".ls"},
                                       PoseNotation::kWprDegrees,
                                       /*joints_in_rad=*/false,
                                       /*names_have_case=*/false,
                                       /*turns_of_three_joints=*/true,
                                       ReadFanuc,
                                       FanucCalls,
                                       FanucWords};
  switch (dialect) {
    case ProgramDialect::kKrl:
      return kKrl;
    case ProgramDialect::kRapid:
      return kRapid;
    case ProgramDialect::kUrScript:
      return kUrScript;
    case ProgramDialect::kFanuc:
      return kFanuc;
    case ProgramDialect::kCount:
      break;
  }
  return kKrl;
}

ProgramDialect DialectOfFile(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
  for (const ProgramDialect dialect : AllDialects()) {
    for (const char* known : TraitsOf(dialect).endings) {
      if (ending == known) return dialect;
    }
  }
  throw InputError({path, 0, ""}, "the ending '" + ending + "' is of no robot program that is known", KnownEndings());
}

}  // namespace sagitta

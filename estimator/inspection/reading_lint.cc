#include "estimator/inspection/reading_lint.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "estimator/alignment/aligned_misfit.h"
#include "estimator/calibration/unit_guess.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr double kSuspicious = 0.005;  // of the reach: no arm needs that much calibration
constexpr double kImprovement = 5.0;
constexpr double kAsGood = 1.1;    // readings that fit alike: the simplest is named
constexpr double kPerfect = 1e-4;  // of the reach: no better fit means anything
constexpr size_t kMostFlips = 3;
constexpr size_t kShown = 6;
constexpr double kRightAngle = 1.57079632679489661923;

// q' = sign q + offset for some joints, or another kinematic table.
struct JointChange {
  int joint;
  double sign, offset;
};
struct Reading {
  std::string name, remedy;
  std::vector<JointChange> changes;
  std::optional<Robot> robot;
  double misfit = 0.0;
};

CalibrationProblem Reread(const CalibrationProblem& problem, const Reading& reading) {
  if (reading.robot) {
    Experiment experiment = problem.experiment;
    experiment.validation.kind = ValidationSpec::Kind::kNone;
    return MakeCalibrationProblem(*reading.robot, problem.data, experiment);
  }
  CalibrationProblem reread = problem;
  for (Configuration& configuration : reread.data.configurations) {
    for (const JointChange& change : reading.changes)
      configuration.q[change.joint] = change.sign * configuration.q[change.joint] + change.offset;
  }
  for (size_t s = 0; s < reread.shot_inputs.size(); ++s) {
    reread.shot_inputs[s].conditions.q = reread.data.configurations[reread.data.shots[s].configuration].q;
  }
  reread.model.Prepare(&reread.shot_inputs);
  return reread;
}

std::vector<int> RevoluteJoints(const Chain& chain) {
  std::vector<int> joints;
  for (int j = 0; j < chain.num_joints(); ++j) {
    if (chain.joints[j].type == JointType::kRevolute) joints.push_back(j);
  }
  return joints;
}

std::string Named(const Chain& chain, const std::vector<JointChange>& changes) {
  std::vector<std::string> names;
  for (const JointChange& change : changes) names.push_back(chain.joints[change.joint].name);
  return Enumerate(names);
}

// Subsets of joints that are counted the other way, smallest first.
void AddFlips(const Chain& chain, std::vector<Reading>* readings) {
  std::vector<std::vector<JointChange>> subsets = {{}};
  for (size_t size = 1; size <= kMostFlips; ++size) {
    std::vector<std::vector<JointChange>> larger;
    for (const auto& subset : subsets) {
      for (int j = subset.empty() ? 0 : subset.back().joint + 1; j < chain.num_joints(); ++j) {
        larger.push_back(subset);
        larger.back().push_back({j, -1.0, 0.0});
      }
    }
    for (const auto& subset : larger) {
      const std::string names = Named(chain, subset);
      readings->push_back(
          {(subset.size() == 1 ? "joint " : "joints ") + names + " counted the other way",
           "state sign: -1 on the joint's transform (a chain), turn the sign of the q columns, or check "
           "the axis directions of the table: " +
               names,
           subset,
           {}});
    }
    subsets = larger;
  }
}

void AddOffsets(const Chain& chain, std::vector<Reading>* readings) {
  for (const int j : RevoluteJoints(chain)) {
    for (const int quarter : {1, -1, 2}) {
      for (const double sign : {1.0, -1.0}) {
        const std::string degrees = std::to_string(90 * quarter);
        std::string name = "joint " + chain.joints[j].name + " with its zero " + degrees + " deg away";
        if (sign < 0) name += " and counted the other way";
        readings->push_back({name,
                             "add " + degrees + " deg to the joint's theta_deg or offset_deg" +
                                 (sign < 0 ? std::string(", and turn its sign") : ""),
                             {{j, sign, quarter * kRightAngle}},
                             {}});
      }
    }
  }
}

void AddTables(const CalibrationProblem& problem, std::vector<Reading>* readings) {
  if (!problem.robot.dh) return;
  const auto add = [&](const std::string& name, const std::string& remedy, DhTable table) {
    Robot robot = problem.robot;
    robot.chain = ChainFromDhTable(robot.chain.joints, robot.chain.couplings, table);
    robot.dh = table;
    readings->push_back({name, remedy, {}, robot});
  };
  const bool standard = problem.robot.dh->convention == DhConvention::kStandard;
  DhTable other = *problem.robot.dh;
  other.convention = standard ? DhConvention::kModified : DhConvention::kStandard;
  const std::string name = standard ? "modified" : "standard";
  add("the table as " + name + " DH", "state convention: " + name, other);
  // alpha and a of the link before: a modified table typed into rows of a standard one, and the reverse
  DhTable shifted = *problem.robot.dh;
  const int n = static_cast<int>(shifted.links.size());
  for (int i = 0; i < n; ++i) {
    const int from = standard ? (i + 1) % n : (i + n - 1) % n;
    shifted.links[i].a = problem.robot.dh->links[from].a;
    shifted.links[i].alpha = problem.robot.dh->links[from].alpha;
  }
  add("the table with a and alpha one row off", "check whether a and alpha belong to the joint's own row or the next",
      shifted);
  bool any_beta = false;
  DhTable without_beta = *problem.robot.dh;
  for (DhLink& link : without_beta.links) {
    any_beta |= link.beta != 0.0;
    link.beta = -link.beta;
  }
  if (any_beta) add("Hayati's beta of the other sign", "check the sign of beta_deg", without_beta);
}

std::vector<Reading> AllReadings(const CalibrationProblem& problem) {
  std::vector<Reading> readings;
  AddTables(problem, &readings);
  AddFlips(problem.robot.chain, &readings);
  AddOffsets(problem.robot.chain, &readings);
  return readings;
}

Finding Describe(const Reading& reading, double misfit) {
  Finding finding;
  finding.severity = Severity::kSerious;
  finding.code = reading.robot ? "dh_convention" : reading.changes[0].offset != 0.0 ? "joint_offset" : "sign_flip";
  finding.words = "the aligned nominal robot misses by " + WholeMillimetres(misfit) + " (RMS) as stated, by " +
                  WholeMillimetres(reading.misfit) + " with " + reading.name;
  finding.remedy = reading.remedy;
  return finding;
}

Finding Unexplained(double misfit) {
  return {Severity::kSerious,
          "misfit",
          "the aligned nominal robot misses by " + WholeMillimetres(misfit) +
              " (RMS), more than a calibration can be asked to explain, and no other sign, zero position, unit or DH "
              "convention alone explains it",
          "check that robot file and measurements belong together: joint order, signs, zero positions, link lengths",
          {}};
}

}  // namespace

double SuspiciousMisfit(const Chain& chain) { return kSuspicious * Reach(chain); }

ReadingLint LintReadings(const CalibrationProblem& problem) {
  ReadingLint lint;
  const std::vector<int> sample = SampleOfRows(problem);
  lint.misfit = AlignedMisfit(problem, sample);
  lint.readings.push_back({"as stated", lint.misfit});
  lint.is_suspicious = lint.misfit > SuspiciousMisfit(problem.robot.chain);
  if (!lint.is_suspicious) return lint;
  if (const auto unit = GuessWrongUnit(problem)) {
    lint.findings.push_back({Severity::kSerious,
                             "unit",
                             unit->column + ": " + unit->words,
                             unit->hint,
                             {unit->file + ":" + std::to_string(unit->line)}});
    lint.is_explained = true;
    return lint;
  }
  std::vector<Reading> readings = AllReadings(problem);
  for (Reading& reading : readings) reading.misfit = AlignedMisfit(Reread(problem, reading), sample);
  double least = lint.misfit;
  for (const Reading& reading : readings) least = std::min(least, reading.misfit);
  const double best = std::max(kPerfect * Reach(problem.robot.chain), kAsGood * least);
  const auto simplest =
      std::find_if(readings.begin(), readings.end(), [&](const Reading& reading) { return reading.misfit <= best; });
  const bool explains = simplest != readings.end() && simplest->misfit * kImprovement < lint.misfit;
  lint.is_explained = explains;
  lint.findings.push_back(explains ? Describe(*simplest, lint.misfit) : Unexplained(lint.misfit));
  std::stable_sort(readings.begin(), readings.end(),
                   [](const Reading& a, const Reading& b) { return a.misfit < b.misfit; });
  for (size_t i = 0; i < std::min(kShown, readings.size()); ++i)
    lint.readings.push_back({readings[i].name, readings[i].misfit});
  return lint;
}

}  // namespace sagitta

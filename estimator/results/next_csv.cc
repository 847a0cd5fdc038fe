#include "estimator/results/next_csv.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "problems/io/rows_in_memory.h"
#include "problems/io/text_checks.h"
#include "problems/io/units.h"
#include "problems/split.h"
#include "problems/text.h"

namespace sagitta {
namespace {

// Of the station, its instrument, its markers, the load and the split a cell stays. Of the moment of measuring nothing
// is known (time, temperature, the direction of a joint's last motion), and a remark was about another row.
bool IsOfTheScene(const std::string& column, const ValidationSpec& validation) {
  static const std::set<std::string> names = {"marker", "station", "visit", "repeat", "load",  "set",
                                              "fx_N",   "fy_N",    "fz_N",  "mx_Nm",  "my_Nm", "mz_Nm"};
  const bool splits = validation.kind == ValidationSpec::Kind::kColumn && column == validation.column;
  return splits || names.count(column) > 0 || column.rfind("sigma_", 0) == 0;
}

struct JointColumn {
  int joint = 0;
  Unit unit;
};

// Of q<i>_unit in a unit that joint i may be stated in; nothing of other columns.
std::optional<JointColumn> JointColumnOf(const Chain& chain, const std::string& column) {
  for (int j = 0; j < chain.num_joints(); ++j) {
    const bool turns = chain.joints[j].type == JointType::kRevolute;
    for (const Unit& unit : UnitsOf(turns ? Dimension::kAngle : Dimension::kLength)) {
      if (column == "q" + std::to_string(j + 1) + "_" + unit.suffix) return JointColumn{j, unit};
    }
  }
  return std::nullopt;
}

// A joint value of the pose to 1e-3 deg or mm, 1e-5 rad or m; nothing where the column is of no joint.
std::string JointCell(const Chain& chain, const std::string& column, const ProposedPose& pose) {
  const std::optional<JointColumn> of_joint = JointColumnOf(chain, column);
  if (!of_joint) return "";
  const double si = of_joint->unit.ToSi(1.0);
  return Fixed(pose.q[of_joint->joint] / si, si == 1.0 ? 5 : 3);
}

constexpr char kConfigColumn[] = "config";
constexpr char kVisitColumn[] = "visit";

// Columns of all files, and of joint values where rows are of none; again: poses are visited once more, which a column
// has to say.
std::vector<std::string> HeaderOfNext(const Measurements& data, const Chain& chain, bool again) {
  std::vector<std::string> header;
  for (const MeasurementFile& file : data.files) {
    for (const std::string& column : file.header) {
      if (std::find(header.begin(), header.end(), column) == header.end()) header.push_back(column);
    }
  }
  const bool has_joints = std::any_of(header.begin(), header.end(), [&](const std::string& column) {
    return JointColumnOf(chain, column).has_value();
  });
  for (int j = 0; j < chain.num_joints() && !has_joints; ++j) {
    const char* unit = chain.joints[j].type == JointType::kRevolute ? "_deg" : "_mm";
    header.push_back("q" + std::to_string(j + 1) + unit);
  }
  if (again && std::find(header.begin(), header.end(), kVisitColumn) == header.end()) header.push_back(kVisitColumn);
  return header;
}

// Points that a pose is measured with; one that is visited again as in its first visit. A pose's two readings are one
// row.
std::vector<int> RowsLike(const Measurements& data, int configuration, bool again) {
  std::vector<int> rows;
  const std::vector<int> shots = ShotsOfProposal(data, configuration);
  for (size_t i = 0; i < data.observations.size(); ++i) {
    const Observation& row = data.observations[i];
    if (!row.is_point() || !std::binary_search(shots.begin(), shots.end(), row.shot)) continue;
    if (again && data.shots[row.shot].visit != data.shots[shots.front()].visit) continue;
    rows.push_back(static_cast<int>(i));
  }
  return rows;
}

// A name that none of the configuration's visits has.
std::string VisitAfter(const Measurements& data, int configuration) {
  std::set<std::string> visits;
  for (const Shot& shot : data.shots) {
    if (shot.configuration == configuration) visits.insert(shot.visit);
  }
  for (size_t number = visits.size() + 1;; ++number) {
    const std::string name = std::to_string(number);
    if (visits.count(name) == 0) return name;
  }
}

// Whether the row of a pose has the cell of the row that it is like: a pose that is visited again is that pose.
bool StaysInNext(const std::string& column, bool again, const CalibrationProblem& problem) {
  if (again && (column == kConfigColumn || JointColumnOf(problem.robot().chain, column))) return true;
  return IsOfTheScene(column, problem.experiment().validation);
}

std::string LineOfCells(const std::vector<std::string>& texts) {
  std::vector<std::string> cells;
  for (const std::string& text : texts) cells.push_back(CsvCell(text));
  return Joined(cells, ",") + "\n";
}

// own: cells that are neither those of the row that it is like nor joint values.
std::string NextRow(const Measurements& data, int like, const std::vector<std::string>& header, const Diagnosis& d,
                    const ProposedPose& pose, const std::map<std::string, std::string>& own) {
  const Observation& row = data.observations[like];
  const MeasurementFile& file = data.files[row.file];
  const MeasurementRows::Cells cells = file.rows[row.row].cells;
  const CalibrationProblem& problem = *d.baseline.problem;
  std::vector<std::string> texts;
  for (const std::string& column : header) {
    const int at = file.FindColumn(column);
    const auto stated = own.find(column);
    if (stated != own.end()) {
      texts.push_back(stated->second);
    } else if (at >= 0 && StaysInNext(column, d.next->again, problem)) {
      texts.emplace_back(cells[at]);
    } else {
      texts.push_back(JointCell(problem.robot().chain, column, pose));
    }
  }
  return LineOfCells(texts);
}

}  // namespace

std::string NextToCsv(const Diagnosis& d) {
  const CalibrationProblem& problem = *d.baseline.problem;
  std::optional<Measurements> made;
  const Measurements& data = WithCells(problem.data(), &made);
  const ValidationSpec& validation = problem.experiment().validation;
  const std::vector<std::string> header = HeaderOfNext(data, problem.robot().chain, d.next->again);
  const std::vector<std::string> names =
      NamesThatAreFitted(validation, data, "next", static_cast<int>(d.next->poses.size()));
  std::string text = LineOfCells(header);
  for (size_t k = 0; k < d.next->poses.size(); ++k) {
    const ProposedPose& pose = d.next->poses[k];
    std::map<std::string, std::string> own;
    if (d.next->again) own[kVisitColumn] = VisitAfter(data, pose.like);
    if (!d.next->again) own[kConfigColumn] = names[k];
    for (const int i : RowsLike(data, pose.like, d.next->again)) text += NextRow(data, i, header, d, pose, own);
  }
  return text;
}

}  // namespace sagitta

#include "problems/io/measurement_row.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "models/effects/effect.h"
#include "problems/input_error.h"
#include "problems/io/load_names.h"
#include "problems/limits.h"
#include "problems/text.h"

namespace sagitta {
namespace {

std::string HintForNoNumber(const std::string& cell, const char* otherwise) {
  if (cell.find(',') != std::string::npos) return "numbers have a decimal point and no commas";
  const auto is_plain = [](unsigned char c) { return c < 0x80; };
  if (std::all_of(cell.begin(), cell.end(), is_plain)) return otherwise;
  return "it has a character that no number has, a typographic minus or a blank of its own kind: write - and plain "
         "digits";
}

class RowReader {
 public:
  RowReader(const MeasurementFile& file, const MeasurementFile::Row& row, std::vector<NumberRead>* last)
      : file_(file), row_(row), last_(*last) {}

  [[noreturn]] void Fail(const std::string& column, const std::string& what, const std::string& hint = "") const {
    throw InputError({file_.path, row_.line, column}, what, hint);
  }

  // Empty cells of optional columns count as not stated.
  bool IsStated(const NumberColumn& column) const { return column.present() && !row_.cells[column.index].empty(); }

  std::string_view Text(int column, std::string_view otherwise) const {
    return column < 0 || row_.cells[column].empty() ? otherwise : row_.cells[column];
  }

  std::string_view RequiredText(int column) const {
    if (row_.cells[column].empty()) Fail(file_.header[column], "the cell is empty");
    return row_.cells[column];
  }

  // At most `most`, SI, either sign (problems/limits.h); hint: to where there is none.
  double Number(const NumberColumn& column, double most, const char* hint = "") const {
    const std::string_view text = row_.cells[column.index];
    NumberRead& last = last_[column.index];
    if (!text.empty() && text == last.text) return last.si;
    const std::optional<double> number = ParseNumber(text);
    if (number) {
      const double si = column.unit.ToSi(*number);
      if (std::abs(si) <= most) {
        last = {text, si};
        return si;
      }
    }
    const std::string cell(text);
    if (number) {
      Fail(column.name, "'" + cell + "' is beyond anything that is measured on a robot",
           "at most " + FormatNumber(ToUnit(most, column.unit)));
    }
    if (cell.empty()) Fail(column.name, "the cell is empty, a number is expected", hint);
    Fail(column.name, "'" + cell + "' is not a finite number", HintForNoNumber(cell, hint));
  }

  double NumberOr(const NumberColumn& column, double otherwise, double most) const {
    return IsStated(column) ? Number(column, most) : otherwise;
  }

  double Sigma(const NumberColumn& column, double least, double most) const {
    const double sigma = Number(column, std::numeric_limits<double>::max());
    if (sigma <= 0.0) Fail(column.name, "a standard deviation is above 0");
    if (sigma < least || sigma > most) {
      Fail(column.name, "'" + std::string(row_.cells[column.index]) + "' is no standard deviation of a measurement",
           "between " + FormatNumber(ToUnit(least, column.unit)) + " and " + FormatNumber(ToUnit(most, column.unit)));
    }
    return sigma;
  }

  bool IsAnyStated(const std::array<NumberColumn, 3>& columns) const {
    return IsStated(columns[0]) || IsStated(columns[1]) || IsStated(columns[2]);
  }

  // All three or none; false: none.
  bool Triple(const std::array<NumberColumn, 3>& columns, bool required, double most, Vector3<double>* values,
              const char* hint = "") const {
    if (!IsAnyStated(columns) && !required) return false;
    for (int i = 0; i < 3; ++i) (*values)[i] = Number(columns[i], most, hint);
    return true;
  }

 private:
  const MeasurementFile& file_;
  const MeasurementFile::Row& row_;
  std::vector<NumberRead>& last_;
};

void ReadPoint(const RowReader& reader, const MeasurementColumns& columns, const MeasurementReadOptions& options,
               MeasurementRow* row) {
  row->point.setConstant(std::numeric_limits<double>::quiet_NaN());
  reader.Triple(columns.point, options.points_required, limits::kCoordinate, &row->point,
                "a lost reading has x, y and z all empty");
  row->sigma.setZero();
  for (int i = 0; i < 3 && options.row_sigmas_used && reader.IsAnyStated(columns.sigma); ++i) {
    row->sigma[i] = reader.Sigma(columns.sigma[i], limits::kLeastSigma, limits::kLargestSigma);
  }
  Vector3<double> sim;  // read by name later; checked here with the rest
  reader.Triple(columns.sim, false, limits::kCoordinate, &sim);
}

// A rotation vector or a quaternion; empty cells: the reading is a point.
void ReadRotation(const RowReader& reader, const MeasurementColumns& columns, MeasurementRow* row) {
  Vector3<double> vector;
  const auto stated = [&](const NumberColumn& column) { return reader.IsStated(column); };
  const auto& q = columns.quaternion;
  row->is_pose = true;
  if (reader.Triple(columns.rotation, false, limits::kJointValue, &vector)) {
    row->rotation = RotationFromVector(vector);
  } else if (std::any_of(q.begin(), q.end(), stated)) {
    Eigen::Quaterniond rotation(reader.Number(q[0], 2.0), reader.Number(q[1], 2.0), reader.Number(q[2], 2.0),
                                reader.Number(q[3], 2.0));
    if (std::abs(rotation.norm() - 1.0) > kUnitQuaternion) {
      reader.Fail(q[0].name, "ow, ox, oy, oz have the length " + FormatNumber(rotation.norm()),
                  "a unit quaternion is expected, scalar first");
    }
    row->rotation = rotation.normalized().toRotationMatrix();
  } else {
    row->is_pose = false;
  }
  row->rotation_sigma.setZero();
  if (reader.IsStated(columns.common_rotation_sigma)) {
    row->rotation_sigma.setConstant(
        reader.Sigma(columns.common_rotation_sigma, limits::kLeastRotationSigma, limits::kLargestRotationSigma));
  } else if (reader.IsAnyStated(columns.rotation_sigma)) {
    for (int i = 0; i < 3; ++i) {
      row->rotation_sigma[i] =
          reader.Sigma(columns.rotation_sigma[i], limits::kLeastRotationSigma, limits::kLargestRotationSigma);
    }
  }
}

void ReadLoad(const RowReader& reader, const MeasurementColumns& columns, MeasurementRow* row) {
  for (int i = 0; i < 3; ++i) {
    row->wrench.force[i] = reader.NumberOr(columns.wrench[i], 0.0, limits::kForce);
    row->wrench.moment[i] = reader.NumberOr(columns.wrench[i + 3], 0.0, limits::kMoment);
  }
  const bool loaded = !row->wrench.IsZero();
  // Without a load column the wrench alone distinguishes the two states.
  row->load = reader.Text(columns.load, columns.load < 0 && loaded ? "unnamed" : kNoLoad);
  if (IsNoneInOtherLetters(row->load)) {
    reader.Fail("load", "'" + std::string(row->load) + "': " + kLoadOrNone, kHowNoneIsWritten);
  }
  if (row->load == kNoLoad && loaded) {
    reader.Fail("load", "load 'none' has a wrench that is not 0", "name the load state, or set the wrench to 0");
  }
}

void ReadApproach(const RowReader& reader, const MeasurementColumns& columns, MeasurementRow* row) {
  row->approach.clear();
  const auto stated = [&](const NumberColumn& column) { return reader.IsStated(column); };
  if (std::none_of(columns.approach.begin(), columns.approach.end(), stated)) return;
  for (const NumberColumn& column : columns.approach) {
    if (!reader.IsStated(column)) {
      row->approach.push_back(kApproachNotStated);
      continue;
    }
    const double direction = reader.NumberOr(column, 0.0, 1e9);
    if (direction != -1.0 && direction != 0.0 && direction != 1.0) {
      reader.Fail(column.name, "the direction of the last motion is -1, 0 or 1");
    }
    row->approach.push_back(static_cast<int>(direction));
  }
}

void ReadTorques(const RowReader& reader, const MeasurementColumns& columns, MeasurementRow* row) {
  row->joint_torques.resize(0);
  const auto stated = [&](const NumberColumn& column) { return reader.IsStated(column); };
  if (std::none_of(columns.torque.begin(), columns.torque.end(), stated)) return;
  row->joint_torques.resize(static_cast<Eigen::Index>(columns.torque.size()));
  for (size_t j = 0; j < columns.torque.size(); ++j) {
    row->joint_torques[static_cast<Eigen::Index>(j)] = reader.Number(columns.torque[j], limits::kMoment);
  }
}

void CheckSet(const RowReader& reader, const MeasurementColumns& columns) {
  if (columns.set < 0) return;
  const std::string_view set = reader.Text(columns.set, "calibration");
  if (set == "calibration" || set == "validation") return;
  const std::string cell(set);
  reader.Fail("set", "'" + cell + "' is no set", SpellingHint(cell, {"calibration", "validation"}));
}

}  // namespace

void MeasurementRowReader::Read(const MeasurementFile::Row& cells, MeasurementRow* row) {
  const MeasurementColumns& columns = columns_;
  const RowReader reader(file_, cells, &last_);
  const auto is_empty = [&](const NumberColumn& column) { return column.present() && !reader.IsStated(column); };
  row->lost = options_.points_required && std::all_of(columns.point.begin(), columns.point.end(), is_empty);
  if (row->lost) return;
  row->config = reader.RequiredText(columns.config);
  row->marker = reader.RequiredText(columns.marker);
  row->station = reader.Text(columns.station, "S1");
  row->visit = reader.Text(columns.visit, "");
  row->repeat = reader.Text(columns.repeat, "");
  row->q.resize(static_cast<Eigen::Index>(columns.q.size()));
  for (size_t j = 0; j < columns.q.size(); ++j) {
    row->q[static_cast<Eigen::Index>(j)] = reader.Number(columns.q[j], limits::kJointValue);
  }
  ReadPoint(reader, columns, options_, row);
  ReadRotation(reader, columns, row);
  ReadLoad(reader, columns, row);
  ReadApproach(reader, columns, row);
  ReadTorques(reader, columns, row);
  CheckSet(reader, columns);
  row->has_time = reader.IsStated(columns.time);
  row->time = reader.NumberOr(columns.time, 0.0, limits::kTime);
  row->has_temperature = reader.IsStated(columns.temperature);
  row->temperature = reader.NumberOr(columns.temperature, 0.0, limits::kTemperature);
}

}  // namespace sagitta

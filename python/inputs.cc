#include "python/inputs.h"

#include <pybind11/stl.h>

#include <cmath>

#include "problems/io/diagnosis_prior.h"
#include "problems/io/effect_names.h"
#include "problems/io/experiment_file.h"
#include "problems/io/files.h"
#include "problems/io/measurement_file.h"
#include "problems/io/measurement_writer.h"
#include "problems/io/text_checks.h"
#include "problems/range.h"
#include "problems/text.h"

namespace sagitta::python {

namespace py = pybind11;

namespace {

std::string TextOf(const py::handle& text, const InputError::Where& where) {
  try {
    return py::cast<std::string>(text);
  } catch (const py::cast_error&) {
    throw InputError(where, "the text has letters that UTF-8 does not have (lone surrogates)");
  }
}

// Numbers by the shortest text that reads back to the same double: nothing is lost on the way through cells.
std::vector<std::string> CellsOf(const std::string& table, const std::string& name, const py::handle& column) {
  std::vector<std::string> cells;
  if (py::isinstance<py::array_t<double>>(column)) {
    const auto numbers = py::reinterpret_borrow<py::array_t<double>>(column);
    if (numbers.ndim() != 1) throw InputError({table, 0, name}, "a column has one dimension");
    const auto at = numbers.unchecked<1>();
    cells.reserve(static_cast<size_t>(at.shape(0)));
    for (py::ssize_t i = 0; i < at.shape(0); ++i) cells.push_back(std::isnan(at(i)) ? "" : FormatNumber(at(i)));
    return cells;
  }
  for (const py::handle& cell : column)
    cells.push_back(TextOf(cell, {table, static_cast<int>(cells.size()) + 1, name}));
  return cells;
}

}  // namespace

CsvTable TableFrom(const std::string& name, const py::dict& columns) {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> cells;
  for (const auto& [key, column] : columns) {
    header.push_back(TextOf(key, {name, 0, ""}));
    cells.push_back(CellsOf(name, header.back(), column));
    if (cells.back().size() == cells.front().size()) continue;
    throw InputError({name, 0, header.back()}, "the column has " + std::to_string(cells.back().size()) + " values, '" +
                                                   header.front() + "' has " + std::to_string(cells.front().size()));
  }
  return CsvTableOf(name, std::move(header), cells);
}

namespace {

// Of rows that the library wrote: their cells are what they were, and row 1 is the first.
CsvTable TableFromText(const std::string& name, const std::string& text) {
  const MeasurementFile file = ParseCsvTable(text, name).file;
  std::vector<std::vector<std::string>> columns(file.header.size());
  for (const MeasurementFile::Row row : file.rows) {
    for (size_t c = 0; c < columns.size(); ++c) columns[c].emplace_back(row.cells[c]);
  }
  return CsvTableOf(name, file.header, columns);
}

}  // namespace

CsvTable TableFrom(const py::object& source, std::vector<InputFile>* files) {
  CsvTable table;
  if (py::isinstance<py::str>(source)) {
    table = ReadCsvTable(py::cast<std::string>(source));
  } else {
    const auto [name, cells] = py::cast<std::pair<std::string, py::object>>(source);
    table = py::isinstance<py::str>(cells) ? TableFromText(name, py::cast<std::string>(cells))
                                           : TableFrom(name, py::cast<py::dict>(cells));
  }
  if (files != nullptr) files->push_back({table.file.path, table.file.sha256});
  return table;
}

Measurements RowsFrom(const Robot& robot, const py::list& sources, bool points_required,
                      std::vector<InputFile>* files) {
  std::vector<CsvTable> tables;
  for (const py::handle& source : sources) {
    tables.push_back(TableFrom(py::reinterpret_borrow<py::object>(source), files));
  }
  MeasurementReadOptions options;
  options.points_required = points_required;
  return MeasurementsFromTables(std::move(tables), robot, options);
}

CalibrationProblem ProblemOf(const ExperimentInputs& inputs, bool force) {
  CalibrationProblem problem = MakeCalibrationProblem(inputs.robot, inputs.data, inputs.experiment);
  if (!force) CheckReadings(problem, kForce);
  return problem;
}

py::array ViewOf(const Eigen::Ref<const Eigen::MatrixXd>& matrix, const py::handle& owner) {
  const auto size = static_cast<py::ssize_t>(sizeof(double));
  py::array_t<double> view({matrix.cols(), matrix.rows()}, {matrix.outerStride() * size, size}, matrix.data(), owner);
  view.attr("setflags")(py::arg("write") = false);
  return std::move(view);
}

py::array PointsOf(const Measurements& data, const Eigen::Matrix3Xd& values, const py::handle& owner) {
  if (data.NumRows() == values.cols()) return ViewOf(values, owner);
  py::array_t<double> points({static_cast<py::ssize_t>(data.NumRows()), py::ssize_t{3}});
  auto at = points.mutable_unchecked<2>();
  py::ssize_t row = 0;
  for (size_t k = 0; k < data.observations.size(); ++k) {
    if (!data.observations[k].is_point()) continue;
    for (int a = 0; a < 3; ++a) at(row, a) = values(a, static_cast<Eigen::Index>(k));
    ++row;
  }
  return std::move(points);
}

namespace {

ExperimentInputs ReadFiles(const std::vector<std::string>& paths, bool row_sigmas_used, bool points_required) {
  return ReadExperimentInputs(paths, {points_required, row_sigmas_used});
}

// robot: a path, or its text where `is_text`.
ExperimentInputs Assemble(const std::string& robot, bool is_text, const py::list& sources, const std::string& settings,
                          bool row_sigmas_used, bool points_required) {
  ExperimentInputs inputs;
  inputs.robot = is_text ? ReadRobotText(robot, "robot") : ReadRobotFile(robot);
  inputs.files.push_back(is_text ? InputFile{"robot", Sha256(robot)} : DescribeInput(robot));
  inputs.experiment = ReadExperimentSettings(settings, "settings");
  inputs.prior = ReadDiagnosisPriorText(settings, "settings");
  if (settings != "{}") inputs.experiment.file = "settings";
  std::vector<CsvTable> tables;
  for (const py::handle& source : sources) {
    tables.push_back(TableFrom(py::reinterpret_borrow<py::object>(source), &inputs.files));
  }
  inputs.data = MeasurementsFromTables(std::move(tables), inputs.robot, {points_required, row_sigmas_used});
  return inputs;
}

py::array_t<double> PointsMeasured(const Measurements& data) {
  py::array_t<double> points({static_cast<py::ssize_t>(data.NumRows()), py::ssize_t{3}});
  auto at = points.mutable_unchecked<2>();
  py::ssize_t row = 0;
  for (const Observation& observation : data.observations) {
    if (!observation.is_point()) continue;
    for (int a = 0; a < 3; ++a) at(row, a) = observation.point_in_station[a];
    ++row;
  }
  return points;
}

py::array_t<double> JointValues(const Measurements& data) {
  const auto n = static_cast<py::ssize_t>(data.configurations.size());
  const py::ssize_t joints = n == 0 ? 0 : data.configurations.front().q.size();
  py::array_t<double> values({n, joints});
  auto at = values.mutable_unchecked<2>();
  for (py::ssize_t i = 0; i < n; ++i) {
    for (py::ssize_t j = 0; j < joints; ++j) at(i, j) = data.configurations[static_cast<size_t>(i)].q[j];
  }
  return values;
}

template <typename Class>
void BindData(Class& bound, const Measurements& (*data)(const typename Class::type&)) {
  using Type = typename Class::type;
  bound.def_property_readonly("stations", [data](const Type& self) { return data(self).stations; })
      .def_property_readonly("markers", [data](const Type& self) { return data(self).markers; })
      .def_property_readonly("warnings", [data](const Type& self) { return data(self).warnings; })
      .def_property_readonly("configurations",
                             [data](const Type& self) {
                               std::vector<std::string> ids;
                               for (const Configuration& c : data(self).configurations) ids.push_back(c.id);
                               return ids;
                             })
      .def_property_readonly("joint_values", [data](const Type& self) { return JointValues(data(self)); })
      .def_property_readonly("points_m", [data](const Type& self) { return PointsMeasured(data(self)); })
      .def("csv", [data](const Type& self) { return MeasurementsToCsv(data(self)); })
      .def("__len__", [data](const Type& self) { return data(self).NumRows(); });
}

}  // namespace

void BindInputs(py::module_& module) {
  py::class_<ExperimentInputs> inputs(module, "Inputs");
  BindData<py::class_<ExperimentInputs>>(inputs,
                                         [](const ExperimentInputs& i) -> const Measurements& { return i.data; });
  inputs.def_property_readonly("robot_name", [](const ExperimentInputs& i) { return i.robot.name; })
      .def_property_readonly("joints", [](const ExperimentInputs& i) { return JointNames(i.robot.chain.joints); })
      .def_property_readonly("robot_yaml", [](const ExperimentInputs& i) { return RobotToYaml(i.robot); })
      .def("set_sigma",
           [](ExperimentInputs& i, double sigma_mm) {
             CheckIn(allowed::kSigma, sigma_mm / 1e3, "sigma_mm");
             i.experiment.noise.from = NoiseSpec::From::kSigma;
             i.experiment.noise.sigma = sigma_mm / 1e3;
             i.experiment.noise.replaces_rows = true;
           })
      .def("set_holdout",
           [](ExperimentInputs& i, double fraction, unsigned long long seed) {
             CheckIn(allowed::kFraction, fraction, "holdout");
             i.experiment.validation = ValidationSpec();
             i.experiment.validation.kind = ValidationSpec::Kind::kFraction;
             i.experiment.validation.fraction = fraction;
             i.experiment.validation.seed = seed;
           })
      .def("set_validation_seed",
           [](ExperimentInputs& i, unsigned long long seed) {
             if (i.experiment.validation.kind != ValidationSpec::Kind::kFraction || i.experiment.validation.by_time) {
               throw InputError({"", 0, "seed"}, "no rows are held out at random", "holdout=0.3 holds some out");
             }
             i.experiment.validation.seed = seed;
           })
      .def("set_free", [](ExperimentInputs& i, std::vector<std::string> names) { i.experiment.estimate.free = names; })
      .def("set_fixed",
           [](ExperimentInputs& i, std::vector<std::string> names) { i.experiment.estimate.fixed = names; });
  py::class_<Rows> rows(module, "Rows");
  BindData<py::class_<Rows>>(rows, [](const Rows& r) -> const Measurements& { return r.data; });
  module.def("unguarded", &UnguardedCell);
  module.def("split_names", &SplitOutsideBrackets);
  module.def("read", &ReadFiles);
  module.def("assemble", &Assemble);
}

}  // namespace sagitta::python

// Experiments and rows as Python hands them in: files, or columns in memory.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <string>
#include <vector>

#include "estimator/sagitta.h"
#include "problems/io/csv_table.h"
#include "problems/io/target_file.h"

namespace sagitta::python {

// One name -> a NumPy array of float64 (of any stride, read where it lies), or a list of texts. Row 1 is the first.
CsvTable TableFrom(const std::string& name, const pybind11::dict& columns);

// A path, or a pair (name, columns) or (name, text of a file). `files`: what was read, for provenance.
CsvTable TableFrom(const pybind11::object& source, std::vector<InputFile>* files);

// Rows of a measurement table for this robot.
Measurements RowsFrom(const Robot& robot, const pybind11::list& sources, bool points_required,
                      std::vector<InputFile>* files);

struct Rows {
  Measurements data;
};

// What goes on where a robot cannot have made its readings.
constexpr const char* kForce = "force=True goes on as stated";
CalibrationProblem ProblemOf(const ExperimentInputs& inputs, bool force);

void BindInputs(pybind11::module_& module);
void BindEstimates(pybind11::module_& module);
void BindResults(pybind11::module_& module);

// 3 x N of Eigen as N x 3 of NumPy, row-major, read-only, without a copy; alive as long as `owner`.
pybind11::array ViewOf(const Eigen::Ref<const Eigen::MatrixXd>& matrix, const pybind11::handle& owner);
// The columns of points among those of all observations: a view where all are.
pybind11::array PointsOf(const Measurements& data, const Eigen::Matrix3Xd& values, const pybind11::handle& owner);

// A failure of the numbers, not of the input: raises sagitta.NumericalError.
struct NumericalFailure : std::runtime_error {
  NumericalFailure(std::string the_status, const std::string& message)
      : std::runtime_error(message), status(std::move(the_status)) {}
  std::string status;
};

// What a prediction throws where a load folds the arm.
template <typename Function>
auto Numerically(const Function& function) {
  try {
    return function();
  } catch (const InputError&) {
    throw;
  } catch (const Interruption&) {
    throw;
  } catch (const std::runtime_error& error) {
    const bool folded = std::string(error.what()).find("equilibrium_diverged") != std::string::npos;
    throw NumericalFailure(folded ? "equilibrium_diverged" : "failed", error.what());
  }
}

}  // namespace sagitta::python

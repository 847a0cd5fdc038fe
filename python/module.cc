// sagitta._core: what python/sagitta/__init__.py is made of. Units and rules are those of the library's front door.
#include <glog/logging.h>
#include <pybind11/pybind11.h>

#include "problems/io/pattern.h"
#include "problems/io/text_checks.h"
#include "python/inputs.h"
#include "python/interruptible.h"

namespace sagitta::python {
namespace {

namespace py = pybind11;

// Arguments have the names of the program's flags, but for those of the commands that Python does not have.
std::string WithoutHyphens(const std::string& text) {
  static const std::regex flag = MakePattern("(^|[ (])--(?!(base_link|tip_link|out)\\b)([a-z])");
  return ReplacePattern(text, flag, "$1$3");
}

// Raises an exception of the package with attributes.
void Raise(const char* type, const std::string& what,
           const std::vector<std::pair<const char*, py::object>>& attributes) {
  const py::object raised = py::module_::import("sagitta").attr(type)(what);
  for (const auto& [name, value] : attributes) raised.attr(name) = value;
  PyErr_SetObject(raised.get_type().ptr(), raised.ptr());
}

void Translate(std::exception_ptr thrown) {
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const InputError& error) {
    const std::string file = error.where().file;
    const std::string words = WithoutHyphens(std::string(error.what()).substr(file.size()));
    Raise("InputError", ValidUtf8(file + words),
          {{"file", py::str(ValidUtf8(file))},
           {"line", py::int_(error.where().line)},
           {"key", py::str(ValidUtf8(WithoutHyphens(error.where().key)))},
           {"hint", py::str(ValidUtf8(WithoutHyphens(error.hint())))}});
  } catch (const NumericalFailure& error) {
    Raise("NumericalError", error.what(), {{"status", py::str(error.status)}});
  } catch (const Interruption&) {
    PyErr_SetNone(PyExc_SystemExit);  // the interpreter ends: it alone interrupts what has no progress
  }
}

}  // namespace
}  // namespace sagitta::python

PYBIND11_MODULE(_core, module) {
  FLAGS_minloglevel = google::GLOG_FATAL;  // Ceres' own words help nobody, and a library prints nothing
  module.attr("__version__") = SAGITTA_VERSION;
  pybind11::register_exception_translator(sagitta::python::Translate);
  pybind11::module_::import("atexit").attr("register")(pybind11::cpp_function(&sagitta::python::EndRunningCalls));
  pybind11::module_::import("os").attr("register_at_fork")(
      pybind11::arg("after_in_child") = pybind11::cpp_function(&sagitta::python::ForgetRunningCalls));
  sagitta::python::BindInputs(module);
  sagitta::python::BindEstimates(module);
  sagitta::python::BindResults(module);
}

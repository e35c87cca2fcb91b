#include <exception>
#include <system_error>

#include "bindings.h"
#include "twin/core/error.h"

namespace twin::python {
namespace {

nb::handle robot_fault;  // panda_twin._errors.RobotFault; of a module that is never unloaded

/// InputError becomes ValueError, EnvironmentError OSError, RobotFault the package's own class.
void Translate(const std::exception_ptr& thrown, void* /*payload*/) {
  try {
    std::rethrow_exception(thrown);
  } catch (const InputError& error) {
    PyErr_SetString(PyExc_ValueError, error.what());
  } catch (const EnvironmentError& error) {
    PyErr_SetString(PyExc_OSError, error.what());
  } catch (const std::system_error& error) {
    PyErr_SetString(PyExc_OSError, error.what());
  } catch (const Error& error) {
    PyErr_SetString(robot_fault.ptr(), error.what());
  }
}

}  // namespace

void AddErrors(nb::module_& module) {
  const nb::module_ errors = nb::module_::import_("panda_twin._errors");
  robot_fault = nb::object(errors.attr("RobotFault")).release();
  module.attr("RobotFault") = robot_fault;
  nb::register_exception_translator(&Translate);
}

}  // namespace twin::python

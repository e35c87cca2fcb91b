#include <exception>
#include <system_error>

#include "bindings.h"
#include "twin/core/error.h"

namespace twin::python {
namespace {

nb::handle robot_fault;  // owned by the module, which is never unloaded

/// InputError becomes ValueError, EnvironmentError OSError, RobotFault the module's own class.
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
  robot_fault = nb::exception<RobotFault>(module, "RobotFault", PyExc_RuntimeError).release();
  nb::register_exception_translator(&Translate);
}

}  // namespace twin::python

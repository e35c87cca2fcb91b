#pragma once

#include <stdexcept>
#include <string>

namespace twin {

/// Base of all failures outside real time that the user or the environment causes. The text says
/// what is wrong, where (file, line, field), the value, the allowed range and the remedy.
class Error : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Invalid file, flag, model, scenario or trajectory. Exit code 3.
class InputError : public Error {
  using Error::Error;
};

/// The host lacks something: a program, a writable folder, a mesh package, a scheduler permission.
/// Exit code 4.
class EnvironmentError : public Error {
  using Error::Error;
};

/// The robot or its backend refused or aborted a request. Exit code 1.
class RobotFault : public Error {
  using Error::Error;
};

}  // namespace twin

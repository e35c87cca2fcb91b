#pragma once

#include <stdexcept>
#include <string>

namespace twin {

/// Base of every failure that is the user's or the world's, outside real time. The text says what
/// is wrong, where (file, line, field), the value and the allowed range, and what to do.
class Error : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A file, a flag, a model, a scenario or a trajectory is not acceptable. Exit code 3.
class InputError : public Error {
  using Error::Error;
};

/// The host lacks something: a program, a folder that can be written, a mesh package, a scheduler
/// right. Exit code 4.
class EnvironmentError : public Error {
  using Error::Error;
};

/// The robot or its backend refused or ended something that was asked of it. Exit code 1.
class RobotFault : public Error {
  using Error::Error;
};

}  // namespace twin

#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

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

/// @param what  area and field as the user knows them: "tick: lambda".
/// @throws InputError naming `what`, the value and the range, unless value is in [low, high]; NaN
/// always throws.
void RequireInRange(std::string_view what, double value, double low, double high);

namespace internal {
[[noreturn]] void CheckFailed(const char* condition, const char* file, int line);
}  // namespace internal

}  // namespace twin

/// Aborts the program when `condition` is false: a bug of ours. Always on. Never used in a tick.
#define TWIN_CHECK(condition)         \
  ((condition) ? static_cast<void>(0) \
               : ::twin::internal::CheckFailed(#condition, __FILE__, __LINE__))

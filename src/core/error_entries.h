#pragma once

#include <array>

#include "twin/core/error_catalogue.h"

namespace twin {

/// Entries of all errors, by index; that of communication_constraints_violation is for consecutive
/// lost commands.
extern const std::array<ErrorEntry, kRobotErrorCount> kErrorEntries;

/// communication_constraints_violation of a motion whose first command did not arrive.
extern const ErrorEntry kNoFirstCommandEntry;
/// instability_detected caused by a value that is not finite.
extern const ErrorEntry kNoNumberEntry;

}  // namespace twin

#pragma once

#include <array>

#include "twin/core/error_catalogue.h"

namespace twin {

/// The entries of all errors, by index; of communication_constraints_violation the one for commands
/// lost in a row.
extern const std::array<ErrorEntry, kRobotErrorCount> kErrorEntries;

/// communication_constraints_violation of a motion whose first command did not come.
extern const ErrorEntry kNoFirstCommandEntry;
/// That of an instability whose cause is a value that is no number.
extern const ErrorEntry kNoNumberEntry;

}  // namespace twin

#pragma once

#include <array>

#include "twin/core/error_catalogue.h"

namespace twin {

/// Entries of all errors, by index; that of communication_constraints_violation is for consecutive
/// lost commands.
extern const std::array<ErrorEntry, kRobotErrorCount> kErrorEntries;

/// Another cause of an error, which its violations tell by their axis.
struct OtherCause {
  RobotError error{};
  std::int8_t axis = -1;
  ErrorEntry entry;
};
extern const std::array<OtherCause, 2> kOtherCauses;

}  // namespace twin

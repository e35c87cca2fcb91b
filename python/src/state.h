#pragma once

#include <string>
#include <vector>

#include "twin/core/robot_errors.h"

namespace twin::python {

/// As clients of the real robot print them.
[[nodiscard]] std::vector<std::string> NamesOf(const RobotErrors& errors);

}  // namespace twin::python

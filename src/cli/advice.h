#pragma once

#include <string_view>

#include "twin/core/robot_errors.h"

namespace twin::cli {

/// What a user can do about an error of the robot's controller.
[[nodiscard]] std::string_view Advice(RobotError error) noexcept;

}  // namespace twin::cli

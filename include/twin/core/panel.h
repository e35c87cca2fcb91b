#pragma once

#include <cstdint>
#include <string_view>

namespace twin {

/// Manual actions at the robot beside the wire: buttons and switches. Source: FCI protocol 5, user
/// stop, guiding, brakes, recovery.
enum class PanelAction : std::uint8_t {
  kPressUserStop,
  kReleaseUserStop,
  kCloseBrakes,
  kOpenBrakes,
  kPressGuidingButton,
  kReleaseGuidingButton,
};

inline constexpr int kPanelActions = 6;

/// In snake case: "press_user_stop", ...
[[nodiscard]] std::string_view Name(PanelAction action) noexcept;

}  // namespace twin

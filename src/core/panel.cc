#include "twin/core/panel.h"

namespace twin {

std::string_view Name(PanelAction action) noexcept {
  switch (action) {
    case PanelAction::kPressUserStop: return "press_user_stop";
    case PanelAction::kReleaseUserStop: return "release_user_stop";
    case PanelAction::kCloseBrakes: return "close_brakes";
    case PanelAction::kOpenBrakes: return "open_brakes";
    case PanelAction::kPressGuidingButton: return "press_guiding_button";
    case PanelAction::kReleaseGuidingButton: return "release_guiding_button";
  }
  return "unknown";
}

}  // namespace twin

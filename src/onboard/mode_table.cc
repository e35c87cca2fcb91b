#include "twin/onboard/mode_table.h"

#include <fmt/format.h>

namespace twin::onboard {
namespace {

constexpr std::array<std::string_view, kRequests> kRequestNames{
    "Move",
    "Stop Move",
    "Get Cartesian Limit",
    "Set requests",
    "Automatic Error Recovery",
    "Load Model Library",
    "press_user_stop",
    "release_user_stop",
    "close_brakes",
    "open_brakes",
    "press_guiding_button",
    "release_guiding_button",
};

}  // namespace

std::string ModeTable() {
  std::string text = "| request |";
  std::string rule = "|---|";
  for (std::size_t mode = 0; mode < kRobotModes; ++mode) {
    text += fmt::format(" {} |", Name(static_cast<RobotMode>(mode)));
    rule += "---|";
  }
  text += '\n' + rule + '\n';
  for (std::size_t request = 0; request < kRequests; ++request) {
    text += fmt::format("| {} |", kRequestNames[request]);
    for (const auto& row : kModeTable) text += fmt::format(" {} |", Name(row[request]));
    text += '\n';
  }
  return text;
}

std::string_view Name(Request request) noexcept {
  return kRequestNames[static_cast<std::size_t>(request)];
}

std::string_view Name(Verdict verdict) noexcept {
  switch (verdict) {
    case Verdict::kGranted: return "granted";
    case Verdict::kGrantedAtRest: return "granted at rest";
    case Verdict::kNothingToDo: return "nothing to do";
    case Verdict::kNothingUnlessError: return "nothing to do; refused with an error";
    case Verdict::kRefused: return "refused";
  }
  return "unknown";
}

}  // namespace twin::onboard

#include "twin/onboard/mode_table.h"

#include <fmt/format.h>

namespace twin::onboard {
namespace {

constexpr std::array<std::string_view, kRequests> kRequestNames{
    "Move",
    "Stop Move",
    "Get Cartesian Limit",
    "Set Collision Behavior",
    "Set Joint Impedance",
    "Set Cartesian Impedance",
    "Set Guiding Mode",
    "Set EE to K",
    "Set NE to EE",
    "Set Load",
    "Set Filters",
    "Automatic Error Recovery",
    "Load Model Library",
    "press_user_stop",
    "release_user_stop",
    "close_brakes",
    "open_brakes",
    "press_guiding_button",
    "release_guiding_button",
};

struct Requester {
  Request operator()(const setting::JointImpedance&) { return Request::kSetJointImpedance; }
  Request operator()(const setting::CartesianImpedance&) { return Request::kSetCartesianImpedance; }
  Request operator()(const setting::CollisionBehavior&) { return Request::kSetCollisionBehavior; }
  Request operator()(const setting::GuidingMode&) { return Request::kSetGuidingMode; }
  Request operator()(const setting::StiffnessFrame&) { return Request::kSetEEToK; }
  Request operator()(const setting::EndEffectorFrame&) { return Request::kSetNEToEE; }
  Request operator()(const setting::Load&) { return Request::kSetLoad; }
  Request operator()(const setting::Filters&) { return Request::kSetFilters; }
};

}  // namespace

Request RequestOf(const Setting& setting) noexcept {
  return std::visit(Requester(), setting);
}

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

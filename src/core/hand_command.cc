#include "twin/core/hand_command.h"

#include <cmath>

namespace twin {
namespace {

using Finding = std::optional<BadValue>;

constexpr double kMostForce = 140;

/// @param good  also false for NaN.
Finding Require(bool good, std::string_view field, double value,
                std::string_view allowed) noexcept {
  if (good) return {};
  return BadValue{field, {}, value, allowed};
}

Finding FindMotion(double width, double speed, double max_width) noexcept {
  const double most = (max_width > 0 ? max_width : kHandStroke) + kHandWidthTolerance;
  if (const Finding found = Require(width >= 0 && width <= most, "width", width,
                                    "in [0, the hand's largest opening] m")) {
    return found;
  }
  return Require(speed > 0 && std::isfinite(speed), "speed", speed, "finite and above 0 m/s");
}

Finding Find(const hand::Homing& /*homing*/, double /*max_width*/) noexcept {
  return {};
}
Finding Find(const hand::Stop& /*stop*/, double /*max_width*/) noexcept {
  return {};
}
Finding Find(const hand::Move& move, double max_width) noexcept {
  return FindMotion(move.width, move.speed, max_width);
}

Finding FindTimeout(std::int64_t timeout_ms) noexcept {
  return Require(timeout_ms >= 0, "timeout_ms", static_cast<double>(timeout_ms),
                 "not negative (ms)");
}

Finding Find(const hand::Vacuum& vacuum, double /*max_width*/) noexcept {
  constexpr int kProfiles = 4;
  if (const Finding found =
          Require(vacuum.vacuum > 0, "vacuum", vacuum.vacuum, "in [1, 255] times 10 mbar")) {
    return found;
  }
  if (const Finding found =
          Require(vacuum.profile < kProfiles, "profile", vacuum.profile, "one of 0, 1, 2, 3")) {
    return found;
  }
  return FindTimeout(vacuum.timeout_ms);
}

Finding Find(const hand::DropOff& drop, double /*max_width*/) noexcept {
  return FindTimeout(drop.timeout_ms);
}

Finding Find(const hand::Grasp& grasp, double max_width) noexcept {
  if (const Finding found = FindMotion(grasp.width, grasp.speed, max_width)) return found;
  if (const Finding found = Require(grasp.force > 0 && grasp.force <= kMostForce, "force",
                                    grasp.force, "above 0 and at most 140 N")) {
    return found;
  }
  constexpr std::string_view kEpsilon = "finite and not negative (m)";
  const auto good = [](double epsilon) { return epsilon >= 0 && std::isfinite(epsilon); };
  if (const Finding found =
          Require(good(grasp.epsilon_inner), "epsilon_inner", grasp.epsilon_inner, kEpsilon)) {
    return found;
  }
  return Require(good(grasp.epsilon_outer), "epsilon_outer", grasp.epsilon_outer, kEpsilon);
}

struct CommandNamer {
  std::string_view operator()(const hand::Homing&) { return "Homing"; }
  std::string_view operator()(const hand::Move&) { return "Move"; }
  std::string_view operator()(const hand::Grasp&) { return "Grasp"; }
  std::string_view operator()(const hand::Stop&) { return "Stop"; }
  std::string_view operator()(const hand::Vacuum&) { return "Vacuum"; }
  std::string_view operator()(const hand::DropOff&) { return "Drop Off"; }
};

/// A command that the device does not have; Stop is both devices'.
Finding FindForeign(const HandCommand& command, HandDevice device) noexcept {
  if (std::holds_alternative<hand::Stop>(command)) return {};
  const bool sucks = std::holds_alternative<hand::Vacuum>(command) ||
                     std::holds_alternative<hand::DropOff>(command);
  if (sucks == (device == HandDevice::kCobotPump)) return {};
  return BadValue{"the command",
                  {},
                  {},
                  sucks ? "homing, move, grasp or stop: the Franka Hand does not suck"
                        : "vacuum, drop off or stop: the cobot pump has no fingers"};
}

}  // namespace

std::optional<BadValue> FindBadValue(const HandCommand& command, double max_width,
                                     HandDevice device) noexcept {
  if (const Finding found = FindForeign(command, device)) return found;
  return std::visit([max_width](const auto& one) { return Find(one, max_width); }, command);
}

std::string_view Name(const HandCommand& command) noexcept {
  return std::visit(CommandNamer(), command);
}

std::string_view Name(HandResult result) noexcept {
  switch (result) {
    case HandResult::kSuccess: return "success";
    case HandResult::kFail: return "fail";
    case HandResult::kUnsuccessful: return "unsuccessful";
    case HandResult::kAborted: return "aborted";
  }
  return "unknown";
}

std::string_view Name(PumpStatus status) noexcept {
  switch (status) {
    case PumpStatus::kGreen: return "green";
    case PumpStatus::kYellow: return "yellow";
    case PumpStatus::kOrange: return "orange";
    case PumpStatus::kRed: return "red";
  }
  return "unknown";
}

}  // namespace twin

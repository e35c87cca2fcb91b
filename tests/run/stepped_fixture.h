#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "twin/run/stepped_robot.h"

namespace twin::test {

/// A link that loses and delays.
inline constexpr std::string_view kLossy =
    "link: {state_delay: {log_normal: {median: 60 us, sigma: 0.4}}, command_loss: 5 %}\n";

/// A robot without a motion that poses lead.
[[nodiscard]] inline scenario::Scenario Stepped(std::string_view more = "") {
  scenario::Scenario scenario = scenario::ParseServed(
      "name: stepped\n"
      "robot: {q_start: {unit: rad, values: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}}\n" +
          std::string(more),
      "stepped.yaml");
  scenario.motion.interface = control::CommandInterface::kCartesianPose;
  return scenario;
}

[[nodiscard]] inline run::RunFiles Files() {
  return {std::filesystem::path(TWIN_SOURCE_DIR) / "models", {}, {}, false};
}

/// The pose of the end effector that a report tells, as a matrix.
[[nodiscard]] inline Transform PoseOf(const run::StepReport& report) {
  const auto& [w, x, y, z] = report.turn_d;
  return {1 - 2 * (y * y + z * z), 2 * (x * y + w * z),     2 * (x * z - w * y),     0,
          2 * (x * y - w * z),     1 - 2 * (x * x + z * z), 2 * (y * z + w * x),     0,
          2 * (x * z + w * y),     2 * (y * z - w * x),     1 - 2 * (x * x + y * y), 0,
          report.position_d[0],    report.position_d[1],    report.position_d[2],    1};
}

}  // namespace twin::test

#include "twin/scenario/scenario.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::scenario {
namespace {

bool IsNameLetter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
         c == '-';
}

void RequireName(const char* field, const std::string& name) {
  constexpr std::size_t kLongest = 64;
  if (!name.empty() && name.size() <= kLongest && std::ranges::all_of(name, IsNameLetter)) return;
  throw InputError(fmt::format("{}: \"{}\" is no name; use 1 to {} letters, digits, '_' and '-'",
                               field, name, kLongest));
}

void RequireRange(const char* field, double value, double least, double most) {
  if (value >= least && value <= most) return;  // false for NaN
  throw InputError(
      fmt::format("{}: {} is out of range; it must lie in [{}, {}]", field, value, least, most));
}

void ValidateDelay(const char* field, const Delay& delay) {
  try {
    (void)delay.Model();
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", field, error.what()));
  }
}

void ValidateMotion(const MotionSection& motion) {
  if (motion.waypoints.size() < 2) {
    throw InputError(fmt::format("motion.trajectory: {} waypoints; a trajectory needs at least two",
                                 motion.waypoints.size()));
  }
  RequireRange("motion.trajectory.velocity_scale", motion.timing.velocity_scale, 1e-6, 1);
  RequireRange("motion.trajectory.acceleration_scale", motion.timing.acceleration_scale, 1e-6, 1);
  RequireRange("motion.trajectory.jerk_scale", motion.timing.jerk_scale, 1e-6, 1);
}

void ValidateRender(const RenderSection& render) {
  RequireRange("render.width", render.width, 16, 4096);
  RequireRange("render.height", render.height, 16, 4096);
  RequireRange("render.fps", render.fps, 1, 240);
  if (render.width % 2 != 0 || render.height % 2 != 0) {
    throw InputError(fmt::format("render: {} x {} pixels; both must be even for H.264",
                                 render.width, render.height));
  }
  RequireRange("render.camera.distance", render.distance, 0.01, 1000);
}

bool SamePoint(const reference::Waypoint& a, const reference::Waypoint& b) {
  return a.q == b.q && a.at == b.at && a.stop == b.stop;
}

}  // namespace

Drive DriveFromName(std::string_view name) {
  if (name == "lockstep") return Drive::kLockstep;
  if (name == "realtime" || name == "remote") {
    throw InputError(fmt::format(
        "drive \"{}\" is not part of this version; use lockstep, the virtual clock", name));
  }
  throw InputError(fmt::format("drive \"{}\" is unknown; accepted: lockstep", name));
}

rt::DelayModel Delay::Model() const {
  if (kind == Kind::kConstant) return rt::DelayModel(rt::ConstantDelay{constant});
  return rt::DelayModel(rt::LogNormalDelay{median, sigma, offset});
}

bool MotionSection::operator==(const MotionSection& other) const {
  return interface == other.interface &&
         std::ranges::equal(waypoints, other.waypoints, &SamePoint) &&
         timing.duration == other.timing.duration &&
         timing.velocity_scale == other.timing.velocity_scale &&
         timing.acceleration_scale == other.timing.acceleration_scale &&
         timing.jerk_scale == other.timing.jerk_scale;
}

void Scenario::Validate() const {
  RequireName("name", name);
  RequireName("backend", backend);
  RequireName("robot.model", robot.model);
  RequireName("controller.type", controller.type);
  ValidateDelay("link.state_delay", link.state_delay);
  ValidateDelay("link.command_delay", link.command_delay);
  ValidateDelay("tick.cost", tick.cost);
  ValidateDelay("controller.wake_delay", controller.wake_delay);
  ValidateDelay("controller.cost", controller.cost);
  RequireRange("plant.noise.q", plant.noise_q, 0, 1);
  RequireRange("plant.noise.dq", plant.noise_dq, 0, 10);
  RequireRange("plant.noise.tau_J", plant.noise_tau_J, 0, 100);
  RequireRange("link.state_loss", link.state_loss_percent, 0, 100);
  RequireRange("link.command_loss", link.command_loss_percent, 0, 100);
  RequireRange("tick.lambda", tick.lambda, 1e-9, 1);
  RequireRange("controller.rate", controller.rate_hz, 1, 1000);
  RequireRange("controller.clock_drift", controller.clock_drift_ppm, -1000, 1000);
  ValidateMotion(motion);
  ValidateRender(render);
}

}  // namespace twin::scenario

#include "twin/loop/loop_config.h"

#include <string_view>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::loop {
namespace {

using control::CommandInterface;

void RequireGenerator(Generator generator, CommandInterface interface) {
  const std::string_view misfit = Misfit(generator, interface);
  if (misfit.empty()) return;
  throw InputError(
      fmt::format("tick.generator: {} and does not go with this motion.interface; say none, or "
                  "leave it out",
                  misfit));
}

void RequireWholeSteps(const TickConfig& config) {
  if (config.generator != Generator::kRejoining || config.low_pass_hz >= TickConfig().low_pass_hz)
    return;
  throw InputError(
      "tick.low_pass: it weakens the steps by which tick.generator: rejoining accelerates, and the "
      "arm would creep; say off, or another generator");
}

void RequireMotion(CommandInterface interface) {
  if (interface != CommandInterface::kTorque) return;
  throw InputError(
      "tick.viability: it keeps the limits of commanded motions, and motion.interface is torque; "
      "say off, or leave it out");
}

}  // namespace

std::string_view Misfit(Generator generator, CommandInterface interface) {
  switch (generator) {
    case Generator::kNone: return {};
    case Generator::kJoint:
      return interface == CommandInterface::kJointPosition ? "" : "joint makes joint positions";
    case Generator::kRejoining:
      return interface == CommandInterface::kTorque ? "rejoining makes motions" : "";
    case Generator::kCartesian:
      return interface == CommandInterface::kCartesianPose ? "" : "cartesian makes poses";
  }
  return {};
}

void TickConfig::Validate(CommandInterface interface) const {
  RequireInRange("tick: lambda", lambda, 1e-9, 1);
  RequireInRange("tick: source_rate_hz", source_rate_hz, 1, 1000);
  RequireInRange("tick: finish_tolerance_rad", finish_tolerance_rad, 1e-9, 1e-2);
  RequireInRange("tick: period_tolerance (us)", ToSeconds(period_tolerance) * 1e6, 0, 1000);
  RequireInRange("tick: low_pass_hz", low_pass_hz, 1, 1000);
  RequireGenerator(generator, interface);
  RequireWholeSteps(*this);
  if (viability) RequireMotion(interface);
  RequireInRange("tick: stall_time (ms)", ToSeconds(stall_time) * 1e3, 1, 10000);
  if (!viability && !lab && generator != Generator::kRejoining) return;
  limits.Validate();
  if (interface == CommandInterface::kCartesianPose) cartesian.Validate();
}

void ControllerLoopConfig::Validate() const {
  RequireInRange("controller: rate_hz", rate_hz, 1, 1000);
  RequireInRange("controller: clock_ppm", clock_ppm, -1000, 1000);
  RequireInRange("controller: phase (ms)", ToSeconds(phase) * 1e3, 0, 10000);
  RequireInRange("controller: target_noise", target_noise, 0, 1);
}

}  // namespace twin::loop

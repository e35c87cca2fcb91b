#pragma once

#include <cstdint>
#include <memory>

#include "twin/control/controller.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/loop/loop_config.h"
#include "twin/reference/target.h"

namespace twin::loop {

/// Result of the viability filter: as TickRecord::margin and TickRecord::kept_back.
struct Viable {
  double margin = 0;
  std::uint8_t changed_joints = 0;
};

/// From at most this velocity and acceleration a reference can stand still at once: its jerk is
/// then 2000 rad/s^3 (m/s^3) at most. A decision.
constexpr double kRestVelocity = 1e-3;   // rad/s, m/s
constexpr double kRestAcceleration = 1;  // rad/s^2, m/s^2

/// The stages of a CommandChain for one command interface. They use this interface's fields of
/// targets and commands only.
///
/// Threads: one. Real-time: all but construction; noexcept, no allocation.
class InterfaceStages {
 public:
  virtual ~InterfaceStages() = default;

  /// A motion starts at the reference in `state`: it fills the rate matcher's window.
  virtual void Reset(const RobotState& state) noexcept TWIN_REALTIME = 0;
  /// One cycle of rate matching.
  virtual void Match(const reference::Target& target,
                     reference::Target& matched) noexcept TWIN_REALTIME = 0;
  /// The paper's reference generator if configured, else the target itself.
  virtual void Generate(const RobotState& state, const reference::Target& matched,
                        RobotCommand& command) const noexcept TWIN_REALTIME = 0;
  /// libfranka's low-pass and rate limiter, each if configured.
  virtual void Smooth(const RobotState& state,
                      RobotCommand& command) const noexcept TWIN_REALTIME = 0;
  /// @pre TickConfig::viability.
  virtual Viable KeepViable(const RobotState& state,
                            RobotCommand& command) const noexcept TWIN_REALTIME = 0;
  /// Keeps a command after which the reference can stand still at once; else has it stand still.
  virtual void Settle(const RobotState& state,
                      RobotCommand& command) const noexcept TWIN_REALTIME = 0;
  /// True when the target is at rest and the robot's reference within the finish tolerance of it.
  [[nodiscard]] virtual bool Arrived(
      const RobotState& state, const reference::Target& matched) const noexcept TWIN_REALTIME = 0;
};

/// Source rate for the rate matcher, Hz; without rate matching, the rate of the cycles.
[[nodiscard]] double MatchedRate(const TickConfig& config) noexcept;

/// @param config  validated for `interface`.
[[nodiscard]] std::unique_ptr<InterfaceStages> MakeStages(const TickConfig& config,
                                                          control::CommandInterface interface);

}  // namespace twin::loop

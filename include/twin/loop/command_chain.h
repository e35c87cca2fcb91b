#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "twin/control/controller.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/loop/loop_config.h"
#include "twin/loop/rejoining_follower.h"
#include "twin/reference/stall_decay.h"
#include "twin/reference/target.h"

namespace twin::loop {

class InterfaceStages;

/// From the deposited target to the command that answers a state:
///   rate matcher -> [stall decay] -> the paper's reference generator, or none
///   or: resampler -> saturated correction (Generator::kRejoining)
///   -> [low-pass] -> [rate limiter] -> [viability filter].
/// Stages in brackets are off unless configured, or act on stalled sources only; low-pass and
/// limiter are libfranka's client-side stages, in its order. The constructor chooses the stages of
/// the interface. All but matcher, resampler and decay are functions of the state: they continue
/// from the reference that the robot accepted. A raw position stream (no generator) stops abruptly
/// when its source stalls, and the robot aborts.
///
/// Threads: one. Real-time: Reset() and Next() are noexcept and allocate nothing.
class CommandChain {
 public:
  /// @throws InputError as TickConfig::Validate.
  CommandChain(const TickConfig& config, control::CommandInterface interface);
  CommandChain(CommandChain&&) noexcept;
  ~CommandChain();

  /// A motion begins: the chain starts from where `state` says the reference is.
  void Reset(const RobotState& state) noexcept TWIN_REALTIME;

  /// Fills the fields of `command` that its interface uses.
  /// @param fresh   the target was deposited since the last call.
  /// @param cycles  of the robot since the last call, at least 1: the matcher's window is of
  /// cycles, those that could not be answered included.
  /// @param source_time  of the target, on the source's own clock.
  void Next(const RobotState& state, const reference::Target& target, bool fresh,
            std::uint64_t cycles, Time source_time, RobotCommand& command) noexcept TWIN_REALTIME;

  /// Target of the last Next(): after rate matching, or as the resampler has the source now.
  [[nodiscard]] const reference::Target& matched() const noexcept { return matched_; }

  /// Whether the source counts as stalled: TickConfig::stall_time went without a deposit.
  [[nodiscard]] bool stalled() const noexcept { return waited_ > stall_cycles_; }

  /// Of the last Next(), behind a viability filter: as TickRecord::margin and
  /// TickRecord::kept_back.
  [[nodiscard]] std::optional<double> margin() const noexcept { return margin_; }
  [[nodiscard]] std::uint8_t changed_joints() const noexcept { return changed_joints_; }

  /// Commands since Reset() that the viability filter changed.
  [[nodiscard]] std::uint64_t kept_back() const noexcept { return kept_back_; }

  /// The matched target is at rest, and the robot's reference is within the finish tolerance of it;
  /// behind a viability filter or saturated correction also nearly at rest.
  [[nodiscard]] bool Arrived(const RobotState& state) const noexcept TWIN_REALTIME;

 private:
  void MatchAndDecay(const reference::Target& target, std::uint64_t cycles) noexcept;

  TickConfig config_;
  std::unique_ptr<InterfaceStages> stages_;
  std::size_t window_;  ///< of the rate matcher, cycles
  std::uint64_t stall_cycles_;
  std::uint64_t waited_ = 0;  ///< cycles since the last deposit
  reference::StallDecay stall_decay_;
  std::optional<RejoiningFollower> rejoining_;
  std::optional<double> margin_;
  std::uint8_t changed_joints_ = 0;
  std::uint64_t kept_back_ = 0;
  reference::Target matched_;
};

/// Whether the fields of `interface` can be sent: all finite; a pose's last row exact, its rotation
/// orthonormal within 1e-5. Source: FCI protocol 5, validity checks before sending.
[[nodiscard]] bool IsValid(const RobotCommand& command,
                           control::CommandInterface interface) noexcept TWIN_REALTIME;

}  // namespace twin::loop

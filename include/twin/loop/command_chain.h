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
#include "twin/onboard/stop_proof.h"
#include "twin/reference/stall_decay.h"
#include "twin/reference/target.h"

namespace twin::loop {

class InterfaceStages;
class LimitGuard;

/// From the deposited target to the command that answers a state:
///   rate matcher -> [stall decay] -> the paper's reference generator, or none
///   or: resampler -> saturated correction (Generator::kRejoining)
///   -> [low-pass] -> [rate limiter] -> [viability filter] -> [limit guard].
/// Stages in brackets are off unless configured; the decay acts on stalled sources only. Low-pass
/// and limiter are libfranka's client-side stages, in its order. The constructor chooses the stages
/// of the interface. All but matcher, resampler and decay are functions of the state: they continue
/// from the reference that the robot accepted. A raw position stream (no generator) stops abruptly
/// when its source stalls, and the robot aborts.
///
/// Threads: one. Real-time: Reset() and Next() are noexcept and allocate nothing.
class CommandChain {
 public:
  /// @throws InputError as TickConfig::Validate().
  CommandChain(const TickConfig& config, control::CommandInterface interface);
  CommandChain(CommandChain&&) noexcept;
  ~CommandChain();

  /// Starts a motion from the reference in `state`.
  void Reset(const RobotState& state) noexcept TWIN_REALTIME;

  /// Fills the fields of `command` that its interface uses.
  /// @param fresh   true if the target was deposited since the last call.
  /// @param cycles  robot cycles since the last call, >= 1. The matcher's window counts cycles,
  /// including those without an answer.
  /// @param source_time  time of the target on the source's clock.
  void Next(const RobotState& state, const reference::Target& target, bool fresh,
            std::uint64_t cycles, Time source_time, RobotCommand& command) noexcept TWIN_REALTIME;

  /// Target of the last Next(): rate-matched, or resampled at the present time.
  [[nodiscard]] const reference::Target& matched() const noexcept { return matched_; }

  /// True when TickConfig::stall_time has passed without a deposit.
  [[nodiscard]] bool stalled() const noexcept { return waited_ > stall_cycles_; }

  /// The viability filter's results of the last Next(), as TickRecord::margin and
  /// TickRecord::kept_back; margin() is nullopt without a filter.
  [[nodiscard]] std::optional<double> margin() const noexcept { return margin_; }
  [[nodiscard]] std::uint8_t changed_joints() const noexcept { return changed_joints_; }

  /// Commands since Reset() that the viability filter changed.
  [[nodiscard]] std::uint64_t kept_back() const noexcept { return kept_back_; }

  /// The limit of a lab for which the chain stops the arm (TickConfig::lab); nullopt: none.
  [[nodiscard]] std::optional<onboard::BrokenLimit> breach() const noexcept;
  /// False when the robot itself must stop the arm, and no command goes out.
  [[nodiscard]] bool sends() const noexcept;
  /// True when the motion is to end after a breach: the commanded stop rests, or !sends().
  [[nodiscard]] bool stopped() const noexcept;

  /// True when `command` of the last Next() may end the motion: the matched target is at rest and
  /// the robot's reference within the finish tolerance of this target. With a viability filter or
  /// saturated correction, the reference must also be nearly at rest, before the command and after
  /// it: a step of a noisy source from which the robot could not stand still at once is left out.
  /// @param is_noisy  as RejoiningFollower::Arrived.
  [[nodiscard]] bool Finish(const RobotState& state, bool is_noisy,
                            RobotCommand& command) const noexcept TWIN_REALTIME;

 private:
  void MatchAndDecay(const reference::Target& target, std::uint64_t cycles) noexcept;
  void KeepViable(const RobotState& state, RobotCommand& command) noexcept;

  TickConfig config_;
  std::unique_ptr<InterfaceStages> stages_;
  std::size_t window_;  ///< rate matcher's window, cycles
  std::uint64_t stall_cycles_;
  std::uint64_t waited_ = 0;  ///< cycles since the last deposit
  reference::StallDecay stall_decay_;
  std::optional<RejoiningFollower> rejoining_;
  std::unique_ptr<LimitGuard> guard_;
  std::optional<double> margin_;
  std::uint8_t changed_joints_ = 0;
  std::uint64_t kept_back_ = 0;
  reference::Target matched_;
};

/// True when the fields of `interface` are valid to send: all finite; a pose's last row exact, its
/// rotation orthonormal within 1e-5. Source: FCI protocol 5, validity checks before sending.
[[nodiscard]] bool IsValid(const RobotCommand& command,
                           control::CommandInterface interface) noexcept TWIN_REALTIME;

}  // namespace twin::loop

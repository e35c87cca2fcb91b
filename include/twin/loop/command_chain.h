#pragma once

#include <cstdint>
#include <optional>

#include "twin/control/controller.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_command.h"
#include "twin/core/robot_state.h"
#include "twin/loop/loop_config.h"
#include "twin/loop/stall_bridge.h"
#include "twin/reference/cartesian_reference_generator.h"
#include "twin/reference/joint_reference_generator.h"
#include "twin/reference/low_pass.h"
#include "twin/reference/pose_viability_filter.h"
#include "twin/reference/rate_matcher.h"
#include "twin/reference/rejoining_generator.h"
#include "twin/reference/resampler.h"
#include "twin/reference/target.h"
#include "twin/reference/viability_filter.h"

namespace twin::loop {

/// From the deposited target to the command that answers a state:
///   rate matcher -> reference generator -> [low-pass] -> stall bridge -> [rate limiter]
///   -> [viability filter].
/// Those in brackets are off unless configured; the first two are libfranka's client-side stages,
/// in its order. The bridge comes after the low-pass, which would scale the motion that the bridge
/// goes on with. Everything but the matcher's window and the bridge is a function of the state: it
/// continues from what the robot really took. A raw position stream (no generator) is not bridged:
/// a source that stalls stops dead, and the robot aborts.
///
/// Threads: one. Real-time: Reset() and Next() are noexcept and allocate nothing.
class CommandChain {
 public:
  /// @throws InputError as TickConfig::Validate.
  CommandChain(const TickConfig& config, control::CommandInterface interface);

  /// A motion begins: the chain starts from where `state` says the reference is.
  void Reset(const RobotState& state) noexcept TWIN_REALTIME;

  /// Fills the fields of `command` that its interface uses.
  /// @param fresh   the target was deposited since the last call.
  /// @param cycles  of the robot since the last call, at least 1: the matcher's window is of
  /// cycles, those that could not be answered included.
  /// @param source_time  of the target, on the source's own clock.
  void Next(const RobotState& state, const reference::Target& target, bool fresh,
            std::uint64_t cycles, Time source_time, RobotCommand& command) noexcept TWIN_REALTIME;

  /// Target after rate matching, of the last Next().
  [[nodiscard]] const reference::Target& matched() const noexcept { return matched_; }

  /// Of the last Next(), behind a viability filter: as TickRecord::margin and
  /// TickRecord::kept_back.
  [[nodiscard]] std::optional<double> margin() const noexcept { return margin_; }
  [[nodiscard]] std::uint8_t changed_joints() const noexcept { return changed_joints_; }

  /// Commands since Reset() that the viability filter changed.
  [[nodiscard]] std::uint64_t kept_back() const noexcept { return kept_back_; }

  /// The matched target is at rest, nothing is left of a stall, and the robot's reference is within
  /// the finish tolerance of it; behind a viability filter also nearly at rest.
  [[nodiscard]] bool Arrived(const RobotState& state) const noexcept TWIN_REALTIME;

 private:
  void MatchAndBridge(const RobotState& state, const reference::Target& target, bool fresh,
                      std::uint64_t cycles, Time source_time) noexcept;
  void Match(const reference::Target& target) noexcept;
  void Resample(const JointVector& q, bool fresh, std::uint64_t cycles, Time source_time) noexcept;
  [[nodiscard]] JointVector JointPosition(const RobotState& state) const noexcept;
  void Generate(const RobotState& state, RobotCommand& command) const noexcept;
  /// @returns cycles before `state` in a row in which the robot took no command of ours.
  std::uint64_t CountUnserved(const RobotState& state, std::uint64_t cycles) noexcept;
  void Filter(const RobotState& state, RobotCommand& command) const noexcept;
  void Limit(const RobotState& state, RobotCommand& command) const noexcept;
  void KeepViable(const RobotState& state, RobotCommand& command) noexcept;

  TickConfig config_;
  control::CommandInterface interface_;
  reference::RateMatcher joint_matcher_;
  reference::TorqueRateMatcher torque_matcher_;
  reference::PoseRateMatcher pose_matcher_;
  reference::JointReferenceGenerator joint_generator_;
  reference::CartesianReferenceGenerator cartesian_generator_;
  reference::LowPass low_pass_;
  StallBridge bridge_;
  reference::Resampler resampler_;
  reference::RejoiningGenerator rejoining_generator_;
  std::optional<reference::ViabilityFilter> viability_;
  std::optional<reference::PoseViabilityFilter> pose_viability_;  ///< the same, of poses
  std::optional<double> margin_;
  std::uint8_t changed_joints_ = 0;
  std::uint64_t kept_back_ = 0;
  std::optional<JointVector> sent_;  ///< by which the next state shows that the command was taken
  std::uint64_t unserved_ = 0;
  reference::Target matched_;
};

/// Whether the fields of `interface` can be sent: all finite; a pose's last row exact, its rotation
/// orthonormal within 1e-5. Source: FCI protocol 5, validity checks before sending.
[[nodiscard]] bool IsValid(const RobotCommand& command,
                           control::CommandInterface interface) noexcept TWIN_REALTIME;

}  // namespace twin::loop

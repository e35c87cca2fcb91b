#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "twin/core/hand_command.h"
#include "twin/core/joint_vector.h"
#include "twin/core/time.h"
#include "twin/plant/mujoco_plant.h"
#include "twin/reference/target.h"
#include "twin/run/catalogue.h"
#include "twin/scenario/scenario.h"

namespace twin::run {

/// What differs from one episode of a stepped robot to the next.
struct EpisodeStart {
  std::uint64_t seed = 0;                     ///< of link, sensors and workstation
  std::optional<JointVector> q{};             ///< where the arm rests, rad; absent: as it was kept
  std::map<std::string, Transform> places{};  ///< X_WB of free bodies, at rest
  std::map<std::string, double> masses{};     ///< kg, of bodies; they stay until given anew
  std::map<std::string, double> frictions{};  ///< of bodies, sliding; they stay, too
  std::optional<Duration> delay{};            ///< of every message, in place of the scenario's
  std::optional<double> loss{};  ///< of every message, in [0, 1], in place of the scenario's
};

/// What a step came to; doubles alone, so that a row of an array holds one. World and base axes
/// are the same; without a mobile base.
struct StepReport {
  // The robot's state that the workstation has received last. Units and frames: core/robot_state.h.
  JointVector q{};
  JointVector dq{};
  JointVector q_d{};
  JointVector dq_d{};
  JointVector tau_J{};
  JointVector tau_ext{};         ///< tau_ext_hat_filtered
  Vector3 position{};            ///< of EE in O, m
  std::array<double, 4> turn{};  ///< of EE in O: unit quaternion w x y z, w >= 0
  Vector6 twist{};               ///< of EE from the measured q and dq, [v; w], axes of O
  Vector3 position_d{};          ///< the same of O_T_EE_d
  std::array<double, 4> turn_d{};
  Vector6 wrench{};         ///< O_F_ext_hat_K: the robot's own estimate
  double width = 0;         ///< between the fingers, m
  double is_grasped = 0;    ///< 0 or 1
  double success_rate = 0;  ///< control_command_success_rate
  // Ground truth.
  Vector6 contact{};  ///< plant::ContactWrench about EE; 0 on the ideal plant
  // Of the last Advance().
  double cycles = 0;
  double served = 0;     ///< cycles that a command came for in time
  double held = 0;       ///< cycles without one, in the motion
  double margin = 0;     ///< smallest margin of the viability filter, in [0, 1]; NaN without one
  double kept_back = 0;  ///< commands that the filter changed
  // Of the episode.
  double time = 0;       ///< since its first command, s
  double errors = 0;     ///< bit i: RobotError i has ended the motion
  double is_moving = 0;  ///< 1; 0 once the motion has ended

  static constexpr std::size_t kSize = 7 * 6 + 3 + 4 + 6 + 3 + 4 + 6 + 3 + 6 + 8;
  /// A member, for those who take a report as doubles.
  struct Field {
    std::string_view name;
    std::size_t begin;
    std::size_t size;
  };
  [[nodiscard]] static std::vector<Field> Fields();
};
static_assert(sizeof(StepReport) == StepReport::kSize * sizeof(double));

/// An emulated robot in lockstep, led step by step instead of along a reference: for learning.
///
/// Between Reset() and the next, one motion runs. Targets are deposited where a controller's would
/// be, at the scenario's controller.rate, and go through the workstation's asynchronous chain
/// (loop::CommandChain: rejoining generator, viability filter) and the link with the scenario's
/// delays and losses to INT at 1 kHz:
///
///   Advance(n): n cycles of state -> link -> tick -> link -> INT -> plant; every N = 1000 /
///               rate of them begin with a deposit, wake delay + cost late. Deposit i of m = n / N
///               is x(i) = x_last + i / m (x - x_last) of positions and poses, and x itself of
///               velocities and torques, with the target x and x_last that of the step before.
///
/// So a target is reached at the end of its step, but for the chain's lag of 2.25 N cycles and its
/// limits. Poses are led within a part of the robot's Cartesian limits (kPoseShare), since INT also
/// limits the joints, which the filter of poses does not see.
///
/// Used of the scenario: scene, objects, robot, plant, link, onboard, tick, motion.interface,
/// motion.controller; of the controller: rate, wake_delay, cost, feed_forward, target_noise.
///
/// Same scenario, files, starts and targets give the same bits, in any thread and after any number
/// of earlier episodes. A reset copies the state that was kept; nothing is built anew.
///
/// Threads: one at a time; different robots share nothing. Not for real time.
class SteppedRobot {
 public:
  /// Builds the robot, lets it and the objects rest for 0.1 s, and keeps that as the start.
  /// @param scenario  of a robot, without a motion (scenario::ParseServed()).
  /// @throws InputError and EnvironmentError as Run.
  SteppedRobot(const scenario::Scenario& scenario, const RunFiles& files);
  ~SteppedRobot();

  /// Goes back to the kept start and begins a motion that holds still, which takes a few cycles.
  /// @throws InputError for an unknown body, a place inside of another body, or a value out of
  /// range; RobotFault when no motion begins, as when the link loses all.
  void Reset(const EpisodeStart& start);

  /// Sets where the next Advance() leads: the member of the scenario's interface counts.
  /// @throws InputError unless it is finite, and a pose rigid.
  void SetTarget(const reference::Target& target);

  /// Starts a command of the hand. @returns false if the hand refuses it. @throws InputError
  /// without a hand.
  bool StartHand(const HandCommand& command);

  /// Lets cycles pass; also after the motion has ended. @pre Reset() was called.
  void Advance(std::uint64_t cycles);

  /// Ends the motion, waits until the arm rests, and keeps this state as the start of Reset().
  /// @throws RobotFault when an error has ended the motion, or the arm does not come to rest.
  void KeepAsStart();

  [[nodiscard]] const StepReport& report() const noexcept;

  /// Names of the free bodies. Constant.
  [[nodiscard]] const std::vector<std::string>& objects() const noexcept;
  /// Numbers per object: position (3), quaternion w x y z (4), twist [v; w] (6), in the world.
  static constexpr std::size_t kObjectSize = 13;
  /// Ground truth of the objects, after each other. @pre out.size() == objects().size() *
  /// kObjectSize.
  void CopyObjects(std::span<double> out) const noexcept;

  /// Details of the errors that ended the motion, a sentence each; empty: none.
  [[nodiscard]] std::string DescribeErrors() const;

  /// For pictures; null on the ideal plant.
  [[nodiscard]] const plant::TruthProbe* truth() const noexcept;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::run

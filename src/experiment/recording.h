#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"
#include "twin/record/cycle_record.h"
#include "twin/reference/trajectory.h"

namespace twin::experiment {

/// The part of an INT cycle that curves show; names as in RobotState and CycleRecord.
struct CycleSample {
  std::uint64_t message_id = 0;
  JointVector q{};
  JointVector dq{};
  JointVector q_d{};
  JointVector dq_d{};
  JointVector dddq_d{};
  JointVector tau_J_d{};
  record::CommandFate fate = record::CommandFate::kNone;
};

/// The part of a tick that wrote a command; names as in TickRecord and RobotCommand.
struct TickSample {
  std::uint64_t message_id = 0;  ///< of the state it answers
  JointVector q_ext{};
  JointVector dq_ext{};
  JointVector q_c{};
  JointVector dq_c{};
  std::optional<double> margin{};
  std::uint8_t kept_back = 0;
};

/// Keeps a run's curves in memory: every cycle in motion, and every tick that wrote.
///
/// Threads: cycles from one, ticks from one; the rest after the run.
class Recording final : public record::RecordSink {
 public:
  /// @param cycles  initial capacity: on the wall clock a run must not allocate. The default holds
  /// more than any motion of the experiments.
  explicit Recording(std::size_t cycles = 32768) {
    cycles_.reserve(cycles);
    ticks_.reserve(cycles);
  }

  void Put(const record::CycleRecord& record) noexcept override;
  void Put(const record::TickRecord& record) noexcept override;

  [[nodiscard]] const std::vector<CycleSample>& cycles() const noexcept { return cycles_; }
  [[nodiscard]] const std::vector<TickSample>& ticks() const noexcept { return ticks_; }

 private:
  std::vector<CycleSample> cycles_;
  std::vector<TickSample> ticks_;
};

/// One joint of the cycles in [begin, end), as a signal of 1 kHz. @param end  at most the number of
/// cycles counts.
[[nodiscard]] std::vector<double> Signal(const std::vector<CycleSample>& cycles,
                                         JointVector CycleSample::*field, std::size_t joint,
                                         std::size_t begin = 0, std::size_t end = SIZE_MAX);

/// Number of cycles in which the plan moves; the first is at the plan's time 0.
[[nodiscard]] std::size_t PlannedCycles(const reference::Trajectory& plan,
                                        const std::vector<CycleSample>& cycles);

/// The delay of a position behind the plan by least squares over all joints, within 100 ms, s.
/// @param field  the position.
[[nodiscard]] double DelayBehind(const reference::Trajectory& plan,
                                 const std::vector<CycleSample>& cycles,
                                 JointVector CycleSample::*field);

/// Root mean square of each joint's error from the plan so delayed, rad.
[[nodiscard]] JointVector RmsError(const reference::Trajectory& plan,
                                   const std::vector<CycleSample>& cycles,
                                   JointVector CycleSample::*field, double delay_s);

/// The plan's velocity at every cycle, joint by joint, rad/s.
[[nodiscard]] std::array<std::vector<double>, kJoints> PlannedVelocities(
    const reference::Trajectory& plan);

}  // namespace twin::experiment

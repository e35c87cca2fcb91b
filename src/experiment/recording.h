#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/core/robot_command.h"
#include "twin/core/time.h"
#include "twin/reference/trajectory.h"
#include "twin/rt/cycle_record.h"

namespace twin::experiment {

/// Of one INT cycle what curves are drawn from; names as in RobotState and CycleRecord.
struct CycleSample {
  std::uint64_t message_id = 0;
  JointVector q{};
  JointVector dq{};
  JointVector q_d{};
  JointVector dq_d{};
  JointVector dddq_d{};
  JointVector tau_J_d{};
  rt::CommandFate fate = rt::CommandFate::kNone;
};

/// Of one tick that wrote a command; names as in TickRecord and RobotCommand.
struct TickSample {
  std::uint64_t message_id = 0;  ///< of the state it answers
  JointVector q_ext{};
  JointVector dq_ext{};
  JointVector q_c{};
  JointVector dq_c{};
  std::optional<double> margin{};
  std::uint8_t kept_back = 0;
};

/// Keeps a run's curves in memory: of every cycle in motion, and of every tick that wrote.
///
/// Threads: cycles from one, ticks from one; the rest once the run is over.
class Recording final : public rt::RecordSink {
 public:
  /// @param cycles  room for so many from the start: on the wall clock nothing is allocated while a
  /// run goes on.
  explicit Recording(std::size_t cycles = 0) {
    cycles_.reserve(cycles);
    ticks_.reserve(cycles);
  }

  void Put(const rt::CycleRecord& record) noexcept override;
  void Put(const rt::TickRecord& record) noexcept override;

  [[nodiscard]] const std::vector<CycleSample>& cycles() const noexcept { return cycles_; }
  [[nodiscard]] const std::vector<TickSample>& ticks() const noexcept { return ticks_; }

 private:
  std::vector<CycleSample> cycles_;
  std::vector<TickSample> ticks_;
};

/// One joint of the cycles in [begin, end), as a signal of 1 kHz.
[[nodiscard]] std::vector<double> Signal(const std::vector<CycleSample>& cycles,
                                         JointVector CycleSample::*field, std::size_t joint,
                                         std::size_t begin, std::size_t end);

/// Cycles in which the plan was to be moved along; the first stands at the plan's time 0.
[[nodiscard]] std::size_t PlannedCycles(const reference::Trajectory& plan,
                                        const std::vector<CycleSample>& cycles);

/// The delay that leaves the least squares between a position and the plan, over all joints, s.
/// @param field  the position, of the cycles. @returns a delay within 100 ms.
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

/// Slope of the regression of y on x, both with their means: sum (x - mx)(y - my) / sum (x - mx)^2.
/// @pre as many of both, and x is not constant.
[[nodiscard]] double RegressionSlope(const std::vector<double>& x, const std::vector<double>& y);

}  // namespace twin::experiment

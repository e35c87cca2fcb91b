#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/record/cycle_record.h"
#include "twin/record/log_records.h"

namespace twin::report {

/// How close a run came to one limit, over all its joints or axes.
struct Approach {
  std::string_view what{};  ///< "ddq_d, its acceleration"
  std::string_view unit{};
  int axis = -1;     ///< joint 0..6; -1: the quantity has no axes
  double value = 0;  ///< at the closest
  double limit = 0;  ///< of it, signed like the value
  double share = 0;  ///< of the limit, 1: reached; of positions, of half the range
  double time = 0;   ///< s
};

/// Finds out how close the cycles of a run came to the robot's limits: in cycles of a motion what
/// was commanded (joints; end effector and elbow while a Cartesian motion runs; torques), in all
/// cycles what was measured.
///
/// Threads: one thread. Real-time: no.
class ApproachTracker {
 public:
  /// Without limits: only losses and external forces are told.
  ApproachTracker() = default;
  explicit ApproachTracker(const record::RunLimits& limits) : limits_(limits) {}

  /// @param cycle  the next one.
  void Add(const record::CycleRecord& cycle);

  /// Of each quantity that was not zero, in a fixed order. Empty without limits.
  [[nodiscard]] std::vector<Approach> Closest() const;

  [[nodiscard]] std::uint32_t longest_loss() const { return longest_loss_; }
  [[nodiscard]] double peak_force() const { return peak_force_; }    ///< |F_ext| at K, N
  [[nodiscard]] double peak_torque() const { return peak_torque_; }  ///< largest |tau_ext|, Nm
  [[nodiscard]] bool has_limits() const { return limits_.has_value(); }

 private:
  enum Quantity : std::size_t {
    kPosition,
    kVelocity,
    kAcceleration,
    kJerk,
    kTorqueRate,
    kMeasuredPosition,
    kMeasuredVelocity,
    kMeasuredTorque,
    kSpeed,
    kSpeedup,
    kTurn,
    kTurnup,
    kElbowVelocity,
    kElbowAcceleration,
    kQuantities
  };

  void AddJoints(Quantity quantity, const JointVector& values, const JointVector& limits,
                 double time);
  void AddPositions(Quantity quantity, const JointVector& q, double time);
  void AddCartesian(const RobotState& state, double time);
  void Consider(Quantity quantity, const Approach& candidate);

  std::optional<record::RunLimits> limits_;
  std::array<std::optional<Approach>, kQuantities> closest_;
  std::optional<JointVector> last_tau_J_d_;  ///< while an external controller runs
  std::uint32_t longest_loss_ = 0;
  double peak_force_ = 0;
  double peak_torque_ = 0;
};

}  // namespace twin::report

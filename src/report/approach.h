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

/// Closest approach of a run to one limit, over all joints or axes.
struct Approach {
  std::string_view what{};  ///< "ddq_d, its acceleration"
  std::string_view unit{};
  int axis = -1;     ///< joint 0..6; -1: the quantity has no axes
  double value = 0;  ///< at the closest approach
  double limit = 0;  ///< of this joint or axis, signed like the value
  double share = 0;  ///< share of the limit (1: reached); for positions, of half the range
  double time = 0;   ///< s
};

/// Finds the closest approach of a run's cycles to the robot's limits: of commanded quantities in
/// the cycles of motions (joints; end effector and elbow during Cartesian motions; torques), and of
/// measured ones in all cycles.
///
/// Threads: one thread. Real-time: no.
class ApproachTracker {
 public:
  /// Without limits: tracks only losses and external forces.
  ApproachTracker() = default;
  explicit ApproachTracker(const record::RunLimits& limits) : limits_(limits) {}

  /// @param cycle  the next cycle of the log.
  void Add(const record::CycleRecord& cycle);

  /// One entry per quantity that was not always zero, in a fixed order. Empty without limits.
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

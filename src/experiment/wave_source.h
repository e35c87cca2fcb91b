#pragma once

#include <chrono>
#include <vector>

#include "twin/control/controller.h"
#include "twin/core/joint_vector.h"
#include "twin/core/time.h"

namespace twin::experiment {

/// A source that swings joint 1 without feedback, alike on every interface:
///   q(t) = q_0 + A sin^4(w t),   w = pi/2 1/s,   4 s long: at rest at both ends,
/// as position, as its derivative, or as a torque of 1 Nm per rad of the swing. Its largest
/// acceleration is 4 A w^2.
///
/// Threads: all calls from the controller loop's thread. Real-time: Update().
class WaveSource final : public control::Controller {
 public:
  static constexpr Duration kLength = std::chrono::seconds(4);

  /// @param interface  joint position, joint velocity or torque. @param start  q_0.
  /// @param acceleration  the largest, rad/s^2.
  WaveSource(control::CommandInterface interface, const JointVector& start, double acceleration)
      : interface_(interface), start_(start), acceleration_(acceleration) {}

  [[nodiscard]] control::CommandInterface command_interface() const noexcept override {
    return interface_;
  }
  void Activate(const RobotState& /*state*/, Time /*now*/) override { is_running_ = false; }
  void Update(const RobotState& state, Time now,
              control::ControllerOutput& output) noexcept TWIN_REALTIME override;
  void Deactivate() noexcept override {}

 private:
  control::CommandInterface interface_;
  JointVector start_;
  double acceleration_;
  bool is_running_ = false;
  Time begin_{};
};

/// The deposit for joint 1 at time t of the motion, and its derivative; a position less q_0.
struct WaveValue {
  double value = 0;
  double rate = 0;
};
[[nodiscard]] WaveValue WaveAt(control::CommandInterface interface, double acceleration,
                               double t) noexcept;

/// The lag of a signal of 1 kHz behind the wave, by least squares over shift and a constant, s.
[[nodiscard]] double WaveDelay(control::CommandInterface interface, double acceleration,
                               const std::vector<double>& signal);

}  // namespace twin::experiment

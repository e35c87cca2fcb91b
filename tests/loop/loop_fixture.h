#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <vector>

#include <gtest/gtest.h>

#include "plugins/backends.h"
#include "support/panda_limits.h"
#include "twin/backend/registry.h"
#include "twin/core/error.h"
#include "twin/loop/drive.h"

namespace twin::test {

/// Moves joint 7 by `amplitude` and back along a smooth curve of 1 s, then is done. Its peak
/// acceleration is 32 times the amplitude.
class Swing final : public control::Controller {
 public:
  control::CommandInterface command_interface() const noexcept override {
    return control::CommandInterface::kJointPosition;
  }
  void Activate(const RobotState& state, Time) override {
    if (refuses) throw InputError("this controller does not want to start");
    start_ = state.q_d;
    begin_ = Time::min();
  }
  void Update(const RobotState&, Time now, control::ControllerOutput& output) noexcept override {
    if (begin_ == Time::min()) begin_ = now;
    const double s = std::min(ToSeconds(now - begin_), 1.0);
    const double bump = s * s * s * s * (1 - s) * (1 - s) * (1 - s) * (1 - s) * 256;
    output.target.joint.q = start_;
    output.target.joint.q[6] += amplitude * bump;
    output.finished = s >= 1.0 && !endless;
    ++updates;
  }
  void Deactivate() noexcept override { ++deactivated; }

  double amplitude = 0.3;  ///< rad
  bool refuses = false;
  bool endless = false;
  int deactivated = 0;
  std::uint64_t updates = 0;

 private:
  JointVector start_{};
  Time begin_ = Time::min();
};

/// Keeps every record, so that runs can be compared to the bit.
class Keeper final : public record::RecordSink {
 public:
  void Put(const record::CycleRecord& record) noexcept override { cycles.push_back(record); }
  void Put(const record::TickRecord& record) noexcept override { ticks.push_back(record); }

  [[nodiscard]] std::size_t Count(record::CommandFate fate) const {
    return static_cast<std::size_t>(
        std::ranges::count(cycles, fate, [](const record::CycleRecord& r) { return r.fate; }));
  }

  std::vector<record::CycleRecord> cycles;
  std::vector<record::TickRecord> ticks;
};

/// A Panda on the ideal plant over a link with a little jitter.
[[nodiscard]] inline robot::RobotConfig IdealPanda() {
  using std::chrono::microseconds;
  robot::RobotConfig config;
  config.onboard.limits = PandaLimits();
  config.onboard.cartesian = PandaCartesianLimits();
  config.plant_kind = robot::PlantKind::kIdeal;
  config.link.state.delay = faults::DelayModel(faults::LogNormalDelay{microseconds(60), 0.3, {}});
  config.link.command.delay = faults::DelayModel(faults::LogNormalDelay{microseconds(60), 0.3, {}});
  config.q_start = {0, -0.785398163397, 0, -2.356194490192, 0, 1.570796326795, 0.785398163397};
  return config;
}

/// One motion in lockstep.
struct LockstepMotion {
  robot::RobotConfig robot = IdealPanda();
  MotionModes modes;
  loop::LoopKind kind = loop::LoopKind::kAsynchronous;
  loop::TickConfig tick;
  loop::ControllerLoopConfig controller_loop;
  Duration time_limit = std::chrono::seconds(20);
  const volatile bool* interrupted = nullptr;
  std::function<Time(Time)> attend;

  /// @param sink  of cycles and ticks; may be null.
  [[nodiscard]] loop::RunReport Run(control::Controller& controller, std::uint64_t seed = 1,
                                    record::RecordSink* sink = nullptr) {
    robot.seed = seed;
    backend::Registry registry;
    plugins::RegisterMujoco(registry);
    const auto drive = loop::MakeLockstepDrive(registry.Find("mujoco"), robot, sink);
    return drive->Run({.backend = *drive->connection().backend,
                       .controller = controller,
                       .modes = modes,
                       .kind = kind,
                       .tick = tick,
                       .controller_loop = controller_loop,
                       .seed = seed,
                       .time_limit = time_limit,
                       .sink = sink,
                       .progress = {},
                       .event = {},
                       .interrupted = interrupted,
                       .attend = attend});
  }
};

}  // namespace twin::test

#pragma once

#include "twin/loop/communication_loop.h"
#include "twin/loop/depositor.h"
#include "twin/loop/loop_config.h"
#include "twin/loop/wake_grid.h"

namespace twin::loop {

/// A loop that runs the controller inside, one step after the other: read -> publish -> controller
/// -> tick -> write. Base class of the paper's two baselines. The controller is updated only with
/// states of the running motion.
class InlineLoop : public CommunicationLoop {
 public:
  void Activate(const MotionModes& modes) noexcept override;
  void StopController() noexcept override { stopped_ = true; }

 protected:
  InlineLoop(ControlTick& tick, backend::Backend& backend, record::RecordSink* sink,
             backend::ReadRule rule, control::Controller& controller, Exchange& exchange,
             const TickConfig& tick_config, const ControllerLoopConfig& config, std::uint64_t seed);

  /// @returns the controller's own time for a state whose read ended at `read`.
  [[nodiscard]] virtual Time ControllerTime(const RobotState& state, Time read) noexcept = 0;

 private:
  [[nodiscard]] const RobotCommand* Compute(const RobotState& state, Time read,
                                            Duration& cost) noexcept TWIN_REALTIME override;

  control::Controller& controller_;
  Depositor depositor_;
  faults::DelayModel tick_cost_;
  faults::DelayModel controller_cost_;
  Random tick_random_;
  Random controller_random_;
  control::ControllerOutput output_;
  bool stopped_ = false;
};

/// The paper's synchronous loop (RS), as in the official ROS 2 stack: a periodic timer on the
/// workstation's clock starts a cycle = wait for a fresh state -> controllers -> write -> sleep.
/// Two clocks pace one loop; when their phases meet, cycles overrun and remain unserved. An overrun
/// skips to the next instant of the grid. Source: the paper's section on why the synchronous loop
/// fails.
class SynchronousLoop final : public InlineLoop {
 public:
  SynchronousLoop(ControlTick& tick, backend::Backend& backend, record::RecordSink* sink,
                  control::Controller& controller, Exchange& exchange,
                  const TickConfig& tick_config, const ControllerLoopConfig& config,
                  std::uint64_t seed)
      : InlineLoop(tick, backend, sink, backend::ReadRule::kFresh, controller, exchange,
                   tick_config, config, seed),
        grid_(config, seed) {}

  [[nodiscard]] Time Start(Time now) noexcept TWIN_REALTIME override { return grid_.Start(now); }

  /// Wake-ups skipped because a cycle outlasted its period.
  [[nodiscard]] std::uint64_t overruns() const noexcept { return grid_.overruns(); }

 private:
  [[nodiscard]] Time ControllerTime(const RobotState& /*state*/,
                                    Time read) noexcept TWIN_REALTIME override {
    return grid_.OwnTime(read);
  }
  [[nodiscard]] Time NextRead(Time now) noexcept TWIN_REALTIME override { return grid_.Next(now); }

  WakeGrid grid_;
};

/// The paper's bare loop (LF), as a libfranka callback: paced by the robot, with the controller
/// inside, on the newest state. The controller's time is the robot's, 1 ms per message_id: no
/// sampling jitter, but the loop runs at exactly the robot's rate.
class BareLoop final : public InlineLoop {
 public:
  BareLoop(ControlTick& tick, backend::Backend& backend, record::RecordSink* sink,
           control::Controller& controller, Exchange& exchange, const TickConfig& tick_config,
           const ControllerLoopConfig& config, std::uint64_t seed)
      : InlineLoop(tick, backend, sink, backend::ReadRule::kNewest, controller, exchange,
                   tick_config, config, seed) {}

  [[nodiscard]] Time Start(Time now) noexcept TWIN_REALTIME override { return now; }

 private:
  [[nodiscard]] Time ControllerTime(const RobotState& state,
                                    Time /*read*/) noexcept TWIN_REALTIME override {
    return Time(kCycle * static_cast<std::int64_t>(state.message_id));
  }
};

}  // namespace twin::loop

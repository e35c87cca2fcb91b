#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "twin/control/controller.h"
#include "twin/core/modes.h"
#include "twin/core/random.h"
#include "twin/core/robot_state.h"
#include "twin/loop/control_tick.h"
#include "twin/loop/depositor.h"
#include "twin/loop/exchange.h"
#include "twin/loop/loop_config.h"
#include "twin/robot/robot.h"
#include "twin/rt/event_queue.h"

namespace twin::run {

/// The workstation of a stepped robot: the asynchronous loop of loop::AsynchronousLoop with a
/// deposits of a step in place of a controller. Its first deposit of a motion holds still.
///
/// Threads: the queue's.
class SteppedChain {
 public:
  /// @param events, robot  must outlive the object. @throws InputError as loop::CommandChain.
  SteppedChain(rt::EventQueue& events, robot::Robot& robot, control::CommandInterface interface,
               const loop::TickConfig& tick, const loop::ControllerLoopConfig& controller);

  /// Prepares a motion with these modes, before its start.
  void Start(const MotionModes& modes, std::uint64_t seed);
  /// Ends the motion's ticks; events that are still pending have no effect.
  void Stop() noexcept;

  /// As SteppedRobot.
  void SetTarget(const reference::Target& target);
  /// Deposits what is to be reached at `share` of the step, in (0, 1], at `wake` + wake delay +
  /// cost.
  void Deposit(Time wake, double share) noexcept;
  /// The next step leads on from the present target.
  void EndStep() noexcept { from_ = output_.target; }
  /// A state has arrived.
  void OnState(Time now) noexcept;

  /// Forgets the last step's margin and changes.
  void BeginStep() noexcept {
    margin_.reset();
    kept_back_ = 0;
  }
  [[nodiscard]] std::optional<double> margin() const noexcept { return margin_; }
  [[nodiscard]] std::uint64_t kept_back() const noexcept { return kept_back_; }
  /// The state read last.
  [[nodiscard]] const RobotState& state() const noexcept { return state_; }

 private:
  /// Deposits on their way at once; later ones wait for the next step.
  static constexpr std::size_t kMostOnTheWay = 64;

  /// What lives for one motion.
  struct Motion {
    Motion(const SteppedChain& chain, std::uint64_t seed)
        : tick(chain.tick_, chain.interface_, exchange),
          depositor(chain.controller_, chain.interface_, exchange, seed),
          tick_cost(seed, RandomStream::kTickCost),
          wake(seed, RandomStream::kControllerWake),
          cost(seed, RandomStream::kControllerCost) {}
    loop::Exchange exchange;
    loop::ControlTick tick;
    loop::Depositor depositor;
    Random tick_cost;
    Random wake;
    Random cost;
  };
  struct OnTheWay {
    control::ControllerOutput output;
    Time source_time{};
    std::uint64_t based_on = 0;
  };
  /// Forwards the events of the present motion.
  class Port final : public rt::EventHandler {
   public:
    using Step = void (SteppedChain::*)(std::uint64_t) noexcept;
    Port(SteppedChain& chain, Step step) noexcept : chain_(chain), step_(step) {}
    void OnEvent(Time /*now*/, std::uint64_t token) noexcept override {
      if (token / kMostOnTheWay == chain_.serial_) (chain_.*step_)(token % kMostOnTheWay);
    }

   private:
    SteppedChain& chain_;
    Step step_;
  };

  void Write(std::uint64_t /*slot*/) noexcept;
  void Arrive(std::uint64_t slot) noexcept;
  void Hold() noexcept;
  [[nodiscard]] reference::Target Between(double share) const noexcept;

  rt::EventQueue& events_;
  robot::Robot& robot_;
  const control::CommandInterface interface_;
  const loop::TickConfig tick_;
  const loop::ControllerLoopConfig controller_;
  Port done_{*this, &SteppedChain::Write};
  Port deposit_{*this, &SteppedChain::Arrive};
  std::unique_ptr<Motion> motion_;
  std::uint64_t serial_ = 0;  ///< of the motion
  RobotState state_;
  const RobotCommand* command_ = nullptr;
  bool computing_ = false;
  bool holds_ = false;                ///< a motion's first deposit has been made
  control::ControllerOutput output_;  ///< with the target of the step
  reference::Target from_;            ///< target of the last step
  std::array<OnTheWay, kMostOnTheWay> on_the_way_{};
  std::uint64_t deposits_ = 0;  ///< of the motion, made
  std::uint64_t arrived_ = 0;   ///< of these, arrived
  std::optional<double> margin_;
  std::uint64_t kept_back_ = 0;
};

}  // namespace twin::run

#include "cli/page_operator.h"

#include <chrono>
#include <cstdint>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/core/hand_command.h"
#include "twin/rt/sleep.h"
#include "twin/scenario/operator.h"
#include "twin/scenario/session.h"
#include "twin/teleop/teleoperator.h"

namespace twin::cli {
namespace {

constexpr Duration kLook = std::chrono::milliseconds(50);
/// An operator has to go home some time.
constexpr Duration kLongest = std::chrono::hours(8);

scenario::Scenario OverTheWire(scenario::Scenario served) {
  served.backend = scenario::kRemoteBackend;
  served.drive = scenario::Drive::kRemote;
  served.robot.clock_drift_ppm = 0;
  served.application.reset();
  served.hand.clear();
  return served;
}

scenario::RealtimeSettings ServedAt(const fci::Endpoint& arm) {
  scenario::RealtimeSettings settings;
  settings.remote.host = "127.0.0.1";
  settings.remote.arm_port = arm.port;
  settings.remote.checks_start = false;
  return settings;
}

/// The paper's, of its teleoperation.
control::Parameters Gains() {
  return {{.key = "reference", .values = {"live"}},
          {.key = "k0", .values = {"0.3 Nm/rad"}},
          {.key = "stiffness.translation", .values = {"900 N/m"}},
          {.key = "stiffness.rotation", .values = {"90 Nm/rad"}},
          {.key = "damping.translation", .values = {"100 Ns/m"}},
          {.key = "damping.rotation",
           .values = {"10 Nms/rad", "1 Nms/rad", "1 Nms/rad"},
           .is_list = true}};
}

/// Whatever there is between the fingers is held.
const HandCommand kClose =
    hand::Grasp{.width = 0, .speed = 0.1, .force = 30, .epsilon_outer = kHandStroke};
const HandCommand kOpen = hand::Move{.width = kHandStroke, .speed = 0.1};

/// Closes and opens the hand as often as the operator presses.
class Fingers {
 public:
  Fingers(backend::Hand* hand, const teleop::Teleoperator& led) : hand_(hand), led_(led) {}

  /// As loop::MotionRun::attend.
  Time Attend(Time now) {
    const std::uint32_t presses = led_.gripper_presses();
    if (hand_ != nullptr && presses != done_) {
      static_cast<void>(hand_->Start(presses % 2 == 1 ? kClose : kOpen));
      done_ = presses;
    }
    return now + kLook;
  }

 private:
  backend::Hand* hand_;
  const teleop::Teleoperator& led_;
  std::uint32_t done_ = 0;
};

}  // namespace

PageOperator::PageOperator(const Parts& parts, const scenario::Scenario& served,
                           const fci::Endpoint& arm, Tell tell)
    : parts_(parts),
      scenario_(OverTheWire(served)),
      settings_(ServedAt(arm)),
      tell_(std::move(tell)),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

void PageOperator::Run(const std::stop_token& stop) {
  const std::stop_callback interrupt(stop, [this] { interrupted_ = true; });
  const MonotonicClock clock;
  std::uint64_t served = 0;
  for (; !stop.stop_requested(); rt::SleepUntil(clock, clock.Now() + kLook)) {
    if (!wanted_.load(std::memory_order_acquire)) continue;
    const std::uint64_t take = takes_.load(std::memory_order_relaxed);
    if (take == served) continue;  // that one's session has ended, and control was not given back
    page::PageDevice device(parts_.channel, "this server");
    // Whoever gives control back from now on presses an end that this device is told.
    if (!wanted_.load(std::memory_order_acquire)) continue;
    served = take;
    try {
      Session(device);
    } catch (const Error& error) {
      tell_(clock.Now(), "error",
            fmt::format("{}; to try again, give control back and take it", error.what()));
    }
  }
}

void PageOperator::Session(page::PageDevice& device) {
  scenario::Session session(scenario_, parts_.catalogue, parts_.files, nullptr, settings_);
  scenario::RunHooks hooks;
  hooks.interrupted = &interrupted_;
  hooks.event = tell_;
  session.Begin(hooks);
  session.Recover();
  const scenario::OperatorSection section =
      scenario_.operator_section.value_or(scenario::OperatorSection());
  teleop::Teleoperator led({.device = device, .limits = session.robot().limits},
                           scenario::MakeTeleoperator(section), scenario::MakeWire(section),
                           scenario_.seed);
  Fingers fingers(session.connection().hand, led);
  scenario::Motion motion = scenario::MotionOn(
      scenario_, "led by the page", control::CommandInterface::kTorque,
      scenario::StandingFor(session.ReadState().q_d, kLongest, session.robot().limits));
  motion.controller.type = "compliance";
  motion.controller.parameters = Gains();
  motion.live = &led;
  motion.attend = [&fingers](Time now) { return fingers.Attend(now); };
  const scenario::MotionResult result = session.Move(motion);
  if (!result.report.succeeded()) tell_(session.Now(), "error", result.report.failure);
}

}  // namespace twin::cli

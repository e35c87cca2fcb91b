#include "twin/application/page_operator.h"

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "twin/application/application.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/page/page_device.h"
#include "twin/rt/host_time.h"
#include "twin/run/operator_page.h"
#include "twin/run/session.h"
#include "twin/teleop/device_registry.h"

namespace twin::application {
namespace {

constexpr Duration kLook = std::chrono::milliseconds(50);
/// Longest session that the application permits.
constexpr const char* kLongest = "3600 s";

/// The served robot's scenario for a remote client, with the page as the operator's device.
scenario::Scenario LedFromThePage(scenario::Scenario served) {
  served.backend = scenario::kRemoteBackend;
  served.robot.clock_drift_ppm = 0;
  served.hand.clear();
  if (!served.robot.q_start && !served.motion.waypoints.empty()) {
    served.robot.q_start = served.motion.waypoints.front().q;
  }
  served.motion = {};
  served.base.reset();  // the interface has no mobile base
  served.application = scenario::ApplicationSection{
      .type = "teleoperation", .parameters = {{.key = "longest", .values = {kLongest}}}};
  if (!served.operator_section) served.operator_section.emplace();
  served.operator_section->device = std::string(run::kPageDevice);
  served.operator_section->parameters.clear();
  return served;
}

run::RealtimeConfig ServedAt(const fci::Endpoint& arm, const std::optional<fci::Endpoint>& hand) {
  run::RealtimeConfig settings;
  // The address at which this server listens; at another, another robot may use the same port.
  settings.remote.host = arm.address == 0 ? "127.0.0.1" : fci::AddressText(arm.address);
  settings.remote.arm_port = arm.port;
  if (hand) settings.remote.hand_port = hand->port;
  settings.checks_start = false;
  return settings;
}

}  // namespace

PageOperator::PageOperator(const Parts& parts, const scenario::Scenario& served,
                           const fci::Endpoint& arm, const std::optional<fci::Endpoint>& hand,
                           Tell tell)
    : parts_(parts),
      scenario_(LedFromThePage(served)),
      settings_(ServedAt(arm, hand)),
      tell_(std::move(tell)),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

void PageOperator::Run(const std::stop_token& stop) {
  const std::stop_callback interrupt(stop, [this] { interrupted_ = true; });
  const MonotonicClock clock;
  std::uint64_t served = 0;
  for (; !stop.stop_requested(); rt::SleepUntil(clock, clock.Now() + kLook)) {
    if (!wanted_.load(std::memory_order_acquire)) continue;
    const std::uint64_t take = takes_.load(std::memory_order_relaxed);
    if (take == served) continue;  // its session has ended, but control was not returned
    auto device = std::make_unique<page::PageDevice>(parts_.channel, "this server");
    // From here on, the device receives the end that is pressed when control is returned.
    if (!wanted_.load(std::memory_order_acquire)) continue;
    served = take;
    try {
      Session(std::move(device));
    } catch (const Error& error) {
      tell_(clock.Now(), "error",
            fmt::format("{}; to try again, give control back and take it", error.what()));
    }
  }
}

void PageOperator::Session(std::unique_ptr<teleop::Device> device) {
  run::RunHooks hooks;
  hooks.interrupted = &interrupted_;
  hooks.event = tell_;
  {
    // Recovers from a stop or a reflex.
    run::Session session(scenario_, parts_.catalogue, parts_.files, nullptr, settings_);
    session.Begin(hooks);
    session.Recover();
  }
  teleop::DeviceRegistry devices;
  devices.Add(std::string(run::kPageDevice),
              [&device](const teleop::DeviceRequest&) { return std::move(device); });
  const run::Catalogue catalogue{parts_.catalogue.backends, parts_.catalogue.controllers, &devices};
  const MonotonicClock clock;
  ApplicationRun run(scenario_, catalogue, parts_.files, nullptr, clock, settings_);
  const TaskResult& task_result = run.Execute(hooks);
  if (!task_result.task.failure.empty()) tell_(clock.Now(), "error", task_result.task.failure);
}

}  // namespace twin::application

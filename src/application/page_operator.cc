#include "twin/application/page_operator.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "application/home_motion.h"
#include "twin/application/application.h"
#include "twin/application/own_client.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/page/page_device.h"
#include "twin/rt/host_time.h"
#include "twin/run/operator_page.h"
#include "twin/run/session.h"
#include "twin/teleop/device_registry.h"
#include "twin/teleop/teleoperator_config.h"

namespace twin::application {
namespace {

constexpr Duration kLook = std::chrono::milliseconds(50);
/// Longest session that the application permits.
constexpr const char* kLongest = "3600 s";

/// 20 mm, 18 N: a hand that slides off what it presses onto starts no faster than it is led. By 40
/// mm it struck a table so that joint 6 left its range of torques.
constexpr const char* kPress = "20 mm";

void SetIfAbsent(control::Parameters& settings, std::string_view key, std::string value) {
  const bool is_given = std::ranges::any_of(
      settings, [key](const control::Parameter& one) { return one.key == key; });
  if (!is_given) settings.push_back({.key = std::string(key), .values = {std::move(value)}});
}

/// Browsers send by the wall clock, and samples age by the robot's time, which may be faster.
std::string StaleAfter(double pace) {
  const double usual = ToSeconds(teleop::TeleoperatorConfig().stale_after);
  return fmt::format("{} s", std::min(std::max(pace, 1.0) * usual, 10.0));
}

/// The served robot's scenario for a client that the page leads.
scenario::Scenario LedFromThePage(const scenario::Scenario& served, double pace) {
  scenario::Scenario led = OwnClientOf(served);
  led.application = scenario::ApplicationSection{
      .type = "teleoperation", .parameters = {{.key = "longest", .values = {kLongest}}}};
  if (!led.operator_section) led.operator_section.emplace();
  led.operator_section->device = std::string(run::kPageDevice);
  led.operator_section->parameters.clear();
  control::Parameters& settings = led.operator_section->settings;
  SetIfAbsent(settings, "stale_after", StaleAfter(pace));
  SetIfAbsent(settings, "workspace.press", kPress);
  return led;
}

}  // namespace

PageOperator::PageOperator(Parts parts, const scenario::Scenario& served, const fci::Endpoint& arm,
                           const std::optional<fci::Endpoint>& hand, Tell tell)
    : parts_(std::move(parts)),
      served_(served),
      scenario_(LedFromThePage(served, parts_.pace)),
      settings_(OwnClientAt(arm, hand)),
      tell_(std::move(tell)),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

void PageOperator::Offer(page::PageSettings& settings) {
  settings.control = [this](bool wanted) { Operate(wanted); };
  settings.resume = {.phase =
                         [this] {
                           const std::lock_guard lock(mutex_);
                           return phase_;
                         },
                     .recover = [this] { return Ask(Wish::kLead); },
                     .home = [this] { return Ask(Wish::kHome); }};
}

void PageOperator::Operate(bool wanted) {
  const std::lock_guard lock(mutex_);
  wanted_ = wanted;
  wish_ = wanted ? Wish::kLead : Wish::kNone;
  if (!wanted) ends_home_ = true;
}

bool PageOperator::Ask(Wish wish) {
  using page::LedSession;
  const std::lock_guard lock(mutex_);
  const bool may =
      phase_ == LedSession::kRests || (wish == Wish::kHome && phase_ == LedSession::kLeads);
  if (!wanted_ || !may) return false;
  wish_ = wish;
  return true;
}

bool PageOperator::is_wanted() const {
  const std::lock_guard lock(mutex_);
  return wanted_;
}

PageOperator::Wish PageOperator::Begin() {
  const std::lock_guard lock(mutex_);
  const Wish wish = std::exchange(wish_, Wish::kNone);
  if (wish == Wish::kNone) return wish;
  phase_ = wish == Wish::kHome ? page::LedSession::kGoesHome : page::LedSession::kConnects;
  ends_home_ = false;
  return wish;
}

void PageOperator::End(Wish next) {
  const std::lock_guard lock(mutex_);
  phase_ = page::LedSession::kRests;
  if (wanted_ && wish_ == Wish::kNone) wish_ = next;
}

void PageOperator::Run(const std::stop_token& stop) {
  const std::stop_callback interrupt(stop, [this] {
    interrupted_ = true;
    ends_home_ = true;
  });
  const MonotonicClock clock;
  for (; !stop.stop_requested(); rt::SleepUntil(clock, clock.Now() + kLook)) {
    const Wish wish = Begin();
    if (wish == Wish::kNone) continue;
    Wish next = Wish::kNone;  // after an end or an error the operator decides
    try {
      if (wish == Wish::kHome) {
        Home();
        next = Wish::kLead;
      } else {
        auto device = std::make_unique<page::PageDevice>(parts_.channel, "this server",
                                                         page::PageDevice::Presses::kFromNow);
        // From here on, the device receives the end that is pressed when control is returned.
        if (is_wanted()) Session(std::move(device));
      }
    } catch (const Error& error) {
      tell_(clock.Now(), "error", error.what());
    }
    End(next);
  }
}

void PageOperator::Home() {
  run::RunHooks hooks;
  hooks.interrupted = &ends_home_;
  hooks.event = tell_;
  run::Session session(scenario_, parts_.catalogue, parts_.files, nullptr, settings_);
  session.Begin(hooks);
  session.Recover();
  MoveHome(session, scenario_, served_, parts_.files, parts_.arrange);
}

void PageOperator::Session(std::unique_ptr<teleop::Device> device) {
  device->Feel({});  // nothing is left of the last session's
  run::RunHooks hooks;
  hooks.interrupted = &interrupted_;
  hooks.event = tell_;
  run::RunFiles files = parts_.files;
  files.neighbours = {};  // they move, and an operator's surroundings are fixed
  {
    // Recovers from a stop or a reflex.
    run::Session session(scenario_, parts_.catalogue, files, nullptr, settings_);
    session.Begin(hooks);
    session.Recover();
  }
  teleop::DeviceRegistry devices;
  devices.Add(std::string(run::kPageDevice),
              [&device](const teleop::DeviceRequest&) { return std::move(device); });
  const run::Catalogue catalogue{parts_.catalogue.backends, parts_.catalogue.controllers, &devices};
  const MonotonicClock clock;
  ApplicationRun run(scenario_, catalogue, files, nullptr, clock, settings_);
  {
    const std::lock_guard lock(mutex_);
    phase_ = page::LedSession::kLeads;
  }
  const TaskResult& task_result = run.Execute(hooks);
  if (!task_result.task.failure.empty()) tell_(clock.Now(), "error", task_result.task.failure);
}

}  // namespace twin::application

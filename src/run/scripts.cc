#include "run/scripts.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::run {
namespace {

/// How often the hand is asked whether a command has ended, and a base is commanded.
constexpr Duration kHandPeriod = std::chrono::milliseconds(10);
constexpr Duration kDrivePeriod = std::chrono::milliseconds(50);

std::string EndText(const HandCommand& command, const HandOutcome& outcome) {
  const std::string state = outcome.pump ? fmt::format("{} mbar", outcome.pump->vacuum)
                                         : fmt::format("{:.1f} mm open", 1e3 * outcome.width);
  return fmt::format("{}: {}; {}{}", twin::Name(command), Name(*outcome.result), state,
                     outcome.is_grasped ? ", something is grasped" : "");
}

/// Lines of a script as events of a kind; empty when nothing listens. `hooks` must outlive it.
std::function<void(Time, std::string_view)> EventsOf(const RunHooks& hooks, std::string_view kind) {
  if (!hooks.event) return {};
  return [&hooks, kind](Time now, std::string_view text) { hooks.event(now, kind, text); };
}

}  // namespace

backend::Hand& RequireHand(const backend::Connection& connection, std::string_view backend) {
  if (connection.hand != nullptr) return *connection.hand;
  throw InputError(
      fmt::format("hand: the backend {} has no hand; leave the commands out", backend));
}

HandScript::HandScript(const std::vector<scenario::HandEvent>& events, backend::Hand& hand,
                       ScriptLog log)
    : events_(events), hand_(hand), log_(std::move(log)), outcomes_(events.size()) {}

Time HandScript::Attend(Time now) {
  Look(now);
  for (; next_ < events_.size() && Time(events_[next_].at) <= now; ++next_) Begin(next_, now);
  if (running_) return now + kHandPeriod;
  return next_ < events_.size() ? Time(events_[next_].at) : Time::max();
}

void HandScript::Begin(std::size_t index, Time now) {
  const HandCommand& command = events_[index].command;
  HandOutcome& outcome = outcomes_[index];
  outcome.begun = now;
  try {
    const HandTicket ticket = hand_.Start(command);
    Look(now);  // what ran until now is aborted
    running_ = index;
    ticket_ = ticket;
    Say(now, fmt::format("{} started", twin::Name(command)));
    Look(now);  // a stop has ended already
  } catch (const Error& error) {
    outcome.ended = now;
    outcome.result = HandResult::kFail;
    outcome.failure = error.what();
    Say(now, outcome.failure);
  }
}

void HandScript::Look(Time now) {
  if (!running_) return;
  const std::size_t index = *running_;
  HandOutcome& outcome = outcomes_[index];
  try {
    outcome.result = hand_.Outcome(ticket_);
    if (!outcome.result) return;
    const HandState state = hand_.ReadState();
    outcome.width = state.width;
    outcome.is_grasped = state.is_grasped;
    outcome.pump = state.pump;
    Say(now, EndText(events_[index].command, outcome));
  } catch (const Error& error) {
    outcome.result = HandResult::kFail;
    outcome.failure = error.what();
    Say(now, outcome.failure);
  }
  outcome.ended = now;
  running_.reset();
}

HandReport HandScript::Report() const {
  return {.commands = outcomes_, .state = hand_.ReadState()};
}

backend::MobileBase& RequireBase(const backend::Connection& connection, std::string_view backend) {
  if (connection.base != nullptr) return *connection.base;
  throw InputError(fmt::format("base: the backend {} has no mobile base; leave it out", backend));
}

DriveScript::DriveScript(const std::vector<scenario::DriveEvent>& events, backend::MobileBase& base,
                         ScriptLog log)
    : events_(events), base_(base), log_(std::move(log)) {}

Time DriveScript::Attend(Time now) {
  while (next_ < events_.size() && Time(events_[next_].at + events_[next_].span) <= now) {
    ++next_;
    told_ = false;
  }
  Time until = now + kDrivePeriod;
  BaseTwist twist;
  if (next_ < events_.size()) {
    const scenario::DriveEvent& event = events_[next_];
    const bool runs = Time(event.at) <= now;
    if (runs) twist = event.twist;
    until = std::min(until, Time(runs ? event.at + event.span : event.at));
    if (runs && !std::exchange(told_, true) && log_) {
      log_(now, fmt::format("asked for {} m/s, {} rad/s for {} s", twist.v, twist.w,
                            ToSeconds(event.span)));
    }
  }
  base_.Drive(twist);
  return until;
}

MotionScripts::MotionScripts(const scenario::Scenario& scenario,
                             const backend::Connection& connection, const RunHooks& hooks) {
  if (!scenario.hand.empty()) {
    hand_.emplace(scenario.hand, RequireHand(connection, scenario.backend),
                  EventsOf(hooks, "hand"));
  }
  if (scenario.base && !scenario.base->drive.empty()) {
    drive_.emplace(scenario.base->drive, RequireBase(connection, scenario.backend),
                   EventsOf(hooks, "base"));
  }
}

std::function<Time(Time)> MotionScripts::Attend() {
  if (!hand_ && !drive_) return {};
  return [this](Time now) {
    const Time next = hand_ ? hand_->Attend(now) : Time::max();
    return drive_ ? std::min(next, drive_->Attend(now)) : next;
  };
}

std::optional<HandReport> MotionScripts::Report() const {
  return hand_ ? std::optional(hand_->Report()) : std::nullopt;
}

}  // namespace twin::run

#include "run/hand_script.h"

#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::run {
namespace {

/// How often the hand is asked whether a command has ended.
constexpr Duration kLook = std::chrono::milliseconds(10);

std::string EndText(const HandCommand& command, const HandOutcome& outcome) {
  return fmt::format("{}: {}; {:.1f} mm open{}", twin::Name(command), Name(*outcome.result),
                     1e3 * outcome.width, outcome.is_grasped ? ", something is grasped" : "");
}

}  // namespace

backend::Hand& RequireHand(const backend::Connection& connection, std::string_view backend) {
  if (connection.hand != nullptr) return *connection.hand;
  throw InputError(
      fmt::format("hand: the backend {} has no hand; leave the commands out", backend));
}

HandScript::HandScript(const std::vector<scenario::HandEvent>& events, backend::Hand& hand,
                       Tell tell)
    : events_(events), hand_(hand), tell_(std::move(tell)), outcomes_(events.size()) {}

Time HandScript::Attend(Time now) {
  Look(now);
  for (; next_ < events_.size() && Time(events_[next_].at) <= now; ++next_) Begin(next_, now);
  if (running_) return now + kLook;
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

}  // namespace twin::run

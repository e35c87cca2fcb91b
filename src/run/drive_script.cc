#include "run/drive_script.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::run {
namespace {

constexpr Duration kPeriod = std::chrono::milliseconds(50);

}  // namespace

backend::MobileBase& RequireBase(const backend::Connection& connection, std::string_view backend) {
  if (connection.base != nullptr) return *connection.base;
  throw InputError(fmt::format("base: the backend {} has no mobile base; leave it out", backend));
}

DriveScript::DriveScript(const std::vector<scenario::DriveEvent>& events, backend::MobileBase& base,
                         Tell tell)
    : events_(events), base_(base), tell_(std::move(tell)) {}

Time DriveScript::Attend(Time now) {
  while (next_ < events_.size() && Time(events_[next_].at + events_[next_].span) <= now) {
    ++next_;
    told_ = false;
  }
  Time until = now + kPeriod;
  BaseTwist twist;
  if (next_ < events_.size()) {
    const scenario::DriveEvent& event = events_[next_];
    const bool runs = Time(event.at) <= now;
    if (runs) twist = event.twist;
    until = std::min(until, Time(runs ? event.at + event.span : event.at));
    if (runs && !std::exchange(told_, true) && tell_) {
      tell_(now, fmt::format("asked for {} m/s, {} rad/s for {} s", twist.v, twist.w,
                             ToSeconds(event.span)));
    }
  }
  base_.Drive(twist);
  return until;
}

}  // namespace twin::run

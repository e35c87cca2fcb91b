#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "twin/backend/hand.h"
#include "twin/backend/registry.h"
#include "twin/core/time.h"
#include "twin/run/run.h"
#include "twin/scenario/scenario.h"

namespace twin::run {

/// @returns the connection's hand. @throws InputError when the backend of this name has none.
[[nodiscard]] backend::Hand& RequireHand(const backend::Connection& connection,
                                         std::string_view backend);

/// Gives a hand its commands at their times, and sees how they end. A command that the hand refuses
/// or does not answer has failed; the arm's motion goes on.
///
/// Threads: one, the run's, which may wait; not for real-time code.
class HandScript {
 public:
  /// (when, what), a line about a begin or an end.
  using Tell = std::function<void(Time now, std::string_view text)>;

  /// @param events  in order of time; they and the hand must outlive the script. @param tell  may
  /// be empty.
  HandScript(const std::vector<scenario::HandEvent>& events, backend::Hand& hand, Tell tell);

  /// Starts what is due by `now`, and looks whether what runs has ended.
  /// @returns when to be called next; Time::max() once nothing is left to do.
  [[nodiscard]] Time Attend(Time now);

  /// @returns what the commands came to so far, and the hand as it is.
  [[nodiscard]] HandReport Report() const;

 private:
  void Begin(std::size_t index, Time now);
  void Look(Time now);
  void Say(Time now, const std::string& text) const {
    if (tell_) tell_(now, text);
  }

  const std::vector<scenario::HandEvent>& events_;
  backend::Hand& hand_;
  const Tell tell_;
  std::vector<HandOutcome> outcomes_;
  std::size_t next_ = 0;                ///< to begin
  std::optional<std::size_t> running_;  ///< of events_
  HandTicket ticket_ = 0;               ///< of what runs
};

}  // namespace twin::run

#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "twin/backend/hand.h"
#include "twin/backend/mobile_base.h"
#include "twin/backend/registry.h"
#include "twin/core/time.h"
#include "twin/run/run.h"
#include "twin/scenario/scenario.h"

// What a scenario lists for times of a run: commands to the hand, velocities of the mobile base.
namespace twin::run {

/// Receives a line about a command that begins or ends, with its time. May be empty.
using ScriptLog = std::function<void(Time now, std::string_view text)>;

/// @returns the connection's hand. @throws InputError when the backend of this name has none.
[[nodiscard]] backend::Hand& RequireHand(const backend::Connection& connection,
                                         std::string_view backend);

/// Gives a hand its commands at their times, and records their results. A command that the hand
/// refuses or does not answer fails; the arm's motion continues.
///
/// Threads: one, the run's, which may wait; not for real-time code.
class HandScript {
 public:
  /// @param events  in order of time; they and the hand must outlive the script. @param log  may
  /// be empty.
  HandScript(const std::vector<scenario::HandEvent>& events, backend::Hand& hand, ScriptLog log);

  /// Starts what is due by `now`, and looks whether what runs has ended.
  /// @returns when to be called next; Time::max() once nothing is left to do.
  [[nodiscard]] Time Attend(Time now);

  /// @returns what the commands came to so far, and the hand as it is.
  [[nodiscard]] HandReport Report() const;

 private:
  void Begin(std::size_t index, Time now);
  void Look(Time now);
  void Say(Time now, const std::string& text) const {
    if (log_) log_(now, text);
  }

  const std::vector<scenario::HandEvent>& events_;
  backend::Hand& hand_;
  const ScriptLog log_;
  std::vector<HandOutcome> outcomes_;
  std::size_t next_ = 0;                ///< to begin
  std::optional<std::size_t> running_;  ///< of events_
  HandTicket ticket_ = 0;               ///< of what runs
};

/// @returns the connection's mobile base. @throws InputError when the backend of this name has
/// none.
[[nodiscard]] backend::MobileBase& RequireBase(const backend::Connection& connection,
                                               std::string_view backend);

/// Commands a mobile base every 50 ms, as an operator at a joystick: the listed velocity, else
/// zero.
///
/// Threads: one, the run's; not for real-time code.
class DriveScript {
 public:
  /// @param events  one after the other; they and the base must outlive the script. @param log may
  /// be empty.
  DriveScript(const std::vector<scenario::DriveEvent>& events, backend::MobileBase& base,
              ScriptLog log);

  /// Asks for what is due at `now`. @returns when to be called next.
  [[nodiscard]] Time Attend(Time now);

 private:
  const std::vector<scenario::DriveEvent>& events_;
  backend::MobileBase& base_;
  const ScriptLog log_;
  std::size_t next_ = 0;  ///< of events_, not over yet
  bool told_ = false;     ///< of it
};

/// The scripts of a scenario, beside its motion.
class MotionScripts {
 public:
  /// @param hooks  their events get the scripts' lines. All must outlive the scripts.
  /// @throws InputError when the connection has not what the scenario commands.
  MotionScripts(const scenario::Scenario& scenario, const backend::Connection& connection,
                const RunHooks& hooks);

  /// As Motion::attend; empty when the scenario lists nothing. It refers to the scripts.
  [[nodiscard]] std::function<Time(Time)> Attend();
  /// nullopt: no commands to the hand.
  [[nodiscard]] std::optional<HandReport> Report() const;

 private:
  std::optional<HandScript> hand_;
  std::optional<DriveScript> drive_;
};

}  // namespace twin::run

#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "twin/core/hand_command.h"
#include "twin/core/realtime.h"

namespace twin::onboard {

/// How the commands to a hand ended, of which one runs at a time. Keeps the results of the last
/// kRemembered commands; earlier ones count as aborted.
///
/// Threads: one. Real-time: all calls are noexcept, O(1), allocate nothing.
class HandOutcomes {
 public:
  static constexpr std::size_t kRemembered = 8;

  /// A command begins, which aborts the running one. @returns its ticket.
  HandTicket Begin() noexcept TWIN_REALTIME {
    if (is_running()) End(HandResult::kAborted);
    running_ = ++last_;
    entries_[running_ % kRemembered] = {running_, {}};
    return running_;
  }

  /// The running command ends. @pre one runs.
  void End(HandResult result) noexcept TWIN_REALTIME {
    entries_[running_ % kRemembered].result = result;
    running_ = 0;
  }

  [[nodiscard]] bool is_running() const noexcept { return running_ != 0; }

  /// @returns how the command ended; nullopt while it runs and for an unknown ticket.
  [[nodiscard]] std::optional<HandResult> Of(HandTicket ticket) const noexcept TWIN_REALTIME {
    if (ticket == 0 || ticket > last_) return {};
    const Entry& entry = entries_[ticket % kRemembered];
    return entry.ticket == ticket ? entry.result : HandResult::kAborted;
  }

 private:
  struct Entry {
    HandTicket ticket = 0;
    std::optional<HandResult> result;
  };
  std::array<Entry, kRemembered> entries_{};
  HandTicket last_ = 0;
  HandTicket running_ = 0;  ///< zero: none
};

}  // namespace twin::onboard

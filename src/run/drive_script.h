#pragma once

#include <cstddef>
#include <functional>
#include <string_view>
#include <vector>

#include "twin/backend/mobile_base.h"
#include "twin/backend/registry.h"
#include "twin/core/time.h"
#include "twin/scenario/base_section.h"

namespace twin::run {

/// @returns the connection's mobile base. @throws InputError when the backend of this name has
/// none.
[[nodiscard]] backend::MobileBase& RequireBase(const backend::Connection& connection,
                                               std::string_view backend);

/// Asks a mobile base for what a scenario lists, every 50 ms, as somebody at a stick would; for
/// zero where it lists nothing.
///
/// Threads: one, the run's; not for real-time code.
class DriveScript {
 public:
  /// (when, what), a line about a drive that begins.
  using Tell = std::function<void(Time now, std::string_view text)>;

  /// @param events  one after the other; they and the base must outlive the script. @param tell may
  /// be empty.
  DriveScript(const std::vector<scenario::DriveEvent>& events, backend::MobileBase& base,
              Tell tell);

  /// Asks for what is due at `now`. @returns when to be called next.
  [[nodiscard]] Time Attend(Time now);

 private:
  const std::vector<scenario::DriveEvent>& events_;
  backend::MobileBase& base_;
  const Tell tell_;
  std::size_t next_ = 0;  ///< of events_, not over yet
  bool told_ = false;     ///< of it
};

}  // namespace twin::run

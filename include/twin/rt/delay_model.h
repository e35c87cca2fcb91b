#pragma once

#include <cstdint>
#include <variant>

#include "twin/core/random.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"

namespace twin::rt {

/// Always the same delay.
struct ConstantDelay {
  Duration value{0};  ///< >= 0
};

/// offset + exp(mu + sigma z), z standard normal: what queueing and scheduling look like. Given by
/// what one can measure.
struct LogNormalDelay {
  Duration median{0};  ///< of the log-normal part, > 0
  double sigma = 0;    ///< standard deviation of its logarithm, >= 0; 0.5 gives p99 = 3.2 median
  Duration offset{0};  ///< least delay, >= 0
};

/// How long something takes: a message's way, a computation, a wake-up. Drawn from the run's seed,
/// so that lockstep repeats.
///
/// Threads: any (stateless). Real-time: Draw() is noexcept, O(1), allocates nothing.
class DelayModel {
 public:
  DelayModel() = default;  ///< no delay
  /// @throws InputError naming the field when a parameter is outside its range.
  explicit DelayModel(const ConstantDelay& constant);
  explicit DelayModel(const LogNormalDelay& log_normal);

  /// @param random  seed and stream; @param tick  which message or cycle.
  /// @returns delay >= 0.
  [[nodiscard]] Duration Draw(const Random& random,
                              std::uint64_t tick) const noexcept TWIN_REALTIME;

 private:
  std::variant<ConstantDelay, LogNormalDelay> model_;
};

}  // namespace twin::rt

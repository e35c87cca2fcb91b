#pragma once

#include <cstdint>
#include <variant>
#include <vector>

#include "twin/core/random.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"

namespace twin::faults {

/// A constant delay.
struct ConstantDelay {
  Duration value{0};  ///< >= 0
};

/// offset + exp(mu + sigma z), z standard normal: typical of queueing and scheduling. The
/// parameters are measurable quantities.
struct LogNormalDelay {
  Duration median{0};  ///< of the log-normal part, > 0
  double sigma = 0;    ///< standard deviation of its logarithm, >= 0; 0.5 gives p99 = 3.2 median
  Duration offset{0};  ///< least delay, >= 0
};

/// mean + sigma z, z standard normal, truncated at 0: the density above 0 is scaled up. Such a
/// delay is longer than `mean` on average: mean + sigma phi(r) / Phi(r) with r = mean / sigma, phi
/// and Phi the normal density and distribution.
struct NormalDelay {
  Duration mean{0};   ///< of the normal before truncation, >= 0
  Duration sigma{0};  ///< its standard deviation, >= 0
};

/// offset + scale G, G with the gamma distribution of this shape: mean offset + shape scale,
/// standard deviation sqrt(shape) scale. Shape 1 is the exponential distribution.
struct GammaDelay {
  double shape = 1;    ///< in [0.01, 1e6]
  Duration scale{0};   ///< > 0
  Duration offset{0};  ///< least delay, >= 0
};

/// A measured histogram: bins by weight, uniform within a bin.
struct EmpiricalDelay {
  std::vector<Duration> edges;  ///< n + 1 for n >= 1 bins, increasing, the first >= 0
  std::vector<double> weights;  ///< n, each >= 0 and finite, not all 0; normalised internally
};

/// Duration of a transmission, a computation or a wake-up, drawn from the run's seed, so that
/// lockstep repeats. No parameter may exceed kLongestParameter.
///
/// The gamma distribution is drawn after Marsaglia and Tsang, "A simple method for generating gamma
/// variables", ACM TOMS 2000.
///
/// Threads: any (stateless). Real-time: Draw() is noexcept, allocates nothing, O(1) (a histogram:
/// O(log bins)); rejection methods stop after a fixed number of tries.
class DelayModel {
 public:
  static constexpr Duration kLongestParameter = std::chrono::hours(1);

  DelayModel() = default;  ///< no delay
  /// @throws InputError naming the field when a parameter is outside its range.
  explicit DelayModel(const ConstantDelay& constant);
  explicit DelayModel(const LogNormalDelay& log_normal);
  explicit DelayModel(const NormalDelay& normal);
  explicit DelayModel(const GammaDelay& gamma);
  explicit DelayModel(const EmpiricalDelay& empirical);

  /// @param random  seed and stream; @param tick  number of the message or cycle.
  /// @returns delay >= 0.
  [[nodiscard]] Duration Draw(const Random& random,
                              std::uint64_t tick) const noexcept TWIN_REALTIME;

 private:
  /// An EmpiricalDelay prepared for drawing.
  struct Histogram {
    std::vector<Duration> edges;
    std::vector<double> cumulative;  ///< cumulative weight at the end of each bin, last 1

    [[nodiscard]] Duration Draw(const Random& random,
                                std::uint64_t tick) const noexcept TWIN_REALTIME;
  };

  std::variant<ConstantDelay, LogNormalDelay, NormalDelay, GammaDelay, Histogram> model_;
};

}  // namespace twin::faults

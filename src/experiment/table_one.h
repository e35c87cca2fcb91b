#pragma once

#include <array>
#include <cstddef>

#include "experiment/loop_sample.h"

namespace twin::experiment {

/// A row of the paper's Table 1.
struct TableRow {
  const char* name;
  const char* unit;
  std::array<double, 3> paper;    ///< of LF, RS and RA, as in CalibratedLoops()
  std::array<bool, 3> is_fitted;  ///< of which models/experiments is calibrated on it
  double (*of)(const LoopSample& sample);
};

/// d_EXT: median, p99 and largest; unserved cycles.
inline constexpr std::array<TableRow, 4> kTableOne{
    {{"d_EXT, median",
      "ms",
      {0.012, 0.065, 0.013},
      {true, true, true},
      [](const LoopSample& s) { return 1e-3 * Percentile(s.d_EXT_us, 0.5); }},
     {"d_EXT, p99",
      "ms",
      {0.040, 0.137, 0.048},
      {true, true, true},
      [](const LoopSample& s) { return 1e-3 * Percentile(s.d_EXT_us, 0.99); }},
     {"d_EXT, max",
      "ms",
      {0.087, 2.174, 0.141},
      {false, false, false},
      [](const LoopSample& s) { return 1e-3 * s.d_EXT_us.back(); }},
     {"unserved cycles", "%", {0.18, 5.91, 0.41}, {true, false, false}, [](const LoopSample& s) {
        return s.unserved_percent;
      }}}};
inline constexpr std::size_t kMedianLatency = 0;
inline constexpr std::size_t kHighLatency = 1;  ///< p99
inline constexpr std::size_t kLargestLatency = 2;
inline constexpr std::size_t kUnserved = 3;

}  // namespace twin::experiment

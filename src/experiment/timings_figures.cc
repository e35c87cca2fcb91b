#include "experiment/timings_figures.h"

#include <cstddef>
#include <string>

#include "twin/experiment/calibration.h"

namespace twin::experiment {
namespace {

// Places in CalibratedLoops().
constexpr std::size_t kBare = 0;
constexpr std::size_t kSynchronous = 1;
constexpr std::size_t kAsynchronous = 2;

}  // namespace

std::vector<double> Pooled(const std::vector<LoopSample>& runs,
                           std::vector<double> LoopSample::*key) {
  std::vector<double> pooled;
  for (const LoopSample& run : runs) {
    pooled.insert(pooled.end(), (run.*key).begin(), (run.*key).end());
  }
  return pooled;
}

Figure LatencyFigure(const LoopRuns& runs) {
  const std::vector<double> edges = LogEdges(4, 3000, 40);
  Figure figure{.id = "d_ext",
                .columns =
                    "d_EXT [us],LF in bin [%],LF above [1],RS in bin [%],RS above [1],RA in "
                    "bin [%],RA above [1]"};
  for (const double edge : edges) figure.rows.push_back({edge});
  for (const std::vector<LoopSample>& loop : runs) {
    const std::vector<double> values = Pooled(loop, &LoopSample::d_EXT_us);
    std::vector<double> shares = Histogram(values, edges);
    shares.push_back(0);
    const std::vector<double> above = Exceedance(values, edges);
    for (std::size_t i = 0; i < edges.size(); ++i) {
      figure.rows[i].insert(figure.rows[i].end(), {100 * shares[i], above[i]});
    }
  }
  return figure;
}

Figure IntervalFigure(const LoopRuns& runs) {
  constexpr double kWidth = 20;  // us
  constexpr std::size_t kBins = 220;
  std::vector<double> edges(kBins + 1);
  for (std::size_t i = 0; i <= kBins; ++i) edges[i] = kWidth * static_cast<double>(i);
  Figure figure{.id = "intervals", .columns = "interval [us],RS [1],LF [1],RA [1]"};
  for (std::size_t i = 0; i < kBins; ++i) figure.rows.push_back({edges[i] + kWidth / 2});
  for (const std::size_t loop : {kSynchronous, kBare, kAsynchronous}) {
    const std::vector<double> values = Pooled(runs[loop], &LoopSample::interval_us);
    const std::vector<double> shares = Histogram(values, edges);
    for (std::size_t i = 0; i < kBins; ++i) figure.rows[i].push_back(shares[i]);
    // The share of a single interval: where the logarithmic axis begins.
    figure.values["one_" + std::string(CalibratedLoops()[loop].name)] =
        1 / static_cast<double>(values.size());
  }
  return figure;
}

}  // namespace twin::experiment

#include "experiment/client_study_figures.h"

#include <algorithm>
#include <cstddef>

#include "experiment/loop_sample.h"
#include "twin/core/time.h"

namespace twin::experiment {
Figure ClientLatencyFigure(const std::vector<double>& latencies_us) {
  const std::vector<double> edges = LogEdges(4, 4000, 40);
  std::vector<double> shares = Histogram(latencies_us, edges);
  shares.push_back(0);
  const std::vector<double> longer = Exceedance(latencies_us, edges);
  Figure figure{.id = "wire", .columns = "d_EXT on the wire [us],in bin [%],longer [1]"};
  for (std::size_t i = 0; i < edges.size(); ++i) {
    figure.rows.push_back({edges[i], 100 * shares[i], longer[i]});
  }
  return figure;
}

Figure ClientLossesFigure(const MotionTally& tally) {
  constexpr std::size_t kMostPoints = 4000;
  Figure figure{.id = "losses",
                .columns = "t [s],unserved in a row [1]",
                .values = {{"most", MotionTally::EndsTheMotion()}}};
  const std::vector<std::uint8_t>& lost = tally.lost_in_row();
  const std::size_t step = lost.size() / kMostPoints + 1;
  for (std::size_t k = 0; k < lost.size(); k += step) {
    const auto end = lost.begin() + static_cast<std::ptrdiff_t>(std::min(k + step, lost.size()));
    const double most = *std::max_element(lost.begin() + static_cast<std::ptrdiff_t>(k), end);
    figure.rows.push_back({static_cast<double>(k) * kCycleSeconds, most});
  }
  return figure;
}

}  // namespace twin::experiment

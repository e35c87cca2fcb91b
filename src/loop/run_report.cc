#include "twin/loop/run_report.h"

#include <array>

#include <fmt/format.h>

namespace twin::loop {

std::string DescribeTick(const record::TickRecord& tick) {
  constexpr std::array kDone{"published, not answered", "answered", "answered: finish",
                             "came out of time, not answered", "not answered: invalid command"};
  std::string text = fmt::format("state {} read at {:.6f} s: {}", tick.message_id,
                                 ToSeconds(tick.read.time_since_epoch()),
                                 kDone.at(static_cast<std::size_t>(tick.action)));
  if (tick.written > tick.read) {
    text += fmt::format(" {:.1f} us later", ToSeconds(tick.written - tick.read) * 1e6);
  }
  if (tick.skipped_states > 0) text += fmt::format("; {} states lost before", tick.skipped_states);
  return text;
}

}  // namespace twin::loop

#include "twin/run/told_events.h"

#include <algorithm>

namespace twin::run {

ToldEvent EventOf(std::string_view line) noexcept {
  constexpr std::string_view kMotion = "motion ";
  const std::size_t colon = line.find(": ");
  if (colon == std::string_view::npos) return {"server", line};
  const std::string_view text = line.substr(colon + 2);
  if (text.starts_with(kMotion)) return {"motion", text.substr(kMotion.size())};
  const bool is_client = !text.empty() && text.front() >= '0' && text.front() <= '9';
  return is_client ? ToldEvent{"client", line} : ToldEvent{line.substr(0, colon), text};
}

void ToldEvents::Tell(std::string_view line) noexcept {
  static_cast<void>(lines_.TryPushWith([line](Line& slot) {
    slot.size = std::min(line.size(), slot.text.size());
    std::copy_n(line.begin(), slot.size, slot.text.begin());
  }));
}

void ToldEvents::Put(const record::CycleRecord& record) noexcept {
  last_ = record.at;
  PassOn(last_);
  records_.Put(record);
}

void ToldEvents::PassOn(Time at) noexcept {
  const auto put = [&](const Line& line) {
    const ToldEvent event = EventOf({line.text.data(), line.size});
    records_.Event(at, event.kind, event.text);
  };
  while (lines_.TryPopWith(put)) {
  }
}

}  // namespace twin::run

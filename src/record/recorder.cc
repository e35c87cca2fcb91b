#include "twin/record/recorder.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>

#include "record/log_writer.h"
#include "twin/rt/host_time.h"
#include "twin/rt/spsc_ring.h"

namespace twin::record {
namespace {

/// Capacity of a ring, records; 3 MB.
constexpr std::size_t kRingRecords = 1024;

/// Capacity of the events' own ring; events are rare.
constexpr std::size_t kRingEvents = 64;

/// Records written from one ring before the writer checks the others and waiting producers.
constexpr std::size_t kBatch = 128;

/// Pause of the writer when the rings are empty. The fastest lockstep run puts a few hundred
/// records meanwhile; a wake-up by the producer would cost it nearly one system call per record.
constexpr std::chrono::microseconds kIdlePause(1000);

/// A text of bounded length, which crosses the ring without allocation.
template <std::size_t kCapacity>
struct BoundedText {
  std::array<char, kCapacity> bytes;
  std::size_t size;

  void Set(std::string_view text) noexcept {
    size = std::min(text.size(), kCapacity);
    std::copy_n(text.begin(), size, bytes.begin());
  }
  [[nodiscard]] std::string_view Get() const noexcept { return {bytes.data(), size}; }
};

struct EventItem {
  Time at;
  BoundedText<31> kind;
  BoundedText<2000> text;
};

using Item = std::variant<CycleRecord, TickRecord, EventItem, SceneRecord>;
static_assert(std::is_trivially_copyable_v<Item>);

}  // namespace

class Recorder::Ring : public rt::SpscRing<Item> {
  using SpscRing::SpscRing;
};

class Recorder::Writer {
 public:
  Writer(const std::filesystem::path& path, const RunInfo& run, const LogSplit& split,
         std::size_t chunk_bytes)
      : log_(path, run, split, chunk_bytes) {}

  template <class Record>
  void operator()(const Record& record) {
    log_.Add(record);
  }
  void operator()(const EventItem& event) {
    log_.Add(event.at, event.kind.Get(), event.text.Get());
  }

  void Flush() { log_.Flush(); }
  McapTotals Finish() { return log_.Finish(); }

 private:
  LogWriter log_;
};

Recorder::Recorder(const std::filesystem::path& path, const RunInfo& run, FullRing full_ring,
                   const LogSplit& split, std::size_t chunk_bytes)
    : full_ring_(full_ring),
      writer_(std::make_unique<Writer>(path, run, split, chunk_bytes)),
      cycles_(std::make_unique<Ring>(kRingRecords)),
      ticks_(full_ring == FullRing::kDrop ? std::make_unique<Ring>(kRingRecords) : nullptr),
      events_(full_ring == FullRing::kDrop ? std::make_unique<Ring>(kRingEvents) : nullptr),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

Recorder::~Recorder() {
  StopThread();
  if (writer_ == nullptr || failure_.happened()) return;
  try {
    writer_->Flush();
  } catch (const std::exception&) {
    // The file keeps the name .partial, which marks it as incomplete.
  }
}

void Recorder::Put(const CycleRecord& record) noexcept {
  Push(cycles_, [&record](Item& slot) { slot.emplace<CycleRecord>(record); });
}

void Recorder::Put(const TickRecord& record) noexcept {
  Push(ticks_, [&record](Item& slot) { slot.emplace<TickRecord>(record); });
}

void Recorder::Put(const SceneRecord& record) noexcept {
  Push(cycles_, [&record](Item& slot) { slot.emplace<SceneRecord>(record); });
}

void Recorder::Event(Time at, std::string_view kind, std::string_view text) noexcept {
  Push(events_, [&](Item& slot) {
    auto& event = slot.emplace<EventItem>();
    event.at = at;
    event.kind.Set(kind);
    event.text.Set(text);
  });
}

template <class Fill>
void Recorder::Push(const std::unique_ptr<Ring>& own, Fill&& fill) noexcept {
  Ring& ring = own != nullptr ? *own : *cycles_;
  while (true) {
    const std::uint32_t seen = drained_.load(std::memory_order_acquire);
    if (ring.TryPushWith(fill)) return;
    if (full_ring_ == FullRing::kDrop) {
      dropped_.fetch_add(1, std::memory_order_relaxed);
      return;
    }
    drained_.wait(seen, std::memory_order_acquire);
  }
}

void Recorder::Run(const std::stop_token& stop) {
  while (true) {
    // Read before Drain(), so that records put before the stop request are still written.
    const bool last = stop.stop_requested();
    if (Drain() > 0) continue;
    if (last) return;
    rt::Pause(kIdlePause);
  }
}

std::size_t Recorder::Drain() {
  const auto write = [this](const Item& item) {
    if (failure_.happened()) return;
    try {
      std::visit(*writer_, item);
    } catch (...) {
      failure_.Keep();
    }
  };
  std::size_t count = 0;
  for (const auto& ring : {cycles_.get(), ticks_.get(), events_.get()}) {
    if (ring == nullptr) continue;
    for (std::size_t i = 0; i < kBatch && ring->TryPopWith(write); ++i) ++count;
  }
  if (count > 0) {
    drained_.fetch_add(1, std::memory_order_release);
    drained_.notify_one();
  }
  return count;
}

void Recorder::Add(PlanRecord plan) {
  plans_.push_back(std::move(plan));
}

void Recorder::StopThread() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
}

RecordingSummary Recorder::Finish() {
  StopThread();
  const std::unique_ptr<Writer> writer = std::move(writer_);
  failure_.Rethrow();
  for (const PlanRecord& plan : plans_) (*writer)(plan);
  const McapTotals totals = writer->Finish();
  return {.messages = totals.messages,
          .bytes = totals.bytes,
          .dropped = dropped_.load(std::memory_order_relaxed)};
}

}  // namespace twin::record

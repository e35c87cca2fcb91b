#include "twin/record/column_reader.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "record/column_decoder.h"
#include "record/mcap_index.h"
#include "twin/core/error.h"
#include "twin/record/log_reader.h"

namespace twin::record {
namespace {

/// Whether a chunk may have messages of an interval. The log time of negative times is 0.
bool MayHave(const mcap::ChunkHeader& header, const Interval& interval) {
  return (header.first_ns == 0 || std::cmp_less(header.first_ns, interval.until_ns)) &&
         std::cmp_greater_equal(header.last_ns, interval.from_ns);
}

}  // namespace

class ColumnReader::Impl {
 public:
  Impl(std::unique_ptr<mcap::Source> source, const std::string& name, const LogReader& log)
      : run(log.run()), truncated(log.truncated()), index_(std::move(source), name) {}

  const RunInfo run;
  const bool truncated;

  [[nodiscard]] const std::vector<mcap::Index::Place>& chunks() const { return index_.chunks(); }

  Table Read(const TableInfo& table, std::span<const std::size_t> columns, const Interval& interval,
             int threads) const {
    TWIN_CHECK(threads >= 1);
    std::vector<const mcap::Index::Place*> places;
    for (const mcap::Index::Place& place : chunks()) {
      if (MayHave(place.header, interval)) places.push_back(&place);
    }
    std::vector<RowBuffer> buffers(places.size());
    std::vector<std::exception_ptr> failures(places.size());
    std::atomic<std::size_t> next{0};  // counters and a flag: relaxed; joining orders the results
    std::atomic<std::uint64_t> bytes{0};
    std::atomic<bool> has_failed{false};
    const auto work = [&] {
      mcap::Chunk chunk;
      mcap::Bytes record;
      while (!has_failed.load(std::memory_order_relaxed)) {
        const std::size_t i = next.fetch_add(1, std::memory_order_relaxed);
        if (i >= places.size()) return;
        try {
          index_.Open(*places[i], record, chunk);
          RowDecoder decoder(table, columns, interval);
          DecodeChunk(chunk, decoder, bytes);
          buffers[i] = decoder.Take();
        } catch (...) {
          failures[i] = std::current_exception();
          has_failed.store(true, std::memory_order_relaxed);
        }
      }
    };
    {
      std::vector<std::jthread> helpers;
      const auto most = std::min<std::size_t>(static_cast<std::size_t>(threads), places.size());
      for (std::size_t i = 1; i < most; ++i) helpers.emplace_back(work);
      work();
    }
    for (const std::exception_ptr& failure : failures) {
      if (failure) std::rethrow_exception(failure);
    }
    if (buffers.empty()) buffers.push_back(RowDecoder(table, columns).Take());
    return Join(table, buffers);
  }

 private:
  void DecodeChunk(mcap::Chunk& chunk, RowDecoder& decoder,
                   std::atomic<std::uint64_t>& bytes) const {
    mcap::Channels channels = index_.channels();
    std::size_t counted = 0;
    const auto count = [&] {
      const std::size_t now = decoder.rows().Bytes();
      if (bytes.fetch_add(now - counted, std::memory_order_relaxed) + (now - counted) >
          kMostBytes) {
        throw InputError(fmt::format(
            "{}: the table takes more than {} GiB; read fewer columns, or a part of the run",
            index_.name(), kMostBytes >> 30));
      }
      counted = now;
    };
    constexpr std::size_t kCountRows = 4096;
    for (std::size_t messages = 1; const auto message = chunk.Next(channels); ++messages) {
      try {
        if (decoder.Takes(*message->channel)) decoder.Decode(message->data);
      } catch (const InputError& error) {
        throw InputError(fmt::format("{}: message {}, on topic {}: {}", chunk.where(), messages,
                                     message->channel->topic, error.what()));
      }
      if (messages % kCountRows == 0) count();
    }
    count();
  }

  mcap::Index index_;
};

ColumnReader::ColumnReader(const std::filesystem::path& path)
    : impl_(std::make_unique<Impl>(mcap::OpenFile(path), path.string(), LogReader(path))) {}

ColumnReader::ColumnReader(std::span<const std::byte> bytes, const std::string& name)
    : impl_(std::make_unique<Impl>(mcap::OpenMemory(bytes), name, LogReader(bytes, name))) {}

ColumnReader::~ColumnReader() = default;

const RunInfo& ColumnReader::run() const {
  return impl_->run;
}

bool ColumnReader::truncated() const {
  return impl_->truncated;
}

std::int64_t ColumnReader::first_ns() const {
  std::uint64_t first = impl_->chunks().empty() ? 0 : UINT64_MAX;
  for (const auto& chunk : impl_->chunks()) first = std::min(first, chunk.header.first_ns);
  return static_cast<std::int64_t>(first);
}

std::int64_t ColumnReader::last_ns() const {
  std::uint64_t last = 0;
  for (const auto& chunk : impl_->chunks()) last = std::max(last, chunk.header.last_ns);
  return static_cast<std::int64_t>(last);
}

std::uint64_t ColumnReader::BytesIn(const Interval& interval) const {
  std::uint64_t bytes = 0;
  for (const auto& chunk : impl_->chunks()) {
    if (MayHave(chunk.header, interval)) bytes += chunk.header.bytes;
  }
  return bytes;
}

Table ColumnReader::Read(const TableInfo& table, std::span<const std::size_t> columns,
                         const Interval& interval, int threads) const {
  return impl_->Read(table, columns, interval, threads);
}

}  // namespace twin::record

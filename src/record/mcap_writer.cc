#include "twin/record/mcap_writer.h"

#include <zstd.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "record/mcap_format.h"
#include "twin/core/error.h"
#include "twin/record/partial_file.h"

namespace twin::record {

using mcap::BeginArray;
using mcap::BeginRecord;
using mcap::Bytes;
using mcap::EndArray;
using mcap::EndRecord;
using mcap::Opcode;
using mcap::Put;
using mcap::PutBytes;
using mcap::PutString;

namespace {

constexpr std::size_t kIndexBlockBytes = std::size_t{64} * 1024;

/// Range of log times in a chunk or the file; zero without messages, as MCAP requires.
struct TimeSpan {
  std::uint64_t first = 0;
  std::uint64_t last = 0;
  bool empty = true;

  void Add(std::uint64_t time) {
    first = empty ? time : std::min(first, time);
    last = empty ? time : std::max(last, time);
    empty = false;
  }
};

struct ChannelState {
  std::uint32_t sequence = 0;                                       ///< of the next message
  std::uint64_t messages = 0;                                       ///< in the file
  std::vector<std::pair<std::uint64_t, std::uint64_t>> in_chunk{};  ///< log time, offset in chunk
};

}  // namespace

class McapWriter::Impl {
 public:
  Impl(const std::filesystem::path& path, const McapWriterOptions& options)
      : options_(options),
        file_(path, PartialFile::Leftover::kKeep,
              {.name = "an MCAP log", .magic = mcap::AsBytes(mcap::kMagic)}),
        zstd_(ZSTD_createCCtx(), &ZSTD_freeCCtx) {
    TWIN_CHECK(zstd_ != nullptr);
    ZSTD_CCtx_setParameter(zstd_.get(), ZSTD_c_compressionLevel, options_.zstd_level);
    chunk_.reserve(options_.chunk_bytes);
    out_.reserve(ZSTD_compressBound(options_.chunk_bytes));
    PutBytes(out_, mcap::AsBytes(mcap::kMagic));
    const std::size_t begin = BeginRecord(out_, Opcode::kHeader);
    PutString(out_, "");  // no profile
    PutString(out_, options_.library);
    EndRecord(out_, begin);
    WriteOut();
  }

  std::uint16_t AddSchema(std::string_view name, std::string_view encoding, std::string_view data) {
    const auto id = static_cast<std::uint16_t>(++schema_count_);
    const std::size_t begin = BeginRecord(out_, Opcode::kSchema);
    Put(out_, id);
    PutString(out_, name);
    PutString(out_, encoding);
    PutString(out_, data);
    EndRecord(out_, begin);
    PutBytes(schemas_, out_);
    WriteOut();
    return id;
  }

  std::uint16_t AddChannel(std::uint16_t schema, std::string_view topic,
                           std::string_view encoding) {
    const auto id = static_cast<std::uint16_t>(channel_states_.size());
    ChannelState& state = channel_states_.emplace_back();
    if (id < options_.first_sequences.size()) state.sequence = options_.first_sequences[id];
    const std::size_t begin = BeginRecord(out_, Opcode::kChannel);
    Put(out_, id);
    Put(out_, schema);
    PutString(out_, topic);
    PutString(out_, encoding);
    mcap::PutMap(out_, {});
    EndRecord(out_, begin);
    PutBytes(channels_, out_);
    WriteOut();
    return id;
  }

  void AddMetadata(std::string_view name, const mcap::TextMap& entries) {
    const std::size_t begin = BeginRecord(out_, Opcode::kMetadata);
    PutString(out_, name);
    mcap::PutMap(out_, entries);
    EndRecord(out_, begin);

    const std::size_t index = BeginRecord(metadata_index_, Opcode::kMetadataIndex);
    Put(metadata_index_, file_.size());
    Put(metadata_index_, std::uint64_t{out_.size()});
    PutString(metadata_index_, name);
    EndRecord(metadata_index_, index);
    ++metadata_count_;
    WriteOut();
  }

  void AddAttachment(std::string_view name, std::string_view media_type, std::string_view data,
                     std::uint64_t log_time_ns) {
    const std::size_t begin = BeginRecord(out_, Opcode::kAttachment);
    Put(out_, log_time_ns);
    Put(out_, std::uint64_t{0});  // no creation time: it would come from the wall clock
    PutString(out_, name);
    PutString(out_, media_type);
    Put(out_, std::uint64_t{data.size()});
    PutBytes(out_, mcap::AsBytes(data));
    Put(out_, mcap::Crc32(0, std::span(out_).subspan(begin + mcap::kRecordHeaderBytes)));
    EndRecord(out_, begin);

    const std::size_t index = BeginRecord(attachment_index_, Opcode::kAttachmentIndex);
    Put(attachment_index_, file_.size());
    Put(attachment_index_, std::uint64_t{out_.size()});
    Put(attachment_index_, log_time_ns);
    Put(attachment_index_, std::uint64_t{0});
    Put(attachment_index_, std::uint64_t{data.size()});
    PutString(attachment_index_, name);
    PutString(attachment_index_, media_type);
    EndRecord(attachment_index_, index);
    ++attachment_count_;
    WriteOut();
  }

  std::span<std::byte> AddMessage(std::uint16_t channel, std::uint64_t log_time_ns,
                                  std::size_t size) {
    constexpr std::size_t kMessageHeaderBytes = 2 + 4 + 8 + 8;
    const std::size_t total = mcap::kRecordHeaderBytes + kMessageHeaderBytes + size;
    if (chunk_.size() + total > options_.chunk_bytes) Flush();

    ChannelState& state = channel_states_.at(channel);
    state.in_chunk.emplace_back(log_time_ns, chunk_.size());
    chunk_time_.Add(log_time_ns);
    const std::size_t begin = BeginRecord(chunk_, Opcode::kMessage);
    Put(chunk_, channel);
    Put(chunk_, state.sequence++);
    ++state.messages;
    Put(chunk_, log_time_ns);
    Put(chunk_, log_time_ns);  // publish time equals log time
    chunk_.resize(chunk_.size() + size);
    EndRecord(chunk_, begin);
    return std::span(chunk_).last(size);
  }

  [[nodiscard]] std::vector<std::uint32_t> next_sequences() const {
    std::vector<std::uint32_t> sequences;
    for (const ChannelState& state : channel_states_) sequences.push_back(state.sequence);
    return sequences;
  }
  [[nodiscard]] std::uint64_t bytes() const noexcept { return file_.size(); }

  void Flush() {
    if (chunk_.empty()) return;
    const std::size_t compressed_bytes = PutChunk();
    const std::size_t chunk_length = out_.size();
    const std::size_t index = BeginRecord(chunk_index_, Opcode::kChunkIndex);
    Put(chunk_index_, chunk_time_.first);
    Put(chunk_index_, chunk_time_.last);
    Put(chunk_index_, file_.size());
    Put(chunk_index_, std::uint64_t{chunk_length});
    PutMessageIndexes();
    Put(chunk_index_, std::uint64_t{out_.size() - chunk_length});
    PutString(chunk_index_, "zstd");
    Put(chunk_index_, std::uint64_t{compressed_bytes});
    Put(chunk_index_, std::uint64_t{chunk_.size()});
    EndRecord(chunk_index_, index);
    KeepChunkIndex();

    ++chunk_count_;
    file_time_.Add(chunk_time_.first);
    file_time_.Add(chunk_time_.last);
    chunk_time_ = {};
    chunk_.clear();
    WriteOut();
  }

  McapTotals Finish() {
    Flush();
    const std::size_t data_end = BeginRecord(out_, Opcode::kDataEnd);
    Put(out_, data_crc_);
    EndRecord(out_, data_end);
    WriteOut();
    PutSummary();
    WriteOut();
    options_.is_synced ? file_.CommitSynced() : file_.Commit();
    return {.messages = message_count(), .chunks = chunk_count_, .bytes = file_.size()};
  }

 private:
  /// Writes the open chunk to out_. @returns its compressed size.
  std::size_t PutChunk() {
    const std::size_t begin = BeginRecord(out_, Opcode::kChunk);
    Put(out_, chunk_time_.first);
    Put(out_, chunk_time_.last);
    Put(out_, std::uint64_t{chunk_.size()});
    Put(out_, mcap::Crc32(0, chunk_));
    PutString(out_, "zstd");
    const std::size_t length_at = out_.size();
    Put(out_, std::uint64_t{0});
    const std::size_t data_at = out_.size();
    out_.resize(data_at + ZSTD_compressBound(chunk_.size()));
    const std::size_t compressed = ZSTD_compress2(
        zstd_.get(), &out_[data_at], out_.size() - data_at, chunk_.data(), chunk_.size());
    TWIN_CHECK(ZSTD_isError(compressed) == 0);
    const std::uint64_t length = compressed;
    std::memcpy(&out_[length_at], &length, sizeof(length));
    out_.resize(data_at + compressed);
    EndRecord(out_, begin);
    return compressed;
  }

  void KeepChunkIndex() {
    if (chunk_indexes_.empty() ||
        chunk_indexes_.back().size() + chunk_index_.size() > chunk_indexes_.back().capacity()) {
      chunk_indexes_.emplace_back().reserve(std::max(kIndexBlockBytes, chunk_index_.size()));
    }
    PutBytes(chunk_indexes_.back(), chunk_index_);
    chunk_index_.clear();
  }

  /// Writes one message index per channel, and their offsets into the chunk's index.
  void PutMessageIndexes() {
    const std::size_t offsets = BeginArray(chunk_index_);
    for (std::size_t id = 0; id < channel_states_.size(); ++id) {
      auto& entries = channel_states_[id].in_chunk;
      if (entries.empty()) continue;
      Put(chunk_index_, static_cast<std::uint16_t>(id));
      Put(chunk_index_, file_.size() + out_.size());
      const std::size_t begin = BeginRecord(out_, Opcode::kMessageIndex);
      Put(out_, static_cast<std::uint16_t>(id));
      const std::size_t array = BeginArray(out_);
      for (const auto& [time, offset] : entries) {
        Put(out_, time);
        Put(out_, offset);
      }
      EndArray(out_, array);
      EndRecord(out_, begin);
      entries.clear();
    }
    EndArray(chunk_index_, offsets);
  }

  void PutSummary() {
    const std::uint64_t start = file_.size();
    const Bytes statistics = Statistics();
    for (const Bytes& block : chunk_indexes_) PutBytes(chunk_index_, block);
    const std::pair<Opcode, const Bytes*> groups[] = {
        {Opcode::kSchema, &schemas_},
        {Opcode::kChannel, &channels_},
        {Opcode::kStatistics, &statistics},
        {Opcode::kChunkIndex, &chunk_index_},
        {Opcode::kAttachmentIndex, &attachment_index_},
        {Opcode::kMetadataIndex, &metadata_index_},
    };
    Bytes offsets;
    for (const auto& [opcode, records] : groups) {
      if (records->empty()) continue;
      const std::size_t begin = BeginRecord(offsets, Opcode::kSummaryOffset);
      Put(offsets, opcode);
      Put(offsets, start + out_.size());
      Put(offsets, std::uint64_t{records->size()});
      EndRecord(offsets, begin);
      PutBytes(out_, *records);
    }
    const std::uint64_t offset_start = start + out_.size();
    PutBytes(out_, offsets);
    const std::size_t footer = BeginRecord(out_, Opcode::kFooter);
    Put(out_, start);
    Put(out_, offset_start);
    // The CRC at the footer's end covers the footer's length.
    Put(out_, std::uint32_t{0});
    EndRecord(out_, footer);
    out_.resize(out_.size() - sizeof(std::uint32_t));
    Put(out_, mcap::Crc32(0, out_));
    PutBytes(out_, mcap::AsBytes(mcap::kMagic));
  }

  [[nodiscard]] Bytes Statistics() const {
    Bytes record;
    const std::size_t begin = BeginRecord(record, Opcode::kStatistics);
    Put(record, message_count());
    Put(record, static_cast<std::uint16_t>(schema_count_));
    Put(record, static_cast<std::uint32_t>(channel_states_.size()));
    Put(record, attachment_count_);
    Put(record, metadata_count_);
    Put(record, static_cast<std::uint32_t>(chunk_count_));
    Put(record, file_time_.first);
    Put(record, file_time_.last);
    const std::size_t counts = BeginArray(record);
    for (std::size_t id = 0; id < channel_states_.size(); ++id) {
      Put(record, static_cast<std::uint16_t>(id));
      Put(record, channel_states_[id].messages);
    }
    EndArray(record, counts);
    EndRecord(record, begin);
    return record;
  }

  [[nodiscard]] std::uint64_t message_count() const {
    std::uint64_t count = 0;
    for (const ChannelState& state : channel_states_) count += state.messages;
    return count;
  }

  /// Writes `out_` to the file.
  void WriteOut() {
    file_.Write(out_);
    data_crc_ = mcap::Crc32(data_crc_, out_);
    out_.clear();
  }

  const McapWriterOptions options_;
  PartialFile file_;
  std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> zstd_;
  std::uint32_t data_crc_ = 0;  ///< of all bytes written
  Bytes out_;                   ///< pending output
  Bytes chunk_;                 ///< records of the open chunk
  TimeSpan chunk_time_;
  TimeSpan file_time_;
  std::vector<ChannelState> channel_states_;
  std::uint32_t schema_count_ = 0;
  std::uint32_t attachment_count_ = 0;
  std::uint32_t metadata_count_ = 0;
  std::uint64_t chunk_count_ = 0;
  // Records for the summary.
  Bytes schemas_;
  Bytes channels_;
  Bytes chunk_index_;  ///< of the chunk that is written; at the end of all
  /// Of the chunks so far, in blocks that stay where they are: hours of a log make megabytes, of
  /// which one vector would leave copies in the heap as it grows.
  std::vector<Bytes> chunk_indexes_;
  Bytes attachment_index_;
  Bytes metadata_index_;
};

McapWriter::McapWriter(const std::filesystem::path& path, const McapWriterOptions& options)
    : impl_(std::make_unique<Impl>(path, options)) {}

McapWriter::~McapWriter() = default;

std::uint16_t McapWriter::AddSchema(std::string_view name, std::string_view encoding,
                                    std::string_view data) {
  return impl_->AddSchema(name, encoding, data);
}

std::uint16_t McapWriter::AddChannel(std::uint16_t schema, std::string_view topic,
                                     std::string_view message_encoding) {
  return impl_->AddChannel(schema, topic, message_encoding);
}

void McapWriter::AddMetadata(std::string_view name,
                             const std::map<std::string, std::string>& entries) {
  impl_->AddMetadata(name, entries);
}

void McapWriter::AddAttachment(std::string_view name, std::string_view media_type,
                               std::string_view data, std::uint64_t log_time_ns) {
  impl_->AddAttachment(name, media_type, data, log_time_ns);
}

std::span<std::byte> McapWriter::AddMessage(std::uint16_t channel, std::uint64_t log_time_ns,
                                            std::size_t size) {
  return impl_->AddMessage(channel, log_time_ns, size);
}

std::vector<std::uint32_t> McapWriter::next_sequences() const {
  return impl_->next_sequences();
}

std::uint64_t McapWriter::bytes() const noexcept {
  return impl_->bytes();
}

void McapWriter::Flush() {
  impl_->Flush();
}

McapTotals McapWriter::Finish() {
  return impl_->Finish();
}

}  // namespace twin::record
